"""The report of a step test: plant, operating point, residual, evidence, next step."""

from __future__ import annotations

from typing import Any

from rcac_numeric.designing._plants import Uncertainty
from rcac_numeric.designing._step_tests import uncertainty_of_step
from rcac_numeric.identification._step_response import StepResponse
from rcac_numeric.reports._sheet import Fact, Section, Sheet


def step_response_sheet(step: StepResponse) -> Sheet:
    """The five lines of a step test."""
    facts = (
        Fact("Plant", f"{step.kind}: {step.words}"),
        Fact("Operating point", _operating_point(step)),
        Fact("Residual", _residual(step)),
        Fact("Evidence", _evidence(step)),
        Fact(
            "Next step",
            f"design(step), or rcac design; control period {step.control_period:.4g} {step.unit}"
            if step.sample_time
            else "give sample_time: without a clock times are in steps",
        ),
    )
    record: dict[str, Any] = {
        "kind": step.kind, "plant": step.plant, "gain": step.gain,
        "gain_interval": step.gain_interval, "dead_time": step.dead_time,
        "dead_time_interval": step.dead_time_interval, "time_constants": step.time_constants,
        "damping": step.damping, "natural_frequency": step.natural_frequency,
        "residence_time": step.residence_time, "operating_point": step.operating_point,
        "slope": step.slope, "is_moving": step.is_moving, "moves": step.moves,
        "residual": step.residual, "noise": step.noise, "explained": step.explained,
        "jumps": step.jumps, "u_noise": step.u_noise, "spikes": step.spikes,
        "sample_time": step.sample_time, "control_period": step.control_period,
    }  # fmt: skip
    record["credible_kinds"] = dict(step.credible_kinds)
    record["gates"] = {
        gate.name: {"passed": gate.passed, "value": gate.value, "limit": gate.limit}
        for gate in step.gates
    }
    return Sheet("Step test", f": G(s) = {_with_dead_time(step)}", sections=(
        Section("", facts, {"step_response": record}),
    ))  # fmt: skip


def design_command(step: StepResponse) -> str:
    """The command that designs a controller; what no step test shows stands as a placeholder."""
    if not step.sample_time:
        return "the same command with --sample-time SECONDS; rcac design needs seconds"
    uncertain = uncertainty_of_step(step, step.control_period)
    low, high = uncertain.gain
    words = (
        f'rcac design "{step.plant}" --dead-time {step.dead_time:.4g} --sample-time '
        f"{step.control_period:.4g} --noise {step.residual:.2g}"
    )
    usual = Uncertainty()
    if uncertain.gain != usual.gain:
        words += f" --uncertain-gain {low:.2g},{high:.2g}"
    if uncertain.delay != usual.delay:
        words += f" --uncertain-delay {uncertain.delay}"
    if uncertain.time != usual.time:
        words += f" --uncertain-time {uncertain.time:.3g}"
    # Without these the command asks, and refuses where no terminal can answer.
    return f"{words} --disturbance SIZE --u-limits LOW,HIGH"


def _with_dead_time(step: StepResponse) -> str:
    return f"{step.plant} exp(-{step.dead_time:.4g} s)"


def _operating_point(step: StepResponse) -> str:
    u, y = step.operating_point
    words = f"u = {u:.5g}, y = {y:.5g}; moves of u: {step.moves}"
    if step.u_noise:
        words += f"; noise of u averaged (standard deviation {step.u_noise:.2g})"
    if step.is_moving:
        words += "; y moved before u did, which is fitted"
    return words


def _residual(step: StepResponse) -> str:
    words = (
        f"{step.residual:.3g} (standard deviation, {step.noise}); the model explains "
        f"{100 * step.explained:.4g} % of var(y)"
    )
    if step.slope:
        words += f"; y drifts by {step.slope:.3g} per {'s' if step.sample_time else 'step'}"
    for time, size in step.jumps:
        words += f"; level jump of {size:.3g} at {time:.4g} {step.unit}"
    if step.spikes:
        words += f"; single spikes replaced: {step.spikes}"
    return words


def _evidence(step: StepResponse) -> str:
    words = f"gates passed: {', '.join(gate.name for gate in step.gates)}"
    rivals = [f"{kind} (BIC +{d:.1f})" for kind, d in step.credible_kinds if kind != step.kind]
    return f"{words}; also credible: {', '.join(rivals)}" if rivals else words
