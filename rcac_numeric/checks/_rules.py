"""When a loop is not healthy: the rules, their thresholds, and the remedy of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.analysis._internal_models import drift_of
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import MOST_STATES
from rcac_numeric.checks._check import ControllerCheck
from rcac_numeric.checks._health import DRIFT, HealthWarning, LoopHealth
from rcac_numeric.checks._target_errors import TURNED, TargetError, target_errors, zeros_of
from rcac_numeric.checks._trials import what_places_them
from rcac_numeric.controllers._fixed import FixedController
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
LEAST_GAIN, LEAST_PHASE = 2**0.5, 20.0  # 3 dB and degrees: half of what textbooks ask for
SATURATED = 0.1  # share of the last tenth of the steps
UNSETTLED = 0.1  # change of theta in the last tenth, relative
KICKED, FAR = 10.0, 100.0  # |z| after a kick over that with theta held, and where that is grave
IDLE = 1e-6  # of the largest of w and z: smaller is no loop at work
COSTLY = 2.0  # cost over LQG's
GRAVE = 1e4  # |z| or |u| over what acts on the loop, whatever the loop does in the end
MISSED_SAMPLES = 0.05  # share of the steps
SLOW = 0.5  # time constant of the slowest mode over the length of the run

SOFTER = "a larger R_theta (100 times), or a later k_w"
OUTCOMES = {
    "overflow": "lambda = 1, or a reset: P grows in directions without excitation",
    "unsupported R_theta": "a larger R_theta: the data cannot support this one",
    "plant not finite": "smaller commands, or a saturation of u: the plant left float64",
    "interrupted": "run it again",
}


def warnings_of_run(health: LoopHealth, found: LoopAnalysis) -> tuple[HealthWarning, ...]:
    """Every warning of a run, the grave ones first."""
    run = found.run
    errors = _target_errors(found)
    learnt, directed = tuple(learning_warnings(run)), _direction_errors(found)
    steps = [w.next_step for w in learnt] + [e.next_step for e in (*errors, *directed)]
    remedies = [*dict.fromkeys(steps)]
    at_first = [*_sampling_zeros(found), *remedies]  # before R_theta, which may make it worse
    rules = (
        _ended_badly(run, remedies),
        _unstable(health, remedies),
        _transients(health, run, at_first),
        _control(health, run, found, at_first),
        _worse(health, run),
        _wound_up(health),
        _missed(health, found),
        _costly(health),
        _arithmetic(health, run),
        _margins(health),
        _saturated(run),
        _learning(health, run),
        _slow(health),
    )
    warnings = [warning for rule in rules for warning in rule]
    warnings += [w for w in learnt if warnings or w.code not in CAUSES]
    if warnings:  # a loop that does well with another G_f than the plant's needs no remedy
        warnings += [_of_target(error) for error in errors]
    warnings += [_of_target(error) for error in directed]  # what hides from z is said in any case
    warnings = _with_road(warnings, found)
    if isinstance(run.settings, FixedController):
        warnings = [_of_fixed(warning) for warning in warnings]
    return tuple(sorted(warnings, key=lambda warning: not warning.is_grave))


# What there is to change of a controller that does not adapt: it has no R_theta, no k_w, no G_f.
OTHER = "another controller: design(plant), lqg_controller(plant), or a smaller gain of this one"
OF_A_FIXED_ONE = {
    "diverged": f"its sign, u = G_c y; then {OTHER}",
    "unstable": f"its sign, u = G_c y, and the plant's; then {OTHER}",
    "large transient": f"a saturation of u, handed over as u_applied; then {OTHER}",
    "large control": f"a saturation of u, handed over as u_applied; then {OTHER}",
    "worse than without control": f"its sign, u = G_c y; then {OTHER}",
    "small margins": OTHER,
    "costly": "lqg_controller(plant), whose cost it is measured by",
    "saturated": "smaller commands or a stronger actuator; a smaller gain",
    "slow": "more steps; a controller with faster closed-loop poles",
    "inconsistent log": "its transfer function and sign, u = G_c y, what it reads, and the columns "
    "of the log",
}


def _of_fixed(warning: HealthWarning) -> HealthWarning:
    """The same of a controller that does not adapt: what can be done about it is another thing."""
    interrupted = warning.next_step in (OUTCOMES["interrupted"], "correct the function that failed")
    step = warning.next_step if interrupted else OF_A_FIXED_ONE.get(warning.code)
    return warning if step is None else replace(warning, next_step=step)


# Where settings that begin at theta = 0 went wrong, and the plant is known.

BY_SETTINGS = (
    "diverged", "unstable", "large transient", "large control", "worse than without control",
    "small margins", "costly",
)  # fmt: skip
DAMPED, SOON = 0.2, 3  # damping of a pole, and steps until z feels u, below which FIR is a fair try


def _with_road(warnings: list[HealthWarning], found: LoopAnalysis) -> list[HealthWarning]:
    """The same; the first that settings can be blamed for names `design`."""
    blamed = [w for w in warnings if w.code in BY_SETTINGS]
    settings = found.run.settings
    if not blamed or not isinstance(settings, ControllerSettings) or settings.theta_0.any():
        return warnings
    try:
        plant = plant_at(found.run.plant, 0)
    except CompensatorError:
        return warnings
    is_read = plant.l_u == plant.l_y and np.array_equal(plant.E_1, plant.C)
    if not is_read or plant.D_0.any():
        return warnings
    first = next((w for w in blamed if w.is_grave), blamed[0])
    words = f"{first.next_step}; or design(plant), which begins at a robust loop"
    why = what_to_expect(plant, settings.target)
    sentence = f"{first.sentence} {why}" if why else first.sentence
    return [replace(w, sentence=sentence, next_step=words) if w is first else w for w in warnings]


def what_to_expect(plant: Plant, target: TargetModel) -> str:
    """What an FIR target model asks of a plant that oscillates or answers late; else nothing."""
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
        f"G_f is FIR: it asks for a loop that is at rest within {target.n_f} steps, and with "
        f"{' and '.join(words)} seldom any R_theta makes it a good one."
    )


def warnings_of_check(health: LoopHealth, check: ControllerCheck) -> tuple[HealthWarning, ...]:
    """Every warning of a logged controller, the grave ones first."""
    found = [*_unstable(health, []), *_margins(health), *_slow(health)]
    if not check.is_consistent:
        found.append(HealthWarning(
            "inconsistent log", "The logged u is not the output of the logged controller.",
            "the structure, k_w, --k-c and the columns of the log", is_grave=True,
        ))  # fmt: skip
    if check.drift is not None and check.drift.relative > UNSETTLED:
        found.append(_unsettled(check.drift.relative))
    if check.is_fixed:
        found = [_of_fixed(warning) for warning in found]
    return tuple(sorted(found, key=lambda warning: not warning.is_grave))


def _ended_badly(run: Run, remedies: list[str]) -> Iterator[HealthWarning]:
    if run.outcome == "completed":
        return
    sentence = f"The run ended at step {run.first_step + run.steps}: {run.outcome}."
    if run.failure:
        sentence = f"{sentence[:-1]} ({run.failure.rstrip('.')})."
    if run.outcome in ("plant failed", "weight failed"):
        step = "correct the function that failed"
    else:
        step = OUTCOMES.get(run.outcome) or _or(remedies, SOFTER, "the sign of H and d_zu")
    yield HealthWarning("diverged", sentence, step, is_grave=run.outcome != "interrupted")


def _unstable(health: LoopHealth, remedies: list[str]) -> Iterator[HealthWarning]:
    if health.is_stable is False:
        yield HealthWarning(
            "unstable",
            "With the final controller held fixed the loop is unstable, spectral radius "
            f"{health.spectral_radius:.6g}.",
            _or(remedies, SOFTER, "the sign of H and d_zu", "a larger n_c", "more steps"),
            is_grave=True,
        )


def _transients(health: LoopHealth, run: Run, remedies: list[str]) -> Iterator[HealthWarning]:
    z = health.signals["z"]
    if z.after is None or z.late is None:
        return
    from_outside = max(_peak(run.w), _peak(run.x_0), z.before.peak if z.before else 0.0)
    scale = max(from_outside, z.late.peak, health.free.peak if health.free else 0.0)
    when = "Under control" if isinstance(run.settings, FixedController) else "While theta adapted"
    if scale and z.after.peak > TRANSIENT * scale:
        yield HealthWarning(
            "large transient",
            f"{when} |z| reached {z.after.peak:.3g}, {z.after.peak / scale:.2g} times "
            "all that acts on the loop or is left at its end.",
            _or(remedies, SOFTER, "a saturation of u, handed over as u_applied"),
            is_grave=z.after.peak > GRAVE * scale or not _ends_well(health),
        )


def _ends_well(health: LoopHealth) -> bool:
    """Whether the loop is stable, and z at the end no larger than without control."""
    late = health.signals["z"].late
    if not health.is_stable or health.outcome != "completed" or late is None:
        return False
    return health.free is None or late.rms <= max(health.free.rms, 1e-12 * _largest(health))


def _largest(health: LoopHealth) -> float:
    after = health.signals["z"].after
    return 0.0 if after is None else after.peak


def _control(
    health: LoopHealth, run: Run, found: LoopAnalysis, remedies: list[str]
) -> Iterator[HealthWarning]:
    u = health.signals["u"].after
    first = _first_gain(found)
    if u is None or run.saturation is not None or not first:
        return
    z = health.signals["z"]
    seen = [size.peak for size in (z.before, z.late, health.free) if size is not None]
    scale = max(_peak(run.w), _peak(run.x_0), *seen) * max(1.0, 1 / first)
    if scale and u.peak > LARGE_U * scale:
        yield HealthWarning(
            "large control",
            f"|u| reached {u.peak:.3g}; {scale:.2g} moves z in one step by as much as w and z ask "
            "for.",
            _or(remedies, SOFTER, "a saturation of u, handed over as u_applied", "a weight R_u"),
            is_grave=u.peak > GRAVE * scale or not _ends_well(health),
        )


def _worse(health: LoopHealth, run: Run) -> Iterator[HealthWarning]:
    late, free = health.signals["z"].late, health.free
    if late is None or free is None or run.outcome != "completed" or not free.rms:
        return
    idle = IDLE * max(_peak(run.w), _largest(health))
    if late.rms > max(WORSE * free.rms, idle):
        yield HealthWarning(
            "worse than without control",
            f"At the end rms z is {late.rms:.3g}, and {free.rms:.3g} with u = 0.",
            "the sign of H and d_zu, a larger n_c, a larger R_theta",
            is_grave=late.rms > TRANSIENT * free.rms,
        )


def _wound_up(health: LoopHealth) -> Iterator[HealthWarning]:
    """By trial where the plant is known; else by the growth of P alone."""
    record, kick = health.supervision, health.next_disturbance
    grown = "" if record is None else f"P grew to {record.growth:.2g} times P(0), and "
    remedy = "CappedForgetting or SubspaceForgetting in the place of lambda, or lambda = 1"
    if record is None or record.growth <= 1:
        grown = ""
        remedy = (
            "a larger R_theta, or a dither: P(0) is what directions without excitation still have"
        )
    if kick is not None and kick.ratio > KICKED:
        reached = "leaves float64" if not np.isfinite(kick.adapting) else f"{kick.adapting:.3g}"
        yield HealthWarning(
            "windup",
            _capital(f"{grown}the next disturbance, a fifth of w at most, may take z to {reached}, "
                     f"and to {kick.frozen:.3g} with theta held."),
            remedy,
            is_grave=kick.ratio > FAR,
        )  # fmt: skip
    elif kick is None and record is not None and (count := record.troubles.get("windup")):
        yield HealthWarning(
            "windup",
            f"From step {count.first} on, in {count.steps} steps, P was up to {count.worst:.2g} "
            "times P(0): the next disturbance meets a gain that no data support.",
            remedy,
            is_grave=not {"bounded", "frozen", "reset", "to fallback"} & set(record.troubles),
        )


def _missed(health: LoopHealth, found: LoopAnalysis) -> Iterator[HealthWarning]:
    missed = health.missed_by
    if missed is None or health.outcome != "completed" or health.is_held:
        return
    comparison = found.comparison
    if comparison.is_reached:
        return
    cure = what_places_them(found)
    usual = "a dither or a richer command: neither k_w nor R_theta alone places them"
    structure = found.structure
    if structure is not None and comparison.can_be_placed_by(structure) is False:
        cure = (
            f"another structure or target, where these poles matter: no theta of {structure.name} "
            f"with {structure.l_theta} coefficients places them; iir with n_c = "
            f"{comparison.plant.n} has enough"
        )
    yield HealthWarning(
        "missed poles",
        f"A pole that the target asks for is missed by {missed:.2g}; the closed-loop polynomial "
        f"differs by {comparison.backward_error:.2g} of itself.",
        cure or usual,
    )


def _costly(health: LoopHealth) -> Iterator[HealthWarning]:
    if health.cost_ratio is not None and health.cost_ratio > COSTLY:
        yield HealthWarning(
            "costly",
            f"For the noise of the run the final controller costs {health.cost_ratio:.3g} times "
            "what LQG does.",
            "more steps, a larger n_c, another R_theta",
        )


def warnings_of_controller(
    health: LoopHealth, record: SupervisionRecord
) -> tuple[HealthWarning, ...]:
    """Every warning of a controller that is driven step by step, the grave ones first."""
    found = [*_wound_up(health)]
    if count := record.troubles.get("overflow"):
        found.append(HealthWarning(
            "overflow",
            f"{count.steps} updates left float64, the last at step {count.last}; theta went back "
            "to that of the last look without trouble.",
            "lambda = 1 or CappedForgetting, a larger R_theta, the sign of H and d_zu",
            is_grave=True,
        ))  # fmt: skip
    if (count := record.troubles.get("missed sample")) and (
        count.steps > MISSED_SAMPLES * max(health.steps, 1)
    ):
        found.append(HealthWarning(
            "missed samples",
            f"{count.steps} of {health.steps} samples were missed; u was held there.",
            "a slower sample time, or a fallback for missed samples",
        ))  # fmt: skip
    if count := record.troubles.get("saturated"):
        found.append(HealthWarning(
            "saturated",
            f"The actuator did not apply u for up to {count.worst:.0f} steps on end.",
            "smaller commands or a stronger actuator, a larger R_theta",
        ))  # fmt: skip
    if record.in_fallback or record.is_frozen:
        words = "the fallback makes u" if record.in_fallback else "theta is held"
        found.append(HealthWarning(
            "stopped", f"By the policy of the supervision {words}.",
            "correct what its record reports, then Controller.resume()",
        ))  # fmt: skip
    if health.guard_count:
        found.append(HealthWarning(
            "rounding", f"{health.guard_count} updates were decided by rounding.",
            "a larger R_theta",
        ))  # fmt: skip
    return tuple(sorted(found, key=lambda warning: not warning.is_grave))


def _arithmetic(health: LoopHealth, run: Run) -> Iterator[HealthWarning]:
    if run.guard_count:
        yield HealthWarning(
            "rounding",
            f"{run.guard_count} updates, the first at step {run.guard_first_step}, were decided "
            "by rounding: the data cannot support this R_theta.",
            "a larger R_theta",
        )
    found = health.excitation
    if found is not None and found.drift > DRIFT:
        yield HealthWarning(
            "rounding",
            f"Rounding moved theta by {found.drift:.1g} of its size along directions that nothing "
            "excites, where exact arithmetic keeps theta(0): z does not tell apart what these "
            "coefficients do.",
            "a larger R_theta (the drift is proportional to 1/R_theta), or a controller without "
            "the inputs or measurements that repeat others",
        )


def _margins(health: LoopHealth) -> Iterator[HealthWarning]:
    for name, margins in health.margins.items():
        if words := small_margins(margins):
            at = "" if len(health.margins) == 1 else f" at {name}"
            yield HealthWarning(
                "small margins",
                f"The margins{at} are small: {', '.join(words)}.",
                "a larger R_theta or a weight R_u, a larger n_c",
            )


def small_margins(margins: Margins) -> list[str]:
    """The margins of a stable loop that are below 3 dB or 20 degrees, in words."""
    if not margins.is_stable:
        return []
    assert margins.gain_up is not None
    assert margins.gain_down is not None
    assert margins.phase is not None
    words = []
    if margins.gain_up.value < LEAST_GAIN:
        words.append(f"{margins.gain_up.value:.3g} times the gain is unstable")
    if margins.gain_down.value > 1 / LEAST_GAIN:
        words.append(f"{margins.gain_down.value:.3g} times the gain is unstable")
    if margins.phase.value < LEAST_PHASE:
        words.append(f"{margins.phase.value:.3g} degrees of phase are left")
    return words


def _saturated(run: Run) -> Iterator[HealthWarning]:
    if run.saturation is None or not run.steps:
        return
    last = slice(-max(run.steps // 10, 1), None)
    share = float(np.mean((run.u[last] != run.u_applied[last]).any(axis=1)))
    if share > SATURATED:
        yield HealthWarning(
            "saturated",
            f"In {share:.0%} of the last tenth of the steps the actuator did not apply u.",
            "smaller commands or a stronger actuator, a larger R_theta",
        )


def _learning(health: LoopHealth, run: Run) -> Iterator[HealthWarning]:
    excitation = health.excitation
    if excitation is not None and not excitation.outweighed and run.steps > health.k_w:
        yield HealthWarning(
            "no excitation",
            "The data never outweighed R_theta: theta hardly left theta(0).",
            "a smaller R_theta, more steps, a command or disturbance that moves the loop",
        )
    if (
        run.settings.l_theta
        and run.stride == 1
        and run.outcome == "completed"
        and len(run.theta) > 1
    ):
        moved = drift_of(run.theta).relative
        if moved > UNSETTLED:
            yield _unsettled(moved)


def _unsettled(moved: float) -> HealthWarning:
    return HealthWarning(
        "unsettled",
        f"theta still moved by {moved:.2g} of its size in the last tenth of the steps; what is "
        "said of the final controller is said of one moment.",
        "more steps, a larger R_theta, or lambda = 1",
    )


def _slow(health: LoopHealth) -> Iterator[HealthWarning]:
    radius = health.spectral_radius
    if health.is_stable and radius is not None and radius > 0 and health.steps > 1:
        steps = -1 / np.log(radius) if radius < 1 else np.inf
        if steps > SLOW * health.steps:
            yield HealthWarning(
                "slow",
                f"The slowest mode decays within {steps:.3g} steps by e, and the record has "
                f"{health.steps}.",
                "more steps, a target with faster poles, a smaller R_theta",
            )


def _target_errors(found: LoopAnalysis) -> tuple[TargetError, ...]:
    try:
        return target_errors(found.plant, found.compared_with)
    except CompensatorError:
        return ()


def _sampling_zeros(found: LoopAnalysis) -> tuple[str, ...]:
    try:
        return sampling_zero_remedies(found.plant, found.compared_with)
    except CompensatorError:
        return ()


def _direction_errors(found: LoopAnalysis) -> tuple[TargetError, ...]:
    try:
        return direction_errors(found.plant, found.compared_with)
    except CompensatorError:
        return ()


def _of_target(error: TargetError) -> HealthWarning:
    return HealthWarning(error.code, _capital(error.sentence), error.next_step)


def _first_gain(found: LoopAnalysis) -> float:
    """The largest entry of the first Markov parameter of G_zu that is not zero; 0 if unknown."""
    plant = found.run.plant
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


def _or(*steps: list[str] | str) -> str:
    """The remedies that the evidence names, and otherwise the usual ones in their order."""
    named = [step for group in steps if isinstance(group, list) for step in group]
    usual = [step for step in steps if isinstance(step, str)]
    return "; then ".join([*named, *usual][:3])


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


# Where a target model for several inputs and outputs loses zeros and their directions.

LARGEST = 10  # states of a plant whose zeros and directions are asked for, exactly, in a second
CODES = {
    "not a zero": "unmodelled zero",
    "in every channel": "zero in every channel",
    "in one channel": "zero in one channel",
    "on the input side": "zero on the input side",
    "in another direction": "zero in another direction",
}
REMEDY = 'zero_direction_target(plant), in a file model = "zero directions"'


def direction_errors(plant: Plant, target: TargetModel) -> tuple[TargetError, ...]:
    """What `check_directions` finds of a square G_zu with several inputs; nothing of others.

    They are said of loops that look well too: a zero that is lost hides an instability from z.
    """
    if plant.l_u < 2 or plant.l_u != plant.l_z or plant.n > LARGEST:
        return ()
    check = check_directions(target, plant)
    forms = [form for form in check.forms if form != "kept"]
    return tuple(
        TargetError(CODES[form], f"{sentence}.", REMEDY)
        for form, sentence in zip(forms, check.warnings, strict=True)
    )


# When a target model was not learnt as it should have been: the rules of `DataDriven` runs.

LONGEST = 20_000  # steps that the model is fitted to again
VISIBLE = 1e-3  # a residual this small beside z is of a start, a step or rounding, and never white
POOR = 0.1  # share of R_theta in what is known of the worst known coefficient
GROWTH = 1e6  # of an unstable mode while u is the dither alone
CAUSES = ("poor excitation", "unstable start")  # said where there is another warning


@dataclass(frozen=True)
class _Look:
    """What an ARX model of so many steps says of itself."""

    steps: int
    whiteness: float
    excitation: float
    visible: bool


def learning_warnings(run: Run) -> Iterator[HealthWarning]:
    """The warnings of a run with `DataDriven`, `CAUSES` first where they explain others."""
    settings = run.settings
    if not isinstance(settings, ControllerSettings) or settings.learning is None:
        return
    learning = settings.learning
    if run.first_step or run.steps <= learning.order + 1:
        return
    yield from _unstable_start(run, learning)
    if run.steps <= learning.start:
        return
    if not run.changes:
        yield HealthWarning(
            "nothing learnt",
            f"In {run.steps} steps u was not seen to act on z: there is no target model, and u is "
            "the dither alone.",
            f"a larger dither than {learning.dither:.3g}, ten times the noise in z; then a later "
            "start",
            is_grave=True,
        )
        return
    looks = _looks(run, learning)
    coloured = [look for look in looks if look.visible and look.whiteness < WHITE]
    if coloured:
        first = coloured[0]
        yield HealthWarning(
            "low order",
            f"The residuals of the ARX({learning.order}) are not white after {first.steps} steps "
            f"(probability {first.whiteness:.1g}): the order is below that of the plant and its "
            "noise, or the plant changed, and the zeros that were learnt may be wrong.",
            f"order = {2 * learning.order}; for a plant that changes lambda = 0.999 and a running "
            "dither",
        )
    if looks and looks[0].excitation > POOR:
        yield HealthWarning(
            "poor excitation",
            f"In the {looks[0].steps} steps of the start the dither of {learning.dither:.3g} did "
            "not excite every coefficient of the model: of the worst, "
            f"{looks[0].excitation:.0%} of what is known comes from its R_theta.",
            "a larger dither, a later start, or a smaller order",
        )


def _unstable_start(run: Run, learning: DataDriven) -> Iterator[HealthWarning]:
    try:
        plant = plant_at(run.plant, 0)
    except CompensatorError:  # no linear plant is known
        return
    radius = float(np.abs(np.linalg.eigvals(plant.A)).max(initial=0.0))
    with np.errstate(over="ignore"):
        growth = np.float64(radius) ** learning.start
    if radius > 1 and growth > GROWTH:
        least = max(learning.order + 1, int(np.log(1e3) / np.log(radius)))
        yield HealthWarning(
            "unstable start",
            f"The plant is unstable, spectral radius {radius:.4g}: in the {learning.start} steps "
            f"with the dither alone a mode grows {growth:.2g} times.",
            f"start = {least} or so, the least order, a dither ten times the noise, and d_zu and H "
            "told",
        )


def _looks(run: Run, learning: DataDriven) -> list[_Look]:
    """After the start, and at the end of what is looked at."""
    model = RecursiveARX(learning.order, R_theta=learning.R_theta, lambda_=learning.lambda_)
    found: list[_Look] = []
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
        found.append(_Look(last, online.whiteness, model.excitation(), bool(visible)))
    return found


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


# Sampling zeros near -1 that a target model has the controller cancel, and their remedy.

RINGING = 0.9  # a cancelled zero of this modulus or more rings for tens of steps


def sampling_zero_remedies(plant: Plant, target: TargetModel) -> tuple[str, ...]:
    """What to try where G_f asks for the cancellation of a zero of G_zu in (-1, -0.9].

    The controller pole that cancels it rings at half the sampling frequency, and a larger R_theta
    may make that worse: abs u from 2e4 to 9e4 for a second-order lag sampled at 10 Hz. Zeros
    elsewhere near the circle are left alone: telling those near 1 or near j made u larger
    wherever it was tried.
    """
    if (plant.l_u, plant.l_z, target.l_u, target.l_z) != (1, 1, 1, 1):
        return ()
    zeros = zeros_of(plant)
    real = zeros.real[np.abs(zeros.imag) < TURNED]
    near = np.sort(real[(real >= -1 - TURNED) & (real <= -RINGING)])
    modelled = np.roots(target.numerator[target.relative_degree :, 0, 0])
    told = int((np.abs(modelled + 1) <= 1 - RINGING + TURNED).sum())
    left = [f"{zero:.4g}" for zero in near[told:]]
    if not left:
        return ()
    words, on_circle = ", ".join(left), ", ".join(["-1"] * len(left))
    many, those = ("zeros", "ones") if len(left) > 1 else ("zero", "one")
    return (
        f"the {many} {words} of the plant told as {those} on the unit circle, nmp_zeros with "
        f"{on_circle}: with this G_f the controller cancels what rings, and a larger R_theta may "
        "make that worse",
    )
