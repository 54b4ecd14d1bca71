"""Accuracy of pole placement by a float64 Sylvester solve."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from sympy import Poly

from compensator_theory import TransferFunction, certified_roots, exact_number, place_poles
from compensator_theory.bezout import sylvester_m
from compensator_theory.errors import InputError, RoundingWarning
from compensator_theory.placement._rounding_effects import is_stable
from compensator_theory.polynomials._poly import canonical, scaled
from compensator_theory.results import PolePlacement, Root
from compensator_theory.systems._sample_times import way_to_numbers
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result


@dataclass(frozen=True, eq=False)
class PlacementConditioning(Result):
    """An exact pole placement and the float64 solution of the same linear equations.

    Attributes
    ----------
    exact : PolePlacement
        The exact answer.
    matrix : array, shape (n + n_c, n_c + m_hat + 2)
        The matrix of (7.38) with its equation for the leading coefficient, rounded to float64.
    condition_number : float
        Of `matrix`, in the 2-norm; above 4.5e15 no digit is guaranteed.
    relative_error : float
        Of the float64 coefficients against the exact ones, in the 2-norm.
    float64 : TransferFunction
        The compensator that the float64 solve gives; its coefficients are exact binary numbers.
    poles : tuple of Root
        Certified closed-loop poles of the exact plant with that compensator.
    target_is_stable, float64_is_stable : bool
        Whether all requested poles, and all poles that the float64 solve reaches, are in the open
        left half plane (s) or unit disk (z, q).

    Examples
    --------
    >>> from rcac_numeric import placement_conditioning
    >>> conditioning = placement_conditioning("4/((s + 1)*(s + 3))", [-6, -5, -4, -2], feedback=-1)
    >>> conditioning.digits > 13, conditioning.float64_is_stable
    (True, True)
    """

    exact: PolePlacement
    matrix: Array
    condition_number: float
    relative_error: float
    float64: TransferFunction
    poles: tuple[Root, ...]
    target_is_stable: bool
    float64_is_stable: bool

    @property
    def digits(self) -> float:
        """Decimal digits that the float64 solve keeps, -log10 of the error, between 0 and 16."""
        return float(np.clip(-np.log10(max(self.relative_error, 1e-16)), 0.0, 16.0))

    @property
    def abscissa(self) -> float:
        """Largest real part of the closed-loop poles that the float64 solve reaches."""
        return max(root.value.real for root in self.poles)

    def __str__(self) -> str:
        verdict = "stable" if self.float64_is_stable else "UNSTABLE"
        return (
            f"condition number {self.condition_number:.1e}; the float64 solve keeps "
            f"{self.digits:.1f} digits and its closed loop is {verdict} "
            f"(largest real part {self.abscissa:.4g}, largest modulus "
            f"{max(abs(root.value) for root in self.poles):.4g})"
        )


def placement_conditioning(
    plant: Any, target: Any, *, feedback: int, n_c: int | None = None
) -> PlacementConditioning:
    r"""Solve a pole placement problem exactly and in float64, and compare.

    .. math:: M \begin{bmatrix} d \\ c \end{bmatrix} = \tilde d, \qquad
              \kappa(M) = \|M\|_2 \|M^{-1}\|_2

    Parameters
    ----------
    plant, target, feedback, n_c
        As for :func:`compensator_theory.place_poles`; rational, and n_c at least n - 1.

    Returns
    -------
    PlacementConditioning

    Warns
    -----
    RoundingWarning
        If the float64 solve makes a loop unstable whose target is stable, or keeps fewer than
        three digits.

    Raises
    ------
    InputError
        If a coefficient is symbolic or overflows, or the equations are not square.
    CompensatorError
        As :func:`compensator_theory.place_poles` does.

    Notes
    -----
    The poles belong to the plant as given, exactly, with the float64 coefficients read by their
    binary value, so that they show the error of the solve and not that of an eigenvalue routine.
    ``exact.to_control()`` rounds the exact answer once instead.

    Examples
    --------
    >>> from rcac_numeric import placement_conditioning
    >>> print(placement_conditioning("1/(s - 1)", [-1, -2], feedback=-1))
    condition number 4.0e+00; the float64 solve keeps 16.0 digits and its closed loop is stable
    (largest real part -1, largest modulus 2)
    """
    solves = compared_solves(place_poles(plant, target, n_c, feedback=feedback))
    if (solves.target_is_stable and not solves.float64_is_stable) or solves.digits < 3:
        warnings.warn(
            f"{solves}. Use the exact solution, which to_control() rounds once",
            RoundingWarning,
            stacklevel=2,
        )
    return solves


def compared_solves(exact: PolePlacement) -> PlacementConditioning:
    """Return `placement_conditioning` for a solved problem, without the warning."""
    G, order = exact.plant, int(exact.denominator.degree())
    m_hat = min(G.order - 1, order)
    M = sylvester_m(
        G.denominator, scaled(G.numerator, exact_number(-exact.feedback)), order + 1, m_hat
    )
    if M.rows != M.cols:
        raise InputError(
            f"with n_c = {order} below n - 1 = {G.order - 1} the equations are {M.rows} x {M.cols} "
            "and have no condition number; use a higher order"
        )
    entries = [_float(entry) for entry in M]
    matrix = np.array(entries, dtype=np.float64).reshape(M.shape)
    right = np.array([_float(c) for c in exact.target.all_coeffs()])
    solution = _solve(matrix, right)
    exact_solution = _descending(exact.denominator, order) + _descending(exact.numerator, m_hat)
    scale = np.array([_float(c) for c in exact_solution])
    error = float(np.linalg.norm(solution - scale) / np.linalg.norm(scale))
    denominator, numerator = (
        canonical(Poly([exact_number(float(c), binary=True) for c in part], G.variable))
        for part in (solution[: order + 1], [0.0, *solution[order + 1 :]])
    )
    float64 = TransferFunction(numerator, denominator)
    closed = exact.closed_loop_polynomial(float64)
    return PlacementConditioning(
        exact,
        matrix,
        float(np.linalg.cond(matrix)),
        error,
        float64,
        certified_roots(closed),
        is_stable(exact.target),
        is_stable(closed),
    )


def _solve(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:  # singular in float64 only: the exact matrix is regular
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def _descending(poly: Poly, degree: int) -> list[Any]:
    degree_of = 0 if poly.is_zero else int(poly.degree())
    return [0] * (degree - degree_of) + poly.all_coeffs() if degree >= 0 else []


def _float(value: Any) -> float:
    number = exact_number(value)
    if not number.is_Rational:
        raise InputError(
            f"the coefficient {number} is not a rational number; {way_to_numbers(number)}"
        )
    try:
        return int(number.p) / int(number.q)
    except OverflowError as error:
        raise InputError(f"the coefficient {number} exceeds the range of float64") from error
