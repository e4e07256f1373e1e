"""The words for the layers of an image. Does not need NumPy."""

from __future__ import annotations

from enfilade._arguments import deprecated
from enfilade._errors import ArgumentError

LAYERS = ("rgb", "depth", "semantic", "instance")
"""All of them."""
_OLD = {"colour": "rgb", "class": "semantic", "classes": "semantic", "instances": "instance"}


def layer_of(word: str) -> str:
    """The layer that a word names, old words included; another word unchanged."""
    return _OLD.get(word, word)


def checked_layer(argument: str, word: str) -> str:
    """The layer that a word names; an old word warns. Raises ArgumentError for another word."""
    layer = layer_of(word)
    if layer not in LAYERS:
        raise ArgumentError(f"{argument} '{word}': any of {', '.join(LAYERS)} are wanted")
    if layer != word:
        deprecated(f"{argument} '{word}'", f"'{layer}'")
    return layer
