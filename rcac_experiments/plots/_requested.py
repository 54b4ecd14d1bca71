"""The requested figures of an experiment, drawn from its verification."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from compensator_theory.errors import InputError
from rcac_experiments.experiments._estimation_studies import StudyResult
from rcac_experiments.experiments._experiment import RunResult, Verification
from rcac_experiments.experiments._figure_requests import FigureRequest, require_drawable
from rcac_experiments.plots._distributions import draw_distribution, draw_study_distribution
from rcac_experiments.plots._frequency_responses import draw_disturbance_response, draw_matches
from rcac_experiments.plots._histories import (
    draw_coefficients,
    draw_estimates,
    draw_outputs,
    draw_responses,
)
from rcac_experiments.plots._plant_zeros import draw_identified_zeros, draw_plant_zeros
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._pole_maps import draw_pole_maps
from rcac_numeric.plots._run import plot_sheet
from rcac_numeric.plots._style import draw_title, label_words

Results = Mapping[str, RunResult]
TITLED = 7.0  # inches from which a figure stands alone
Drawing = Callable[[Figure, Results, FigureRequest], None]


def plot_request(
    verification: Verification, request: FigureRequest, *, width: float = 9.0
) -> Figure:
    """Draw one figure of an experiment from its runs.

    Parameters
    ----------
    verification : Verification
    request : FigureRequest
    width : float
        In inches. A figure of less than 7 has no title: it stands on a page that has one.

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to a window.

    Raises
    ------
    InputError
        Where the request names a run or a measure that does not exist.

    Examples
    --------
    >>> from rcac_experiments import FigureRequest, verify
    >>> from rcac_experiments.plots import plot_request
    >>> from rcac_experiments.dissertation import load_example
    >>> verification = verify(load_example("2.1"))
    >>> figure = plot_request(verification, FigureRequest("responses", "What R_theta does."))
    >>> figure.axes[0].get_xlabel()
    'step $k$'
    """
    instance_of(verification, "verification", Verification)
    instance_of(request, "request", FigureRequest)
    results = verification.results
    experiment = verification.experiment
    title = f"{experiment.id}: {experiment.title}".strip(": ")
    if verification.estimates:
        return _titled(_study_figure(verification.estimates, request, width), title, width)
    require_drawable(request, results)
    chosen = {label_words(name): results[name] for name in request.runs or results}
    if request.kind == "sheet":
        return plot_sheet(next(iter(chosen.values())).first, title)
    figure = Figure(figsize=(width, 0.62 * width), layout="constrained")
    if request.kind not in DRAWINGS:
        raise InputError(f"no run estimates anything: a figure of {request.kind!r} shows nothing.")
    DRAWINGS[request.kind](figure, chosen, request)
    return _titled(figure, title, width)


def plot_verification(
    verification: Verification, request: FigureRequest | None = None, *, width: float = 9.0
) -> Figure:
    """Return the requested figure; by default that of the estimates, or a sheet on the main run."""
    experiment = verification.experiment
    if request is None and verification.estimates:
        request = next(iter(experiment.figures), FigureRequest("estimates", ""))
    if request is None:
        title = f"{experiment.id}: {experiment.title}".strip(": ")
        return plot_sheet(verification.main.first, title)
    return plot_request(verification, request, width=width)


def _study_figure(
    results: Mapping[str, StudyResult], request: FigureRequest, width: float
) -> Figure:
    """Plot a figure of an estimation example."""
    if request.kind not in OF_STUDIES:
        raise InputError(
            f"an estimation example has no figure of the kind {request.kind!r}; it has "
            f"{', '.join(OF_STUDIES)}."
        )
    if missing := [name for name in request.runs if name not in results]:
        raise InputError(f"a figure requests the run {missing[0]!r}; there are {list(results)}.")
    figure = Figure(figsize=(width, 0.62 * width), layout="constrained")
    chosen = {label_words(name): results[name] for name in request.runs or results}
    OF_STUDIES[request.kind](figure, chosen, request)
    return figure


def _titled(figure: Figure, title: str, width: float) -> Figure:
    if width >= TITLED:
        draw_title(figure, title)
    return figure


def _of_runs(draw: Callable[..., None]) -> Drawing:
    return lambda figure, results, request: draw(
        figure, {name: result.first.run for name, result in results.items()}, request
    )


def _pole_maps(figure: Figure, results: Results, request: FigureRequest) -> None:
    draw_pole_maps(figure, {name: result.first for name, result in results.items()})


DRAWINGS: dict[str, Drawing] = {
    "responses": draw_responses,
    "coefficients": draw_coefficients,
    "poles": _pole_maps,
    "disturbance response": draw_disturbance_response,
    "intercalated match": draw_matches,
    "distribution": draw_distribution,
    "plant zeros": _of_runs(draw_plant_zeros),
    "identified zeros": _of_runs(draw_identified_zeros),
}
OF_STUDIES: dict[str, Callable[[Figure, Mapping[str, StudyResult], FigureRequest], None]] = {
    "estimates": draw_estimates,
    "responses": draw_outputs,
    "distribution": draw_study_distribution,
}
