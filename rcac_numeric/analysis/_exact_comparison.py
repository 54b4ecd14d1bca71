"""Comparison of the final controller with the exact prediction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from sympy import Poly

import compensator_theory as exact
from compensator_theory import figures
from compensator_theory.errors import Advice, CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._pairing import pairing
from rcac_numeric.arrays._showing import notebook_of, report_of
from rcac_numeric.arrays._values import Result, shown_array
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel


@dataclass(frozen=True, eq=False)
class ExactComparison(Result):
    """A final controller compared with the exact solution; scalar loops.

    Attributes
    ----------
    reached : sympy.Poly
        D D_c - N_yu N_c, exact: the float64 coefficients of the controller are dyadic rationals.
    requested : sympy.Poly or None
        The characteristic polynomial at which the intercalated transfer function equals G_f.
        None where no controller of this order reaches G_f; `obstacle` says why.
    compensators : PolePlacement or None
        Every compensator of this order that places exactly `requested`.
    poles : array of complex
        Roots of `reached`, from certified isolation.
    zeros : mapping from channel of w to array of complex
        Closed-loop zeros from that channel to z.
    target_poles : array of complex
        The poles of G_f, which the controller has to assign.

    Notes
    -----
    Whether the poles are reached is decided by `is_reached`, by the backward error: distances are
    measures. An m-fold pole moves by the m-th root of a change of the coefficients, and every plant
    with dead time has several poles at 0.
    """

    plant: Plant
    compensator: Compensator
    target: TargetModel
    reached: Poly
    requested: Poly | None
    obstacle: str
    compensators: exact.results.PolePlacement | None
    poles: ComplexArray
    zeros: dict[str, ComplexArray]
    target_poles: ComplexArray

    def _sheet(self) -> Any:
        from rcac_numeric.reports._loop import comparison_sheet

        return comparison_sheet(self)

    def report(self) -> str:
        """Return the report: polynomials, poles and zeros, missed poles first."""
        return report_of(self._sheet())

    def __str__(self) -> str:
        """Return stability and verdict in five lines; `report` has polynomials, poles and zeros."""
        radius = float(np.abs(self.poles).max(initial=0.0))
        stable = "stable" if radius < 1 else "UNSTABLE"
        lines = [
            f"closed loop {stable}, spectral radius {radius:.6g}",
            self.verdict,
            f"no exact prediction: {self.obstacle}"
            if self.obstacle
            else f"requested poles     {shown_array(self.requested_poles)}",
            f"closed-loop poles   {shown_array(self.poles)}",
            "report() has the polynomials, the assigned poles and the zeros",
        ]
        return "\n".join(lines)

    @property
    def verdict(self) -> str:
        """Whether the requested poles are reached, with the numbers, in one sentence."""
        errors = (
            f"worst pole distance {self.worst_distance:.3g}, backward error "
            f"{self.backward_error:.3g}"
        )
        if not self.target_poles.any():
            return f"an FIR target requires no pole; beside the poles of G_f: {errors}"
        return f"requested poles {'reached' if self.is_reached else 'NOT reached'}: {errors}"

    def __repr__(self) -> str:
        distance, change = self.worst_distance, self.backward_error
        return f"ExactComparison(worst_distance={distance:.3g}, backward_error={change:.3g})"

    def _repr_html_(self) -> str:
        """Return the notebook view: the report and the map of poles."""
        return notebook_of(self._sheet(), self.plot)

    def plot(self, *, width: float = 5.0) -> figures.Figure:
        """Plot the closed-loop poles and zeros, and the requested poles."""
        from rcac_numeric.plots._run import plot_comparison

        return plot_comparison(self, width=width)

    @property
    def requested_poles(self) -> ComplexArray:
        """Every pole that the target requires; only those of G_f if it is unreachable."""
        return self.target_poles if self.requested is None else polynomial_roots(self.requested)

    @property
    def assigned(self) -> list[tuple[complex, complex]]:
        """Pairs (pole of G_f, closed-loop pole assigned to it), matched one to one."""
        return pairing(self.target_poles, self.poles)

    @property
    def worst_distance(self) -> float:
        """Largest distance between a pole of G_f and the closed-loop pole assigned to it."""
        return _worst(self.assigned)

    @cached_property
    def backward_error(self) -> float:
        """The relative change of the closed-loop polynomial to the requested poles.

        The largest over the frequencies, abs(Dtilde - A)/max(abs(Dtilde), abs(A)) on the unit
        circle. A is `requested`, or, nearly the same, that at which the intercalated transfer
        function is G_f; where no exact prediction is known, also the poles of G_f with the loop's
        own others, those next to 0 at 0. A simple pole at p that is off by d makes d/(1 - abs(p)).
        """
        return min(relative_change(reached, requested) for reached, requested in self._candidates())

    @property
    def is_reached(self) -> bool:
        """Whether the loop has the poles that the target requires.

        They are reached where the backward error is at most 0.05, so that no simple pole is off by
        more than 0.05 (1 - abs(p)) unless others make up for it, or where each is within 0.01. An
        FIR target requires a finite response, and no pole.
        """
        if not self.target_poles.any():
            return True
        return _worst(self.judged) <= NEAR or self.backward_error <= REACHED

    @property
    def judged(self) -> list[tuple[complex, complex]]:
        """Pairs as in `assigned`, without the poles of G_f that cancel zeros of G_zu.

        All of `requested` are matched: where the loop cancels a zero of G_zu at which G_f has a
        pole, two poles are requested there, and the one that cancels does not count for the other.
        """
        if self.requested is None:
            return self.assigned
        pairs = pairing(self.requested_poles, self.poles)
        return [pair for pair in pairs if np.abs(self.target_poles - pair[0]).min() < SAME]

    @property
    def missed(self) -> list[tuple[complex, complex]]:
        """The pairs of `judged` with a distance above 0.01, the largest first; empty if reached."""
        if self.is_reached:
            return []
        apart = [(a, b) for a, b in self.judged if not abs(a - b) <= NEAR]
        return sorted(apart, key=lambda pair: -abs(pair[0] - pair[1]))

    def sensitivity(self, change: float = 1e-9) -> tuple[complex, int, float] | None:
        """The most sensitive requested multiple pole; None if every pole is simple.

        That pole, its multiplicity m, and how far it moves where each coefficient of the polynomial
        changes by `change` of the largest: the m-th root of what that change makes there.
        """
        polynomial = self.requested
        if polynomial is None and self.target.exact is not None:
            polynomial = self.target.exact.denominator
        if polynomial is None or polynomial.degree() < 2:
            return None
        roots = exact.certified_roots(polynomial)
        largest = max(abs(float(c)) for c in polynomial.monic().all_coeffs())
        sensitivities = []
        for root in roots:
            p, m = root.value, root.multiplicity
            rest = [(p - other.value) ** other.multiplicity for other in roots if other is not root]
            size = np.sum(np.abs(p) ** np.arange(polynomial.degree()))
            moved = (change * largest * size / abs(np.prod(rest))) ** (1 / m)
            sensitivities.append((p, m, float(moved)))
        multiple = [one for one in sensitivities if one[1] > 1]
        return max(multiple, key=lambda one: one[2], default=None)

    def _candidates(self) -> Iterator[tuple[ComplexArray, ComplexArray]]:
        """Return Dtilde and a polynomial with the requested poles, on the unit circle."""
        q = on_circle(self.poles, self.target_poles)
        reached = values_at(q, self.poles)
        if self.requested is not None:
            yield reached, values_at(q, self.requested_poles)
        else:
            others = sorted(self.unassigned, key=abs)
            for count in range(len(others) + 1):
                assigned = np.array(others[count:], dtype=np.complex128)
                requested = values_at(q, self.target_poles) * values_at(q, assigned)
                yield reached, requested * q**count
        N_zu, leading = self.plant.problem.numerator("zu"), float(self.reached.LC())
        N = np.polyval(np.array(N_zu.all_coeffs(), dtype=np.float64), q) * q**self.compensator.n_c
        N_f, D_f = (np.polyval(side.ravel(), q) for side in (
            self.target.numerator, self.target.denominator
        ))  # fmt: skip
        yield leading * reached * N_f, N * D_f  # the intercalated transfer function, and G_f

    @property
    def spectrum_distance(self) -> float:
        """Largest distance over all n + n_c poles, assigned or not; NaN without `requested`."""
        if self.requested is None:
            return float("nan")
        return _worst(pairing(self.requested_poles, self.poles))

    @property
    def unassigned(self) -> ComplexArray:
        """The closed-loop poles without an assigned pole of G_f."""
        rest = list(self.poles)
        for _, pole in self.assigned:
            rest.remove(pole)
        return np.array(rest, dtype=np.complex128)

    @property
    def controller_distance(self) -> float:
        """Euclidean distance of (D_c, N_c) to the set of compensators that place `requested`."""
        if self.compensators is None:
            return float("nan")
        one, directions = self._placing(self.compensators)
        coefficients = np.concatenate([self.compensator.denominator, self.compensator.numerator])
        return _distance(coefficients - one, directions)

    def can_be_placed_by(self, structure: Structure) -> bool | None:
        """Whether this structure can place `requested`; None for a structure that reads r.

        Its compensators and those that place `requested` are two affine sets; they meet, or they
        are apart: by more than 1e-9 of their entries.
        """
        if (structure.l_u, structure.l_y, structure.l_r) != (1, 1, 0) or self.requested is None:
            return None
        if self.compensators is None:
            return False
        one, directions = self._placing(self.compensators)

        def vector(theta: Array) -> Array:
            compensator = structure.compensator(theta)
            return np.concatenate([compensator.denominator, compensator.numerator])

        rest = vector(np.zeros(structure.l_theta))
        free = np.array([vector(row) - rest for row in np.eye(structure.l_theta)]).T
        gap = _distance(rest - one, np.hstack([directions, free]))
        return bool(gap <= SAME * (np.linalg.norm(rest) + np.linalg.norm(one)))

    def _placing(self, placement: exact.results.PolePlacement) -> tuple[Array, Array]:
        """Return (D_c, N_c) of one compensator that places `requested`, and its free directions."""
        length = self.compensator.n_c + 1

        def vector(denominator: Poly, numerator: Poly) -> Array:
            parts = [
                [float(p.nth(length - 1 - i)) for i in range(length)]
                for p in (denominator, numerator)
            ]
            return np.concatenate(parts)

        directions = [vector(dD, dN) for dN, dD in placement.homogeneous]
        shape = (len(directions), 2 * length)
        return vector(placement.denominator, placement.numerator), np.reshape(directions, shape).T


SAME = 1e-9
POINTS = 1000  # number of frequencies of the backward error, beside those of the poles
# The backward error up to which poles are reached, that is, 5 % of the return difference at every
# frequency; and the distance that counts as zero for any conditioning.
REACHED, NEAR = 0.05, 0.01


def on_circle(*poles: ComplexArray) -> ComplexArray:
    """Return points of the upper unit circle, those of the angles of poles among them."""
    omega = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    at_poles = np.abs(np.angle(np.concatenate(poles)))
    return np.asarray(np.exp(1j * np.concatenate([omega, at_poles, [0.0, np.pi]])))


def values_at(q: ComplexArray, roots: ComplexArray) -> ComplexArray:
    """Return the values of a monic polynomial with these roots."""
    return np.asarray(np.prod(q[:, None] - roots[None, :], axis=1))


def relative_change(reached: ComplexArray, requested: ComplexArray) -> float:
    """Return the largest relative difference of the values of two polynomials."""
    with np.errstate(all="ignore"):  # at a pole on the circle the error is undefined
        change = np.abs(reached - requested) / np.maximum(np.abs(reached), np.abs(requested))
    change[(reached == 0) & (requested == 0)] = 0.0
    return float(change.max()) if not np.isnan(change).any() else float("inf")


def _distance(gap: Array, directions: Array) -> float:
    """Return the distance of a point to the span of directions."""
    if directions.shape[1]:
        gap = gap - directions @ np.linalg.lstsq(directions, gap, rcond=None)[0]
    return float(np.linalg.norm(gap))


def comparison_of(plant: Plant, compensator: Compensator, target: TargetModel) -> ExactComparison:
    """Compare a compensator with the exact prediction for its target model."""
    if (plant.l_u, plant.l_y, plant.l_z) != (1, 1, 1):
        raise InputError(
            f"the plant has l_u = {plant.l_u}, l_y = {plant.l_y}, l_z = {plant.l_z}; the exact "
            "comparison is for scalar signals. ",
            Advice("ClosedLoop.poles", (), "Use ClosedLoop(...).poles() instead"),
            ".",
        )
    problem = plant.problem
    N_c, D_c = exact_polynomials(compensator)
    reached = exact.closed_loop_polynomial(problem, N_c, D_c)
    requested, placed, obstacle = None, None, ""
    try:
        if not isinstance(target.exact, exact.TransferFunction):
            raise InputError(
                "the target model has float64 coefficients only: they were given so, or its zeros "
                "are irrational."
                if target.exact is None
                else f"the target model is {target.l_z} x {target.l_u}, not scalar."
            )
        requested = exact.loops.target_characteristic_polynomial(
            problem, compensator.n_c, target.exact
        )
        strictness = _strictness(compensator)
        placed = exact.place_poles(
            problem.transfer_function("yu"),
            requested,
            compensator.n_c,
            feedback=+1,
            numerator_degree=compensator.n_c - strictness,
        )
    except CompensatorError as error:
        obstacle = str(error)
    zeros = {}
    for index, name in enumerate(plant.channels):
        polynomial = exact.loops.closed_loop_zero_polynomial(problem, N_c, D_c, index)
        if not polynomial.is_zero:
            zeros[name] = polynomial_roots(polynomial)
    return ExactComparison(
        plant=plant,
        compensator=compensator,
        target=target,
        reached=reached,
        requested=requested,
        obstacle=obstacle,
        compensators=placed,
        poles=polynomial_roots(reached),
        zeros=zeros,
        target_poles=_target_poles(target),
    )


def exact_polynomials(compensator: Compensator) -> tuple[Poly, Poly]:
    """Return (N_c, D_c) in q with the exact values of their float64 coefficients."""
    N_c, D_c = (
        exact.polynomial([exact.exact_number(float(c), binary=True) for c in coefficients], "q")
        for coefficients in (compensator.numerator, compensator.denominator)
    )
    return N_c, D_c


def _worst(pairs: list[tuple[complex, complex]]) -> float:
    return max((abs(a - b) for a, b in pairs), default=0.0)


def polynomial_roots(polynomial: Poly) -> ComplexArray:
    """Return all roots, from certified isolation."""
    if polynomial.degree() < 1:
        return np.zeros(0, dtype=np.complex128)
    roots = [r.value for r in exact.certified_roots(polynomial) for _ in range(r.multiplicity)]
    return np.array(roots, dtype=np.complex128)


def _target_poles(target: TargetModel) -> ComplexArray:
    if target.exact is not None:
        return polynomial_roots(target.exact.denominator)
    return np.roots(target.denominator[:, 0, 0]).astype(np.complex128)


def _strictness(compensator: Compensator) -> int:
    """Return k_c from the coefficients: 0 if Q_0 is nonzero, else 1."""
    return 0 if compensator.past_y[0].any() else 1
