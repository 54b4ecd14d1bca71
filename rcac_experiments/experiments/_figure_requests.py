"""Which figures answer the questions of an experiment: data, drawn elsewhere."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, get_args

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.format._tables import Table
from rcac_experiments.format._values import Choice, Integer, ListOf, MapOf, Numbers
from rcac_experiments.judging._measures import MEASURES
from rcac_numeric.arrays._validation import instance_of, integer, items, one_of, reads, with_checks
from rcac_numeric.arrays._values import Value

Kind = Literal[
    "sheet", "responses", "coefficients", "poles", "disturbance response", "intercalated match",
    "distribution", "estimates", "plant zeros", "identified zeros",
]  # fmt: skip
SignalName = Literal["z", "u", "y", "u_applied"]
KINDS: tuple[str, ...] = get_args(Kind)
SIGNALS: tuple[str, ...] = get_args(SignalName)


def _names(value: object, name: str) -> tuple[str, ...]:
    return tuple(instance_of(one, "a run", str) for one in items(value, name))


def _mapping(value: object, name: str) -> dict[str, Any]:
    return dict(instance_of({} if value is None else value, name, Mapping))


def _mappings(value: object, name: str) -> tuple[dict[str, Any], ...]:
    return tuple(_mapping(one, "a design") for one in items(value, name))


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class FigureRequest(Value):
    """One figure: its kind, its runs, and the caption.

    Parameters
    ----------
    kind : str
        "sheet": all about one run. "responses": a signal of several runs in one pair of axes.
        "coefficients": theta of each run. "poles": closed-loop poles and zeros of each run.
        "disturbance response": gain from w to z with the final controllers, without one, and with
        LQG. "intercalated match": G_f and what each run made of it. "distribution": a measure over
        the repetitions or seeds of each run. "estimates", of estimation examples: what each run
        estimates beside the truth, or with `magnitude` its error. "plant zeros": those of
        the plant, frozen at steps. "identified zeros": those that windows of the run's data show.
    caption : str
        The caption.
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
    >>> from rcac_experiments.experiments._figure_requests import FigureRequest
    >>> FigureRequest("responses", "The three settle.", runs=["a", "b"]).signal
    'z'
    """

    kind: Kind = attrs.field(metadata=reads(one_of, choices=KINDS))
    caption: str = attrs.field(metadata=reads(instance_of, kind=str))
    runs: Sequence[str] = attrs.field(default=(), metadata=reads(_names))
    signal: SignalName = attrs.field(default="z", metadata=reads(one_of, choices=SIGNALS))
    first: int = attrs.field(default=0, metadata=reads(integer))
    last: int | None = attrs.field(default=None, metadata=reads(integer, optional=True))
    magnitude: bool = attrs.field(default=False, metadata=reads(instance_of, kind=bool))
    measure: str = attrs.field(default="", metadata=reads(instance_of, kind=str))
    channel: str = attrs.field(default="", metadata=reads(instance_of, kind=str))
    noise: Mapping[str, Any] = attrs.field(factory=dict, metadata=reads(_mapping))
    designs: Sequence[Mapping[str, Any]] = attrs.field(default=(), metadata=reads(_mappings))
    direct: bool = attrs.field(default=True, metadata=reads(instance_of, kind=bool))

    def __attrs_post_init__(self) -> None:
        if self.last is not None:
            integer(self.last, "last", at_least=self.first + 1)
        if (self.kind == "distribution") != bool(self.measure):
            raise InputError(
                'a figure of the kind "distribution" names its measure'
                if not self.measure
                else f"a figure of the kind {self.kind!r} draws no measure; remove measure"
            )


# The default figures of a case without requests: one question each.
STANDARD_FIGURES = (
    FigureRequest("responses", "Performance z of every run."),
    FigureRequest("coefficients", "The coefficients theta of every run that adapts."),
    FigureRequest("poles", "Closed-loop poles and zeros with the final controllers."),
    FigureRequest("intercalated match", "The target model, and what each run made of it."),
)


def require_drawable(request: FigureRequest, runs: Collection[str]) -> FigureRequest:
    """Return the request if the runs and the measure that it names exist."""
    for name in request.runs:
        if name not in runs:
            raise InputError(
                f"the run {name!r} of a figure is not known; the runs are {', '.join(runs)}."
                f"{did_you_mean(name, runs)}"
            )
    if request.measure and request.measure not in MEASURES:
        raise InputError(
            f"the measure {request.measure!r} of a figure is not known; known are "
            f"{', '.join(MEASURES)}."
            f"{did_you_mean(request.measure, MEASURES)}"
        )
    return request


FIGURE = Table(
    FigureRequest,
    forms={
        "last": Integer(1),
        "measure": Choice(tuple(MEASURES)),
        "noise": MapOf(Numbers()),
        "designs": ListOf(MapOf(Numbers())),
    },
)
