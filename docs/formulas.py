"""Formulas as MathML, which every browser since 2023 sets by itself: no script and no request."""

from html import escape
from typing import Any

from math_core import LatexError, LatexToMathML

READER = LatexToMathML(fancy_error=False)
"""Refuses what it does not know, where a script would show the reader red letters."""


def mathml(formula: str, displayed: bool = False) -> str:
    r"""Write a formula of LaTeX as MathML.

    A displayed one may have several lines, parted as in ``aligned`` or by an empty line, and a
    ``\tag``.

    Raises
    ------
    math_core.LatexError
        Where a command is unknown or a bracket stands alone.

    Examples
    --------
    >>> from docs.formulas import mathml
    >>> mathml("n_c")
    '<math><msub><mi>n</mi><mi>c</mi></msub></math>'
    """
    if not displayed:
        return READER.convert_with_local_state(formula, displaystyle=False)
    body, tag, number = formula.strip().partition(r"\tag")
    body = r"\\".join(part.strip() for part in body.split("\n\n") if part.strip())
    if r"\\" in body:
        body = rf"\begin{{aligned}}{body}\end{{aligned}}"
    if tag:
        body = rf"\begin{{equation*}}{body}{tag}{number}\end{{equation*}}"
    return READER.convert_with_local_state(body, displaystyle=True)


# What follows is called by Sphinx, which the tests do without.


def _written(node: Any, formula: str, displayed: bool = False) -> str:
    from sphinx.util import logging

    try:
        return mathml(formula, displayed)
    except LatexError as error:
        logging.getLogger(__name__).warning("%s in %r", error, formula, location=node)
        return f"<code>{escape(formula)}</code>"


def visit_inline(writer: Any, node: Any) -> None:
    """Write a formula within a sentence."""
    from docutils.nodes import SkipNode

    writer.body.append(writer.starttag(node, "span", "", CLASS="math notranslate nohighlight"))
    writer.body.append(f"{_written(node, node.astext())}</span>")
    raise SkipNode


def visit_displayed(writer: Any, node: Any) -> None:
    """Write a formula on a line of its own, with its number if another place refers to it."""
    from docutils.nodes import SkipNode
    from sphinx.util.math import get_node_equation_number

    formula = node.astext()
    if node["number"]:
        formula += rf"\tag{{{get_node_equation_number(writer, node)}}}"
    writer.body.append(writer.starttag(node, "div", CLASS="math notranslate nohighlight"))
    writer.body.append(f"{_written(node, formula, displayed=True)}</div>\n")
    raise SkipNode


def setup_formulas(app: Any) -> None:
    """Tell Sphinx of the renderer `mathml`."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_displayed, None))
