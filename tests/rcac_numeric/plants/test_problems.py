"""The servo problem of a row of transfer functions, against the entries themselves."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Poly, symbols

import rcac_numeric as rn
from compensator_theory import InputError, transfer_function
from compensator_theory.errors import ImproperError, NotCoprimeError

q = symbols("q")
roots = st.lists(st.integers(-4, 4), min_size=1, max_size=3)


@settings(max_examples=30)
@given(st.lists(st.tuples(roots, st.integers(1, 5), st.integers(-3, 3)), min_size=2, max_size=3))
def test_a_row_has_its_entries_between_u_and_y(rows):
    entries = [
        transfer_function((Poly(gain * (q - zero) ** (len(poles) - 1), q),
                           Poly.from_list([1], q) * _monic(poles)))
        for poles, gain, zero in rows
    ]  # fmt: skip
    try:
        plant = rn.servo_plant([list(entries)])
    except NotCoprimeError:
        shared = entries[0].denominator
        for entry in entries[1:]:
            shared = shared.lcm(entry.denominator)
        common = shared
        for entry in entries:
            common = common.gcd(entry.numerator * shared.quo(entry.denominator))
        assert common.degree() > 0
        return
    problem = plant.problem
    maps = problem.G_yu
    for i, entry in enumerate(entries):
        result = maps[0, i]
        assert result.numerator * entry.denominator == -entry.numerator * result.denominator
    assert plant.blocks == {"r": 1, "d": len(entries), "v": 1}
    assert problem.D_1[:, 1 : 1 + len(entries)] == problem.B


def _monic(poles):
    product = Poly(1, q)
    for pole in poles:
        product *= Poly(q - pole, q)
    return product


def test_a_scalar_system_of_another_library_is_its_transfer_function():
    """In the coordinates of the transfer function, whatever it was given in."""
    written = rn.servo_plant("(q - 1/4)/(q**2 - 5/4*q + 3/8)")
    read = rn.servo_plant(control.tf([1, -0.25], [1, -1.25, 0.375], 1.0))
    assert read.blocks == written.blocks and read.sample_time == 1.0
    for name in ("A", "B", "C", "D_1"):
        assert np.array_equal(getattr(read, name), getattr(written, name))


def test_one_entry_is_the_transfer_function():
    """A row of one is the plant itself, in observer canonical form."""
    one, row = (
        rn.servo_plant("(q - 3)/((q - 1)*(q - 2))"),
        rn.servo_plant([["(q - 3)/((q - 1)*(q - 2))"]]),
    )
    assert str(one.problem.G_yu[0, 0]) == str(row.problem.G_yu[0, 0])


def test_a_factor_of_one_entry_alone_is_no_hidden_mode():
    """As q = 0.975 in (6.7), which cancels in the second entry and not in the first."""
    plant = rn.servo_plant([["(q - 1)/((q - 1)*(q - 2))", "1/((q - 1)*(q - 3))"]])
    assert plant.n == 3


@pytest.mark.parametrize(
    ("row", "error", "message"),
    [
        (["(q - 1)/((q - 1)*(q - 2))", "(q - 1)/((q - 1)*(q - 3))"], NotCoprimeError, "q - 1"),
        (["q/(q - 2)", "1/q"], ImproperError, "not strictly proper"),
        (["1/(q - 2)", "1/s"], InputError, "different variables"),
    ],
)
def test_rows_that_are_refused(row, error, message):
    with pytest.raises(error, match=message):
        rn.servo_plant([row])


@pytest.mark.parametrize("make", [rn.standard_plant, rn.servo_plant])
def test_z_is_the_same_as_q(make):
    """A plant in z meets compensators and target models, which are in q."""
    in_z, in_q = (
        make("(z - 1/2)/((z - 9/10)*(z - 7/10))"),
        make("(q - 1/2)/((q - 9/10)*(q - 7/10))"),
    )
    assert in_z == in_q and in_z.problem == in_q.problem
    target = rn.pole_placement_target(in_z, ["1/2", "1/3"])
    compensator = rn.Compensator(past_u=[[[-1.25]]], past_y=[[[0.0]], [[-2.625]]])
    compared = [rn.compare_exactly(plant, compensator, target) for plant in (in_z, in_q)]
    assert compared[0].reached == compared[1].reached
