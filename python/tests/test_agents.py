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


def test_a_split_is_walked_and_scored(small: str, model: Path, tmp_path: Path) -> None:
    agents = learn_module()
    agent = agents.load(model, threads=1)
    assert (agent.kind, agent.iteration, agent.sees) == ("seq2seq", 2, False)
    assert "seq2seq" in repr(agent)
    episodes = enfilade.Dataset(small).episodes("val_unseen")
    with pytest.raises(RuntimeError, match="enter"):
        agent.walk()
    agent.enter(episodes)
    results, attention = tmp_path / "r.json", tmp_path / "a.json"
    walked = agent.walk(7, results=results, attention=attention)
    assert len(walked) == len(episodes)
    assert [entry["instr_id"] for entry in walked] == [e.instruction_id for e in episodes]
    assert json.loads(results.read_text()) == walked
    assert attention.is_file()
    assert 0 <= episodes.score(walked).means["success"][0] <= 1
    assert agent.walk(100) == walked, "the batch size changes nothing"


@pytest.mark.parametrize("actions", ["six", "viewpoint", "panoramic"])
def test_an_environment_goes_where_the_agent_goes(small: str, model: Path, actions: str) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    config = gym.EnvConfig(small, "val_unseen", actions=actions, reward="none", max_steps=50)
    envs = gym.RoomToRoomVectorEnv(config, 3, autoreset_mode="NextStep")
    agent = agents.load(model, threads=1)
    agent.enter(envs)
    walked = agent.walk()
    envs.reset(options={"episode": np.arange(3)})
    ends: dict[int, str] = {}
    for _ in range(60):
        _, _, stopped, cut, _ = envs.step(agent.act(envs))
        for slot in np.flatnonzero(stopped | cut):
            scan = envs.episodes[int(slot)].scan
            ids = envs.episodes.graphs[scan].viewpoints
            ends.setdefault(int(slot), ids[envs.arrays["viewpoint"][slot]])
        if len(ends) == 3:
            break
    assert [ends[slot] for slot in range(3)] == [points(walked[slot])[-1] for slot in range(3)]


def test_actions_that_were_not_taken_are_noticed(small: str, model: Path) -> None:
    gym = pytest.importorskip("enfilade.gym")
    agents = learn_module()
    env = gym.RoomToRoomEnv(gym.EnvConfig(small, "val_unseen", max_steps=50))
    agent = agents.load(model, threads=1)
    env.reset(options={"episode": 0})
    with pytest.raises(enfilade.ArgumentError, match="enter"):
        agent.act(env)
    agent.enter(env)
    others: list[int] = []
    for episode in range(len(env.episodes)):  # one in which it moves, where there are two ways
        env.reset(options={"episode": episode})
        first = agent.act(env)
        assert first.shape == (1,) and first.dtype == np.int64
        others = [k for k in range(1, 16) if k != first[0] and env.action_masks()[k]]
        if first[0] != 0 and others:
            break
    env.step(others[0])
    with pytest.raises(enfilade.ArgumentError, match="take its actions"):
        agent.act(env)
    with pytest.raises(TypeError, match="enfilade.gym"):
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
