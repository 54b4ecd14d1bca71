"""The compiled updates on recorded data, at every instruction set this processor runs."""

import numpy as np
import pytest
from flint import arb, arb_mat, ctx
from hypothesis import example, given
from hypothesis import strategies as st

from benchmarks.yardsticks import symmetric_covariance
from compensator_theory import InputError
from rcac_numeric import UD, ControllerSettings, fir_target, iir, simulate, standard_plant
from rcac_numeric.compiled import _kernel
from tests.support.strategies import seeds

SETS = _kernel.instruction_sets()
# Tiles are 8 x 8 and blocks of lanes have 4 columns: 1 to 70 holds every kind of remainder.
lengths = st.integers(1, 70)


def record(seed, steps, l_z, l_theta):
    """Random rows, targets, weights and a start, none of them special."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((l_z, l_z))
    return {
        "Phi_f": rng.standard_normal((steps, l_z, l_theta)),
        "target": rng.standard_normal((steps, l_z)),
        "R_z": np.eye(l_z) + 0.3 * np.diag(rng.random(l_z)),
        "R_u": 0.2 * root @ root.T,
        "P_0": np.diag(rng.uniform(0.5, 2.0, l_theta)),
        "theta_0": rng.standard_normal(l_theta),
    }


def minimiser(data, lam=1.0):
    """Theta and P from the normal equations of (2.41) in 400-bit ball arithmetic."""
    precision, ctx.prec = ctx.prec, 400
    try:
        balls = lambda a: arb_mat(*np.shape(a), [arb(float(v)) for v in np.ravel(a)])  # noqa: E731
        n, lam = len(data["theta_0"]), arb(lam)
        H = balls(data["P_0"]).inv()
        g = H * balls(data["theta_0"][:, None])
        R_z = balls(data["R_z"])
        W = R_z + balls(data["R_u"])
        for F, target in zip(map(balls, data["Phi_f"]), data["target"], strict=True):
            H = H * lam + F.transpose() * W * F
            g = g * lam - F.transpose() * R_z * balls(target[:, None])
        theta, P = H.solve(g), H.inv()
        numbers = lambda m: np.array([float(v.mid()) for v in m.entries()])  # noqa: E731
        return numbers(theta), numbers(P).reshape(n, n)
    finally:
        ctx.prec = precision


def close(value, exact, bound):
    return np.abs(value - exact).max() <= bound * np.abs(exact).max()


@given(lengths, st.integers(1, 3), st.sampled_from([1.0, 0.97]), seeds)
@example(8, 1, 1.0, 0)
@example(64, 3, 0.97, 1)
def test_every_update_is_the_least_squares_solution(l_theta, l_z, lam, seed):
    data = record(seed, 12, l_z, l_theta)
    weight = data["R_z"] + data["R_u"]
    H = np.linalg.inv(data["P_0"])
    g = H @ data["theta_0"]
    for F, target in zip(data["Phi_f"], data["target"], strict=True):
        H = lam * H + F.T @ weight @ F
        g = lam * g - F.T @ data["R_z"] @ target
    theta_exact, P_exact = np.linalg.solve(H, g), np.linalg.inv(H)
    for update in ("ud", "covariance"):
        for name in SETS:
            theta, P, count, first, finite = _kernel.replay_updates(
                update, **data, forgetting=lam, instruction_set=name
            )
            assert (finite, count, first) == (True, 0, -1)
            assert close(theta, theta_exact, 1e-10)
            assert close(P, P_exact, 1e-10)
            if update == "ud":
                assert np.array_equal(P, P.T)


@pytest.mark.skipif(symmetric_covariance.compiler() is None, reason="no C++ compiler")
@given(lengths, st.sampled_from([1.0, 0.97]), seeds)
@example(8, 0.97, 0)
def test_the_yardstick_of_the_benchmark_is_the_same_recursion(l_theta, lam, seed):
    data = record(seed, 12, 1, l_theta)
    weights = {"R_z": np.eye(1), "R_u": np.zeros((1, 1))}
    theta, P, *_ = _kernel.replay_updates("ud", **{**data, **weights}, forgetting=lam)
    start = {name: data[name] for name in ("P_0", "theta_0")}
    result, covariance = symmetric_covariance.replay(
        data["Phi_f"][:, 0], data["target"][:, 0], forgetting=lam, **start
    )
    assert close(result, theta, 1e-10)
    assert close(covariance, P, 1e-10)
    assert np.array_equal(covariance, covariance.T)


@given(st.integers(1, 20), st.integers(1, 3), seeds, st.sampled_from([1e-40, 1e-20, 1e20]))
def test_ud_keeps_its_digits_for_every_size_of_P_0(l_theta, l_z, seed, R_theta):
    """With R_theta = 1e-40 the first l_theta steps are a question of 80 digits."""
    data = record(seed, 3 * l_theta + 3, l_z, l_theta)
    data["P_0"] = np.eye(l_theta) / R_theta
    exact, _ = minimiser(data)
    rows = data["Phi_f"].reshape(-1, l_theta)
    # theta passes through the solution of the first l_theta equations, which may be worse posed.
    rounding = 1e-14 * (np.linalg.cond(rows) ** 2 + np.linalg.cond(rows[:l_theta]))
    for name in SETS:
        theta, _, _, _, finite = _kernel.replay_updates("ud", **data, instruction_set=name)
        assert finite
        assert close(theta, exact, max(1e-12, rounding))


@given(st.integers(1, 32), st.sampled_from([1.0, 1e-12, 1e-30]), seeds)
@example(10, 1.0, 0)
@example(24, 1.0, 0)
@example(20, 1e-30, 1)
def test_a_size_that_the_compiler_knows_gives_the_bits_of_the_tiles(l_theta, R_theta, seed):
    """Coefficients that no row reaches make of a small update one of any size."""
    data = record(seed, l_theta + 4, 1, l_theta)
    root = np.random.default_rng(seed).standard_normal((l_theta, l_theta))
    data["P_0"] = (np.eye(l_theta) + 0.1 * root @ root.T) / R_theta
    data["theta_0"] = np.zeros(l_theta)
    wide = {**data, "P_0": np.eye(48) * np.diag(data["P_0"]).min(), "theta_0": np.zeros(48)}
    wide["P_0"][:l_theta, :l_theta] = data["P_0"]
    wide["Phi_f"] = np.pad(data["Phi_f"], ((0, 0), (0, 0), (0, 48 - l_theta)))
    # The innovation is summed in the order of n, and is only the target in the first step.
    first = [{**d, "Phi_f": d["Phi_f"][:1], "target": d["target"][:1]} for d in (data, wide)]
    for name in SETS:
        few, many = (_kernel.replay_updates("ud", **d, instruction_set=name) for d in (data, wide))
        assert np.array_equal(few[1], many[1][:l_theta, :l_theta])
        assert few[2:] == many[2:]
        few, many = (_kernel.replay_updates("ud", **d, instruction_set=name) for d in first)
        assert np.array_equal(few[0], many[0][:l_theta])


@given(lengths, seeds)
def test_rows_of_zeros_change_nothing(l_theta, seed):
    data = record(seed, 6, 1, l_theta)
    gaps = dict(data)
    gaps["Phi_f"] = np.insert(data["Phi_f"], [0, 2, 6], 0.0, axis=0)
    gaps["target"] = np.insert(data["target"], [0, 2, 6], 1.0, axis=0)
    for name in SETS:
        plain = _kernel.replay_updates("ud", **data, instruction_set=name)
        assert all(
            np.array_equal(a, b)
            for a, b in zip(
                plain, _kernel.replay_updates("ud", **gaps, instruction_set=name), strict=True
            )
        )


@given(st.integers(2, 40), seeds)
def test_the_guard_speaks_alike_with_every_instruction_set(l_theta, seed):
    """A row seen again, once scaled: the direction it leaves has no excitation but rounding."""
    data = record(seed, 2, 1, l_theta)
    data["Phi_f"][1] = data["Phi_f"][0] * (1 / 3)
    data["P_0"] = np.eye(l_theta) * 1e40
    counts = {_kernel.replay_updates("ud", **data, instruction_set=name)[2] for name in SETS}
    assert counts == {1}
    data["P_0"] = np.eye(l_theta)
    assert {_kernel.replay_updates("ud", **data, instruction_set=name)[2] for name in SETS} == {0}


def lane_record(seed, steps, l_theta, sizes):
    rng = np.random.default_rng(seed)
    return {
        "Phi_f": rng.standard_normal((steps, l_theta, _kernel.lanes)),
        "target": rng.standard_normal((steps, _kernel.lanes)),
        "P_0": np.array([np.eye(l_theta) * size for size in sizes]),
        "theta_0": rng.standard_normal((l_theta, _kernel.lanes)),
    }


def alone(data, lane, **options):
    """The same lane as a run of its own."""
    return _kernel.replay_updates(
        "ud",
        np.ascontiguousarray(data["Phi_f"][:, None, :, lane]),
        np.ascontiguousarray(data["target"][:, lane, None]),
        R_z=np.eye(1),
        R_u=np.zeros((1, 1)),
        P_0=data["P_0"][lane],
        theta_0=np.ascontiguousarray(data["theta_0"][:, lane]),
        **options,
    )


@given(lengths, st.sampled_from([1.0, 0.97]), seeds)
def test_lanes_are_single_runs(l_theta, lam, seed):
    data = lane_record(seed, 10, l_theta, 10.0 ** np.arange(-4, 4))
    for name in SETS:
        theta, P, lost, finite = _kernel.replay_ud_lanes(
            **data, forgetting=lam, instruction_set=name
        )
        assert finite
        assert lost == [0] * _kernel.lanes
        for lane in range(_kernel.lanes):
            single = alone(data, lane, forgetting=lam, instruction_set=name)
            assert close(theta[:, lane], single[0], 1e-11)
            assert close(P[lane], single[1], 1e-11)


@given(lengths, seeds)
def test_a_lane_without_a_measurement_stays_as_it_is(l_theta, seed):
    data = lane_record(seed, 4, l_theta, np.full(_kernel.lanes, 2.0))
    data["Phi_f"][2:, :, 3] = 0.0
    shorter = {k: v[:2] if k in ("Phi_f", "target") else v for k, v in data.items()}
    for name in SETS:
        long = _kernel.replay_ud_lanes(**data, instruction_set=name)
        short = _kernel.replay_ud_lanes(**shorter, instruction_set=name)
        assert np.array_equal(long[0][:, 3], short[0][:, 3])
        assert np.array_equal(long[1][3], short[1][3])


@given(st.integers(2, 30), seeds)
def test_a_lane_is_lost_by_itself(l_theta, seed):
    sizes = np.ones(_kernel.lanes)
    sizes[5] = 1e40
    data = lane_record(seed, 2, l_theta, sizes)
    data["Phi_f"][1] = data["Phi_f"][0] * (1 / 3)
    for name in SETS:
        lost = _kernel.replay_ud_lanes(**data, instruction_set=name)[2]
        assert lost == [0, 0, 0, 0, 0, 1, 0, 0]


def test_replays_check_their_arguments():
    data = record(0, 3, 2, 4)
    with pytest.raises(ValueError, match="target: extent 3"):
        _kernel.replay_updates("ud", **{**data, "target": np.zeros((3, 3))})
    with pytest.raises(ValueError, match="no update named"):
        _kernel.replay_updates("kalman", **data)
    with pytest.raises(ValueError, match="no instruction set named"):
        _kernel.replay_updates("ud", **data, instruction_set="avx1024")
    with pytest.raises(ValueError, match="forgetting"):
        _kernel.replay_updates("ud", **data, forgetting=0.0)
    lanes = lane_record(0, 3, 4, np.ones(_kernel.lanes))
    with pytest.raises(ValueError, match="theta_0"):
        _kernel.replay_ud_lanes(**{**lanes, "theta_0": np.zeros((_kernel.lanes, 4))})
    assert SETS[-1] == "plain"


def test_what_leaves_the_range_of_float64_is_said():
    data = record(0, 4, 1, 5)
    data["Phi_f"][2] = 1e200
    for name in SETS:
        assert not _kernel.replay_updates("ud", **data, instruction_set=name)[-1]


def test_the_environment_forces_an_instruction_set(monkeypatch):
    """Every one runs; one that this processor does not have is refused by name."""
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    settings = ControllerSettings(structure=iir(9), target=fir_target(plant), update=UD(R_theta=1))
    w = np.random.default_rng(0).standard_normal((300, 1))
    result = {}
    for name in _kernel.instruction_sets():
        monkeypatch.setenv("RCAC_INSTRUCTION_SET", name)
        result[name] = simulate(plant, settings, w).theta_final
    assert np.ptp(list(result.values()), axis=0).max() < 1e-9 * np.abs(result["plain"]).max()
    monkeypatch.delenv("RCAC_INSTRUCTION_SET")
    assert np.array_equal(simulate(plant, settings, w).theta_final, next(iter(result.values())))
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "sse9")
    with pytest.raises(InputError, match=r"sse9.*plain"):
        simulate(plant, settings, w)
