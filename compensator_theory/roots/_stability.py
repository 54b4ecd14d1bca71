"""Stability of all roots, decided twice: from the coefficients and from certified roots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.matrices._flint_matrices import of_rows, rational
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.polynomials._carrying import (
    carried_by,
    carrying,
    polynomial_with_functions,
    refusing,
)
from compensator_theory.polynomials._complex_polynomials import complex_parts, joined, norm_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._reading import (
    PolynomialLike,
    PolynomialOrSystem,
    polynomial,
    polynomial_in_time,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time
from compensator_theory.roots._counts import count_roots, require_rational
from compensator_theory.roots._independent_numbers import polynomial_with_exponentials
from compensator_theory.roots._regions import locate_roots
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.roots._schur_cohn import reflection_coefficients

MAX_DETERMINANTS = 40
MAX_SYMBOLIC_DEGREE = 4


@dataclass(frozen=True)
class StabilityDecision(ExactValue):
    """Whether a polynomial is Hurwitz or Schur, by two independent routes, with the evidence.

    Attributes
    ----------
    polynomial : sympy.Poly
        As requested.
    time : {"continuous", "discrete"}
        Whether the roots are to lie in the open left half plane or in the open unit disk.
    by_coefficients, by_roots : bool or None
        The two answers. None if it depends on the value of a symbol, or (by_roots) if there are
        symbols or irrational coefficients at all.
    counts_by_coefficients, counts_by_roots : RootCount or None
        The two counts behind the answers; None with symbols or irrational coefficients.
    evidence : tuple of sympy.Expr
        Hurwitz determinants, or reflection coefficients as far as they decide.

    Examples
    --------
    >>> from compensator_theory import decide_stability
    >>> print(decide_stability("s**4 + s**3 + 2*s**2 + 2*s + 5", time="continuous"))
    s**4 + s**3 + 2*s**2 + 2*s + 5 is not Hurwitz
    from the coefficients: 2 stable, 0 on the boundary, 2 unstable
    from certified roots: 2 stable, 0 on the boundary, 2 unstable
    """

    _ANSWER = "is_stable"

    polynomial: Poly
    time: Time
    by_coefficients: bool | None
    by_roots: bool | None
    counts_by_coefficients: RootCount | None
    counts_by_roots: RootCount | None
    evidence: tuple[Expr, ...]

    @property
    def is_stable(self) -> bool | None:
        """The answer; None if it depends on a symbol (or the two routes contradict)."""
        return self.by_coefficients if self.is_unanimous else None

    @property
    def is_unanimous(self) -> bool:
        """Whether the two routes agree in every count; False would be an error of this software."""
        return self.counts_by_coefficients == self.counts_by_roots

    def __str__(self) -> str:
        name = "Hurwitz" if self.time == "continuous" else "Schur"
        verdict = {
            True: f"is {name}",
            False: f"is not {name}",
            None: f"is {name} or not, depending on its symbols",
        }[self.is_stable]
        lines = [f"{format_polynomial(self.polynomial)} {verdict}"]
        if self.counts_by_roots is not None:
            lines.append(f"from the coefficients: {self.counts_by_coefficients}")
            lines.append(f"from certified roots: {self.counts_by_roots}")
        return "\n".join(lines)

    def _repr_latex_(self) -> str:
        name = "Hurwitz" if self.time == "continuous" else "Schur"
        verdict = {True: f"is {name}", False: f"is not {name}", None: "is undecided"}[
            self.is_stable
        ]
        return displayed(rf"{latex(self.polynomial)} {words(' ' + verdict)}")


@holds_where_defined
@carried_by("none")
def decide_stability(
    poly: PolynomialOrSystem, variable: str | Symbol | None = None, *, time: Time | None = None
) -> StabilityDecision:
    r"""Decide whether every root is stable: Hurwitz in continuous, Schur in discrete time.

    Parameters
    ----------
    poly : polynomial, or a Realisation or TransferFunction
        Not zero; of a system its characteristic polynomial, modes that cancel counted. Exponentials
        of rational numbers are decided exactly, complex coefficients by the polynomial times its
        conjugate. With symbols
        the Hurwitz determinants decide, in discrete time the product of the roots or, up to degree
        4, the determinants of the polynomial mapped to the half plane, as far as their signs follow
        from the symbols' assumptions. :func:`polynomial` adds none: a SymPy symbol declared
        positive keeps its assumption.
    time : {"continuous", "discrete"}, optional
        Whether the real parts are to be below 0 or the moduli below 1. Default: what the variable
        says, s or z and q; of another one, and of a list of coefficients, it has to be named.
    variable : str or Symbol, optional
        Default: evident; of a list of coefficients s, in discrete time q.

    Returns
    -------
    StabilityDecision
        The counts are those of :func:`count_roots` and :func:`locate_roots`; the evidence are the
        Hurwitz determinants of the monic polynomial up to degree 40 (above it, their cost would
        exceed that of both decisions), or its :func:`reflection_coefficients`. A constant has no
        root and is stable.

    Raises
    ------
    InputError
        If the polynomial is zero, or `time` is missing or not that of the variable.

    Examples
    --------
    >>> from sympy import symbols
    >>> from compensator_theory import decide_stability
    >>> decide_stability("(s + 1)*(s + 2)").is_stable
    True
    >>> from compensator_theory import transfer_function
    >>> decide_stability(transfer_function("(s - 1)/((s - 1)*(s + 2))")).is_stable
    False
    >>> decision = decide_stability([1, "-1/2", "1/4"], time="discrete")
    >>> decision.is_stable, decision.evidence
    (True, (1/4, -2/5))
    >>> a, s = symbols("a", positive=True), symbols("s")
    >>> decide_stability(s**2 + a*s + a, time="continuous").is_stable
    True
    >>> decide_stability("s**2 + a*s + 1", time="continuous").is_stable is None
    True
    """
    rewritten = polynomial_with_exponentials(poly, variable, time)
    if rewritten is not None:
        p, domain, numbers = rewritten
        count = numbers.count(p, domain)
        shown = polynomial_with_functions(
            [c.subs(dict(numbers.meaning)) for c in p.all_coeffs()], p.gen
        )
        return StabilityDecision(shown, domain, count.stable == p.degree(), None, None, None, ())
    if (parts := complex_parts(poly, variable, time)) is not None:
        return _decided_by_norm(parts, time)
    return _decided(poly, variable, time)


def _decided_by_norm(parts: tuple[Poly, Poly], time: Time | None) -> StabilityDecision:
    """Decide for complex coefficients: p times its conjugate is real, with each root twice."""
    both = _decided(norm_of(parts), None, time)
    by_coefficients, by_roots = (
        None if c is None else RootCount(c.stable // 2, c.boundary // 2, c.unstable // 2)
        for c in (both.counts_by_coefficients, both.counts_by_roots)
    )
    return StabilityDecision(
        joined(parts), both.time, both.by_coefficients, both.by_roots, by_coefficients, by_roots,
        both.evidence,
    )  # fmt: skip


@refusing
def _decided(
    poly: PolynomialOrSystem, variable: str | Symbol | None, time: Time | None
) -> StabilityDecision:
    """Decide for rational coefficients, or symbols."""
    p, time = polynomial_in_time(poly, time, variable)
    discrete = time == "discrete"
    if not is_rational(p):
        return _schur_with_symbols(p) if discrete else _hurwitz_with_symbols(p)
    require_rational(p)
    counts = count_roots(p, time=time), locate_roots(p, time=time)
    by_coefficients, by_roots = (count.stable == p.degree() for count in counts)
    if discrete:
        evidence = reflection_coefficients(p)
        by_coefficients = all(abs(k) < 1 for k in evidence)
    else:
        evidence = hurwitz_determinants(p) if p.degree() <= MAX_DETERMINANTS else ()
    return StabilityDecision(p, time, by_coefficients, by_roots, *counts, evidence)


@carrying()
def hurwitz_determinants(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[Expr, ...]:
    r"""Return the leading principal minors of the Hurwitz matrix of the monic polynomial.

    .. math:: H_{ij} = a_{n - 2j + i}, \qquad \Delta_k = \det [H_{ij}]_{i,j\le k}

    Parameters
    ----------
    poly : polynomial
        Degree n, symbols allowed.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of sympy.Expr
        :math:`\Delta_1, \ldots, \Delta_n`; all positive if and only if every root has a negative
        real part.

    Raises
    ------
    InputError
        If the polynomial is zero.

    Examples
    --------
    >>> from compensator_theory.roots import hurwitz_determinants
    >>> hurwitz_determinants("s**2 + a*s + b")
    (a, a*b)
    """
    p = polynomial(poly, variable)
    if p.is_zero:
        require_rational(p)
    if is_rational(p):
        return _minors_by_routh(p)
    leading, degree = p.LC(), int(p.degree())
    a = [sympy.cancel(c / leading) for c in p.all_coeffs()]  # a[k] belongs to s**(n - k)
    H = _hurwitz_matrix(a)
    return tuple(determinant(H[:k, :k]) for k in range(1, degree + 1))


def _hurwitz_matrix(a: Sequence[Expr]) -> ImmutableMatrix:
    """Return the Hurwitz matrix of the monic polynomial with the coefficients a, descending."""
    n = len(a) - 1
    rows = [
        [a[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= n else sympy.Integer(0) for j in range(n)]
        for i in range(n)
    ]
    return of_rows(rows, (n, n))


def _minors_by_routh(p: Poly) -> tuple[Expr, ...]:
    """Return the minors of rational numbers as products of the first column of Routh's array.

    A zero in that column ends the array; the minors after it are computed one by one.
    """
    monic = to_flint_polynomial(p) / to_flint_polynomial(p).leading_coefficient()
    a = monic.coeffs()[::-1]
    upper, lower = a[0::2], a[1::2]
    minors: list[flint.fmpq] = []
    while lower and lower[0]:
        minors.append(lower[0] * (minors[-1] if minors else 1))
        factor = upper[0] / lower[0]
        padded = [*lower[1:], *[flint.fmpq(0)] * (len(upper) - len(lower))]
        upper, lower = lower, [u - factor * v for u, v in zip(upper[1:], padded, strict=True)]
    H = _hurwitz_matrix([rational(c) for c in a])
    rest = range(len(minors) + 1, len(a))
    return *map(rational, minors), *(determinant(H[:k, :k]) for k in rest)


def _hurwitz_with_symbols(p: Poly) -> StabilityDecision:
    determinants = hurwitz_determinants(p)
    signs = [sympy.factor(d).is_positive for d in determinants]
    needed = [sympy.factor(c / p.LC()).is_positive for c in p.all_coeffs()]  # all positive
    by_signs = True if set(signs) == {True} else None
    if False in signs + needed and p.LC().is_nonzero:  # else the degree may drop
        by_signs = False
    return StabilityDecision(p, "continuous", by_signs, None, None, None, determinants)


def _schur_with_symbols(p: Poly) -> StabilityDecision:
    product = sympy.cancel(p.TC() / p.LC())
    if not p.free_symbols_in_domain:
        return StabilityDecision(p, "discrete", _jury(p), None, None, None, (product,))
    certain = p.LC().is_nonzero  # else the degree may drop and the product mean nothing
    outside = certain and sympy.Ge(sympy.Abs(product), 1) == sympy.true
    is_small = 0 < p.degree() <= MAX_SYMBOLIC_DEGREE
    if outside or not is_small or not any(x.is_real for x in p.free_symbols_in_domain):
        answer = False if outside else None
        return StabilityDecision(p, "discrete", answer, None, None, None, (product,))
    return _schur_through_hurwitz(p, certain)


def _schur_through_hurwitz(p: Poly, degree_is_certain: bool) -> StabilityDecision:
    """Decide by the signs of the determinants of (1 - w)^n p((1 + w)/(1 - w))."""
    w, n = p.gen, int(p.degree())
    terms = (c * (1 + w) ** k * (1 - w) ** (n - k) for (k,), c in p.terms())
    mapped = polynomial(sympy.expand(sympy.Add(*terms)), w)
    if mapped.degree() < n:  # p(-1) = 0, for all values
        answer = False if degree_is_certain else None
        return StabilityDecision(p, "discrete", answer, None, None, None, ())
    determinants = hurwitz_determinants(mapped)
    signs = [sympy.factor(d).is_positive for d in determinants]
    stable = None not in signs and False not in signs and bool(p.eval(-1).is_nonzero)
    answer = True if stable else False if False in signs and degree_is_certain else None
    return StabilityDecision(p, "discrete", answer, None, None, None, determinants)


def _jury(poly: Poly) -> bool | None:
    """Run the Schur-Cohn recursion on irrational numbers; None if SymPy cannot tell a sign."""
    coefficients = list(poly.all_coeffs())
    while len(coefficients) > 1:
        k = sympy.simplify(coefficients[-1] / coefficients[0])
        if not (1 - k**2).is_positive:
            return None if (1 - k**2).is_positive is None else False
        reduced = zip(coefficients[:-1], coefficients[:0:-1], strict=True)
        coefficients = [sympy.simplify(c - k * mirrored) for c, mirrored in reduced]
    return True
