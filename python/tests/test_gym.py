"""enfilade.gym against Gymnasium's own checkers, and the vector environment against single ones."""

from __future__ import annotations

import copy
import json
import pickle
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
gymnasium = pytest.importorskip("gymnasium", minversion="1.0")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium import wrappers  # noqa: E402
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.wrappers import vector as vector_wrappers  # noqa: E402

import enfilade  # noqa: E402
from enfilade.gym import EnvConfig, VlnEnv, VlnVectorEnv, Transition  # noqa: E402


@pytest.fixture(scope="session")
def vocabulary(small: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("words") / "vocabulary.txt"
    file.write_text("<PAD>\n<UNK>\n<EOS>\nwalk\nturn\nthe\n")
    return str(file)


def equal(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(equal, a, b))
    return bool(np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"))


@pytest.mark.parametrize("actions", ["viewpoint", "six", "panoramic", "map"])
def test_the_environment_passes_gymnasiums_checker(
    small: str, vocabulary: str, actions: str
) -> None:
    config = EnvConfig(small, actions=actions, vocabulary=vocabulary)
    env = gymnasium.make("enfilade/R2R-v0", config=config, render_mode="ansi")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=1)
    text = env.render()
    assert isinstance(text, str) and "heading" in text
    env.close()


@pytest.mark.parametrize("actions", ["viewpoint", "six", "panoramic", "map"])
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_the_vector_environment_does_what_single_ones_do(
    small: str, vocabulary: str, actions: str, mode: AutoresetMode
) -> None:
    """Observations, rewards, ends and final observations, for 300 steps of 5 agents."""
    n = 5
    config = EnvConfig(small, actions=actions, vocabulary=vocabulary, max_steps=9)
    ours = VlnVectorEnv(config, n, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: VlnEnv(config)] * n, autoreset_mode=mode)
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert ours.metadata["autoreset_mode"] == mode
    assert equal(ours.reset(seed=7)[0], theirs.reset(seed=7)[0])
    rng = np.random.default_rng(2)
    ends = 0
    for _ in range(300):
        chosen = rng.integers(0, 6, n)
        got, want = ours.step(chosen), theirs.step(chosen)
        assert equal(got[:4], want[:4])
        assert ours.observation_space.contains(got[0])
        ended = got[2] | got[3]
        ends += int(ended.sum())
        if ended.any():
            check_final(got[4], want[4], mode)
        if ended.any() and mode == AutoresetMode.DISABLED:
            options = {"reset_mask": ended}
            assert equal(ours.reset(options=options)[0], theirs.reset(options=dict(options))[0])
    assert ends > 50


def check_final(ours: dict[str, Any], theirs: dict[str, Any], mode: AutoresetMode) -> None:
    if mode != AutoresetMode.SAME_STEP:
        assert equal(ours["success"], theirs["success"])
        assert equal(ours["_success"], theirs["_success"])
        return
    assert equal(ours["_final_obs"], theirs["_final_obs"])
    for one, other in zip(ours["final_obs"], theirs["final_obs"]):
        assert (one is None) == (other is None)
        assert one is None or equal(one, other)
    for name in ("success", "spl", "distance", "_success", "_distance"):
        got = ours["final_info"][name]
        mask = ours["_final_obs"]
        assert equal(np.where(mask, got, 0), np.where(mask, theirs["final_info"][name], 0))


@pytest.mark.parametrize("actions", ["viewpoint", "six", "panoramic", "map"])
def test_the_teacher_names_possible_actions_and_arrives(small: str, actions: str) -> None:
    env = VlnEnv(EnvConfig(small, actions=actions, max_steps=200))
    with pytest.raises(enfilade.ArgumentError, match="reset"):
        env.expert()
    for episode in range(4):
        env.reset(options={"episode": episode})
        ended, info = False, {}
        while not ended:
            action = env.expert()
            assert action is not None and env.action_masks()[action]
            _, _, stopped, cut, info = env.step(action)
            ended = stopped or cut
        # "six" goes forward to the nearest to the middle, which may be another than the teacher means.
        assert actions == "six" or (stopped and info["success"] == 1)
    with pytest.raises(enfilade.ArgumentError, match="spl, ndtw"):
        env.expert("cls")


def test_map_arrays_say_where_each_action_leads(small: str) -> None:
    env = VlnEnv(EnvConfig(small, actions="map"))
    env.reset(seed=3)
    rng = np.random.default_rng(4)
    for _ in range(6):
        arrays, masks = env.arrays, env.action_masks()
        assert masks.shape == (env.action_space.n,)
        assert not (arrays["node_visited"][0] & arrays["node_mask"][0])[1:].any()
        seen = set(arrays["candidate_viewpoint"][0][arrays["candidate_mask"][0] == 1])
        known = (arrays["node_visited"][0] | arrays["node_mask"][0]) == 1
        assert seen <= set(arrays["node_viewpoint"][0][known])
        assert arrays["nodes"][0, 0].tolist() == [0, 1, 0, 1, 0, 0, 0]
        choices = np.flatnonzero(masks)[1:]
        if not len(choices):
            break
        action = int(rng.choice(choices))
        wanted = int(arrays["node_viewpoint"][0, action])
        env.step(action)
        assert env.arrays["viewpoint"][0] == wanted
        assert env.arrays["node_visited"][0, action] == 1  # a node keeps its number
    assert env.arrays["step"][0] > 0


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_environments_in_other_processes_do_the_same(small: str, mode: AutoresetMode) -> None:
    """Without shared memory: there Gymnasium (1.4) reads texts once, before the first reset()."""
    config = EnvConfig(small, max_steps=5)
    ours = VlnVectorEnv(config, 3, autoreset_mode=mode)
    theirs = AsyncVectorEnv(
        [lambda: VlnEnv(config)] * 3, shared_memory=False, autoreset_mode=mode
    )
    try:
        assert equal(ours.reset(seed=2)[0], theirs.reset(seed=2)[0])
        ours.action_space.seed(1)
        for _ in range(30):
            actions = ours.action_space.sample()
            assert equal(ours.step(actions)[:4], theirs.step(actions)[:4])
    finally:
        theirs.close()


def test_gymnasiums_wrappers_wrap_them(small: str) -> None:
    config = EnvConfig(small, max_steps=9)
    one = wrappers.RecordEpisodeStatistics(wrappers.TimeLimit(VlnEnv(config), 3))
    one.reset(seed=1)
    rewards, ended = [], False
    while not ended:
        _, reward, stopped, cut, info = one.step(1)
        rewards.append(reward)
        ended = stopped or cut
    assert len(rewards) == 3 and info["episode"]["r"] == pytest.approx(sum(rewards), abs=1e-5)
    for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
        plain = VlnVectorEnv(config, 4, autoreset_mode=mode)
        many = vector_wrappers.RecordEpisodeStatistics(
            vector_wrappers.NormalizeReward(VlnVectorEnv(config, 4, autoreset_mode=mode))
        )
        many.reset(seed=3), plain.reset(seed=3)
        lengths = []
        for step in range(40):
            actions = np.full(4, 1 + step % 2)
            seen, rewards, stopped, cut, info = many.step(actions)
            want = plain.step(actions)
            assert equal((seen, stopped, cut), (want[0], want[2], want[3]))
            assert np.isfinite(rewards).all()
            if "episode" in info:
                lengths += info["episode"]["l"][info["_episode"]].tolist()
        assert lengths and set(lengths) <= {8, 9}  # Gymnasium 1.1 counts one less after the first
    numbers = vector_wrappers.FlattenObservation(
        vector_wrappers.FilterObservation(VlnVectorEnv(config, 4), ["pose", "candidates"])
    )
    assert numbers.reset(seed=1)[0].shape == (4, 2 + 16 * 3)


def test_the_same_seed_gives_the_same_steps(small: str) -> None:
    """Again by the same environment, and by a pickled or copied one, which begins anew."""

    def walk(env: Any) -> list[Any]:
        env.action_space.seed(3)
        found = [env.reset(seed=11)]
        for _ in range(60):
            found.append(env.step(env.action_space.sample()))
            if isinstance(env, VlnEnv) and (found[-1][2] or found[-1][3]):
                found.append(env.reset())
        return found

    config = EnvConfig(small, max_steps=5)
    for env in (VlnEnv(config), VlnVectorEnv(config, 3, autoreset_mode="SameStep")):
        first = walk(env)
        again = [walk(env), walk(pickle.loads(pickle.dumps(env))), walk(copy.deepcopy(env))]
        assert all(str(one) == str(first) for one in again)


def test_what_is_seen_at_the_end_is_in_its_space(small: str) -> None:
    for actions in ("viewpoint", "six"):
        config = EnvConfig(small, max_steps=4, actions=actions)
        envs = VlnVectorEnv(config, 8, autoreset_mode=AutoresetMode.SAME_STEP)
        envs.reset(seed=0)
        envs.action_space.seed(0)
        ends = {"terminated": 0, "truncated": 0}
        for _ in range(100):
            seen, _, stopped, cut, info = envs.step(envs.action_space.sample())
            assert envs.observation_space.contains(seen)
            ends["terminated"] += int(stopped.sum())
            ends["truncated"] += int(cut.sum())
            for final in info.get("final_obs", ()):
                assert final is None or envs.single_observation_space.contains(final)
        assert min(ends.values()) > 10


def test_make_vec_gives_the_native_one(small: str) -> None:
    envs = gymnasium.make_vec(
        "enfilade/R2R-v0", 3, config=EnvConfig(small), autoreset_mode="SameStep"
    )
    assert envs.unwrapped.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    with pytest.raises(enfilade.ArgumentError, match="reset_mask"):
        envs.reset(options={"reset_mask": np.zeros(3, bool)})
    assert envs.reset(options={"episode": [2, 0, 1]})[1]["episode_index"].tolist() == [2, 0, 1]
    envs = gymnasium.make_vec("enfilade/R2R-v0", 3, config=EnvConfig(small))
    assert isinstance(envs.unwrapped, VlnVectorEnv) and envs.num_envs == 3
    envs.reset(seed=1)
    envs.step(envs.action_space.sample())


def test_what_is_returned_is_ones_own(small: str) -> None:
    envs = VlnVectorEnv(EnvConfig(small), 4)
    first, _ = envs.reset(seed=1)
    kept = {name: np.array(value) for name, value in first.items()}
    _, rewards, *_ = envs.step([1, 1, 1, 1])
    before = rewards.copy()
    envs.step([1, 2, 1, 2])
    assert all((kept[name] == np.array(first[name])).all() for name in first)
    assert (rewards == before).all()


def test_the_teacher_is_paid_for_its_way(small: str) -> None:
    """Along the reference path the rewards sum to its length and the prize for stopping there."""
    env = VlnEnv(EnvConfig(small))
    episodes = env.episodes
    graphs = episodes.graphs
    for index in range(0, len(episodes), 17):
        episode = episodes[index]
        _, info = env.reset(options={"episode": index})
        assert info["instruction_id"] == episode.instruction_id
        arrays, total, done = env.arrays, 0.0, False
        graph = graphs[episode.scan]
        for step in [*episode.path[1:], None]:
            number = 0
            if step is not None:
                count = int(arrays["candidate_mask"][0].sum())
                number = list(arrays["candidate_viewpoint"][0][:count]).index(graph.index(step))
            _, reward, done, _, info = env.step(number)
            total += reward
        way = graph.distance(episode.path[0], episode.path[-1])
        assert done and info["success"] == 1 and info["distance"] == 0
        assert total == pytest.approx(way + 2)
        assert env.metrics()["ndtw"] == pytest.approx(1)
        assert info["spl"] == env.metrics()["spl"]


def test_candidates_say_where_one_gets(small: str) -> None:
    env = VlnEnv(EnvConfig(small))
    seen, info = env.reset(seed=3)
    right, _, metres = seen["candidates"][1]
    graph = env.episodes.graphs[info["scan"]]
    here = graph.positions[graph.index(info["viewpoint"])]
    _, _, _, _, info = env.step(1)
    there = graph.positions[graph.index(info["viewpoint"])]
    assert np.linalg.norm(there - here) == pytest.approx(metres, abs=1e-5)
    heading = np.arctan2(there[0] - here[0], there[1] - here[1])
    turned = seen["pose"][0] + right - heading
    assert abs((turned + np.pi) % (2 * np.pi) - np.pi) < 1e-5


def halfway(transition: Transition) -> Any:
    return 0.5 * (transition.distance_before - transition.distance) + transition.success


def test_rewards_are_pluggable(small: str) -> None:
    config = EnvConfig(small, reward=halfway, max_steps=5)
    mine = VlnVectorEnv(config, 8)
    plain = VlnVectorEnv(EnvConfig(small, max_steps=5), 8)
    none = VlnVectorEnv(EnvConfig(small, reward="none", max_steps=5), 8)
    for envs in (mine, plain, none):
        envs.reset(seed=4)
    rng = np.random.default_rng(1)
    for _ in range(50):
        actions = rng.integers(0, 5, 8)
        _, got, stopped, _, info = mine.step(actions)
        _, want, *_ = plain.step(actions)
        success = stopped & (info["distance"] < 3)
        prize = np.where(stopped, np.where(success, 2.0, -2.0), 0)
        assert got == pytest.approx(0.5 * (want - prize) + success)
        assert not none.step(actions)[1].any()


def test_configs_are_pickled_and_bad_ones_refused(small: str) -> None:
    config = EnvConfig(small, reward=halfway, observe=("rgb",))
    assert pickle.loads(pickle.dumps(config)) == config
    wrong: dict[str, Any]
    for wrong in ({"actions": "fly"}, {"observe": ("smell",)}, {"observe": "rgb"}, {"tokens": 0},
                  {"reward": "money"}, {"reward": None}, {"width": -1}, {"seed": -1}):  # fmt: skip
        with pytest.raises(enfilade.ArgumentError, match=next(iter(wrong))):
            EnvConfig(small, **wrong)
    with pytest.raises(TypeError, match="max_steps 2.5"):
        EnvConfig(small, max_steps=2.5)  # type: ignore[arg-type]
    for wrong in ({"max_steps": 0}, {"max_candidates": 2}, {"vfov": -1.0}):
        with pytest.raises(ValueError):
            VlnEnv(EnvConfig(small, **wrong))
    VlnEnv(EnvConfig(Path(small))).reset()
    with pytest.raises(ValueError, match="episode 'x'"):
        VlnEnv(EnvConfig(small)).reset(options={"episode": "x"})
    with pytest.raises(ValueError, match="hides its goals"):
        VlnEnv(EnvConfig(small, split="test"))
    VlnEnv(EnvConfig(small, split="test", reward="none")).reset()


def test_an_ended_episode_has_to_be_reset(small: str) -> None:
    env = VlnEnv(EnvConfig(small))
    with pytest.raises(ValueError, match="reset"):
        env.step(0)
    env.reset()
    env.step(0)
    with pytest.raises(ValueError, match="ended"):
        env.step(0)
    with pytest.raises(ValueError, match="action 16"):
        env.reset()
        env.step(16)


def test_wrong_calls_are_named_and_change_nothing(small: str) -> None:
    config = EnvConfig(small)
    one, many = VlnEnv(config, render_mode="ansi"), VlnVectorEnv(config, 2)
    for call in (one.render, lambda: many.step([0, 0])):
        with pytest.raises(enfilade.ArgumentError, match=r"reset\(\) has to come first"):
            call()
    kept = one.reset(seed=5), many.reset(seed=5)
    wrong, refused = enfilade.ArgumentError, TypeError
    for error, words, call in [
        (refused, "actions of type float64", lambda: one.step(0.5)),
        (refused, "actions of type object", lambda: one.step(None)),
        (wrong, "action -1: 0 to 15", lambda: one.step(-1)),
        (wrong, r"shape \(1, 2\), not \(1,\)", lambda: one.step([0, 1])),
        (refused, "actions of type float64", lambda: many.step([0.5, 0.7])),
        (wrong, r"shape \(1,\), not \(2,\)", lambda: many.step([0])),
        (wrong, "agent 1: action 99", lambda: many.step([0, 99])),
        (wrong, "episode -1", lambda: one.reset(options={"episode": -1})),
        (wrong, "episode 1000000: 0 to", lambda: one.reset(options={"episode": 10**6})),
        (refused, "episode 0.5", lambda: one.reset(options={"episode": 0.5})),
        (wrong, "2 elements for 1 agents", lambda: one.reset(options={"episode": [0, 1]})),
        (wrong, "seed -1", lambda: many.reset(seed=[5, -1])),
        (wrong, "seed 1180591620717411303424", lambda: many.reset(seed=[None, 2**70])),
        (wrong, "num_envs 0|batch_size 0", lambda: VlnVectorEnv(config, 0)),
        (wrong, "num_envs -1", lambda: VlnVectorEnv(config, -1)),
        (wrong, "reset_mask", lambda: many.reset(options={"reset_mask": np.zeros(2, bool)})),
    ]:  # fmt: skip
        with pytest.raises(error, match=words):
            call()
    assert one.arrays["step"].tolist() == [0] and many.arrays["step"].tolist() == [0, 0]
    assert equal((one.reset(seed=5), many.reset(seed=5)), kept)


@pytest.fixture
def pictured(reference: Path, data: Path, tmp_path: Path) -> str:
    """Episodes between two of the viewpoints that there are recorded pictures of."""
    (tmp_path / "connectivity").symlink_to(data / "connectivity")
    (tmp_path / "scans").symlink_to(reference / "golden" / "scans")
    start, goal = "5b9b2794954e4694a45fc424a8643081", "51857544c192476faebf212acb1b3d90"
    path = {"path_id": 1, "scan": "17DRP5sb8fy", "heading": 0.5, "path": [start, goal],
            "distance": 3.0, "instructions": ["go"] * 3}  # fmt: skip
    (tmp_path / "r2r").mkdir()
    (tmp_path / "r2r" / "R2R_train.json").write_text(json.dumps([path]))
    return str(tmp_path)


@pytest.mark.parametrize("mode", ["rgb_array", None])
def test_pictures_are_seen_where_there_are_some(pictured: str, mode: Any) -> None:
    config = EnvConfig(pictured, observe=("rgb", "depth"), width=64, height=48)
    env = VlnEnv(config, render_mode=mode)
    seen, _ = env.reset(seed=1)
    assert env.observation_space.contains(seen)
    assert seen["rgb"].std() > 5 and 0 < seen["depth"].max() < 20
    assert mode is None or (env.render() == seen["rgb"]).all()
    envs = VlnVectorEnv(config, 2)
    both, _ = envs.reset(seed=1)
    assert (both["rgb"][0] == seen["rgb"]).all() and envs.observation_space.contains(both)


def test_the_checker_passes_with_pictures_and_render_modes(homes: str) -> None:
    layers = ("rgb", "depth", "semantic", "instance")
    config = EnvConfig(homes, observe=layers, width=64, height=48)
    env = gymnasium.make("enfilade/R2R-v0", config=config, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    envs = VlnVectorEnv(config, 2, render_mode="rgb_array")
    envs.reset(seed=1)
    drawn = envs.render()
    assert isinstance(drawn, tuple) and [one.shape for one in drawn] == [(48, 64, 3)] * 2


@pytest.mark.parametrize("mode", list(AutoresetMode)[:2])
def test_pictures_of_ended_episodes_are_those_of_single_environments(
    pictured: str, mode: AutoresetMode
) -> None:
    config = EnvConfig(pictured, actions="six", observe=("rgb", "depth"), width=32, height=24)
    ours = VlnVectorEnv(config, 3, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: VlnEnv(config)] * 3, autoreset_mode=mode)
    assert equal(ours.reset(seed=7)[0], theirs.reset(seed=7)[0])
    stop, kept = 5, []
    for actions in ([0, 1, stop], [stop, 0, 2], [3, 1, 0], [stop, stop, 1], [0, stop, 0]):
        got, want = ours.step(np.array(actions)), theirs.step(np.array(actions))
        assert equal(got[:4], want[:4])
        if mode == AutoresetMode.SAME_STEP and (got[2] | got[3]).any():
            check_final(got[4], want[4], mode)
        kept.append((got[0]["rgb"], got[0]["rgb"].copy()))
    assert all((one == as_it_was).all() for one, as_it_was in kept)


# --- other benchmarks than R2R; the data are SYNTHETIC


IDS = {
    "enfilade/R2R-v0": "val_unseen",
    "enfilade/R2R-Back-v0": "val_unseen",
    "enfilade/R4R-v0": "val_unseen",
    "enfilade/RxR-v0": "val_unseen",
    "enfilade/REVERIE-v0": "val_unseen",
    "enfilade/CVDN-v0": "val_unseen",
    "enfilade/SOON-v0": "val_unseen_instrs",
}


def walk_along(env: Any) -> tuple[float, dict[str, Any]]:
    """Along the reference path of the episode, and a stop there."""
    arrays, episode = env.unwrapped.arrays, env.unwrapped.episodes
    path = episode[int(arrays["episode"][0])].path
    graph = env.unwrapped.episodes.graphs[episode[0].scan]
    reward = 0.0
    for viewpoint in path[1:]:
        row = arrays["candidate_viewpoint"][0] == graph.index(viewpoint)
        masked = row & (arrays["candidate_mask"][0] == 1)
        _, gained, stopped, cut, info = env.step(int(np.flatnonzero(masked)[0]))
        reward += float(gained)
        assert not stopped and not cut
    _, gained, stopped, _, info = env.step(0)
    assert stopped
    return reward + float(gained), info


@pytest.mark.parametrize("name", IDS)
def test_every_benchmark_has_an_environment(made: Path, name: str) -> None:
    env = gymnasium.make(name, config=EnvConfig(made, IDS[name]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=1, options={"episode": 0})
    assert env.unwrapped.episodes.task == enfilade.gym.ENV_TASKS[name]
    distance = float(env.unwrapped.arrays["distance"][0])
    reward, info = walk_along(env)
    assert info["success"] == 1 and info["distance"] == 0
    assert reward == pytest.approx(distance + 2)
    envs = gymnasium.make_vec(name, 3, config=EnvConfig(made, IDS[name]))
    envs.reset(seed=1)
    assert envs.unwrapped.episodes.task == enfilade.gym.ENV_TASKS[name]


def test_to_stop_at_the_start_is_no_success(made: Path) -> None:
    for name, split in IDS.items():
        env = gymnasium.make(name, config=EnvConfig(made, split, success_distance=0.5))
        env.reset(seed=1)
        assert env.step(0)[4]["success"] == 0, name


def test_objects_are_answered(made: Path) -> None:
    config = EnvConfig(made, "val_unseen", answer_reward=5.0)
    env = gymnasium.make("enfilade/REVERIE-v0", config=config).unwrapped
    env.reset(options={"episode": 0})
    assert env.objects() == [] and env.metrics()["rgs"] == 0
    distance = float(env.arrays["distance"][0])
    env.answer(7)
    reward, info = walk_along(env)
    assert info["answered"] and reward == pytest.approx(distance + 2 + 5)
    assert [one.name for one in env.objects()] == ["plant#pot"]
    metrics = env.metrics()
    assert metrics["rgs"] == 1 and metrics["rgspl"] == pytest.approx(1)
    for answer in (8, None):
        env.reset(options={"episode": 0})
        env.answer(answer)
        reward, info = walk_along(env)
        assert not info["answered"] and reward == pytest.approx(distance + 2)
    env.reset(options={"episode": 0})
    assert not walk_along(env)[1]["answered"], "an answer is of one episode"
    with pytest.raises(TypeError):
        env.answer([1])


def test_objects_are_pointed_at(made: Path) -> None:
    env = gymnasium.make("enfilade/SOON-v0", config=EnvConfig(made, "val_unseen_instrs")).unwrapped
    for direction, right in (((1.5, 0.0), True), ((3.0, 0.0), False)):
        env.reset(options={"episode": 0})
        env.answer(direction)
        assert walk_along(env)[1]["answered"] == right
        assert env.metrics()["det_success"] == right
    env = gymnasium.make("enfilade/R4R-v0", config=EnvConfig(made, "val_unseen")).unwrapped
    env.reset()
    with pytest.raises(enfilade.ArgumentError, match="a path alone"):
        env.answer("x")
    assert "CLS" in env.metrics()


def test_the_vector_environment_answers(made: Path) -> None:
    envs = VlnVectorEnv(EnvConfig(made, "val_unseen", task="reverie"), 2)
    envs.reset(options={"episode": [0, 1]})
    envs.answer(1, 7)
    info = envs.step([0, 0])[4]
    assert info["answered"].tolist() == [False, True] and info["_answered"].all()
    assert envs.metrics(1)["rgs"] == 1 and envs.objects(0) == []


@pytest.mark.parametrize("actions", ["viewpoint", "six", "panoramic", "map"])
def test_masks_say_which_actions_do_something(small: str, actions: str) -> None:
    envs = VlnVectorEnv(EnvConfig(small, actions=actions, max_steps=1000), 4,
                               autoreset_mode="Disabled")  # fmt: skip
    envs.reset(seed=3)
    rng = np.random.default_rng(1)
    stop = 5 if actions == "six" else 0
    forbidden = 0
    for _ in range(60):
        masks = envs.action_masks()
        assert masks.shape == (4, envs.single_action_space.n) and masks[:, stop].all()
        before = [envs.arrays[n].copy() for n in ("viewpoint", "heading", "elevation")]
        chosen = np.array([rng.choice(np.delete(np.arange(masks.shape[1]), stop)) for _ in range(4)])
        envs.step(chosen)
        after = [envs.arrays[n] for n in ("viewpoint", "heading", "elevation")]
        changed = np.any([b != a for b, a in zip(before, after)], axis=0)
        allowed = masks[np.arange(4), chosen]
        assert (changed == allowed).all()
        forbidden += int((~allowed).sum())
    assert forbidden > 5
    env = VlnEnv(EnvConfig(small, actions=actions))
    env.reset(seed=3)
    assert env.action_masks().dtype == np.bool_ and env.action_masks().ndim == 1


def test_the_checker_renders_without_pictures(small: str) -> None:
    """check_env() makes one for each render mode that there is."""
    env = gymnasium.make("enfilade/R2R-v0", config=EnvConfig(small))
    assert env.unwrapped.metadata["render_modes"] == ["ansi"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    with pytest.raises(enfilade.ArgumentError, match="no pictures"):
        VlnEnv(EnvConfig(small), render_mode="rgb_array")
    assert VlnVectorEnv(EnvConfig(small), 2).metadata["render_modes"] == ["ansi"]


def test_observations_may_be_without_text(small: str) -> None:
    env = gymnasium.make("enfilade/R2R-v0", config=EnvConfig(small, text=False))
    seen, _ = env.reset(seed=1)
    assert "instruction" not in seen and env.observation_space.contains(seen)
    assert "instruction" not in VlnVectorEnv(EnvConfig(small, text=False), 2).reset()[0]


def test_hidden_goals_are_walked_and_no_answer_is_right(made: Path, tmp_path: Path) -> None:
    for folder in ("connectivity", "reverie"):
        shutil.copytree(made / folder, tmp_path / folder)
    file = tmp_path / "reverie" / "REVERIE_val_unseen.json"
    records = json.loads(file.read_text())
    for record in records:
        del record["objId"]
        record["id"] = str(record["path_id"])
        record["path"] = record["path"][:1]
    file.with_name("REVERIE_test.json").write_text(json.dumps(records))
    with pytest.raises(enfilade.ArgumentError, match="hides its goals"):
        gymnasium.make("enfilade/REVERIE-v0", config=EnvConfig(tmp_path, "test"))
    env = gymnasium.make("enfilade/REVERIE-v0", config=EnvConfig(tmp_path, "test", reward="none"))
    env.reset(seed=1)
    env.unwrapped.answer(7)
    _, _, stopped, _, info = env.step(0)
    assert stopped and info["answered"] is False and np.isnan(info["success"])
    with pytest.raises(enfilade.ArgumentError, match="element 0 is hidden"):
        env.unwrapped.metrics()


# --- configs from keywords, and names of earlier releases ------------------------------------------


def test_no_config_object_is_needed(small: str, monkeypatch: pytest.MonkeyPatch) -> None:
    env = gymnasium.make("enfilade/R2R-v0", data=small, split="val_unseen", max_steps=3)
    assert env.unwrapped.episodes.split == "val_unseen"
    same = VlnEnv(EnvConfig(small, "val_unseen", max_steps=3))
    assert equal(env.reset(seed=4), same.reset(seed=4))
    envs = gymnasium.make_vec("enfilade/R2R-v0", 2, data=small, actions="six", autoreset_mode="SameStep")
    assert envs.unwrapped.single_action_space.n == 6 and envs.unwrapped.episodes.split == "train"
    for one in (env.unwrapped, envs.unwrapped):
        again = pickle.loads(pickle.dumps(one))
        assert equal(again.reset(seed=4)[0], one.reset(seed=4)[0])
    shorter = VlnEnv(EnvConfig(small), max_steps=1)  # both: the keywords count
    shorter.reset(seed=1)
    assert shorter.step(1)[3] and same.episodes.task == "r2r"
    with pytest.raises(TypeError, match="flavour"):
        VlnEnv(data=small, flavour="mint")
    with pytest.raises(enfilade.ArgumentError, match="ContinuousEnvConfig"):
        VlnEnv(EnvConfig(small), task="r2r-ce")
    monkeypatch.setenv("ENFILADE_DATA", small)
    assert len(gymnasium.make("enfilade/R2R-v0").unwrapped.episodes) > 0
    monkeypatch.delenv("ENFILADE_DATA")
    with pytest.raises(enfilade.FileError, match="ENFILADE_DATA"):
        gymnasium.make("enfilade/R2R-v0")


def test_old_ids_warn_and_work(made: Path) -> None:
    for old, new in (("RoomToRoom-v0", "enfilade/R2R-v0"), ("enfilade/R2RBack-v0", "enfilade/R2R-Back-v0")):
        config = EnvConfig(made, "val_unseen", task=enfilade.gym.ENV_TASKS[new])
        with pytest.warns(DeprecationWarning, match=f"write {new}") as seen:
            env = gymnasium.make(old, config=config)
        assert seen[0].filename == __file__
        assert equal(env.reset(seed=1), gymnasium.make(new, config=config).reset(seed=1))
        with pytest.warns(DeprecationWarning, match=f"write {new}"):
            envs = gymnasium.make_vec(old, 2, config=config)
        assert isinstance(envs.unwrapped, VlnVectorEnv)
        with pytest.warns(DeprecationWarning, match=old):
            again = pickle.loads(pickle.dumps(env.unwrapped))
        assert equal(again.reset(seed=1), env.reset(seed=1))


def test_old_classes_warn() -> None:
    for old, new in (("RoomToRoomEnv", VlnEnv), ("ContinuousRoomToRoomVectorEnv", VlnVectorEnv)):
        with pytest.warns(DeprecationWarning, match=f"write enfilade.gym.{new.__name__}"):
            assert getattr(enfilade.gym, old) is new
    with pytest.warns(DeprecationWarning, match="write enfilade.gym.ENV_TASKS"):
        assert len(enfilade.gym.CONTINUOUS_ENV_TASKS) == 2
    with pytest.raises(AttributeError, match="RoomEnv"):
        enfilade.gym.RoomEnv  # noqa: B018


def test_old_words_of_layers_are_the_callers(homes: str) -> None:
    size = {"width": 32, "height": 24}
    with pytest.warns(DeprecationWarning, match="write 'semantic'") as seen:
        config = EnvConfig(homes, observe=("rgb", "class"), **size)
    assert seen[0].filename == __file__
    old, new = VlnEnv(config), VlnEnv(EnvConfig(homes, observe=("rgb", "semantic"), **size))
    before, now = old.reset(seed=2)[0], new.reset(seed=2)[0]
    assert old.observation_space.contains(before) and "semantic" not in before
    assert (before["class"] == now["semantic"]).all() and now["semantic"].any()


def test_one_image_of_any_layer(homes: str) -> None:
    d = enfilade.Dataset(homes)
    episode = d.episodes("val_unseen")[0]
    where = (episode.scan, episode.path[0], episode.heading)
    size = {"width": 32, "height": 24}
    drawn = d.renderer().render(
        [where[0]], [where[1]], where[2], layers=("depth", "semantic", "instance"), **size
    )
    assert set(drawn) == {"rgb", "depth", "semantic", "instance"}
    for layer in drawn:
        assert (d.render(*where, layer=layer, **size) == drawn[layer][0]).all()
    with pytest.raises(enfilade.ArgumentError, match="any of rgb, depth"):
        d.render(*where, layer="smell")
    with pytest.warns(DeprecationWarning, match="write 'instance'"):
        assert d.render(*where, layer="instances", **size).dtype == np.uint32
