"""Matrices of exact transfer functions over one common denominator that is never reduced."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from sympy import ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.latex import displayed, fraction, table
from compensator_theory.matrices.certificates import Certificate
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.transfer_functions.matrix_arithmetic import MatrixArithmetic
from compensator_theory.transfer_functions.sample_times import time_base, to_float
from compensator_theory.transfer_functions.transfer_functions import TransferFunction

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, repr=False)
class TransferMatrix(MatrixArithmetic, ExactValue):
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
    sample_time : Rational, optional
        In seconds, where it was read from a system that has one.

    Raises
    ------
    InputError
        If the rows have different lengths or the matrix is empty.

    Notes
    -----
    Source: (2.10), where the four maps of a plant share the denominator det(qI - A).

    Examples
    --------
    >>> from compensator_theory import polynomial, servo_problem
    >>> G_zw = servo_problem("1/(q - 0.5)").G_zw
    >>> G_zw.shape, str(G_zw[0, 1])
    ((1, 3), '(-1)/(q - 1/2)')
    """

    numerators: tuple[tuple[Poly, ...], ...]
    denominator: Poly
    certificate: Certificate | None = field(default=None, compare=False)
    sample_time: Rational | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        rows = self.numerators
        if not rows or not rows[0] or len({len(row) for row in rows}) != 1:
            raise InputError("a transfer matrix needs rows of one and the same nonzero length")
        entries = [[TransferFunction(entry, self.denominator) for entry in row] for row in rows]
        object.__setattr__(self, "denominator", entries[0][0].denominator)
        object.__setattr__(
            self, "numerators", tuple(tuple(entry.numerator for entry in row) for row in entries)
        )

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
        return TransferFunction(
            self.numerators[row][column],
            self.denominator,
            self.certificate,
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

    def numerator_matrix(self) -> ImmutableMatrix:
        """Return the numerators as a SymPy matrix of expressions."""
        return ImmutableMatrix([[entry.as_expr() for entry in row] for row in self.numerators])

    def to_control(self, dt: float | bool | None = None) -> "control.TransferFunction":
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
        import control  # slow to import, and only needed at this door

        below = [to_float(c) for c in self.denominator.all_coeffs()]
        above = [[[to_float(c) for c in n.all_coeffs()] for n in row] for row in self.numerators]
        time = time_base(self.variable, self.sample_time, dt)
        return control.TransferFunction(above, [[below] * self.shape[1]] * self.shape[0], time)

    def __str__(self) -> str:
        rows = ["[" + ", ".join(map(format_polynomial, row)) + "]" for row in self.numerators]
        return f"[{', '.join(rows)}]/({format_polynomial(self.denominator)})"

    def __repr__(self) -> str:
        return f"TransferMatrix({self})"

    def _repr_latex_(self) -> str:
        return displayed(rf"{fraction(1, self.denominator)}\, {table(self.numerators)}")
