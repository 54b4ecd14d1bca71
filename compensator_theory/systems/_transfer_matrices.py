"""Matrices of exact transfer functions over one common denominator that is never reduced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce
from itertools import chain
from operator import matmul
from typing import TYPE_CHECKING, TypeAlias, cast

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, MatrixBase, Poly, Rational, Symbol
from sympy.polys.matrices import DomainMatrix

from compensator_theory._latex import displayed, fraction, table
from compensator_theory._terminal import matrix_repr
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._diagonalisation import invariant_polynomials
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._rings import in_lowest_terms
from compensator_theory.polynomials._budget import ask, is_integer
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import (
    common_divisor,
    exact_quotient,
    from_expression,
    product,
    total,
)
from compensator_theory.polynomials._reading import polynomial
from compensator_theory.roots._certified import Root
from compensator_theory.roots._closed_forms import RootFormula, roots_of
from compensator_theory.systems._adjugates import adjugate_and_determinant
from compensator_theory.systems._sample_times import (
    System,
    period_in,
    shared_sample_time,
    time_base,
    to_float,
)
from compensator_theory.systems._transfer_functions import (
    TransferFunction,
    constant_one,
    inverted,
    sides_of,
)

if TYPE_CHECKING:
    import control

Rows: TypeAlias = tuple[tuple[Poly, ...], ...]
MatrixSides: TypeAlias = tuple[Rows, Poly]
Scalar: TypeAlias = TransferFunction | NumberLike | Poly
"""Scalar factors of a transfer matrix."""
Operand: TypeAlias = "TransferMatrix | MatrixLike"
"""Matrix operands of a transfer matrix."""


@dataclass(frozen=True, repr=False)
class TransferMatrix(System):
    r"""A polynomial matrix over one monic polynomial.

    .. math:: G = \frac{1}{D}\begin{bmatrix} N_{11} & \cdots \\ \vdots & \ddots \end{bmatrix}

    Parameters
    ----------
    numerators : tuple of tuples of sympy.Poly
        One tuple for each output.
    denominator : sympy.Poly
        Not zero; everything is divided by its leading coefficient.
    certificate : Certificate, optional
        The identity that a conversion checked.
    sample_time : number, optional
        As of :class:`TransferFunction`.

    Raises
    ------
    InputError
        If the rows have different lengths or the matrix is empty.

    Notes
    -----
    Two matrices over one denominator are added over it, those over two different ones over their
    product; a product is over the product of both, and nothing cancels. ``@`` multiplies matrices
    (constant ones of SymPy or nested lists included), ``*`` does so too between two transfer
    matrices, and by a number, text or transfer function it multiplies every entry.

    Source: (2.10), where the four maps of a plant share the denominator det(qI - A).

    Examples
    --------
    >>> from compensator_theory import polynomial, servo_problem
    >>> G_zw = servo_problem("1/(q - 0.5)").G_zw
    >>> G_zw.shape, str(G_zw[0, 1])
    ((1, 3), '(-1)/(q - 1/2)')
    >>> from compensator_theory import transfer_matrix
    >>> G = transfer_matrix([["1/(s + 1)", 2]])
    >>> print(G + G, "a" * G, sep=", ")
    [[2, 4*s + 4]]/(s + 1), [[a, 2*a*s + 2*a]]/(s + 1)
    >>> print(G @ [[1], ["b"]], G - [[0, 2]], sep=", ")
    [[2*b*s + (2*b + 1)]]/(s + 1), [[1, 0]]/(s + 1)
    >>> G = transfer_matrix([["1/s", 0], [0, "(s + 2)/s"]])
    >>> [(root.value, root.multiplicity) for root in (*G.poles(), *G.zeros())]
    [(0j, 2), ((-2+0j), 1)]
    """

    numerators: Rows
    denominator: Poly
    certificate: Certificate | None = field(default=None, compare=False)
    sample_time: Rational | None = None

    def __post_init__(self) -> None:
        rows = self.numerators
        if not rows or not rows[0] or len({len(row) for row in rows}) != 1:
            raise InputError("a transfer matrix needs rows of one and the same nonzero length")
        entries = [[TransferFunction(entry, self.denominator) for entry in row] for row in rows]
        object.__setattr__(self, "denominator", entries[0][0].denominator)
        object.__setattr__(
            self, "numerators", tuple(tuple(entry.numerator for entry in row) for row in entries)
        )
        object.__setattr__(self, "sample_time", period_in(self.variable, self.sample_time))

    @property
    def variable(self) -> Symbol:
        """Variable of all entries."""
        return self.denominator.gen

    @property
    def shape(self) -> tuple[int, int]:
        """Number of outputs and number of inputs."""
        return len(self.numerators), len(self.numerators[0])

    def __getitem__(self, index: tuple[int, int]) -> TransferFunction:
        row, column = index
        return TransferFunction._of_canonical(
            numerator=self.numerators[row][column],
            denominator=self.denominator,
            certificate=self.certificate,
            feedback=None,
            sample_time=self.sample_time,
        )

    def scalar(self) -> TransferFunction:
        """Return the only entry; InputError if there are several."""
        if self.shape != (1, 1):
            raise InputError(
                f"this map has {self.shape[0]} outputs and {self.shape[1]} inputs; pick an entry, "
                "as in G[0, 0]"
            )
        return self[0, 0]

    def as_matrix(self) -> ImmutableMatrix:
        """Return a SymPy matrix of expressions; SymPy may cancel factors in them."""
        bottom = self.denominator.as_expr()
        return ImmutableMatrix([[entry.as_expr() / bottom for entry in r] for r in self.numerators])

    def evalf(self, digits: int = 15) -> ImmutableMatrix:
        """Return a SymPy matrix with floats of so many digits, to look at.

        Examples
        --------
        >>> from compensator_theory import transfer_matrix
        >>> transfer_matrix([["1/(3*s)", "sqrt(2)/(s + 1)"]]).evalf(4)
        Matrix([[0.3333/s, 1.414/(s + 1.0)]])
        """
        rows, columns = self.shape
        return ImmutableMatrix(rows, columns, lambda i, j: self[i, j].reduced().evalf(digits))

    def numerator_matrix(self) -> ImmutableMatrix:
        """Return the numerators as a SymPy matrix of expressions."""
        return ImmutableMatrix([[entry.as_expr() for entry in row] for row in self.numerators])

    def to_control(self, dt: float | bool | None = None) -> control.TransferFunction:
        """Return the python-control object; every coefficient is rounded once to float64.

        Parameters
        ----------
        dt : float or bool, optional
            As for :meth:`TransferFunction.to_control`.

        Raises
        ------
        InputError
            If a coefficient is symbolic or overflows, or `dt` is needed and missing.
        """
        import control  # slow to import, and only needed here

        below = [to_float(c) for c in self.denominator.all_coeffs()]
        above = [[[to_float(c) for c in n.all_coeffs()] for n in row] for row in self.numerators]
        time = time_base(self.variable, self.sample_time, dt)
        return control.TransferFunction(above, [[below] * self.shape[1]] * self.shape[0], time)

    __array_ufunc__ = None  # an array times a transfer matrix comes to __rmatmul__, not to a loop
    _op_priority = 30.0  # so does a matrix of SymPy

    def __add__(self, other: Operand) -> TransferMatrix:
        return self._join(other, lambda a, b: _added(a, b, 1))

    def __radd__(self, other: Operand) -> TransferMatrix:
        return self._join(other, lambda a, b: _added(b, a, 1))

    def __sub__(self, other: Operand) -> TransferMatrix:
        return self._join(other, lambda a, b: _added(a, b, -1))

    def __rsub__(self, other: Operand) -> TransferMatrix:
        return self._join(other, lambda a, b: _added(b, a, -1))

    def __neg__(self) -> TransferMatrix:
        return self._with(tuple(tuple(-n for n in row) for row in self.numerators))

    def __pos__(self) -> TransferMatrix:
        return self

    def __matmul__(self, other: Operand) -> TransferMatrix:
        return self._join(other, _multiplied)

    def __rmatmul__(self, other: Operand) -> TransferMatrix:
        return self._join(other, lambda a, b: _multiplied(b, a))

    def __mul__(self, other: Operand | Scalar) -> TransferMatrix:
        if _is_matrix(other):
            return self._join(cast(Operand, other), _multiplied)
        return self._scaled(cast(Scalar, other))

    def __rmul__(self, other: Operand | Scalar) -> TransferMatrix:
        if _is_matrix(other):
            return self._join(cast(Operand, other), lambda a, b: _multiplied(b, a))
        return self._scaled(cast(Scalar, other))

    def __truediv__(self, other: TransferMatrix | Scalar) -> TransferMatrix:
        """The product with the inverse of a matrix, or every entry over a number or a text."""
        if isinstance(other, TransferMatrix):
            return self @ other.inverse()
        sides = sides_of(other, self.denominator.gen)
        if sides is None:
            return NotImplemented
        below, above = inverted(sides)
        factor = TransferFunction(below, above, sample_time=shared_sample_time(self, other))
        return self * factor

    def __pow__(self, exponent: int) -> TransferMatrix:
        """Return a power, of the inverse for a negative exponent; the identity for 0."""
        if not is_integer(exponent):
            raise TypeError(f"{exponent!r} is no exponent of a transfer matrix; an int is")
        rows, columns = self.shape
        if rows != columns:
            raise InputError(f"a {rows} x {columns} transfer matrix is not square: no powers")
        base = self.inverse() if exponent < 0 else self
        degrees = [int(p.degree()) for p in (base.denominator, *chain(*base.numerators)) if p]
        ask("degree", max(degrees) * abs(exponent), "the power")
        one, zero = constant_one(self.denominator), _zero(self.denominator)
        identity = tuple(tuple(one if i == j else zero for j in range(rows)) for i in range(rows))
        return reduce(matmul, [base] * abs(exponent), self._with(identity, one))

    @property
    def T(self) -> TransferMatrix:
        """The transpose."""
        return self._with(tuple(zip(*self.numerators, strict=True)))

    def reduced(self) -> TransferMatrix:
        """Return the same matrix without the factor that all entries share with the denominator."""
        entries = (entry for row in self.numerators for entry in row)
        common = common_divisor(self.denominator, *entries)
        if common.degree() < 1:
            return self
        rows = tuple(tuple(exact_quotient(e, common) for e in row) for row in self.numerators)
        return self._with(rows, exact_quotient(self.denominator, common))

    def poles(self) -> tuple[Root | RootFormula, ...]:
        """Return the finite poles by McMillan's definition, with multiplicity.

        Certified where the matrix is rational, in closed form with symbols, as of a
        :class:`TransferFunction`.

        Those of 1/s times the 2 x 2 identity are 0, twice; what all entries of the common
        denominator cancel is none. :func:`smith_mcmillan_form` has those at infinity too.
        """
        return roots_of(self._smith_mcmillan_products()[1])

    def zeros(self) -> tuple[Root | RootFormula, ...]:
        """Return the finite transmission zeros, with multiplicity.

        At one of them the rank of the matrix falls, or would but for a pole in another direction.
        """
        return roots_of(self._smith_mcmillan_products()[0])

    def _smith_mcmillan_products(self) -> tuple[Poly, Poly]:
        """The products of the epsilon_i and of the psi_i of the Smith-McMillan form."""
        one = constant_one(self.denominator)
        fractions = [
            in_lowest_terms(invariant, self.denominator)
            for invariant in invariant_polynomials(self.numerators)
        ]
        return reduce(product, (e for e, _ in fractions), one), reduce(
            product, (psi for _, psi in fractions), one
        )

    def inverse(self) -> TransferMatrix:
        """Return the inverse of a square matrix, reduced; InputError if it is singular."""
        rows, columns = len(self.numerators), len(self.numerators[0])
        if rows != columns:
            raise InputError(f"a {rows} x {columns} transfer matrix is not square")
        s = self.denominator.gen
        entries = [[entry.as_expr() for entry in row] for row in self.numerators]
        square = DomainMatrix.from_Matrix(Matrix(entries))
        adjugate, determinant = adjugate_and_determinant(square)
        domain = adjugate.domain
        below = from_expression(domain.to_sympy(determinant), s)
        if below.is_zero:
            raise InputError("the transfer matrix is singular; it has no inverse")
        top = [[from_expression(domain.to_sympy(e), s) for e in r] for r in adjugate.to_list()]
        numerators = tuple(tuple(product(e, self.denominator) for e in row) for row in top)
        return self._with(numerators, below).reduced()

    def _scaled(self, factor: Scalar) -> TransferMatrix:
        sides = sides_of(factor, self.denominator.gen)
        if sides is None:
            return cast(TransferMatrix, NotImplemented)
        rows = tuple(tuple(product(entry, sides[0]) for entry in row) for row in self.numerators)
        period = shared_sample_time(self, factor)
        return TransferMatrix(rows, product(self.denominator, sides[1]), sample_time=period)

    def _join(
        self, other: Operand, operation: Callable[[MatrixSides, MatrixSides], MatrixSides]
    ) -> TransferMatrix:
        sides = _matrix_sides(other, self.denominator)
        if sides is None:
            return cast(TransferMatrix, NotImplemented)  # Python then asks the other operand
        joined = operation((self.numerators, self.denominator), sides)
        return TransferMatrix(*joined, sample_time=shared_sample_time(self, other))

    def _with(self, numerators: Rows, denominator: Poly | None = None) -> TransferMatrix:
        below = self.denominator if denominator is None else denominator
        return TransferMatrix(numerators, below, sample_time=self.sample_time)

    def __str__(self) -> str:
        rows = ["[" + ", ".join(map(format_polynomial, row)) + "]" for row in self.numerators]
        return f"[{', '.join(rows)}]/({format_polynomial(self.denominator)})"

    def __repr__(self) -> str:
        return matrix_repr("TransferMatrix", str(self), self.shape)

    def _repr_latex_(self) -> str:
        return displayed(rf"{fraction(1, self.denominator)}\, {table(self.numerators)}")


def _is_matrix(obj: object) -> bool:
    return isinstance(obj, TransferMatrix | MatrixBase | list | tuple) or (
        hasattr(obj, "shape") and not isinstance(obj, Expr) and obj.shape != ()
    )


def _matrix_sides(operand: Operand, like: Poly) -> MatrixSides | None:
    if isinstance(operand, TransferMatrix):
        if operand.denominator.gen != like.gen:
            raise InputError(
                f"one transfer matrix is in {operand.denominator.gen} and the other in {like.gen}; "
                "both need one variable"
            )
        return operand.numerators, operand.denominator
    if not _is_matrix(operand):
        return None
    matrix = exact_matrix(operand, "the constant matrix")
    if like.gen in matrix.free_symbols:
        raise InputError(
            f"the matrix contains the variable {like.gen}; make it a transfer matrix first, with "
            "transfer_matrix(...)"
        )
    rows = [[polynomial(entry, like.gen) for entry in row] for row in matrix.tolist()]
    return tuple(map(tuple, rows)), constant_one(like)


def _added(a: MatrixSides, b: MatrixSides, sign: int) -> MatrixSides:
    shapes = [(len(rows), len(rows[0]) if rows else 0) for rows, _ in (a, b)]
    if shapes[0] != shapes[1]:
        (p, m), (k, l) = shapes  # noqa: E741
        raise InputError(f"a {p} x {m} matrix and a {k} x {l} matrix have no sum")
    one = constant_one(a[1])
    over_one = a[1] == b[1]
    left, right = (one, one) if over_one else (b[1], a[1])
    rows = tuple(
        tuple(total(product(x, left), product(y * sign, right)) for x, y in zip(r, q, strict=True))
        for r, q in zip(a[0], b[0], strict=True)
    )
    return rows, a[1] if over_one else product(a[1], b[1])


def _multiplied(a: MatrixSides, b: MatrixSides) -> MatrixSides:
    inner = len(a[0][0]) if a[0] else 0
    if not b[0] or inner != len(b[0]):
        raise InputError(
            f"a {len(a[0])} x {inner} matrix and one with {len(b[0])} rows have no product"
        )
    ask("entries", len(a[0]) * len(b[0]) * len(b[0][0]), "the product")
    columns = list(zip(*b[0], strict=True))
    rows = tuple(
        tuple(
            total(_zero(a[1]), *(product(x, y) for x, y in zip(row, column, strict=True)))
            for column in columns
        )
        for row in a[0]
    )
    return rows, product(a[1], b[1])


def _zero(like: Poly) -> Poly:
    return Poly(0, like.gen, domain=sympy.QQ)
