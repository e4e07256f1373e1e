"""Feature files: what is written is read, in every format, and broken ones are named."""

from __future__ import annotations

import json
import os
import pickle
import re
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import enfilade
import pytest

np = pytest.importorskip("numpy")

from enfilade import features  # noqa: E402
from enfilade.features import FeatureInfo  # noqa: E402

INFO = FeatureInfo(224, 224, 75.5, "resnet18", "torchvision", "0123456789abcdef")
SUFFIXES = [".tsv", ".safetensors", ".h5"]


@pytest.fixture
def some() -> dict[tuple[str, str], Any]:
    random = np.random.default_rng(1)
    names = [("b", "v1"), ("a_scan", "v2"), ("b", "v3")]
    return {key: random.standard_normal((36, 5)).astype(np.float32) for key in names}


def write(file: Path, some: dict[tuple[str, str], Any]) -> str:
    """HDF5 is written as the field's own files are."""
    if file.suffix == ".tsv":
        features.write_tsv(file, some, width=224, height=224, vfov=75.5)
    elif file.suffix == ".safetensors":
        features.write_safetensors(str(file), some, INFO)
    else:
        h5py = pytest.importorskip("h5py", reason="h5py is not installed")
        with h5py.File(file, "w") as root:
            for (scan, viewpoint), values in some.items():
                root.create_dataset(f"{scan}_{viewpoint}", values.shape, "f", compression="gzip")
                root[f"{scan}_{viewpoint}"][...] = values
                said = {"scanId": scan, "viewpointId": viewpoint, "image_w": 224, "image_h": 224,
                        "vfov": 75.5}  # fmt: skip
                root[f"{scan}_{viewpoint}"].attrs.update(said)
    return str(file)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_is_written_is_read(tmp_path: Path, some: Any, suffix: str) -> None:
    found = features.open_features(write(tmp_path / f"f{suffix}", some))
    assert set(found) == set(some) and len(found) == 3 and found.shape == (36, 5)
    assert all((found[key] == some[key]).all() for key in some)
    assert found["b", "v3"].dtype == np.float32 and found.dimensions == 5
    info = found.info
    assert (info.width, info.height, info.vfov) == (224, 224, 75.5)
    assert info == INFO or suffix != ".safetensors"
    assert ("b", "nowhere") not in found and found.get(("b", "nowhere")) is None
    with pytest.raises(KeyError, match="nowhere"):
        found["b", "nowhere"]
    again = pickle.loads(pickle.dumps(found))
    assert (again["b", "v1"] == some["b", "v1"]).all()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_viewpoints_with_underscores_are_found_by_the_whole_name(tmp_path: Path, suffix: str) -> None:
    """As cameras name their pictures: IMG_1_01.jpg."""
    key = ("my_home", "IMG_1_01")
    values = np.ones((36, 2), np.float32)
    found = features.open_features(write(tmp_path / f"f{suffix}", {key: values}))
    assert (found[key] == values).all() and key in found
    assert ("my_home", "01") not in found and "my_home" not in found


def test_safetensors_are_read_by_their_bytes(tmp_path: Path) -> None:
    """A file made by hand from the format's description: F16, no metadata."""
    values = np.arange(36 * 2, dtype=np.float16)
    header = {"s_v": {"dtype": "F16", "shape": [36, 2], "data_offsets": [0, values.nbytes]}}
    text = json.dumps(header).encode()
    file = tmp_path / "f.safetensors"
    file.write_bytes(struct.pack("<Q", len(text)) + text + values.tobytes())
    found = features.open_features(file)
    assert (found["s", "v"] == values.reshape(36, 2)).all() and found["s", "v"].dtype == np.float32
    assert found.info == FeatureInfo()
    file.write_bytes(file.read_bytes()[:-1])
    with pytest.raises(enfilade.InvalidInput, match="f.safetensors"):
        features.open_features(file)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_broken_arrays_are_named(
    tmp_path: Path, some: Any, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(features, "_checked", lambda key, values: values)  # as others write them
    some["b", "v3"] = some["b", "v3"].copy()
    some["b", "v3"][7, 1] = np.nan
    if suffix == ".h5":
        some["b", "wide"] = np.ones((36, 6), np.float32)
    found = features.open_features(write(tmp_path / f"f{suffix}", some))
    assert np.isfinite(found["b", "v1"]).all()
    for name in ("v3", "wide") if suffix == ".h5" else ("v3",):
        with pytest.raises(enfilade.InvalidInput, match=rf"f{suffix}.*{name}"):
            found["b", name]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_of_something_else_are_refused(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"f{suffix}"
    with pytest.raises(FileNotFoundError):
        features.open_features(file)
    if suffix == ".h5":
        pytest.importorskip("h5py", reason="h5py is not installed")
    for junk in (b"", b"junk\n", b"\xff" * 100):
        file.write_bytes(junk)
        with pytest.raises(enfilade.InvalidInput, match=f"f{suffix}"):
            features.open_features(file)
    with pytest.raises(enfilade.ArgumentError, match=".hdf5"):
        features.open_features("features.npy")


def test_broken_lines_of_tsv_are_named(tmp_path: Path) -> None:
    file = tmp_path / "f.tsv"
    good = {("s", "v"): np.ones((36, 4), np.float32)}
    features.write_tsv(str(file), good, width=640, height=480, vfov=60)
    line = file.read_text()
    for bad in ("s\tv\t640\t480\t60\t!!\n", "s\tw\t640\t480\n", line,
                line.replace("v\t640", "w\t320")):  # fmt: skip
        file.write_text(line + bad)
        with pytest.raises(enfilade.InvalidInput, match="f.tsv:2"):
            features.open_features(file)


def test_two_keys_of_one_name_are_refused(tmp_path: Path) -> None:
    """Either would be found by the other's ids."""
    values = np.ones((36, 4), np.float32)
    one, other = {("a_b", "c"): values}, {("a", "b_c"): values}
    text = ""
    for some in (one, other):
        text += Path(write(tmp_path / "f.tsv", some)).read_text()
    (tmp_path / "f.tsv").write_text(text)
    said = r"features of \('a', 'b_c'\): another key has the name a_b_c too"
    with pytest.raises(enfilade.InvalidInput, match=rf"f\.tsv: {said}"):
        features.open_features(tmp_path / "f.tsv")
    for suffix in (".tsv", ".safetensors"):
        with pytest.raises(enfilade.ArgumentError, match=said):
            write(tmp_path / f"g{suffix}", {**one, **other})
    assert not list(tmp_path.glob("g*"))


def test_hdf5_that_another_program_writes_is_said_to_be_locked(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    file = tmp_path / "f.h5"
    with h5py.File(file, "w") as root:
        root["b_v1"] = np.zeros((36, 2), np.float32)
    writes = "import sys, h5py\nf = h5py.File(sys.argv[1], 'a')\nprint('open', flush=True)\nsys.stdin.read()\n"
    with subprocess.Popen(
        [sys.executable, "-c", writes, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as writer:
        assert writer.stdout is not None and writer.stdout.readline() == b"open\n"
        with pytest.raises(enfilade.InvalidInput, match="another program.*HDF5_USE_FILE_LOCKING=FALSE"):
            features.open_features(file)
        writer.communicate()
    assert len(features.open_features(file)) == 1


def test_hdf5_with_a_filter_that_is_missing_names_it(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    packed = tmp_path / "lzf.h5"
    with h5py.File(packed, "w") as root:
        root.create_dataset("b_v1", data=np.ones((36, 2), np.float32), compression="lzf")
    assert (features.open_features(packed)["b", "v1"] == 1).all()
    with h5py.File(tmp_path / "blosc.h5", "w") as root:
        made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        made.set_chunk((36, 2))
        # An optional filter that is missing does not pack, but is named in the file.
        made.set_filter(32001, h5py.h5z.FLAG_OPTIONAL)
        space = h5py.h5s.create_simple((36, 2))
        # The second claims to be packed; the first's chunk skipped the filter.
        for name, skipped in ((b"b_v1", 1), (b"b_v2", 0)):
            found = h5py.h5d.create(root.id, name, h5py.h5t.IEEE_F32LE, space, dcpl=made)
            found.write_direct_chunk((0, 0), np.ones((36, 2), np.float32).tobytes(), skipped)
    some = features.open_features(tmp_path / "blosc.h5")
    with pytest.raises(enfilade.InvalidInput, match="32001.*hdf5plugin"):
        some["b", "v2"]
    assert (some["b", "v1"] == 1).all()


def test_hdf5_leads_nowhere_else(tmp_path: Path, some: Any) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    other = write(tmp_path / "other.h5", some)
    links = {"s_soft": h5py.SoftLink("/b_v1"), "s_far": h5py.ExternalLink(other, "/b_v1")}
    for name, link in links.items():
        file = write(tmp_path / f"{name}.h5", some)
        with h5py.File(file, "a") as root:
            root[name] = link
        with pytest.raises(enfilade.InvalidInput, match=name):
            features.open_features(file)["s", name[2:]]
    virtual = h5py.VirtualLayout(shape=(36, 5), dtype="f")
    virtual[:] = h5py.VirtualSource(other, "b_v1", shape=(36, 5))
    with h5py.File(tmp_path / "virtual.h5", "w") as root:
        root.create_virtual_dataset("s_v", virtual)
        root.create_dataset("s_whole", (36, 5), "i4")
    for name in ("v", "whole"):
        with pytest.raises(enfilade.InvalidInput, match=f"s_{name}|s_v"):
            features.open_features(tmp_path / "virtual.h5")["s", name]


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "h5py", None)
    (tmp_path / "f.h5").touch()
    with pytest.raises(ImportError, match=r"h5py.*enfilade\[features\]"):
        features.open_features(tmp_path / "f.h5")


def test_the_library_of_the_format_agrees(tmp_path: Path, some: Any) -> None:
    library = pytest.importorskip("safetensors.numpy", reason="safetensors is not installed")
    file = tmp_path / "f.safetensors"
    features.write_safetensors(file, some, INFO)
    read = library.load_file(file)
    assert set(read) == {"_".join(key) for key in some}
    assert all((read["_".join(key)] == values).all() for key, values in some.items())
    library.save_file(read, file, metadata={"encoder": "resnet18", "vfov": "75.5"})
    found = features.open_features(file)
    assert found.info == FeatureInfo(vfov=75.5, encoder="resnet18")
    assert all((found[key] == values).all() for key, values in some.items())


def save(file: Path, some: Any) -> None:
    if file.suffix == ".tsv":
        features.write_tsv(file, some, width=224, height=224, vfov=75.5)
    else:
        features.write_safetensors(file, some, INFO)


GOOD = np.ones((36, 4), np.float32)


@pytest.mark.parametrize("suffix", [".tsv", ".safetensors"])
@pytest.mark.parametrize(
    ("key", "values"),
    [
        (("s", "flat"), np.ones(36, np.float32)),
        (("s", "integers"), np.ones((36, 4), np.int32)),
        (("s", "empty"), np.ones((36, 0), np.float32)),
        (("s", "wide"), np.ones((36, 5), np.float32)),
        (("s", "few"), np.ones((12, 4), np.float32)),
        (("s", "infinite"), GOOD * np.inf),
        (("s", "a\ttab"), GOOD),
        (("s", "umläut"), GOOD),
        (("", "nameless"), GOOD),
        ("s_whole", GOOD),
    ],
)
def test_what_could_not_be_read_is_not_written(
    tmp_path: Path, suffix: str, key: Any, values: Any
) -> None:
    """The file that was there before stays, and nothing else does."""
    file = tmp_path / f"f{suffix}"
    file.write_text("old")
    with pytest.raises(enfilade.ArgumentError, match=re.escape(repr(key))):
        save(file, {("s", "v"): GOOD, key: values})
    assert [one.name for one in tmp_path.iterdir()] == [file.name] and file.read_text() == "old"


def test_what_is_not_in_safetensors_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(enfilade.ArgumentError, match="float64"):
        save(tmp_path / "f.safetensors", {("s", "v"): GOOD.astype(np.float64)})
    with pytest.raises(enfilade.ArgumentError, match="s_1_v"):
        save(tmp_path / "f.safetensors", {("s_1", "v"): GOOD, ("s", "1_v"): GOOD})


@pytest.mark.parametrize("suffix", [".tsv", ".safetensors"])
def test_a_file_has_its_name_when_it_is_whole(tmp_path: Path, some: Any, suffix: str) -> None:
    """A writer that dies leaves what was there before; what is written is as readable as any file."""
    file = tmp_path / f"f{suffix}"
    save(file, {("s", "v"): GOOD})
    (tmp_path / "other").touch()
    assert file.stat().st_mode == (tmp_path / "other").stat().st_mode

    class Dies(dict):  # type: ignore[type-arg]
        def items(self) -> Any:
            yield from super().items()
            os._exit(9)

    child = os.fork()
    if child == 0:
        save(file, Dies(some))
    assert os.waitpid(child, 0)[1] == 9 << 8  # it exited, with 9
    assert (features.open_features(file)["s", "v"] == GOOD).all()
    save(file, some)
    assert set(features.open_features(file)) == set(some)
    with pytest.raises(OSError):
        save(tmp_path / "nowhere" / f"f{suffix}", some)


def test_other_numbers_of_views_are_said_to_both(tmp_path: Path) -> None:
    file, values = tmp_path / "f.tsv", np.arange(24, dtype=np.float32).reshape(12, 2)
    with pytest.raises(enfilade.ArgumentError, match=r"\(12, 2\), not \(36, 2\)"):
        save(file, {("s", "v"): values})
    features.write_tsv(file, {("s", "v"): values}, width=224, height=224, vfov=90, views=12)
    (row,) = features.read_tsv(file, views=12)
    assert (row.features == values).all() and row.vfov == 90


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_program_reads_and_writes_the_same(tmp_path: Path, some: Any, suffix: str) -> None:
    """From Python through `enfilade features --merge` and back."""
    program = os.environ.get("ENFILADE_PROGRAM")
    if not program or not Path(program).is_file():
        pytest.skip("ENFILADE_PROGRAM names no program that was built with libtorch")
    first = write(tmp_path / f"first{suffix}", some)
    for other in SUFFIXES:
        after = str(tmp_path / f"after{other}")
        subprocess.run([program, "features", "--merge", first, "-o", after], check=True)
        if other == ".h5":
            pytest.importorskip("h5py", reason="h5py is not installed")
        found = features.open_features(after)
        assert set(found) == set(some) and found.info.vfov == 75.5
        assert all((found[key] == some[key]).all() for key in some)
        assert found.info == INFO or suffix != ".safetensors" or other == ".tsv"
