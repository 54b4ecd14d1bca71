"""Numbers of any kind to exact SymPy numbers."""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Iterable, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

import flint
import sympy
from sympy import Expr, Rational

from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._budget import (
    ask,
    ask_for_number,
    decimal_digits,
    limit_of,
    listed,
    repr_of,
)
from compensator_theory.polynomials._decidable import require_decidable
from compensator_theory.polynomials._expressions import parse_expression
from compensator_theory.polynomials._sympy_trees import rational_floats, require_readable

NumberLike: TypeAlias = int | float | complex | Fraction | Decimal | str | Expr
"""Input types of :func:`exact_number`; NumPy scalars and numbers of python-flint too."""

PLAIN = re.compile(r"-?[0-9]{1,18}(?:\.[0-9]{1,18}|/[1-9][0-9]{0,17})?")
"""Strings that need no parser; a matrix may have 500 000 of them."""

WHOLE_AS_PRINTED = 10**16
"""Below this a float without a fraction is the integer of its shortest decimal."""


@roots_in_sympy()
def exact_number(value: NumberLike, *, binary: bool = False) -> Expr:
    r"""Turn a number of any kind into an exact SymPy number or expression.

    A float means its shortest decimal, :math:`0.1 \mapsto 1/10`, unless ``binary=True`` asks for
    the value that the machine stores, :math:`0.1 \mapsto 3602879701896397/2^{55}`.

    Parameters
    ----------
    value : object
        int, Fraction, Decimal, float, complex, NumPy scalar, SymPy number or expression, or a
        string such as ``"0.1"``, ``"1/3"``, ``"-0.8j"``, ``"2*a + 1"``.
    binary : bool
        Read floats by their binary value. Strings and Decimals are decimals either way.

    Returns
    -------
    sympy.Expr
        A Rational wherever the value is a real number.

    Raises
    ------
    InputError
        If the value is NaN, infinite, a bool, or no number at all.
    BudgetError
        If it has too many digits; decided before they are written out.

    Notes
    -----
    A SymPy expression was already rounded where it contains floats; each of these is read as its
    shortest decimal.

    Examples
    --------
    >>> from compensator_theory import exact_number
    >>> exact_number(0.1), exact_number("1/3"), exact_number(0.5 - 0.8j)
    (1/10, 1/3, 1/2 - 4*I/5)
    >>> exact_number(0.1, binary=True)
    3602879701896397/36028797018963968
    """
    if isinstance(value, str):
        return _from_plain(value) if PLAIN.fullmatch(value) else parse_expression(value)
    if isinstance(value, bool) or value is None:
        raise InputError(f"{repr_of(value)} is not a number")
    if isinstance(value, Expr):
        require_readable(value)
        return rational_floats(value, binary)
    if isinstance(value, Decimal):
        return _from_decimal(value)
    if isinstance(value, numbers.Rational):
        return _ratio(int(value.numerator), int(value.denominator))
    if isinstance(value, numbers.Real):
        return _from_float(value, binary)
    if isinstance(value, numbers.Complex):
        return _from_float(value.real, binary) + sympy.I * _from_float(value.imag, binary)
    return _from_wrapped(value, binary)


def read_coefficients(values: Iterable[NumberLike]) -> list[Expr]:
    """Read a list of coefficients in descending powers, no more of them than the budget allows."""
    if getattr(values, "shape", None) == ():
        raise InputError(f"{repr_of(values)} is one number, not a list; give the number itself")
    value_list = listed(values, "degree", "the list of coefficients", more=1)
    if not value_list:
        raise InputError("the list of coefficients is empty; the zero polynomial is [0]")
    coefficients = exact_numbers(value_list)
    require_decidable(coefficients)
    return coefficients


def exact_numbers(values: Sequence[Any]) -> list[Expr]:
    """Read numbers one by one as :func:`exact_number` does, plain ones at once."""
    if (rational := plain_rationals(values)) is not None:
        return [Rational(int(value.p), int(value.q)) for value in rational]
    return [sympy.sympify(exact_number(value)) for value in values]


def plain_rationals(values: Sequence[Any]) -> list[flint.fmpq] | None:
    """Read finite numbers of Python, and SymPy's Rationals, each as :func:`exact_number` does.

    None where there is anything else, or a number longer than the budget allows: whoever reads them
    one by one says which.
    """
    if not all(_is_plain(kind) for kind in set(map(type, values))):
        return None
    numbers = []
    for number in values:
        value = number
        if isinstance(number, float):
            if not math.isfinite(number):
                return None
            whole = number.is_integer() and abs(number) < WHOLE_AS_PRINTED
            value = int(number) if whole else Fraction(float.__repr__(number))
        numbers.append(flint.fmpq(int(value.numerator), int(value.denominator)))
    longest = max(map(flint.fmpq.height_bits, numbers), default=0)
    return numbers if decimal_digits(longest) <= limit_of("digits") else None


def _is_plain(kind: type) -> bool:
    return issubclass(kind, int | float | Fraction | Rational) and kind is not bool


def _ratio(numerator: int, denominator: int) -> Rational:
    ask_for_number(numerator, denominator)
    return Rational(numerator, denominator)


def _from_plain(text: str) -> Rational:
    ask("characters", len(text), "the expression")
    number = Fraction(text)
    return _ratio(number.numerator, number.denominator)


def _from_decimal(value: Decimal) -> Rational:
    if not value.is_finite():
        raise InputError(f"{value} is not a finite number; exact data must be finite")
    _, digits, exponent = value.as_tuple()
    ask("digits", len(digits) + abs(int(exponent)), "a number")
    return _ratio(*value.as_integer_ratio())


def _from_float(value: Any, binary: bool) -> Rational:
    if not math.isfinite(value):
        raise InputError(f"{value} is not a finite number; exact data must be finite")
    if binary:
        return _ratio(*map(int, value.as_integer_ratio()))
    text = str(value)  # of a float32 the shortest for 24 bits
    ask("digits", abs(int(text.lower().partition("e")[2] or 0)), "a number")
    number = Fraction(text)
    return _ratio(number.numerator, number.denominator)


def _from_wrapped(value: Any, binary: bool) -> Expr:
    if isinstance(value, flint.fmpz):
        return _ratio(int(value), 1)
    if isinstance(value, flint.fmpq):
        return _ratio(int(value.p), int(value.q))
    if type(value).__name__ == "MaskedConstant":  # whose item is 0
        raise InputError("an entry of the array is masked, and so is no number; fill it in first")
    if getattr(value, "shape", None) == () and hasattr(value, "item"):  # a 0-dimensional array
        if hasattr(value, "filled") and value.mask:
            raise InputError("an entry is masked and has no value; leave it out")
        return exact_number(value.item(), binary=binary)
    raise InputError(
        f"{repr_of(value)} of type {type(value).__name__} is not a "
        "number; give an int, Fraction, float, decimal string or SymPy expression"
    )
