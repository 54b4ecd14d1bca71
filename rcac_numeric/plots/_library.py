"""What the pictures take from Matplotlib; where it is missing, what installs it."""

from compensator_theory.libraries import require_library

try:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import SymmetricalLogLocator
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "matplotlib":
        raise

    class Axes:  # type: ignore[no-redef]
        """Stands where a class of Matplotlib would, and says what is missing when one is made."""

        def __init__(self, *given: object, **named: object) -> None:
            require_library("matplotlib")

    Figure = SymmetricalLogLocator = Axes  # type: ignore[misc,assignment]

__all__ = ["Axes", "Figure", "SymmetricalLogLocator"]
