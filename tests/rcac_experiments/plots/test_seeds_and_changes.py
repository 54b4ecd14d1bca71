"""Figures of runs with seeds, of plants that change and of loops that diverge."""

import numpy as np
import pytest

from rcac_experiments import FigureRequest, verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.files._builder import build
from rcac_experiments.plots import plot_request
from rcac_numeric import lqg_controller
from rcac_numeric.arrays._values import replaced as replace

SEEDS = 4


@pytest.fixture(scope="module")
def changing():
    """Example 5.1 with its plant changing at step 300."""
    table = {
        "plant": {
            "problem": "standard", "G": "(q - 0.5)/((q - 0.9)*(q - 0.8))",
            "changes": [{"start": 300, "gain": 2}, {"start": 450, "gain": 3}],
        },
        "signals": {"w": {"white_noise": 0.1}},
        "target": {"model": "fir"},
        "controller": {"n_c": 4, "R_theta": 1e-3},
        "run": {"steps": 600, "seeds": SEEDS},
        "runs": [{"name": "a"}, {"name": "no change", "plant": {"changes": []}}],
    }  # fmt: skip
    return verify(build(table, "case"))


def labelled(axis):
    return dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))


@pytest.mark.parametrize("kind", ["responses", "coefficients"])
@pytest.mark.parametrize(
    ("first", "last", "starts"), [(0, None, [300, 450]), (310, 500, [450]), (460, 500, [])]
)
def test_changes_of_the_plant_are_marked_where_they_are_shown(changing, kind, first, last, starts):
    request = FigureRequest(kind, "", runs=["a"], first=first, last=last)
    axis = plot_request(changing, request).axes[0]
    marks = [x for x in axis.get_lines() if len(x.get_xdata()) == 2 and len({*x.get_xdata()}) == 1]
    assert [mark.get_xdata()[0] for mark in marks] == starts
    assert ("the plant changes" in labelled(axis)) == bool(starts)
    same = plot_request(changing, FigureRequest(kind, "", runs=["no change"]))
    assert "the plant changes" not in labelled(same.axes[0])


def test_magnitudes_of_seeds_are_a_median_in_a_band(changing):
    request = FigureRequest("responses", "", runs=["a"], magnitude=True, first=100, last=399)
    axis = plot_request(changing, request).axes[0]
    (line,) = [x for x in axis.get_lines() if "median" in str(x.get_label())]
    z = np.array([r.run.z[100:400, 0] for r in changing.results["a"].repetitions])
    assert line.get_label().endswith(f"{SEEDS} seeds")
    assert np.allclose(line.get_ydata(), np.median(np.abs(z), axis=0))
    (band,) = axis.collections
    heights = band.get_paths()[0].vertices[:, 1]
    assert heights.max() == pytest.approx(np.abs(z).max())
    assert heights.min() == pytest.approx(np.abs(z).min())


def test_one_of_several_seeds_says_so(changing):
    axis = plot_request(changing, FigureRequest("responses", "", runs=["a"])).axes[0]
    assert f"a, one of {SEEDS} seeds" in labelled(axis)


@pytest.mark.parametrize("kind", ["disturbance response", "intercalated match"])
def test_frequency_responses_of_seeds_are_a_median_in_a_band(changing, kind):
    axis = plot_request(changing, FigureRequest(kind, "", runs=["a"])).axes[0]
    curve = labelled(axis)[f"a: median and range of {SEEDS} seeds"]
    repetitions = changing.results["a"].repetitions
    omega = curve.get_xdata()
    if kind == "intercalated match":
        every = [np.abs(r.match.reached[:, 0, 0]) for r in repetitions]
    else:
        every = [np.abs(r.loop.frequency_response(omega)[:, 0, 0]) for r in repetitions]
    assert np.allclose(curve.get_ydata(), np.median(every, axis=0))
    heights = axis.collections[0].get_paths()[0].vertices[:, 1]
    assert heights.max() == pytest.approx(np.max(every))


@pytest.mark.costly
def test_several_lqg_designs_stand_in_one_pair_of_axes():
    example = load_example("4.5")
    (run,) = [replace(example.runs["as printed"], steps=300, stride=100, seeds=1)]
    verification = verify(replace(example, runs={"as printed": run}, claims=()))
    designs = [{"d": 1.0, "v": value} for value in (0.05, 2.0)]
    request = FigureRequest("disturbance response", "", channel="d", designs=designs)
    drawn = labelled(plot_request(verification, request).axes[0])
    assert "LQG" not in drawn
    for noise in designs:
        curve = drawn[f"LQG, d = 1, v = {noise['v']:g}"]
        loop = lqg_controller(run.plant, noise=noise).loop
        column = list(run.plant.channels).index("d")
        expected = np.abs(loop.frequency_response(curve.get_xdata())[:, 0, column])
        assert np.allclose(curve.get_ydata(), expected)


def test_two_target_models_are_both_drawn():
    example = load_example("2.5")
    runs = {name: replace(run, steps=60) for name, run in example.runs.items()}
    verification = verify(replace(example, runs=runs, claims=()))
    names = ["(2.50)", "(2.50), k_w = 50", "(2.49)"]
    drawn = labelled(
        plot_request(verification, FigureRequest("intercalated match", "", runs=names)).axes[0]
    )
    assert {"$G_f$", "$G_f$ of (2.49)"} <= set(drawn)
    assert sum("G_f" in label for label in drawn) == 2


@pytest.mark.costly
@pytest.mark.parametrize("magnitude", [False, True])
def test_a_run_that_diverged_does_not_blow_up_the_axis(magnitude):
    verification = verify(replace(load_example("2.5"), claims=()))
    axis = plot_request(verification, FigureRequest("responses", "", magnitude=magnitude)).axes[0]
    remaining = [r for r in verification.results.values() if not r.diverged]
    largest = max(np.abs(r.first.run.z).max() for r in remaining)
    assert largest <= axis.get_ylim()[1] <= (1000 if magnitude else 2) * largest
    crosses = [x for x in axis.get_lines() if x.get_marker() == "x"]
    low, high = axis.get_ylim()
    assert len(crosses) == 2 and all(low <= x.get_ydata()[0] <= high for x in crosses)
