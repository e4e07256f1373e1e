"""Iterates a data set by `lerobot` itself, in the Python of its own environment (test_export_readers.py).

lerobot_reader.py FOLDER OUT.npz    # values of all frames, some pictures, statistics
"""

from __future__ import annotations

import importlib.metadata
import json
import sys

import numpy as np
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

KEY = "observation.images.rgb"


def decoder() -> str:
    """torchcodec finds no FFmpeg on some machines; PyAV brings its own."""
    try:
        import torchcodec.decoders  # noqa: F401
    except (ImportError, RuntimeError, OSError):
        return "pyav"
    return "torchcodec"


def main(folder: str, out: str) -> None:
    backend = decoder()
    data = LeRobotDataset("enfilade/export", root=folder, video_backend=backend)
    found: dict[str, list] = {}
    tasks = []
    means = []
    for item in data:
        for name in (
            "action",
            "observation.state",
            "timestamp",
            "frame_index",
            "episode_index",
            "index",
        ):
            found.setdefault(name, []).append(np.asarray(item[name]))
        tasks.append(item["task"])
        picture = item[KEY]
        assert picture.dtype == torch.float32 and picture.min() >= 0 and picture.max() <= 1
        means.append(picture.mean(dim=(1, 2)).numpy())
    # As training asks: some actions ahead, in batches that are shuffled.
    ahead = LeRobotDataset(
        "enfilade/export",
        root=folder,
        delta_timestamps={"action": [0, 1 / data.fps]},
        video_backend=backend,
    )
    pairs = []
    for batch in torch.utils.data.DataLoader(ahead, batch_size=8, shuffle=True):
        padded = batch["action_is_pad"][:, 1]
        pairs += [
            [int(row), *map(int, two), int(pad)]
            for row, two, pad in zip(batch["index"], batch["action"], padded)
        ]
    some = [0, len(data) // 2, len(data) - 1]
    names = data.meta.stats
    stats = {f"{key}/{name}": np.asarray(names[key][name]) for key in names for name in names[key]}
    about = {
        "lerobot": importlib.metadata.version("lerobot"),
        "version": str(data.meta._version),
        "tasks": tasks,
        "frames": len(data),
        "episodes": data.num_episodes,
        "fps": data.fps,
    }
    np.savez(
        out,
        about=json.dumps(about),
        some=some,
        pictures=np.stack([(data[k][KEY] * 255).round().byte().permute(1, 2, 0).numpy() for k in some]),
        means=np.stack(means),
        pairs=np.array(sorted(pairs)),
        **{name: np.stack(values) for name, values in found.items()},
        **{"stats/" + name: value for name, value in stats.items()},
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
