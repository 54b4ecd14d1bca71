"""Kharitonov's theorem: a whole box of polynomials is stable if four of them are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_discrete
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._root_counts import RootCount

PATTERNS = ("lluu", "uull", "luul", "ullu")
"""Lower or upper end of the coefficients of s^0, s^1, s^2, s^3, and so on again."""


@dataclass(frozen=True)
class IntervalStability(ExactValue):
    """Whether every polynomial with coefficients in given intervals is Hurwitz.

    Attributes
    ----------
    intervals : tuple of (Rational, Rational)
        In descending powers.
    polynomials : tuple of sympy.Poly
        Kharitonov's four, all members of the family.
    counts : tuple of RootCount
        Of their roots.
    """

    _ANSWER = "is_stable"

    intervals: tuple[tuple[Rational, Rational], ...]
    polynomials: tuple[Poly, ...]
    counts: tuple[RootCount, ...]

    @property
    def is_stable(self) -> bool:
        """Whether all polynomials of the family are Hurwitz."""
        return all(count.stable == count.total for count in self.counts)

    @property
    def failing(self) -> tuple[Poly, ...]:
        """Those of the four polynomials that are not Hurwitz: they prove the answer."""
        pairs = zip(self.polynomials, self.counts, strict=True)
        return tuple(dict.fromkeys(p for p, count in pairs if count.stable < count.total))

    def __str__(self) -> str:
        if self.is_stable:
            return "every polynomial of the family is Hurwitz"
        return f"not stable: {', '.join(map(format_polynomial, self.failing))}"

    def _repr_latex_(self) -> str:
        if self.is_stable:
            return displayed(words(str(self)))
        return displayed(words("not stable"), *map(latex, self.failing))


@refusing
def decide_interval_stability(
    intervals: Sequence[NumberLike | Sequence[NumberLike]], variable: str | Symbol = "s"
) -> IntervalStability:
    r"""Decide whether all polynomials with coefficients in intervals are Hurwitz.

    .. math:: p = a_n s^n + \cdots + a_0, \quad l_i \le a_i \le u_i; \qquad
              l_0 + l_1 s + u_2 s^2 + u_3 s^3 + l_4 s^4 + \cdots

    and the other three with the patterns u u l l, l u u l and u l l u.

    Parameters
    ----------
    intervals : sequence of numbers and of pairs (lower, upper)
        In descending powers, rational; the first must not contain 0.
    variable : str or Symbol
        s: in discrete time four polynomials do not decide.

    Raises
    ------
    InputError, BudgetError
        If an interval is empty or cannot be read, the degree may drop, or the variable means
        discrete time.

    Notes
    -----
    Source: V. L. Kharitonov, Differential Equations 14 (1979) 1483-1485. The intervals are taken to
    be independent; where they are not, a stable box is sufficient only.

    Examples
    --------
    >>> from compensator_theory import decide_interval_stability
    >>> print(decide_interval_stability([1, (2, 3), (2, 4), (1, 5)]))
    not stable: s**3 + 2*s**2 + 2*s + 5
    >>> decide_interval_stability([1, (3, 4), (4, 5), (1, 5)]).is_stable
    True
    """
    s = as_symbol(variable)
    if is_discrete(s, "the stability of intervals"):
        raise InputError(
            f"{s} means discrete time, for which four polynomials do not decide; write the "
            "variable as s, or call stability_conditions with symbols"
        )
    if isinstance(intervals, str) or not isinstance(intervals, Sequence) or not intervals:
        raise InputError("give a list of numbers and pairs in descending powers, as [1, (2, 3)]")
    ask("degree", len(intervals) - 1, "the family of polynomials")
    read = tuple(_interval(item) for item in intervals)
    lower, upper = read[0]
    if lower <= 0 <= upper:
        raise InputError(
            f"the leading coefficient lies in [{repr_of(lower)}, {repr_of(upper)}], which contains "
            "0: the degree would drop; give it one sign, or decide each degree separately"
        )
    signed = read if lower > 0 else tuple((-high, -low) for low, high in read)
    ascending = list(reversed(signed))
    polynomials = tuple(
        canonical(
            Poly(
                [pair["lu".index(pattern[k % 4])] for k, pair in enumerate(ascending)][::-1],
                s,
                domain=QQ,
            )
        )
        for pattern in PATTERNS
    )
    counts = tuple(count_roots(poly, time="continuous") for poly in polynomials)
    return IntervalStability(read, polynomials, counts)


def _interval(item: NumberLike | Sequence[NumberLike]) -> tuple[Rational, Rational]:
    ends: list[Expr]
    if isinstance(item, tuple | list):
        if len(item) != 2:
            raise InputError(f"{repr_of(item)} is no interval; write (lower, upper)")
        ends = [sympy.sympify(exact_number(end)) for end in item]
    else:
        ends = [sympy.sympify(exact_number(item))] * 2
    if not all(end.is_Rational for end in ends):
        raise InputError(f"the ends {repr_of(ends)} of an interval must be rational numbers")
    if ends[0] > ends[1]:
        raise InputError(
            f"the interval ({repr_of(ends[0])}, {repr_of(ends[1])}) is empty: its ends are "
            "exchanged"
        )
    return ends[0], ends[1]
