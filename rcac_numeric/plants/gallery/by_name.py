"""The plants of the gallery by name, sampled, as experiment files ask for them."""

from __future__ import annotations

from rcac_numeric.arrays.validation import one_of
from rcac_numeric.plants.gallery.boost_converter import BoostConverter
from rcac_numeric.plants.gallery.cart_pendulum import CartPendulum
from rcac_numeric.plants.gallery.continuous import ContinuousPlant
from rcac_numeric.plants.gallery.limited_margins import limited_delay_margin
from rcac_numeric.plants.gallery.mass_spring import MassSpringDamper
from rcac_numeric.plants.gallery.rohrs import rohrs_plant
from rcac_numeric.plants.linear import Plant

LOOPS = ("servo", "standard")


def sampled_boost_converter(
    h: float,
    duty: float = 0.5,
    supply: float = 12.0,
    inductance: float = 1e-4,
    capacitance: float = 1e-4,
    resistance: float = 10.0,
    loop: str = "servo",
) -> Plant:
    """The boost converter near a duty cycle, from duty cycle to output voltage.

    Parameters
    ----------
    h : float
        Sampling period, s.
    duty : float
        Duty cycle about which it is linearised.
    supply : float
        Supply voltage, V.
    inductance, capacitance, resistance : float
        In H, F and ohm.
    loop : {"servo", "standard"}
        The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).

    Examples
    --------
    >>> from rcac_numeric.gallery import plant_zeros
    >>> from rcac_numeric.plants.gallery.by_name import sampled_boost_converter
    >>> plant_zeros(sampled_boost_converter(2e-5)).round(4)
    array([1.6682+0.j])
    """
    plant = BoostConverter(supply, inductance, capacitance, resistance)
    return _in_loop(plant.linearised(plant.operating_point(duty)), h, loop)


def sampled_cart_pendulum(
    h: float,
    kind: str = "upright",
    cart_mass: float = 0.5,
    pendulum_mass: float = 0.2,
    friction: float = 0.1,
    length: float = 0.3,
    inertia: float = 0.006,
    gravity: float = 9.8,
    loop: str = "servo",
) -> Plant:
    """The pendulum on a cart at rest, from force to position.

    Parameters
    ----------
    h : float
        Sampling period, s.
    kind : {"upright", "hanging"}
        Where the pendulum rests.
    cart_mass, pendulum_mass : float
        In kg.
    friction : float
        Of the cart, N s/m.
    length : float
        From the pivot to the centre of mass, m.
    inertia : float
        About the centre of mass, kg m^2.
    gravity : float
        In m/s^2.
    loop : {"servo", "standard"}
        The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).

    Examples
    --------
    >>> from rcac_numeric.plants.gallery.by_name import sampled_cart_pendulum
    >>> sampled_cart_pendulum(0.02)
    Plant(n=4, l_u=1, l_w=3, l_y=1, l_z=1)
    """
    plant = CartPendulum(cart_mass, pendulum_mass, friction, length, inertia, gravity)
    return _in_loop(plant.linearised(plant.operating_point(kind)), h, loop)


def sampled_mass_spring_damper(
    h: float,
    mass: float = 1.0,
    damping: float = 5.0,
    stiffness: float = 10.0,
    loop: str = "servo",
) -> Plant:
    """The mass-spring-damper of (8.64), from force to velocity, by a zero-order hold.

    Parameters
    ----------
    h : float
        Sampling period, s.
    mass, damping, stiffness : float
        In kg, N s/m and N/m.
    loop : {"servo", "standard"}
        The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).

    Examples
    --------
    >>> from rcac_numeric.plants.gallery.by_name import sampled_mass_spring_damper
    >>> sampled_mass_spring_damper(0.1, loop="standard")
    Plant(n=2, l_u=1, l_w=1, l_y=1, l_z=1)
    """
    return _in_loop(MassSpringDamper(mass, damping, stiffness).continuous(), h, loop)


def sampled_rohrs_plant(h: float, loop: str = "servo") -> Plant:
    """Rohrs's plant T(s) of (1.7), sampled.

    Parameters
    ----------
    h : float
        Sampling period, s.
    loop : {"servo", "standard"}
        The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).

    Examples
    --------
    >>> from rcac_numeric.plants.gallery.by_name import sampled_rohrs_plant
    >>> sampled_rohrs_plant(0.04)
    Plant(n=3, l_u=1, l_w=3, l_y=1, l_z=1)
    """
    return _in_loop(rohrs_plant(), h, loop)


def sampled_delay_limited(h: float = 0.1, loop: str = "servo") -> Plant:
    """The plant (1.3)-(1.4) with a limited delay margin, sampled.

    Parameters
    ----------
    h : float
        Sampling period, s.
    loop : {"servo", "standard"}
        The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).

    Examples
    --------
    >>> from rcac_numeric.plants.gallery.by_name import sampled_delay_limited
    >>> sampled_delay_limited()
    Plant(n=3, l_u=1, l_w=3, l_y=1, l_z=1)
    """
    return _in_loop(limited_delay_margin(), h, loop)


def _in_loop(plant: ContinuousPlant, h: float, loop: str) -> Plant:
    if one_of(loop, "loop", LOOPS) == "servo":
        return plant.servo(h)
    return plant.sampled(h)
