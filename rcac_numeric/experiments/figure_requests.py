"""Which figures answer the questions of an experiment: data, drawn elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, one_of
from rcac_numeric.arrays.values import Value

KINDS = (
    "sheet",
    "responses",
    "coefficients",
    "poles",
    "disturbance response",
    "intercalated match",
    "distribution",
)
SIGNALS = ("z", "u", "y", "u_applied")


@dataclass(frozen=True, eq=False, init=False)
class FigureRequest(Value):
    """One figure: what is drawn, of which runs, and the sentence below it.

    Attributes
    ----------
    kind : str
        "sheet": all about one run. "responses": a signal of several runs in one pair of axes.
        "coefficients": theta of each run. "poles": closed-loop poles and zeros of each run.
        "disturbance response": gain from w to z with the final controllers, without one, and with
        LQG. "intercalated match": G_f and what each run made of it. "distribution": a measure over
        the repetitions or seeds of each run.
    caption : str
        What the reader is to see in it.
    runs : tuple of str
        Names; empty for all.
    signal : {"z", "u", "y", "u_applied"}
        For "responses".
    first, last : int, optional
        The steps that are shown.
    magnitude : bool
        Draw the absolute value on a logarithmic axis.
    measure : str
        For "distribution".
    channel : str
        For "disturbance response": the block or channel of w; all by default.

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
    ) -> None:
        for name, value in (("caption", caption), ("measure", measure), ("channel", channel)):
            instance_of(value, name, str)
        instance_of(magnitude, "magnitude", bool)
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
        }
        if (kind == "distribution") != bool(measure):
            raise InputError(
                'a figure of the kind "distribution" names its measure'
                if not measure
                else f"a figure of the kind {kind!r} draws no measure; leave measure out"
            )
        for field, kept in fields.items():
            object.__setattr__(self, field, kept)
