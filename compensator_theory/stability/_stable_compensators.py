"""A stable compensator for a plant that has one, searched by its order."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations

import flint
from sympy import QQ, Expr, Integer, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops._siso import closed_loop_of_pair, is_well_posed, require_sign
from compensator_theory.matrices._certificates import Certificate, evaluated
from compensator_theory.matrices._rings import RationalRing
from compensator_theory.polynomials._budget import ask, integer
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._counts import count_roots
from compensator_theory.stability._stabilising_gains import intervals_of_gains
from compensator_theory.stability._strong_stabilisability import (
    StrongStabilisability,
    decide_strong_stabilisability,
)
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._transfer_functions import TransferFunction

CONTINUOUS_GRID = tuple(Rational(2) ** k for k in (0, 1, -1, 2, -2, 3, -3, 4, 5, -4, 6, -5, 8))
DISCRETE_GRID = tuple(Rational(k, 10) for k in (0, 3, -3, 5, -5, 7, -7, 8, -8, 9, -9))


@dataclass(frozen=True)
class StableCompensator(ExactValue):
    """A stable compensator that stabilises a plant, or the orders that were searched.

    Attributes
    ----------
    plant : TransferFunction
    compensator : TransferFunction or None
        Stable and proper; None where none was found, for the reason in `reason`.
    characteristic_polynomial : sympy.Poly or None
        Of the loop, of the unreduced plant.
    decision : StrongStabilisability
        Whether one exists at all: the parity interlacing property.
    searched : int
        The largest order that was searched.
    reason : str
        Why there is none: "" if there is one.
    """

    plant: TransferFunction
    compensator: TransferFunction | None
    characteristic_polynomial: Poly | None
    decision: StrongStabilisability
    searched: int
    reason: str

    @property
    def certificate(self) -> Certificate | None:
        """The loop and the counts of roots, evaluated anew; None without a compensator."""
        if self.compensator is None or self.characteristic_polynomial is None:
            return None
        left = loop_residuals(self.plant, self.compensator, self.characteristic_polynomial)
        counts = count_roots(self.compensator.denominator)
        left.append([Integer(counts.total - counts.stable)])
        return evaluated(f"{LOOP}; no root of D_c is", left)

    def __str__(self) -> str:
        if self.compensator is None:
            return self.reason
        return f"{self.compensator} is stable and stabilises {self.decision.plant}"

    def _repr_latex_(self) -> str:
        if self.compensator is None:
            return displayed(words(self.reason))
        return displayed(
            f"G_c = {latex(self.compensator)}",
            rf"\tilde D = {latex(self.characteristic_polynomial)}",
        )


LOOP = "D D_c - f N N_c = D~; no root of D~ is unstable or on the boundary of stability"


def loop_residuals(
    plant: TransferFunction, compensator: TransferFunction, loop: Poly
) -> list[Poly | list[Expr]]:
    """Return the residuals of `LOOP` for a compensator with a sign of feedback."""
    f, roots = compensator.feedback or 1, count_roots(loop)
    difference = canonical(closed_loop_of_pair(plant, compensator, f) - loop)
    return [difference, [Integer(roots.total - roots.stable)]]


@refusing
def stable_compensator(
    plant: TransferFunctionLike,
    max_order: int | None = None,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> StableCompensator:
    r"""Search a stable compensator, order by order.

    .. math:: D D_c - f\,N N_c = \tilde D, \qquad N_c = -f\,\tilde D\,N^{-1} \bmod D

    Order 0 is decided by :func:`stabilising_gains`. At the orders 1 to n - 2 the largest real part
    (or modulus) of the roots is made small in floats, over stable :math:`D_c` and from several
    starts; candidates are rounded and then decided exactly. From order n - 1 on, closed-loop
    polynomials with up to two different real roots on a grid are placed, and the first whose
    :math:`D_c` is stable is taken. That none was found at an order above 0 is no proof that none is
    there.

    Parameters
    ----------
    plant : transfer function
        Strictly proper, rational; in s, or in z or q. Anything :func:`transfer_function` reads.
    max_order : int, optional
        Default: n + 2.
    feedback : {+1, -1}
        The sign f.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    StableCompensator
        None where there is none, by :func:`decide_strong_stabilisability`, or none was found up to
        that order: the order that is needed has no bound in n (as an unstable pole and zero come
        close to those that would forbid it, it grows without limit).

    Raises
    ------
    InputError, BudgetError
        If the plant is not strictly proper, is symbolic, or does not show the time domain; or
        `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: D. C. Youla, J. J. Bongiorno, C. N. Lu, Automatica 10 (1974); on the order M. C. Smith,
    K. P. Sondergeld, Systems and Control Letters 7 (1986) 9-13.

    Examples
    --------
    >>> from compensator_theory import stable_compensator
    >>> print(stable_compensator("(s - 2)/(s**2 - 1)", feedback=-1))
    (-4*s - 4)/(s + 7) is stable and stabilises (s - 2)/(s**2 - 1)
    >>> stable_compensator("(s - 1)/(s*(s - 2))", feedback=-1).compensator is None
    True
    """
    return search_by_order(
        transfer_function(plant, variable), max_order, feedback=feedback, between=True
    )


def search_by_order(
    plant: TransferFunctionLike, max_order: int | None, *, feedback: int, between: bool
) -> StableCompensator:
    """Search as :func:`stable_compensator`, at the orders 1 to n - 2 if requested."""
    require_sign(feedback)
    G = transfer_function(plant)
    time = time_of(G.variable, "strong stabilisability")
    discrete = time == "discrete"
    decision = decide_strong_stabilisability(G)
    if not G.is_strictly_proper:
        raise InputError(f"the plant {G} is not strictly proper; take its direct part out first")
    highest = G.order + 2 if max_order is None else max_order
    integer(highest, "max_order", at_least=0)
    ask("degree", highest, "the order of the compensator")
    if not decision.is_strongly_stabilisable:
        return StableCompensator(G, None, None, decision, 0, str(decision))
    gains = intervals_of_gains(G, feedback=feedback)
    if gains.intervals:
        gain = min((cell.sample for cell in gains.intervals), key=lambda k: (abs(k), k))
        one = Poly(1, G.variable, domain=QQ)
        return _verified_compensator(
            G, Poly(gain, G.variable, domain=QQ), one, feedback, decision, 0
        )
    reduced = G.reduced()
    N, D = reduced.numerator, reduced.denominator
    ring = RationalRing(G.variable)
    for order in range(1, min(reduced.order - 2, highest) + 1 if between else 1):
        for numbers in low_order_candidates(N, D, order, discrete):
            top, bottom = (canonical(Poly(side, G.variable, domain=QQ)) for side in numbers)
            loop = canonical(D * bottom + N * top)
            counts = [count_roots(poly, time=time) for poly in (loop, bottom)]
            if all(c.stable == c.total for c in counts):
                return _verified_compensator(G, top * -feedback, bottom, feedback, decision, order)
    n, d = ring.read(N), ring.read(D)
    inverse = ring.read(N.invert(D)) if D.degree() else n
    grid = DISCRETE_GRID if discrete else tuple(-x for x in CONTINUOUS_GRID)
    for order in range(max(1, reduced.order - 1), highest + 1):
        for target in _targets(ring, reduced.order + order, grid):
            top = (target * inverse) % d  # D D_c + N top = target
            bottom = (target - n * top) // d
            if not _may_be_stable(bottom, discrete):
                continue
            candidate = ring.write(bottom)
            location = count_roots(candidate, time=time)
            if location.stable == location.total:
                top = ring.write(top * (-feedback))
                return _verified_compensator(G, top, candidate, feedback, decision, order)
    return StableCompensator(
        G,
        None,
        None,
        decision,
        highest,
        f"{G} is strongly stabilisable, not by a gain, and the search up to order {highest} found "
        "no stable compensator, which is no proof that there is none; raise max_order",
    )


def _targets(
    ring: RationalRing, size: int, grid: tuple[Rational, ...]
) -> Iterator[flint.fmpq_poly]:
    """Yield monic polynomials with one or two different roots of the grid, simple ones first."""
    s = ring.power(1)
    powers = []
    for root in grid:
        base = s - flint.fmpq(int(root.p), int(root.q))
        powers.append([base**k for k in range(size + 1)])
    for of_root in powers:
        yield of_root[size]
    for one, two in permutations(powers, 2):
        for split in range(1, size // 2 + 1):
            yield one[size - split] * two[split]


def _may_be_stable(poly: flint.fmpq_poly, discrete: bool) -> bool:
    """A necessary condition for stability: signs, or the product of the roots."""
    coefficients = poly.coeffs()
    if discrete:
        return bool(abs(coefficients[0]) < abs(coefficients[-1]))
    return all(c * coefficients[-1] > 0 for c in coefficients)


def _verified_compensator(
    G: TransferFunction,
    top: Poly,
    bottom: Poly,
    feedback: int,
    decision: StrongStabilisability,
    order: int,
) -> StableCompensator:
    compensator = TransferFunction(
        canonical(top), canonical(bottom), feedback=feedback, sample_time=G.sample_time
    )
    whole = closed_loop_of_pair(G, compensator, feedback)
    time = time_of(G.variable, "strong stabilisability")
    for poly in (whole, compensator.denominator):
        location = count_roots(canonical(poly), time=time)
        if location.stable != location.total:
            raise NoSolutionError(f"{compensator} leaves {location}; please report it")
    if not is_well_posed(whole, G, compensator):
        raise NoSolutionError(f"the loop of {compensator} is not well posed; please report it")
    return StableCompensator(G, compensator, canonical(whole), decision, order, "")


# Candidates for stable compensators of low order: computed in floats, returned as rationals.

STARTS = 12
EVALUATIONS = 500
"""Of the spectrum of the loop in each start, for each free number of the compensator."""
PATIENCE, STALLED = 40, 0.9  # an end where so many steps for each free number gained so little
WORK = 15_000_000
"""Steps towards one root times the degree of the loop, for one plant: some two seconds."""
DENOMINATORS = (1, 2, 4, 10, 100, 10**4, 10**8)
ENOUGH = -0.05  # so far inside the region that rounding is no danger, in units of the plant's roots


def low_order_candidates(
    N: Poly, D: Poly, order: int, discrete: bool
) -> Iterator[tuple[tuple[Rational, ...], tuple[Rational, ...]]]:
    r"""Yield coefficients (N_c, D_c) that should make both D D_c + N N_c and D_c stable.

    .. math:: \min_{N_c, D_c} \max_i \operatorname{Re} \lambda_i(D D_c + N N_c)
              \quad\text{or}\quad \max_i |\lambda_i(D D_c + N N_c)|

    over stable :math:`D_c`, from several starts that are the same in every run, by random steps
    that grow with success and shrink without; then rounded, the coarsest first. A candidate is no
    answer before its stability is decided exactly, and no candidate is no proof.

    Of plants that were made around a compensator of order 2 or 3 with no gain that stabilises
    them, three in four get one back; of those around order 1 nearly all.
    """
    size = int(D.degree())
    share = WORK // (max(size - 2, 1) * STARTS)
    for start in range(STARTS):
        try:
            unit = 1.0 if discrete else _size_of_roots(D)
            n, d = (_scaled(p, unit, size) for p in (N, D))
            gain = max(map(abs, n))
            n = [c / gain for c in n]
            candidate = _descent(n, d, order, discrete, share, random.Random(start))
        except (OverflowError, ZeroDivisionError):  # the numbers leave the range of floats
            continue
        if candidate is None:
            continue
        # x = s/unit: a monic polynomial in x has the coefficient of s**(order - k) times unit**k
        weights = [unit**k for k in range(order + 1)]
        top = [c / gain * w for c, w in zip(candidate[0], weights, strict=True)]
        bottom = [c * w for c, w in zip(candidate[1], weights, strict=True)]
        for q in DENOMINATORS:
            yield tuple(_near(c, q) for c in top), tuple(_near(c, q) for c in bottom)


def _near(value: float, largest_denominator: int) -> Rational:
    """Round to a small denominator, small numbers to as many digits as large ones."""
    power = 0 if value == 0 else max(0, -math.floor(math.log10(abs(value))))
    nearest = Fraction(value * 10**power).limit_denominator(largest_denominator) / 10**power
    return Rational(nearest.numerator, nearest.denominator)


def _size_of_roots(D: Poly) -> float:
    """Return the geometric mean of the moduli of the nonzero roots; 1 if there is none."""
    coefficients = [c for c in D.all_coeffs() if c != 0]
    power = [i for i, c in enumerate(D.all_coeffs()) if c != 0][-1]
    return float(abs(coefficients[-1] / coefficients[0])) ** (1 / power) if power else 1.0


def _scaled(p: Poly, unit: float, degree: int) -> list[float]:
    """Return the coefficients of p(unit x)/unit**degree, descending."""
    top = int(p.degree())
    return [float(c) * unit ** (top - i - degree) for i, c in enumerate(p.all_coeffs())]


def _descent(
    n: Sequence[float],
    d: Sequence[float],
    order: int,
    discrete: bool,
    work: int,
    rng: random.Random,
) -> tuple[list[float], list[float]] | None:
    """Return (N_c, D_c) with a stable loop, as far as floats can tell, or None."""
    free = 2 * order + 1
    roots: list[complex] = []
    spent = 0

    def cost(x: Sequence[float]) -> float:
        nonlocal spent
        bottom = _stable(x[:order], discrete)
        loop = _sum(_product(d, bottom), _product(n, x[order:]))
        roots[:], sweeps = _roots(loop, roots)
        spent += sweeps * len(roots) ** 2
        return max(map(abs, roots)) - 1 if discrete else max(root.real for root in roots)

    best = [rng.gauss(0, 1) for _ in range(free)]
    least, step, before = cost(best), 1.0, math.inf
    for tries in range(EVALUATIONS * free):
        if least < ENOUGH or step < 1e-5 or spent > work:
            break
        if tries % (PATIENCE * free) == 0:
            if least > STALLED * before:
                break
            before = least
        length = step * rng.lognormvariate(0, 1)
        trial = [x + length * rng.gauss(0, 1) for x in best]
        now = cost(trial)
        if now < least:
            best, least, step = trial, now, step * 1.6
        else:
            step *= 0.95
    return (best[order:], _stable(best[:order], discrete)) if least < 0 else None


def _stable(x: Sequence[float], discrete: bool) -> list[float]:
    """Return a monic stable polynomial, descending: every one of its degree, for some x."""
    p = [1.0]
    if discrete:
        for reflection in map(math.tanh, x):
            p = [a + reflection * b for a, b in zip([*p, 0.0], [0.0, *p[::-1]], strict=True)]
        return p
    rates = [math.exp(max(-30.0, min(30.0, value))) for value in x]
    for i in range(0, len(rates) - 1, 2):
        p = _product(p, [1.0, rates[i], rates[i + 1]])
    return _product(p, [1.0, rates[-1]]) if len(rates) % 2 else p


def _product(p: Sequence[float], q: Sequence[float]) -> list[float]:
    product = [0.0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] += a * b
    return product


def _sum(p: Sequence[float], q: Sequence[float]) -> list[float]:
    """Add, the constant terms at the end; p is the longer."""
    shift = len(p) - len(q)
    return [a + (q[i - shift] if i >= shift else 0.0) for i, a in enumerate(p)]


def _roots(p: Sequence[float], start: Sequence[complex]) -> tuple[list[complex], int]:
    """Return the roots of a monic polynomial by Aberth's iteration, and the sweeps that it took."""
    degree = len(p) - 1
    roots = list(start)
    if len(roots) != degree:
        radius = max(abs(c) ** (1 / i) for i, c in enumerate(p[1:], 1)) or 1.0
        roots = [cmath.rect(radius, 0.4 + 2 * math.pi * k / degree) for k in range(degree)]
    sweeps, largest = 0, 1.0
    while largest > 1e-6 and sweeps < 40:
        sweeps, largest = sweeps + 1, 0.0
        for i, z in enumerate(roots):
            value, slope = 0j, 0j
            for c in p:
                slope = slope * z + value
                value = value * z + c
            if value == 0:
                continue
            repelled = sum(1 / (z - other) for other in roots if other != z)
            bottom = slope - value * repelled
            change = value / bottom if bottom else 0.1 * (1 + abs(z))
            roots[i] = z - change
            largest = max(largest, abs(change) / (1 + abs(z)))
    return roots, sweeps
