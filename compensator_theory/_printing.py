"""Integers of any length to text and back, whatever limit of digits the user set in Python."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import flint
from sympy.printing.latex import LatexPrinter
from sympy.printing.printer import Printer
from sympy.printing.str import StrPrinter

SHORT = 600
"""Digits that Python converts under every setting: the smallest limit is 640."""


def decimal(number: int) -> str:
    """Write an integer."""
    return str(number if number.bit_length() < 3 * SHORT else flint.fmpz(number))


def integer_of(digits: str) -> int:
    """Read an integer."""
    if len(digits) <= SHORT:
        return int(digits)
    plain = digits if digits.isascii() else "".join(str(int(digit)) for digit in digits)
    return int(flint.fmpz(plain))


def fraction_of(number: str) -> Fraction:
    """Read an unsigned number with a decimal point and an exponent, or without."""
    if len(number) <= SHORT:
        return Fraction(number)
    mantissa, _, exponent = number.lower().partition("e")
    whole, _, decimals = mantissa.partition(".")
    power = int(exponent or 0) - len(decimals)
    return integer_of(whole + decimals) * Fraction(10) ** power


def text(value: object) -> str:
    """Return SymPy's ``str`` of a value, with integers of any length."""
    return _written(_Text, value)


def representation(value: object) -> str:
    """Return the ``repr`` of a value, with integers of any length in SymPy's objects."""
    try:
        return repr(value)
    except ValueError:
        return long_representation(value)


def long_representation(value: object) -> str:
    """Return the ``repr`` of a value whose integers Python does not write."""
    return _written(_Representation, value)


def formula(value: object, **settings: object) -> str:
    r"""Return SymPy's ``latex`` of a value, with integers of any length."""
    return _written(_Formula, value, **settings)


def _written(printer: type[Printer], value: object, **settings: object) -> str:
    try:
        return str(printer({"order": None, **settings}).doprint(value))
    except ValueError:  # SymPy sorts factors by their text, with its own printer
        return str(printer({**settings, "order": "none"}).doprint(value))


def _quotient(value: Any) -> str:
    top, bottom = decimal(int(value.numerator)), decimal(int(value.denominator))
    return top if bottom == "1" else f"{top}/{bottom}"


class _Text(StrPrinter):  # type: ignore[misc]
    """SymPy's printer with integers by `decimal`."""

    def _print_int(self, number: int) -> str:
        return decimal(number)

    def _print_Integer(self, number: Any) -> str:
        return decimal(number.p)

    def _print_Rational(self, number: Any) -> str:
        return _quotient(number)

    _print_Fraction = _print_mpq = _print_PythonRational = _print_Rational

    def _print_MatrixBase(self, matrix: Any) -> str:
        """Print in one line, as SymPy's ``str``."""
        if 0 in matrix.shape:
            return str(matrix)
        return f"Matrix({self._print(matrix.tolist())})"


class _Representation(_Text):
    def _print_MatrixBase(self, matrix: Any) -> str:
        """Print in lines, as SymPy's ``repr``."""
        if 0 in matrix.shape or matrix.rows == 1:
            return super()._print_MatrixBase(matrix)
        rows = ",\n".join(self._print(row) for row in matrix.tolist())
        return f"Matrix([\n{rows}])"

    def _print_str(self, value: str) -> str:
        return repr(value)

    def emptyPrinter(self, value: object) -> str:
        return repr(value)


class _Formula(LatexPrinter):  # type: ignore[misc]
    """SymPy's printer with integers by `decimal`."""

    def _print_int(self, number: int) -> str:
        return decimal(number)

    def _print_Rational(self, number: Any) -> str:
        if number.q == 1:
            return decimal(number.p)
        sign = "- " if number.p < 0 else ""
        return rf"{sign}\frac{{{decimal(abs(number.p))}}}{{{decimal(number.q)}}}"
