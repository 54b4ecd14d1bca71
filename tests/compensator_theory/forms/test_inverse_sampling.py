"""Continuous plants from samples: sampled again by SciPy, logarithms by mpmath, and refusals."""

import mpmath
import numpy as np
import pytest
import scipy.signal
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Rational, log

import compensator_theory as exact
from compensator_theory import Realisation, realisation, transfer_function
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.sampling import (
    inverse_tustin,
    inverse_zero_order_hold,
    tustin,
    zero_order_hold,
)
from compensator_theory.strategies import matrices
from compensator_theory.strategies.plants import unimodular_matrices
from tests.support.structure_cases import fewer

BLOCKS = [
    [["1/2"]], [["2/3"]], [["1/4"]], [[1]], [[3]],
    [["1/2", 1], [0, "1/2"]], [[1, 1], [0, 1]],
    [["1/2", "-1/2"], ["1/2", "1/2"]], [[0, -1], [1, 0]], [[0, "-1/3"], [1, "-1/2"]],
    [[0, -1], [1, 3]],
    [["-1/2", 0], [0, "-1/2"]], [[-2, 1, 0, 0], [0, -2, 0, 0], [0, 0, -2, 1], [0, 0, 0, -2]],
]  # fmt: skip
"""Real, multiple, complex, irrational, and pairs of negative poles."""


@st.composite
def sampled_plants(draw):
    """Discrete plants with a real logarithm, in hidden coordinates."""
    blocks = draw(st.lists(st.sampled_from(BLOCKS), min_size=1, max_size=2))
    A = sympy.diag(*(Matrix(block).applyfunc(Rational) for block in blocks))
    T = Matrix(draw(unimodular_matrices(A.rows)))
    m = draw(st.integers(1, 2))
    n = A.rows
    return Realisation(
        T * A * T.inv(), draw(matrices(n, m)), draw(matrices(1, n)), draw(matrices(1, m)), "z"
    )


def floats(plant):
    return [np.array(part.tolist(), dtype=float).reshape(part.shape) for part in plant.matrices]


STEPS = st.sampled_from([Rational(1, 10), Rational(1), Rational(7, 3)])


@fewer(2)
@given(sampled_plants(), STEPS, st.integers(-1, 1))
def test_scipy_samples_the_answer_to_the_source(plant, step, k):
    answer = inverse_zero_order_hold(plant, step)
    assert answer.certificate.holds
    numbers = answer.approximation(40, [k] * len(answer.branches))
    theirs = scipy.signal.cont2discrete(floats(numbers), float(step), "zoh")
    scale = np.abs(floats(numbers)[0]).max(initial=1) * float(step)
    for mine, other in zip(floats(plant)[:2], theirs[:2], strict=True):
        bound = 1e-11 * np.exp(min(scale, 8)) * max(1, np.abs(mine).max(initial=0))
        np.testing.assert_allclose(other, mine, rtol=0, atol=bound)


@fewer(2)
@given(sampled_plants(), STEPS)
def test_mpmath_samples_the_answer_to_thirty_digits(plant, step):
    """exp of the rounded answer at 60 digits, of every branch between -2 and 2."""
    answer = inverse_zero_order_hold(plant, step)
    n, m = plant.B.shape
    target = (
        Matrix(plant.A).row_join(Matrix(plant.B)).col_join(sympy.zeros(m, n).row_join(sympy.eye(m)))
    )
    for k in range(-2, 3) if answer.branches else [0]:
        numbers = answer.approximation(80, [k] * len(answer.branches))
        M = numbers.A.row_join(numbers.B).col_join(sympy.zeros(m, n + m)) * step
        with mpmath.workdps(80):
            E = mpmath.expm(mpmath.matrix([[mpmath.mpf(x.p) / x.q for x in row]
                                           for row in M.tolist()]))  # fmt: skip
            for i in range(n + m):
                for j in range(n + m):
                    gap = E[i, j] - mpmath.mpf(target[i, j].p) / target[i, j].q
                    assert abs(gap) < 1e-30


@fewer(2)
@given(sampled_plants())
def test_the_lowest_frequencies_are_the_principal_logarithm(plant):
    """mpmath's logarithm of the matrix, where no pole is negative."""
    poles = sympy.roots(plant.characteristic_polynomial.as_expr(), sympy.Symbol("z"))
    if any(pole.is_negative for pole in poles):
        return
    answer = inverse_zero_order_hold(plant, 1).approximation(40)
    with mpmath.workdps(60):
        A = mpmath.matrix([[mpmath.mpf(x.p) / x.q for x in row] for row in plant.A.tolist()])
        theirs = mpmath.logm(A)
        for i in range(plant.n):
            for j in range(plant.n):
                assert abs(theirs[i, j] - mpmath.mpf(answer.A[i, j].p) / answer.A[i, j].q) < 1e-25


@st.composite
def continuous_plants(draw):
    poles = draw(st.lists(st.sampled_from(["s", "s + 1", "2*s + 1", "s + a", "s - b"]),
                          min_size=1, max_size=3))  # fmt: skip
    top = draw(st.sampled_from(["1", "c", "s + 3"])) if len(poles) > 1 else "1"
    return transfer_function(f"({top})/({'*'.join(f'({p})' for p in poles)})", "s")


@fewer(2)
@given(continuous_plants(), st.sampled_from(["h", "1/10", "2"]))
def test_the_inverse_of_a_hold_is_the_plant(plant, step):
    sampled = zero_order_hold(plant, step)
    back = inverse_zero_order_hold(sampled)
    assert back.logarithms == () and back.step == sampled.step
    source = realisation(plant)
    for mine, other in zip(back.realisation.matrices, source.matrices, strict=True):
        assert (mine - other).applyfunc(sympy.cancel).is_zero_matrix


@fewer(2)
@given(sampled_plants(), st.sampled_from(["h", "1/10", "7/3"]))
def test_the_inverse_of_tustin(plant, step):
    if exact.count_roots(plant.characteristic_polynomial).boundary and (
        plant.characteristic_polynomial.eval(-1) == 0
    ):
        return
    answer = inverse_tustin(plant, step)
    back = tustin(answer.realisation, "T" if step == "h" else step).realisation.subs({"T": "h"})
    for mine, other in zip(back.matrices, plant.matrices, strict=True):
        assert (mine - other).applyfunc(sympy.cancel).is_zero_matrix


@fewer(2)
@given(continuous_plants())
def test_tustin_there_and_back_with_symbols(plant):
    assert inverse_tustin(tustin(plant, "T")).transfer_function == plant.reduced()


def test_every_branch_of_a_pair_has_the_same_samples():
    """z**2 + 1 with h = pi/2 is 1/(s**2 + w**2), w = 4 k + 1."""
    answer = inverse_zero_order_hold("(z + 1)/(z**2 + 1)", sympy.pi / 2)
    ((w, meaning),) = answer.logarithms
    (k,) = answer.branches
    assert meaning == 4 * k + 1 and answer.is_every_branch
    poles = answer.realisation.characteristic_polynomial.as_expr()
    assert sympy.expand(poles - (sympy.Symbol("s") ** 2 + w**2)) == 0
    for turns in (0, 1):
        G = answer.transfer_function.subs({w: meaning.subs(k, turns)})
        assert zero_order_hold(G, sympy.pi / 2).transfer_function == transfer_function(
            "(z + 1)/(z**2 + 1)"
        )


def test_powers_of_one_number_share_a_symbol():
    answer = inverse_zero_order_hold("1/((z - 1/4)*(z - 1/8)*(z - 2))", 1)
    ((a, value),) = answer.logarithms
    poles = answer.realisation.characteristic_polynomial
    powers = {sympy.exp(pole.subs(a, value)) for pole in sympy.roots(poles.as_expr(), poles.gen)}
    assert powers == {Rational(1, 4), Rational(1, 8), 2}


def test_positive_poles_with_symbols_are_a_condition():
    answer = inverse_zero_order_hold("1/(z - x)", "h")
    assert answer.positive == (sympy.Symbol("x"),)
    assert "x > 0" in str(answer)
    with pytest.raises(InputError, match="give numbers"):
        answer.approximation()


@pytest.mark.parametrize(
    ("plant", "error", "words"),
    [
        ("1/(z*(z - 1/2))", NoSolutionError, "dead time"),
        ("1/(z + 1/2)", NoSolutionError, "Jordan"),
        ("1/(z + 1/2)**2", NoSolutionError, "Jordan"),
        ("1/(z + 1/2)**3", NoSolutionError, "Jordan"),
        ("1/(z**2 + 3*z + 1)", NoSolutionError, "negative"),
        ("1/(z**2 - z - 1)", NoSolutionError, "negative"),
        ("1/(z**3 - z + 5)", InputError, "degree"),
        ("1/(z**2 - x)", InputError, "symbols"),
        ("1/(s + 1)", InputError, "continuous"),
        ("z", InputError, "improper"),
    ],
)
def test_refusals(plant, error, words):
    with pytest.raises((error, exact.errors.ImproperError), match=words):
        inverse_zero_order_hold(plant, 1)


def test_two_sizes_of_blocks_of_a_negative_pole():
    """Blocks of sizes 1, 1, 2 for -1/2: the one of size 2 has no partner."""
    A = sympy.diag(*([Rational(-1, 2)] * 4)) + Matrix(4, 4, lambda i, j: int((i, j) == (2, 3)))
    with pytest.raises(NoSolutionError, match="size 2"):
        inverse_zero_order_hold((A, [[1]] * 4, [[1] * 4]), 1, variable="z")


def test_steps_and_sample_times():
    G = transfer_function("1/(z - 1/2)", sample_time="1/10")
    assert inverse_zero_order_hold(G).step == Rational(1, 10)
    for function in (inverse_zero_order_hold, inverse_tustin):
        with pytest.raises(InputError, match="contradicts"):
            function(G, 1)
        with pytest.raises(InputError, match="time domain"):
            function(([[1]], [[1]], [[1]]), 1)
        with pytest.raises(InputError, match="continuous_variable"):
            function("1/(q - 1/2)", 1, continuous_variable="z")
    assert inverse_zero_order_hold("1/(z - 1/2)", log(2)).logarithms == ()
    with pytest.raises(InputError, match="leave the step a symbol"):
        inverse_zero_order_hold("1/(z - 1)", log(2))
    with pytest.raises(NoSolutionError, match="a pole at -1"):
        inverse_tustin("1/(z + 1)", 1)
    with pytest.raises(InputError, match="one integer for each"):
        inverse_zero_order_hold("1/(z**2 + 1)", 1).approximation(5, [1, 2])
