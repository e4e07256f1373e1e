"""enfilade.arena(): a function walks episodes. Homes are SYNTHETIC."""

import json
import subprocess

import enfilade
import pytest


def first(step):
    """The rule `first` of `enfilade ask --stand-in`: the first place, and never a stop."""
    place = step.observation["places"][0]["name"]
    return {"name": "go_to", "arguments": {"place": place}}


def walk_all(walk, act):
    for step in walk:
        step.act(act(step))
    return walk


def test_a_function_walks(small):
    walk = enfilade.arena("r2r/val_unseen", data=small, subset=3)
    texts = []
    for step in walk:
        texts.append((step.first, step.episode, step.prompt))
        assert step.images == []
        assert {tool["name"] for tool in step.functions} >= {"go_to", "look", "stop"}
        assert step.act(first(step) if step.first else {"name": "stop"})
    assert len(walk) == walk.done == 3
    assert [begin for begin, _, _ in texts] == [True, False] * 3
    assert all("Instruction: " in text for begin, _, text in texts if begin)
    results = walk.results()
    assert [entry["instr_id"] for entry in results] == [e for begin, e, _ in texts if begin]
    assert all(len(entry["trajectory"]) == 2 for entry in results)
    assert set(walk.score().episodes) == {entry["instr_id"] for entry in results}


def test_what_is_impossible_is_told(small):
    walk = enfilade.arena("r2r/val_unseen", data=small, subset=1, mistakes=2)
    step = next(walk)
    assert not step.act({"name": "go_to", "arguments": {"place": "QQ"}})
    assert "is not one of" in step.told and step.ending is None
    step = next(walk)
    assert "is not one of" in step.prompt
    assert not step.act("I am lost.")
    assert step.ending == "mistakes"
    with pytest.raises(StopIteration):
        next(walk)
    assert len(walk.results()[0]["trajectory"]) == 1


def test_answers_are_read_as_the_prompt_says(small):
    step = next(enfilade.arena("r2r/val_unseen", data=small, subset=1, prompt="navgpt"))
    assert step.act("I turn.\nAction: look left")
    walk = enfilade.arena("r2r/val_unseen", data=small, subset=1, answers="json")
    step = next(walk)
    assert step.schema["type"] == "object"
    assert step.act('{"thought": "here", "tool": "stop", "argument": null}')
    assert step.ending == "stopped"


def test_steps_are_taken_one_by_one(small):
    walk = enfilade.arena("r2r/val_unseen", data=small, subset=1)
    step = next(walk)
    with pytest.raises(RuntimeError, match="act\\(\\) was not called"):
        next(walk)
    step.act({"name": "stop"})
    for again in (lambda: step.act({"name": "stop"}), lambda: step.images, lambda: step.schema):
        with pytest.raises(RuntimeError, match="this step is over"):
            again()


def test_a_folder_goes_on(small, tmp_path):
    walk = enfilade.arena("r2r/val_unseen", data=small, subset=2, output=tmp_path)
    next(walk).act({"name": "stop"})
    with pytest.raises(enfilade.FileError):  # one at a time in a folder
        enfilade.arena("r2r/val_unseen", data=small, subset=2, output=tmp_path)
    del walk
    again = enfilade.arena("r2r/val_unseen", data=small, subset=2, output=tmp_path)
    assert again.done == 1
    walk_all(again, lambda step: {"name": "stop"})
    assert again.results() == json.loads((tmp_path / "results.json").read_text())
    assert len(list((tmp_path / "transcripts").iterdir())) == 2


def test_bad_values_are_named(small):
    for name in ("r2r", "/val_unseen", "r2r/"):
        with pytest.raises(enfilade.ArgumentError, match="task/split is expected"):
            enfilade.arena(name, data=small)
    for settings, wanted in (
        ({"subset": 10**6}, "split val_unseen has"),
        ({"steps": 0}, "steps"),
        ({"picture_size": 4096}, "picture_size"),
        ({"answers": "poem"}, "one of tools, json, text"),
    ):
        with pytest.raises(enfilade.ArgumentError, match=wanted):
            enfilade.arena("r2r/val_unseen", data=small, **settings)
    with pytest.raises(enfilade.UnknownNameError):
        enfilade.arena("r2r/val_unseen", data=small, prompt="shout")
    with pytest.raises(enfilade.FileError):
        enfilade.arena("r2r/val_unseen", data=small, subset="nowhere.txt")


def test_what_no_tool_can_answer_is_refused(made):
    with pytest.raises(enfilade.ArgumentError, match="no tool|answer"):
        next(enfilade.arena("soon/val_unseen_instrs", data=made, subset="all"))


def test_pictures_are_jpegs(homes):
    step = next(enfilade.arena("r2r/val_unseen", data=homes, subset=1, prompt="marks", picture_size=64))
    (strip,) = step.images
    assert strip[:2] == b"\xff\xd8"
    assert step.images[0] is strip


def test_trajectories_are_those_of_ask(small, web_program, tmp_path):
    asked = subprocess.run(
        [web_program, "ask", "--data", small, "--stand-in", "first", "--subset", "5", "-o", str(tmp_path)],
        capture_output=True,
        text=True,
    )
    assert asked.returncode == 0, asked.stderr
    walk = walk_all(enfilade.arena("r2r/val_unseen", data=small, subset=5), first)
    assert walk.results() == json.loads((tmp_path / "results.json").read_text())
