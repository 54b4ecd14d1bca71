"""Ten thousand drawn textbook problems, each against an oracle of another algorithm.

``python benchmarks/drawn_problems.py [PROBLEMS [SEED]]`` draws problems of twelve kinds in the
shares of `KINDS`, prints each answer that differs from its oracle, and a table of the counts,
refusals and times. The exit status is 1 where an answer is wrong. The oracles:

- responses and transition matrices in continuous time: exp of the companion matrix in balls
  (python-flint), at three times; in discrete time: the recursion in fractions;
- Routh's and Jury's arrays and ranges of gains: roots of the polynomial, isolated by python-flint;
- delays: Chebyshev collocation of the characteristic operator (SciPy), 60 and 90 nodes;
- margins with a dead time: crossovers on a dense grid, refined by Brent's method (SciPy);
- zero-order hold: exp of the augmented matrix in balls; characteristics: a dense response (NumPy);
- placement: the product of polynomials in fractions.
"""

import sys
import time
from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from random import Random
from typing import Any

import flint
import numpy as np
import scipy.linalg
import scipy.optimize
import sympy
from flint import arb, arb_mat, fmpq_poly

import compensator_theory as exact
from compensator_theory.errors import CompensatorError
from compensator_theory.results import TimeResponse

flint.ctx.prec = 200
S, Z = sympy.Symbol("s"), sympy.Symbol("z")
Numbers = list[Fraction]


def number(random: Random, largest: int = 6) -> Fraction:
    """A small fraction, mostly an integer."""
    return Fraction(random.randint(-largest, largest), random.choice((1, 1, 1, 2, 3)))


def factors(random: Random, degree: int, variable: str) -> Numbers:
    """A monic polynomial of small factors; roots repeat and lie on the boundary at times."""
    p = [Fraction(1)]
    while len(p) <= degree:
        if len(p) == degree or random.random() < 0.6:
            factor = [Fraction(1), -number(random) / (3 if variable == "z" else 1)]
        else:
            scale = 4 if variable == "z" else 1
            factor = [
                Fraction(1),
                number(random, 4) / scale,
                Fraction(random.randint(0, 6)) / scale,
            ]
        for _ in range(2 if random.random() < 0.15 else 1):
            if len(p) + len(factor) - 1 <= degree + 1:
                p = product(p, factor)
    return p


def dense(random: Random, degree: int) -> Numbers:
    """A monic polynomial of small integers."""
    return [Fraction(1), *(Fraction(random.randint(-3, 8)) for _ in range(degree))]


def product(a: Numbers, b: Numbers) -> Numbers:
    """The product of two polynomials."""
    result = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def text(p: Numbers, variable: str) -> str:
    """A polynomial as a user types it."""
    n = len(p) - 1
    terms = [f"({c})*{variable}**{n - k}" for k, c in enumerate(p) if c]
    return " + ".join(terms) or "0"


def plant(random: Random, variable: str, order: int) -> tuple[Numbers, Numbers, str]:
    """Numerator, denominator and text of a strictly proper plant."""
    a = factors(random, order, variable)
    b = [Fraction(random.randint(-5, 5)) for _ in range(random.randint(1, order))]
    if not any(b):
        b[-1] = Fraction(1)
    while not b[0]:
        b = b[1:]
    return b, a, f"({text(b, variable)})/({text(a, variable)})"


def ball(value: Fraction) -> arb:
    """A fraction as a ball."""
    return arb(value.numerator) / value.denominator


def companion(a: Numbers, b: Numbers) -> tuple[list[Numbers], Numbers, Numbers]:
    """The controllable companion form (A, B, C) of b/a."""
    n = len(a) - 1
    rows = [[Fraction(int(j == i + 1)) for j in range(n)] for i in range(n - 1)]
    rows.append([-a[n - j] for j in range(n)])
    c = [Fraction(0)] * n
    for k, coefficient in enumerate(reversed(b)):
        c[k] = coefficient
    return rows, [Fraction(0)] * (n - 1) + [Fraction(1)], c


def exponential(rows: list[Numbers], when: Fraction) -> list[list[arb]]:
    """exp(A t) in balls."""
    matrix = arb_mat([[ball(x * when) for x in row] for row in rows]).exp()
    n = len(rows)
    return [[matrix[i, j] for j in range(n)] for i in range(n)]


def value_at(expression: sympy.Expr, variable: sympy.Symbol, when: Fraction) -> complex:
    """A closed form at a time, to 40 digits."""
    return sympy.N(expression.subs(variable, sympy.Rational(when.numerator, when.denominator)), 40)


def near(value: Any, oracle: arb) -> bool:
    """Whether a number of 40 digits agrees with a ball to 25."""
    middle = sympy.Float(oracle.mid().str(45, radius=False), 45)
    radius = sympy.Float(
        (oracle.rad() + abs(oracle) * arb("1e-25")).upper().str(5, radius=False), 5
    )
    return bool(abs(value - middle) <= radius + sympy.Float("1e-30"))


TIMES = Fraction(1, 3), Fraction(1), Fraction(5, 2)


def agrees(y: TimeResponse, A: list[Numbers], C: Numbers) -> bool:
    """Whether a response is C exp(A t) e_n at three times."""
    right = True
    for when in TIMES:
        E = exponential(A, when)
        oracle = sum((ball(c) * E[i][-1] for i, c in enumerate(C)), arb(0))
        right &= near(value_at(y.expression, y.time, when), oracle)
    return right


def impulse(random: Random) -> tuple[str, bool]:
    """Impulse response at three times."""
    b, a, G = plant(random, "s", random.randint(1, 4))
    A, _, C = companion(a, b)
    return G, agrees(exact.impulse_response(G), A, C)


def step(random: Random) -> tuple[str, bool]:
    """Step response at three times: the impulse response of G/s."""
    b, a, G = plant(random, "s", random.randint(1, 4))
    A, _, C = companion([*a, Fraction(0)], b)
    return G, agrees(exact.step_response(G), A, C)


def discrete(random: Random) -> tuple[str, bool]:
    """Step and impulse response in discrete time at k = 0 to 9: the recursion."""
    b, a, G = plant(random, "z", random.randint(1, 4))
    is_step = random.random() < 0.5
    y = (exact.step_response if is_step else exact.impulse_response)(G)
    n, right = len(a) - 1, True
    padded = [Fraction(0)] * (n + 1 - len(b)) + b
    u = [Fraction(1)] * 10 if is_step else [Fraction(1)] + [Fraction(0)] * 9
    values: Numbers = []
    impulses = {int(k): sympy.sympify(v) for k, v in y.impulses} if y.impulses else {}
    for k in range(10):
        total = sum(padded[i] * u[k - i] for i in range(min(k, n) + 1))
        total -= sum(a[i] * values[k - i] for i in range(1, min(k, n) + 1))
        values.append(Fraction(total))
        value = value_at(y.expression, y.time, Fraction(k)) + impulses.get(k, 0)
        oracle = sympy.Rational(values[-1].numerator, values[-1].denominator)
        right &= bool(abs(value - oracle) <= sympy.Float("1e-25") * (1 + abs(oracle)))
    return G, right


def transition(random: Random) -> tuple[str, bool]:
    """exp(A t) at three times."""
    n = random.randint(1, 3)
    A = [[Fraction(random.randint(-3, 3)) for _ in range(n)] for _ in range(n)]
    matrix = exact.transition_matrix([[str(x) for x in row] for row in A], "s")
    right = True
    for when in TIMES:
        E = exponential(A, when)
        for i in range(n):
            for j in range(n):
                right &= near(value_at(matrix.expression[i, j], matrix.time, when), E[i][j])
    return str(A), right


def roots_of(p: Numbers) -> list[tuple[Any, int]]:
    """Isolated roots with their multiplicities, by python-flint."""
    poly = fmpq_poly([flint.fmpq(c.numerator, c.denominator) for c in reversed(p)])
    return list(poly.complex_roots())


def counted(p: Numbers, variable: str) -> list[int]:
    """Stable, boundary and unstable roots; a root within 1e-40 of the boundary lies on it."""
    count = [0, 0, 0]
    for root, multiplicity in roots_of(p):
        distance = root.real if variable == "s" else root.real**2 + root.imag**2 - 1
        middle = float(distance.mid())
        place = 1 if abs(middle) < 1e-40 else 0 if middle < 0 else 2
        count[place] += multiplicity
    return count


def polynomial(random: Random, variable: str) -> Numbers:
    """A polynomial for an array; one in four has mirrored roots, so that rows of zeros occur."""
    p = (
        dense(random, random.randint(1, 5))
        if random.random() < 0.5
        else factors(random, random.randint(1, 5), variable)
    )
    if random.random() < 0.25:
        p = product(
            p,
            [Fraction(1), Fraction(0), Fraction(random.randint(-4, 4))]
            if variable == "s"
            else [Fraction(1), Fraction(random.randint(-4, 4), 2), Fraction(1)],
        )
    return p


def routh(random: Random) -> tuple[str, bool]:
    """Routh's array: roots in the two half planes and on the axis."""
    p = polynomial(random, "s")
    count = exact.routh_array(text(p, "s"), "s").count
    return text(p, "s"), [count.stable, count.boundary, count.unstable] == counted(p, "s")


def jury(random: Random) -> tuple[str, bool]:
    """Jury's array: roots inside, on and outside the circle."""
    p = polynomial(random, "z")
    count = exact.jury_array(text(p, "z"), "z").count
    return text(p, "z"), [count.stable, count.boundary, count.unstable] == counted(p, "z")


def gains(random: Random) -> tuple[str, bool]:
    """Ranges of the gain: roots in the middle of each range and at 200 points beside."""
    variable = random.choice("sz")
    b, a, G = plant(random, variable, random.randint(1, 4))
    intervals = exact.stabilising_gains(G, feedback=-1).intervals
    ends = [
        tuple(
            Fraction(str(sympy.Rational(str(sympy.N(end, 30))))) if end.is_finite else end
            for end in map(sympy.sympify, (cell.lower, cell.upper))
        )
        for cell in intervals
    ]
    padded = [Fraction(0)] * (len(a) - len(b)) + b
    points = [Fraction(random.randint(-400, 400), random.choice((1, 7, 30))) for _ in range(200)]
    for k in points:
        inside = any(lower < k < upper for lower, upper in ends)
        if any(
            end not in (sympy.oo, -sympy.oo) and abs(end - k) < Fraction(1, 10**12)
            for pair in ends
            for end in pair
        ):
            continue
        p = [x + k * y for x, y in zip(a, padded, strict=True)]
        _, boundary, unstable = counted(p, variable)
        if inside != (boundary == unstable == 0):
            return f"{G} at {k}", False
    return G, True


def collocation(a: Numbers, b: Numbers, delay: float, nodes: int) -> np.ndarray:
    """Eigenvalues of a(s) + b(s) exp(-s tau), deg b < deg a, by Chebyshev collocation."""
    n = len(a) - 1
    A0 = np.array([[float(x) for x in row] for row in companion(a, [Fraction(1)])[0]])
    A1 = np.zeros((n, n))
    A1[-1, : len(b)] = [-float(x) for x in reversed(b)]
    points = np.cos(np.pi * np.arange(nodes + 1) / nodes)
    weight = np.array([2.0, *np.ones(nodes - 1), 2.0]) * (-1.0) ** np.arange(nodes + 1)
    differences = points[:, None] - points[None, :] + np.eye(nodes + 1)
    D = weight[:, None] / weight[None, :] / differences
    D -= np.diag(D.sum(axis=1))
    M = np.kron(D * 2 / delay, np.eye(n))
    M[:n] = 0
    M[:n, :n] = A0
    M[:n, -n:] = A1
    return scipy.linalg.eigvals(M)


def delays(random: Random) -> tuple[str, bool]:
    """Unstable roots of a retarded quasi-polynomial at a delay."""
    n = random.randint(1, 3)
    a = dense(random, n)
    b = [Fraction(random.randint(-4, 4)) for _ in range(random.randint(1, n))]
    b[0] = b[0] or Fraction(1)
    tau = Fraction(random.randint(1, 40), 10)
    name = f"{text(a, 's')} + ({text(b, 's')}) exp(-{tau} s)"
    windows = exact.stability_delays([text(a, "s"), text(b, "s")], variable="s")
    counts = []
    for nodes in (60, 90):
        roots = collocation(a, b, float(tau), nodes)
        counts.append(int((roots.real > 1e-7).sum()))
        nearest = np.abs(roots[np.abs(roots) < 60].real).min()
    if counts[0] != counts[1] or nearest < 1e-7:
        return f"{name}: the oracle is undecided, nearest root {nearest:.1e}", True
    return name, windows.unstable_roots(sympy.Rational(tau.numerator, tau.denominator)) == counts[0]


def delayed_margins(random: Random) -> tuple[str, bool]:
    """Gain and delay margin of a stable plant with a dead time, from a dense frequency response."""
    poles = [
        Fraction(random.randint(1, 12), random.choice((1, 2, 5)))
        for _ in range(random.randint(1, 3))
    ]
    gain = Fraction(random.randint(1, 30), 4)
    dead = Fraction(random.randint(1, 20), 10)
    bottom = "*".join(f"(s/({p}) + 1)" for p in poles)
    G = f"{gain}*exp(-{dead}*s)/({bottom})"
    margins = exact.stability_margins(G, feedback=-1)
    pole, K, L = np.array([float(p) for p in poles]), float(gain), float(dead)

    def angle(w: float) -> float:
        return float(np.arctan(w / pole).sum() + L * w - np.pi)

    def size(w: float) -> float:
        return float(K / np.sqrt(1 + (w / pole) ** 2).prod())

    crossing = scipy.optimize.brentq(angle, 1e-9, 2 * np.pi / L, xtol=1e-14)
    right = True
    critical = 1 / size(crossing)  # monotone phase and gain: the first crossing decides
    stable = critical > 1
    right &= bool(margins.is_stable) == stable
    if stable:
        right &= abs(float(sympy.N(number_of(margins.gain_up.value))) - critical) < 1e-8 * critical
        if K > 1:
            w = scipy.optimize.brentq(lambda x: size(x) - 1, 1e-9, 1e6, xtol=1e-14)
            delay = -angle(w) / w
            right &= abs(float(sympy.N(number_of(margins.delay.value))) - delay) < 1e-7 * (
                1 + delay
            )
    return G, right


def number_of(value: Any) -> sympy.Expr:
    """The centre of an enclosure, or the number."""
    return value.centre if isinstance(value, exact.results.Enclosure) else sympy.sympify(value)


def hold(random: Random) -> tuple[str, bool]:
    """Zero-order hold: values of the sampled transfer function at two points."""
    order = random.randint(1, 3)
    a = [Fraction(1)]
    while len(a) <= order:  # poles at whole numbers or in pairs with a rational frequency
        if len(a) == order or random.random() < 0.6:
            factor = [Fraction(1), Fraction(random.randint(-3, 3))]
        else:
            real, imaginary = random.randint(-2, 2), random.randint(1, 3)
            factor = [Fraction(1), Fraction(-2 * real), Fraction(real**2 + imaginary**2)]
        a = product(a, factor)
    b = [Fraction(random.randint(1, 5))]
    G = f"({text(b, 's')})/({text(a, 's')})"
    h = Fraction(random.randint(1, 8), 4)
    sampled = exact.sampling.zero_order_hold(G, sympy.Rational(h.numerator, h.denominator))
    A, B, C = companion(a, b)
    n = len(A)
    augmented = [[*row, x] for row, x in zip(A, B, strict=True)] + [[Fraction(0)] * (n + 1)]
    E = exponential(augmented, h)
    values = dict(sampled.exponentials)
    closed_form = sampled.transfer_function.as_expr().subs(values)
    right = True
    for z in (Fraction(7, 2), Fraction(-5, 3)):
        system = arb_mat([[ball(z) * int(i == j) - E[i][j] for j in range(n)] for i in range(n)])
        state = system.solve(arb_mat([[E[i][n]] for i in range(n)]))
        oracle = sum((ball(c) * state[i, 0] for i, c in enumerate(C)), arb(0))
        right &= near(value_at(closed_form, Z, z), oracle)
    return f"{G}, h = {h}", right


def characteristics(random: Random) -> tuple[str, bool]:
    """Overshoot, settling and rise time of a stable plant, from 2500 samples a second."""
    kind = random.randrange(3)
    if kind == 0:
        poles = [complex(-random.randint(1, 6)) for _ in range(2)]
    else:
        poles = [complex(-random.randint(1, 4), random.randint(1, 8))]
        poles += [poles[0].conjugate()]
    if kind == 2:
        poles.append(complex(-random.randint(1, 5)))
    a = [Fraction(round(x)) for x in np.real(np.poly(poles))]
    b = [a[-1]] if random.random() < 0.5 else [Fraction(random.randint(1, 4)) * a[-1] / 4, a[-1]]
    G = f"({text(b, 's')})/({text(a, 's')})"
    response = exact.step_response(G)
    A, B, C = (
        np.array([[float(x) for x in row] for row in part])
        for part in (companion(a, b)[0], [[x] for x in companion(a, b)[1]], [companion(a, b)[2]])
    )
    end, n = 16.0, 40_001
    times = np.linspace(0, end, n)
    M = np.block([[A, B], [np.zeros((1, len(A) + 1))]])
    E = scipy.linalg.expm(M * (times[1] - times[0]))
    state = np.zeros(len(A) + 1)
    state[-1] = 1
    y = np.empty(n)
    for k in range(n):
        y[k] = C[0] @ state[:-1]
        state = E @ state
    step_of_grid = times[1]
    over = max(y.max() - 1, 0.0)
    outside = np.flatnonzero(np.abs(y - 1) > 0.02)
    settle = times[outside[-1] + 1]
    rise = times[np.flatnonzero(y >= 0.9)[0]] - times[np.flatnonzero(y >= 0.1)[0]]
    characteristics = [
        float(sympy.N(number_of(value)))
        for value in (response.overshoot(), response.settling_time(), response.rise_time())
    ]
    right = abs(characteristics[0] - over) < 1e-5 * (1 + over)
    right &= abs(characteristics[1] - settle) < 2 * step_of_grid + 1e-6
    right &= abs(characteristics[2] - rise) < 2 * step_of_grid + 1e-6
    return f"{G}: {characteristics} against {[over, settle, rise]}", right


def placement(random: Random) -> tuple[str, bool]:
    """The polynomial of the loop is the target, in fractions."""
    n = random.randint(1, 4)
    b, a, G = plant(random, "s", n)
    target = factors(random, 2 * n - 1, "s")
    compensator = exact.place_poles(G, text(target, "s"), feedback=-1, variable="s").compensator
    top, bottom = (
        [Fraction(int(c.p), int(c.q)) for c in p.all_coeffs()]
        for p in (compensator.numerator, compensator.denominator)
    )
    first, second = product(a, bottom), product(b, top)
    size = max(len(first), len(second))
    loop = [
        x + y
        for x, y in zip(
            [Fraction(0)] * (size - len(first)) + first,
            [Fraction(0)] * (size - len(second)) + second,
            strict=True,
        )
    ]
    return f"{G} to {text(target, 's')}", [c / loop[0] for c in loop] == target


Kind = Callable[[Random], tuple[str, bool]]
KINDS: dict[Kind, int] = {
    step: 20, impulse: 10, discrete: 12, transition: 10, routh: 13, jury: 10, gains: 4, delays: 6,
    delayed_margins: 5, hold: 5, characteristics: 2, placement: 3,
}  # fmt: skip
"""Problems of each kind in a hundred."""


def main(problems: int = 10_000, seed: int = 0) -> int:
    """Draw, compare, print, and return the exit status."""
    rows = []
    for kind, share in KINDS.items():
        counts, refusals, took = Counter[str](), Counter[str](), []
        for problem in range(max(1, problems * share // 100)):
            random = Random(f"{seed} {kind.__name__} {problem}")
            start = time.process_time()
            try:
                name, right = kind(random)
            except CompensatorError as error:
                counts["refused"] += 1
                refusals[f"{type(error).__name__}: {str(error)[:90]}"] += 1
                continue
            except Exception as error:  # not of our tree: a defect, or of the oracle
                name, right = f"problem {problem}: {type(error).__name__}: {error}", False
            took.append(time.process_time() - start)
            counts["right" if right else "WRONG"] += 1
            counts["undecided"] += "undecided" in name
            if not right:
                print(f"WRONG {kind.__name__} {problem}: {name}", flush=True)
        rows.append((kind, counts, took))
        print(f"{kind.__name__}: {dict(counts)}", flush=True)
        for refusal, number_of_times in refusals.most_common(3):
            print(f"    {number_of_times} refused: {refusal}", flush=True)
    print("\n| kind | right | wrong | refused | oracle undecided | median ms | slowest s |")
    print("|---|---|---|---|---|---|---|")
    for kind, counts, took in rows:
        print(
            f"| {kind.__name__} | {counts['right'] - counts['undecided']} | {counts['WRONG']} | "
            f"{counts['refused']} | {counts['undecided']} | {1e3 * np.median(took):.0f} | "
            f"{max(took):.2f} |"
        )
    wrong = sum(counts["WRONG"] for _, counts, _ in rows)
    print(f"{sum(sum(c.values()) - c['undecided'] for _, c, _ in rows)} problems, {wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
