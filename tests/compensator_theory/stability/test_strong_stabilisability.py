"""Parity interlacing: against the count of poles between zeros, and against drawn stabilisers."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sympy import Matrix, Symbol, eye

import compensator_theory as ct
from compensator_theory.strategies import hurwitz_spectra, rationals


@pytest.mark.parametrize(
    ("plant", "answer"),
    [
        ("(s - 2)/(s**2 - 1)", True),
        ("(s - 1)/(s*(s - 2))", False),
        ("(z - 6/5)/((z - 3/2)*(z - 1/2))", False),
        ("1/(s - 1)", True),
        ("s/(s - 1)", True),
        ("s/(s**2 - 1)", False),
        ("s/((s - 1)*(s - 2))", True),
        ("(s - 1)*(s - 3)/((s - 2)*(s + 1))", False),
        ("(z + 1)/((z + 2)*z)", False),
        ("(z**2 - 1)/((z + 2)*(z - 2)*z)", False),
        ("(z + 3)/((z + 2)*z)", True),
    ],
)
def test_known_plants(plant, answer):
    assert ct.decide_strong_stabilisability(plant).is_strongly_stabilisable is answer


def test_the_stabilisers_of_the_known_plants():
    """What the two textbook plants are stabilised by: the second compensator has the pole 9."""
    stable = ct.place_poles("(s - 2)/(s**2 - 1)", [-1, -1, -1], feedback=-1).compensator
    assert stable == ct.transfer_function("-4*(s + 1)/(s + 7)")
    unstable = ct.place_poles("(s - 1)/(s*(s - 2))", [-1, -1, -1], feedback=-1).compensator
    assert unstable.denominator == ct.polynomial("s - 9")
    assert "between the zeros 1 and infinity" in str(
        ct.decide_strong_stabilisability("(s - 1)/(s*(s - 2))")
    )


def counted(G):
    """Youla's words: an even number of real poles between each pair of unstable real zeros."""
    zeros = sorted(r.value.real for r in ct.certified_roots(G.numerator) if r.is_real)
    zeros = [x for x in zeros if x >= 0] + [np.inf]
    poles = [
        r.value.real
        for r in ct.certified_roots(G.denominator)
        if r.is_real
        for _ in range(r.multiplicity)
    ]
    return all(sum(low < pole < high for pole in poles) % 2 == 0 for low, high in pairwise(zeros))


@given(st.lists(rationals(), max_size=3), st.lists(rationals(), min_size=1, max_size=4))
def test_parity_is_that_of_the_poles_between(zeros, poles):
    assume(len(zeros) < len(poles) and not set(zeros) & set(poles))
    G = ct.transfer_function(zeros=zeros, poles=poles, variable="s")
    assert ct.decide_strong_stabilisability(G).is_strongly_stabilisable == counted(G)


@st.composite
def with_a_pole_between_zeros(draw):
    """Zeros at 0 < z_1 (and perhaps z_2, else infinity), and one real pole between them."""
    first, gap, further = (draw(rationals().map(lambda x: abs(x) + 1)) for _ in range(3))
    zeros, poles = [first], [first + gap, -draw(st.integers(1, 5))]
    if draw(st.booleans()):
        zeros, poles = [first, first + gap + further], [*poles, -draw(st.integers(6, 9))]
    return ct.transfer_function(zeros=zeros, poles=poles, variable="s")


@given(with_a_pole_between_zeros(), st.data())
def test_every_stabiliser_has_the_poles_that_are_told(G, data):
    """Compensators that place a stable spectrum, whatever it is, have a pole in each interval."""
    decision = ct.decide_strong_stabilisability(G)
    assert decision.pole_intervals
    n_c = data.draw(st.integers(G.order - 1, G.order))
    roots = data.draw(hurwitz_spectra(G.order + n_c))
    compensator = ct.place_poles(G, roots, feedback=-1).compensator
    poles = [r.value.real for r in ct.certified_roots(compensator.denominator) if r.is_real]
    for low, high in decision.pole_intervals:
        end = np.inf if high.place is None else float(high.place)
        assert any(float(low.place) < pole < end for pole in poles)
    assert not ct.decide_stability(compensator.denominator, time="continuous").is_stable


def test_what_is_refused():
    for text, why in (
        ("0/(s + 1)", "the plant is 0"),
        ("s**2/(s + 1)", "improper"),
        ("1/(s + a)", "not all rational numbers"),
        ("1/(x + 1)", "continuous time"),
    ):
        with pytest.raises(ct.InputError, match=why):
            ct.decide_strong_stabilisability(text)
    hidden = ct.decide_strong_stabilisability("(s - 1)/((s - 1)*(s + 1))")
    assert not hidden.is_strongly_stabilisable and "hidden mode" in str(hidden)


UNSTABLE = "(s - 1)/(s*(s - 2))"  # one pole between its zeros 1 and infinity


@pytest.mark.parametrize(
    ("plant", "answer"),
    [
        ([[UNSTABLE, 0], [0, UNSTABLE]], True),  # two poles between
        ([[UNSTABLE, 0, 0], [0, UNSTABLE, 0], [0, 0, UNSTABLE]], False),
        ([[UNSTABLE, "1/(s + 1)"]], True),  # 1 is no blocking zero
        ([[UNSTABLE, "(s - 1)/(s + 1)**2"]], False),
        ([[UNSTABLE], ["(s - 1)/(s - 2)"]], True),  # infinity is no blocking zero
        ([[UNSTABLE], ["(s - 1)/((s - 2)*(s + 1))"]], False),  # the pole 2 counts once
        ([["(z - 6/5)/(z - 3/2)**2", 0], [0, "(z - 6/5)/((z - 3/2)*z)"]], False),
    ],
)
def test_known_plants_with_several_signals(plant, answer):
    assert ct.decide_strong_stabilisability(plant).is_strongly_stabilisable is answer


def test_two_of_a_plant_that_needs_an_unstable_compensator_need_none():
    """The stable compensator n/d with d = s + 1 + 10j, n = (2 - 15j)s + 1 + 2j, written real."""
    s = Symbol("s")
    d = Matrix([[s + 1, -10], [10, s + 1]])
    n = Matrix([[2 * s + 1, 15 * s - 2], [-15 * s + 2, 2 * s + 1]])
    assert n * d == (d * n).expand() or (n * d - d * n).expand().is_zero_matrix
    assert ct.decide_stability(ct.polynomial(d.det()), time="continuous").is_stable
    loop = s * (s - 2) * d + (s - 1) * n  # D I and N I commute with everything
    assert ct.decide_stability(ct.polynomial(loop.det().expand()), time="continuous").is_stable
    assert not ct.decide_strong_stabilisability(UNSTABLE).is_strongly_stabilisable


@st.composite
def invertible(draw, size):
    """A product of triangles with ones, and its inverse."""
    entries = st.integers(-2, 2)
    lower = Matrix(size, size, lambda i, j: draw(entries) if i > j else int(i == j))
    upper = Matrix(size, size, lambda i, j: draw(entries) if i < j else int(i == j))
    return lower * upper


@given(st.data(), st.integers(1, 3), st.booleans())
def test_copies_of_a_plant_in_disguise(data, copies, discrete):
    """Of an even number the poles between are even; of an odd one they are as of the plant."""
    z = "z" if discrete else "s"
    reals = rationals()
    roots, poles = (data.draw(st.lists(reals, min_size=k, max_size=k + 1)) for k in (0, 1))
    assume(len(roots) < len(poles) and not set(roots) & set(poles))
    G = ct.transfer_function(zeros=roots, poles=poles, variable=z)
    left, right = (data.draw(invertible(copies)) for _ in range(2))
    rows = left * (G.as_expr() * eye(copies)) * right
    decision = ct.decide_strong_stabilisability(rows)
    alone = ct.decide_strong_stabilisability(G)
    assert decision.is_strongly_stabilisable == (copies % 2 == 0 or alone.is_strongly_stabilisable)


@pytest.mark.costly
@settings(max_examples=10)
@given(st.data())
def test_every_stabiliser_of_several_signals_has_the_poles_that_are_told(data):
    """Three copies, coupled by the regulator and observer that are drawn."""
    G = data.draw(with_a_pole_between_zeros())
    rows = [[str(G) if i == j else 0 for j in range(3)] for i in range(3)]
    (low, high), *_ = ct.decide_strong_stabilisability(rows).pole_intervals
    spectra = [data.draw(hurwitz_spectra(3 * G.order)) for _ in range(2)]
    compensator = ct.stabilising_compensators(rows, *spectra, feedback=-1).compensator()
    modes = ct.certified_roots(compensator.characteristic_polynomial)  # a stable loop hides none
    poles = [r.value.real for r in modes if r.is_real]
    end = np.inf if high.place is None else float(high.place)
    assert any(float(low.place) < pole < end for pole in poles)


def test_hidden_modes_of_several_signals():
    realisation = ct.Realisation([[1, 0], [0, 1]], [[1, 0], [0, 0]], [[1, 0], [0, 0]], variable="s")
    assert not ct.decide_strong_stabilisability(realisation).is_stabilisable
    rows = [["(s - 1)/((s - 1)*(s + 1))", 0], [0, "1/(s + 2)"]]
    assert not ct.decide_strong_stabilisability(rows).is_stabilisable
    twice = ct.Realisation(eye(2), eye(2), eye(2), variable="s")
    assert ct.decide_strong_stabilisability(twice).is_stabilisable
