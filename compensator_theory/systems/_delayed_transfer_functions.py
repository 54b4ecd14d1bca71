"""Exact SISO transfer functions with one dead time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import comb, factorial
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import sympy
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory import figures
from compensator_theory._latex import displayed, fraction, latex
from compensator_theory._printing import text
from compensator_theory._showing import picture_of
from compensator_theory.errors import Advice, InputError
from compensator_theory.matrices._certificates import certificate_of
from compensator_theory.polynomials._budget import ask, integer, is_integer, quoted, repr_of
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import from_coefficients
from compensator_theory.systems._sample_times import System
from compensator_theory.systems._transfer_functions import Operand, TransferFunction

if TYPE_CHECKING:
    import control

DelayedOperand: TypeAlias = "DelayedTransferFunction | Operand"
"""Operands of a sum or product with a transfer function that has a dead time."""


@dataclass(frozen=True, repr=False)
class DelayedTransferFunction(System):
    r"""A rational transfer function in continuous time with one dead time.

    .. math:: G = \frac{N(s)}{D(s)}\,e^{-\theta s}, \qquad \theta > 0

    Parameters
    ----------
    rational : TransferFunction
        N/D in s, with all its common factors.
    delay : number
        :math:`\theta` in seconds: a positive rational number, or an expression of symbols.

    Raises
    ------
    InputError
        If the delay is not positive or not rational, or the transfer function is in z or q.

    Notes
    -----
    :func:`transfer_function` reads it from a text or an expression. Its product with another
    transfer function adds the dead times; a sum needs equal ones. These functions take it as it
    is: :func:`stability_margins`, :func:`step_response`, :func:`impulse_response`,
    :func:`time_response` and :func:`~compensator_theory.sampling.zero_order_hold`. The others
    refuse it; :meth:`pade` gives them a rational approximation. Poles and zeros are those of
    `rational`.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> G = transfer_function("2*exp(-3*s)/(10*s + 1)")
    >>> print(G)
    (1/5)/(s + 1/10)*exp(-3*s)
    >>> G.rational, G.delay
    (transfer_function('(1/5)/(s + 1/10)', 's'), 3)
    >>> print(G * G, 1 - G / G, G.pade(1), sep="; ")
    (1/25)/(s**2 + s/5 + 1/100)*exp(-6*s); (0)/(s + 1/10); (-s/5 + 2/15)/(s**2 + 23*s/30 + 1/15)
    >>> G("1j")
    (2/101 - 20*I/101)*exp(-3*I)
    """

    rational: TransferFunction
    delay: Expr

    def __post_init__(self) -> None:
        G, delay = self.rational, exact_number(self.delay)
        if not isinstance(G, TransferFunction):
            raise InputError(f"{repr_of(G)} is not a TransferFunction; make one with its function")
        if G.time == "discrete":
            raise InputError(
                f"{G} is in discrete time, where a dead time of d steps is a factor; write "
                f"{G}/{G.variable}**d"
            )
        if not (delay.is_Rational or delay.free_symbols):
            raise InputError(
                f"the dead time {quoted(delay)} is irrational; give a rational number close to it"
            )
        if G.variable in delay.free_symbols:
            raise InputError(f"the dead time {quoted(delay)} contains the variable {G.variable}")
        if delay == 0:
            raise InputError(f"the dead time is 0; take the rational transfer function {G}")
        if delay.is_negative:
            raise InputError(
                f"exp({quoted(-delay * G.variable)}) predicts: its output comes before its input; "
                "a dead time theta > 0 is exp(-theta*s)"
            )
        object.__setattr__(self, "delay", delay)

    @property
    def variable(self) -> Symbol:
        """Variable of the transfer function."""
        return self.rational.variable

    @property
    def sample_time(self) -> Rational | None:
        """None: continuous time has no sample time."""
        return None

    def as_expr(self) -> Expr:
        """Return a SymPy expression; SymPy may cancel factors in it."""
        return self.rational.as_expr() * self._exponential

    @property
    def _exponential(self) -> Expr:
        return sympy.exp(-self.delay * self.variable)

    def pade(self, order: int, numerator: int | None = None) -> TransferFunction:
        r"""Return the transfer function with a Pade approximant in place of the dead time.

        .. math:: e^{-\theta s} = \frac{N_m(s)}{D_n(s)} + O(s^{m+n+1}), \qquad
                  D_n = \sum_{k=0}^n \binom nk \frac{(m+n-k)!}{(m+n)!} (\theta s)^k, \quad
                  N_m = \sum_{k=0}^m \binom mk \frac{(m+n-k)!}{(m+n)!} (-\theta s)^k

        Parameters
        ----------
        order : int
            n, at least 1.
        numerator : int, optional
            m. Default: n, an all-pass approximant.

        Returns
        -------
        TransferFunction
            Its `certificate` has the coefficients of the remainder below :math:`s^{m+n+1}`.

        Raises
        ------
        InputError, BudgetError
            If a degree is negative or too large, or the order is 0.

        Notes
        -----
        Source: H. Pade (1892); G. A. Baker, P. Graves-Morris, Pade Approximants (1996), Section
        1.2. :func:`~compensator_theory.interpolation.pade_approximant` takes any power series.

        Examples
        --------
        >>> from compensator_theory import transfer_function
        >>> G = transfer_function("exp(-s)/s")
        >>> print(G.pade(2), G.pade(2, numerator=1).certificate, sep="; ")
        (s**2 - 6*s + 12)/(s**3 + 6*s**2 + 12*s); N - exp(-theta s) D up to s^(m + n): holds exactly
        """
        n = integer(order, "the order", at_least=1)
        m = n
        if numerator is not None:
            m = integer(numerator, "the degree of the numerator", at_least=0)
        ask("degree", m + n, "the Pade approximant")
        s = self.variable
        below, above = _pade_coefficients(m, n), _pade_coefficients(n, m)
        theta = self.delay
        D = from_coefficients([c * theta**k for k, c in enumerate(below)][::-1], s)
        N = from_coefficients([c * (-theta) ** k for k, c in enumerate(above)][::-1], s)
        padded = [*above, *[sympy.Integer(0)] * n]
        remainder = [
            ((-1) ** k * padded[k] - sum(
                (below[i] * Rational((-1) ** (k - i), factorial(k - i))
                for i in range(min(k, n) + 1)), start=sympy.Integer(0)
            )) * theta**k for k in range(m + n + 1)
        ]  # fmt: skip
        product = self.rational * TransferFunction(N, D)
        return TransferFunction(
            product.numerator,
            product.denominator,
            certificate_of("N - exp(-theta s) D up to s^(m + n)", [remainder]),
            self.rational.feedback,
        )

    def to_control(self, order: int, numerator: int | None = None) -> control.TransferFunction:
        """Return the python-control object of :meth:`pade`, rounded once to float64."""
        return self.pade(order, numerator).to_control()

    def plot(self, view: str = "all", **options: Any) -> figures.Figure:
        """Draw the step response, Bode's plot and Nyquist's curve, the dead time exact.

        Margins are those of the loop closed by negative feedback, L = G.

        Parameters
        ----------
        view : {"all", "step", "bode", "nyquist", "poles"}
            One of them, or all. Poles and zeros are those of `rational`.
        ax : matplotlib Axes or sequence of Axes, optional
            Where it is drawn instead of in a new figure, as in :meth:`TransferFunction.plot`.
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
        >>> figure = transfer_function("2*exp(-3*s)/(10*s + 1)").plot("bode")
        >>> [axis.get_title() for axis in figure.axes]
        ['gain margin 2.95 at 0.58', 'phase margin 90.2 degrees at 0.173']
        """
        return picture_of(self, view=view, **options)

    def __call__(self, point: NumberLike) -> Expr:
        """Return the value at a number or a symbolic point.

        Raises
        ------
        InputError
            If the point is a pole.
        """
        at = exact_number(point)
        return self.rational(at) * sympy.exp(-self.delay * at)

    __array_ufunc__ = None  # an array of numbers times a transfer function is refused, not looped
    _op_priority = 20.0  # SymPy's expressions delegate sums and products to this class

    def _sympy_(self) -> Expr:
        """Convert to an expression for SymPy's functions."""
        return self.as_expr()

    def __neg__(self) -> DelayedTransferFunction:
        return DelayedTransferFunction(-self.rational, self.delay)

    def __pos__(self) -> DelayedTransferFunction:
        return self

    def __add__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        if not isinstance(other, DelayedTransferFunction):
            term = _rational(self.rational, other)
            if term is None:
                return cast("DelayedTransferFunction", NotImplemented)
            if term.numerator.is_zero:  # as the built-in sum begins with
                return self
            raise self._sum_refused(sympy.Integer(0))
        if not _are_equal(self.delay, other.delay):
            raise self._sum_refused(other.delay)
        return DelayedTransferFunction(self.rational + other.rational, self.delay)

    __radd__ = __add__

    def __sub__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        if isinstance(other, DelayedTransferFunction):
            return self + -other
        return self + other

    def __rsub__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        return -self + other

    def __mul__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        return self._joined(other, lambda a, b: a * b, 1)

    __rmul__ = __mul__

    def __truediv__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        return self._joined(other, lambda a, b: a / b, -1)

    def __rtruediv__(self, other: DelayedOperand) -> TransferFunction | DelayedTransferFunction:
        quotient = _rational(self.rational, other)
        if quotient is None:
            return cast("DelayedTransferFunction", NotImplemented)
        return DelayedTransferFunction(self.rational, -self.delay)  # which refuses a prediction

    def __pow__(self, exponent: int) -> TransferFunction | DelayedTransferFunction:
        if not is_integer(exponent):
            raise TypeError(f"{exponent!r} is no exponent of a transfer function; an int is")
        return delayed(self.rational**exponent, self.delay * exponent)

    def _joined(
        self,
        other: DelayedOperand,
        operation: Callable[[TransferFunction, TransferFunction], TransferFunction],
        sign: int,
    ) -> TransferFunction | DelayedTransferFunction:
        late: Expr = sympy.Integer(0)
        if isinstance(other, DelayedTransferFunction):
            factor: TransferFunction | None = other.rational
            late = other.delay
        else:
            factor = _rational(self.rational, other)
        if factor is None:
            return cast("DelayedTransferFunction", NotImplemented)
        return delayed(operation(self.rational, factor), self.delay + sign * late)

    def _sum_refused(self, other: Expr) -> InputError:
        return InputError(
            f"the terms of the sum have the dead times {quoted(self.delay)} s and {quoted(other)} "
            "s; give the quasi-polynomial of the loop to stability_delays, ",
            way_of_pade("or add the approximations G.pade({order})"),
        )

    def __str__(self) -> str:
        return f"{self.rational}*{text(self._exponential)}"

    def __repr__(self) -> str:
        return f"transfer_function('{self}', '{self.variable}')"

    def _repr_latex_(self) -> str:
        G = self.rational
        return displayed(f"{fraction(G.numerator, G.denominator)} {latex(self._exponential)}")


def way_of_pade(words: str) -> Advice:
    """Return the advice to approximate a dead time."""
    return Advice("DelayedTransferFunction.pade", (("order", "3"),), words)


def delayed(rational: TransferFunction, delay: Expr) -> TransferFunction | DelayedTransferFunction:
    """Return a transfer function with a dead time, which may be 0."""
    late = sympy.expand(delay)
    return rational if late == 0 else DelayedTransferFunction(rational, late)


def refuse_dead_time(G: DelayedTransferFunction) -> InputError:
    """Return the error of a function that takes rational transfer functions."""
    return InputError(
        f"{G} has a dead time, and this function takes rational transfer functions; ",
        way_of_pade(
            "give an approximation, G.pade({order}), or sample it by zero_order_hold. "
            "stability_margins, step_response, impulse_response, time_response and design take the "
            "dead time as it is"
        ),
    )


def _are_equal(a: Expr, b: Expr) -> bool:
    return bool(sympy.expand(a - b) == 0)


def _rational(like: TransferFunction, operand: Operand) -> TransferFunction | None:
    """Return an operand as a transfer function in the same variable; None if it is none."""
    one = Poly(1, like.variable, domain="QQ")
    product: object = TransferFunction(one, one).__mul__(operand)
    return product if isinstance(product, TransferFunction) else None


def _pade_coefficients(m: int, n: int) -> list[Rational]:
    """Return binom(n, k) (m + n - k)!/(m + n)! for k = 0 to n."""
    whole = factorial(m + n)
    return [Rational(comb(n, k) * factorial(m + n - k), whole) for k in range(n + 1)]
