"""Enfilade's exceptions. The extension module raises these classes."""

from __future__ import annotations


class Error(Exception):
    """Base of Enfilade's exceptions for wrong arguments and files."""

    __module__ = "enfilade"


class ArgumentError(Error, ValueError):
    """A value outside what is allowed; the message says what is."""

    __module__ = "enfilade"


class UnknownNameError(Error, LookupError):
    """A scan, viewpoint or split that does not exist; the message says where it was looked for."""

    __module__ = "enfilade"


class FileError(Error, OSError):
    """A file that cannot be opened, read or written; the message begins with its path."""

    __module__ = "enfilade"


class InvalidInput(Error, ValueError):
    """A file with faults; the message lists the first ten."""

    __module__ = "enfilade"
