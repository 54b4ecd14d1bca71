"""Numbers of any kind to exact SymPy numbers."""

import math
import numbers
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

import sympy
from sympy import Expr, Float, Rational

from compensator_theory.errors import InputError
from compensator_theory.polynomials.expressions import parse_expression

NumberLike: TypeAlias = int | float | complex | Fraction | Decimal | str | Expr
"""What :func:`exact_number` reads; NumPy scalars and numbers of python-flint too."""


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
        return parse_expression(value)
    if isinstance(value, bool) or value is None:
        raise InputError(f"{value!r} is not a number")
    if isinstance(value, Expr):
        return _without_floats(value, binary)
    if isinstance(value, Decimal):
        if not value.is_finite():
            raise InputError(f"{value} is not a finite number; exact data must be finite")
        return _rational(Fraction(value))
    if isinstance(value, numbers.Rational):
        return _rational(Fraction(int(value.numerator), int(value.denominator)))
    if isinstance(value, numbers.Real):
        return _from_float(value, binary)
    if isinstance(value, numbers.Complex):
        return _from_float(value.real, binary) + sympy.I * _from_float(value.imag, binary)
    return _from_wrapped(value, binary)


def _from_float(value: Any, binary: bool) -> Expr:
    if not math.isfinite(value):
        raise InputError(f"{value} is not a finite number; exact data must be finite")
    if binary:
        return _rational(Fraction(*value.as_integer_ratio()))
    return _rational(Fraction(str(value)))  # str of a float32 is the shortest for 24 bits


def _from_wrapped(value: Any, binary: bool) -> Expr:
    if hasattr(value, "p") and hasattr(value, "q"):  # a python-flint rational
        return _rational(Fraction(int(value.p), int(value.q)))
    if getattr(value, "shape", None) == () and hasattr(value, "item"):  # a 0-dimensional array
        return exact_number(value.item(), binary=binary)
    raise InputError(
        f"{value!r} of type {type(value).__name__} is not a number; give an int, Fraction, float, "
        "decimal string or SymPy expression"
    )


def _without_floats(value: Expr, binary: bool) -> Expr:
    if value.has(sympy.nan, sympy.oo, -sympy.oo, sympy.zoo):
        raise InputError(f"{value} is not finite; exact data must be finite")
    floats = value.atoms(Float)
    if not floats:
        return value
    return value.xreplace({number: _from_sympy_float(number, binary) for number in floats})


def _from_sympy_float(number: Float, binary: bool) -> Rational:
    double_digits = 15
    if binary:
        sign, mantissa, exponent, _ = number._mpf_
        return _rational(Fraction(-1 if sign else 1) * int(mantissa) * Fraction(2) ** int(exponent))
    text = repr(float(number)) if number._prec <= Float(1, double_digits)._prec else str(number)
    return _rational(Fraction(text))


def _rational(value: Fraction) -> Rational:
    return Rational(value.numerator, value.denominator)
