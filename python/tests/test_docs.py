"""The documentation's Python runs, and its tables name every call."""

from __future__ import annotations

import inspect
import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any

import enfilade
import MatterSim
import pytest
from made_tasks import results_of, write_reverie

np = pytest.importorskip("numpy")

DOCS = Path(__file__).parents[2] / "docs"


def blocks_of(page: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", (DOCS / page).read_text(), re.M | re.S)


@pytest.fixture(scope="module")
def desk(homes: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a reader of the pages has in the working directory: data (here synthetic homes), a
    vocabulary, results, features."""
    from enfilade import features

    folder = tmp_path_factory.mktemp("desk")
    (folder / "data").mkdir()
    for part in Path(homes).iterdir():
        (folder / "data" / part.name).symlink_to(part)
    episodes = enfilade.Episodes(folder / "data", "val_unseen")
    if not (folder / "data" / "reverie").exists():
        for split in ("train", "val_unseen"):
            paths = {e.path_id: (e.scan, e.path) for e in enfilade.Episodes(homes, split)}
            write_reverie(folder / "data", split, list(paths.values()))
    objects = enfilade.Episodes(folder / "data", "val_unseen", task="reverie")
    for name, some_episodes in (("results.json", episodes), ("reverie.json", objects)):
        (folder / name).write_text(json.dumps(results_of(some_episodes)))
    texts = [e.text for e in episodes]
    enfilade.Vocabulary.build(texts, least_count=1).save(folder / "train_vocab.txt")
    key = (episodes[0].scan, episodes[0].path[0])
    some = {key: np.ones((36, 4), np.float32)}
    features.write_safetensors(folder / "resnet152.safetensors", some)
    return folder


def test_the_pages_python_runs(
    desk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each page from top to bottom, in one namespace a page."""
    monkeypatch.chdir(desk)
    graphs = enfilade.Graphs("data/connectivity")
    scan = graphs.scans[0]
    place = {"scan": scan, "viewpoint": next(filter(graphs[scan].included, graphs[scan].viewpoints))}
    pages = {"python.md": {}, "python_gym.md": {}, "python_mattersim.md": place, "mattersim.md": place}
    free = {"python_continuous.md": {}}  # whose navigation meshes the program makes
    if os.environ.get("ENFILADE_COMMAND"):
        subprocess.run([os.environ["ENFILADE_COMMAND"], "continuous", "data"], check=True)
        pages.update(free)
    for page, known in pages.items():
        blocks = blocks_of(page)
        names: dict[str, Any] = dict(known)
        for number, block in enumerate(blocks):
            # What a page reads has the names of its own; everything else is in the block or before.
            if "read[scan, viewpoint]" in block:
                names["scan"], names["viewpoint"] = next(iter(enfilade.features.open_features(
                    "resnet152.safetensors")))  # fmt: skip
            exec(compile(block, f"{page}, block {number}", "exec"), names)
        assert blocks
        if page == "python_mattersim.md":
            old = [sim.getState()[0] for sim in names["sims"]]
            state = names["agents"].state
            assert [s.location.viewpointId for s in old] == names["agents"].viewpoint_ids()
            assert [s.heading for s in old] == state.heading.tolist()
    free["python_habitat_sim.md"] = {}  # test_habitat_sim_docs.py runs it
    for page in [*DOCS.glob("*.md"), *DOCS.glob("design/*.md")]:  # tutorials have a runner of their own
        assert page.name in {**pages, **free} or "```python" not in page.read_text(), f"{page}: add it here"


def test_everything_public_says_what_it_is() -> None:
    gym = pytest.importorskip("enfilade.gym", reason="Gymnasium is not installed")
    from enfilade import camera, eyes, features, goals, synth

    silent = []
    for module in (enfilade, MatterSim, gym, camera, eyes, features, goals, synth):
        own = [name for name, it in vars(module).items()
               if getattr(it, "__module__", "") == module.__name__]  # fmt: skip
        for name in getattr(module, "__all__", own):
            thing = getattr(module, name)
            members = vars(thing).items() if inspect.isclass(thing) else ()
            methods = [(f"{name}.{m}", v) for m, v in members if callable(v) or hasattr(v, "__get__")]
            for full, it in [(name, thing), *methods]:
                if "_" not in (full[0], full.split(".")[-1][0]) and not inspect.getdoc(it):
                    silent.append(f"{module.__name__}.{full}")
    assert silent == []


def test_the_table_names_every_call_of_the_old_simulator() -> None:
    text = (DOCS / "python_mattersim.md").read_text()
    for thing in (MatterSim, MatterSim.Simulator, MatterSim.SimState, MatterSim.ViewPoint):
        for name in dir(thing):
            assert name.startswith("_") or re.search(rf"\b{name}\b", text), name


def test_the_table_names_every_option(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (DOCS / "python_mattersim.md").read_text()
    monkeypatch.setenv("ENFILADE_MATTERSIM", "?")
    with pytest.raises(ValueError) as error:
        MatterSim.Simulator()
    words = re.findall(r"[\w-]+", str(error.value).split("'?': ")[1].split(" are allowed")[0])
    words.remove("and")
    assert len(words) == 6 and all(f"| `{word}` |" in text for word in words)
