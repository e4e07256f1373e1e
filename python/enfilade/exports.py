"""Files that Python packages write: `enfilade export` runs this module for them.

`pip install "enfilade[graphs]"` brings networkx, `pip install "enfilade[lerobot]"` pyarrow, and
`pip install "enfilade[lerobot-videos]"` PyAV too.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pickle
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

from enfilade import ArgumentError, FileError, Graph, Graphs, InvalidInput, UnknownNameError
from enfilade._lerobot import LEROBOT_VERSIONS, write_lerobot
from enfilade._output import write_whole

__all__ = ["main", "networkx_graph", "write_lerobot", "write_networkx"]


def networkx_graph(graph: Graph) -> Any:
    """A networkx.Graph of the included viewpoints, or a DiGraph if an edge leads one way only.

    Edges have `weight`, metres. Viewpoints have `world_position`, metres, and `position`: x, z, -y of it.
    """
    ids, (pairs, lengths) = graph.viewpoints, graph.edge_arrays()
    edges = {(ids[a], ids[b]): length for (a, b), length in zip(pairs.tolist(), lengths.tolist())}
    positions = dict(zip(ids, graph.positions.tolist()))
    return _networkx_graph({name: at for name, at in positions.items() if graph.included(name)}, edges)


def _networkx_graph(
    positions: Mapping[str, Sequence[float]], edges: Mapping[tuple[str, str], float]
) -> Any:
    networkx = importlib.import_module("networkx")
    directed = any((b, a) not in edges for a, b in edges)
    made = networkx.DiGraph() if directed else networkx.Graph()
    for name, (x, y, z) in positions.items():
        made.add_node(name, position=[x, z, -y], world_position=[x, y, z])
    made.add_weighted_edges_from((a, b, length) for (a, b), length in edges.items())
    return made


def write_networkx(
    graphs: Graphs, file: Union[str, os.PathLike[str]], scans: Optional[Iterable[str]] = None
) -> None:
    """Pickles {scan: networkx_graph()}, of the scans given or of all. Raises UnknownNameError."""
    whole = {scan: networkx_graph(graphs[scan]) for scan in (graphs.scans if scans is None else scans)}
    write_whole(Path(file).parent, Path(file).name, pickle.dumps(whole, protocol=2))


def _join_networkx(folder: Path) -> Path:
    """Makes connectivity_graphs.pkl of the parts that `enfilade export --as networkx` has written."""
    parts, file = folder / "connectivity_graphs.parts", folder / "connectivity_graphs.pkl"
    whole = {}
    for part in sorted(parts.glob("*.json")):
        viewpoints = json.loads(part.read_text(encoding="utf-8"))
        positions = {name: found["position"] for name, found in viewpoints.items()}
        edges = {(a, b): n for a, found in viewpoints.items() for b, n in found["edges"].items()}
        whole[part.stem] = _networkx_graph(positions, edges)
    write_whole(folder, file.name, pickle.dumps(whole, protocol=2))
    shutil.rmtree(parts)
    return file


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """networkx FOLDER, or lerobot FOLDER [--version 2.1] [--videos].

    The folder is what `enfilade export` wrote, with its parts. Returns 0, or 3 for what it cannot read
    or write.
    """
    parser = argparse.ArgumentParser(prog="enfilade export")
    forms = parser.add_subparsers(dest="form", required=True)
    forms.add_parser("networkx").add_argument("folder", help="the folder with the parts")
    lerobot = forms.add_parser("lerobot")
    lerobot.add_argument("folder", help="the folder of the data set, with its parts")
    lerobot.add_argument("--version", default="3.0", choices=LEROBOT_VERSIONS, help="of the format")
    lerobot.add_argument("--videos", action="store_true", help="AV1 videos instead of pictures")
    given = parser.parse_args(arguments)
    try:
        if given.form == "networkx":
            file = _join_networkx(Path(given.folder))
            said = f"{file}: {os.path.getsize(file) / 1e6:.1f} MB"
        else:
            os.environ.setdefault("SVT_LOG", "1")  # errors alone: the encoder describes itself
            tables = write_lerobot(given.folder, given.version, given.videos)
            said = f"{given.folder}: {tables} tables of LeRobot {given.version}"
    except (ArgumentError, FileError, InvalidInput, UnknownNameError, OSError) as error:
        print(error, file=sys.stderr)
        return 3
    print(said)
    return 0


if __name__ == "__main__":
    sys.exit(main())
