"""The system from u to the regressor: the recursion of runs with a moving theta, and poles."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import BudgetError, ImproperError, InputError
from rcac_numeric import (
    Compensator,
    DerivedSignal,
    Plant,
    Structure,
    Tap,
    fir,
    iir,
    pid,
    simulate,
    standard_plant,
)
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.analysis._regressor_system import regressor_system, rounded_matrix
from rcac_numeric.arrays._values import replaced
from rcac_numeric.controllers._compensator import parallel
from tests.support.engine_cases import cases, engine_plants
from tests.support.strategies import seeds


def run_from(plant, chosen, seed, steps=40):
    """Return a run without exogenous input from a random state."""
    x_0 = np.random.default_rng(seed).standard_normal(plant.n)
    return simulate(plant, chosen, np.zeros((steps, plant.l_w)), x_0=x_0)


@given(st.data(), st.sampled_from([(1, 1, 0), (2, 1, 1), (1, 2, 0), (2, 2, 1)]), seeds)
def test_every_structure_runs_as_its_system_while_theta_moves(data, widths, seed):
    """x(k+1) = (A + B Theta(k) C) x(k), with u = 0 before k_w, is the run of the engine."""
    l_u, l_y, l_r = widths
    chosen, _ = data.draw(cases(l_u, l_y, 1, l_r))
    plant = data.draw(engine_plants(l_u, l_y, 1, l_r))
    run = run_from(plant, chosen, seed)
    system = regressor_system(plant, chosen.structure)
    A, B, C = map(rounded_matrix, (system.A, system.B, system.C))
    x = np.zeros(len(A))
    x[: plant.n] = run.x_0
    for k in range(run.steps):
        Theta = run.theta[k].reshape(-1, l_u).T
        u = Theta @ (C @ x) if k >= chosen.k_w else np.zeros(l_u)
        size = 1 + np.abs(run.u[: k + 1]).max() + np.abs(run.y[: k + 1]).max()
        assert np.abs(u - run.u[k]).max() <= 1e-9 * size
        assert np.abs(plant.C @ x[: plant.n] - run.y[k]).max() <= 1e-9 * size
        x = A @ x + B @ u


@given(seeds)
def test_a_fixed_compensator_in_parallel_is_a_part_of_the_loop(seed):
    rng = np.random.default_rng(seed)
    plant = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
    fixed = Compensator(rng.uniform(-0.4, 0.4, (2, 1, 1)), rng.uniform(-0.4, 0.4, (3, 1, 1)))
    theta = rng.uniform(-0.3, 0.3, 4)
    loop = regressor_system(plant, iir(2), fixed).loop_matrix(theta)
    adaptive = iir(2).compensator(theta)
    expected = np.poly(frozen_loop(plant, parallel(fixed, adaptive), 0).poles())
    reached = np.poly(np.linalg.eigvals(loop))
    size = min(len(expected), len(reached))  # further states are poles at zero
    np.testing.assert_allclose(reached[:size], expected[:size], atol=1e-9)
    assert np.abs(reached[size:]).max(initial=0) < 1e-9


def test_a_signal_derived_of_the_command_alone_is_no_state():
    """Its sum may grow with r, but no change of theta feeds it back."""
    of_command = DerivedSignal((0.0, 1.0), (0.0, 0.0), 1.0)
    taps = [Tap("y", 0, 1), Tap("derived", 0, 0), Tap("r", 0, 1)]
    structure = Structure(taps, l_r=1, derived=[of_command])
    plant = standard_plant("1/(q - 0.9)")
    system = regressor_system(plant, structure)
    assert not any(any(row) for row in system.C.tolist()[1:])
    assert np.abs(np.linalg.eigvals(system.loop_matrix(np.array([-0.2, 5, 5])))).max() < 1


def test_the_float64_numbers_are_taken_as_they_are():
    """Weights of 0.1 and 0.3 multiply C without rounding."""
    weighted = DerivedSignal((0.1,), (0.3,), 0.7)
    structure = Structure([Tap("derived", 0, 0)], derived=[weighted])
    plant = Plant(A=[[0.1]], B=[[1.0]], D_1=[[1.0]], C=[[0.3]])
    row = regressor_system(plant, structure).C.tolist()[0]
    assert Fraction(int(row[0].p), int(row[0].q)) == Fraction(0.1) * Fraction(0.3)


def test_what_does_not_fit_is_refused():
    plant = standard_plant("1/(q - 0.9)")
    with pytest.raises(InputError, match="l_u = 2"):
        regressor_system(plant, iir(1, l_u=2))
    with pytest.raises(ImproperError, match="D_0"):
        regressor_system(replaced(plant, D_0=[[1.0]], exact=None), iir(1))
    with pytest.raises(BudgetError, match="states"):
        regressor_system(plant, fir(200))
    assert regressor_system(plant, pid("P")).C.nrows() == 1
