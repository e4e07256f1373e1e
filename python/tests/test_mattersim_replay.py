"""What was recorded of the old simulator, done again through the drop-in: equal to the bit."""

from __future__ import annotations

import gzip
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import MatterSim
import pytest


def bits(*reals: float) -> bytes:
    """Tells -0.0 from 0.0 as well."""
    return struct.pack(f"{len(reals)}d", *reals)


def read_trace(file: Path) -> tuple[dict[str, Any], Iterator[dict[str, Any]]]:
    lines = (json.loads(line) for line in gzip.open(file, "rt"))  # noqa: SIM115
    return next(lines), lines


def make_simulator(config: dict[str, Any], connectivity: str) -> MatterSim.Simulator:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setRenderingEnabled(False)
    if "width" in config:
        sim.setCameraResolution(config["width"], config["height"])
        sim.setCameraVFOV(config["vfov"])
    if "elevation_limits" in config:
        assert sim.setElevationLimits(*config["elevation_limits"])
    sim.setDiscretizedViewingAngles(config.get("discretized", False))
    if not config.get("restricted", True):
        sim.setRestrictedNavigation(False)
    return sim


def differences(state: Any, old: dict[str, Any], position: tuple[float, float, float]) -> list[str]:
    """Names of the fields of `state` that are not as recorded."""
    here = state.location
    integers = {"step": state.step, "ix": here.ix, "viewIndex": state.viewIndex}
    found = [name for name, value in integers.items() if value != old[name]]
    if (state.scanId, here.viewpointId) != (old["scanId"], old["viewpointId"]):
        found.append("place")
    ours = bits(*position, state.heading, state.elevation)
    if ours != bits(old["x"], old["y"], old["z"], old["heading"], old["elevation"]):
        found.append("pose")
    ways = state.navigableLocations
    if [(w.viewpointId, w.ix) for w in ways] != [(w[0], w[1]) for w in old["nav"]]:
        return [*found, "navigable"]
    for ours_way, old_way in zip(ways, old["nav"]):
        relative = (ours_way.rel_heading, ours_way.rel_elevation, ours_way.rel_distance)
        if bits(*relative) != bits(*old_way[2:]):
            found.append("relative")
    return found


def test_v02_states_are_the_recorded_ones(reference: Path, connectivity: str) -> None:
    header, steps = read_trace(reference / "traces_public.jsonl.gz")
    sims = {name: make_simulator(c, connectivity) for name, c in header["configs"].items()}
    for sim in sims.values():
        sim.initialize()
    states = mismatches = 0
    for step in steps:
        sim = sims[step["c"]]
        if "new" in step["a"]:
            viewpoint, heading, elevation = step["a"]["new"]
            sim.newEpisode([step["s"]], [viewpoint], [heading], [elevation])
        else:
            index, heading, elevation = step["a"]["act"]
            sim.makeAction([index], [heading], [elevation])
        state = sim.getState()[0]
        here = state.location
        mismatches += bool(differences(state, step["st"], (here.x, here.y, here.z)))
        states += 1
    assert states == len(header["scans"]) * len(header["configs"]) * 30 * 16
    assert mismatches == 0


def test_v01_states_are_the_recorded_ones(reference: Path, connectivity: str) -> None:
    header, steps = read_trace(reference / "traces_v01_public.jsonl.gz")
    sims = {name: make_simulator(c, connectivity) for name, c in header["configs"].items()}
    for sim in sims.values():
        sim.init()
    states = mismatches = 0
    for step in steps:
        sim = sims[step["c"]]
        if "new" in step["a"]:
            sim.newEpisode(step["s"], *step["a"]["new"])
        else:
            sim.makeAction(*step["a"]["act"])
        state = sim.getState()
        mismatches += bool(differences(state, step["st"], tuple(state.location.point)))
        states += 1
    assert states == len(header["scans"]) * len(header["configs"]) * 12 * 13
    assert mismatches == 0


def test_random_episodes_are_the_recorded_ones(reference: Path, connectivity: str) -> None:
    for run in json.loads((reference / "random_episodes.json").read_text()):
        sim = MatterSim.Simulator()
        sim.setNavGraphPath(connectivity)
        sim.setRenderingEnabled(False)
        sim.setBatchSize(len(run["scans"]))
        sim.setDiscretizedViewingAngles(run["discretized"])
        if run["seed"] is not None:
            sim.setSeed(run["seed"])
        sim.initialize()
        for call in run["calls"]:
            sim.newRandomEpisode(run["scans"])
            got = [
                [s.scanId, s.location.viewpointId, s.location.ix, s.heading, s.elevation,
                 s.viewIndex]
                for s in sim.getState()
            ]  # fmt: skip
            assert got == call, (run["seed"], run["discretized"])


def test_v01_random_starts_are_the_recorded_ones(reference: Path, connectivity: str) -> None:
    starts = 0
    for run in json.loads((reference / "random_v01.json").read_text()):
        sim = MatterSim.Simulator()
        sim.setNavGraphPath(connectivity)
        sim.setRenderingEnabled(False)
        sim.setDiscretizedViewingAngles(run["discretized"])
        sim.setSeed(run["seed"])
        sim.init()
        for scan, heading, elevation, *recorded in run["calls"]:
            sim.newEpisode(scan, "", heading, elevation)
            s = sim.getState()
            got = [s.location.viewpointId, s.location.ix, s.heading, s.elevation, s.viewIndex]
            assert got == recorded, (run["seed"], scan)
            starts += 1
    assert starts == 744


def test_pictures_are_the_recorded_ones(
    reference: Path, connectivity: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    np = pytest.importorskip("numpy")
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setenv("ENFILADE_MATTERSIM", "8bit-depth")
    golden = reference / "golden"
    for item in json.loads((golden / "golden.json").read_text())["items"]:
        sim = MatterSim.Simulator()
        sim.setNavGraphPath(connectivity)
        sim.setDatasetPath(str(golden / "scans"))
        sim.setDepthEnabled(True)
        sim.setCameraResolution(item["width"], item["height"])
        sim.setCameraVFOV(item["vfov"])
        assert sim.setElevationLimits(-1.55, 1.55)
        sim.initialize()
        start = (item["scanId"], item["viewpointId"], item["heading_given"], item["elevation_given"])
        sim.newEpisode(*([value] for value in start))
        state = sim.getState()[0]

        rgb = np.array(state.rgb)[:, :, ::-1].astype(int)
        away = np.abs(rgb - np.asarray(image.open(golden / item["rgb"])).astype(int))
        # Another JPEG decoder adds a level or two; up to 8 on the edges of faces.
        assert away.max() <= 8 and away.mean() <= 0.3 and (away > 2).mean() <= 1e-4, item["n"]

        depth = np.array(state.depth)[:, :, 0].astype(int)
        steps = np.abs(depth - np.asarray(image.open(golden / item["depth"])).astype(int))
        # Nearest texels on a tie, and silhouettes.
        assert (steps > 257).mean() <= 1e-3, item["n"]


def test_depth_is_not_cut_to_eight_bits(reference: Path, connectivity: str) -> None:
    np = pytest.importorskip("numpy")
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setDepthEnabled(True)
    sim.initialize()
    sim.newEpisode(["17DRP5sb8fy"], ["5b9b2794954e4694a45fc424a8643081"], [0], [0])
    depth = np.array(sim.getState()[0].depth)
    assert depth.dtype == np.uint16 and depth.shape == (240, 320, 1)
    assert (depth[depth > 0] % 257 != 0).mean() > 0.9
