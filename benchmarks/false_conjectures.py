"""How many examples the public strategies need to refute thirteen false conjectures.

Textbooks warn of each. ``python benchmarks/false_conjectures.py [SEEDS]`` draws with each of 20
seeds until the conjecture fails, without shrinking, and prints the median, the worst, and how often
500 examples did not do.
"""

import statistics
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Matrix, Poly, Symbol, eye

from compensator_theory import decide_stability, place_poles, polynomial_from_roots
from compensator_theory import strategies as ours
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.observers import realisation_is_observer_based

LIMIT = 500
s = Symbol("s")


@dataclass(frozen=True)
class Conjecture:
    """A sentence that is false, what its cases are drawn from, and whether it holds of one."""

    sentence: str
    cases: st.SearchStrategy[Any]
    holds: Callable[[Any], bool]


def sees_all(A: Matrix, C: Matrix) -> bool:
    """Whether (A, C) is observable."""
    return rank(ImmutableMatrix.vstack(*(C * A**k for k in range(A.rows)))) == A.rows


def hurwitz(A: Matrix) -> bool:
    """Whether every eigenvalue has a negative real part."""
    return decide_stability(characteristic_polynomial(A, s)).is_stable is True


def schur(A: Matrix) -> bool:
    """Whether every eigenvalue has modulus below 1."""
    return decide_stability(characteristic_polynomial(A, Symbol("z"))).is_stable is True


def semidefinite(M: Matrix) -> bool:
    """Whether a symmetric matrix is, by the signs of its characteristic polynomial."""
    descending = characteristic_polynomial(Matrix(M), s).all_coeffs()
    return all((-1) ** i * coefficient >= 0 for i, coefficient in enumerate(descending))


def leading_minors(M: Matrix) -> list[Any]:
    """The leading principal minors."""
    return [M[:k, :k].det() for k in range(1, M.rows + 1)]


def simple(p: Poly) -> bool:
    """Whether no root is multiple."""
    return p.gcd(p.diff()).degree() == 0


positive = st.lists(st.integers(1, 9), min_size=4, max_size=5)


@st.composite
def placements(draw: st.DrawFn) -> Any:
    """A plant and the compensator that places twice its order of poles."""
    plant = draw(ours.strictly_proper_plants(max_order=3))
    target = polynomial_from_roots(draw(ours.spectra(2 * plant.order)), "s")
    return place_poles(plant, target, feedback=-1).compensator


CONJECTURES = (
    Conjecture(
        "Observability survives state feedback",
        ours.plants_with_gain(),
        lambda c: sees_all(c[0].A + c[0].B * c[1], c[0].C),
    ),
    Conjecture(
        "A polynomial with positive coefficients is Hurwitz",
        positive,
        lambda c: decide_stability(Poly(c, s), time="continuous").is_stable is True,
    ),
    Conjecture(
        "The sum of two Hurwitz matrices is Hurwitz",
        st.tuples(ours.hurwitz_matrices(2), ours.hurwitz_matrices(2)),
        lambda c: hurwitz(c[0] + c[1]),
    ),
    Conjecture(
        "The product of two Schur matrices is Schur: switching between stable loops is stable",
        st.tuples(ours.schur_matrices(2), ours.schur_matrices(2)),
        lambda c: schur(c[0] * c[1]),
    ),
    Conjecture(
        "A Schur matrix shortens every vector in one step: I - A'A >= 0",
        ours.schur_matrices(2),
        lambda A: semidefinite(eye(2) - A.T * A),
    ),
    Conjecture(
        "A + A' <= 0 for a Hurwitz matrix: its states never grow",
        ours.hurwitz_matrices(2),
        lambda A: semidefinite(-A - A.T),
    ),
    Conjecture(
        "A symmetric matrix with nonnegative leading minors is semidefinite",
        ours.symmetric_matrices(3, elements=st.integers(-1, 1)).filter(
            lambda M: min(leading_minors(M)) >= 0
        ),
        semidefinite,
    ),
    Conjecture(
        "The symmetric part of the product of two semidefinite matrices is semidefinite",
        st.tuples(ours.semidefinite_matrices(2), ours.semidefinite_matrices(2)),
        lambda c: semidefinite(c[0] * c[1] + c[1] * c[0]),
    ),
    Conjecture(
        "Two minimal systems in series are minimal",
        ours.plants_and_compensators(),
        lambda c: (
            (c[0].numerator * c[1].numerator).gcd(c[0].denominator * c[1].denominator).degree() == 0
        ),
    ),
    Conjecture(
        "Two minimal systems in parallel are minimal",
        ours.plants_with_common_factor(),
        lambda c: c[0].denominator.gcd(c[1].denominator).degree() == 0,
    ),
    Conjecture(
        "The poles of a minimal plant are simple, so that A is diagonalisable",
        ours.minimal_plants(3),
        lambda c: simple(c.characteristic_polynomial),
    ),
    Conjecture(
        "A compensator of the order 3 of the plant is observer-based",
        ours.loops_with_spectrum(3),
        lambda c: realisation_is_observer_based(*c).answer,
    ),
    Conjecture(
        "The compensator that places the poles is coprime",
        placements(),
        lambda c: c.is_coprime,
    ),
)


def examples_until_refuted(conjecture: Conjecture, number: int) -> int:
    """Draw until the conjecture fails; LIMIT + 1 where it does not."""
    drawn = 0

    @seed(number)
    @settings(
        max_examples=LIMIT, database=None, deadline=None, phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck), report_multiple_bugs=False,
    )  # fmt: skip
    @given(conjecture.cases)
    def search(case: Any) -> None:
        nonlocal drawn
        drawn += 1
        assert conjecture.holds(case)

    try:
        search()
    except AssertionError:
        return drawn
    return LIMIT + 1


def main(seeds: int) -> None:
    """Print one line for each conjecture."""
    print(f"examples until it is refuted, {seeds} seeds: median, worst, not within {LIMIT}")
    for conjecture in CONJECTURES:
        counts = [examples_until_refuted(conjecture, number) for number in range(seeds)]
        missed = sum(count > LIMIT for count in counts)
        median = statistics.median(counts)
        print(f"{median:7.1f} {max(counts):5d} {missed:3d}  {conjecture.sentence}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
