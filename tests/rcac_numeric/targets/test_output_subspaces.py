"""Zeros of plants with several performance variables, against published and independent ones."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory import InputError
from compensator_theory.errors import NoSolutionError
from rcac_numeric import Plant, transmission_zero_polynomial
from rcac_numeric.targets import output_subspace_target, output_subspace_zeros
from tests.support.aircraft import NOMINAL, OFF_NOMINAL, aircraft
from tests.support.strategies import seeds


def pencil_zeros(plant, W=None):
    """Finite generalised eigenvalues of the Rosenbrock pencil of a square plant W z, by SciPy."""
    W = np.eye(plant.l_z) if W is None else W
    E_1, E_2 = W @ plant.E_1, W @ plant.E_2
    left = np.block([[plant.A, plant.B], [-E_1, -E_2]])
    right = scipy.linalg.block_diag(np.eye(plant.n), np.zeros_like(E_2))
    alpha, beta = scipy.linalg.eig(left, right, homogeneous_eigvals=True)[0]
    finite = np.abs(beta) > 1e-8 * np.abs(alpha)
    return alpha[finite] / beta[finite]


def assert_same_roots(roots, expected, tolerance):
    assert len(roots) == len(expected)
    rest = list(expected)
    for zero in roots:
        nearest = min(rest, key=lambda other: abs(other - zero))
        assert abs(nearest - zero) < tolerance
        rest.remove(nearest)


@pytest.mark.parametrize(
    ("model", "zeros", "outside"),
    [
        (NOMINAL, [0.9811 + 0.0591j, 0.9811 - 0.0591j, 0.9944], 0),
        (OFF_NOMINAL, [0.8405, 0.9944, 1.1493], 1),
    ],
)
def test_full_state_feedback_of_the_aircraft(model, zeros, outside):
    """Section 3.4.1: no transmission zero, but output-subspace zeros, one of which turns NMP."""
    plant = aircraft(model, np.eye(4))
    assert transmission_zero_polynomial(plant).degree() == 0
    result = output_subspace_zeros(plant)
    assert_same_roots(result.zeros, zeros, 1e-4)
    assert len(result.nmp_zeros) == outside
    assert f"{outside} not inside" in str(result)
    target = output_subspace_target(plant)
    assert (target.l_z, target.l_u, target.n_f, target.relative_degree) == (4, 1, 1 + outside, 1)
    assert target.numerator[1] == pytest.approx(plant.B)
    if outside:
        assert target.numerator[2] == pytest.approx(-1.1493 * plant.B, abs=1e-4)


@pytest.mark.parametrize(
    ("model", "zeros"),
    [
        (NOMINAL, [-0.9959, 0.9818 + 0.0556j, 0.9818 - 0.0556j]),
        (OFF_NOMINAL, [-1.0027, 0.8512, 1.1369]),
    ],
)
def test_output_feedback_of_the_aircraft(model, zeros):
    """Section 3.5: the zeros that the text prints."""
    plant = aircraft(model, [[0, 0, 0, 1.0]])
    result = [complex(z) for z in transmission_zero_polynomial(plant).nroots()]
    assert_same_roots(result, zeros, 1e-4)
    assert_same_roots(output_subspace_zeros(plant).zeros, result, 1e-9)


@st.composite
def tall_plants(draw, extra=st.integers(0, 2)):
    rng = np.random.default_rng(draw(seeds))
    n, l_u = draw(st.integers(2, 3)), draw(st.integers(1, 2))
    l_z = l_u + draw(extra)
    A, B, E_1 = (rng.uniform(-1, 1, s).round(2) for s in ((n, n), (n, l_u), (l_z, n)))
    E_2 = rng.uniform(-1, 1, (l_z, l_u)).round(2) * draw(st.booleans())
    return Plant(A=A, B=B, D_1=B, C=E_1, D_0=E_2, E_1=E_1, E_2=E_2)


@pytest.mark.costly
@settings(max_examples=20)
@given(tall_plants())
def test_they_are_the_zeros_of_the_squared_plant(plant):
    zeros = output_subspace_zeros(plant)
    assert_same_roots(zeros.zeros, pencil_zeros(plant, zeros.H.T), 1e-5)
    outside = np.abs(zeros.zeros) >= 1
    assert len(zeros.nmp_zeros) == outside.sum()


@pytest.mark.costly
@settings(max_examples=20)
@given(tall_plants(extra=st.just(0)))
def test_of_a_square_plant_they_are_the_transmission_zeros(plant):
    """Exactly, provided that H is nonsingular, as it is for almost every plant."""
    assert output_subspace_zeros(plant).polynomial == transmission_zero_polynomial(plant)


def test_of_a_tall_plant_every_transmission_zero_is_one():
    """A zero common to all outputs stays one of every combination."""
    A, B = [[0.5, 1.0], [0.0, 0.2]], [[0.0], [1.0]]
    plant = Plant(A=A, B=B, D_1=B, C=[[-2.0, 1.0], [-4.0, 2.0]])
    assert [float(z) for z in output_subspace_zeros(plant).nmp_zeros] == [2.5]
    assert transmission_zero_polynomial(plant).nroots() == [2.5]


def delays(*rows):
    """Two states, each a delay of its own input or of the other state."""
    A = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]
    B = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]
    return Plant(A=A, B=B, D_1=B, C=list(rows))


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: output_subspace_zeros(delays([1.0, 0, 0])), InputError, "wider than tall"),
        (
            # diag(1/q, 1/q^2) has full rank, its first Markov parameter diag(1, 0) has not.
            lambda: output_subspace_zeros(delays([1.0, 0, 0], [0, 1.0, 0])),
            NoSolutionError,
            "full column rank",
        ),
        (
            lambda: output_subspace_target(
                Plant(A=[[0.5]], B=[[0.0]], D_1=[[1.0]], C=[[1.0], [2.0]])
            ),
            InputError,
            "does not act on z",
        ),
    ],
)
def test_bad_input_is_named(make, error, message):
    with pytest.raises(error, match=message):
        make()
