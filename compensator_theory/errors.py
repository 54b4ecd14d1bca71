"""Errors of all packages: each message gives the cause and the next step."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Self

from compensator_theory._wording import printable

_LONG_NUMBER = re.compile(r"\d{80,}")


@dataclass(frozen=True)
class Advice:
    """The next step that an error advises, as data: the call that takes it.

    Its text is for Python users; another program, such as the command line, writes its own text
    from the names and the values.

    Attributes
    ----------
    function : str
        The name of a public function or class; of a method with its class.
    arguments : tuple of (str, str)
        Names of arguments and their values as text.
    words : str
        The clause of the message, in which {function} stands for the name and names of
        arguments for their values.

    Examples
    --------
    >>> from compensator_theory.errors import Advice
    >>> advice = Advice("place_poles", (("n_c", "2"),), "from {function}(..., n_c={n_c}) on")
    >>> str(advice)
    'from place_poles(..., n_c=2) on'
    >>> f"from --order {advice.values['n_c']} on"
    'from --order 2 on'
    """

    function: str
    arguments: tuple[tuple[str, str], ...]
    words: str

    @property
    def values(self) -> dict[str, str]:
        """Values of the arguments by their names."""
        return dict(self.arguments)

    def __str__(self) -> str:
        return self.words.format(function=self.function, **self.values)


class CompensatorError(ValueError):
    """Base of every error that this project raises on purpose.

    Catch it to catch them all; each message names the offending input and the next step.

    Parameters
    ----------
    *parts : str or Advice
        The message in parts, which are put together. ``raise InputError("G: ", *error.args)`` says
        the same of another place and keeps the advice.

    Examples
    --------
    >>> from compensator_theory import CompensatorError, place_poles, transfer_function
    >>> plant = transfer_function("(s + 1)/((s + 1)*(s + 2))")
    >>> try:
    ...     place_poles(plant, ["-3", "-4", "-5"], feedback=-1)
    ... except CompensatorError as error:
    ...     print(type(error).__name__)
    NotCoprimeError

    Attributes
    ----------
    advice : tuple of Advice
        The next steps that the message names, as data.
    source : str
        The file whose name is the first part of the message; empty where it begins with none.
    unless : tuple or None
        With symbols: polynomials that are all zero where the refusal falls; None: not known.
    exceptional : tuple
        With symbols: polynomials that are not zero where `unless` decides.
    """

    source: str = ""
    unless: tuple[object, ...] | None = None
    exceptional: tuple[object, ...] = ()

    def of(self, source: str) -> Self:
        """Return the error with the file name at the beginning of its message."""
        self.source = source
        return self

    def holding(self, unless: Iterable[object], exceptional: Iterable[object] = ()) -> Self:
        """Return the error with the conditions on the symbols under which it holds."""
        self.unless, self.exceptional = tuple(unless), tuple(exceptional)
        return self

    @property
    def advice(self) -> tuple[Advice, ...]:
        """The parts of the message that are advice."""
        return tuple(part for part in self.args if isinstance(part, Advice))

    def message_for(self, reader: Callable[[Advice], str]) -> str:
        """Return the message with each advice written by `reader`, as the command line does."""
        parts = (reader(part) if isinstance(part, Advice) else str(part) for part in self.args)
        text = _LONG_NUMBER.sub(lambda m: f"{m[0][:20]}...", "".join(parts))
        return printable(text if len(text) <= 1600 else f"{text[:1000]} ... {text[-500:]}")

    def __str__(self) -> str:
        """Return the message, shortened to a page; control characters in it are written out."""
        return self.message_for(str)


class InputError(CompensatorError):
    """An argument has the wrong type, shape, range or value (NaN and infinity included)."""


class BudgetError(InputError):
    """A request is larger than the :class:`~compensator_theory.Budget` allows."""


class UndecidedError(InputError):
    """Data leave more than one answer, each with other consequences, so that none is given."""


class NotCoprimeError(CompensatorError):
    """Numerator and denominator share a root, so some poles cannot be moved."""


class NotControllableError(CompensatorError):
    """Some modes of (A, B) do not feel the input, so no state feedback moves them."""


class NotObservableError(CompensatorError):
    """Some modes of (A, C) do not show in the output, so no output injection moves them."""


class ImproperError(CompensatorError):
    """A transfer function has more zeros than poles, or a loop is not well posed."""


class NoSolutionError(CompensatorError):
    """The design equation has no solution for this order of compensator."""


class NotReachableTargetError(CompensatorError):
    """No controller of this structure makes the intercalated transfer function equal the target."""


class UnitCircleError(CompensatorError):
    """A zero or a pole lies on the unit circle where none may."""


class DivergedError(CompensatorError):
    """A closed loop left the range of float64; the result has the steps before."""


class IllConditionedError(CompensatorError):
    """Rounding decides the answer, so that it is undecided; exact data or other units may help."""


class PrecisionError(CompensatorError):
    """Another thread set python-flint's precision while balls were computed at it."""


class FunctionFailedError(CompensatorError):
    """A function that was passed in failed; `run` holds the steps before."""

    def __init__(self, *parts: str | Advice, run: object = None) -> None:
        super().__init__(*parts)
        self.run = run


class RoundingWarning(UserWarning):
    """Rounding to float64 alone moves the poles of a closed loop dangerously."""


class WrongAnswerError(CompensatorError):
    """An answer to an exercise is wrong; `judgement` has the least counterexample."""

    def __init__(self, *parts: str | Advice, judgement: object = None) -> None:
        super().__init__(*parts)
        self.judgement = judgement

    def _render_traceback_(self) -> list[str]:
        """Return the notebook view: the sentence without the frames of the checker."""
        return [str(self)]
