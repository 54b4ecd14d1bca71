"""What is wrong with a store, in words that help."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from compensator_theory.errors import InputError


class StoreError(InputError):
    """The store of a study cannot be used: it is damaged, locked, full, or of another study."""


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turn SQLite's errors, and those of text that is none, into ours.

    Whatever went wrong, SQLite has rolled back what was being written: rows that were there stay.
    """
    try:
        yield
    except sqlite3.IntegrityError as error:
        raise StoreError(damaged(path, f"a result was to be stored twice ({error})")) from error
    except sqlite3.OperationalError as error:
        raise StoreError(_of_operation(path, error)) from None
    except (sqlite3.Error, UnicodeError, OverflowError) as error:
        raise StoreError(damaged(path, str(error))) from None


def damaged(path: Path, what: str) -> str:
    """That a file is no longer what was written, and what can be done."""
    return (
        f"{path} is damaged or no store of a study: {what}. Nothing was changed. `rcac store "
        f"check` (check_store) names all that is wrong with it, `rcac store repair` (repair_store) "
        "keeps what is right and lets the rest be run again; or take it from a copy."
    )


def without_study(path: Path, what: str) -> str:
    """That a file cannot say what its runs are, which nothing in it can repair."""
    return (
        f"{path} is damaged or no store of a study: {what}. Nothing was changed. Without its study "
        "nothing in it can be checked or repaired; take it from a copy, or run the study into "
        "another file."
    )


def _of_operation(path: Path, error: sqlite3.OperationalError) -> str:
    name = getattr(error, "sqlite_errorname", "") or ""
    if name == "SQLITE_IOERR_SHORT_READ":
        return damaged(path, str(error))
    if name == "SQLITE_FULL" or name.startswith("SQLITE_IOERR"):
        return (
            f"{path} cannot be written: the disk is full or does not answer ({error}). What had "
            "ended is kept. Make room and give the same command again."
        )
    if name.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
        return f"{path} is in use by another process, and stayed so. Try again when it has ended."
    if name == "SQLITE_READONLY_ROLLBACK":
        return (
            f"{path} was being written with --journal rollback when its process was killed: "
            f"{path.name}-journal is still there. Nothing is lost: give the same `rcac sweep` "
            "again, which puts it in order."
        )
    if name.startswith("SQLITE_READONLY"):
        return f"{path} may not be written ({error})."
    if name.startswith("SQLITE_CANTOPEN"):
        return f"{path} cannot be opened: is there such a folder, and may you write to it?"
    return damaged(path, str(error))
