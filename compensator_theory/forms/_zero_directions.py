"""Zeros and their blocking directions, from Smith forms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import sympy
from sympy import Expr, ImmutableMatrix, Poly

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory._printing import text
from compensator_theory.forms._equivalence import Equivalence
from compensator_theory.forms._polynomial_matrices import PolynomialMatrix
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import Root, certified_roots

IDENTITY = "the matrix at each zero times its directions"


@dataclass(frozen=True)
class ZeroDirection(ExactValue):
    """The zero directions at every root of one irreducible factor.

    Attributes
    ----------
    factor : sympy.Poly
        Monic and irreducible; the zeros are its roots.
    state, input : sympy.ImmutableMatrix
        Columns: the motion x e^(zt) under the input u e^(zt) that does not show in the output. For
        a factor of higher degree their entries are polynomials in the variable, to be taken at a
        root. Empty where the kind of zero has none.
    costate, output : sympy.ImmutableMatrix
        Columns: the same of the transposed system, the combination of outputs in which no input
        with that exponent shows.
    """

    factor: Poly
    state: ImmutableMatrix
    input: ImmutableMatrix
    costate: ImmutableMatrix
    output: ImmutableMatrix

    def __str__(self) -> str:
        names = ("state", "input", "costate", "output")
        vectors = [(name, list(getattr(self, name))) for name in names]
        listed_vectors = ", ".join(f"{name} {text(vector)}" for name, vector in vectors if vector)
        return f"{format_polynomial(self.factor)} = 0: {listed_vectors}"

    def _repr_latex_(self) -> str:
        names = {"x": self.state, "u": self.input, "w": self.costate, "y'": self.output}
        vectors = [f"{name} = {latex(vector)}" for name, vector in names.items() if vector.rows]
        return displayed(f"{latex(self.factor)} = 0", *vectors)


@dataclass(frozen=True)
class Zeros(ExactValue):
    """The zeros of one kind, with multiplicity and directions.

    Attributes
    ----------
    invariant_polynomials : tuple of sympy.Poly
        Of the matrix whose rank falls at the zeros, those of degree 0 left out.
    polynomial : sympy.Poly
        Their product; 1 if there are no zeros.
    directions : tuple of ZeroDirection
        For each irreducible factor as many as the rank falls by.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        That the matrix annihilates each direction, modulo its factor.
    """

    _REST: ClassVar[str] = ".directions lists them"
    invariant_polynomials: tuple[Poly, ...]
    polynomial: Poly
    directions: tuple[ZeroDirection, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def roots(self) -> tuple[Root, ...]:
        """The certified zeros with multiplicity; InputError with symbols."""
        return certified_roots(self.polynomial)

    def __str__(self) -> str:
        line = f"zeros of {format_polynomial(self.polynomial)}"
        heading = line if self.polynomial.degree() else "no zeros"
        return "\n".join([heading, *map(str, self.directions)])

    def _repr_latex_(self) -> str:
        directions = [latex(direction) for direction in self.directions]
        line = f"{words('zeros of ')} {latex(self.polynomial)}"
        polynomial = line if self.polynomial.degree() else words("no zeros")
        return displayed(polynomial, *directions, unless(self.exceptional))


def zeros_of(
    right: Equivalence,
    left: Equivalence,
    right_sizes: tuple[int, int],
    left_sizes: tuple[int, int],
    right_map: PolynomialMatrix | None = None,
    left_map: PolynomialMatrix | None = None,
) -> Zeros:
    """Read the zeros off the Smith forms: U M V = S makes column k of V a direction where s_k = 0.

    The vectors are multiplied by the maps, and split into state and signal by the sizes; what
    exceeds the sizes is ignored.
    """
    s = right.matrix.variable
    invariants = tuple(p for p in right.invariant_polynomials if p.degree() > 0)
    whole = canonical(sympy.prod(invariants, start=Poly(1, s, domain=sympy.QQ)))
    directions: list[ZeroDirection] = []
    left_over: list[Expr] = []
    first = right.rank - len(invariants)
    offset = left.rank - right.rank
    for factor in (f.monic() for f, _ in whole.factor_list()[1]):
        for k, invariant in enumerate(invariants, first):
            if not _rest(invariant, factor).is_zero:
                continue
            v = _column(right.V, k)
            w = _column(left.U.T, k + offset)
            for remainder in (right.matrix @ v, left.matrix.T @ w):
                left_over += [_rest(row[0], factor).as_expr() for row in remainder.rows]
            v = v if right_map is None else right_map @ v
            w = w if left_map is None else left_map.T @ w
            state, signal = _split(v, factor, right_sizes)
            costate, output = _split(w, factor, left_sizes)
            directions.append(ZeroDirection(canonical(factor), state, signal, costate, output))
    residual = ImmutableMatrix(1, len(left_over), left_over)
    exceptional = exceptional_factors([*right.exceptional, *left.exceptional])
    certificate = Certificate(IDENTITY, residual)
    return Zeros(invariants, whole, tuple(directions), exceptional, certificate)


def _column(matrix: PolynomialMatrix, index: int) -> PolynomialMatrix:
    return PolynomialMatrix(tuple((row[index],) for row in matrix.rows))


def _rest(poly: Poly, factor: Poly) -> Poly:
    """Return a polynomial modulo a factor; its value at the root, if the factor is linear."""
    a, b = poly.unify(factor)
    field = a.domain.get_field()
    return canonical(a.set_domain(field).rem(b.set_domain(field)))


def _split(
    vector: PolynomialMatrix, factor: Poly, sizes: tuple[int, int]
) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    """Reduce a vector modulo the factor, without common denominators and factors, and split it."""
    n, m = sizes
    entries = [_rest(row[0], factor).as_expr() for row in vector.rows[: n + m]]
    if any(entry != 0 for entry in entries):
        common = sympy.lcm_list([sympy.fraction(sympy.together(e))[1] for e in entries])
        cleared = [sympy.cancel(e * common) for e in entries]
        divisor = sympy.gcd_list([e for e in cleared if e != 0])
        first = next(e for e in cleared if e != 0)
        sign = -1 if (first / divisor).could_extract_minus_sign() else 1
        entries = [sympy.expand(sympy.cancel(sign * e / divisor)) for e in cleared]
    return ImmutableMatrix(n, 1, entries[:n]), ImmutableMatrix(m, 1, entries[n:])
