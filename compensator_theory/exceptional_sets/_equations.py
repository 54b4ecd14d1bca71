"""Polynomial equations in symbols, solved for one symbol after the other, case by case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import sympy
from sympy import Dummy, Expr, Poly, Symbol

from compensator_theory.errors import BudgetError
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._substitution import substituted
from compensator_theory.polynomials._sympy_trees import settled


@dataclass(frozen=True)
class Conditions:
    """The conditions of a case.

    Attributes
    ----------
    values : dict of sympy.Symbol to sympy.Expr
        Symbols that are solved for, by those that stay free.
    nonzero : tuple of sympy.Expr
        Irreducible polynomials in the free symbols that are not zero.
    pending : tuple of sympy.Expr
        Polynomials that are zero, not yet solved.
    unsolved : str
        Reason why the first of `pending` is not solved; empty if not attempted.
    """

    values: dict[Symbol, Expr] = field(default_factory=dict)
    nonzero: tuple[Expr, ...] = ()
    pending: tuple[Expr, ...] = ()
    unsolved: str = ""

    def assuming(self, *nonzero: Expr) -> Conditions:
        """Return the conditions with additional nonzero polynomials."""
        return replace(self, nonzero=tuple(dict.fromkeys((*self.nonzero, *nonzero))))

    def also_zero(self, *polynomials: Expr) -> Conditions:
        """Return the conditions with additional equations to be solved."""
        return replace(self, pending=(*polynomials, *self.pending))

    def with_value(self, symbol: Symbol, value: Expr) -> Conditions | None:
        """Return the conditions with a value substituted for a symbol; None if it violates one."""
        if _contradicts(symbol, value):
            return None
        at = {symbol: value}
        nonzero: list[Expr] = []
        for polynomial in self.nonzero:
            factors = irreducible_factors(substituted(polynomial, at))
            if factors is None:
                return None
            nonzero += factors
        values = {s: substituted(expression, at) for s, expression in self.values.items()} | at
        pending = tuple(substituted(polynomial, at) for polynomial in self.pending)
        if any(_contradicts(s, expression) for s, expression in values.items()):
            return None
        return Conditions(values, tuple(dict.fromkeys(nonzero)), pending)


def irreducible_factors(expression: Expr) -> tuple[Expr, ...] | None:
    """Return the factors of a numerator that may vanish somewhere; None for zero."""
    numerator = sympy.fraction(sympy.cancel(settled(expression)))[0]
    symbols = sorted(numerator.free_symbols, key=lambda s: str(s.name))
    if not symbols:
        constant = Poly(numerator, Dummy(), extension=_is_irrational(numerator) or None)
        return None if constant.is_zero else ()
    poly = Poly(numerator, *symbols, extension=_is_irrational(numerator) or None)
    if poly.is_zero:
        return None
    factors = [factor.as_expr() for factor, _ in poly.factor_list()[1]]
    return tuple(sorted((f for f in factors if not f.is_nonzero), key=_size))


def solutions(conditions: Conditions) -> Iterator[Conditions]:
    r"""Solve the pending equations: disjoint cases with values, or with the reason why not.

    .. math:: c\,x + d = 0: \quad x = -d/c \text{ where } c \ne 0, \quad c = d = 0; \qquad
              p(x) = 0: \quad x \text{ a real root of } p

    The symbols stand for real numbers. An irreducible polynomial that is linear in no symbol and
    has several symbols stays pending, and so does one whose roots span too large a field.
    """
    if not conditions.pending:
        yield conditions
        return
    first, rest = conditions.pending[0], replace(conditions, pending=conditions.pending[1:])
    factors = irreducible_factors(first)
    if factors is None:
        yield from solutions(rest)
        return
    left = [factor for factor in factors if factor not in conditions.nonzero]
    for index, factor in enumerate(left):
        for case in _solved(factor, rest.assuming(*left[:index])):
            if case.unsolved:
                yield case
            else:
                yield from solutions(case)


def _solved(factor: Expr, rest: Conditions) -> Iterator[Conditions]:
    linear = [
        (sympy.diff(factor, symbol), symbol)
        for symbol in factor.free_symbols
        if sympy.degree(factor, symbol) == 1
    ]
    if linear:
        slope, symbol = min(linear, key=lambda pair: (_size(pair[0]), str(pair[1])))
        offset = settled(factor.subs(symbol, 0))
        yield from _linear(symbol, settled(slope), offset, rest)
        return
    if len(factor.free_symbols) > 1:
        reason = "is linear in no symbol, and has several"
        yield replace(rest.also_zero(factor), unsolved=f"{factor} = 0 {reason}")
        return
    (symbol,) = factor.free_symbols
    if _is_irrational(factor):
        reason = "has irrational coefficients and is not linear"
        yield replace(rest.also_zero(factor), unsolved=f"{factor} = 0 {reason}")
        return
    try:
        ask("field_degree", int(sympy.degree(factor, symbol)), f"a root of {factor}")
    except BudgetError as error:
        yield replace(rest.also_zero(factor), unsolved=str(error))
        return
    for root in dict.fromkeys(Poly(factor, symbol).real_roots()):
        solved = rest.with_value(symbol, settled(root))
        if solved is not None:
            yield solved


def _linear(symbol: Symbol, slope: Expr, offset: Expr, rest: Conditions) -> Iterator[Conditions]:
    factors = irreducible_factors(slope) or ()
    solved = rest.assuming(*factors).with_value(symbol, settled(-offset / slope))
    if solved is not None:
        yield solved
    if [factor for factor in factors if factor not in rest.nonzero]:
        yield from solutions(rest.also_zero(slope, offset))


def _contradicts(symbol: Symbol, value: Expr) -> bool:
    """Return whether a value contradicts the assumptions of a symbol."""
    assumptions = (
        (symbol.is_positive, value.is_positive),
        (symbol.is_negative, value.is_negative),
        (symbol.is_nonnegative, value.is_nonnegative),
        (symbol.is_nonpositive, value.is_nonpositive),
        (symbol.is_nonzero, value.is_nonzero),
        (symbol.is_integer, value.is_integer),
        (True, value.is_real if value.is_number else None),
    )
    return any(assumed and has is False for assumed, has in assumptions)


def _is_irrational(expression: Expr) -> bool:
    return any(
        atom.is_number and not atom.is_Rational
        for atom in expression.atoms(sympy.Pow, sympy.polys.rootoftools.ComplexRootOf)
    )


def _size(expression: Expr) -> tuple[int, int, str]:
    return len(expression.free_symbols), int(sympy.count_ops(expression)), str(expression)


def distinct(polynomials: Iterable[Expr], known: Iterable[Expr]) -> tuple[Expr, ...]:
    """Return the irreducible factors of polynomials that are not known to be nonzero."""
    factors = (factor for p in polynomials for factor in irreducible_factors(p) or ())
    return tuple(dict.fromkeys(factor for factor in factors if factor not in set(known)))
