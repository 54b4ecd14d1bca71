"""Atomic replacement of files, and limits of reading."""

from __future__ import annotations

import os
import secrets
import stat
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from compensator_theory.errors import InputError

if sys.platform != "win32":
    import fcntl

FLAGS = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
MARK = "rcac-"  # mark in the name of a temporary file, so that other hidden files are left alone

MOST_BYTES = 2**28  # of a file that is read: a million steps of thirty signals as float64


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary file that replaces `path` when the block ends without an error.

    Whatever happens in between, a full disk, an exception or a kill, the file that was there
    stays whole. A pipe or a device is written to directly.

    A process that is killed cannot remove its new file, hidden under the name
    ``.STEM.rcac-XXXXXXXX.SUFFIX``. The next one that writes the same file does, if nobody holds
    the lock on it any more, which the system releases when a process ends.
    """
    target = Path(os.path.realpath(path))  # a link stays a link; its target is replaced
    try:
        if target.exists() and not target.is_file():
            yield target
            return
        mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
        _remove_abandoned(target)
        handle, name = _locked(target, 0o666 if mode is None else 0o600)
        try:
            yield Path(name)
            _settle(name, mode)
            os.replace(name, target)
        finally:
            with suppress(OSError):
                os.unlink(name)
            if handle is not None:
                os.close(handle)
    except OSError as error:
        # A reference cycle of the writer may hold a buffer view, and the garbage collector of
        # Python 3.12.1 crashes on it (python/cpython issue 111049).
        traceback.clear_frames(error.__traceback__)
        raise InputError(f"{path} cannot be written: {error.strerror or error}.") from None


def member(folder: str | Path, name: str) -> Path:
    """Return the path of an output file in a folder; links and devices are refused.

    The folder is the caller's, and may be a link. What stands in it may come from others: a link,
    a pipe or a device under such a name is refused, since it would lead out of the folder.
    """
    path = Path(folder)
    if ".." in Path(name).parts or Path(name).is_absolute():
        raise InputError(f"{name} is no file in {folder}; a name in it has no '..'.")
    for part in Path(name).parts[:-1]:
        path /= part
        _require_kind(path, stat.S_ISDIR, "folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path} cannot be made: {error.strerror}.") from None
    path /= Path(name).name
    _require_kind(path, stat.S_ISREG, "file")
    return path


def _require_kind(path: Path, is_kind: Callable[[int], bool], kind: str) -> None:
    with suppress(FileNotFoundError):
        if not is_kind(os.lstat(path).st_mode):
            raise InputError(
                f"{path} is not a regular {kind} and is not written. Remove it, "
                "or give another folder."
            )


def _prefix(target: Path) -> str:
    return f".{target.stem[:40]}.{MARK}"


def _created(target: Path, mode: int) -> tuple[int, str]:
    """Create a temporary file beside `target`; the system applies the umask to `mode`."""
    while True:
        # The suffix stays: writers of figures and arrays choose the format by the suffix.
        name = os.path.abspath(
            target.with_name(f"{_prefix(target)}{secrets.token_hex(4)}{target.suffix}")
        )
        with suppress(FileExistsError):
            return os.open(name, FLAGS, mode), name


def _locked(target: Path, mode: int) -> tuple[int | None, str]:
    """Create a temporary file beside `target` with a lock that ends with the process."""
    while True:
        handle, name = _created(target, mode)
        if sys.platform == "win32":  # Windows cannot rename an open file
            os.close(handle)
            return None, name
        try:
            _lock(handle)
        # Another process removed the file as abandoned before the lock was taken.
        except BlockingIOError:
            os.close(handle)
            continue
        if os.path.exists(name):
            return handle, name
        os.close(handle)


def _lock(handle: int) -> bool:
    """Lock the file and return whether that succeeded; some file systems have no locks."""
    if sys.platform == "win32":
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True


def _remove_abandoned(target: Path) -> None:
    """Remove temporary files of killed processes beside `target`."""
    if sys.platform == "win32":
        return
    prefix = _prefix(target)
    with suppress(OSError), os.scandir(target.parent) as entries:
        for entry in entries:
            random = entry.name.removeprefix(prefix).removesuffix(target.suffix)
            if entry.name != f"{prefix}{random}{target.suffix}" or "." in random:
                continue
            with suppress(OSError):
                handle = os.open(entry.path, os.O_RDWR | os.O_NOFOLLOW)
                try:
                    if _lock(handle):
                        os.unlink(entry.path)
                finally:
                    os.close(handle)


def _settle(name: str, mode: int | None) -> None:
    """Flush the file to disk before the rename, so that one version survives a power loss."""
    if mode is not None:
        os.chmod(name, mode)
    with open(name, "rb") as written:
        os.fsync(written.fileno())


def require_readable(file: Path) -> None:
    """Refuse devices, pipes and files that are too large."""
    try:
        size = file.stat().st_size
    except ValueError as error:  # a null character in the path
        raise InputError(f"{str(file)!r} cannot be read: {error}.") from None
    if not file.is_file():
        raise InputError(f"{file} cannot be read: it is not a regular file.")
    if size == 0:
        raise InputError(f"{file} is empty.")
    if size > MOST_BYTES:
        raise InputError(f"{file} has {size} bytes; at most {MOST_BYTES} are read. Cut it.")
