"""Shares and quantiles: against SciPy, pandas and the definition of Wilson's interval."""

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_experiments.plots._sweep import plot_summary
from rcac_experiments.sweeps import SweepTable, summarise, wilson_interval

counts = st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(st.lists(counts, min_size=1, max_size=5), st.sampled_from([0.5, 0.9, 0.95, 0.999]))
def test_wilson_is_that_of_scipy(pairs, confidence):
    k, n = np.array(pairs).T
    low, high = wilson_interval(k, n, confidence)
    for i, (successes, trials) in enumerate(pairs):
        known = scipy.stats.binomtest(successes, trials).proportion_ci(confidence, "wilson")
        assert (low[i], high[i]) == pytest.approx(tuple(known), abs=1e-12)


@given(counts)
def test_its_ends_solve_the_equation_that_defines_them(pair):
    k, n = pair
    z = scipy.stats.norm.ppf(0.975)
    for p in wilson_interval(k, n):
        assert (k / n - p) ** 2 == pytest.approx(z**2 * p * (1 - p) / n, abs=1e-12)


def test_nothing_is_known_of_no_trials_and_bad_counts_are_refused():
    low, high = wilson_interval(0, 0)
    assert (low, high) == (0.0, 1.0)
    for k, n in ((3, 2), (-1, 2)):
        with pytest.raises(InputError, match="successes"):
            wilson_interval(k, n)


def table(seed, rows=60):
    rng = np.random.default_rng(seed)
    values = rng.lognormal(size=rows)
    values[rng.random(rows) < 0.2] = np.nan
    outcomes = np.where(rng.random(rows) < 0.3, "diverged", "completed").astype(object)
    columns = {
        "run": np.arange(rows), "outcome": outcomes, "rms": values,
        "gain": rng.choice([1.0, 2.5], rows), "n_c": rng.choice([3, 6, 9], rows),
        "way": rng.choice(["ud", "covariance"], rows),
    }  # fmt: skip
    return SweepTable(columns, ("gain", "n_c", "way"), ("rms",))


@pytest.mark.costly
@given(seed=st.integers(0, 50), by=st.permutations(["gain", "n_c", "way"]), many=st.integers(0, 3))
def test_a_summary_is_that_of_pandas(seed, by, many):
    pandas = pytest.importorskip("pandas")
    data, axes = table(seed), by[:many]
    summary = summarise(data, "rms", axes, quantiles=[0.1, 0.9])
    frame = pandas.DataFrame(data.columns)
    assert summary["runs"].sum() == len(data)
    for i in range(len(summary)):
        chosen = np.ones(len(frame), dtype=bool)
        for name in axes:
            chosen &= frame[name] == summary[name][i]
        group = frame[chosen]
        good = group[group.outcome == "completed"].rms.dropna()
        assert summary["runs"][i] == len(group)
        assert summary["not_completed"][i] == (group.outcome != "completed").sum()
        assert summary["measured"][i] == len(good)
        for name, q in (("median", 0.5), ("q0.1", 0.1), ("q0.9", 0.9)):
            assert summary[name][i] == pytest.approx(good.quantile(q), nan_ok=True)


def test_a_map_has_its_values_where_they_belong():
    summary = summarise(table(1), "rms", ["gain", "n_c"])
    xs, ys, values = summary.grid("median", "n_c", "gain")
    assert values.shape == (2, 3)
    for i in range(len(summary)):
        j, k = list(ys).index(summary["gain"][i]), list(xs).index(summary["n_c"][i])
        assert values[j, k] == summary["median"][i]
    with pytest.raises(InputError, match="by="):
        summary.grid("median", "n_c", "way")


@pytest.mark.costly
@pytest.mark.parametrize("by", [["gain"], ["way"], ["gain", "n_c"], ["way", "n_c"]])
def test_a_picture_shows_every_group(by):
    figure = plot_summary(summarise(table(1), "rms", by))
    share, median = figure.axes[:2]
    assert share.get_xlabel() == by[0] and median.get_xlabel() == by[0]
    if len(by) == 1:
        assert len(share.lines[0].get_xdata()) == len(summarise(table(1), "rms", by))
    with pytest.raises(InputError, match="one axis or two"):
        plot_summary(summarise(table(1), "rms"))


def test_what_is_no_axis_is_refused():
    with pytest.raises(InputError, match="'rms' is no axis"):
        summarise(table(1), "rms", ["rms"])
    with pytest.raises(InputError, match="between 0 and 1"):
        summarise(table(1), "rms", quantiles=[2])
    with pytest.raises(InputError, match=r"no column 'rsm'.*Did you mean 'rms'"):
        summarise(table(1), "rsm")
