r"""Formulas of results for notebooks: LaTeX out of polynomials and matrices."""

from __future__ import annotations

import re
from collections.abc import Iterable

import sympy
from sympy import Basic, Expr, MatrixBase, Poly

from compensator_theory._printing import formula

BEFORE, AFTER = r"$\displaystyle ", "$"
# Signs that words may not have: set as formulas, which MathJax, KaTeX and LaTeX write alike.
ESCAPED = {"\\": r"\backslash ", "^": r"\wedge ", "~": r"\sim "}
ESCAPED |= {sign: rf"\{sign}" for sign in "_{}#$%&"}
SPECIAL = re.compile("([" + re.escape("".join(ESCAPED)) + "])")


def latex(value: object) -> str:
    r"""Write one value as a formula, without the signs around it.

    Parameters
    ----------
    value : sympy object, result of ours, number, tuple, str or anything else
        A str is taken as the formula that it is; a matrix without rows or columns shows its shape,
        anything else is words.
    """
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
    show = getattr(value, "_repr_latex_", None)  # every result of ours has it
    if show is None:
        return words(str(value))
    return str(show()).removeprefix(BEFORE).removesuffix(AFTER)


def displayed(*formulas: str) -> str:
    r"""Return what a notebook shows: the formulas that are not empty, in one line."""
    return BEFORE + r", \quad ".join(filter(None, formulas)) + AFTER


def unless(exceptional: Iterable[Expr]) -> str:
    r"""Say where a symbolic result holds.

    Examples
    --------
    >>> from sympy.abc import a, b
    >>> from compensator_theory._latex import unless
    >>> print(unless((a, a - b)))
    a \neq 0, \; a - b \neq 0
    """
    return r", \; ".join(rf"{latex(factor)} \neq 0" for factor in exceptional)


def words(text: str) -> str:
    r"""Return words that may stand in a formula.

    Examples
    --------
    >>> from compensator_theory._latex import words
    >>> print(words("det(sI - A_cl)"))
    \text{det(sI - A}\_\text{cl)}
    """
    parts = SPECIAL.split(text.replace("\n", " "))
    return "".join(ESCAPED.get(part) or rf"\text{{{part}}}" for part in parts if part)


def diagonal(entries: Iterable[object]) -> str:
    r"""Write a diagonal matrix by its entries.

    Examples
    --------
    >>> from compensator_theory._latex import diagonal
    >>> print(diagonal((1, "L_2")))
    \operatorname{diag}\left(1, L_2\right)
    """
    return r"\operatorname{diag}" + latex(tuple(entries))


def fraction(top: object, bottom: object) -> str:
    r"""Write a quotient.

    Examples
    --------
    >>> from compensator_theory._latex import fraction
    >>> print(fraction(1, "D_c"))
    \frac{1}{D_c}
    """
    return rf"\frac{{{latex(top)}}}{{{latex(bottom)}}}"


def total(terms: Iterable[str]) -> str:
    r"""Write a sum; the sign of a term takes the place of the plus.

    Examples
    --------
    >>> from compensator_theory._latex import total
    >>> print(total(["a", r"- \frac{1}{2} b"]))
    a - \frac{1}{2} b
    """
    return " + ".join(terms).replace("+ - ", "- ").replace("+ -", "- ")


def lines(formulas: Iterable[str]) -> str:
    r"""Write formulas one below the other.

    Examples
    --------
    >>> from compensator_theory._latex import lines
    >>> print(lines(["a = 1", "b = 2"]))
    \begin{array}{l} a = 1 \\ b = 2 \end{array}
    """
    return r"\begin{array}{l} " + r" \\ ".join(formulas) + r" \end{array}"


def table(rows: Iterable[Iterable[object]]) -> str:
    r"""Write a matrix by its entries.

    Examples
    --------
    >>> from compensator_theory._latex import table
    >>> print(table([[1, "a"], [0, 1]]))
    \left[\begin{matrix}1 & a\\0 & 1\end{matrix}\right]
    """
    cells = r"\\".join(" & ".join(map(latex, row)) for row in rows)
    return rf"\left[\begin{{matrix}}{cells}\end{{matrix}}\right]"


def _polynomial(poly: Poly) -> str:
    """Write descending powers of the variable, whatever symbols the coefficients have."""
    terms = [
        coefficient * poly.gen**power
        for (power,), coefficient in sorted(poly.as_dict().items(), reverse=True)
    ]
    return formula(sympy.Add(*terms, evaluate=False), order="none") if terms else "0"
