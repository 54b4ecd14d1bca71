"""Symbols that a function introduces, distinct from those of its input."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import fields, is_dataclass
from typing import Any

from sympy import Basic, MatrixBase, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._variables import as_symbol

_RESERVED: ContextVar[frozenset[str]] = ContextVar("reserved", default=frozenset())


@contextmanager
def reserved(names: Iterable[str]) -> Iterator[None]:
    """Reserve names in this context: no function introduces a symbol with one of them."""
    token = _RESERVED.set(_RESERVED.get().union(names))
    try:
        yield
    finally:
        _RESERVED.reset(token)


def names_in_all(*values: Any) -> set[str]:
    """The names of all symbols in some objects, variables included."""
    names: set[str] = set()
    for value in values:
        if isinstance(value, Basic | MatrixBase):
            names |= {symbol.name for symbol in value.free_symbols}
        elif isinstance(value, list | tuple | set | frozenset):
            names |= names_in_all(*value)
        elif is_dataclass(value):
            names |= names_in_all(*(getattr(value, field.name) for field in fields(value)))
    return names


def fresh(used_names: Iterable[str], *names: str) -> Symbol:
    """Return the symbol of the first unused name, or of the last one with underscores."""
    used = _RESERVED.get().union(used_names)
    name = next((name for name in names if name not in used), names[-1])
    while name in used:
        name += "_"
    return Symbol(name)


def numbered(used_names: Iterable[str], name: str, last: int, first: int = 1) -> tuple[Symbol, ...]:
    """Return the symbols name_1, name_2, ...; the name gets underscores where one is used."""
    used = _RESERVED.get().union(used_names)
    numbers = range(first, last + 1)
    while any(f"{name}_{k}" in used for k in numbers):
        name += "_"
    return tuple(Symbol(f"{name}_{k}") for k in numbers)


def introduced(
    requested: str | Symbol | None, used_names: Iterable[str], *names: str, meaning: str, owner: str
) -> Symbol:
    """Return the symbol that a function introduces: as named, and else chosen fresh."""
    if requested is None:
        return fresh(used_names, *names)
    symbol = as_symbol(requested)
    if symbol.name in (used := set(used_names)):
        another = fresh(used, *names)
        raise InputError(
            f"{symbol} is {owner} and cannot also be {meaning}; rename one of the two, for "
            f"instance {another}"
        )
    return symbol


def variable_for_matrix(variable: str | Symbol | None, *inputs: Any) -> Symbol:
    """Return the variable of polynomials that belong to matrices with symbols: s, or lambda."""
    return introduced(
        variable, names_in_all(*inputs), "s", "lambda",
        meaning="the variable of the polynomial", owner="a symbol of the matrices",
    )  # fmt: skip
