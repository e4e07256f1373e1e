"""Files that Python packages write: `enfilade export` runs this module for them.

`pip install "enfilade[graphs]"` brings networkx.
"""

from __future__ import annotations

import argparse
import os
import pickle
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import networkx  # type: ignore[import-untyped]

from enfilade import FileError, Graph, Graphs, InvalidInput, UnknownNameError


def networkx_graph(graph: Graph) -> Any:
    """A networkx.Graph of the included viewpoints, or a DiGraph if an edge leads one way only.

    Edges have `weight`, metres. Viewpoints have `world_position`, metres, and `position`: x, z, -y of it.
    """
    ids, (pairs, lengths) = graph.viewpoints, graph.edge_arrays()
    edges = {(ids[a], ids[b]): length for (a, b), length in zip(pairs.tolist(), lengths.tolist())}
    directed = any((b, a) not in edges for a, b in edges)
    made = networkx.DiGraph() if directed else networkx.Graph()
    for name, (x, y, z) in zip(ids, graph.positions.tolist()):
        if graph.included(name):
            made.add_node(name, position=[x, z, -y], world_position=[x, y, z])
    made.add_weighted_edges_from((a, b, length) for (a, b), length in edges.items())
    return made


def write_networkx(
    graphs: Graphs, file: Union[str, os.PathLike[str]], scans: Optional[Iterable[str]] = None
) -> None:
    """Pickles {scan: networkx_graph()}, of the scans given or of all. Raises UnknownNameError."""
    whole = {scan: networkx_graph(graphs[scan]) for scan in (graphs.scans if scans is None else scans)}
    part = Path(f"{os.fspath(file)}.part")
    part.write_bytes(pickle.dumps(whole, protocol=2))
    part.replace(file)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """networkx CONNECTIVITY FILE [SCAN...]. Returns 0, or 2 for what it cannot read or write."""
    parser = argparse.ArgumentParser(prog="enfilade export")
    parser.add_argument("form", choices=["networkx"])
    parser.add_argument("connectivity", help="the folder with scans.txt")
    parser.add_argument("file", help="the file to write")
    parser.add_argument("scans", nargs="*", help="only these (default: all)")
    given = parser.parse_args(arguments)
    try:
        write_networkx(Graphs(given.connectivity), given.file, given.scans or None)
    except (FileError, InvalidInput, UnknownNameError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{given.file}: {os.path.getsize(given.file) / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
