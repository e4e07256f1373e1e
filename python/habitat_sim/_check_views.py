"""Pictures, semantic scenes and episodes of habitat-lab, asked again. For habitat_sim.check."""

from __future__ import annotations

import contextlib
import importlib
import tempfile
from pathlib import Path
from typing import Any

import habitat_sim
import numpy as np

from . import _check_scenes as scenes
from ._check_navigation import state
from ._check_scenes import Job
from ._check_tally import LeftOutError, Tally, numbers, rotation

DEPTH_ERROR = 0.001  # metres
DEPTH_STEPS = 3  # of the recorded z-buffer: 24 bits from 0.01 m, so that a step is z^2 / 167,772 m
DEPTH_SHARE = 0.999  # of pixels
COLOUR_ERROR = 3  # levels of 255
COLOUR_SHARE = 0.98

PICTURES = {
    "rgb256": "rgb256",
    "rgb224": "rgb224",
    "rgb_rxr": "rgb_320x240_hfov79",
    "equirect_color": "equirect",
    "fisheye_color": "fisheye",
}
"""What follows a pose's name in the files of pictures, by sensor."""


def _scans(folder: Path, ending: str) -> list[str]:
    return sorted(f.name[: -len(ending)] for f in folder.glob("*" + ending))


def sensor_parts(folder: Path) -> list[str]:
    """The homes with recorded pictures."""
    return sorted({row["scan"] for row in scenes.read_json(folder / "poses.json")})


def check_sensors(job: Job, part: str, tally: Tally) -> None:
    """The pictures of one home, by one kind of sensor after the other: a module may lack some kinds."""
    scenes.choose_navigation(job.folder)
    rows = [row for row in scenes.read_json(job.here / "poses.json") if row["scan"] == part]
    shapes = {key: x["shape"] for row in rows for key, x in row.items() if isinstance(x, dict)}
    depths = job.here / "depth_f32.npz"
    with np.load(depths) if depths.exists() else contextlib.nullcontext({}) as depth:
        for kind in ("rgb", "depth", "equirect", "fisheye"):
            some = {name: shape for name, shape in shapes.items() if name.startswith(kind)}
            with tally.leaving_out(kind):
                _check_kind(job, rows, some, depth, tally)


def _check_kind(job: Job, rows: list[Any], shapes: dict[str, Any], depth: Any, tally: Tally) -> None:
    """The poses and pictures of some sensors, at all poses."""
    sensors = [_sensor(name, shape) for name, shape in shapes.items()]
    if not sensors:
        return
    with scenes.simulator(job.glb(rows[0]["scan"]), None, sensors=sensors) as sim:
        agent = sim.get_agent(0)
        for row in rows:
            agent.set_state(state(row["position"], row["rotation_xyzw"]), True)
            if row["tilt"]:
                agent.act(row["tilt"])
            seen, now = sim.get_sensor_observations(), agent.get_state()
            place = f"{job.folder}/poses.json: {row['name']}"
            pose = {"position": numbers(now.position), "rotation_xyzw": rotation(now.rotation).tolist()}
            if "rgb256" in shapes:  # the one whose pose was recorded
                eye = now.sensor_states["rgb256"]
                pose["sensor_position"] = numbers(eye.position)
                pose["sensor_rotation_xyzw"] = rotation(eye.rotation).tolist()
            tally.tree(place, {key: row[key] for key in pose}, pose)
            for key in shapes:
                wanted = {name: row[key][name] for name in ("shape", "dtype")}
                picture = np.asarray(seen[key])
                found = {"shape": list(picture.shape), "dtype": str(picture.dtype)}
                tally.tree(f"{place}.{key}", wanted, found)
                _check_depth(job, f"{row['name']}_{key}", depth, picture, tally)
                if key in PICTURES:
                    with tally.leaving_out("colour"):
                        _check_colour(job, f"{row['name']}_{PICTURES[key]}.png", picture, tally)


def _sensor(name: str, shape: list[int]) -> Any:
    """The recorded sensor of a name."""
    kind = "DEPTH" if "depth" in name else "COLOR"
    if not name.startswith(("equirect", "fisheye")):
        return scenes.camera(name, kind, shape[0], shape[1], 79.0 if name.endswith("_rxr") else 90.0)
    spec: Any
    if name.startswith("equirect"):
        spec = habitat_sim.EquirectangularSensorSpec()
    else:
        spec = habitat_sim.FisheyeSensorDoubleSphereSpec()
        spec.sensor_model_type = habitat_sim.FisheyeSensorModelType.DOUBLE_SPHERE
        spec.xi, spec.alpha, spec.focal_length = -0.27, 0.57, [90.0, 90.0]
        spec.principal_point_offset = [128.0, 128.0]
    spec.uuid = name
    spec.sensor_type = getattr(habitat_sim.SensorType, kind)
    spec.resolution = shape[:2]
    spec.position = [0.0, 1.25, 0.0]
    spec.channels = 4 if kind == "COLOR" else 1
    return spec


def _check_depth(job: Job, name: str, recorded: Any, found: Any, tally: Tally) -> None:
    if name in recorded:
        wanted = recorded[name]
        agrees = np.zeros(1, bool)
        if wanted.shape == found.shape:
            step = np.square(wanted, dtype=np.float64) / (0.01 * 2**24)
            agrees = np.abs(wanted - found) <= np.maximum(DEPTH_ERROR, DEPTH_STEPS * step)
        tally.share(f"{job.folder}/depth_f32.npz: {name}", agrees, DEPTH_SHARE)


def _check_colour(job: Job, name: str, found: Any, tally: Tally) -> None:
    file = job.here / name
    if not file.exists():
        return
    try:
        pillow = importlib.import_module("PIL.Image")
    except ImportError:
        raise LeftOutError("Pillow, which reads the pictures, is not installed") from None
    with pillow.open(file) as image:
        wanted = np.asarray(image.convert("RGB"), np.int16)
    agrees = np.zeros(1, bool)
    if found.shape == (*wanted.shape[:2], 4):
        near = np.abs(wanted - found[..., :3].astype(np.int16)) <= COLOUR_ERROR
        agrees = near.all(axis=-1) & (found[..., 3] == 255)
    tally.share(f"{job.folder}/{name}", agrees, COLOUR_SHARE)


def semantic_parts(folder: Path) -> list[str]:
    """The homes with a recorded semantic scene."""
    return _scans(folder, "_scene.json")


def check_semantic(job: Job, part: str, tally: Tally) -> None:
    """The semantic scene of one home."""
    glb = job.glb(part)
    if not glb.with_suffix(".house").exists():
        raise LeftOutError(f"there is no {glb.with_suffix('.house')}")
    eyes = [scenes.camera("semantic", "SEMANTIC", 8, 8)]
    with scenes.simulator(glb, None, sensors=eyes, semantic=True) as sim:
        found = _semantic_scene(sim.semantic_scene)
    name = f"{part}_scene.json"
    tally.tree(f"{job.folder}/{name}: scene", scenes.read_json(job.here / name), found)


def _semantic_scene(scene: Any) -> dict[str, Any]:
    def box(b: Any) -> dict[str, Any]:
        return {"min": numbers(b.min), "max": numbers(b.max)}

    levels = [
        {
            "id": level.id,
            "aabb": box(level.aabb),
            "regions": [region.id for region in level.regions],
            "objects": len(level.objects),
        }
        for level in scene.levels
    ]
    regions = [
        {
            "id": region.id,
            "category": region.category.name(),
            "category_index": region.category.index(),
            "level": region.level.id,
            "aabb": box(region.aabb),
            "objects": len(region.objects),
        }
        for region in scene.regions
    ]
    objects = [
        {
            "id": one.id,
            "semantic_id": one.semantic_id,
            "category": one.category.name(),
            "category_raw": one.category.name("raw"),
            "category_index": one.category.index(),
            "region": None if one.region is None else one.region.id,
            "aabb": box(one.aabb),
            "obb": {
                "center": numbers(one.obb.center),
                "sizes": numbers(one.obb.sizes),
                "half_extents": numbers(one.obb.half_extents),
                "rotation_xyzw": [float(x) for x in one.obb.rotation],
            },
        }
        for one in scene.objects
    ]
    categories = [{"name": c.name(), "index": c.index()} for c in scene.categories]
    return {
        "aabb": box(scene.aabb),
        "levels": levels,
        "regions": regions,
        "categories": categories,
        "objects": objects,
    }


MEAN_ERRORS = {"rgb": 1.0, "depth": 0.002}
"""By how much the mean of a picture may differ: levels, and the unit of habitat-lab's depth."""


def lab_parts(folder: Path) -> list[str]:
    """SPLIT:AGENT of the recorded episodes."""
    rows = scenes.read_lines(folder / "vln_episodes.jsonl.gz")
    return sorted({f"{row['split']}:{row['agent']}" for row in rows})


def check_lab(job: Job, part: str, tally: Tally) -> None:
    """The episodes of one split by one agent, with habitat-lab."""
    scenes.choose_navigation(job.folder)
    try:
        lab, omega = importlib.import_module("habitat"), importlib.import_module("omegaconf")
    except ImportError as e:
        raise LeftOutError(f"habitat-lab cannot be imported: {e}") from None
    split, _, agent = part.partition(":")
    episodes = job.scenes / "vlnce" / f"{split}.json.gz"
    if not episodes.exists():
        raise LeftOutError(f"there is no {episodes}")
    rows = scenes.read_lines(job.here / "vln_episodes.jsonl.gz")
    with tempfile.TemporaryDirectory() as root:
        (Path(root) / "scene_datasets").mkdir()
        (Path(root) / "scene_datasets/mp3d").symlink_to((job.scenes / "mp3d").resolve())
        (Path(root) / "vlnce").symlink_to((job.scenes / "vlnce").resolve())
        text = (job.here / "config.yaml").read_text(encoding="utf-8")
        config = omega.OmegaConf.create(text.replace("ROOT/", f"{root}/"))
        config.habitat.dataset.split = split
        with lab.Env(config=config) as env:
            known = {str(e.episode_id): e for e in env.episodes}
            for i, row in enumerate(rows):
                if (row["split"], row["agent"]) != (split, agent):
                    continue
                place = f"{job.folder}/vln_episodes.jsonl.gz: line {i}"
                episode = known.get(str(row["episode_id"]))
                if episode is None:
                    tally.value(f"{place}.episode_id", row["episode_id"], None)
                else:
                    _check_episode(place, row, env, episode, tally)


def _check_episode(place: str, row: dict[str, Any], env: Any, episode: Any, tally: Tally) -> None:
    """One episode: the recorded actions again, and the follower asked beside them."""
    # As recorded: another version of the program may write their last digits in another way.
    episode.start_position, episode.start_rotation = row["start_position"], row["start_rotation"]
    episode.goals[0].position = row["goal"]
    env.current_episode = episode
    seen = env.reset()
    finder, now = env.sim.pathfinder, env.sim.get_agent_state()
    found = {
        "episode_over_after_reset": env.episode_over,
        "observation_after_reset": _seen(seen),
        "metrics_after_reset": _plain(env.get_metrics()),
        "navmesh": {"area": finder.navigable_area, "islands": finder.num_islands},
        "state_after_reset": _state(now),
    }
    for key, value in found.items():
        _check_seen(f"{place}.{key}", row[key], value, tally)
    follower = None
    if row["agent"] == "shortest":
        module = importlib.import_module("habitat.tasks.nav.shortest_path_follower")
        follower = module.ShortestPathFollower(env.sim, goal_radius=0.5, return_one_hot=False)
    for i, (action, step) in enumerate(zip(map(int, row["actions"]), row["steps"])):
        at = f"{place}.steps[{i}]"
        if follower is not None:
            chosen = follower.get_next_action(episode.goals[0].position)
            tally.value(f"{at}: the follower's action", action, 0 if chosen is None else int(chosen))
        seen = env.step(action)
        again = {
            **_state(env.sim.get_agent_state()),
            "over": env.episode_over,
            "metrics": _plain(env.get_metrics()),
            "seen": _seen(seen),
        }
        for key, value in again.items():
            _check_seen(f"{at}.{key}", step[key], value, tally)


def _check_seen(place: str, wanted: Any, found: Any, tally: Tally) -> None:
    """Pictures by their shape, type and mean: their bytes are those of one renderer."""
    if isinstance(wanted, dict):
        wanted = {key: value for key, value in wanted.items() if not key.endswith("_sha256")}
        for name, error in MEAN_ERRORS.items():
            picture = wanted.pop(name, None)
            if picture is not None:
                exact = {key: picture[key] for key in ("shape", "dtype")}
                tally.tree(f"{place}.{name}", exact, found[name])
                tally.values += 1
                if not abs(picture["mean"] - found[name]["mean"]) <= error:
                    tally.wrong(f"{place}.{name}.mean", picture["mean"], found[name]["mean"])
    tally.tree(place, wanted, found)


def _state(now: Any) -> dict[str, Any]:
    return {"position": numbers(now.position), "rotation_xyzw": rotation(now.rotation).tolist()}


def _plain(metrics: dict[str, Any]) -> dict[str, Any]:
    """Metrics as JSON has them."""
    made: dict[str, Any] = {}
    for name, value in metrics.items():
        if isinstance(value, dict):
            made[name] = {"count": int(value["count"]), "is_collision": bool(value["is_collision"])}
        elif isinstance(value, (float, np.floating)):
            made[name] = float(value)
        else:
            made[name] = value
    return made


def _seen(observation: dict[str, Any]) -> dict[str, Any]:
    """An observation as JSON has it."""
    made: dict[str, Any] = {}
    for name, value in observation.items():
        if name == "instruction":
            made[name] = value["text"]
        elif name in MEAN_ERRORS:
            picture = np.asarray(value)
            made[name] = {
                "shape": list(picture.shape),
                "dtype": str(picture.dtype),
                "mean": float(picture.mean()),
            }
        else:
            made[name] = np.asarray(value).astype(float).tolist()
    return made
