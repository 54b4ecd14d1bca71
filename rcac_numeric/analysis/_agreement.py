"""Comparison of float64 and exact closed-loop poles of LQG."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sympy import Matrix

import compensator_theory as theory
from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis._noise import NoiseInputs
from rcac_numeric.analysis._solutions import StabilisingSolution
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._pairing import pairing
from rcac_numeric.arrays._values import Result
from rcac_numeric.plants._linear import Plant


@dataclass(frozen=True, eq=False)
class ExactAgreement(Result):
    """The distance of the float64 LQG poles to the exact ones.

    Attributes
    ----------
    exact : compensator_theory.results.LQGPoles or None
        The polynomials of A + BC_c and A - B_cC over the rationals, or in certified balls.
    reason : str
        The reason why `exact` is None; empty otherwise.
    coefficient_distance : float or None
        Largest difference between coefficients of the two polynomials and the exact ones, each
        over the largest exact coefficient of its polynomial.
    pole_distance : float or None
        Largest distance between poles paired one to one. A pole of multiplicity d moves by the
        d-th root of a rounding error, so judge by the coefficients.
    """

    exact: theory.results.LQGPoles | None
    reason: str
    coefficient_distance: float | None
    pole_distance: float | None

    def __repr__(self) -> str:
        if self.exact is None:
            return f"ExactAgreement(None: {self.reason})"
        return (
            f"ExactAgreement(coefficients {self.coefficient_distance:.1e}, "
            f"poles {self.pole_distance:.1e})"
        )


def exact_agreement(
    plant: Plant,
    inputs: NoiseInputs,
    regulator: StabilisingSolution,
    estimator: StabilisingSolution,
) -> ExactAgreement:
    """Compare the poles with `compensator_theory.lqg_poles`, exact for any R_2 and V_2."""
    try:
        D_1, D_2 = _exact_noise_inputs(plant, inputs)
        p = plant.problem
        exact = theory.lqg_poles(
            theory.StandardProblem(
                A=p.A, B=p.B, C=p.C, D_1=D_1, D_0=p.D_0, D_2=D_2, E_1=p.E_1, E_2=p.E_2, E_0=None,
                variable=p.variable,
            )
        )  # fmt: skip
    except CompensatorError as error:
        return ExactAgreement(None, str(error), None, None)
    coefficients, poles = 0.0, 0.0
    for solution, factor in ((regulator, exact.regulator), (estimator, exact.estimator)):
        centre = factor.enclosure.centre
        target = np.array([float(c) for c in centre.all_coeffs()])
        reached = _characteristic_polynomial(solution)
        gap = np.abs(reached - target).max() / np.abs(target).max()
        coefficients = max(coefficients, float(gap))
        poles = max(poles, _pole_distance(centre, solution.poles))
    return ExactAgreement(exact, "", coefficients, poles)


def _exact_noise_inputs(plant: Plant, inputs: NoiseInputs) -> tuple[Matrix, Matrix]:
    """Return exact (D_1, D_2); the factor of the intensities is rounded to float64 first."""
    entries = [theory.exact_number(float(c)) for c in inputs.factor.ravel()]
    factor = Matrix(*inputs.factor.shape, entries)
    return plant.problem.D_1 * factor, plant.problem.D_2 * factor


def _characteristic_polynomial(solution: StabilisingSolution) -> Array:
    return np.real(np.poly(solution.poles)) if len(solution.poles) else np.ones(1)


def _pole_distance(polynomial: object, poles: ComplexArray) -> float:
    exact = [r.value for r in theory.certified_roots(polynomial) for _ in range(r.multiplicity)]
    pairs = pairing(np.array(exact, dtype=np.complex128), poles)
    return max((abs(a - b) for a, b in pairs), default=0.0)
