"""A plant model of several inputs and outputs from logs, experiments and gaps, and its evidence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._log_gates import LOW as BELOW
from rcac_numeric.designing._log_gates import ROBUST as MOST_PEAK
from rcac_numeric.designing._log_gates import design_plant
from rcac_numeric.designing._logs import LogSearch, PartsOfALog, rows_a_step
from rcac_numeric.designing._plants import (
    LOW,
    MOST_SIGNALS,
    DesignPlant,
    balanced,
    checked_plant,
)
from rcac_numeric.designing._reference import loop_radius
from rcac_numeric.identification._box_jenkins import CIRCLE
from rcac_numeric.identification._joint_evidence import (
    channel_delays,
    effect_gates,
    joint_misfit,
    joint_parts,
    response_slopes,
    sign_of,
)
from rcac_numeric.identification._joint_fits import (
    JointFit,
    joint_covariance,
    joint_fit,
    joint_residual,
    student_weights,
)
from rcac_numeric.identification._joint_records import JointRecord
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    MISFIT,
    OMEGA,
    Gate,
    inflation,
)
from rcac_numeric.identification._process_matrix import (
    MatrixSearch,
    ProcessMatrix,
    is_controlled,
    matrix_search,
    process_matrix,
)
from rcac_numeric.signals._log_signals import require_sample_time

TRIED = 4  # combinations of credible models for which a controller is designed
DRAWS = 40  # models drawn from the covariance
SHARES = (1.0, 0.5, 0.25)  # of a draw, until it is credible
SEED = 49
ROBUST = 4.0  # Ms of the reference loop with the model of a part


@dataclass(frozen=True, eq=False)
class LoggedMatrix(PartsOfALog):
    """A plant model of several inputs and outputs from logs, with its evidence.

    Attributes
    ----------
    plant : DesignPlant
    model : ProcessMatrix
    parts : tuple of DesignPlant
        The model fitted again to each experiment, or to halves of the only one.
    noise : float
        Standard deviation of the white part of the residuals at most, in units of y; the root mean
        square of the outputs.
    disturbance : float
        Size of the remainder, in units of u.
    u : (float, float)
        The least and the largest control of the logs.
    is_closed : bool
        Whether a log is from a closed loop: its command moves, or y predicts u.
    every : int
        Rows of the log in one step of the controller.
    """

    plant: DesignPlant
    model: ProcessMatrix
    parts: tuple[DesignPlant, ...]
    noise: float
    disturbance: float
    u: tuple[float, float]
    is_closed: bool = False
    every: int = 1

    @property
    def gains(self) -> tuple[float, ...]:
        """Gain of each part over that of the whole, in the direction of the weakest singular value.

        At 0.02 rad/step; negative where the direction is turned.
        """
        whole = self.plant.response(LOW)[0]
        ratios = []
        for part in self.parts:
            values = np.linalg.eigvals(np.linalg.solve(whole, part.response(LOW)[0]))
            ratios += [float(np.copysign(abs(one), one.real)) for one in values]
        return tuple(ratios)

    @property
    def integrates(self) -> bool:
        """False: a pole that the log cannot distinguish from 1 has a rival with a pole at 1."""
        return False

    @property
    def evidence(self) -> str:
        """The tests that were passed, and the assumptions."""
        names = ", ".join(gate.name for gate in self.model.gates if gate.passed)
        return "; ".join([f"gates passed: {names}", *self.model.assumptions])


def joined_logs(logs: Sequence[ControllerLog]) -> tuple[Array, Array, tuple[int, ...]]:
    """Concatenate u and y of logs, with the number of steps of each."""
    first = logs[0]
    for log in logs[1:]:
        if log.u.shape[1] != first.u.shape[1] or log.y.shape[1] != first.y.shape[1]:
            raise InputError(
                f"{log.source} has {log.u.shape[1]} controls and {log.y.shape[1]} measurements, "
                f"{first.source} {first.u.shape[1]} and {first.y.shape[1]}: experiments must be of "
                "the same signals."
            )
        one, other = log.sample_time, first.sample_time
        if one is not None and other is not None and abs(one - other) > 1e-6 * other:
            raise InputError(
                f"{log.source} has sample_time = {one:g}, {first.source} {other:g}: experiments "
                "must have the same. read_log(..., resample=...) brings them to one."
            )
    return (
        np.concatenate([log.u for log in logs]), np.concatenate([log.y for log in logs]),
        tuple(log.steps for log in logs),
    )  # fmt: skip


_Plants = list[DesignPlant]
_Kept = tuple[tuple[JointFit, ...], tuple[_Plants, _Plants, _Plants]]


class MatrixLogSearch:
    """The models of logs in the order in which controllers are designed for them.

    Parameters
    ----------
    logs : sequence of ControllerLog
        One for each experiment.
    sample_time : float, optional
    dead_time : float
        0: every entry has a dead time of its own, which is fitted.
    """

    def __init__(
        self, logs: Sequence[ControllerLog], sample_time: float | None, dead_time: float
    ) -> None:
        u, y, experiments = joined_logs(logs)
        if u.shape[1] != y.shape[1] or u.shape[1] > MOST_SIGNALS:
            raise InputError(
                f"{logs[0].source} has {u.shape[1]} controls and {y.shape[1]} measurements; design "
                f"takes as many controls as measurements, {MOST_SIGNALS} at most. Leave signals "
                "out; identification.identify_process_matrix takes any numbers of them."
            )
        if number(dead_time, "dead_time"):
            raise InputError(
                "dead_time is for one log of one input and output without gaps; here every entry "
                "has a dead time of its own. Leave it out."
            )
        self.sample_time, self.source = sample_time, logs[0].source
        skews = np.array([log.time_skew for log in logs])
        self.time_skew = float(skews[:, 0].min()), float(skews[:, 1].max())
        if len(logs) > 1:
            self.source = f"{len(logs)} logs"
        self.search = matrix_search(u, y, experiments)
        has_command = any(log.r is not None and bool(np.nanmax(np.ptp(log.r, axis=0)) > 0)
                          for log in logs)  # fmt: skip
        self.is_closed = has_command or any(
            is_controlled(one.record, j) for one in self.search.searches
            for j in range(len(one.record.u))
        )  # fmt: skip
        self.range = float(np.nanmin(u)), float(np.nanmax(u))
        self._kept: _Kept | None = None  # for the last models that were judged

    def candidates(self) -> Iterator[tuple[JointFit, ...]]:
        """The best model of each output; then with the next credible one of each in turn."""
        best = self.search.best
        yield best
        for rank in range(1, TRIED):
            for i, one in enumerate(self.search.searches):
                others = one.distinct
                if rank < len(others):
                    yield (*best[:i], others[rank], *best[i + 1 :])

    def first_gates(self, fits: tuple[JointFit, ...]) -> tuple[Gate, ...]:
        """The gates that ask for no controller."""
        with np.errstate(all="ignore"):
            return tuple(
                gate
                for i, (one, fit) in enumerate(zip(self.search.searches, fits, strict=True))
                for gate in effect_gates(one, fit, i, self.search.names)
            )

    def every(self, fits: Sequence[JointFit]) -> int:
        """Rows of the log in one step of the controller."""
        longest = max(one.delay for fit in fits for one in fit.channels)
        return rows_a_step(longest * len(fits))

    def plant(self, fits: Sequence[JointFit], every: int) -> DesignPlant:
        """The plant of a model of each output."""
        return matrix_plant(self.search, fits, self.sample_time, every)

    def logged(self, fits: tuple[JointFit, ...], gates: tuple[Gate, ...] = ()) -> LoggedMatrix:
        """The plant of a model of each output, its parts and its disturbances."""
        search = self.search
        model = process_matrix(search, fits, gates, self.sample_time, self.time_skew)
        every = self.every(fits)
        plant = checked_plant(self.plant(fits, every))
        sizes = []
        for i, (one, fit) in enumerate(zip(search.searches, fits, strict=True)):
            e = joint_residual(one.record, fit) * one.record.unit_y
            noise = min(float(np.std(np.diff(e)) / np.sqrt(2)), float(np.std(e)))
            rest = float(np.sqrt(max(float(np.var(e)) - noise**2, 0.0)))
            gain = float(np.linalg.norm(plant.response(LOW)[0, i]))
            sizes.append((noise, max(rest, noise) / gain))
        noise, size = (float(np.sqrt(np.mean(np.square(one)))) for one in zip(*sizes, strict=True))
        parts = tuple(self.plant(part, every) for part in self.parts(fits))
        return LoggedMatrix(plant, model, parts, noise, size, self.range, self.is_closed, every)

    def parts(self, fits: tuple[JointFit, ...]) -> list[tuple[JointFit, ...]]:
        """The models fitted to each experiment or half, where it knows their gains."""
        by_part: dict[int, list[JointFit]] = {}
        for i, (one, fit) in enumerate(zip(self.search.searches, fits, strict=True)):
            with np.errstate(all="ignore"):
                for k, again in joint_parts(one, fit):
                    models = by_part.setdefault(k, list(fits))
                    models[i] = merged(fit, again)
        return [tuple(one) for _, one in sorted(by_part.items())]

    def judged(
        self, fits: tuple[JointFit, ...], logged: LoggedMatrix, G_c: Compensator, peak: float
    ) -> LoggedMatrix:
        """The plant with the gates of its controller beside the others."""
        gates = self.controller_gates(fits, logged, _of_e(G_c, logged), peak)
        return replace(logged, model=replace(logged.model, gates=(*logged.model.gates, *gates)))

    def lost(
        self, fits: tuple[JointFit, ...], logged: LoggedMatrix, G_c: Compensator
    ) -> list[DesignPlant]:
        """The credible plants that a controller does not stabilise."""
        parts = _of_e(G_c, logged)
        plants = [plant for kind in self._others(fits, logged.every) for plant in kind]
        return [plant for plant in plants if not loop_radius(plant.servo(), parts) < 1]

    def _others(self, fits: tuple[JointFit, ...], every: int) -> tuple[_Plants, _Plants, _Plants]:
        """The plants of rivals, of draws and of the parts of the log."""
        if self._kept is None or self._kept[0] is not fits:
            with np.errstate(all="ignore"):
                kinds = self._rivals(fits), self._drawn(fits), self.parts(fits)
                rivals, drawn, parts = (
                    [self.plant(one, every) for one in models] for models in kinds
                )
            self._kept = fits, (rivals, drawn, parts)
        return self._kept[1]

    def controller_gates(
        self, fits: tuple[JointFit, ...], logged: LoggedMatrix, controller: StateSpace, peak: float
    ) -> tuple[Gate, ...]:
        """The gates of a controller from e to u; `peak` is Ms of its loop with the model."""
        with np.errstate(all="ignore"):
            return self._controller_gates(fits, logged, controller, peak)

    def _controller_gates(
        self, fits: tuple[JointFit, ...], logged: LoggedMatrix, parts: StateSpace, peak: float
    ) -> tuple[Gate, ...]:
        search, m = self.search, logged.plant.m
        every, omega = logged.every, OMEGA / logged.every
        K = responses_of(parts, OMEGA)
        L = logged.plant.response(OMEGA) @ K
        above = np.nonzero(np.linalg.svd(L, compute_uv=False)[:, 0] > 1)[0]
        crossover = float(OMEGA[above[-1]] if len(above) else 0.01)
        # det(I + (G + Delta) K) = det(I + G K) det(I + Delta M), M = K (I + G K)^-1.
        inverse = np.linalg.inv(np.eye(m) + L)
        M = K @ inverse
        variance = np.zeros(len(OMEGA))
        for i, (one, fit) in enumerate(zip(search.searches, fits, strict=True)):
            covariance = joint_covariance(one.record, fit)
            by = sum(
                M[:, channel.input, i, None] * search.gain_unit(i, channel.input) * slopes
                for channel, slopes in response_slopes(fit, omega)
            )
            grown = inflation(fit.e, omega)
            variance += np.real(np.einsum("wi,ij,wj->w", by, covariance, np.conj(by))) * grown
        # Below a third of the crossover S stands in place of T if it is smaller, as for one input.
        T, S = np.linalg.norm(L @ inverse, 2, axis=(1, 2)), np.linalg.norm(inverse, 2, axis=(1, 2))
        share = np.where(crossover / BELOW < OMEGA, 1.0, np.minimum(1.0, S / T))
        worst = float((np.sqrt(np.maximum(variance, 0.0)) * share).max())
        gain = Gate(
            "gain", worst < KNOWN, worst, KNOWN,
            f"largest standard deviation of trace(dG K (I + G K)^-1): {worst:.2g}, at most "
            f"{KNOWN:.2g} is allowed",
            "The gains around the crossover are not known well enough: excite u more, or record "
            "longer.",
        )  # fmt: skip
        names = search.names
        left, chance, turned = np.zeros(len(OMEGA)), 1.0, 0.0
        low = np.array([crossover / BELOW / every])
        for i, (one, fit) in enumerate(zip(search.searches, fits, strict=True)):
            probability, responses = joint_misfit(one.record, fit, np.append(omega, low))
            chance = min(chance, probability)
            if probability > MISFIT:
                continue
            for channel in fit.channels:
                j = channel.input
                left += np.abs(M[:, j, i] * search.gain_unit(i, j) * responses[:-1, j])
                share_of = np.abs(responses[-1, j] / channel.response(low)).item()
                turned = max(turned, float(share_of))
        size = max(float((left * share).max()) / KNOWN, turned)
        remainder = Gate(
            "misfit", size < 1.0, size, 1.0,
            f"past u explains {size:.2g} of the gains that matter in the prediction errors, with "
            f"probability {chance:.2g} by chance",
            "The model misses a part of the plant: a nonlinear plant, an input that is not logged, "
            "or a plant of higher order. Give design a model.",
        )  # fmt: skip
        signs = tuple(
            sign_of(one, channel, crossover / BELOW / every, names.u(channel.input), names.y(i))
            for i, (one, fit) in enumerate(zip(search.searches, fits, strict=True))
            for channel in fit.channels
        )
        robust = Gate(
            "robustness", peak <= MOST_PEAK, peak, MOST_PEAK,
            f"Ms = {peak:.3g} of the fixed controller with the model, at most {MOST_PEAK:.3g} is "
            "allowed",
            "No controller of the weight grid is robust for this model: sample more slowly.",
        )  # fmt: skip

        def lost(plants: Sequence[DesignPlant]) -> int:
            return sum(not loop_radius(plant.servo(), parts) < 1 for plant in plants)

        rivals, drawn, of_parts = self._others(fits, every)
        count = [lost(rivals), lost(drawn), lost(of_parts)]
        return (
            gain, *signs,
            Gate(
                "rivals", not count[0], float(count[0]), 0.0,
                f"the fixed controller stabilises {len(rivals) - count[0]} of {len(rivals)} "
                "credible models and delays",
                "Several plants fit the record and need different controllers: excite u more, or "
                "record longer.",
            ),
            Gate(
                "draws", not count[1], float(count[1]), 0.0,
                f"the fixed controller stabilises {len(drawn) - count[1]} of {len(drawn)} models "
                "drawn from the covariance",
                "The gains around the crossover are not known well enough: excite u more, or "
                "record longer.",
            ),
            Gate(
                "parts", not count[2], float(count[2]), 0.0,
                f"the fixed controller stabilises the models of {len(of_parts) - count[2]} of the "
                f"{len(of_parts)} experiments or halves that determine one",
                "The plant differs between the experiments, or is not linear: design for each.",
            ),
            remainder, robust,
        )  # fmt: skip

    def _rivals(self, fits: tuple[JointFit, ...]) -> list[tuple[JointFit, ...]]:
        """The models with another credible one, or another delay, of one output."""
        rivals = []
        for i, (one, fit) in enumerate(zip(self.search.searches, fits, strict=True)):
            others = [other for other in one.rivals if other is not fit]
            for channel in fit.channels:
                for moved in channel_delays(one, fit, channel):
                    if moved.delay != channel.delay:
                        channels = tuple(moved if old is channel else old for old in fit.channels)
                        others.append(replace(fit, channels=channels))
            rivals += [(*fits[:i], other, *fits[i + 1 :]) for other in others]
        return rivals

    def _drawn(self, fits: tuple[JointFit, ...]) -> list[tuple[JointFit, ...]]:
        """Models drawn from the covariances, with poles in the circle as all models have."""
        rng, draws = np.random.default_rng(SEED), []
        roots = []
        for one, fit in zip(self.search.searches, fits, strict=True):
            values, vectors = np.linalg.eigh(joint_covariance(one.record, fit))
            roots.append(vectors * np.sqrt(np.maximum(values, 0.0)))
        for _ in range(DRAWS):
            draws.append(tuple(
                _credible_step(one.record, fit, root @ rng.standard_normal(len(root)))
                for one, fit, root in zip(self.search.searches, fits, roots, strict=True)
            ))  # fmt: skip
        return draws

    def undecided(self, gates: tuple[Gate, ...]) -> UndecidedError:
        """The error for logs of which gates failed."""
        failed = [gate for gate in gates if not gate.passed]
        words = "; ".join(f"{gate.name}: {gate.words}" for gate in failed)
        return UndecidedError(
            f"{self.source} does not determine the plant well enough for a controller. Failed: "
            f"{words}. {failed[0].advice}"
        )


def _credible_step(record: JointRecord, fit: JointFit, step: Array) -> JointFit:
    """The fit with its coefficients moved, by the largest of some shares that is credible.

    A covariance is that of a parabola; where a pole and a zero nearly cancel the likelihood is far
    from one, and most models of the ellipsoid do not fit the record.
    """
    weights = student_weights(record, fit) if fit.heavy else None
    at_rest = joint_fit(record, fit.start, iterations=0, weights=weights)
    for share in SHARES:
        channels = []
        for channel, place in zip(fit.channels, fit.places, strict=True):
            n, moved = channel.order, share * step[place]
            A = confined(channel.A + np.r_[0.0, moved[:n]], CIRCLE)
            channels.append(replace(channel, A=A, B=channel.B + moved[n:]))
        model = replace(fit, channels=tuple(channels))
        again = joint_fit(record, model.start, iterations=0, weights=weights)
        if again is not None and at_rest is not None and again.bic < at_rest.bic + ODDS:
            return model
    return fit


def _of_e(G_c: Compensator, logged: LoggedMatrix) -> StateSpace:
    """The controller from e to u, without its command."""
    past_y = G_c.past_y[:, :, : logged.plant.m]
    return Compensator(G_c.past_u, past_y, G_c.sample_time).state_space()


def search_of_logs(
    plant: ControllerLog | Sequence[ControllerLog], sample_time: float | None, dead_time: float
) -> LogSearch | MatrixLogSearch:
    """The models of a log, or of several; all of a scalar one without gaps, unstable ones too."""
    logs = [plant] if isinstance(plant, ControllerLog) else list(plant)
    for log in logs:
        require_sample_time(log.source, log.sample_time, sample_time)
    if sample_time is None:
        sample_time = next((log.sample_time for log in logs if log.sample_time), None)
    is_scalar = len(logs) == 1 and logs[0].u.shape[1] == logs[0].y.shape[1] == 1
    if is_scalar and not (np.isnan(logs[0].u) | np.isnan(logs[0].y)).any():
        return LogSearch(logs[0], sample_time, dead_time)
    return MatrixLogSearch(logs, sample_time, dead_time)


def merged(fit: JointFit, part: JointFit) -> JointFit:
    """A fit with the channels of a part of the log."""
    channels = tuple(part.channel(one.input) or one for one in fit.channels)
    return replace(fit, channels=channels)


def matrix_plant(
    search: MatrixSearch, fits: Sequence[JointFit], sample_time: float | None, every: int = 1
) -> DesignPlant:
    """The plant of a model of each output: states for each entry, a common integrator a row.

    For a controller in one of `every` rows; if that is more than 1 an entry has its own integrator.
    """
    m = len(search.inputs.u)
    blocks, inputs, delays, rows, feeds = [], [], [], [], []
    for i, fit in enumerate(fits):
        for one in fit.channels:
            denominator = one.A if every == 1 else one.denominator
            unit = search.gain_unit(i, one.input)
            entry = design_plant(one.B, denominator, one.delay, unit, None, every)
            blocks.append((entry.A, entry.B[:, 0]))
            inputs.append(one.input)
            delays.append(entry.delay)
            rows.append((i, entry.C[0]))
            feeds.append(one.summed and every == 1)
    has_sums = [every == 1 and any(one.summed for one in fit.channels) for fit in fits]
    sums = [i for i, has_sum in enumerate(has_sums) if has_sum]
    states = sum(len(a) for a, _ in blocks)
    A = np.zeros((states + len(sums), states + len(sums)))
    B, C = np.zeros((len(A), m)), np.zeros((len(fits), len(A)))
    late, at = np.full((len(A), m), min(delays)), 0
    for (a, b), j, delay, (i, c), is_summed in zip(
        blocks, inputs, delays, rows, feeds, strict=True
    ):
        place = slice(at, at + len(a))
        A[place, place], B[place, j], C[i, place] = a, b, c
        late[place] = delay
        if is_summed:
            A[states + sums.index(i), place] = c
        at += len(a)
    for k, i in enumerate(sums):
        A[states + k, states + k] = C[i, states + k] = 1.0
    A, B, C = balanced(A, B, C)
    later = late - min(delays)
    period = None if sample_time is None else every * sample_time
    return DesignPlant(
        A, B, C, int(min(delays)), sample_time=period,
        later=later.astype(np.int64) if later.any() else None,
    )  # fmt: skip
