"""Names of earlier releases; each warns, and says what to write."""

from __future__ import annotations

from typing import Any

from enfilade._arguments import deprecated
from enfilade.gym._env import VlnEnv
from enfilade.gym._vector import VlnVectorEnv

#: Old id -> its task (None: the config's), and the id to write.
OLD_IDS = {
    "RoomToRoom-v0": (None, "enfilade/R2R-v0"),
    "enfilade/R2RLast-v0": ("r2r-last", "enfilade/R2R-Last-v0"),
    "enfilade/R2RBack-v0": ("r2r-back", "enfilade/R2R-Back-v0"),
    "Enfilade/ContinuousRoomToRoom-v0": ("r2r-ce", "enfilade/R2R-CE-v0"),
    "Enfilade/ContinuousRoomAcrossRoom-v0": ("rxr-ce", "enfilade/RxR-CE-v0"),
}

OLD_CLASSES = {
    "RoomToRoomEnv": VlnEnv,
    "RoomToRoomVectorEnv": VlnVectorEnv,
    "ContinuousRoomToRoomEnv": VlnEnv,
    "ContinuousRoomToRoomVectorEnv": VlnVectorEnv,
}


class OldEnv(VlnEnv):
    """The environment of an old id."""

    def __init__(self, *args: Any, old: str, **options: Any) -> None:
        deprecated(f"the id {old}", OLD_IDS[old][1])
        super().__init__(*args, **options)
        self._ezpickle_kwargs = {**self._ezpickle_kwargs, "old": old}


class OldVectorEnv(VlnVectorEnv):
    """The vector environment of an old id."""

    def __init__(self, *args: Any, old: str, **options: Any) -> None:
        deprecated(f"the id {old}", OLD_IDS[old][1])
        super().__init__(*args, **options)
        self._ezpickle_kwargs = {**self._ezpickle_kwargs, "old": old}
