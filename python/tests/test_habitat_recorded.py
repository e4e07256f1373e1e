"""Recordings of the real Habitat-Sim, of one home: its files, queries, steps and walks, to the bit.

`python -m habitat_sim.check FOLDER` compares all of them, which takes many minutes.
"""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any, Iterator

import numpy as np
import pytest

pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")
hs = pytest.importorskip("habitat_sim", reason="the drop-in habitat_sim is not there")


@pytest.fixture(params=["latest", "0.3.3"])
def navigation(request: pytest.FixtureRequest) -> Iterator[str]:
    before, hs.nav.navigation = hs.nav.navigation, request.param
    yield request.param
    hs.nav.navigation = before


@pytest.fixture
def recorded(reference: Path, navigation: str) -> Path:
    folder = reference / "habitat" / ("nav" if navigation == "latest" else "nav_v0.3.3")
    if not folder.is_dir():
        pytest.skip(f"{folder} is no folder: no recordings of Habitat-Sim")
    return folder


def open_mesh(recorded: Path, body: str, folder: Path) -> Any:
    finder, file = hs.PathFinder(), folder / "a.navmesh"
    file.write_bytes(gzip.decompress((recorded / f"home0001_{body}.navmesh.gz").read_bytes()))
    assert finder.load_nav_mesh(str(file))
    return finder


def same(found: Any, wanted: Any) -> None:
    np.testing.assert_array_equal(np.array(found, wanted.dtype), wanted)


@pytest.mark.parametrize("body", ["r2r-ce", "rxr-ce"])
def test_a_mesh_answers_as_habitats(recorded: Path, body: str, tmp_path: Path) -> None:
    finder = open_mesh(recorded, body, tmp_path)
    finder.save_nav_mesh(str(tmp_path / "b.navmesh"))
    assert (tmp_path / "b.navmesh").read_bytes() == (tmp_path / "a.navmesh").read_bytes()

    with np.load(recorded / f"home0001_{body}_queries.npz") as arrays:
        known = {name: arrays[name] for name in arrays.files}
    point = known["point"]
    same([finder.is_navigable(p) for p in point], known["is_navigable"])
    same([finder.snap_point(p) for p in point], known["snap"])
    same([finder.get_island(p) for p in point], known["island"])
    same([finder.island_radius(p) for p in point], known["island_radius"])
    same([finder.distance_to_closest_obstacle(p) for p in point], known["obstacle_dist"])
    steps = list(zip(known["step_from"], known["step_to"]))
    same([finder.try_step(a, b) for a, b in steps], known["step_sliding"])
    same([finder.try_step_no_sliding(a, b) for a, b in steps], known["step_no_sliding"])
    for seed, points in zip(known["random_seeds"], known["random_points"]):
        finder.seed(int(seed))
        same([finder.get_random_navigable_point() for _ in points], points)

    lengths, corners = [], []
    for start, end in zip(known["path_start"], known["path_end"]):
        path = hs.ShortestPath()
        path.requested_start, path.requested_end = start, end
        finder.find_path(path)
        lengths.append(path.geodesic_distance)
        corners += path.points
    same(lengths, known["path_distance"])
    same(corners, known["path_point_list"])
