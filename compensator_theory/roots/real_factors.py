"""Real factors of a real polynomial, with multiplicity and with a certificate."""

import sympy
from sympy import Poly

from compensator_theory.polynomials.poly import is_rational
from compensator_theory.roots.certified import certified_roots
from compensator_theory.roots.counts import number_of_real_roots


def real_multiplicities(poly: Poly) -> list[tuple[int, int]]:
    """Return (degree, multiplicity) of each distinct irreducible real factor, 1 or 2 in degree.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.real_factors import real_multiplicities
    >>> real_multiplicities(polynomial("(s + 1)**2*(s**2 + 1)**3"))
    [(1, 2), (2, 3)]
    """
    roots = certified_roots(poly)
    kept = [root for root in roots if root.is_real or root.value.imag > 0]
    return [(1 if root.is_real else 2, root.multiplicity) for root in kept]


def has_real_root(poly: Poly) -> bool | None:
    """Tell whether a monic real polynomial has a real root; None if symbols decide.

    Symbols stand for real numbers. A factor of odd degree has a real root whatever they are.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.real_factors import has_real_root
    >>> has_real_root(polynomial("(s + a)*(s**2 + 1)")), has_real_root(polynomial("s**2 + a", "s"))
    (True, None)
    """
    if is_rational(poly):
        return number_of_real_roots(poly) > 0
    factors = [factor for factor, _ in poly.factor_list()[1]]
    if any(factor.degree() % 2 for factor in factors):
        return True
    real = {symbol: sympy.Dummy(symbol.name, real=True) for symbol in poly.free_symbols_in_domain}
    signs = [
        sympy.sympify(f.discriminant()).xreplace(real).is_nonnegative if f.degree() == 2 else None
        for f in factors
    ]
    return True if True in signs else False if set(signs) == {False} else None
