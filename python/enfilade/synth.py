"""Synthetic homes: furnished buildings with panoramas, depth, labels, graphs, paths and instructions,
for machines without Matterport3D. Results on them are results on synthetic data.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Optional, Union

from enfilade import _synth
from enfilade._arguments import whole
from enfilade._errors import ArgumentError


@dataclass(frozen=True)
class HomeReport:
    """The result of write_homes()."""

    homes: int
    paths: int  #: 0 for fewer than 3 homes, the least for splits by building
    instructions: int


def write_homes(
    folder: Union[str, os.PathLike[str]],
    *,
    preset: str = "small",
    homes: int = 0,
    seed: int = 1,
    face_size: Optional[int] = None,
    threads: int = 0,
) -> HomeReport:
    """Makes, or completes, a data folder of synthetic homes. The same arguments give the same bytes.

    Args:
        folder: new, empty, or of an earlier run, which is then continued.
        preset: "small" (a few viewpoints per home), "pretty" (25 to 50), "full" (117 on average),
            "graphs" (homes like those of "pretty", without images), "training" (96 homes for training
            agents), "demo" (60 of these, three of them pretty).
        homes: number of homes; 0: the preset's.
        face_size: texels along an edge of a panorama's faces; 0: no images; None: the preset's.
        threads: 0: all cores; never changes a byte.

    A viewpoint takes about a second of one core at 256 texels. Raises ArgumentError for an unknown
    preset or an invalid number. Raises FileError for a folder that cannot be written or that holds
    other files.
    """
    made = _synth.write_homes(
        os.fspath(folder),
        preset,
        whole("homes", homes),
        whole("seed", seed, 2**64 - 1),
        None if face_size is None else whole("face_size", face_size),
        threads,
    )
    return HomeReport(*made)


def write_small_dataset(
    folder: Union[str, os.PathLike[str]], buildings: int = 6, seed: int = 1
) -> None:
    """Writes a small synthetic data set without images: graphs and R2R annotations.

    Short for `write_homes(folder, preset="graphs", homes=buildings, seed=seed)`; the same arguments
    give the same bytes. Raises ArgumentError for fewer than 3 buildings (train, val_unseen and test
    need one each).
    """
    if whole("buildings", buildings) < 3:
        raise ArgumentError(f"buildings: {buildings}, but splits by building need 3")
    write_homes(folder, preset="graphs", homes=buildings, seed=seed)
