"""A report as HTML: the same words as on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby

from rcac_numeric.arrays.wording import in_a_line, printable
from rcac_numeric.reports.sheets.sheet import Block, Cell, Fact, Section, Sheet, Table, Text


def sheet_html(sheet: Sheet, level: int = 3) -> str:
    """The body of a report: its health, its sections and its notes, without the title.

    Parameters
    ----------
    sheet : Sheet
    level : int
        Of the headings of its sections.

    Examples
    --------
    >>> from rcac_numeric.reports.page.html import sheet_html
    >>> from rcac_numeric.reports.sheets.sheet import Fact, Section, Sheet
    >>> print(sheet_html(Sheet("A", sections=(Section("Loop", (Fact("radius", "0.5 < 1"),)),))))
    <h3>Loop</h3>
    <dl>
    <div><dt>radius</dt><dd class="plain">0.5 &lt; 1</dd></div>
    </dl>
    """
    lines: list[str] = []
    if sheet.health:
        lines += ['<div class="health">', *map(_sentence, sheet.health), "</div>"]
    for section in sheet.sections:
        lines += _section(section, level)
    if sheet.notes:
        lines += [f'<p class="notes">{words(part)}</p>' for part in sheet.notes.split("\n\n")]
    return "\n".join(lines)


def words(text: str) -> str:
    """Words of others as text of a page: no markup, no control characters."""
    return escape(printable(text))


def table_html(table: Table, caption: str = "") -> Iterator[str]:
    """A table; on a narrow screen each row is a card, and each entry says its column."""
    yield "<table>"
    if caption:
        yield f"<caption>{words(caption)}</caption>"
    heads = "".join(f'<th scope="col">{words(head)}</th>' for head in table.heads)
    yield f"<thead><tr>{heads}</tr></thead>"
    yield "<tbody>"
    for row in table.rows:
        yield f"<tr>{''.join(map(_entry, table.heads, row))}</tr>"
    yield "</tbody></table>"


def _section(section: Section, level: int) -> Iterator[str]:
    if section.title:
        yield f"<h{level}>{words(in_a_line(section.title + section.remark))}</h{level}>"
    for is_fact, alike in groupby(section.blocks, lambda block: isinstance(block, Fact)):
        blocks = list(alike)
        yield from _facts(blocks) if is_fact else _others(blocks)


def _facts(blocks: Iterable[Block]) -> Iterator[str]:
    yield "<dl>"
    for block in blocks:
        assert isinstance(block, Fact)
        yield (
            f'<div><dt>{words(block.name)}</dt><dd class="{block.level}">{words(block.value)}</dd>'
            "</div>"
        )
    yield "</dl>"


def _others(blocks: Iterable[Block]) -> Iterator[str]:
    for block in blocks:
        if isinstance(block, Table):
            yield from table_html(block)
        elif isinstance(block, Text):
            yield _sentence(block)


def _sentence(text: Text) -> str:
    return f'<p class="{text.level}">{words(text.words)}</p>'


def _entry(head: str, cell: Cell) -> str:
    lines = "<br>".join(f'<span class="{line.level}">{words(line.words)}</span>' for line in cell)
    return f'<td data-l="{words(head)}"><div>{lines}</div></td>'
