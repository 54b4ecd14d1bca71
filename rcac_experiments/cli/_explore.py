"""The command `rcac explore`: an interactive page of an adaptive loop."""

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
              help="The HTML file to write.")  # fmt: skip
@click.option("--run", "name", help="Run of CASE; default: the first.")
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
    """Write an interactive web page of an adaptive loop: drag poles, move dials.

    CASE is the number of an example (see `rcac list`) or the path of a TOML file; without CASE the
    page has only its built-in scenes. The page works offline, and saves its settings as a file for
    `rcac verify`.
    """
    with np.errstate(all="ignore"):
        dials = None
        if case is not None:
            table, file = read_case_table(case)
            dials = case_of(with_values(table, values), file, name, budget)
        elif values or name:
            raise click.UsageError("--set and --run need a CASE.")
        page = explorer_page(dials)
    write_page(page, path)
    title = "built-in scenes" if dials is None else str(dials["title"])
    facts = (Fact("page", str(path)), Fact("opens with", title), Fact("size", f"{len(page)} bytes"))
    record = {"page": str(path), "opens with": title, "bytes": len(page)}
    show(
        Sheet("The explorer", sections=(Section(blocks=facts, record={"explorer": record}),)),
        as_json,
    )
