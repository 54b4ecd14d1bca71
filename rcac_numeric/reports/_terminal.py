"""Reports in a terminal with colours, elsewhere as plain text."""

from __future__ import annotations

import io
from collections.abc import Mapping

import rich.table
from rich import box
from rich.console import Console, RenderableType
from rich.padding import Padding
from rich.text import Text as Styled

from rcac_numeric.arrays._wording import in_a_line, printable
from rcac_numeric.reports._sheet import Cell, Fact, Level, Section, Sheet, SheetTable, Text

ROOM = 18  # characters of a name in a table
USUAL = 80  # of a line: of a shorter one the heads are broken, too
STYLES: dict[Level, str] = {
    "plain": "",
    "quiet": "dim",
    "good": "green",
    "warning": "yellow",
    "bad": "red",
}


class _Output(Console):
    """A console that leaves a closed pipe to the command."""

    def on_broken_pipe(self) -> None:
        """Raise the error that rich would turn into an exit status."""
        raise BrokenPipeError


def print_sheet(sheet: Sheet, console: Console | None = None) -> None:
    """Print a report to standard output.

    Only a terminal, or the given console, wraps sentences: a pipe is searched for words.
    """
    out = console or _Output(highlight=False)
    wraps = console is not None or out.is_terminal
    if wraps:
        out.print()
    out.print(_title(sheet.title, sheet.remark), soft_wrap=not wraps)
    for sentence in sheet.health:
        _print_text(out, sentence, wraps)
    for section in sheet.sections:
        _print_section(out, section, wraps)
    if sheet.notes:
        out.print()
        out.print(Styled(printable(sheet.notes)), soft_wrap=not wraps)


def as_text(sheet: Sheet, width: int = 100) -> str:
    """The report as plain text of lines of at most `width` characters."""
    stream = io.StringIO()
    print_sheet(
        sheet,
        Console(file=stream, width=width, highlight=False, color_system=None, force_jupyter=False),
    )
    return "\n".join(line.rstrip() for line in stream.getvalue().strip("\n").split("\n"))


def _print_section(out: Console, section: Section, wraps: bool) -> None:
    if section.title:
        out.print(Styled(), _title(section.title, section.remark), sep="\n")
    facts: list[Fact] = []
    for block in (*section.blocks, None):
        if isinstance(block, Fact):
            facts.append(block)
            continue
        if facts:
            out.print(_facts(facts))
            facts = []
        if isinstance(block, Text):
            _print_text(out, block, wraps)
        elif block is not None:
            names = _long_names(block) if block.has_names else {}
            out.print(_table(block, names, out.width))
            for name, number in names.items():
                out.print(Styled(f"  [{number}] {name}"), soft_wrap=True)


def _long_names(block: SheetTable) -> dict[str, int]:
    """The names that do not fit the first column, with the numbers by which they are listed."""
    names = [_name(row) for row in block.rows]
    return {name: i + 1 for i, name in enumerate(dict.fromkeys(names)) if len(name) > ROOM}


def _name(row: tuple[Cell, ...]) -> str:
    return " ".join(in_a_line(text.words) for text in row[0])


def _title(title: str, remark: str) -> Styled:
    head = Styled(in_a_line(title), "bold")
    return head.append(in_a_line(remark), "not bold") if remark else head


def _print_text(out: Console, text: Text, wraps: bool) -> None:
    if wraps:
        out.print(Padding(_styled(text), (0, 0, 0, 2), expand=False))
    else:
        out.print(Styled("  ") + _styled(text), soft_wrap=True)


def _table(block: SheetTable, names: Mapping[str, int], width: int) -> RenderableType:
    table = rich.table.Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for i, head in enumerate(block.heads):
        words = max(map(len, in_a_line(head).split()), default=0)
        table.add_column(
            Styled(in_a_line(head)), overflow="fold", no_wrap=block.has_names and not i,
            min_width=words if block.has_names and width >= USUAL else None,
        )  # fmt: skip
    for row in block.rows:
        texts = [Styled("\n").join(map(_styled, cell)) for cell in row]
        number = names.get(_name(row))
        if number is not None:
            mark = f"... [{number}]"
            texts[0] = Styled(f"{_name(row)[: ROOM - len(mark)]}{mark}")
        table.add_row(*texts)
    return Padding(table, (0, 0, 0, 2), expand=False)


def _facts(facts: list[Fact]) -> RenderableType:
    grid = rich.table.Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    for fact in facts:
        value = Styled(printable(fact.value), STYLES[fact.level])
        grid.add_row(Styled(in_a_line(fact.name)), value)
    return Padding(grid, (0, 0, 0, 2), expand=False)


def _styled(text: Text) -> Styled:
    return Styled(printable(text.words), STYLES[text.level])
