"""The warnings of a loop's health: the sentence, the next step and the gravity of each, as a table.

What is found, and with which numbers, is said in `_rules`; the numbers stand in braces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rcac_numeric.checks._health import HealthWarning

# What is found: a key of `RULES`, and the numbers of its sentence. `is_grave` and `next_step` among
# them go before those of the rule.
Finding = tuple[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Rule:
    """What is said where something is found.

    Attributes
    ----------
    sentence : str
    steps : tuple of str
        What to try, in this order; at most three are named.
    is_grave : bool
        Whether the loop cannot be used as it is.
    fixed : str
        The next step for a controller that does not adapt: it has no R_theta, no k_w, no G_f.
    first : str
        Which remedies that the evidence names go before `steps`: none, those of errors in the
        target model, or before these the one of sampling zeros too, which a larger R_theta may
        make worse.
    by_settings : bool
        Whether the settings can be blamed for it, so that `design` is named too.
    """

    sentence: str
    steps: tuple[str, ...] = ()
    is_grave: bool = False
    fixed: str = ""
    first: Literal["", "errors", "sampling zeros"] = ""
    by_settings: bool = False


SOFTER = "a larger R_theta (100 times), or a later k_w"
SIGN = "the sign of H and d_zu"
SATURATION = "a saturation of u, handed over as u_applied"
ACTUATOR = "smaller commands or a stronger actuator"
OTHER = "another controller: design(plant), lqg_controller(plant), or a smaller gain of this one"
FIXED_SIGN = f"its sign, u = G_c y; then {OTHER}"
CAPPED = "CappedForgetting or SubspaceForgetting in the place of lambda, or lambda = 1"
DITHER = "a larger R_theta, or a dither: P(0) is what directions without excitation still have"
NEXT_DISTURBANCE = (
    "next disturbance, a fifth of w at most, may take z to {reached}, and to {frozen:.3g} with "
    "theta held."
)
WINDUP = (
    "From step {first} on, in {steps} steps, P was up to {worst:.2g} times P(0): the next "
    "disturbance meets a gain that no data support."
)
ENDED = "The run ended at step {step}: {outcome}{failure}."
DIRECTIONS = ('zero_direction_target(plant), in a file model = "zero directions"',)

# The code of a warning is what stands before the colon.
RULES = {
    "diverged": Rule(
        ENDED, (SOFTER, SIGN), is_grave=True, fixed=FIXED_SIGN, first="errors", by_settings=True
    ),
    "diverged: overflow": Rule(
        ENDED, ("lambda = 1, or a reset: P grows in directions without excitation",),
        is_grave=True, fixed=FIXED_SIGN, by_settings=True,
    ),
    "diverged: unsupported R_theta": Rule(
        ENDED, ("a larger R_theta: the data cannot support this one",),
        is_grave=True, fixed=FIXED_SIGN, by_settings=True,
    ),
    "diverged: plant not finite": Rule(
        ENDED, ("smaller commands, or a saturation of u: the plant left float64",),
        is_grave=True, fixed=FIXED_SIGN, by_settings=True,
    ),
    "diverged: interrupted": Rule(ENDED, ("run it again",), by_settings=True),
    "diverged: plant failed": Rule(
        ENDED, ("correct the function that failed",), is_grave=True, by_settings=True
    ),
    "diverged: weight failed": Rule(
        ENDED, ("correct the function that failed",), is_grave=True, by_settings=True
    ),
    "unstable": Rule(
        "With the final controller held fixed the loop is unstable, spectral radius {radius:.6g}.",
        (SOFTER, SIGN, "a larger n_c", "more steps"),
        is_grave=True, fixed=f"its sign, u = G_c y, and the plant's; then {OTHER}",
        first="errors", by_settings=True,
    ),
    "large transient": Rule(
        "{when} |z| reached {peak:.3g}, {times:.2g} times all that acts on the loop or is left at "
        "its end.",
        (SOFTER, SATURATION), fixed=f"{SATURATION}; then {OTHER}",
        first="sampling zeros", by_settings=True,
    ),
    "large control": Rule(
        "|u| reached {peak:.3g}; {scale:.2g} moves z in one step by as much as w and z ask for.",
        (SOFTER, SATURATION, "a weight R_u"), fixed=f"{SATURATION}; then {OTHER}",
        first="sampling zeros", by_settings=True,
    ),
    "worse than without control": Rule(
        "At the end rms z is {late:.3g}, and {free:.3g} with u = 0.",
        (f"{SIGN}, a larger n_c, a larger R_theta",), fixed=FIXED_SIGN, by_settings=True,
    ),
    "windup": Rule(f"The {NEXT_DISTURBANCE}", (DITHER,)),
    "windup: P grew": Rule(
        f"P grew to {{growth:.2g}} times P(0), and the {NEXT_DISTURBANCE}", (CAPPED,)
    ),
    "windup: noted": Rule(WINDUP, (DITHER,)),
    "windup: noted, P grew": Rule(WINDUP, (CAPPED,)),
    "missed poles": Rule(
        "A pole that the target asks for is missed by {missed:.2g}; the closed-loop polynomial "
        "differs by {error:.2g} of itself.",
        ("a dither or a richer command: neither k_w nor R_theta alone places them",),
    ),
    "costly": Rule(
        "For the noise of the run the final controller costs {ratio:.3g} times what LQG does.",
        ("more steps, a larger n_c, another R_theta",),
        fixed="lqg_controller(plant), whose cost it is measured by", by_settings=True,
    ),
    "rounding": Rule(
        "{count} updates, the first at step {first}, were decided by rounding: the data cannot "
        "support this R_theta.",
        ("a larger R_theta",),
    ),
    "rounding: of a live controller": Rule(
        "{count} updates were decided by rounding.", ("a larger R_theta",)
    ),
    "rounding: drift": Rule(
        "Rounding moved theta by {drift:.1g} of its size along directions that nothing excites, "
        "where exact arithmetic keeps theta(0): z does not tell apart what these coefficients do.",
        ("a larger R_theta (the drift is proportional to 1/R_theta), or a controller without the "
         "inputs or measurements that repeat others",),
    ),
    "small margins": Rule(
        "The margins{at} are small: {margins}.",
        ("a larger R_theta or a weight R_u, a larger n_c",), fixed=OTHER, by_settings=True,
    ),
    "saturated": Rule(
        "In {share:.0%} of the last tenth of the steps the actuator did not apply u.",
        (f"{ACTUATOR}, a larger R_theta",), fixed=f"{ACTUATOR}; a smaller gain",
    ),
    "saturated: on end": Rule(
        "The actuator did not apply u for up to {steps:.0f} steps on end.",
        (f"{ACTUATOR}, a larger R_theta",),
    ),
    "no excitation": Rule(
        "The data never outweighed R_theta: theta hardly left theta(0).",
        ("a smaller R_theta, more steps, a command or disturbance that moves the loop",),
    ),
    "unsettled": Rule(
        "theta still moved by {moved:.2g} of its size in the last tenth of the steps; what is "
        "said of the final controller is said of one moment.",
        ("more steps, a larger R_theta, or lambda = 1",),
    ),
    "slow": Rule(
        "The slowest mode decays within {decay:.3g} steps by e, and the record has {steps}.",
        ("more steps, a target with faster poles, a smaller R_theta",),
        fixed="more steps; a controller with faster closed-loop poles",
    ),
    "inconsistent log": Rule(
        "The logged u is not the output of the logged controller.",
        ("the structure, k_w, --k-c and the columns of the log",), is_grave=True,
        fixed="its transfer function and sign, u = G_c y, what it reads, and the columns of the "
        "log",
    ),
    # Of a controller that is driven step by step.
    "overflow": Rule(
        "{count} updates left float64, the last at step {last}; theta went back to that of the "
        "last look without trouble.",
        (f"lambda = 1 or CappedForgetting, a larger R_theta, {SIGN}",), is_grave=True,
    ),
    "missed samples": Rule(
        "{count} of {steps} samples were missed; u was held there.",
        ("a slower sample time, or a fallback for missed samples",),
    ),
    "stopped": Rule(
        "By the policy of the supervision {how}.",
        ("correct what its record reports, then Controller.resume()",),
    ),
    # Where a target model contradicts its plant.
    "wrong sign": Rule(
        "G_f begins with {lead:.4g} q^-{delay}, the plant with {plant:.4g} q^-{delay}: the sign "
        "differs.",
        ("turn the sign of H (or of the target's numerator)",),
    ),
    "wrong d_zu": Rule(
        "G_f answers u after {delay} steps, the plant after {d_zu}.",
        ("give the target d_zu = {d_zu}",),
    ),
    "unmodelled zero": Rule(
        "The plant has nonminimum-phase zeros that G_f lacks: {zeros}.",
        ("give them to the target: nmp_zeros = [{zeros}]",),
    ),
    "unmodelled zero: of several channels": Rule("{sentence}.", DIRECTIONS),
    "zero in every channel": Rule("{sentence}.", DIRECTIONS),
    "zero in one channel": Rule("{sentence}.", DIRECTIONS),
    "zero on the input side": Rule("{sentence}.", DIRECTIONS),
    "zero in another direction": Rule("{sentence}.", DIRECTIONS),
    # When a target model was not learnt as it should have been, by `DataDriven`.
    "nothing learnt": Rule(
        "In {steps} steps u was not seen to act on z: there is no target model, and u is the "
        "dither alone.",
        ("a larger dither than {dither:.3g}, ten times the noise in z", "a later start"),
        is_grave=True,
    ),
    "low order": Rule(
        "The residuals of the ARX({order}) are not white after {steps} steps (probability "
        "{whiteness:.1g}): the order is below that of the plant and its noise, or the plant "
        "changed, and the zeros that were learnt may be wrong.",
        ("order = {twice}; for a plant that changes lambda = 0.999 and a running dither",),
    ),
    "poor excitation": Rule(
        "In the {steps} steps of the start the dither of {dither:.3g} did not excite every "
        "coefficient of the model: of the worst, {excitation:.0%} of what is known comes from its "
        "R_theta.",
        ("a larger dither, a later start, or a smaller order",),
    ),
    "unstable start": Rule(
        "The plant is unstable, spectral radius {radius:.4g}: in the {start} steps with the dither "
        "alone a mode grows {growth:.2g} times.",
        ("start = {least} or so, the least order, a dither ten times the noise, and d_zu and H "
         "told",),
    ),
}  # fmt: skip


def warning_of(
    finding: Finding,
    errors: Sequence[str] = (),
    sampling_zeros: Sequence[str] = (),
    *,
    is_fixed: bool = False,
) -> HealthWarning:
    """The warning of what was found; the other remedies are those that the evidence names."""
    key, numbers = finding
    rule = RULES[key]
    named = {"": (), "errors": errors, "sampling zeros": (*sampling_zeros, *errors)}[rule.first]
    steps = [*named, *(step.format_map(numbers) for step in rule.steps)]
    if is_fixed and rule.fixed:
        steps = [rule.fixed]
    elif "next_step" in numbers:
        steps = [numbers["next_step"]]
    return HealthWarning(
        key.partition(":")[0],
        rule.sentence.format_map(numbers),
        "; then ".join(steps[:3]),
        is_grave=numbers.get("is_grave", rule.is_grave),
    )
