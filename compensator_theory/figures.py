"""The type of a picture, for annotations; matplotlib is imported on first use."""

from __future__ import annotations

from compensator_theory.libraries import needed


def __getattr__(name: str) -> object:
    if name != "Figure":
        raise AttributeError(name)
    with needed("matplotlib"):
        from matplotlib.figure import Figure  # a third of a second

    return Figure
