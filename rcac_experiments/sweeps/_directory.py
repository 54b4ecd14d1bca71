"""A folder whose files are read and written by their names in it, whole, sealed, through no link.

Every file carries the digest of its own bytes, the digest's own places taken as zeros: so whatever
changed is seen before anything interprets it.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import time
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from rcac_experiments.sweeps._problems import Damaged, StoreError

# So that nothing but what stands there itself is opened, and a pipe does not wait.
NOT_THROUGH = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
BINARY = getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
PART = ".part"  # what the hidden name of a file that is being written ends in
ABANDONED = 3600.0  # seconds after which nobody writes it any more
HAS_HANDLES = {os.open, os.mkdir, os.rename, os.unlink, os.stat} <= os.supports_dir_fd
FULL = (errno.ENOSPC, errno.EFBIG, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC))
# Where a file has its digest; nothing that a user chose comes after it.
MARK, ZEROS = b'"digest": "', b"0" * 32


def sealed(data: bytes) -> bytes:
    """The bytes of a file with their digest in its place."""
    place = data.rindex(MARK + ZEROS) + len(MARK)
    return data[:place] + _digest(data) + data[place + len(ZEROS) :]


def require_sealed(data: bytes) -> None:
    """Refuse bytes without the digest of `sealed`."""
    place = data.rfind(MARK) + len(MARK)
    end = place + len(ZEROS)
    if place < len(MARK) or data[place:end] != _digest(data[:place] + ZEROS + data[end:]):
        raise Damaged("it is not what was written")


def _digest(data: bytes) -> bytes:
    return blake2b(data, digest_size=len(ZEROS) // 2).hexdigest().encode()


def is_part(name: str) -> bool:
    """Whether a file of this name is one that was being written."""
    return name.startswith(".") and name.endswith(PART)


class Directory:
    """A folder by a handle that is open on it; by its path where the system has no such handles."""

    def __init__(self, path: Path, handle: int | None = None) -> None:
        self.path, self.handle = path, handle
        if HAS_HANDLES and handle is None:
            self.handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | BINARY)

    def close(self) -> None:
        """Let go of it."""
        if self.handle is not None:
            os.close(self.handle)
            self.handle = None

    def inside(self, name: str) -> Directory | None:
        """A folder in it; None where there is none, and a link is refused."""
        with suppress(FileNotFoundError):
            if not stat.S_ISDIR(self.about(name).st_mode):
                raise StoreError(
                    f"{self.path / name} is a link, or no folder. Nothing was changed. Remove it "
                    "if the study is from others."
                )
            handle = self._open(name, os.O_RDONLY | os.O_DIRECTORY) if HAS_HANDLES else None
            return Directory(self.path / name, handle)
        return None

    def make(self, name: str) -> None:
        """Create a folder in it, unless the name exists."""
        try:
            with suppress(FileExistsError):
                os.mkdir(self._at(name), dir_fd=self.handle)
        except OSError as error:
            raise self._unwritten(name, error) from None

    def names(self) -> list[str]:
        """Return its entries, hidden names too."""
        return os.listdir(self.path if self.handle is None else self.handle)

    def about(self, name: str) -> os.stat_result:
        """Return the status of the entry itself, not of a link's target."""
        return os.stat(self._at(name), dir_fd=self.handle, follow_symlinks=False)

    def read(self, name: str, at_most: int) -> bytes:
        """A sealed file as it was written; raises FileNotFoundError, or `Damaged`."""
        try:
            with open(self._open(name, os.O_RDONLY), "rb") as file:
                about = os.fstat(file.fileno())
                if not stat.S_ISREG(about.st_mode):
                    raise Damaged("it is not a regular file")
                if about.st_size > at_most:
                    raise Damaged(f"it has {about.st_size} bytes, and at most {at_most} are read")
                data = file.read(about.st_size)
        except FileNotFoundError:
            raise
        except OSError as error:
            raise Damaged(f"it cannot be read ({error.strerror})") from None
        require_sealed(data)
        return data

    def put(self, name: str, data: bytes) -> None:
        """Write a file, sealed, whole or not at all; it is on the disk when this returns."""
        part = f".{name}.{secrets.token_hex(4)}{PART}"
        try:
            with open(self._open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
                file.write(sealed(data))
                file.flush()
                os.fsync(file.fileno())
            if self.handle is None:
                os.replace(self._at(part), self._at(name))
            else:
                os.rename(part, name, src_dir_fd=self.handle, dst_dir_fd=self.handle)
                with suppress(OSError):  # some file systems have none for a folder
                    os.fsync(self.handle)
        except OSError as error:
            raise self._unwritten(name, error) from None
        finally:
            with suppress(OSError):
                os.unlink(self._at(part), dir_fd=self.handle)

    def remove_abandoned(self) -> None:
        """Remove partial files that are older than an hour."""
        for name in filter(is_part, self.names()):
            with suppress(OSError):
                about = self.about(name)
                if stat.S_ISREG(about.st_mode) and time.time() - about.st_mtime > ABANDONED:
                    os.unlink(self._at(name), dir_fd=self.handle)

    def _open(self, name: str, flags: int) -> int:
        return os.open(self._at(name), flags | NOT_THROUGH | BINARY, 0o666, dir_fd=self.handle)

    def _at(self, name: str) -> str:
        return str(self.path / name) if self.handle is None else name

    def _unwritten(self, name: str, error: OSError) -> StoreError:
        path = self.path / name
        if error.errno in FULL:
            return StoreError(
                f"{path} cannot be written: the disk is full or does not answer "
                f"({error.strerror}). What had ended is kept. Make room and give the same command "
                "again."
            )
        if isinstance(error, IsADirectoryError):
            return StoreError(f"{path} is a folder, and a file of the study belongs there.")
        return StoreError(f"{path} cannot be written ({error.strerror}). What had ended is kept.")
