"""Discrete-time Riccati equations with one input, solved exactly or in certified balls."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import flint
from sympy import ImmutableMatrix, Matrix, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, latex
from compensator_theory.lqg.regulator_data import (
    EnclosedMatrix,
    RegulatorData,
    approximately,
    ball_matrix,
    enclosed_rows,
    exact_rows,
    regulator_data,
    state_numerators,
)
from compensator_theory.matrices.exact_matrices import MatrixLike
from compensator_theory.matrices.flint_matrices import from_flint, to_flint
from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import as_symbol, require_discrete
from compensator_theory.printing import text
from compensator_theory.roots.enclosures import ball_of_enclosure, ball_of_number
from compensator_theory.roots.reflections import spectrum_of
from compensator_theory.roots.spectral_factors import (
    SpectralFactor,
    factor_palindrome,
)
from compensator_theory.roots.unit_circle_enclosures import working_bits
from compensator_theory.systems.state_space import transfer_matrix_of_realisation

FlintMatrix: TypeAlias = flint.fmpq_mat | flint.arb_mat


@dataclass(frozen=True)
class RiccatiSolution(ExactValue):
    r"""The stabilising solution of a Riccati equation with one input, and its gain.

    .. math::
        P &= A^T P A + R_1 + (A^T P B + R_{12}) K, \\
        K &= -(R_2 + B^T P B)^{-1}(B^T P A + R_{12}^T)

    Attributes
    ----------
    A, B, E_1, E_2 : sympy.ImmutableMatrix
        The data; :math:`R_1 = E_1^TE_1`, :math:`R_{12} = E_1^TE_2`, :math:`R_2 = E_2^TE_2`.
    factor : SpectralFactor
        The closed-loop polynomial :math:`\det(qI - A - BK)`; its constant is
        :math:`R_2 + B^T P B`.
    K, P : sympy.ImmutableMatrix or None
        1 x n and n x n, exact; None if the factor is not rational.
    K_enclosure, P_enclosure : nested tuples of Enclosure
        The same, certified; radii 0 if exact.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> print(solve_riccati([["3/2"]], [[1]], [[1]]))
    K = Matrix([[-3/2]]), P = Matrix([[1]])
    χ = q
    R_2 + B'PB = 1
    """

    A: ImmutableMatrix
    B: ImmutableMatrix
    E_1: ImmutableMatrix
    E_2: ImmutableMatrix
    factor: SpectralFactor
    K: ImmutableMatrix | None
    P: ImmutableMatrix | None
    K_enclosure: EnclosedMatrix
    P_enclosure: EnclosedMatrix

    @property
    def is_exact(self) -> bool:
        """Whether gain and solution are rational."""
        return self.P is not None

    @property
    def residual(self) -> EnclosedMatrix:
        """What is left of the Riccati equation, computed anew; every entry contains 0."""
        if self.P is not None:
            left = self.A.T * self.P
            gain_row = self.B.T * self.P * self.A + self.E_2.T * self.E_1
            innovation = (self.E_2.T * self.E_2 + self.B.T * self.P * self.B)[0]
            exact = left * self.A + self.E_1.T * self.E_1 - gain_row.T * gain_row / innovation
            return exact_rows(exact - self.P)
        finest = max(int(c.centre.q).bit_length() for row in self.P_enclosure for c in row)
        with ball_precision(64 + 2 * finest):
            A, B, E_1, E_2 = map(ball_matrix, (self.A, self.B, self.E_1, self.E_2))
            P = flint.arb_mat([[ball_of_enclosure(c) for c in row] for row in self.P_enclosure])
            gain_row = B.transpose() * P * A + E_2.transpose() * E_1
            innovation = (E_2.transpose() * E_2 + B.transpose() * P * B)[0, 0]
            correction = gain_row.transpose() * gain_row * (1 / innovation)
            return enclosed_rows(A.transpose() * P * A + E_1.transpose() * E_1 - correction - P)

    def __str__(self) -> str:
        K = self.K if self.is_exact else self.K_enclosure
        P = f", P = {text(self.P)}" if self.is_exact else ""
        chi = str(self.factor).split("\n", maxsplit=1)[0]
        return f"K = {text(K)}{P}\n{chi}\nR_2 + B'PB = {self.factor.constant!r}"

    def _repr_latex_(self) -> str:
        innovation = f"R_2 + B^TPB = {latex(self.factor.constant)}"
        if self.is_exact:
            return displayed(f"K = {latex(self.K)}", f"P = {latex(self.P)}", innovation)
        return displayed(rf"K \approx {approximately(self.K_enclosure)}", innovation)


def solve_riccati(
    A: MatrixLike,
    B: MatrixLike,
    E_1: MatrixLike,
    E_2: MatrixLike | None = None,
    *,
    digits: int = 30,
    variable: str | Symbol = "q",
) -> RiccatiSolution:
    r"""Solve the regulator's Riccati equation for one input through its spectral factor.

    .. math:: (R_2 + B^T P B)\,\chi(q)\,\chi(1/q)
              = \sum_i N_i(q) N_i(1/q), \qquad \chi(q) = \det(qI - A - BK)

    where :math:`N_i` are the numerators of :math:`E_1(qI - A)^{-1}B + E_2` over
    :math:`\det(qI - A)`.

    Parameters
    ----------
    A, B, E_1, E_2 : matrix
        n x n, n x 1, l_z x n, l_z x 1, rational; E_2 defaults to zero.
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol
        Of the polynomials, z or q: the equation is for discrete time.

    Returns
    -------
    RiccatiSolution
        The gain solves a linear system for the prescribed polynomial, P a Lyapunov equation.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable, so that the polynomial does not determine the gain.
    UnitCircleError
        If the spectrum vanishes on the unit circle: no solution is stabilising.
    NoSolutionError
        If the input does not reach z.
    InputError
        If there is more than one input, a shape does not fit, or an entry is symbolic.

    Notes
    -----
    Source: (A.6), (A.7) with the cross term. For the estimator give the transposes. "Unique
    positive-semidefinite solution" after (A.12) is true of the stabilising one only: with
    :math:`R_2 = 0` and :math:`E_1B \ne 0`, for instance, :math:`P = E_1^TE_1` is always a
    positive-semidefinite solution.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> found = solve_riccati([[0, 1], ["-1/4", 1]], [[0], [1]], [["-6/5", 1]])
    >>> found.K, found.factor.polynomial.as_expr(), found.factor.constant
    (Matrix([[1/4, -1/6]]), q**2 - 5*q/6, 36/25)
    """
    q = as_symbol(variable)
    require_discrete(q, "this Riccati equation")
    a, b, e_1, e_2 = matrices = regulator_data(A, B, E_1, E_2)
    if b.cols != 1:
        raise InputError(f"B has {b.cols} columns; one input is needed (see lqg_poles for several)")
    n = a.rows
    open_loop, W = state_numerators(a, b, q)
    outputs = transfer_matrix_of_realisation(a, b, e_1, e_2, q)
    palindrome = sum(
        (spectrum_of(outputs[row, 0].numerator, n) for row in range(e_1.rows)), Poly(0, q)
    )
    if palindrome.is_zero:
        raise NoSolutionError("the transfer matrix from u to z is zero, so no gain is the best")
    precision = digits
    working_bits(digits)
    while True:
        factor = factor_palindrome(canonical(palindrome), n, precision)
        if factor.polynomial is not None:
            difference = canonical(open_loop - factor.polynomial)
            right = Matrix([difference.coeff_monomial(q**k) for k in range(n - 1, -1, -1)])
            K, P = _gain_and_cost(to_flint, matrices, W, to_flint(right))
            exact_K, exact_P = from_flint(K), from_flint(P)
            return RiccatiSolution(
                *matrices, factor, exact_K, exact_P, exact_rows(exact_K), exact_rows(exact_P)
            )
        with ball_precision(2 * working_bits(precision)):
            d, chi = open_loop.all_coeffs()[1:], factor.enclosure.coefficients[1:]
            right = [
                [ball_of_number(x) - ball_of_enclosure(y)] for x, y in zip(d, chi, strict=True)
            ]
            K, P = _gain_and_cost(ball_matrix, matrices, W, flint.arb_mat(right))
            rows = enclosed_rows(K), enclosed_rows(P)
        radii = [c.radius for matrix in rows for row in matrix for c in row]
        if max(radii) <= Rational(1, 10**digits):
            return RiccatiSolution(*matrices, factor, None, None, *rows)
        precision *= 2


def _gain_and_cost(
    convert: Callable[[Matrix], FlintMatrix],
    matrices: RegulatorData,
    W: Matrix,
    right: FlintMatrix,
) -> tuple[FlintMatrix, FlintMatrix]:
    """Solve W K' = right and P = A_K' P A_K + E_K' E_K, in rationals or in balls."""
    A, B, E_1, E_2 = map(convert, matrices)
    K = convert(W).solve(right).transpose()
    closed, output = A + B * K, E_1 + E_2 * K
    Q = output.transpose() * output
    n = A.nrows()
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    a = closed.tolist()
    rows = [
        [
            (1 if (i, j) == (k, m) else 0)
            - (a[k][i] * a[m][j] + (a[m][i] * a[k][j] if k != m else 0))
            for k, m in pairs
        ]
        for i, j in pairs
    ]
    column = type(A)([[Q[i, j]] for i, j in pairs])
    found = type(A)(rows).solve(column)
    values = {pair: found[index, 0] for index, pair in enumerate(pairs)}
    return K, type(A)([[values[min(i, j), max(i, j)] for j in range(n)] for i in range(n)])
