"""Links from the words of a page to the index of equations.

`equation` is a kind of object of the docs. Where a page or a docstring says (2.43), the words
become a link to its entry, so that the way back is as short.
"""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform

NUMBER = re.compile(r"\(([1-9AB]\.[1-9]\d?)\)")


class LinkEquations(SphinxTransform):
    """Make a link of every number of an equation in the words of a page."""

    default_priority = 850
    skipped = (
        nodes.FixedTextElement,
        nodes.Invisible,
        nodes.literal,
        nodes.math,
        nodes.raw,
        nodes.reference,
        nodes.title,
        addnodes.desc_signature,
        addnodes.pending_xref,
    )

    def apply(self, **kwargs: Any) -> None:
        """Replace the words, but not within links, code, formulas and headings."""
        known = self.config.equation_numbers
        for text in list(self.document.findall(nodes.Text)):
            parent, words = text.parent, text.astext()
            if not NUMBER.search(words) or self._within(parent):
                continue
            nodes_of_text: list[nodes.Node] = []
            end = 0
            for match in NUMBER.finditer(words):
                if match[1] not in known:
                    continue
                link = addnodes.pending_xref(
                    "", nodes.inline("", match[0]), refdomain="std", reftype="eqn",
                    reftarget=match[1], refdoc=self.env.docname, refexplicit=True, refwarn=True,
                )  # fmt: skip
                nodes_of_text += [nodes.Text(words[end : match.start()]), link]
                end = match.end()
            if nodes_of_text:
                parent.replace(text, [*nodes_of_text, nodes.Text(words[end:])])

    def _within(self, node: nodes.Node | None) -> bool:
        while node is not None:
            if isinstance(node, self.skipped):
                return True
            node = node.parent
        return False


def parse_equation(env: Any, sig: str, signode: Any) -> str:
    """Show a number as the text does."""
    signode += addnodes.desc_name(sig, f"({sig})")
    return sig


def setup_equations(app: Any) -> None:
    """Tell Sphinx of equations."""
    app.add_config_value("equation_numbers", frozenset(), "")
    app.add_object_type(
        "equation", "eqn", objname="equation", indextemplate="pair: equation; %s",
        parse_node=parse_equation,
    )  # fmt: skip
    app.add_transform(LinkEquations)
