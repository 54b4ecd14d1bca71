"""Number of observer-based forms, without their enumeration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from sympy import Poly, Symbol

from compensator_theory.polynomials._budget import integer
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.roots._certified import real_multiplicities


@refusing
def count_observer_forms(
    Dtilde: PolynomialLike, n: int, *, variable: str | Symbol | None = None
) -> int:
    r"""Count the real monic divisors of degree n without listing them.

    .. math:: [x^n] \prod_{\text{real roots}} (1 + x + \cdots + x^m)
              \prod_{\text{complex pairs}} (1 + x^2 + \cdots + x^{2m})

    Parameters
    ----------
    Dtilde : polynomial
        Closed-loop polynomial, rational; m runs over the multiplicities of its roots.
    n : int
        Order of the plant, degree of the regulator polynomial.
    variable : str or Symbol, optional
        Of the polynomial; default: evident.

    Returns
    -------
    int
        For a minimal SISO plant and a minimal compensator this is the number of observer-based
        forms (K, F, T) of the realisation, for every order of the compensator.

    Raises
    ------
    InputError
        If the polynomial is zero or symbolic, or n is no natural number.

    Notes
    -----
    Roots are counted with multiplicity, as Theorem 1 needs them: (s + 1)^2 (s^2 + 1)^2 has two
    real roots.

    Examples
    --------
    >>> from compensator_theory.observers import count_observer_forms
    >>> count_observer_forms("(s + 2)*(s + 4)*(s + 5)*(s + 6)", 2)  # Example 7.1
    6
    >>> count_observer_forms("(s + 1)**2*(s**2 + 1)**2", 3)
    1
    """
    integer(n, "the order n of the plant", at_least=0)
    return number_of_selections(real_multiplicities(polynomial(Dtilde, variable)), n)


def number_of_selections(factors: Iterable[tuple[int, int]], n: int) -> int:
    """Count the products of degree n of factors given as (degree, multiplicity)."""
    factors = list(factors)
    if n > sum(degree * multiplicity for degree, multiplicity in factors):
        return 0
    ways = [1] + [0] * n
    for degree, multiplicity in factors:
        ways = [
            sum(ways[k - degree * e] for e in range(min(multiplicity, k // degree) + 1))
            for k in range(n + 1)
        ]
    return ways[n]


def count_partitions(Dtilde: Poly, sizes: Iterable[int]) -> int:
    """Count the ways to split a polynomial into real monic factors of given degrees."""
    goal = tuple(sizes)
    ways = {tuple(0 for _ in goal): 1}
    for degree, multiplicity in real_multiplicities(Dtilde):
        grown: dict[tuple[int, ...], int] = {}
        for filled, count in ways.items():
            for share in _compositions(multiplicity, len(goal)):
                size = tuple(f + degree * e for f, e in zip(filled, share, strict=True))
                if all(a <= b for a, b in zip(size, goal, strict=True)):
                    grown[size] = grown.get(size, 0) + count
        ways = grown
    return ways.get(goal, 0)


def _compositions(total: int, parts: int) -> Iterator[tuple[int, ...]]:
    if parts == 1:
        yield (total,)
        return
    for first in range(total + 1):
        for rest in _compositions(total - first, parts - 1):
            yield (first, *rest)
