"""The letters that a function introduces beside those of its input, chosen in one place."""

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
    """Choose no letter that is among these names either, in this context: those of a larger answer.

    Examples
    --------
    >>> from compensator_theory.polynomials._letters import fresh, reserved
    >>> with reserved(["k"]):
    ...     fresh((), "k", "gain")
    gain
    """
    token = _RESERVED.set(_RESERVED.get().union(names))
    try:
        yield
    finally:
        _RESERVED.reset(token)


def names_in_all(*values: Any) -> set[str]:
    """The names of all symbols in what was read or is shown, those of variables included.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.polynomials._letters import names_in_all
    >>> sorted(names_in_all(transfer_function("1/(s + a)", "s")))
    ['a', 's']
    """
    found: set[str] = set()
    for value in values:
        if isinstance(value, Basic | MatrixBase):
            found |= {symbol.name for symbol in value.free_symbols}
        elif isinstance(value, list | tuple | set | frozenset):
            found |= names_in_all(*value)
        elif is_dataclass(value):
            found |= names_in_all(*(getattr(value, field.name) for field in fields(value)))
    return found


def fresh(taken: Iterable[str], *names: str) -> Symbol:
    """Return the symbol of the first name that is free, or of the last one with underscores.

    Examples
    --------
    >>> from compensator_theory.polynomials._letters import fresh
    >>> fresh({"k"}, "k", "gain"), fresh({"t", "t_"}, "t")
    (gain, t__)
    """
    used = _RESERVED.get().union(taken)
    name = next((name for name in names if name not in used), names[-1])
    while name in used:
        name += "_"
    return Symbol(name)


def numbered(taken: Iterable[str], name: str, last: int, first: int = 1) -> tuple[Symbol, ...]:
    """Return the symbols name_1, name_2, ... of a family, the name longer where one is taken.

    Examples
    --------
    >>> from compensator_theory.polynomials._letters import numbered
    >>> numbered({"a_1"}, "a", 2)
    (a__1, a__2)
    """
    used = _RESERVED.get().union(taken)
    numbers = range(first, last + 1)
    while any(f"{name}_{k}" in used for k in numbers):
        name += "_"
    return tuple(Symbol(f"{name}_{k}") for k in numbers)


def introduced(
    given: str | Symbol | None, taken: Iterable[str], *names: str, meaning: str, owner: str
) -> Symbol:
    """Return the symbol that a function introduces: as named, and else chosen fresh.

    Parameters
    ----------
    given : str, Symbol or None
        What the caller calls it; refused where the input has a symbol of that name.
    taken : iterable of str
        The names in the input.
    *names : str
        What it is called by default, in this order.
    meaning, owner : str
        Both meanings of one name, for the message: "the gain of the loop", "a symbol of the plant".

    Examples
    --------
    >>> from compensator_theory.polynomials._letters import introduced
    >>> introduced(None, {"k"}, "k", "gain", meaning="the gain", owner="a symbol of the plant")
    gain
    """
    if given is None:
        return fresh(taken, *names)
    symbol = as_symbol(given)
    if symbol.name in (used := set(taken)):
        another = fresh(used, *names)
        raise InputError(
            f"{symbol} would be {meaning} and is {owner}; name one of the two otherwise, for "
            f"instance {another}"
        )
    return symbol


def variable_beside(variable: str | Symbol | None, *inputs: Any) -> Symbol:
    """Return the variable of polynomials that belong to matrices with symbols: s, or lambda.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from sympy.abc import s
    >>> from compensator_theory.polynomials._letters import variable_beside
    >>> variable_beside(None, Matrix([[s]])), variable_beside("z", Matrix([[s]]))
    (lambda, z)
    """
    return introduced(
        variable, names_in_all(*inputs), "s", "lambda",
        meaning="the variable of the polynomial", owner="a symbol of the matrices",
    )  # fmt: skip
