"""The figures of an experiment hold what was asked for."""

import io

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_experiments import FigureRequest, verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids
from rcac_experiments.experiments._figure_requests import KINDS
from rcac_experiments.plots import plot_request
from rcac_experiments.plots._requested import DRAWINGS, OF_STUDIES
from rcac_numeric.plots._thinning import MANY, thinned


@pytest.fixture(scope="module")
def steps():
    return verify(load_example("2.1"))


@pytest.fixture(scope="module")
def rounding():
    return verify(load_example("4.6"))


def lines(figure):
    return {line.get_label(): line for axis in figure.axes for line in axis.get_lines()}


@pytest.mark.costly
def test_every_kind_is_drawn(steps):
    assert set(DRAWINGS) | set(OF_STUDIES) == set(KINDS) - {"sheet"}
    for kind in ("sheet", *DRAWINGS):
        measure = "worst_pole_distance" if kind == "distribution" else ""
        figure = plot_request(steps, FigureRequest(kind, "words", measure=measure))
        drawn = [axis for axis in figure.axes if axis.get_visible()]
        assert drawn and all(axis.has_data() for axis in drawn)
        assert all(axis.get_xlabel() or axis.get_ylabel() for axis in drawn)
        figure.savefig(io.BytesIO())


def test_responses_are_those_of_the_runs(steps):
    names = list(steps.results)
    figure = plot_request(steps, FigureRequest("responses", "", runs=names[:1], last=300))
    (line,) = figure.axes[0].get_lines()
    run = steps.results[names[0]].first.run
    assert np.array_equal(line.get_ydata(), run.z[:301, 0])
    both = lines(plot_request(steps, FigureRequest("responses", "", first=10, last=300)))
    assert set(both) == set(names) and {len(line.get_xdata()) for line in both.values()} == {291}


def test_long_signals_keep_their_peaks():
    values = np.random.default_rng(3).standard_normal(100_003)
    values[71_234] = 50.0
    k, shown = thinned(np.arange(len(values)), values)
    assert len(shown) < 2 * MANY and shown.max() == 50.0
    assert np.array_equal(values[k], shown) and (np.diff(k) > 0).all()
    assert thinned(np.arange(9), values[:9])[1] is not None


@pytest.mark.slow
def test_a_distribution_has_every_repetition(rounding):
    request = FigureRequest("distribution", "", measure="worst_pole_distance")
    figure = plot_request(rounding, request)
    points = [
        len(line.get_xdata()) for line in figure.axes[0].get_lines() if line.get_marker() == "o"
    ]
    assert points == [len(result.repetitions) for result in rounding.results.values()]
    assert figure.axes[0].get_xscale() == "log"


@pytest.mark.slow
def test_the_poles_asked_for_are_drawn(rounding):
    name = next(iter(rounding.results))
    figure = plot_request(rounding, FigureRequest("poles", "", runs=[name]))
    requested = lines(figure)["requested"]
    expected = rounding.results[name].first.comparison.requested_poles
    assert np.allclose(sorted(requested.get_xdata()), sorted(expected.real))


@pytest.fixture(scope="module")
def noisy():
    return verify(load_example("6.1"))


def test_costs_are_those_of_the_noise_that_is_named(noisy):
    def points(noise):
        request = FigureRequest("distribution", "", measure="h2_cost", noise=noise)
        lines = plot_request(noisy, request).axes[0].get_lines()
        return np.concatenate([x.get_xdata() for x in lines if x.get_marker() == "o"])

    assert np.allclose(points({"w": 4.0}), 4 * points({}), rtol=1e-12)


def test_disturbance_responses_stand_beside_lqg(noisy):
    answer = noisy
    figure = plot_request(answer, FigureRequest("disturbance response", ""))
    drawn = lines(figure)
    assert {"without control", "LQG", *answer.results} <= set(drawn)
    best = np.mean(np.square(drawn["LQG"].get_ydata()))
    of_its_plant = [
        name for name, result in answer.results.items()
        if result.first.plant == answer.main.first.plant
    ]  # fmt: skip
    for name in of_its_plant:
        assert np.mean(np.square(drawn[name].get_ydata())) > best * (1 - 1e-9)


def test_bad_requests_are_refused(steps):
    with pytest.raises(InputError, match="choose one of sheet"):
        FigureRequest("pie", "")
    with pytest.raises(InputError, match="names its measure"):
        FigureRequest("distribution", "")
    with pytest.raises(InputError, match="remove measure"):
        FigureRequest("poles", "", measure="rms")
    with pytest.raises(InputError, match="at least 11"):
        FigureRequest("responses", "", first=10, last=10)
    with pytest.raises(InputError, match="the run 'no'"):
        plot_request(steps, FigureRequest("responses", "", runs=["no"]))
    with pytest.raises(InputError, match="the measure 'no'"):
        plot_request(steps, FigureRequest("distribution", "", measure="no"))


@pytest.mark.costly
def test_the_examples_ask_for_figures_that_can_be_drawn():
    """Every shipped request names runs and measures that are there; some are drawn above."""
    count = 0
    for number in example_ids():
        for request in load_example(number).figures:
            assert request.caption.endswith("."), (number, request.caption)
            count += 1
    assert count > 50


def test_a_narrow_figure_stands_on_a_page_that_has_a_title(steps):
    request = FigureRequest("poles", "")
    narrow, wide = plot_request(steps, request, width=4.6), steps.plot(request)
    assert narrow._suptitle is None and wide.get_suptitle().startswith("2.1")
    assert narrow.get_figwidth() == 4.6
