"""Systems of python-control, SciPy and SymPy: their contents, or the reason for a refusal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol, TypeAlias

from sympy import Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._variables import CONTINUOUS, DISCRETE, as_symbol
from compensator_theory.systems._kinds import Pair, Roots, Rows, States


class HasFraction(Protocol):
    """A transfer function of python-control, SciPy or SymPy."""

    num: Any
    den: Any


class HasMatrices(Protocol):
    """A state space of python-control, SciPy or SymPy."""

    A: Any
    B: Any
    C: Any
    D: Any


ForeignSystem: TypeAlias = HasFraction | HasMatrices
"""Names of the system classes of these packages; their other classes are refused."""

_PACKAGES = ("control.", "scipy.", "sympy.physics.control.")


Contents: TypeAlias = Pair | Roots | States


def is_foreign(obj: object) -> bool:
    """Tell whether an object comes from a package that describes systems."""
    return f"{type(obj).__module__}.".startswith(_PACKAGES)


def contents_of(system: Any, variable: str | Symbol | None) -> Contents:
    """Return the contents of a foreign system."""
    if type(system).__module__.startswith("sympy"):
        try:
            return _of_sympy(system, variable)
        except InputError:
            raise
        except (
            AttributeError,
            TypeError,
            ValueError,
        ) as error:  # SymPy cannot combine every connection that it can represent
            raise InputError(
                f"SymPy cannot join the parts of this {type(system).__name__}: {error}; join "
                "transfer functions only"
            ) from error
    return replace(_of_numbers(system, variable), sample_time=sample_time_of(system))


def several_of(system: Any, variable: str | Symbol | None) -> States | Rows:
    """Return the contents of a foreign system with any number of signals: entries or states."""
    if type(system).__module__.startswith("sympy") and type(system).__name__.startswith("MIMO"):
        system = joined_of(system)
    outputs = getattr(system, "noutputs", getattr(system, "num_outputs", 1))
    inputs = getattr(system, "ninputs", getattr(system, "num_inputs", 1))
    if (outputs, inputs) == (1, 1) or not hasattr(system, "num"):
        if all(hasattr(system, name) for name in "ABCD"):
            contents = contents_of(system, variable)
            assert isinstance(contents, States)
            return contents
        if (outputs, inputs) == (1, 1):
            return Rows([[system]])
    return Rows([[system[i, j] for j in range(inputs)] for i in range(outputs)])


def sample_time_of(system: Any) -> Rational | None:
    """Return the sample time of a foreign system in seconds; None where it has none."""
    period = getattr(system, "dt", None)
    if period is None or isinstance(period, bool) or not period > 0:
        return None
    time_step: Rational = exact_number(float(period))
    return time_step


def _of_numbers(system: Any, variable: str | Symbol | None) -> Contents:
    if all(hasattr(system, name) for name in "ABCD"):
        return States(system.A, system.B, system.C, system.D, _variable(system, variable))
    if hasattr(system, "gain") and hasattr(system, "zeros"):
        symbol = _variable(system, variable)
        return Roots(list(system.zeros), list(system.poles), system.gain, symbol)
    if not (hasattr(system, "num") and hasattr(system, "den")):
        raise InputError(
            f"a {type(system).__name__} has no rational transfer function; give a transfer "
            "function or a linear state space"
        )
    symbol = _variable(system, variable)
    if type(system).__module__.startswith("scipy"):
        numerator = system.num
        if getattr(numerator, "ndim", 1) > 1 and len(numerator) != 1:
            _refuse_several(system, len(numerator), 1)
        return Pair([*numerator.flat], [*system.den], symbol)
    if (system.ninputs, system.noutputs) != (1, 1):
        _refuse_several(system, system.noutputs, system.ninputs)
    return Pair(list(system.num[0][0]), list(system.den[0][0]), symbol)


def _of_sympy(system: Any, variable: str | Symbol | None) -> Contents:
    name = type(system).__name__
    if name == "StateSpace":
        symbol = as_symbol("s" if variable is None else variable)
        return States(system.A, system.B, system.C, system.D, symbol)
    if (system.num_inputs, system.num_outputs) != (1, 1):
        _refuse_several(system, system.num_outputs, system.num_inputs)
    joined = joined_of(system)
    if type(joined).__name__ == "TransferFunctionMatrix":
        joined = joined[0, 0]
        joined = joined if type(joined).__name__ == "TransferFunction" else joined.doit()
    if type(joined).__name__ == "StateSpace":
        return _of_sympy(joined, variable)
    if not (hasattr(joined, "num") and hasattr(joined, "den")):
        raise InputError(f"a {name} of SymPy has no supported rational transfer function")
    system_variable = joined.var
    if variable is not None and as_symbol(variable) != system_variable:
        raise InputError(f"the system is written in {system_variable}, not in {variable}")
    return Pair(joined.num, joined.den, system_variable)


def joined_of(system: Any) -> Any:
    """Return the system that a Series, Parallel or Feedback of SymPy is equal to.

    SymPy 1.14 keeps in the class whether a connection holds a StateSpace, so that one answers for
    the connection that was made last: each is made again just before it is asked.
    """
    name = type(system).__name__
    if name in ("TransferFunction", "StateSpace", "TransferFunctionMatrix"):
        return system
    parts = [joined_of(p) if hasattr(p, "num_inputs") else p for p in system.args]
    return system.func(*parts).doit()


def _variable(system: Any, variable: str | Symbol | None) -> Symbol:
    """The variable that was named, or evident; the time base of the system has to agree."""
    of_scipy, dt = type(system).__module__.startswith("scipy"), system.dt
    if dt is None and not of_scipy:
        if variable is None:
            raise InputError("the system's time base is unspecified; name the variable, 's' or 'z'")
        return as_symbol(variable)
    continuous = dt is None or (dt == 0 and dt is not False)
    if variable is None:
        return Symbol("s" if continuous else "z")
    symbol, letters = as_symbol(variable), CONTINUOUS if continuous else DISCRETE
    if symbol.name not in letters:
        raise InputError(
            f"the system is in {'continuous' if continuous else 'discrete'} time (dt = {dt}), so "
            f"that its variable is {' or '.join(letters)}, not {symbol}; leave variable out"
        )
    return symbol


def _refuse_several(system: Any, outputs: int, inputs: int) -> None:
    raise InputError(
        f"this {type(system).__name__} has {inputs} inputs and {outputs} outputs; pick one of "
        "each, as in system[0, 0]"
    )
