"""Recursive least squares: (2.42)-(2.44) minimise the cost (2.41), any sizes and any lambda.

By induction the cost up to k - 1 is a constant plus (theta - theta_k)' P^-1 (theta - theta_k). The
next cost is lambda times that plus z^'R_z z^ + (Phi theta)'R_u(Phi theta), where
z^ = Phi theta + e, e = z - u_f. With R = R_z + R_u and Upsilon = lambda R^-1 + Phi P Phi' it is
enough that P+ inverts the new Hessian and that the gradient vanishes at theta+.
"""

from sympy import Expr, Symbol, expand, transpose

from .letters import letters, reduced

P, Phi, R, R_z, Upsilon, e, theta, theta_k = letters("P Phi R R_z Upsilon e theta theta_k")
forgetting = Symbol("lambda", positive=True)
Phi_T = transpose(Phi)
REDUCE = {Phi * P * Phi_T: Upsilon - forgetting * R**-1}
HESSIAN = forgetting * P**-1 + Phi_T * R * Phi
P_NEXT = (P - P * Phi_T * Upsilon**-1 * Phi * P) / forgetting  # (2.43)
INNOVATION = Phi * theta_k + R**-1 * R_z * e
THETA_NEXT = theta_k - P * Phi_T * Upsilon**-1 * INNOVATION  # (2.42)


def gradient(at: Expr) -> Expr:
    """Return half the gradient of the next cost, R_u = R - R_z."""
    return forgetting * P**-1 * (at - theta_k) + Phi_T * (
        R_z * (Phi * at + e) + (R - R_z) * Phi * at
    )


def covariance_inverts_hessian() -> bool:
    """(2.43), (2.44): P(k+1) (lambda P(k)^-1 + Phi'(R_z + R_u)Phi) = 1, from both sides."""
    left = reduced(P_NEXT * HESSIAN, REDUCE)
    right = reduced(HESSIAN * P_NEXT, REDUCE)
    return bool(left == 1 and right == 1)


def gradient_vanishes() -> bool:
    """(2.42): the gradient of the cost is 0 at theta(k+1)."""
    return bool(reduced(gradient(THETA_NEXT), REDUCE) == 0)


def gradient_is_affine() -> bool:
    """The gradient is the Hessian times (theta - theta+), once it vanishes at theta+."""
    difference = gradient(theta) - gradient(theta_k) - HESSIAN * (theta - theta_k)
    return bool(expand(difference) == 0)


def gain_of_new_covariance() -> bool:
    """P(k) Phi' Upsilon^-1 = P(k+1) Phi'(R_z + R_u): the gain of (8.62) is that of (2.42)."""
    left = P * Phi_T * Upsilon**-1
    return bool(reduced(P_NEXT * Phi_T * R - left, REDUCE) == 0)


def kalman_predictor() -> bool:
    """(2.46) is the Riccati equation (8.100) of the pair (I, Phi) with the process noise Q(k)."""
    A, C, V, Q, W = letters("A C V Q W")  # W = (C Q C' + V_2)^-1
    printed = A * Q * transpose(A) + V - A * Q * transpose(C) * W * C * Q * transpose(A)
    predictor = printed.subs({transpose(A): 1, A: 1})
    gain = V + (P_NEXT * forgetting).subs({P: Q, Upsilon: W**-1, Phi: C, Phi_T: transpose(C)})
    return bool(expand(predictor - gain) == 0)
