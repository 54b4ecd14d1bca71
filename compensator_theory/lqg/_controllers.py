"""The LQG controller: exact gains, Riccati solutions, closed-loop poles, compensator and cost."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import flint
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.errors import NoSolutionError
from compensator_theory.lqg._poles import LQGPoles, require_stable_hidden_modes
from compensator_theory.lqg._regulator_data import ball_matrix, regulator_and_estimator
from compensator_theory.lqg._riccati import RiccatiSolution, hamiltonian_spectrum, solve_riccati
from compensator_theory.lqg._targets import scalar_numerators
from compensator_theory.matrices._flint_matrices import to_flint
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import from_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._enclosures import (
    Enclosure,
    PolynomialEnclosure,
    ball_of_enclosure,
    enclosure_of_ball,
)
from compensator_theory.roots._number_fields import (
    Arithmetic,
    FieldMatrix,
    Grid,
    by,
    characteristic_data,
    field_matrix,
    grid_of,
    plus,
    stable_factors,
    times,
    transposed,
)
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

ControllerMatrices: TypeAlias = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]
JOINT_FIELD = 64
"""Degree up to which gains of both sides are written over one field where the budget is less."""


@dataclass(frozen=True)
class LQGController(ExactValue):
    r"""The LQG controller of a plant, with its certificates.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    plant : StandardProblem
    regulator : RiccatiSolution
        (A.6), (A.7): P, the gain :math:`C_c` and the polynomial of :math:`A + BC_c`.
    estimator : RiccatiSolution
        (A.5), (A.8) as the dual regulator: its P is Q, its gain :math:`-B_c^T`.

    Examples
    --------
    >>> from compensator_theory import lqg_controller, standard_problem
    >>> print(lqg_controller(standard_problem("(q - 2)/(q**2 - 1/4)")))
    D = q**4 - q**3 + q**2/4
    G_c = (-q/10 + 1/20)/(q**2 - q + 2/5)
    """

    plant: StandardProblem
    regulator: RiccatiSolution
    estimator: RiccatiSolution

    @property
    def poles(self) -> LQGPoles:
        """The two factors of the closed-loop polynomial."""
        return LQGPoles(self.regulator.factor, self.estimator.factor)

    @property
    def polynomial(self) -> Poly | None:
        """The closed-loop polynomial of degree 2n if it is rational, else None."""
        return self.poles.polynomial

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return self.poles.enclosure

    @property
    def is_rational(self) -> bool:
        """Whether both gains are rational."""
        return self.regulator.is_rational and self.estimator.is_rational

    @property
    def is_exact(self) -> bool:
        """Whether both gains, and so the controller, are known exactly, each in its own field."""
        return self.regulator.is_exact and self.estimator.is_exact

    @cached_property
    def _joined(self) -> tuple[Arithmetic, tuple[flint.fmpq_poly, flint.fmpq_poly]] | None:
        """One field of degree 64 or less, and the generators of both sides in it; else None."""
        sides = self.regulator, self.estimator
        if not self.is_exact:
            return None
        sides_in_field = [stable_factors(hamiltonian_spectrum(s), most=JOINT_FIELD) for s in sides]
        parts = [one.irrational for one in sides_in_field if one is not None]
        joint = (
            stable_factors(*parts, most=JOINT_FIELD) if len(parts) == len(sides_in_field) else None
        )
        if joint is None:
            return None
        work, generators = Arithmetic(joint.field), []
        for one, factor in zip(sides_in_field, joint.factors, strict=True):
            assert one is not None  # minus the sum of the left roots, scaled
            last = factor[-2] if len(factor) > 1 else flint.fmpq_poly()
            generators.append(last * flint.fmpq(one.scale))
        return work, (generators[0], generators[1])

    def _embedded(self, matrix: FieldMatrix, side: int) -> Grid:
        """Return a matrix of one side over the joint field: its generator is one of that field."""
        assert self._joined is not None
        work, generators = self._joined
        powers = [flint.fmpq_poly([1])]
        for _ in range(1, matrix.field.degree):
            powers.append(powers[-1] * generators[side] % work.minimal)
        zero = flint.fmpq_poly()
        return [
            [sum((p * c for p, c in zip(powers, e.coeffs(), strict=False)), zero) for e in row]
            for row in grid_of(matrix)
        ]

    @cached_property
    def matrices_in_field(self) -> tuple[FieldMatrix, FieldMatrix, FieldMatrix] | None:
        r"""(A_c, B_c, C_c) of (A.4)-(A.6) for u = G_c y, over one field of degree 64 or less.

        .. math:: C_c = K, \qquad B_c = -L^T, \qquad A_c = A + BC_c - B_cC - B_cD_0C_c

        None where that field is larger; :attr:`regulator` and :attr:`estimator` hold each gain in
        its own.
        """
        first, second = self.regulator.K_in_field, self.estimator.K_in_field
        if self._joined is None or first is None or second is None:
            return None
        work = self._joined[0]
        K, L = self._embedded(first, 0), self._embedded(second, 1)
        plant = self.plant
        A, B, C, D_0 = (to_flint(m) for m in (plant.A, plant.B, plant.C, plant.D_0))
        B_c = [[-entry for entry in row] for row in transposed(L)]
        output_rows = plus(work.of(C), times(D_0, K))
        through = [[-e for e in row] for row in work.product(B_c, output_rows)]
        A_c = plus(work.of(A), times(B, K), through)
        A_c_, B_c_, C_c_ = (field_matrix(work.field, m) for m in (A_c, B_c, K))
        return A_c_, B_c_, C_c_

    @property
    def realisation(self) -> ControllerMatrices | None:
        r"""The matrices (A_c, B_c, C_c) in SymPy's numbers.

        None beyond a field of degree 32, or the budget: :attr:`matrices_in_field` goes further.
        """
        matrices = self.matrices_in_field
        if matrices is None:
            return None
        A_c, B_c, C_c = (matrix.written for matrix in matrices)
        return None if A_c is None or B_c is None or C_c is None else (A_c, B_c, C_c)

    @cached_property
    def compensator(self) -> TransferFunction | TransferMatrix | None:
        """The compensator of order n for u = G_c y, over a field of degree 4 or less, else None."""
        matrices = self.matrices_in_field
        if matrices is None or matrices[0].field.degree > 4:
            return None
        n, s = self.plant.n, self.plant.variable
        work = Arithmetic(matrices[0].field)
        A_c, B_c, C_c = (grid_of(m) for m in matrices)
        descending, numerators = characteristic_data(A_c, B_c, C_c, work)
        bottom = self._polynomial(descending, work, s)
        rows, columns = len(C_c), len(B_c[0])
        entries = tuple(
            tuple(
                self._polynomial([numerators[k][i][j] for k in range(n)], work, s)
                for j in range(columns)
            )
            for i in range(rows)
        )
        if (rows, columns) == (1, 1):
            return TransferFunction(entries[0][0], bottom, sample_time=self.plant.sample_time)
        return TransferMatrix(entries, bottom, sample_time=self.plant.sample_time)

    @staticmethod
    def _polynomial(descending: list[flint.fmpq_poly], work: Arithmetic, s: Symbol) -> Poly:
        return from_coefficients(list(field_matrix(work.field, [descending]).matrix), s)

    @cached_property
    def cost_in_field(self) -> FieldMatrix | None:
        r"""The least cost, 1 x 1, over one field of degree 64 or less, else None.

        .. math:: J = \lim \mathbb{E}\,z^Tz = \mathrm{tr}\,P\,D_1D_1^T +
                  \mathrm{tr}\,K^T \Omega K\,\Sigma + \mathrm{tr}\,E_0E_0^T

        for white noise w of unit intensity, :math:`\Omega = R_2`, in discrete time
        :math:`R_2 + B^TPB`, and :math:`\Sigma` the P of the estimator. The last term is that of
        discrete time; in continuous time the cost is infinite if :math:`E_0 \ne 0`.

        Raises
        ------
        NoSolutionError
            If it is infinite.
        """
        self._require_finite_cost()
        if self._joined is None:
            return None
        parts = self.regulator.K_in_field, self.regulator.P_in_field, self.estimator.P_in_field
        if None in parts:
            return None
        work = self._joined[0]
        K, P, S = (
            self._embedded(m, side)
            for m, side in zip(parts, (0, 0, 1), strict=True)
            if m is not None
        )
        plant = self.plant
        B, D_1, E_2, E_0 = (to_flint(m) for m in (plant.B, plant.D_1, plant.E_2, plant.E_0))
        weight = work.of(E_2.transpose() * E_2)
        if self.regulator.factor.time == "discrete":
            weight = plus(weight, times(B.transpose(), by(P, B)))
        noise = by(P, D_1 * D_1.transpose())
        gain = work.product(work.product(transposed(K), work.product(weight, K)), S)
        total = sum((m[i][i] for m in (noise, gain) for i in range(plant.n)), flint.fmpq_poly())
        total = total + sum((x * x for x in E_0.entries()), flint.fmpq(0))
        return field_matrix(work.field, [[total]])

    @property
    def cost(self) -> Expr | None:
        """The least cost in SymPy's numbers.

        None beyond a field of degree 32, or the budget: :attr:`cost_in_field` goes further, and
        :attr:`cost_enclosure` as far as the gains.
        """
        cost = None if self.cost_in_field is None else self.cost_in_field.written
        return None if cost is None else cost[0, 0]

    @property
    def cost_enclosure(self) -> Enclosure:
        """The least cost, certified.

        Raises
        ------
        NoSolutionError
            If it is infinite.
        """
        self._require_finite_cost()
        parts = self.regulator.P_enclosure, self.regulator.K_enclosure, self.estimator.P_enclosure
        finest = max(int(c.centre.q).bit_length() for m in parts for row in m for c in row)
        plant = self.plant
        with ball_precision(64 + 2 * finest):
            P, K, S = (
                flint.arb_mat([[ball_of_enclosure(c) for c in row] for row in m]) for m in parts
            )
            B, D_1, E_2, E_0 = (ball_matrix(m) for m in (plant.B, plant.D_1, plant.E_2, plant.E_0))
            weight = E_2.transpose() * E_2
            if self.regulator.factor.time == "discrete":
                weight = weight + B.transpose() * P * B
            total = (P * D_1 * D_1.transpose()).trace()
            total += (K.transpose() * weight * K * S).trace()
            return enclosure_of_ball(total + sum((x * x for x in E_0.entries()), flint.arb(0)))

    def _require_finite_cost(self) -> None:
        if self.regulator.factor.time == "continuous" and not self.plant.E_0.is_zero_matrix:
            raise NoSolutionError(
                "E_0 is not zero: z holds white noise, and its power is infinite in continuous "
                "time; leave E_0 out to compare controllers"
            )

    def __str__(self) -> str:
        if self.compensator is not None:
            D = self.enclosure if self.polynomial is None else format_polynomial(self.polynomial)
            return f"D = {D}\nG_c = {self.compensator}"
        return (
            f"D = {self.enclosure}\n"
            "G_c spans no number field of degree 4 or less; certified are regulator.K_enclosure, "
            "estimator.K_enclosure and cost_enclosure"
        )

    def _repr_latex_(self) -> str:
        return self.poles._repr_latex_()


@refusing
def lqg_controller(plant: StandardProblem, *, digits: int = 30) -> LQGController:
    r"""Solve LQG exactly, whatever numbers it needs, for any number of signals.

    .. math:: \tilde D(s) = \det(sI - A - BC_c)\,\det(sI - A + B_cC)

    Parameters
    ----------
    plant : StandardProblem
        Rational, any number of signals, cross terms allowed; its variable s, z or q says the time
        domain. Modes that u does not move or y does not show must be stable: a filter that colours
        the noise, for instance. In continuous time :math:`R_2 = E_2^TE_2` and
        :math:`V_2 = D_2D_2^T` are nonsingular.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    LQGController

    Raises
    ------
    UnitCircleError
        If the spectrum of a side, for scalar signals :math:`N_{zu}` or :math:`N_{yw}`, has a zero
        on the unit circle.
    NoSolutionError
        If a spectrum is zero, for scalar signals :math:`N_{zu} = 0` or :math:`N_{yw} = 0`; in
        continuous time if a combination of u or of the sensor noise costs nothing (the gains are
        infinite then, see :func:`high_authority_limits`), or no solution is stabilising.
    NotControllableError, NotObservableError
        If a hidden mode is not stable.
    InputError
        If an entry is symbolic, or the plant is not written in s, z or q.

    Notes
    -----
    ``rcac_numeric.lqg_controller`` answers the same in float64 in discrete time, in milliseconds,
    and has the filter form.

    Source: (A.4)-(A.17) and their counterpart in continuous time. With :math:`R_2 = 0` and
    :math:`V_2 = 0` in discrete time this is high-authority LQG,

    .. math::
        \tilde D_{HA} = q^{d_{zu}} N_{zu,s} \bar N_{zu,u} \cdot
                          q^{d_{yw}} N_{yw,s} \bar N_{yw,u}, \qquad
        B^T P B = H_{d_{zu}}^2 \textstyle\prod |\text{zeros of } N_{zu,u}|^2

    where the bar is the monic polynomial with the reflected zeros. Errata: (A.15)-(A.17) print
    :math:`N_u(z^{-1})`, which has a pole of order :math:`n_u` at 0, so that n_u zeros are missing;
    the polynomials above have all n. For scalar z and w the formulas also hold with
    :math:`d_{zu} = 0` or :math:`d_{yw} = 0`, that is, with :math:`R_2 \ne 0`.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, lqg_controller, standard_problem
    >>> controller = lqg_controller(standard_problem("(q - 2)/(q**2 - 1/4)"))
    >>> controller.regulator.P.tolist(), controller.cost
    ([[4, -2], [-2, 4]], 128/25)
    >>> plant = StandardProblem(A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]],
    ...     D_1=[[0, 0], [1, 0]], D_0=None, D_2=[[0, 1]],
    ...     E_1=[[1, 0], [0, 0]], E_2=[[0], [1]], E_0=None, variable="s")
    >>> controller = lqg_controller(plant)
    >>> controller.regulator.K, controller.cost
    (Matrix([[-1, -sqrt(2)]]), 6*sqrt(2))
    >>> print(controller.compensator)
    (-2*sqrt(2)*s - 1)/(s**2 + 2*sqrt(2)*s + 4)
    """
    sides = regulator_and_estimator(plant)
    s = plant.variable
    time = time_of(s, "LQG")
    require_stable_hidden_modes(plant, time)
    if time == "discrete" and (plant.l_u, plant.l_w, plant.l_y, plant.l_z) == (1, 1, 1, 1):
        scalar_numerators(plant)  # its error names the invalid numerator
    solutions = (
        solve_riccati(A, B, E_1=E_1, E_2=E_2, time=time, digits=digits, variable=s)
        for A, B, E_1, E_2 in sides
    )
    return LQGController(plant, *solutions)
