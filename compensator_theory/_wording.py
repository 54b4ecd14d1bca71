"""Foreign text in messages: control characters are escaped, so that no terminal executes them."""

from __future__ import annotations

import re

# Control characters but the newline and the tab, half characters, and what changes the direction
# or the lines of the text around it.
CONTROL = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def printable(text: str) -> str:
    r"""Escape the control characters of a text, so that no terminal executes them.

    Examples
    --------
    >>> from compensator_theory._wording import printable
    >>> print(printable("a\x1b[31m title"))
    a\x1b[31m title
    """
    return CONTROL.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def in_a_line(text: str) -> str:
    r"""Escape line ends too, as in a title."""
    return printable(text.replace("\n", "\\n").replace("\t", "\\t"))
