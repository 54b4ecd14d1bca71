"""From state space to (2.28): the same response and poles, or a refusal by name; never another."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import CompensatorError, IllConditionedError
from rcac_numeric import Plant, compensator_from_state_space, lqg_controller
from rcac_numeric.analysis._conversion import (
    CANCELLED,
    FURTHER,
    _of_least_norm,
    converted,
    deadbeat_gain,
)
from rcac_numeric.controllers._compensator import Compensator
from tests.support.delayed_plants import delayed_plant
from tests.support.strategies import seeds

# On the circle, between the points that the certificate uses.
POINTS = np.exp(1j * np.linspace(0.0123, np.pi - 0.0123, 41))


def response(parts):
    A, B, C, D = parts
    return np.array([C @ np.linalg.solve(z * np.eye(len(A)) - A, B) + D for z in POINTS])


def gap(design):
    """Of the difference equation to the state space, relative at each frequency; and if it is any.

    Where nothing can be predicted G_c is zero, and its state space leaves only rounding, below
    1e-12 of the terms C (qI - A)^{-1} B that it is the sum of; the gap is then relative to them.
    """
    A, B, C, _ = design.state_space
    expected, result = response(design.state_space), response(design.compensator.state_space())
    sizes = np.linalg.norm(expected, axis=(1, 2))
    terms = np.linalg.norm(C) * np.linalg.norm(response((A, B, np.eye(len(A)), 0 * B)), axis=(1, 2))
    is_any = sizes.max() > 1e-12 * terms.max() + np.finfo(float).tiny
    gaps = np.linalg.norm(result - expected, axis=(1, 2))
    return float((gaps / (sizes if is_any else np.maximum(terms, 1.0))).max()), is_any


@pytest.mark.costly
def test_random_designs_with_delays_keep_their_response(in_full):
    built, refused, nothing, worst = 0, 0, 0, 0.0
    rng = np.random.default_rng(0)
    while built < (2000 if in_full else 60):
        try:
            design = lqg_controller(delayed_plant(rng))
        except CompensatorError:
            continue
        built += 1
        try:
            result, is_any = gap(design)
        except IllConditionedError:
            refused += 1
            continue
        worst, nothing = max(worst, result), nothing + (not is_any)
        assert result < 1e-8
        assert design.certificate.worst < 1e-9
        assert design.loop.is_stable == np.isfinite(design.cost.value)
    assert refused <= built / 100
    print(f"{built} designs, {refused} refused by name, {nothing} zero, worst gap {worst:.1e}")


def test_two_delayed_inputs_with_a_common_mode():
    """Of the audit: the difference equation made a loop of radius 28.9 of one of 8e-5."""
    plant = Plant(
        A=[[0.7, 1, -0.6], [0, 0, 0], [0, 0, 0]], B=[[0, 0], [1, 0], [0, 1]],
        C=[[-1.4, 0, 0], [-1.4, 0, 0]], D_1=np.hstack([np.diag([1.0, 0, 0]), np.zeros((3, 2))]),
        D_2=np.hstack([np.zeros((2, 3)), 0.01 * np.eye(2)]),
        E_1=[[-1.4, 0, 0], [-1.4, 0, 0], [0, 0, 0], [0, 0, 0]],
        E_2=[[0, 0], [0, 0], [0.001, 0], [0, 0.001]],
    )  # fmt: skip
    design = lqg_controller(plant)
    assert design.cost.value == pytest.approx(6.782, abs=1e-3)
    assert gap(design)[0] < 1e-11
    assert design.loop.spectral_radius < 1e-2  # a multiple pole at 0
    assert np.abs(design.compensator.past_u).max() < 10


@given(seeds, st.integers(2, 6), st.integers(1, 3), st.integers(0, 2))
def test_a_deadbeat_gain_makes_nilpotent_what_is_shown(seed, n, outputs, hidden):
    rng = np.random.default_rng(seed)
    A, C = rng.standard_normal((n, n)), rng.standard_normal((outputs, n))
    whole = np.block([[A, np.zeros((n, hidden))], [np.zeros((hidden, n)), 1.3 * np.eye(hidden)]])
    Q = np.linalg.qr(rng.standard_normal((n + hidden, n + hidden)))[0]
    whole, shown = Q @ whole @ Q.T, np.hstack([C, np.zeros((outputs, hidden))]) @ Q.T
    F, remaining, steps = deadbeat_gain(whole, shown, 1e-9)
    assert remaining.shape[1] == n and steps == -(-n // min(outputs, n))
    closed = remaining.T @ (whole - F @ shown) @ remaining
    size = np.linalg.norm(closed) ** steps
    assert np.abs(np.linalg.matrix_power(closed, steps)).max() < 1e-6 * max(size, 1.0)


def test_the_certificate_sees_a_wrong_difference_equation(monkeypatch):
    """With candidates that are all wrong nothing is handed out."""
    parts = np.diag([0.5, 0.2]), np.ones((2, 1)), np.eye(2), np.zeros((2, 1))
    good = converted(parts)[1]
    assert good.worst < 1e-12 and good.left_out == 0 and np.abs(good.points).min() >= 1 - 1e-12

    def wrong(A, B, C, D):
        yield (np.zeros((1, 2, 2)), np.ones((2, 2, 1))), np.eye(2)

    monkeypatch.setattr("rcac_numeric.analysis._conversion.difference_equations", wrong)
    monkeypatch.setattr("rcac_numeric.analysis._conversion._of_least_norm", lambda parts: ())
    with pytest.raises(IllConditionedError, match="reproduces this compensator of order 2"):
        converted(parts)


def test_an_error_is_seen_where_the_response_is_small(monkeypatch):
    """Near a zero on the circle, where an error of 3e-10 is much of what is left."""
    middle = -2 * np.cos(np.pi / 4 + 1e-3)  # 1 + middle q^-1 + q^-2, twice
    parts = np.eye(2, k=-1), np.eye(2)[:, :1], np.array([[middle, 1.0]] * 2), np.ones((2, 1))
    assert converted(parts)[1].worst < 1e-9

    def wrong(A, B, C, D):
        yield (np.zeros((2, 2, 2)), np.stack([D + 3e-10, middle * D, D])), np.eye(2)

    monkeypatch.setattr("rcac_numeric.analysis._conversion.difference_equations", wrong)
    monkeypatch.setattr("rcac_numeric.analysis._conversion._of_least_norm", lambda parts: ())
    with pytest.raises(IllConditionedError, match="reproduces this compensator of order 2"):
        converted(parts)


@given(seeds, st.integers(2, 8), st.integers(2, 3), st.integers(0, 1))
def test_an_equation_of_least_norm_has_the_poles_and_others_that_cancel(seed, n, outputs, hidden):
    """det D_c against numpy's eigenvalues; a mode that u does not show is left out."""
    rng = np.random.default_rng(seed)
    A = np.diag(rng.uniform(0.5, 0.99, n + hidden)) + np.triu(
        rng.standard_normal((n + hidden,) * 2), 1
    )
    A[:n, n:] = 0.0
    B, C = rng.standard_normal((n + hidden, 2)), rng.standard_normal((outputs, n + hidden))
    C[:, n:] = 0.0
    parts = A, B, C, rng.standard_normal((outputs, 2))
    expected, checked = response(parts), 0
    for equation, basis, further in _of_least_norm(parts):
        rank, steps = basis.shape[1], len(equation[0])
        if rank < n or np.linalg.cond(C) > 1e3:
            continue  # another rank of a record that float64 does not tell
        assert rank == n and len(further) == steps * outputs - n
        checked += 1
        result = Compensator(*equation).state_space()
        size = np.linalg.norm(expected, axis=(1, 2))
        assert np.linalg.norm(response(result) - expected, axis=(1, 2)) == pytest.approx(
            0.0, abs=1e-6 * size.max()
        )
        z = 1.3 * np.exp(1j * np.linspace(0.1, 3, 7))
        poles = np.concatenate([np.diag(A)[:n], np.linalg.eigvals(further)])
        left = [np.linalg.det(np.eye(outputs) - sum(
            P * q**-(i + 1) for i, P in enumerate(equation[0])
        )) for q in z]  # fmt: skip
        assert left == pytest.approx([np.prod(1 - poles / q) for q in z], rel=1e-5)
        assert np.abs(np.linalg.eigvals(further)).max(initial=0.0) < CANCELLED
    rows = [C[:, :n]]
    while len(rows) < -(-n // outputs) + FURTHER:
        rows.append(rows[-1] @ A[:n, :n])
    assert checked or np.linalg.cond(np.vstack(rows)) > 1e3 or np.linalg.cond(C) > 1e3


def test_an_integrator_is_checked_beside_its_pole():
    compensator = compensator_from_state_space(np.eye(2), np.eye(2), np.eye(2))
    assert np.allclose(compensator.past_u[0], np.eye(2)) and np.allclose(
        compensator.past_y[1], np.eye(2)
    )
    assert np.isfinite(converted((np.eye(2), np.eye(2), np.eye(2), np.zeros((2, 2))))[1].residual)


def test_a_response_that_is_rounding_only_is_none():
    """C and B are orthogonal up to rounding: what is left is 1e-17 of the terms."""
    B, C = np.array([[0.1], [0.2], [-0.3]]), np.array([[1.0, 1.0, 1.0], [3.0, 3.0, 3.0]])
    result, certificate = converted((0.5 * np.eye(3), B, C, np.zeros((2, 1))))
    assert np.abs(result.past_y).max() < 1e-15 and certificate.worst < 1e-9
