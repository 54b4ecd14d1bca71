"""A numbered example of the dissertation as an experiment."""

from __future__ import annotations

from rcac_experiments.dissertation._examples import read_example
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import Experiment
from rcac_experiments.files._builder import build


def load_example(number: str, budget: ExperimentBudget | None = None) -> Experiment:
    """A numbered example of the dissertation.

    Examples
    --------
    >>> from rcac_experiments.dissertation import load_example
    >>> load_example("4.7").main_run.settings.k_w
    50
    """
    return build(*read_example(number), budget)
