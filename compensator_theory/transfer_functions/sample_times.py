"""Sample times of exact systems: kept through arithmetic, and handed to python-control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy
from sympy import Expr, ImmutableMatrix, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.budget import quoted

if TYPE_CHECKING:
    import control


def shared_sample_time(*systems: Any) -> Rational | None:
    """The sample time of what is joined, in seconds; None where none of them has one.

    What has no sample time, a number or a transfer function that was written down, takes on that of
    the others.

    Examples
    --------
    >>> import control
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.transfer_functions.sample_times import shared_sample_time
    >>> shared_sample_time(transfer_function(control.tf([1], [1, -1], 0.01)), "1/(z - 2)")
    1/100
    """
    found = {t for t in (getattr(s, "sample_time", None) for s in systems) if t is not None}
    if len(found) > 1:
        raise InputError(
            f"systems sampled every {' and '.join(f'{t} s' for t in sorted(found))} cannot be "
            "joined; resample one of them"
        )
    return found.pop() if found else None


def time_base(
    variable: Symbol, sample_time: Rational | None, dt: float | bool | None = None
) -> float | bool:
    """What python-control calls dt: seconds, 0 in continuous time, True where no one knows.

    Examples
    --------
    >>> from sympy import Rational
    >>> from sympy.abc import s, z
    >>> from compensator_theory.transfer_functions.sample_times import time_base
    >>> time_base(s, None), time_base(z, None), time_base(z, Rational(1, 100))
    (0, True, 0.01)
    """
    if dt is not None:
        return dt
    if sample_time is not None:
        return to_float(sample_time)
    known: dict[str, float | bool] = {"s": 0, "z": True, "q": True}
    if variable.name not in known:
        raise InputError(f"say what {variable} means: dt=0 or a sample time")
    return known[variable.name]


def control_state_space(
    A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix, D: ImmutableMatrix,
    dt: float | bool,
) -> control.StateSpace:  # fmt: skip
    """The state space of python-control, every entry rounded once to float64.

    Examples
    --------
    >>> from sympy import ImmutableMatrix as M
    >>> from compensator_theory.transfer_functions.sample_times import control_state_space
    >>> control_state_space(*(M([[k]]) for k in range(4)), 0.01).dt
    0.01
    """
    import control  # slow to import, and only needed here

    symbols = set().union(*(m.free_symbols for m in (A, B, C, D)))
    if symbols:
        raise InputError(f"substitute numbers for {sorted(map(str, symbols))} first")
    matrices = (A, B, C, D)
    rounded = [[[_entry(e) for e in row] for row in m.tolist()] if m else [] for m in matrices]
    return control.StateSpace(*rounded, dt)


def to_float(value: Expr) -> float:
    """A rational number, rounded once to float64.

    Examples
    --------
    >>> from sympy import Rational
    >>> from compensator_theory.transfer_functions.sample_times import to_float
    >>> to_float(Rational(1, 10))
    0.1
    """
    number = sympy.sympify(value)
    if not isinstance(number, Rational):
        raise InputError(
            f"the coefficient {quoted(number)} is not a rational number; substitute numbers"
        )
    try:
        return int(number.p) / int(number.q)
    except OverflowError as error:
        raise InputError(
            f"the coefficient {quoted(number)} exceeds the range of float64"
        ) from error


def _entry(value: Expr) -> float:
    """A number of a matrix, which may be irrational."""
    return to_float(value) if isinstance(value, Rational) else float(value)
