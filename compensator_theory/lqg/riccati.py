"""Riccati equations with one input in both time domains, solved exactly or in certified balls."""

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
from compensator_theory.polynomials.variables import Time, variable_in
from compensator_theory.printing import text
from compensator_theory.roots.enclosures import ball_of_enclosure, ball_of_number
from compensator_theory.roots.reflections import spectrum_of
from compensator_theory.roots.spectral_factors import SpectralFactor, factor_spectrum
from compensator_theory.roots.unit_circle_enclosures import working_bits
from compensator_theory.systems.state_space import transfer_matrix_of_realisation

FlintMatrix: TypeAlias = flint.fmpq_mat | flint.arb_mat


@dataclass(frozen=True)
class RiccatiSolution(ExactValue):
    r"""The stabilising solution of a Riccati equation with one input, and its gain.

    .. math::
        \text{discrete:} \quad P &= A^T P A + R_1 + (A^T P B + R_{12}) K, &
        K &= -(R_2 + B^T P B)^{-1}(B^T P A + R_{12}^T) \\
        \text{continuous:} \quad 0 &= A^T P + P A + R_1 + (P B + R_{12}) K, &
        K &= -R_2^{-1}(B^T P + R_{12}^T)

    Attributes
    ----------
    A, B, E_1, E_2 : sympy.ImmutableMatrix
        The data; :math:`R_1 = E_1^TE_1`, :math:`R_{12} = E_1^TE_2`, :math:`R_2 = E_2^TE_2`.
    factor : SpectralFactor
        The closed-loop polynomial :math:`\det(sI - A - BK)`; its constant is :math:`R_2`, in
        discrete time :math:`R_2 + B^T P B`.
    K, P : sympy.ImmutableMatrix or None
        1 x n and n x n, exact; None if the factor is not rational.
    K_enclosure, P_enclosure : nested tuples of Enclosure
        The same, certified; radii 0 if exact.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> print(solve_riccati([["3/2"]], [[1]], [[1]], time="discrete"))
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
        time, matrices = self.factor.time, (self.A, self.B, self.E_1, self.E_2)
        if self.P is not None:
            exact = _residual([to_flint(m) for m in matrices], to_flint(self.P), time)
            return exact_rows(from_flint(exact))
        finest = max(int(c.centre.q).bit_length() for row in self.P_enclosure for c in row)
        with ball_precision(64 + 2 * finest):
            P = flint.arb_mat([[ball_of_enclosure(c) for c in row] for row in self.P_enclosure])
            return enclosed_rows(_residual([ball_matrix(m) for m in matrices], P, time))

    @property
    def _weight(self) -> str:
        """What the constant of the factor is."""
        return "R_2 + B'PB" if self.factor.time == "discrete" else "R_2"

    def __str__(self) -> str:
        K = self.K if self.is_exact else self.K_enclosure
        P = f", P = {text(self.P)}" if self.is_exact else ""
        chi = str(self.factor).split("\n", maxsplit=1)[0]
        return f"K = {text(K)}{P}\n{chi}\n{self._weight} = {self.factor.constant!r}"

    def _repr_latex_(self) -> str:
        weight = f"{self._weight.replace(chr(39), '^T')} = {latex(self.factor.constant)}"
        if self.is_exact:
            return displayed(f"K = {latex(self.K)}", f"P = {latex(self.P)}", weight)
        return displayed(rf"K \approx {approximately(self.K_enclosure)}", weight)


def solve_riccati(
    A: MatrixLike,
    B: MatrixLike,
    E_1: MatrixLike,
    E_2: MatrixLike | None = None,
    *,
    time: Time,
    digits: int = 30,
    variable: str | Symbol | None = None,
) -> RiccatiSolution:
    r"""Solve the regulator's Riccati equation through its spectral factor.

    .. math:: c\,\chi\,\chi^* = \sum_i N_i N_i^*, \qquad \chi(s) = \det(sI - A - BK)

    where :math:`N_i` are the numerators of :math:`E_1(sI - A)^{-1}B + E_2` over
    :math:`\det(sI - A)`, and the star is that of :func:`spectral_factor`.

    Parameters
    ----------
    A, B, E_1, E_2 : matrix
        n x n, n x 1, l_z x n, l_z x 1, rational: z = E_1 x + E_2 u. E_2 defaults to zero, which
        continuous time does not allow.
    time : {"continuous", "discrete"}
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Of the polynomials. Default: s in continuous, q in discrete time.

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
        If the input does not reach z, the spectrum vanishes on the imaginary axis, or in continuous
        time E_2 = 0, so that the best gain is infinite (see :func:`regulator_locus`).
    InputError
        If there is more than one input, a shape does not fit, an entry is symbolic, or the
        variable stands for the other time domain.

    Notes
    -----
    Source: (A.6), (A.7) with the cross term, and their counterpart in continuous time. For the
    estimator give the transposes. "Unique positive-semidefinite solution" after (A.12) is true of
    the stabilising one only: with :math:`R_2 = 0` and :math:`E_1B \ne 0`, for instance,
    :math:`P = E_1^TE_1` is always a positive-semidefinite solution.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> found = solve_riccati([[0, 1], ["-1/4", 1]], [[0], [1]], [["-6/5", 1]], time="discrete")
    >>> found.K, found.factor.polynomial.as_expr(), found.factor.constant
    (Matrix([[1/4, -1/6]]), q**2 - 5*q/6, 36/25)
    >>> E_1, E_2 = [[2, 0], [0, 0]], [[0], [1]]
    >>> found = solve_riccati([[0, 1], [0, 0]], [[0], [1]], E_1, E_2, time="continuous")
    >>> found.K, found.factor.polynomial.as_expr(), found.P.tolist()
    (Matrix([[-2, -2]]), s**2 + 2*s + 2, [[4, 2], [2, 2]])
    """
    s = variable_in(time, variable, "this Riccati equation")
    a, b, e_1, e_2 = matrices = regulator_data(A, B, E_1, E_2)
    if b.cols != 1:
        raise InputError(f"B has {b.cols} columns; one input is needed (see lqg_poles for several)")
    if time == "continuous" and e_2.is_zero_matrix:
        raise NoSolutionError(
            "E_2 = 0: u costs nothing, and in continuous time the best gain is then infinite; "
            "give u a weight, or see regulator_locus for the limits of the poles"
        )
    n = a.rows
    open_loop, W = state_numerators(a, b, s)
    outputs = transfer_matrix_of_realisation(a, b, e_1, e_2, s)
    numerators = [outputs[row, 0].numerator for row in range(e_1.rows)]
    spectrum = sum((spectrum_of(N, n, time) for N in numerators), Poly(0, s))
    if spectrum.is_zero:
        raise NoSolutionError("the transfer matrix from u to z is zero, so no gain is the best")
    precision = digits
    working_bits(digits)
    while True:
        factor = factor_spectrum(canonical(spectrum), n, time, precision)
        if factor.polynomial is not None:
            difference = canonical(open_loop - factor.polynomial)
            right = Matrix([difference.coeff_monomial(s**k) for k in range(n - 1, -1, -1)])
            data = [to_flint(m) for m in matrices]
            K, P = map(from_flint, _gain_and_cost(data, to_flint(W), to_flint(right), time))
            return RiccatiSolution(*matrices, factor, K, P, exact_rows(K), exact_rows(P))
        with ball_precision(2 * working_bits(precision)):
            pairs = zip(open_loop.all_coeffs()[1:], factor.enclosure.coefficients[1:], strict=True)
            column = flint.arb_mat([[ball_of_number(x) - ball_of_enclosure(y)] for x, y in pairs])
            balls = [ball_matrix(m) for m in matrices]
            K, P = _gain_and_cost(balls, ball_matrix(W), column, time)
            rows = enclosed_rows(K), enclosed_rows(P)
        radii = [c.radius for matrix in rows for row in matrix for c in row]
        if max(radii) <= Rational(1, 10**digits):
            return RiccatiSolution(*matrices, factor, None, None, *rows)
        precision *= 2


def _gain_and_cost(
    matrices: Sequence[FlintMatrix], W: FlintMatrix, right: FlintMatrix, time: Time
) -> tuple[FlintMatrix, FlintMatrix]:
    """Solve W K' = right and the Lyapunov equation of the closed loop for P.

    It is A_K' P + P A_K + E_K' E_K = 0, or P = A_K' P A_K + E_K' E_K in discrete time.
    """
    A, B, E_1, E_2 = matrices
    K = W.solve(right).transpose()
    closed, output = A + B * K, E_1 + E_2 * K
    Q, n, a = output.transpose() * output, A.nrows(), closed.tolist()
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    index = {pair: k for k, pair in enumerate(pairs)}
    if time == "discrete":
        rows = [
            [
                (1 if (i, j) == (k, m) else 0)
                - (a[k][i] * a[m][j] + (a[m][i] * a[k][j] if k != m else 0))
                for k, m in pairs
            ]
            for i, j in pairs
        ]
        column = [[Q[i, j]] for i, j in pairs]
    else:
        rows = [[0] * len(pairs) for _ in pairs]
        for row, (i, j) in zip(rows, pairs, strict=True):
            for k in range(n):
                row[index[min(k, j), max(k, j)]] += a[k][i]
                row[index[min(i, k), max(i, k)]] += a[k][j]
        column = [[-Q[i, j]] for i, j in pairs]
    values = type(A)(rows).solve(type(A)(column))
    P = [[values[index[min(i, j), max(i, j)], 0] for j in range(n)] for i in range(n)]
    return K, type(A)(P)


def _residual(matrices: Sequence[FlintMatrix], P: FlintMatrix, time: Time) -> FlintMatrix:
    A, B, E_1, E_2 = matrices
    row, weight = B.transpose() * P, E_2.transpose() * E_2
    if time == "discrete":
        weight = weight + row * B
        row = row * A
    row = row + E_2.transpose() * E_1
    correction = row.transpose() * row * (1 / weight[0, 0])
    if time == "discrete":
        return A.transpose() * P * A + E_1.transpose() * E_1 - correction - P
    return A.transpose() * P + P * A + E_1.transpose() * E_1 - correction
