"""Validation: convert arguments to float64 arrays of a known shape, or raise InputError."""

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
LARGEST_SQUARED = 1e140  # its square times any number of rows stays within float64
# Types that the kernel reads directly; others, such as masked arrays, are converted first.
PLAIN = frozenset({float, int, np.float64, np.ndarray, list, tuple, type(None)})


def reads(check: Callable[..., Any], *, optional: bool = False, **options: Any) -> dict[str, Any]:
    """Return attrs metadata with the converter check(value, name, ...).

    With `optional` None stays None. The class needs `field_transformer=with_checks`.
    """

    def converted(value: Any, field: attrs.Attribute[Any]) -> Any:
        return None if optional and value is None else check(value, field.name, **options)

    return {"reads": attrs.Converter(converted, takes_field=True)}


def with_checks(
    cls: type[Any], fields: Sequence[attrs.Attribute[Any]]
) -> list[attrs.Attribute[Any]]:
    """Return the fields of an attrs class with the checks of their metadata as converters."""
    return [f.evolve(converter=f.metadata.get("reads", f.converter)) for f in fields]


def array_like(value: ArrayLike) -> Array:
    """Typing stub: argument type of an array field."""
    return cast(Array, value)


def optional_array_like(value: ArrayLike | None) -> Array:
    """Typing stub: argument type of an array field that may be None."""
    return cast(Array, value)


def optional_number(value: float | None) -> float:
    """Typing stub: argument type of a number field that may be None."""
    return cast(float, value)


def optional_integer(value: int | None) -> int:
    """Typing stub: argument type of an integer field that may be None."""
    return cast(int, value)


def _shown(value: object) -> str:
    """Return the repr of an argument, shortened for a message."""
    return shortened(repr(value), 60)


def real_array(value: ArrayLike, name: str) -> Array:
    """Return a read-only C-contiguous float64 copy with finite entries.

    The copy protects the checked entries from later changes by the caller.
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
    """Return a C-contiguous float64 copy; entries may be infinite or NaN."""
    if type(value) is np.ndarray and value.dtype == np.float64:  # the common case
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
    """Whether a value is or contains a NumPy masked array with a masked entry."""
    if isinstance(value, list | tuple):
        return any(map(has_mask, value))
    return isinstance(value, np.ma.MaskedArray) and bool(np.ma.is_masked(value))


def gaps_as_nan(value: Any) -> Any:
    """Replace masked entries of a NumPy masked array by NaN; return anything else unchanged."""
    if isinstance(value, list | tuple) and has_mask(value):
        return [gaps_as_nan(entry) for entry in value]
    is_numeric = isinstance(value, np.ma.MaskedArray) and value.dtype.kind in "iuf"
    return value.astype(np.float64).filled(np.nan) if is_numeric else value


def squarable(array: Array, name: str) -> Array:
    """Return the array, or raise InputError if sums of squares overflow float64."""
    largest = float(np.abs(array).max(initial=0.0))
    if largest and not 1 / LARGEST_SQUARED < largest < LARGEST_SQUARED:
        raise InputError(
            f"the largest entry of {name} is {largest:.3g} in size, and its square overflows "
            f"float64. "
            f"Write {name} in another unit."
        )
    return array


def rounded(entries: Sequence[Any], name: str) -> Array:
    """Round exact numbers to float64, each once."""
    for entry in entries:
        if not getattr(entry, "is_number", True):
            raise InputError(
                f"{name} contains {entry}, which is not a number; give every symbol a value."
            )
        if getattr(entry, "is_rational", True) is not True:
            raise InputError(
                f"{name} contains the irrational number {entry}; write it as a decimal, so that "
                f"the exact comparison has an exact value."
            )
    try:
        return real_array([float(entry) for entry in entries], name)
    except OverflowError:
        raise InputError(f"{name} has an entry beyond the range of float64.") from None


def matrix(value: ArrayLike, name: str, shape: tuple[int | None, int | None]) -> Array:
    """Return a matrix of `shape`; None leaves a dimension free.

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
    """Return a 1-D array of `size` entries; a number is accepted for one entry."""
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
    """Return a signal as an array of shape (steps, width); a 1-D array is a scalar signal.

    The error message names the blocks of columns with their widths.
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
    """Whether an object array holds only real numbers, such as fractions."""
    return values.dtype.kind == "O" and all(
        isinstance(v, Real) and not isinstance(v, bool) for v in values.ravel()
    )


def items(value: Any, name: str, kind: type | None = None) -> tuple[Any, ...]:
    """Return the entries of an iterable; each must be an instance of `kind`."""
    try:
        iterator = iter(value)
    except TypeError:
        raise InputError(f"{name} = {_shown(value)} must be a list.") from None
    entries = tuple(iterator)
    for entry in entries:
        instance_of(entry, f"an entry of {name}", kind or object)
    return entries


def instance_of(value: Any, name: str, kind: type | UnionType) -> Any:
    """Return `value` if it is an instance of `kind`, else raise InputError."""
    if not isinstance(value, kind):
        kinds = kind.__args__ if isinstance(kind, UnionType) else (kind,)
        needed = " or ".join(k.__name__ for k in kinds)
        raise InputError(f"{name} = {_shown(value)} is not a {needed}.")
    return value


def integer(value: object, name: str, at_least: int = 0, at_most: int = 2**62) -> int:
    """Return an int in a range; booleans and fractions are refused."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InputError(f"{name} must be an integer, not {_shown(value)}.")
    if value < at_least:
        raise InputError(f"{name} = {value} must be at least {at_least}.")
    if value > at_most:
        raise InputError(f"{name} = {value} must be at most {at_most}.")
    return int(value)


def number(value: object, name: str) -> float:
    """Return a finite float."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{name} must be a real number, not {_shown(value)}.")
    return float(real_array(value, name))  # type: ignore[arg-type]


def interval(value: object, name: str) -> tuple[float, float]:
    """Two finite real numbers, the first no larger than the second."""
    numbers = [number(one, name) for one in items(value, name)]
    if len(numbers) != 2 or numbers[0] > numbers[1]:
        words = ", ".join(f"{one:g}" for one in numbers)
        raise InputError(f"{name} = ({words}) must be two numbers, the least one first.")
    return numbers[0], numbers[1]


def positive_time(value: object, name: str) -> float:
    """Return a positive time in seconds."""
    if not (period := number(value, name)) > 0:
        raise InputError(f"{name} = {value} must be positive, in seconds.")
    return period


def complex_number(value: object, name: str) -> complex:
    """Return a number or a text as a finite complex float64 number."""
    read = exact.exact_number(value)
    if not read.is_number:
        raise InputError(f"{name} = {value} contains symbols; give a number.")
    number = complex(read)
    if not cmath.isfinite(number):
        raise InputError(f"{name} = {value} is too large for float64.")
    return number


def one_of(value: str | None, name: str, choices: Sequence[str]) -> str:
    """Return `value` if it is one of `choices`, else raise InputError."""
    if value is None or value not in choices:
        raise InputError(
            f"{name} = {_shown(value)} is not known; choose one of {', '.join(choices)}."
        )
    return value


def require_dense(order: int, subject: str) -> int:
    """Return the order of a realisation, or raise BudgetError if full matrices are too large."""
    if order > MOST_STATES:
        raise BudgetError(
            f"{subject} has {order} states; poles, margins and responses are computed for at most "
            f"{MOST_STATES}, from full matrices. Take a smaller n_c, or reduce the plant."
        )
    return order


def by_step(changes: object, name: str) -> dict[int, Any]:
    """Return a mapping from steps to values, sorted by step."""
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise InputError(
            f"{name} = {_shown(changes)} must map steps to values, such as {{1000: ...}}."
        )
    read = {integer(k, f"a step of {name}", at_least=1): v for k, v in changes.items()}
    return dict(sorted(read.items()))
