"""Parity interlacing: against the count of poles between zeros, and against drawn stabilisers."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import (
    InputError,
    certified_roots,
    decide_hurwitz,
    decide_strong_stabilisability,
    place_poles,
    polynomial,
    transfer_function,
)
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
    assert decide_strong_stabilisability(plant).is_strongly_stabilisable is answer


def test_the_stabilisers_of_the_known_plants():
    """What the two textbook plants are stabilised by: the second compensator has the pole 9."""
    stable = place_poles("(s - 2)/(s**2 - 1)", [-1, -1, -1], feedback=-1).compensator
    assert stable == transfer_function("-4*(s + 1)/(s + 7)")
    unstable = place_poles("(s - 1)/(s*(s - 2))", [-1, -1, -1], feedback=-1).compensator
    assert unstable.denominator == polynomial("s - 9")
    assert "between the zeros 1 and infinity" in str(
        decide_strong_stabilisability("(s - 1)/(s*(s - 2))")
    )


def counted(G):
    """Youla's words: an even number of real poles between each pair of unstable real zeros."""
    zeros = sorted(r.value.real for r in certified_roots(G.numerator) if r.is_real)
    zeros = [x for x in zeros if x >= 0] + [np.inf]
    poles = [
        r.value.real
        for r in certified_roots(G.denominator)
        if r.is_real
        for _ in range(r.multiplicity)
    ]
    return all(sum(low < pole < high for pole in poles) % 2 == 0 for low, high in pairwise(zeros))


@given(st.lists(rationals(), max_size=3), st.lists(rationals(), min_size=1, max_size=4))
def test_parity_is_that_of_the_poles_between(zeros, poles):
    assume(len(zeros) < len(poles) and not set(zeros) & set(poles))
    G = transfer_function(zeros=zeros, poles=poles, variable="s")
    assert decide_strong_stabilisability(G).is_strongly_stabilisable == counted(G)


@st.composite
def with_a_pole_between_zeros(draw):
    """Zeros at 0 < z_1 (and perhaps z_2, else infinity), and one real pole between them."""
    first, gap, further = (draw(rationals().map(lambda x: abs(x) + 1)) for _ in range(3))
    zeros, poles = [first], [first + gap, -draw(st.integers(1, 5))]
    if draw(st.booleans()):
        zeros, poles = [first, first + gap + further], [*poles, -draw(st.integers(6, 9))]
    return transfer_function(zeros=zeros, poles=poles, variable="s")


@given(with_a_pole_between_zeros(), st.data())
def test_every_stabiliser_has_the_poles_that_are_told(G, data):
    """Compensators that place a stable spectrum, whatever it is, have a pole in each interval."""
    found = decide_strong_stabilisability(G)
    assert found.pole_intervals
    n_c = data.draw(st.integers(G.order - 1, G.order))
    roots = data.draw(hurwitz_spectra(G.order + n_c))
    compensator = place_poles(G, roots, feedback=-1).compensator
    poles = [r.value.real for r in certified_roots(compensator.denominator) if r.is_real]
    for low, high in found.pole_intervals:
        end = np.inf if high.place is None else float(high.place)
        assert any(float(low.place) < pole < end for pole in poles)
    assert not decide_hurwitz(compensator.denominator).is_stable


def test_what_is_refused():
    for text, why in (
        ("0/(s + 1)", "the plant 0"),
        ("s**2/(s + 1)", "improper"),
        ("1/(s + a)", "not all rational numbers"),
        ("1/(x + 1)", "continuous time"),
    ):
        with pytest.raises(InputError, match=why):
            decide_strong_stabilisability(text)
    hidden = decide_strong_stabilisability("(s - 1)/((s - 1)*(s + 1))")
    assert not hidden.is_strongly_stabilisable and "hidden mode" in str(hidden)
