"""The H2 cost of a loop, and the controller whose cost is least: high-authority LQG."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.closed_loop import ClosedLoop
from rcac_numeric.compensators import Compensator
from rcac_numeric.plants import Plant


def h2_cost(loop: ClosedLoop) -> float:
    """The variance of z for white w of unit variance, (4.21); infinite for an unstable loop.

    (4.21) leaves out the direct term E_0; it is counted here.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, standard_plant
    >>> from rcac_numeric.h2_costs import h2_cost
    >>> none = Compensator(P=[[[0.0]]], Q=[[[0.0]], [[0.0]]])
    >>> round(h2_cost(ClosedLoop(standard_plant("1/(q - 0.6)"), none)), 6)  # 1 / (1 - 0.36)
    1.5625
    """
    from scipy.linalg import solve_discrete_lyapunov

    if not loop.is_stable:
        return float("inf")
    A, B, C, D = loop.matrices
    l_w, l_z = loop.plant.l_w, loop.plant.l_z
    covariance = solve_discrete_lyapunov(A, B[:, :l_w] @ B[:, :l_w].T)
    return float(np.trace(C[:l_z] @ covariance @ C[:l_z].T) + np.sum(D[:l_z, :l_w] ** 2))


def high_authority_compensator(plant: Plant) -> Compensator:
    """The LQG controller (A.4)-(A.6) with R_2 = 0 and V_2 = 0, for scalar signals.

    Raises
    ------
    InputError
        Where a signal is not scalar, or the controller is not rational.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.h2_costs import high_authority_compensator
    >>> high_authority_compensator(standard_plant("(q - 2)/(q**2 - 1/4)")).denominator
    array([ 1. , -1. ,  0.4])
    """
    from compensator_theory import high_authority_lqg

    exact = high_authority_lqg(plant.problem).compensator
    if exact is None:
        raise InputError("the high-authority LQG controller of this plant is not rational.")
    D_c = [float(c) for c in exact.denominator.monic().all_coeffs()]
    leading = exact.denominator.LC()
    N_c = [float(c / leading) for c in exact.numerator.all_coeffs()]
    N_c = [0.0] * (len(D_c) - len(N_c)) + N_c
    return Compensator(-np.array(D_c[1:])[:, None, None], np.array(N_c)[:, None, None])
