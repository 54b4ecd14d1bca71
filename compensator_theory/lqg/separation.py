"""What regulator and estimator make together: the closed-loop polynomial and the controller."""

from typing import TypeAlias

import sympy
from sympy import ImmutableMatrix, Poly

from compensator_theory.polynomials.poly import canonical
from compensator_theory.roots.enclosures import PolynomialEnclosure
from compensator_theory.roots.half_plane_factors import HalfPlaneFactor
from compensator_theory.roots.spectral_factors import SpectralFactor
from compensator_theory.roots.unit_circle_enclosures import multiply_enclosures
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.systems.state_space import transfer_matrix_of_realisation
from compensator_theory.transfer_functions.transfer_functions import TransferFunction

Factor: TypeAlias = SpectralFactor | HalfPlaneFactor
ControllerMatrices: TypeAlias = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]


def product_of_factors(regulator: Factor, estimator: Factor) -> Poly | None:
    """Return the closed-loop polynomial if both factors are rational, else None.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> from compensator_theory.lqg.separation import product_of_factors
    >>> product_of_factors(spectral_factor("z - 2"), spectral_factor("z")).as_expr()
    z**2 - z/2
    """
    if regulator.polynomial is None or estimator.polynomial is None:
        return None
    return canonical(regulator.polynomial * estimator.polynomial)


def enclosed_product(regulator: Factor, estimator: Factor) -> PolynomialEnclosure:
    """Return the closed-loop polynomial, certified.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> from compensator_theory.lqg.separation import enclosed_product
    >>> print(enclosed_product(spectral_factor("z - 2"), spectral_factor("z")))
    z**2 - 1/2*z
    """
    return multiply_enclosures(regulator.enclosure, estimator.enclosure)


def controller_matrices(
    plant: StandardProblem, K: ImmutableMatrix | None, L: ImmutableMatrix | None
) -> ControllerMatrices | None:
    r"""Return (A_c, B_c, C_c) of (A.4)-(A.6) out of the gains of both regulators.

    .. math:: C_c = K, \qquad B_c = -L^T, \qquad A_c = A + BC_c - B_cC - B_cD_0C_c

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.lqg.separation import controller_matrices
    >>> K = ImmutableMatrix([[-2]])
    >>> controller_matrices(standard_problem("1/(q - 2)"), K, K)
    (Matrix([[-2]]), Matrix([[2]]), Matrix([[-2]]))
    """
    if K is None or L is None:
        return None
    B_c, C_c = -L.T, K
    A_c = plant.A + plant.B * C_c - B_c * plant.C - B_c * plant.D_0 * C_c
    return ImmutableMatrix(A_c), ImmutableMatrix(B_c), ImmutableMatrix(C_c)


def scalar_controller(
    plant: StandardProblem, matrices: ControllerMatrices | None
) -> TransferFunction | None:
    """Return the compensator of order n for u = G_c y of a plant with scalar u and y.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.lqg.separation import controller_matrices, scalar_controller
    >>> plant, K = standard_problem("1/(q - 2)"), ImmutableMatrix([[-2]])
    >>> print(scalar_controller(plant, controller_matrices(plant, K, K)))
    (-4)/(q + 2)
    """
    if matrices is None:
        return None
    direct = sympy.zeros(1, 1)
    return transfer_matrix_of_realisation(*matrices, direct, plant.variable).scalar()
