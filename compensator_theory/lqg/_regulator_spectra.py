"""The polynomial whose stable roots are a regulator's poles: one determinant of a pencil."""

from __future__ import annotations

from itertools import count, islice

import flint
from sympy import ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory.lqg._regulator_data import Weights, read_weights
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.matrices._flint_matrices import (
    identity_matrix,
    rational,
    to_flint,
    zero_matrix,
)
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    interpolated,
    to_flint_polynomial,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    multiplied,
    rank,
    solve,
)
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._variables import Time, require_time, variable_in
from compensator_theory.systems._state_space import transfer_matrix_of_realisation


@refusing
def regulator_spectrum(
    A: MatrixLike,
    B: MatrixLike,
    Q: MatrixLike | None = None,
    R: MatrixLike | None = None,
    N: MatrixLike | None = None,
    *,
    time: Time | None = None,
    E_1: MatrixLike | None = None,
    E_2: MatrixLike | None = None,
    variable: str | Symbol | None = None,
) -> Poly:
    r"""Return the polynomial whose stable roots are the regulator's poles.

    .. math::
        p(z) &= \pm\det\begin{bmatrix} A - zI & 0 & B \\ -Q & I - zA^T & -N \\
              N^T & zB^T & R \end{bmatrix}
              = z^{n}\, \det\!\left(G^T(1/z)\,G(z)\right) D(z) D(1/z) \\
        p(s) &= \pm\det\begin{bmatrix} A - sI & 0 & B \\ -Q & -A^T - sI & -N \\
              N^T & B^T & R \end{bmatrix} = \det\!\left(G^T(-s)\,G(s)\right) D(s) D(-s)

    with :math:`G = E_1(sI - A)^{-1}B + E_2` and :math:`D = \det(sI - A)`.

    Parameters
    ----------
    A, B, Q, R, N, E_1, E_2
        As for :func:`solve_riccati`; :math:`Q = E_1^TE_1`, :math:`N = E_1^TE_2`,
        :math:`R = E_2^TE_2`.
    time : {"continuous", "discrete"}
        Whether the polynomial is even or palindromic.
    variable : str or Symbol, optional
        Default: s in continuous, q in discrete time.

    Returns
    -------
    sympy.Poly
        Of degree 2n or less. For the estimator give
        the transposes :math:`A^T, C^T, D_1^T, D_2^T`.

    Raises
    ------
    InputError
        If a shape does not fit, an entry is symbolic, or the variable stands for the other time
        domain.

    Examples
    --------
    >>> from compensator_theory import regulator_spectrum
    >>> regulator_spectrum([[3]], [[1]], [[4]], time="discrete").as_expr()
    4*q
    >>> regulator_spectrum([[0]], [[1]], [[4]], [[1]], time="continuous").as_expr()
    4 - s**2
    """
    time = require_time(time)
    symbol = variable_in(time, variable, "the spectrum of an LQG regulator")
    return spectrum_of_weights(read_weights(A, B, Q, R, N, E_1, E_2), time, symbol)


def spectrum_of_weights(weights: Weights, time: Time, symbol: Symbol) -> Poly:
    """Return the same polynomial for weights that are read."""
    a, b, q, r, cross = weights
    n, l_u = b.shape
    if time == "continuous" and rank(r) == l_u:
        return _of_hamiltonian(weights, symbol)
    if l_u**2 <= n:
        return _of_response(weights, time, symbol)
    zero, eye = zero_matrix, identity_matrix
    discrete = time == "discrete"
    constant = _of_blocks(
        [a, zero(n, n), b],
        [-q, eye(n) if discrete else -a.T, -cross],
        [cross.T, zero(l_u, n) if discrete else b.T, r],
    )
    slope = _of_blocks(
        [-eye(n), zero(n, n), zero(n, l_u)],
        [zero(n, n), -a.T if discrete else -eye(n), zero(n, l_u)],
        [zero(l_u, n), b.T if discrete else zero(l_u, n), zero(l_u, l_u)],
    )
    return _determinant(constant, slope, n, symbol)


def _of_hamiltonian(weights: Weights, symbol: Symbol) -> Poly:
    """Return (-1)^n det R det(sI - H) by the Hamiltonian matrix, where R is not singular."""
    a, b, q, r, cross = weights
    by_state, by_costate = solve(r, cross.T), solve(r, b.T)
    H = _of_blocks(
        [a - multiplied(b, by_state), -multiplied(b, by_costate)],
        [multiplied(cross, by_state) - q, multiplied(cross, by_costate) - a.T],
    )
    sign = -1 if a.rows % 2 else 1
    return canonical(characteristic_polynomial(H, symbol) * (sign * determinant(r)))


def _of_response(weights: Weights, time: Time, symbol: Symbol) -> Poly:
    r"""Return it by the numerators of the response, so that no determinant is larger than R.

    .. math:: \Phi(s) = X^T(-s) \begin{bmatrix} Q & N \\ N^T & R \end{bmatrix} X(s), \quad
              X = \begin{bmatrix} \mathrm{adj}(sI - A)\,B \\ D(s)\,I \end{bmatrix}, \quad
              \det\Phi(s) = p(s)\,(D(s)\,D(-s))^{m - 1}

    In discrete time :math:`z^nX^T(1/z)` stands for :math:`X^T(-s)`.
    """
    a, b, q, r, cross = weights
    n, m = b.shape
    weight = _of_blocks([q, cross], [cross.T, r])
    X, Y = (
        transfer_matrix_of_realisation(a, b, left[:, :n], left[:, n:], symbol)
        for left in (identity_matrix(n + m), weight)
    )
    numerators, weighted = (
        [[to_flint_polynomial(entry) for entry in row] for row in G.numerators] for G in (X, Y)
    )
    mirrored = [[_mirrored(entry, n, time) for entry in row] for row in numerators]
    zero = flint.fmpq_poly()
    spectrum = [
        [
            sum((x[i] * y[j] for x, y in zip(mirrored, weighted, strict=True)), zero)
            for j in range(m)
        ]
        for i in range(m)
    ]
    if m == 1:
        return canonical(from_flint_polynomial(spectrum[0][0], symbol))
    D = to_flint_polynomial(X.denominator)
    return _divided_determinant(spectrum, D * _mirrored(D, n, time), n, symbol)


def _mirrored(poly: flint.fmpq_poly, size: int, time: Time) -> flint.fmpq_poly:
    """Return p(-s), or z^n p(1/z)."""
    if time == "continuous":
        return poly(flint.fmpq_poly([0, -1]))
    ascending = poly.coeffs()
    return flint.fmpq_poly([0] * (size + 1 - len(ascending)) + ascending[::-1])


def _divided_determinant(
    matrix: list[list[flint.fmpq_poly]], divisor: flint.fmpq_poly, n: int, variable: Symbol
) -> Poly:
    """Return det M/d^(m-1), of degree 2n at most, from 2n + 1 integers that are no root of d."""
    integers = (flint.fmpq(k // 2 if k % 2 else -(k // 2)) for k in count(1))
    points = list(islice((x for x in integers if divisor(x) != 0), 2 * n + 1))
    values = [
        flint.fmpq_mat([[entry(x) for entry in row] for row in matrix]).det()
        / divisor(x) ** (len(matrix) - 1)
        for x in points
    ]
    return canonical(from_flint_polynomial(flint.fmpq_poly(interpolated(points, values)), variable))


def _of_blocks(*rows: list[Matrix]) -> ImmutableMatrix:
    """Return the matrix of blocks; SymPy's BlockMatrix would look for each entry by comparisons."""
    return ImmutableMatrix.vstack(*(ImmutableMatrix.hstack(*row) for row in rows))


def _determinant(constant: Matrix, slope: Matrix, n: int, variable: Symbol) -> Poly:
    """Return (-1)^n times that of a pencil, from its values at 2n + 1 integers."""
    pencil = [to_flint(matrix) for matrix in (constant, slope)]
    points = [flint.fmpq(k) for k in range(-n, n + 1)]
    values = [(pencil[0] + point * pencil[1]).det() for point in points]
    sign = -1 if n % 2 else 1
    descending = [sign * rational(c) for c in reversed(interpolated(points, values))]
    return canonical(Poly(descending or [0], variable))
