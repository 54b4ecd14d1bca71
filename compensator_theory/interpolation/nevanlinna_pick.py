"""Nevanlinna-Pick interpolation: how large a stable function with given values must be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import mul

import sympy
from sympy import QQ, QQ_I, Expr, ImmutableMatrix, Poly, Symbol
from sympy.polys.domains.gaussiandomains import GaussianRational
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.frequency.passivity import decide_bounded_real
from compensator_theory.latex import displayed, latex
from compensator_theory.matrices.certificates import Certificate, certificate_of
from compensator_theory.matrices.flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.polynomials.budget import ask, quoted, shown
from compensator_theory.polynomials.numbers import NumberLike, exact_number, read_coefficients
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import as_symbol, is_discrete
from compensator_theory.printing import text
from compensator_theory.roots.enclosures import Enclosure
from compensator_theory.stabilisation.critical_values import real_roots
from compensator_theory.systems.conversions import TransferFunctionLike, transfer_function
from compensator_theory.transfer_functions.transfer_functions import TransferFunction

LEVEL = Symbol("g")


@dataclass(frozen=True)
class PickInterpolation(ExactValue):
    r"""Whether a stable function of bounded size takes given values, and the least bound.

    Attributes
    ----------
    matrix : sympy.ImmutableMatrix
        Pick's matrix for `bound`, Hermitian.
    bound : sympy.Expr
    is_feasible : bool
        Whether it is positive semidefinite.
    is_unique : bool
        Whether there is one interpolating function only: it is feasible and singular.
    least_squared : sympy.Expr
        The least bound, squared: exact, the largest root of `polynomial`.
    enclosure : Enclosure
        Of `least_squared`, certified.
    polynomial : sympy.Poly
        In g: the determinant of Pick's matrix with bound squared g, up to a factor.
    points, values : tuple of sympy.Expr
        As read.
    variable : Symbol
        s, z or q.
    """

    matrix: ImmutableMatrix
    bound: Expr
    is_feasible: bool
    is_unique: bool
    least_squared: Expr
    enclosure: Enclosure
    polynomial: Poly
    points: tuple[Expr, ...]
    values: tuple[Expr, ...]
    variable: Symbol

    def interpolant(self, parameter: TransferFunctionLike | None = None) -> TransferFunction:
        r"""Return a real function that takes the values and keeps the bound, verified.

        .. math:: f(s_i) = w_i, \quad \|f\|_\infty \le \gamma, \qquad
                  f = \gamma\,\frac{\Theta_{11} g + \Theta_{12}}{\Theta_{21} g + \Theta_{22}}

        Parameters
        ----------
        parameter : transfer function, optional
            g, real, stable and proper with a norm of at most 1: every g gives another f, and every
            f comes from one. Default 0, the central function of order n, or less.

        Returns
        -------
        TransferFunction
            In lowest terms, with :math:`f(\infty) = \gamma\,g(\infty)` (in discrete time at -1),
            and a certificate that it takes the values. That it is stable and within the bound was
            decided by :func:`decide_bounded_real`. Where Pick's matrix is singular of rank r, f is
            unique: gamma times a Blaschke product of degree r.

        Raises
        ------
        NoSolutionError
            If the bound is too small: none exists.
        InputError
            If the data are not closed under conjugation, so that no real function takes the
            values, or the parameter is not bounded by 1, in another variable, or not free.

        Notes
        -----
        Theta is the product of the n steps of Nevanlinna's algorithm, normalised at infinity. It
        then has real coefficients. Source: J. A. Ball, I. Gohberg, L. Rodman, Interpolation of
        Rational Matrix Functions (1990), Chapter 18.

        Examples
        --------
        >>> from compensator_theory import h_infinity_norm, nevanlinna_pick
        >>> found = nevanlinna_pick([1, 2], ["1/2", "1/3"])
        >>> f = found.interpolant()
        >>> print(f, h_infinity_norm(f).value)
        (3*s/4 + 15/4)/(s**2 + 15*s/4 + 17/4) 15/17
        >>> print(found.interpolant("1"))  # lossless: the bound is reached at every frequency
        (s**2 - 3*s + 8)/(s**2 + 3*s + 8)
        >>> print(nevanlinna_pick([2, 3], ["1/3", "1/2"]).interpolant())  # unique
        (s - 1)/(s + 1)
        """
        if not self.is_feasible:
            raise NoSolutionError(f"{self}: no function takes the values within the bound")
        require_closed(self.points, self.values)
        s, discrete = self.variable, is_discrete(self.variable, "interpolation")
        if self.is_unique and parameter is not None:
            raise InputError("the interpolating function is unique; leave the parameter out")
        g = transfer_function(0 if parameter is None else parameter, s)
        if not decide_bounded_real(g, s).holds:
            raise InputError(f"the parameter {g} is not stable with a norm of at most 1")
        if self.bound == 0:
            return transfer_function((0, 1), variable=s)
        scaled = [sympy.expand(w / self.bound) for w in self.values]
        f = solve_pick(self.points, scaled, s, g, discrete=discrete)
        whole = TransferFunction(f.numerator * self.bound, f.denominator)
        return replace(whole, certificate=values_at(whole, self.points, self.values))

    def __str__(self) -> str:
        verdict = "feasible" if self.is_feasible else "not feasible"
        least = sympy.sqrtdenest(sympy.sqrt(self.least_squared))
        return f"{verdict} with bound {text(self.bound)}; the least bound is {text(least)}"

    def _repr_latex_(self) -> str:
        sign = r"\succeq" if self.is_feasible else r"\not\succeq"
        least = latex(sympy.sqrtdenest(sympy.sqrt(self.least_squared)))
        return displayed(
            rf"{latex(self.matrix)} {sign} 0, \quad \gamma = {latex(self.bound)}",
            rf"\gamma_{{\min}} = {least}",
        )


def nevanlinna_pick(
    points: Sequence[NumberLike],
    values: Sequence[NumberLike],
    bound: NumberLike = 1,
    variable: str | Symbol = "s",
) -> PickInterpolation:
    r"""Decide whether a stable function with H-infinity norm at most gamma takes given values.

    .. math:: f(s_i) = w_i, \quad \|f\|_\infty \le \gamma \qquad\Longleftrightarrow\qquad \left[
              \frac{\gamma^2 - \bar w_i w_j}{\bar s_i + s_j} \right]_{i,j} \ge 0

    In discrete time the denominators are :math:`1 - 1/(\bar z_i z_j)`.

    Parameters
    ----------
    points : sequence of numbers
        Different, right of the imaginary axis (s) or outside of the unit circle (z, q), where f is
        analytic: rational, or complex with rational parts. For a real function give complex points
        together with their conjugates.
    values : sequence of numbers
        As many.
    bound : number
        gamma, rational, at least 0.
    variable : str or Symbol
        s, z or q: which region.

    Raises
    ------
    InputError, BudgetError
        If a point is in the wrong region or there twice, a number is not rational, or the numbers
        of points and values differ.

    Notes
    -----
    The least bound solves a generalised eigenvalue problem; its polynomial has real coefficients.
    It is what no sensitivity of a plant with these zeros and values there can fall below. Source:
    G. Pick (1916), R. Nevanlinna (1919); J. C. Doyle, B. A. Francis, A. R. Tannenbaum, Feedback
    Control Theory (1992), Chapter 9.

    Examples
    --------
    >>> from compensator_theory import nevanlinna_pick
    >>> print(nevanlinna_pick([1, 2], [1, -1], 5))
    not feasible with bound 5; the least bound is 2*sqrt(2) + 3
    >>> nevanlinna_pick([1, 2], ["1/2", "1/3"]).is_feasible
    True
    """
    symbol = as_symbol(variable)
    discrete = is_discrete(symbol, "interpolation")
    where, w = (_numbers(listed, name) for listed, name in ((points, "points"), (values, "values")))
    gamma = sympy.sympify(exact_number(bound))
    if not gamma.is_Rational or gamma < 0:
        raise InputError(f"the bound {gamma} must be a rational number, at least 0")
    n = len(where)
    if len(w) != n:
        raise InputError(f"there are {n} points and {len(w)} values; give as many")
    if len(set(where)) < n:
        raise InputError("a point is there twice; values of derivatives are not read here")
    ask("entries", n**4 // 20, "the polynomial of Pick's matrix")  # n coefficients of n^2 digits
    for point in where:
        size = sympy.expand(point * sympy.conjugate(point)) - 1 if discrete else sympy.re(point)
        if size <= 0:
            region = "outside of the unit circle" if discrete else "right of the imaginary axis"
            raise InputError(f"the point {point} does not lie {region}")

    def kernel(i: int, j: int) -> Expr:
        a, b = sympy.conjugate(where[i]), where[j]
        bottom = sympy.expand(1 - 1 / sympy.expand(a * b)) if discrete else sympy.expand(a + b)
        mirrored = sympy.conjugate(bottom)
        return sympy.expand(mirrored / sympy.expand(bottom * mirrored))

    A = ImmutableMatrix(n, n, kernel)
    B = ImmutableMatrix(n, n, lambda i, j: sympy.expand(sympy.conjugate(w[i]) * w[j] * A[i, j]))
    polynomial = _pencil(A, B)
    matrix = ImmutableMatrix((gamma**2 * A - B).applyfunc(sympy.expand))
    roots = real_roots([polynomial])
    largest = roots[-1]
    there = polynomial.eval(gamma**2)
    above = all(root.enclosure.upper < gamma**2 for root in roots)
    on = there == 0 and all(
        root.value == gamma**2 or root.enclosure.upper < gamma**2 for root in roots
    )
    return PickInterpolation(
        matrix, gamma, above or on, on, largest.value, largest.enclosure, polynomial,
        tuple(where), tuple(w), symbol,
    )  # fmt: skip


def _numbers(listed: Sequence[NumberLike], name: str) -> list[Expr]:
    if isinstance(listed, str):
        raise InputError(f"the {name} {shown(listed)} are to be given in a list")
    found = [sympy.expand(number) for number in read_coefficients(listed)]
    for number in found:
        # with symbols the real part alone would be multiplied out, whatever the degree
        if number.free_symbols or not all(part.is_Rational for part in number.as_real_imag()):
            raise InputError(
                f"the {name} must be rational or complex rational, and {quoted(number)} is not"
            )
    return found


def _pencil(A: ImmutableMatrix, B: ImmutableMatrix) -> Poly:
    """Return det(g I - A^-1 B), with real coefficients because A and B are Hermitian."""
    a, b = DomainMatrix.from_Matrix(A).unify(DomainMatrix.from_Matrix(B), fmt="dense")
    field = a.domain.get_field()
    product = a.convert_to(field).inv() * b.convert_to(field)
    coefficients = [sympy.expand(field.to_sympy(c)) for c in product.charpoly()]
    return Poly(coefficients, LEVEL, domain=QQ)


# The functions that solve a Nevanlinna-Pick problem, by one linear fractional map.

IDENTITY = "f(s_i) = w_i"
Entries = tuple[tuple[Poly, Poly], tuple[Poly, Poly]]


def solve_pick(
    points: Sequence[Expr],
    values: Sequence[Expr],
    variable: Symbol,
    parameter: TransferFunction,
    *,
    discrete: bool,
) -> TransferFunction:
    r"""Return the interpolating function of norm at most 1 that belongs to a parameter.

    .. math:: f = \frac{\Theta_{11} g + \Theta_{12}}{\Theta_{21} g + \Theta_{22}}, \qquad
              \Theta = I - \sum_{j,k} \begin{bmatrix} 1 \\ \bar w_j \end{bmatrix}
              \frac{(P^{-1})_{jk}}{s + \bar s_j} \begin{bmatrix} 1 & -w_k \end{bmatrix}, \quad
              P_{ij} = \frac{1 - w_i \bar w_j}{s_i + \bar s_j}

    In discrete time s stands for (z - 1)/(z + 1). Where P is singular, of rank r, its first r
    points make Theta, and one more point the number g of modulus 1: f is a Blaschke product.

    Parameters
    ----------
    points, values : sequence of sympy.Expr
        Closed under conjugation, in Q(j), with a positive semidefinite P.
    variable : Symbol
        Of f.
    parameter : TransferFunction
        g, of norm at most 1; not used where P is singular.
    discrete : bool
        Whether the variable is z or q.
    """
    where, w = _complex_rational(points), _complex_rational(values)
    if discrete:
        where = [(p - 1) / (p + 1) for p in where]
    P = _pick_matrix(where, w)
    size = P.rank()
    theta = _theta(where[:size], w[:size], P.extract(range(size), range(size)), variable)
    if size == len(points):
        top, bottom = parameter.numerator, parameter.denominator
        if discrete:
            theta = _in_discrete_time(theta, size)
        sides = [row[0] * top + row[1] * bottom for row in theta]
    else:
        number = _unimodular(theta, where[size], w[size])
        sides = [row[0] * number + row[1] for row in theta]
        if discrete:
            sides = [_mapped(side, size) for side in sides]
    f = _in_lowest_terms(*(side.set_domain(QQ_I) for side in sides))
    bounded = decide_bounded_real(f)
    if not bounded.holds:
        raise NoSolutionError(f"f = {f} is {bounded}; it is wrong, please report it")
    return TransferFunction(f.numerator, f.denominator, certificate=values_at(f, points, values))


def values_at(f: TransferFunction, points: Sequence[Expr], values: Sequence[Expr]) -> Certificate:
    """Return the certificate that a function takes given values, evaluated anew."""
    pairs = zip(_complex_rational(points), _complex_rational(values), strict=True)
    evaluated = [(_at(f.numerator, p), _at(f.denominator, p), w) for p, w in pairs]
    if not all(bottom for _, bottom, _ in evaluated):
        raise NoSolutionError(f"{f} has a pole at a point; it is wrong, please report it")
    left = [QQ_I.to_sympy(top - w * bottom) for top, bottom, w in evaluated]
    return certificate_of(IDENTITY, [left], "interpolating function")


def require_closed(points: Sequence[Expr], values: Sequence[Expr]) -> None:
    """Refuse data that no real function takes."""
    known = dict(zip(points, values, strict=True))
    for point, value in known.items():
        partner = sympy.conjugate(point)
        if known.get(partner) != sympy.conjugate(value):
            raise InputError(
                f"f({point}) = {value}, and a real function then has f({partner}) = "
                f"{sympy.conjugate(value)}; give complex points together with their conjugates"
            )


def _complex_rational(numbers: Sequence[Expr]) -> list[GaussianRational]:
    return [QQ_I.from_sympy(sympy.sympify(number)) for number in numbers]


def _conjugate(number: GaussianRational) -> GaussianRational:
    return QQ_I(number.x, -number.y)


def _pick_matrix(
    points: Sequence[GaussianRational], values: Sequence[GaussianRational]
) -> DomainMatrix:
    pairs = list(zip(points, values, strict=True))
    rows = [[(1 - w * _conjugate(v)) / (p + _conjugate(q)) for q, v in pairs] for p, w in pairs]
    return DomainMatrix(rows, (len(pairs), len(pairs)), QQ_I)


def _theta(
    points: Sequence[GaussianRational],
    values: Sequence[GaussianRational],
    P: DomainMatrix,
    s: Symbol,
) -> Entries:
    """Return the four numerators of Theta over the product of s + conj(s_j)."""
    factors = [_poly([QQ_I(1), _conjugate(p)], s) for p in points]
    D = reduce(mul, factors, _poly([QQ_I(1)], s))
    zero = _poly([], s)
    (a, b), (c, d) = [[zero, zero], [zero, zero]]
    right = DomainMatrix([[QQ_I(1), -w] for w in values], (len(values), 2), QQ_I)
    rows = P.lu_solve(right).to_list() if values else []
    for factor, w, (x, y) in zip(factors, values, rows, strict=True):
        rest, v = D.exquo(factor), _conjugate(w)
        a, b = a - rest * _poly([x], s), b - rest * _poly([y], s)
        c, d = c - rest * _poly([v * x], s), d - rest * _poly([v * y], s)
    return (D + a, b), (c, D + d)


def _unimodular(theta: Entries, point: GaussianRational, value: GaussianRational) -> Poly:
    """Return the constant g for which one more value is taken."""
    on_g, free = (
        _at(upper, point) - value * _at(lower, point) for upper, lower in zip(*theta, strict=True)
    )
    return _poly([-free / on_g], theta[0][0].gen)


def _in_discrete_time(theta: Entries, degree: int) -> Entries:
    (a, b), (c, d) = theta
    return (_mapped(a, degree), _mapped(b, degree)), (_mapped(c, degree), _mapped(d, degree))


def _mapped(poly: Poly, degree: int) -> Poly:
    """Return (z + 1)^n p((z - 1)/(z + 1))."""
    z, found = poly.gen, _poly([], poly.gen)
    up, down = (_poly([QQ_I(1), QQ_I(c)], z) for c in (-1, 1))
    for (k,), c in poly.terms():
        found = found + up**k * down ** (degree - k) * _poly([QQ_I.from_sympy(c)], z)
    return found


def _poly(descending: Sequence[GaussianRational], variable: Symbol) -> Poly:
    return Poly.from_list(list(descending), gens=variable, domain=QQ_I)


def _in_lowest_terms(N: Poly, D: Poly) -> TransferFunction:
    """Return the real function N/D; sides that are not real share what makes them so."""
    if any(number.y for number in _complex_rational(D.quo_ground(D.LC()).all_coeffs())):
        common = N.gcd(D)
        N, D = N.exquo(common), D.exquo(common)
    top, bottom = (to_flint_polynomial(_real(side.quo_ground(D.LC()))) for side in (N, D))
    shared = top.gcd(bottom)
    return TransferFunction(*(from_flint_polynomial(p // shared, D.gen) for p in (top, bottom)))


def _real(poly: Poly) -> Poly:
    numbers = _complex_rational(poly.all_coeffs())
    if any(number.y for number in numbers):
        raise NoSolutionError(f"{poly.as_expr()} is not real; it is wrong, please report it")
    return Poly.from_list([number.x for number in numbers], gens=poly.gen, domain=QQ)


def _at(poly: Poly, point: GaussianRational) -> GaussianRational:
    """The value at a point, by Horner's rule."""
    value = QQ_I(0)
    for c in _complex_rational(poly.all_coeffs()):
        value = value * point + c
    return value
