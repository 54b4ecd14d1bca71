"""Pade approximants of power series."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.polynomials._budget import ask, integer
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._numbers import NumberLike, read_coefficients
from compensator_theory.polynomials._poly import canonical, from_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol
from compensator_theory.systems._transfer_functions import TransferFunction

IDENTITY = "the coefficients of N - c D up to s^(m + n)"


@dataclass(frozen=True)
class PadeApproximant(ExactValue):
    """A rational function and its order of agreement with a series.

    Attributes
    ----------
    approximant : TransferFunction
        In lowest terms.
    agreement : int
        How many coefficients agree for certain: m + n + 1.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
    """

    approximant: TransferFunction
    agreement: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return str(self.approximant)

    def _repr_latex_(self) -> str:
        s = latex(self.approximant.denominator.gen)
        order = rf"O\left({s}^{{{self.agreement}}}\right)"
        return displayed(f"{latex(self.approximant)} + {order}", unless(self.exceptional))


@refusing
def pade_approximant(
    coefficients: Sequence[NumberLike],
    numerator_degree: int,
    denominator_degree: int,
    *,
    variable: str | Symbol = "s",
) -> PadeApproximant:
    r"""Find the Pade approximant [m/n] of a power series.

    .. math:: c_0 + c_1 s + c_2 s^2 + \cdots = \frac{N(s)}{D(s)} + O(s^{m+n+1}), \qquad
              \deg N \le m, \quad \deg D \le n

    Parameters
    ----------
    coefficients : sequence of numbers
        :math:`c_0, c_1, \ldots`, at least m + n + 1 of them, symbols allowed.
    numerator_degree, denominator_degree : int
        m and n, not negative.
    variable : str or Symbol

    Returns
    -------
    PadeApproximant
        Unique.

    Raises
    ------
    NoSolutionError
        If there is none of this type: only N - c D, and not N/D - c, vanishes so far.
    InputError, BudgetError
        If there are too few coefficients, or a degree is negative or too large.

    Notes
    -----
    D spans the null space of a Toeplitz matrix; common factors are cancelled, and an approximant
    exists if and only if D(0) is not 0 then. Source: H. Pade (1892); G. A. Baker, P. Graves-Morris,
    Pade Approximants (1996), Section 1.4.

    Examples
    --------
    >>> from compensator_theory.interpolation import pade_approximant
    >>> print(pade_approximant([1, -1, "1/2", "-1/6", "1/24"], 2, 2))  # of exp(-s)
    (s**2 - 6*s + 12)/(s**2 + 6*s + 12)
    """
    m, n = (_degree(d) for d in (numerator_degree, denominator_degree))
    s = as_symbol(variable)
    ask("entries", n * (n + 1) + m, "the Pade approximant")
    series = read_coefficients(coefficients)
    if len(series) < m + n + 1:
        raise InputError(
            f"[{m}/{n}] needs {m + n + 1} coefficients c_0 to c_{m + n}, and {len(series)} are "
            "given"
        )
    if any(s in c.free_symbols for c in series):
        raise InputError(f"the coefficients contain {s}, the variable; name another one")
    c = series[: m + n + 1]
    symbols = len(set().union(*(number.free_symbols for number in c)))
    if symbols:  # N has minors of order n + 1 as coefficients
        amount = (m + n + 1) * math.comb(n + 1 + symbols, symbols)
        ask("terms", amount, "the Pade approximant with symbols")
    table = ImmutableMatrix(n, n + 1, lambda i, j: c[m + 1 + i - j] if m + 1 + i >= j else 0)
    reduced = echelon(table)
    kernel = reduced.kernel()
    below = list(kernel[:, 0])
    D = from_coefficients(list(reversed(below)), s)
    N = from_coefficients(_convolved(below, c, m + 1, s)[::-1], s)
    quotient = TransferFunction(N, D).reduced()
    top, bottom = quotient.numerator, quotient.denominator
    above, below = (list(reversed(poly.all_coeffs())) for poly in (top, bottom))
    above += [sympy.S(0)] * (m + n + 1 - len(above))
    expanded = _convolved(below, c, m + n + 1, s)
    left = [sympy.cancel(x - y) for x, y in zip(above, expanded, strict=True)]
    if bottom.eval(0) == 0 or any(left):  # a power of s was cancelled, and the agreement with it
        raise NoSolutionError(
            f"the series has no Pade approximant [{m}/{n}]: N - c D vanishes so far only with "
            f"D = 0 at {s} = 0; request other degrees"
        )
    coefficients_of = ImmutableMatrix(1, 0, [])
    for poly in (top, bottom):
        coefficients_of = coefficients_of.row_join(ImmutableMatrix([poly.all_coeffs()]))
    divisors = [reduced.divided_by, bottom.eval(0), *denominators_of([coefficients_of])]
    return PadeApproximant(
        quotient,
        m + n + 1,
        exceptional_factors(map(sympy.sympify, divisors)),
        certificate_of(IDENTITY, [ImmutableMatrix(1, len(left), left)]),
    )


def _convolved(ascending: list[Expr], series: list[Expr], count: int, s: Symbol) -> list[Expr]:
    """Return the first coefficients of the product of a polynomial and a series."""
    left, right = (from_coefficients(values[::-1], s) for values in (ascending, series))
    coefficients = canonical(left * right).all_coeffs()[::-1][:count]
    return [*coefficients, *[sympy.S(0)] * (count - len(coefficients))]


def _degree(value: int) -> int:
    ask("degree", integer(value, "the degree", at_least=0), "the Pade approximant")
    return value
