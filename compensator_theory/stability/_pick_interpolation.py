"""Nevanlinna-Pick interpolation: stable functions with given values and H-infinity bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import factorial
from operator import mul
from typing import Any, TypeAlias, cast

import sympy
from sympy import QQ, QQ_I, Expr, ImmutableMatrix, Poly, Symbol
from sympy.polys.domains.gaussiandomains import GaussianRational
from sympy.polys.matrices import DomainMatrix

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.polynomials._budget import ask, listed, quoted, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._numbers import NumberLike, exact_number, read_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_discrete
from compensator_theory.roots._enclosures import Enclosure
from compensator_theory.stability._critical_values import real_roots
from compensator_theory.stability._passivity import decide_bounded_real
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._transfer_functions import TransferFunction

LEVEL = Symbol("g")
Data: TypeAlias = "Sequence[tuple[GaussianRational, Sequence[GaussianRational]]]"
"""Points, each with the first coefficients of the function's Taylor series there."""


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
    points : tuple of sympy.Expr
    values : tuple of tuple of sympy.Expr
        For each point the value, and the derivatives that were given.
    variable : Symbol
        s, z or q.
    """

    _ANSWER = "is_feasible"

    matrix: ImmutableMatrix
    bound: Expr
    is_feasible: bool
    is_unique: bool
    least_squared: Expr
    enclosure: Enclosure
    polynomial: Poly
    points: tuple[Expr, ...]
    values: tuple[tuple[Expr, ...], ...]
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
        >>> from compensator_theory import h_infinity_norm
        >>> from compensator_theory.interpolation import nevanlinna_pick
        >>> pick = nevanlinna_pick([1, 2], ["1/2", "1/3"])
        >>> f = pick.interpolant()
        >>> print(f, h_infinity_norm(f).value)
        (3*s/4 + 15/4)/(s**2 + 15*s/4 + 17/4) 15/17
        >>> print(pick.interpolant("1"))  # lossless: the bound is reached at every frequency
        (s**2 - 3*s + 8)/(s**2 + 3*s + 8)
        >>> print(nevanlinna_pick([2, 3], ["1/3", "1/2"]).interpolant())  # unique
        (s - 1)/(s + 1)
        """
        if not self.is_feasible:
            raise NoSolutionError(f"{self}: no function takes the values within the bound")
        data = _taylor(self.points, self.values)
        _require_closed(data)
        s, discrete = self.variable, is_discrete(self.variable, "interpolation")
        if self.is_unique and parameter is not None:
            raise InputError("the interpolating function is unique; leave the parameter out")
        g = transfer_function(0 if parameter is None else parameter, s)
        if not decide_bounded_real(g, s).holds:
            raise InputError(f"the parameter {g} is not stable with a norm of at most 1")
        if self.bound == 0:
            return transfer_function((0, 1), variable=s)
        level = QQ_I.from_sympy(self.bound)
        scaled = [(point, [w / level for w in series]) for point, series in data]
        f = solve_pick(scaled, s, g, discrete=discrete)
        whole = TransferFunction(f.numerator * self.bound, f.denominator)
        return replace(whole, certificate=_interpolation_certificate(whole, data))

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


@refusing
def nevanlinna_pick(
    points: Sequence[NumberLike],
    values: Sequence[NumberLike | Sequence[NumberLike]],
    bound: NumberLike = 1,
    *,
    variable: str | Symbol = "s",
) -> PickInterpolation:
    r"""Decide whether a stable function with H-infinity norm at most gamma takes given values.

    .. math:: f(s_i) = w_i, \quad \|f\|_\infty \le \gamma \qquad\Longleftrightarrow\qquad \left[
              \frac{\gamma^2 - \bar w_i w_j}{\bar s_i + s_j} \right]_{i,j} \ge 0

    In discrete time the denominators are :math:`1 - 1/(\bar z_i z_j)`. Where derivatives are given,
    the rows and columns of their point are the Taylor coefficients of this quotient there.

    Parameters
    ----------
    points : sequence of numbers
        Different, right of the imaginary axis (s) or outside of the unit circle (z, q), where f is
        analytic: rational, or complex with rational parts. For a real function give complex points
        together with their conjugates.
    values : sequence of numbers, or of sequences of numbers
        One for each point: :math:`w_i`, or :math:`[w_i, w_i', w_i'', \ldots]` with derivatives, as
        a double zero of the plant or a tangency requires.
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
    No sensitivity of a plant with these zeros and values has a smaller norm. Source:
    G. Pick (1916), R. Nevanlinna (1919); J. C. Doyle, B. A. Francis, A. R. Tannenbaum, Feedback
    Control Theory (1992), Chapter 9; with derivatives: Ball, Gohberg, Rodman (1990), Chapter 18.

    Examples
    --------
    >>> from compensator_theory.interpolation import nevanlinna_pick
    >>> print(nevanlinna_pick([1, 2], [1, -1], 5))
    not feasible with bound 5; the least bound is 2*sqrt(2) + 3
    >>> nevanlinna_pick([1, 2], ["1/2", "1/3"]).is_feasible
    True
    >>> print(nevanlinna_pick([1], [["1/2", 0]]).interpolant())  # f(1) = 1/2, f'(1) = 0
    (8*s/3)/(s**2 + 10*s/3 + 1)
    """
    symbol = as_symbol(variable)
    discrete = is_discrete(symbol, "interpolation")
    where = _numbers(points, "points")
    if isinstance(values, str) or getattr(values, "shape", None) == ():
        raise InputError(f"the values {repr_of(values)} must be a list")
    value_list = listed(values, "degree", "the list of values", more=1)
    if len(value_list) != len(where):
        raise InputError(
            f"there are {len(where)} points and {len(value_list)} values; give as many"
        )
    chains = [list(cast("Sequence[Any]", v)) if _is_list(v) else [v] for v in value_list]
    if not all(chains):
        raise InputError("a point has an empty list of values; give its value at least")
    w = [_numbers(chain, "values") for chain in chains]
    gamma = sympy.sympify(exact_number(bound))
    if not gamma.is_Rational or gamma < 0:
        raise InputError(f"the bound {gamma} must be a rational number, at least 0")
    if len(set(where)) < len(where):
        raise InputError(
            "a point is listed twice; give its value and derivatives in one list, as in "
            "nevanlinna_pick([1], [[w, dw]])"
        )
    n = sum(map(len, w))
    ask("entries", n**4 // 20, "the polynomial of Pick's matrix")  # n coefficients of n^2 digits
    for point in where:
        size = sympy.expand(point * sympy.conjugate(point)) - 1 if discrete else sympy.re(point)
        if size <= 0:
            region = "outside of the unit circle" if discrete else "right of the imaginary axis"
            raise InputError(f"the point {point} does not lie {region}")
    data = [
        (_conjugate(point), [_conjugate(c) for c in series]) for point, series in _taylor(where, w)
    ]
    A, B = (ImmutableMatrix(part.to_Matrix()) for part in _pick_matrices(data, discrete=discrete))
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
        tuple(where), tuple(map(tuple, w)), symbol,
    )  # fmt: skip


def _numbers(numbers: Sequence[NumberLike], name: str) -> list[Expr]:
    if isinstance(numbers, str):
        raise InputError(f"the {name} {repr_of(numbers)} must be a list")
    expanded = [sympy.expand(number) for number in read_coefficients(numbers)]
    for number in expanded:
        # with symbols the real part alone would be multiplied out, whatever the degree
        if number.free_symbols or not all(part.is_Rational for part in number.as_real_imag()):
            raise InputError(
                f"the {name} must be rational or complex rational, and {quoted(number)} is not"
            )
    return expanded


def _pencil(A: ImmutableMatrix, B: ImmutableMatrix) -> Poly:
    """Return det(g I - A^-1 B), with real coefficients because A and B are Hermitian."""
    a, b = DomainMatrix.from_Matrix(A).unify(DomainMatrix.from_Matrix(B), fmt="dense")
    field = a.domain.get_field()
    product = a.convert_to(field).inv() * b.convert_to(field)
    coefficients = [sympy.expand(field.to_sympy(c)) for c in product.charpoly()]
    return Poly(coefficients, LEVEL, domain=QQ)


# The functions that solve a Nevanlinna-Pick problem, by one linear fractional map.

IDENTITY = "f(s_i) = w_i"
IDENTITY_WITH_DERIVATIVES = "f(s_i) = w_i, with the derivatives given"
Entries = tuple[tuple[Poly, Poly], tuple[Poly, Poly]]


def solve_pick(
    data: Data, variable: Symbol, parameter: TransferFunction, *, discrete: bool
) -> TransferFunction:
    r"""Return the interpolating function of norm at most 1 that belongs to a parameter.

    .. math:: f = \frac{\Theta_{11} g + \Theta_{12}}{\Theta_{21} g + \Theta_{22}}, \qquad
              \Theta = I - \begin{bmatrix} e & w \end{bmatrix}^* (s I + \Lambda^*)^{-1} P^{-1}
              \begin{bmatrix} e & -w \end{bmatrix}, \quad
              \Lambda P + P \Lambda^* = e e^* - w w^*

    with the points on the diagonal of Lambda, and for derivatives in Jordan blocks of its: e is the
    Taylor series of 1 and w that of f, at each point. In discrete time s stands for
    (z - 1)/(z + 1). Where P is singular, of rank r, the first r data make Theta, and the next one
    the number g of modulus 1: f is a Blaschke product.
    """
    inner = [_in_continuous_time(*datum) for datum in data] if discrete else data
    size, P = _leading_pick_matrix(inner)
    theta = _theta(_first(inner, size), P, variable)
    left = _next_datum(inner, size)
    if left is None:
        top, bottom = parameter.numerator, parameter.denominator
        if discrete:
            theta = _in_discrete_time(theta, size)
        sides = [row[0] * top + row[1] * bottom for row in theta]
    else:
        number = _unimodular(theta, *left)
        sides = [row[0] * number + row[1] for row in theta]
        if discrete:
            sides = [_mapped(side, size) for side in sides]
    f = _in_lowest_terms(*(side.set_domain(QQ_I) for side in sides))
    bounded = decide_bounded_real(f)
    if not bounded.holds:
        raise NoSolutionError(f"f = {f} is {bounded}; it is wrong, please report it")
    return TransferFunction(
        f.numerator, f.denominator, certificate=_interpolation_certificate(f, data)
    )


def _interpolation_certificate(f: TransferFunction, data: Data) -> Certificate:
    """Return the certificate that a function interpolates the data, recomputed."""
    left, identity = [], IDENTITY
    for point, series in data:
        top, bottom = (_series_at(p, point, len(series)) for p in (f.numerator, f.denominator))
        if not bottom[0]:
            raise NoSolutionError(f"{f} has a pole at a point; it is wrong, please report it")
        expected = _multiplied(series, bottom)
        left += [QQ_I.to_sympy(a - b) for a, b in zip(top, expected, strict=True)]
        identity = IDENTITY_WITH_DERIVATIVES if len(series) > 1 else identity
    return certificate_of(identity, [left], "interpolating function")


def _require_closed(data: Data) -> None:
    """Refuse data that no real function interpolates."""
    known = {point: list(series) for point, series in data}
    for point, series in known.items():
        partner = known.get(_conjugate(point), [])
        for k, c in enumerate(series):
            if partner[k : k + 1] != [_conjugate(c)]:
                name = "f" + "'" * k if k < 4 else f"f^({k})"
                number, there = (QQ_I.to_sympy(p) for p in (point, _conjugate(point)))
                value, mirrored = (QQ_I.to_sympy(v * factorial(k)) for v in (c, _conjugate(c)))
                raise InputError(
                    f"{name}({number}) = {value}, and a real function then has {name}({there}) = "
                    f"{mirrored}; give complex points together with their conjugates"
                )


def _taylor(
    points: Sequence[Expr], values: Sequence[Sequence[Expr]]
) -> list[tuple[GaussianRational, list[GaussianRational]]]:
    """Derivatives to Taylor coefficients, f^(k) / k!."""
    return [
        (
            QQ_I.from_sympy(sympy.sympify(point)),
            [QQ_I.from_sympy(sympy.sympify(w)) / factorial(k) for k, w in enumerate(chain)],
        )
        for point, chain in zip(points, values, strict=True)
    ]


def _is_list(value: object) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _multiplied(
    a: Sequence[GaussianRational], b: Sequence[GaussianRational]
) -> list[GaussianRational]:
    """The product of two power series, as long as the shorter."""
    sums = (
        sum((a[i] * b[k - i] for i in range(k + 1)), QQ_I(0)) for k in range(min(len(a), len(b)))
    )
    return list(sums)


def _in_continuous_time(
    point: GaussianRational, series: Sequence[GaussianRational]
) -> tuple[GaussianRational, list[GaussianRational]]:
    """The data of f((1 + s)/(1 - s)) at (z - 1)/(z + 1)."""
    place = (point - 1) / (point + 1)
    rest = 1 - place
    step = [QQ_I(0)] + [2 / rest ** (k + 1) for k in range(1, len(series))]  # of z, in powers of s
    mapped = [QQ_I(0)] * len(series)
    for c in reversed(series):  # Horner's rule
        mapped = _multiplied(mapped, step)
        mapped[0] += c
    return place, mapped


def _conjugate(number: GaussianRational) -> GaussianRational:
    return QQ_I(number.x, -number.y)


def _pick_matrices(data: Data, *, discrete: bool) -> tuple[DomainMatrix, DomainMatrix]:
    r"""Return the Taylor coefficients of :math:`k(x, \bar y)` and of it times f(x) conj f(y)."""
    kernel, product = [], []
    for x, v in data:
        rows, products = [[] for _ in v], [[] for _ in v]  # type: ignore[var-annotated]
        for p, w in data:
            y = _conjugate(p)
            block = _kernel(x, y, len(v), len(w), discrete=discrete)
            right = [_multiplied(row, [_conjugate(c) for c in w]) for row in block]
            columns = [_multiplied(column, v) for column in zip(*right, strict=True)]
            for k in range(len(v)):
                rows[k] += block[k]
                products[k] += [column[k] for column in columns]
        kernel += rows
        product += products
    n = len(kernel)
    return DomainMatrix(kernel, (n, n), QQ_I), DomainMatrix(product, (n, n), QQ_I)


def _kernel(
    x: GaussianRational, y: GaussianRational, rows: int, columns: int, *, discrete: bool
) -> list[list[GaussianRational]]:
    """The series of 1/(x + y), in discrete time of 1/(1 - 1/(xy)) = 1 + 1/(xy - 1), at a point."""
    bottom, by_row, by_column, both = (
        (x * y - 1, y, x, QQ_I(1)) if discrete else (x + y, QQ_I(1), QQ_I(1), QQ_I(0))
    )
    table = [[QQ_I(0)] * (columns + 1) for _ in range(rows + 1)]  # one of zeros at either edge
    for k in range(rows):
        for j in range(columns):
            rest = by_row * table[k - 1][j] + by_column * table[k][j - 1]
            rest += both * table[k - 1][j - 1]
            table[k][j] = (QQ_I(int(k == j == 0)) - rest) / bottom
    if discrete:
        table[0][0] += 1
    return [row[:columns] for row in table[:rows]]


def _leading_pick_matrix(data: Data) -> tuple[int, DomainMatrix]:
    """Return the rank r of Pick's matrix and its first r rows and columns."""
    kernel, product = _pick_matrices(data, discrete=False)
    P = kernel - product
    size = P.rank()
    return size, P.extract(range(size), range(size))


def _first(data: Data, size: int) -> Data:
    """The first data, as many as given."""
    coefficients = []
    for point, series in data:
        coefficients.append((point, series[: max(0, size)]))
        size -= len(series)
    return [(point, series) for point, series in coefficients if series]


def _next_datum(
    data: Data, size: int
) -> tuple[GaussianRational, Sequence[GaussianRational]] | None:
    """The point of the first datum beyond so many, with its series up to there."""
    for point, series in data:
        if size < len(series):
            return point, series[: size + 1]
        size -= len(series)
    return None


def _theta(data: Data, P: DomainMatrix, s: Symbol) -> Entries:
    """Return the four numerators of Theta over the product of s + conj(s_j)."""
    factors = [(_poly([QQ_I(1), _conjugate(p)], s), series) for p, series in data]
    D = reduce(mul, (f for f, series in factors for _ in series), _poly([QQ_I(1)], s))
    zero = _poly([], s)
    (a, b), (c, d) = [[zero, zero], [zero, zero]]
    right = [[QQ_I(int(k == 0)), -w] for _, series in data for k, w in enumerate(series)]
    rows = iter(P.lu_solve(DomainMatrix(right, (len(right), 2), QQ_I)).to_list() if right else [])
    for factor, series in factors:
        for k in range(len(series)):
            x, y = next(rows)
            rest, sign = D, QQ_I(1)
            for back in range(k + 1):  # (sI + Lambda*)^-1 has (-1)^back/(s + conj p)^(back + 1)
                rest = rest.exquo(factor)
                v = sign * _conjugate(series[k - back])
                if back == k:
                    a, b = a - rest * _poly([sign * x], s), b - rest * _poly([sign * y], s)
                c, d = c - rest * _poly([v * x], s), d - rest * _poly([v * y], s)
                sign = -sign
    return (D + a, b), (c, D + d)


def _unimodular(
    theta: Entries, point: GaussianRational, series: Sequence[GaussianRational]
) -> Poly:
    """Return the constant g for which one more datum, the last of a series, is met."""
    n = len(series)
    on_g, free = (
        _series_at(upper, point, n)[-1] - _multiplied(series, _series_at(lower, point, n))[-1]
        for upper, lower in zip(*theta, strict=True)
    )
    return _poly([-free / on_g], theta[0][0].gen)


def _complex_rational(numbers: Sequence[Expr]) -> list[GaussianRational]:
    return [QQ_I.from_sympy(sympy.sympify(number)) for number in numbers]


def _in_discrete_time(theta: Entries, degree: int) -> Entries:
    (a, b), (c, d) = theta
    return (_mapped(a, degree), _mapped(b, degree)), (_mapped(c, degree), _mapped(d, degree))


def _mapped(poly: Poly, degree: int) -> Poly:
    """Return (z + 1)^n p((z - 1)/(z + 1))."""
    z, mapped = poly.gen, _poly([], poly.gen)
    up, down = (_poly([QQ_I(1), QQ_I(c)], z) for c in (-1, 1))
    for (k,), c in poly.terms():
        mapped = mapped + up**k * down ** (degree - k) * _poly([QQ_I.from_sympy(c)], z)
    return mapped


def _poly(descending: Sequence[GaussianRational], variable: Symbol) -> Poly:
    return Poly.from_list(list(descending), gens=variable, domain=QQ_I)


def _in_lowest_terms(N: Poly, D: Poly) -> TransferFunction:
    """Return the real function N/D without the common complex factor of both sides."""
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


def _series_at(poly: Poly, point: GaussianRational, terms: int) -> list[GaussianRational]:
    """The first Taylor coefficients at a point, by Horner's rule."""
    series_at_point = [QQ_I(0)] * terms
    for c in _complex_rational(poly.all_coeffs()):
        series_at_point = [point * series_at_point[0] + c] + [
            point * series_at_point[k] + series_at_point[k - 1] for k in range(1, terms)
        ]
    return series_at_point
