"""Pictures of runs and of other results: what is drawn are the numbers, and they are named."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from compensator_theory import place_poles
from compensator_theory.errors import InputError
from rcac_numeric import (
    LoopAnalysis,
    check_controller,
    load_run,
    loop_health,
    lqg_controller,
    observer_forms,
    plant_of,
    servo_plant,
    simulate,
    stability_margins,
    standard_plant,
)
from rcac_numeric.plots import plot_runs
from rcac_numeric.plots._coefficients import coefficient_names
from tests.rcac_numeric import samples
from tests.support.examples import EXAMPLE_2_1, EXAMPLE_4_7


@pytest.fixture(scope="module")
def compared():
    return {name: loop.run() for name, loop in EXAMPLE_2_1.items()}


def test_several_runs_share_their_axes(compared):
    figure = plot_runs(list(compared.values()), labels=list(compared))
    z, u, *thetas = figure.axes
    for axis, signal in ((z, "z"), (u, "u")):
        assert [line.get_label() for line in axis.lines] == list(compared)
        for line, run in zip(axis.lines, compared.values(), strict=True):
            assert np.array_equal(line.get_ydata(), getattr(run, signal)[:, 0])
        looks = {(line.get_color(), line.get_linestyle()) for line in axis.lines}
        assert len({colour for colour, _ in looks}) == len({dash for _, dash in looks}) == 2
    for axis, run in zip(thetas, compared.values(), strict=True):
        assert [t.get_text() for t in axis.get_legend().get_texts()] == [
            f"${name}$" for name in coefficient_names(run)
        ]
        assert np.array_equal(axis.lines[0].get_ydata(), run.theta[:, 0])
    assert z.get_yscale() == "symlog" and u.get_yscale() == "linear"


def test_signals_are_chosen_and_drawn_in_axes_of_ones_own(compared):
    run = next(iter(compared.values()))
    figure = Figure(figsize=(8, 5))
    axes = figure.subplots(2, 2)
    assert run.plot(signals=["u", "theta"], ax=axes[:, 0]) is figure
    assert np.array_equal(axes[0, 0].lines[0].get_ydata(), run.u[:, 0])
    assert np.array_equal(axes[1, 0].lines[0].get_ydata(), run.theta[:, 0])
    assert axes[1, 0].get_xlabel() == "step $k$" and not axes[0, 1].lines
    alone = run.plot(signals=["y"], width=3.5)
    assert len(alone.axes) == 1 and alone.get_figwidth() == 3.5
    for wrong, words in (
        ({"signals": ["x"]}, "choose one of w, y"),
        ({"signals": []}, "nothing to draw"),
        ({"ax": axes[0, 0]}, "3 are drawn"),
    ):
        with pytest.raises(InputError, match=words):
            run.plot(**wrong)


def test_a_sample_time_makes_seconds():
    plant = servo_plant(plant_of("1/(10*s + 1)", sample_time=0.5))
    run = simulate(plant, samples.adaptive(1), np.ones((20, 3)))
    figure = run.plot(signals=["z", "theta"])
    for axis in figure.axes:
        assert np.array_equal(axis.lines[0].get_xdata(), 0.5 * np.arange(20))
    assert figure.axes[-1].get_xlabel() == "time $t$, s"


def test_names_of_coefficients_are_what_they_multiply():
    """u(k) made again from the named signals."""
    run = samples.run(5)
    names, k = coefficient_names(run), 9
    u = sum(
        run.theta[k, i] * getattr(run, name[0])[k - int(name[4:-1]), 0]
        for i, name in enumerate(names)
    )
    assert np.isclose(u, run.u[k, 0])


def test_bad_comparisons_are_refused(compared):
    with pytest.raises(InputError, match="no run"):
        plot_runs([])
    with pytest.raises(InputError, match="2 runs have 1 labels"):
        plot_runs(list(compared.values()), labels=["one"])
    with pytest.raises(InputError, match="a run"):
        plot_runs([3])


@pytest.mark.slow
def test_notebooks_show_results_in_their_own_ink(tmp_path):
    run = EXAMPLE_4_7.run()
    run.save(tmp_path / "run.npz")
    check = check_controller(load_run(tmp_path / "run.npz"))
    margins = stability_margins(run)
    for shown in (run, LoopAnalysis(run), check, margins, loop_health(run)):
        text = shown._repr_html_()
        assert text.startswith('<div class="rcac">') and text.rstrip().endswith("</div>")
        assert "#000000" not in text and "currentColor" in text
    assert "Warning (small margins)" in run._repr_html_()


def test_results_in_numbers_are_latex_and_pictures():
    design = lqg_controller(standard_plant("(q - 0.5)/((q - 1.2)*(q - 0.3))"))
    text = design._repr_latex_()
    for part in design.state_space:
        assert all(f"{entry:.4g}" in text for entry in part.ravel())
    drawn = [line.get_xdata() for line in design.plot().axes[0].lines[1:]]
    assert np.allclose(np.sort(np.concatenate(drawn)), np.sort(design.poles.real))
    compensator = place_poles("1/((s+1)*(s+2))", [-3, -4, -5, -6], feedback=1).compensator
    forms = observer_forms("1/((s+1)*(s+2))", compensator)
    assert forms._repr_latex_().count("K_{") == min(len(forms), 6)
    assert np.array_equal(forms.plot().axes[1].lines[0].get_ydata(), forms.condition)


def test_what_was_kept_of_theta_is_seen_whatever_the_stride():
    """With one row kept the axes were empty: theta(0) is zero, and the last one stood nowhere."""
    case = EXAMPLE_4_7.run(stride=100)
    assert len(case.theta) == 1
    figure = plot_runs([case], signals=["theta"])
    for line, last in zip(figure.axes[0].lines, case.theta_final, strict=True):
        assert line.get_ydata().tolist() == [0.0, last]
        assert line.get_xdata()[-1] == case.steps and line.get_marker() == "."
