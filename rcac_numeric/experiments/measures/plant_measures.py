"""The measures of a run's plant: its zeros, and those that the data of the run show."""

from __future__ import annotations

import re

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.loop_analysis import LoopAnalysis
from rcac_numeric.arrays.validation import integer, number
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.target_learner import acting_input
from rcac_numeric.identification.windows import IdentifiedWindow, identify_windows
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.plants.gallery.zeros import plant_zeros
from rcac_numeric.plants.problems import standard_plant

WINDOW = 70  # samples, section 3.6


def largest_plant_zero(r: LoopAnalysis, at: int = 0) -> float:
    """Largest modulus of a zero from u to z of the plant of a step.

    Parameters
    ----------
    at : int
        A step.
    """
    return float(np.abs(plant_zeros(plant_at(r.run.plant, at))).max(initial=0.0))


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


def plant_spectral_radius(r: LoopAnalysis, at: int = 0) -> float:
    """Largest modulus of a pole of the plant of a step.

    Parameters
    ----------
    at : int
        A step.
    """
    return float(np.abs(np.linalg.eigvals(plant_at(r.run.plant, at).A)).max(initial=0.0))


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


def printed_plant_distance(r: LoopAnalysis, printed: str) -> float:
    r"""How far the first plant, up to its sign, is from a transfer function as it is printed.

    The largest difference of the two frequency responses at eleven frequencies, relative to the
    printed one; the sign is that of the problem, standard or servo.

    Parameters
    ----------
    printed : str
        A fraction of LaTeX, ``\frac{...}{...}`` with ``\mathbf{q}``.
    """
    plant, other = plant_at(r.run.plant, 0), standard_plant(_from_latex(printed))
    z = np.exp(1j * np.linspace(0.1, 3.0, 11))
    here, there = (
        np.array([(p.E_1 @ np.linalg.solve(x * np.eye(p.n) - p.A, p.B) + p.E_2)[0, 0] for x in z])
        for p in (plant, other)
    )
    apart = min(np.abs(here - there).max(), np.abs(here + there).max())
    return float(apart / np.abs(there).max())


def _from_latex(printed: str) -> str:
    """A fraction of LaTeX in the notation of files."""
    text = re.sub(r"\\mathbf\{([a-z])\}", "q", printed).replace(" ", "").replace("^", "**")
    found = re.fullmatch(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", text)
    if found is None:
        raise InputError(f"printed = {printed!r} is no fraction of polynomials in q.")
    top, bottom = (
        re.sub(r"(?<=[\d)])(?=[q(])(?<!\*\*)", "*", part).replace("**2*(", "**2*(")
        for part in found.groups()
    )
    return f"({top})/({bottom})"


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
    """What windows of 70 samples of a run show of its plant, of whose order the model is."""
    n = plant_at(run.plant, 0).n
    return identify_windows(acting_input(run), run.z, 2 * n + 2, n, window=WINDOW, order=n)


def _distance(run: Run, window: IdentifiedWindow) -> float:
    if window.zeros is None:
        return float("inf")
    true, found = plant_zeros(plant_at(run.plant, window.start)), window.zeros.zeros
    if len(true) != len(found):
        return float("inf")
    return float(np.abs(found[:, None] - true[None, :]).min(axis=1).max(initial=0.0))


PLANT_MEASURES = (
    largest_plant_zero,
    plant_zero_distance,
    plant_spectral_radius,
    growth_rate,
    delay_bound,
    continuous_zero_distance,
    printed_plant_distance,
    identified_zero_error,
)
