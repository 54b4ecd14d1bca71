"""The metrics of a run: numbers measured where it ran."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Never

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.judging._measures import MEASURES
from rcac_experiments.sweeps._axes import RESERVED
from rcac_experiments.sweeps._canonical import plain
from rcac_numeric.analysis._boundaries import StabilityBoundary
from rcac_numeric.analysis._classical import Margins, stability_margins
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._pairing import pairing
from rcac_numeric.arrays._values import Value

# The measures of how far the final loop is from instability; no number where it is unstable.


def gain_margin(r: LoopAnalysis) -> float:
    """Least factor above 1 of the loop gain at which the final loop is no longer stable."""
    return _value(_margins(r).gain_up)


def phase_margin(r: LoopAnalysis) -> float:
    """Least turn of the loop's phase, in degrees, at which the final loop is no longer stable."""
    return _value(_margins(r).phase)


def delay_margin(r: LoopAnalysis) -> float:
    """Least additional delay, in steps, at which the final loop is no longer stable."""
    return _value(_margins(r).delay)


def disk_margin(r: LoopAnalysis) -> float:
    """The disk margin alpha of the final loop: gain and phase varied together."""
    disk = _margins(r).disk
    return math.nan if disk is None else disk.alpha


def _margins(r: LoopAnalysis) -> Margins:
    return stability_margins(r.loop)


def _value(boundary: StabilityBoundary | None) -> float:
    return math.nan if boundary is None else float(boundary.value)


MARGIN_MEASURES = {
    measure.__name__: measure for measure in (gain_margin, phase_margin, delay_margin, disk_margin)
}


MeasureFunction = Callable[..., float]
# What looks at theta while it moved; the others need its last value only.
OF_THETA_OVER_TIME = (
    "controller_pole_distance",
    "coefficient",
    "unstable_fraction",
    "last_unstable_step",
    "first_unstable_controller",
)


def worst_pole_distance(r: LoopAnalysis, exact: bool = False) -> float:
    """Largest distance between a pole of G_f and the closed-loop pole assigned to it.

    Parameters
    ----------
    exact : bool
        From certified roots of exact polynomials, some 30 ms a run, instead of float64
        eigenvalues: they differ by what rounding makes of nearly equal poles.
    """
    if exact:
        return r.comparison.worst_distance
    target = r.compared_with
    if (target.l_z, target.l_u) != (1, 1):
        raise InputError("the poles of a target model that is not scalar are not assigned.")
    target_poles = np.roots(target.denominator[:, 0, 0]).astype(np.complex128)
    pairs = pairing(target_poles, r.loop.poles())
    return max((abs(a - b) for a, b in pairs), default=0.0)


# What a study may keep by name: what claims may ask for, and the faster forms of some of it.
STUDY_MEASURES: dict[str, MeasureFunction] = {
    **MEASURES,
    **MARGIN_MEASURES,
    "worst_pole_distance": worst_pole_distance,
}


@dataclass(frozen=True, eq=False, init=False)
class Metric(Value):
    """A number that is stored for every run.

    Parameters
    ----------
    measure : str or function
        The name of a measure, or a function at the top of a module that takes an `LoopAnalysis` and
        returns a number.
    name : str, optional
        Name of its column; default: that of the measure.
    arguments : mapping
        Keyword arguments of the measure.

    Raises
    ------
    InputError
        Where the measure is not known or does not take these arguments, the name cannot be that of
        a column, or a keyword of the measure stands outside `arguments`.

    Examples
    --------
    >>> from rcac_experiments.sweeps import Metric
    >>> Metric("peak", "error", {"start": 900})
    Metric(error = peak(start=900))
    """

    name: str
    measure: str | MeasureFunction
    arguments: dict[str, Any]

    def __init__(
        self,
        measure: str | MeasureFunction,
        name: str = "",
        arguments: Mapping[str, Any] | None = None,
        **others: Never,
    ) -> None:
        if others:
            extra: dict[str, object] = dict(others)
            raise InputError(
                f"Metric has the parameters measure, name and arguments, not {', '.join(extra)}; "
                f"write arguments of the measure as arguments={extra!r}."
            )
        default_name = measure if isinstance(measure, str) else getattr(measure, "__name__", "")
        set_ = object.__setattr__
        set_(self, "measure", measure)
        set_(self, "name", name or default_name)
        set_(self, "arguments", {key: plain(v) for key, v in (arguments or {}).items()})
        require_column(self.name)
        try:
            inspect.signature(self.function).bind(None, **self.arguments)
        except TypeError as error:
            raise InputError(f"the measure {self.name!r}: {error}.") from None

    @property
    def function(self) -> MeasureFunction:
        """The function of the measure."""
        if callable(self.measure):
            return self.measure
        if self.measure not in STUDY_MEASURES:
            raise InputError(
                f"the measure {self.measure!r} is not known; known are "
                f"{', '.join(STUDY_MEASURES)}.{did_you_mean(self.measure, STUDY_MEASURES)}"
            )
        return STUDY_MEASURES[self.measure]

    @property
    def needs_theta(self) -> bool:
        """Whether the measure needs theta over time; a function may."""
        return callable(self.measure) or self.measure in OF_THETA_OVER_TIME

    def __repr__(self) -> str:
        measure = self.measure if isinstance(self.measure, str) else self.measure.__name__
        arguments = ", ".join(f"{key}={value!r}" for key, value in self.arguments.items())
        return f"Metric({self.name} = {measure}({arguments}))"


def require_column(name: str) -> None:
    """Refuse an invalid name of a column."""
    if not isinstance(name, str) or not name.isidentifier() or name.lower() in RESERVED:
        raise InputError(
            f"a column cannot be called {name!r}; give `name` in letters, digits and "
            f"underscores, and none of {', '.join(RESERVED)}."
        )
