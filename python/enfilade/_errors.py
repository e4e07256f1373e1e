"""Enfilade's exceptions. The extension module raises these classes."""

from __future__ import annotations


class Error(Exception):
    """Base of Enfilade's exceptions for wrong arguments and files."""

    __module__ = "enfilade"


class ArgumentError(Error, ValueError):
    """An invalid value; the message says which values are allowed."""

    __module__ = "enfilade"


class UnknownNameError(Error, LookupError):
    """An unknown scan, viewpoint or split; the message says where it was searched."""

    __module__ = "enfilade"


class FileError(Error, OSError):
    """A file that cannot be opened, read or written; the message begins with its path."""

    __module__ = "enfilade"


class InvalidInput(Error, ValueError):
    """A file with faults; the message lists the first ten."""

    __module__ = "enfilade"
