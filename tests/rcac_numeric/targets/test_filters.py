"""Any filter as a target model, against the libraries that the filters come from."""

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import InputError, TransferMatrix, polynomial
from compensator_theory.errors import BudgetError, ImproperError
from rcac_numeric import TargetModel, target_model
from rcac_numeric.analysis._match import filtered
from tests.support.strategies import seeds, sizes

OMEGA = np.linspace(0.1, 3.0, 7)


@st.composite
def stable_systems(draw, outputs=sizes, inputs=sizes):
    """Stable A, B, C, D with entries of two decimals, so that the exact half has an easy life."""
    rng = np.random.default_rng(draw(seeds))
    n = draw(st.integers(1, 3))
    A = rng.uniform(-0.9, 0.9, (n, n)) / n
    shapes = (n, draw(inputs)), (draw(outputs), n)
    B, C = (rng.uniform(-1, 1, shape) for shape in shapes)
    D = rng.uniform(-1, 1, (len(C), B.shape[1])) * draw(st.booleans())
    A, B, C, D = (m.round(2) for m in (A, B, C, D))
    B[0, 0] = C[0, 0] = 1.0
    return A, B, C, D


@given(stable_systems())
def test_a_state_space_filter_keeps_its_frequency_response(matrices):
    system = control.ss(*matrices, True)
    expected = np.moveaxis(np.atleast_3d(system(np.exp(1j * OMEGA), squeeze=False)), 2, 0)
    for filter in (system, scipy.signal.dlti(*matrices)):
        target = target_model(filter)
        assert target.frequency_response(OMEGA) == pytest.approx(expected, abs=1e-9)
        assert target.n_f <= len(matrices[0])


@given(stable_systems(), seeds)
def test_it_filters_as_dlsim_does(matrices, seed):
    u = np.random.default_rng(seed).standard_normal((30, matrices[1].shape[1]))
    _, expected, _ = scipy.signal.dlsim(scipy.signal.dlti(*matrices), u)
    assert filtered(target_model(control.ss(*matrices, 0.1)), u) == pytest.approx(
        expected, abs=1e-9
    )


def test_a_matrix_of_quotients_has_one_denominator_for_each_row():
    """Two rows of orders 2 and 1; the least common multiple and not the product is used."""
    G = control.tf(
        [[[1.0], [1.0, 1.0]], [[2.0], [0.0]]],
        [[[1.0, -0.5], [1.0, -0.75, 0.125]], [[1.0, 0.2], [1.0]]],
        dt=True,
    )
    target = target_model(G)
    assert target.n_f == 2
    assert np.diagonal(target.denominator, axis1=1, axis2=2) == pytest.approx(
        np.array([[1, 1], [-0.75, 0.2], [0.125, 0]])
    )
    expected = np.moveaxis(G(np.exp(1j * OMEGA)), 2, 0)
    assert target.frequency_response(OMEGA) == pytest.approx(expected)
    entries = tuple(tuple(polynomial(e, "q") for e in row) for row in (("2*q - 1", "4"),))
    exact = TransferMatrix(entries, polynomial("(q - 1/2)*(q - 1/4)"))
    assert target_model(exact).exact.numerators[0][1] == polynomial("4", "q")


@pytest.mark.parametrize(
    "filter",
    [
        [0.0, 2.0, -1.0],
        np.array([0.0, 2.0, -1.0]),
        ([0.0, 2.0, -1.0], [1.0]),
        [[[0.0]], [[2.0]], [[-1.0]]],
        "(2*q - 1)/q**2",
        ("2*q - 1", "q**2"),
        scipy.signal.dlti([2.0, -1.0], [1.0, 0.0, 0.0]),
        scipy.signal.dlti([0.5], [0.0, 0.0], 2.0),
        control.tf([2.0, -1.0], [1.0, 0.0, 0.0], dt=0.1),
    ],
    ids=lambda filter: type(filter).__name__,
)
def test_every_way_to_write_a_scalar_filter(filter):
    assert target_model(filter).numerator.ravel().tolist() == [0.0, 2.0, -1.0]
    assert not target_model(filter).denominator[1:].any()


def test_a_single_input_with_two_outputs_of_scipy():
    filter = scipy.signal.dlti([[1.0, 0.0], [0.0, 2.0]], [1.0, -0.5])
    target = target_model(filter)
    assert (target.l_z, target.l_u) == (2, 1)
    assert target.numerator[:, :, 0].tolist() == [[1.0, 0.0], [0.0, 2.0]]


@pytest.mark.parametrize(
    "make",
    [
        lambda: TargetModel([1.0], [1.0, -1.0]),  # an integrator
        lambda: target_model("1/(q**2 - 6/5*q + 1)"),
        lambda: target_model("1/((q - 1)*(q - 1/3)*(q - 1/7))"),  # rounding moves the pole at 1
        lambda: target_model("1/(q - 0.99999999999999999999)"),
    ],
)
def test_poles_on_or_barely_inside_the_circle_are_allowed(make):
    assert make().n_f >= 1


def with_coupled_rows(gain):
    """det D_f = 1 - gain q^-2: no entry alone shows where the poles are."""
    denominator = np.zeros((2, 2, 2))
    denominator[0] = np.eye(2)
    denominator[1] = [[0.0, gain], [1.0, 0.0]]
    return TargetModel(np.ones((1, 2, 1)), denominator)


@given(st.integers(1, 400))
def test_the_poles_of_a_matrix_denominator_are_those_of_its_determinant(hundredths):
    gain = hundredths / 100
    if gain <= 1:
        assert with_coupled_rows(gain).n_f == 1
    else:
        with pytest.raises(InputError, match="2 poles outside the unit circle"):
            with_coupled_rows(gain)


@pytest.mark.exact_data
@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: target_model("1/(q - 1.25)"), InputError, "1 pole outside.*largest at 1.25"),
        (lambda: TargetModel([1.0], [1.0, -1.0000000000000002]), InputError, "1 pole outside"),
        (lambda: target_model("1/(q - 1.00000000000000000001)"), InputError, "1 pole outside"),
        (lambda: target_model("(q - 2)/((q - 2)*(q - 0.5))"), InputError, "largest at 2"),
        (lambda: target_model(control.tf([1.0], [1.0, 1.0])), InputError, "continuous time"),
        (lambda: target_model(control.ss([[0]], [[1]], [[1]], [[0]])), InputError, "continuous"),
        (lambda: target_model(scipy.signal.lti([1.0], [1.0, 1.0])), InputError, "continuous time"),
        (lambda: target_model(control.tf([1], [1, 0.5], dt=None)), InputError, "a sample time"),
        (lambda: target_model(control.tf([1, 0, 0], [1, 0.5], dt=1)), ImproperError, "more zeros"),
        (lambda: target_model(scipy.signal.ShortTimeFFT), InputError, "not a number"),
        (lambda: target_model(control.frd([1, 2], [0.1, 0.2], dt=True)), InputError, "Frequency"),
        (lambda: target_model([[1.0, 2.0], [0.5]]), InputError, "must be the identity"),
        (lambda: target_model([[1.0], [1.0], [1.0]]), InputError, r"shapes \[\(1,\)"),
        (lambda: target_model([[[1.0]], [[1.0, 2.0]]]), InputError, "list of arrays of shapes"),
        (lambda: target_model([]), InputError, "list of arrays"),
        (lambda: target_model(np.ones((2, 2))), InputError, r"shape \(2, 2\)"),
        (lambda: target_model([0.0, float("nan")]), InputError, "finite"),
    ],
)
def test_bad_filters_are_named(make, error, message):
    with pytest.raises(error, match=message):
        make()


@given(seeds, sizes, st.integers(1, 4), st.floats(0.3, 3))
def test_poles_are_those_of_the_block_companion_matrix(seed, l_z, n_f, scale):
    D = scale * np.random.default_rng(seed).uniform(-1, 1, (n_f + 1, l_z, l_z)) / (n_f * l_z)
    D[0] = np.eye(l_z)
    companion = np.eye(l_z * n_f, k=-l_z)
    companion[:l_z] = -np.hstack(list(D[1:]))
    radius = np.abs(np.linalg.eigvals(companion)).max()
    assume(abs(radius - 1) > 1e-6)
    numerator = np.ones((1, l_z, 1))
    if radius < 1:
        assert TargetModel(numerator, D).n_f == n_f
    else:
        with pytest.raises(InputError, match="outside the unit circle"):
            TargetModel(numerator, D)


@pytest.mark.parametrize("last", [-0.999, -1.0, -1.001])
def test_a_long_denominator_takes_no_time(last):
    """1 - a q^-1000 with small terms between, or none where the poles are on the circle."""
    D = np.zeros(1001)
    D[0], D[-1] = 1.0, last
    if last > -1:
        D[1:-1] = np.random.default_rng(0).uniform(-1e-6, 1e-6, 999)
    if last < -1:
        with pytest.raises(InputError, match="has a pole outside"):
            TargetModel([1.0], D)
    else:
        assert TargetModel([1.0], D).n_f == 1000


def test_denominators_beyond_the_budget_are_refused():
    dense = np.zeros((51, 20, 20))
    dense[0], dense[-1] = np.eye(20), 1e-3
    for D in (np.r_[1.0, np.zeros(1000), 0.5], dense):
        N = np.ones((1, D.shape[1] if D.ndim > 1 else 1, 1))
        with pytest.raises(BudgetError, match="the denominator of the target model needs"):
            TargetModel(N, D)
    assert TargetModel(np.ones((1, 20, 1)), np.eye(20) * np.r_[1, [1e-3] * 50][:, None, None])
