"""Continuous-time Riccati equations with one input, solved exactly or in certified balls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import flint
from sympy import ImmutableMatrix, Matrix, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, latex
from compensator_theory.lqg.regulator_data import (
    EnclosedMatrix,
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
from compensator_theory.polynomials.variables import as_symbol, is_discrete
from compensator_theory.printing import text
from compensator_theory.roots.enclosures import ball_of_enclosure, ball_of_number
from compensator_theory.roots.half_plane_factors import HalfPlaneFactor, factor_even
from compensator_theory.roots.reflections import even_spectrum
from compensator_theory.roots.unit_circle_enclosures import working_bits
from compensator_theory.systems.state_space import transfer_matrix_of_realisation

FlintMatrix: TypeAlias = flint.fmpq_mat | flint.arb_mat


@dataclass(frozen=True)
class ContinuousRiccatiSolution(ExactValue):
    r"""The stabilising solution of a continuous-time Riccati equation, and its gain.

    .. math::
        0 &= A^T P + P A + R_1 + (P B + R_{12}) K, \qquad
        K = -R_2^{-1}(B^T P + R_{12}^T)

    Attributes
    ----------
    A, B, E_1, E_2 : sympy.ImmutableMatrix
        The data; :math:`R_1 = E_1^TE_1`, :math:`R_{12} = E_1^TE_2`, :math:`R_2 = E_2^TE_2`.
    factor : HalfPlaneFactor
        The closed-loop polynomial :math:`\det(sI - A - BK)`; its constant is :math:`R_2`.
    K, P : sympy.ImmutableMatrix or None
        1 x n and n x n, exact; None if the factor is not rational.
    K_enclosure, P_enclosure : nested tuples of Enclosure
        The same, certified; radii 0 if exact.

    Examples
    --------
    >>> from compensator_theory import solve_continuous_riccati
    >>> print(solve_continuous_riccati([[0]], [[1]], [[2], [0]], [[0], [1]]))
    K = Matrix([[-2]]), P = Matrix([[2]])
    χ = s + 2
    """

    A: ImmutableMatrix
    B: ImmutableMatrix
    E_1: ImmutableMatrix
    E_2: ImmutableMatrix
    factor: HalfPlaneFactor
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
        matrices = (self.A, self.B, self.E_1, self.E_2)
        if self.P is not None:
            return exact_rows(
                from_flint(_residual([to_flint(m) for m in matrices], to_flint(self.P)))
            )
        finest = max(int(c.centre.q).bit_length() for row in self.P_enclosure for c in row)
        with ball_precision(64 + 2 * finest):
            P = flint.arb_mat([[ball_of_enclosure(c) for c in row] for row in self.P_enclosure])
            return enclosed_rows(_residual([ball_matrix(m) for m in matrices], P))

    def __str__(self) -> str:
        K = self.K if self.is_exact else self.K_enclosure
        P = f", P = {text(self.P)}" if self.is_exact else ""
        return f"K = {text(K)}{P}\n" + str(self.factor).split("\n", maxsplit=1)[0]

    def _repr_latex_(self) -> str:
        if self.is_exact:
            return displayed(f"K = {latex(self.K)}", f"P = {latex(self.P)}")
        return displayed(rf"K \approx {approximately(self.K_enclosure)}")


def solve_continuous_riccati(
    A: MatrixLike,
    B: MatrixLike,
    E_1: MatrixLike,
    E_2: MatrixLike,
    *,
    digits: int = 30,
    variable: str | Symbol = "s",
) -> ContinuousRiccatiSolution:
    r"""Solve the regulator's Riccati equation in continuous time through its spectral factor.

    .. math:: R_2\,\chi(s)\,\chi(-s) = \sum_i N_i(s) N_i(-s), \qquad \chi(s) = \det(sI - A - BK)

    where :math:`N_i` are the numerators of :math:`E_1(sI - A)^{-1}B + E_2` over
    :math:`\det(sI - A)`.

    Parameters
    ----------
    A, B, E_1, E_2 : matrix
        n x n, n x 1, l_z x n, l_z x 1, rational, E_2 not zero: z = E_1 x + E_2 u.
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol
        Of the polynomials, s: the equation is for continuous time.

    Returns
    -------
    ContinuousRiccatiSolution
        The gain solves a linear system for the prescribed polynomial, P a Lyapunov equation.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable, so that the polynomial does not determine the gain.
    NoSolutionError
        If E_2 = 0, so that the best gain is infinite (see :func:`regulator_locus`), or the spectrum
        vanishes on the imaginary axis: no solution is stabilising.
    InputError
        If there is more than one input, a shape does not fit, an entry is symbolic, or the
        variable means discrete time.

    Notes
    -----
    The counterpart of (A.6), (A.7) in continuous time, with the cross term. For the estimator give
    the transposes.

    Examples
    --------
    >>> from compensator_theory import solve_continuous_riccati
    >>> found = solve_continuous_riccati([[0, 1], [0, 0]], [[0], [1]], [[2, 0], [0, 0]], [[0], [1]])
    >>> found.K, found.factor.polynomial.as_expr(), found.P
    (Matrix([[-2, -2]]), s**2 + 2*s + 2, Matrix([
    [4, 2],
    [2, 2]]))
    """
    s = as_symbol(variable)
    if is_discrete(s, "this Riccati equation"):
        raise InputError(f"{s} means discrete time; use solve_riccati, or write the variable as s")
    a, b, e_1, e_2 = matrices = regulator_data(A, B, E_1, E_2)
    if b.cols != 1:
        raise InputError(f"B has {b.cols} columns; one input is needed")
    if e_2.is_zero_matrix:
        raise NoSolutionError(
            "E_2 = 0: u costs nothing, and in continuous time the best gain is then infinite; "
            "give u a weight, or see regulator_locus for the limits of the poles"
        )
    n = a.rows
    open_loop, W = state_numerators(a, b, s)
    outputs = transfer_matrix_of_realisation(a, b, e_1, e_2, s)
    spectrum = sum((even_spectrum(outputs[i, 0].numerator) for i in range(e_1.rows)), Poly(0, s))
    precision = digits
    while True:
        factor = factor_even(canonical(spectrum), precision)
        if factor.polynomial is not None:
            difference = canonical(open_loop - factor.polynomial)
            right = Matrix([difference.coeff_monomial(s**k) for k in range(n - 1, -1, -1)])
            found = _gain_and_cost([to_flint(m) for m in matrices], *map(to_flint, (W, right)))
            K, P = map(from_flint, found)
            return ContinuousRiccatiSolution(
                *matrices, factor, K, P, exact_rows(K), exact_rows(P)
            )  # fmt: skip
        with ball_precision(2 * working_bits(precision)):
            pairs = zip(open_loop.all_coeffs()[1:], factor.enclosure.coefficients[1:], strict=True)
            column = flint.arb_mat([[ball_of_number(x) - ball_of_enclosure(y)] for x, y in pairs])
            found = _gain_and_cost([ball_matrix(m) for m in matrices], ball_matrix(W), column)
            rows = enclosed_rows(found[0]), enclosed_rows(found[1])
        radii = [c.radius for matrix in rows for row in matrix for c in row]
        if max(radii) <= Rational(1, 10**digits):
            return ContinuousRiccatiSolution(*matrices, factor, None, None, *rows)
        precision *= 2


def _gain_and_cost(
    matrices: Sequence[FlintMatrix], W: FlintMatrix, right: FlintMatrix
) -> tuple[FlintMatrix, FlintMatrix]:
    """Solve W K' = right and A_K' P + P A_K + E_K' E_K = 0, in rationals or in balls."""
    A, B, E_1, E_2 = matrices
    K = W.solve(right).transpose()
    closed, output = A + B * K, E_1 + E_2 * K
    Q, n, a = output.transpose() * output, A.nrows(), closed.tolist()
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    index = {pair: k for k, pair in enumerate(pairs)}
    rows = [[0] * len(pairs) for _ in pairs]
    for row, (i, j) in zip(rows, pairs, strict=True):
        for k in range(n):
            row[index[min(k, j), max(k, j)]] += a[k][i]
            row[index[min(i, k), max(i, k)]] += a[k][j]
    found = type(A)(rows).solve(type(A)([[-Q[i, j]] for i, j in pairs]))
    P = [[found[index[min(i, j), max(i, j)], 0] for j in range(n)] for i in range(n)]
    return K, type(A)(P)


def _residual(matrices: Sequence[FlintMatrix], P: FlintMatrix) -> FlintMatrix:
    A, B, E_1, E_2 = matrices
    row = B.transpose() * P + E_2.transpose() * E_1
    weight = (E_2.transpose() * E_2)[0, 0]
    correction = row.transpose() * row * (1 / weight)
    return A.transpose() * P + P * A + E_1.transpose() * E_1 - correction
