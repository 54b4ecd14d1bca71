"""Quote untrusted text in messages: limited length, escaped control characters; LaTeX."""

from __future__ import annotations

import re
import unicodedata
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

# Separators at which spreadsheets of some locales begin a new cell inside a text.
SEPARATOR = re.compile(r"([;|\t])")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
FORMULA = "=+-@\N{MINUS SIGN}"
# Unicode categories that a spreadsheet skips.
UNSEEN = ("Cc", "Cf", "Mn", "Zl", "Zp", "Zs")


def shortened(text: str, at_most: int = 400) -> str:
    """Return the text, cut in the middle beyond `at_most`, with control characters escaped."""
    if len(text) <= at_most:
        return text
    cut = f" ... [{len(text)} characters] ... "
    room = max(at_most - len(cut), 2)
    end = room // 3
    return f"{text[: room - end]}{cut}{text[len(text) - end :]}"


def spreadsheet_text(text: str) -> str:
    """Return the text as a spreadsheet cell that cannot be a formula.

    Control characters and ends of lines are written out. A cell that begins with =, +, - or @
    in any width, after spaces, quotes and invisible characters, gets an apostrophe in front of that
    character; so does the text after a semicolon, a bar or a tabulator, where the spreadsheets
    of some countries begin a new cell. A text that is a plain number stays.
    """
    plain = in_a_line(text)
    if NUMBER.fullmatch(plain):
        return plain
    return "".join(map(_no_formula, SEPARATOR.split(plain)))


def _no_formula(cell: str) -> str:
    for i, character in enumerate(cell):
        if unicodedata.normalize("NFKC", character)[0] in FORMULA:
            return f"{cell[:i]}'{cell[i:]}"
        if character != '"' and unicodedata.category(character) not in UNSEEN:
            break
    return cell


def matrix_latex(rows: Iterable[Iterable[float]], digits: int = 4) -> str:
    r"""Return a matrix of numbers in LaTeX, each with a few digits."""
    lines = (" & ".join(number_latex(value, digits) for value in row) for row in rows)
    body = r" \\ ".join(lines)
    return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"


def number_latex(value: float, digits: int = 4) -> str:
    r"""Return a number in LaTeX, with a power of ten if that is shorter."""
    mantissa, e, exponent = f"{value:.{digits}g}".partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if e else mantissa


def polynomial_latex(coefficients: Iterable[float], variable: str = "q") -> str:
    r"""Return a polynomial in LaTeX from coefficients in descending powers, without zeros."""
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
    r"""Return a sum of matrices times delayed signals in LaTeX, without zero matrices."""
    parts = []
    for delay, matrix in terms:
        rows = [list(row) for row in matrix]
        if any(value for row in rows for value in row):
            parts.append(f"{matrix_latex(rows)} {signal}(k{f'-{delay}' * (delay > 0)})")
    return " + ".join(parts)
