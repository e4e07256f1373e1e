"""The log of habitat_sim: a logger of Python, which prints warnings."""

from __future__ import annotations

import logging
from logging import DEBUG, ERROR, FATAL, INFO, WARN, WARNING, LogRecord
from typing import Any

__all__ = [
    "DEBUG", "ERROR", "FATAL", "HabitatSimFormatter", "INFO", "LogRecord", "LoggingContext", "WARN", "WARNING",
    "format_message", "handler", "logger", "logging",
]  # fmt: skip


def format_message(subsystem: str, level: int, message: str, file: str, line: int) -> str:
    """A message with its origin in front."""
    return f"[{logging.getLevelName(level)}:{subsystem}] {file}({line}): {message}"


class HabitatSimFormatter(logging.Formatter):
    """Writes records as format_message() does."""

    def format(self, record: LogRecord) -> str:
        return format_message(
            "habitat_sim", record.levelno, record.getMessage(), record.filename, record.lineno
        )


handler = logging.StreamHandler()
handler.setFormatter(HabitatSimFormatter())
logger = logging.getLogger("habitat_sim")
logger.addHandler(handler)


class LoggingContext:
    """Accepted, without effect: levels are those of `logger`."""

    def __enter__(self) -> LoggingContext:
        return self

    def __exit__(self, *_: Any) -> None:
        pass
