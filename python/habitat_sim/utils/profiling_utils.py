"""Hooks of profilers: accepted, without effect."""

from __future__ import annotations

from contextlib import ContextDecorator
from typing import Any


def configure(capture_start_step: int = -1, num_steps_to_capture: int = -1) -> None:
    """Without effect."""


def on_start_step() -> None:
    """Without effect."""


def range_push(msg: str) -> None:
    """Without effect."""


def range_pop() -> None:
    """Without effect."""


class RangeContext(ContextDecorator):
    """Without effect."""

    def __init__(self, msg: str) -> None:
        self.msg = msg

    def __enter__(self) -> RangeContext:
        return self

    def __exit__(self, *_: Any) -> None:
        pass
