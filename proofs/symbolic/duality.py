"""Regulator and estimator are dual: A, B, R become A', C', V. Letters are matrices of any size."""

from sympy import expand, transpose

from .letters import dual, letters

A, B, C, P, Q, R_1, R_2, V_1, V_2 = letters("A B C P Q R_1 R_2 V_1 V_2")
W, U = letters("W U")  # (R_2 + B'PB)^-1 and (V_2 + CQC')^-1
RENAMED = {A: transpose(A), B: transpose(C), P: Q, R_1: V_1, R_2: V_2, W: U}


def riccati_equations() -> bool:
    """The transpose of (8.96), renamed, is (8.100)."""
    regulator = transpose(A) * P * A + R_1 - transpose(A) * P * B * W * transpose(B) * P * A
    estimator = A * Q * transpose(A) + V_1 - A * Q * transpose(C) * U * C * Q * transpose(A)
    return bool(expand(dual(regulator, RENAMED) - estimator) == 0)


def gains() -> bool:
    """The gain (8.95), renamed, is -F' of (8.99)."""
    K = -W * transpose(B) * P * A
    F = A * Q * transpose(C) * U
    return bool(expand(dual(K, RENAMED) + F) == 0)


def weights() -> bool:
    """R_2 + B'PB, renamed, is V_2 + CQC'."""
    regulator, estimator = R_2 + transpose(B) * P * B, V_2 + C * Q * transpose(C)
    return bool(expand(dual(regulator, RENAMED) - estimator) == 0)
