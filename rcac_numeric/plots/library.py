"""What the pictures take from Matplotlib, or the word of what installs it."""

from compensator_theory.libraries import needed

with needed("matplotlib"):
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import SymmetricalLogLocator

__all__ = ["Axes", "Figure", "SymmetricalLogLocator"]
