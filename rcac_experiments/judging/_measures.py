"""The quantities that claims are checked by: a run in, a number out."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal, get_args

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.judging import _cost_measures as cost_measures
from rcac_numeric.analysis._boundaries import (
    StabilityBoundary,
    delay_boundary,
    gain_boundary,
    gain_crossovers,
    nowhere,
    phase_boundary,
    phase_crossovers,
)
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.analysis._opened_loop import broken_loop
from rcac_numeric.analysis._predictive_limits import predictive_cost_limit
from rcac_numeric.arrays._validation import integer, number, one_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._target_learner import acting_input
from rcac_numeric.identification._windows import IdentifiedWindow, identify_windows
from rcac_numeric.plants._problems import standard_plant
from rcac_numeric.plants._schedules import plant_at
from rcac_numeric.plants.gallery._zeros import plant_zeros

Measure = Callable[..., float]
MEASURES: dict[str, Measure] = {}
SignalName = Literal["z", "y", "u", "u_applied", "w"]
SIGNALS: tuple[str, ...] = get_args(SignalName)
MarginKind = Literal["gain up", "gain down", "phase lag", "phase lead", "delay"]
MARGINS: tuple[str, ...] = get_args(MarginKind)


def measure(function: Measure) -> Measure:
    """Make a function available to claims, under its name."""
    MEASURES[function.__name__] = function
    return function


for _function in cost_measures.COST_MEASURES:
    measure(_function)


WINDOW = 70  # samples, section 3.6


@measure
def largest_plant_zero(r: LoopAnalysis, at: int = 0) -> float:
    """Largest modulus of a zero from u to z of the plant of a step.

    Parameters
    ----------
    at : int
        A step.
    """
    return float(np.abs(plant_zeros(plant_at(r.run.plant, at))).max(initial=0.0))


@measure
def plant_zero_distance(
    r: LoopAnalysis, value: float, imaginary: float = 0.0, at: int = 0
) -> float:
    """Distance from a number to the nearest zero from u to z of the plant of a step.

    Parameters
    ----------
    value, imaginary : number
        The number, its imaginary part being zero where it is left out.
    at : int
        A step.
    """
    zeros = plant_zeros(plant_at(r.run.plant, at))
    return float(np.abs(zeros - complex(value, imaginary)).min(initial=np.inf))


@measure
def plant_spectral_radius(r: LoopAnalysis, at: int = 0) -> float:
    """Largest modulus of a pole of the plant of a step.

    Parameters
    ----------
    at : int
        A step.
    """
    return float(np.abs(np.linalg.eigvals(plant_at(r.run.plant, at).A)).max(initial=0.0))


@measure
def growth_rate(r: LoopAnalysis, period: float, at: int = 0) -> float:
    """Largest real part, in rad/s, of a pole of the continuous plant that a hold has sampled.

    Parameters
    ----------
    period : number
        The sampling period h, in seconds: a pole p is at exp(p h).
    at : int
        A step.
    """
    return float(np.log(plant_spectral_radius(r, at)) / number(period, "period"))


@measure
def delay_bound(r: LoopAnalysis, period: float, at: int = 0) -> float:
    """The delay, in seconds, that no controller's delay margin reaches: 2 over the growth rate.

    Parameters
    ----------
    period : number
        The sampling period, in seconds.
    at : int
        A step.
    """
    return 2 / growth_rate(r, period, at)


@measure
def continuous_zero_distance(r: LoopAnalysis, value: float, period: float, at: int = 0) -> float:
    """Distance, in rad/s, from a number to a zero of the plant that Euler's rule has sampled.

    Parameters
    ----------
    value : number
        In rad/s.
    period : number
        The sampling period h, in seconds: a zero s is at 1 + h s.
    at : int
        A step.
    """
    zeros = plant_zeros(plant_at(r.run.plant, at))
    return float(
        np.abs((zeros - 1) / number(period, "period") - number(value, "value")).min(initial=np.inf)
    )


@measure
def printed_plant_distance(r: LoopAnalysis, printed: str) -> float:
    r"""Distance of the first plant, up to its sign, from a printed transfer function.

    The largest difference of the two frequency responses at eleven frequencies, relative to the
    printed one; the sign is that of the problem, standard or servo.

    Parameters
    ----------
    printed : str
        A fraction of LaTeX, ``\frac{...}{...}`` with ``\mathbf{q}``.
    """
    plant, other = plant_at(r.run.plant, 0), standard_plant(_from_latex(printed))
    z = np.exp(1j * np.linspace(0.1, 3.0, 11))
    first, second = (
        np.array([(p.E_1 @ np.linalg.solve(x * np.eye(p.n) - p.A, p.B) + p.E_2)[0, 0] for x in z])
        for p in (plant, other)
    )
    apart = min(np.abs(first - second).max(), np.abs(first + second).max())
    return float(apart / np.abs(second).max())


def _from_latex(printed: str) -> str:
    """A fraction of LaTeX in the notation of files."""
    text = re.sub(r"\\mathbf\{([a-z])\}", "q", printed).replace(" ", "").replace("^", "**")
    match = re.fullmatch(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", text)
    if match is None:
        raise InputError(f"printed = {printed!r} is no fraction of polynomials in q.")
    top, bottom = (
        re.sub(r"(?<=[\d)])(?=[q(])(?<!\*\*)", "*", part).replace("**2*(", "**2*(")
        for part in match.groups()
    )
    return f"({top})/({bottom})"


@measure
def identified_zero_error(r: LoopAnalysis, start: int = 0, stop: int | None = None) -> float:
    """Largest distance of a zero that windows of 70 samples show from that of the plant.

    Parameters
    ----------
    start, stop : int
        First step of a window that counts, and the first step after the last one; to the end where
        `stop` is left out. The plant must not change between them.
    """
    end = r.run.steps if stop is None else integer(stop, "stop")
    chosen = [w for w in windows_of(r.run) if integer(start, "start") <= w.start and w.stop <= end]
    if not chosen:
        raise InputError(f"no window of {WINDOW} samples lies in [{start}, {end}).")
    return max(_distance(r.run, window) for window in chosen)


def windows_of(run: Run) -> tuple[IdentifiedWindow, ...]:
    """Models of the plant of a run, of its order, from windows of 70 samples."""
    n = plant_at(run.plant, 0).n
    return identify_windows(acting_input(run), run.z, 2 * n + 2, n, window=WINDOW, order=n)


def _distance(run: Run, window: IdentifiedWindow) -> float:
    if window.zeros is None:
        return float("inf")
    true, identified = plant_zeros(plant_at(run.plant, window.start)), window.zeros.zeros
    if len(true) != len(identified):
        return float("inf")
    return float(np.abs(identified[:, None] - true[None, :]).min(axis=1).max(initial=0.0))


# What is so of a plant, whatever the controller does.
OF_PLANT = frozenset(
    function.__name__
    for function in (
        largest_plant_zero,
        plant_zero_distance,
        plant_spectral_radius,
        growth_rate,
        delay_bound,
        continuous_zero_distance,
        printed_plant_distance,
        identified_zero_error,
        cost_measures.high_authority_cost,
        cost_measures.high_authority_exists,
        cost_measures.high_authority_pole_distance,
    )
)


@measure
def worst_pole_distance(r: LoopAnalysis) -> float:
    """Largest distance between a pole of G_f and the closed-loop pole assigned to it."""
    return r.comparison.worst_distance


@measure
def worst_spectrum_distance(r: LoopAnalysis) -> float:
    """Largest pole distance over all poles, those at zeros of G_zu and at 0 included."""
    return r.comparison.spectrum_distance


@measure
def backward_error(r: LoopAnalysis) -> float:
    """The relative change of the closed-loop polynomial that gives it the poles of G_f."""
    return r.comparison.backward_error


@measure
def polynomial_distance(r: LoopAnalysis) -> float:
    """Largest difference between a closed-loop coefficient, achieved and requested, both exact."""
    c = r.comparison
    if c.requested is None:
        raise InputError(f"there is no characteristic polynomial to compare with: {c.obstacle}")
    return float(max(map(abs, (c.reached - c.requested).all_coeffs())))


@measure
def limit_pole_distance(r: LoopAnalysis) -> float:
    """Largest distance of a final pole of predictive cost control from that of its exact limit."""
    return predictive_cost_limit(r.run).worst_distance


@measure
def limit_backward_error(r: LoopAnalysis) -> float:
    """The relative change of the loop polynomial that gives it the poles of the exact limit."""
    return predictive_cost_limit(r.run).backward_error


@measure
def spectral_radius(r: LoopAnalysis) -> float:
    """Largest modulus of a closed-loop pole with the final controller."""
    return r.loop.spectral_radius


@measure
def controller_spectral_radius(r: LoopAnalysis) -> float:
    """Largest modulus of a pole of the final controller."""
    return float(np.abs(r.run.compensator.poles()).max())


@measure
def controller_pole_distance(r: LoopAnalysis, omega: float = 0.0, k: int | None = None) -> float:
    """Distance from exp(j omega) to the nearest controller pole, at step k or at the end.

    Parameters
    ----------
    omega : float
        A frequency in rad/sample.
    k : int, optional
        A step; theta(k) must have been kept.
    """
    compensator = r.run.compensator if k is None else r.run.compensator_at(k)
    return float(np.abs(compensator.poles() - np.exp(1j * omega)).min())


@measure
def completed(r: LoopAnalysis) -> float:
    """1 where the run reached its last step, 0 where it diverged or failed before."""
    return float(r.run.outcome == "completed")


@measure
def steps(r: LoopAnalysis) -> float:
    """Number of completed steps."""
    return float(r.run.steps)


@measure
def coefficient(r: LoopAnalysis, index: int, k: int | None = None) -> float:
    """One entry of theta, from 0 on: of theta(k), or of the last theta.

    For structure = "pid" the entries are the gains in the order of the terms.

    Parameters
    ----------
    index : int
        Which entry, from 0 on.
    """
    run = r.run
    if k is None:
        theta = run.theta_final
    else:
        row, rest = divmod(integer(k, "k"), run.stride)
        if rest or row >= len(run.theta):
            raise InputError(
                f"k = {k}: theta(k) is recorded at multiples of {run.stride} below {run.steps}."
            )
        theta = run.theta[row]
    return float(theta[integer(index, "index", at_most=len(theta) - 1)])


@measure
def updates_at_bounds(r: LoopAnalysis) -> float:
    """Updates after which theta was moved to its bounds."""
    return float(r.run.bounded)


@measure
def radius_of_bounds(r: LoopAnalysis) -> float:
    """The largest share of the radius of CertifiedBounds that theta used, in its stored steps."""
    if (radius := r.run.radius) is None:
        raise InputError("the controller has no CertifiedBounds: bounds = { center, factor }.")
    return float(radius.max(initial=0.0))


@measure
def reflections(r: LoopAnalysis) -> float:
    """Number of updates after which controller poles were reflected (6.2.2)."""
    return float(r.run.reflections)


@measure
def resets(r: LoopAnalysis) -> float:
    """Number of covariance resets."""
    return float(r.run.resets)


@measure
def unstable_fraction(r: LoopAnalysis, stop: int | None = None) -> float:
    """Fraction of the steps below `stop` at which the loop, frozen at theta(k), is unstable."""
    return float(np.mean(_unstable(r, stop)))


@measure
def last_unstable_step(r: LoopAnalysis) -> float:
    """Last step at which the loop, frozen at theta(k), is unstable; -1 if there is none."""
    steps = np.flatnonzero(_unstable(r, None))
    return float(steps[-1] * r.run.stride) if steps.size else -1.0


@measure
def first_unstable_controller(r: LoopAnalysis) -> float:
    """First step at which theta(k) describes an unstable controller; -1 if there is none."""
    run = r.run
    for row, theta in enumerate(run.theta):
        if np.abs(run.settings.compensator_of(theta).poles()).max() > 1:
            return float(row * run.stride)
    return -1.0


@measure
def theta_drift(r: LoopAnalysis, start: int) -> float:
    """Largest change of a controller coefficient after step `start`, relative to the largest."""
    late = r.run.theta[-(-start // r.run.stride) :]
    if not len(late):
        raise InputError(f"the run of {r.run.steps} steps has no theta from step {start} on.")
    return float(np.abs(late - r.run.theta_final).max() / np.abs(r.run.theta_final).max())


@measure
def closed_loop_zero_distance(r: LoopAnalysis, channel: str, omega: float = 0.0) -> float:
    """Distance from exp(j omega) to the nearest closed-loop zero from a channel of w to z."""
    zeros = r.zeros
    if channel not in zeros:
        raise InputError(f"w has no channel {channel!r}; the channels are {', '.join(zeros)}.")
    return float(np.abs(zeros[channel] - np.exp(1j * omega)).min())


@measure
def guard_count(r: LoopAnalysis) -> float:
    """Number of updates that rounding decided."""
    return float(r.run.guard_count)


def _unstable(r: LoopAnalysis, stop: int | None) -> np.ndarray:
    run = r.run
    rows = run.theta if stop is None else run.theta[: -(-stop // run.stride)]
    return np.array(
        [
            not frozen_loop(
                run.plant, run.settings.compensator_of(theta), row * run.stride
            ).is_stable
            for row, theta in enumerate(rows)
        ]
    )


@measure
def worst_match(r: LoopAnalysis) -> float:
    """Largest relative distance of the intercalated transfer function to G_f over frequency."""
    return r.match.worst


@measure
def median_match(r: LoopAnalysis) -> float:
    """Median relative distance of the intercalated transfer function to G_f over frequency."""
    return r.match.median


@measure
def match_change(r: LoopAnalysis, since: int) -> float:
    """The median match over the one of theta(since); below 1 where it has come nearer.

    Parameters
    ----------
    since : int
        An earlier step at which theta was kept.
    """
    return r.match.median / r.until(since).match.median


@measure
def matching_error_share(r: LoopAnalysis, start: int = 0) -> float:
    """Mean square of (G~zu~ - G_f) u~ over that of the rest of the residual (4.14), G~zw w.

    From an initial state the rest holds the response to it too.

    Parameters
    ----------
    start : int
        First step that counts.
    """
    split = r.split
    error = split.matching_error[start:]
    rest = (split.residual - split.matching_error)[start:]
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return float(np.divide(np.sum(error**2), np.sum(rest**2)))


@measure
def settling_step(r: LoopAnalysis, band: float = 0.02) -> float:
    """First step from which the size of z stays within the band to the end of the run.

    Parameters
    ----------
    band : float
        Largest size of z.
    """
    if r.run.outcome != "completed":
        return float("inf")
    outside = np.flatnonzero(np.abs(r.run.z).max(axis=1) > band)
    return float(outside[-1] + 1) if outside.size else 0.0


@measure
def peak(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int | None = None,
) -> float:
    """Largest size of a signal over start <= k < stop; of one channel or of all of them.

    Parameters
    ----------
    start, stop : int
        First step that counts, and the first that does not count any more; to the end where
        `stop` is left out.
    signal : {"z", "y", "u", "u_applied", "w"}
        The signal; u_applied is the output of the actuator.
    channel : int or str
        A component from 0 on; for zeros the name of a channel of w.
    """
    return float(np.abs(_window(r, start, stop, signal, channel)).max())


@measure
def rms(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int | None = None,
) -> float:
    """Root mean square of a signal over start <= k < stop."""
    squares = _window(r, start, stop, signal, channel) ** 2
    # The sum over one channel is that channel: the same bits, in half the time.
    powers = squares[:, 0] if squares.shape[1] == 1 else np.sum(squares, axis=1)
    return float(np.sqrt(np.add.reduce(powers) / len(powers)))


@measure
def mean(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int = 0,
) -> float:
    """Mean of one channel of a signal over start <= k < stop."""
    return float(np.mean(_window(r, start, stop, signal, channel)))


@measure
def saturated_fraction(r: LoopAnalysis, start: int = 0, stop: int | None = None) -> float:
    """Fraction of the steps start <= k < stop at which the actuator did not apply u as it was."""
    u, applied = (_window(r, start, stop, name, None) for name in ("u", "u_applied"))
    return float(np.mean((u != applied).any(axis=1)))


def _window(
    r: LoopAnalysis, start: int, stop: int | None, signal: str, channel: int | None
) -> np.ndarray:
    values: np.ndarray = getattr(r.run, one_of(signal, "signal", SIGNALS))
    window = values[start:stop]
    if not len(window):
        raise InputError(f"the run of {r.run.steps} steps has no step in [{start}, {stop}).")
    if channel is None:
        return window
    last = integer(channel, "channel", at_most=window.shape[1] - 1)
    return window[:, last : last + 1]


@measure
def margin(r: LoopAnalysis, kind: MarginKind = "gain up") -> float:
    """A stability margin of the loop with the final controller; not a number if it is unstable.

    Parameters
    ----------
    kind : {"gain up", "gain down", "phase lag", "phase lead", "delay"}
        Factor of the gain, degrees of phase, or steps of delay at which stability is lost.
    """
    return _boundary(r, kind).value


@measure
def margin_frequency(r: LoopAnalysis, kind: MarginKind = "gain up") -> float:
    """Frequency in rad/sample at which the loop loses stability at that margin."""
    return _boundary(r, kind).frequency


@measure
def frozen_spectral_radius(r: LoopAnalysis, at: int) -> float:
    """Largest modulus of a pole of the plant of a step in a loop with the theta of that step.

    Where the plant changes at that step, it is the new plant with what was adapted to the old one.

    Parameters
    ----------
    at : int
        A step at which theta was kept.
    """
    run = r.run
    return frozen_loop(run.plant, run.compensator_at(at), at).spectral_radius


@measure
def stable_from(r: LoopAnalysis, start: int = 0) -> float:
    """First stored step from which the loop, frozen at theta(k), is stable to the end of the run.

    Infinity where it is unstable at the last one; steps before `start` do not count.
    """
    run = r.run
    if run.outcome != "completed":
        return float("inf")
    first = -(-integer(start, "start") // run.stride)
    step = float("inf")
    for row in reversed(range(first, len(run.theta))):
        k = row * run.stride
        if not frozen_loop(run.plant, run.settings.compensator_of(run.theta[row]), k).is_stable:
            break
        step = float(k)
    return step


def _boundary(r: LoopAnalysis, kind: str) -> StabilityBoundary:
    one_of(kind, "kind", MARGINS)
    opened = broken_loop(r.loop, at="u", channel=0, feedback=None)
    if not opened.is_stable:
        return nowhere(np.nan)
    if kind.startswith("gain"):
        return gain_boundary(opened, phase_crossovers(opened), up=kind == "gain up")
    crossovers = gain_crossovers(opened)
    if kind == "delay":
        return delay_boundary(opened, crossovers)
    return phase_boundary(opened, crossovers, lead=kind == "phase lead")
