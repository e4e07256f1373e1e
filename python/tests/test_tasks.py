"""Every benchmark from Python: episodes, goals, scores as functions, results in memory. Files that are
made here are SYNTHETIC; REVERIE's and fine-grained R2R's are the real ones, where they are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import enfilade
import pytest
from enfilade import goals
from made_tasks import SPLITS, results_of

np = pytest.importorskip("numpy")


def test_a_data_set_tells_its_benchmarks(made: Path) -> None:
    assert enfilade.Dataset(made).tasks == {task: [split] for task, split in SPLITS.items()}


def test_goals_and_details(made: Path) -> None:
    d = enfilade.Dataset(made)
    assert isinstance(d.episodes("val_unseen", task="r4r")[0].goal, goals.NearEnd)
    e = d.episodes("val_unseen", "r2r-back")[0]
    assert e.goal == goals.TurningPoint(e.path[2])
    e = d.episodes("val_unseen", task="rxr")[0]
    assert e.language == "hi-IN" and e.instruction_id == "0_100"
    assert e.words == (enfilade.TimedWord("Turn", 0.5, 0.75), enfilade.TimedWord("around", None, None))
    e = d.episodes("val_unseen", task="reverie")[0]
    assert isinstance(e.goal, goals.Object) and e.instruction_id == "0_7_0"
    assert e.goal.id == 7 and e.path[-1] in e.goal.seen_from
    (seen,) = d.objects(e.scan, e.path[-1])
    assert seen == enfilade.SeenObject(7, "plant#pot", (12, 13), ((1, 2, 3, 4), (5, 6, 7, 8)))
    assert d.objects(e.scan, e.path[0]) == []
    e = d.episodes("val_unseen", task="cvdn")[0]
    assert e.turns == (enfilade.Turn("navigator", "Left?", 0), enfilade.Turn("oracle", "Yes.", 0))
    assert e.goal == goals.Region((e.path[-1],), e.path, e.path) and "<TAR> plant" in e.text
    e = d.episodes("val_unseen_instrs", task="soon")[0]
    assert isinstance(e.goal, goals.Boxes) and e.goal.boxes[0].viewpoint == e.path[-1]
    assert e.goal.boxes[0].corners[2] == (2.0, -0.5) and e.fields["obj_name"] == "plant"
    with pytest.raises(enfilade.UnknownNameError, match="reverie"):
        d.episodes("val_unseen", task="alfred")


def test_look_up_by_instruction_id(made: Path) -> None:
    episodes = enfilade.Episodes(made, "val_unseen", task="r4r")
    assert episodes["1_1"] == episodes[3] and episodes.place("1_1") == 3
    assert "1_1" in episodes and "1_9" not in episodes and episodes[0] in episodes
    with pytest.raises(enfilade.UnknownNameError, match="'9_9'"):
        episodes["9_9"]


@pytest.mark.parametrize("task", SPLITS)
def test_what_follows_the_path_is_right(made: Path, task: str) -> None:
    episodes = enfilade.Episodes(made, SPLITS[task], task=task)
    good = episodes.score(results_of(episodes))
    bad = episodes.score(results_of(episodes, right=False))
    names = {"reverie": ("rgs", "rgspl"), "cvdn": ("dist_to_end_reduction",), "soon": ("det_sr",)}
    for name in names.get(task, ()):
        assert good.means[name][0] > bad.means[name][0]
    best = next(n for n in good.means if n in ("sr", "success", "success_rate"))
    assert good.means[best][0] > bad.means[best][0] >= 0
    assert good.task == task and good.scorer and len(good.episodes) == len(episodes)
    assert [row["instruction_id"] for row in good.about] == [e.instruction_id for e in episodes]


@pytest.mark.parametrize("task", SPLITS)
def test_functions_of_paths_give_what_a_file_gives(made: Path, tmp_path: Path, task: str) -> None:
    episodes = enfilade.Episodes(made, SPLITS[task], task=task)
    rows = results_of(episodes)
    file = tmp_path / "results.json"
    file.write_text(json.dumps(rows))
    answers = None
    if task in ("reverie", "r2r-back"):
        answers = [row["pred_objid" if task == "reverie" else "midstop"] for row in rows]
    if task == "soon":
        points = [row["trajectory"] for row in rows]
        answers = [(p["obj_heading"][0], p["obj_elevation"][0]) for p in points]
    for scorer in enfilade.scorers(task):
        assert scorer.task == task and scorer.source
        scored = episodes.score(file, scorer=scorer.name, bootstrap_samples=0)
        columns = episodes.score_paths(
            [e.path for e in episodes], answers=answers, scorer=scorer.name
        )
        assert tuple(columns) == scorer.metrics and set(scored.means) == set(scorer.means)
        for name, values in columns.items():
            listed = [scored.episodes[e.instruction_id][name] for e in episodes]
            assert np.array_equal(values, listed, equal_nan=True), (scorer.name, name)


def test_arrays_of_indices(made: Path) -> None:
    episodes = enfilade.Episodes(made, "val_unseen", task="r4r")
    graph = episodes.graphs[episodes[0].scan]
    most = max(len(e.path) for e in episodes)
    rows = np.full((len(episodes), most), -1)
    for row, e in zip(rows, episodes):
        row[: len(e.path)] = [graph.index(v) for v in e.path]
    by_index = enfilade.score_paths(episodes.graphs, graph.scan, rows, rows, task="r4r")
    by_name = episodes.score_paths([e.path for e in episodes])
    assert all(np.array_equal(by_index[n], by_name[n], equal_nan=True) for n in by_name)
    ours = enfilade.metrics(episodes.graphs, graph.scan, rows[0], rows[0])
    assert ours["success"] == 1


def test_what_does_not_fit_is_refused(made: Path) -> None:
    episodes = enfilade.Episodes(made, "val_unseen", task="r4r")
    e = episodes[0]
    ask: Any = enfilade.score_paths
    with pytest.raises(enfilade.ArgumentError, match="references: 2 for 1"):
        ask(episodes.graphs, e.scan, [e.path], [e.path, e.path], task="r4r")
    with pytest.raises(enfilade.ArgumentError, match="element 0"):
        ask(episodes.graphs, e.scan, [e.path], [e.path], task="reverie")
    with pytest.raises(enfilade.UnknownNameError, match="duet"):
        ask(episodes.graphs, e.scan, [e.path], [e.path], task="r4r", scorer="mine")
    with pytest.raises(enfilade.UnknownNameError, match="enfilade.metrics"):
        ask(episodes.graphs, e.scan, [e.path], [e.path], task="r2r", scorer="enfilade")
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        ask(episodes.graphs, e.scan, [["nowhere"]], [e.path], task="r4r")
    with pytest.raises(enfilade.ArgumentError, match="0 to"):
        ask(episodes.graphs, e.scan, [[10**6]], [e.path], task="r4r")
    with pytest.raises(TypeError, match="enfilade.goals"):
        ask(episodes.graphs, e.scan, [e.path], [e.path], task="r4r", goals=[3])
    with pytest.raises(enfilade.ArgumentError, match="has its own"):
        episodes.score(results_of(episodes), success_distance=1.0)
    with pytest.raises(enfilade.UnknownNameError, match="for R4R; there are hamt, duet"):
        episodes.score(results_of(episodes), scorer="enfilade")


def test_a_part_is_scored_on_purpose(made: Path) -> None:
    episodes = enfilade.Episodes(made, "val_unseen")
    rows = results_of(episodes)
    with pytest.raises(enfilade.InvalidInput, match="no entry for"):
        episodes.score(rows[:2])
    some = episodes.score(rows[:2], part=True)
    assert list(some.episodes) == ["0_0", "0_1"] and some.means["success"][0] == 1
    with pytest.raises(enfilade.InvalidInput, match="missing-instr-id"):
        episodes.score([], part=True)
    with pytest.raises(enfilade.InvalidInput, match="unknown-instr-id"):
        episodes.score([{**rows[0], "instr_id": "99_0"}], part=True)


def test_fourth_instructions_are_scored_where_they_are_episodes(made: Path) -> None:
    every = enfilade.Episodes(made, "val_unseen", all_instructions=True)
    assert "0_3" in every
    score = every.score(results_of(every))
    assert not score.warnings and len(score.episodes) == len(every) == 12
    usual = enfilade.Episodes(made, "val_unseen")
    assert "0_3" not in usual
    assert len(usual.score(results_of(every)).warnings) == 3


def test_results_may_hold_arrays(made: Path) -> None:
    episodes = enfilade.Episodes(made, "val_unseen", task="reverie")
    rows = results_of(episodes)
    for row in rows:
        row["pred_objid"] = np.int64(row["pred_objid"])
        row["trajectory"] = np.array([[v[0]] for v in row["trajectory"]])
    assert episodes.score(iter(rows)).means["rgs"][0] == 1
    with pytest.raises(TypeError, match="cannot be part"):
        episodes.score([{"instr_id": object()}])


def test_a_table_of_scores(made: Path) -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    episodes = enfilade.Episodes(made, "val_unseen", task="rxr")
    table = episodes.score(results_of(episodes)).to_pandas()
    assert isinstance(table, pandas.DataFrame) and list(table.index) == ["0_100", "1_101", "2_102"]
    assert set(table["language"]) == {"hi-IN"}
    assert table.groupby("language")["nDTW"].mean().iloc[0] == pytest.approx(1)


def test_reverie_as_it_is_published(data: Path) -> None:
    d = enfilade.Dataset(data)
    if "reverie" not in d.tasks:
        pytest.skip("the data have no REVERIE")
    episodes = d.episodes("val_unseen", task="reverie")
    assert len(episodes) in (3521, 3433)  # version 1, version 2
    assert all(isinstance(e.goal, goals.Object) for e in episodes)
    seen = [len(e.goal.seen_from) for e in episodes if isinstance(e.goal, goals.Object)]
    assert 1.5 < sum(seen) / len(seen) < 2.5
    assert sum(len(e.path) for e in episodes) > len(episodes)


def test_fine_grained_as_it_is_published(data: Path) -> None:
    file = data / "fgr2r" / "FGR2R_val_seen.json"
    if not file.exists():
        pytest.skip("the data have no fine-grained R2R")
    every = enfilade.Episodes(data, "val_seen", file=file, all_instructions=True)
    assert len(every) == 1021 and "757_3" in every
    e = every[0]
    assert e.parts and e.parts[0].places is not None
    ids = [{"instr_id": e.instruction_id, "trajectory": list(e.path)} for e in every]
    score = every.score(ids)
    assert not score.warnings and "757_3" in score.episodes
    assert score.means["success"][0] == 1
