"""Model homes: synthetic, furnished buildings with panoramas, depth, labels, graphs, paths and
instructions, for machines without Matterport3D. Results on them are results on synthetic data.
"""

from __future__ import annotations

from dataclasses import dataclass

from enfilade import _synth


@dataclass(frozen=True)
class HomeReport:
    """What was made."""

    homes: int
    paths: int  #: 0 for fewer than 3 homes: splits by building take as many
    instructions: int


def write_homes(
    folder: str,
    *,
    preset: str = "small",
    homes: int = 0,
    seed: int = 1,
    face_size: int = 128,
    threads: int = 0,
) -> HomeReport:
    """Makes, or completes, a data folder of model homes; the same arguments give the same bytes.

    Args:
        folder: new, empty, or of an earlier run that goes on.
        preset: "small" (a few viewpoints a home), "demo" (25 to 40), "full" (117 on average).
        homes: how many; 0: as many as the preset has.
        face_size: texels of a panorama's faces; 0: no pictures.
        threads: 0: all cores; never changes a byte.

    A viewpoint takes about a second of one core at 256 texels.
    """
    return HomeReport(*_synth.write_homes(folder, preset, homes, seed, face_size, threads))
