"""The type of a picture, for annotations: it loads matplotlib when it is looked at, not before."""

from __future__ import annotations


def __getattr__(name: str) -> object:
    if name != "Figure":
        raise AttributeError(name)
    from matplotlib.figure import Figure  # a third of a second

    return Figure
