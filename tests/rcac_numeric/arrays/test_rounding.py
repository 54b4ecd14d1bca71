"""The two roundings of a column: the number format that it had, and its printed digits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric.arrays._rounding import Rounding, rounding_of, roundings_of
from tests.support.strategies import seeds

pytestmark = pytest.mark.exact_data  # the very digits are what is tested

FORMATS = ("%.3g", "%.5g", "%.7g", "%.8g", "%.9g", "%.10g", "%.12g", "%.17g", "%.4f", "%.3e")


def numbers(seed, size=300):
    rng = np.random.default_rng(seed)
    return rng.standard_normal(size) * 10 ** rng.uniform(-2, 3)


def printed(values, form):
    return np.array([float(form % value) for value in values])


@given(seeds, st.sampled_from(FORMATS), st.sampled_from(["f8", "f4"]))
def test_the_error_of_both_roundings_is_bounded(seed, form, kind):
    values = numbers(seed)
    logged = printed(values.astype(kind), form)
    rounding = rounding_of(logged)
    bound = rounding.error(logged) * (1 + 1e-6) + 2.0**-24 * np.abs(values)
    assert (np.abs(logged - values) <= bound).all(), str(rounding)


@given(seeds, st.sampled_from(["%.2f", "%.4f", "%.5g", "%.3e", "%.17g"]), st.integers(-3, 3))
def test_the_error_of_numbers_of_one_size_is_bounded(seed, form, exponent):
    """The decimals of numbers below 0.1 are not taken for significant digits."""
    values = 10.0**exponent * np.random.default_rng(seed).standard_normal(200)
    logged = printed(values, form)
    rounding = rounding_of(logged)
    if np.unique(np.abs(logged)).size > 10 and rounding.number_format != "integer":
        error = rounding.error(logged, with_step=True)
        assert (np.abs(logged - values) <= error * (1 + 1e-9) + 1e-15).all(), str(rounding)


@given(seeds)
def test_the_error_of_single_precision_is_bounded(seed):
    values = 10 * np.random.default_rng(seed).standard_normal(200)
    logged = values.astype(np.float32).astype(float)
    rounding = rounding_of(logged)
    assert rounding.sum_unit == 2.0**-24
    assert (np.abs(logged - values) <= rounding.error(logged) * (1 + 1e-9)).all(), str(rounding)


@given(seeds, st.sampled_from(["%.9g", "%.10g", "%.12g", "%.15g", "%.17g"]))
def test_single_precision_is_found_however_many_digits_are_printed(seed, form):
    """The more digits the better: `%.9g` of single precision was refused, `%.17g` was not."""
    values = numbers(seed)
    single = rounding_of(printed(values.astype(np.float32), form))
    assert single.number_format == "float32" and single.relative >= 2.0**-24
    assert rounding_of(printed(values, form)).number_format == "float64"


@given(seeds)
def test_the_shortest_text_of_single_and_half_precision(seed):
    """Pandas and NumPy write the shortest text that is read as the same number."""
    values = numbers(seed)
    for kind, name in ((np.float32, "float32"), (np.float16, "float16")):
        shortest = np.array([float(str(value)) for value in values.astype(kind)])
        assert rounding_of(shortest).number_format == name


@given(seeds, st.integers(3, 9), st.floats(1e-3, 0.1), st.floats(-5, 5))
def test_the_step_of_a_converter_is_found_through_printed_decimals(seed, places, step, offset):
    levels = np.random.default_rng(seed).integers(0, 1024, 400)
    logged = printed(offset + step * levels, f"%.{places}f")
    rounding = rounding_of(logged)
    if 10.0**-places > step / 20:  # the decimals are the coarser
        assert rounding.quantum >= 10.0**-places or rounding.is_exact
        return
    assert rounding.quantum == pytest.approx(step, abs=2 * 10.0**-places / np.ptp(levels))
    assert (rounding.error(logged, with_step=True) >= step / 2 * 0.99).all()


@given(seeds, st.sampled_from([1.0, 0.0123, 5 / 1024]), st.sampled_from([None, 4, 6]))
def test_a_converter_rounds_a_measurement_before_it_is_read_and_u_after(seed, step, decimals):
    counts = np.random.default_rng(seed).integers(-500, 500, 400)
    logged = step * counts + 0.25
    if decimals is not None:
        logged = np.round(logged, decimals)
    rounding = rounding_of(logged)
    assert np.isclose(rounding.step, step, rtol=1e-3)
    assert (rounding.error(logged, with_step=True) >= step).all()
    assert (rounding.error(logged) < step / 10).all()


@given(seeds, st.integers(1, 9), st.integers(1, 5))
def test_levels_of_a_few_units_of_the_last_decimal_are_found(seed, every, places):
    """Multiples of 0.02 or 0.05 with two decimals; ordinary decimals have no levels."""
    counts = np.append(np.random.default_rng(seed).integers(-499, 500, 400), [0, 1])
    logged = printed(every * 10.0**-places * counts, f"%.{places}f")
    assert rounding_of(logged).quantum == pytest.approx(every * 10.0**-places)
    assert bool(rounding_of(logged).step) == (every > 1)


@given(seeds, st.sampled_from([18, 20, 24]))
def test_the_levels_of_a_fine_converter_are_found(seed, bits):
    """Of 24 bits, too, and not taken for the spacing of a floating-point format."""
    step = 10.0 / 2**bits
    counts = np.random.default_rng(seed).integers(-(2 ** (bits - 1)), 2 ** (bits - 1), 20_000)
    counts[:2] = 0, 1
    assert np.isclose(rounding_of(step * counts).step, step, rtol=1e-6)


@given(seeds, st.sampled_from(["%.4f", "%.5g", "%.9g"]))
def test_a_column_of_few_numbers_has_the_digits_of_its_signal_or_of_another(seed, form):
    y = printed(np.random.default_rng(seed).standard_normal(200), form)
    theta = np.column_stack([printed(np.sin(np.arange(200.0)), form), np.tile([0.25, 0.5], 100)])
    constant = np.full(200, 0.5)
    known = roundings_of({"y": y, "theta": theta, "u": constant, "r": np.zeros(200)})
    assert known["theta"][0] == rounding_of(theta[:, 0])
    assert known["theta"][1] == rounding_of(theta)
    assert known["u"][0].printing == known["y"][0].printing != "exact"
    assert known["r"][0].is_exact


@given(seeds, st.integers(8, 20))
def test_fixed_point_in_binary_is_exact(seed, bits):
    values = np.rint(np.random.default_rng(seed).uniform(-1, 1, 200) * 2**bits) / 2**bits
    rounding = rounding_of(values)
    assert rounding.printing == "exact"
    assert rounding.step == 2.0**-bits or rounding.number_format == "float32"


@given(seeds, st.integers(5, 300), st.sampled_from(FORMATS))
def test_no_format_is_seen_in_ordinary_numbers(seed, size, form):
    assert rounding_of(printed(numbers(seed, size), form)).number_format in {"float64", "integer"}


@pytest.mark.parametrize(
    "values", [np.zeros(50), np.ones(50), np.tile([0, 1.0], 50), np.zeros(0), [1e300, 5e-324],
               np.tile([0.125, 0.375, np.nan], 50)],
)  # fmt: skip
def test_nothing_is_concluded_from_the_levels_of_a_step(values):
    assert rounding_of(values).is_exact


def test_counts_are_integers():
    assert rounding_of(np.arange(4096.0)) == Rounding("integer", 1.0)
    assert rounding_of(np.arange(4096.0)).error([3.0]) == 0.0


def test_a_text_tells_the_digits_of_a_few_numbers():
    assert rounding_of([0.5, 0.25], ["0.5000", "0.2500"]) == Rounding("float64", 0, "decimals", 4)
    assert rounding_of([0.5, 0.25], ["0,5000", "0,2500"]).quantum == 1e-4
    assert rounding_of([0.5, 1250.0], ["5.00e-01", "1.25D+03"]).relative == 0.005
    assert rounding_of([0.5, 0.25], ["", "NA"]).is_exact
