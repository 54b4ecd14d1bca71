"""Regulator and observer gains that place the eigenvalues of A + BK and A - FC exactly."""

from __future__ import annotations

import flint
from sympy import Expr, ImmutableMatrix, Poly, Symbol
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import (
    InputError,
    NoSolutionError,
    NotControllableError,
    NotObservableError,
)
from compensator_theory.matrices._domain_matrices import domain_matrices
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import from_flint, zero_matrix
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.matrices._linear_algebra import determinant, solve
from compensator_theory.placement._gain_families import state_feedback_family
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike, polynomial_or_roots
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._letters import variable_for_matrix
from compensator_theory.polynomials._poly import is_rational, monic
from compensator_theory.systems._controllability import (
    controllability_matrix,
    rational_pair,
    uncontrollable_polynomial,
)


@carrying()
def regulator_gain(
    A: MatrixLike, B: MatrixLike, poles: SpectrumLike, *, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return a gain K that places the eigenvalues of A + BK; with one input it is unique.

    .. math:: K = -\begin{bmatrix} 0 & \cdots & 0 & 1 \end{bmatrix}\,\mathcal C(A,B)^{-1} p_R(A)

    That is Ackermann's formula, for one input. With several inputs many gains have these
    eigenvalues, and K is the first member of :func:`state_feedback_family` that exists.

    Parameters
    ----------
    A, B : matrix
        n x n and n x m; symbols allowed, for generic values of them.
    poles : polynomial or list of roots
        :math:`p_R`, of degree n; a list holds its *roots*.
    variable : str or Symbol, optional
        Variable of the polynomial; default: s, or lambda where the matrices have a symbol s.

    Returns
    -------
    sympy.ImmutableMatrix
        m x n, with :math:`\det(sI - A - BK) = p_R`.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable; the message names the polynomial of the fixed modes.
    InputError
        If the number of poles is not n.

    Notes
    -----
    Source: (7.25)-(7.27). Erratum: with :math:`S_C` as (7.26) defines it, (7.25) must read
    :math:`A + BK = S_C^{-1}(A_C + B_C K_C)S_C` and :math:`K_C = K S_C^{-1}`.

    Examples
    --------
    >>> from compensator_theory import regulator_gain
    >>> regulator_gain([[-1, 4], [0, -3]], [[0], [1]], [-5, -4])  # Example 7.1
    Matrix([[-3, -5]])
    >>> regulator_gain([[0, 1], [0, 0]], [[1, 0], [0, 1]], [-1, -2])
    Matrix([
    [2, -7],
    [2, -5]])
    """
    pair = rational_pair(A, B)
    if pair is None:
        a, b = exact_matrix(A, "A"), exact_matrix(B, "B")
        size, inputs, symbol = int(a.rows), int(b.cols), variable_for_matrix(variable, a, b)
    else:
        symbol = variable_for_matrix(variable)
        size, inputs = int(pair[0].nrows()), int(pair[1].ncols())
    if inputs > 1:
        return _one_of_many(A, B, poles, symbol)
    goal = read_target_polynomial(poles, size, symbol)
    try:
        if pair is not None and is_rational(goal):
            return _rational_gain(*pair, to_flint_polynomial(goal))
        return _symbolic_gain(exact_matrix(A, "A"), exact_matrix(B, "B"), goal)
    except NoSolutionError as error:
        fixed = format_polynomial(uncontrollable_polynomial(A, B, variable=symbol))
        raise NotControllableError(
            f"(A, B) is not controllable: every A + BK keeps the roots of {fixed}. Remove these "
            "modes from the plant, or change B"
        ) from error


def _one_of_many(
    A: MatrixLike, B: MatrixLike, poles: SpectrumLike, variable: Symbol
) -> ImmutableMatrix:
    """Return the first gain of the family with these poles, for several inputs."""
    uncontrollable = uncontrollable_polynomial(A, B, variable=variable)
    if uncontrollable.degree() > 0:
        raise NotControllableError(
            "(A, B) is not controllable: every A + BK keeps the roots of "
            f"{format_polynomial(uncontrollable)}. Remove these modes from the plant, or change B"
        )
    return state_feedback_family(A, B, poles, variable=variable).gain()


def _rational_gain(a: flint.fmpq_mat, b: flint.fmpq_mat, goal: flint.fmpq_poly) -> ImmutableMatrix:
    """Compute the gain in integers: A = A_i/d, b = b_i/e; r A_i^k b_i = 0 but for the last k."""
    n = int(a.nrows())
    (A, d), (column, e) = a.numer_denom(), b.numer_denom()
    columns = [column]
    for _ in range(n - 1):
        columns.append(A * columns[-1])
    kalman = flint.fmpz_mat([x.entries() for x in columns])
    last = flint.fmpz_mat([[int(k == n - 1)] for k in range(n)])
    try:
        row, q = kalman.solve(last).transpose().numer_denom()
    except ZeroDivisionError as error:
        raise NoSolutionError("the controllability matrix is singular") from error
    numerators, below = goal.numer(), goal.denom()
    value, power = row * numerators[n], d
    for k in range(n - 1, -1, -1):  # Horner's scheme, made homogeneous by d
        value, power = value * A + row * (numerators[k] * power), power * d
    scale = flint.fmpq(-e, q * d * below)
    return from_flint(flint.fmpq_mat(value) * scale)


def _symbolic_gain(a: ImmutableMatrix, b: ImmutableMatrix, goal: Poly) -> ImmutableMatrix:
    """Solve K [V_1 .. V_n] = p - p_R for the columns of adj(sI - A) b (Bass and Gura)."""
    if a.rows != a.cols or b.rows != a.rows or not a.rows:
        controllability_matrix(a, b)  # its error names the mismatch
        return zero_matrix(1, 0)
    target = ImmutableMatrix([goal.all_coeffs()[1:]])
    A, v, target = domain_matrices(a, b, target)
    p = A.charpoly()
    columns = [v]
    for coefficient in p[1:-1]:
        columns.append(A * columns[-1] + v * coefficient)
    difference = DomainMatrix([p[1:]], target.shape, A.domain).to_dense() - target
    kalman = columns[0].hstack(*columns[1:])
    return solve(kalman.transpose().to_Matrix(), difference.transpose().to_Matrix()).T


@generic_answer_of(regulator_gain)
def _generic_regulator_gain(
    A: MatrixLike, B: MatrixLike, poles: SpectrumLike, *, variable: str | Symbol | None = None
) -> tuple[ImmutableMatrix, list[Expr]]:
    K = regulator_gain(A, B, poles, variable=variable)
    if K.rows > 1:
        return K, list(state_feedback_family(A, B, poles, variable=variable).exceptional)
    return K, [determinant(controllability_matrix(A, B))]


@carrying()
def observer_gain(
    A: MatrixLike, C: MatrixLike, poles: SpectrumLike, *, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return a gain F that places the eigenvalues of A - FC; with one output it is unique.

    .. math:: F = p_O(A)\,\mathcal O(A,C)^{-1}\begin{bmatrix} 0 & \cdots & 0 & 1 \end{bmatrix}^T

    Parameters
    ----------
    A, C : matrix
        n x n and p x n; symbols allowed, for generic values of them.
    poles : polynomial or list of roots
        :math:`p_O`, of degree n; a list holds its *roots*.
    variable : str or Symbol, optional
        Variable of the polynomial; default: s, or lambda where the matrices have a symbol s.

    Returns
    -------
    sympy.ImmutableMatrix
        n x p, with :math:`\det(sI - A + FC) = p_O`; with several outputs one of many, the dual of
        :func:`regulator_gain`.

    Raises
    ------
    NotObservableError
        If (A, C) is not observable; the message names the polynomial of the fixed modes.
    InputError
        If the number of poles is not n.

    Notes
    -----
    Source: (7.28)-(7.30).

    Examples
    --------
    >>> from compensator_theory import observer_gain
    >>> observer_gain([[-1, 4], [0, -3]], [[1, 0]], [-2, -6]).T  # Example 7.1
    Matrix([[4, -3/4]])
    """
    a, c = exact_matrix(A, "A"), exact_matrix(C, "C")
    try:
        return ImmutableMatrix(-regulator_gain(a.T, c.T, poles, variable=variable).T)
    except NotControllableError as error:
        fixed = uncontrollable_polynomial(a.T, c.T, variable=variable)
        raise NotObservableError(
            f"(A, C) is not observable: every A - FC keeps the roots of "
            f"{format_polynomial(fixed)}. Remove these modes from the plant, or measure more"
        ) from error


@generic_answer_of(observer_gain)
def _generic_observer_gain(
    A: MatrixLike, C: MatrixLike, poles: SpectrumLike, *, variable: str | Symbol | None = None
) -> tuple[ImmutableMatrix, list[Expr]]:
    F = observer_gain(A, C, poles, variable=variable)
    a, c = (exact_matrix(M, name).T for M, name in ((A, "A"), (C, "C")))
    return F, list(_generic_regulator_gain(a, c, poles, variable=variable)[1])


def read_target_polynomial(poles: SpectrumLike, size: int, variable: Symbol) -> Poly:
    """Read a monic polynomial of the given degree, from its roots or from itself."""
    goal = monic(polynomial_or_roots(poles, variable))
    if goal.degree() != size:
        raise InputError(
            f"{format_polynomial(goal)} has degree {goal.degree()}, but {size} eigenvalues are to "
            "be placed"
        )
    return goal
