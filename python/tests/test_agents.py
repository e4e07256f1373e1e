"""Trained agents in Python. They are trained here for a moment, on SYNTHETIC homes."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import enfilade
import numpy as np
import pytest

PROGRAM = os.environ.get("ENFILADE_PROGRAM")


def learn_module() -> Any:
    try:
        return importlib.import_module("enfilade.agents")
    except ImportError:
        pytest.skip("enfilade._learn is not built: no libtorch")


@pytest.fixture(scope="module")
def model(small: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sequence-to-sequence agent that sees no pictures, after two updates."""
    if not PROGRAM:
        pytest.skip("ENFILADE_PROGRAM is not set: no `enfilade train`")
    folder = tmp_path_factory.mktemp("models") / "student"
    command = [PROGRAM, "train", "-o", str(folder), "--data", small, "--inputs", "language"]
    sizes = ["--hidden", "16", "--iterations", "2", "--batch", "8", "--least-count", "1"]
    subprocess.run([*command, *sizes, "--threads", "1"], check=True, capture_output=True)
    return folder


def output_of(code: str) -> str:
    command = [sys.executable, "-c", code]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def points(entry: dict[str, Any]) -> list[str]:
    return [point[0] for point in entry["trajectory"]]


def test_a_split_is_run_and_scored(small: str, model: Path, tmp_path: Path) -> None:
    agents = learn_module()
    agent = agents.load(model, threads=1)
    assert (agent.kind, agent.iteration, agent.sees) == ("seq2seq", 2, False)
    assert "seq2seq" in repr(agent)
    episodes = enfilade.Dataset(small).episodes("val_unseen")
    results, attention = tmp_path / "r.json", tmp_path / "a.json"
    entries = agent.run(episodes, batch_size=7, results=results, attention=attention)
    assert len(entries) == len(episodes)
    assert [entry["instr_id"] for entry in entries] == [e.instruction_id for e in episodes]
    assert json.loads(results.read_text()) == entries
    assert attention.is_file()
    assert agent.run(episodes) == entries, "the batch size changes nothing"
    assert agent.evaluate(episodes, batch_size=9) == episodes.score(entries)
    other = enfilade.Dataset(small).episodes("val_seen")  # in any order, without a call in between
    assert len(agent.evaluate(other).episodes) == len(other)
    assert agent.run(episodes) == entries


@pytest.mark.parametrize("actions", ["six", "viewpoint", "panoramic"])
def test_an_environment_goes_where_the_agent_goes(small: str, model: Path, actions: str) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    config = gym.EnvConfig(small, "val_unseen", actions=actions, reward="none", max_steps=50)
    envs = gym.VlnVectorEnv(config, 3, autoreset_mode="NextStep")
    agent = agents.load(model, threads=1)
    policy = agent.policy(envs)
    entries = agent.run(envs.episodes)
    seen, _ = envs.reset(options={"episode": np.arange(3)})
    ends: dict[int, str] = {}
    for _ in range(60):
        seen, _, stopped, cut, _ = envs.step(policy(seen))
        for slot in np.flatnonzero(stopped | cut):
            scan = envs.episodes[int(slot)].scan
            ids = envs.episodes.graphs[scan].viewpoints
            ends.setdefault(int(slot), ids[envs.arrays["viewpoint"][slot]])
        if len(ends) == 3:
            break
    assert [ends[slot] for slot in range(3)] == [points(entries[slot])[-1] for slot in range(3)]


def moving(env: Any, act: Any) -> tuple[int, int]:
    """The episode and its first action, of one in which the agent moves, where there are two ways."""
    for episode in range(len(env.episodes)):
        env.reset(options={"episode": episode})
        first = int(act())
        others = [k for k in range(1, 16) if k != first and env.action_masks()[k]]
        if first != 0 and others:
            return episode, others[0]
    raise AssertionError("the agent stops everywhere")


def test_actions_that_were_not_taken_are_noticed(small: str, model: Path) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    env = gym.VlnEnv(gym.EnvConfig(small, "val_unseen", max_steps=50))
    agent = agents.load(model, threads=1)
    policy = agent.policy(env)
    with pytest.raises(enfilade.ArgumentError, match="reset"):
        policy()
    _, other = moving(env, policy)
    env.step(other)
    with pytest.raises(enfilade.ArgumentError, match="take its actions"):
        policy()
    for wrong in (3, enfilade):
        with pytest.raises(TypeError, match="enfilade.gym"):
            agent.policy(wrong)


def test_policies_of_one_agent_say_when_they_have_to_begin_again(small: str, model: Path) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    agent = agents.load(model, threads=1)
    one, two = (gym.VlnEnv(gym.EnvConfig(small, split, max_steps=50)) for split in ("val_unseen", "val_seen"))
    first, second = agent.policy(one), agent.policy(two)
    episode, _ = moving(one, first)  # though the second was made later
    before = int(first())
    one.step(before)
    two.reset(seed=1)
    second()
    with pytest.raises(enfilade.ArgumentError, match="begin together: reset"):
        first()
    one.reset(options={"episode": episode})
    assert first() == before
    one.step(before)
    agent.run(one.episodes)
    with pytest.raises(enfilade.ArgumentError, match="begin together: reset"):
        first()


def test_the_old_order_of_calls_warns_and_works(small: str, model: Path) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    agent = agents.load(model, threads=1)
    envs = gym.VlnVectorEnv(gym.EnvConfig(small, "val_unseen", max_steps=50), 3)
    envs.reset(options={"episode": np.arange(3)})
    with pytest.warns(DeprecationWarning), pytest.raises(RuntimeError, match="enter"):
        agent.walk()
    with pytest.warns(DeprecationWarning), pytest.raises(enfilade.ArgumentError, match="enter"):
        agent.act(envs)
    with pytest.warns(DeprecationWarning, match=r"write run\(\), evaluate\(\) or policy\(\)") as seen:
        agent.enter(envs)
    assert seen[0].filename == __file__
    with pytest.warns(DeprecationWarning, match=r"write run\(episodes, features\)"):
        assert agent.walk(7) == agent.run(envs.episodes)
    policy = agent.policy(envs)
    wanted = []
    for _ in range(4):
        wanted.append(policy().tolist())
        envs.step(wanted[-1])
    envs.reset(options={"episode": np.arange(3)})
    for actions in wanted:
        with pytest.warns(DeprecationWarning, match=r"write policy\(env\)\(\)"):
            old = agent.act(envs)
        assert old.dtype == np.int64 and old.tolist() == actions
        envs.step(old)
    with pytest.warns(DeprecationWarning), pytest.raises(TypeError, match="enfilade.gym"):
        agent.act(3)


def test_what_is_wrong_with_a_model_is_said(small: str, model: Path, tmp_path: Path) -> None:
    agents = learn_module()
    with pytest.raises(enfilade.FileError):
        agents.load(tmp_path / "none")
    with pytest.raises(enfilade.Error):
        agents.load(model, device="no such device")
    (tmp_path / "config.json").write_text("{")
    with pytest.raises(enfilade.Error, match="no weights.safetensors in it"):
        agents.load(tmp_path)
    (tmp_path / "weights.safetensors").write_bytes(b"")
    with pytest.raises(enfilade.Error, match="config.json"):
        agents.load(tmp_path)


def test_without_libtorch_it_says_how_to_get_it() -> None:
    code = (
        "import sys; sys.modules['enfilade._learn'] = None\n"
        "import enfilade\n"
        "try:\n    enfilade.agents\nexcept ImportError as e:\n    print(e)"
    )
    said = output_of(code)
    assert "libtorch" in said and "EN_WITH_TORCH=ON" in said


def test_pytorch_is_not_imported(model: Path) -> None:
    learn_module()
    load = f"enfilade.agents.load({str(model)!r})"
    code = f"import sys, enfilade; {load}; print('torch' in sys.modules)"
    said = output_of(code)
    assert said.strip() == "False"
