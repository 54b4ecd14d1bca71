"""Real polynomials from their exact roots, rational or not."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import reduce
from numbers import Real
from typing import Any, TypeAlias, cast

import sympy
from sympy import QQ, Expr, Poly, Symbol

from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.polynomials._algebraic import Algebraic, algebraic, rational_number
from compensator_theory.polynomials._budget import ask, is_collection, listed, quoted, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._expressions import WORDS
from compensator_theory.polynomials._functions import functions_in
from compensator_theory.polynomials._numbers import NumberLike, exact_number, exact_numbers
from compensator_theory.polynomials._poly import canonical, from_coefficients, from_expression
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._variables import as_symbol

SpectrumLike: TypeAlias = PolynomialLike | Iterable[NumberLike]
"""A polynomial in any form but a list, or a collection of roots, or a text with commas."""

SEPARATOR = re.compile("[,;]")
NAME = re.compile(r"(?<![\d.])[^\W\d]\w*")  # not the e of 1e5, or the j of 0.5j
"""Between the roots in a text; no polynomial contains it."""


def read_roots(roots: str | Iterable[NumberLike]) -> tuple[Expr, ...]:
    """Read a list of numbers, from a text or from any collection.

    Parameters
    ----------
    roots : str or iterable
        In a text, commas (or semicolons) separate; without any, white space does, and then no
        number may contain white space: ``"-1 -2"`` are two numbers, ``"-1 - 2"`` is refused, and
        so is ``"-1 -2, -3"``.

    Raises
    ------
    InputError
        If an entry is missing or no number; BudgetError if there are too many.

    Examples
    --------
    >>> from compensator_theory import read_roots
    >>> read_roots("-1 -2"), read_roots("-1 + 2i, -1 - 2i")
    ((-1, -2), (-1 + 2*I, -1 - 2*I))
    """
    if isinstance(roots, str):
        ask("characters", len(roots), "the list of roots")
        text = roots.strip()
        roots = re.split(r"\s*[,;]\s*", text) if SEPARATOR.search(text) else text.split()
        if not roots or not all(roots):
            raise InputError(f"{text[:60]!r} has an empty entry; write for instance '-1, -2+1j'")
    elif not is_collection(roots):
        raise InputError(f"the roots {repr_of(roots)} must be a list, for instance ['-1', '-2+1j']")
    root_list = listed(roots, "degree", "the list of roots")
    return tuple(map(sympy.expand, exact_numbers(root_list)))


@carrying()
def polynomial_from_roots(roots: Iterable[NumberLike], variable: str | Symbol) -> Poly:
    r"""Multiply out the monic real polynomial with the given exact roots.

    .. math:: p(s) = \prod_i (s - \lambda_i)

    Parameters
    ----------
    roots : iterable
        Anything :func:`exact_number` reads; a root is repeated as often as its multiplicity, and
        complex roots come in conjugate pairs. Symbols stand for real numbers.
    variable : str or Symbol
        The variable of the polynomial.

    Returns
    -------
    sympy.Poly
        Monic; 1 if there are no roots.

    Raises
    ------
    InputError
        If a complex root lacks its conjugate; the message names it.

    Examples
    --------
    >>> from compensator_theory import polynomial_from_roots
    >>> polynomial_from_roots([-1, "-0.5+0.1j", "-0.5-0.1j"], "s")
    Poly(s**3 + 2*s**2 + 63/50*s + 13/50, s, domain='QQ')
    """
    symbol = as_symbol(variable)
    return _multiplied_out(read_roots(roots), symbol)


@carrying()
def from_read_roots(roots: tuple[Expr, ...], variable: Symbol) -> Poly:
    """Multiply out the roots of :func:`read_roots`, as :func:`polynomial_from_roots` does."""
    return _multiplied_out(roots, variable)


def _multiplied_out(roots: tuple[Expr, ...], symbol: Symbol) -> Poly:
    plain: list[Expr] = []
    irrational: list[Algebraic] = []
    for root in roots:
        if root.is_Rational:
            plain.append(root)
            continue
        if symbol in root.free_symbols:
            raise InputError(f"the root {quoted(root)} contains the variable {symbol} itself")
        number = None if _is_plain(root) else algebraic(root)
        if number is not None:
            irrational.append(number)
        elif _is_plain(root) or root.is_real or root.free_symbols:
            plain.append(root)
        else:
            raise InputError(f"the root {quoted(root)} is neither algebraic nor known to be real")
    factors = [Poly([1], symbol, domain=QQ)]
    if plain:
        factors += _rational_or_symbolic(plain, symbol)
    if irrational:
        factors += _irrational(irrational, symbol)
    return canonical(_product(factors))


def _is_plain(root: Expr) -> bool:
    """Tell whether it is a + jb with rational a and b, or real symbols in their places."""
    if root.free_symbols:
        return True
    real, imaginary = root.as_coeff_Add()[0], root.coeff(sympy.I)
    return bool(imaginary.is_Rational and root == real + sympy.I * imaginary)


def _rational_or_symbolic(roots: Sequence[Expr], s: Symbol) -> list[Poly]:
    factors, joint, waiting = [], [], Counter(roots)
    for root in roots:
        if not waiting[root]:
            continue
        if root.is_Rational:
            factors.append(from_coefficients([sympy.S.One, -root], s))
            continue
        partner = sympy.expand(root.xreplace({sympy.I: -sympy.I}))
        waiting[root] -= 1
        if partner == root and any(True for _ in functions_in([root])):
            joint.append(s - root)  # of the roots of a quadratic, the product is free of them
        elif partner == root:
            factors.append(from_expression(s - root, s))
        elif waiting[partner]:
            waiting[partner] -= 1
            quadratic = s**2 - sympy.expand(root + partner) * s + sympy.expand(root * partner)
            factors.append(from_expression(quadratic, s))
        else:
            raise InputError(
                f"the root {quoted(root)} lacks its conjugate {quoted(partner)}; list both, "
                "equally often"
            )
    if joint:
        factors.append(from_expression(sympy.expand(sympy.Mul(*joint)), s))
    return factors


def _irrational(roots: Sequence[Algebraic], s: Symbol) -> list[Poly]:
    """Take out whole minimal polynomials, whose coefficients are rational; then pair the rest."""
    if not roots:
        return []
    factors, rest = [], []
    for members in _grouped(roots):
        minimal = members[0][0].minimal
        degree = int(minimal.degree())
        whole = min(m for _, m in members) if len(members) == degree else 0
        monic = Poly([QQ(int(c)) for c in reversed(minimal.coeffs())], s, domain=QQ).monic()
        factors.append(monic**whole)
        rest += [(root, m - whole) for root, m in members if m > whole]
    product = [_ONE]
    for root, multiplicity in rest:
        if not root.is_real and (root.conjugate, multiplicity) not in rest:
            raise InputError(
                f"the root near {complex(root.ball):.6g}, of {_text(root, s)}, lacks its "
                "conjugate; list both, equally often"
            )
        for _ in range(multiplicity if root.is_real or root.is_above_the_axis else 0):
            product = _times(product, _real_factor(root))
    coefficients = [c.expression() for c in product]
    terms = [c * s**k for k, c in enumerate(reversed(coefficients))]
    return [*factors, from_expression(sympy.Add(*terms), s)]


_ONE, _MINUS = rational_number(sympy.Integer(1)), rational_number(sympy.Integer(-1))


def _real_factor(root: Algebraic) -> list[Algebraic]:
    """Return s - root, or with the conjugate the quadratic factor, in descending powers."""
    if root.is_real:
        return [_ONE, _MINUS * root]
    return [_ONE, _MINUS * (root + root.conjugate), root * root.conjugate]


def _times(a: list[Algebraic], b: list[Algebraic]) -> list[Algebraic]:
    """Multiply two polynomials with real algebraic coefficients, each as simple as it is."""
    products = []
    for k in range(len(a) + len(b) - 1):
        parts = [a[i] * b[k - i] for i in range(len(a)) if 0 <= k - i < len(b)]
        products.append(reduce(lambda x, y: x + y, parts))
    return products


def _grouped(roots: Sequence[Algebraic]) -> list[list[tuple[Algebraic, int]]]:
    """Group equal minimal polynomials; each root with its multiplicity."""
    groups: dict[tuple[int, ...], Counter[Algebraic]] = {}
    for root in roots:
        groups.setdefault(tuple(map(int, root.minimal.coeffs())), Counter())[root] += 1
    return [list(members.items()) for members in groups.values()]


def _text(root: Algebraic, s: Symbol) -> str:
    return str(Poly([int(c) for c in reversed(root.minimal.coeffs())], s).as_expr())


def _product(factors: list[Poly]) -> Poly:
    while len(factors) > 1:
        factors = [
            reduce(lambda a, b: a * b, factors[i : i + 2]) for i in range(0, len(factors), 2)
        ]
    return factors[0]


def polynomial_or_roots(value: SpectrumLike, variable: str | Symbol) -> Poly:
    """Read a target: a polynomial, or its roots in any collection.

    A list, tuple, array, set or generator holds *roots*, and so does a text with commas, or with
    one number, which are no polynomials to be placed; coefficients are written as a polynomial,
    one of NumPy or python-flint for instance. An array that begins with 1 may be either.
    """
    if lists_roots(value):
        return polynomial_from_roots(cast(Iterable[NumberLike], value), variable)
    return polynomial(cast(PolynomialLike, value), variable)


def _require_no_doubt(value: object) -> None:
    """Refuse an array that begins with 1, as np.poly and every monic polynomial's coefficients."""
    if getattr(value, "ndim", 0) != 1 or isinstance(value, list | tuple):
        return
    entries = list(cast(Iterable[Any], value))
    if len(entries) > 1 and isinstance(entries[0], Real) and entries[0] == 1:
        raise InputError(
            f"{repr_of(value)} may be roots, one of them 1, or the coefficients of a monic "
            "polynomial, such as numpy.poly returns; give a list of the roots, or the coefficients "
            "as numpy.poly1d(...)"
        )


def lists_roots(value: object) -> bool:
    """Whether roots are listed: in a collection, a text with commas, or a text of one number."""
    if not isinstance(value, str):
        _require_no_doubt(value)
        return is_collection(value)
    return bool(SEPARATOR.search(value)) or _is_number(value)


def _is_number(value: str) -> bool:
    if not set(NAME.findall(value)) <= WORDS | {"i"}:
        return False  # q - q is a polynomial
    try:
        return bool(exact_number(value).is_number)
    except CompensatorError:
        return False
