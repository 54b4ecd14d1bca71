"""The functions that solve a Nevanlinna-Pick problem, by one linear fractional map."""

from collections.abc import Sequence
from functools import reduce
from operator import mul

import sympy
from sympy import QQ, QQ_I, Expr, Poly, Symbol
from sympy.polys.domains.gaussiandomains import GaussianRational
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.frequency.passivity import decide_bounded_real
from compensator_theory.matrices.certificates import Certificate, certificate_of
from compensator_theory.matrices.flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.transfer_functions.transfer_functions import TransferFunction

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

    Raises
    ------
    NoSolutionError
        If f misses a value or the bound: then the computation before was wrong.

    Examples
    --------
    >>> from sympy import Rational
    >>> from sympy.abc import s
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.interpolation.pick_interpolants import solve_pick
    >>> g = transfer_function(("0", "1"), variable="s")
    >>> print(solve_pick([Rational(1)], [Rational(1, 2)], s, g, discrete=False))
    (4/3)/(s + 5/3)
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
    """Return the certificate that a function takes given values, evaluated anew.

    Raises
    ------
    NoSolutionError
        If it does not.

    Examples
    --------
    >>> from sympy import I
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.interpolation.pick_interpolants import values_at
    >>> values_at(transfer_function("1/s"), [1, I], [1, -I]).holds
    True
    """
    pairs = zip(_complex_rational(points), _complex_rational(values), strict=True)
    evaluated = [(_at(f.numerator, p), _at(f.denominator, p), w) for p, w in pairs]
    if not all(bottom for _, bottom, _ in evaluated):
        raise NoSolutionError(f"{f} has a pole at a point; it is wrong, please report it")
    left = [QQ_I.to_sympy(top - w * bottom) for top, bottom, w in evaluated]
    return certificate_of(IDENTITY, [left], "interpolating function")


def require_closed(points: Sequence[Expr], values: Sequence[Expr]) -> None:
    """Refuse data that no real function takes.

    Raises
    ------
    InputError
        If the conjugate of a point is missing, or its value is not the conjugate.

    Examples
    --------
    >>> from sympy import I
    >>> from compensator_theory.interpolation.pick_interpolants import require_closed
    >>> require_closed([1 + I, 1 - I], [2 * I, -2 * I])
    """
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
