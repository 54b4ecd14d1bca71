"""Polynomials as text that reads back to the same polynomial."""

from sympy import Poly

from compensator_theory.polynomials.budget import long_integers


def format_polynomial(poly: Poly) -> str:
    """Write a polynomial in descending powers, as :func:`polynomial` reads it.

    Examples
    --------
    >>> from compensator_theory.polynomials.formatting import format_polynomial
    >>> from compensator_theory.polynomials.poly import polynomial
    >>> format_polynomial(polynomial("a - s/3 + (a + 1)*s**2"))
    '(a + 1)*s**2 - s/3 + a'
    """
    with long_integers():
        return _formatted(poly)


def _formatted(poly: Poly) -> str:
    text = ""
    for power, coefficient in sorted(poly.as_dict().items(), reverse=True):
        unit = poly.gen ** power[0]
        if coefficient.is_Add:
            term = f"({coefficient})" if power[0] == 0 else f"({coefficient})*{unit}"
        else:
            term = str(coefficient * unit)
        sign, term = ("-", term[1:]) if term.startswith("-") else ("+", term)
        text += f" {sign} {term}"
    if not text:
        return "0"
    return text[3:] if text.startswith(" +") else "-" + text[3:]
