"""The command `rcac`: the names of its commands, by group, and their modules."""

from __future__ import annotations

import difflib
import importlib
import re
import sys
from collections.abc import Sequence
from typing import Any

import click

from rcac_experiments.cli._exits import EXIT_STATUS, ended, piped

# A command is one file and one line here: its function, and its line of `rcac --help`. A command is
# imported when it is called, so that `rcac list` waits for neither NumPy nor SymPy.
GROUPS = {
    "Derive (exact)": {
        "place": ("_place:place", "Place closed-loop poles exactly."),
        "observer": ("_observer:observer", "Test whether a compensator is observer-based."),
    },
    "Adapt": {
        "step": ("_step:step", "Identify gain, time constants and dead time of a step test."),
        "design": ("_design:design", "Design a controller and explain the choices."),
        "tune": (
            "_design:tune_command",
            "Design a controller and tune its settings by simulation.",
        ),
        "explore": ("_explore:explore", "Write an interactive web page of an adaptive loop."),
        "export": ("_export:export", "Write a controller as C or as an FMU."),
    },
    "Check": {
        "check": ("_check:check", "Check a logged controller: loop, poles, margins."),
        "log": ("_log:log", "Show the columns, the clock and the rounding of a log."),
        "verify": ("_verify:verify", "Run an example and compare it with theory."),
    },
    "Studies": {
        "sweep": ("_studies:sweep", "Run a study: one experiment over many settings and seeds."),
        "show": ("_studies:show_store", "Show the results of a study, or the file of an example."),
        "replay": ("_studies:replay", "Repeat one run of a study, bit for bit."),
        "store": ("_studies:store", "Check the stored runs of a study, or convert an old store."),
    },
    "Dissertation": {
        "list": ("_list:list_examples", "List the numbered examples."),
        "reproduce": ("_dissertation:reproduce_command", "Verify all examples and write a page."),
        "errata": ("_dissertation:errata", "List the errors in the text, with evidence."),
    },
    "Files": {
        "schema": ("_schema:schema", "Print the JSON Schema of experiment files."),
    },
}
COMMANDS = {
    name: (f"rcac_experiments.cli.{function}", text)
    for group in GROUPS.values()
    for name, (function, text) in group.items()
}

# The start of a plant with a minus sign, which is no option: -1/(s + 1), -(q - 2)/q, -s/(s + 1).
MINUS = re.compile(r"^-(?=[\d.(]|[a-np-zA-Z]\s*[*/^])(?=.*[/(])")  # -o has a path behind it


class Commands(click.Group):
    """A group that imports a command when it is called, and returns the statuses of `_exits`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in alphabetical order."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of that name, or None."""
        if cmd_name not in COMMANDS:
            return None
        module, _, function = COMMANDS[cmd_name][0].partition(":")
        command = getattr(importlib.import_module(module), function)
        if not isinstance(command, click.Command):
            raise TypeError(f"{COMMANDS[cmd_name][0]} is no command")
        command.epilog = EXIT_STATUS
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as click does; a formula that begins with a minus sign is no option."""
        return super().parse_args(ctx, [MINUS.sub(" -", word) for word in args])

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Resolve as click does; an unknown name is answered with the closest command."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            close = difflib.get_close_matches(args[0], COMMANDS, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            raise click.UsageError(f"{error.message}{hint}", ctx) from None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the tables of `rcac --help`, one for each group, without importing a command."""
        width = max(map(len, COMMANDS))  # one column for all groups
        for title, commands in GROUPS.items():
            with formatter.section(title):
                rows = [(name.ljust(width), text) for name, (_, text) in commands.items()]
                formatter.write_dl(rows)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Make the context as click does; `rcac --help` prints here."""
        return piped(lambda: super(Commands, self).make_context(*args, **extra))

    def invoke(self, ctx: click.Context) -> Any:
        """Invoke as click does."""
        return piped(lambda: super(Commands, self).invoke(ctx))

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None,
        complete_var: str | None = None, standalone_mode: bool = True, **extra: Any,
    ) -> Any:  # fmt: skip
        """Run the command of the arguments, and exit with its status."""

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
    """Retrospective cost adaptive control, checked against exact compensator theory."""
