r"""Formulas of results for notebooks: LaTeX out of polynomials and matrices."""

from __future__ import annotations

import re
from collections.abc import Iterable

import sympy
from sympy import Basic, Expr, MatrixBase, Poly

from compensator_theory._printing import formula

BEFORE, AFTER = r"$\displaystyle ", "$"
# Characters that \text cannot hold: written as formulas that MathJax, KaTeX and LaTeX agree on.
ESCAPED = {"\\": r"\backslash ", "^": r"\wedge ", "~": r"\sim "}
ESCAPED |= {sign: rf"\{sign}" for sign in "_{}#$%&"}
SPECIAL = re.compile("([" + re.escape("".join(ESCAPED)) + "])")


def latex(value: object) -> str:
    r"""Write one value as a formula, without delimiters."""
    if isinstance(value, str):
        return value
    if isinstance(value, Poly):
        return _polynomial(value)
    if isinstance(value, tuple):
        return rf"\left({', '.join(map(latex, value))}\right)"
    if isinstance(value, MatrixBase) and 0 in value.shape:
        return rf"0_{{{value.rows} \times {value.cols}}}"
    if isinstance(value, Basic | MatrixBase | int) and not isinstance(value, bool):
        return formula(value)
    show = getattr(value, "_repr_latex_", None)  # every result class of this package has it
    if show is None:
        return words(str(value))
    return str(show()).removeprefix(BEFORE).removesuffix(AFTER)


def displayed(*formulas: str) -> str:
    r"""Return the LaTeX of a notebook: the nonempty formulas, in one line."""
    return BEFORE + r", \quad ".join(filter(None, formulas)) + AFTER


def unless(exceptional: Iterable[Expr]) -> str:
    r"""Return the conditions under which a symbolic result holds."""
    return r", \; ".join(rf"{latex(factor)} \neq 0" for factor in exceptional)


def words(text: str) -> str:
    r"""Return words that may stand in a formula."""
    parts = SPECIAL.split(text.replace("\n", " "))
    return "".join(ESCAPED.get(part) or rf"\text{{{part}}}" for part in parts if part)


def diagonal(entries: Iterable[object]) -> str:
    r"""Write a diagonal matrix by its entries."""
    return r"\operatorname{diag}" + latex(tuple(entries))


def fraction(top: object, bottom: object) -> str:
    r"""Write a quotient."""
    return rf"\frac{{{latex(top)}}}{{{latex(bottom)}}}"


def total(terms: Iterable[str]) -> str:
    r"""Write a sum; the sign of a term takes the place of the plus."""
    return " + ".join(terms).replace("+ - ", "- ").replace("+ -", "- ")


def lines(formulas: Iterable[str]) -> str:
    r"""Write formulas one below the other."""
    return r"\begin{array}{l} " + r" \\ ".join(formulas) + r" \end{array}"


def table(rows: Iterable[Iterable[object]]) -> str:
    r"""Write a matrix by its entries."""
    cells = r"\\".join(" & ".join(map(latex, row)) for row in rows)
    return rf"\left[\begin{{matrix}}{cells}\end{{matrix}}\right]"


def _polynomial(poly: Poly) -> str:
    """Write descending powers of the variable, whatever symbols the coefficients have."""
    terms = [
        coefficient * poly.gen**power
        for (power,), coefficient in sorted(poly.as_dict().items(), reverse=True)
    ]
    return formula(sympy.Add(*terms, evaluate=False), order="none") if terms else "0"
