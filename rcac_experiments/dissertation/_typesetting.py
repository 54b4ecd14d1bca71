"""The formulas of quotes as HTML: letters, accents, indices and exponents; no mathematics."""

from __future__ import annotations

import re
from html import unescape

from markupsafe import Markup, escape

SYMBOLS = {
    "theta": "θ", "eta": "η", "kappa": "κ", "lambda": "λ", "omega": "ω", "sigma": "σ", "mu": "μ",
    "phi": "φ", "gamma": "γ", "pm": "±", "times": "×", "leq": "≤", "geq": "≥", "lesssim": "≲",
    "in": "∈", "quad": " ", "gg": "≫", "deg": "deg ", "det": "det ", "min": "min ", "cos": "cos ",
    "triangleq": "≜", "approx": "≈", "infty": "∞", "{": "{", "}": "}", ",": " ", "to": "→",
}  # fmt: skip
ACCENTS = {"tilde": "\u0303", "hat": "\u0302", "bar": "\u0304"}
PLAIN = ("text", "mathbf", "mathrm", "mathcal", "operatorname", "mathbb")
_QUOTE = re.compile("\N{LEFT DOUBLE QUOTATION MARK}[^<]*\N{RIGHT DOUBLE QUOTATION MARK}")
_TOKEN = re.compile(r"\\([A-Za-z]+|.)|([{}^_])|([^\\{}^_]+)", re.DOTALL)


def typeset(text: str) -> Markup:
    r"""Words with formulas between dollars as HTML."""
    parts = re.split(r"(?<!\\)\$", text)
    if len(parts) % 2 == 0:  # a dollar without its other one is no formula
        return escape(text)
    pieces = (_formula(part) if i % 2 else escape(part) for i, part in enumerate(parts))
    return Markup("").join(pieces)


def typeset_quotes(body: str) -> Markup:
    """Return HTML with the formulas of quotations typeset."""
    return Markup(_QUOTE.sub(lambda quote: typeset(unescape(quote.group(0))), body))


def _formula(text: str) -> Markup:
    tokens = [match.group(0) for match in _TOKEN.finditer(text.strip())]
    return Markup("<i>{}</i>").format(_read(tokens, 0, "")[0])


def _read(tokens: list[str], i: int, stop: str) -> tuple[Markup, int]:
    """Return the text before the closing brace, and its position."""
    parts: list[Markup] = []
    while i < len(tokens) and tokens[i] != stop:
        one, i = _one(tokens, i)
        parts.append(one)
    return Markup("").join(parts), i


def _one(tokens: list[str], i: int) -> tuple[Markup, int]:
    """One token, or the group that begins with it."""
    token = tokens[i]
    if token == "{":
        inner, end = _read(tokens, i + 1, "}")
        return inner, end + 1
    if token in "^_" and i + 1 < len(tokens):
        inner, end = _argument(tokens, i + 1)
        tag = "sup" if token == "^" else "sub"
        return Markup("<{0}>{1}</{0}>").format(Markup(tag), inner), end
    name = token[1:]
    if token.startswith("\\") and name in (*ACCENTS, *PLAIN, "frac") and i + 1 < len(tokens):
        inner, end = _argument(tokens, i + 1)
        if name == "frac":
            below, end = _argument(tokens, end)
            return Markup("({})/({})").format(inner, below), end
        return inner + ACCENTS.get(name, ""), end
    return escape(SYMBOLS.get(name, name) if token.startswith("\\") else token), i + 1


def _argument(tokens: list[str], i: int) -> tuple[Markup, int]:
    """Return a group, or the next letter."""
    if i >= len(tokens):
        return Markup(""), i
    token = tokens[i]
    if token == "{" or token.startswith("\\"):
        return _one(tokens, i)
    first, rest = token[0], token[1:]
    if rest:
        tokens[i] = rest
        return escape(first), i
    return escape(first), i + 1
