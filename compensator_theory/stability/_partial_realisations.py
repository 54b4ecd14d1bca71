"""Partial realisation: a transfer function of least order with given Markov parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._numbers import NumberLike, read_coefficients
from compensator_theory.polynomials._poly import from_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol
from compensator_theory.systems._transfer_functions import TransferFunction

IDENTITY = "D h = N in the powers of z that the data determine"


@dataclass(frozen=True)
class PartialRealisation(ExactValue):
    """A transfer function of least order with given first Markov parameters.

    Attributes
    ----------
    transfer_function : TransferFunction
        Strictly proper, of that order.
    order : int
        The least one that there is.
    free_parameters : int
        Dimension of the set of all transfer functions of that order with these parameters; 0 if it
        is the only one, which is so if and only if there are at least 2 * order of them.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the order is that for values where none is zero.
    certificate : Certificate
    """

    transfer_function: TransferFunction
    order: int
    free_parameters: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def is_unique(self) -> bool:
        """Whether no other transfer function of this order has these parameters."""
        return not self.free_parameters

    def __str__(self) -> str:
        count = self.free_parameters
        return f"{self.transfer_function}" + (
            f", one of a family of dimension {count}" * bool(count)
        )

    def _repr_latex_(self) -> str:
        return displayed(f"G = {latex(self.transfer_function)}", unless(self.exceptional))


@carrying()
def partial_realisation(
    markov_parameters: Sequence[NumberLike], variable: str | Symbol = "s"
) -> PartialRealisation:
    r"""Find a transfer function of least order with given first Markov parameters.

    .. math:: \frac{N(s)}{D(s)} = \frac{h_1}{s} + \frac{h_2}{s^2} + \cdots + \frac{h_N}{s^N} +
              O(s^{-N-1}), \qquad \sum_{j=0}^{n} D_j\,h_{i+j} = 0 \quad (i = 1, \ldots, N - n)

    Parameters
    ----------
    markov_parameters : sequence of numbers
        :math:`h_1, h_2, \ldots`, at least one, symbols allowed, without the
        feedthrough :math:`h_0`.
    variable : str or Symbol
        s, or z for samples of an impulse response.

    Returns
    -------
    PartialRealisation

    Raises
    ------
    InputError, BudgetError
        If there is no parameter, or there are too many.

    Notes
    -----
    The least n for which the recursion has a solution is found one after the other. Source: R. E.
    Kalman, Acta Polytechnica Scandinavica 31 (1979) 9-32; for fields of any kind it is the
    algorithm of Berlekamp and Massey (1969).

    Examples
    --------
    >>> from compensator_theory.interpolation import partial_realisation
    >>> print(partial_realisation([1, 2, -8, 20]))
    (s + 5)/(s**2 + 3*s + 2)
    >>> print(partial_realisation([1, 2, -8]))
    (s + 2)/(s**2 + 8), one of a family of dimension 1
    """
    s = as_symbol(variable)
    h = read_coefficients(markov_parameters)
    if any(s in c.free_symbols for c in h):
        raise InputError(f"the parameters contain {s}, the variable; name another one")
    count = len(h)
    ask("entries", count**3 // 8, "the partial realisation")
    divisors: list[Expr] = []
    for n in range(count + 1):
        table = ImmutableMatrix(count - n, n + 1, lambda i, j: h[i + j])
        reduced = echelon(table)
        divisors.append(reduced.divided_by)
        if n not in reduced.pivots:  # the last column, of D_n = 1, is a combination of the others
            break
    D = [sympy.Integer(0)] * n + [sympy.Integer(1)]
    for row, pivot in enumerate(reduced.pivots):
        D[pivot] = -reduced.matrix[row, n]
    denominator = from_coefficients(list(reversed(D)), s)
    numerator = from_coefficients(
        [
            sympy.cancel(sum((D[j] * h[j - k - 1] for j in range(k + 1, n + 1)), sympy.Integer(0)))
            for k in range(n - 1, -1, -1)
        ]
        or [0],
        s,
    )
    left = [
        sum((D[j] * h[i + j] for j in range(n + 1)), sympy.Integer(0)) for i in range(count - n)
    ]
    divisors += denominators_of([ImmutableMatrix(1, n + 1, D)])
    return PartialRealisation(
        TransferFunction(numerator, denominator),
        n,
        n - len(reduced.pivots),
        exceptional_factors(divisors),
        certificate_of(IDENTITY, [ImmutableMatrix(1, len(left), left)]),
    )
