"""Margins of sampled loops."""

import control
import numpy as np
import pytest

from compensator_theory import CompensatorError
from rcac_numeric import stability_margins
from tests.support.world import case

TF = control.tf
W = 2 * np.pi


def sampled(num, den, T):
    return control.c2d(control.ss(TF(num, den)), T)


RIGHT = [
    # Gain, phase in degrees; python-control where it is right, MATLAB in the thread, exact limits.
    case("pc-523", sampled([1.1 * W**2], [1, 0.4 * W, W**2], 0.05), 2.3842, 18.161, 1e-4),
    case("pc-465", sampled([2], [1, 3, 2, 0], 0.05), 2.79279, 31.5416, 1e-5),
    case("fast-sampling", sampled([2], [1, 3, 2, 0], 1e-4), 3, 32.6131, 1e-3),
    case("faster-sampling", sampled([2], [1, 3, 2, 0], 1e-6), 3, 32.6131, 1e-4),
    case("pc-1105", sampled([200], [1, 21, 20, 0], 0.01), 1.901, None, 1e-3),
    case("dead-time", TF([0.02], [1, -0.98] + [0] * 10, 0.1), None, None, 1e-6),
]


@pytest.mark.parametrize(("loop", "gain", "phase", "within"), RIGHT)
def test_margins(loop, gain, phase, within):
    """And at the margin the loop is on the edge: NumPy's eigenvalues of the closed loop."""
    margins = stability_margins(loop, feedback=-1)
    assert margins.is_stable
    if gain is not None:
        assert margins.gain_up.value == pytest.approx(gain, rel=within)
    if phase is not None:
        least = min(abs(margins.phase_lag.value), abs(margins.phase_lead.value))
        assert least == pytest.approx(phase, rel=within)
    at_edge = control.feedback(loop * float(margins.gain_up.value), 1)
    assert np.abs(at_edge.poles()).max() == pytest.approx(1, abs=1e-6)


UNSTABLE = [
    case("pc-87-amplifier", sampled([1e15], [1e1, 1.01e7, 1e11], 1e-7), 1.171),
    case("JL-961", sampled([50], [5, 10.25, 6.25, 1], 0.1), 1.046),
    case("conditionally-stable", sampled([3.0], [1, 3, 2, 0], 0.5) * 4, None),
]


@pytest.mark.parametrize(("loop", "radius"), UNSTABLE)
def test_an_unstable_loop_has_none(loop, radius):
    """Eigenvalues of the closed loop; a margin of an unstable loop is none."""
    right = np.abs(control.feedback(loop, 1).poles()).max()
    try:
        margins = stability_margins(loop, feedback=-1)
    except CompensatorError as error:
        assert "unstable" in str(error) or "not stable" in str(error)
    else:
        assert not margins.is_stable
        assert margins.spectral_radius == pytest.approx(right, rel=1e-6)
    assert right > 1 and (radius is None or right == pytest.approx(radius, rel=1e-3))


DOORS = [
    case(
        "pc-754",
        lambda: stability_margins(TF([0.5], [1, -0.5], True), feedback=-1).gain_up.value,
        3.0,
    ),
    case(
        "pc-332",
        lambda: (
            stability_margins(
                TF([0.5], [1, -0.5], 0.3), feedback=-1, sample_time=0.1 * 3
            ).sample_time
        ),
        pytest.approx(0.3),
    ),
]


@pytest.mark.parametrize(("ask", "right"), DOORS)
def test_what_is_asked_like_this_is_answered(ask, right):
    """0.5/(z - 0.5): pole 0.5 - 0.5 g, at -1 for g = 3, by hand."""
    assert ask() == right


REFUSED = [
    case("pc-419", lambda: stability_margins(TF([0.5], [1, -0.5], None), feedback=-1)),
    case("continuous", lambda: stability_margins(TF([1], [1, 1]), feedback=-1)),
    case(
        "FRD",
        lambda: stability_margins(
            control.frd(np.array([1, 0.5, 0.2]), np.array([0.1, 1, 2.0])), feedback=-1
        ),
    ),
    case(
        "another-sample-time",
        lambda: stability_margins(TF([0.5], [1, -0.5], 0.3), feedback=-1, sample_time=0.7),
    ),
]


@pytest.mark.parametrize("ask", REFUSED)
def test_what_contradicts_itself_is_refused(ask):
    with pytest.raises(CompensatorError):
        ask()
