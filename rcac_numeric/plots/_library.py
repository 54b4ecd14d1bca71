"""Imports from Matplotlib, with an install hint if it is missing."""

from compensator_theory.libraries import require_library

try:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import SymmetricalLogLocator
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "matplotlib":
        raise

    class Axes:  # type: ignore[no-redef]
        """Placeholder of a Matplotlib class; raises the install hint when used."""

        def __init__(self, *args: object, **kwargs: object) -> None:
            require_library("matplotlib")

    Figure = SymmetricalLogLocator = Axes  # type: ignore[misc,assignment]

__all__ = ["Axes", "Figure", "SymmetricalLogLocator"]
