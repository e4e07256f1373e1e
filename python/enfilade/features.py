"""Feature files of the field: base64 TSV, as the first R2R code wrote and most code still reads.

A line: scanId, viewpointId, image_w, image_h, vfov (degrees), and 36 x D float32 in base64, views in
the order of viewIndex.
"""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

VIEWS = 36


@dataclass(frozen=True)
class ViewFeatures:
    """One line of a file."""

    scan: str
    viewpoint: str
    width: int  #: pixels
    height: int  #: pixels
    vfov: float  #: degrees
    features: NDArray[np.float32]  #: (36, D)


def read_tsv(file: str, views: int = VIEWS) -> Iterator[ViewFeatures]:
    """Reads a file line by line. Raises ValueError naming file, line and fault."""
    with open(file, encoding="ascii") as lines:
        for number, line in enumerate(lines, 1):
            try:
                scan, viewpoint, width, height, vfov, text = line.rstrip("\n").split("\t")
                values = np.frombuffer(base64.b64decode(text, validate=True), np.float32)
                rows = values.reshape(views, -1)
                found = ViewFeatures(scan, viewpoint, int(width), int(height), float(vfov), rows)
            except (ValueError, binascii.Error) as error:
                raise ValueError(f"{file}:{number}: no line of features: {error}") from error
            yield found


def write_tsv(
    file: str,
    features: Mapping[tuple[str, str], NDArray[np.float32]],
    *,
    width: int,
    height: int,
    vfov: float,
) -> None:
    """Writes features by (scan, viewpoint), each (36, D); `vfov` in degrees."""
    with open(file, "w", encoding="ascii") as out:
        for (scan, viewpoint), values in features.items():
            if values.ndim != 2:
                raise ValueError(f"features of {viewpoint}: shape {values.shape}, not (views, D)")
            text = base64.b64encode(np.asarray(values, np.float32).tobytes()).decode("ascii")
            out.write(f"{scan}\t{viewpoint}\t{width}\t{height}\t{vfov:g}\t{text}\n")
