"""Errors."""

from __future__ import annotations

from habitat_sim._missing import PHYSICS, refused


class GreedyFollowerError(RuntimeError):
    """A goal that the follower cannot reach."""


class InvalidAttachedObject(RuntimeError):
    """Never raised here: nothing can be attached to an agent."""


assert_obj_valid = refused("habitat_sim.errors.assert_obj_valid", PHYSICS)

__all__ = ["GreedyFollowerError", "InvalidAttachedObject", "assert_obj_valid"]
