"""The budget: the largest request, checked before the work begins."""

from __future__ import annotations

import math
import sys
from collections.abc import (
    Callable,
    Iterable,
    Iterator,
    KeysView,
    Mapping,
    Sequence,
    Set,
    Sized,
    ValuesView,
)
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields, replace
from itertools import islice
from typing import TypeGuard, TypeVar

from sympy import MatrixBase, Poly, Tuple

from compensator_theory._printing import text
from compensator_theory.errors import Advice, BudgetError, InputError


@dataclass(frozen=True)
class Budget:
    """The largest requests that are begun; raise a limit with :func:`budget`.

    Attributes
    ----------
    characters : int
        Of a text.
    nesting : int
        Parentheses inside parentheses, roots inside roots.
    terms : int
        Of an expression when it is multiplied out.
    degree : int
        Of a polynomial, and order of a compensator.
    digits : int
        Of the numerator and denominator of a number in a text, an int, a Fraction or a Decimal.
    field_degree : int
        Of the number field that irrational numbers span together: sqrt(2) and sqrt(3) span 4.
    entries : int
        Of a matrix.

    Examples
    --------
    >>> from compensator_theory import Budget
    >>> Budget().degree
    1000
    """

    characters: int = 20_000
    nesting: int = 60
    terms: int = 2_000
    degree: int = 1_000
    digits: int = 4_000
    field_degree: int = 16
    entries: int = 500_000


Item = TypeVar("Item")
_USUAL = Budget()
_current: ContextVar[Budget] = ContextVar("budget", default=_USUAL)
_UNITS = {
    "characters": "characters",
    "nesting": "levels of nesting",
    "terms": "terms",
    "degree": "as degree",
    "digits": "digits",
    "field_degree": "as degree of a number field",
    "entries": "entries",
}


@contextmanager
def budget(**limits: int) -> Iterator[Budget]:
    """Raise or lower limits of the :class:`Budget` for everything inside a ``with`` block.

    Parameters
    ----------
    **limits : int
        New limits by name, at least 1.

    Raises
    ------
    InputError
        If there is no such limit, or it is no positive integer.

    Examples
    --------
    >>> from compensator_theory import budget, polynomial
    >>> with budget(degree=2000):
    ...     polynomial("s**1500 + 1").degree()
    1500
    """
    names = [field.name for field in fields(Budget)]
    for name, limit in limits.items():
        if name not in names:
            raise InputError(f"there is no limit {repr_of(name)}; choose among {', '.join(names)}")
        integer(limit, f"the limit {name}", at_least=1)
    changed = replace(_current.get(), **limits)
    token = _current.set(changed)
    try:
        yield changed
    finally:
        _current.reset(token)


@contextmanager
def unlimited() -> Iterator[None]:
    """Lift all limits: for conversions of computed results."""
    token = _current.set(Budget(*[sys.maxsize] * len(fields(Budget))))
    try:
        yield
    finally:
        _current.reset(token)


def quoted(obj: object) -> str:
    """Return the text of an object for an error message, at most two lines."""
    return _truncated(obj.as_expr() if isinstance(obj, Poly) else obj, str, 200, 40)


def is_integer(value: object) -> TypeGuard[int]:
    """Tell whether a value is an int, which True and False are not."""
    return isinstance(value, int) and not isinstance(value, bool)


def integer(
    value: object, name: str, *, at_least: int | None = None, at_most: int | None = None
) -> int:
    """Return an argument that must be an integer within bounds."""
    if is_integer(value):
        low = at_least is not None and value < at_least
        if not (low or (at_most is not None and value > at_most)):
            return value
    kind = "an integer"
    if at_most is not None:
        kind = f"an integer from {at_least} to {at_most}"
    elif at_least is not None:
        kind = "a positive integer" if at_least == 1 else f"an integer of at least {at_least}"
    raise InputError(f"{name} = {repr_of(value)} must be {kind}")


def repr_of(value: object, most: int = 60) -> str:
    """Return the repr of an input for an error message, cut to `most` characters."""
    return _truncated(value, repr, most)


def _truncated(value: object, write: Callable[[object], str], most: int, last: int = 0) -> str:
    """Return the text of a value, cut in the middle."""
    try:
        written = _written(value, write)
    except Exception:  # of a foreign object, or a number that fits nowhere
        written = f"an object of type {type(value).__name__}"
    if len(written) <= most:
        return written
    return f"{written[: most - 3 - last - (not last)]}...{written[len(written) - last :]}"


def _written(value: object, write: Callable[[object], str]) -> str:
    try:
        return write(value)
    except ValueError:  # an integer that is longer than Python writes
        return text(value)


def limit_of(name: str) -> int:
    """Return a limit of the current budget."""
    return int(getattr(_current.get(), name))


def ask(name: str, amount: int, subject: str) -> None:
    """Refuse a request above a limit, before any work is done for it."""
    limit = limit_of(name)
    if amount > limit:
        size = str(amount) if amount < 10**15 else _order_of(amount)
        raise BudgetError(
            f"{subject} needs {size} {_UNITS[name]}, and the limit is {limit}; reduce the problem, "
            "or raise the limit: with ",
            Advice("compensator_theory.budget", ((name, "..."),), f"{{function}}({name}=...)"),
        )


def listed(values: Iterable[Item], name: str, subject: str, more: int = 0) -> list[Item]:
    """Return the items of an iterable; refuse it as soon as it exceeds a limit by more."""
    if hasattr(values, "toarray"):
        raise InputError(f"{subject} is a sparse array; write it out with .toarray()")
    if not is_collection(values):
        raise InputError(f"{subject} must be a list, not {repr_of(values)}")
    if isinstance(values, Sized):
        ask(name, len(values) - more, subject)
    items = list(islice(values, limit_of(name) + more + 1))
    ask(name, len(items) - more, subject)
    return items


_COLLECTIONS = (Sequence, Set, Iterator, KeysView, ValuesView, Tuple, MatrixBase)
_OF_ARRAYS = ("numpy", "pandas", "xarray")


def is_collection(values: object) -> bool:
    """Return whether an object is a collection of values; not every iterable is.

    A polynomial can be, from either end; a text, bytes and a mapping hold letters and keys.
    """
    if isinstance(values, str | bytes | bytearray | memoryview | Mapping):
        return False
    return isinstance(values, _COLLECTIONS) or is_array(values)


def is_array(values: object, dimensions: int | None = None) -> bool:
    """Tell whether something is an array of NumPy, pandas or xarray, of so many dimensions."""
    if (type(values).__module__ or "").split(".")[0] not in _OF_ARRAYS:
        return False
    rank = len(getattr(values, "shape", ()))
    return rank > 0 if dimensions is None else rank == dimensions


def ask_for_number(numerator: int, denominator: int, subject: str = "a number") -> None:
    """Refuse a rational number with too many digits."""
    ask("digits", decimal_digits(max(numerator.bit_length(), denominator.bit_length())), subject)


def decimal_digits(bits: int) -> int:
    """Return a bound of the decimal digits of an integer with so many bits."""
    return bits * 30103 // 100_000 + 1


def _order_of(amount: int) -> str:
    return f"about 10**{int(math.log10(2) * (amount.bit_length() - 1))}"
