"""ERA against pyMOR and SLICOT where they are installed, and against Lyapunov equations always.

python-control's `eigensys_realization` and `markov` stand in the tests of ERA and of the windows.
SLICOT's identification (IB01AD) has no wrapper in slycot; what overlaps is balanced truncation,
AB09AD: of many Markov parameters ERA is the same, singular value by singular value.
"""

import numpy as np
import pytest
import scipy.linalg

from rcac_numeric.gallery import aircraft_matrices
from rcac_numeric.identification import eigensystem_realisation

RADIUS = 0.6


def system(seed, n=5, l_y=2, l_u=1):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= RADIUS / np.abs(np.linalg.eigvals(A)).max()
    return A, rng.standard_normal((n, l_u)), rng.standard_normal((l_y, n))


def parameters(A, B, C, count):
    rows = [np.zeros((len(C), B.shape[1]))]
    for _ in range(count):
        rows.append(C @ B)
        B = A @ B
    return np.array(rows)


def model_parameters(model, count):
    return parameters(model.A, model.B, model.C, count)


def hankel_singular_values(A, B, C):
    """Roots of the eigenvalues of the product of the Gramians."""
    W_c = scipy.linalg.solve_discrete_lyapunov(A, B @ B.T)
    W_o = scipy.linalg.solve_discrete_lyapunov(A.T, C.T @ C)
    return np.sort(np.sqrt(np.abs(np.linalg.eigvals(W_c @ W_o))))[::-1]


@pytest.mark.parametrize("seed", range(5))
def test_many_parameters_give_the_hankel_singular_values(seed):
    """The infinite Hankel matrix is the product of observability and controllability matrices."""
    A, B, C = system(seed)
    model = eigensystem_realisation(parameters(A, B, C, 400), 5)
    assert model.singular_values[:5] == pytest.approx(hankel_singular_values(A, B, C), rel=1e-9)
    W = [scipy.linalg.solve_discrete_lyapunov(*pair) for pair in
         ((model.A, model.B @ model.B.T), (model.A.T, model.C.T @ model.C))]  # fmt: skip
    for gramian in W:
        assert gramian == pytest.approx(np.diag(model.singular_values[:5]), abs=1e-8)


@pytest.mark.parametrize("order", [2, 3, 5])
def test_pymor_realises_the_same_parameters(order):
    era = pytest.importorskip("pymor.reductors.era", reason="optional oracle: pip install pymor")
    A, B, C = system(order, n=order)
    H = parameters(A, B, C, 20)
    theirs = era.ERAReductor(H[1:20], sampling_time=1.0, force_stability=False)
    reduced = theirs.reduce(r=order)
    result = parameters(*(np.asarray(M) for M in reduced.to_matrices()[:3]), 20)
    ours = eigensystem_realisation(H, order)
    assert result == pytest.approx(H, abs=1e-9)
    assert model_parameters(ours, 20) == pytest.approx(result, abs=1e-9)


def test_pymor_has_the_same_singular_values_under_noise():
    era = pytest.importorskip("pymor.reductors.era", reason="optional oracle: pip install pymor")
    A, B, C = system(1)
    H = parameters(A, B, C, 20) + 1e-3 * np.random.default_rng(2).standard_normal((21, 2, 1))
    theirs = era.ERAReductor(H[1:20], sampling_time=1.0, force_stability=False)
    values = theirs._sv_U_V(None, None)[0]
    ours = eigensystem_realisation(H, 5).singular_values
    assert ours[: len(values)] == pytest.approx(values, abs=1e-12)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_slicot_truncates_to_the_same_model(order):
    """AB09AD balances and truncates; so does ERA of parameters that have died out."""
    slycot = pytest.importorskip("slycot", reason="optional oracle: pip install slycot")
    A, B, C = system(7)
    _, A_r, B_r, C_r, values = slycot.ab09ad("D", "B", "N", 5, 1, 2, A, B, C, nr=order)
    ours = eigensystem_realisation(parameters(A, B, C, 400), order)
    assert ours.singular_values[:5] == pytest.approx(values, rel=1e-8)
    count = 30
    theirs = parameters(A_r, B_r, C_r, count)
    assert model_parameters(ours, count) == pytest.approx(theirs, abs=1e-8)


def test_pymor_sees_the_zeros_of_the_aircraft():
    """The transfer function of pyMOR's realisation against the zeros of section 3.5."""
    era = pytest.importorskip("pymor.reductors.era", reason="optional oracle: pip install pymor")
    A, B = aircraft_matrices("off-nominal", "corrected")
    C = np.eye(4)[3:]
    H = parameters(A, B, C, 20)
    reduced = era.ERAReductor(H[1:20], sampling_time=0.1, force_stability=False).reduce(r=4)
    M, N, P = (np.asarray(m) for m in reduced.to_matrices()[:3])
    # det(qI - A + B C) - det(qI - A) is the numerator of C(qI - A)^-1 B.
    zeros = np.roots((np.poly(M - N @ P) - np.poly(M))[1:])
    assert np.sort(zeros.real) == pytest.approx([-1.0027, 0.8512, 1.1369], abs=5e-5)
