"""Feature files: an image encoder's output for the 36 views of each viewpoint, in the order of
viewIndex. Formats: docs/features.md.

>>> from enfilade import features
>>> found = features.open_features("resnet152.safetensors")   # or .tsv, .h5, .hdf5
>>> found["17DRP5sb8fy", "5b9b2794954e4694a45fc424a8643081"]   # (36, 2048) float32

HDF5 needs h5py, which is imported when such a file is opened: `pip install "enfilade[features]"`.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import errno
import importlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Callable, Mapping, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from enfilade import _core
from enfilade._errors import ArgumentError, InvalidInput

VIEWS = 36  #: views per viewpoint, in the order of viewIndex
MOST_VALUES = 1 << 24  #: most values per viewpoint; a file could claim more in a few bytes

Key = Tuple[str, str]  #: scan, viewpoint
Array = NDArray[np.float32]  #: (views, D)


@dataclass(frozen=True)
class FeatureInfo:
    """A file's metadata. Texts are empty if the file has none."""

    width: int = 640  #: of the camera, pixels
    height: int = 480  #: of the camera, pixels
    vfov: float = 60.0  #: degrees
    encoder: str = ""  #: "resnet152", "home", ...
    preprocessing: str = ""  #: "caffe", "torchvision", "home"
    weights: str = ""  #: hash of the encoder's weights, 16 hexadecimal digits


@dataclass(frozen=True)
class ViewFeatures:
    """One line of a TSV."""

    scan: str
    viewpoint: str
    width: int  #: pixels
    height: int  #: pixels
    vfov: float  #: degrees
    features: Array  #: (36, D)


class Features(Mapping[Key, Array]):
    """The features of a file by (scan, viewpoint); open_features() makes one.

    Files have names `<scan>_<viewpoint>`, and lookups compare these. Keys of safetensors and HDF5 are cut
    at the last `_`, so a viewpoint with `_` is found, but listed under another scan.

    Each is (views, D) float32, whatever its type in the file. Arrays of safetensors and HDF5 files are
    read at access, as copies. A TSV is in memory, and its arrays are read-only. Any thread may read.
    Unpickling (with spawn) opens the file again; after a fork, open HDF5 in the child.

    Reading raises KeyError for a missing viewpoint. It raises InvalidInput, naming file and viewpoint,
    for an array of another shape than the first, or with numbers that are not finite.
    """

    def __init__(
        self, file: str, info: FeatureInfo, names: dict[Key, str], read: Callable[[str], Any]
    ) -> None:
        if not names:
            raise InvalidInput(f"{file}: holds no viewpoint's features")
        self.file = file
        self.info = info
        self._names = names
        try:
            _check_names(names)
        except ArgumentError as error:
            raise InvalidInput(f"{file}: {error}") from error
        self._keys = {"_".join(key): key for key in names}  # either id may have a "_"
        self._read = read
        self.shape: tuple[int, ...] = np.shape(read(next(iter(names.values()))))  #: (views, D)
        self._check_shape(next(iter(names)), self.shape)

    @property
    def dimensions(self) -> int:
        """D: numbers per view."""
        return self.shape[1]

    def __getitem__(self, key: Key) -> Array:
        if key not in self:
            raise KeyError(f"{self.file}: no features of (scan, viewpoint) {key}")
        name = self._names[self._keys["_".join(key)]]
        values: Array = np.asarray(self._read(name), np.float32)
        if values.shape != self.shape:
            raise InvalidInput(f"{self.file}: {key}: shape {values.shape}, not {self.shape} as the first")
        if not np.isfinite(values).all():
            raise InvalidInput(f"{self.file}: {key}: a number that is infinite or NaN")
        return values

    def __contains__(self, key: object) -> bool:
        if not (isinstance(key, tuple) and len(key) == 2 and all(isinstance(k, str) for k in key)):
            return False
        return "_".join(key) in self._keys

    def __iter__(self) -> Iterator[Key]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __reduce__(self) -> tuple[Any, ...]:
        return open_features, (self.file,)

    def _check_shape(self, key: Key, shape: tuple[int, ...]) -> None:
        if len(shape) != 2 or 0 in shape or shape[0] * shape[1] > MOST_VALUES:
            raise InvalidInput(
                f"{self.file}: {key}: shape {shape}, not (views, numbers a view), {MOST_VALUES} at most"
            )


def open_features(file: Union[str, Path]) -> Features:
    """Opens a file of features by its suffix: .safetensors, .tsv, .h5, .hdf5.

    A TSV has 36 views; read_tsv() reads others. Raises ArgumentError for another suffix, OSError for a
    file that cannot be read, and InvalidInput for a broken one. Raises ImportError naming a missing
    library.
    """
    openers = {".safetensors": _open_safetensors, ".tsv": _open_tsv, ".h5": _open_hdf5,
               ".hdf5": _open_hdf5}  # fmt: skip
    suffix = Path(file).suffix
    if suffix not in openers:
        raise ArgumentError(f"{file}: one of {', '.join(openers)} is wanted")
    with open(file, "rb"):
        pass  # Python's own error for a missing file
    return openers[suffix](str(file))


# --- TSV ------------------------------------------------------------------------------------------


def read_tsv(file: Union[str, Path], views: int = VIEWS) -> Iterator[ViewFeatures]:
    """Reads a file line by line; the format does not contain the number of views. Raises OSError, and
    InvalidInput naming file, line and fault."""
    with open(file, encoding="ascii", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            try:
                scan, viewpoint, width, height, vfov, text = line.rstrip("\n").split("\t")
                values = np.frombuffer(base64.b64decode(text, validate=True), "<f4")
                rows = values.reshape(views, -1)
                found = ViewFeatures(scan, viewpoint, int(width), int(height), float(vfov), rows)
            except (ValueError, binascii.Error) as error:
                raise InvalidInput(f"{file}:{number}: no line of features: {error}") from error
            yield found


def write_tsv(
    file: Union[str, Path],
    features: Mapping[Key, NDArray[Any]],
    *,
    width: int,
    height: int,
    vfov: float,
    views: int = VIEWS,
) -> None:
    """Writes features by (scan, viewpoint), each (views, D), as float32; `vfov` in degrees.

    The file gets its name when it is complete. The format does not contain `views`: if it is not 36, use
    read_tsv() with the same number. Raises OSError for a file that cannot be written. Raises
    ArgumentError, naming the viewpoint, for values that could not be read again.
    """
    shape: tuple[int, ...] = ()
    _check_names(features)
    with _whole_file(file) as part, open(part, "w", encoding="ascii") as out:
        for key, given in features.items():
            values = _checked(key, given)
            shape = shape or (views, values.shape[1])
            if values.shape != shape:
                raise ArgumentError(f"features of {key}: shape {values.shape}, not {shape}")
            text = base64.b64encode(np.asarray(values, "<f4").tobytes()).decode("ascii")
            out.write(f"{key[0]}\t{key[1]}\t{width}\t{height}\t{vfov:g}\t{text}\n")


def _open_tsv(file: str) -> Features:
    info = FeatureInfo()
    rows: list[Array] = []
    names: dict[Key, str] = {}
    for row in read_tsv(file):
        key = (row.scan, row.viewpoint)
        camera = FeatureInfo(row.width, row.height, row.vfov)
        info = info if names else camera
        if key in names or camera != info:
            fault = "comes twice" if key in names else "another camera than the first"
            raise InvalidInput(f"{file}:{len(rows) + 1}: {key}: {fault}")
        names[key] = str(len(rows))
        rows.append(row.features)
    return Features(file, info, names, lambda name: rows[int(name)])


# --- safetensors ----------------------------------------------------------------------------------


def write_safetensors(
    file: Union[str, Path],
    features: Mapping[Key, NDArray[Any]],
    info: FeatureInfo = FeatureInfo(),
) -> None:
    """Writes features by (scan, viewpoint), each (views, D) float32 or float16, in the format of
    `enfilade features`: the 36 views in the order of viewIndex.

    The file gets its name when it is complete. Raises OSError for a file that cannot be written. Raises
    ArgumentError, naming the viewpoint, for values that the format cannot hold.
    """
    arrays: dict[str, NDArray[Any]] = {}
    _check_names(features)
    for key, given in features.items():
        values = _checked(key, given)
        first = next(iter(arrays.values()), values)
        known = values.dtype in (np.float32, np.float16)
        if not known or values.shape != first.shape:
            raise ArgumentError(
                f"features of {key}: {values.dtype} of shape {values.shape}; (views, D) of float32 or "
                "float16 is wanted, the same for all"
            )
        arrays["_".join(key)] = np.ascontiguousarray(values)
    _core.write_safetensors(file, arrays, _metadata(info))


def _open_safetensors(file: str) -> Features:
    tensors = _core.TensorFile(file)
    names = {_key(name, file): name for name in tensors.names()}
    # A copy outlives the file's mapping, and may be changed.
    return Features(
        file, _info(tensors.metadata(), file), names, lambda name: np.array(tensors.array(name), np.float32)
    )


# --- HDF5 -----------------------------------------------------------------------------------------


def _unlocked(library: Any, file: str) -> Any:
    """The file, read without a lock where the file system has none."""
    try:
        return library.File(file, "r")
    except BlockingIOError as error:
        raise InvalidInput(
            f"{file}: another program has the file open for writing. Wait for it, or set "
            "HDF5_USE_FILE_LOCKING=FALSE to read the file as it is now"
        ) from error
    except OSError as error:
        if error.errno not in (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP):
            raise
        return library.File(file, "r", locking=False)


def _check_filters(library: Any, found: Any, where: str) -> None:
    made = found.id.get_create_plist()
    for place in range(made.get_nfilters()):
        number, _, _, name = made.get_filter(place)
        if not library.h5z.filter_avail(number):
            raise InvalidInput(
                f"{where}: packed with the filter '{name.decode(errors='replace')}' ({number}), which "
                "h5py lacks: pip install hdf5plugin, and import it first"
            )


def _open_hdf5(file: str) -> Features:
    try:
        library = importlib.import_module("h5py")
    except ImportError as error:
        raise ImportError(
            'features of this format need h5py: pip install "enfilade[features]"'
        ) from error
    try:
        root = _unlocked(library, file)
        names = {_key(name, file): name for name in root}
    except (OSError, RuntimeError) as error:
        raise InvalidInput(f"{file}: not an HDF5 file, or a damaged one: {error}") from error

    def dataset(name: str) -> Any:
        # Links and external data could refer to other files.
        linked = not isinstance(root.get(name, getlink=True), library.HardLink)
        found: Any = None if linked else root[name]
        if not isinstance(found, library.Dataset) or found.is_virtual or found.external:
            raise InvalidInput(f"{file}: '{name}': a link or data in other files, not a dataset")
        if found.dtype.kind != "f" or found.ndim != 2 or found.size > MOST_VALUES:
            raise InvalidInput(f"{file}: '{name}': {found.dtype} of shape {found.shape}, not of floats")
        return found

    def read(name: str) -> Any:
        try:
            found = dataset(name)
            try:
                return found[()]
            except OSError:
                _check_filters(library, found, f"{file}: '{name}'")
                raise
        except (OSError, RuntimeError, KeyError) as error:
            raise InvalidInput(f"{file}: '{name}' cannot be read: {error}") from error

    said = {**root.attrs, **(dataset(next(iter(names.values()))).attrs if names else {})}
    return Features(file, _info(said, file), names, read)


# --- shared by all formats ------------------------------------------------------------------------


@contextlib.contextmanager
def _whole_file(file: Union[str, Path]) -> Iterator[Path]:
    """A temporary file beside `file`; renamed to it on success, otherwise removed."""
    part = Path(f"{os.fspath(file)}.{os.getpid()}.part")
    try:
        yield part
        os.replace(part, file)
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


def _check_names(keys: Iterable[Key]) -> None:
    """Raises ArgumentError for two keys of one name: either id may have a "_"."""
    known: dict[str, Key] = {}
    for key in keys:
        name = "_".join(map(str, key))
        if known.setdefault(name, key) != key:
            raise ArgumentError(f"features of {key}: another key has the name {name} too")


def _checked(key: Key, given: Any) -> NDArray[Any]:
    """Features as an array. Raises ArgumentError for values that could not be read again."""
    names = len(key) == 2 and all(isinstance(name, str) and name.isascii() for name in key)
    if not names or not all(key) or any(c.isspace() for c in "".join(key)):
        raise ArgumentError(f"features of {key!r}: (scan, viewpoint) of ASCII names without spaces")
    values = np.asarray(given)
    if values.ndim != 2 or 0 in values.shape or values.dtype.kind != "f":
        raise ArgumentError(
            f"features of {key}: {values.dtype} of shape {values.shape}; floats, (views, D), are wanted"
        )
    if not np.isfinite(values).all():
        raise ArgumentError(f"features of {key}: a number that is infinite or NaN")
    return values


def _key(name: str, file: str) -> Key:
    scan, _, viewpoint = name.rpartition("_")  # one of perhaps several: Features finds whole names
    if not scan or not viewpoint:
        raise InvalidInput(f"{file}: '{name[:100]}' is not <scan>_<viewpoint>: no file of features")
    return scan, viewpoint


def _metadata(info: FeatureInfo) -> dict[str, str]:
    texts = {name: f"{value}" for name, value in asdict(info).items()}
    texts["image_w"], texts["image_h"] = texts.pop("width"), texts.pop("height")
    texts["vfov"] = f"{info.vfov:.14g}"
    return texts


def _info(said: Mapping[str, Any], file: str) -> FeatureInfo:
    def text(name: str) -> str:
        value = said.get(name, "")
        return value.decode(errors="replace") if isinstance(value, bytes) else str(value)

    try:
        width, height, vfov = (
            float(said.get(name, otherwise))
            for name, otherwise in (("image_w", 640), ("image_h", 480), ("vfov", 60))
        )
        return FeatureInfo(
            int(width), int(height), vfov, text("encoder"), text("preprocessing"), text("weights")
        )
    except (OverflowError, TypeError, ValueError) as error:
        raise InvalidInput(f"{file}: image_w, image_h, vfov: {error}") from error
