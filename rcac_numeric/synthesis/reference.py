"""The reference loop: LQG with what the disturbance asks for, made robust."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import CompensatorError, NoSolutionError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.gramians import stein_solution
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.h2.conversion import converted
from rcac_numeric.h2.costs import loop_matrices
from rcac_numeric.h2.lqg import LQG, controller_matrices, lqg, weights
from rcac_numeric.h2.noise import noise_inputs, with_bias, with_oscillation
from rcac_numeric.h2.riccati.equations import stabilising_solution
from rcac_numeric.h2.riccati.obstacles import ESTIMATOR, REGULATOR
from rcac_numeric.h2.state_space import StateSpace
from rcac_numeric.margins.peaks import hinf_norm
from rcac_numeric.plants.linear import Plant
from rcac_numeric.synthesis.expected import Expected
from rcac_numeric.synthesis.plants import DesignPlant, Variation, balanced

MOST = 2.0  # peak of the sensitivity S that a reference loop may have
CONTROL = (1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0)  # R_2 over the square of the gain
NOISE = (1.0, 10.0, 100.0)  # factors of V_2
LASTS = 1 - 1e-6  # modulus of the disturbance model's poles: no control moves one at 1 itself
DRIFT = 1e-2  # of the disturbance: how far it moves in a step
LEAST_NOISE = 1e-5  # of what the disturbance makes of y: LQG without noise has no margins
LEAST_LEFT = 0.1  # of the actuator's range, whatever lasts of the disturbance
NEAR = 1e-6  # rad/step beside the pole of a disturbance model
SLOWEST = 1 - 1e-4  # spectral radius: one beside a zero at 1 is a hair from unstable
# Beside poles at LASTS no difference equation of several u has the response to 1e-9. What is to
# hold is the loop with it: its own peak is looked at.
CLOSE, CLOSER = 1e-4, 1e-2
OUT_OF_REACH = 1e-4  # of the plant's gain: what a zero leaves there

Models = dict[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Reference(Value):
    """A reference loop and what it was chosen by.

    Attributes
    ----------
    lqg : LQG
        In units in which the disturbance and its effect on y are 1.
    compensator : Compensator
        In the units of the plant: from e to u.
    peak : float
        Ms, the largest abs(S) over frequency; of several signals at u and at y.
    R_2, V_2 : float
        The weight of u, and that of the noise, over what is expected.
    units : (float, float)
        Those of u and y.
    """

    lqg: LQG
    compensator: Compensator
    peak: float
    R_2: float
    V_2: float
    units: tuple[float, float]

    def loop(self, plant: DesignPlant) -> ClosedLoop:
        """The nominal plant in a loop with it."""
        return ClosedLoop(plant.servo(), self.compensator)


def reference_loop(
    plant: DesignPlant, expected: Expected, u_range: float = np.inf,
    others: Sequence[Variation] = (),
) -> Reference:  # fmt: skip
    """The LQG controller of least cost on a ladder of weights whose loop is robust.

    Robust is: Ms <= 2, all poles inside 1 - 1e-4, and stable with every other plant. Where none is,
    the one that fails with the fewest of them, and of those the one with the smallest peak.

    z = [e; sqrt(R_2) (u + b)] with b what of d is not white: then the Riccati equation itself has
    the controller cancel b, whatever R_2 is.

    Parameters
    ----------
    plant : DesignPlant
    expected : Expected
        What of d is a constant or a sinusoid becomes a model of the disturbance: an integrator,
        an oscillator.
    u_range : float
        Half of what the actuator can do. What lasts of d is cancelled by u; the rest of u is to
        have a standard deviation of a third of what is left, at most.
    others : sequence of Variation
        What the plant may be instead.

    Raises
    ------
    NoSolutionError
        Where no rung of the ladder has a controller.
    """
    units = expected.size, plant.low_gain * expected.size
    scaled = _in_units(plant, units)
    models = _disturbance_models(expected, units)
    for omega, _ in models.values():
        _require_reach(plant, omega)
    blocks = [f"{channel}_{kind}" for channel in _channels_of_d(scaled) for kind in models]
    noise = {"d": (expected.white / units[0]) ** 2} | dict.fromkeys(blocks, 1.0)
    V = max(expected.noise / units[1], LEAST_NOISE) ** 2
    left = u_range - expected.lasting
    most_u = max(left, LEAST_LEFT * u_range) / (3 * units[0])
    instead = [_in_units(plant, units, one) for one in others]
    found, obstacle = [], ""
    for R_2, V_2, parts in _rungs(scaled, models, noise, V):
        try:
            peak = _peak(scaled, parts)
            if not np.isfinite(peak):
                continue
            lost = sum(not _radius(other, parts) < 1 for other in instead)
            lost += not _radius(scaled, parts) < SLOWEST
            robust = peak <= MOST and not lost
            e, u = _powers(scaled, models, parts, {**noise, "v": V})
            wide = u > most_u**2
            order = (wide, u if wide else e) if robust else (lost, peak)
            found.append((not robust, *order, R_2, V_2, peak))
        except CompensatorError as error:
            obstacle = f" The last obstacle: {error}"
    for *_, R_2, V_2, peak in sorted(found):
        try:
            best = lqg(_weighted(scaled, R_2, models), noise={**noise, "v": V * V_2})
            G_c = best.compensator if plant.m == 1 else converted(best.state_space, CLOSE)[0]
        except CompensatorError as error:
            obstacle = f" The last obstacle: {error}"
            continue
        made = Compensator(G_c.past_u, G_c.past_y * units[0] / units[1], plant.sample_time)
        if plant.m > 1 and not (
            sensitivity_peak(ClosedLoop(plant.servo(), made)) <= (1 + CLOSER) * peak
        ):
            obstacle = " The last obstacle: its difference equation has not its robustness."
            continue
        return Reference(best, made, peak, R_2, V_2, units)
    raise NoSolutionError(
        "no LQG controller with this disturbance model stabilises the plant in float64; reduce "
        f"its order or its dead time, or sample more slowly.{obstacle}"
    )


def _require_reach(plant: DesignPlant, omega: float) -> None:
    """Refuse a disturbance model with its pole at a zero of the plant."""
    if np.linalg.norm(plant.response(omega + NEAR)[0], -2) < OUT_OF_REACH * plant.low_gain:
        what = "a constant" if omega == 0 else f"a sinusoid of {omega:.4g} rad/step"
        raise NoSolutionError(
            f"the plant has a zero where {what} has its pole: no controller rejects it. Choose "
            "another measurement or actuator; or, for noise alone, say disturbance=WhiteNoise(...)."
        )


def _in_units(
    plant: DesignPlant, units: tuple[float, float], changed: Variation | None = None
) -> Plant:
    """The servo problem in these units of u and y, its states of like size."""
    servo = plant.servo(changed)
    B, C = servo.B * units[0], servo.C / units[1]
    A, B, C = balanced(servo.A, B, C)
    none = np.zeros_like(B)
    return replace(servo, A=A, B=B, C=C, E_1=C, D_1=np.hstack([none, B, none]))


def _channels_of_d(plant: Plant) -> tuple[str, ...]:
    """The names of the components of d, which follow those of r."""
    return tuple(plant.channels[plant.l_y : plant.l_y + plant.l_u])


def _disturbance_models(expected: Expected, units: tuple[float, float]) -> Models:
    """From kinds to (frequency, mean square) of what each d carries beside white noise."""
    found: Models = {}
    stays = max(expected.lasting / units[0], expected.largest_command / units[1])
    drive = DRIFT**2 / (1 - LASTS**2)
    if stays:
        found["bias"] = 0.0, stays**2 * drive
    for omega, amplitude in expected.sinusoids[:1]:
        found["oscillation"] = omega, (amplitude / units[0]) ** 2 * drive
    return found


def _weighted(plant: Plant, R_2: float, models: Models) -> Plant:
    """Z = [e; sqrt(R_2) (u + d)], with the disturbance models on d."""
    m = plant.l_u
    none, rho = np.zeros((m, m)), np.sqrt(R_2) * np.eye(m)
    made = replace(
        plant,
        E_1=np.vstack([plant.E_1, np.zeros((m, plant.n))]),
        E_2=np.vstack([none, rho]),
        E_0=np.vstack([plant.E_0, np.hstack([none, rho, none])]),
    )
    for channel in _channels_of_d(plant):
        if "bias" in models:
            made = with_bias(made, channel, pole=LASTS, mean_square=models["bias"][1])
        if "oscillation" in models:
            omega, power = models["oscillation"]
            made = with_oscillation(made, channel, omega=omega, radius=LASTS, mean_square=power)
    return made


def _rungs(
    plant: Plant, models: Models, noise: dict[str, float], V: float
) -> Iterator[tuple[float, float, StateSpace]]:
    """The LQG controllers of the ladder: two Riccati equations for each side, not for each rung."""
    regulators, estimators = {}, {}
    for R_2 in CONTROL:
        made = _weighted(plant, R_2, models)
        try:
            regulators[R_2] = stabilising_solution(
                made.A, made.B, weights(made.E_1, made.E_2), (made.E_1, made.E_2), REGULATOR
            )
        except CompensatorError:
            continue
    made = _weighted(plant, 1.0, models)
    for V_2 in NOISE:
        inputs = noise_inputs(made, {**noise, "v": V * V_2})
        pair = inputs.D_1.T, inputs.D_2.T
        try:
            estimators[V_2] = stabilising_solution(
                made.A.T, made.C.T, weights(*pair), pair, ESTIMATOR
            )
        except CompensatorError:
            continue
    none = np.zeros((plant.l_u, plant.l_y))
    for V_2, estimator in estimators.items():
        for R_2, regulator in regulators.items():
            gains = regulator.gain, -estimator.gain.T
            yield R_2, V_2, controller_matrices(made, *gains, none)


def _peak(plant: Plant, parts: StateSpace) -> float:
    """Ms, the peak of S = (I - G_c G_yu)^-1 at u and at y; infinite where the loop is unstable."""
    A_c, B_c, C_c, _ = parts
    if not _radius(plant, parts) < 1:
        return np.inf
    A, eye = _closed(plant, parts), np.eye(plant.l_u)
    at_u = np.vstack([plant.B, np.zeros((len(A_c), plant.l_u))])
    of_u = np.hstack([np.zeros((plant.l_u, plant.n)), C_c])
    peak = hinf_norm((A, at_u, of_u, eye), rtol=1e-4)[0]
    if plant.l_u == 1:
        return peak
    at_y = np.vstack([np.zeros((plant.n, plant.l_y)), B_c])
    of_y = np.hstack([plant.C, np.zeros((plant.l_y, len(A_c)))])
    return max(peak, hinf_norm((A, at_y, of_y, eye), rtol=1e-4)[0])


def _closed(plant: Plant, parts: StateSpace) -> Array:
    """A of the loop with a strictly proper controller."""
    A_c, B_c, C_c, _ = parts
    return np.block([[plant.A, plant.B @ C_c], [B_c @ plant.C, A_c]])


def _radius(plant: Plant, parts: StateSpace) -> float:
    """The spectral radius of the loop."""
    return float(np.abs(np.linalg.eigvals(_closed(plant, parts))).max())


def _powers(
    plant: Plant, models: Models, parts: StateSpace, noise: dict[str, float]
) -> tuple[float, float]:
    """E[e_0^2] and E[(u + b)^2] under what is expected; the means of several."""
    made = _weighted(plant, 1.0, models)
    m = plant.l_u
    E_0 = np.zeros((2 * m, made.l_w))
    E_0[:m, :m] = np.eye(m)  # of the noise v only what comes back through the loop is an error
    inputs = noise_inputs(replace(made, E_0=E_0), noise)
    A, B, (E_x, E_w), (K_x, K_w) = loop_matrices(made, parts, inputs)
    covariance = stein_solution(A, B @ B.T)
    Z, W = E_x + made.E_2 @ K_x, E_w + made.E_2 @ K_w
    powers = np.einsum("ij,jk,ik->i", Z, covariance, Z) + np.sum(W**2, axis=1)
    return float(np.mean(powers[:m])), float(np.mean(powers[m:]))


def sensitivity_peak(loop: ClosedLoop) -> float:
    """Ms of a loop, the peak of S over frequency, at u and at y; infinite where it is unstable.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, standard_plant
    >>> from rcac_numeric.synthesis.reference import sensitivity_peak
    >>> still = Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[0.0]]])
    >>> sensitivity_peak(ClosedLoop(standard_plant("1/(q - 0.5)"), still))
    1.0
    """
    if not loop.is_stable:
        return np.inf
    A_c, B_c, C_c, D_c = loop.compensator.state_space()
    plant = loop.plant
    if D_c.any():
        raise NoSolutionError("the peak is found for strictly proper controllers.")
    return _peak(plant, (A_c, B_c, C_c, D_c))
