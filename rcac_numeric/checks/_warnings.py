"""The warnings of a loop's health as a table: sentence, next step and gravity of each.

`_rules` evaluates the conditions and hands over the numbers that stand in braces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rcac_numeric.checks._health import HealthWarning
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._compatibility import AnyController

# A key of `RULES`, and the numbers of its sentence. `is_grave` and `next_step` among them override
# those of the rule.
Finding = tuple[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Rule:
    """The sentence and the next steps of a warning.

    Attributes
    ----------
    sentence : str
    steps : tuple of str
        Remedies in this order; a warning names at most three.
    is_grave : bool
        Whether the loop cannot be used as it is.
    fixed : str
        The next step for a controller that does not adapt: it has no R_theta, no k_w, no G_f.
    predictive : str
        The next step for predictive cost adaptive control, which has no k_w, no n_c, no G_f.
    first : str
        Remedies from the evidence that precede `steps`: none; those of errors in the target
        model; or also that of sampling zeros, which a larger R_theta may make worse.
    by_settings : bool
        Whether settings can cause it, so that the warning names `design` too.
    """

    sentence: str
    steps: tuple[str, ...] = ()
    is_grave: bool = False
    fixed: str = ""
    predictive: str = ""
    first: Literal["", "errors", "sampling zeros"] = ""
    by_settings: bool = False


Kind = Literal["RCAC", "PCAC", "fixed"]
MODEL = "a larger order (it covers the plant with its dead time), a longer horizon, or a larger R"
LIMITS = "limits=ControlLimits(...), a larger R, or a theta_0 nearer to the plant"
SOFTER = "a larger R_theta (100 times), or a later k_w"
SIGN = "the sign of H and d_zu"
SATURATION = "a saturation of u, handed over as u_applied"
ACTUATOR = "smaller commands or a stronger actuator"
OTHER = "another controller: design(plant), lqg_controller(plant), or a smaller gain of this one"
FIXED_SIGN = f"its sign, u = G_c y; then {OTHER}"
OTHER_SIGN = "the other sign of the controller: with u = -G_c y the loop is stable"
CAPPED = "CappedForgetting or SubspaceForgetting instead of lambda, or lambda = 1"
DITHER = "a larger R_theta, or a dither: directions without excitation keep P(0)"
NEXT_DISTURBANCE = (
    "next disturbance, of at most a fifth of w, may drive z to {reached} ({frozen:.3g} with theta "
    "held)."
)
WINDUP = (
    "From step {first} on, P was up to {worst:.2g} times P(0) in {steps} steps: no data support "
    "the gain with which the update answers the next disturbance."
)
ENDED = "The run ended at step {step}: {outcome}{failure}."
DIRECTIONS = ('zero_direction_target(plant), in a file model = "zero directions"',)

# The code of a warning is the part of the key before the colon.
RULES = {
    "diverged": Rule(
        ENDED, (SOFTER, SIGN), is_grave=True, fixed=FIXED_SIGN, predictive=MODEL, first="errors",
        by_settings=True,
    ),
    "diverged: overflow": Rule(
        ENDED, ("lambda = 1, or a reset: P grows in directions without excitation",),
        is_grave=True, fixed=FIXED_SIGN, predictive="lambda = 1, or a larger R_theta",
        by_settings=True,
    ),
    "diverged: unsupported R_theta": Rule(
        ENDED, ("a larger R_theta: this one is too small for the data",),
        is_grave=True, fixed=FIXED_SIGN, by_settings=True,
    ),
    "diverged: plant not finite": Rule(
        ENDED, ("smaller commands, or a saturation of u: the plant left float64",),
        is_grave=True, fixed=FIXED_SIGN, predictive=LIMITS, by_settings=True,
    ),
    "diverged: interrupted": Rule(ENDED, ("run it again",), by_settings=True),
    "diverged: plant failed": Rule(
        ENDED, ("correct the function that failed",), is_grave=True, by_settings=True
    ),
    "diverged: weight failed": Rule(
        ENDED, ("correct the function that failed",), is_grave=True, by_settings=True
    ),
    "unstable": Rule(
        "With the final controller fixed, the closed loop is unstable, spectral radius "
        "{radius:.6g}.",
        (SOFTER, SIGN, "{order}", "more steps"),
        is_grave=True, predictive=f"more steps; then {MODEL}",
        fixed=f"its sign, u = G_c y, and the plant's; then {OTHER}",
        first="errors", by_settings=True,
    ),
    "large transient": Rule(
        "{when} |z| reached {peak:.3g}, {times:.2g} times the largest of w, x(0), z with u = 0 and "
        "z at the end.",
        (SOFTER, SATURATION), predictive=LIMITS, fixed=f"{SATURATION}; then {OTHER}",
        first="sampling zeros", by_settings=True,
    ),
    "large control": Rule(
        "|u| reached {peak:.3g}; u = {scale:.2g} would move z in one step by the size of w and z.",
        (SOFTER, SATURATION, "a weight R_u"), predictive=LIMITS,
        fixed=f"{SATURATION}; then {OTHER}",
        first="sampling zeros", by_settings=True,
    ),
    "worse than without control": Rule(
        "At the end the rms of z is {late:.3g}; with u = 0 it is {free:.3g}.",
        (f"{SIGN}, {{order}}, a larger R_theta",), fixed=FIXED_SIGN, predictive=MODEL,
        by_settings=True,
    ),
    "windup": Rule(f"The {NEXT_DISTURBANCE}", (DITHER,)),
    "windup: P grew": Rule(
        f"P grew to {{growth:.2g}} times P(0), and the {NEXT_DISTURBANCE}", (CAPPED,)
    ),
    "windup: noted": Rule(WINDUP, (DITHER,)),
    "windup: noted, P grew": Rule(WINDUP, (CAPPED,)),
    "missed poles": Rule(
        "A target pole is missed by {missed:.2g}; the closed-loop polynomial has a backward error "
        "of {error:.2g}.",
        ("a dither or a richer command: neither k_w nor R_theta alone places them",),
    ),
    "costly": Rule(
        "For the noise of the run, the cost of the final controller is {ratio:.3g} times the LQG "
        "cost.",
        ("more steps, {order}, another R_theta",), predictive=f"more steps; then {MODEL}",
        fixed="lqg_controller(plant), which has the least cost", by_settings=True,
    ),
    "rounding": Rule(
        "Rounding decided {count} updates, the first at step {first}: R_theta is too small for "
        "these data.",
        ("a larger R_theta",),
    ),
    "rounding: of a live controller": Rule(
        "Rounding decided {count} updates.", ("a larger R_theta",)
    ),
    "rounding: drift": Rule(
        "Rounding moved theta by {drift:.1g} of its size along directions without excitation, "
        "where exact arithmetic keeps theta(0): z does not depend on them.",
        ("a larger R_theta (the drift is proportional to 1/R_theta), or a controller without "
         "redundant inputs or measurements",),
    ),
    "small margins": Rule(
        "The margins{at} are small: {margins}.",
        ("a larger R_theta or a weight R_u, {order}",), fixed=OTHER, predictive=MODEL,
        by_settings=True,
    ),
    "saturated": Rule(
        "In {share:.0%} of the last tenth of the steps the actuator did not apply u.",
        (f"{ACTUATOR}, a larger R_theta",), fixed=f"{ACTUATOR}; a smaller gain",
    ),
    "saturated: on end": Rule(
        "The actuator did not apply u for up to {steps:.0f} consecutive steps.",
        (f"{ACTUATOR}, a larger R_theta",),
    ),
    "no excitation": Rule(
        "The excitation was too small for R_theta: theta stayed near theta(0).",
        ("a smaller R_theta, more steps, a command or disturbance that moves the loop",),
    ),
    "unsettled": Rule(
        "theta still moved by {moved:.2g} of its size in the last tenth of the steps; the results "
        "for the final controller hold for the last step only.",
        ("more steps, a larger R_theta, or lambda = 1",), fixed="more steps",
        predictive="more steps, a larger R_theta, or lambda = 1",
    ),
    "slow": Rule(
        "The slowest mode has a time constant of {decay:.3g} steps; the record has {steps} steps.",
        ("more steps, a target with faster poles, a smaller R_theta",),
        fixed="more steps; a controller with faster closed-loop poles",
        predictive="more steps, a smaller R",
    ),
    "inconsistent log": Rule(
        "The logged u is not the output of the logged controller.",
        ("the structure, k_w, --k-c and the columns of the log",), is_grave=True,
        fixed="its transfer function and sign, u = G_c y, its inputs, and the columns of the log",
        predictive="the run as it was saved: its u, y, theta or settings were changed since",
    ),
    # For a controller that is driven step by step.
    "overflow": Rule(
        "{count} updates overflowed, the last at step {last}; the last valid theta was restored.",
        (f"lambda = 1 or CappedForgetting, a larger R_theta, {SIGN}",), is_grave=True,
    ),
    "missed samples": Rule(
        "{count} of {steps} samples were missed; u was held at these steps.",
        ("a slower sample time, or a fallback for missed samples",),
    ),
    "stopped": Rule(
        "The supervision has intervened: {how}.",
        ("correct the cause in Controller.record, then call Controller.resume()",),
    ),
    # For a target model that contradicts its plant.
    "wrong sign": Rule(
        "G_f begins with {lead:.4g} q^-{delay}, the plant with {plant:.4g} q^-{delay}: the sign "
        "differs.",
        ("change the sign of H (or of the target's numerator)",),
    ),
    "wrong d_zu": Rule(
        "G_f has a delay of {delay} steps from u to z, the plant of {d_zu}.",
        ("give the target d_zu = {d_zu}",),
    ),
    "unmodelled zero": Rule(
        "The plant has nonminimum-phase zeros that G_f lacks: {zeros}.",
        ("give the target nmp_zeros = [{zeros}]",),
    ),
    "unmodelled zero: of several channels": Rule("{sentence}.", DIRECTIONS),
    "zero in every channel": Rule("{sentence}.", DIRECTIONS),
    "zero in one channel": Rule("{sentence}.", DIRECTIONS),
    "zero on the input side": Rule("{sentence}.", DIRECTIONS),
    "zero in another direction": Rule("{sentence}.", DIRECTIONS),
    # For a target model that `DataDriven` did not identify well.
    "nothing learnt": Rule(
        "In {steps} steps no effect of u on z was identified: there is no target model, and u is "
        "the dither alone.",
        ("a larger dither than {dither:.3g}, ten times the noise in z", "a later start"),
        is_grave=True,
    ),
    "low order": Rule(
        "The residuals of the ARX({order}) are not white after {steps} steps (probability "
        "{whiteness:.1g}): the order is below that of the plant and its noise, or the plant "
        "changed, and the identified zeros may be wrong.",
        ("order = {twice}; for a plant that changes lambda = 0.999 and a running dither",),
    ),
    "poor excitation": Rule(
        "In the {steps} steps of the start the dither of {dither:.3g} did not excite every "
        "coefficient of the model: for the worst one, {excitation:.0%} of the information comes "
        "from its R_theta.",
        ("a larger dither, a later start, or a smaller order",),
    ),
    "unstable start": Rule(
        "The plant is unstable, spectral radius {radius:.4g}: in the {start} steps with the dither "
        "alone a mode grows {growth:.2g} times.",
        ("start = {least} or so, the least order, a dither ten times the noise, and known d_zu "
         "and H",),
    ),
}  # fmt: skip


def kind_of(settings: AnyController) -> Kind:
    """Return which settings a controller has: those of RCAC, of PCAC, or none that adapt."""
    if isinstance(settings, PredictiveCost):
        return "PCAC"
    return "fixed" if isinstance(settings, FixedController | StepwiseController) else "RCAC"


def order_of(structure: Structure | None) -> str:
    """Return the remedy for too few coefficients; a PID controller has no order n_c."""
    if structure is not None and structure.name.startswith("PID"):
        return "a structure with more coefficients, iir(n_c)"
    return "a larger n_c"


def warning_of(
    finding: Finding,
    errors: Sequence[str] = (),
    sampling_zeros: Sequence[str] = (),
    *,
    kind: Kind = "RCAC",
    order: str = "a larger n_c",
) -> HealthWarning:
    """Return the warning of a finding, with the remedies that the evidence and the kind name."""
    key, numbers = finding
    rule = RULES[key]
    named = {"": (), "errors": errors, "sampling zeros": (*sampling_zeros, *errors)}[rule.first]
    steps = [*named, *(step.format_map({"order": order, **numbers}) for step in rule.steps)]
    of_kind = {"RCAC": "", "PCAC": rule.predictive, "fixed": rule.fixed}[kind]
    if "next_step" in numbers:
        steps = [numbers["next_step"]]
    elif of_kind:
        steps = [of_kind]
    return HealthWarning(
        key.partition(":")[0],
        rule.sentence.format_map(numbers),
        "; then ".join(steps[:3]),
        is_grave=numbers.get("is_grave", rule.is_grave),
    )
