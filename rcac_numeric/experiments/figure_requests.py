"""Which figures answer the questions of an experiment: data, drawn elsewhere."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, one_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.format.lists import ListOf, MapOf
from rcac_numeric.experiments.format.places import did_you_mean
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Choice, Integer, Numbers, Text
from rcac_numeric.experiments.measures.measures import MEASURES

KINDS = (
    "sheet",
    "responses",
    "coefficients",
    "poles",
    "disturbance response",
    "intercalated match",
    "distribution",
    "estimates",
    "plant zeros",
    "identified zeros",
)
SIGNALS = ("z", "u", "y", "u_applied")


@dataclass(frozen=True, eq=False, init=False)
class FigureRequest(Value):
    """One figure: what is drawn, of which runs, and the sentence below it.

    Parameters
    ----------
    kind : str
        "sheet": all about one run. "responses": a signal of several runs in one pair of axes.
        "coefficients": theta of each run. "poles": closed-loop poles and zeros of each run.
        "disturbance response": gain from w to z with the final controllers, without one, and with
        LQG. "intercalated match": G_f and what each run made of it. "distribution": a measure over
        the repetitions or seeds of each run. "estimates", of estimation examples: what each run
        estimates beside the truth, or with `magnitude` its error.
        the repetitions or seeds of each run. "plant zeros": those of the plant, frozen at steps.
        "identified zeros": those that windows of the run's data show.
    caption : str
        What the reader is to see in it.
    runs : list of str
        Their names; all where they are left out.
    signal : str
        "z", "u", "y" or "u_applied", for "responses".
    first, last : int, optional
        The steps that are shown.
    magnitude : bool
        Draw the absolute value on a logarithmic axis; of coefficients the sign is kept.
    measure : str
        For "distribution".
    channel : str
        For "disturbance response": the block or channel of w; all by default.
    noise : mapping
        Intensities of w by block or channel, for which LQG is designed and costs are measured; 1
        for all by default.
    designs : list of mappings
        For "disturbance response": several such intensities, with an LQG controller for each.
    direct : bool
        For the distribution of a cost: whether what w adds to z directly counts.

    Examples
    --------
    >>> from rcac_numeric.experiments.figure_requests import FigureRequest
    >>> FigureRequest("responses", "The three settle.", runs=["a", "b"]).signal
    'z'
    """

    kind: str
    caption: str
    runs: tuple[str, ...]
    signal: str
    first: int
    last: int | None
    magnitude: bool
    measure: str
    channel: str
    noise: dict[str, Any]
    designs: tuple[dict[str, Any], ...]
    direct: bool

    def __init__(
        self,
        kind: str,
        caption: str,
        runs: Sequence[str] = (),
        signal: str = "z",
        first: int = 0,
        last: int | None = None,
        magnitude: bool = False,
        measure: str = "",
        channel: str = "",
        noise: Mapping[str, Any] | None = None,
        designs: Sequence[Mapping[str, Any]] = (),
        direct: bool = True,
    ) -> None:
        for name, value in (("caption", caption), ("measure", measure), ("channel", channel)):
            instance_of(value, name, str)
        instance_of(magnitude, "magnitude", bool)
        instance_of(direct, "direct", bool)
        fields = {
            "kind": one_of(kind, "kind", KINDS),
            "caption": caption,
            "runs": tuple(instance_of(run, "a run", str) for run in runs),
            "signal": one_of(signal, "signal", SIGNALS),
            "first": integer(first, "first", at_least=0),
            "last": None if last is None else integer(last, "last", at_least=first + 1),
            "magnitude": magnitude,
            "measure": measure,
            "channel": channel,
            "noise": dict(instance_of({} if noise is None else noise, "noise", Mapping)),
            "designs": tuple(dict(instance_of(d, "a design", Mapping)) for d in designs),
            "direct": direct,
        }
        if (kind == "distribution") != bool(measure):
            raise InputError(
                'a figure of the kind "distribution" names its measure'
                if not measure
                else f"a figure of the kind {kind!r} draws no measure; leave measure out"
            )
        for field, kept in fields.items():
            object.__setattr__(self, field, kept)


# What a case that asks for no figure is drawn by: one question each.
STANDARD_FIGURES = (
    FigureRequest("responses", "Performance z of every run."),
    FigureRequest("coefficients", "The coefficients theta of every run that adapts."),
    FigureRequest("poles", "Closed-loop poles and zeros with the final controllers."),
    FigureRequest("intercalated match", "The target model, and what each run made of it."),
)


def require_drawable(request: FigureRequest, runs: Collection[str]) -> FigureRequest:
    """The request itself, where the runs and the measure that it names are there.

    Raises
    ------
    InputError
        Names what is not there.

    Examples
    --------
    >>> from rcac_numeric.experiments.figure_requests import FigureRequest, require_drawable
    >>> require_drawable(FigureRequest("poles", "Where they are.", runs=["a"]), {"a"}).kind
    'poles'
    """
    for name in request.runs:
        if name not in runs:
            raise InputError(
                f"a figure asks for the run {name!r}; the runs are {', '.join(runs)}."
                f"{did_you_mean(name, runs)}"
            )
    if request.measure and request.measure not in MEASURES:
        raise InputError(
            f"a figure asks for the measure {request.measure!r}; known are {', '.join(MEASURES)}."
            f"{did_you_mean(request.measure, MEASURES)}"
        )
    return request


FIGURE = Table(
    FigureRequest,
    forms={
        "kind": Choice(KINDS),
        "runs": ListOf(Text()),
        "signal": Choice(SIGNALS),
        "first": Integer(0),
        "last": Integer(1),
        "measure": Choice(tuple(MEASURES)),
        "noise": MapOf(Numbers()),
        "designs": ListOf(MapOf(Numbers())),
    },
)
