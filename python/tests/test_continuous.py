"""Continuous navigation: the simulator, episodes and Gymnasium environments, in model homes (SYNTHETIC)
that `enfilade homes` and `enfilade continuous` make."""

from __future__ import annotations

import copy
import gzip
import io
import json
import math
import pickle
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest
from programs import run

np = pytest.importorskip("numpy")

import enfilade  # noqa: E402
from enfilade import ContinuousAction, ContinuousSimulator, EpisodeStatus, continuous_episodes  # noqa: E402

STOP, FORWARD, LEFT, RIGHT, LOOK_UP, LOOK_DOWN = ContinuousAction


@pytest.fixture(scope="session")
def free(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three homes without pictures, with navigation meshes and episodes of both benchmarks."""
    folder = tmp_path_factory.mktemp("free") / "homes"
    run("homes", "-o", folder, "--preset", "graphs", "--homes", 3, "--paths", 6)
    for task in ("r2r-ce", "rxr-ce"):
        run("continuous", folder, "--task", task)
    return folder


@pytest.fixture(scope="session")
def one(free: Path) -> enfilade.ContinuousEpisode:
    return continuous_episodes(free, "r2r-ce", "train")[0]


def start(sim: ContinuousSimulator, *episodes: enfilade.ContinuousEpisode) -> enfilade.ContinuousState:
    return sim.new_episodes(
        [e.scan for e in episodes], [e.start for e in episodes], [e.heading for e in episodes]
    )


# --- episodes -------------------------------------------------------------------------------------


def test_episodes_have_what_their_files_have(free: Path) -> None:
    episodes = continuous_episodes(free, "r2r-ce", "val_unseen")
    of_graph = enfilade.Episodes(free, "val_unseen")
    assert len(episodes) > 0 and episodes.file.endswith("val_unseen.json.gz")
    texts = {(str(e.path_id), e.text) for e in of_graph}
    for place, episode in enumerate(episodes):
        assert (episode.trajectory_id, episode.instruction) in texts
        assert episode.scan in episode.scene and 0 <= episode.heading < 2 * math.pi
        assert episode.goals is not None and episode.reference_path is not None
        assert np.array_equal(episode.reference_path[0], episode.start)
        assert np.array_equal(episode.reference_path[-1], episode.goals[0].position)
        assert episode.goals[0].radius == 3
        _, y, _, w = episode.rotation  # about Habitat's y axis, to the left
        turn = -2 * math.atan2(y, w)
        assert abs(math.remainder(turn - episode.heading, 2 * math.pi)) < 1e-6
        assert episodes.find(episode.id) == place == episodes.find(int(episode.id))
        expert = episodes.expert(place)
        assert expert is not None and expert.actions[-1] == STOP
        assert len(expert.locations) == np.count_nonzero(expert.actions == FORWARD) + 1
    assert episodes.find("none") is None
    assert episodes[-1].id == episodes[len(episodes) - 1].id
    assert [e.id for e in episodes[:2]] == [episodes[0].id, episodes[1].id]
    again = pickle.loads(pickle.dumps(episodes))
    assert len(again) == len(episodes) and again[0].id == episodes[0].id
    from_file = continuous_episodes(file=episodes.file)
    assert len(from_file) == len(episodes) and from_file.expert(0) is None
    spoken = continuous_episodes(free, "rxr-ce", "val_unseen")[0]
    assert spoken.language is not None and spoken.instruction_id is not None


def test_a_data_set_has_the_episodes_of_both_worlds(free: Path) -> None:
    d = enfilade.Dataset(free)
    assert {"r2r", "r2r-ce", "rxr-ce"} <= d.tasks.keys()
    episodes = d.episodes("val_unseen", "r2r-ce")
    assert isinstance(episodes, enfilade.ContinuousEpisodes)
    assert [e.id for e in episodes] == [e.id for e in continuous_episodes(free, "r2r-ce", "val_unseen")]
    assert isinstance(d.episodes("val_unseen"), enfilade.Episodes)
    ask: Any = d.episodes
    with pytest.raises(enfilade.ArgumentError, match="all_instructions"):
        ask("train", "r2r-ce", all_instructions=True)


def test_wrong_episodes_are_named(free: Path, tmp_path: Path) -> None:
    with pytest.raises(enfilade.FileError, match="tried .*vlnce"):
        continuous_episodes(free, "r2r-ce", "nowhere")
    with pytest.raises(enfilade.UnknownNameError, match="r2r-ce, rxr-ce"):
        continuous_episodes(free, "r2r", "train")
    broken = tmp_path / "broken.json"
    broken.write_text('{"episodes": [{"episode_id": 1, "start_position": [0, 1]}]}')
    with pytest.raises(enfilade.InvalidInput, match=r"\$\.episodes\[0\]"):
        continuous_episodes(file=broken)
    with pytest.raises(IndexError):
        continuous_episodes(free, "r2r-ce", "train")[10**6]


# --- the simulator --------------------------------------------------------------------------------


def test_bodies_move_as_the_state_says(free: Path, one: enfilade.ContinuousEpisode) -> None:
    sim = ContinuousSimulator(free, batch_size=2)
    state = start(sim, one, one)
    assert sim.scans[state.building[0]] == one.scan
    assert np.allclose(state.position, one.start, atol=1e-6) and state.position.dtype == np.float32
    assert (state.off_floor < 0.5).all()
    assert state is sim.state
    with pytest.raises(ValueError):
        state.position[0, 0] = 1
    before = state.position.copy()
    sim.step([FORWARD, RIGHT])
    assert np.linalg.norm(state.position[0] - before[0]) <= 0.3 and state.steps.tolist() == [1, 1]
    assert np.array_equal(state.position[1], before[1])
    turned = math.remainder(state.heading[1] - one.heading - math.radians(15), 2 * math.pi)
    assert abs(turned) < 1e-12
    sim.step([STOP, LOOK_UP])
    assert state.episode.tolist() == [EpisodeStatus.STOPPED, EpisodeStatus.WALKING]
    assert math.isclose(state.elevation[1], math.radians(30))
    stopped = state.position[0].copy()
    sim.step([FORWARD, FORWARD])
    assert np.array_equal(state.position[0], stopped)
    sim.new_episode(0, one.scan, one.start, 0.5)
    assert state.episode[0] == EpisodeStatus.WALKING and state.heading[0] == 0.5


def test_equal_actions_give_equal_bytes_in_any_batch(free: Path) -> None:
    episodes = continuous_episodes(free, "r2r-ce", "train")
    rng = np.random.default_rng(3)
    n = len(episodes)
    actions = rng.choice([1, 1, 1, 2, 3], (60, n))
    together = ContinuousSimulator(free, batch_size=n, threads=2)
    start(together, *episodes)
    alone = ContinuousSimulator(free)
    for row in actions:
        together.step(row)
    for k in range(n):
        start(alone, episodes[k])
        for row in actions:
            alone.step(row[k : k + 1])
        for name in ("position", "heading", "steps", "collisions", "collided"):
            assert np.array_equal(getattr(alone.state, name)[0], getattr(together.state, name)[k])
    assert together.state.collisions.sum() > 0


def test_options_and_tasks_are_what_they_say(free: Path, one: enfilade.ContinuousEpisode) -> None:
    rxr = ContinuousSimulator(free, "rxr-ce")
    assert math.isclose(rxr.config["turn"], math.radians(30)) and rxr.config["slide"] is False
    short = ContinuousSimulator(free, forward=0.5, turn=0.1, most_steps=2)
    start(short, one)
    short.step([RIGHT])
    assert math.isclose(math.remainder(short.state.heading[0] - one.heading, 2 * math.pi), 0.1)
    short.step([RIGHT])
    assert short.state.episode[0] == EpisodeStatus.CUT_SHORT
    own = ContinuousSimulator(navigation=free / "navmesh" / "r2r-ce")
    assert own.scans == short.scans and own.areas(0)[0] > 10
    again = copy.copy(short)
    assert again.config == short.config and again.batch_size == 1


def test_distances_are_those_of_the_floor(free: Path, one: enfilade.ContinuousEpisode) -> None:
    sim = ContinuousSimulator(free)
    assert one.goals is not None and one.geodesic_distance is not None
    goal = one.goals[0].position
    metres = sim.geodesic_distance(one.scan, one.start, goal)
    assert abs(metres - one.geodesic_distance) < 0.02
    assert metres >= math.dist(one.start, goal) - 1e-3
    assert abs(sim.geodesic_distance(one.scan, goal, one.start) - metres) < 1e-3
    path = sim.geodesic_path(one.scan, one.start, goal)
    assert path is not None
    walked = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    assert abs(walked - metres) < 1e-3
    nearer = sim.geodesic_distance(one.scan, one.start, [goal, one.start])
    assert nearer < 1e-3
    assert sim.geodesic_distance(one.scan, one.start, (1e4, 0, 0)) == math.inf
    assert sim.geodesic_path(one.scan, one.start, (1e4, 0, 0)) is None
    assert sim.nearest(one.scan, (1e4, 0, 0)) is None
    drawn = sim.random_point(one.scan, 7)
    assert drawn == sim.random_point(one.scan, 7) != sim.random_point(one.scan, 8)
    back = sim.nearest(one.scan, drawn)
    assert back is not None and math.dist(back, drawn) < 1e-3


def test_the_teacher_does_what_the_experts_did(free: Path) -> None:
    episodes = continuous_episodes(free, "r2r-ce", "val_unseen")
    sim = ContinuousSimulator(free)
    for place in range(0, len(episodes), 3):
        episode, expert = episodes[place], episodes.expert(place)
        assert expert is not None and episode.reference_path is not None
        start(sim, episode)
        sim.follow(0, episode.reference_path)
        did, positions = [], [sim.state.position[0].copy()]
        while sim.state.episode[0] == EpisodeStatus.WALKING:
            action = sim.expert_action(0)
            assert action == sim.expert_action(0)
            sim.step([action])
            did.append(action)
            positions.append(sim.state.position[0].copy())
        assert did == expert.actions.tolist()
        score = episodes.score(sim, place, positions, did)
        assert score["success"] == 1 and score["ndtw"] > 0.999 and math.isnan(score["collisions"])
        assert score["steps_taken"] == len(did)


def test_wrong_calls_of_the_simulator_are_named(free: Path, one: enfilade.ContinuousEpisode) -> None:
    sim = ContinuousSimulator(free, batch_size=2)
    with pytest.raises(enfilade.ArgumentError, match="no episode"):
        sim.step([FORWARD, FORWARD])
    with pytest.raises(enfilade.ArgumentError, match="agent 0 has no episode yet"):
        sim.follow(0, [one.start])
    start(sim, one, one)
    with pytest.raises(enfilade.ArgumentError, match="follow"):
        sim.expert_action(1)
    for wrong in ([1], [1, 2, 3], [1, 6], [-1, 0]):
        with pytest.raises(enfilade.ArgumentError):
            sim.step(wrong)
    with pytest.raises(TypeError, match="integers"):
        sim.step([0.5, 1])
    assert sim.state.steps.tolist() == [0, 0]
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        sim.new_episode(0, "nowhere", one.start, 0)
    with pytest.raises(enfilade.ArgumentError, match="building 99|99"):
        sim.new_episode(0, 99, one.start, 0)
    with pytest.raises(enfilade.ArgumentError, match="agent 1"):
        sim.new_episodes([one.scan] * 2, [one.start, (0, 0, 50)], 0.0)
    with pytest.raises(enfilade.ArgumentError, match="finite"):
        sim.new_episode(0, one.scan, (math.nan, 0, 0), 0)
    with pytest.raises(enfilade.ArgumentError, match=r"positions: shape"):
        sim.new_episodes([one.scan] * 2, one.start, 0.0)
    with pytest.raises(enfilade.ArgumentError, match="no floor within 1 m"):
        sim.follow(0, [(1e4, 0, 0)])
    with pytest.raises(enfilade.ArgumentError, match="speed: not an option"):
        ContinuousSimulator(free, speed=1)
    with pytest.raises(enfilade.ArgumentError, match="forward"):
        ContinuousSimulator(free, forward=-1)
    for name, value in (("forward", "far"), ("most_steps", -1), ("start_reach", 1.0)):
        with pytest.raises(TypeError, match=name):
            ContinuousSimulator(free, **{name: value})
    for many in (0, 2**31):
        with pytest.raises(enfilade.ArgumentError, match="batch_size"):
            ContinuousSimulator(free, batch_size=many)
    assert sim.nearest(one.scan, (math.nan, 0, 0)) is None
    with pytest.raises(enfilade.ArgumentError, match="reached"):
        sim.follow(0, [one.start], reached=-1)
    with pytest.raises(enfilade.ArgumentError):
        sim.follow(0, np.empty((0, 3)))
    with pytest.raises(enfilade.ArgumentError, match="agent 5"):
        sim.new_episode(5, one.scan, one.start, 0)
    with pytest.raises(enfilade.ArgumentError, match="r2r-ce, rxr-ce"):
        ContinuousSimulator(free, "r2r")
    with pytest.raises(enfilade.FileError):
        ContinuousSimulator(free / "vlnce")
    damaged = free.parent / "damaged"
    damaged.mkdir()
    (damaged / "home0001.navmesh").write_bytes(b"no navigation mesh")
    with pytest.raises(enfilade.InvalidInput, match="not-a-navigation-mesh"):
        ContinuousSimulator(navigation=damaged).areas(0)


# --- pictures ---------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def boxes(free: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Meshes of the homes' names that are all the same: a box of 100 x 100 x 50 m around them."""
    folder = tmp_path_factory.mktemp("boxes")
    corners = [(x, y, z) for z in (-5, 45) for y in (-50, 50) for x in (-50, 50)]
    faces = ["1 2 4 3", "5 6 8 7", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"]
    text = "".join("v {} {} {}\n".format(*c) for c in corners) + "".join(f"f {f}\n" for f in faces)
    for scan in ContinuousSimulator(free).scans:
        (folder / f"{scan}.obj").write_text(text)
    return folder


def test_depth_is_that_of_the_mesh(free: Path, boxes: Path, one: enfilade.ContinuousEpisode) -> None:
    from enfilade.eyes import Eyes

    eyes = Eyes(meshes=boxes)
    scan = one.scan
    seen = eyes.render(
        [scan] * 3, [(0, 0, 20)] * 3, [0, math.pi / 2, 0], [0, 0, -math.pi / 2],
        layers=("depth", "rgb", "semantic", "instance"), size={"rgb": (64, 32)},
    )  # fmt: skip
    assert seen["rgb"].shape == (3, 32, 64, 3) and seen["rgb"].dtype == np.uint8
    assert seen["depth"].shape == (3, 256, 256) and seen["semantic"].dtype == np.uint16
    assert np.abs(seen["depth"][:2, 100:156] - 50).max() < 1e-3
    assert np.abs(seen["depth"][2, 100:156, 100:156] - 25).max() < 1e-3
    sim = ContinuousSimulator(free, batch_size=2)
    start(sim, one, continuous_episodes(free, "r2r-ce", "val_unseen")[0])
    assert sim.state.building[0] != sim.state.building[1]
    walked = eyes.render_agents(sim)
    for k in range(2):  # a batch of two buildings is what each gives alone
        x, y, z = sim.state.position[k]
        alone = eyes.render(
            [sim.scans[sim.state.building[k]]], [(x, y, float(z) + 1.25)], sim.state.heading[k]
        )
        assert np.allclose(alone["depth"][0], walked["depth"][k], atol=1e-4)
        assert np.abs(alone["rgb"][0].astype(int) - walked["rgb"][k]).max() <= 1
    by_file = Eyes(meshes={scan: boxes / f"{scan}.obj"}, threads=1)
    again = by_file.render([scan], [(0, 0, 20)], layers=("depth",))
    assert np.array_equal(again["depth"][0], seen["depth"][0])
    for wrong, what in (
        ({"layers": ("smell",)}, "any of rgb"),
        ({"size": (0, 4)}, "at least 1 x 1"),
        ({"vfov": 4.0}, "field_of_view|field of view"),
    ):
        with pytest.raises(enfilade.ArgumentError, match=what):
            eyes.render([scan], [(0, 0, 20)], **wrong)
    with pytest.raises(enfilade.ArgumentError, match="1 names"):
        eyes.render(scan, [(0, 0, 20)])
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        eyes.open("nowhere")
    with pytest.raises(enfilade.FileError, match="none"):
        Eyes(meshes=boxes / "none")
    (boxes / "broken.obj").write_text("v 0 0\n")
    with pytest.raises(enfilade.InvalidInput, match="broken.obj"):
        Eyes(meshes=boxes).open("broken")


def test_homes_have_light_that_is_kept(free: Path, tmp_path: Path, one: enfilade.ContinuousEpisode) -> None:
    """The light of a home takes half a minute of a core."""
    from enfilade.eyes import Eyes

    x, y, z = one.start
    eyes = Eyes(free, light=tmp_path, light_spacing=0.2)
    layers = ("rgb", "depth", "semantic", "instance")
    down = eyes.render([one.scan], [(x, y, z + 1.25)], 0, -math.pi / 2, layers=layers)
    assert abs(down["depth"][0, 128, 128] - 1.25) < 0.1  # the floor, or a rug
    assert down["rgb"].std() > 1 and down["semantic"].any()
    assert (tmp_path / f"{one.scan}.light").exists()
    again = Eyes(free, light=tmp_path).render([one.scan], [(x, y, z + 1.25)], 0, -math.pi / 2, layers=layers)
    assert all(np.array_equal(down[layer], again[layer]) for layer in layers)
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        eyes.open("nowhere")


# --- Habitat's frame ------------------------------------------------------------------------------


def test_points_are_converted_to_habitats_frame_and_back() -> None:
    ours = np.array([[1.0, 2, 3], [4, 5, 6]])
    assert np.array_equal(enfilade.from_habitat(enfilade.to_habitat(ours)), ours)
    assert enfilade.to_habitat((1, 2, 3)).tolist() == [1, 3, -2]


# --- Gymnasium ------------------------------------------------------------------------------------


def equal(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(equal, a, b))
    return bool(np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"))


@pytest.mark.parametrize("name", ["enfilade/R2R-CE-v0", "enfilade/RxR-CE-v0"])
def test_the_environments_pass_gymnasiums_checker(free: Path, boxes: Path, name: str) -> None:
    gymnasium = pytest.importorskip("gymnasium", minversion="1.0")
    from enfilade.gym import ContinuousEnvConfig
    from gymnasium.utils.env_checker import check_env

    env = gymnasium.make(name, config=ContinuousEnvConfig(free, "train"), render_mode="ansi")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=1)
    assert "heading" in env.render()
    assert env.action_space.n == (4 if "R2R" in name else 6)
    size = {"rgb": (24, 16), "depth": (16, 16)}
    looking = ContinuousEnvConfig(free, observe=("rgb", "depth"), sizes=size, eyes={"meshes": boxes})
    sees = gymnasium.make(name, config=looking, render_mode="rgb_array")
    check_env(sees.unwrapped, skip_render_check=True)
    assert sees.reset(seed=1)[0]["depth"].shape == (16, 16) and sees.render().shape == (16, 24, 3)
    with pytest.raises(enfilade.ArgumentError, match="any of rgb"):
        ContinuousEnvConfig(free, observe=("smell",))
    again = pickle.loads(pickle.dumps(env.unwrapped))
    assert equal(again.reset(seed=4)[0], env.unwrapped.reset(seed=4)[0])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_the_vector_environment_does_what_single_ones_do(free: Path, boxes: Path, mode: str) -> None:
    pytest.importorskip("gymnasium", minversion="1.0")
    from enfilade.gym import ContinuousEnvConfig, VlnEnv, VlnVectorEnv
    from gymnasium.vector import AutoresetMode, SyncVectorEnv

    n, kind = 4, AutoresetMode(mode)
    pictures = {"observe": ("depth",), "sizes": {"depth": (12, 8)}, "eyes": {"meshes": boxes, "threads": 1}}
    config = ContinuousEnvConfig(free, max_steps=12, **(pictures if kind == AutoresetMode.SAME_STEP else {}))
    ours = VlnVectorEnv(config, n, autoreset_mode=kind)
    theirs = SyncVectorEnv([lambda: VlnEnv(config)] * n, autoreset_mode=kind)
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert equal(ours.reset(seed=7)[0], theirs.reset(seed=7)[0])
    rng = np.random.default_rng(2)
    ends = 0
    for _ in range(150):
        chosen = rng.choice([0, 1, 1, 1, 1, 1, 1, 2, 3], n)
        got, want = ours.step(chosen), theirs.step(chosen)
        assert equal(got[:4], want[:4])
        assert ours.observation_space.contains(got[0])
        ended = got[2] | got[3]
        ends += int(ended.sum())
        if not ended.any():
            continue
        final, other = (got[4], want[4]) if kind != AutoresetMode.SAME_STEP else (
            got[4]["final_info"], want[4]["final_info"])  # fmt: skip
        for name in ("success", "spl", "ndtw", "distance_to_goal"):
            assert equal(np.where(ended, final[name], 0), np.where(ended, other[name], 0))
        if kind == AutoresetMode.SAME_STEP:
            for mine, its in zip(got[4]["final_obs"], want[4]["final_obs"]):
                assert (mine is None) == (its is None) and (mine is None or equal(mine, its))
        if kind == AutoresetMode.DISABLED:
            options = {"reset_mask": ended}
            assert equal(ours.reset(options=options)[0], theirs.reset(options=dict(options))[0])
    assert ends > 20


def test_the_teacher_arrives_and_rewards_add_up(free: Path) -> None:
    pytest.importorskip("gymnasium", minversion="1.0")
    from enfilade.gym import ContinuousEnvConfig, VlnEnv

    env = VlnEnv(ContinuousEnvConfig(free, "val_unseen"))
    with pytest.raises(enfilade.ArgumentError, match="reset"):
        env.step(1)
    for rule in ("reference", "shortest"):
        _, info = env.reset(options={"episode": 3})
        first, total, ended, steps = info["distance"], 0.0, False, 0
        while not ended:
            if steps == 20:  # asked anew, the other teacher has followed the walk too
                assert env.expert("shortest") is not None
            action = env.expert(rule)
            _, reward, ended, cut, info = env.step(action)
            total, steps = total + reward, steps + 1
            assert not cut
        assert info["success"] == 1 and info["ndtw"] > 0.5
        assert math.isclose(total, first - info["distance"] + 2, abs_tol=1e-6)
        assert env.metrics()["spl"] == info["spl"]
    with pytest.raises(enfilade.ArgumentError, match="ended"):
        env.step(1)
    with pytest.raises(enfilade.ArgumentError, match="reference, shortest"):
        env.expert("spl")
    with pytest.raises(enfilade.ArgumentError, match="not in the split"):
        env.reset(options={"episode": "none"})
    quiet = VlnEnv(ContinuousEnvConfig(free, reward="success", text=False, max_steps=1))
    seen, _ = quiet.reset(seed=1)
    assert "instruction" not in seen
    _, reward, stopped, cut, info = quiet.step(1)
    assert (reward, stopped, cut, info["success"]) == (0.0, False, True, 0)
    with pytest.raises(enfilade.ArgumentError, match="task 'r2r'"):
        ContinuousEnvConfig(free, task="r2r")


def test_no_config_object_is_needed_and_old_ids_warn(free: Path, boxes: Path) -> None:
    gymnasium = pytest.importorskip("gymnasium", minversion="1.0")
    import enfilade.gym

    options = {"data": free, "split": "val_unseen", "max_steps": 5}
    env = gymnasium.make("enfilade/R2R-CE-v0", **options)
    assert env.unwrapped.episodes.task == "r2r-ce" and env.unwrapped.action_masks().all()
    with pytest.warns(DeprecationWarning, match="write enfilade/R2R-CE-v0"):
        old = gymnasium.make("Enfilade/ContinuousRoomToRoom-v0", **options)
    assert equal(env.reset(seed=3)[0], old.reset(seed=3)[0])
    envs = gymnasium.make_vec("enfilade/RxR-CE-v0", 2, data=free)
    assert isinstance(envs.unwrapped, enfilade.gym.VlnVectorEnv) and envs.reset(seed=1)
    for call in (lambda: env.unwrapped.answer("x"), env.unwrapped.objects):
        with pytest.raises(enfilade.ArgumentError, match="r2r-ce"):
            call()
    size, eyes = {"class": (12, 8)}, {"meshes": boxes, "threads": 1}
    with pytest.warns(DeprecationWarning, match="write 'semantic'"):
        looking = enfilade.gym.VlnEnv(
            task="r2r-ce", data=free, observe=("class", "instance"), sizes=size, eyes=eyes
        )
    seen, _ = looking.reset(seed=1)
    assert looking.observation_space.contains(seen)
    assert seen["class"].shape == (8, 12) and seen["instance"].shape == (256, 256)


def test_old_words_of_layers_are_the_callers(boxes: Path, one: enfilade.ContinuousEpisode) -> None:
    from enfilade.eyes import Eyes

    eyes, where = Eyes(meshes=boxes), ([one.scan], [(0, 0, 20)])
    with pytest.warns(DeprecationWarning, match="write 'semantic'") as warned:
        seen = eyes.render(*where, layers=("class", "depth"), size={"class": (6, 4)})
    assert warned[0].filename == __file__ and list(seen) == ["class", "depth"]
    again = eyes.render(*where, layers=("semantic",), size={"semantic": (6, 4)})
    assert np.array_equal(again["semantic"], seen["class"])


# --- experts' walks for video models --------------------------------------------------------------


def test_lerobot_tables_are_read_by_pyarrow(free: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    command = ("export", "--as", "lerobot", "--lerobot-version", "2.1", "--data", free,
               "--split", "val_unseen", "-o", tmp_path)  # fmt: skip
    run(*command, "--python", sys.executable)
    info = json.loads((tmp_path / "meta/info.json").read_text())
    tasks = [json.loads(line)["task"] for line in (tmp_path / "meta/tasks.jsonl").read_text().splitlines()]
    lengths = [json.loads(line) for line in (tmp_path / "meta/episodes.jsonl").read_text().splitlines()]
    episodes = continuous_episodes(free, "r2r-ce", "val_unseen")
    assert info["total_episodes"] == len(lengths) == len(episodes)
    row = 0
    for place, episode in enumerate(episodes):
        name = info["data_path"].format(episode_chunk=0, episode_index=place)
        table = parquet.read_table(tmp_path / name)
        # What is done after a picture leads to the next row's state.
        actions = table["action"].to_pylist()
        states = np.array(table["observation.state"].to_pylist())
        expert = episodes.expert(place)
        assert expert is not None and actions == expert.actions.tolist()
        for k, action in enumerate(actions[:-1]):
            moved = np.linalg.norm(states[k + 1][:2] - states[k][:2])
            turned = math.remainder(states[k + 1][3] - states[k][3], 2 * math.pi)
            turn = {FORWARD: 0.0, LEFT: -math.radians(15), RIGHT: math.radians(15)}[action]
            assert abs(turned - turn) < 1e-5  # headings of single precision
            assert moved < 0.25 + 1e-5 if action == FORWARD else moved == 0
        goal = episode.goals[0].position
        # 0.25 m, or where a step of 0.25 m comes no nearer.
        assert np.linalg.norm(states[-1][:3] - goal) < 0.5
        assert table.num_rows == lengths[place]["length"]
        assert tasks[table["task_index"][0].as_py()] == episode.instruction
        assert table["index"].to_pylist() == list(range(row, row + table.num_rows))
        row += table.num_rows
        first = table["observation.state"][0].as_py()
        assert np.allclose(first[:2], episode.start[:2], atol=1e-5)  # rounded to single precision
        assert abs(math.remainder(first[3] - episode.heading, 2 * math.pi)) < 1e-6
        picture = table["observation.images.rgb"][table.num_rows - 1].as_py()
        opened = image.open(io.BytesIO(picture["bytes"]))
        assert list(opened.size) == info["features"]["observation.images.rgb"]["shape"][1::-1]
    assert row == info["total_frames"]
    named = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    assert set(named) == set(table.column_names) == set(info["features"])
    statistics = json.loads((tmp_path / "meta/episodes_stats.jsonl").read_text().splitlines()[-1])
    assert statistics["stats"]["index"]["max"] == [row - 1]
    table = tmp_path / "data/chunk-000/episode_000001.parquet"
    before = table.read_bytes()
    table.unlink()
    said = run(*command, "--python", sys.executable)
    assert f"of which {len(episodes) - 1} walks were there" in said and table.read_bytes() == before


def test_vlnce_export_is_the_same_split(free: Path, tmp_path: Path) -> None:
    run("export", "--as", "vlnce", "--data", free, "--split", "val_unseen", "-o", tmp_path)
    there = tmp_path / "R2R_VLNCE_v1-3_preprocessed/val_unseen"
    for name in ("val_unseen.json.gz", "val_unseen_gt.json.gz"):
        read = json.loads(gzip.decompress((there / name).read_bytes()))
        assert read == json.loads(gzip.decompress((free / "vlnce" / name).read_bytes()))
    assert len(continuous_episodes(tmp_path, "r2r-ce", "val_unseen")) == len(read)
