"""Irrational numbers, exactly: a minimal polynomial and a ball that holds one root of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

import flint
import sympy
from sympy import Expr, Poly, Rational, Symbol
from sympy.polys.polyerrors import CoercionFailed, NotInvertible, PolynomialError

from compensator_theory.errors import InputError
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._budget import ask, limit_of
from compensator_theory.polynomials._sympy_trees import irrational_parts, square_root

_X = Symbol("x")
_PART_DIGITS = 60  # the time grows with the cube of them: 0.2 s at 30, 1.8 s at 100


@dataclass(frozen=True)
class Algebraic:
    """A root of an irreducible integer polynomial.

    Attributes
    ----------
    minimal : flint.fmpz_poly
        Primitive and irreducible, with a positive leading coefficient.
    ball : flint.acb
        Holds this root and no other.
    """

    minimal: flint.fmpz_poly
    ball: flint.acb

    def refined(self, precision: int) -> flint.acb:
        """Return a smaller ball around the same root."""
        with ball_precision(precision):
            (root,) = (r for r, _ in self.minimal.complex_roots() if r.overlaps(self.ball))
            return root

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Algebraic)
            and self.minimal == other.minimal
            and bool(self.ball.overlaps(other.refined(128)))
        )

    def __hash__(self) -> int:
        return hash(tuple(map(int, self.minimal.coeffs())))

    @property
    def is_real(self) -> bool:
        """Whether it is real; decided by the certificate."""
        return bool(self.refined(128).imag == 0)

    @property
    def is_above_the_axis(self) -> bool:
        """Whether the imaginary part is positive."""
        return bool(self.refined(128).imag > 0)

    @property
    def conjugate(self) -> Algebraic:
        """The complex conjugate, a root of the same polynomial."""
        ball = self.refined(128)
        with ball_precision(1024):  # a sign is rounded, too, and the ball held two roots then
            return Algebraic(self.minimal, flint.acb(ball.real, -ball.imag))

    def __add__(self, other: Algebraic) -> Algebraic:
        x, y = _PLANE.gens()
        image = _composed(other.minimal, lambda c, k, _: c * (x - y) ** k)
        return _of(_eliminated(self.minimal, image), lambda p: self.refined(p) + other.refined(p))

    def __mul__(self, other: Algebraic) -> Algebraic:
        if 0 in (self.minimal(0), other.minimal(0)):
            return rational_number(Rational(0))
        x, y = _PLANE.gens()
        image = _composed(other.minimal, lambda c, k, n: c * x**k * y ** (n - k))
        return _of(_eliminated(self.minimal, image), lambda p: self.refined(p) * other.refined(p))

    def inverse(self) -> Algebraic:
        """Return the reciprocal; InputError for zero."""
        if self.minimal(0) == 0:
            raise InputError("the expression divides by zero")
        reversed_ = flint.fmpz_poly(self.minimal.coeffs()[::-1])
        return _of(reversed_, lambda p: 1 / self.refined(p))

    def power(self, exponent: Rational) -> Algebraic:
        """Return the principal value of a rational power."""
        size, index = abs(int(exponent.p)), int(exponent.q)
        root = self if index == 1 else self._principal_root(index)
        base = root.inverse() if exponent < 0 else root
        return reduce(lambda a, b: a * b, [base] * size, rational_number(Rational(1)))

    def _principal_root(self, index: int) -> Algebraic:
        ask("field_degree", int(self.minimal.degree()) * index, "an irrational number")
        gaps = [0] * (index - 1)
        spread = [entry for c in self.minimal.coeffs() for entry in (c, *gaps)]
        is_real = self.is_real  # a ball must not fall to both sides of the branch cut
        return _of(
            flint.fmpz_poly(spread[: len(spread) - len(gaps)]),
            lambda p: _principal_root(self.refined(p), index, is_real),
        )

    @ball_precision(256)
    def expression(self) -> Expr:
        """Return a real one in SymPy: a rational number, a surd a + b sqrt(c), or a CRootOf."""
        c = [sympy.Integer(int(k)) for k in reversed(self.minimal.coeffs())]
        if len(c) == 2:
            return -c[1] / c[0]
        if len(c) == 3:
            upper = bool(self.refined(256).real > flint.arb(flint.fmpq(int(-c[1]), int(2 * c[0]))))
            root = square_root(c[1] ** 2 - 4 * c[0] * c[2]) * (1 if upper else -1)
            return sympy.expand((-c[1] + root) / (2 * c[0]))
        if not any(c[1:-1]):  # SymPy takes seconds for the value of an indexed root of these
            root = abs(c[-1] / c[0]) ** Rational(1, len(c) - 1)
            return root if self.refined(256).real > 0 else -root
        if len(c) == 5 and c[1] == c[3] == 0:  # a root of a surd
            sign = 1 if self.refined(256).real > 0 else -1
            return sign * square_root((self * self).expression())
        balls = [r for r, _ in self.minimal.complex_roots() if r.imag == 0]
        below = sum(bool(r.real < self.refined(256).real) for r in balls)
        return sympy.CRootOf(Poly(c, _X), below)


def algebraic(number: Expr) -> Algebraic | None:
    """Return an irrational constant exactly, or None if it is transcendental or unknown."""
    if number.is_Rational:
        return rational_number(number)
    for part in number.atoms(Rational):
        if max(abs(int(part.p)), int(part.q)).bit_length() > 3.33 * _PART_DIGITS:
            raise InputError(
                f"an irrational number has rational parts with more than {_PART_DIGITS} digits, "
                "so that its minimal polynomial takes long; give a rational number close to it"
            )
    if number == sympy.I:
        return Algebraic(flint.fmpz_poly([1, 0, 1]), flint.acb(0, 1))
    if isinstance(number, sympy.Add | sympy.Mul):
        parts = [algebraic(part) for part in number.args]
        known = [part for part in parts if part is not None]
        if len(known) < len(parts):
            return None
        join: Callable[[Algebraic, Algebraic], Algebraic] = (
            Algebraic.__add__ if isinstance(number, sympy.Add) else Algebraic.__mul__
        )
        return reduce(join, known)
    if isinstance(number, sympy.Pow) and number.exp.is_Rational:
        ask("degree", abs(int(number.exp.p)), "the exponent of an irrational number")
        base = algebraic(number.base)
        return None if base is None else base.power(number.exp)
    if isinstance(number, sympy.polys.rootoftools.ComplexRootOf):
        return _of_indexed_root(number)
    if isinstance(number, sympy.exp | sympy.cos | sympy.sin):
        turn = number.args[0] / (sympy.I * sympy.pi if isinstance(number, sympy.exp) else sympy.pi)
        if turn.is_Rational:
            return _of_turn(number, turn)
    return None


def rationalised(number: Expr) -> Expr:
    """Return a constant without its one root below the line; with several roots as it is."""
    top, bottom = number.as_numer_denom()
    roots = irrational_parts(number)
    if not all(isinstance(root, sympy.Pow) and root.exp.is_Rational for root in roots):
        return number
    bases = {root.base for root in roots}
    if bottom.is_Rational or len(bases) != 1 or not all(base.is_Rational for base in bases):
        return number
    (base,), index, x = bases, int(sympy.ilcm(1, *(root.exp.q for root in roots))), sympy.Dummy("x")
    powers = {root: x ** (root.exp * index) for root in roots}
    minimal = Poly(x**index - base, x)
    try:
        above, below = (Poly(side.xreplace(powers), x, domain=sympy.QQ) for side in (top, bottom))
        quotient = (above * below.invert(minimal)).rem(minimal)
    except (PolynomialError, NotInvertible, CoercionFailed):  # pi, for instance
        return number
    return sympy.expand(quotient.as_expr().subs(x, base ** Rational(1, index)))


_PLANE = flint.fmpz_mpoly_ctx.get(("x", "y"), flint.Ordering.lex)


def rational_number(number: Rational) -> Algebraic:
    """Return a rational number as an element of python-flint's algebraic numbers."""
    value = flint.fmpq(int(number.p), int(number.q))
    with ball_precision(64):
        return Algebraic(flint.fmpz_poly([-value.p, value.q]), flint.acb(value))


def _composed(
    poly: flint.fmpz_poly, term: Callable[[flint.fmpz, int, int], flint.fmpz_mpoly]
) -> flint.fmpz_mpoly:
    degree = int(poly.degree())
    return sum((term(c, k, degree) for k, c in enumerate(poly.coeffs())), _PLANE.constant(0))


def _eliminated(poly: flint.fmpz_poly, image: flint.fmpz_mpoly) -> flint.fmpz_poly:
    """Return the resultant over y of p(y) and a polynomial in x and y."""
    _, y = _PLANE.gens()
    degree = int(poly.degree()) * max(map(int, image.degrees()))
    ask("field_degree", -(-degree // limit_of("field_degree")), "a sum or product of roots")
    eliminated = _composed(poly, lambda c, k, _: c * y**k).resultant(image, "y")
    terms = {int(powers[0]): c for powers, c in eliminated.to_dict().items()}
    return flint.fmpz_poly([terms.get(k, 0) for k in range(max(terms) + 1)])


def _of(poly: flint.fmpz_poly, ball: Callable[[int], flint.acb]) -> Algebraic:
    """Find the irreducible factor and the root of it in a ball of any size."""
    factors = [factor for factor, _ in poly.factor()[1]]

    def attempt(bits: int) -> Algebraic | None:
        value = ball(bits)
        left = [f for f in factors if flint.acb_poly(f)(value).contains(0)]
        if len(left) != 1:
            return None
        roots = [r for r, _ in left[0].complex_roots() if r.overlaps(value)]
        if len(roots) != 1:
            return None
        ask("field_degree", int(left[0].degree()), "an irrational number")
        sign = 1 if left[0].coeffs()[-1] > 0 else -1
        return Algebraic(left[0] * sign, roots[0])

    return at_growing_precision(attempt, 128, "an irrational number")  # the factors are coprime


def _principal_root(ball: flint.acb, index: int, is_real: bool) -> flint.acb:
    if is_real and ball.real < 0:
        turn = flint.acb(flint.fmpq(1, index)).exp_pi_i()
        return flint.acb((-ball.real).root(index)) * turn
    if is_real:
        return flint.acb(ball.real.root(index))
    return ball ** flint.acb(flint.fmpq(1, index))


def _of_indexed_root(number: Expr) -> Algebraic:
    _, integers = number.poly.clear_denoms(convert=True)
    poly = flint.fmpz_poly([int(c) for c in reversed(integers.all_coeffs())])

    def ball(precision: int) -> flint.acb:
        digits = precision // 16  # few to begin with: SymPy is slow at this
        near = Rational(1, 10**digits)
        centre = number.eval_rational(near, near)
        real, imaginary = (flint.fmpq(int(c.p), int(c.q)) for c in centre.as_real_imag())
        error = flint.arb(0, flint.arb(10) ** -digits)
        return flint.acb(flint.arb(real) + error, flint.arb(imaginary) + error)

    return _of(poly, ball)


def _of_turn(number: Expr, turn: Rational) -> Algebraic:
    """Return exp(j pi r), cos(pi r) or sin(pi r)."""
    order = int(turn.q) * 2
    ask("field_degree", order // 2, f"the number {number}")
    circle = flint.fmpz_poly([-1, *[0] * (order - 1), 1])
    unit = _of(circle, lambda p: flint.acb(flint.fmpq(int(turn.p), int(turn.q))).exp_pi_i())
    if isinstance(number, sympy.exp):
        return unit
    if isinstance(number, sympy.cos):
        return (unit + unit.conjugate) * rational_number(Rational(1, 2))
    minus_half_j = algebraic(-sympy.I / 2)
    assert minus_half_j is not None
    return (unit + unit.conjugate * rational_number(Rational(-1))) * minus_half_j
