"""From claims and runs to verdicts: computed, never typed in."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.arrays.showing import notebook_of, picture_of, report_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.estimation.studies import MEASURES as ESTIMATION_MEASURES
from rcac_numeric.experiments.estimation.studies import StudyResult
from rcac_numeric.experiments.experiment import Experiment, RunResult
from rcac_numeric.experiments.figure_requests import STANDARD_FIGURES, FigureRequest
from rcac_numeric.experiments.format.places import did_you_mean
from rcac_numeric.experiments.judging.claim import Measured, Verdict, judged
from rcac_numeric.experiments.judging.interval import Check
from rcac_numeric.experiments.measures.measures import MEASURES


@dataclass(frozen=True, eq=False)
class Verification(Value):
    """An experiment after its runs: results, estimates of its studies, and verdicts.

    Examples
    --------
    >>> from rcac_numeric import verify
    >>> from rcac_numeric.dissertation import load_example
    >>> verification = verify(load_example("4.7"))
    >>> [v.verdict for v in verification.verdicts][0]
    'reproduced'
    >>> verification.main.first.comparison.worst_distance < 1e-5
    True
    """

    experiment: Experiment
    results: Mapping[str, RunResult]
    verdicts: tuple[Verdict, ...]
    estimates: Mapping[str, StudyResult] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "results", dict(self.results))
        object.__setattr__(self, "estimates", dict(self.estimates))

    @property
    def main(self) -> RunResult:
        """The result of the experiment's main run."""
        if not self.results:
            what = "estimates: no controller" if self.estimates else "is exact: nothing"
            raise InputError(f"{self.experiment.id or 'this'} {what} ran, or is drawn.")
        return next(iter(self.results.values()))

    @property
    def diverged(self) -> list[str]:
        """Names of the runs that diverged."""
        return [name for name, result in self.results.items() if result.diverged]

    @property
    def surprising(self) -> list[str]:
        """Names of the runs that did not end as their specification says."""
        return [name for name, result in self.results.items() if not result.as_expected]

    def report(self) -> str:
        """The whole verification in words and numbers."""
        return report_of(self)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return self.report().split("\n\n", 1)[0]  # its name and the health of its loop

    def _repr_html_(self) -> str:
        """What a notebook shows: the report and, where something ran, its sheet of pictures."""
        return notebook_of(self, self.plot if self.results else None)

    @property
    def figure_requests(self) -> tuple[FigureRequest, ...]:
        """The figures that the experiment asks for; the usual ones where it asks for none."""
        if self.experiment.figures:
            return tuple(self.experiment.figures)
        if self.estimates:
            return (FigureRequest("estimates", "What is estimated."),)
        return STANDARD_FIGURES if self.results else ()

    def plot(self, request: FigureRequest | None = None, *, width: float = 9.0) -> figures.Figure:
        """One sheet on the main run; or the figure that is asked for, so many inches wide.

        `figure_requests` are those that an example asks for, or the usual ones.
        """
        return picture_of(self, request, width=width)

    @property
    def exit_status(self) -> int:
        """0: done; 1: a verdict of record has changed; 3: a loop diverged unexpectedly.

        3 goes before 1. A run that was expected to diverge and did not is a changed verdict, 1.
        """
        if any(self.results[name].diverged for name in self.surprising):
            return 3
        return 1 if self.surprising or any(v.has_changed for v in self.verdicts) else 0


def verify(
    experiment: Experiment, progress: Callable[[str], None] = lambda name: None
) -> Verification:
    """Run every run of an experiment and judge every claim.

    Parameters
    ----------
    experiment : Experiment
        From `load_example` or `load_experiment`.
    progress : callable
        Called with the name of each run before it starts.

    Raises
    ------
    InputError
        Where a claim names a measure or a run that does not exist.

    Examples
    --------
    >>> from rcac_numeric import verify
    >>> from rcac_numeric.dissertation import load_example
    >>> verify(load_example("2.2")).exit_status
    0
    """
    for claim in experiment.claims:
        for check in claim.checks:
            if isinstance(check, Check):
                _known(check, experiment)
    results = {}
    for name, specification in experiment.runs.items():
        progress(name)
        results[name] = specification.execute()
    estimates = {}
    for name, study in experiment.studies.items():
        progress(name)
        estimates[name] = study.execute()
    measured: dict[str, Measured] = {**results, **estimates}
    verdicts = tuple(
        judged(claim, measured, experiment.reduced_runs) for claim in experiment.claims
    )
    return Verification(experiment, results, verdicts, estimates)


def _known(check: Check, experiment: Experiment) -> None:
    """Refuse a check that could not be evaluated, before anything runs."""
    known: Mapping[str, Callable[..., float]] = MEASURES
    if experiment.studies:
        known = ESTIMATION_MEASURES
    if check.measure not in known:
        raise InputError(
            f"a claim asks for the measure {check.measure!r}; known are {', '.join(known)}."
            f"{did_you_mean(check.measure, known)}"
        )
    try:
        inspect.signature(known[check.measure]).bind(None, **check.arguments)
    except TypeError as error:
        raise InputError(f"the check {check.measure!r} of a claim: {error}.") from None
    repeated = {name: run.seeds * run.repetitions for name, run in experiment.runs.items()}
    repeated |= {name: study.seeds for name, study in experiment.studies.items()}
    for name in (check.run, check.relative_to):
        if name and name not in repeated:
            raise InputError(
                f"a claim refers to the run {name!r}; the runs are {', '.join(repeated)}."
                f"{did_you_mean(name, repeated)}"
            )
    if len({repeated[name] for name in (check.run, check.relative_to) if name}) > 1:
        raise InputError(
            f"a claim divides a measure of {check.run!r} by that of {check.relative_to!r}, "
            "repetition by repetition; give them as many seeds and repetitions."
        )
