"""Folders in object stores: on fsspec's own file system, and on a server that speaks S3."""

import json
import os
import socket
import subprocess
import sys
import time

import pytest

pytest.importorskip("fsspec", reason="the package fsspec is not installed")

from enfilade import stores
from enfilade._errors import FileError


@pytest.fixture
def s3(monkeypatch):
    """The URL of a bucket on a server of moto's."""
    pytest.importorskip("moto", reason="the package moto[server] is not installed")
    s3fs = pytest.importorskip("s3fs", reason="the package s3fs is not installed")
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    command = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for name, value in {
        "AWS_ACCESS_KEY_ID": "key",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
    }.items():
        monkeypatch.setenv(name, value)
    s3fs.S3FileSystem.clear_instance_cache()
    for _ in range(200):
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) == 0:
                break
        time.sleep(0.1)
    s3fs.S3FileSystem(endpoint_url=os.environ["AWS_ENDPOINT_URL"]).mkdir("bucket")
    yield "s3://bucket/homes"
    server.kill()
    server.wait()


@pytest.fixture(params=["file", "s3"])
def url(request, tmp_path):
    return request.getfixturevalue("s3") if request.param == "s3" else f"file://{tmp_path}/store/homes"


@pytest.fixture
def homes(tmp_path):
    folder = tmp_path / "homes"
    (folder / "connectivity").mkdir(parents=True)
    (folder / "connectivity/scans.txt").write_text("one\n")
    (folder / "big.bin").write_bytes(bytes(range(256)) * 20000)
    (folder / "empty").write_bytes(b"")
    return folder


def content(folder):
    return {f.relative_to(folder).as_posix(): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


def test_what_is_fetched_is_what_was_published(homes, url, tmp_path):
    assert stores.publish(str(homes), url, threads=2) == (3, 5120004, 0)
    assert stores.publish(str(homes), url) == (0, 0, 3)  # nothing is done twice
    assert stores.fetch(url, str(tmp_path / "there")) == (3, 5120004, 0)
    assert content(tmp_path / "there") == content(homes)
    # What changed is copied, and what was damaged here.
    (homes / "empty").write_bytes(b"no more")
    assert stores.publish(str(homes), url).files == 1
    (tmp_path / "there/connectivity/scans.txt").write_text("two\n")
    assert stores.fetch(url, str(tmp_path / "there")) == (2, 11, 1)
    assert content(tmp_path / "there") == content(homes)


def test_other_bytes_than_the_list_has_are_not_kept(homes, tmp_path):
    store = tmp_path / "store"
    stores.publish(str(homes), f"file://{store}")
    (store / "big.bin").write_bytes(b"short")
    with pytest.raises(FileError, match="big.bin: other bytes than the list has"):
        stores.fetch(f"file://{store}", str(tmp_path / "there"))
    assert not (tmp_path / "there/big.bin").exists()


def test_nothing_is_fetched_out_of_the_folder(homes, tmp_path):
    url = f"file://{tmp_path}/store"
    stores.publish(str(homes), url, progress=False)
    (tmp_path / "outside").mkdir()
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy/connectivity").symlink_to(tmp_path / "outside")
    with pytest.raises(FileError, match="connectivity: a link stands in the place of a folder"):
        stores.fetch(url, str(tmp_path / "copy"), progress=False)
    list_file = tmp_path / "store" / stores.LIST
    listed = json.loads(list_file.read_text())
    listed["files"]["a/../../outside/x"] = listed["files"]["empty"]
    list_file.write_text(json.dumps(listed))
    with pytest.raises(FileError, match="is no path below the folder"):
        stores.fetch(url, str(tmp_path / "other"), progress=False)
    assert not list((tmp_path / "outside").iterdir())


def test_a_name_that_fetch_would_refuse_is_not_published(homes, url, tmp_path):
    (homes / "a\\b.txt").write_text("x")
    with pytest.raises(FileError, match="b.txt' has a character that names of files may not have"):
        stores.publish(str(homes), url, progress=False)
    (homes / "a\\b.txt").unlink()
    stores.publish(str(homes), url, progress=False)
    assert stores.fetch(url, str(tmp_path / "there"), progress=False).files == 3


def test_faults_are_told(homes, tmp_path, capsys):
    with pytest.raises(FileError, match="nothing was published there"):
        stores.fetch(f"file://{tmp_path}/none", str(tmp_path / "there"))
    with pytest.raises(FileError, match="no folder with files"):
        stores.publish(str(tmp_path / "none"), f"file://{tmp_path}/store")
    with pytest.raises(FileError, match="nowhere://"):
        stores.fetch("nowhere://bucket", str(tmp_path / "there"))
    store = tmp_path / "evil"
    store.mkdir()
    for text in ("[]", "{", json.dumps({"files": {"../out": {"size": 1, "sha256": "0"}}}), json.dumps({"files": {"a": {}}})):
        (store / stores.LIST).write_text(text)
        with pytest.raises(FileError, match="not a list that Enfilade wrote"):
            stores.fetch(f"file://{store}", str(tmp_path / "there"))
    assert stores.main(["fetch", f"file://{tmp_path}/none", str(tmp_path / "there")]) == 3
    assert "nothing was published" in capsys.readouterr().err
