"""The solution of a pole placement problem, with its certificate."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import sympy
from sympy import Expr, Poly

from compensator_theory._latex import displayed, fraction, latex
from compensator_theory._printing import text
from compensator_theory.bezout._resultants import resultant
from compensator_theory.errors import InputError, RoundingWarning
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
)
from compensator_theory.loops._sensitivity import sensitivity_function
from compensator_theory.loops._siso import closed_loop_of_pair
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.placement._rounding_effects import rounding_effect
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical, over_one_field, scaled
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._transfer_functions import TransferFunction

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, repr=False)
class PolePlacement(Certified, ExactValue):
    r"""The compensators of :func:`place_poles`.

    .. math:: D (D_c + \textstyle\sum_i \alpha_i\,\delta D_i)
              - f N (N_c + \sum_i \alpha_i\,\delta N_i) = \lambda\tilde D

    Attributes
    ----------
    plant : TransferFunction
        N/D of order n, as given.
    target : sympy.Poly
        :math:`\tilde D`, monic.
    feedback : int
        The sign f, +1 or -1.
    numerator, denominator : sympy.Poly
        :math:`N_c` and the monic :math:`D_c` of one solution.
    homogeneous : tuple of pairs of sympy.Poly
        :math:`(\delta N_i, \delta D_i)`; empty if the solution is unique.
    roots : tuple of sympy.Expr or None
        The list that was given, read as roots; None if a polynomial was given.

    Notes
    -----
    Source: (7.23), (7.34)-(7.36), Proposition 5.

    Examples
    --------
    >>> from compensator_theory import place_poles
    >>> family = place_poles("1/(s - 1)", [-1, -2], feedback=-1, numerator_degree=1)
    >>> family.is_unique, family.residual.is_zero
    (False, True)
    >>> print(family.member([1]))  # 1 is the coefficient of s in N_c
    (s + 5)/(s + 3)
    """

    _CARRIES = True

    identity = "D D_c - f N N_c = lambda D~, D dD_i = f N dN_i"

    plant: TransferFunction
    target: Poly
    feedback: int
    numerator: Poly
    denominator: Poly
    homogeneous: tuple[tuple[Poly, Poly], ...] = ()
    roots: tuple[Expr, ...] | None = field(default=None, compare=False)

    @property
    def is_unique(self) -> bool:
        """Whether no other compensator of these degrees exists."""
        return not self.homogeneous

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Irreducible polynomials in the symbols; the answer holds where none of them is zero.

        They divide the resultant of N and D, without the factor that they share, or a denominator
        of the answer. Where one is zero there may be no compensator or a family:
        :func:`exceptional_cases` finds them. Empty without symbols.
        """
        answers = [(self.numerator, self.denominator), *self.homogeneous]
        matrices = [PolynomialMatrix((pair,)) for pair in answers]
        g = self.plant.common_factor()
        p, q = (canonical(side.quo(g)) for side in (self.plant.denominator, self.plant.numerator))
        matrices.append(PolynomialMatrix(((g, self.target),)))
        return exceptional_factors([resultant(p, q, variable=p.gen), *denominators(*matrices)])

    @property
    def compensator(self) -> TransferFunction:
        """The pair (N_c, D_c) as an unreduced transfer function, which knows its sign."""
        return TransferFunction(
            self.numerator,
            self.denominator,
            feedback=self.feedback,
            sample_time=self.plant.sample_time,
        )

    @property
    def leading_coefficient(self) -> Expr:
        r"""The factor :math:`\lambda`, 1 unless plant and compensator are both exactly proper."""
        return self.closed_loop_polynomial(self.compensator).LC()

    @property
    def residual(self) -> Poly:
        r"""The residual :math:`D D_c - f N N_c - \lambda\tilde D`, recomputed; zero."""
        return self.residual_of(self.compensator)

    def _residuals(self) -> list[Poly]:
        residuals = [self.residual]
        for pair in self.homogeneous:
            sides = self.plant.denominator, self.plant.numerator, *pair
            D, N, above, below = over_one_field(*sides)
            residuals.append(canonical(D * below - N * above * self.feedback))
        return residuals

    def residual_of(self, compensator: TransferFunction) -> Poly:
        """Return the residual of any compensator, for instance of a :meth:`member`."""
        polynomial, target = over_one_field(self.closed_loop_polynomial(compensator), self.target)
        leading = Poly({(0,): polynomial.rep.LC()}, polynomial.gen, domain=polynomial.domain)
        return canonical(polynomial - target * leading)

    def closed_loop_polynomial(self, compensator: TransferFunction) -> Poly:
        """Return D D_c - f N N_c for any compensator in the same variable."""
        return closed_loop_of_pair(self.plant, compensator, self.feedback)

    def member(self, parameters: Sequence[NumberLike]) -> TransferFunction:
        """Return one compensator of the family.

        Parameters
        ----------
        parameters : sequence
            One number or symbol for each entry of :attr:`homogeneous`.

        Raises
        ------
        InputError
            If their number is wrong, or one contains the variable.
        """
        if len(parameters) != len(self.homogeneous):
            raise InputError(
                f"there are {len(parameters)} parameters; this family has {len(self.homogeneous)}"
            )
        values = [sympy.sympify(exact_number(parameter)) for parameter in parameters]
        if any(self.plant.variable in value.free_symbols for value in values):
            raise InputError(
                f"the parameters {values} contain {self.plant.variable}, the variable of the "
                "transfer function; give numbers or other symbols"
            )
        numerator, denominator = self.numerator, self.denominator
        for parameter, (d_numerator, d_denominator) in zip(values, self.homogeneous, strict=True):
            numerator = canonical(numerator + scaled(d_numerator, parameter))
            denominator = canonical(denominator + scaled(d_denominator, parameter))
        return replace(self.compensator, numerator=numerator, denominator=denominator)

    @property
    def sensitivity(self) -> TransferFunction:
        r"""The sensitivity function :math:`S = D D_c/\tilde D` of (7.22)."""
        return sensitivity_function(self.plant, self.compensator, feedback=self.feedback)

    def to_control(self, dt: float | bool | None = None) -> control.TransferFunction:
        """Return the compensator as a python-control object, rounded once to float64.

        Parameters
        ----------
        dt : float or bool, optional
            As for :meth:`TransferFunction.to_control`.

        Warns
        -----
        RoundingWarning
            If rounding the coefficients alone makes a stable loop unstable, or moves a pole by more
            than a tenth of its distance to the stability boundary.

        Raises
        ------
        InputError
            If a coefficient is symbolic or overflows.
        """
        system = self.compensator.to_control(dt)
        effect = rounding_effect(self.plant, self.compensator, feedback=self.feedback)
        if effect.is_dangerous:
            warnings.warn(
                f"{effect}. Keep the exact compensator, or realise it as a cascade",
                RoundingWarning,
                stacklevel=2,
            )
        return system

    def __repr__(self) -> str:
        request = f"polynomial {format_polynomial(self.target)}"
        if self.roots is not None:
            listed = ", ".join(map(text, self.roots))
            request = f"ROOTS {listed} (a list holds roots; coefficients go to polynomial=)"
        return f"<PolePlacement with feedback {self.feedback:+d} of the {request}: {self}>"

    def __str__(self) -> str:
        count = len(self.homogeneous)
        degrees = f"deg N_c <= {self._numerator_bound()}, deg D_c = {self.denominator.degree()}"
        extent = "unique" if self.is_unique else f"one of a {count}-parameter family"
        sign = "-" if self.feedback == 1 else "+"
        factor = "" if self.leading_coefficient == 1 else f"({text(self.leading_coefficient)}) * "
        target = format_polynomial(self.target)
        target = f"({target})" if factor else target
        return (
            f"G_c = {self.compensator}\n{extent}: {degrees}\nD D_c {sign} N N_c = {factor}{target}"
        )

    def _numerator_bound(self) -> int:
        degrees = [d_numerator.degree() for d_numerator, _ in self.homogeneous]
        return int(max([min(self.plant.order - 1, self.denominator.degree()), *degrees]))

    def _repr_latex_(self) -> str:
        sign = "-" if self.feedback == 1 else "+"
        return displayed(
            f"G_c = {fraction(self.numerator, self.denominator)}",
            f"D D_c {sign} N N_c = {latex(self.target)}",
        )
