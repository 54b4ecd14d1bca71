"""Commands behind filters: SciPy's sampled filters between the limits, the limits everywhere."""

import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError

omegas = st.floats(1e-3, 3.0)
zetas = st.one_of(st.none(), st.floats(0.05, 20.0), st.just(1.0))
seeds = st.integers(0, 10_000)


@given(omega=omegas, zeta=zetas, seed=seeds)
def test_between_the_limits_it_has_the_poles_of_the_sampled_filter(omega, zeta, seed):
    """X/r is z-rational with the poles e^s, numerator gain z^-1 (or (1 - p)(1 - q) z^-1 in second
    order, where v(k+1) adds to x(k+1) at once): SciPy runs it by its own recursion.
    """
    r = np.random.default_rng(seed).standard_normal(80)
    if zeta is None:
        poles = np.exp([-omega])
        numerator = [0, 1 - poles[0]]
    else:
        poles = np.exp(np.roots([1, 2 * zeta * omega, omega**2]))
        numerator = [0, np.prod(1 - poles).real, 0]
    expected = scipy.signal.lfilter(numerator, np.real(np.poly(poles)), r)
    command = rn.FilteredCommand(rn.Levels(r), omega, zeta).samples(80)
    # Poles that meet, or lie near 1, are told apart from roots of a polynomial only to sqrt(eps).
    assert command == pytest.approx(expected, rel=1e-5, abs=1e-6)


@given(omega=omegas, zeta=zetas, seed=seeds, rate=st.floats(1e-3, 2))
def test_no_limit_is_ever_left(omega, zeta, seed, rate):
    rng = np.random.default_rng(seed)
    r = rng.standard_normal(200) * 10.0 ** rng.integers(-2, 6, 200)
    low, high = sorted(rng.standard_normal(2))
    limits = {"low": low, "high": high, "rate": rate, "initial": (low + high) / 2}
    command = rn.FilteredCommand(rn.Levels(r), omega, zeta, **limits).samples(200)
    assert command[0] == (low + high) / 2
    assert command.min() >= low and command.max() <= high
    assert np.abs(np.diff(command)).max() <= rate * (1 + 1e-12)


@given(omega=st.floats(0.05, 3.0), zeta=zetas, height=st.floats(-5, 5))
def test_a_constant_is_reached(omega, zeta, height):
    """As far as its limit; the slowest pole is e^(-omega/(2 zeta)) or faster."""
    slowest = omega if zeta is None else omega * min(zeta, 1 / (2 * zeta))
    steps = int(40 / slowest) + 100
    command = rn.FilteredCommand(rn.Step(height), omega, zeta, low=-1.0, high=2.0, rate=0.5)
    assert command.samples(steps)[-1] == pytest.approx(np.clip(height, -1, 2), abs=1e-9)


def test_without_overshoot_where_it_is_damped():
    x = rn.FilteredCommand(rn.Step(), omega=0.2, zeta=1.2).samples(200)
    assert (np.diff(x) >= 0).all() and x.max() <= 1
    assert rn.FilteredCommand(rn.Step(), omega=0.2, zeta=0.3).samples(200).max() > 1.3
    assert rn.FilteredCommand(rn.Step(), omega=0.2, zeta=0.3, high=1.0).samples(200).max() == 1.0


@given(omega=omegas, zeta=zetas, seed=seeds)
def test_beside_a_device_it_is_the_same(omega, zeta, seed):
    r = np.random.default_rng(seed).standard_normal(30)
    command = rn.FilteredCommand(rn.Levels(r), omega, zeta, high=0.5, rate=0.2)
    state, result = command.start, [command.start[0]]
    for value in r[:-1]:
        state = command.advance(state, value)
        result.append(state[0])
    assert np.array_equal(result, command.samples(30))


def test_what_is_random_or_ends_is_that_of_the_signal():
    noisy = rn.FilteredCommand(rn.WhiteNoise(), omega=3.0)
    one, other = (noisy.samples(20, np.random.default_rng(seed)) for seed in (1, 2))
    assert not np.array_equal(one, other)
    record = rn.FilteredCommand(rn.Recorded([1.0, 2.0], "flight"), omega=1.0)
    assert record.samples(3).shape == (3,)  # x(2) is of r(1)
    with pytest.raises(InputError, match=r"flight .*filtered at 1 rad/sample is known for 3"):
        record.samples(4)
    assert record.samples(0).shape == (0,) and record.samples(1).tolist() == [0.0]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"omega": 0.0}, "omega = 0 must be positive"),
        ({"omega": np.nan}, "omega has the entry nan"),
        ({"omega": 1.0, "zeta": -1}, "zeta = -1 must be positive"),
        ({"omega": 1.0, "rate": 0}, "rate = 0 must be positive"),
        ({"omega": 1.0, "low": 2, "high": 1}, "low = 2 exceeds high = 1"),
        ({"omega": 1.0, "low": 2}, "initial = 0 lies outside the limits 2 and inf"),
        ({"omega": "fast"}, "omega must be a real number"),
        ({"omega": 1.0, "signal": 3.0}, "signal = 3.0 is not a Signal"),
    ],
)
def test_what_is_wrong_is_named(options, says):
    with pytest.raises(InputError, match=says):
        rn.FilteredCommand(**{"signal": rn.Harmonic(0.1), **options})


def test_a_command_that_is_no_number_is_named():
    command = rn.FilteredCommand(rn.Step(), omega=1.0)
    with pytest.raises(InputError, match="r has the entry nan"):
        command.advance(command.start, np.nan)
