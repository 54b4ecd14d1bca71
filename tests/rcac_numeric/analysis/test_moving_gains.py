"""Gains that move beside theta: every corner decreases one function, and the exact norm agrees."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from compensator_theory import decide_bounded_real
from compensator_theory.errors import InputError, NoSolutionError
from rcac_numeric import (
    Compensator,
    certified_set,
    iir,
    standard_plant,
)
from rcac_numeric.analysis._moving_gains import InputGains, centered_loop
from rcac_numeric.analysis._regressor_system import regressor_system, rounded_matrix
from rcac_numeric.arrays._values import replaced
from tests.support.certified_loops import PLANT, first_order, loops
from tests.support.strategies import seeds


def loop_with(plant, structure, theta, s, g):
    """The loop in which limits pass s of each u and the inputs have the gains g, each held."""
    amplified = replaced(plant, B=plant.B * g, exact=None)
    Theta = theta.reshape(-1, structure.l_u) * s
    return regressor_system(amplified, structure).loop_matrix(Theta.ravel())


@pytest.mark.costly
@settings(max_examples=15)
@given(
    loops(radius=0.99), st.sampled_from([(0.8, 1.25, 1.0), (1.0, 1.0, 0.7), (0.9, 1.0, 0.8)]), seeds
)
def test_every_theta_with_every_gain_decreases_one_function(loop, ends, seed):
    """x'Px falls at every step, whatever theta, the limits and the gains of the inputs do."""
    plant, chosen = loop
    low, high, share = ends
    try:
        region = certified_set(plant, chosen, input_gain=(low, high), limit_share=share)
    except NoSolutionError:
        assume(False)
    assert region.is_verified
    rng = np.random.default_rng(seed)
    P = np.array([[float(e) for e in row] for row in region.members[0].P])
    root = np.linalg.cholesky(P / np.abs(P).max()).T
    for _ in range(20):
        v = rng.standard_normal(len(region.center))
        theta = region.center + region.factor @ (v / np.linalg.norm(v))
        s = rng.choice([share, 1.0, rng.uniform(share, 1)], chosen.structure.l_u)
        g = rng.choice([low, high, rng.uniform(low, high)], chosen.structure.l_u)
        step = np.linalg.solve(root.T, (root @ loop_with(plant, chosen.structure, theta, s, g)).T)
        assert np.linalg.norm(step, 2) <= 1 + 1e-7


@settings(max_examples=15)
@given(loops(radius=0.99), st.floats(0.3, 1.0), st.floats(0.5, 1.0), st.floats(1.0, 2.0), seeds)
def test_gains_that_are_held_make_the_loop_of_their_plant(loop, share, low, high, seed):
    """The perturbed loop at its corners is the loop of the plant with that gain, state by state."""
    plant, chosen = loop
    gains, m = InputGains(low, high, share), plant.l_u
    system = regressor_system(plant, chosen.structure)
    centered = centered_loop(system, chosen.theta_0, gains)
    rng = np.random.default_rng(seed)
    s, g = rng.uniform(share, 1, m), rng.uniform(low, high, m)
    deltas = []
    for values, kind in ((s, gains.moving()[0]), (g, gains.moving()[1])):
        if kind is not None:
            deltas += [(v - float(kind[0])) / float(kind[1]) for v in values]
        else:
            values[:] = 1
    expected = loop_with(plant, chosen.structure, chosen.theta_0, s, g)
    A = centered.held(deltas).A if deltas else centered.A
    np.testing.assert_allclose(A, expected, rtol=1e-9, atol=1e-9 * max(1, np.abs(expected).max()))


def test_a_compensator_in_parallel_passes_the_same_limits_and_gains():
    fixed = Compensator([[[0.5]]], [[[0.0]], [[-0.1]]])
    gains = InputGains(0.5, 0.5, 0.6)
    system = regressor_system(PLANT, iir(1), fixed)
    theta = np.array([0.2, -0.3])
    loop = centered_loop(system, theta, gains)
    assert loop.gains == 2
    A = loop.held([-1.0, 0.0]).A  # u_a = 0.6 u, and the plant receives half of it
    less = regressor_system(replaced(PLANT, B=PLANT.B * 0.3, exact=None), iir(1), fixed)
    direct = rounded_matrix(less.loop(theta))
    # the memory of u holds u_a without the part of the fixed compensator
    parallel, adaptive = rounded_matrix(system.parallel), theta[None] @ system.outputs
    memory = rounded_matrix(system.B - system.plant_inputs)
    direct += memory @ (0.6 * (parallel + adaptive) - parallel - adaptive)
    np.testing.assert_allclose(A, direct, atol=1e-12)


@pytest.mark.costly
@pytest.mark.parametrize("theta_0", [[0.2, -0.3], [0.5, -0.1]])
def test_the_exact_norm_of_the_theory_agrees(theta_0):
    """The scaled bound of the certificate is decided by Sturm sequences, without P."""
    region = certified_set(PLANT, first_order(theta_0=theta_0), input_gain=(0.8, 1.25))
    z, v, w = sympy.symbols("z v w")
    a, p, q, low, high, d = (
        sympy.Rational(float(e))
        for e in (PLANT.A.item(), *theta_0, 0.8, 1.25, region.members[0].multipliers.item())
    )
    u, y = sympy.symbols("u y")
    solution = sympy.solve(
        [
            sympy.Eq(u, p * u / z + q * y / z + v),
            sympy.Eq((z - a) * y, (low + high) / 2 * u + w),
        ],
        [u, y],
    )
    K = sympy.Matrix([[sympy.Rational(e) for e in row] for row in region.regressor_factor.tolist()])
    phi = sympy.Matrix([solution[u] / z, solution[y] / z])
    rows = (K.T * phi).col_join(sympy.Matrix([(high - low) / 2 * d * solution[u]]))

    def gain(factor):
        scaled = sympy.diag(factor, factor, 1) * rows
        both = scaled.jacobian([v, w]) * sympy.diag(1, 1 / d)
        return decide_bounded_real(both.applyfunc(sympy.cancel).tolist(), "z").holds

    assert gain(1)
    assert max(region.peaks.values()) > 0.999
    assert not gain(sympy.Rational(101, 100))


def hostile_growth(region, scale, steps=1500):
    """Growth a step where theta and the gain make x'Px largest at the next step."""
    (member,) = region.members
    low, high = region.input_gain
    system = regressor_system(member.plant, region.structure)
    P = np.array([[float(e) for e in row] for row in member.P])
    A, C = rounded_matrix(system.A), system.outputs
    plant, K = rounded_matrix(system.plant_inputs)[:, 0], scale * region.regressor_factor
    memory = system.inputs[:, 0] - plant
    x, growth = np.random.default_rng(1).standard_normal(len(A)), 0.0
    for k in range(steps):
        phi = C @ x
        size = np.linalg.norm(K.T @ phi)
        u = region.center @ phi + size * np.array([-1, -1, 1, 1])
        after = (A @ x)[:, None] + np.outer(memory, u) + np.outer(plant, u * [low, high, low, high])
        values = np.einsum("ic,ij,jc->c", after, P, after)
        x, length = after[:, values.argmax()], np.sqrt(values.max())
        growth += np.log(length) if k >= steps // 2 else 0.0
        x /= length
    return np.exp(growth / (steps - steps // 2))


@pytest.mark.parametrize("theta_0", [[0.2, -0.3], [0.5, -0.1]])
def test_a_hostile_motion_of_both_decays_within_the_set_and_diverges_beyond(theta_0):
    region = certified_set(PLANT, first_order(theta_0=theta_0), input_gain=(0.8, 1.25))
    assert hostile_growth(region, 0.999) < 1 < hostile_growth(region, 1.3)


def test_the_set_of_a_constant_gain_is_too_large_for_one_that_moves():
    alone = certified_set(PLANT, first_order())
    moving = replace(alone, input_gain=(0.8, 1.25))
    assert hostile_growth(alone, 0.999) < 1 < hostile_growth(moving, 0.999)
    assert not moving.is_verified


def test_a_wider_motion_or_another_multiplier_has_no_proof():
    region = certified_set(PLANT, first_order(), input_gain=(0.8, 1.25), limit_share=0.9)
    (member,) = region.members
    assert region.is_verified
    for change in ({"input_gain": (0.75, 1.25)}, {"limit_share": 0.8}, {"input_gain": (1.0, 1.0)}):
        assert not replace(region, **change).is_verified
    for s in (member.multipliers * 2, -member.multipliers, member.multipliers[:1],
              member.multipliers * np.nan):  # fmt: skip
        assert not replace(region, members=(replace(member, multipliers=s),)).is_verified


def test_limits_of_any_size_need_a_plant_that_is_stable_without_control():
    stable = standard_plant("1/(q - 0.5)")
    region = certified_set(stable, first_order(theta_0=[0.2, -0.1]), limit_share=0.0)
    assert region.is_verified
    assert not any("at a limit the loop is another one" in words for words in region.uncovered)
    unstable = standard_plant("1/(q - 1.1)")
    with pytest.raises(NoSolutionError, match="limits that pass 0 of u"):
        certified_set(unstable, first_order(), limit_share=0.0)
    assert certified_set(unstable, first_order(), limit_share=0.95).is_verified


def test_a_family_has_multipliers_of_its_own_for_each_plant():
    others = {"gain x 1.2": "1.2/(q - 0.9)"}
    region = certified_set(PLANT, first_order(), uncertainty=others, input_gain=(0.9, 1.1))
    assert region.is_verified
    assert [member.multipliers.shape for member in region.members] == [(1,), (1,)]
    shares = region.decay([1.0, 0.9])
    assert shares[0.9] < shares[1.0]
    assert np.isclose(shares[1.0], 1, atol=2e-3)
    assert "input gains in [0.9, 1.1]" in region.report()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"input_gain": (1.25, 0.8)}, "low <= high"),
        ({"input_gain": (-1.0, 1.0)}, "other\nsign"),
        ({"input_gain": 0.8}, "low, high"),
        ({"input_gain": (0.8, np.nan)}, "input_gain"),
        ({"input_gain": ("a", 1)}, "input_gain"),
        ({"limit_share": 1.5}, "limit_share"),
        ({"limit_share": "half"}, "limit_share"),
    ],
)
def test_wrong_gains_are_refused_by_name(options, words):
    with pytest.raises(InputError, match=words.replace("\n", " ")):
        certified_set(PLANT, first_order(), **options)
