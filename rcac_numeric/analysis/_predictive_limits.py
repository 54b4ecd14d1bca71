"""The final controller of predictive cost adaptive control compared with its exact limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sympy import Poly

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.analysis._exact_comparison import (
    exact_polynomials,
    on_circle,
    polynomial_roots,
    relative_change,
    values_at,
)
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._pairing import pairing
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._schedules import plant_at


@dataclass(frozen=True, eq=False)
class PredictiveCostLimit(Result):
    """A final predictive cost adaptive controller beside the one of the true plant.

    Attributes
    ----------
    limit : compensator_theory.results.PredictiveCostCompensator
        The exact compensator for the true plant, the horizon and the weights of the settings.
    compensator : Compensator
        The final one, from y_0 to u and without limits.
    K : array, shape (1, n)
        The gain of the final model.
    predicted : sympy.Poly
        Of degree 2n: `limit.regulator` times a power of q.
    reached : sympy.Poly
        D D_c - N N_c of the true plant and the final compensator, whose float64 coefficients are
        dyadic rationals; exact.
    """

    limit: exact.results.PredictiveCostCompensator
    compensator: Compensator
    K: Array
    predicted: Poly
    reached: Poly

    @property
    def poles(self) -> ComplexArray:
        """The poles of the loop, by certified isolation."""
        return polynomial_roots(self.reached)

    @property
    def predicted_poles(self) -> ComplexArray:
        """The poles that the limit has, by certified isolation."""
        return polynomial_roots(self.predicted)

    @property
    def pairs(self) -> list[tuple[complex, complex]]:
        """Pairs (predicted pole, pole), matched one to one."""
        return pairing(self.predicted_poles, self.poles)

    @property
    def worst_distance(self) -> float:
        """Largest distance of a pair."""
        return max(abs(a - b) for a, b in self.pairs)

    @property
    def backward_error(self) -> float:
        """Relative change of the polynomial on the unit circle, the largest over the frequencies.

        abs(reached - predicted)/max(abs(reached), abs(predicted)); 1 or more says that the two
        loops need not be stable together.
        """
        q = on_circle(self.poles, self.predicted_poles)
        return relative_change(values_at(q, self.poles), values_at(q, self.predicted_poles))

    @property
    def gain_error(self) -> float:
        """Norm of the difference of the final and the exact K, relative to the exact one."""
        K = np.array(self.limit.K.tolist(), dtype=np.float64)
        size = float(np.linalg.norm(K))
        return float(np.linalg.norm(self.K - K)) / size if size else float("inf")

    def __str__(self) -> str:
        predicted, poles = (np.abs(p).max() for p in (self.predicted_poles, self.poles))
        return (
            f"Exact limit: {self.limit.regulator.degree()} regulator poles and "
            f"{self.predicted.degree() - self.limit.regulator.degree()} at 0, spectral radius "
            f"{predicted:.6g}\n"
            f"Final loop: spectral radius {poles:.6g}, largest distance of a pole "
            f"{self.worst_distance:.3g}\n"
            f"Backward error of the polynomial {self.backward_error:.3g}, of the gain "
            f"{self.gain_error:.3g}"
        )

    def __repr__(self) -> str:
        return (
            f"PredictiveCostLimit(worst_distance={self.worst_distance:.3g}, "
            f"backward_error={self.backward_error:.3g})"
        )


def predictive_cost_limit(run: Run) -> PredictiveCostLimit:
    """Compare the final controller of a `PredictiveCost` run with the exact limit.

    The limit is the compensator for the true plant: q^n chi(A + B K) with the gain K of the exact
    finite-horizon problem. Limits of u do not enter.

    Parameters
    ----------
    run : Run
        Of a `PredictiveCost` of one input and one output on a linear plant, of its last step.

    Raises
    ------
    InputError
        Where it is a run of another controller or of a nonlinear plant, signals are not scalar, or
        the order is not that of the plant: a model of higher order has common factors that depend
        on the data, and one of lower order is not the plant.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     PredictiveCost, Step, exogenous, predictive_cost_limit, servo_plant, simulate)
    >>> plant = servo_plant("(q - 2/5)/(q**2 + q/2 - 1/10)")
    >>> settings = PredictiveCost(
    ...     order=2, horizon=5, Q=2, P=5, problem="servo", R_theta=1e-8)
    >>> run = simulate(plant, settings, exogenous([Step(), Step(0), Step(0)], steps=100))
    >>> comparison = predictive_cost_limit(run)
    >>> comparison.worst_distance < 1e-3, comparison.limit.certificate.holds
    (True, True)
    """
    settings = instance_of(run, "run", Run).settings
    if not isinstance(settings, PredictiveCost):
        raise InputError(
            f"the run is of a {type(settings).__name__}; this comparison is for PredictiveCost. "
            "Use compare_exactly for a target model."
        )
    if isinstance(run.plant, FunctionPlant):
        raise InputError("the plant is nonlinear; an exact limit needs a linear plant.")
    if settings.l_u != 1 or settings.l_y != 1:
        raise InputError(
            f"the plant has l_u = {settings.l_u} and l_y = {settings.l_y}; the comparison is for "
            "scalar signals. Use compensator_theory.predictive_cost_compensator((b, a), ...)."
        )
    if not run.steps:
        raise InputError("the run has no completed step.")
    plant = plant_at(run.plant, run.first_step + run.steps - 1)
    sign = -1 if settings.problem == "servo" else 1
    G = plant.problem.transfer_function("yu") * sign
    if G.denominator.degree() != settings.order:
        raise InputError(
            f"order = {settings.order}, and the plant has degree {G.denominator.degree()}: the "
            "final model is not determined by the plant. Use order="
            f"{G.denominator.degree()}, or compare with "
            "compensator_theory.predictive_cost_compensator of settings.model(theta)."
        )
    Q, P, R = (
        exact.exact_number(float(weight[0, 0]), binary=True)
        for weight in (settings.Q, settings.P, settings.R)
    )
    limit = exact.predictive_cost_compensator(
        G, horizon=settings.horizon, Q=Q, P=P, R=R, weighs=settings.weighs
    )
    whole = settings.compensator_of(run.theta_final)
    compensator = Compensator(whole.past_u, sign * whole.past_y[:, :, :1])
    N_c, D_c = exact_polynomials(compensator)
    q = limit.regulator.gen
    N_c, D_c = (part.replace(part.gen, q) for part in (N_c, D_c))
    reached = G.denominator * D_c - G.numerator * N_c
    lower = 2 * settings.order - limit.regulator.degree()
    return PredictiveCostLimit(
        limit=limit,
        compensator=compensator,
        K=settings.gain(run.theta_final)[0],
        predicted=limit.regulator * Poly(q**lower, q),
        reached=reached.monic(),
    )
