"""``python -m proofs``: check the ledger and print it."""

import sys

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from compensator_theory.errors import CompensatorError

from .formal.rocq_build import NOT_COMPILED, compile_formal_part
from .ledger.ledger import LedgerError, select, theorems
from .ledger.verification import number_of_checks, verify
from .output.printing import print_ledger, print_names, print_summary
from .output.records import to_json


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("selection", nargs=-1)
@click.option("--quick", is_flag=True, help="Fewer examples and smaller sizes.")
@click.option("--formal", is_flag=True, help="Also compile proofs/rocq, where Coq is installed.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--list", "names_only", is_flag=True, help="Print the names of the entries only.")
def main(
    selection: tuple[str, ...], quick: bool, formal: bool, as_json: bool, names_only: bool
) -> None:
    """Check every statement that the software relies on, and print the ledger of their evidence.

    SELECTION names chapters (2, 4, 7, 8, 9, field, A, B) or entries; default: all. The exit
    status is 1 if anything fails that should hold.
    """
    console, progress_console = Console(), Console(stderr=True)
    try:
        entries = select(selection)
        if names_only:
            print_names(console, entries)
            return
        compilation = NOT_COMPILED
        columns = (TextColumn("{task.description:45}"), BarColumn(), MofNCompleteColumn(),
                   TimeElapsedColumn())  # fmt: skip
        with Progress(*columns, console=progress_console, transient=True) as progress:
            if formal:
                compiling = progress.add_task("compiling proofs/rocq", total=None)
                compilation = compile_formal_part(theorems(entries))
                progress.remove_task(compiling)
            task = progress.add_task("checking", total=number_of_checks(entries))
            outcomes = verify(
                entries,
                compilation,
                quick=quick,
                tick=lambda check: progress.update(task, advance=1, description=check),
            )
    except (CompensatorError, LedgerError) as error:
        raise click.UsageError(str(error)) from error
    if as_json:
        click.echo(to_json(outcomes, compilation, quick=quick))
    else:
        print_ledger(console, outcomes)
        print_summary(console, outcomes, compilation, quick=quick)
    sys.exit(0 if all(entry.holds for entry in outcomes) and compilation.holds else 1)


if __name__ == "__main__":
    main(prog_name="python -m proofs")
