"""Episodes with features for PyTorch: a map-style dataset for torch.utils.data.DataLoader.

>>> from enfilade.torch_data import EpisodeDataset
>>> data = EpisodeDataset(d.episodes("train"), "resnet152.safetensors", vocabulary="train_vocab.txt")
>>> batches = torch.utils.data.DataLoader(data, 32, shuffle=True, num_workers=4, collate_fn=data.collate)

Importing this imports PyTorch.
"""

from __future__ import annotations

import os
from typing import Any, Dict, Mapping, Optional, Sequence, Union

import numpy as np
import torch  # type: ignore[import-not-found, unused-ignore]

from enfilade import Vocabulary
from enfilade._episodes import Episodes
from enfilade.features import Array, Features, Key, open_features

__all__ = ["EpisodeDataset"]

Item = Dict[str, Any]


class EpisodeDataset(torch.utils.data.Dataset):  # type: ignore[misc, type-arg, unused-ignore]
    """Episodes of a split, each with the features of its path. Any worker process may have a copy.

    Args:
        episodes: Dataset.episodes(), of any benchmark on graphs.
        features: a file of features, Features, or any mapping of (scan, viewpoint) to (views, D); None:
            no features.
        vocabulary: file of words, for token ids; None: no tokens.
        tokens: length of the row of ids.

    Item:
        - instruction_id, scan, text.
        - path: k viewpoint ids; only the start if the goal is hidden.
        - heading: at the start, radians.
        - features: (k, views, D) float32.
        - tokens: (tokens,) int64.

    Reading an item raises KeyError for a viewpoint without features.
    """

    def __init__(
        self,
        episodes: Episodes,
        features: Union[None, str, os.PathLike[str], Mapping[Key, Array]] = None,
        *,
        vocabulary: Union[None, str, os.PathLike[str]] = None,
        tokens: int = 80,
    ) -> None:
        self.episodes, self.tokens = episodes, tokens
        self._words = None if vocabulary is None else os.fspath(vocabulary)
        self._file = features.file if isinstance(features, Features) else features
        self._open()

    def _open(self) -> None:
        named = isinstance(self._file, (str, os.PathLike))
        self._features: Any = open_features(os.fspath(self._file)) if named else self._file  # type: ignore[arg-type]
        self._vocabulary: Optional[Vocabulary] = Vocabulary.load(self._words) if self._words else None
        self._process = os.getpid()

    def __len__(self) -> int:
        return len(self.episodes)

    def __getitem__(self, index: int) -> Item:
        if self._process != os.getpid():  # after a fork, HDF5 has to be opened again
            self._open()
        episode = self.episodes[index]
        item: Item = {name: getattr(episode, name) for name in ("instruction_id", "scan", "text", "path")}
        item["heading"] = torch.tensor(episode.heading, dtype=torch.float32)
        if self._features is not None:
            seen = [np.asarray(self._features[episode.scan, v], np.float32) for v in episode.path]
            item["features"] = torch.from_numpy(np.stack(seen))
        if self._vocabulary is not None:
            ids = self._vocabulary.encode(episode.text, self.tokens)
            item["tokens"] = torch.from_numpy(np.asarray(ids, np.int64))
        return item

    def __getstate__(self) -> dict[str, Any]:
        hidden = ("_vocabulary", "_features")
        return {name: value for name, value in vars(self).items() if name not in hidden}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._open()

    @staticmethod
    def collate(items: Sequence[Item]) -> Item:
        """A batch of items, for DataLoader's collate_fn: tensors stacked, the rest in lists. Paths are
        padded: features (n, k, views, D) with zeros, path_mask (n, k) bool, True for viewpoints."""
        batch: Item = {name: [item[name] for item in items] for name in items[0]}
        lengths = torch.tensor([len(path) for path in batch["path"]])
        batch["path_mask"] = torch.arange(int(lengths.max()))[None] < lengths[:, None]
        if "features" in batch:
            batch["features"] = torch.nn.utils.rnn.pad_sequence(batch["features"], batch_first=True)
        for name in {"heading", "tokens"} & batch.keys():
            batch[name] = torch.stack(batch[name])
        return batch
