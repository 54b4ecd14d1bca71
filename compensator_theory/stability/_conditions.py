"""Stability of a polynomial with symbols as a short list of inequalities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import flint
import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_matrices import rational
from compensator_theory.matrices._fraction_free import SymbolicRows
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.matrices._rational_functions import RationalFunctions, factored
from compensator_theory.matrices._symbolic_matrices import Numerators, over_common_symbols
from compensator_theory.polynomials._budget import ask, limit_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._complex_polynomials import complex_parts, norm_of
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._variables import is_discrete
from compensator_theory.roots._half_plane import half_plane_polynomial
from compensator_theory.systems._transfer_functions import TransferFunction

Coefficient = TypeVar("Coefficient")
PRODUCTS = 150_000
"""Of two terms, times the words of a number, for each term of the budget: some seconds in all."""


class StabilityConditions(tuple[Expr, ...]):
    """Expressions that must be positive; the list has no truth value, since empty means stable."""

    __slots__ = ()

    def __bool__(self) -> bool:
        raise InputError(
            "a list of conditions has no truth value: call decide_stability(p), or len(...) for "
            "the number of conditions"
        )


@carrying(real=True)
def stability_conditions(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[Expr, ...]:
    r"""Return expressions that are all positive if and only if every root is stable.

    .. math:: a_0, a_1, a_3, a_5, \ldots > 0, \qquad \Delta_{n-1}, \Delta_{n-3}, \ldots > 0

    for even n, and :math:`a_0, a_2, a_4, \ldots` in place of the odd ones for odd n: half of
    Hurwitz's determinants :math:`\Delta_k`, as Lienard and Chipart have shown. A polynomial in z or
    q is mapped to the half plane by z = (1 + w)/(1 - w) first.

    Parameters
    ----------
    poly : polynomial
        In s for the open left half plane, in z or q for the open unit disk; symbols stand for real
        numbers. Where the leading coefficient is symbolic, it is taken to be positive, and is the
        first condition; for a negative one pass the negated polynomial, and where it is zero
        for the remaining polynomial. Complex coefficients are read, as of a rotating frame: the
        conditions are those of the polynomial times its conjugate.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of sympy.Expr
        Without the conditions that are true whatever the symbols are; empty where all are. It has
        no truth value, as `decide_stability` has.

    Raises
    ------
    InputError
        If the polynomial is zero, or its variable is none of s, z and q.
    BudgetError
        If a coefficient, or a determinant as a polynomial in the coefficients, has more terms than
        the :class:`Budget`.

    Notes
    -----
    A condition is multiplied out, with each factor of a denominator once or squared, as long as it
    has no more terms than the budget allows; a longer one is left as a product, a determinant as
    the polynomial that it is in the coefficients. ``budget(terms=...)`` moves the limit.

    Source: A. Lienard and H. Chipart, J. Math. Pures Appl. 10 (1914) 291-346; F. R. Gantmacher, The
    Theory of Matrices, vol. 2, XV.13. A condition that is false whatever the symbols are stands in
    the list as a negative number or 0.

    Examples
    --------
    >>> from compensator_theory import stability_conditions
    >>> stability_conditions("s**3 + a*s**2 + b*s + c")
    (c, a, a*b - c)
    >>> stability_conditions("z**2 + a*z + b")
    (-a + b + 1, a + b + 1, 1 - b)
    >>> stability_conditions("s + a + w*I", "s")  # a pole in a frame that rotates with w
    (a**2 + w**2, a)
    """
    if isinstance(poly, TransferFunction):
        raise InputError(
            f"{poly} is a transfer function; its poles are the roots of G.denominator, and those "
            "of a loop the roots of closed_loop_polynomial(standard_problem(G), N_c, D_c)"
        )
    parts = complex_parts(poly, variable)
    p = polynomial(poly, variable) if parts is None else norm_of(parts)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    if sympy.sympify(p.LC()).is_negative:
        p = -p
    leading = [] if sympy.sympify(p.LC()).is_positive else [p.LC()]
    if is_discrete(p.gen, "stability"):
        size = int(p.degree())
        p = half_plane_polynomial(p)
        a = [p.coeff_monomial(p.gen**k) for k in range(size + 1)]
        leading.append(a[-1])
    else:
        a = list(reversed(p.all_coeffs()))
    n = len(a) - 1
    first = range(1, n, 2) if n % 2 == 0 else range(2, n, 2)
    chosen = [0, *first] if n else []
    sizes = sorted(range(n - 1, 1, -2))
    if (read := over_common_symbols(sympy.Matrix([[*leading, *a]]))) is not None:
        work, (numerators,) = read
        return StabilityConditions(
            _HurwitzArray(work, numerators, len(leading)).conditions(chosen, sizes)
        )
    by_routh = _rational_minors(a, max(sizes, default=0))
    minors = [by_routh[k] if k in by_routh else _hurwitz_minor(a, k) for k in sizes]
    return StabilityConditions(simplified_conditions([*leading, *(a[k] for k in chosen), *minors]))


@generic_answer_of(stability_conditions)
def _generic_conditions(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[tuple[Expr, ...], list[Expr]]:
    """Return the conditions for a fixed degree and a positive symbolic leading coefficient."""
    parts = complex_parts(poly, variable)
    p = polynomial(poly, variable) if parts is None else norm_of(parts)
    leading = sympy.sympify(p.LC())
    return stability_conditions(poly, variable), [leading]


class _HurwitzArray:
    """Coefficients as numerators over one denominator, and the conditions on them in their ring."""

    def __init__(self, work: RationalFunctions, numerators: Numerators, before: int) -> None:
        """Read extra conditions, their number, and the ascending coefficients."""
        self.work, self.below = work, numerators.below
        self.before, self.tops = list(numerators.flat[:before]), list(numerators.flat[before:])
        content, self.factors = factored(numerators.below)
        self.sign = 1 if content > 0 else -1

    def conditions(self, chosen: Sequence[int], sizes: Sequence[int]) -> list[Expr]:
        """Return the conditions that do not always hold, without repetition."""
        requests: list[tuple[flint.fmpz_mpoly | None, int, int | None]]
        requests = [(top, 1, None) for top in self.before]
        requests += [(self.tops[k], 1, None) for k in chosen]
        minors = _leading_minors(self.tops, self.work.context, max(sizes, default=0))
        if any(pivot.is_zero() for pivot in minors.values()):
            minors |= {size: self._minor(size) for size in sizes if size not in minors}
        requests += [(minors.get(size), size, size) for size in sizes]
        conditions: list[Expr] = []
        for top, power, size in requests:
            condition = self._condition(top, power, size)
            if not condition.is_positive and condition not in conditions:
                conditions.append(condition)
        return conditions

    def _minor(self, size: int) -> flint.fmpz_mpoly:
        """Return one determinant, where a smaller one is zero, with exchanges of rows."""
        zero, places = self.work.zero, [(i, j) for i in range(size) for j in range(size)]
        flat = [_entry(self.tops, i, j, zero) for i, j in places]
        rows = SymbolicRows(self.work, [Numerators(flat, self.work.one, size, size)])
        return rows.last * rows.sign if len(rows.reduce(size)) == size else self.work.zero

    def _condition(self, top: flint.fmpz_mpoly | None, power: int, size: int | None) -> Expr:
        r"""Return a polynomial with the sign of a numerator over a power of the denominator.

        It is multiplied out as far as the budget of terms goes, else left as a product, and a
        determinant as the polynomial that it is in the coefficients.
        """
        most = limit_of("terms")
        if top is not None and len(top) <= most:
            whole = self._multiplied_out(top, power)
            if whole.is_constant():
                value = self.work.write(top, self.below**power)
                return sympy.Integer(value.p * value.q)
            if len(whole) <= most:
                return self.work.expression(whole / abs(whole.content()))
        below = self._expression(self.below)
        outside = 1 if below.is_number else below ** (2 - power % 2)
        if size is None:
            return self._expression(top) * outside
        return self._determinant(size) * outside

    def _multiplied_out(self, top: flint.fmpz_mpoly, power: int) -> flint.fmpz_mpoly:
        """Multiply by the factors of the denominator that do not cancel, once or twice each."""
        for factor, multiplicity in self.factors:
            left = int(multiplicity) * power
            while left:
                quotient, rest = divmod(top, factor)
                if not rest.is_zero():
                    break
                top, left = quotient, left - 1
            top = top * factor ** (left if left < 2 else 2 - left % 2)
        return top * self.sign**power

    def _determinant(self, size: int) -> Expr:
        """Return a determinant as a polynomial in the numerators, which are multiplied out."""
        n = len(self.tops) - 1
        places = flint.fmpz_mpoly_ctx.get([f"c{k}" for k in range(n + 1)], flint.Ordering.lex)
        generic = _leading_minors(list(places.gens()), places, size, is_generic=True)
        values = [self._expression(top) for top in self.tops]
        return sympy.Add(
            *(
                sympy.Mul(int(c), *(x**p for x, p in zip(values, map(int, powers), strict=True)))
                for powers, c in generic[size].to_dict().items()
            )
        )

    def _expression(self, top: flint.fmpz_mpoly) -> Expr:
        ask("terms", len(top), "a coefficient, multiplied out,")
        return self.work.expression(top)


def _leading_minors(
    ascending: list[flint.fmpz_mpoly],
    ring: flint.fmpz_mpoly_ctx,
    most: int,
    *,
    is_generic: bool = False,
) -> dict[int, flint.fmpz_mpoly]:
    """Return Hurwitz's determinants by size, up to one that is zero: Bareiss's pivots, bordered.

    Those of symbols as long as the budget has terms for them, others as long as products are few.
    """
    zero, products, most_products = ring.constant(0), 0, PRODUCTS * limit_of("terms")
    rows = [[_entry(ascending, i, j, zero) for j in range(most)] for i in range(most)]
    minors = {0: ring.constant(1)}
    for k in range(most):
        places = [(t, i, k) for t in range(k) for i in range(t + 1, k)]
        places += [(t, k, j) for t in range(k) for j in range(t + 1, k + 1)]
        for t, i, j in places:
            pivot, x, head, y = minors[t + 1], rows[i][j], rows[i][t], rows[t][j]
            words = 1 + int(pivot.leading_coefficient()).bit_length() // 64
            products += (len(pivot) * len(x) + len(head) * len(y)) * words
            if products > most_products and not is_generic:
                return minors
            rows[i][j] = (pivot * x - head * y) / minors[t]
        minors[k + 1] = rows[k][k]
        if is_generic:
            ask("terms", len(rows[k][k]), f"Hurwitz's determinant {k + 1}, multiplied out,")
        if rows[k][k].is_zero():
            break
    return minors


def _rational_minors(ascending: list[Expr], most: int) -> dict[int, Expr]:
    """Return Hurwitz's determinants by size up to one that is zero: products of Routh's column."""
    if not all(c.is_Rational for c in ascending):
        return {}
    numbers = [flint.fmpq(int(c.p), int(c.q)) for c in reversed(ascending)]
    above, row, product, minors = numbers[::2], numbers[1::2], flint.fmpq(1), {}
    for size in range(1, most + 1):
        product *= row[0]
        minors[size] = rational(product)
        if product == 0:
            break
        factor, padded = above[0] / row[0], [*row[1:], flint.fmpq(0)]
        following = [x - factor * y for x, y in zip(above[1:], padded, strict=False)]
        above, row = row, following
    return minors


def _hurwitz_minor(ascending: list[Expr], size: int) -> Expr:
    zero = sympy.Integer(0)
    return determinant(sympy.Matrix(size, size, lambda i, j: _entry(ascending, i, j, zero)))


def _entry(ascending: Sequence[Coefficient], i: int, j: int, zero: Coefficient) -> Coefficient:
    """Return an entry of Hurwitz's matrix, counted from 0."""
    k = len(ascending) - 1 - 2 * (j + 1) + (i + 1)
    return ascending[k] if 0 <= k < len(ascending) else zero


def simplified_conditions(conditions: list[Expr]) -> list[Expr]:
    """Return the conditions without denominators, positive factors and repetitions."""
    simplified: list[Expr] = []
    for condition in conditions:
        top, bottom = sympy.fraction(sympy.cancel(condition))
        shorter = sympy.expand(top * bottom)
        symbols = sorted(shorter.free_symbols, key=str)
        if symbols:
            shorter = Poly(shorter, *symbols).primitive()[1].as_expr()
        if not shorter.is_positive and shorter not in simplified:
            simplified.append(shorter)
    return simplified
