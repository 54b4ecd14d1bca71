"""The command `rcac reproduce`: all examples, or those of a chapter, and one page of them."""

from __future__ import annotations

import os
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import click

from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from rcac_numeric.cli.output import as_json_option, show
from rcac_numeric.dissertation.archive import write_archive
from rcac_numeric.dissertation.examples import example_ids
from rcac_numeric.dissertation.load import load_example
from rcac_numeric.dissertation.pages import headline
from rcac_numeric.dissertation.reproduction import Reproduction, reduced, reproduce
from rcac_numeric.dissertation.workers import case_workers
from rcac_numeric.experiments.judging.claim import OURS, READING, TEXT, VERDICTS
from rcac_numeric.reports.page.cases import Case
from rcac_numeric.reports.sheets.sheet import Block, Fact, Section, Sheet, Table, Text, cells

LARGEST_JOBS = 256


def _checked_archive(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
    """The option --archive, whose file is refused before anything long is run."""
    if value is not None and value.suffix.lower() != ".zip":
        raise InputError(f"--archive {value}: the name must end in .zip.")
    if value is not None and not value.parent.is_dir():
        raise InputError(f"--archive {value}: there is no folder {value.parent}.")
    return value


@click.command("reproduce")
@click.option("--chapter", help="Only the examples of this chapter: 2, 4, A, ...")
@click.option(
    "--quick",
    is_flag=True,
    help="A quick look: repeat runs less often; no verdict is called changed for it.",
)
@click.option(
    "-o", "--output", "folder", type=click.Path(file_okay=False, path_type=Path), required=True,
    help="The folder for index.html and for what is done already.",
)  # fmt: skip
@click.option(
    "--jobs", type=click.IntRange(1, LARGEST_JOBS), default=None,
    help="Processes; by default as many as there are processors.",
)  # fmt: skip
@click.option(
    "--archive", type=click.Path(dir_okay=False, path_type=Path), callback=_checked_archive,
    help="Write the page, its data, the files, the sources and all versions into this .zip file.",
)  # fmt: skip
@as_json_option
def reproduce_command(
    chapter: str | None,
    quick: bool,
    folder: Path,
    jobs: int | None,
    archive: Path | None,
    as_json: bool,
) -> int:
    """Verify the examples of the dissertation and write a page of them.

    What is done is kept: after a kill the same command goes on where it was.
    """
    numbers = [n for n in example_ids() if chapter is None or n.split(".")[0] == chapter.upper()]
    if not numbers:
        raise InputError(f"there is no example of chapter {chapter!r}; see `rcac list`.")
    require_library("matplotlib")
    experiments = [load_example(number).held_out() for number in numbers]
    if quick:
        experiments = [reduced(experiment) for experiment in experiments]
    count = min(jobs or os.cpu_count() or 1, len(experiments))
    with case_workers(count) as executor:
        found = reproduce(
            experiments,
            folder,
            executor=executor,
            progress=_progress if sys.stderr.isatty() else _silence,
        )
    if sys.stderr.isatty():
        click.echo("\r\033[K", err=True, nl=False)
    if archive is not None:
        write_archive(found, archive)
    show(_sheet(found, archive), as_json)
    return found.exit_status


def _progress(name: str, done: int, of: int) -> None:
    width = 30
    bar = "=" * (width * done // of)
    click.echo(f"\r[{bar:<{width}}] {done} of {of}, {name} is done\033[K", err=True, nl=False)


def _silence(name: str, done: int, of: int) -> None:
    """Say nothing of what is done."""


def _sheet(found: Reproduction, archive: Path | None) -> Sheet:
    rows = tuple(cells(case.id, case.title, _verdicts(case), _end(case)) for case in found.cases)
    counts = headline(found.cases)
    record = {
        "page": str(found.page),
        "verdicts": {
            whose: {verdict: count[verdict] for verdict in VERDICTS}
            for whose, count in counts.items()
        },
        "examples": [
            {"id": case.id, "status": case.status, "verdicts": [c.verdict for c in case.claims]}
            for case in found.cases
        ],
    }
    blocks: tuple[Block, ...] = (
        Table(("example", "title", "claims", "outcome"), rows),
        Fact("sentences of the text", _words(counts[TEXT])),
        Fact("sentences that leave room", _words(counts[READING])),
        Fact("page", str(found.page)),
        *([] if archive is None else [Fact("archive", str(archive))]),
    )
    return Sheet("The dissertation's examples", sections=(Section("", blocks, record),))


def _verdicts(case: Case) -> str:
    return _words(Counter(row.verdict for row in case.claims if row.whose != OURS))


def _words(count: Counter[str]) -> str:
    return ", ".join(f"{count[verdict]} {verdict}" for verdict in VERDICTS if count[verdict])


def _end(case: Case) -> Text:
    told = {
        0: Text("as on record", "quiet"),
        1: Text("a verdict has changed", "bad"),
        2: Text("could not be verified", "bad"),
        3: Text("diverged unexpectedly", "bad"),
    }
    return told[case.status]
