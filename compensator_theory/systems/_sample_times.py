"""Time domain and sample time of systems, and their agreement in connections."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, TypeVar

import sympy
from sympy import Expr, ImmutableMatrix, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.libraries import absent_attribute
from compensator_theory.polynomials._budget import quoted, repr_of
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._substitution import Substitutions, with_values
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import DISCRETE, Time, is_operator, time_of

if TYPE_CHECKING:
    import control


class System(ExactValue):
    """Base of the systems: variable, time domain and sample time, inherited by derived systems."""

    _CARRIES = True

    if TYPE_CHECKING:

        @property
        def variable(self) -> Symbol:
            """The variable of its transfer functions."""

        @property
        def sample_time(self) -> Rational | None:
            """Sample time in seconds; None if it is not known, and in continuous time."""

    else:  # hidden from type checkers, to which it would give every attribute

        def __getattr__(self, name: str) -> Any:
            """Refuse an attribute that does not exist, and name the one to type."""
            raise absent_attribute(self, name)

    def __bool__(self) -> bool:
        """True, as of any object that one constructs."""
        return True

    @classmethod
    def _of_canonical(cls, **fields: Any) -> Self:
        """Return one of fields in canonical form, denominators monic: none is looked at again."""
        system = object.__new__(cls)
        vars(system).update(fields)
        return system

    @property
    def time(self) -> Time | None:
        """The time domain: continuous in s, discrete in z and q; None in other variables."""
        return time_of(self.variable, "time") if is_operator(self.variable) else None

    def subs(self, values: Substitutions, value: NumberLike | None = None) -> Self:
        """Give values, numbers or expressions, to symbols of the coefficients.

        As SymPy's: `subs({"a": 2, b: 1})`, all at once, `subs("a", 2)`, or
        `subs([("a", b), ("b", 1)])`, one after the other.
        """
        return with_values(self, values, value, self.variable)


Timed = TypeVar("Timed", bound=System)


def period_in(variable: Symbol, sample_time: NumberLike | None) -> Rational | None:
    """The sample time of a system, read; only discrete time has one."""
    if sample_time is None:
        return None
    period = exact_number(sample_time)
    if not (isinstance(period, Rational) and period > 0):
        raise InputError(f"sample_time = {repr_of(sample_time)} is no positive number of seconds")
    if variable.name not in DISCRETE:
        raise InputError(
            f"a system in {variable} has no sample time, but sample_time is {period} s; write it "
            "in z or q, or leave sample_time out"
        )
    return period


# Relative difference up to which sample times are equal: above rounding, below clock errors.
SAME = Rational(1, 10**9)


def agreed_period(*periods: Any, at: str = "the system", remedy: str = "resample it") -> Any:
    """Return the common sample time, or None; refuse two that differ by more than 1e-9.

    Of 3/10 and the decimal of 0.1*3 the one that is shorter to write is kept, in any order.
    """
    known = [period for period in periods if period is not None]
    if not known:
        return None
    for period in known[1:]:
        if abs(period - known[0]) > SAME * max(period, known[0]):
            raise InputError(
                f"{at} is sampled every {_seconds(known[0])} s, not every {_seconds(period)} s; "
                f"{remedy}"
            )
    return min(known, key=lambda period: (len(str(period)), period))


def _seconds(period: Any) -> str:
    return str(period) if isinstance(period, Rational) else f"{float(period):.12g}"


def sampled_every(system: Timed, sample_time: NumberLike | None) -> Timed:
    """Return the system with a sample time; refuse one that contradicts the known one."""
    period = period_in(system.variable, sample_time)
    agreed_period(system.sample_time, period)
    if period is None or system.sample_time is not None:
        return system
    return replace(system, sample_time=period)  # type: ignore[type-var]


def shared_sample_time(*systems: Any) -> Rational | None:
    """Return the sample time of connected systems in seconds; None if none has one.

    An operand without sample time, a number or a transfer function from text, takes that of
    the others.
    """
    times = {t for t in (getattr(s, "sample_time", None) for s in systems) if t is not None}
    try:
        return agreed_period(*sorted(times))
    except InputError:
        raise InputError(
            f"systems sampled every {' and '.join(f'{t} s' for t in sorted(times))} cannot be "
            "joined; resample one of them"
        ) from None


def time_base(
    variable: Symbol, sample_time: Rational | None, dt: float | bool | None = None
) -> float | bool:
    """The dt of python-control: seconds, 0 in continuous time, True if unknown."""
    if dt is not None:
        if sample_time is not None and not isinstance(dt, bool):
            agreed_period(to_float(sample_time), dt, remedy="leave dt out, or resample it")
        return dt
    if sample_time is not None:
        return to_float(sample_time)
    known: dict[str, float | bool] = {"s": 0, "z": True, "q": True}
    if variable.name not in known:
        raise InputError(f"the time base of {variable} is unknown: pass dt=0 or a sample time")
    return known[variable.name]


def control_state_space(
    A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix, D: ImmutableMatrix,
    dt: float | bool,
) -> control.StateSpace:  # fmt: skip
    """The state space of python-control, every entry rounded once to float64."""
    import control  # slow to import, and only needed here

    symbols = set().union(*(m.free_symbols for m in (A, B, C, D)))
    if symbols:
        raise InputError(f"substitute numbers for {sorted(map(str, symbols))} first")
    matrices = (A, B, C, D)
    rounded = [[[_entry(e) for e in row] for row in m.tolist()] if m else [] for m in matrices]
    return control.StateSpace(*rounded, dt)


def way_to_numbers(value: Expr) -> str:
    """The advice about a coefficient that is not rational: it has symbols, or is irrational."""
    names = ", ".join(sorted(map(str, value.free_symbols)))
    return f"substitute numbers for {names}" if names else "give a rational number close to it"


def to_float(value: Expr) -> float:
    """A rational number, rounded once to float64."""
    number = sympy.sympify(value)
    if not isinstance(number, Rational):
        raise InputError(
            f"the coefficient {quoted(number)} is not a rational number; {way_to_numbers(number)}"
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
