"""From continuous to discrete time, exact and in float64."""

import control
import numpy as np
import pytest
import scipy.linalg
import sympy as sp

from compensator_theory import CompensatorError, transfer_function
from compensator_theory.sampling import first_order_hold, matched, tustin, zero_order_hold
from rcac_numeric import plant_of
from tests.support.world import case

z, s = sp.symbols("z s")

BILINEAR = [
    case(
        "SymPy-24558",
        tustin("1/(a*s + b)", "T", variable="s").transfer_function.as_expr,
        "T*(z + 1)/((T*b + 2*a)*z + T*b - 2*a)",
    ),
    case(
        "SymPy-24698",
        lambda: transfer_function("1/(a*s + b)", "s").compose("(z - 1)/(T*z)", "z").as_expr(),
        "T*z/((a + b*T)*z - a)",
    ),
    case(
        "SymPy-24984",
        lambda: transfer_function("1/(a*s + b)", "s").compose("(z - 1)/T", "z").as_expr(),
        "T/(a*z + b*T - a)",
    ),
    case(
        "JL-128",
        lambda: transfer_function("s", "s").compose("2/T*(z - 1)/(z + 1)", "z").as_expr(),
        "2*(z - 1)/(T*(z + 1))",
    ),
]


@pytest.mark.parametrize(("ask", "right"), BILINEAR)
def test_substitutions(ask, right):
    """By hand: s replaced."""
    assert sp.simplify(sp.sympify(str(ask())) - sp.sympify(right)) == 0


HOLDS = [
    case("harold-95", "1/(s**2 + 0.9*s + 1)", [1], [1, 0.9, 1], 2.0, "2"),
    case("pc-465-zoh", "2/(s**3 + 3*s**2 + 2*s)", [2], [1, 3, 2, 0], 0.05, "1/20"),
    case("textbook-lag", "1/(s + 1)", [1], [1, 1], 0.5, "1/2"),
]


@pytest.mark.parametrize(("plant", "num", "den", "T", "step"), HOLDS)
def test_zero_order_hold(plant, num, den, T, step):
    """Against python-control at three points."""
    sampled = zero_order_hold(plant, step, variable="s")
    G = sampled.transfer_function
    values = sampled.exponentials
    for at in (2.0, -1.5, 0.7):
        number = G.as_expr().subs({z: at}).subs(dict(values)).evalf()
        assert complex(number) == pytest.approx(
            complex(control.c2d(control.tf(num, den), T)(at)), rel=1e-9
        )


def test_a_zero_at_the_origin_stays():
    """pc #1241: s/(s + 1) matched has its zero at 1 and a finite gain."""
    sampled = matched("s/(s + 1)", "T")
    G = sampled.transfer_function
    assert sp.simplify(G.as_expr().subs(z, 1)) == 0


OWN_H = [
    case("h-as-gain", lambda hold: hold("h/(s + 1)", variable="s")),
    case("h-as-zero", lambda hold: hold("(s + h)/(s + 1)", variable="s")),
    case("h-as-pole", lambda hold: hold("1/(s + h)", variable="s")),
]


@pytest.mark.parametrize("hold", [zero_order_hold, first_order_hold, tustin, matched])
@pytest.mark.parametrize("ask", OWN_H)
def test_the_step_is_no_letter_of_the_plant(ask, hold):
    """Refused, or another letter is taken for the step."""
    try:
        result = ask(hold)
    except CompensatorError:
        return
    assert str(result.step) != "h"


STIFF = [
    # exp(h A) is bounded: the fast pole is gone within a sample.
    case("stiff-1e-2", [[-100.0, 0], [1, -1]], [[100.0], [0]], 1.0),
    case("stiff-1e-3", [[-1e3, 0], [1, -1]], [[1e3], [0]], 1.0),
    case("stiff-1e-6", [[-1e6, 0], [1, -1]], [[1e6], [0]], 1.0),
    case("pc-stiff-1e-8", [[-1e8, 0], [1, -1]], [[1e8], [0]], 1.0),
    case("MEMS", [[0, 1.0], [-1e6, -10]], [[0], [1e6]], 1.0),
]


@pytest.mark.parametrize(("A", "B", "T"), STIFF)
def test_a_fast_actuator_on_a_slow_process(A, B, T):
    """SciPy's exponential of the matrix."""
    plant = plant_of(control.ss(A, B, [[0, 1]], 0), sample_time=T)
    want = scipy.linalg.expm(np.array(A) * T)
    assert sorted(np.abs(np.linalg.eigvals(plant.A))) == pytest.approx(
        sorted(np.abs(np.linalg.eigvals(want))), abs=1e-9
    )


PADE = [
    case("control-75-order-2", 1.0, 2, 0.1),
    case("control-75-order-3", 0.1, 3, 0.01),
    case("control-75-order-5", 1.0, 5, 0.1),
]


@pytest.mark.parametrize(("delay", "order", "T"), PADE)
def test_a_pade_approximant_is_sampled(delay, order, T):
    """Against python-control, at points of the circle."""
    system = control.tf([1], [1, 1]) * control.tf(*control.pade(delay, order))
    result, want = plant_of(system, sample_time=T).to_control(), control.c2d(control.ss(system), T)
    for at in (1.0, 1j, np.exp(0.3j)):
        value = np.ravel(result(at))
        assert np.abs(value).max() == pytest.approx(abs(want(at)), rel=1e-6)


TIMES = [
    case("pc-332", 0.3, 0.1 * 3),
    case(
        "pc-332-arange",
        0.1,
        float(np.arange(10)[3] * 0.1 - np.arange(10)[2] * 0.1),
    ),
    case("pc-332-equal", 0.3, 0.3),
    case("third", 1 / 3, 0.3333333333333333),
]


@pytest.mark.parametrize(("dt", "dt_2"), TIMES)
def test_sample_times_that_differ_by_rounding_are_equal(dt, dt_2):
    plant = plant_of(control.tf([0.5], [1, -0.5], dt), sample_time=dt_2)
    assert plant.sample_time == pytest.approx(dt, rel=1e-12)


REFUSED = [
    case("SymPy-21585", lambda: zero_order_hold("1/(s**3 + s + 1)", "1/2", variable="s")),
    case(
        "another-sample-time", lambda: plant_of(control.tf([0.5], [1, -0.5], 0.3), sample_time=0.7)
    ),
    case("complex-matrix", lambda: plant_of(([[1j]], [[1]], [[1]], [[0]]), sample_time=1.0)),
]


@pytest.mark.parametrize("ask", REFUSED)
def test_what_cannot_be_sampled_is_refused(ask):
    with pytest.raises(CompensatorError):
        ask()
