"""Loops opened at one scalar signal: open-loop response and closed-loop poles."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import compensator_theory as exact
from compensator_theory.errors import ImproperError, InputError
from compensator_theory.loops._siso import agreed_sign, read_loop
from compensator_theory.systems._conversions import transfer_function
from compensator_theory.systems._descriptions import is_description
from compensator_theory.systems._foreign import is_foreign
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis, closed_loop
from rcac_numeric.analysis._pure_delays import without_delay
from rcac_numeric.analysis._resolvents import (
    MANY_STATES,
    hessenberg_form,
    inverse_norms,
    responses,
)
from rcac_numeric.analysis._stability import is_schur_stable
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._algebraic_loops import closes
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import integer, one_of, real_array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._linear import Plant


@dataclass(frozen=True, eq=False)
class OpenedLoop(Value):
    """The loop transfer function L = C (qI - A)^{-1} B + D that is closed by 1 + L = 0."""

    A: Array
    B: Array
    C: Array
    D: Array

    def response(self, omega: ArrayLike) -> ComplexArray:
        """Return L(e^{j omega}), omega in rad/sample; infinite at a pole."""
        return self.at(np.exp(1j * np.atleast_1d(np.asarray(omega, dtype=np.float64))))

    def at(self, z: ComplexArray) -> ComplexArray:
        """Return L at points of the plane."""
        steps, inner = self.undelayed
        return _shifted(inner._resolvent(z, 1), z, steps)

    def slope(self, z: ComplexArray) -> ComplexArray:
        """Return dL/dz at points of the plane."""
        steps, inner = self.undelayed
        slope = inner._resolvent(z, 2)
        return _shifted(slope - steps * inner._resolvent(z, 1) / z if steps else slope, z, steps)

    @cached_property
    def undelayed(self) -> tuple[int, OpenedLoop]:
        """The steps k and a loop L_0 with L = z^{-k} L_0; k = 0 without delay states."""
        steps, matrices = without_delay(self.A, self.B, self.C, self.D)
        return steps, OpenedLoop(*matrices) if steps else self

    def nearness(self, z: ComplexArray) -> tuple[float, Array]:
        """Return 1 + norm(A) and norm((zI - A)^{-1}), estimated for many states.

        For a loop with pure delay, the norms of the loop without it; each step adds 1 to the first.
        """
        steps, inner = self.undelayed
        if steps:
            size, distances = inner.nearness(z)
            return size + steps, np.maximum(distances, 1.0)
        if len(self.A) >= MANY_STATES:
            H = self._by_hessenberg[0]
            with np.errstate(all="ignore"):
                return 1 + float(np.linalg.norm(H, 1)), inverse_norms(H, np.asarray(z))
        pencils = np.asarray(z)[:, None, None] * np.eye(len(self.A)) - self.A
        try:
            distances = np.linalg.norm(np.linalg.inv(pencils), 1, axis=(1, 2))
        except np.linalg.LinAlgError:  # a pole among the points
            distances = np.array([1 / max(np.linalg.svd(p)[1][-1], 1e-300) for p in pencils])
        return 1 + float(np.linalg.norm(self.A, 1)), distances

    @cached_property
    def _by_hessenberg(self) -> tuple[Array, Array, Array]:
        return hessenberg_form(self.A, self.B, self.C)

    def _resolvent(self, z: ComplexArray, power: int) -> ComplexArray:
        direct = self.D[0, 0] if power == 1 else 0.0
        if not len(self.A):
            return np.full(len(z), direct, dtype=np.complex128)
        if len(self.A) >= MANY_STATES:
            resolvents = responses(*self._by_hessenberg, np.asarray(z), slopes=power == 2)
            return np.asarray(resolvents[:, 0, 0] + direct)
        pencils = np.asarray(z)[:, None, None] * np.eye(len(self.A)) - self.A
        try:
            states = self._states(pencils, power)
        except np.linalg.LinAlgError:  # a pole among the points
            return np.array([self._value_or_infinity(pencil, power) for pencil in pencils])
        return np.asarray((self.C @ states)[:, 0, 0] + direct, dtype=np.complex128)

    def _states(self, pencils: ComplexArray, power: int) -> ComplexArray:
        states = np.linalg.solve(pencils, np.broadcast_to(self.B, (*pencils.shape[:-1], 1)))
        if power == 2:
            states = -np.linalg.solve(pencils, states)
        return np.asarray(states, dtype=np.complex128)

    def _value_or_infinity(self, pencil: ComplexArray, power: int) -> complex:
        try:
            value = (self.C @ self._states(pencil[None], power))[0, 0, 0]
        except np.linalg.LinAlgError:
            return complex(np.inf)
        return complex(value + (self.D[0, 0] if power == 1 else 0.0))

    @cached_property
    def open_poles(self) -> ComplexArray:
        """The eigenvalues of the opened loop."""
        inner = self.undelayed[1].A
        hidden = np.zeros(len(self.A) - len(inner))
        return np.concatenate([np.linalg.eigvals(inner), hidden]).astype(np.complex128)

    def closed_poles(self, gain: complex = 1.0) -> ComplexArray:
        """Return the roots of 1 + gain L = 0 with hidden modes; infinite if not well posed.

        A complex gain turns the phase at every positive frequency and is no real system; its
        poles show where phase and disk margins end.
        """
        direct = 1 + gain * self.D[0, 0]
        if direct == 0:
            return np.full(max(len(self.A), 1), np.inf, dtype=np.complex128)
        poles = np.linalg.eigvals(self.A - (gain / direct) * (self.B @ self.C))
        return np.asarray(poles, dtype=np.complex128)

    def radius(self, gain: complex = 1.0) -> float:
        """Return the spectral radius of the loop closed with an extra gain."""
        return float(np.abs(self.closed_poles(gain)).max(initial=0.0))

    @property
    def is_stable(self) -> bool:
        """Whether the closed loop is stable, decided for its float64 matrix."""
        direct = 1 + self.D[0, 0]
        return bool(direct) and is_schur_stable(self.A - self.B @ self.C / direct)

    @property
    def has_stable_opposite(self) -> bool:
        """Whether the loop with the other sign of feedback, 1 - L = 0, is stable."""
        return OpenedLoop(self.A, self.B, -self.C, -self.D).is_stable

    def delayed(self, steps: int) -> OpenedLoop:
        """Return the loop with `steps` more steps of delay."""
        if steps == 0:
            return self
        n = len(self.A)
        A = np.zeros((n + steps, n + steps))
        A[:n, :n] = self.A
        A[n:, n:] = np.eye(steps, k=-1)
        A[n, :n] = self.C[0]
        B = np.vstack([self.B, self.D, np.zeros((steps - 1, 1))])
        C = np.zeros((1, n + steps))
        C[0, -1] = 1.0
        return OpenedLoop(A, B, C, np.zeros((1, 1)))


def _shifted(values: ComplexArray, z: ComplexArray, steps: int) -> ComplexArray:
    """Return z^{-steps} times the values; infinite values stay infinite."""
    if not steps:
        return values
    with np.errstate(all="ignore"):  # infinite, at a pole
        return np.where(np.isfinite(values), values * np.asarray(z) ** -steps, np.inf + 0j)


def broken_loop(
    plant: Any,
    compensator: Any = None,
    *,
    at: str = "u",
    channel: int = 0,
    feedback: int | None = None,
    variable: str | None = None,
) -> OpenedLoop:
    """Open a closed loop at one component of u or y, or read a loop transfer function."""
    one_of(at, "at", ("u", "y"))
    is_pair = (
        isinstance(plant, tuple) and len(plant) == 2 and feedback is None and compensator is None
    )
    if is_pair or isinstance(plant, ClosedLoop | LoopAnalysis | Run):
        if compensator is not None:
            raise InputError("a ClosedLoop contains its compensator; leave compensator out.")
        if feedback is not None:
            raise InputError("a ClosedLoop has a sign of feedback; leave feedback out.")
        return _opened(closed_loop(plant), at, channel)
    if isinstance(compensator, Compensator) or (
        isinstance(plant, Plant) and compensator is not None
    ):
        return _opened(_closed(plant, compensator, feedback), at, channel)
    L = _matrices(plant, variable) if compensator is None else None
    sign = _sign(feedback)
    A, B, C, D = _in_series(plant, compensator, sign, variable) if L is None else L
    return OpenedLoop(A, B, -sign * C, -sign * D)


def _sign(feedback: int | None) -> int:
    if feedback not in (1, -1):
        raise InputError(
            f"feedback = {feedback!r}: a loop transfer function L needs the sign of feedback; "
            f"give -1 for 1 + L = 0 or +1 for 1 - L = 0."
        )
    return int(feedback)


def _closed(plant: Any, compensator: Any, feedback: int | None) -> ClosedLoop:
    """Return the loop of a plant and a Compensator, or a text with its sign of feedback."""
    if not isinstance(compensator, Compensator):
        sign = _sign(feedback)
        if isinstance(compensator, exact.TransferFunction | exact.Realisation):
            agreed_sign(compensator, sign)
        read = compensator_of(compensator)
        return ClosedLoop(plant, Compensator(read.past_u, sign * read.past_y))
    if feedback not in (None, 1):
        raise InputError(
            f"feedback = {feedback!r}: a Compensator computes u = G_c y, which is feedback = +1; "
            "leave feedback out, or change the sign of past_y."
        )
    return ClosedLoop(plant, compensator)


def _in_series(plant: Any, compensator: Any, sign: int, variable: str | None) -> StateSpace:
    """Return the series connection of plant and compensator with all modes."""
    if not (is_foreign(plant) or is_foreign(compensator)):
        plant, compensator = read_loop(plant, compensator, sign, variable=variable)
    elif isinstance(compensator, exact.TransferFunction | exact.Realisation):
        agreed_sign(compensator, sign)
    A_1, B_1, C_1, D_1 = _matrices(plant, variable)
    if not (is_foreign(compensator) or isinstance(compensator, exact.TransferFunction)):
        compensator = read_beside(compensator)
    A_2, B_2, C_2, D_2 = _matrices(compensator)
    A = np.block([[A_2, np.zeros((len(A_2), len(A_1)))], [B_1 @ C_2, A_1]])
    return A, np.vstack([B_2, B_1 @ D_2]), np.hstack([D_1 @ C_2, C_1]), D_1 @ D_2


def is_continuous(system: Any, variable: str | None = None) -> bool:
    """Whether a system of this or another package is in continuous time."""
    if isinstance(system, str | exact.TransferFunction | exact.Realisation):
        with suppress(InputError):
            return bool(transfer_function(system, variable).time == "continuous")
        return False
    if hasattr(system, "isctime"):  # of python-control
        return bool(system.isctime(strict=True))
    return hasattr(system, "dt") and system.dt is None and is_foreign(system)  # of SciPy


def read_beside(compensator: Any) -> exact.TransferFunction:
    """Convert a compensator to the time of a system of another package."""
    try:
        return transfer_function(compensator)
    except InputError:
        return transfer_function(compensator, "z")


def _matrices(system: Any, variable: str | None = None) -> StateSpace:
    kind = type(system).__name__
    if hasattr(system, "frdata"):
        raise InputError(
            f"the {kind} holds a response at some frequencies and no poles, by which margins are "
            "decided here: control.stability_margins interpolates it, or fit a StateSpace to it."
        )
    if is_continuous(system, variable):
        is_control = hasattr(system, "isctime")
        of_control = "system" if is_control else "transfer_function(loop).to_control()"
        raise InputError(
            "the loop is in continuous time: compensator_theory.stability_margins answers it "
            f"exactly; or discretise it with control.c2d({of_control}, sample_time)."
        )
    if type(system).__module__.split(".")[0] != "control" or not hasattr(system, "isdtime"):
        if not is_description(system) or any(isinstance(p, Compensator) for p in _parts(system)):
            raise InputError(
                f"a {kind} is not a loop; give a Run, a ClosedLoop, a pair of a plant and a "
                "Compensator (whose sign of feedback is known), or a transfer function in q."
            )
        return _matrices(_in_discrete_time(transfer_function(system, variable)))
    if system.dt is None:
        raise InputError(
            f"the {kind} has no time domain; give dt=True for a function of q. "
            f"compensator_theory.stability_margins has the margins of a loop in s."
        )
    if (system.ninputs, system.noutputs) != (1, 1):
        raise InputError(
            f"the {kind} has {system.ninputs} inputs and {system.noutputs} outputs; margins are "
            "for one scalar loop. Give a ClosedLoop, and name the channel to be opened."
        )
    if hasattr(system, "A"):
        parts = (system.A, system.B, system.C, system.D)
        A, B, C, D = (
            real_array(part, f"{n} of the loop") for part, n in zip(parts, "ABCD", strict=True)
        )
        return A, B, C, D
    from scipy.signal import tf2ss

    numerator = np.trim_zeros(real_array(system.num[0][0], "the numerator"), "f")
    denominator = np.trim_zeros(real_array(system.den[0][0], "the denominator"), "f")
    if len(numerator) > len(denominator):
        raise ImproperError(
            f"the loop transfer function has {len(numerator) - 1} zeros and only "
            f"{len(denominator) - 1} poles: it would use future values."
        )
    if len(denominator) == 1 or not len(numerator):
        n = len(denominator) - 1
        direct = numerator[0] / denominator[0] if len(numerator) else 0.0
        A = np.zeros((n, n))
        if n:  # L = 0: the modes of the denominator remain
            A[0], A[1:, :-1] = -denominator[1:] / denominator[0], np.eye(n - 1)
        return A, np.zeros((n, 1)), np.zeros((1, n)), np.array([[direct]])
    A, B, C, D = tf2ss(numerator, denominator)
    return A, B, C, D


def _parts(system: Any) -> Sequence[Any]:
    return system if isinstance(system, list | tuple) else ()


def _in_discrete_time(G: exact.TransferFunction) -> Any:
    """Return the python-control system of a loop in q or z; a loop in s is refused."""
    if G.time != "discrete":
        raise InputError(
            f"the loop is in the variable {G.variable}, and these margins are those of a loop in "
            "discrete time: write it in q or z, discretise it, or ask "
            "compensator_theory.stability_margins, which has those of a loop in s."
        )
    return G.to_control()


def _opened(loop: ClosedLoop, at: str, channel: int) -> OpenedLoop:
    plant = loop.plant
    A_c, B_c, C_c, D_c = loop.compensator.state_space()
    # (first) is where the opened signal enters, (second) where it comes from; D_0 and Q_0 swap.
    first = (plant.A, plant.B, plant.C, plant.D_0)
    second = (A_c, B_c, C_c, D_c)
    if at == "y":
        first, second = second, first
    A_1, B_1, C_1, D_1 = first
    A_2, B_2, C_2, D_2 = second
    width = B_1.shape[1]
    i = integer(channel, f"channel of {at}", at_most=width - 1)
    stays = np.eye(width)
    stays[i, i] = 0.0
    enters = np.eye(width)[:, [i]]
    # s = C_2 x_2 + D_2 (C_1 x_1 + D_1 (stays s + enters v)) is the whole signal, v the opened one.
    if not closes(D_2, D_1 @ stays):
        raise ImproperError(
            f"with {at}[{i}] opened, the algebraic loop of the other channels is not well posed."
        )
    closing = np.eye(width) - D_2 @ D_1 @ stays
    s_x = np.asarray(np.linalg.solve(closing, np.hstack([D_2 @ C_1, C_2])), dtype=np.float64)
    s_v = np.asarray(np.linalg.solve(closing, D_2 @ D_1 @ enters), dtype=np.float64)
    in_x, in_v = stays @ s_x, stays @ s_v + enters
    out_x = np.hstack([C_1, np.zeros((len(C_1), len(A_2)))]) + D_1 @ in_x
    out_v = D_1 @ in_v
    n_1, n_2 = len(A_1), len(A_2)
    A = np.block([[A_1, np.zeros((n_1, n_2))], [np.zeros((n_2, n_1)), A_2]])
    A = A + np.vstack([B_1 @ in_x, B_2 @ out_x])
    B = np.vstack([B_1 @ in_v, B_2 @ out_v])
    return OpenedLoop(A, B, -s_x[[i]], -s_v[[i]])  # positive feedback: 1 + L = 0 with L = -G_c G
