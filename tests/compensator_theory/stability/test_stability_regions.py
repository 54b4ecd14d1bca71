"""Regions of stability against floating roots at drawn places, and regions known by hand."""

import functools

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational

from compensator_theory import stabilising_gains, stability_region
from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.results import StabilityRegion
from tests.support.structure_cases import fewer

REGIONS = ["s*(s + 1)**3 + a*s + b", "s**3 + a*s**2 + b*s + 1", "s**2 + (a*b - 1)*s + a - b",
           "s**3 + s**2 + a*s + b*a", "z**2 + a*z + b", "z**3 - z/2 + a*z + b", "s + a*b",
           "s**4 + 2*s**3 + (a + 2)*s**2 + b*s + a**2"]  # fmt: skip
REGION_OF = {text: stability_region(text, "a", "b") for text in REGIONS}


@given(st.sampled_from(REGIONS), st.data())
def test_drawn_pairs_lie_inside_or_outside(text, data):
    result = REGION_OF[text]
    p, q = (Rational(data.draw(st.integers(-40, 60)), data.draw(st.integers(1, 8))) for _ in "pq")
    there = [
        complex(c.subs({"a": p, "b": q}))
        for c in map(sympy.sympify, result.polynomial.all_coeffs())
    ]
    roots = np.roots(there)
    size = max(abs(roots) - 1) if result.polynomial.gen.name == "z" else max(roots.real)
    assume(abs(size) > 1e-7)
    assert ((p, q) in result) == (size < 0)


@given(st.sampled_from(REGIONS), st.data())
@fewer(2)
def test_a_slab_looks_the_same_everywhere(text, data):
    """As many stable intervals at any other place of a slab."""
    slab = data.draw(st.sampled_from(REGION_OF[text].slabs))
    share = Rational(data.draw(st.integers(1, 9)), 10)
    ends = [
        slab.sample - 5
        if e == -sympy.oo
        else slab.sample + 5
        if e == sympy.oo
        else Rational(str(sympy.N(e, 30)))
        for e in (slab.lower, slab.upper)
    ]
    place = ends[0] + share * (ends[1] - ends[0])
    assert len(REGION_OF[text].section(place).intervals) == len(slab.section.intervals)


def test_regions_of_the_notes():
    region = stability_region("(s + 1)**3*s + k_p*s + k_i", "k_p", "k_i")
    for p in (Rational(0), Rational(3), Rational(15, 2)):
        (cell,) = region.section(p).intervals
        assert (cell.lower, cell.upper) == (0, (8 - p) * (1 + p) / 9)
    assert not region.is_empty and stability_region("s**2 - s + a + b", "a", "b").is_empty


# Stable PID gains, a plant with a gain and a time constant, a loop in z; several orders of cutting.
MANY = [
    ("s**2*(s + 1) + c*s**2 + a*s + b", "c", "a", "b"),
    ("s*(s + 1)**3 + c*s**2 + a*s + b", "a", "b", "c"),
    ("s*(s + 1)**2*(s + 2) + (1 - s)*(c*s**2 + a*s + b)", "c", "a", "b"),
    ("z*(z - 1)*(z - 1/2) + c*z**2 + a*z + b", "c", "a", "b"),
    ("s*(b*s + 1)*(s + 1) + c*a", "b", "a", "c"),
    ("s**3 + a*s**2 + b*s + c*d", "a", "b", "c", "d"),
]


@functools.cache
def cells_of(row):
    return stability_region(*row)


def in_its_formulas(region, values):
    """Whether values lie in a stable cell, by the printed ends alone; None on an edge."""
    place = {}
    while True:
        first, *rest = region.parameters
        place[first] = values[first.name]
        for slab in region.slabs:
            low, high = (float(sympy.sympify(end).subs(place)) for end in slab.range)
            if low < place[first] < high:
                break
        else:
            return None
        if isinstance(slab.section, StabilityRegion):
            region = slab.section
            continue
        last = values[rest[0].name]
        cells = [[sympy.sympify(end).subs(place) for end in ends] for ends in slab.ends]
        return any(float(low) < last < float(high) for low, high in cells)


@pytest.mark.costly
@fewer(5)
@given(st.sampled_from(MANY), st.data())
def test_the_printed_cells_are_where_the_roots_are_stable(row, data):
    """Formulas hold in whole cells, not at their samples alone: projection, order, sign of root."""
    region = cells_of(row)
    place = {
        name: Rational(data.draw(st.integers(-60, 60)), data.draw(st.integers(3, 16)))
        for name in row[1:]
    }
    there = [sympy.sympify(c).subs(place) for c in region.polynomial.all_coeffs()]
    roots = np.roots([float(c) for c in there])
    size = max(abs(roots) - 1) if region.polynomial.gen.name == "z" else max(roots.real)
    assume(abs(size) > 1e-6 and there[0] != 0)
    result = in_its_formulas(region, place)
    assume(result is not None)
    assert result == (size < 0)
    assert (tuple(place[k.name] for k in region.parameters) in region) == (size < 0)


@pytest.mark.costly
def test_a_plant_of_order_five_under_pid():
    """Curves of degree three and more have no formulas: the ends are those at the samples."""
    plant = "s*(s**5 + 8*s**4 + 32*s**3 + 46*s**2 + 46*s + 17)"
    region = stability_region(
        f"{plant} + (s**3 - 4*s**2 + s + 2)*(k_d*s**2 + k_p*s + k_i)", "k_p", "k_i", "k_d"
    )
    assert "for instance" in str(region) and not region.is_empty
    for slab in region.slabs:
        inner = slab.section
        for cell in inner.slabs:
            k_d = [one.sample for one in cell.section.cells]
            for value, one in zip(k_d, cell.section.cells, strict=True):
                there = [
                    float(
                        sympy.sympify(c).subs(
                            {"k_p": slab.sample, "k_i": cell.sample, "k_d": value}
                        )
                    )
                    for c in region.polynomial.all_coeffs()
                ]
                assert one.is_stable == (np.roots(there).real.max() < 0)


def test_gains_of_a_plant_with_symbols():
    """Routh: s (s + 1) (s + a) + k is stable where a > 0 and 0 < k < a (a + 1)."""
    gains = stabilising_gains("1/(s*(s + 1)*(s + a))", feedback=-1)
    assert str(gains) == "a in (0, oo): k in (0, a**2 + a)"
    assert (2, 5) in gains and (2, 6) not in gains and (-1, 1) not in gains
    lag = stabilising_gains("b/(T*s + 1)", feedback=-1)
    assert str(lag.section(2)) == "b in (-oo, 0): k in (-oo, -1/b)\nb in (0, oo): k in (-1/b, oo)"
    assert (2, 3, 1) in lag and (-2, 3, 1) not in lag


def test_where_the_degree_drops_a_loop_is_not_well_posed():
    gains = stabilising_gains("(s + a)/(s + 2)", feedback=-1)
    assert (1, -1) not in gains  # 1 + k G(oo) = 0, and 2 - a is what is left
    polynomials = stability_region("(k + 1)*s + 2 + a*k", "a", "k")
    assert (1, -1) in polynomials and (2, -1) not in polynomials  # 1 has no root, 0 has every one
    drops = stability_region("k*s**2 + a*s + 1", "a", "k")
    assert (1, 0) in drops


def test_a_section_takes_one_parameter_away():
    region = cells_of(MANY[-1])
    there = region.section(1).section(2)
    assert [str(k) for k in there.parameters] == ["c", "d"]
    assert str(there) == "c in (-oo, 0): d in (2/c, 0)\nc in (0, oo): d in (0, 2/c)"


@pytest.mark.costly
@pytest.mark.parametrize(
    "call",
    [
        lambda: stability_region("s + p", "p", "p"),
        lambda: stability_region("s + c + a", "a", "b"),
        lambda: stability_region([0], "a", "b"),
        lambda: stability_region("s**2 + a", "a", "b"),
        lambda: stability_region("x + a", "a", "b"),
        lambda: stability_region("s + 1/a", "a", "b"),
        lambda: stability_region("s + a", "s", "b"),
        lambda: stability_region("s**900 + a + b", "a", "b"),
        lambda: stability_region("s**40 + a*s**3 + b*s + c", "a", "b", "c"),
        lambda: stability_region("s + a + b", "a", "b", "a"),
        # Its projection would take minutes: refused by the size of a resultant, before it is made.
        lambda: stability_region(
            "s**6 + (a + b + c)*s**5 + (a*b + c**2 + 1)*s**4 + (a**2 + b*c + 3)*s**3"
            " + (a + b**2 + c)*s**2 + (a*c + b)*s + a*b*c + 1",
            "a",
            "b",
            "c",
        ),
        lambda: stabilising_gains("1/(s + sqrt(2)*a)", feedback=-1),
        lambda: stabilising_gains("1/(s + 1/a**k)", feedback=-1),
    ],
)
def test_bad_input(call):
    with pytest.raises(CompensatorError):
        call()


def test_a_region_is_asked_for_as_many_values_as_it_has_parameters():
    with pytest.raises(InputError, match="each of c, a, b"):
        assert (1, 2) in cells_of(MANY[0])
