"""Closed loop of a plant and a fixed compensator: state space and frequency responses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.analysis._stability import is_schur_stable
from rcac_numeric.arrays._algebraic_loops import closes
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._frames import StateSpace, control_state_space
from rcac_numeric.arrays._validation import require_dense, signal_array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import agreed_times, linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import measuring_command, plant_at

# The next step for an unstable loop that is stable with the other sign of feedback.
OTHER_SIGN = (
    " With the other sign of feedback the loop is stable: negate past_y of the Compensator, which "
    "computes u = G_c y, or change feedback=."
)
FEW = 1000  # recursions up to this length are evaluated step by step


@dataclass(frozen=True, eq=False)
class ClosedLoop(Value):
    """The loop u = G_c y + u_tilde, with u_tilde injected inside the compensator.

    The feedback is positive, as everywhere in chapters 2 and 4. The compensator is realised in
    observer canonical form, whose states read u itself: adding u_tilde to u there is the
    intercalated injection (4.5)-(4.8), so the response from u_tilde to z is the intercalated
    transfer function (4.16). The state is [x; x_c], of order n + l_u n_c.

    Parameters
    ----------
    plant : Plant, or a discrete system that `plant_of` reads
    compensator : Compensator, or a transfer function in q

    Raises
    ------
    ImproperError
        Where I - Q_0 D_0 is singular: the loop is not well posed.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, standard_plant
    >>> plant = standard_plant("1/(q - 2)")
    >>> loop = ClosedLoop(plant, Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]]))
    >>> loop.poles().round(6)
    array([0.5+0.5j, 0.5-0.5j])
    >>> loop.is_stable
    True
    """

    plant: Plant
    compensator: Compensator

    def __post_init__(self) -> None:
        plant, compensator = linear_plant(self.plant), compensator_of(self.compensator)
        object.__setattr__(self, "plant", plant)
        object.__setattr__(self, "compensator", compensator)
        agreed_times([plant, compensator])
        if (plant.l_u, plant.l_y) != (compensator.l_u, compensator.l_y):
            raise InputError(
                f"the plant has l_u = {plant.l_u}, l_y = {plant.l_y}; the compensator has "
                f"l_u = {compensator.l_u}, l_y = {compensator.l_y}."
            )
        if not closes(compensator.past_y[0], plant.D_0):
            raise ImproperError(
                "I - Q_0 D_0 is singular: the algebraic loop of u and y is not well posed."
            )

    @cached_property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """Return (A, B, C, D) from [w; u_tilde] to [z; u].

        Raises
        ------
        BudgetError
            Where the loop has more states than full matrices are computed for.
        """
        p = self.plant
        require_dense(p.n + self.compensator.n_c * p.l_u, "the loop")
        S, H, P, Q = self.compensator.observer_form()
        Q_0 = self.compensator.past_y[0]
        n, n_c, l_w = p.n, len(S), p.l_w
        # u = M (Q_0 C x + H x_c + Q_0 D_2 w + u_tilde)
        M = np.linalg.inv(np.eye(p.l_u) - Q_0 @ p.D_0)
        u_x, u_v = M @ np.hstack([Q_0 @ p.C, H]), M @ np.hstack([Q_0 @ p.D_2, np.eye(p.l_u)])
        y_x = np.hstack([p.C, np.zeros((p.l_y, n_c))]) + p.D_0 @ u_x
        y_v = np.hstack([p.D_2, np.zeros((p.l_y, p.l_u))]) + p.D_0 @ u_v
        A = np.block([[p.A, np.zeros((n, n_c))], [np.zeros((n_c, n)), S]])
        A = A + np.vstack([p.B, P]) @ u_x + np.vstack([np.zeros((n, p.l_y)), Q]) @ y_x
        B = np.vstack([p.B, P]) @ u_v + np.vstack([np.zeros((n, p.l_y)), Q]) @ y_v
        B[:n, :l_w] += p.D_1
        C = np.vstack([np.hstack([p.E_1, np.zeros((p.l_z, n_c))]) + p.E_2 @ u_x, u_x])
        D = np.vstack([p.E_2 @ u_v, u_v])
        D[: p.l_z, :l_w] += p.E_0
        return A, B, C, D

    def poles(self) -> ComplexArray:
        """Return the n + l_u n_c eigenvalues of the closed loop."""
        return np.linalg.eigvals(self.matrices[0]).astype(np.complex128)

    def zeros(self) -> dict[str, ComplexArray]:
        """Return the zeros from each channel of w to z in float64; for scalar z.

        They are the finite generalised eigenvalues of the system pencil. A channel that does not
        reach z at all is left out.
        """
        from scipy.linalg import eigvals

        plant = self.plant
        if plant.l_z != 1:
            raise InputError(f"zeros need scalar z; the plant has l_z = {plant.l_z}.")
        A, B, C, D = self.matrices
        zeros, order = {}, len(A)
        left = np.zeros((order + 1, order + 1))
        left[:order, :order] = np.eye(order)
        for index, name in enumerate(plant.channels):
            if not (B[:, index].any() or D[0, index]):
                continue
            pencil = np.block([[A, B[:, [index]]], [C[:1], D[:1, [index]]]])
            values = eigvals(pencil, left)
            finite = np.isfinite(values) & (np.abs(values) < 1e6)  # the other zeros are at infinity
            zeros[name] = np.asarray(values[finite], dtype=np.complex128)
        return zeros

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of a computed pole.

        The eigenvalues of a strongly non-normal loop are wrong by more than rounding, in rare
        cases across the unit circle; `is_stable` is not read off them.
        """
        return float(np.abs(self.poles()).max(initial=0.0))

    @cached_property
    def is_stable(self) -> bool:
        """Whether every pole of the float64 loop is inside the unit circle, decided rigorously.

        By powers, by eigenvalues with their bound, or by an exact count.
        """
        return is_schur_stable(self.matrices[0])

    @property
    def has_stable_opposite(self) -> bool:
        """Whether the loop of -G_c is stable, as a controller designed for u = -G_c y is."""
        G_c = self.compensator
        negated = Compensator(G_c.past_u, -G_c.past_y, G_c.sample_time)
        return (
            closes(negated.past_y[0], self.plant.D_0) and ClosedLoop(self.plant, negated).is_stable
        )

    def frequency_response(self, omega: ArrayLike) -> ComplexArray:
        """Return the response (2.9) from w to z, (len(omega), l_z, l_w), omega in rad/sample."""
        return self._response(omega)[:, : self.plant.l_z, : self.plant.l_w]

    def intercalated_response(self, omega: ArrayLike) -> ComplexArray:
        """Return the intercalated transfer function (4.16); shape (len(omega), l_z, l_u)."""
        return self._response(omega)[:, : self.plant.l_z, self.plant.l_w :]

    def simulate(self, w: ArrayLike, u_tilde: ArrayLike) -> Array:
        """Return the response z to w and an intercalated u_tilde, from rest; shape (steps, l_z)."""
        w = signal_array(w, "w", self.plant.l_w)
        u_tilde = signal_array(u_tilde, "u_tilde", self.plant.l_u, len(w))
        A, B, C, D = self.matrices
        C, D = C[: self.plant.l_z], D[: self.plant.l_z]
        inputs = np.hstack([w, u_tilde])
        states = linear_states(A, inputs @ B.T)
        return np.asarray(states[:-1] @ C.T + inputs @ D.T)

    def to_control(self) -> StateSpace:
        """Return the python-control loop from [w; u_tilde] to [z; u], sampled as the plant."""
        return control_state_space(*self.matrices, self.plant.sample_time)

    def _response(self, omega: ArrayLike) -> ComplexArray:
        A, B, C, D = self.matrices
        z = np.exp(1j * np.atleast_1d(omega))
        pencils = z[:, None, None] * np.eye(len(A)) - A
        try:
            return np.asarray(C @ np.linalg.solve(pencils, B[None]) + D)
        except np.linalg.LinAlgError:  # a pole on the grid, or an overflow
            return np.asarray(C @ np.stack([_solved(pencil, B) for pencil in pencils]) + D)


def _solved(pencil: ComplexArray, B: Array) -> ComplexArray:
    try:
        return np.asarray(np.linalg.solve(pencil, B), dtype=np.complex128)
    except np.linalg.LinAlgError:
        return np.full(B.shape, np.nan, dtype=np.complex128)


def frozen_loop(plant: AnyPlant, compensator: Compensator, k: int) -> ClosedLoop:
    """Return the loop of the plant at step k with a fixed compensator that reads y or [y; r]."""
    fixed = plant_at(plant, k)
    if compensator.l_y > fixed.l_y:
        fixed = measuring_command(fixed)
    return ClosedLoop(fixed, compensator)


def linear_states(A: Array, drive: Array) -> Array:
    """Return x(0), ..., x(N) of x(k+1) = A x(k) + d(k) from rest; shape (N + 1, n).

    Many steps are cut into m blocks of m. All blocks run side by side from rest; what the state at
    the beginning of a block adds, A^j x, follows. That is 2 sqrt(N) steps in place of N, and the
    same sums in another order.
    """
    steps, n = drive.shape
    if steps <= FEW:
        states = np.zeros((steps + 1, n))
        for k, d in enumerate(drive):
            states[k + 1] = A @ states[k] + d
        return states
    size = int(steps**0.5)
    blocks = -(-steps // size)
    padded = np.zeros((blocks * size, n))
    padded[:steps] = drive
    cut = padded.reshape(blocks, size, n)
    powers = np.empty((size + 1, n, n))
    powers[0] = np.eye(n)
    forced = np.zeros((blocks, size + 1, n))
    for j in range(size):
        powers[j + 1] = A @ powers[j]
        forced[:, j + 1] = forced[:, j] @ A.T + cut[:, j]
    starts = np.zeros((blocks + 1, n))
    for b in range(blocks):
        starts[b + 1] = powers[size] @ starts[b] + forced[b, size]
    whole = forced[:, 1:] + np.einsum("jab,cb->cja", powers[1:], starts[:-1])
    return np.concatenate([np.zeros((1, n)), whole.reshape(-1, n)[:steps]])
