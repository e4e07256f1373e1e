"""Navigation meshes, queries, walks and followers, asked again. For habitat_sim.check."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import Any, Optional

import habitat_sim
import numpy as np

from . import _check_scenes as scenes
from ._check_scenes import Job
from ._check_tally import Tally, numbers, point, rotation

ACTIONS = ("move_forward", "turn_left", "turn_right", "look_up", "look_down")
LETTERS = {"move_forward": "F", "turn_left": "L", "turn_right": "R", None: "S"}
MOST_ACTIONS = 500  # of a follower


def mesh_parts(folder: Path) -> list[str]:
    """SCAN_BODY of every navigation mesh of a folder."""
    names = {
        f.name[: -len(end)] for end in (".navmesh.gz", "_queries.npz") for f in folder.glob("*" + end)
    }
    if (folder / "navmeshes.json").exists():
        known = scenes.read_json(folder / "navmeshes.json")["scenes"]
        names |= {f"{scan}_{body}" for scan, bodies in known.items() for body in bodies}
    return sorted(names)


def check_mesh(job: Job, part: str, tally: Tally) -> None:
    """One navigation mesh: its file, its numbers, and all that was asked of it."""
    scenes.choose_navigation(job.folder)
    scan, _, body = part.rpartition("_")
    recorded = job.here / "navmeshes.json"
    about = scenes.read_json(recorded) if recorded.exists() else {}
    form = about.get("form", "config" if job.folder.endswith("_config") else "mp3d")
    known = about.get("scenes", {}).get(scan, {}).get(body, {})
    file, queries = job.here / f"{part}.navmesh.gz", job.here / f"{part}_queries.npz"
    glb = job.glb(scan, form)
    dataset = glb.with_name("homes.scene_dataset_config.json") if form == "config" else None
    with scenes.simulator(glb, dataset) as sim:
        settings = scenes.settings_of(job, body)
        finder = habitat_sim.PathFinder()
        done = sim.recompute_navmesh(finder, settings)
        made = scenes.saved_mesh(finder)
        if file.exists():
            _check_file(f"{job.folder}/{file.name}", scenes.unpacked(file), made, tally)
        settings.include_static_objects = True
        other = habitat_sim.PathFinder()
        sim.recompute_navmesh(other, settings)
        found = {"ok": done, **_numbers(made, scenes.saved_mesh(other), finder)}
    if known:
        version = about.get("habitat_sim_version", habitat_sim.__version__)
        tally.value(f"{recorded.name}: habitat_sim_version", version, habitat_sim.__version__)
        place = f"{job.folder}/navmeshes.json: {scan}.{body}"
        if "home_islands" in known:
            with tally.leaving_out():
                found["home_islands"] = _home_islands(finder, scenes.viewpoints(job.scenes, scan))
        _check_numbers(place, known, found, tally)
        for i, view in enumerate(known.get("topdown", [])):
            tally.tree(f"{place}.topdown[{i}]", view, _topdown(finder, view))
    if queries.exists():
        asked = finder
        if file.exists():
            asked = habitat_sim.PathFinder()
            scenes.load_mesh(asked, scenes.unpacked(file))
        with np.load(queries) as arrays:
            _check_queries(f"{job.folder}/{queries.name}", dict(arrays), asked, tally)


def _check_file(place: str, wanted: bytes, found: bytes, tally: Tally) -> None:
    tally.values += 1
    if wanted != found:
        size = min(len(wanted), len(found))
        a, b = (np.frombuffer(data, np.uint8, size) for data in (wanted, found))
        differing = np.flatnonzero(a != b)
        at = int(differing[0]) if len(differing) else size
        many = f", of which {len(differing)} differ, from byte {at}"
        tally.wrong(place, f"{len(wanted)} bytes", f"{len(found)}{many}")


def _numbers(made: bytes, other: bytes, finder: Any) -> dict[str, Any]:
    """What navmeshes.json has of a mesh, by its names. `other`: its file with static objects."""
    vertices = np.array([point(p) for p in finder.build_navmesh_vertices()], np.float32).reshape(-1, 3)
    indices = np.array(list(finder.build_navmesh_vertex_indices()), np.uint32)
    reopened = habitat_sim.PathFinder()
    loaded = scenes.load_mesh(reopened, made)
    islands = range(finder.num_islands)
    return {
        "settings": finder.nav_mesh_settings,
        "bytes": len(made),
        "sha256": scenes.sha256(made),
        "same_bytes_from_static_objects_but_settings": made[:100] != other[:100] or made == other,
        "tile_same_with_static_objects": made[-200:] == other[-200:] and len(made) == len(other),
        "bounds": [numbers(p) for p in finder.get_bounds()],
        "bounds_when_loaded_from_file": [numbers(p) for p in reopened.get_bounds()],
        "loaded": loaded,
        "navigable_area": finder.navigable_area,
        "num_islands": finder.num_islands,
        "island_area": [finder.island_area(i) for i in islands],
        "island_radius": [finder.island_radius(i) for i in islands],
        "vertices": len(vertices),
        "indices": len(indices),
        "vertices_sha256": scenes.sha256(vertices),
        "indices_sha256": scenes.sha256(indices),
        "island_vertices": [len(finder.build_navmesh_vertices(i)) for i in islands],
    }


def _check_numbers(place: str, known: dict[str, Any], found: dict[str, Any], tally: Tally) -> None:
    for name, wanted in known.items():
        if name == "settings":
            tally.tree(
                f"{place}.settings", wanted, {key: getattr(found[name], key, None) for key in wanted}
            )
        elif name in found:
            if isinstance(wanted, list):
                tally.array(f"{place}.{name}", wanted, found[name], parts=int("bounds" in name))
            else:
                tally.value(f"{place}.{name}", wanted, found[name])


def _home_islands(finder: Any, places: Any) -> dict[str, int]:
    found: dict[str, int] = {}
    for place in places:
        island = str(int(finder.get_island(place)))
        found[island] = found.get(island, 0) + 1
    return found


def _topdown(finder: Any, view: dict[str, Any]) -> dict[str, Any]:
    asked = (view["meters_per_pixel"], view["height"], view["eps"])
    floor = np.asarray(finder.get_topdown_view(*asked))
    islands = np.asarray(finder.get_topdown_island_view(*asked))
    return {
        **view,
        "shape": list(floor.shape),
        "navigable": int(floor.sum()),
        "sha256": scenes.sha256(floor.astype(np.uint8)),
        "islands_sha256": scenes.sha256(islands.astype(np.int32)),
    }


def _check_queries(place: str, arrays: dict[str, Any], finder: Any, tally: Tally) -> None:
    """Every array of a *_queries.npz that is an answer."""
    found: dict[str, Any] = {}
    for ask in (_ask_random, _ask_points, _ask_paths, _ask_goals, _ask_steps, _ask_topdown):
        with contextlib.suppress(_MissingError):
            ask(_Questions(arrays), finder, found)
    vertices = [point(p) for p in finder.build_navmesh_vertices()]
    found["mesh_vertices"] = np.array(vertices, np.float32).reshape(-1, 3)
    for name, answer in found.items():
        if name not in arrays:
            continue
        if name.endswith("_point_list"):
            counts = arrays[name.replace("_point_list", "_points")]
            _check_point_lists(
                f"{place}: {name}", np.split(arrays[name], np.cumsum(counts)[:-1]), answer, tally
            )
        else:
            rows = arrays[name].ndim > 1  # a point, a row of a picture
            tally.array(f"{place}: {name}", arrays[name], answer, parts=int(rows))


def _check_point_lists(place: str, wanted: list[Any], found: list[Any], tally: Tally) -> None:
    """The points of each path are one value."""
    for i, (one, other) in enumerate(zip(wanted, found)):
        tally.value(f"{place}, path {i}", one.tolist(), [numbers(p) for p in other])


class _MissingError(Exception):
    """A recording has not the arrays of one kind of question."""


class _Questions:
    """The arrays of a recording."""

    def __init__(self, arrays: dict[str, Any]) -> None:
        self._arrays = arrays

    def __getitem__(self, name: str) -> Any:
        if name not in self._arrays:
            raise _MissingError(name)
        return self._arrays[name]


def _ask_random(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    answers = []
    for seed in asked["random_seeds"]:
        finder.seed(int(seed))
        answers.append(
            [point(finder.get_random_navigable_point()) for _ in range(asked["random_points"].shape[1])]
        )
    found["random_points"] = answers
    island = int(asked["random_island"][0])
    finder.seed(7)
    found["random_island_points"] = [
        point(finder.get_random_navigable_point(max_tries=10, island_index=island))
        for _ in asked["random_island_points"]
    ]
    finder.seed(9)
    centre = asked["random_near_centre"]
    found["random_near_points"] = [
        point(finder.get_random_navigable_point_near(centre, float(radius), max_tries=100))
        for radius in asked["random_near_radius"]
    ]


def _ask_points(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    points = list(asked["point"])
    hits = [finder.closest_obstacle_surface_point(p) for p in points]
    found["is_navigable"] = [finder.is_navigable(p) for p in points]
    found["is_navigable_y10cm"] = [finder.is_navigable(p, 0.1) for p in points]
    found["snap"] = [point(finder.snap_point(p)) for p in points]
    found["island"] = [finder.get_island(p) for p in points]
    found["island_radius"] = [finder.island_radius(p) for p in points]
    found["obstacle_dist"] = [finder.distance_to_closest_obstacle(p) for p in points]
    found["obstacle_dist_50cm"] = [finder.distance_to_closest_obstacle(p, 0.5) for p in points]
    found["hit_pos"] = [point(hit.hit_pos) for hit in hits]
    found["hit_normal"] = [point(hit.hit_normal) for hit in hits]
    found["hit_dist"] = [hit.hit_dist for hit in hits]
    islands = asked["snap_island_index"]
    found["snap_island"] = [point(finder.snap_point(p, int(i))) for p, i in zip(points, islands)]


def _ask_paths(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    paths, ways = [], []
    for start, end in zip(asked["path_start"], asked["path_end"]):
        path = habitat_sim.ShortestPath()
        path.requested_start, path.requested_end = start, end
        ways.append(finder.find_path(path))
        paths.append(path)
    found["path_found"] = ways
    found["path_distance"] = [path.geodesic_distance for path in paths]
    found["path_points"] = [len(path.points) for path in paths]
    found["path_point_list"] = [list(path.points) for path in paths]


def _ask_goals(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    counts, starts = asked["multi_goal_count"], iter(asked["multi_start"])
    again = len(asked["multi_start"]) // max(len(counts), 1)  # starts of one object
    names = ("found", "distance", "index", "points", "point_list")
    answers: dict[str, list[Any]] = {name: [] for name in names}
    for goals in np.split(asked["multi_goal_list"], np.cumsum(counts)[:-1]):
        path = habitat_sim.MultiGoalShortestPath()
        path.requested_ends = list(goals)
        for _ in range(again):
            path.requested_start = next(starts)
            answers["found"].append(finder.find_path(path))
            answers["distance"].append(path.geodesic_distance)
            answers["index"].append(path.closest_end_point_index)
            answers["points"].append(len(path.points))
            answers["point_list"].append(list(path.points))
    found.update({f"multi_{name}": answer for name, answer in answers.items()})


def _ask_steps(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    steps = list(zip(asked["step_from"], asked["step_to"]))
    found["step_sliding"] = [point(finder.try_step(a, b)) for a, b in steps]
    found["step_no_sliding"] = [point(finder.try_step_no_sliding(a, b)) for a, b in steps]


def _ask_topdown(asked: _Questions, finder: Any, found: dict[str, Any]) -> None:
    height = float(asked["topdown_0.5m_height"][0])
    found["topdown_0.5m"] = finder.get_topdown_view(0.5, height, 0.5)
    found["topdown_islands_0.5m"] = finder.get_topdown_island_view(0.5, height, 0.5)


def put_on_mesh(job: Job, sim: Any, scan: str, body: str) -> None:
    """Gives a simulator the recorded mesh of its scene, or makes it."""
    ending = "_v0.3.3" if job.folder.endswith("_v0.3.3") else ""
    file = job.recordings / f"nav{ending}" / f"{scan}_{body}.navmesh.gz"
    if file.exists():
        scenes.load_mesh(sim.pathfinder, scenes.unpacked(file))
    else:
        sim.recompute_navmesh(sim.pathfinder, scenes.settings_of(job, body))


def state(position: Any, turned: Any) -> Any:
    """An AgentState; `turned` is x, y, z, w."""
    made = habitat_sim.AgentState()
    made.position = np.asarray(position, np.float64)
    made.rotation = habitat_sim.utils.common.quat_from_coeffs(np.asarray(turned, np.float64))
    return made


def walk_parts(folder: Path) -> list[str]:
    """SCAN:GROUP of every group of walks of a folder."""
    parts = []
    for file in sorted(folder.glob("*_walks.npz")):
        with np.load(file) as arrays:
            groups = [name[: -len("_actions")] for name in arrays.files if name.endswith("_actions")]
        parts += [f"{file.name[: -len('_walks.npz')]}:{group}" for group in groups]
    return parts


def check_walks(job: Job, part: str, tally: Tally) -> None:
    """The walks of one group in one home."""
    scenes.choose_navigation(job.folder)
    scan, _, group = part.partition(":")
    parsed = re.fullmatch(r"(.+)_turn([\d.]+)_(slide|stop)", group)
    if parsed is None:
        raise ValueError(
            f"{scan}_walks.npz: group {group!r}: BODY_turnDEGREES_slide or ..._stop is wanted"
        )
    body, turn, moves = parsed.groups()
    with np.load(job.here / f"{scan}_walks.npz") as arrays:
        recorded = {
            name[len(group) + 1 :]: arrays[name] for name in arrays.files if name.startswith(group)
        }
    names = (
        "start",
        "start_rotation",
        "position",
        "rotation",
        "sensor_rotation",
        "collided",
        "sensor_height",
    )
    found: dict[str, list[Any]] = {name: [] for name in names}
    size = scenes.body_size(job, body)
    eye = [scenes.camera("rgb", "COLOR", 8, 8)]
    with scenes.simulator(job.glb(scan), None, size, moves == "slide", float(turn), eye) as sim:
        put_on_mesh(job, sim, scan, body)
        agent = sim.get_agent(0)
        for start, turned, actions in zip(
            recorded["start"], recorded["start_rotation"], recorded["actions"]
        ):
            agent.set_state(state(start, turned), True)
            now = agent.get_state()
            found["start"].append(point(now.position))
            found["start_rotation"].append(rotation(now.rotation))
            for action in actions:
                found["collided"].append(bool(agent.act(ACTIONS[action])))
                now = agent.get_state()
                eyes = now.sensor_states["rgb"]
                found["position"].append(point(now.position))
                found["rotation"].append(rotation(now.rotation))
                found["sensor_rotation"].append(rotation(eyes.rotation))
                found["sensor_height"].append(point(eyes.position)[1] - point(now.position)[1])
    for name, answers in found.items():
        if name in recorded:
            wanted = recorded[name]
            if name == "sensor_height":  # of the first walks alone
                answers = answers[: wanted.size]
            parts = int(name in ("start", "start_rotation", "position", "rotation", "sensor_rotation"))
            tally.array(
                f"{job.folder}/{scan}_walks.npz: {group}_{name}",
                wanted,
                np.array(answers).reshape(wanted.shape),
                parts,
            )


def follower_parts(folder: Path) -> list[str]:
    """SCAN:GROUP of the recorded followers."""
    rows = scenes.read_lines(folder / "greedy_follower.jsonl.gz")
    return sorted({_follower_part(row) for row in rows})


def _follower_part(row: dict[str, Any]) -> str:
    return f"{row['scan']}:{row['body']}_turn{row['turn']}_{'slide' if row['sliding'] else 'stop'}"


def check_follower(job: Job, part: str, tally: Tally) -> None:
    """The followers of one group in one home."""
    scenes.choose_navigation(job.folder)
    name = "greedy_follower.jsonl.gz"
    rows = [
        (i, r) for i, r in enumerate(scenes.read_lines(job.here / name)) if _follower_part(r) == part
    ]
    first = rows[0][1]
    scan, body = first["scan"], first["body"]
    size = scenes.body_size(job, body)
    with scenes.simulator(job.glb(scan), None, size, first["sliding"], first["turn"]) as sim:
        put_on_mesh(job, sim, scan, body)
        for i, row in rows:
            for kind in ("default", "0.25"):
                found = _follow(sim, row, None if kind == "default" else float(kind))
                for key, value in found.items():
                    if f"{key}_{kind}" in row:
                        tally.value(
                            f"{job.folder}/{name}: line {i}, {key}_{kind}", row[f"{key}_{kind}"], value
                        )


def _follow(sim: Any, row: dict[str, Any], radius: Optional[float]) -> dict[str, Any]:
    """Both ways to follow, from the recorded start."""
    agent, goal = sim.get_agent(0), point(row["goal"])
    start = state(row["start"], row["rotation_xyzw"])
    agent.set_state(start, True)
    follower = sim.make_greedy_follower(0, radius)
    failed = habitat_sim.errors.GreedyFollowerError
    try:
        path = "".join(LETTERS[action] for action in follower.find_path(goal))
    except failed:
        path = "ERROR"
    agent.set_state(start, True)
    follower.reset()
    done, ended = "", "limit"
    while ended == "limit" and len(done) < MOST_ACTIONS:
        try:
            action = follower.next_action_along(goal)
        except failed:
            ended = "error"
            break
        done += LETTERS[action]
        if action is None:
            ended = "stop"
        else:
            agent.act(action)
    return {
        "find_path": path,
        "next_action": done,
        "ended": ended,
        "end": numbers(agent.get_state().position),
        "goal_radius": follower.goal_radius,
    }
