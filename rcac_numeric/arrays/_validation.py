"""Turning what a user passes into float64 arrays of a known shape, or saying what is wrong."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from types import UnionType
from typing import Any, cast

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

import compensator_theory as exact
from compensator_theory.errors import BudgetError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._wording import shortened

MOST_STATES = 1000
LARGEST_SQUARED = 1e140  # its square, times any number of rows, is within float64
# What a kernel may read by itself; of other types, such as masked arrays, an array is made first.
PLAIN = frozenset({float, int, np.float64, np.ndarray, list, tuple, type(None)})


def reads(check: Callable[..., Any], *, optional: bool = False, **options: Any) -> dict[str, Any]:
    """Metadata of an attrs field: it keeps what `check(value, name, ...)` makes of what is given.

    With `optional` None stays None. The class is made with `field_transformer=with_checks`.
    """

    def converted(value: Any, field: attrs.Attribute[Any]) -> Any:
        return None if optional and value is None else check(value, field.name, **options)

    return {"reads": attrs.Converter(converted, takes_field=True)}


def with_checks(
    cls: type[Any], fields: Sequence[attrs.Attribute[Any]]
) -> list[attrs.Attribute[Any]]:
    """The fields of an attrs class, each with the check of its metadata as its converter."""
    return [f.evolve(converter=f.metadata.get("reads", f.converter)) for f in fields]


def array_like(value: ArrayLike) -> Array:
    """What a field takes whose check makes an array of it; for type checkers."""
    return cast(Array, value)


def optional_array_like(value: ArrayLike | None) -> Array:
    """The same of a field that may be None, to stay so or until its default is known."""
    return cast(Array, value)


def optional_number(value: float | None) -> float:
    """The same of a number."""
    return cast(float, value)


def optional_integer(value: int | None) -> int:
    """The same of an integer."""
    return cast(int, value)


def _shown(value: object) -> str:
    """What was given, in a line of a message."""
    return shortened(repr(value), 60)


def real_array(value: ArrayLike, name: str) -> Array:
    """`value` as a new read-only C-contiguous float64 array with finite entries.

    A copy, so that what has been checked cannot be changed from outside.
    """
    array = float_array(value, name)
    array.setflags(write=False)
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(
            f"{name} has the entry {array[where]} at index {where}; every entry must be finite. "
            "Remove or replace it first."
        )
    return array


def float_array(value: ArrayLike, name: str) -> Array:
    """`value` as a new C-contiguous float64 array, whose entries may be infinite or NaN."""
    if type(value) is np.ndarray and value.dtype == np.float64:  # as most that are asked for
        return np.array(value, order="C")
    try:
        if has_mask(value):
            raise TypeError("some of its entries are masked")
        array = np.asarray(value)
        if array.dtype.kind not in "iuf" and not _all_real(array):
            raise TypeError(f"its entries are of type {array.dtype}")
        return np.array(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"{name} must be an array of real numbers, not {_shown(value)}: {error}."
        ) from None


def has_mask(value: object) -> bool:
    """Whether a masked array of NumPy with a masked entry is, or is inside, what is given."""
    if isinstance(value, list | tuple):
        return any(map(has_mask, value))
    return isinstance(value, np.ma.MaskedArray) and bool(np.ma.is_masked(value))


def gaps_as_nan(value: Any) -> Any:
    """A masked array of NumPy with NaN where it is masked; anything else as it is."""
    if isinstance(value, list | tuple) and has_mask(value):
        return [gaps_as_nan(entry) for entry in value]
    is_numeric = isinstance(value, np.ma.MaskedArray) and value.dtype.kind in "iuf"
    return value.astype(np.float64).filled(np.nan) if is_numeric else value


def squarable(array: Array, name: str) -> Array:
    """The array, if sums of squares of its entries are within float64."""
    largest = float(np.abs(array).max(initial=0.0))
    if largest and not 1 / LARGEST_SQUARED < largest < LARGEST_SQUARED:
        raise InputError(
            f"the largest entry of {name} is {largest:.3g} in size, and its square leaves float64. "
            f"Write {name} in another unit."
        )
    return array


def rounded(entries: Sequence[Any], name: str) -> Array:
    """Exact numbers, each rounded once to float64; the one way out of the exact half."""
    for entry in entries:
        if not getattr(entry, "is_number", True):
            raise InputError(
                f"{name} contains {entry}, which is not a number; give every symbol a value."
            )
        if getattr(entry, "is_rational", True) is not True:
            raise InputError(
                f"{name} contains the irrational number {entry}; write it as a decimal, so that "
                "the exact comparison knows what was meant."
            )
    try:
        return real_array([float(entry) for entry in entries], name)
    except OverflowError:
        raise InputError(f"{name} has an entry beyond the range of float64.") from None


def matrix(value: ArrayLike, name: str, shape: tuple[int | None, int | None]) -> Array:
    """`value` as a matrix of `shape`, in which None leaves a dimension free.

    A scalar stands for a 1 x 1 matrix, and a flat array for the column of size x any or the row of
    any x size, as B and C have them; nothing else is reshaped.
    """
    array = real_array(value, name)
    if array.ndim == 0:
        array = array.reshape(1, 1)
    elif array.ndim == 1 and (None in shape) and array.size in shape:
        array = array.reshape((-1, 1) if shape[1] is None else (1, -1))
    fits = array.ndim == 2 and all(
        want in (None, have) for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        expected = " x ".join("any" if size is None else str(size) for size in shape)
        raise InputError(f"{name} has shape {array.shape}; a matrix of size {expected} is needed.")
    return array


def vector(value: ArrayLike, name: str, size: int) -> Array:
    """`value` as a 1-D array of `size` entries; a number where one is enough."""
    array = real_array(value, name).reshape(-1)
    if array.size != size:
        raise InputError(f"{name} has {array.size} entries where {size} are needed.")
    return array


def signal_array(
    value: ArrayLike,
    name: str,
    width: int,
    steps: int | None = None,
    blocks: Mapping[str, int] | None = None,
) -> Array:
    """`value` as an array of shape (steps, width); a 1-D array is a scalar signal.

    An error names the blocks of columns, with their widths.
    """
    array = real_array(value, name)
    if array.ndim == 1 and width == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2 or array.shape[1] != width:
        named = ", ".join(f"{n} columns {b}" if n != 1 else b for b, n in (blocks or {}).items())
        columns = f": {named}" if blocks and list(blocks) != [name] else ""
        raise InputError(
            f"{name} has shape {array.shape}; (steps, {width}) is needed, one row for each step"
            f"{columns}."
        )
    if steps is not None and array.shape[0] != steps:
        raise InputError(f"{name} has {array.shape[0]} rows where {steps} steps are needed.")
    return array


def _all_real(values: NDArray[Any]) -> bool:
    """Whether an array of objects holds real numbers only, such as fractions."""
    return values.dtype.kind == "O" and all(
        isinstance(v, Real) and not isinstance(v, bool) for v in values.ravel()
    )


def items(value: Any, name: str, kind: type | None = None) -> tuple[Any, ...]:
    """The entries of a list or another iterable, each of them a `kind`."""
    try:
        iterator = iter(value)
    except TypeError:
        raise InputError(f"{name} = {_shown(value)} must be a list.") from None
    entries = tuple(iterator)
    for entry in entries:
        instance_of(entry, f"an entry of {name}", kind or object)
    return entries


def instance_of(value: Any, name: str, kind: type | UnionType) -> Any:
    """`value` if it is a `kind`."""
    if not isinstance(value, kind):
        kinds = kind.__args__ if isinstance(kind, UnionType) else (kind,)
        needed = " or ".join(k.__name__ for k in kinds)
        raise InputError(f"{name} = {_shown(value)} is not a {needed}.")
    return value


def integer(value: object, name: str, at_least: int = 0, at_most: int = 2**62) -> int:
    """`value` as an int in a range; booleans and fractions are refused."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InputError(f"{name} must be an integer, not {_shown(value)}.")
    if value < at_least:
        raise InputError(f"{name} = {value} must be at least {at_least}.")
    if value > at_most:
        raise InputError(f"{name} = {value} must be at most {at_most}.")
    return int(value)


def number(value: object, name: str) -> float:
    """`value` as a finite float."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{name} must be a real number, not {_shown(value)}.")
    return float(real_array(value, name))  # type: ignore[arg-type]


def positive_time(value: object, name: str) -> float:
    """`value` as a positive number of seconds."""
    if not (period := number(value, name)) > 0:
        raise InputError(f"{name} = {value} must be positive, in seconds.")
    return period


def complex_number(value: object, name: str) -> complex:
    """`value`, a number or a text, as a finite complex number of float64."""
    read = exact.exact_number(value)
    if not read.is_number:
        raise InputError(f"{name} = {value} contains symbols; give a number.")
    number = complex(read)
    if not cmath.isfinite(number):
        raise InputError(f"{name} = {value} is too large for float64.")
    return number


def one_of(value: str, name: str, choices: Sequence[str]) -> str:
    """`value` if it is among `choices`."""
    if value not in choices:
        raise InputError(
            f"{name} = {_shown(value)} is not known; choose one of {', '.join(choices)}."
        )
    return value


def require_dense(order: int, subject: str) -> int:
    """The order of a realisation, if it is one that full matrices are filled for."""
    if order > MOST_STATES:
        raise BudgetError(
            f"{subject} has {order} states; poles, margins and responses are computed for at most "
            f"{MOST_STATES}, from full matrices. Take a smaller n_c, or reduce the plant."
        )
    return order


def by_step(changes: object, name: str) -> dict[int, Any]:
    """A mapping from steps to values, sorted by step."""
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise InputError(
            f"{name} = {_shown(changes)} must map steps to values, such as {{1000: ...}}."
        )
    read = {integer(k, f"a step of {name}", at_least=1): v for k, v in changes.items()}
    return dict(sorted(read.items()))
