"""The errata as they stand in the files, and those of one place."""

from __future__ import annotations

import re
import tomllib
from functools import lru_cache
from importlib import resources
from typing import Annotated

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.dissertation._entries import Erratum
from rcac_experiments.format._places import Location, quoted
from rcac_experiments.format._tables import Raw, Table
from rcac_experiments.format._values import Choice, ListOf

CHAPTERS = ("1", "2", "3", "4", "5", "6", "7", "8", "9", "A", "B")
_NUMBER = re.compile(r"[1-9AB]\.\d+")


@attrs.frozen(eq=False)
class _File:
    """The errata of one chapter."""

    chapter: Annotated[str, Choice(CHAPTERS)]
    erratum: Annotated[list[Erratum], ListOf(Table(Erratum, supplied=["chapter"]), 1)]


_FILE: Table[_File] = Table(_File)


def find_errata(where: str = "") -> tuple[Erratum, ...]:
    """Return the errata at a place of the dissertation, or all.

    Parameters
    ----------
    where : str
        A chapter, ``"8"`` or ``"A"``; an equation, ``"(2.31)"``; ``"Example 7.1"`` or
        ``"Table 5.2"``; the name of an erratum; or a number, ``"7.1"``, for all that bear it.

    Raises
    ------
    InputError
        If that is no place of the dissertation.

    Examples
    --------
    >>> from rcac_experiments.dissertation import find_errata
    >>> [entry.name for entry in find_errata("(2.31)")]
    ['transposed-vec']
    >>> find_errata("(2.1)")
    ()
    """
    every = _every()
    place = " ".join(where.split())
    if not place:
        return every
    if place.upper() in CHAPTERS:
        return tuple(entry for entry in every if entry.chapter == place.upper())
    bare = place.strip("()")
    if _NUMBER.fullmatch(bare):
        return tuple(entry for entry in every if _bears(entry, bare, bare != place))
    matches = tuple(
        entry
        for entry in every
        if entry.name == place or place.lower() in (name.lower() for name in entry.named)
    )
    if matches or re.fullmatch(r"(?i)(example|table|figure|section) [1-9AB][\d.]*", place):
        return matches
    raise InputError(
        f"{quoted(where)} is no place of the dissertation; give a chapter ({', '.join(CHAPTERS)}), "
        'an equation such as "(2.31)", "Example 7.1", or the name of an erratum.'
    )


def read_chapter(table: Raw, file: str) -> tuple[Erratum, ...]:
    """The errata of one file's table."""
    read: _File = _FILE.read(table, Location(file))
    entries = tuple(attrs.evolve(entry, chapter=read.chapter) for entry in read.erratum)
    _require_different(entries, file)
    return entries


@lru_cache(maxsize=1)
def _every() -> tuple[Erratum, ...]:
    folder = resources.files("rcac_experiments.dissertation").joinpath("errata_files")
    entries: list[Erratum] = []
    for chapter in CHAPTERS:
        name = f"{'appendix' if chapter in 'AB' else 'chapter'}_{chapter}.toml"
        if (file := folder.joinpath(name)).is_file():  # Chapter 9 has none
            entries += read_chapter(tomllib.loads(file.read_text("utf-8")), name)
    _require_different(tuple(entries), "the errata")
    return tuple(entries)


def _bears(entry: Erratum, number: str, is_equation: bool) -> bool:
    named = () if is_equation else (name.split()[1] for name in entry.named)
    return number in entry.equations or number in named


def _require_different(entries: tuple[Erratum, ...], file: str) -> None:
    names = [entry.name for entry in entries]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"{file}: two errata are named {quoted(twice)}; give each its own name.")
