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


def shown(value: object, most: int = 60) -> str:
    """Write anything that was given for an error message, however large or broken it is.

    Examples
    --------
    >>> from compensator_theory.polynomials.formatting import shown
    >>> shown("s" * 1000, 8), shown(2)
    ("'sss...", '2')
    """
    try:
        with long_integers():
            text = repr(value)
    except Exception:  # of a foreign object, or a number that fits nowhere
        text = f"an object of type {type(value).__name__}"
    return text if len(text) <= most else text[: most - 4] + "..."
