"""Words of others in our messages: never longer than can be read, never a command to a terminal."""

from __future__ import annotations

import re
from collections.abc import Iterable

from compensator_theory._wording import in_a_line, printable

__all__ = [
    "in_a_line",
    "matrix_latex",
    "number_latex",
    "polynomial_latex",
    "printable",
    "shortened",
    "spreadsheet_text",
    "sum_latex",
]

FORMULA = re.compile(r"\s*(?:[=@]|[+-](?![\w+\-*/^(). ]*$))")


def shortened(text: str, at_most: int = 400) -> str:
    """The text, or its beginning and end where it is longer than `at_most`.

    Examples
    --------
    >>> from rcac_numeric.arrays._wording import shortened
    >>> shortened("u, y, z")
    'u, y, z'
    >>> shortened(", ".join(map(str, range(1000))), at_most=40)
    '0, 1, 2,  ... [4888 characters] ...  999'
    """
    if len(text) <= at_most:
        return text
    cut = f" ... [{len(text)} characters] ... "
    room = max(at_most - len(cut), 2)
    end = room // 3
    return f"{text[: room - end]}{cut}{text[len(text) - end :]}"


def spreadsheet_text(text: str) -> str:
    """The text as a cell of a table that a spreadsheet may open: never a formula.

    Control characters and ends of lines are written out. What begins as a formula does, with = or
    @, or with + or - where more follows than an expression in numbers and names, gets an
    apostrophe in front, which spreadsheets do not show.

    Examples
    --------
    >>> from rcac_numeric.arrays._wording import spreadsheet_text
    >>> spreadsheet_text("=HYPERLINK(A1)"), spreadsheet_text("-1/(q - 0.5)")
    ("'=HYPERLINK(A1)", '-1/(q - 0.5)')
    """
    plain = in_a_line(text)
    return f"'{plain}" if FORMULA.match(plain) else plain


def matrix_latex(rows: Iterable[Iterable[float]], digits: int = 4) -> str:
    r"""A matrix of numbers in LaTeX, each with a few digits.

    Examples
    --------
    >>> from rcac_numeric.arrays._wording import matrix_latex
    >>> print(matrix_latex([[1.0, -2.5e-7]]))
    \begin{bmatrix}1 & -2.5 \cdot 10^{-7}\end{bmatrix}
    """
    lines = (" & ".join(number_latex(value, digits) for value in row) for row in rows)
    body = r" \\ ".join(lines)
    return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"


def number_latex(value: float, digits: int = 4) -> str:
    r"""A number in LaTeX, with a power of ten where that is shorter.

    Examples
    --------
    >>> from rcac_numeric.arrays._wording import number_latex
    >>> print(number_latex(0.25), number_latex(1.5e10))
    0.25 1.5 \cdot 10^{10}
    """
    mantissa, e, exponent = f"{value:.{digits}g}".partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if e else mantissa


def polynomial_latex(coefficients: Iterable[float], variable: str = "q") -> str:
    r"""A polynomial in LaTeX, from its coefficients in descending powers; zeros are left out."""
    listed = list(coefficients)
    text = ""
    for power, value in zip(reversed(range(len(listed))), listed, strict=True):
        if value == 0:
            continue
        symbol = {0: "", 1: variable}.get(power, f"{variable}^{{{power}}}")
        size = number_latex(abs(value))
        size = "" if size == "1" and symbol else f"{size} " if symbol else size
        minus = value < 0
        sign = (" - " if minus else " + ") if text else ("-" if minus else "")
        text += f"{sign}{size}{symbol}"
    return text or "0"


def sum_latex(terms: Iterable[tuple[int, Iterable[Iterable[float]]]], signal: str) -> str:
    r"""A sum of matrices times a signal at earlier steps, in LaTeX; zero matrices are left out.

    Examples
    --------
    >>> from rcac_numeric.arrays._wording import sum_latex
    >>> print(sum_latex([(0, [[0.0]]), (1, [[2.0]])], "y"))
    \begin{bmatrix}2\end{bmatrix} y(k-1)
    """
    parts = []
    for delay, matrix in terms:
        rows = [list(row) for row in matrix]
        if any(value for row in rows for value in row):
            parts.append(f"{matrix_latex(rows)} {signal}(k{f'-{delay}' * (delay > 0)})")
    return " + ".join(parts)
