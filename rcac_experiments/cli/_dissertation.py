"""The commands about the dissertation: `rcac reproduce` and `rcac errata`."""

from __future__ import annotations

import os
import sys
from collections import Counter
from pathlib import Path

import click
import numpy as np

from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from rcac_experiments.cli._output import as_json_option, no_progress, show, writable
from rcac_experiments.dissertation._archive import write_archive
from rcac_experiments.dissertation._checking import can_run, check_erratum
from rcac_experiments.dissertation._examples import example_ids
from rcac_experiments.dissertation._load import load_example
from rcac_experiments.dissertation._pages import headline
from rcac_experiments.dissertation._reading import find_errata
from rcac_experiments.dissertation._reproduction import (
    Reproduction,
    case_workers,
    reduced,
    reproduce,
)
from rcac_experiments.dissertation._sheet import errata_sheet
from rcac_experiments.judging._claim import OURS, READING, TEXT, VERDICTS
from rcac_experiments.reports._cases import Case
from rcac_numeric.reports._sheet import Block, Fact, Section, Sheet, SheetTable, Text, cells

LARGEST_JOBS = 256


@click.command("reproduce")
@click.option("--chapter", help="Only the examples of this chapter: 2, 4, A, ...")
@click.option(
    "--quick",
    is_flag=True,
    help="Repeat runs less often; a changed verdict is then not reported.",
)
@click.option(
    "-o", "--output", "folder", type=click.Path(file_okay=False, path_type=Path), required=True,
    help="The folder for index.html and for completed cases.",
)  # fmt: skip
@click.option(
    "--jobs", type=click.IntRange(1, LARGEST_JOBS), default=None,
    help="Number of processes; default: number of processors.",
)  # fmt: skip
@click.option(
    "--archive", type=click.Path(dir_okay=False, path_type=Path), callback=writable(".zip"),
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
    """Verify the examples of the dissertation and write a page of the results.

    Completed cases are stored: after an interruption the same command continues.
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
        result = reproduce(
            experiments,
            folder,
            executor=executor,
            progress=_progress if sys.stderr.isatty() else no_progress,
        )
    if sys.stderr.isatty():
        click.echo("\r\033[K", err=True, nl=False)
    if archive is not None:
        write_archive(result, archive)
    show(_sheet(result, archive), as_json)
    return result.exit_status


def _progress(name: str, done: int, of: int) -> None:
    width = 30
    bar = "=" * (width * done // of)
    click.echo(f"\r[{bar:<{width}}] {done} of {of}, {name} completed\033[K", err=True, nl=False)


def _sheet(reproduction: Reproduction, archive: Path | None) -> Sheet:
    rows = tuple(
        cells(case.id, case.title, _verdicts(case), _end(case)) for case in reproduction.cases
    )
    counts = headline(reproduction.cases)
    record = {
        "page": str(reproduction.page),
        "verdicts": {
            owner: {verdict: count[verdict] for verdict in VERDICTS}
            for owner, count in counts.items()
        },
        "examples": [
            {"id": case.id, "status": case.status, "verdicts": [c.verdict for c in case.claims]}
            for case in reproduction.cases
        ],
    }
    blocks: tuple[Block, ...] = (
        SheetTable(("example", "title", "claims", "outcome"), rows),
        Fact("sentences of the text", _words(counts[TEXT])),
        Fact("sentences that leave room", _words(counts[READING])),
        Fact("page", str(reproduction.page)),
        *([] if archive is None else [Fact("archive", str(archive))]),
    )
    return Sheet("The dissertation's examples", sections=(Section("", blocks, record),))


def _verdicts(case: Case) -> str:
    return _words(Counter(row.verdict for row in case.claims if row.owner != OURS))


def _words(count: Counter[str]) -> str:
    return ", ".join(f"{count[verdict]} {verdict}" for verdict in VERDICTS if count[verdict])


def _end(case: Case) -> Text:
    messages = {
        0: Text("verdicts as on record", "quiet"),
        1: Text("a verdict has changed", "bad"),
        2: Text("could not be verified", "bad"),
        3: Text("diverged unexpectedly", "bad"),
    }
    return messages[case.status]


@click.command("errata")
@click.argument("where", nargs=-1)
@click.option("--check", "checks", is_flag=True, help="Run the checks that prove the errors.")
@as_json_option
def errata(where: tuple[str, ...], checks: bool, as_json: bool) -> int:
    """List the errors in the text of the dissertation, with corrections and evidence.

    WHERE is a chapter (8, A), an equation ("(2.31)"), an example (Example 7.1), a number of
    several items (7.1), or the name of an erratum; default: all errata.
    """
    place = " ".join(where)
    entries = find_errata(place)
    with np.errstate(all="ignore"):
        results = {
            entry.name: check_erratum(entry) for entry in entries if checks and can_run(entry)
        }
    show(errata_sheet(entries, place, results), as_json)
    return 0 if all(checked.holds for checked in results.values()) else 1
