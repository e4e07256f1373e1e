"""Folders in object stores: data sets, homes, features and models of a cluster without a shared disk.

    python -m enfilade.stores publish homes s3://bucket/homes
    python -m enfilade.stores fetch s3://bucket/homes homes

Any URL of fsspec works: ``s3://`` (with the package s3fs; AWS_ENDPOINT_URL names another S3-compatible
store), ``gs://``, ``az://``, ``file://``. The file ``enfilade-files.json`` lists the files with sizes and
SHA-256. It is written last, so fetch() finds a whole folder or none, and it checks each file.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Optional

from enfilade._errors import FileError
from enfilade._output import is_name, whole_file

__all__ = ["LIST", "Copied", "fetch", "publish"]

LIST = "enfilade-files.json"
"""The name of the list of files, beside them."""

_BLOCK = 1 << 20
_Entry = Dict[str, Any]


class Copied(NamedTuple):
    """Files copied, and files already present."""

    files: int
    bytes: int
    there: int  #: files that were equal already


def _open_store(url: str) -> tuple[Any, str]:
    try:
        import fsspec  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError:
        raise ImportError("enfilade.stores: pip install fsspec, and for s3:// s3fs") from None
    try:
        store, root = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError) as error:
        raise FileError(f"{url}: {error}") from None
    return store, root.rstrip("/")


def _described(file: Path) -> _Entry:
    digest, size = hashlib.sha256(), 0
    with file.open("rb") as stream:
        while block := stream.read(_BLOCK):
            digest.update(block)
            size += len(block)
    return {"size": size, "sha256": digest.hexdigest()}


def _files_in(folder: Path) -> list[str]:
    return sorted(
        file.relative_to(folder).as_posix()
        for file in folder.rglob("*")
        if file.is_file() and file.name != LIST and not file.name.endswith(".part")
    )


def _read_list(store: Any, root: str, url: str) -> Optional[dict[str, _Entry]]:
    place = f"{root}/{LIST}"
    try:
        if not store.exists(place):
            return None
        listed = json.loads(store.cat_file(place))
        files = listed["files"]
        for name, entry in files.items():
            # The list is untrusted: nothing is written outside the folder.
            if not is_name(name):
                raise ValueError(f"{name!r} is no path below the folder")
            if not isinstance(entry["size"], int) or not isinstance(entry["sha256"], str):
                raise ValueError(f"{name!r} has no size and SHA-256")
        return dict(files)
    except OSError as error:
        raise FileError(f"{url}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileError(f"{url}/{LIST}: not a list that Enfilade wrote: {error}") from None


def _copy_all(
    names: list[str], copy: Callable[[str], None], sizes: dict[str, int], threads: int, progress: bool
) -> None:
    total, done = sum(sizes[name] for name in names), 0
    live = progress and sys.stderr.isatty()
    with ThreadPoolExecutor(threads) as pool:
        running = [(name, pool.submit(copy, name)) for name in names]
        try:
            for name, one in running:
                one.result()
                done += sizes[name]
                if live:
                    print(f"\r{done / 1e6:.0f} of {total / 1e6:.0f} MB\033[K", end="", file=sys.stderr)
        except BaseException:
            for _, one in running:
                one.cancel()
            raise
        finally:
            if live:
                print("\r\033[K", end="", file=sys.stderr)


def publish(folder: str, url: str, *, threads: int = 8, progress: bool = True) -> Copied:
    """Copies a folder into a store. Files that the store's list has with the same bytes are skipped.

    Args:
        folder: all files in it and in its subfolders.
        url: of a folder in a store, with no other writer.
        threads: files copied at the same time.
        progress: show a bar, on a terminal.

    Raises:
        FileError: the folder has no files, or a file cannot be read or written; the list is unchanged.
    """
    root_folder = Path(folder)
    names = _files_in(root_folder)
    if not names:
        raise FileError(f"{folder}: no folder with files")
    for name in names:
        if not is_name(name):  # fetch() would refuse the whole list
            raise FileError(f"{folder}: {name[:40]!r} has a character that names of files may not have")
    store, root = _open_store(url)
    with ThreadPoolExecutor(threads) as pool:
        files = dict(zip(names, pool.map(lambda name: _described(root_folder / name), names)))
    before = _read_list(store, root, url) or {}
    new = [name for name in names if before.get(name) != files[name]]

    def copy(name: str) -> None:
        parent = f"{root}/{name}".rsplit("/", 1)[0]
        store.makedirs(parent, exist_ok=True)
        store.put_file(str(root_folder / name), f"{root}/{name}")

    try:
        _copy_all(new, copy, {name: files[name]["size"] for name in new}, threads, progress)
        text = json.dumps({"files": files}, indent=1, sort_keys=True)
        store.pipe_file(f"{root}/{LIST}", text.encode())
    except OSError as error:
        raise FileError(f"{url}: {error}") from None
    return Copied(len(new), sum(files[name]["size"] for name in new), len(names) - len(new))


def fetch(url: str, folder: str, *, threads: int = 8, progress: bool = True) -> Copied:
    """Copies a published folder from a store. Files with the right bytes are kept, so an interrupted copy
    resumes.

    Args:
        url: the URL of publish().
        folder: made if missing. Files that the store does not have are not changed.
        threads: files copied at the same time.
        progress: show a bar, on a terminal.

    Raises:
        FileError: nothing was published there, or a file cannot be read or written, or its bytes differ
            from the list's; it is then not kept.
    """
    store, root = _open_store(url)
    files = _read_list(store, root, url)
    if files is None:
        raise FileError(f"{url}: nothing was published there: it has no {LIST}")
    to = Path(folder)

    def is_there(name: str) -> bool:
        file, entry = to / name, files[name]
        return file.is_file() and file.stat().st_size == entry["size"] and _described(file) == entry

    with ThreadPoolExecutor(threads) as pool:
        there = dict(zip(files, pool.map(is_there, files)))
    new = [name for name in files if not there[name]]

    def copy(name: str) -> None:
        with whole_file(to, name) as part:
            store.get_file(f"{root}/{name}", str(part))
            if _described(part) != files[name]:
                part.unlink()
                raise FileError(f"{url}/{name}: other bytes than the list has; publish it again")

    try:
        _copy_all(new, copy, {name: files[name]["size"] for name in new}, threads, progress)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{url}: {error}") from None
    return Copied(len(new), sum(files[name]["size"] for name in new), len(files) - len(new))


def main(words: Optional[list[str]] = None) -> int:
    """The command line. Returns its exit code: 0, or 3 for a file or store that cannot be used."""
    parser = argparse.ArgumentParser(
        prog="python -m enfilade.stores",
        description="Copies folders into object stores (publish) and out of them (fetch).",
        epilog="examples:\n  python -m enfilade.stores publish homes s3://bucket/homes\n"
        "  python -m enfilade.stores fetch s3://bucket/homes homes",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("verb", choices=["publish", "fetch"])
    parser.add_argument("source", help="the folder, or the URL to fetch from")
    parser.add_argument("target", help="the URL, or the folder to fetch into")
    parser.add_argument("--threads", type=int, default=8, help="files at a time (default: 8)")
    arguments = parser.parse_args(words)
    if arguments.threads < 1:
        parser.error("--threads: at least 1")
    work = publish if arguments.verb == "publish" else fetch
    try:
        copied = work(arguments.source, arguments.target, threads=arguments.threads)
    except (FileError, ImportError) as error:
        print(f"enfilade.stores: {error}", file=sys.stderr)
        return 3
    print(f"{copied.files} files, {copied.bytes / 1e6:.1f} MB copied; {copied.there} were there")
    return 0


if __name__ == "__main__":
    sys.exit(main())
