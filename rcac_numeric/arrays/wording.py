"""Words of others in our messages: never longer than can be read, never a command to a terminal."""

from __future__ import annotations

import re

# Control characters but the newline and the tab; a terminal obeys them.
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def shortened(text: str, at_most: int = 400) -> str:
    """The text, or its beginning and end where it is longer than `at_most`.

    Examples
    --------
    >>> from rcac_numeric.arrays.wording import shortened
    >>> shortened("u, y, z")
    'u, y, z'
    >>> shortened(", ".join(map(str, range(1000))), at_most=40)
    '0, 1, 2,  ... [4888 characters] ...  999'
    """
    if len(text) <= at_most:
        return text
    cut = f" ... [{len(text)} characters] ... "
    room = max(at_most - len(cut), 2)
    end = room // 3
    return f"{text[: room - end]}{cut}{text[len(text) - end :]}"


def printable(text: str) -> str:
    r"""The text with control characters written out, so that no terminal obeys them.

    Examples
    --------
    >>> from rcac_numeric.arrays.wording import printable
    >>> print(printable("a\x1b[31m title"))
    a\x1b[31m title
    """
    return CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), text)
