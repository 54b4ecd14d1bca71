"""The standard problem of a plant with weights of states and inputs, and covariances of noises."""

from __future__ import annotations

import sympy
from sympy import Matrix, Rational, Symbol
from sympy.solvers.diophantine.diophantine import sum_of_four_squares

from compensator_theory.errors import InputError
from compensator_theory.lqg._regulator_data import read_weights
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.systems._canonical_forms import RealisationLike, timed_realisation
from compensator_theory.systems._descriptions import has_states
from compensator_theory.systems._standard_problems import StandardProblem


@holds_where_defined
@refusing
def lqg_problem(
    plant: RealisationLike,
    Q: MatrixLike,
    R: MatrixLike,
    W: MatrixLike,
    V: MatrixLike,
    *,
    N: MatrixLike | None = None,
    S: MatrixLike | None = None,
    variable: str | Symbol | None = None,
) -> StandardProblem:
    r"""Make the standard problem of LQG from its weights and covariances.

    .. math:: J = \mathrm E\!\begin{bmatrix} x \\ u \end{bmatrix}^T\!
              \begin{bmatrix} Q & N \\ N^T & R \end{bmatrix}\!
              \begin{bmatrix} x \\ u \end{bmatrix}, \quad
              \mathrm{cov}\begin{bmatrix} w \\ v \end{bmatrix} =
              \begin{bmatrix} W & S \\ S^T & V \end{bmatrix}, \quad
              \dot x = Ax + Bu + w, \quad y = Cx + Du + v

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or a state-space system of another library
        Rational. A transfer function is refused, since Q weighs states; see :func:`realisation`.
    Q, R : matrix
        n x n and l_u x l_u, rational, with N positive semidefinite together.
    W, V : matrix
        n x n and l_y x l_y, rational: the covariances, in continuous time the intensities, of the
        noise in the state and of the sensors; with S positive semidefinite together. A noise that
        enters through G with covariance Q_N is W = G Q_N G'.
    N, S : matrix, optional
        n x l_u and n x l_y; default zero.
    variable : str or Symbol, optional
        For matrices "s", or "z" or "q" in discrete time; it must be written.

    Returns
    -------
    StandardProblem
        With :math:`[E_1\ E_2]^T[E_1\ E_2]` and :math:`[D_1;\ D_2][D_1;\ D_2]^T` the two matrices
        above, for :func:`lqg_controller`, :func:`lqg_poles` and all that reads such a problem.

    Raises
    ------
    InputError
        If the plant has no states or no time domain, a shape does not fit, an entry is symbolic, or
        a matrix is not symmetric and positive semidefinite.

    Notes
    -----
    E and D are rational whatever the weights are: :math:`L\Delta L^T` of a weight has rational
    entries, and each positive rational number is a sum of four squares of rational numbers
    (Lagrange), a row for each.

    Examples
    --------
    >>> from compensator_theory import lqg_controller, lqg_problem
    >>> double_integrator = [[0, 1], [0, 0]], [[0], [1]], [[1, 0]]
    >>> problem = lqg_problem(double_integrator, [[1, 0], [0, 0]], [[1]], [[0, 0], [0, 1]], [[1]],
    ...     variable="s")
    >>> controller = lqg_controller(problem)
    >>> controller.cost
    6*sqrt(2)
    >>> print(controller.compensator)
    (-2*sqrt(2)*s - 1)/(s**2 + 2*sqrt(2)*s + 4)
    """
    if not has_states(plant, variable):
        raise InputError(
            "Q weighs states, and a transfer function does not say which they are; give (A, B, C), "
            "or realisation(G), which has the states of the controllable canonical form"
        )
    system = timed_realisation(plant, variable, "an LQG problem")
    A, B, Q_, R_, N_ = read_weights(system.A, system.B, Q, R, N)
    E = _rows_of_squares(_joined(Q_, R_, N_), "Q, R and N")
    names = ("A", "C", "W", "V", "S")
    _, _, W_, V_, S_ = read_weights(system.A.T, system.C.T, W, V, S, names=names)
    D = _rows_of_squares(_joined(W_, V_, S_), "W, V and S").T
    n = system.n
    return StandardProblem(
        A=A, B=B, C=system.C, D_0=system.D, D_1=D[:n, :], D_2=D[n:, :], E_1=E[:, :n], E_2=E[:, n:],
        E_0=None, variable=system.variable, sample_time=system.sample_time,
    )  # fmt: skip


def _joined(first: Matrix, second: Matrix, cross: Matrix) -> Matrix:
    return Matrix.vstack(Matrix.hstack(first, cross), Matrix.hstack(cross.T, second))


def _rows_of_squares(gram: Matrix, names: str) -> Matrix:
    """Return E with E'E = gram, rational, by symmetric elimination and Lagrange's four squares."""
    size, left, rows = gram.rows, gram.as_mutable(), []
    for k in range(size):
        pivot = left[k, k]
        if pivot < 0 or (pivot == 0 and any(left[k, :])):
            raise InputError(
                f"{names} are not positive semidefinite together, so that the cost, or the "
                "variance of a noise, would be negative somewhere"
            )
        if pivot == 0:
            continue
        row = left[k, :] / pivot
        left -= pivot * row.T * row
        rows += [square * row for square in _squares(pivot)]
    return Matrix.vstack(*rows) if rows else sympy.zeros(1, size)


def _squares(number: Rational) -> list[Rational]:
    """Return at most four rational numbers whose squares add to a positive one."""
    roots = sum_of_four_squares(int(number.p * number.q))
    return [Rational(root, number.q) for root in roots if root]
