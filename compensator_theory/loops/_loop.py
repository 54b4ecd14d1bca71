"""A plant and a compensator joined: the equations of the loop, solved exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias, TypeGuard, cast

import sympy
from sympy import ImmutableMatrix, MatrixBase, Poly, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.domains.domainelement import DomainElement
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import ImproperError, InputError
from compensator_theory.matrices._certificates import Certificate, proven
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._poly import from_expression
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import require_no_other_operator
from compensator_theory.systems._adjugates import adjugate_and_determinant
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._transfer_matrices import TransferMatrix

PolynomialMatrixLike: TypeAlias = PolynomialLike | MatrixBase | Sequence[Sequence[PolynomialLike]]
"""A polynomial, or a SymPy matrix or nested lists of polynomials."""


@dataclass(frozen=True)
class Loop(ExactValue):
    r"""A plant and a compensator :math:`D_c u = N_c y`, ready to be solved for u.

    .. math:: \Delta = D D_c - N_c N_{yu}, \qquad \det\Delta = D^{l_u-1}\,\det(qI - \tilde A)
              \cdot\mathrm{const}

    Attributes
    ----------
    problem : StandardProblem
        The plant.
    N_c, D_c : sympy.ImmutableMatrix
        l_u x l_y and l_u x l_u, entries polynomial in the variable; D_c is monic.
    n_c : int
        Degree of D_c.

    Notes
    -----
    The powers of D that the formulas of the dissertation leave in numerator and denominator are
    divided out exactly: the loop has :math:`n + l_u n_c` poles.
    """

    problem: StandardProblem
    N_c: ImmutableMatrix
    D_c: ImmutableMatrix
    n_c: int

    def characteristic_polynomial(self) -> Poly:
        r"""Return :math:`\det\Delta/D^{l_u-1}`, the closed-loop characteristic polynomial."""
        return self._polynomial(self._delta[1], self.problem.l_u - 1)

    def response(self, injected: ImmutableMatrix) -> TransferMatrix:
        r"""Return the map to z from an input added as :math:`D_c u = N_c y + V\tilde u`.

        .. math:: N_{zu}\,\mathrm{adj}(\Delta)\,V\,/\det\Delta
        """
        adjugate, _ = self._delta
        N_zu, V = self._in_ring(self._numerators("zu"), injected)
        return self._over_poles(N_zu * adjugate * V, self.problem.l_u - 1)

    def numerators_from_w(self) -> tuple[tuple[Poly, ...], ...]:
        """Return the numerators of the map from w to z over the characteristic polynomial."""
        adjugate, determinant = self._delta
        N_zu, N_c, N_yw, N_zw = self._in_ring(
            self._numerators("zu"), self.N_c, self._numerators("yw"), self._numerators("zw")
        )
        return self._rows(N_zu * adjugate * N_c * N_yw + N_zw * determinant, self.problem.l_u)

    def from_w(self) -> TransferMatrix:
        """Return the map from w to z."""
        return TransferMatrix(
            self.numerators_from_w(),
            self.characteristic_polynomial(),
            self.certificate,
            self.problem.sample_time,
        )

    @cached_property
    def _domain(self) -> Domain:
        """The ring that contains every polynomial of the loop."""
        matrices = [self._numerators(channel) for channel in ("zw", "zu", "yw", "yu")]
        entries = ImmutableMatrix(
            [self._D, *self.N_c, *self.D_c, *(e for m in matrices for e in m)]
        )
        return DomainMatrix.from_Matrix(entries).domain

    @property
    def _delta(self) -> tuple[DomainMatrix, DomainElement]:
        return self._checked_delta[:2]

    @property
    def certificate(self) -> Certificate:
        r"""The identity :math:`\Delta\,\mathrm{adj}\Delta = \det\Delta\, I`, evaluated."""
        return self._checked_delta[2]

    @cached_property
    def _checked_delta(self) -> tuple[DomainMatrix, DomainElement, Certificate]:
        N_yu, N_c, D_c = self._in_ring(self._numerators("yu"), self.N_c, self.D_c)
        delta = D_c * self._domain.from_sympy(self._D) - N_c * N_yu
        adjugate, determinant = adjugate_and_determinant(delta)
        identity = DomainMatrix.eye(delta.shape[0], self._domain).to_dense()
        residual = ImmutableMatrix((delta * adjugate - identity * determinant).to_Matrix())
        name = "(D D_c - N_c N_yu) adj(D D_c - N_c N_yu) = det(D D_c - N_c N_yu) I"
        certificate = proven(Certificate(name, residual), "loop")
        return adjugate, determinant, certificate

    @cached_property
    def _D(self) -> sympy.Expr:
        return self.problem.denominator.as_expr()

    @cached_property
    def _channels(self) -> dict[str, ImmutableMatrix]:
        channels = {c: self.problem.transfer_matrix(c) for c in ("zw", "zu", "yw", "yu")}
        return {channel: matrix.numerator_matrix() for channel, matrix in channels.items()}

    def _numerators(self, channel: str) -> ImmutableMatrix:
        return self._channels[channel]

    def _in_ring(self, *matrices: ImmutableMatrix) -> list[DomainMatrix]:
        domain = self._domain
        return [
            DomainMatrix([list(map(domain.from_sympy, row)) for row in m.tolist()], m.shape, domain)
            for m in matrices
        ]

    def _over_poles(self, product: DomainMatrix, power: int) -> TransferMatrix:
        return TransferMatrix(
            self._rows(product, power),
            self.characteristic_polynomial(),
            self.certificate,
            self.problem.sample_time,
        )

    def _rows(self, product: DomainMatrix, power: int) -> tuple[tuple[Poly, ...], ...]:
        return tuple(tuple(self._polynomial(e, power) for e in row) for row in product.to_list())

    def _polynomial(self, element: DomainElement, power: int) -> Poly:
        """Divide by that power of D, which leaves no remainder."""
        domain = self._domain
        quotient = domain.exquo(element, domain.from_sympy(self._D) ** power)
        return from_expression(domain.to_sympy(quotient), self.problem.variable)


def close_loop(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> Loop:
    r"""Check a compensator against a plant and join the two."""
    require_problem(problem)
    q = problem.variable
    numerator = _polynomial_rows(N_c, (problem.l_u, problem.l_y), q, "N_c")
    denominator = _polynomial_rows(D_c, (problem.l_u, problem.l_u), q, "D_c")
    n_c = max(int(entry.degree()) for row in denominator for entry in row if not entry.is_zero)
    if _leading(denominator, n_c) != identity_matrix(problem.l_u):
        raise InputError(
            f"D_c must be monic: the coefficient of {q}**{n_c} is "
            f"{_leading(denominator, n_c).tolist()} and not the identity; multiply N_c and D_c by "
            "its inverse from the left"
        )
    if any(entry.degree() > n_c for row in numerator for entry in row):
        raise ImproperError(
            f"the compensator is improper: N_c has a higher degree than D_c, which has {n_c}"
        )
    direct = identity_matrix(problem.l_u) - _leading(numerator, n_c) * problem.D_0
    if sympy.expand(direct.det()) == 0:
        raise ImproperError(
            "the loop is not well posed: det(I - Q_0 D_0) = 0 for the direct terms Q_0 of the "
            "compensator and D_0 of the plant; use a strictly proper compensator"
        )
    return Loop(problem, _as_matrix(numerator), _as_matrix(denominator), n_c)


def require_problem(problem: StandardProblem) -> None:
    """Refuse a plant that is not a standard problem."""
    if not isinstance(problem, StandardProblem):
        raise InputError(
            f"{repr_of(problem)} is not a StandardProblem; make one with standard_problem or "
            "servo_problem"
        )


def _polynomial_rows(
    value: PolynomialMatrixLike, shape: tuple[int, int], variable: Symbol, name: str
) -> list[list[Poly]]:
    entries = _nested(value)
    if len(entries) != shape[0] or any(len(row) != shape[1] for row in entries):
        lengths = repr_of([len(row) for row in entries[:20]])  # more entries than a message quotes
        raise InputError(
            f"{name} has rows of lengths {lengths}; this plant needs a {shape[0]} x {shape[1]} "
            "matrix"
        )
    rows = [[_entry(entry, variable) for entry in row] for row in entries]
    if name == "D_c" and all(entry.is_zero for row in rows for entry in row):
        raise InputError("D_c is zero; a compensator needs a denominator")
    return rows


def _nested(value: PolynomialMatrixLike) -> Sequence[Sequence[PolynomialLike]]:
    """Return rows; anything but a matrix or a list of lists is the only entry."""
    if isinstance(value, MatrixBase):
        return list(value.tolist())
    if _is_list(value) and all(_is_list(row) for row in value):
        return value
    return [[cast(PolynomialLike, value)]]  # a list of numbers holds coefficients


def _is_list(value: object) -> TypeGuard[Sequence[Any]]:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _entry(value: PolynomialLike, variable: Symbol) -> Poly:
    entry = polynomial(value, variable)
    require_no_other_operator(entry)
    return entry


def _leading(rows: list[list[Poly]], degree: int) -> ImmutableMatrix:
    return ImmutableMatrix([[e.coeff_monomial(e.gen**degree) for e in row] for row in rows])


def _as_matrix(rows: list[list[Poly]]) -> ImmutableMatrix:
    return ImmutableMatrix([[entry.as_expr() for entry in row] for row in rows])
