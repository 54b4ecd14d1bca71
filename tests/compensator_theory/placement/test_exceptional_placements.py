"""Where a symbolic placement holds: against the placement with values put in first."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational

from compensator_theory import place_poles, polynomial, resultant, transfer_function
from compensator_theory.errors import NoSolutionError, NotCoprimeError

s, a, t0, t1, t2 = sympy.symbols("s a t0 t1 t2")
PLANT = "(s - a)/((s - 1)*(s - 2))"
TARGET = "s**3 + t2*s**2 + t1*s + t0"
PLACEMENT = place_poles(
    transfer_function(PLANT, "s"), polynomial=polynomial(TARGET, "s"), feedback=-1, n_c=1
)
RATIONAL = st.integers(-9, 9).map(lambda k: Rational(k, 2))


def test_the_exceptional_set_of_the_notes():
    assert set(PLACEMENT.exceptional) == {a - 1, a - 2}
    expected = (a**2 * (t2 + 3) + a * (t1 - 2) + t0) / ((a - 1) * (a - 2))
    assert sympy.cancel(PLACEMENT.denominator.eval(0) - expected) == 0


@given(st.fixed_dictionaries(dict.fromkeys((a, t0, t1, t2), RATIONAL)))
def test_the_answer_holds_off_the_set_and_branches_on_it(values):
    plant = transfer_function(PLANT, "s").subs({"a": values[a]})
    target = polynomial(sympy.sympify(TARGET).subs(values), "s")
    if any(factor.subs(values) == 0 for factor in PLACEMENT.exceptional):
        if target.eval(values[a]) != 0:  # the hidden mode is no root of the target
            with pytest.raises(NotCoprimeError):
                place_poles(plant, polynomial=target, feedback=-1, n_c=1)
        else:  # a line of compensators
            try:
                family = place_poles(plant, polynomial=target, feedback=-1, n_c=1)
            except NoSolutionError:
                return
            assert len(family.homogeneous) == 1 and family.residual.is_zero
        return
    there = place_poles(plant, polynomial=target, feedback=-1, n_c=1)
    assert there.is_unique
    for one, other in (
        (PLACEMENT.numerator, there.numerator),
        (PLACEMENT.denominator, there.denominator),
    ):
        assert sympy.expand(one.as_expr().subs(values) - other.as_expr()) == 0


def test_everything_symbolic(in_full):
    """The general compensator of order n - 1; what it divides by is the resultant."""
    n = 4 if in_full else 3
    N = sum(sympy.Symbol(f"b{i}") * s**i for i in range(n))
    D = s**n + sum(sympy.Symbol(f"a{i}") * s**i for i in range(n))
    T = s ** (2 * n - 1) + sum(sympy.Symbol(f"t{i}") * s**i for i in range(2 * n - 1))
    plant, target = transfer_function((N, D), "s"), polynomial(T, "s")
    placement = place_poles(plant, polynomial=target, feedback=-1, n_c=n - 1)
    (factor,) = placement.exceptional
    full = resultant(plant.numerator, plant.denominator)
    assert sympy.expand(factor - full) == 0 or sympy.expand(factor + full) == 0
    values = {
        x: Rational(7 * i * i % 23 - 11, i % 3 + 1)
        for i, x in enumerate(sorted(full.free_symbols | T.free_symbols - {s}, key=str))
    }
    top, bottom = (
        p.as_expr().xreplace(values) for p in (placement.numerator, placement.denominator)
    )
    assert (
        sympy.expand(D.xreplace(values) * bottom + N.xreplace(values) * top - T.xreplace(values))
        == 0
    )


def test_numbers_have_no_exceptional_set():
    assert place_poles("1/(s - 1)", [-1, -2], feedback=-1).exceptional == ()
    assert place_poles("0/(s + 1)", [-1], feedback=-1).exceptional == ()
    assert place_poles(transfer_function("2", "s"), [-1], feedback=-1).exceptional == ()
