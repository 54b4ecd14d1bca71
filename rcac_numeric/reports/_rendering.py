"""Pages from templates: texts are escaped, and only one script and one style may run."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from html import escape
from importlib import resources
from itertools import groupby
from pathlib import Path
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._wording import in_a_line, printable
from rcac_numeric.reports._sheet import Section, Sheet

HOME = "rcac_numeric.reports"


def rendered(name: str, /, home: str = HOME, **values: Any) -> Markup:
    """A template of a package's folder `templates` with these values."""
    return Markup(_environment(home).get_template(name).render(**values))


def whole_page(
    name: str, /, home: str = HOME, *, style: str = "", script: str = "", wasm: bool = False,
    **values: Any,
) -> str:  # fmt: skip
    """A whole page from a template that extends ``page.html``, with style, script and policy."""
    folder = resources.files(HOME)
    css, js = (folder.joinpath(f"page.{kind}").read_text("utf-8") for kind in ("css", "js"))
    css, js = f"\n{css}{style}", f"\n{js}{script}"
    compiles = " 'wasm-unsafe-eval'" if wasm else ""
    policy = (
        f"default-src 'none'; script-src 'sha256-{_digest(js)}'{compiles}; "
        f"style-src-elem 'sha256-{_digest(css)}'; style-src-attr 'unsafe-inline'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    assets = {"policy": Markup(policy), "css": Markup(css), "js": Markup(js)}
    return f"{rendered(name, home, **assets, **values)}\n"


def write_page(page: str, path: str | Path) -> None:
    """Write a page; the old file stays until the new one is complete."""
    with replacing(path) as new:
        new.write_text(page, encoding="utf-8")


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


@cache
def _environment(home: str) -> Environment:
    homes = dict.fromkeys((home, HOME))

    def source(name: str) -> str | None:
        for one in homes:
            file = resources.files(one).joinpath("templates").joinpath(name)
            if file.is_file():
                return file.read_text("utf-8").rstrip("\n")
        return None

    environment = Environment(
        loader=FunctionLoader(source),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_printable,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(line=in_a_line)
    return environment


def _printable(value: object) -> object:
    """Remove control characters from text; markup is safe already."""
    if isinstance(value, Markup) or not isinstance(value, str):
        return value
    return printable(value)


def sheet_html(sheet: Sheet, level: int = 3) -> str:
    """The body of a report: its health, its sections and its notes, without the title."""
    sections = [
        {"title": section.title, "remark": section.remark, "groups": _groups(section)}
        for section in sheet.sections
    ]
    notes = sheet.notes.split("\n\n") if sheet.notes else []
    values: dict[str, Any] = {
        "health": sheet.health,
        "sections": sections,
        "notes": notes,
        "level": level,
    }
    return str(rendered("sheet.html", **values)).rstrip("\n")


def words(text: str) -> str:
    """Escape a text for a page: no markup, no control characters."""
    return escape(printable(text))


def _groups(section: Section) -> list[tuple[str, list[object]]]:
    """Group the blocks by kind: successive facts are one list."""
    grouped = groupby(section.blocks, lambda block: type(block).__name__)
    return [(kind, list(blocks)) for kind, blocks in grouped]
