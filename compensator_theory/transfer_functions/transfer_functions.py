"""Exact SISO transfer functions that keep the common factors they were given."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import sympy
from sympy import Expr, Poly, Rational, Symbol
from sympy.printing.pretty.stringpict import prettyForm

from compensator_theory.errors import ImproperError, InputError
from compensator_theory.latex import displayed, fraction
from compensator_theory.matrices.certificates import Certificate
from compensator_theory.polynomials.budget import quoted
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical, monic, scaled
from compensator_theory.polynomials.reading import polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.roots.certified import Root, certified_roots
from compensator_theory.transfer_functions.sample_times import time_base, to_float
from compensator_theory.transfer_functions.substitution import Substitution

if TYPE_CHECKING:
    import control
    from sympy.physics.control import TransferFunction as SympyTransferFunction


@dataclass(frozen=True, repr=False)
class TransferFunction(Substitution, ExactValue):
    r"""A quotient of two exact polynomials with monic denominator, never reduced silently.

    .. math:: G = \frac{N}{D}, \qquad D(s) = s^n + D_{n-1}s^{n-1} + \cdots + D_0

    Parameters
    ----------
    numerator, denominator : sympy.Poly
        In the same variable. Both are divided by the leading coefficient of the denominator,
        which, if symbolic, is taken to be nonzero.
    certificate : Certificate, optional
        Where it was converted from a realisation: the identity that was checked.
    feedback : {+1, -1}, optional
        Of a compensator: the sign of the loop that it was designed for. Functions that close a loop
        refuse another one.
    sample_time : Rational, optional
        In seconds, where it was read from a system that has one; arithmetic keeps it, and it goes
        back out with it.

    Raises
    ------
    InputError
        If the denominator is zero or the variables differ.

    Notes
    -----
    A factor that `numerator` and `denominator` share is part of the data: it is a mode of the plant
    that no compensator moves. :meth:`common_factor` finds it, :meth:`reduced` removes it. With
    symbolic coefficients every statement is about generic values of the symbols, and a predicate
    that depends on the values is None.

    Source: (2.10), (2.12), (7.32), (7.33).

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> G = transfer_function("2*(s + 1)/((s + 1)*(2*s + 4))")
    >>> print(G)
    (s + 1)/(s**2 + 3*s + 2)
    >>> G.order, G.common_factor(), str(G.reduced())
    (2, Poly(s + 1, s, domain='QQ'), '(1)/(s + 2)')
    """

    numerator: Poly
    denominator: Poly
    certificate: Certificate | None = field(default=None, compare=False)
    feedback: int | None = field(default=None, compare=False)
    sample_time: Rational | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        numerator, denominator = polynomial(self.numerator), polynomial(self.denominator)
        if numerator.gen != denominator.gen:
            raise InputError(
                f"the numerator is a polynomial in {numerator.gen} and the denominator in "
                f"{denominator.gen}; they need the same variable"
            )
        if denominator.is_zero:
            raise InputError(f"the denominator of {quoted(numerator)} over 0 is zero")
        leading = denominator.LC()
        if leading != 1:
            numerator, denominator = scaled(numerator, 1 / leading), monic(denominator)
        object.__setattr__(self, "numerator", numerator)
        object.__setattr__(self, "denominator", denominator)

    @property
    def variable(self) -> Symbol:
        """Variable of numerator and denominator."""
        return self.denominator.gen

    @property
    def order(self) -> int:
        """Degree of the (unreduced) denominator."""
        return int(self.denominator.degree())

    @property
    def relative_degree(self) -> int:
        """Degree of the denominator minus degree of the numerator; InputError if G = 0."""
        if self.numerator.is_zero:
            raise InputError("the transfer function 0 has no relative degree")
        return self.order - int(self.numerator.degree())

    @property
    def leading_coefficient(self) -> Expr:
        """Leading coefficient of the numerator over the monic denominator, 0 if G = 0."""
        return self.numerator.LC()

    @property
    def is_proper(self) -> bool | None:
        """Whether deg N <= deg D; None if that depends on the value of a symbol."""
        return self._degree_excess_at_most(0)

    @property
    def is_strictly_proper(self) -> bool | None:
        """Whether deg N < deg D; None if that depends on the value of a symbol."""
        return self._degree_excess_at_most(-1)

    @property
    def is_coprime(self) -> bool | None:
        """Whether N and D share no root; None if that depends on the value of a symbol."""
        if self.common_factor().degree() > 0:
            return False
        if self.numerator.domain.is_QQ and self.denominator.domain.is_QQ:
            return True
        resultant = sympy.sympify(self.numerator.resultant(self.denominator))
        known: bool | None = resultant.is_nonzero
        return known

    def common_factor(self) -> Poly:
        """Return the monic greatest common divisor of numerator and denominator."""
        return monic(canonical(self.numerator.gcd(self.denominator)))

    def reduced(self) -> "TransferFunction":
        """Return the same transfer function without its common factor."""
        factor = self.common_factor()
        return TransferFunction(
            canonical(self.numerator.exquo(factor)),
            canonical(self.denominator.exquo(factor)),
            feedback=self.feedback,
            sample_time=self.sample_time,
        )

    def zeros(self) -> tuple[Root, ...]:
        """Return the certified roots of the numerator."""
        return certified_roots(self.numerator)

    def poles(self) -> tuple[Root, ...]:
        """Return the certified roots of the unreduced denominator."""
        return certified_roots(self.denominator)

    def as_expr(self) -> Expr:
        """Return a SymPy expression; SymPy may cancel factors in it."""
        return self.numerator.as_expr() / self.denominator.as_expr()

    def to_sympy(self) -> "SympyTransferFunction":
        """Return the class of sympy.physics.control, numerator and denominator as they are."""
        from sympy.physics.control import TransferFunction as Sympys  # slow to import

        return Sympys(self.numerator.as_expr(), self.denominator.as_expr(), self.variable)

    def to_control(self, dt: float | bool | None = None) -> "control.TransferFunction":
        """Return the python-control object; every coefficient is rounded once to float64.

        Parameters
        ----------
        dt : float or bool, optional
            Sample time in seconds. Default: that which it was read with, else 0 (continuous) for
            ``s`` and True for ``z`` and ``q``.

        Raises
        ------
        InputError
            If a coefficient is symbolic or overflows, or `dt` is needed and missing.
        """
        import control  # slow to import, and only needed at this door

        rounded = [
            [to_float(c) for c in p.all_coeffs()] for p in (self.numerator, self.denominator)
        ]
        return control.TransferFunction(*rounded, time_base(self.variable, self.sample_time, dt))

    def __str__(self) -> str:
        return f"({format_polynomial(self.numerator)})/({format_polynomial(self.denominator)})"

    def __repr__(self) -> str:
        return f"transfer_function('{self}', '{self.variable}')"

    def _latex(self, printer: object = None) -> str:
        """Answer SymPy's printer, which takes our class for its own namesake."""
        return fraction(self.numerator, self.denominator)

    def _sympystr(self, printer: object = None) -> str:
        return str(self)

    def _pretty(self, printer: object = None) -> prettyForm:
        return prettyForm(str(self))

    def _repr_latex_(self) -> str:
        return displayed(self._latex())

    def _degree_excess_at_most(self, bound: int) -> bool | None:
        if self.numerator.is_zero or self.numerator.degree() - self.order <= bound:
            return True
        return False if sympy.sympify(self.numerator.LC()).is_nonzero else None


def require_proper(G: TransferFunction, name: str) -> None:
    """Refuse a transfer function that is not known to be proper.

    Raises
    ------
    ImproperError
        If deg N > deg D.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.transfer_functions.transfer_functions import require_proper
    >>> require_proper(transfer_function("s/(s + 1)"), "plant")
    """
    if not G.is_proper:
        raise ImproperError(
            f"the {name} {G} is improper: its numerator has degree {G.numerator.degree()} and its "
            f"denominator {G.order}; a realisable {name} has at least as many poles as zeros"
        )
