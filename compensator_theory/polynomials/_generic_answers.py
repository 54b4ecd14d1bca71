"""Exceptional conditions of functions that return plain values."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias, TypeVar

from sympy import Expr

from compensator_theory.polynomials._poly import monic
from compensator_theory.polynomials._substitution import denominators_in

Generic: TypeAlias = Callable[..., tuple[Any, Iterable[Expr]]]
"""A function with the same arguments that returns the generic answer and its divisors."""

Function = TypeVar("Function", bound=Callable[..., Any])

_GENERIC: dict[Callable[..., Any], Generic] = {}


def generic_answer_of(function: Callable[..., Any]) -> Callable[[Generic], Generic]:
    """Register the generic answer of a function that returns a number, a bool or a polynomial.

    Results that are classes have the attribute `exceptional` instead.
    """

    def register(companion: Generic) -> Generic:
        _GENERIC[function] = companion
        return companion

    return register


def holds_where_defined(function: Function) -> Function:
    """Mark a function whose answer is rational in the symbols and holds wherever it is defined."""

    def companion(*arguments: Any, **options: Any) -> tuple[Any, list[Expr]]:
        answer = function(*arguments, **options)
        return answer, denominators_in(answer)

    _GENERIC[function] = companion
    return function


holds_where_defined(monic)  # which stands below this


def generic_answer(function: Callable[..., Any]) -> Generic | None:
    """Return the registered function, or None."""
    try:
        return _GENERIC.get(function)
    except TypeError:  # a callable object that cannot be hashed
        return None
