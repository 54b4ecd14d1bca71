"""Forward Riccati gains against SciPy's solution, the printed recursion and separation."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.estimation import ForwardEstimator, ForwardRegulator
from tests.support.estimation_cases import relative_error

seeds = st.integers(0, 10_000)


def pair(seed, n=3, l_u=2):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    return 1.1 * A / max(abs(np.linalg.eigvals(A))), rng.standard_normal((n, l_u))


def printed(A, B, P, R_1, R_2):
    """(8.96) as it stands."""
    middle = np.linalg.inv(R_2 + B.T @ P @ B)
    return A.T @ P @ A + R_1 - A.T @ P @ B @ middle @ B.T @ P @ A


@settings(max_examples=8)
@given(seed=seeds)
def test_a_constant_plant_gets_the_stabilising_gain(seed):
    A, B = pair(seed)
    regulator = ForwardRegulator(3, 2, R_1=1, R_2=np.diag([1.0, 2]))
    for _ in range(400):
        K = regulator.step(A, B)
    P = scipy.linalg.solve_discrete_are(A, B, np.eye(3), np.diag([1.0, 2]))
    assert relative_error(regulator.P, P) < 1e-9
    assert max(abs(np.linalg.eigvals(A + B @ K))) < 1


@given(seed=seeds)
def test_each_step_is_8_96_also_where_the_plant_changes(seed):
    R_1, R_2 = np.diag([1.0, 0, 2]), np.diag([1.0, 3])
    regulator, P = ForwardRegulator(3, 2, R_1, R_2), np.zeros((3, 3))
    for k in range(20):
        A, B = pair(seed + k)
        K = regulator.step(A, B)
        assert np.allclose(K, -np.linalg.solve(R_2 + B.T @ P @ B, B.T @ P @ A), atol=1e-8)
        P = printed(A, B, P, R_1, R_2)
        assert relative_error(regulator.P, P) < 1e-8
        assert np.linalg.eigvalsh(regulator.P).min() > -1e-12 * abs(regulator.P).max()


@given(seed=seeds)
def test_the_estimator_is_the_dual(seed):
    A, B = pair(seed)
    regulator, estimator = ForwardRegulator(3, 2, 1, 2), ForwardEstimator(3, 2, 1, 2)
    for _ in range(5):
        assert np.array_equal(estimator.step(A.T, B.T), -regulator.step(A, B).T)
        assert np.array_equal(estimator.Q, regulator.P)


@given(seed=seeds)
def test_the_corrected_loop_separates(seed):
    """(8.102) with A_a + B_a K - F C_a in its corner: regulator and observer poles, no others."""
    A, B = pair(seed)
    _, C = pair(seed + 1)
    C = C.T
    regulator, estimator = ForwardRegulator(3, 2, 1, 1), ForwardEstimator(3, 2, 1, 1)
    for _ in range(30):
        K, F = regulator.step(A, B), estimator.step(A, C)
    loop = np.block([[A, B @ K], [F @ C, A + B @ K - F @ C]])
    expected = np.concatenate([np.linalg.eigvals(A + B @ K), np.linalg.eigvals(A - F @ C)])
    assert np.allclose(np.poly(loop), np.poly(expected), atol=1e-8)


def test_the_integrator_does_not_belong_into_the_observer():
    """(8.100) for [x; gamma] grows for ever: its C_a does not see gamma."""
    A_a = np.array([[0.9, 0], [-1, 1]])
    estimator = ForwardEstimator(2, 1, V_1=1, V_2=1)
    grown = []
    for _ in range(3000):
        F = estimator.step(A_a, [[1, 0]])
        grown.append(estimator.Q[1, 1])
    assert grown[-1] > 1000 and grown[-1] - grown[-2] == pytest.approx(grown[-2] - grown[-3])
    assert max(abs(np.linalg.eigvals(A_a - F @ [[1, 0]]))) == pytest.approx(1)


def test_what_cannot_be_stabilised_is_named():
    regulator = ForwardRegulator(1, 1, 1, 1)
    with pytest.raises(DivergedError, match=r"P left the range of float64 at step \d+: \(A, B\)"):
        for _ in range(20_000):
            regulator.step(A=2, B=0)
    estimator = ForwardEstimator(1, 1, 1, 1)
    with pytest.raises(DivergedError, match=r"\(A, C\) is not detectable"):
        for _ in range(20_000):
            estimator.step(A=2, C=0)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: ForwardRegulator(2, 1, R_1=-1, R_2=1), "R_1 has the eigenvalue -1"),
        (lambda: ForwardRegulator(2, 1, R_1=1, R_2=0), "R_2 has the eigenvalue 0"),
        (lambda: ForwardEstimator(2, 1, V_1=1, V_2=0), "V_2 has the eigenvalue 0"),
        (lambda: ForwardEstimator(2, 1, V_1=[[1, 2], [2, 1]], V_2=1), "V_1 has the eigenvalue -1"),
        (lambda: ForwardRegulator(0, 1, 1, 1), "n = 0 must be at least 1"),
        (lambda: ForwardRegulator(2, 1, 1, 1).step(np.eye(3), [[1], [1]]), "A has shape"),
        (lambda: ForwardRegulator(1, 1, 1, 1).step(np.nan, 1), "A has the entry nan"),
    ],
)
def test_bad_input(make, says):
    with pytest.raises(InputError, match=says):
        make()
