"""The command `rcac explore`: a page on which a loop is run live."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from rcac_experiments.cli._cases import complete_case, read_case_table, values_option, with_values
from rcac_experiments.cli._output import as_json_option, budget_option, show, writable_page
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.explorer._case import case_of
from rcac_experiments.explorer._page import explorer_page
from rcac_numeric.reports._rendering import write_page
from rcac_numeric.reports._sheet import Fact, Section, Sheet


@click.command("explore")
@click.argument("case", required=False, shell_complete=complete_case)
@click.option("-o", "--output", "path", required=True, callback=writable_page,
              type=click.Path(dir_okay=False, path_type=Path),
              help="The page that is written.")  # fmt: skip
@click.option("--run", "name", help="Which run of CASE; default: the first.")
@values_option
@budget_option(of_runs=True)
@as_json_option
def explore(
    *,
    case: str | None,
    path: Path,
    name: str | None,
    values: tuple[str, ...],
    as_json: bool,
    budget: ExperimentBudget,
) -> None:
    """Write a page on which a loop under RCAC runs live: drag poles, move dials.

    CASE is the number of an example (see `rcac list`) or the path of a TOML file; without it the
    page has its own scenes alone. The page asks no network, and hands its settings back as a file
    for `rcac verify`. It needs clang and lld here, which build the core for it.
    """
    with np.errstate(all="ignore"):
        found = None
        if case is not None:
            table, file = read_case_table(case)
            found = case_of(with_values(table, values), file, name, budget)
        elif values or name:
            raise click.UsageError("--set and --run belong to a CASE.")
        page = explorer_page(found)
    write_page(page, path)
    title = "its own scenes" if found is None else str(found["title"])
    facts = (Fact("page", str(path)), Fact("opens with", title), Fact("size", f"{len(page)} bytes"))
    record = {"page": str(path), "opens with": title, "bytes": len(page)}
    show(
        Sheet("The explorer", sections=(Section(blocks=facts, record={"explorer": record}),)),
        as_json,
    )
