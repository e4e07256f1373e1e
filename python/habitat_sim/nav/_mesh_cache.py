"""Navigation meshes that were made before: making one takes seconds."""

from __future__ import annotations

import hashlib
import os
import struct
import tempfile
from pathlib import Path
from typing import Optional

from enfilade import InvalidInput
from enfilade._eyes import habitat as native

from habitat_sim.logging import logger

_BOUNDS = struct.Struct("<6f")  # of the triangles; the file has those of its tile
_FORM = "1"  # another one for another recipe


def _folder() -> Path:
    """$XDG_CACHE_HOME/enfilade/navmesh, or ~/.cache/enfilade/navmesh. Anything in it may be removed."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(given) if os.path.isabs(given) else Path.home() / ".cache") / "enfilade" / "navmesh"


def made_mesh(
    mesh_file: str, up: str, settings: native.NavMeshSettings, navigation: str
) -> native.Floor:
    """The navigation mesh of a mesh file, out of the cache or made. Raises as native.Floor.make()."""
    values = {name: getattr(settings, name) for name in dir(settings) if not name.startswith("_")}
    numbers = [f"{name}={value!r}" for name, value in values.items() if not callable(value)]
    with open(mesh_file, "rb") as file:
        key = hashlib.sha256(file.read())
    key.update("\n".join([_FORM, up, navigation, *numbers]).encode())
    kept = _folder() / f"{key.hexdigest()}.navmesh"
    floor = _read(kept, navigation)
    if floor is None:
        floor = native.Floor.make(mesh_file, up, settings, navigation)
        _keep(kept, floor)
    return floor


def _read(kept: Path, navigation: str) -> Optional[native.Floor]:
    try:
        data = kept.read_bytes()
        numbers = _BOUNDS.unpack_from(data)
        bounds = (numbers[:3], numbers[3:])
        return native.Floor.read(data[_BOUNDS.size :], str(kept), navigation, bounds)
    except (OSError, InvalidInput, struct.error):
        return None  # there is none, or it is damaged: then it is made anew


def _keep(kept: Path, floor: native.Floor) -> None:
    low, high = floor.bounds
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as part:
            part.write(_BOUNDS.pack(*low, *high) + floor.file())
        os.replace(part.name, kept)
    except OSError as error:
        logger.debug("%s: the navigation mesh is not kept: %s", kept, error)
