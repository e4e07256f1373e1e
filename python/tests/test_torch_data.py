"""Episodes with features as a dataset of PyTorch."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import enfilade
import pytest

np = pytest.importorskip("numpy")
torch = pytest.importorskip("torch", reason="torch is not installed")

from enfilade.torch_data import EpisodeDataset  # noqa: E402
from torch.utils.data import DataLoader  # noqa: E402


@pytest.fixture(scope="module")
def files(small: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Features of every viewpoint, whose first number is the viewpoint's index; and a vocabulary."""
    folder = tmp_path_factory.mktemp("features")
    graphs = enfilade.Dataset(small).graphs
    known = {
        (scan, name): np.full((36, 4), ix, np.float32)
        for scan in graphs.scans
        for ix, name in enumerate(graphs[scan].viewpoints)
    }
    safetensors = folder / "all.safetensors"
    enfilade.features.write_safetensors(safetensors, known)
    texts = [episode.text for episode in enfilade.Episodes(small, "train")]
    words = folder / "vocabulary.txt"
    enfilade.Vocabulary.build(texts, least_count=1).save(words)
    return {"features": safetensors, "vocabulary": words}


def test_items_are_episodes_with_the_features_of_their_path(small: str, files: dict[str, Path]) -> None:
    episodes = enfilade.Episodes(small, "train")
    data = EpisodeDataset(episodes, files["features"], vocabulary=files["vocabulary"], tokens=20)
    assert isinstance(data, torch.utils.data.Dataset) and len(data) == len(episodes)
    item, episode = data[3], episodes[3]
    assert (item["instruction_id"], item["scan"], item["text"], item["path"]) == (
        episode.instruction_id, episode.scan, episode.text, episode.path)  # fmt: skip
    assert item["features"].shape == (len(episode.path), 36, 4) and item["tokens"].shape == (20,)
    graph = episodes.graphs[episode.scan]
    assert item["features"][:, 0, 0].tolist() == [graph.index(name) for name in episode.path]
    assert item["heading"].item() == pytest.approx(episode.heading)
    assert data[-1]["instruction_id"] == episodes[-1].instruction_id
    with pytest.raises(IndexError):
        data[len(data)]
    assert set(EpisodeDataset(episodes)[0]) == {"instruction_id", "scan", "text", "path", "heading"}
    with pytest.raises(KeyError):
        EpisodeDataset(episodes, {})[0]


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_workers_read_the_same(small: str, files: dict[str, Path], context: str) -> None:
    episodes = enfilade.Episodes(small, "train")
    data = EpisodeDataset(episodes, enfilade.features.open_features(files["features"]))
    here = [data.collate([data[k] for k in range(start, start + 4)]) for start in (0, 4)]
    some = torch.utils.data.Subset(data, range(8))
    loader = DataLoader(some, 4, num_workers=2, collate_fn=data.collate, multiprocessing_context=context)
    for got, wanted in zip(loader, here):
        lengths = [len(path) for path in wanted["path"]]
        assert got["features"].shape == (4, max(lengths), 36, 4)
        assert got["path_mask"].sum(1).tolist() == lengths
        assert torch.equal(got["features"], wanted["features"]) and got["text"] == wanted["text"]
        assert not got["features"][~got["path_mask"]].any()


def test_a_pickled_dataset_is_the_same(small: str, files: dict[str, Path]) -> None:
    data = EpisodeDataset(enfilade.Episodes(small, "train"), files["features"], vocabulary=files["vocabulary"])
    again = pickle.loads(pickle.dumps(data))
    assert len(again) == len(data)
    assert all(torch.equal(again[5][name], data[5][name]) for name in ("features", "tokens", "heading"))


def test_torch_is_imported_on_use_only() -> None:
    code = "import sys, enfilade; a = 'torch' in sys.modules; enfilade.torch_data; print(a, 'torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["False", "True"]
