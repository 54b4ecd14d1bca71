"""Separation: the closed loop of an observer-based compensator is block triangular.

Letters are matrices of any size, with any number of signals; 1 is the identity.
"""

from sympy import Matrix

from .letters import letters, vanishes

A, B, C, K, F, D_0, T = letters("A B C K F D_0 T")
A_c, B_c, C_c, A_q, B_q, C_q = letters("A_c B_c C_c A_q B_q C_q")
S = Matrix([[1, 0], [1, -1]])  # (7.18), its own inverse


def closed_loop(dynamics: object, direct: object = 0) -> Matrix:
    """Return (7.14), with D_0 (A.12), for B_c = F and C_c = K."""
    return Matrix([[A, B * K], [F * C, dynamics + F * direct * K]])


def triangular() -> Matrix:
    """Return the right-hand side of (7.18)."""
    return Matrix([[A + B * K, -B * K], [0, A - F * C]])


def similarity() -> bool:
    """(7.18): S A~ = A~' S."""
    return vanishes(S * closed_loop(A + B * K - F * C) - triangular() * S)


def similarity_with_direct_term() -> bool:
    """(A.11), (A.12): the same with D_0, where A_c = A + BC_c - B_cC - B_cD_0C_c."""
    dynamics = A + B * K - F * C - F * D_0 * K
    return vanishes(S * closed_loop(dynamics, D_0) - triangular() * S)


def inverse_of_S() -> bool:
    """S of (7.18) is its own inverse, so that A~ and A~' are similar."""
    return bool(Matrix([[1, 0], [0, 1]]) == S * S)


def riccati_is_triangular() -> bool:
    """In the basis [1 0; T 1] the closed loop is block triangular if and only if TBC_cT + TA -
    A_cT - B_cC = 0, for compensators of any order.

    The blocks on the diagonal are then A + BC_cT and A_c - TBC_c.
    """
    loop = Matrix([[A, B * C_c], [B_c * C, A_c]])
    transformed = Matrix([[1, 0], [-T, 1]]) * loop * Matrix([[1, 0], [T, 1]])
    riccati = T * B * C_c * T + T * A - A_c * T - B_c * C
    claimed = Matrix([[A + B * C_c * T, B * C_c], [-riccati, A_c - T * B * C_c]])
    return vanishes(transformed - claimed)


def form_solves_riccati() -> bool:
    """With A_cT = T(A + BK - FC), K = C_cT and B_c = TF that equation holds."""
    riccati = T * B * K + T * A - T * (A + B * K - F * C) - T * F * C
    return vanishes(Matrix([[riccati]]))


def youla_similarity() -> bool:
    """With a filter (A_q, B_q, C_q) of the innovations the loop in (x, x_q, e) is block triangular,
    and its diagonal is A + BK, A_q, A - FC.
    """
    loop = Matrix(
        [
            [A, B * K, B * C_q],
            [F * C, A + B * K - F * C, B * C_q],
            [B_q * C, -B_q * C, A_q],
        ]
    )
    basis = Matrix([[1, 0, 0], [0, 0, 1], [1, -1, 0]])  # x, x_q, e = x - x^
    claimed = Matrix([[A + B * K, B * C_q, -B * K], [0, A_q, B_q * C], [0, 0, A - F * C]])
    return vanishes(basis * loop - claimed * basis)
