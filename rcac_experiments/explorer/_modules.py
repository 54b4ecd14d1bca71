"""The stand-alone core around a plant as WebAssembly, for each order n_c.

One module adapts freely, another keeps theta in an ellipsoid.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import Any

DATA = "modules.json"  # written by _compiling, which needs clang
LARGEST_N_C = 20
LARGEST_STEPS = 5000
LARGEST_TARGET = 24  # order of the target model


def modules(orders: Iterable[int], *, in_ellipsoid: bool = False) -> dict[str, Any]:
    """The modules of these orders n_c for a page, deflated as one text, with their lengths."""
    codes = {n_c: module(n_c, in_ellipsoid=in_ellipsoid) for n_c in sorted(set(orders))}
    packed = zlib.compress(b"".join(codes.values()), 9)
    return {
        "orders": list(codes),
        "lengths": [len(code) for code in codes.values()],
        "deflated": base64.b64encode(packed).decode(),
    }


def module(n_c: int, *, in_ellipsoid: bool = False) -> bytes:
    """The module of one order.

    The page writes theta_0, the target model, R_theta, lambda and k_w into it, and center, inverse
    factor and radii of the ellipsoid.
    """
    lengths, code = _codes()
    number = n_c - 1 + LARGEST_N_C * in_ellipsoid
    start = sum(lengths[:number])
    return code[start : start + lengths[number]]


def stored() -> dict[str, Any]:
    """The compiled modules of the package, with their compiler and the digest of their sources."""
    file = resources.files("rcac_experiments.explorer").joinpath(DATA)
    table: dict[str, Any] = json.loads(file.read_text("ascii"))
    return table


@cache
def _codes() -> tuple[list[int], bytes]:
    table = stored()
    return table["lengths"], zlib.decompress(base64.b64decode(table["deflated"]))
