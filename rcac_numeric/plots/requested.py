"""The figures that an experiment asks for, drawn from its verification."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from matplotlib.figure import Figure

from rcac_numeric.arrays.validation import instance_of
from rcac_numeric.experiments.experiment import RunResult
from rcac_numeric.experiments.figure_requests import FigureRequest, require_drawable
from rcac_numeric.experiments.verdicts import Verification
from rcac_numeric.plots.distributions import draw_distribution
from rcac_numeric.plots.frequency_responses import draw_disturbance_response, draw_matches
from rcac_numeric.plots.histories import draw_coefficients, draw_responses
from rcac_numeric.plots.pole_maps import draw_pole_maps
from rcac_numeric.plots.run import plot_sheet
from rcac_numeric.plots.style import draw_title

Results = Mapping[str, RunResult]
TITLED = 7.0  # inches from which a figure stands alone
Drawing = Callable[[Figure, Results, FigureRequest], None]


def plot_request(
    verification: Verification, request: FigureRequest, *, width: float = 9.0
) -> Figure:
    """Draw one figure of an experiment from what its runs have left.

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
    >>> from rcac_numeric import FigureRequest, load_example, plot_request, verify
    >>> found = verify(load_example("2.1"))
    >>> figure = plot_request(found, FigureRequest("responses", "What R_theta does."))
    >>> figure.axes[0].get_xlabel()
    'step $k$'
    """
    instance_of(verification, "verification", Verification)
    instance_of(request, "request", FigureRequest)
    results = verification.results
    require_drawable(request, results)
    chosen = {name: results[name] for name in request.runs or results}
    experiment = verification.experiment
    title = f"{experiment.id}: {experiment.title}".strip(": ")
    if request.kind == "sheet":
        return plot_sheet(next(iter(chosen.values())).first, title)
    figure = Figure(figsize=(width, 0.62 * width), layout="constrained")
    DRAWINGS[request.kind](figure, chosen, request)
    if width >= TITLED:
        draw_title(figure, title)
    return figure


DRAWINGS: dict[str, Drawing] = {
    "responses": draw_responses,
    "coefficients": draw_coefficients,
    "poles": draw_pole_maps,
    "disturbance response": draw_disturbance_response,
    "intercalated match": draw_matches,
    "distribution": draw_distribution,
}
