"""The reference loop: a robust LQG controller with models of the disturbance."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from compensator_theory.errors import CompensatorError, NoSolutionError
from rcac_numeric.analysis._closed_loop import ClosedLoop, frozen_loop
from rcac_numeric.analysis._conversion import converted
from rcac_numeric.analysis._costs import loop_matrices
from rcac_numeric.analysis._equations import stabilising_solution
from rcac_numeric.analysis._gramians import stein_solution
from rcac_numeric.analysis._lqg import LQG, controller_matrices, lqg_controller, weights
from rcac_numeric.analysis._noise import noise_inputs, with_bias, with_oscillation
from rcac_numeric.analysis._obstacles import ESTIMATOR, REGULATOR
from rcac_numeric.analysis._peaks import hinf_norm
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._values import Value, replaced
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.designing._expected import KINDS, Expected
from rcac_numeric.designing._plants import DesignPlant, Variation, balanced
from rcac_numeric.engine._batches import SimulationCase, simulate_many
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation

MOST = 2.0  # peak of the sensitivity S that a reference loop may have
CONTROL = (1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0)  # R_2 over the square of the gain
NOISE = (1.0, 10.0, 100.0)  # factors of V_2
# With limits of u: a gain that exceeds them at every step of y gives a limit cycle between them.
CALMER = (1e-9, 1e-4, 1e-2, 1.0, 10.0, 100.0)
NOISIER = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6)
TRIED = 1000  # steps of a simulation with the actuator
NEARLY = 1.1  # times the least rms of the error: among those the one with least u is taken
LEARNING = 1_000  # the first seed of the runs that choose settings
BIAS, SLOPE = "bias", "bias_bias"  # models of a constant and of a ramp, an integrated constant
# Where rivals of a model are to be held, too, slower loops are tried.
SLOWER = (1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0)
SLOWER_OBSERVER = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5)
LASTS = 1 - 1e-6  # modulus of the disturbance model's poles: one at 1 is not stabilisable
DRIFT = 1e-2  # of the disturbance: how far it moves in a step
LEAST_NOISE = 1e-5  # of the disturbance's effect on y: LQG without noise has no margins
LEAST_LEFT = 0.1  # of the actuator's range, whatever a lasting disturbance takes
NEAR = 1e-6  # rad/step beside the pole of a disturbance model
SLOWEST = 1 - 1e-4  # spectral radius of a usable loop; a zero at 1 pulls a pole beyond it
# With poles at LASTS no difference equation of several u has the response to 1e-9, so the peak of
# the loop with it is computed instead.
CLOSE, CLOSER = 1e-4, 1e-2
OUT_OF_REACH = 1e-4  # of the plant's gain: the remainder at a zero
HIDDEN = 1e-9  # of the largest singular value: a mode that is not controllable, or not observable
FALLS = 0.2  # of the gain ten times as far from the zero, where a zero leaves a tenth

Models = dict[str, tuple[float, float]]
Weights = tuple[float, float]  # R_2 and V_2
Candidates = Mapping[Weights, StateSpace]


@dataclass(frozen=True, eq=False)
class Reference(Value):
    """A reference loop and its weights.

    Attributes
    ----------
    problem : Plant
        Of the LQG controller, in units in which the disturbance and its effect on y are 1.
    noise : mapping
        The intensities of its noise.
    compensator : Compensator
        In the units of the plant: from e to u, or from [e; r].
    peak : float
        Ms, the largest abs(S) over frequency; of several signals at u and at y.
    R_2, V_2 : float
        The weight of u, and that of the noise over the expected one.
    units : (float, float)
        Those of u and y.
    structure, theta : Structure and array, or None
        Of a controller that is reduced to a structure.
    full : Compensator or None
        The LQG controller that it was reduced from.
    """

    problem: Plant
    noise: Mapping[str, float]
    compensator: Compensator
    peak: float
    R_2: float
    V_2: float
    units: tuple[float, float]
    structure: Structure | None = None
    theta: Array | None = None
    full: Compensator | None = None

    @property
    def commands(self) -> int:
        """The number of commands that the compensator reads."""
        return self.compensator.l_y - self.problem.l_y

    @cached_property
    def lqg(self) -> LQG:
        """The LQG controller with its cost, in the units of `problem`.

        Raises
        ------
        IllConditionedError
            Where rounding decides the cost of its loop with the disturbance models.
        """
        return lqg_controller(self.problem, noise=self.noise)

    @property
    def fixed(self) -> FixedController:
        """The compensator as a controller that runs."""
        return FixedController(self.compensator, l_r=self.commands)

    def loop(self, plant: DesignPlant) -> ClosedLoop:
        """The closed loop with the nominal plant."""
        return frozen_loop(plant.servo(), self.compensator, 0)


@dataclass(frozen=True)
class LoopEvaluation:
    """The evaluation of a controller on the plants of a weight grid.

    Attributes
    ----------
    lost : int
        Plants that it does not stabilise, and one more if the nominal loop is nearly unstable.
    peak : float
        Ms with the nominal plant; infinite where that loop is unstable.
    error, control : float
        E[e_0^2] and E[(u + b)^2] under the expected signals, in units of the grid.
    most : float
        The limit of `control`.
    """

    lost: int
    peak: float
    error: float = np.inf
    control: float = np.inf
    most: float = np.inf

    @property
    def wide(self) -> float:
        """The control power over its limit; u exceeds the actuator's range above 1."""
        return float(self.control / self.most)

    @property
    def safe(self) -> tuple[bool, int]:
        """The sort key of robustness, which precedes the error."""
        is_robust = self.peak <= MOST and not self.lost
        return not is_robust, 0 if is_robust else self.lost

    @property
    def order(self) -> tuple[bool, float, float]:
        """The sort key: robust, u in the actuator's range, least error; else most robust."""
        if self.peak <= MOST and not self.lost:
            is_wide = self.wide > 1
            return False, float(is_wide), self.control if is_wide else self.error
        return True, float(self.lost), self.peak


Evaluated = tuple[LoopEvaluation, float, float]


class WeightGrid:
    """The LQG controllers of a plant on a grid of weights, and their evaluation.

    z = [e; sqrt(R_2) (u + b)] with b the part of d that is not white: the optimal controller then
    cancels b for every R_2.

    Attributes
    ----------
    blocked : tuple of float
        Frequencies, in rad/step, of parts of d that a zero of the plant blocks. The controller has
        no model of them, since the zero would cancel its poles.
    """

    def __init__(
        self, plant: DesignPlant, expected: Expected, u_range: float = np.inf,
        others: Sequence[Variation] = (), saturation: Saturation | None = None,
        rivals: Sequence[DesignPlant] = (),
    ) -> None:  # fmt: skip
        self.plant, self.units = plant, (expected.size, plant.low_gain * expected.size)
        self.expected, self.saturation = expected, saturation
        self.scaled = _in_units(plant, self.units)
        self.models = _disturbance_models(expected, self.units)
        self.blocked = _without_blocked(self.models, plant, expected)
        blocks = [f"{c}_{kind}" for c in _channels_of_d(self.scaled) for kind in self.models]
        self.noise: dict[str, float] = {"d": (expected.white / self.units[0]) ** 2}
        self.noise |= dict.fromkeys(blocks, 1.0)
        self.noise_variance = max(expected.noise / self.units[1], LEAST_NOISE) ** 2
        left = u_range - expected.lasting
        self.most_u = max(left, LEAST_LEFT * u_range) / (3 * self.units[0])
        self.others, self.rivals = others, rivals
        self.instead = [_in_units(plant, self.units, one) for one in others]
        self.instead += [_in_units(one, self.units) for one in rivals]

    def judged(self, parts: StateSpace) -> LoopEvaluation:
        """Evaluate a controller (A_c, B_c, C_c, D_c) from e to u, in units of the grid."""
        try:
            lost = sum(not loop_radius(other, parts) < 1 for other in self.instead)
            lost += not loop_radius(self.scaled, parts) < SLOWEST
            peak = _peak(self.scaled, parts)
            if not np.isfinite(peak):
                return LoopEvaluation(lost, peak)
            return LoopEvaluation(lost, peak, *self._powers(parts), self.most_u**2)
        except CompensatorError:
            return LoopEvaluation(len(self.instead) + 1, np.inf)

    def _powers(self, parts: StateSpace) -> tuple[float, float]:
        """E[e_0^2] and E[(u + b)^2] under the expected signals."""
        noise = {**self.noise, "v": self.noise_variance}
        return _powers(self.scaled, self.models, parts, noise)

    def candidates(self) -> Iterator[tuple[float, float, StateSpace]]:
        """Yield R_2, V_2 and the LQG controller of every candidate that exists."""
        free = self.saturation is None
        factors: tuple[Sequence[float], Sequence[float]] = CALMER, NOISIER
        if free:
            factors = (SLOWER, SLOWER_OBSERVER) if self.rivals else (CONTROL, NOISE)
        yield from _grid_candidates(
            self.scaled, self.models, self.noise, self.noise_variance, factors
        )

    def in_units(self, G_c: Compensator) -> Compensator:
        """Convert a controller from units of the grid to those of the plant."""
        by = self.units[0] / self.units[1]
        return Compensator(G_c.past_u, G_c.past_y * by, self.plant.sample_time)

    def in_runs(self, compensators: Sequence[Compensator]) -> list[int]:
        """Sort controllers, in units of the plant, by runs with limits; return their indices.

        The first one stays the first if its error, over the nominal plant and the others, is
        within a tenth of the least. Otherwise the one within it whose u moves least comes first:
        linear theory does not cover the limits.
        """
        if not compensators:
            return []
        m = self.plant.m
        runs = self._runs(compensators)
        errors, moves = np.full((2, len(runs)), np.inf)
        for i, run in enumerate(runs):
            if run.outcome == "completed":
                errors[i] = np.mean((run.z + run.w[:, -m:]) ** 2)
                moves[i] = np.mean(np.diff(run.u_applied, axis=0) ** 2)
        error, move = (one.reshape(len(compensators), -1).mean(axis=1) for one in (errors, moves))
        near = error <= NEARLY**2 * error.min(initial=np.inf)
        if near[:1].any():
            move[0] = -1.0
        return [int(i) for i in np.lexsort((np.where(near, move, error), ~near))]

    def _runs(self, compensators: Sequence[Compensator]) -> list[Run]:
        """Run each controller with the limits, on all plants and draws."""
        draws = range(1 if self.expected.is_known else len(KINDS))
        plants = [Variation(), *self.others]
        ws = {one.noise: [self.expected.w(TRIED, LEARNING + i, one.noise) for i in draws]
              for one in plants}  # fmt: skip
        options = {"saturation": self.saturation}
        cases = [
            SimulationCase(servo, FixedController(G_c), w, options)
            for G_c in compensators
            for servo, one in zip(map(self.plant.servo, plants), plants, strict=True)
            for w in ws[one.noise]
        ]
        return simulate_many(cases, threads=1)

    def without_limits(self) -> WeightGrid:
        """Return the grid for an actuator without limits."""
        return WeightGrid(self.plant, self.expected, others=self.others, rivals=self.rivals)

    def reaches_limits(self, G_c: Compensator) -> bool:
        """Whether u reaches the limits on one of the plants, or a run ends early."""
        return any(
            run.outcome != "completed" or bool((run.u != run.u_applied).any())
            for run in self._runs([G_c])
        )

    def best(self) -> Reference:
        """The robust controller with nearly the least error, else the most robust one.

        Among those within a tenth of the least error the one with the least u; with limits of u,
        runs with them decide. A candidate that loses a rival is left out.
        """
        rivals = list(self.instead[len(self.others) :])
        candidates = {
            (R_2, V_2): parts for R_2, V_2, parts in self.candidates() if _stabilises(rivals, parts)
        }
        ordered: Iterator[Evaluated] = chain(self._robust(candidates), self._fragile(candidates))
        if self.saturation is not None:
            ordered = iter(self._by_runs(list(ordered), candidates))
        return self._first(ordered, candidates)

    def _robust(self, candidates: Candidates) -> Iterator[Evaluated]:
        """Yield the robust candidates in order; no peak is computed that the order does not need.

        Costs are quick beside peaks and beside the loops with every other plant.
        """
        costs: list[Evaluated] = []  # as of robust candidates, which `peak` confirms
        for pair, parts in candidates.items():
            if not loop_radius(self.scaled, parts) < SLOWEST:
                continue
            with suppress(CompensatorError):
                costs.append((LoopEvaluation(0, 1.0, *self._powers(parts), self.most_u**2), *pair))
        costs.sort(key=_order)
        others = self.instead[: len(self.others)]
        peaks: dict[Weights, float] = {}

        def peak(one: Evaluated) -> float:
            """Ms of a candidate, infinite where another plant is lost."""
            key = one[1:]
            if key not in peaks:
                peaks[key] = self._robust_peak(candidates[key], others)
            return peaks[key]

        first = next((i for i, one in enumerate(costs) if peak(one) <= MOST), len(costs))
        for one in _calmest_first(costs[first:]):
            if peak(one) <= MOST:
                yield replace(one[0], peak=peak(one)), *one[1:]

    def _robust_peak(self, parts: StateSpace, others: list[Plant]) -> float:
        """Ms of a loop, or a bound of it above `MOST`; infinite where another plant is lost."""
        if not _stabilises(others, parts):
            return np.inf
        try:
            return _peak(self.scaled, parts, MOST)
        except CompensatorError:
            return np.inf

    def _fragile(self, candidates: Candidates) -> Iterator[Evaluated]:
        """Yield the candidates that are not robust: least lost plants, then least peak, first."""
        by_lost: dict[int, list[Weights]] = {}
        for pair, parts in candidates.items():
            radius = loop_radius(self.scaled, parts)
            if radius < 1:
                others = self.instead[: len(self.others)]
                lost = sum(not loop_radius(other, parts) < 1 for other in others)
                by_lost.setdefault(lost + (radius >= SLOWEST), []).append(pair)
        for lost, same in sorted(by_lost.items()):
            evaluations = []
            for pair in same:
                with suppress(CompensatorError):
                    peak = _peak(self.scaled, candidates[pair])
                    evaluations.append((LoopEvaluation(lost, peak), *pair))
            yield from sorted((one for one in evaluations if one[0].safe[0]), key=_order)

    def _first(self, evaluations: Iterable[Evaluated], candidates: Candidates) -> Reference:
        """The first controller that float64 carries."""
        plant, units, V = self.plant, self.units, self.noise_variance
        obstacle: CompensatorError | None = None
        for evaluation, R_2, V_2 in evaluations:
            try:
                parts = candidates[R_2, V_2]
                G_c = converted(parts, CLOSE)[0] if plant.m > 1 else converted(parts)[0]
                compensator = self.in_units(G_c)
                peak = sensitivity_peak(ClosedLoop(plant.servo(), compensator))
            except CompensatorError as error:
                obstacle = error
                continue
            if not peak <= (1 + CLOSER) * evaluation.peak:
                obstacle = NoSolutionError("rounded, the controller loses its robustness.")
                continue
            problem, noise = _weighted(self.scaled, R_2, self.models), {**self.noise, "v": V * V_2}
            return Reference(problem, noise, compensator, evaluation.peak, R_2, V_2, units)
        _require_no_hidden_mode(plant)
        order = self.scaled.n + len(self.models) * plant.m
        rounded = f": those of order {order} that do so need more digits" * bool(obstacle)
        raise NoSolutionError(
            "no float64 controller of the weight grid stabilises the plant for this disturbance "
            f"and this command{rounded}. Reduce the order of the plant or its dead time, sample "
            "more slowly (a log with --resample or read_log(..., resample=)), or give the "
            "disturbance as its size alone."
        ) from obstacle

    def _by_runs(self, judged: list[Evaluated], candidates: Candidates) -> list[Evaluated]:
        """Sort the most robust candidates by runs; then the others."""
        if not judged:
            return judged
        first = [one for one in judged if one[0].safe == min(other[0].safe for other in judged)]
        compensators, remaining = [], []
        for one in first:
            try:
                compensators.append(self.in_units(converted(candidates[one[1:]], CLOSE)[0]))
                remaining.append(one)
            except CompensatorError:
                continue
        best = [remaining[i] for i in self.in_runs(compensators)]
        return best + [one for one in judged if one not in best]

    def response(self, omega: Array) -> ComplexArray:
        """The response from u to e, both scalar, in units of the grid."""
        to_e = -self.plant.response(omega)[:, 0, 0] * self.units[0] / self.units[1]
        return np.asarray(to_e, dtype=np.complex128)

    def disturbance_spectrum(self, omega: Array) -> Array:
        """The spectrum of d in units of the grid: white noise and the disturbance models."""
        spectrum = np.full(len(omega), self.noise["d"])
        z = np.exp(1j * omega)
        for kind, (pole, power) in self.models.items():
            mode = LASTS * np.exp(1j * pole)
            size = np.abs((z - mode) * (z - np.conj(mode))) if pole else np.abs(z - mode)
            part = (1 - LASTS**2) * power / size**2
            if kind == SLOPE:
                part = part * (1 - LASTS**2) * self.models[BIAS][1] / size**2
            spectrum += part
        return spectrum


def _stabilises(plants: list[Plant], parts: StateSpace) -> bool:
    """Whether a controller stabilises all plants; the one that it loses is moved to the front.

    The next controller often loses the same plant.
    """
    for i, plant in enumerate(plants):
        if not loop_radius(plant, parts) < 1:
            plants.insert(0, plants.pop(i))
            return False
    return True


def _order(one: Evaluated) -> tuple[object, ...]:
    return one[0].order, *one[1:]


def _calmest_first(judged: list[Evaluated]) -> list[Evaluated]:
    """Put the candidate with the least u first, of the robust ones with nearly the least error.

    The last tenth of the error is bought with a u that answers to every step of the noise.
    """
    if not judged or judged[0][0].order[:2] != (False, 0.0):
        return judged
    most = NEARLY**2 * judged[0][0].error
    near = [one for one in judged if one[0].order[:2] == (False, 0.0) and one[0].error <= most]
    near.sort(key=lambda one: one[0].control)
    return near + [one for one in judged if one not in near]


def reference_loop(
    plant: DesignPlant, expected: Expected, u_range: float = np.inf,
    others: Sequence[Variation] = (), saturation: Saturation | None = None,
) -> Reference:  # fmt: skip
    """The robust LQG controller on a grid of weights with nearly the least error.

    Robust is: Ms <= 2, all poles inside 1 - 1e-4, and stable with every other plant. Of those
    within a tenth of the least error the one with the least u is taken; where none is robust,
    the one that fails with the fewest of them, and of those the one with the smallest peak.
    Parameters are those of `WeightGrid`.
    """
    return WeightGrid(plant, expected, u_range, others, saturation).best()


def _without_blocked(models: Models, plant: DesignPlant, expected: Expected) -> tuple[float, ...]:
    """Remove disturbance models that a plant zero blocks; refuse commands at their poles.

    A zero at the pole of the disturbance model blocks d, and an integrating controller beside it
    has an uncontrollable mode. At that frequency no controller follows a command or rejects a
    disturbance of y.
    """
    blocked = {name: omega for name, (omega, _) in models.items() if _is_blocked(plant, omega)}
    if not blocked:
        return ()
    omega = min(blocked.values())
    at = "at rest, z = 1 (s = 0)" if omega == 0 else f"at {omega:.4g} rad/step"
    where = f"the plant has a zero {at}, so that"
    if plant.m > 1:
        signals = "constants" if omega == 0 else f"sinusoids of {omega:.4g} rad/step"
        raise NoSolutionError(
            f"{where} in one direction {signals} of u do not reach y: no controller rejects a "
            "disturbance there. Choose another measurement or actuator; or, for noise alone, give "
            "disturbance=WhiteNoise(...)."
        )
    if BIAS in blocked and expected.constant_command:
        raise NoSolutionError(
            f"{where} a constant u has no lasting effect on y: no controller holds y at a "
            "constant command. Leave the command out, or choose another measurement or actuator."
        )
    if SLOPE in blocked:
        raise NoSolutionError(
            f"{where} a ramp of d gives a constant in y, which no controller rejects, and none "
            "follows a ramp. Give the disturbance and the command without ramps, or choose another "
            "measurement or actuator."
        )
    for name in blocked:
        del models[name]
    return tuple(blocked.values())


def _require_no_hidden_mode(plant: DesignPlant) -> None:
    """Raise an error for an unstable mode that is uncontrollable or unobservable.

    By Popov, Belevitch and Hautus: rank [A - pI, B] and [A' - pI, C'] at every such pole p.
    """
    A, n = plant.A, len(plant.A)
    for p in np.linalg.eigvals(A):
        if abs(p) < 1 - NEAR or p.imag < 0:
            continue
        for pencil, words in (
            (np.hstack([A - p * np.eye(n), plant.B]), "u does not control"),
            (np.hstack([A.T - p * np.eye(n), plant.C.T]), "y does not show"),
        ):
            sizes = np.linalg.svd(pencil, compute_uv=False)
            if sizes[-1] <= HIDDEN * sizes[0]:
                value = f"{p.real:.6g}" if abs(p.imag) <= NEAR else f"{p:.6g}"
                raise NoSolutionError(
                    f"the plant has a pole at z = {value} that {words}: a common factor of "
                    "numerator and denominator, or a state outside the loop. Cancel the factor if "
                    "the plant does not have it; else choose another actuator or sensor."
                )


def _is_blocked(plant: DesignPlant, omega: float) -> bool:
    """Whether the plant has a zero at a frequency: its gain falls towards it."""
    near, far = plant.response(omega + NEAR * np.array([1.0, 10.0]))
    least = np.linalg.norm(near, -2)
    return bool(least < FALLS * np.linalg.norm(far, -2) or least < OUT_OF_REACH * plant.low_gain)


def _in_units(
    plant: DesignPlant, units: tuple[float, float], changed: Variation | None = None
) -> Plant:
    """The servo problem in these units of u and y, its states balanced."""
    servo = plant.servo(changed)
    B, C = servo.B * units[0], servo.C / units[1]
    A, B, C = balanced(servo.A, B, C)
    none = np.zeros_like(B)
    return replaced(servo, A=A, B=B, C=C, E_1=C, D_1=np.hstack([none, B, none]))


def _channels_of_d(plant: Plant) -> tuple[str, ...]:
    """The names of the components of d, which follow those of r."""
    return tuple(plant.channels[plant.l_y : plant.l_y + plant.l_u])


def _disturbance_models(expected: Expected, units: tuple[float, float]) -> Models:
    """The disturbance models: (frequency, mean square) by kind."""
    models: Models = {}
    stays, grows = (
        max(size / unit for size, unit in zip(sizes, units, strict=True))
        for sizes in (expected.stays, expected.slopes)
    )
    drive = DRIFT**2 / (1 - LASTS**2)
    if stays or grows:
        stays = max(stays, grows)
        models[BIAS] = 0.0, stays**2 * drive
    if grows:  # a bias of what drives the bias, by which that moves DRIFT of its size in a step
        models[SLOPE] = 0.0, (grows / (DRIFT * stays)) ** 2 * drive
    for i, (omega, amplitude) in enumerate(expected.sinusoids):
        name = f"oscillation_{i + 1}_"  # of its two channels the names end in 1 and 2
        models[name] = omega, (amplitude / units[0]) ** 2 * drive
    return models


def _weighted(plant: Plant, R_2: float, models: Models) -> Plant:
    """Z = [e; sqrt(R_2) (u + d)], with the disturbance models on d."""
    m = plant.l_u
    none, rho = np.zeros((m, m)), np.sqrt(R_2) * np.eye(m)
    problem = replaced(
        plant,
        E_1=np.vstack([plant.E_1, np.zeros((m, plant.n))]),
        E_2=np.vstack([none, rho]),
        E_0=np.vstack([plant.E_0, np.hstack([none, rho, none])]),
    )
    for channel in _channels_of_d(plant):
        for name, (omega, power) in models.items():
            if name == BIAS:
                problem = with_bias(problem, channel, pole=LASTS, mean_square=power)
            elif name == SLOPE:
                problem = with_bias(problem, f"{channel}_{BIAS}", pole=LASTS, mean_square=power)
            else:
                problem = with_oscillation(
                    problem, channel, omega=omega, radius=LASTS, mean_square=power, name=name
                )
    return problem


def _grid_candidates(
    plant: Plant,
    models: Models,
    noise: dict[str, float],
    V: float,
    factors: tuple[Sequence[float], Sequence[float]],
) -> Iterator[tuple[float, float, StateSpace]]:
    """The LQG controllers of the grid: one Riccati equation per weight, not per pair of weights."""
    regulators, estimators = {}, {}
    for R_2 in factors[0]:
        problem = _weighted(plant, R_2, models)
        try:
            regulators[R_2] = stabilising_solution(
                problem.A,
                problem.B,
                weights(problem.E_1, problem.E_2),
                (problem.E_1, problem.E_2),
                REGULATOR,
            )
        except CompensatorError:
            continue
    problem = _weighted(plant, 1.0, models)
    for V_2 in factors[1]:
        inputs = noise_inputs(problem, {**noise, "v": V * V_2})
        pair = inputs.D_1.T, inputs.D_2.T
        try:
            estimators[V_2] = stabilising_solution(
                problem.A.T, problem.C.T, weights(*pair), pair, ESTIMATOR
            )
        except CompensatorError:
            continue
    none = np.zeros((plant.l_u, plant.l_y))
    for V_2, estimator in estimators.items():
        for R_2, regulator in regulators.items():
            gains = regulator.K, -estimator.K.T
            yield R_2, V_2, controller_matrices(problem, *gains, none)


def _peak(plant: Plant, parts: StateSpace, most: float = np.inf) -> float:
    """Ms, the peak of S = (I - G_c G_yu)^-1 at u and at y; infinite where the loop is unstable.

    Above `most` a lower bound of it.
    """
    A_c, B_c, C_c, D_c = parts
    if not loop_radius(plant, parts) < 1:
        return np.inf
    A, eye = _closed(plant, parts), np.eye(plant.l_u)
    at_u = np.vstack([plant.B, np.zeros((len(A_c), plant.l_u))])
    of_u = np.hstack([D_c @ plant.C, C_c])
    peak = hinf_norm((A, at_u, of_u, eye), rtol=1e-4, most=most)[0]
    if plant.l_u == 1 or peak > most:
        return peak
    at_y = np.vstack([plant.B @ D_c, B_c])
    of_y = np.hstack([plant.C, np.zeros((plant.l_y, len(A_c)))])
    return max(peak, hinf_norm((A, at_y, of_y, np.eye(plant.l_y)), rtol=1e-4, most=most)[0])


def _closed(plant: Plant, parts: StateSpace) -> Array:
    """A of the loop, D_0 = 0."""
    A_c, B_c, C_c, D_c = parts
    n = len(plant.A)
    A = np.empty((n + len(A_c), n + len(A_c)))
    A[:n, :n], A[:n, n:] = plant.A + plant.B @ D_c @ plant.C, plant.B @ C_c
    A[n:, :n], A[n:, n:] = B_c @ plant.C, A_c
    return A


def loop_radius(plant: Plant, parts: StateSpace) -> float:
    """The spectral radius of the loop."""
    return float(np.abs(np.linalg.eigvals(_closed(plant, parts))).max())


def _powers(
    plant: Plant, models: Models, parts: StateSpace, noise: dict[str, float]
) -> tuple[float, float]:
    """E[e_0^2] and E[(u + b)^2] under the expected signals; the means of several channels."""
    problem = _weighted(plant, 1.0, models)
    m = plant.l_u
    E_0 = np.zeros((2 * m, problem.l_w))
    E_0[:m, :m] = np.eye(m)  # of the noise v only what comes back through the loop is an error
    inputs = noise_inputs(replaced(problem, E_0=E_0), noise)
    A, B, (E_x, E_w), (K_x, K_w) = loop_matrices(problem, parts, inputs)
    covariance = stein_solution(A, B @ B.T)
    Z, W = E_x + problem.E_2 @ K_x, E_w + problem.E_2 @ K_w
    powers = np.einsum("ij,jk,ik->i", Z, covariance, Z) + np.sum(W**2, axis=1)
    return float(np.mean(powers[:m])), float(np.mean(powers[m:]))


def sensitivity_peak(loop: ClosedLoop) -> float:
    """Ms of a loop, the peak of S over frequency, at u and at y; infinite where it is unstable."""
    if not loop.is_stable:
        return np.inf
    return _peak(loop.plant, loop.compensator.state_space())
