"""The explorer: one page that asks no network, its scenes, and a case of one's own before them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from importlib import resources
from typing import Any

from markupsafe import Markup

from rcac_experiments.explorer._case import draws, scenes, wave
from rcac_experiments.explorer._modules import modules
from rcac_numeric.reports._rendering import whole_page

HOME = "rcac_experiments.explorer"
ORDERS = range(1, 9)  # that every page has
LONGEST_SCENE = 600
# In the order in which one uses what stands before it.
SCRIPTS = (
    "rationals", "formulas", "roots", "plan", "loop", "margins", "words", "charts", "plane",
    "settings", "explorer",
)  # fmt: skip


def explorer_page(case: Mapping[str, Any] | None = None, orders: Iterable[int] = ORDERS) -> str:
    """The text of the page."""
    cases = [*([] if case is None else [case]), *scenes()]
    longest = max(LONGEST_SCENE, *(one["steps"] for one in cases))
    orders = {*orders, *(one["n_c"] for one in cases)}
    data = {
        "cases": cases,
        "draws": draws(longest, {one["seed"] for one in cases}),
        "wave": wave(longest),
        "core": modules(orders),
    }
    return whole_page(
        "explorer.html",
        HOME,
        style=_text("explorer.css"),
        script=bundled(),
        wasm=True,
        title="The RCAC explorer",
        data=in_a_script(data),
    )


def bundled() -> str:
    """The modules of the page as one script: what they import stands before them."""
    parts = []
    for name in SCRIPTS:
        text = re.sub(r"^import .*;\n", "", _text(f"scripts/{name}.js"), flags=re.MULTILINE)
        parts.append(re.sub(r"^export ", "", text, flags=re.MULTILINE))
    return '(() => {\n"use strict";\n' + "\n".join(parts) + "})();\n"


def in_a_script(data: Mapping[str, Any]) -> Markup:
    """JSON that ends no element, whatever the words of a file are."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return Markup(re.sub("[<>&\u2028\u2029]", lambda found: f"\\u{ord(found[0]):04x}", text))


def _text(name: str) -> str:
    return resources.files(HOME).joinpath(*name.split("/")).read_text("utf-8")
