"""Decoupling by state feedback: each new input moves one output alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import diagonal, displayed, fraction, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
    solve,
)
from compensator_theory.polynomials._budget import listed
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, monic
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "p_i (C + D F)(sI - A - B F)^-1 B W + p_i D W = I"


@dataclass(frozen=True)
class Decoupling(ExactValue):
    r"""u = F x + W v, with which output i follows input i alone.

    Attributes
    ----------
    relative_degrees : tuple of int
        The d_i: how often output i is differentiated, or shifted, until the input shows.
    matrix : sympy.ImmutableMatrix
        :math:`B^*`, m x m, nonsingular; its rows are :math:`\lim s^{d_i} G_i(s)`.
    F, W : sympy.ImmutableMatrix
        m x n and m x m.
    polynomials : tuple of sympy.Poly
        The p_i, monic of degree d_i; the loop is diag(1/p_i).
    hidden : sympy.Poly
        The other modes of A + BF, which decoupling makes unobservable: they are zeros of the plant.
        The loop is stable only if they are.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        The transfer matrix of the loop, computed anew.
    """

    relative_degrees: tuple[int, ...]
    matrix: ImmutableMatrix
    F: ImmutableMatrix
    W: ImmutableMatrix
    polynomials: tuple[Poly, ...]
    hidden: Poly
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        parts = ", ".join(f"1/({format_polynomial(p)})" for p in self.polynomials)
        return f"diag({parts}) with F = {text(self.F.tolist())}, W = {text(self.W.tolist())}"

    def _repr_latex_(self) -> str:
        loop = diagonal(fraction(1, poly) for poly in self.polynomials)
        return displayed(
            rf"y = {loop}\, v, \quad u = F x + W v, \quad F = {latex(self.F)}",
            f"W = {latex(self.W)}",
            unless(self.exceptional),
        )


@carrying()
def decouple(
    plant: RealisationLike,
    polynomials: Sequence[PolynomialLike] | None = None,
    *,
    variable: str | Symbol | None = None,
) -> Decoupling:
    r"""Decouple a square plant by state feedback, so that each new input moves one output alone.

    With :math:`u = F x + W v` output i follows :math:`v_i` through :math:`1/p_i(s)`:

    .. math:: B^*_i = C_i A^{d_i - 1} B, \qquad W = (B^*)^{-1}, \qquad F = -W
              \begin{bmatrix} C_1\,p_1(A) \\ \vdots \end{bmatrix}

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        As many inputs as outputs. With symbols, for generic values of them.
    polynomials : sequence of polynomials, optional
        The p_i, monic of degree d_i; default :math:`s^{d_i}`, integrators or delays.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Raises
    ------
    NoSolutionError
        If the decoupling matrix is singular: then no static state feedback decouples the plant.
    InputError, ImproperError
        If the plant is not square or cannot be read, or a polynomial has another degree.

    See Also
    --------
    interactor : For a transfer matrix without states: which outputs come how late, and what to put
        in front where no static feedback decouples.
    decouple_disturbance : Hide a disturbance from the output.

    Notes
    -----
    The loop is stable if the p_i and `hidden` are: the modes that decoupling makes
    unobservable are zeros of the plant. F belongs to the states of `plant`, so a transfer matrix G
    is realised first: ``minimal_realisation(G).realisation``. Source: P. L. Falb,
    W. A. Wolovich, IEEE Transactions on Automatic Control 12 (1967) 651-659.

    Examples
    --------
    >>> from compensator_theory.geometry import decouple
    >>> plant = [[0, 1], [2, 3]], [[1, 0], [0, 1]], [[1, 0], [1, 1]]
    >>> decoupling = decouple(plant, ["s + 1", "s + 2"], variable="s")
    >>> print(decoupling)
    diag(1/(s + 1), 1/(s + 2)) with F = [[-1, -1], [-3, -5]], W = [[1, 0], [-1, 1]]
    """
    try:
        source = realisation(plant, variable)
    except InputError:
        is_rows = isinstance(plant, list) and len(plant) == 2
        if not (is_rows or isinstance(plant, TransferMatrix)):
            raise
        raise InputError(
            "F acts on states, and a transfer matrix G has none: give "
            "minimal_realisation(G).realisation, or see interactor, which reads G"
        ) from None
    A, B, C, D = source.A, source.B, source.C, source.D
    m = B.cols
    if C.rows != m or not m:
        raise InputError(f"the plant has {m} inputs and {C.rows} outputs; decoupling needs as many")
    degrees, rows, divisors = [], [], []
    for i in range(m):
        d, row = _relative_degree(source, i)
        degrees.append(d)
        rows.append(row)
        if row.free_symbols:
            nonzero = [entry for entry in row if entry != 0]
            divisors.append(min(nonzero, key=lambda entry: len(entry.free_symbols)))
    star = ImmutableMatrix.vstack(*rows)
    minor = determinant(star)
    if sympy.cancel(minor) == 0:
        raise NoSolutionError(
            f"the decoupling matrix {star.tolist()} is singular, so no static state feedback "
            "decouples the plant; see interactor for the required precompensation"
        )
    targets = _targets(polynomials, degrees, source.variable)
    below = ImmutableMatrix.vstack(
        *(_applied(source, i, p) for i, p in enumerate(targets))
    )  # C_i p_i(A)
    W = in_lowest_terms(solve(star, identity_matrix(m)))
    F = in_lowest_terms(-W * below)
    modes = characteristic_polynomial(ImmutableMatrix(in_lowest_terms(A + B * F)), source.variable)
    visible = sympy.prod(targets, start=Poly(1, source.variable, domain=sympy.QQ))
    top, bottom = modes.unify(visible)
    field = top.domain.get_field()
    hidden = monic(canonical(top.set_domain(field).exquo(bottom.set_domain(field))))
    divisors += [minor, *denominators_of((A, B, C, D, F, W))]
    return Decoupling(
        tuple(degrees),
        star,
        F,
        W,
        targets,
        hidden,
        exceptional_factors(divisors),
        _certificate(source, F, W, targets),
    )


def _relative_degree(plant: Realisation, i: int) -> tuple[int, ImmutableMatrix]:
    if not plant.D[i, :].is_zero_matrix:
        return 0, plant.D[i, :]
    row = plant.C[i, :]
    for d in range(1, plant.n + 1):
        row_times_B = multiplied(row, plant.B)
        if not row_times_B.is_zero_matrix:
            return d, row_times_B
        row = multiplied(row, plant.A)
    raise NoSolutionError(f"no input reaches output {i + 1}; leave that output out")


def _targets(
    polynomials: Sequence[PolynomialLike] | None, degrees: list[int], s: Symbol
) -> tuple[Poly, ...]:
    if polynomials is None:
        return tuple(polynomial(s**d, s) for d in degrees)
    example = f"give one polynomial for each of the {len(degrees)} outputs, in a list"
    if isinstance(polynomials, str):
        raise InputError(example)
    several = listed(polynomials, "entries", "the list of polynomials")
    if len(several) != len(degrees):
        raise InputError(f"there are {len(several)} polynomials; {example}")
    read = tuple(polynomial(p, s) for p in several)
    for i, (p, d) in enumerate(zip(read, degrees, strict=True)):
        if p.is_zero or p.degree() != d or p.LC() != 1:
            raise InputError(
                f"polynomial {i + 1}, {format_polynomial(p)}, must be monic of degree {d}, the "
                "relative degree of that output"
            )
    return read


def _applied(plant: Realisation, i: int, p: Poly) -> ImmutableMatrix:
    row = zero_matrix(1, plant.n)
    for coefficient in p.all_coeffs():  # Horner's rule
        row = row * plant.A + coefficient * plant.C[i, :]
    return row


def _certificate(
    plant: Realisation, F: ImmutableMatrix, W: ImmutableMatrix, targets: tuple[Poly, ...]
) -> Certificate:
    loop = transfer_matrix_of_realisation(
        in_lowest_terms(plant.A + plant.B * F),
        multiplied(plant.B, W),
        in_lowest_terms(plant.C + plant.D * F),
        multiplied(plant.D, W),
        plant.variable,
    )
    left = [
        (entry * p - (loop.denominator if i == j else 0)).as_expr()
        for i, (row, p) in enumerate(zip(loop.numerators, targets, strict=True))
        for j, entry in enumerate(row)
    ]
    return certificate_of(IDENTITY, [ImmutableMatrix(1, len(left), left)])
