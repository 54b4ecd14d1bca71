"""Compensators from the coefficient matrices of their difference equation."""

from __future__ import annotations

from collections.abc import Sequence

import sympy
from sympy import ImmutableMatrix, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._budget import ask, integer, listed
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._letters import introduced, names_in_all


@carrying()
def compensator_polynomials(
    P: Sequence[MatrixLike],
    Q: Sequence[MatrixLike],
    n_c: int,
    k_c: int,
    *,
    variable: str | Symbol | None = None,
) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    r"""Return :math:`(N_c, D_c)` of a controller given by its coefficient matrices.

    .. math:: D_c = q^{n_c} I - q^{n_c-1}P_1 - \cdots - P_{n_c}, \qquad
              N_c = q^{n_c-k_c} Q_{k_c} + \cdots + Q_{n_c}

    Parameters
    ----------
    P : sequence of matrices
        :math:`P_1, \ldots, P_{n_c}`, each l_u x l_u; scalars may be numbers.
    Q : sequence of matrices
        :math:`Q_{k_c}, \ldots, Q_{n_c}`, each l_u x l_y; scalars may be numbers.
    n_c, k_c : int
        Order and relative degree, :math:`0 \le k_c \le n_c`.
    variable : str or Symbol, optional
        Forward shift; default: q, or z where the matrices have a symbol q.

    Raises
    ------
    InputError
        If the number of matrices or their shapes do not fit n_c and k_c.

    Notes
    -----
    Source: (4.9), (4.10); the controller is (2.28).

    Examples
    --------
    >>> from compensator_theory import compensator_polynomials
    >>> compensator_polynomials([1, "-0.5"], [3, 4], n_c=2, k_c=1)
    (Matrix([[3*q + 4]]), Matrix([[q**2 - q + 1/2]]))
    """
    for name, count in (("n_c", n_c), ("k_c", k_c)):
        integer(count, name)
        ask("degree", count, "the compensator")
    P, Q = (listed(x, "degree", f"the list of {name}") for x, name in ((P, "P"), (Q, "Q")))
    if not 0 <= k_c <= n_c:
        raise InputError(f"k_c = {k_c} must lie between 0 and n_c = {n_c}")
    if (len(P), len(Q)) != (n_c, n_c + 1 - k_c):
        raise InputError(
            f"there are {len(P)} matrices P and {len(Q)} matrices Q; n_c = {n_c} and k_c = {k_c} "
            f"need {n_c} and {n_c + 1 - k_c}"
        )
    P_exact, Q_exact = [_matrix(p, "P") for p in P], [_matrix(m, "Q") for m in Q]
    q = introduced(
        variable, names_in_all(P_exact, Q_exact), "q", "z",
        meaning="the shift operator", owner="a symbol of the matrices",
    )  # fmt: skip
    l_u, l_y = Q_exact[0].shape
    shapes = {m.shape for m in P_exact} - {(l_u, l_u)} | {m.shape for m in Q_exact} - {(l_u, l_y)}
    if shapes:
        raise InputError(
            f"matrices of shapes {sorted(shapes)} do not fit l_u = {l_u} and l_y = {l_y}, as the "
            "first Q shows"
        )
    D_c = q**n_c * identity_matrix(l_u)
    for i, p in enumerate(P_exact, start=1):
        D_c -= q ** (n_c - i) * p
    N_c = sympy.zeros(l_u, l_y)
    for i, m in enumerate(Q_exact, start=k_c):
        N_c += q ** (n_c - i) * m
    return ImmutableMatrix(N_c), ImmutableMatrix(D_c)


def _matrix(value: MatrixLike, name: str) -> ImmutableMatrix:
    is_matrix = isinstance(value, sympy.MatrixBase | Sequence) and not isinstance(value, str)
    is_array = len(getattr(value, "shape", ())) == 2
    return exact_matrix(value if is_matrix or is_array else [[value]], name)
