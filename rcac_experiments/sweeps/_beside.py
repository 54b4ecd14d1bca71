"""What lies beside the file of a study, looked at before SQLite acts on it."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

from rcac_experiments.sweeps._problems import StoreError, without_study

# Of open, so that nothing but what stands there itself is opened, and a pipe does not wait.
NOT_THROUGH = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
JOURNAL = "-journal"
SIDECARS = (JOURNAL, "-wal", "-shm")  # that SQLite reads, writes and removes by itself
DAMAGED = (".damaged", ".damaged-wal")  # that a repair makes
# What a rollback journal ends with where it belongs to a transaction over several databases, whose
# own journal it names. SQLite removes the file of that name. A study is one file.
SUPER_JOURNAL = bytes.fromhex("d9d505f920a163d7")
HEADER = b"SQLite format 3\0"


@dataclass(frozen=True)
class Header:
    """Whose file it is by its first bytes, 0 where they do not say; None for an empty one."""

    application: int | None = None


def require_ours(path: Path) -> int | None:
    """Refuse what lies beside a store and was not put there by SQLite for it.

    How many pages there were before a transaction that was interrupted, whose rollback journal is
    still there; None where there is none.
    """
    real = Path(os.path.realpath(path))
    pages = None
    for end in SIDECARS:
        beside = real.with_name(real.name + end)
        found = _opened(beside)
        if found is None:
            continue
        try:
            about = os.fstat(found)
            if not stat.S_ISREG(about.st_mode) or about.st_nlink > 1:
                raise StoreError(_leads_elsewhere(path, beside))
            if end == JOURNAL and about.st_size:
                pages = int.from_bytes(os.read(found, 28)[16:20], "big")
                os.lseek(found, max(about.st_size - len(SUPER_JOURNAL), 0), os.SEEK_SET)
                if os.read(found, len(SUPER_JOURNAL)) == SUPER_JOURNAL:
                    raise StoreError(_leads_elsewhere(path, beside))
        finally:
            os.close(found)
    return pages


def header_of(path: Path) -> Header | None:
    """What a file is by its first bytes; None where there is none; no store is refused."""
    try:
        if not path.is_file() and os.path.lexists(os.path.realpath(path)):
            raise StoreError(f"{path} is no store of a study: it is no ordinary file.")
        with path.open("rb") as file:
            head = file.read(100)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror}.") from None
    except ValueError as error:  # a null character in the path
        raise StoreError(f"{str(path)!r} cannot be read: {error}.") from None
    if not head:
        return Header()
    if not head.startswith(HEADER) and b"\0" in head:
        raise StoreError(without_study(path, "it does not begin as an SQLite file"))
    if not head.startswith(HEADER):
        raise StoreError(
            f"{path} is no store of a study: it is a text, and a store an SQLite file. Nothing was "
            "changed. `rcac sweep` makes stores; `rcac verify` runs the .toml of an experiment."
        )
    return Header(int.from_bytes(head[68:72], "big"))


def _opened(beside: Path) -> int | None:
    """A handle on what stands there itself, links not followed."""
    try:
        return os.open(beside, os.O_RDONLY | NOT_THROUGH)
    except FileNotFoundError:
        return None
    except OSError as error:  # a link, or what may not be read
        raise StoreError(
            f"{beside} cannot be looked at ({error.strerror}). SQLite would act on it; it is a "
            "link, or not yours. Nothing was changed. Remove it if the store is from others."
        ) from None


def _leads_elsewhere(path: Path, beside: Path) -> str:
    return (
        f"{beside} was not made for {path}: it names or is another file, and SQLite would remove "
        "or write that. Nothing was changed. Remove it, and do not trust where it came from."
    )
