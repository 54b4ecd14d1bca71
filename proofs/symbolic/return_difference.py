"""The return-difference identity of the Riccati equation (A.7), with the cross term R_12.

Any number of states and signals. phi stands for (xI - A)^-1 B d and psi for (yI - A)^-1 B e with
y = 1/x: A phi = x phi - B d, which needs no inverse.
"""

from sympy import Expr, Symbol, expand, transpose

from .letters import letters, reduced

A, B, K, P, R_1, R_2, R_12 = letters("A B K P R_1 R_2 R_12")
phi, psi, d, e = letters("phi psi d e")
x = Symbol("x", positive=True)  # commutes; the identity is rational in x, so its sign is no loss
W = R_2 + transpose(B) * P * B
SYMMETRIC = {transpose(P): P, transpose(R_1): R_1, transpose(R_2): R_2}
CROSS = transpose(R_12) + transpose(B) * P * A  # -W K, (A.6)
KWK = transpose(A) * P * A + R_1 - P  # K'WK, (A.7) in the form with R_12


def _with_motion(expression: Expr) -> Expr:
    """Use A phi = x phi - B d and A psi = psi/x - B e."""
    motion = {
        A * phi: x * phi - B * d,
        transpose(psi) * transpose(A): transpose(psi) / x - transpose(e) * transpose(B),
    }
    return reduced(expand(expression).subs(SYMMETRIC), motion)


def identity() -> bool:
    """(e - K psi)'(R_2 + B'PB)(d - K phi) = e'R_2d + psi'R_1phi + e'R_12'phi + psi'R_12d."""
    left = (
        transpose(e) * W * d
        + transpose(e) * CROSS * phi
        + transpose(psi) * transpose(CROSS) * d
        + transpose(psi) * KWK * phi
    )
    right = (
        transpose(e) * R_2 * d
        + transpose(psi) * R_1 * phi
        + transpose(e) * transpose(R_12) * phi
        + transpose(psi) * R_12 * d
    )
    return bool(_with_motion(left - right) == 0)


def square_of_the_response() -> bool:
    """With R_1 = E_1'E_1, R_12 = E_1'E_2, R_2 = E_2'E_2 the right-hand side is (E_1 psi + E_2 e)'
    (E_1 phi + E_2 d), the product of two responses of z.
    """
    E_1, E_2 = letters("E_1 E_2")
    right = (
        transpose(e) * transpose(E_2) * E_2 * d
        + transpose(psi) * transpose(E_1) * E_1 * phi
        + transpose(e) * transpose(E_2) * E_1 * phi
        + transpose(psi) * transpose(E_1) * E_2 * d
    )
    return bool(expand(transpose(E_1 * psi + E_2 * e) * (E_1 * phi + E_2 * d) - right) == 0)


def without_cross_term() -> bool:
    """(A.7) with A^_R and R^_1 of (A.9) is P = A'PA + R_1 - K'(R_2 + B'PB)K with R_12 kept.

    R_2 is invertible here. With V = (R_2 + B'PB)^-1 and X = R_2^-1 R_12' both forms agree.
    """
    V, X = letters("V X")
    A_R = A - B * X
    R_hat = R_1 - transpose(X) * R_2 * X
    printed = (
        transpose(A_R) * P * A_R
        - transpose(A_R) * P * B * V * transpose(B) * P * A_R
        + R_hat
    )  # fmt: skip
    with_cross = R_2 * X + transpose(B) * P * A  # R_12' = R_2 X
    direct = transpose(A) * P * A + R_1 - transpose(with_cross) * V * with_cross
    # V W = W V = 1: R_2 V = 1 - B'PB V, V R_2 = 1 - V B'PB
    BPB = transpose(B) * P * B
    inverse = {R_2 * V: 1 - BPB * V, V * R_2: 1 - V * BPB}
    difference = expand(printed - direct).subs(SYMMETRIC)
    return bool(reduced(difference, inverse) == 0)


def gain_in_both_forms() -> bool:
    """The gain (A.6) is -(R_2 + B'PB)^-1 B'P A^_R - R_2^-1 R_12'."""
    V, X = letters("V X")
    BPB = transpose(B) * P * B
    direct = -V * (R_2 * X + transpose(B) * P * A)
    printed = -V * transpose(B) * P * (A - B * X) - X
    return bool(reduced(direct - printed, {V * R_2: 1 - V * BPB}) == 0)


def joseph_form() -> bool:
    """P+ = A'PA + R_1 - A'PB(R_2 + B'PB)^-1B'PA is (A + BK)'P(A + BK) + K'R_2K + R_1, so that
    (8.96) keeps P positive semidefinite.
    """
    V = letters("V")[0]
    K_T = transpose(A) * P * B * V  # -K'
    gain = -V * transpose(B) * P * A
    closed = A + B * gain
    closed_T = transpose(A) - K_T * transpose(B)
    joseph = closed_T * P * closed + K_T * R_2 * V * transpose(B) * P * A + R_1
    printed = transpose(A) * P * A + R_1 - transpose(A) * P * B * V * transpose(B) * P * A
    BPB = transpose(B) * P * B
    return bool(reduced(joseph - printed, {R_2 * V: 1 - BPB * V}) == 0)


def difference_of_solutions() -> bool:
    """P - P' = (A + BK)'(P - P')(A + BK') for two symmetric solutions of (A.7) with gains K and K',
    so that they are equal if both are stabilising.
    """
    P_1, P_2, K_1, K_2, W_1, W_2 = letters("P_1 P_2 K_1 K_2 W_1 W_2")
    A_T, B_T = transpose(A), transpose(B)
    K_T = transpose(K_1)
    rules = {
        A_T * P_1 * A: P_1 - R_1 + K_T * W_1 * K_1,
        A_T * P_2 * A: P_2 - R_1 + transpose(K_2) * W_2 * K_2,
        A_T * P_1 * B: -K_T * W_1 - R_12,
        A_T * P_2 * B: -transpose(K_2) * W_2 - R_12,
        B_T * P_1 * A: -W_1 * K_1 - transpose(R_12),
        B_T * P_2 * A: -W_2 * K_2 - transpose(R_12),
        B_T * P_1 * B: W_1 - R_2,
        B_T * P_2 * B: W_2 - R_2,
    }
    right = (A_T + K_T * B_T) * (P_1 - P_2) * (A + B * K_2)
    return bool(reduced(right - (P_1 - P_2), rules) == 0)
