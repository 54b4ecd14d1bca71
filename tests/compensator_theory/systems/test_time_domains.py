"""What depends on time says so, or asks: matrices alone show none, and coefficients no variable."""

import pytest

import compensator_theory as exact
from compensator_theory import InputError

BARE = ([["-1/2"]], [[1]], [[1]])


def test_bare_matrices_are_asked_for_their_time():
    for ask in (
        lambda variable: exact.gramians(BARE, variable),
        lambda variable: exact.doubly_coprime_fractions(
            BARE, ["-1/3"], ["-1/4"], variable=variable
        ),
        lambda variable: exact.stabilising_compensators(
            BARE, ["-1/3"], ["-1/4"], variable=variable, feedback=1
        ),
    ):
        with pytest.raises(InputError, match="write variable='s'"):
            ask(None)
        assert ask("s") != ask("z")


def test_the_answer_depends_on_the_time():
    assert exact.gramians(BARE, "s").norm_squared == 1
    assert exact.gramians(BARE, "z").norm_squared == exact.gramians(BARE, "q").norm_squared != 1


@pytest.mark.parametrize(
    ("function", "options"),
    [
        (exact.count_roots, {"time": "discrete"}),
        (exact.locate_roots, {"time": "discrete"}),
        (exact.decide_stability, {"time": "discrete"}),
        (exact.roots.number_of_real_roots, {}),
        (exact.certified_roots, {}),
        (exact.roots.hurwitz_determinants, {}),
        (exact.stability_conditions, {}),
        (exact.roots.reflection_coefficients, {}),
        (exact.roots.split_at_unit_circle, {}),
        (exact.roots.enclose_split_at_unit_circle, {}),
        (exact.roots.reciprocal_polynomial, {}),
        (exact.roots.monic_reciprocal_polynomial, {}),
    ],
)
def test_the_advice_about_variables_works(function, options):
    """A list of coefficients and variable='q' is the polynomial in q."""
    text = "4*q**2 - q + 2"
    assert function([4, -1, 2], variable="q", **options) == function(text, **options)
    if not options and function is not exact.roots.reflection_coefficients:
        with pytest.raises(InputError, match=r"as in polynomial\(..., 's'\)"):
            function([4, -1, 2])
        assert function(exact.polynomial([4, -1, 2], "q")) == function(text)
    else:
        function([4, -1, 2], **options)


def test_variables_of_loops():
    placement = exact.place_poles("1/(s + a)", [-1, -2], feedback=-1, variable="s")
    assert placement.plant.variable.name == "s"
    least = exact.place_poles("a/(s + 1)", [-2], "least", feedback=-1, variable="s")
    assert least.compensator.order == 0
    with pytest.raises(InputError, match="not in z"):
        exact.stabilising_gains(exact.transfer_function("1/s"), feedback=-1, variable="z")
