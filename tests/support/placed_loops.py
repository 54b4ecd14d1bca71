"""Loops around plants with dead time, of which it is known by other means whether they match G_f.

What is true is found with fractions: the loop's polynomial and the one asked for, whose factors
were drawn, beside each other on the unit circle.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

import rcac_numeric as rn
from compensator_theory import InputError, place_poles
from compensator_theory.errors import CompensatorError
from compensator_theory.loops import target_characteristic_polynomial

DECIMALS = 100
VISIBLE, SAME = 0.15, 1e-2  # of the polynomial on the circle: surely another, surely the same


@dataclass
class Loop:
    """A plant, its target model, a controller, and whether the loop has the poles asked for."""

    words: str
    plant: rn.Plant
    target: rn.TargetModel
    compensator: rn.Compensator
    is_same: bool
    run: rn.Run | None = None


def product(*factors):
    """Coefficients, the highest power first, of a product of polynomials."""
    result = [Fraction(1)]
    for factor in factors:
        longer = [Fraction(0)] * (len(result) + len(factor) - 1)
        for i, a in enumerate(result):
            for j, b in enumerate(factor):
                longer[i + j] += a * Fraction(b)
        result = longer
    return result


def from_roots(roots):
    """(q - p) of every real root, and the quadratic of every pair that its upper one stands for."""
    return product(*(
        [1, -2 * p.real, p.real**2 + p.imag**2] if isinstance(p, Pair) else [1, -p] for p in roots
    ))  # fmt: skip


@dataclass(frozen=True)
class Pair:
    """A pole with positive imaginary part, and its conjugate."""

    real: Fraction
    imag: Fraction


def decimal(rng, low, high):
    """A number of two decimals, never 0."""
    return Fraction(int(rng.integers(low * DECIMALS, high * DECIMALS)) or 1, DECIMALS)


def text(coefficients):
    """A polynomial in q for the reader of plants."""
    degree = len(coefficients) - 1
    return " + ".join(f"({c})*q**{degree - i}" for i, c in enumerate(coefficients))


def requested_roots(rng):
    """One to three poles, at times a pair or a double one."""
    kind = rng.integers(0, 4)
    if kind == 0:
        return [Pair(decimal(rng, -0.6, 0.6), abs(decimal(rng, 0.1, 0.6)))]
    if kind == 1:
        return [decimal(rng, -0.9, 0.9)] * 2
    return [decimal(rng, -0.9, 0.9) for _ in range(int(rng.integers(1, 4)))]


class Drawn:
    """A plant with 1 to 12 steps of dead time, and poles to place."""

    def __init__(self, rng):
        order, self.delay = int(rng.integers(1, 4)), int(rng.integers(1, 13))
        self.poles = [decimal(rng, -1.1, 1.1) for _ in range(order)]
        free = (z for z in iter(lambda: decimal(rng, -1.6, 1.6), None) if z not in self.poles)
        self.zeros = [z for z in (next(free) for _ in range(order - 1)) if abs(z) != 1]
        self.gain = decimal(rng, 0.2, 2)
        self.requested = requested_roots(rng)
        self.n_c = order + self.delay + int(rng.integers(0, 2))

    @property
    def numerator(self):
        return product([self.gain], from_roots(self.zeros))

    @property
    def denominator(self):
        return product(from_roots(self.poles), [1, *[0] * self.delay])

    @property
    def plant(self):
        return rn.standard_plant(f"({text(self.numerator)})/({text(self.denominator)})")

    def target(self, roots=None):
        """G_f of the drawn poles, or of others."""
        D_p = text(from_roots(self.requested if roots is None else roots))
        return rn.pole_placement_target(self.plant, D_p)

    def placing(self, requested=None, plant=None):
        """The exact controller that places what the target model asks for, as fractions."""
        plant = self.plant if plant is None else plant
        polynomial = target_characteristic_polynomial(
            plant.problem, self.n_c, self.target(requested).exact
        )
        placement = place_poles(
            plant.problem.transfer_function("yu"), polynomial, self.n_c, feedback=+1,
            numerator_degree=self.n_c - 1,
        )  # fmt: skip
        length = range(self.n_c, -1, -1)
        return tuple(
            [Fraction(int(c.p), int(c.q)) for c in map(side.nth, length)]
            for side in (placement.numerator, placement.denominator)
        )

    def difference(self, compensator):
        """How far the loop's polynomial is from the one asked for, over the unit circle."""
        D_c, N_c = compensator.denominator, compensator.numerator
        ours = [
            a + b for a, b in zip(
                product(self.denominator, D_c),
                [-c for c in padded(product(self.numerator, N_c), len(self.poles) + self.delay
                                    + len(D_c) - 1)],
                strict=True,
            )
        ]  # fmt: skip
        stable = [z for z in self.zeros if abs(z) < 1]
        expected = padded_right(product(from_roots(stable), from_roots(self.requested)), len(ours))
        q = np.exp(1j * np.linspace(0, np.pi, 2001))
        off = np.polyval(np.array([a - b for a, b in zip(ours, expected, strict=True)], float), q)
        return float(np.max(np.abs(off) / np.abs(np.polyval(np.array(expected, float), q))))


def padded(coefficients, degree):
    """The same polynomial with zeros before, for a sum."""
    return [Fraction(0)] * (degree + 1 - len(coefficients)) + coefficients


def padded_right(coefficients, length):
    """Times a power of q."""
    assert len(coefficients) <= length
    return coefficients + [Fraction(0)] * (length - len(coefficients))


def compensator_of(N_c, D_c, rng=None, change=0.0):
    """The rounded coefficients; each changed by so much of it."""

    def rounded(values):
        factors = 1.0 if rng is None else 1 + change * rng.standard_normal(len(values))
        return np.array([float(v) for v in values]) * factors

    D, N = rounded(D_c), rounded(N_c)
    return rn.Compensator(past_u=-D[1:, None, None], past_y=N[:, None, None])


def adapted(drawn, rng, steps, R_theta):
    """What RCAC comes to with white noise at the input."""
    target = drawn.target()
    settings = rn.ControllerSettings(
        structure=rn.iir(drawn.n_c), target=target, update=rn.UD(R_theta), k_w=60
    )
    w = rng.standard_normal((steps, 1))
    with np.errstate(all="ignore"):
        return rn.simulate(drawn.plant, settings, w)


def matching(seed):
    """A loop that has the poles asked for: placed exactly, with rounding or 1e-9 in it, or by RCAC.

    None where this draw has none.
    """
    rng = np.random.default_rng([45, seed])
    kind = seed % 5
    for _ in range(200):
        drawn = Drawn(rng)
        try:
            if kind == 4:
                run = adapted(drawn, rng, 1500, 10.0 ** rng.uniform(-8, -3))
                words, compensator = "RCAC", run.compensator
                if run.outcome != "completed":
                    continue
            else:
                run, change = None, (0.0, 1e-9)[kind % 2]
                words = f"placed, {change:g}"
                compensator = compensator_of(*drawn.placing(), rng, change)
        except CompensatorError:
            continue
        if drawn.difference(compensator) < SAME:
            return Loop(f"{words}: {drawn.delay} steps", drawn.plant, drawn.target(), compensator,
                        True, run)  # fmt: skip
    return None


def missing(seed):
    """A loop that has not: a pole moved by 0.06 to 0.3, another controller, RCAC too early."""
    rng = np.random.default_rng([46, seed])
    kind = seed % 4
    for _ in range(200):
        drawn, run = Drawn(rng), None
        try:
            if kind == 0:
                moved = list(drawn.requested)
                if isinstance(moved[0], Pair):
                    moved[0] = Pair(moved[0].real, moved[0].imag + decimal(rng, 0.06, 0.3))
                    if moved[0].real ** 2 + moved[0].imag ** 2 > Fraction(9, 10):
                        continue
                else:
                    moved[0] += rng.choice([-1, 1]) * decimal(rng, 0.06, 0.3)
                    if abs(moved[0]) > Fraction(95, 100) or 0 in moved:
                        continue
                words, compensator = "a pole moved", compensator_of(*drawn.placing(moved))
            elif kind == 1:
                N_c, D_c = drawn.placing()
                words, compensator = "another controller", compensator_of(N_c, D_c, rng, 0.2)
            elif kind == 2:
                other = Drawn(rng)
                other.delay, other.poles, other.zeros = drawn.delay, drawn.poles, drawn.zeros
                other.requested, other.n_c = drawn.requested, drawn.n_c
                words, compensator = "the gain of another plant", compensator_of(*other.placing())
            else:
                run = adapted(drawn, rng, int(rng.integers(80, 200)), 10.0 ** rng.uniform(-1, 3))
                words, compensator = "RCAC too early", run.compensator
                if run.outcome != "completed":
                    continue
        except InputError:
            continue
        except CompensatorError:
            continue
        if kind and not drawn.difference(compensator) > VISIBLE:
            continue
        return Loop(f"{words}: {drawn.delay} steps", drawn.plant, drawn.target(), compensator,
                    False, run)  # fmt: skip
    return None


def delayed_run(R_theta=1e-6, steps=2000):
    """RCAC with five steps of dead time, whose target has five poles at 0 and one at 1/2."""
    plant = rn.standard_plant("1/(q**5*(q - 1/2))")
    settings = rn.ControllerSettings(
        structure=rn.iir(6),
        target=rn.pole_placement_target(plant, ["1/2"]),
        update=rn.UD(R_theta),
        k_w=60,
    )
    return rn.simulate(plant, settings, np.random.default_rng(0).standard_normal((steps, 1)))
