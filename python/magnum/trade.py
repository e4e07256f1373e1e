"""Importers of files: not there."""

from __future__ import annotations

from typing import Any

from magnum._refused import NotThere, refused

_words = "files are not opened through Magnum here; habitat_sim.Simulator opens scenes"


class ImporterManager:
    """Can be made, as `import habitat` does, and has no importer."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # as pickle and copy ask for
            raise AttributeError(name)
        raise NotThere(f"magnum.trade.ImporterManager: {_words}")


MeshData = refused("magnum.trade.MeshData", _words)

__all__ = ["ImporterManager", "MeshData"]
