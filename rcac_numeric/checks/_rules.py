"""The conditions and thresholds of health warnings; `_warnings` has their sentences."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._internal_models import drift_of
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import MOST_STATES
from rcac_numeric.checks._check import ControllerCheck
from rcac_numeric.checks._health import DRIFT, HealthWarning, LoopHealth
from rcac_numeric.checks._target_errors import TURNED, target_errors, zeros_of
from rcac_numeric.checks._trials import pole_remedy
from rcac_numeric.checks._warnings import (
    OTHER_SIGN,
    RULES,
    Finding,
    Kind,
    kind_of,
    order_of,
    warning_of,
)
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._gain_schedule import GainSchedule
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import SupervisionRecord
from rcac_numeric.engine._runs import Run
from rcac_numeric.identification._recursive_arx import WHITE, RecursiveARX
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import plant_at
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._direction_checks import check_directions
from rcac_numeric.targets._model import TargetModel

TRANSIENT = 30.0  # |z| under control over the largest |w|, |z| before control and |z| at the end
LARGE_U = 100.0  # |u| over the largest of |w| and |z|, and the u that moves z by it in one step
WORSE = 2.0  # rms of z at the end over that without control
LEAST_GAIN, LEAST_PHASE = 2**0.5, 20.0  # 3 dB and degrees: half of the textbook margins
SATURATED = 0.1  # share of the last tenth of the steps
UNSETTLED = 0.1  # change of theta in the last tenth, relative
KICKED, FAR = 10.0, 100.0  # |z| after a kick over that with theta held, and where that is grave
IDLE = 1e-6  # of the largest of w and z: smaller is no loop at work
COSTLY = 2.0  # cost over LQG's
GRAVE = 1e4  # |z| or |u| over what acts on the loop, whatever the loop does in the end
MISSED_SAMPLES = 0.05  # share of the steps
SLOW = 0.5  # time constant of the slowest mode over the length of the run

T = TypeVar("T")


def warnings_of_run(health: LoopHealth, analysis: LoopAnalysis) -> tuple[HealthWarning, ...]:
    """Every warning of a run, the grave ones first."""
    run = analysis.run
    kind, order = kind_of(run.settings), order_of(getattr(run.settings, "structure", None))
    is_fixed = isinstance(run.settings, FixedController)
    errors = _of_target(target_errors, analysis)
    learnt, directed = learning_warnings(run), _of_target(direction_errors, analysis)
    remedies = [*dict.fromkeys(one.next_step for one in (*learnt, *errors, *directed))]
    rules = (
        _ended_badly(run),
        _unstable(health, analysis.loop if is_fixed and health.is_stable is False else None),
        _transients(health, run),
        _control(health, run, analysis),
        _worse(health, run),
        _wound_up(health),
        _missed(health, analysis),
        _costly(health),
        _arithmetic(health, run),
        _margins(health),
        _saturated(run),
        _learning(health, run),
        _slow(health),
    )
    zeros = _of_target(sampling_zero_remedies, analysis)
    warnings = [
        warning_of(finding, remedies, zeros, kind=kind, order=order)
        for rule in rules
        for finding in rule
    ]
    warnings += [w for w in learnt if warnings or w.code not in CAUSES]
    if warnings:  # a healthy loop with another G_f than the plant's needs no remedy
        warnings += errors
    warnings += directed  # z does not show these zeros, so that they are reported in any case
    return _by_gravity(_with_design_advice(warnings, analysis))


def _by_gravity(warnings: list[HealthWarning]) -> tuple[HealthWarning, ...]:
    return tuple(sorted(warnings, key=lambda warning: not warning.is_grave))


def _of_target(
    evaluate: Callable[[Plant, TargetModel], tuple[T, ...]], analysis: LoopAnalysis
) -> tuple[T, ...]:
    """Return the warnings on G_f and its plant; none if one of them is unknown."""
    try:
        return evaluate(analysis.plant, analysis.compared_with)
    except CompensatorError:
        return ()


# Settings that start from theta = 0, with a known plant.

# An FIR target suits a plant with more damping and less delay from u to z, in steps, than these.
DAMPED, SOON = 0.2, 3


def _with_design_advice(
    warnings: list[HealthWarning], analysis: LoopAnalysis
) -> list[HealthWarning]:
    """Append "or design(plant)" to the first warning that settings can cause."""
    blamed = [w for w in warnings if RULES[w.code].by_settings]
    settings = analysis.run.settings
    if not blamed or not isinstance(settings, ControllerSettings) or settings.theta_0.any():
        return warnings
    try:
        plant = plant_at(analysis.run.plant, 0)
    except CompensatorError:
        return warnings
    is_read = plant.l_u == plant.l_y and np.array_equal(plant.E_1, plant.C)
    if not is_read or plant.D_0.any():
        return warnings
    first = next((w for w in blamed if w.is_grave), blamed[0])
    words = f"{first.next_step}; or design(plant), which starts from a robust loop"
    why = fir_target_obstacle(plant, settings.target)
    sentence = f"{first.sentence} {why}" if why else first.sentence
    return [replace(w, sentence=sentence, next_step=words) if w is first else w for w in warnings]


def fir_target_obstacle(plant: Plant, target: TargetModel) -> str:
    """Explain why an FIR target is hard for an oscillating or late plant; empty for others."""
    if target.denominator[1:].any():
        return ""
    poles = np.linalg.eigvals(plant.A).astype(np.complex128)
    turning = poles[(np.abs(poles.imag) > TURNED) & (np.abs(poles) > RINGING)]
    damping = -np.log(np.abs(turning)) / np.abs(np.log(turning))
    late = target.relative_degree
    words = [f"a damping of {damping.min():.2g}"] if (damping < DAMPED).any() else []
    words += [f"a dead time of {late} steps"] if late > SOON else []
    if not words:
        return ""
    return (
        f"G_f is FIR and requires a loop that settles within {target.n_f} steps; with "
        f"{' and '.join(words)} hardly any R_theta gives a good loop."
    )


def warnings_of_check(health: LoopHealth, check: ControllerCheck) -> tuple[HealthWarning, ...]:
    """Every warning of a logged controller, the grave ones first."""
    fixed = check.loop if check.is_fixed else None
    warnings = [*_unstable(health, fixed), *_margins(health), *_slow(health)]
    if not check.is_consistent:
        search = check.conventions
        numbers = {}
        if search is not None and search.is_unique:
            numbers["next_step"] = f"the check with {search.matches[0].options}"
        elif check.sample_shift is not None:
            numbers["next_step"] = check.sample_shift.next_step
        warnings.append(("inconsistent log", numbers))
    if check.drift is not None and check.drift.relative > UNSETTLED:
        warnings.append(("unsettled", {"moved": check.drift.relative}))
    kind: Kind = "fixed" if check.is_fixed else "RCAC"
    if check.settings is not None:
        kind = kind_of(check.settings)
    order = order_of(check.structure)
    return _by_gravity([warning_of(one, kind=kind, order=order) for one in warnings])


def _ended_badly(run: Run) -> Iterator[Finding]:
    if run.outcome != "completed":
        failure = f" ({run.failure.rstrip('.')})" if run.failure else ""
        key = f"diverged: {run.outcome}"
        numbers = {"step": run.first_step + run.steps, "outcome": run.outcome, "failure": failure}
        yield key if key in RULES else "diverged", numbers


def _unstable(health: LoopHealth, fixed: ClosedLoop | None) -> Iterator[Finding]:
    """The loop is unstable; `fixed` is that of a controller that does not adapt."""
    if health.is_stable is False:
        is_turned = fixed is not None and fixed.has_stable_opposite
        step = {"next_step": OTHER_SIGN} if is_turned else {}
        yield "unstable", {"radius": health.spectral_radius, **step}


def _transients(health: LoopHealth, run: Run) -> Iterator[Finding]:
    z = health.signals["z"]
    if z.after is None or z.late is None:
        return
    from_outside = max(_peak(run.w), _peak(run.x_0), z.before.peak if z.before else 0.0)
    scale = max(from_outside, z.late.peak, health.free.peak if health.free else 0.0)
    when = "Under control" if kind_of(run.settings) == "fixed" else "While theta adapted"
    if scale and z.after.peak > TRANSIENT * scale:
        is_grave = z.after.peak > GRAVE * scale or not _ends_well(health)
        peak = z.after.peak
        numbers = {"when": when, "peak": peak, "times": peak / scale, "is_grave": is_grave}
        yield "large transient", numbers


def _ends_well(health: LoopHealth) -> bool:
    """Whether the loop is stable, and z at the end no larger than without control."""
    late = health.signals["z"].late
    if not health.is_stable or health.outcome != "completed" or late is None:
        return False
    return health.free is None or late.rms <= max(health.free.rms, 1e-12 * _largest(health))


def _largest(health: LoopHealth) -> float:
    after = health.signals["z"].after
    return 0.0 if after is None else after.peak


def _control(health: LoopHealth, run: Run, analysis: LoopAnalysis) -> Iterator[Finding]:
    u = health.signals["u"].after
    first = _first_gain(analysis)
    if u is None or run.saturation is not None or not first:
        return
    z = health.signals["z"]
    peaks = [size.peak for size in (z.before, z.late, health.free) if size is not None]
    scale = max(_peak(run.w), _peak(run.x_0), *peaks) * max(1.0, 1 / first)
    if scale and u.peak > LARGE_U * scale:
        is_grave = u.peak > GRAVE * scale or not _ends_well(health)
        yield "large control", {"peak": u.peak, "scale": scale, "is_grave": is_grave}


def _worse(health: LoopHealth, run: Run) -> Iterator[Finding]:
    late, free = health.signals["z"].late, health.free
    if late is None or free is None or run.outcome != "completed" or not free.rms:
        return
    idle = IDLE * max(_peak(run.w), _largest(health))
    if late.rms > max(WORSE * free.rms, idle):
        is_grave = late.rms > TRANSIENT * free.rms
        numbers = {"late": late.rms, "free": free.rms, "is_grave": is_grave}
        yield "worse than without control", numbers


def _wound_up(health: LoopHealth) -> Iterator[Finding]:
    """Evaluate a trial if the plant is known; else the growth of P alone."""
    record, kick = health.supervision, health.next_disturbance
    growth = 0.0 if record is None else record.growth
    if kick is not None and kick.ratio > KICKED:
        reached = "leaves float64" if not np.isfinite(kick.adapting) else f"{kick.adapting:.3g}"
        numbers = {"growth": growth, "reached": reached, "frozen": kick.frozen}
        key = "windup: P grew" if growth > 1 else "windup"
        yield key, {**numbers, "is_grave": kick.ratio > FAR}
    elif kick is None and record is not None and (count := record.troubles.get("windup")):
        numbers = {"first": count.first, "steps": count.steps, "worst": count.worst}
        is_grave = not {"bounded", "frozen", "reset", "to fallback"} & set(record.troubles)
        key = "windup: noted, P grew" if growth > 1 else "windup: noted"
        yield key, {**numbers, "is_grave": is_grave}


def _missed(health: LoopHealth, analysis: LoopAnalysis) -> Iterator[Finding]:
    missed = health.missed_by
    if missed is None or health.outcome != "completed" or health.is_held:
        return
    comparison = analysis.comparison
    if comparison.is_reached:
        return
    numbers: dict[str, Any] = {"missed": missed, "error": comparison.backward_error}
    structure, cure = analysis.structure, pole_remedy(analysis)
    if structure is not None and comparison.can_be_placed_by(structure) is False:
        cure = (
            f"another structure or target, if these poles matter: the {structure.l_theta} "
            f"coefficients of {structure.name} cannot place them; iir with n_c = "
            f"{comparison.plant.n} has enough"
        )
    yield "missed poles", numbers | ({"next_step": cure} if cure else {})


def _costly(health: LoopHealth) -> Iterator[Finding]:
    if health.cost_ratio is not None and health.cost_ratio > COSTLY:
        yield "costly", {"ratio": health.cost_ratio}


def warnings_of_controller(
    health: LoopHealth, record: SupervisionRecord
) -> tuple[HealthWarning, ...]:
    """Every warning of a step-by-step controller, the grave ones first."""
    warnings = [*_wound_up(health)]
    if count := record.troubles.get("overflow"):
        warnings.append(("overflow", {"count": count.steps, "last": count.last}))
    if (count := record.troubles.get("missed sample")) and (
        count.steps > MISSED_SAMPLES * max(health.steps, 1)
    ):
        warnings.append(("missed samples", {"count": count.steps, "steps": health.steps}))
    if count := record.troubles.get("saturated"):
        warnings.append(("saturated: on end", {"steps": count.worst}))
    if record.in_fallback or record.is_frozen:
        how = "u comes from the fallback" if record.in_fallback else "theta is held"
        warnings.append(("stopped", {"how": how}))
    if health.guard_count:
        warnings.append(("rounding: of a live controller", {"count": health.guard_count}))
    return _by_gravity([warning_of(one) for one in warnings])


def _arithmetic(health: LoopHealth, run: Run) -> Iterator[Finding]:
    if run.guard_count:
        yield "rounding", {"count": run.guard_count, "first": run.guard_first_step}
    excitation = health.excitation
    if excitation is not None and excitation.drift > DRIFT:
        yield "rounding: drift", {"drift": excitation.drift}


def _margins(health: LoopHealth) -> Iterator[Finding]:
    for name, margins in health.margins.items():
        if words := small_margins(margins):
            at = "" if len(health.margins) == 1 else f" at {name}"
            yield "small margins", {"at": at, "margins": ", ".join(words)}


def small_margins(margins: Margins) -> list[str]:
    """Describe the margins of a stable loop that are below 3 dB or 20 degrees."""
    if not margins.is_stable:
        return []
    assert margins.gain_up is not None
    assert margins.gain_down is not None
    assert margins.phase is not None
    words = []
    if margins.gain_up.value < LEAST_GAIN:
        words.append(f"unstable with {margins.gain_up.value:.3g} times the gain")
    if margins.gain_down.value > 1 / LEAST_GAIN:
        words.append(f"unstable with {margins.gain_down.value:.3g} times the gain")
    if margins.phase.value < LEAST_PHASE:
        words.append(f"phase margin {margins.phase.value:.3g} degrees")
    return words


def _saturated(run: Run) -> Iterator[Finding]:
    if run.saturation is None or not run.steps:
        return
    last = slice(-max(run.steps // 10, 1), None)
    share = float(np.mean((run.u[last] != run.u_applied[last]).any(axis=1)))
    if share > SATURATED:
        yield "saturated", {"share": share}


def _learning(health: LoopHealth, run: Run) -> Iterator[Finding]:
    excitation = health.excitation
    if excitation is not None and not excitation.outweighed and run.steps > health.k_w:
        yield "no excitation", {}
    if (
        run.settings.l_theta
        and not isinstance(run.settings, GainSchedule)  # whose theta is the scheduling variable
        and run.stride == 1
        and run.outcome == "completed"
        and len(run.theta) > 1
    ):
        moved = drift_of(run.theta).relative
        if moved > UNSETTLED:
            yield "unsettled", {"moved": moved}


def _slow(health: LoopHealth) -> Iterator[Finding]:
    radius = health.spectral_radius
    if health.is_stable and radius is not None and radius > 0 and health.steps > 1:
        decay = -1 / np.log(radius) if radius < 1 else np.inf
        if decay > SLOW * health.steps:
            yield "slow", {"decay": decay, "steps": health.steps}


def _first_gain(analysis: LoopAnalysis) -> float:
    """The largest entry of the first Markov parameter of G_zu that is not zero; 0 if unknown."""
    plant = analysis.run.plant
    if type(plant) is not Plant or plant.n > MOST_STATES:
        return 0.0
    state, parameter = plant.B, plant.E_2
    for _ in range(plant.n + 1):
        if size := _peak(parameter):
            return size
        parameter, state = plant.E_1 @ state, plant.A @ state
    return 0.0


def _peak(values: np.ndarray | None) -> float:
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))


# Target models for several inputs and outputs that lack zeros or their directions.

LARGEST = 10  # states of a plant whose zeros and directions take less than a second, exactly
CODES = {
    "not a zero": "unmodelled zero: of several channels",
    "in every channel": "zero in every channel",
    "in one channel": "zero in one channel",
    "on the input side": "zero on the input side",
    "in another direction": "zero in another direction",
}


def direction_errors(plant: Plant, target: TargetModel) -> tuple[HealthWarning, ...]:
    """Return the warnings of `check_directions` for a square G_zu with several inputs.

    Healthy loops get them too: a zero that G_f lacks hides an instability from z.
    """
    if plant.l_u < 2 or plant.l_u != plant.l_z or plant.n > LARGEST:
        return ()
    check = check_directions(target, plant)
    forms = [form for form in check.forms if form != "kept"]
    return tuple(
        warning_of((CODES[form], {"sentence": sentence[:1].upper() + sentence[1:]}))
        for form, sentence in zip(forms, check.warnings, strict=True)
    )


# Runs with `DataDriven` whose target model was not identified well.

LONGEST = 20_000  # steps that the model is fitted to again
VISIBLE = 1e-3  # of z: a smaller residual is a transient, a step or rounding, which is never white
POOR = 0.1  # share of R_theta in the information on the least excited coefficient
GROWTH = 1e6  # of an unstable mode while DataDriven excites the plant in open loop
CAUSES = ("poor excitation", "unstable start")  # reported if there is another warning


@dataclass(frozen=True)
class _Look:
    """The whiteness and the excitation of an ARX model after some steps."""

    steps: int
    whiteness: float
    excitation: float
    visible: bool


def learning_warnings(run: Run) -> tuple[HealthWarning, ...]:
    """The warnings of a run with `DataDriven`, `CAUSES` first where they explain others."""
    settings = run.settings
    learning = settings.learning if isinstance(settings, ControllerSettings) else None
    if learning is None or run.first_step or run.steps <= learning.order + 1:
        return ()
    findings = [*_unstable_start(run, learning)]
    if run.steps > learning.start:
        findings += _badly_learnt(run, learning)
    return tuple(map(warning_of, findings))


def _badly_learnt(run: Run, learning: DataDriven) -> Iterator[Finding]:
    if not run.changes:
        yield "nothing learnt", {"steps": run.steps, "dither": learning.dither}
        return
    looks, numbers = _looks(run, learning), dict[str, float]()
    coloured = [look for look in looks if look.visible and look.whiteness < WHITE]
    if coloured:
        order, first = learning.order, coloured[0]
        numbers = {"order": order, "twice": 2 * order, "whiteness": first.whiteness}
        yield "low order", {**numbers, "steps": first.steps}
    if looks and looks[0].excitation > POOR:
        numbers = {"steps": looks[0].steps, "dither": learning.dither}
        yield "poor excitation", {**numbers, "excitation": looks[0].excitation}


def _unstable_start(run: Run, learning: DataDriven) -> Iterator[Finding]:
    try:
        plant = plant_at(run.plant, 0)
    except CompensatorError:  # no linear plant is known
        return
    radius = float(np.abs(np.linalg.eigvals(plant.A)).max(initial=0.0))
    with np.errstate(over="ignore"):
        growth = np.float64(radius) ** learning.start
    if radius > 1 and growth > GROWTH:
        least = max(learning.order + 1, int(np.log(1e3) / np.log(radius)))
        numbers = {"radius": radius, "start": learning.start, "growth": growth, "least": least}
        yield "unstable start", numbers


def _looks(run: Run, learning: DataDriven) -> list[_Look]:
    """Evaluate the model after the start and at the end of the run."""
    model = RecursiveARX(learning.order, R_theta=learning.R_theta, lambda_=learning.lambda_)
    looks: list[_Look] = []
    steps = min(run.steps, LONGEST)
    for first, last in ((0, learning.start), (learning.start, steps)):
        try:
            model.update(run.u_applied[first:last], run.z[first:last])
            online = model.estimate()
        except DivergedError:
            break
        except InputError:  # u is not seen to act on z yet
            continue
        size = _rms(run.z[:last])
        visible = np.sqrt(model.variance) > VISIBLE * size
        looks.append(_Look(last, online.whiteness, model.excitation(), bool(visible)))
    return looks


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


# Sampling zeros near -1 that the controller cancels if the target model lacks them.

RINGING = 0.9  # a cancelled zero of this modulus or more rings for tens of steps


def sampling_zero_remedies(plant: Plant, target: TargetModel) -> tuple[str, ...]:
    """Return the remedies if G_f requires the cancellation of a zero of G_zu in (-1, -0.9].

    The controller pole that cancels it rings at half the sampling frequency, and a larger R_theta
    may make that worse: abs u from 2e4 to 9e4 for a second-order lag sampled at 10 Hz. Zeros
    elsewhere near the circle are left out: a G_f with those near 1 or near j made u larger
    in every trial.
    """
    if (plant.l_u, plant.l_z, target.l_u, target.l_z) != (1, 1, 1, 1):
        return ()
    zeros = zeros_of(plant)
    real = zeros.real[np.abs(zeros.imag) < TURNED]
    near = np.sort(real[(real >= -1 - TURNED) & (real <= -RINGING)])
    modelled = np.roots(target.numerator[target.relative_degree :, 0, 0])
    modelled_count = int((np.abs(modelled + 1) <= 1 - RINGING + TURNED).sum())
    left = [f"{zero:.4g}" for zero in near[modelled_count:]]
    if not left:
        return ()
    words, on_circle = ", ".join(left), ", ".join(["-1"] * len(left))
    many, them = ("zeros", "them") if len(left) > 1 else ("zero", "it")
    return (
        f"the {many} {words} of the plant in the target, moved to the unit circle (nmp_zeros with "
        f"{on_circle}): without {them} the controller cancels the plant's and rings, and a larger "
        "R_theta may make that worse",
    )
