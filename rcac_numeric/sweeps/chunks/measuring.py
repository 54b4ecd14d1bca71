"""The numbers that are kept of one run; what is the same for a whole cell is found once."""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis.loop_analysis import LoopAnalysis
from rcac_numeric.experiments.measures.cost_measures import h2_cost, high_authority_cost
from rcac_numeric.sweeps.chunks.chunk import TimeLimitReached
from rcac_numeric.sweeps.study.canonical import canonical_json
from rcac_numeric.sweeps.study.cells import Cell
from rcac_numeric.sweeps.study.measures import Kept


class MeasureFailed(Exception):
    """A measure raised what is no property of its run."""

    def __init__(self, name: str, cause: BaseException) -> None:
        super().__init__(name)
        self.name, self.cause = name, cause


class KeyWatch:
    """Sees Ctrl-C while it is entered, so that a measure's own KeyboardInterrupt is told from it.

    It takes the place of Python's handler of SIGINT in the main thread, and hands on to it.
    """

    def __init__(self) -> None:
        self.pressed = False
        self._previous: Callable[[int, FrameType | None], Any] | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """What Python calls when the key was pressed."""
        self.pressed = True
        if self._previous is not None:
            self._previous(number, frame)

    def __enter__(self) -> KeyWatch:
        previous = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is threading.main_thread() and callable(previous):
            self._previous = previous
            signal.signal(signal.SIGINT, self)
        return self

    def __exit__(self, *error: object) -> None:
        handler: object = signal.getsignal(signal.SIGINT)
        if self._previous is not None and handler is self:
            signal.signal(signal.SIGINT, self._previous)


def is_of_a_key(error: BaseException) -> bool:
    """Whether somebody pressed Ctrl-C here; otherwise whoever runs here raised it himself."""
    if not isinstance(error, KeyboardInterrupt):
        return False
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or handler is signal.SIG_IGN:
        return False
    return handler.pressed if isinstance(handler, KeyWatch) else True


def measured(cell: Cell, run: LoopAnalysis) -> tuple[list[float], str]:
    """One number for each measure of the study, NaN where the run has none, and why.

    That a run has none is a property of it: a measure says so by a `CompensatorError`, which after
    a run that did not complete is not even worth a word.
    """
    values, notes = [], []
    for kept in cell.study.keep:
        try:
            values.append(_value(cell, kept, run))
        except CompensatorError as error:
            values.append(math.nan)
            if run.run.outcome == "completed":
                notes.append(f"measure {kept.name}: {type(error).__name__}: {error}")
        except TimeLimitReached:
            raise
        except BaseException as error:  # of the user's own function: SystemExit too
            if is_of_a_key(error):
                raise
            raise MeasureFailed(kept.name, error) from None
    return values, "; ".join(notes)


def _value(cell: Cell, kept: Kept, run: LoopAnalysis) -> float:
    quick = isinstance(kept.measure, str) and ONCE_FOR_A_CELL.get(kept.measure)
    value = quick(cell, run, **kept.arguments) if quick else kept.function(run, **kept.arguments)
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"it returned a {type(value).__name__}, which is no number") from None


def _least_cost(cell: Cell, run: LoopAnalysis, **arguments: Any) -> float:
    """That of LQG: the same for all runs that ended with the same plant."""
    key = ("high_authority_cost", run.last_step, canonical_json(arguments))
    if key not in cell.remembered:
        cell.remembered[key] = high_authority_cost(run, **arguments)
    return float(cell.remembered[key])


def _cost_ratio(cell: Cell, run: LoopAnalysis, **arguments: Any) -> float:
    return h2_cost(run, **arguments) / _least_cost(cell, run, **arguments)


ONCE_FOR_A_CELL: dict[str, Callable[..., Any]] = {
    "high_authority_cost": _least_cost,
    "cost_over_high_authority": _cost_ratio,
}
