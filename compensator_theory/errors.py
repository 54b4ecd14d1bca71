"""The one tree of errors of all packages: what was wrong with the input, and what to do next."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Self

from compensator_theory._wording import printable

_LONG_NUMBER = re.compile(r"\d{80,}")


class CompensatorError(ValueError):
    """Base of every error that this project raises on purpose.

    Catch it to catch them all; each message names the offending input and the next step.

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
    unless : tuple or None
        With symbols: polynomials that are all zero where the refusal falls; None: not known.
    exceptional : tuple
        With symbols: polynomials that are not zero where `unless` decides.
    """

    unless: tuple[object, ...] | None = None
    exceptional: tuple[object, ...] = ()

    def holding(self, unless: Iterable[object], exceptional: Iterable[object] = ()) -> Self:
        """Return the error, which says now for which values of the symbols it holds."""
        self.unless, self.exceptional = tuple(unless), tuple(exceptional)
        return self

    def __str__(self) -> str:
        """Return the message, shortened to a page; control characters in it are written out."""
        text = _LONG_NUMBER.sub(lambda m: f"{m[0][:20]}...", super().__str__())
        return printable(text if len(text) <= 1600 else f"{text[:1000]} ... {text[-500:]}")


class InputError(CompensatorError):
    """An argument has the wrong type, shape, range or value (NaN and infinity included)."""


class BudgetError(InputError):
    """A request is larger than the :class:`~compensator_theory.Budget` allows."""


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
    """A closed loop left the range of float64; what came before is kept in the result."""


class IllConditionedError(CompensatorError):
    """Rounding decides the answer, so that it is undecided; exact data or other units may help."""


class PrecisionError(CompensatorError):
    """Another thread set python-flint's precision while balls were computed at it."""


class FunctionFailedError(CompensatorError):
    """A function that was passed in failed; `run` holds what was computed before."""

    def __init__(self, message: str, run: object = None) -> None:
        super().__init__(message)
        self.run = run


class RoundingWarning(UserWarning):
    """Rounding to float64 alone moves the poles of a closed loop dangerously."""
