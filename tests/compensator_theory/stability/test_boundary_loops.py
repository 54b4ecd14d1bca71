"""Loops with roots on the boundary, hidden ones, constants, and pairs that are not well posed."""

import pytest
from hypothesis import example, given, settings
from sympy import oo

import compensator_theory as exact
from compensator_theory import (
    root_locus,
    stabilising_gains,
    stability_margins,
    transfer_function,
)
from compensator_theory.errors import BudgetError, ImproperError
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.strategies import boundary_loops
from tests.support.boundary_loops import contradictions


def pair(G, G_c, variable):
    return transfer_function(G, variable), transfer_function(G_c, variable)


@settings(max_examples=12)
@given(boundary_loops("s"))
@example(pair("100/((s**2+1)*(s+1))", "(s**2+1)/(s+5)**2", "s"))
@example(pair("100/((s**2+2)*(s+1))", "(s**2+2)/(s+5)**2", "s"))
@example(pair("-(s+1)/(s+2)", "1", "s"))
@example(pair("-(s+1)/(s+1)", "1", "s"))
@example(pair(("-2*(s+1)", "s+1"), "1", "s"))
@example(pair("0/(s+1)", "1", "s"))
def test_no_two_answers_about_a_continuous_loop_contradict(loop):
    assert contradictions(*loop) == []


@settings(max_examples=8)
@given(boundary_loops("z"))
@example(pair("1/(z*(z**2-6*z/5+1))", "2*(z**2-6*z/5+1)/z**2", "z"))
@example(pair("(3/5 - z)/(z - 1/2)", "1", "z"))
@example(pair("2*(z - 1)/((z - 1)*z)", "1", "z"))
def test_no_two_answers_about_a_discrete_loop_contradict(loop):
    assert contradictions(*loop) == []


def test_a_notch_on_an_undamped_mode_hides_it():
    margins = stability_margins("100/((s**2+2)*(s+1))", "(s**2+2)/(s+5)**2", feedback=-1)
    bare = stability_margins("100/(s+1)", "1/(s+5)**2", feedback=-1)
    assert margins.hidden.as_expr().as_poly() == exact.polynomial("s**2 + 2").as_expr().as_poly()
    assert margins.gain_crossovers == bare.gain_crossovers
    assert margins.phase_crossovers == bare.phase_crossovers
    assert margins.closed_loop.boundary == 2 and not margins.is_stable and margins.gains is None
    assert bare.is_stable


def test_a_crossover_where_the_loop_is_one_or_minus_one():
    """L = 2 (1 - s)/(s + 1)^2 + ... is 1 at +-j for (1 - s^2 + ...): decided by division."""
    # D = (s + 1)^3 and N = D - (s^2 + 1): L = 1 at j; N = (s^2 + 1) (s + 3) - D: L = -1 there
    one = stability_margins("((s + 1)**3 - (s**2 + 1))/(s + 1)**3", feedback=-1)
    assert [abs(float(c.degrees)) for c in one.gain_crossovers if c.square == 1] == [180]
    other = stability_margins("((s**2 + 1)*(s + 3) - (s + 1)**3)/(s + 1)**3", feedback=-1)
    assert next(c.delay for c in other.gain_crossovers if c.square == 1).centre == 0
    assert other.closed_loop.boundary == 2


def test_an_ill_posed_loop_is_not_stable_and_says_so():
    margins = stability_margins("-(s+1)/(s+2)", feedback=-1)
    assert (margins.is_stable, margins.is_well_posed, margins.delay) == (False, False, None)
    assert str(margins).startswith("the loop is not well posed: 1 + L = 0 at infinity")
    assert 1 not in root_locus("-(s+1)/(s+2)", feedback=-1).stable
    assert 1 not in stabilising_gains("-(s+1)/(s+2)", feedback=-1)
    with pytest.raises(ImproperError, match="L = -1 at all frequencies"):
        stability_margins("-1", feedback=-1, variable="s")


def test_what_is_said_of_a_real_loop_holds():
    constant = stability_margins(("-2*(s+1)", "s+1"), feedback=-1, variable="s")
    assert "comes with" not in str(constant) and "the constant -2" in str(constant)
    assert constant.is_stable and constant.gains.upper == oo
    even = stability_margins("1/s**2", feedback=-1)
    assert "a pole s comes with -s" in str(even) and not even.is_stable


def test_a_question_that_no_ball_answers_ends_in_an_error_of_ours():
    with pytest.raises(BudgetError, match="needs balls of more than 262144 bits"):
        at_growing_precision(lambda bits: None, 64, "the sign of zero")
