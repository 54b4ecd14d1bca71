"""Routh's and Jury's arrays of a polynomial, with symbols and with degenerate rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar

import sympy
from sympy import Expr, Poly, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

from compensator_theory._latex import AFTER, BEFORE, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._poly import canonical, common_divisor, is_rational
from compensator_theory.polynomials._reading import PolynomialOrSystem, polynomial_in_time
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability._conditions import (
    StabilityConditions,
    simplified_conditions,
    stability_conditions,
)

Row = tuple[Expr, ...]


class _Table:
    """Printing that both arrays share: rows with labels, then the conclusion."""

    _REST: ClassVar[str] = "overview() has all rows"

    def _lines(self) -> list[tuple[str, Row, str]]:
        """Return (label, entries, remark) of each row."""
        raise NotImplementedError

    @property
    def conclusion(self) -> str:
        """The number of unstable roots, or the conditions for stability, in one sentence."""
        raise NotImplementedError

    def overview(self) -> str:
        """Write all rows, the meaning of the degenerate ones, and the conclusion."""
        return "\n".join([*self._written_rows(), self.conclusion])

    def _written_rows(self) -> list[str]:
        rows = [(label, [*map(text, row)], remark) for label, row, remark in self._lines()]
        widths = [
            max((len(row[k]) for _, row, _ in rows if k < len(row)), default=0)
            for k in range(max(len(row) for _, row, _ in rows))
        ]
        margin = max(len(label) for label, _, _ in rows)
        lines = []
        for label, row, remark in rows:
            cells = "  ".join(entry.ljust(width) for entry, width in zip(row, widths, strict=False))
            lines.append(f"{label.ljust(margin)} | {cells}".rstrip())
            if remark:
                lines.append(f"{' ' * margin}   {remark}")
        return lines

    def _table(self) -> str:
        """The rows as an array of LaTeX."""
        rows = self._lines()
        columns = max(len(row) for _, row, _ in rows)
        written = []
        for label, row, remark in rows:
            base, _, power = label.partition("**")
            name = f"{base}^{{{power}}}" if power else words(label)
            cells = [*map(latex, row), *[""] * (columns - len(row)), words(remark)]
            written.append(" & ".join([name, *cells]))
        body = r" \\ ".join(written)
        array = rf"\begin{{array}}{{r|{'l' * (columns + 1)}}} {body} \end{{array}}"
        return f"{BEFORE}{array}{AFTER}"


@dataclass(frozen=True, repr=False)
class RouthArray(_Table, ExactValue):
    """Routh's array of a polynomial in s.

    Attributes
    ----------
    polynomial : sympy.Poly
        Of degree n, with a positive leading coefficient where its sign is known.
    rows : tuple of tuples of sympy.Expr
        Rows of s**n, s**(n - 1), ..., s**0, as the array continues: a zero first element is
        `epsilon`, a zero row holds the derivative of its auxiliary polynomial.
    zero_rows : tuple of (int, sympy.Poly)
        Power of each row that vanished, and the auxiliary polynomial, from the row above it. Its
        roots are roots of `polynomial` and symmetric about 0.
    zero_pivots : tuple of int
        Powers of the rows whose first element was 0, and another one not.
    epsilon : sympy.Symbol or None
        Replaces a zero first element, and tends to 0 from above; None where there is none.

    Examples
    --------
    >>> from compensator_theory import routh_array
    >>> array = routh_array("s**3 + 2*s**2 + 3*s + 6")
    >>> array.zero_rows
    ((1, Poly(2*s**2 + 6, s, domain='QQ')),)
    >>> print(array.count)
    1 stable, 2 on the boundary, 0 unstable
    """

    polynomial: Poly
    rows: tuple[Row, ...]
    zero_rows: tuple[tuple[int, Poly], ...]
    zero_pivots: tuple[int, ...]
    epsilon: Symbol | None

    @property
    def first_column(self) -> Row:
        """The first elements of the rows."""
        return tuple(row[0] for row in self.rows)

    @cached_property
    def _signs(self) -> tuple[int | None, ...]:
        """Signs of the first column as epsilon tends to 0; None where symbols decide."""
        return tuple(_sign(entry, self.epsilon) for entry in self.first_column)

    @property
    def sign_changes(self) -> int | None:
        """Changes of sign along the first column; None where symbols decide a sign."""
        if None in self._signs:
            return None
        return sum(a != b for a, b in pairwise(self._signs))

    @cached_property
    def count(self) -> RootCount | None:
        """Roots left of, on and right of the imaginary axis; None where symbols decide.

        Of a rational polynomial from :func:`count_roots`, which has no degenerate case: epsilon may
        mislead where roots lie on the axis, and the conclusion says so. Else from the array.
        """
        if is_rational(self.polynomial):
            return count_roots(self.polynomial, time="continuous")
        if self.sign_changes is None or (self.zero_pivots and self._may_have_roots_on_axis()):
            return None
        on_axis = 0
        if self.zero_rows:
            power, auxiliary = self.zero_rows[0]
            start = len(self.rows) - 2 - power  # the row of the auxiliary polynomial
            changes = sum(a != b for a, b in pairwise(self._signs[start:]))
            on_axis = int(auxiliary.degree()) - 2 * changes
        total = len(self.rows) - 1
        return RootCount(total - on_axis - self.sign_changes, on_axis, self.sign_changes)

    def _may_have_roots_on_axis(self) -> bool:
        """Whether roots are symmetric about 0, as those are with which epsilon misleads."""
        p = self.polynomial
        mirrored = p.compose(Poly(-p.gen, p.gen, domain=p.domain))
        return bool(common_divisor(p, mirrored).degree() > 0)

    @property
    def conditions(self) -> tuple[Expr, ...]:
        r"""Return expressions that are all positive if and only if every root is stable.

        Of a regular array :math:`a_n, \Delta_1, \ldots, \Delta_{n-1}, a_0`, where
        :math:`\Delta_k` is the product of k elements of the first column from the second one on:
        the array has positive elements there if and only if these are positive. Of a degenerate
        array those of :func:`stability_conditions`.
        """
        if self.zero_rows or self.zero_pivots:
            return stability_conditions(self.polynomial)
        first, *others = self.first_column
        minors, product = [first], sympy.Integer(1)
        for entry in others[:-1]:
            product = sympy.cancel(product * entry)
            minors.append(product)
        return StabilityConditions(simplified_conditions([*minors, *others[-1:]]))

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Elements of the first column with symbols: where one is zero, the array is another."""
        return tuple(entry for entry in self.first_column if entry.free_symbols)

    @property
    def conclusion(self) -> str:
        """The number of unstable roots, or the conditions for stability, in one sentence."""
        if (count := self.count) is None:
            return _by_conditions(self.conditions)
        if count.unstable == 0 and count.boundary == 0:
            return "no sign change: every root has a negative real part"
        parts = [f"{_roots(count.unstable)} in the open right half plane"]
        if count.boundary:
            parts.append(f"{_roots(count.boundary)} on the imaginary axis")
        changes = self.sign_changes
        sentence = f"{changes} sign change{'s' * (changes != 1)}: {', '.join(parts)}"
        if changes != count.unstable:
            sentence += " (by exact counting: epsilon misleads where roots lie on the axis)"
        return sentence

    def _lines(self) -> list[tuple[str, Row, str]]:
        n, s = len(self.rows) - 1, self.polynomial.gen
        zero_rows = dict(self.zero_rows)
        lines = []
        for k, row in enumerate(self.rows):
            power, remark = n - k, ""
            if power in zero_rows:
                remark = f"zero row; derivative of {format_polynomial(zero_rows[power])}"
            elif power in self.zero_pivots:
                remark = f"{self.epsilon} > 0 in place of a zero first element"
            lines.append((f"{s}**{power}", row, remark))
        return lines

    def __str__(self) -> str:
        return "\n".join([self.conclusion, *self._written_rows()])

    def _repr_latex_(self) -> str:
        return self._table()


@carrying(real=True)
def routh_array(poly: PolynomialOrSystem, variable: str | Symbol | None = None) -> RouthArray:
    r"""Return Routh's array of a polynomial, which counts the roots in the right half plane.

    .. math:: r_{k,j} = \frac{r_{k-1,1}\, r_{k-2,j+1} - r_{k-2,1}\, r_{k-1,j+1}}{r_{k-1,1}}

    The rows begin with :math:`a_n, a_{n-2}, \ldots` and :math:`a_{n-1}, a_{n-3}, \ldots`; the
    number of roots in the open right half plane is that of the sign changes in the first column.

    Parameters
    ----------
    poly : polynomial, or a Realisation or TransferFunction
        In s, not constant; symbols stand for real numbers. A list of coefficients is one in s.
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    RouthArray
        Degenerate rows are handled and named: a zero first element is replaced by a positive
        epsilon; a zero row by the derivative of the auxiliary polynomial of the row above.

    Raises
    ------
    InputError
        If the polynomial is constant or in z or q, for which :func:`jury_array` is.
    BudgetError
        If the degree or an element is beyond the :class:`Budget`.

    Notes
    -----
    With symbols the array holds where no element of `exceptional` is zero. The textbook's epsilon
    miscounts some polynomials with roots on the axis: that of (s**2 + 1)(s - 1)(s**2 + s + 3)
    changes sign three times, for one unstable root. Source: E. J. Routh, A
    Treatise on the Stability of a Given State of Motion, 1877; F. R. Gantmacher, The Theory of
    Matrices, vol. 2, XV.2-XV.4.

    Examples
    --------
    >>> from compensator_theory import routh_array
    >>> print(routh_array("s**3 + a*s**2 + b*s + c").overview())
    s**3 | 1          b
    s**2 | a          c
    s**1 | (a*b - c)/a
    s**0 | c
    stable if and only if a > 0, a*b - c > 0, c > 0
    >>> print(routh_array("s**4 + s**3 + 2*s**2 + 2*s + 5").overview())
    s**4 | 1                        2  5
    s**3 | 1                        2
    s**2 | epsilon                  5
           epsilon > 0 in place of a zero first element
    s**1 | (2*epsilon - 5)/epsilon
    s**0 | 5
    2 sign changes: 2 roots in the open right half plane
    """
    p, _ = polynomial_in_time(poly, "continuous", variable)
    p = _positive_leading(p, "Routh's array")
    rows, zero_rows, zero_pivots, epsilon = _routh_rows(p)
    return RouthArray(p, rows, zero_rows, zero_pivots, epsilon)


def _routh_rows(
    p: Poly,
) -> tuple[tuple[Row, ...], tuple[tuple[int, Poly], ...], tuple[int, ...], Symbol | None]:
    """Return the rows, auxiliary polynomials of zero rows, and substitutes of zero pivots."""
    field: Domain = p.domain.get_field()
    n, s = int(p.degree()), p.gen
    descending = [field.convert(c) for c in p.set_domain(field).rep.to_list()]
    rows: list[list[Any]] = [descending[0::2], descending[1::2]]
    zero_rows: list[tuple[int, Poly]] = []
    zero_pivots: list[int] = []
    epsilon: Symbol | None = None
    for power in range(n - 1, -1, -1):
        row, above = rows[-1], rows[-2]
        if not any(row):
            degree = power + 1
            coefficients = [(degree - 2 * j, c) for j, c in enumerate(above) if degree >= 2 * j]
            auxiliary = sum(
                (field.to_sympy(c) * s**exponent for exponent, c in coefficients),
                start=sympy.Integer(0),
            )
            zero_rows.append((power, canonical(Poly(auxiliary, s))))
            row[:] = [c * exponent for exponent, c in coefficients if exponent > 0]
        elif not row[0]:
            if epsilon is None:
                epsilon = fresh(names_in_all(p), "epsilon")
                ground = field.domain if field.is_FractionField else field
                symbols = field.symbols if field.is_FractionField else ()
                extended: Domain = ground.frac_field(*symbols, epsilon)
                rows = [[extended.convert_from(c, field) for c in line] for line in rows]
                field, row, above = extended, rows[-1], rows[-2]
            zero_pivots.append(power)
            row[0] = field.convert(epsilon)
        if power == 0:
            break
        pivot, head = row[0], above[0]
        width = (power - 1) // 2 + 1
        following = row[1:] + [field.zero] * width
        rows.append([above[j + 1] - head * following[j] / pivot for j in range(width)])
        ask("terms", max(map(_terms, rows[-1])), "an element of the array")
    written = tuple(tuple(field.to_sympy(c) for c in row) for row in rows)
    return written, tuple(zero_rows), tuple(zero_pivots), epsilon


@dataclass(frozen=True, repr=False)
class JuryArray(_Table, ExactValue):
    """Jury's array of a polynomial in z or q.

    Attributes
    ----------
    polynomial : sympy.Poly
        Of degree n, with a positive leading coefficient where its sign is known.
    rows : tuple of tuples of sympy.Expr
        The coefficients in ascending powers, then the rows of the determinants, down to three
        elements. The array as it is printed in textbooks has each row once more, reversed.

    Examples
    --------
    >>> from compensator_theory import jury_array
    >>> print(jury_array("z**2 + a*z + b").conditions)
    (a + b + 1, -a + b + 1, 1 - b, b + 1)
    """

    polynomial: Poly
    rows: tuple[Row, ...]

    @property
    def conditions(self) -> tuple[Expr, ...]:
        r"""Return expressions that are all positive if and only if every root is stable.

        .. math:: p(1), \quad (-1)^n p(-1), \quad a_n \pm a_0, \quad b_0^2 - b_{n-1}^2, \quad
                  c_0^2 - c_{n-2}^2, \ldots

        Without those that are positive whatever the symbols are. Half of them follow from the
        others: :func:`stability_conditions` has the short list.
        """
        return StabilityConditions(
            simplified_conditions([value for value, _ in self._conditions()])
        )

    @cached_property
    def count(self) -> RootCount | None:
        """Roots inside, on and outside the unit circle; None where symbols decide."""
        if is_rational(self.polynomial):
            return count_roots(self.polynomial, time="discrete")
        return None

    @property
    def conclusion(self) -> str:
        """The number of unstable roots, or the conditions for stability, in one sentence."""
        if (count := self.count) is None:
            return _by_conditions(self.conditions)
        if count.unstable == 0 and count.boundary == 0:
            return "every condition holds: every root lies inside the unit circle"
        parts = [f"{_roots(count.unstable)} outside the unit circle"]
        if count.boundary:
            parts.append(f"{_roots(count.boundary)} on it")
        failing = next(phrase for value, phrase in self._conditions() if not value.is_positive)
        return f"{failing} fails: {', '.join(parts)}"

    def _conditions(self) -> list[tuple[Expr, str]]:
        """Return each condition, and the words of the textbook for it."""
        p, n = self.polynomial, int(self.polynomial.degree())
        first, last = self.rows[0][0], self.rows[0][-1]
        one, minus = p.eval(1), (-1) ** n * p.eval(-1)
        sign = "" if n % 2 == 0 else "-"
        conditions = [(one, "p(1) > 0"), (minus, f"{sign}p(-1) > 0")]
        if not last.is_positive:
            conditions.insert(0, (last, f"a_{n} > 0"))
        if n > 1:
            modulus = f"abs(a_0) < a_{n}"
            conditions += [(last - first, modulus), (last + first, modulus)]
        for row, letter in zip(self.rows[1:], _letters(), strict=False):
            phrase = f"abs({letter}_0) > abs({letter}_{len(row) - 1})"
            conditions.append((row[0] ** 2 - row[-1] ** 2, phrase))
        return [(sympy.expand(value), phrase) for value, phrase in conditions]

    def _lines(self) -> list[tuple[str, Row, str]]:
        lines: list[tuple[str, Row, str]] = []
        for k, row in enumerate(self.rows):
            remark = ""
            if not any(row):
                remark = "zero row: roots on the unit circle, or pairs r and 1/r"
            lines += [(f"{2 * k + 1}", row, remark), (f"{2 * k + 2}", row[::-1], "")]
        return lines

    def __str__(self) -> str:
        return "\n".join([self.conclusion, *self._written_rows()])

    def _repr_latex_(self) -> str:
        return self._table()


@carrying(real=True)
def jury_array(poly: PolynomialOrSystem, variable: str | Symbol | None = None) -> JuryArray:
    r"""Return Jury's array of a polynomial, whose conditions put all roots inside the unit circle.

    .. math:: b_k = a_0 a_k - a_n a_{n-k}, \quad c_k = b_0 b_k - b_{n-1} b_{n-1-k}, \ldots; \qquad
              p(1) > 0, \ (-1)^n p(-1) > 0, \ |a_0| < a_n, \ |b_0| > |b_{n-1}|, \ldots

    Parameters
    ----------
    poly : polynomial, or a Realisation or TransferFunction
        In z or q, not constant; symbols stand for real numbers. A list of coefficients, highest
        power first, is one in q.
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    JuryArray
        It has no divisions: a row whose first element is zero is a failing condition, not a
        degenerate case, and `count` says how many roots lie inside, on and outside the circle.

    Raises
    ------
    InputError
        If the polynomial is constant or in s, for which :func:`routh_array` is.
    BudgetError
        If the degree or an element is beyond the :class:`Budget`.

    Notes
    -----
    Source: E. I. Jury, Theory and Application of the z-Transform Method, 1964, chapter 3; K. Ogata,
    Discrete-Time Control Systems, section 4-3. The first row has ascending powers.

    Examples
    --------
    >>> from compensator_theory import jury_array
    >>> print(jury_array("z**3 - 1.3*z**2 - 0.08*z + 0.24").overview())
    1 | 6/25      -2/25      -13/10    1
    2 | 1         -13/10     -2/25     6/25
    3 | -589/625  1601/1250  -29/125
    4 | -29/125   1601/1250  -589/625
    p(1) > 0 fails: 1 root outside the unit circle
    """
    p, _ = polynomial_in_time(poly, "discrete", variable)
    p = _positive_leading(p, "Jury's array")
    ring: Domain = p.domain
    row = [ring.convert(c) for c in reversed(p.rep.to_list())]
    rows = [row]
    while len(row) > 3:
        row = [row[0] * row[k] - row[-1] * row[-1 - k] for k in range(len(row) - 1)]
        ask("terms", max(map(_terms, row)), "an element of the array")
        rows.append(row)
    return JuryArray(p, tuple(tuple(map(ring.to_sympy, row)) for row in rows))


def _letters() -> Iterable[str]:
    """Yield the letters of the rows after a: b, c, ..., as textbooks name them."""
    yield from "bcdefghij"
    k = 11
    while True:
        yield f"row{k}"
        k += 1


def _positive_leading(p: Poly, subject: str) -> Poly:
    """Return the polynomial with a positive leading coefficient; refuse a constant."""
    if p.degree() < 1:
        raise InputError(
            f"{subject} needs a polynomial of degree 1 or more; {format_polynomial(p)} is constant"
        )
    ask("degree", int(p.degree()), subject)
    return canonical(-p) if p.LC().is_negative else p


def _terms(element: Any) -> int:
    """The number of terms of a coefficient."""
    if isinstance(element, FracElement):
        return len(element.numer) + len(element.denom)
    return len(element) if isinstance(element, PolyElement) else 1


def _sign(entry: Expr, epsilon: Symbol | None) -> int | None:
    """The sign of an element for a small positive epsilon; None where symbols decide."""
    if epsilon is not None and entry.has(epsilon):
        sides = sympy.fraction(sympy.cancel(entry))
        top, bottom = (_sign(Poly(side, epsilon).EC(), None) for side in sides)
        return None if top is None or bottom is None else top * bottom
    value = sympy.factor(entry) if entry.free_symbols else entry
    return 1 if value.is_positive else -1 if value.is_negative else None


def _by_conditions(conditions: Sequence[Expr]) -> str:
    """The conclusion where roots are not counted: the conditions, or that one of them fails."""
    for condition in conditions:
        if condition.is_nonpositive:
            return f"not stable: the condition {text(condition)} > 0 fails"
    written = ", ".join(f"{text(condition)} > 0" for condition in conditions)
    return f"stable if and only if {written}" if written else "stable: every condition holds"


def _roots(count: int) -> str:
    return f"{count or 'no'} root{'s' * (count > 1)}"
