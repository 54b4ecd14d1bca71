"""The transition matrix of a linear system: exp(A t), or the powers of A."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb, prod
from typing import ClassVar

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import (
    identity_matrix,
    is_rational_matrix,
    to_flint,
    zero_matrix,
)
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._letters import names_in_all
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import ask_for_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_discrete
from compensator_theory.responses._time_responses import TimeResponse, inverse_transform
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from compensator_theory.systems._transfer_functions import TransferFunction


@dataclass(frozen=True)
class TransitionMatrix(Certified, ExactValue):
    r"""The solution of the state equation without input, as a closed form.

    .. math:: x(t) = e^{At} x(0), \quad e^{At} = \mathcal L^{-1}(sI - A)^{-1}, \qquad
              x(k) = A^k x(0), \quad A^k = \mathcal Z^{-1} z(zI - A)^{-1}

    Attributes
    ----------
    A : sympy.ImmutableMatrix
        n x n.
    responses : tuple of tuples of TimeResponse
        n x n; column j is the response to the j-th unit vector as initial state.

    Examples
    --------
    >>> from compensator_theory import transition_matrix
    >>> E = transition_matrix([[0, 1], [-2, -3]])
    >>> E.expression[0, 1], E.is_verified
    (exp(-t) - exp(-2*t), True)
    """

    identity: ClassVar[str] = "(sI - A) times the transform of the matrix = I"

    A: ImmutableMatrix
    responses: tuple[tuple[TimeResponse, ...], ...]

    @property
    def variable(self) -> Symbol:
        """Variable of the transforms."""
        return self.responses[0][0].variable

    @property
    def time(self) -> Symbol:
        """The symbol t, or k in discrete time."""
        return self.responses[0][0].time

    @cached_property
    def expression(self) -> ImmutableMatrix:
        """The matrix in t or k."""
        return ImmutableMatrix([[y.expression for y in row] for row in self.responses])

    @property
    def transform(self) -> ImmutableMatrix:
        """The transform of the matrix, from the modes of its entries."""
        return ImmutableMatrix([[_transform(y) for y in row] for row in self.responses])

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Polynomials in the symbols at whose zeros eigenvalues meet."""
        return exceptional_factors(
            [e for row in self.responses for y in row for e in y.exceptional]
        )

    def __call__(self, time: NumberLike) -> ImmutableMatrix:
        """Return the exact matrix at a time in seconds, or at a step."""
        return ImmutableMatrix([[y(time) for y in row] for row in self.responses])

    def _residuals(self) -> Residuals:
        s, n = self.variable, self.A.rows
        if is_rational_matrix(self.A):
            return [p for j in range(n) for p in self._rational_residuals(j)]
        factor = s if self.responses[0][0].is_discrete else sympy.Integer(1)
        Phi = self.transform
        return [(s * Phi - self.A * Phi - factor * ImmutableMatrix.eye(n))]

    def _rational_residuals(self, j: int) -> list[Poly]:
        """The residuals of column j, over one denominator, without expressions."""
        column = [_quotient(row[j]) for row in self.responses]
        common = flint.fmpq_poly([1])
        for _, bottom in column:
            if common % bottom:
                common *= bottom // common.gcd(bottom)
        tops = [top * (common // bottom) for top, bottom in column]
        right = common * flint.fmpq_poly([0, 1]) if self.responses[0][0].is_discrete else common
        A, residuals = to_flint(self.A), []
        for i, top in enumerate(tops):
            rest = top * flint.fmpq_poly([0, 1])
            for k, other in enumerate(tops):
                rest -= other * A[i, k]
            residuals.append(rest - right if i == j else rest)
        return [from_flint_polynomial(rest, self.variable) for rest in residuals]

    def __str__(self) -> str:
        name = f"A**{self.time}" if self.responses[0][0].is_discrete else f"exp(A*{self.time})"
        return f"{name} = {text(self.expression.tolist())}"

    def _repr_latex_(self) -> str:
        name = f"A^{{{self.time}}}" if self.responses[0][0].is_discrete else f"e^{{A {self.time}}}"
        return displayed(f"{name} = {latex(self.expression)}")


@carrying()
def transition_matrix(A: MatrixLike, variable: str | Symbol = "s") -> TransitionMatrix:
    r"""Return exp(A t), or A^k in discrete time, as a matrix of closed forms.

    Parameters
    ----------
    A : matrix
        n x n, with numbers and symbols.
    variable : str or Symbol
        s for exp(A t); z or q for A^k.

    Raises
    ------
    InputError
        If A is not square, or is empty.

    Notes
    -----
    Each entry of the resolvent is expanded in partial fractions; eigenvalues of degree three or
    more stay sums over the roots of their polynomial. The certificate transforms back. For values
    at multiples of a sample time with the exponentials as symbols see
    :func:`compensator_theory.sampling.zero_order_hold`.

    Examples
    --------
    >>> from compensator_theory import transition_matrix
    >>> print(transition_matrix([[0, 1], [0, 0]]))
    exp(A*t) = [[1, t], [0, 1]]
    >>> print(transition_matrix([["a", 1], [0, "a"]], "z"))
    A**k = [[a**k, a**k*k/a], [0, a**k]]
    """
    A = exact_matrix(A, "A")
    n = A.rows
    if n != A.cols or n == 0:
        raise InputError(f"A is {A.rows} x {A.cols}; a transition matrix needs a square A")
    symbol = as_symbol(variable)
    discrete = is_discrete(symbol, "the transition matrix")
    if symbol.name in names_in_all(A):
        raise InputError(f"{symbol} is an entry of A; name the variable otherwise, s, z or q")
    unit = identity_matrix(n)
    resolvent = transfer_matrix_of_realisation(A, unit, unit, zero_matrix(n, n), symbol)
    ask_for_coefficients(resolvent.denominator, n, "the transition matrix", 1)
    _ask_for_terms(resolvent.denominator)
    factor = Poly(symbol if discrete else 1, symbol, domain="QQ")
    return TransitionMatrix(
        A,
        tuple(
            tuple(
                inverse_transform(TransferFunction(top * factor, resolvent.denominator))
                for top in row
            )
            for row in resolvent.numerators
        ),
    )


def _ask_for_terms(denominator: Poly) -> None:
    """Refuse partial fractions over discriminants with too many terms, one for each entry."""
    for factor, _ in denominator.factor_list()[1]:
        symbols = factor.free_symbols_in_domain
        if not symbols or factor.degree() < 2:
            continue
        powers = 2 * int(factor.degree()) - 2  # of a coefficient, in the discriminant
        flat = factor.clear_denoms(convert=True)[1].inject()
        degree = powers * max(sum(monomial[1:]) for monomial in flat.monoms())
        box = prod(powers * int(d) + 1 for d in flat.degree_list()[1:])
        terms = min(box, comb(degree + len(symbols), degree))
        ask("terms", int(denominator.degree()) ** 2 * terms, "the transition matrix with symbols")


def _quotient(response: TimeResponse) -> tuple[flint.fmpq_poly, flint.fmpq_poly]:
    """The transform of a rational response, from its modes."""
    top, bottom = to_flint_polynomial(response.impulses), flint.fmpq_poly([1])
    for mode in response.terms:
        above, below = map(to_flint_polynomial, mode.transform)
        if response.is_discrete:
            above *= flint.fmpq_poly([0, 1])
        top, bottom = top * below + above * bottom, bottom * below
    return top, bottom


def _transform(response: TimeResponse) -> Expr:
    """The transform of a response, from its modes."""
    factor = response.variable if response.is_discrete else sympy.Integer(1)
    total = response.impulses.as_expr()
    for mode in response.terms:
        top, bottom = mode.transform
        total += factor * top.as_expr() / bottom.as_expr()
    return total
