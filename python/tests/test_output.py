"""Files with computed names: below a folder, never outside."""

from pathlib import Path

import pytest

from enfilade._errors import FileError
from enfilade._output import output_file, whole_file, write_whole

OUTSIDE = ["", "/", "/etc/x", "../x", "a/../x", "a//b", "a/", "./a", "a\\b", "a\n", "a/\x7f"]


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """One to write into, and one outside of it."""
    out, outside = tmp_path / "p/out", tmp_path / "outside"
    outside.mkdir()
    return out, outside


def test_a_file_is_written_with_its_folders(folders: tuple[Path, Path]) -> None:
    out, _ = folders
    for content in (b"1", b"2"):
        write_whole(out, "a/b/.c d", content)
        assert (out / "a/b/.c d").read_bytes() == content
    assert [file.name for file in (out / "a/b").iterdir()] == [".c d"]


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_name_that_leads_elsewhere_is_refused(folders: tuple[Path, Path], name: str) -> None:
    out, _ = folders
    with pytest.raises(FileError, match="not a name of a file in this folder"):
        write_whole(out, name, b"1")
    assert not out.exists()


def test_no_link_is_followed(folders: tuple[Path, Path]) -> None:
    out, outside = folders
    out.mkdir(parents=True)
    (out / "link").symlink_to(outside)
    with pytest.raises(FileError, match="link: a link stands in the place of a folder"):
        output_file(out, "link/x")
    (outside / "kept").write_bytes(b"old")
    for name in ("a", "a.part"):
        (out / name).symlink_to(outside / "kept")
        write_whole(out, "a", b"new")
        assert (outside / "kept").read_bytes() == b"old"
        assert (out / "a").read_bytes() == b"new"
        assert not (out / "a").is_symlink()
    assert [file.name for file in outside.iterdir()] == ["kept"]


def test_nothing_gets_the_name_if_its_writer_fails(folders: tuple[Path, Path]) -> None:
    out, _ = folders
    with pytest.raises(ValueError):
        with whole_file(out, "a") as part:
            part.write_bytes(b"half")
            raise ValueError
    assert not (out / "a").exists()
