"""Names that are there for imports and annotations, and say what is missing when they are used."""

from __future__ import annotations

from typing import Any, Iterator


class NotThere(NotImplementedError, AttributeError):
    """A name of Habitat that Enfilade does not have. An AttributeError too, so that hasattr() is False."""


class _Refused(type):
    """The class of refused classes and functions: any use raises NotThere."""

    _words = ""

    def __call__(cls, *_: Any, **__: Any) -> Any:
        raise NotThere(cls._words)

    def __getattr__(cls, name: str) -> Any:
        # Type checkers, pickle and copy ask for names with underscores.
        raise AttributeError(name) if name.startswith("_") else NotThere(cls._words)

    def __getitem__(cls, _: Any) -> Any:
        raise NotThere(cls._words)

    def __iter__(cls) -> Iterator[Any]:
        raise NotThere(cls._words)

    def __len__(cls) -> int:
        raise NotThere(cls._words)

    def __bool__(cls) -> bool:
        return True


def refused(name: str, words: str) -> Any:
    """A class in place of a class, function or table that is not there.

    Args:
        name: with its module.
        words: what is missing, and what to use instead.
    """
    module, _, own = name.rpartition(".")
    return _Refused(own, (), {"__module__": module, "_words": f"{name}: {words}", "__doc__": words})


class RefusedAttribute:
    """A method or property that is not there: reading or setting it raises NotThere."""

    def __init__(self, words: str) -> None:
        self._words = words
        self._name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = f"{owner.__name__}.{name}"

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        raise NotThere(f"{self._name}: {self._words}")

    def __set__(self, instance: Any, value: Any) -> None:
        raise NotThere(f"{self._name}: {self._words}")
