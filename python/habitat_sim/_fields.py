"""Structures whose fields are converted and checked when they are set, and what converts them."""

from __future__ import annotations

import enum
import math
from typing import Any, Callable, Generic, TypeVar, Union, overload

import magnum as mn
import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")
Convert = Callable[[str, Any], T]


class Field(Generic[T]):
    """A field of a structure: `convert` makes its value of a name, for messages, and what was given."""

    def __init__(self, convert: Convert[T], default: Any) -> None:
        self._convert, self._default = convert, default
        self._name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, instance: None, owner: Any) -> Field[T]: ...
    @overload
    def __get__(self, instance: Structure, owner: Any) -> T: ...
    def __get__(self, instance: Any, owner: Any) -> Any:
        return self if instance is None else instance.__dict__[self._name]

    def __set__(self, instance: Structure, value: Any) -> None:
        instance.__dict__[self._name] = self._convert(self._name, value)

    def reset(self, instance: Structure) -> None:
        """Sets the default."""
        self.__set__(instance, self._default)


class Structure:
    """An object with the fields of its class, and no other attributes."""

    def __init__(self) -> None:
        for name in self._names():
            getattr(type(self), name).reset(self)

    @classmethod
    def _names(cls) -> list[str]:
        return [
            name
            for kind in reversed(cls.__mro__)
            for name, one in vars(kind).items()
            if isinstance(one, Field)
        ]

    def __setattr__(self, name: str, value: Any) -> None:
        if not hasattr(type(self), name):
            raise AttributeError(f"{type(self).__name__} has no field '{name}'")
        super().__setattr__(name, value)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.__dict__.items())})"


class Code(enum.Enum):
    """An enumeration with numbers, as int() gives them."""

    def __int__(self) -> int:
        return int(self.value)


def wrong(name: str, value: Any, wanted: str) -> TypeError:
    """The error for a value of the wrong type."""
    return TypeError(f"{name} {value!r}: {wanted} is wanted")


def boolean(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise wrong(name, value, "True or False")
    return bool(value)


def whole(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise wrong(name, value, "an integer")
    return int(value)


def number(name: str, value: Any) -> float:
    """A number, as float32 keeps it."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise wrong(name, value, "a number")
    return float(np.float32(value))


def text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise wrong(name, value, "text")
    return value


def table(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise wrong(name, value, "a dictionary")
    return dict(value)


def degrees(name: str, value: Any) -> mn.Deg:
    """An angle: a Deg or Rad, or a number of degrees."""
    return mn.Deg(value if isinstance(value, (mn.Deg, mn.Rad)) else number(name, value))


def numbers(name: str, value: Any, count: int, kinds: str = "fiu") -> NDArray[Any]:
    """An array of a few numbers, from a vector, an array or a list. Tuples are refused, as in Habitat."""
    wanted = f"a list or array of {count} {'numbers' if 'f' in kinds else 'integers'}"
    if isinstance(value, (tuple, str)):
        raise wrong(name, value, wanted)
    array = np.asarray(value)
    if array.dtype.kind not in kinds or array.shape != (count,):
        raise wrong(name, value, wanted)
    return array


def vector3(name: str, value: Any) -> mn.Vector3:
    """A point or direction."""
    return mn.Vector3(numbers(name, value, 3))


def point(name: str, value: Any) -> tuple[float, float, float]:
    """The same as numbers, for the bindings."""
    x, y, z = numbers(name, value, 3).tolist()
    return x, y, z


def vector2(name: str, value: Any) -> mn.Vector2:
    return mn.Vector2(numbers(name, value, 2))


def size(name: str, value: Any) -> mn.Vector2i:
    """Height and width of an image."""
    pixels = numbers(name, value, 2, "iu")
    if (pixels < 1).any() or (pixels > 8192).any():
        raise ValueError(f"{name} {value!r}: 1 to 8192 pixels are allowed")
    return mn.Vector2i(pixels)


def colour(name: str, value: Any) -> mn.Color4:
    return mn.Color4(numbers(name, value, 4))


def one_of(kind: type[T]) -> Convert[T]:
    """Accepts objects of one class."""

    def convert(name: str, value: Any) -> T:
        if not isinstance(value, kind):
            raise wrong(name, value, f"a {kind.__name__}")
        return value

    return convert


def maybe(convert: Convert[T]) -> Convert[Union[T, None]]:
    """Accepts None, too."""
    return lambda name, value: None if value is None else convert(name, value)


def listed(name: str, value: Any) -> list[Any]:
    return list(value)


def finite(name: str, values: NDArray[Any]) -> None:
    """Raises ValueError for numbers that are not finite."""
    if not all(math.isfinite(value) for value in values):
        raise ValueError(f"{name} {values.tolist()}: finite numbers are wanted")
