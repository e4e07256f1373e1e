"""Data sets of LeRobot, of the parts that `enfilade export --as lerobot` renders.

`enfilade.exports.write_lerobot()` is the public function. Two versions of the format are written:

- 3.0 (lerobot 0.4 and later): tables of many episodes, `meta/episodes/`, pictures or videos
- 2.1 (lerobot 0.3, GR00T): one table per episode, lists of lines in `meta/`
"""

from __future__ import annotations

import importlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from enfilade import ArgumentError, FileError
from enfilade._output import whole_file, write_whole

LEROBOT_VERSIONS = ("3.0", "2.1")

_PICTURES = "observation.images.rgb"
_STATE = "observation.state"
_STATE_NAMES = ("x", "y", "z", "heading")
_NUMBERS = {
    "action": "int64",
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
_STEPS_PER_SECOND = 5
_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}

# LeRobot's own limits of 3.0: megabytes per file of data and of video, files per folder.
_DATA_MEGABYTES, _VIDEO_MEGABYTES, _FILES = 100, 200, 1000
# Rows of a file below meta/episodes: each is some 3 kB, before it is packed.
_EPISODES_PER_FILE = 10_000
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA_PATH = "data/" + _FILE + ".parquet"
_VIDEO_PATH = "videos/{video_key}/" + _FILE + ".mp4"
_EPISODES_PATH = "meta/episodes/" + _FILE + ".parquet"


def write_lerobot(
    folder: Union[str, os.PathLike[str]], version: str = "3.0", videos: bool = False
) -> int:
    """Makes a LeRobot data set of the parts that `enfilade export --as lerobot` has rendered.

    `folder` gets `data/chunk-000/file-000.parquet`, ..., and `meta/`; docs/exports.md has the columns.
    `version` is "3.0", or "2.1" with one table per episode. `videos`, of 3.0 only, stores pictures as
    AV1 videos below `videos/`, which needs PyAV (`av`). A table's parts are removed when it is written,
    so a stopped call is continued. Returns the number of tables.

    Raises ArgumentError for another version, videos of 2.1, or videos of an odd width or height. Raises
    FileError if the folder has tables of another version or of other episodes. Raises OSError for a
    missing part.
    """
    if version not in LEROBOT_VERSIONS:
        raise ArgumentError(f"version {version!r}: not one of {', '.join(LEROBOT_VERSIONS)}")
    if videos and version != "3.0":
        raise ArgumentError("videos: only of version 3.0")
    parts = _Parts(Path(folder))
    if videos and (parts.width % 2 or parts.height % 2):
        raise ArgumentError(f"videos of {parts.width} x {parts.height} pixels: not even numbers")
    tables = _plan(parts, version, videos)
    for table in tables:
        if not all((parts.to / name).exists() for name in table.files):
            _write_table(parts, table, version)
        parts.remove(table)
    if version == "3.0":
        _write_meta_30(parts, tables, videos)
    else:
        _write_meta_21(parts)
    return len(tables)


# --- the parts, and which of them make a table ----------------------------------------------------


@dataclass(frozen=True)
class _Table:
    """A file of rows, and the video of its pictures if there is one."""

    files: list[str]  # below the data set's folder; the table first
    first: int  # episode
    count: int  # episodes

    @property
    def episodes(self) -> range:
        return range(self.first, self.first + self.count)


class _Parts:
    """What the program rendered: pictures, actions and states of each episode."""

    def __init__(self, to: Path) -> None:
        self.to, self.folder = to, to / "enfilade_export.parts"
        if self.folder.is_symlink():
            raise FileError(f"{self.folder}: a link stands in the place of a folder")
        about = json.loads((self.folder / "episodes.json").read_text(encoding="utf-8"))
        self.split: str = about["split"]
        self.width: int = about["width"]
        self.height: int = about["height"]
        self.chunk: int = about["chunk"]  # tables per folder in 2.1
        self.episodes: list[dict[str, Any]] = about["episodes"]
        self.tasks: dict[str, int] = {}  # instructions, in the order of the episodes
        self.first_rows: list[int] = []
        self.rows = 0
        for episode in self.episodes:
            self.tasks.setdefault(episode["instruction"], len(self.tasks))
            self.first_rows.append(self.rows)
            self.rows += episode["length"]

    def path(self, index: int, suffix: str = "") -> Path:
        return self.folder / f"{index:06d}{suffix}"

    def bytes_of(self, index: int) -> int:
        return sum(file.stat().st_size for file in self.path(index).iterdir())

    def names(self, index: int) -> list[str]:
        return [f"frame_{k:06d}.jpg" for k in range(self.episodes[index]["length"])]

    def pictures(self, index: int) -> Iterator[bytes]:
        return ((self.path(index) / name).read_bytes() for name in self.names(index))

    def statistics(self, index: int) -> dict[str, dict[str, list[Any]]]:
        entry = json.loads(self.path(index, ".json").read_text(encoding="utf-8"))
        return dict(entry["stats"])

    def remove(self, table: _Table) -> None:
        for index in table.episodes:
            part, gone = self.path(index), self.path(index, ".done")
            # Without its name at once: half a folder must not count as a part.
            if part.exists():
                shutil.rmtree(gone, ignore_errors=True)
                part.rename(gone)
            shutil.rmtree(gone, ignore_errors=True)
            self.path(index, ".rows.json").unlink(missing_ok=True)


def _plan(parts: _Parts, version: str, videos: bool) -> list[_Table]:
    """The tables that the episodes fill, from `tables.json` if an earlier call has decided."""
    file = parts.folder / "tables.json"
    if file.exists():
        before = json.loads(file.read_text(encoding="utf-8"))
        tables = [_Table(**table) for table in before["tables"]]
        if any((parts.to / name).exists() for table in tables for name in table.files):
            if (before["version"], before["videos"]) != (version, videos):
                raise FileError(
                    f"{file}: the folder has tables of version {before['version']}"
                    f"{' with videos' if before['videos'] else ''}; "
                    "give the same version and videos, or take another folder"
                )
            if sum(table.count for table in tables) != len(parts.episodes):
                raise FileError(f"{file}: the folder has tables of other episodes; take another folder")
            return tables
    else:
        for other, names in (("2.1", "episode_*"), ("3.0", "file-*")):
            if version != other and next(parts.to.glob(f"data/*/{names}.parquet"), None):
                raise FileError(f"{parts.to}: the folder has tables of version {other}; take another folder")
    tables = _tables_21(parts) if version == "2.1" else _tables_30(parts, videos)
    plan = {"version": version, "videos": videos, "tables": [asdict(table) for table in tables]}
    write_whole(parts.folder, file.name, _line(plan).encode())
    return tables


def _tables_21(parts: _Parts) -> list[_Table]:
    return [
        _Table([f"data/chunk-{index // parts.chunk:03d}/episode_{index:06d}.parquet"], index, 1)
        for index in range(len(parts.episodes))
    ]


def _tables_30(parts: _Parts, videos: bool) -> list[_Table]:
    """As many episodes per table as have pictures of 100 MB at most, or one that has more."""
    groups: list[list[int]] = []
    size = 0
    for index in range(len(parts.episodes)):
        more = parts.bytes_of(index)
        if not groups or size + more > _DATA_MEGABYTES * 2**20:
            groups.append([])
            size = 0
        groups[-1].append(index)
        size += more
    tables = []
    for number, group in enumerate(groups):
        files = [_DATA_PATH.format(**_place(number))]
        if videos:
            files.append(_VIDEO_PATH.format(video_key=_PICTURES, **_place(number)))
        tables.append(_Table(files, group[0], len(group)))
    return tables


def _place(number: int) -> dict[str, int]:
    return {"chunk_index": number // _FILES, "file_index": number % _FILES}


# --- tables ---------------------------------------------------------------------------------------


def _write_table(parts: _Parts, table: _Table, version: str) -> None:
    """Writes the statistics of the episodes, their video, then their rows."""
    parquet = importlib.import_module("pyarrow.parquet")
    pa = importlib.import_module("pyarrow")
    videos = table.files[1:]
    schema = _schema(version, bool(videos))
    # JPEG does not shrink further.
    packing = "snappy" if videos else "none"
    with whole_file(parts.to, table.files[0]) as part:
        with parquet.ParquetWriter(part, schema, compression=packing, use_dictionary=False) as writer:
            for index in table.episodes:
                data: dict[str, list[Any]] = {}
                if not videos:
                    pictures = zip(parts.names(index), parts.pictures(index))
                    data[_PICTURES] = [{"bytes": content, "path": name} for name, content in pictures]
                for name, column in _columns(parts, index).items():
                    data[name] = column.tolist()
                # One row group per episode, as lerobot writes.
                writer.write_table(pa.Table.from_pydict(data, schema=schema))
        for name in videos:
            contents = (one for index in table.episodes for one in parts.pictures(index))
            with whole_file(parts.to, name) as video:
                _write_video(contents, parts, video)


def _columns(parts: _Parts, index: int) -> dict[str, NDArray[Any]]:
    """The numbers of an episode's rows. Their statistics, and those of its pictures, get a file."""
    given = json.loads(parts.path(index, ".rows.json").read_text(encoding="utf-8"))
    rows = len(given["actions"])
    frames = np.arange(rows)
    columns: dict[str, NDArray[Any]] = {
        _STATE: np.array(given["states"], np.float32),
        "action": np.array(given["actions"], np.int64),
        "timestamp": frames.astype(np.float32) / np.float32(_STEPS_PER_SECOND),
        "frame_index": frames,
        "episode_index": np.full(rows, index),
        "index": parts.first_rows[index] + frames,
        "task_index": np.full(rows, parts.tasks[parts.episodes[index]["instruction"]]),
    }
    pixels = {name: [[[x]] for x in channels] for name, channels in given["pixels"].items()}
    statistics = {
        _PICTURES: {**pixels, "count": [rows]},
        **{name: _statistics(column) for name, column in columns.items()},
    }
    entry = {"episode_index": index, "stats": statistics}
    write_whole(parts.folder, f"{index:06d}.json", _line(entry).encode())
    return columns


def _schema(version: str, videos: bool) -> Any:
    """The columns of a table. Its metadata tells `datasets` that bytes and path are a picture."""
    pa = importlib.import_module("pyarrow")
    # A list of any length in 2.1, as before; lerobot's own tables of 3.0 fix it.
    length = -1 if version == "2.1" else len(_STATE_NAMES)
    columns = {
        _PICTURES: pa.struct([("bytes", pa.binary()), ("path", pa.string())]),
        _STATE: pa.list_(pa.float32(), length),
        **{name: pa.type_for_alias(kind) for name, kind in _NUMBERS.items()},
    }

    def value(kind: str) -> dict[str, str]:
        return {"dtype": kind, "_type": "Value"}

    features: dict[str, dict[str, Any]] = {
        _PICTURES: {"_type": "Image"},
        _STATE: {"feature": value("float32"), "length": length, "_type": "Sequence"},
        **{name: value(kind) for name, kind in _NUMBERS.items()},
    }
    if videos:
        del columns[_PICTURES], features[_PICTURES]
    about = json.dumps({"info": {"features": features}}, separators=(",", ":"))
    return pa.schema(list(columns.items()), metadata={"huggingface": about})


def _write_video(pictures: Iterable[bytes], parts: _Parts, file: Path) -> None:
    """An MP4 of JPEG files: AV1 with lerobot's usual quality and distance of key frames."""
    av = importlib.import_module("av")
    with av.open(str(file), "w", format="mp4") as container:
        stream = container.add_stream(
            "libsvtav1", rate=_STEPS_PER_SECOND, options={"g": "2", "crf": "30"}
        )
        stream.width, stream.height, stream.pix_fmt = parts.width, parts.height, "yuv420p"
        decoder = av.CodecContext.create("mjpeg", "r")
        for number, content in enumerate(pictures):
            (decoded,) = decoder.decode(av.Packet(content))
            # By way of RGB values: JPEG's brightness has all 256 values, a video's has 220. PyAV 18.1's
            # reformat() keeps JPEG's range as the frame's own, which the encoder then assumes.
            frame = av.VideoFrame.from_ndarray(decoded.to_ndarray(format="rgb24"), format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, _STEPS_PER_SECOND)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


# --- what describes the tables --------------------------------------------------------------------


def _features(parts: _Parts, version: str, videos: bool) -> dict[str, Any]:
    """The columns for LeRobot's reader."""

    def numbers(kind: str, names: Optional[Sequence[str]] = None) -> dict[str, Any]:
        return {"dtype": kind, "shape": [len(names) if names else 1], "names": names}

    pictures: dict[str, Any] = {
        "dtype": "video" if videos else "image",
        "shape": [parts.height, parts.width, 3],
        "names": ["height", "width", "channel" if version == "2.1" else "channels"],
    }
    if videos:
        pictures["info"] = {
            "video.height": parts.height,
            "video.width": parts.width,
            "video.codec": "av1",
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False,
            "video.fps": _STEPS_PER_SECOND,
            "video.channels": 3,
            "has_audio": False,
        }
    return {
        _PICTURES: pictures,
        _STATE: numbers("float32", _STATE_NAMES),
        **{
            name: numbers(kind, ["action"] if name == "action" else None)
            for name, kind in _NUMBERS.items()
        },
    }


def _write_info(parts: _Parts, info: dict[str, Any], version: str, videos: bool) -> None:
    whole = {
        "codebase_version": f"v{version}",
        "robot_type": "vln-ce",
        "total_episodes": len(parts.episodes),
        "total_frames": parts.rows,
        "total_tasks": len(parts.tasks),
        **info,
        "fps": _STEPS_PER_SECOND,
        "splits": {parts.split: f"0:{len(parts.episodes)}"},
        "features": _features(parts, version, videos),
    }
    text = json.dumps(whole, indent=2, ensure_ascii=False) + "\n"
    write_whole(parts.to, "meta/info.json", text.encode())


def _write_meta_21(parts: _Parts) -> None:
    statistics = []
    for index in range(len(parts.episodes)):
        stats = {
            feature: {name: value for name, value in found.items() if name not in _QUANTILES}
            for feature, found in parts.statistics(index).items()
        }
        statistics.append(_line({"episode_index": index, "stats": stats}))
    lines = {
        "episodes_stats.jsonl": statistics,
        "episodes.jsonl": [
            _line({"episode_index": k, "tasks": [e["instruction"]], "length": e["length"]})
            for k, e in enumerate(parts.episodes)
        ],
        "tasks.jsonl": [_line({"task_index": k, "task": text}) for text, k in parts.tasks.items()],
    }
    for name, content in lines.items():
        write_whole(parts.to, f"meta/{name}", "".join(content).encode())
    info = {
        "total_videos": 0,
        "total_chunks": -(-len(parts.episodes) // parts.chunk),
        "chunks_size": parts.chunk,
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": None,
    }
    _write_info(parts, info, "2.1", videos=False)


def _write_meta_30(parts: _Parts, tables: Sequence[_Table], videos: bool) -> None:
    statistics = [parts.statistics(index) for index in range(len(parts.episodes))]
    rows = _episode_rows(parts, tables, statistics, videos)
    for number, first in enumerate(range(0, max(len(rows), 1), _EPISODES_PER_FILE)):
        _write_episodes(parts, rows[first : first + _EPISODES_PER_FILE], number)
    _write_tasks(parts)
    whole = {
        feature: _joined([of_episode[feature] for of_episode in statistics])
        for feature in (statistics[0] if statistics else {})
    }
    write_whole(parts.to, "meta/stats.json", (json.dumps(whole, indent=2) + "\n").encode())
    info = {
        "chunks_size": _FILES,
        "data_files_size_in_mb": _DATA_MEGABYTES,
        "video_files_size_in_mb": _VIDEO_MEGABYTES,
        "data_path": _DATA_PATH,
        "video_path": _VIDEO_PATH if videos else None,
    }
    _write_info(parts, info, "3.0", videos)


def _episode_rows(
    parts: _Parts,
    tables: Sequence[_Table],
    statistics: Sequence[dict[str, dict[str, list[Any]]]],
    videos: bool,
) -> list[dict[str, Any]]:
    """Where each episode's rows and pictures are, and its statistics."""
    rows = []
    for number, table in enumerate(tables):
        place = _place(number)
        for index in table.episodes:
            episode, first = parts.episodes[index], parts.first_rows[index]
            row = {
                "episode_index": index,
                "tasks": [episode["instruction"]],
                "length": episode["length"],
                **{f"data/{name}": value for name, value in place.items()},
                "dataset_from_index": first,
                "dataset_to_index": first + episode["length"],
            }
            if videos:
                begin = first - parts.first_rows[table.first]
                row.update({f"videos/{_PICTURES}/{name}": value for name, value in place.items()})
                row[f"videos/{_PICTURES}/from_timestamp"] = begin / _STEPS_PER_SECOND
                row[f"videos/{_PICTURES}/to_timestamp"] = (
                    begin + episode["length"]
                ) / _STEPS_PER_SECOND
            row.update(
                {f"meta/episodes/{k}": v for k, v in _place(index // _EPISODES_PER_FILE).items()}
            )
            for feature, found in statistics[index].items():
                row.update({f"stats/{feature}/{name}": value for name, value in found.items()})
            rows.append(row)
    return rows


def _write_episodes(parts: _Parts, rows: Sequence[dict[str, Any]], number: int) -> None:
    pa = importlib.import_module("pyarrow")

    def kind(name: str) -> Any:
        if name == "tasks":
            return pa.list_(pa.string())
        if name.startswith("stats/"):
            if name.endswith("/count"):
                return pa.list_(pa.int64())
            numbers = pa.list_(pa.float64())
            return pa.list_(pa.list_(numbers)) if _PICTURES in name else numbers
        return pa.float64() if name.endswith("_timestamp") else pa.int64()

    schema = pa.schema([(name, kind(name)) for name in (rows[0] if rows else {})])
    table = pa.Table.from_pylist(list(rows), schema=schema)
    _write_parquet(table, parts.to, _EPISODES_PATH.format(**_place(number)))


def _write_tasks(parts: _Parts) -> None:
    """The instructions are the index of a pandas table, which its metadata says."""
    pa = importlib.import_module("pyarrow")

    def column(name: Optional[str], kind: str, array: str, more: Any = None) -> dict[str, Any]:
        about = {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": array}
        return {**about, "metadata": more}

    about = {
        "index_columns": ["task"],
        "column_indexes": [column(None, "unicode", "object", {"encoding": "UTF-8"})],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.0.0",
    }
    schema = pa.schema(
        [("task_index", pa.int64()), ("task", pa.string())], metadata={"pandas": json.dumps(about)}
    )
    data = {"task_index": list(parts.tasks.values()), "task": list(parts.tasks)}
    _write_parquet(pa.Table.from_pydict(data, schema=schema), parts.to, "meta/tasks.parquet")


def _write_parquet(table: Any, folder: Path, name: str) -> None:
    parquet = importlib.import_module("pyarrow.parquet")
    with whole_file(folder, name) as part:
        parquet.write_table(table, part, compression="snappy")


# --- statistics -----------------------------------------------------------------------------------


def _statistics(column: NDArray[Any]) -> dict[str, Any]:
    """Least, most, mean, deviation and quantiles of each number of a row."""
    values = column.reshape(len(column), -1).astype(np.float64)
    found = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    found.update({name: np.quantile(values, share, axis=0) for name, share in _QUANTILES.items()})
    return {**{name: numbers.tolist() for name, numbers in found.items()}, "count": [len(column)]}


def _joined(of_episodes: Sequence[dict[str, list[Any]]]) -> dict[str, Any]:
    """Statistics of all rows from those of each episode.

    Quantiles are means of the episodes' quantiles by length, as lerobot joins them.
    """

    def all_of(name: str) -> NDArray[np.float64]:
        return np.array([found[name] for found in of_episodes], np.float64)

    counts = all_of("count")[:, 0]

    def mean_of(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.tensordot(counts / counts.sum(), values, axes=1)

    mean = mean_of(all_of("mean"))
    joined = {
        "min": all_of("min").min(0),
        "max": all_of("max").max(0),
        "mean": mean,
        "std": np.sqrt(mean_of(all_of("std") ** 2 + (all_of("mean") - mean) ** 2)),
    }
    # Parts of an earlier version have no quantiles of pixels.
    for name in _QUANTILES:
        if all(name in found for found in of_episodes):
            joined[name] = mean_of(all_of(name))
    whole = {name: numbers.tolist() for name, numbers in joined.items()}
    return {**whole, "count": [int(counts.sum())]}


def _line(entry: dict[str, Any]) -> str:
    return json.dumps(entry, ensure_ascii=False, separators=(",", ":")) + "\n"
