"""The boost converter in continuous conduction, averaged over a switching period."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number, real_array, vector
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._operating_points import OperatingPoint, require_positive


@dataclass(frozen=True)
class BoostConverter:
    """A boost converter from its duty cycle D to its output voltage v.

    L i' = V - (1 - D) v,  C v' = (1 - D) i - v/R

    Parameters
    ----------
    supply : float
        V, volts.
    inductance, capacitance, resistance : float
        L, C and the load R in H, F and ohm.

    Raises
    ------
    InputError
        If a parameter is not positive.

    Notes
    -----
    Averaged over a switching period, without losses, the current never zero. Nonminimum phase at
    every duty cycle: the zero is at (1 - D)^2 R/L rad/s. Source: R. W. Erickson, D. Maksimovic,
    Fundamentals of Power Electronics. The defaults are those of examples/boost_converter.toml.

    Examples
    --------
    >>> from rcac_numeric.gallery import BoostConverter
    >>> converter = BoostConverter()
    >>> converter.linearised(converter.operating_point(duty=0.5)).zeros()
    array([25000.+0.j])
    """

    supply: float = 12.0
    inductance: float = 1e-4
    capacitance: float = 1e-4
    resistance: float = 10.0

    def __post_init__(self) -> None:
        require_positive(
            supply=self.supply, inductance=self.inductance,
            capacitance=self.capacitance, resistance=self.resistance,
        )  # fmt: skip

    def derivative(self, x: ArrayLike, u: ArrayLike) -> Array:
        """[i', v'] at x = [i, v] and u = [D], A/s and V/s."""
        i, v = vector(x, "x", 2)
        off = 1 - vector(u, "u", 1)[0]
        L, C = self.inductance, self.capacitance
        rates = [(self.supply - off * v) / L, (off * i - v / self.resistance) / C]
        return real_array(rates, "the derivative")

    def operating_point(self, duty: float = 0.5) -> OperatingPoint:
        """Return the equilibrium at a duty cycle: v = V/(1 - D), i = v/((1 - D) R)."""
        if not 0 <= number(duty, "duty") < 1:
            raise InputError(f"duty = {duty:g}; a duty cycle is at least 0 and below 1.")
        v = self.supply / (1 - duty)
        return OperatingPoint([v / ((1 - duty) * self.resistance), v], [duty])

    def linearised(self, point: OperatingPoint) -> ContinuousPlant:
        """Return the linearisation at an operating point, in A, V and duty cycle."""
        i, v = point.x
        off = 1 - point.u[0]
        L, C = self.inductance, self.capacitance
        return ContinuousPlant(
            A=[[0, -off / L], [off / C, -1 / (self.resistance * C)]],
            B=[[v / L], [-i / C]],
            C=[[0, 1]],
            states=["inductor current, A", "output voltage, V"],
            inputs=["duty cycle"],
            outputs=["output voltage, V"],
        )
