"""The follower of shortest paths."""

from __future__ import annotations

from typing import Any, Optional

from enfilade._eyes import habitat as native

from habitat_sim._fields import Code, point
from habitat_sim.agent.agent import Agent
from habitat_sim.errors import GreedyFollowerError
from habitat_sim.nav._path_finder import PathFinder

__all__ = ["GreedyFollowerCodes", "GreedyGeodesicFollower"]


class GreedyFollowerCodes(Code):
    """What the follower wants."""

    ERROR = -2
    STOP = -1
    FORWARD = 0
    LEFT = 1
    RIGHT = 2


class GreedyGeodesicFollower:
    """Leads an agent along shortest paths, by trying its actions on the floor.

    Args:
        pathfinder: with a navigation mesh.
        agent: its action space has move_forward, turn_left and turn_right.
        goal_radius: metres; it stops where the path is shorter. None: 0.75 of a step.
        stop_key, forward_key, left_key, right_key: what it returns. None: None, and the agent's own keys.
        fix_thrashing: whether it goes on with its plan after turning to and fro.
        thrashing_threshold: how many such turns.
    """

    def __init__(
        self,
        pathfinder: PathFinder,
        agent: Agent,
        goal_radius: Optional[float] = None,
        *,
        stop_key: Any = None,
        forward_key: Any = None,
        left_key: Any = None,
        right_key: Any = None,
        fix_thrashing: bool = True,
        thrashing_threshold: int = 16,
    ) -> None:
        self.pathfinder, self.agent = pathfinder, agent
        own, self.forward_spec = agent._find_action("move_forward")
        left, self.left_spec = agent._find_action("turn_left")
        right, self.right_spec = agent._find_action("turn_right")
        if self.left_spec.amount != self.right_spec.amount:
            raise ValueError(
                f"turn_left by {self.left_spec.amount:g} and turn_right by {self.right_spec.amount:g} degrees: "
                "the follower needs the same"
            )
        self.goal_radius = (
            0.75 * self.forward_spec.amount if goal_radius is None else float(goal_radius)
        )
        self.action_mapping = {
            GreedyFollowerCodes.STOP: stop_key,
            GreedyFollowerCodes.FORWARD: own if forward_key is None else forward_key,
            GreedyFollowerCodes.LEFT: left if left_key is None else left_key,
            GreedyFollowerCodes.RIGHT: right if right_key is None else right_key,
        }
        self._options = (fix_thrashing, thrashing_threshold)
        self._floor: Optional[native.Floor] = None
        self._goal: Any = None

    def next_action_along(self, goal_pos: Any) -> Any:
        """The next action towards a goal. Raises GreedyFollowerError for a goal that cannot be reached."""
        goal = point("goal_pos", goal_pos)
        impl = self._follower()
        if goal != self._goal:
            self.reset()
            self._goal = goal
        code = GreedyFollowerCodes(impl.next(*self.agent._pose, goal))
        if code == GreedyFollowerCodes.ERROR:
            raise GreedyFollowerError(f"goal_pos {list(goal)}: no path leads there")
        return self.action_mapping[code]

    def find_path(self, goal_pos: Any) -> list[Any]:
        """All actions to a goal, stop last. Raises GreedyFollowerError for one that cannot be reached."""
        goal = point("goal_pos", goal_pos)
        impl = self._follower()
        self.reset()
        codes = impl.path(*self.agent._pose, goal)
        if not codes:
            raise GreedyFollowerError(f"goal_pos {list(goal)}: no path leads there")
        return [self.action_mapping[GreedyFollowerCodes(code)] for code in codes]

    def reset(self) -> None:
        """Forgets the actions before."""
        self._goal = None
        if self._floor is not None:
            self._impl.reset()

    def _follower(self) -> native.GreedyFollower:
        floor = self.pathfinder._loaded
        if floor is not self._floor:  # the first, or one computed since
            slide = self.agent._ground.slide
            amounts = self.forward_spec.amount, self.left_spec.amount
            self._impl = native.GreedyFollower(floor, slide, *amounts, self.goal_radius, *self._options)
            self._floor = floor
        return self._impl
