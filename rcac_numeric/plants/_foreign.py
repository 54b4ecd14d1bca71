"""Plants from systems of other packages, with a check of the frequency response."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import compensator_theory as exact
from compensator_theory.errors import IllConditionedError, InputError
from compensator_theory.polynomials._budget import ask
from compensator_theory.systems._dead_times import with_dead_time
from compensator_theory.systems._delayed_transfer_functions import DelayedTransferFunction
from compensator_theory.systems._descriptions import is_description
from compensator_theory.systems._foreign import is_foreign
from compensator_theory.systems._sample_times import agreed_period
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import instance_of, one_of, positive_time, rounded
from rcac_numeric.arrays._values import replaced
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._problems import (
    exact_realisation,
    plant_of_problem,
    sample_time_of,
    standard_plant,
)
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.plants._zero_order_hold import zero_order_hold

METHODS = ("zoh", "bilinear")
# Points at which the responses of plant and source are compared.
CHECKED = np.exp(1j * np.array([0.1, 0.7, 1.9, 2.9]))
LARGEST_GAP = 1e-8


def plant_of(
    system: Any, *, sample_time: float | None = None, method: str = "zoh",
    variable: str | None = None,
) -> AnyPlant:  # fmt: skip
    """The standard problem y = z = G (u + w) of a system of another package, (2.15).

    Parameters
    ----------
    system : python-control, SciPy or SymPy system, or anything `compensator_theory` reads as one
        One signal or several: a text, a pair (num, den), matrices (A, B, C, D), rows of transfer
        functions; StateSpace, TransferFunction, what `interconnect` gives, a discrete
        `nlsys`; `lti` and `dlti`; StateSpace, TransferFunction, Series, Feedback and their
        matrices of sympy.physics.control. A plant of ours is handed back as it is. A text or a
        transfer function in s may have one dead time, "2*exp(-3*s)/(10*s + 1)", of any length.
    sample_time : float, optional
        In seconds: with it, and only with it, a system in continuous time is sampled.
    method : {"zoh", "bilinear"}
        How: with a zero-order hold on its inputs, or by Tustin's substitution.
    variable : {"s", "z"}, optional
        Of a system that does not say whether its time is discrete: lists of coefficients, matrices,
        a StateSpace of SymPy, which counts as continuous, or a system of python-control with
        dt = None.

    Returns
    -------
    Plant, or FunctionPlant for a nonlinear system

    Raises
    ------
    InputError
        Where the system is in continuous time and no sample time is given, or is in discrete time
        with another one, or cannot be read.
    IllConditionedError
        Where the float64 plant does not have the response of the system.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric import plant_of
    >>> plant_of(control.ss([[0.5, 1], [0, 0.2]], np.eye(2), [[1, 1]], [[0, 0]], 0.01))
    Plant(n=2, l_u=2, l_w=2, l_y=1, l_z=1)
    >>> plant_of(control.tf([1], [1, 1]), sample_time=0.1).sample_time
    0.1
    >>> plant_of(control.tf([1], [1, 1]))
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: this TransferFunction is in continuous time, and RCAC
        runs in discrete time; give the sample time and method: plant_of(system, sample_time=0.01,
        method="zoh").
    """
    one_of(method, "method", METHODS)
    if sample_time is not None:
        positive_time(sample_time, "sample_time")
    if isinstance(system, Plant | PlantSchedule | FunctionPlant) or _is_plant_like(system):
        plant: AnyPlant = system
        agreed_time(plant, sample_time)
        unknown = isinstance(plant, Plant) and sample_time is not None and plant.sample_time is None
        return replaced(plant, sample_time=float(sample_time)) if unknown else plant  # type: ignore
    if is_nonlinear(system):
        return plant_of_nonlinear(system, sample_time)
    late = with_dead_time(system, variable)
    if isinstance(late, DelayedTransferFunction):
        return _delayed(late, sample_time, method)
    realisation = exact_realisation(system, variable)
    if str(realisation.variable) == "s":
        sampled = _sampled(system, realisation, sample_time, method)
        return _verified(sampled, system, realisation, method)
    period = agreed_times([system, realisation], sample_time)
    if is_foreign(system):
        return _verified(_matched(*rounded_once(realisation), period), system, realisation, "")
    if realisation.is_siso:
        plant = standard_plant(realisation)
        return plant if plant.sample_time == period else replaced(plant, sample_time=period)
    return _matched(*rounded_once(realisation), period)


def as_plant(system: Any) -> Any:
    """Convert a text, system or exact problem to a plant; return a plant unchanged.

    Other values are returned, so that the caller refuses them with its argument name.
    """
    if type(system) in (Plant, PlantSchedule, FunctionPlant):
        return system
    if isinstance(system, exact.StandardProblem):
        return plant_of_problem(system)
    return system if _is_plant_like(system) or not is_description(system) else plant_of(system)


def agreed_time(system: Any, sample_time: float | None) -> float | None:
    """Return the sample time of a system or the requested one; refuse two that differ."""
    return agreed_times([system], sample_time)


def agreed_times(systems: Sequence[Any], sample_time: float | None = None) -> float | None:
    """Return the common sample time of systems and of the request."""
    if sample_time is not None:
        positive_time(sample_time, "sample_time")
    periods = [sample_time_of(system) for system in systems]
    name = next((type(s).__name__ for s, p in zip(systems, periods, strict=True) if p), "system")
    advice = "leave sample_time out, or resample it yourself."
    period = agreed_period(*periods, sample_time, at=f"this {name}", remedy=advice)
    return None if period is None else float(period)


def linear_plant(system: Any, name: str = "plant") -> Plant:
    """Return a linear plant; systems are read by `plant_of`."""
    read = as_plant(system)
    if isinstance(read, FunctionPlant):
        raise InputError(
            f"{name} is nonlinear, and a linear one is needed: linearise it at the operating "
            f"point, for instance with control.linearize(system, x, u)."
        )
    linear: Plant = instance_of(read, name, Plant)
    return linear


def _is_plant_like(system: Any) -> bool:
    """Whether a value has the attributes of a plant; the engine decides whether it runs."""
    return all(hasattr(system, name) for name in ("l_u", "l_w", "l_y", "l_z", "blocks"))


def rounded_once(realisation: exact.Realisation) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C, D in float64, each entry rounded once; symbols are refused by name."""
    A, B, C, D = (
        np.reshape(rounded(list(entries), name), entries.shape)
        for name, entries in zip(
            "ABCD", (realisation.A, realisation.B, realisation.C, realisation.D), strict=True
        )
    )
    return A, B, C, D


def _sampled(
    system: Any, realisation: exact.Realisation, sample_time: float | None, method: str
) -> Plant:
    if sample_time is None:
        kind = "text" if isinstance(system, str) else type(system).__name__
        raise InputError(
            f"this {kind} is in continuous time, and RCAC runs in discrete time; "
            'give the sample time and method: plant_of(system, sample_time=0.01, method="zoh").'
        )
    A, B, C, D = rounded_once(realisation)
    if method == "zoh":
        A, B = zero_order_hold(A, B, sample_time)
        return _matched(A, B, C, D, sample_time)
    from scipy.signal import cont2discrete

    A, B, C, D, _ = cont2discrete((A, B, C, D), sample_time, method)
    return _matched(A, B, C, D, sample_time)


def _delayed(G: DelayedTransferFunction, sample_time: float | None, method: str) -> Plant:
    """Sample with a zero-order hold and a dead time, the last inputs among the states."""
    if not G.delay.is_Rational:
        raise InputError(f"the dead time {G.delay} must be a number; substitute one for it.")
    if method != "zoh":
        raise InputError(
            f'a dead time is sampled with method = "zoh", not "{method}"; or give an approximation '
            "in s, by the method pade of the transfer function."
        )
    realisation = exact_realisation(G.rational)
    prompt = _sampled(G, realisation, sample_time, method)
    assert sample_time is not None
    steps = G.delay / exact.exact_number(sample_time)
    d = int(steps.ceiling())
    ask("degree", prompt.n + d, "the plant with its dead time")
    A, B, C, D = rounded_once(realisation)
    n, now = prompt.n, np.zeros_like(B)
    if steps < d:
        fraction = float((d - steps) * exact.exact_number(sample_time))
        _, now = zero_order_hold(A, B, fraction)
    whole_A, whole_B = np.zeros((n + d, n + d)), np.zeros((n + d, 1))
    whole_A[:n, :n], whole_A[:n, n + d - 1 :] = prompt.A, prompt.B - now
    whole_A[range(n + 1, n + d), range(n, n + d - 1)] = 1
    whole_B[n] = 1
    if d > 1:
        whole_A[:n, n + d - 2 : n + d - 1] = now
    else:
        whole_B[:n] = now
    whole_C = np.hstack([C, np.zeros((1, d - 1)), D])
    return _matched(whole_A, whole_B, whole_C, np.zeros((1, 1)), sample_time)


def _matched(A: Array, B: Array, C: Array, D: Array, period: float | None) -> Plant:
    """Return the standard problem with w at the inputs."""
    return Plant(A=A, B=B, D_1=B, C=C, D_0=D, D_2=D, E_2=D, E_0=D, sample_time=period)


def _verified(plant: Plant, system: Any, realisation: exact.Realisation, method: str) -> Plant:
    """Return the plant after comparing its frequency response with that of the system."""
    if method == "zoh":  # the rounding of zero_order_hold is bounded
        return plant
    points = CHECKED
    if method == "bilinear":
        assert plant.sample_time is not None
        points = 2 / plant.sample_time * (CHECKED - 1) / (CHECKED + 1)
    ours, theirs = _response(plant, CHECKED), _response_of(system, realisation, points)
    gap = np.abs(ours - theirs).max(initial=0.0)
    size = np.abs(theirs).max(initial=0.0)
    if not gap <= LARGEST_GAP * (size or 1.0):
        raise IllConditionedError(
            f"the float64 matrices of this {type(system).__name__} have another response than the "
            f"system, by {gap / (size or 1.0):.1e} of its size. Give a state space in a better "
            "basis, or factors instead of coefficients."
        )
    return plant


def _response(plant: Plant, points: ComplexArray) -> ComplexArray:
    pencils = points[:, None, None] * np.eye(plant.n) - plant.A
    with np.errstate(all="ignore"):
        return np.asarray(plant.C @ np.linalg.solve(pencils, plant.B[None]) + plant.D_0)


def _response_of(system: Any, realisation: exact.Realisation, points: ComplexArray) -> ComplexArray:
    """Return the frequency response from the system's package; for SymPy from the exact matrix."""
    package = type(system).__module__.split(".")[0]
    with np.errstate(all="ignore"):
        if package == "control":
            return np.array([np.atleast_2d(system(point)) for point in points])
        if package == "scipy":
            matrices = system if hasattr(system, "A") else system.to_ss()
            A, B, C, D = (np.atleast_2d(getattr(matrices, name)) for name in "ABCD")
            pencils = points[:, None, None] * np.eye(len(A)) - A
            return np.asarray(C @ np.linalg.solve(pencils, B[None]) + D)
    matrix = realisation.transfer_matrix()
    below = _values(matrix.denominator, points)
    values = [[_values(entry, points) / below for entry in row] for row in matrix.numerators]
    return np.moveaxis(np.array(values), -1, 0)


def _values(polynomial: Any, points: ComplexArray) -> ComplexArray:
    coefficients = np.array([float(c) for c in polynomial.all_coeffs()])
    return np.asarray(np.polyval(coefficients, points), dtype=np.complex128)


# Discrete nonlinear systems of python-control as plants made of functions.


def is_nonlinear(system: Any) -> bool:
    """Whether a value is a nonlinear python-control system."""
    is_control = type(system).__module__.split(".")[0] == "control"
    return is_control and hasattr(system, "dynamics") and not hasattr(system, "A")


def plant_of_nonlinear(system: Any, sample_time: float | None) -> FunctionPlant:
    """Return the plant of a discrete `nlsys` or `interconnect`, w added to the inputs, y = z."""
    kind = type(system).__name__
    if sample_time is not None or not system.isdtime(strict=True):
        raise InputError(
            f"this {kind} is nonlinear and cannot be sampled here; write its update for one step, "
            "control.nlsys(update, output, dt=0.01), and leave sample_time out."
        )
    n, l_u, l_y = system.nstates, system.ninputs, system.noutputs
    if not (l_u and l_y) or n is None:
        raise InputError(f"this {kind} has no names of inputs, outputs and states; give them.")
    period = 1.0 if system.dt is True else float(system.dt)
    plant = FunctionPlant(
        advance=Advance(system, period), output=Output(system, period),
        n=max(n, 1), l_u=l_u, l_w=l_u, l_y=l_y, l_z=l_y,
    )  # fmt: skip
    rng = np.random.default_rng(0)
    x = rng.standard_normal(n)
    at_rest = np.ravel(system.output(0.0, x, np.zeros(l_u)))
    if not np.array_equal(at_rest, np.ravel(system.output(0.0, x, rng.standard_normal(l_u)))):
        raise InputError(
            f"the output of this {kind} depends directly on its input (feedthrough); add one step "
            f"of delay at its input."
        )
    return plant


class Advance:
    """State update of a python-control system: f(t, x, u + w)."""

    def __init__(self, system: Any, period: float) -> None:
        self.system, self.period = system, period

    def __call__(self, k: int, x: Array, u: Array, w: Array) -> Array:
        """Return x(k+1)."""
        return np.ravel(self.system.dynamics(k * self.period, x, u + w))


class Output:
    """Output of a python-control system: y = z."""

    def __init__(self, system: Any, period: float) -> None:
        self.system, self.period = system, period

    def __call__(self, k: int, x: Array, w: Array) -> tuple[Array, Array]:
        """Return y(k) and z(k)."""
        y = np.ravel(self.system.output(k * self.period, x, np.zeros(self.system.ninputs)))
        return y, y
