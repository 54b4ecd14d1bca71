"""One case of a page as text: claims with verdicts, report and figures."""

from __future__ import annotations

import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.experiments._experiment import Verification
from rcac_experiments.judging._claim import HOLDS, MISPRINT, REPRODUCED, Verdict
from rcac_experiments.reports._single import page_figures
from rcac_experiments.reports._verification import map_lines, verification_sheet
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import in_a_line, shortened
from rcac_numeric.reports._rendering import HOME, sheet_html, whole_page
from rcac_numeric.reports._sheet import Sheet
from rcac_numeric.reports._svg import svg_of

FIRST = 2  # sections of the report before the figures: problem and claims


@dataclass(frozen=True)
class ClaimRow(Value):
    """A claim and its verdict, in words.

    Attributes
    ----------
    owner : str
        A key of `judging.claim.CLASSES`.
    quote, place, reading, text : str
        The words of the source and where they stand, how they are read, and what is checked.
    measured, verdict, words : str
        What was measured; the verdict, and the verdict with what it depends on.
    notes : tuple of str
        What is corrected or chosen, for which completions it holds, where its checks succeed.
    reason, run, was : str
        Why it does not hold; the variant that it is judged on; the verdict of record where another
        one came out.
    """

    owner: str
    quote: str
    place: str
    reading: str
    text: str
    measured: str
    verdict: str
    words: str
    notes: tuple[str, ...]
    reason: str
    run: str
    was: str


@dataclass(frozen=True)
class Picture(Value):
    """A figure and its title."""

    title: str
    svg: str

    @property
    def anchor(self) -> str:
        """The id of its SVG, by which it is drawn again, small; empty where nothing is drawn."""
        return self._attribute("id")

    @property
    def box(self) -> str:
        """The visible part of the plane: the viewBox of the SVG."""
        return self._attribute("viewBox")

    def _attribute(self, name: str) -> str:
        match = re.match(rf'<svg\b[^>]*\b{name}="([\w .-]+)"', self.svg)
        return match[1] if match else ""


@dataclass(frozen=True)
class Case(Value):
    """The content of a page about one experiment, as text that can be stored.

    Attributes
    ----------
    id, title, source : str
    status : int
        The exit status that `rcac verify` has for it.
    claims : tuple of ClaimRow
    body, details : str
        HTML of its report: the problem, the claims and the notes; runs and controller.
    pictures : tuple of Picture
    settings : str
        Seeds and arithmetic of its runs.
    """

    id: str
    title: str
    source: str
    status: int
    claims: tuple[ClaimRow, ...]
    body: str
    details: str
    pictures: tuple[Picture, ...]
    settings: str

    @property
    def anchor(self) -> str:
        """The anchor of the case on a page."""
        return "e" + re.sub(r"[^A-Za-z0-9.-]+", "-", self.id)

    @property
    def chapter(self) -> str:
        """The chapter of the number; empty without a number."""
        match = re.match(r"([1-9]|[A-B])\.\d", self.id)
        return match[1] if match else ""

    def to_record(self) -> dict[str, Any]:
        """Return the case as a JSON object."""
        return asdict(self)

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Case:
        """Read the result of `to_record`."""
        try:
            claims = tuple(
                ClaimRow(**{**row, "notes": tuple(row["notes"])}) for row in record["claims"]
            )
            pictures = tuple(Picture(**picture) for picture in record["pictures"])
            return cls(**{**record, "claims": claims, "pictures": pictures})
        except (KeyError, TypeError) as error:
            raise InputError(f"the record must be a case of a page: {error}.") from None


def case_of(verification: Verification) -> Case:
    """Return the case of a verification."""
    experiment = verification.experiment
    sheet = verification_sheet(verification)
    name = experiment.id or "case"
    return Case(
        id=name,
        title=experiment.title,
        source=experiment.source,
        status=verification.exit_status,
        claims=tuple(map(_row, verification.verdicts)),
        body=sheet_html(replace(sheet, sections=sheet.sections[:FIRST]), level=3),
        details=sheet_html(Sheet("", sections=sheet.sections[FIRST:]), level=3),
        pictures=_pictures(verification, name),
        settings=_settings(verification),
    )


def _row(verdict: Verdict) -> ClaimRow:
    claim = verdict.claim
    corrected = [("misprint", claim.misprint), ("chosen", claim.completion)]
    return ClaimRow(
        owner=claim.owner,
        quote=claim.quote,
        place=claim.place,
        reading=claim.reading,
        text=claim.text,
        measured=verdict.measured,
        verdict=verdict.verdict,
        words=verdict.words,
        notes=(*(f"{name}: {words}" for name, words in corrected if words), *map_lines(verdict)),
        reason="" if verdict.verdict in (REPRODUCED, MISPRINT, HOLDS) else claim.reason,
        run=claim.run,
        was=claim.recorded if verdict.has_changed else "",
    )


def _pictures(verification: Verification, name: str) -> tuple[Picture, ...]:
    if not (verification.results or verification.estimates):
        return ()
    prefix = re.sub(r"[^A-Za-z0-9]+", "-", name)
    try:
        drawn = page_figures(verification)
    except CompensatorError as error:
        return (Picture(f"No figure: {shortened(str(error))}", ""),)
    return tuple(
        Picture(title, svg_of(figure, f"p{prefix}-{i}", f"{name}: {title}"))
        for i, (title, figure) in enumerate(drawn.items())
    )


def _settings(verification: Verification) -> str:
    """Return arithmetic, seed and steps of each run in one line."""
    studies = verification.experiment.studies
    return "; ".join(
        [
            f"{name}: {run.algorithm}, seed {run.seed}, {run.steps} steps"
            for name, run in verification.experiment.runs.items()
        ]
        + [
            f"{name}: {study.estimator.words}, {study.seeds} seeds from {study.seed}, "
            f"{study.steps} steps"
            for name, study in studies.items()
        ]
    )


NAMED = ("compensator-theory", "numpy", "scipy", "sympy", "python-flint", "matplotlib")


def case_page(case: Case, *, template: str = "case.html", home: str = HOME, **more: Any) -> str:
    """Return the HTML page of one case."""
    title = in_a_line(f"{case.id}: {case.title}".strip(": "))
    lead = case.source or "A case with its claims and measured values."
    values: dict[str, Any] = {
        "title": title,
        "lead": lead,
        "case": case,
        "made": versions_of([case]),
    }
    return whole_page(template, home, **values, **more)


def versions_of(cases: Sequence[Case]) -> dict[str, Any]:
    """Return versions, machine and seeds, on which the numbers of a page depend."""
    machine = f"Python {platform.python_version()}, {platform.system()} on {platform.machine()}"
    versions = [f"{name} {version(name)}" for name in NAMED]
    return {"versions": versions, "machine": machine, "cases": cases}
