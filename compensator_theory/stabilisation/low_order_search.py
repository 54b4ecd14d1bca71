"""Candidates for stable compensators of low order: found in floats, handed over as rationals."""

import cmath
import math
import random
from collections.abc import Iterator, Sequence
from fractions import Fraction

from sympy import Poly, Rational

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

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stabilisation.low_order_search import low_order_candidates
    >>> N, D = polynomial("1", "s"), polynomial("s**2*(s + 10)")
    >>> top, bottom = next(low_order_candidates(N, D, 1, discrete=False))
    >>> len(top), len(bottom)
    (2, 2)
    """
    size = int(D.degree())
    share = WORK // (max(size - 2, 1) * STARTS)
    for start in range(STARTS):
        try:
            unit = 1.0 if discrete else _size_of_roots(D)
            n, d = (_scaled(p, unit, size) for p in (N, D))
            gain = max(map(abs, n))
            n = [c / gain for c in n]
            found = _descent(n, d, order, discrete, share, random.Random(start))
        except (OverflowError, ZeroDivisionError):  # the numbers are none for floats
            continue
        if found is None:
            continue
        # x = s/unit: what is monic in x has the coefficient of s**(order - k) times unit**k
        weights = [unit**k for k in range(order + 1)]
        top = [c / gain * w for c, w in zip(found[0], weights, strict=True)]
        bottom = [c * w for c, w in zip(found[1], weights, strict=True)]
        for q in DENOMINATORS:
            yield tuple(_near(c, q) for c in top), tuple(_near(c, q) for c in bottom)


def _near(value: float, largest_denominator: int) -> Rational:
    """Round to a small denominator, small numbers to as many digits as large ones."""
    power = 0 if value == 0 else max(0, -math.floor(math.log10(abs(value))))
    found = Fraction(value * 10**power).limit_denominator(largest_denominator) / 10**power
    return Rational(found.numerator, found.denominator)


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
        tried = [x + length * rng.gauss(0, 1) for x in best]
        now = cost(tried)
        if now < least:
            best, least, step = tried, now, step * 1.6
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
    found = [0.0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            found[i + j] += a * b
    return found


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
