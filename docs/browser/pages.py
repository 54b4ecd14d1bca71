"""Pages with examples that a reader can run in the browser: Sphinx marks them for ``try_it.js``."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from docs.browser.examples import LECTURE, run_alone, source

ROOT = Path(__file__).resolve().parents[2]
STATIC = str(Path(__file__).resolve().parent / "static")


@cache
def exact_lectures() -> list[Path]:
    """The notebooks that run where the exact half is alone.

    Examples
    --------
    >>> from docs.browser.pages import exact_lectures
    >>> "a_course_in_exact_control" in [path.stem for path in exact_lectures()]
    True
    """
    return [path for path in sorted((ROOT / "notebooks").glob("*.ipynb")) if all(_runs_alone(path))]


def _runs_alone(lecture: Path) -> list[bool]:
    """Whether each code cell of a notebook runs where the exact half is alone."""
    cells = json.loads(lecture.read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return run_alone(code, LECTURE)


# What follows is called by Sphinx, which the tests do without.


def mark(app: Any, tree: Any, page: str) -> None:
    """Give examples that run alone the class ``try-it``, and a lecture a place for its link."""
    from docutils import nodes

    if page in {f"notebooks/{path.stem}" for path in exact_lectures()}:
        place = f'<p class="try-lecture" data-lecture="{page.rpartition("/")[2]}.ipynb"></p>'
        tree.next_node(nodes.title).parent.insert(1, nodes.raw("", place, format="html"))
    elif not page.startswith("notebooks/"):
        scopes: dict[int, list[Any]] = {}
        for block in tree.findall(_is_example):
            scopes.setdefault(_scope(block), []).append(block)
        for blocks in scopes.values():
            answers = run_alone([block.astext() for block in blocks])
            for block, alone in zip(blocks, answers, strict=True):
                if alone:
                    block["classes"].append("try-it")


def _is_example(node: Any) -> bool:
    """Whether a node is a session, or the code of a cell that the build runs."""
    from docutils import nodes

    if not isinstance(node, nodes.FixedTextElement):
        return False
    return source(node.astext()) != node.astext() or "cell_input" in node.parent.get("classes", [])


def _scope(node: Any) -> int:
    """The docstring that an example stands in, whose names no other sees; 0 outside."""
    from sphinx.addnodes import desc

    while node is not None and not isinstance(node, desc):
        node = node.parent
    return 0 if node is None else id(node)


def add_script(app: Any, page: str, template: str, context: Any, tree: Any) -> None:
    """Give a page with marks the script that reads them."""
    if tree is not None and next(tree.findall(_is_marked), None) is not None:
        app.add_js_file("try_it.js", loading_method="defer")
        app.add_css_file("try_it.css")


def _is_marked(node: Any) -> bool:
    """Whether `mark` left a mark here."""
    from docutils import nodes

    if isinstance(node, nodes.raw):
        return "try-lecture" in node.astext()
    return isinstance(node, nodes.Element) and "try-it" in node["classes"]


def setup_browser(app: Any) -> None:
    """Tell Sphinx of the marks."""
    app.connect("doctree-resolved", mark)
    app.connect("html-page-context", add_script)
