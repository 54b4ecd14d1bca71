"""Gramians of a stable realisation, its H2 norm and its Hankel singular values."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import NoSolutionError
from compensator_theory.lqg._sylvester_equations import solve_lyapunov, solve_stein
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import introduced, names_in_all
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._stability import decide_stability
from compensator_theory.stability._conditions import stability_conditions
from compensator_theory.systems._canonical_forms import RealisationLike, timed_realisation

IDENTITY = "both Lyapunov equations of the Gramians"


@dataclass(frozen=True)
class Gramians(ExactValue):
    r"""The controllability and observability Gramians, the H2 norm and the Hankel singular values.

    Attributes
    ----------
    controllability, observability : sympy.ImmutableMatrix
        :math:`W_c` and :math:`W_o`, n x n, symmetric.
    norm_squared : sympy.Expr
        :math:`\|G\|_2^2 = \mathrm{tr}(C W_c C')`, plus tr(D D') in discrete time; oo in continuous
        time where D is not zero.
    conditions : tuple of sympy.Expr
        All positive if and only if the plant is stable, without which the integrals diverge; empty
        without symbols.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        Both equations, evaluated anew.
    """

    controllability: ImmutableMatrix
    observability: ImmutableMatrix
    norm_squared: Expr
    conditions: tuple[Expr, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def hankel_polynomial(self, variable: Symbol | None = None) -> Poly:
        r"""Return :math:`\det(xI - W_c W_o)`: its roots are the Hankel singular values squared."""
        product = self.controllability * self.observability
        x = introduced(
            variable, names_in_all(product), "x", "lambda",
            meaning="the variable of the polynomial", owner="a symbol of the plant",
        )  # fmt: skip
        return characteristic_polynomial(product, x)

    def __str__(self) -> str:
        W_c = matrix_line("W_c", self.controllability, "controllability")
        W_o = matrix_line("W_o", self.observability, "observability")
        return f"{W_c}\n{W_o}\nH2 norm squared: {text(self.norm_squared)}"

    def _repr_latex_(self) -> str:
        return displayed(
            f"W_c = {latex(self.controllability)}",
            f"W_o = {latex(self.observability)}",
            rf"\|G\|_2^2 = {latex(self.norm_squared)}",
            *(f"{latex(condition)} > 0" for condition in self.conditions),
            unless(self.exceptional),
        )


@refusing
def gramians(plant: RealisationLike, variable: str | Symbol | None = None) -> Gramians:
    r"""Compute both Gramians of a stable realisation, and its H2 norm.

    .. math:: A W_c + W_c A' + B B' = 0, \quad A' W_o + W_o A + C'C = 0; \qquad
              W_c = A W_c A' + B B', \quad W_o = A' W_o A + C'C

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        In s for continuous time (the first two equations), in z or q for discrete time.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Returns
    -------
    Gramians
        Hidden modes count in both matrices, not in the norm.

    Raises
    ------
    NoSolutionError
        If the plant is not stable.
    InputError, ImproperError, BudgetError
        If it cannot be read, does not show the time domain, is improper, or too large.

    Notes
    -----
    Source: T. Kailath, Linear Systems (1980), Section 9.2; K. Glover, Int. J. Control 39 (1984).

    Examples
    --------
    >>> from compensator_theory import gramians
    >>> result = gramians("1/(s**2 + a*s + b)", "s")
    >>> result.norm_squared, result.conditions
    (1/(2*a*b), (b, a))
    >>> gramians("1/(z - 1/2)").norm_squared
    4/3
    """
    source = timed_realisation(plant, variable, "a Gramian")
    time = time_of(source.variable, "a Gramian")
    discrete = time == "discrete"
    A, B, C, D = source.A, source.B, source.C, source.D
    direct = (D * D.T).trace()
    conditions: tuple[Expr, ...] = ()
    if source.n:
        modes = characteristic_polynomial(A, source.variable)
        if is_rational(modes):
            decision = decide_stability(modes, time=time)
            if not decision.is_stable:
                raise NoSolutionError(
                    f"the plant is not stable: its poles are the roots of "
                    f"{format_polynomial(modes)}, and its Gramians are infinite; stabilise it "
                    "first, or take the stable part"
                )
        else:
            conditions = tuple(stability_conditions(modes))
        solver = solve_stein if discrete else solve_lyapunov
        first, second = solver(A, B * B.T), solver(A.T, C.T * C)
        if not (first.is_unique and second.is_unique):
            raise NoSolutionError("two modes cancel for all values of the symbols: not stable")
        reached, observed = first.X, second.X
        exceptional = exceptional_factors([*first.exceptional, *second.exceptional])
    else:
        reached = observed = zero_matrix(0, 0)
        exceptional = ()
    energy = sympy.cancel((C * reached * C.T).trace())
    norm = energy + direct if discrete else sympy.oo if not D.is_zero_matrix else energy
    left = (
        [A * reached * A.T + B * B.T - reached, A.T * observed * A + C.T * C - observed]
        if discrete
        else [A * reached + reached * A.T + B * B.T, A.T * observed + observed * A + C.T * C]
    )
    left += [reached - reached.T, observed - observed.T]
    certificate = certificate_of(IDENTITY, left)
    return Gramians(reached, observed, norm, conditions, exceptional, certificate)
