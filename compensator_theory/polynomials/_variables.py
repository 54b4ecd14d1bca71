"""The variable of an input: one rule for every function, and the time domains of s, z and q."""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from functools import lru_cache
from typing import Literal, TypeAlias, cast

from sympy import Expr, Poly, Symbol

from compensator_theory.errors import Advice, InputError
from compensator_theory.polynomials._budget import quoted, repr_of
from compensator_theory.polynomials._expressions import POSITIVE, UNKNOWN, parse_expression
from compensator_theory.polynomials._quotients import Quotient

CONTINUOUS, DISCRETE = ("s",), ("z", "q")
OPERATORS = (*CONTINUOUS, *DISCRETE)
"""Default names of the variable."""

NAME_THE_VARIABLE = (
    Advice("polynomial", (("variable", "s"),), "name it, as in {function}(..., '{variable}')"),
    Advice("transfer_function", (("variable", "s"),), " or {function}(..., '{variable}')"),
)

Time: TypeAlias = Literal["continuous", "discrete"]
"""The time domain: stable is the left half plane, or the inside of the unit circle."""

Readable: TypeAlias = Poly | Expr | Quotient | None
"""A polynomial, an expression, a text that was read and reduced; None for a list, which shows no
variable."""


def as_symbol(variable: str | Symbol) -> Symbol:
    """Return the symbol of that name, as every function here names its variable."""
    if isinstance(variable, Symbol):
        if not variable.is_commutative:
            raise InputError(f"{repr_of(variable)} does not commute and cannot be a variable")
        return variable
    named = _named(variable) if isinstance(variable, str) else None
    if not isinstance(named, Symbol):
        pair = (
            "; coefficients are one pair, before the variable: transfer_function(([1], [1, 2]), "
            "'s'); of several names each is an argument"
        )
        hint = pair if isinstance(variable, list | tuple) else ""
        raise InputError(
            f"{repr_of(variable)} cannot be a variable; give a name such as 's' or 'q'{hint}"
        )
    return named


@lru_cache(maxsize=64)
def _named(text: str) -> Expr:
    """Read the text of a symbol, cached."""
    return parse_expression(text)


def is_operator(variable: Symbol) -> bool:
    """Tell whether a symbol is one of s, z and q."""
    return variable.name in OPERATORS


def is_discrete(variable: Symbol, subject: str) -> bool:
    """Tell whether a variable means discrete time: s is continuous, z and q are discrete."""
    if not is_operator(variable):
        raise InputError(
            f"{subject} depends on the time domain of {variable}; write s for continuous time, z "
            "or q for discrete time"
        )
    return variable.name in DISCRETE


def time_of(variable: Symbol, subject: str) -> Time:
    """Return the time domain that a variable stands for, as :func:`is_discrete` reads it."""
    return "discrete" if is_discrete(variable, subject) else "continuous"


def require_time(time: object) -> Time:
    """Return the time domain that was named."""
    if not (isinstance(time, str) and time in ("continuous", "discrete")):
        raise InputError(
            f"time = {repr_of(time)} is no time domain; write time='continuous' or time='discrete'"
        )
    return cast(Time, time)


def variable_in(time: object, variable: str | Symbol | None, subject: str) -> Symbol:
    """Return the variable of polynomials in a time domain: s or q where none is named."""
    time_of_request = require_time(time)
    if variable is None:
        return Symbol("s" if time_of_request == "continuous" else "q")
    symbol = as_symbol(variable)
    if time_of(symbol, subject) != time_of_request:
        raise InputError(
            f"{symbol} means {time_of(symbol, subject)} time, and {subject} is to be in "
            f"{time_of_request} time; change one of them"
        )
    return symbol


def agreed_time(time: object, variable: Symbol) -> Time:
    """Return the time domain that s, z and q show; of another variable it has to be named."""
    if time is None:
        if not is_operator(variable):
            raise InputError(
                f"{variable} does not show the time domain, and stability depends on it; "
                "write time='continuous' or time='discrete', or use s, z or q"
            )
        return time_of(variable, "stability")
    time_of_request = require_time(time)
    if is_operator(variable):
        variable_in(time_of_request, variable, "the question")
    return time_of_request


def require_discrete(variable: Symbol, subject: str) -> None:
    """Refuse a variable other than z and q."""
    if variable.name not in DISCRETE:
        meaning = " and means continuous time" if variable.name in CONTINUOUS else ""
        raise InputError(
            f"{subject} is for discrete time, but the variable is {variable}{meaning}; write the "
            "plant in z or q (sample a continuous one first, for instance by "
            "compensator_theory.sampling.tustin)"
        )


def shared_variable(parts: Iterable[Readable], variable: str | Symbol | None = None) -> Symbol:
    """Find the one variable of several polynomials, by the rule that holds everywhere.

    It is the one that is named; else that of the arguments that are polynomials; else the only one
    of s, z, q that occurs; else the only symbol. Each expression that has symbols must contain it,
    because "s + 1" and "a" may mean a constant as well as a polynomial in a.
    """
    if variable is not None:
        return as_symbol(variable)
    parts = [*parts]
    known = [part for part in parts if part is not None]
    expressions = [part for part in known if not isinstance(part, Poly)]
    fixed = {part.gen for part in known if isinstance(part, Poly)}
    occurring = fixed.union(*(part.free_symbols for part in expressions))
    subject = _Names([*known] if len(known) == len(parts) else [None, *known])
    evident = evident_variable(occurring, subject, fixed)
    for part in expressions:
        if part.free_symbols and evident not in part.free_symbols:
            raise InputError(
                f"the variable of {subject} is not evident: {_written(part)} does not contain "
                f"{evident}, so that it may be a constant or a polynomial in another variable; ",
                Advice(
                    "polynomial",
                    (("variable", evident.name),),
                    "name the variable, as in {function}(..., '{variable}')",
                ),
            )
    return evident


def evident_variable(
    occurring: Set[Symbol], subject: object, fixed: Set[Symbol] = frozenset()
) -> Symbol:
    """Return the only one of s, z, q that occurs, else the only symbol."""
    operators = fixed | {symbol for symbol in occurring if is_operator(symbol)}
    candidates = operators or occurring
    if len(candidates) != 1:
        names = ", ".join(sorted(symbol.name for symbol in occurring)) or "none"
        raise InputError(
            f"the variable of {subject} is not evident (symbols: {names}); ",
            *NAME_THE_VARIABLE,
        )
    (symbol,) = candidates
    if symbol.name.endswith((UNKNOWN, POSITIVE)):
        raise InputError(
            f"{subject} is a polynomial in {symbol}, which is not a variable; name one"
        )
    return symbol


def require_no_other_operator(*polys: Poly) -> None:
    """Refuse an input that was read in one of s, z, q but contains another of them.

    1/s is no constant of a system in z; in (s + z)/(s + p), read in s, z is a parameter as p is.
    """
    variable = polys[0].gen
    if not is_operator(variable) or any(poly.degree() > 0 for poly in polys):
        return
    for poly in polys:
        others = {symbol for symbol in poly.free_symbols_in_domain if is_operator(symbol)}
        if others - {variable}:
            raise InputError(
                f"{quoted(poly)} is to be read in the variable {variable}, does not contain it, "
                f"and contains {', '.join(sorted(map(str, others)))}; use one variable"
            )


def require_one_symbol_a_name(symbols: Iterable[Symbol]) -> None:
    """Refuse two symbols with one name, which differ in their assumptions only."""
    by_name: dict[str, Symbol] = {}
    for symbol in symbols:
        if by_name.setdefault(symbol.name, symbol) != symbol:
            raise InputError(
                f"two different symbols are called {symbol.name}: they were declared with "
                "different assumptions, and a name in a text has none. Use one symbol in all places"
            )


class _Names:
    """The arguments in words, written only where a message needs them: that takes a while."""

    def __init__(self, parts: Sequence[Readable]) -> None:
        self.parts = parts

    def __str__(self) -> str:
        named_parts = [part for part in self.parts if part is not None]
        with_symbols = [part for part in named_parts if isinstance(part, Poly) or part.free_symbols]
        if None in self.parts:  # numbers in the other parts may be defaults, or denominators of 1
            return " and ".join([*map(_written, with_symbols), "a list of coefficients"])
        return " and ".join(map(_written, with_symbols or named_parts)) or "a list of coefficients"


def _written(part: Poly | Expr | Quotient) -> str:
    text = quoted(part.value() if isinstance(part, Quotient) else part)
    return text if len(text) <= 60 else text[:57] + "..."
