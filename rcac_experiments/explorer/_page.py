"""The page of the explorer, which works offline: the user's case, then the built-in scenes."""

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
ORDERS = range(1, 9)  # of the controllers of every page
LONGEST_SCENE = 600
# Each script uses only those before it.
SCRIPTS = (
    "rationals", "formulas", "roots", "plan", "loop", "margins", "words", "charts", "plane",
    "settings", "explorer",
)  # fmt: skip


def explorer_page(case: Mapping[str, Any] | None = None, orders: Iterable[int] = ORDERS) -> str:
    """Return the HTML of the page."""
    cases = [*([] if case is None else [case]), *scenes()]
    longest = max(LONGEST_SCENE, *(one["steps"] for one in cases))
    orders = {*orders, *(one["n_c"] for one in cases)}
    ellipsoidal = {one["n_c"] for one in cases if "center" in one["ellipsoid"]}
    data = {
        "cases": cases,
        "draws": draws(longest, {one["seed"] for one in cases}),
        "wave": wave(longest),
        "core": modules(orders),
        "ellipsoidal": modules(ellipsoidal, in_ellipsoid=True),
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
    """Join the modules of the page into one script, each after those that it imports."""
    parts = []
    for name in SCRIPTS:
        text = re.sub(r"^import .*;\n", "", _text(f"scripts/{name}.js"), flags=re.MULTILINE)
        parts.append(re.sub(r"^export ", "", text, flags=re.MULTILINE))
    return '(() => {\n"use strict";\n' + "\n".join(parts) + "})();\n"


def in_a_script(data: Mapping[str, Any]) -> Markup:
    """Encode data as JSON in which no text of a file can end the script element."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return Markup(re.sub("[<>&\u2028\u2029]", lambda match: f"\\u{ord(match[0]):04x}", text))


def _text(name: str) -> str:
    return resources.files(HOME).joinpath(*name.split("/")).read_text("utf-8")
