"""Exact SISO transfer functions that keep their common factors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import sympy
from sympy import Expr, Poly, Rational, Symbol
from sympy.printing.pretty.stringpict import prettyForm

from compensator_theory import figures
from compensator_theory._latex import displayed, fraction
from compensator_theory._showing import picture_of
from compensator_theory.errors import ImproperError, InputError
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.polynomials._budget import ask, is_integer, quoted, repr_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import (
    canonical,
    common_divisor,
    exact_quotient,
    monic,
    over_one_field,
    product,
    scaled,
    sides_in,
    total,
)
from compensator_theory.polynomials._quotients import Quotient, multiplied_out
from compensator_theory.polynomials._reading import polynomial, read_quotient
from compensator_theory.polynomials._sympy_trees import tree_of
from compensator_theory.polynomials._variables import (
    DISCRETE,
    as_symbol,
    evident_variable,
    require_no_other_operator,
)
from compensator_theory.roots._certified import Root
from compensator_theory.roots._closed_forms import RootFormula, roots_of
from compensator_theory.systems._sample_times import (
    System,
    period_in,
    shared_sample_time,
    time_base,
    to_float,
)

if TYPE_CHECKING:
    import control
    from sympy.physics.control import TransferFunction as SympyTransferFunction

Sides: TypeAlias = tuple[Poly, Poly]
Operand: TypeAlias = "TransferFunction | NumberLike | Poly"
"""Operands of a sum or product with a transfer function."""


@dataclass(frozen=True, repr=False)
class TransferFunction(System):
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
    sample_time : number, optional
        In seconds, for z and q alone; whatever is made of the system keeps it.

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

    The operators + - * / ** follow the rules of a text: a sum over one denominator keeps it, a sum
    over two different ones is over their product, a product multiplies numerators and denominators,
    and nothing cancels. So G - G is 0 over the denominator of G, and G/G is N D over D N. A sample
    time is kept, and two different ones are refused.

    Source: (2.10), (2.12), (7.32), (7.33).

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> G = transfer_function("2*(s + 1)/((s + 1)*(2*s + 4))")
    >>> print(G)
    (s + 1)/(s**2 + 3*s + 2)
    >>> G.order, G.common_factor(), str(G.reduced())
    (2, Poly(s + 1, s, domain='QQ'), '(1)/(s + 2)')
    >>> G = transfer_function("1/(s + 1)")
    >>> print(G + 2, G * G, G**-2 / "s + a", sep=", ")
    (2*s + 3)/(s + 1), (1)/(s**2 + 2*s + 1), (s**2 + 2*s + 1)/(s + a)
    >>> import sympy
    >>> sympy.simplify(G), sympy.limit(G, "s", 0)  # SymPy's functions take it as an expression
    (1/(s + 1), 1)
    >>> G = transfer_function("1/(s + a)", "s")
    >>> print(G(1), G.subs({"a": 2}), G.subs({"a": 1}).compose("(z - 1)/(z + 1)"), sep=", ")
    1/(a + 1), (1)/(s + 2), (z/2 + 1/2)/(z)
    """

    numerator: Poly
    denominator: Poly
    certificate: Certificate | None = field(default=None, compare=False)
    feedback: int | None = field(default=None, compare=False)
    sample_time: Rational | None = None

    def __post_init__(self) -> None:
        numerator, denominator = self.numerator, self.denominator
        if not (isinstance(numerator, Poly) and isinstance(denominator, Poly)):
            numerator, denominator = polynomial(numerator), polynomial(denominator)
        numerator, denominator = canonical(numerator), canonical(denominator)
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
        object.__setattr__(self, "sample_time", period_in(denominator.gen, self.sample_time))

    @property
    def variable(self) -> Symbol:
        """Variable of numerator and denominator."""
        return self.denominator.gen

    @property
    def characteristic_polynomial(self) -> Poly:
        """The denominator: its roots are the poles, with those that the numerator cancels."""
        return self.denominator

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
        if _resultant_varies(self.numerator, self.denominator):
            return None
        top, bottom = over_one_field(self.numerator, self.denominator)
        resultant = sympy.sympify(top.resultant(bottom))
        known: bool | None = resultant.is_nonzero
        return known

    def common_factor(self) -> Poly:
        """Return the monic greatest common divisor of numerator and denominator."""
        return common_divisor(self.numerator, self.denominator)

    def reduced(self) -> TransferFunction:
        """Return the same transfer function without its common factor."""
        factor = self.common_factor()
        return TransferFunction(
            exact_quotient(self.numerator, factor),
            exact_quotient(self.denominator, factor),
            feedback=self.feedback,
            sample_time=self.sample_time,
        )

    def zeros(self) -> tuple[Root | RootFormula, ...]:
        """Return the roots of the numerator, as :meth:`poles` returns those of the denominator."""
        return roots_of(self.numerator)

    def poles(self) -> tuple[Root | RootFormula, ...]:
        """Return the roots of the unreduced denominator.

        Of a rational transfer function in certified disks; with symbols or surds in closed form.

        Raises
        ------
        NoSolutionError
            If, with symbols, an irreducible factor has degree three or more.

        Examples
        --------
        >>> from compensator_theory import transfer_function
        >>> print(*transfer_function("1/(s**2 + 2*z*w*s + w**2)", "s").poles(), sep="; ")
        -w*z - w*sqrt(z**2 - 1); -w*z + w*sqrt(z**2 - 1)
        """
        return roots_of(self.denominator)

    def as_expr(self) -> Expr:
        """Return a SymPy expression; SymPy may cancel factors in it."""
        return self.numerator.as_expr() / self.denominator.as_expr()

    def evalf(self, digits: int = 15) -> Expr:
        """Return a SymPy expression with floats of so many digits, to look at.

        Examples
        --------
        >>> from compensator_theory import transfer_function
        >>> transfer_function("(s + 1/3)/(s + sqrt(2))").evalf(4)
        (s + 0.3333)/(s + 1.414)
        """
        return self.numerator.as_expr().evalf(digits) / self.denominator.as_expr().evalf(digits)

    def to_sympy(self) -> SympyTransferFunction:
        """Return the class of sympy.physics.control, numerator and denominator as they are."""
        from sympy.physics.control import TransferFunction as Sympys  # slow to import

        return Sympys(self.numerator.as_expr(), self.denominator.as_expr(), self.variable)

    def to_control(self, dt: float | bool | None = None) -> control.TransferFunction:
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
        import control  # slow to import, and only needed here

        rounded = [
            [to_float(c) for c in p.all_coeffs()] for p in (self.numerator, self.denominator)
        ]
        return control.TransferFunction(*rounded, time_base(self.variable, self.sample_time, dt))

    def plot(self, view: str = "all", **options: Any) -> figures.Figure:
        """Draw the step response, Bode's plot, Nyquist's curve, and the poles and zeros.

        Margins are those of the loop closed by negative feedback, L = G.

        Parameters
        ----------
        view : {"all", "step", "bode", "nyquist", "poles"}
            One of them, or all.
        ax : matplotlib Axes or sequence of Axes, optional
            Where it is drawn instead of in a new figure: two for Bode's plot, five for all (step,
            gain, phase, Nyquist, poles).
        width : float
            Of the figure in inches.

        Returns
        -------
        matplotlib.figure.Figure
            Not attached to a window.

        Raises
        ------
        InputError
            If the view is none of these, or G has symbols.

        Examples
        --------
        >>> from compensator_theory import transfer_function
        >>> figure = transfer_function("10/(s*(s + 1)*(s + 5))").plot("bode")
        >>> [axis.get_title() for axis in figure.axes]
        ['gain margin 3 at 2.24', 'phase margin 25.4 degrees at 1.23']
        """
        return picture_of(self, view=view, **options)

    def __call__(self, point: NumberLike) -> Expr:
        r"""Return the value at a number or a symbolic point, G(1), G(2j) or G("exp(1)").

        Raises
        ------
        InputError
            If the point is a root of the denominator.
        """
        at = exact_number(point)
        top, bottom = (
            _expanded(side.as_expr().subs(side.gen, at))
            for side in (self.numerator, self.denominator)
        )
        if bottom == 0:
            shared = "a root that numerator and denominator share; take .reduced()"
            reason = shared if top == 0 else "a pole"
            raise InputError(
                f"{self} has no value at {self.denominator.gen} = {at}: it is {reason}"
            )
        return quotient_of(top / bottom).value()

    def compose(self, inner: Operand, variable: str | Symbol | None = None) -> TransferFunction:
        r"""Put a transfer function in place of the variable, for instance Tustin's.

        .. math:: G\Big(\frac{p}{q}\Big) = \frac{\sum_k N_k p^k q^{d-k}}{\sum_k D_k p^k q^{d-k}},
                  \qquad d = \max(\deg N, \deg D)

        Parameters
        ----------
        inner : transfer function, str, expression or number
            In its own variable, which is that of the result.
        variable : str or Symbol, optional
            The variable of `inner` where it does not show it.

        Raises
        ------
        InputError
            If the denominator becomes zero.
        """
        top, bottom = _inner(inner, self.denominator.gen, variable)
        d = max(self.numerator.degree(), self.denominator.degree())
        ask("degree", int(d) * max(1, int(top.degree()), int(bottom.degree())), "the composition")
        powers = [(constant_one(top), constant_one(top))]
        for _ in range(int(d)):
            powers.append((powers[-1][0] * top, powers[-1][1] * bottom))
        sides = []
        for side in (self.numerator, self.denominator):
            terms = [
                powers[k][0] * powers[int(d) - k][1] * Poly(c, top.gen) for (k,), c in side.terms()
            ]
            sides.append(canonical(sum(terms, start=Poly(0, top.gen))))
        if sides[1].is_zero:
            raise InputError(f"{self} has no value there: its denominator becomes zero")
        period = self.sample_time if top.gen == self.denominator.gen else None
        period = getattr(inner, "sample_time", None) or period
        return TransferFunction(sides[0], sides[1], sample_time=period)

    __array_ufunc__ = None  # an array of numbers times a transfer function is refused, not looped
    _op_priority = 20.0  # SymPy's expressions delegate sums and products to this class

    def _sympy_(self) -> Expr:
        """Convert to an expression for SymPy's functions, such as simplify, apart and limit."""
        return self.as_expr()

    def __add__(self, other: Operand) -> TransferFunction:
        return self._join(other, added)

    __radd__ = __add__

    def __sub__(self, other: Operand) -> TransferFunction:
        return self._join(other, lambda a, b: added(a, (-b[0], b[1])))

    def __rsub__(self, other: Operand) -> TransferFunction:
        return self._join(other, lambda a, b: added(b, (-a[0], a[1])))

    def __neg__(self) -> TransferFunction:
        return TransferFunction(-self.numerator, self.denominator, sample_time=self.sample_time)

    def __pos__(self) -> TransferFunction:
        return self

    def __mul__(self, other: Operand) -> TransferFunction:
        return self._join(other, multiplied)

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> TransferFunction:
        return self._join(other, lambda a, b: multiplied(a, inverted(b)))

    def __rtruediv__(self, other: Operand) -> TransferFunction:
        return self._join(other, lambda a, b: multiplied(b, inverted(a)))

    def __pow__(self, exponent: int) -> TransferFunction:
        if not is_integer(exponent):
            raise TypeError(f"{exponent!r} is no exponent of a transfer function; an int is")
        sides = self.numerator, self.denominator
        top, bottom = inverted(sides) if exponent < 0 else sides
        for side in (top, bottom):
            ask("degree", int(max(0, side.total_degree())) * abs(exponent), "the power")
        return TransferFunction(
            canonical(top ** abs(exponent)),
            canonical(bottom ** abs(exponent)),
            sample_time=self.sample_time,
        )

    def _join(self, other: Operand, operation: Callable[[Sides, Sides], Sides]) -> TransferFunction:
        sides = sides_of(other, self.denominator.gen)
        if sides is None:
            return cast(TransferFunction, NotImplemented)  # Python then asks the other operand
        joined = operation((self.numerator, self.denominator), sides)
        return TransferFunction(*joined, sample_time=shared_sample_time(self, other))

    def __str__(self) -> str:
        return f"({format_polynomial(self.numerator)})/({format_polynomial(self.denominator)})"

    def __repr__(self) -> str:
        return f"transfer_function('{self}', '{self.variable}')"

    def _sympystr(self, printer: object = None) -> str:
        """Print for SymPy, whose printer mistakes this class for SymPy's TransferFunction."""
        return str(self)

    def _pretty(self, printer: object = None) -> prettyForm:
        return prettyForm(str(self))

    def _repr_latex_(self) -> str:
        return displayed(fraction(self.numerator, self.denominator))

    def _degree_excess_at_most(self, bound: int) -> bool | None:
        if self.numerator.is_zero or self.numerator.degree() - self.order <= bound:
            return True
        return False if sympy.sympify(self.numerator.LC()).is_nonzero else None


def require_proper(G: TransferFunction, name: str) -> None:
    """Refuse a transfer function that is not provably proper."""
    if not G.is_proper:
        s = G.variable
        pole = f"{s}" if s.name in DISCRETE else f"(1 + {s}/100)"
        raise ImproperError(
            f"the {name} {G} is improper: its numerator has degree {G.numerator.degree()} and its "
            f"denominator {G.order}; a realisable {name} has at least as many poles as zeros: "
            f"divide by a fast pole for each that is missing, as in G/{pole}"
        )


def sides_of(operand: Operand | Quotient, variable: Symbol) -> Sides | None:
    """Return numerator and denominator of an operand; None if it is none."""
    if isinstance(operand, TransferFunction):
        if operand.denominator.gen != variable:
            raise InputError(
                f"{operand} is in {operand.denominator.gen} and the other operand in {variable}; "
                "both need one variable"
            )
        return operand.numerator, operand.denominator
    if isinstance(operand, Poly):
        return polynomial(operand, variable), constant_one(polynomial(operand, variable))
    try:
        quotient = read_quotient(operand)
    except InputError:
        if isinstance(operand, str | Expr | int | float | complex):
            raise  # a NaN, for instance: the reason is better than "unsupported operand"
        return None
    return _in_one_operator(sides_in(quotient, variable))


def added(a: Sides, b: Sides) -> Sides:
    """Add two quotients over the denominator they share, else over the product of both."""
    if a[1] == b[1]:
        return total(a[0], b[0]), a[1]
    (n_1, d_2), (n_2, d_1) = (a[0], b[1]), (b[0], a[1])
    return total(product(n_1, d_2), product(n_2, d_1)), product(d_1, d_2)


def multiplied(a: Sides, b: Sides) -> Sides:
    """Multiply two quotients, side by side."""
    return product(a[0], b[0]), product(a[1], b[1])


def inverted(sides: Sides) -> Sides:
    """Exchange numerator and denominator."""
    if sides[0].is_zero:
        raise InputError("the transfer function 0 has no inverse")
    return sides[1], sides[0]


def constant_one(like: Poly) -> Poly:
    """Return 1 as a polynomial in the same variable."""
    return Poly(1, like.gen, domain=sympy.QQ)


def quotient_of(expression: Expr) -> Quotient:
    """Multiply out a SymPy expression, as SymPy has it."""
    return multiplied_out(tree_of(expression), least_denominators=True)


def _in_one_operator(sides: Sides) -> Sides:
    """Refuse z or q as a symbol of the coefficients of a system in s, and the reverse."""
    require_no_other_operator(*sides)
    return sides


def _inner(inner: Operand, outer: Symbol, variable: str | Symbol | None) -> Sides:
    if isinstance(inner, TransferFunction | Poly):
        read: Operand | Quotient = inner
        variable_of_inner = inner.gen if isinstance(inner, Poly) else inner.denominator.gen
    else:
        read = read_quotient(inner)
        occurring = read.value().free_symbols
        variable_of_inner = evident_variable(occurring, repr(inner)) if occurring else outer
    sides = sides_of(read, variable_of_inner if variable is None else as_symbol(variable))
    if sides is None:
        raise InputError(f"{repr_of(inner)} cannot replace {outer}")
    return sides


def _expanded(expression: Expr) -> Expr:
    return quotient_of(sympy.expand(expression)).value()


def _resultant_varies(top: Poly, bottom: Poly) -> bool:
    """Tell whether the resultant is seen to depend on symbols of which nothing is known."""
    symbols = sorted(top.free_symbols_in_domain | bottom.free_symbols_in_domain, key=str)
    if any(x != Symbol(x.name) for x in symbols):  # a positive one decides signs
        return False
    values = []
    for first in (3, 14):
        point = {x: Rational(first + 7 * k**2, 5) for k, x in enumerate(symbols)}
        at_point = [Poly([c.xreplace(point) for c in p.all_coeffs()], p.gen) for p in (top, bottom)]
        degrees = [p.degree() for p in (top, bottom)]
        if [p.degree() for p in at_point] != degrees or not all(
            p.domain.is_QQ or p.domain.is_ZZ for p in at_point
        ):
            return False
        values.append(at_point[0].resultant(at_point[1]))
    return bool(values[0] != values[1])
