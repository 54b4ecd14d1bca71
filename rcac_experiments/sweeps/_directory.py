"""A folder whose members are read and written by their names in it, through no link."""

from __future__ import annotations

import errno
import os
import secrets
import stat
import time
from contextlib import suppress
from pathlib import Path

from rcac_experiments.sweeps._problems import StoreError

# So that nothing but what stands there itself is opened, and a pipe does not wait.
NOT_THROUGH = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
BINARY = getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
PART = ".part"  # what the hidden name of a file that is being written ends in
ABANDONED = 3600.0  # seconds after which nobody writes it any more
HAS_HANDLES = {os.open, os.link, os.mkdir, os.rename, os.unlink, os.stat} <= os.supports_dir_fd
FULL = (errno.ENOSPC, errno.EFBIG, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC))
NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK)


class NotOurs(Exception):
    """What stands there is no file that was written here; why."""


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
        """Make a folder in it, unless something is there."""
        try:
            os.mkdir(self._at(name), dir_fd=self.handle)
        except FileExistsError:
            return
        except OSError as error:
            raise self._unwritten(name, error) from None

    def names(self) -> list[str]:
        """What is in it, hidden names too."""
        return os.listdir(self.path if self.handle is None else self.handle)

    def about(self, name: str) -> os.stat_result:
        """What stands there itself."""
        return os.stat(self._at(name), dir_fd=self.handle, follow_symlinks=False)

    def read(self, name: str, at_most: int) -> bytes:
        """An ordinary file; raises FileNotFoundError, or `NotOurs` for what is none."""
        handle = None
        try:
            handle = self._open(name, os.O_RDONLY)
            about = os.fstat(handle)
            if not stat.S_ISREG(about.st_mode):
                raise NotOurs("it is no ordinary file")
            if about.st_size > at_most:
                raise NotOurs(f"it has {about.st_size} bytes, and at most {at_most} are read")
            with open(handle, "rb", closefd=False) as file:
                return file.read(about.st_size)
        except FileNotFoundError:
            raise
        except OSError as error:
            raise NotOurs(f"it cannot be read ({error.strerror})") from None
        finally:
            if handle is not None:
                os.close(handle)

    def put(self, name: str, data: bytes, *, new: bool = False) -> bool:
        """Write a file, whole or not at all; `new` leaves one that is there, and returns False.

        Both the file and its name are on the disk when this returns.
        """
        part = f".{name}.{secrets.token_hex(4)}{PART}"
        try:
            with open(self._open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            if not new or not self._link(part, name):
                if new and self._is_there(name):
                    return False
                self._rename(part, name)
            if self.handle is not None:
                with suppress(OSError):  # some file systems have none for a folder
                    os.fsync(self.handle)
        except OSError as error:
            raise self._unwritten(name, error) from None
        finally:
            with suppress(OSError):
                os.unlink(self._at(part), dir_fd=self.handle)
        return True

    def remove_abandoned(self) -> None:
        """Remove what a process that was killed an hour ago or more was writing."""
        for name in self.names():
            if name.startswith(".") and name.endswith(PART):
                with suppress(OSError):
                    about = self.about(name)
                    if stat.S_ISREG(about.st_mode) and time.time() - about.st_mtime > ABANDONED:
                        os.unlink(self._at(name), dir_fd=self.handle)

    def _open(self, name: str, flags: int) -> int:
        return os.open(self._at(name), flags | NOT_THROUGH | BINARY, 0o666, dir_fd=self.handle)

    def _at(self, name: str) -> str:
        return str(self.path / name) if self.handle is None else name

    def _is_there(self, name: str) -> bool:
        with suppress(FileNotFoundError):
            self.about(name)
            return True
        return False

    def _rename(self, part: str, name: str) -> None:
        """In one step, whatever ordinary file or link had the name."""
        if self.handle is None:
            os.replace(self._at(part), self._at(name))
        else:
            os.rename(part, name, src_dir_fd=self.handle, dst_dir_fd=self.handle)

    def _link(self, part: str, name: str) -> bool:
        """Give it a name that nothing has; False where something has it, or there are no links."""
        here = self.handle
        try:
            os.link(self._at(part), self._at(name), src_dir_fd=here, dst_dir_fd=here)
        except FileExistsError:
            return False
        except OSError as error:
            if error.errno not in NO_LINKS:
                raise
            return False
        return True

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
