"""The command `rcac`: what its commands are called, and where each of them is."""

from __future__ import annotations

import difflib
import importlib
import re
import sys
from collections.abc import Sequence
from typing import Any

import click

from rcac_experiments.cli._exits import EXIT_STATUS, ended, piped

# A command is one file and one line here: its function, and what `rcac --help` says of it. It is
# imported when it is asked for, so that `rcac list` waits for neither NumPy nor SymPy.
COMMANDS = {
    "check": ("rcac_experiments.cli._check:check", "Check the controller that a log ended with."),
    "design": ("rcac_experiments.cli._design:design", "From a plant to a controller with reasons."),
    "errata": (
        "rcac_experiments.cli._dissertation:errata",
        "List what is wrong in the dissertation's text.",
    ),
    "explore": ("rcac_experiments.cli._explore:explore", "Write a page on which a loop runs live."),
    "export": ("rcac_experiments.cli._export:export", "Write a controller as C, for a board."),
    "list": ("rcac_experiments.cli._list:list_examples", "List the examples that can be verified."),
    "observer": (
        "rcac_experiments.cli._observer:observer",
        "Tell if a compensator is observer-based.",
    ),
    "place": ("rcac_experiments.cli._place:place", "Place closed-loop poles exactly."),
    "reproduce": (
        "rcac_experiments.cli._dissertation:reproduce_command",
        "Verify all examples; one page.",
    ),
    "replay": (
        "rcac_experiments.cli._studies:replay",
        "Run one run of a study again, bit for bit.",
    ),
    "schema": ("rcac_experiments.cli._schema:schema", "Print the JSON Schema of experiment files."),
    "show": (
        "rcac_experiments.cli._studies:show_store",
        "Show an example's file, or what a study came to.",
    ),
    "store": (
        "rcac_experiments.cli._studies:store",
        "Check the store of a study; convert an old one.",
    ),
    "sweep": ("rcac_experiments.cli._studies:sweep", "Run a study: many runs of one experiment."),
    "tune": (
        "rcac_experiments.cli._design:tune_command",
        "rcac design, with settings found by trying.",
    ),
    "verify": ("rcac_experiments.cli._verify:verify", "Hold a case against the exact prediction."),
}

# What a plant may begin with, and no option or value of one: -1/(s + 1), -(q - 2)/q, -s/(s + 1).
MINUS = re.compile(r"^-(?=[\d.(]|[a-np-zA-Z]\s*[*/^])(?=.*[/(])")  # -o has a path behind it


class Commands(click.Group):
    """A group that imports a command when it is asked for, and ends as `exits` says."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names, in alphabetical order."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name; None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        module, _, function = COMMANDS[cmd_name][0].partition(":")
        command = getattr(importlib.import_module(module), function)
        if not isinstance(command, click.Command):
            raise TypeError(f"{COMMANDS[cmd_name][0]} is no command")
        command.epilog = EXIT_STATUS
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does it; a formula that begins with a minus sign is no option."""
        return super().parse_args(ctx, [MINUS.sub(" -", word) for word in args])

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click does it, with the command that a wrong word comes closest to."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            close = difflib.get_close_matches(args[0], COMMANDS, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            raise click.UsageError(f"{error.message}{hint}", ctx) from None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The table of `rcac --help`, which imports none of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in sorted(COMMANDS)])

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """As click does it; `rcac --help` prints here."""
        return piped(lambda: super(Commands, self).make_context(*args, **extra))

    def invoke(self, ctx: click.Context) -> Any:
        """As click does it."""
        return piped(lambda: super(Commands, self).invoke(ctx))

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None,
        complete_var: str | None = None, standalone_mode: bool = True, **extra: Any,
    ) -> Any:  # fmt: skip
        """Run the command of the arguments, and leave with its exit status."""

        def command() -> Any:
            return super(Commands, self).main(
                args, prog_name, complete_var, standalone_mode=False, **extra
            )

        if not standalone_mode:
            return command()
        sys.exit(ended(command))


@click.group(cls=Commands, epilog=EXIT_STATUS)
@click.version_option(package_name="compensator-theory", prog_name="rcac")
def main() -> None:
    """Retrospective cost adaptive control, held against exact compensator theory."""
