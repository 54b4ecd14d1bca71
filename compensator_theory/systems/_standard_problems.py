"""The standard problem (2.1)-(2.3) with exact data, its open-loop maps, and the usual ones."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from sympy import ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import InputError
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import identity_matrix, symbols_in, zero_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._variables import as_symbol, require_one_symbol_a_name
from compensator_theory.systems._sample_times import (
    System,
    control_state_space,
    period_in,
    time_base,
)
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

if TYPE_CHECKING:
    import control

from typing import Literal

import sympy

from compensator_theory.errors import ImproperError
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._state_space import controllable_canonical_form

CHANNELS = ("zw", "zu", "yw", "yu")
_SHAPES = {
    "A": ("n", "n"),
    "B": ("n", "l_u"),
    "C": ("l_y", "n"),
    "D_1": ("n", "l_w"),
    "D_0": ("l_y", "l_u"),
    "D_2": ("l_y", "l_w"),
    "E_1": ("l_z", "n"),
    "E_2": ("l_z", "l_u"),
    "E_0": ("l_z", "l_w"),
}
_DIMENSIONS = {
    "n": ("A", 0),
    "l_u": ("B", 1),
    "l_y": ("C", 0),
    "l_w": ("D_1", 1),
    "l_z": ("E_1", 0),
}


@dataclass(frozen=True, init=False)
class StandardProblem(System):
    r"""A linear time-invariant plant with control, exogenous input, measurement, performance.

    .. math::
        x(k+1) &= A x(k) + B u(k) + D_1 w(k) \\
        y(k) &= C x(k) + D_0 u(k) + D_2 w(k) \\
        z(k) &= E_1 x(k) + E_2 u(k) + E_0 w(k)

    Parameters
    ----------
    A, B, C, D_1, D_0, D_2, E_1, E_2, E_0 : matrix
        n x n, n x l_u, l_y x n, n x l_w, l_y x l_u, l_y x l_w, l_z x n, l_z x l_u, l_z x l_w;
        nested lists, arrays or SymPy matrices, read by :func:`exact_number`. None for one of the
        direct terms D_0, D_2, E_2, E_0 means zero.
    variable : str or Symbol
        Name of the forward shift in the maps; default ``q``.
    sample_time : number, optional
        As of :class:`TransferFunction`.

    Raises
    ------
    InputError
        If the shapes do not fit; the message names the matrix.

    Notes
    -----
    Loops are closed with positive feedback, :math:`u = G_c y`. The maps (2.6), (2.7) keep the
    unreduced denominator :math:`D = \det(qI - A)`, so that hidden modes stay visible.
    Source: (2.1)-(2.11).

    Examples
    --------
    >>> from compensator_theory import StandardProblem
    >>> P = StandardProblem(A=[["1/2"]], B=[[2]], C=[[1]], D_1=[[1]], D_0=None, D_2=None,
    ...                     E_1=[[3]], E_2=None, E_0=None)
    >>> print(P.transfer_function("zu"), P.transfer_function("yw"))
    (6)/(q - 1/2) (1)/(q - 1/2)
    """

    _REST: ClassVar[str] = ".D_1, .D_0, .D_2, .E_1, .E_2 and .E_0 are matrices"
    A: ImmutableMatrix
    B: ImmutableMatrix
    C: ImmutableMatrix
    D_1: ImmutableMatrix
    D_0: ImmutableMatrix
    D_2: ImmutableMatrix
    E_1: ImmutableMatrix
    E_2: ImmutableMatrix
    E_0: ImmutableMatrix
    variable: Symbol
    sample_time: Rational | None = None

    def __init__(
        self,
        A: MatrixLike,
        B: MatrixLike,
        C: MatrixLike,
        D_1: MatrixLike,
        D_0: MatrixLike | None,
        D_2: MatrixLike | None,
        E_1: MatrixLike,
        E_2: MatrixLike | None,
        E_0: MatrixLike | None,
        variable: str | Symbol = "q",
        sample_time: NumberLike | None = None,
    ) -> None:
        symbol = as_symbol(variable)
        object.__setattr__(self, "sample_time", period_in(symbol, sample_time))
        object.__setattr__(self, "variable", symbol)
        matrices = {
            "A": A, "B": B, "C": C, "D_1": D_1, "D_0": D_0, "D_2": D_2, "E_1": E_1, "E_2": E_2,
            "E_0": E_0,
        }  # fmt: skip
        exact = {k: exact_matrix(v, k) for k, v in matrices.items() if v is not None}
        missing = [k for k in ("A", "B", "C", "D_1", "E_1") if k not in exact]
        if missing:
            raise InputError(f"the plant lacks {', '.join(missing)}; only D_0, D_2, E_2, E_0 may")
        sizes = {size: exact[name].shape[axis] for size, (name, axis) in _DIMENSIONS.items()}
        for name, symbolic in _SHAPES.items():
            shape = (sizes[symbolic[0]], sizes[symbolic[1]])
            matrix = exact.setdefault(name, zero_matrix(*shape))
            if matrix.shape != shape:
                raise InputError(
                    f"{name} is {matrix.rows} x {matrix.cols} but must be {shape[0]} x {shape[1]} "
                    f"({symbolic[0]} x {symbolic[1]}, as the other matrices show)"
                )
            if symbol in symbols_in(matrix):
                raise InputError(f"{name} contains {symbol}, the name of the shift operator")
            object.__setattr__(self, name, matrix)
        require_one_symbol_a_name({symbol}.union(*map(symbols_in, exact.values())))

    @property
    def n(self) -> int:
        """Order of the plant."""
        return int(self.A.rows)

    @property
    def l_u(self) -> int:
        """Number of control inputs."""
        return int(self.B.cols)

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return int(self.C.rows)

    @property
    def l_w(self) -> int:
        """Number of exogenous inputs."""
        return int(self.D_1.cols)

    @property
    def l_z(self) -> int:
        """Number of performance variables."""
        return int(self.E_1.rows)

    @property
    def denominator(self) -> Poly:
        """Unreduced denominator D = det(qI - A) of the four maps."""
        return characteristic_polynomial(self.A, self.variable)

    def transfer_matrix(self, channel: str) -> TransferMatrix:
        """Return the open-loop map of a channel, one of "zw", "zu", "yw", "yu", as in (2.6)."""
        if channel not in CHANNELS:
            raise InputError(
                f"there is no channel {repr_of(channel)}; choose one of {', '.join(CHANNELS)}"
            )
        if channel not in self._transfer_matrices:
            self._transfer_matrices[channel] = self._transfer_matrix(channel)
        return self._transfer_matrices[channel]

    @cached_property
    def _transfer_matrices(self) -> dict[str, TransferMatrix]:
        """The maps that were computed."""
        return {}

    def _transfer_matrix(self, channel: str) -> TransferMatrix:
        output, inputs = {"z": self.E_1, "y": self.C}, {"w": self.D_1, "u": self.B}
        direct = {"zw": self.E_0, "zu": self.E_2, "yw": self.D_2, "yu": self.D_0}
        return transfer_matrix_of_realisation(
            self.A, inputs[channel[1]], output[channel[0]], direct[channel], self.variable,
            self.sample_time,
        )  # fmt: skip

    @property
    def G_zw(self) -> TransferMatrix:
        """Map from w to z, (2.6)."""
        return self.transfer_matrix("zw")

    @property
    def G_zu(self) -> TransferMatrix:
        """Map from u to z, (2.6)."""
        return self.transfer_matrix("zu")

    @property
    def G_yw(self) -> TransferMatrix:
        """Map from w to y, (2.7)."""
        return self.transfer_matrix("yw")

    @property
    def G_yu(self) -> TransferMatrix:
        """Map from u to y, (2.7)."""
        return self.transfer_matrix("yu")

    def transfer_function(
        self, channel: str, row: int | None = None, column: int | None = None
    ) -> TransferFunction:
        """Return one entry of an open-loop map; row and column may be left out if it is scalar."""
        matrix = self.transfer_matrix(channel)
        if row is None and column is None:
            return matrix.scalar()
        rows, columns = matrix.shape
        row, column = row or 0, column or 0
        if not (0 <= row < rows and 0 <= column < columns):
            raise InputError(
                f"G_{channel} is {rows} x {columns}; it has no entry [{row}, {column}]"
            )
        return matrix[row, column]

    def numerator(self, channel: str, row: int | None = None, column: int | None = None) -> Poly:
        """Return one entry of N_zw, N_zu, N_yw or N_yu of (2.10), over :attr:`denominator`."""
        return self.transfer_function(channel, row, column).numerator

    def to_control(self, dt: float | bool | None = None) -> control.StateSpace:
        """Return the python-control plant from [w; u] to [z; y], rounded once to float64.

        Parameters
        ----------
        dt : float or bool, optional
            As for :meth:`TransferFunction.to_control`.
        """
        B = self.D_1.row_join(self.B)
        C = self.E_1.col_join(self.C)
        D = self.E_0.row_join(self.E_2).col_join(self.D_2.row_join(self.D_0))
        time = time_base(self.variable, self.sample_time, dt)
        return control_state_space(self.A, B, C, D, time)

    def __str__(self) -> str:
        lines = [f"n={self.n}, l_u={self.l_u}, l_y={self.l_y}, l_w={self.l_w}, l_z={self.l_z}"]
        names = [f.name for f in fields(self) if f.name in _SHAPES]
        return "\n".join(lines + [matrix_line(name, getattr(self, name)) for name in names])

    def _repr_latex_(self) -> str:
        return displayed(*(f"{name} = {latex(getattr(self, name))}" for name in _SHAPES))


_SERVO_MATRICES = ("A", "B", "D_1", "C", "D_0")


@holds_where_defined
@carrying()
def standard_problem(
    G: TransferFunctionLike, variable: str | Symbol | None = None
) -> StandardProblem:
    r"""Make the SISO plant whose measurement is its performance and whose disturbance is matched.

    .. math:: G = G_{zw} = G_{yw} = G_{zu} = G_{yu} = N/D

    Parameters
    ----------
    G : transfer function
        Proper; anything :func:`transfer_function` reads.
    variable : str or Symbol, optional
        Variable of G.

    Returns
    -------
    StandardProblem
        In controllable canonical form; a common factor of N and D stays in it.

    Raises
    ------
    ImproperError
        If G is improper.

    Notes
    -----
    Source: (2.15).

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> plant = standard_problem("(q - 0.5)/(q**2 - 1)")
    >>> plant.numerator("zu"), plant.denominator
    (Poly(q - 1/2, q, domain='QQ'), Poly(q**2 - 1, q, domain='QQ'))
    """
    plant = transfer_function(G, variable)
    A, B, C, D = controllable_canonical_form(plant)
    return StandardProblem(A, B, C, B, D, D, C, D, D, plant.variable, plant.sample_time)


@holds_where_defined
@carrying()
def servo_problem(
    G: TransferFunctionLike | None = None,
    variable: str | Symbol | None = None,
    *,
    A: MatrixLike | None = None,
    B: MatrixLike | None = None,
    D_1: MatrixLike | None = None,
    C: MatrixLike | None = None,
    D_0: MatrixLike | None = None,
    performance: Literal["measured", "true"] = "measured",
    sample_time: NumberLike | None = None,
) -> StandardProblem:
    r"""Make the servo problem with :math:`w = (r, d, v)` and measurement :math:`e_n`.

    .. math::
        x(k+1) = A x + B u + \bar D_1 d, \quad y_0 = \bar C x + \bar D_0 u, \quad
        e_0 = r - y_0, \quad e_n = e_0 - v

    Parameters
    ----------
    G : transfer function, optional
        Strictly proper SISO plant, with the disturbance at the plant's input.
    A, B, D_1, C, D_0 : matrix, optional
        Instead of G; D_1 defaults to B (colocated), D_0 to zero.
    performance : {"measured", "true"}
        Whether z is :math:`e_n`, the signal available to an adaptive controller, or :math:`e_0`.
    variable : str or Symbol, optional
        Variable of G, or of the maps (default q).
    sample_time : number, optional
        In seconds, in discrete time; default: that of G.

    Returns
    -------
    StandardProblem
        With :math:`C = E_1 = -\bar C`, :math:`D_0 = E_2 = -\bar D_0`,
        :math:`D_2 = [I\ 0\ {-I}]`, and :math:`E_0 = D_2` or :math:`[I\ 0\ 0]`.

    Raises
    ------
    ImproperError
        If G is not strictly proper.
    InputError
        If the data are incomplete or their shapes do not fit.

    Notes
    -----
    Source: (2.16)-(2.27). Erratum: (2.26) prints :math:`E_0 = [I\ 0\ 0]`, and (2.27) the
    corresponding :math:`G_{zw}`, which belong to :math:`z = e_0`; (2.24) defines
    :math:`z = e_n`, for which :math:`E_0 = [I\ 0\ {-I}]`. The default follows (2.24).

    Examples
    --------
    >>> from compensator_theory import servo_problem
    >>> servo = servo_problem("1/(q - 0.5)")
    >>> servo.E_0, servo_problem("1/(q - 0.5)", performance="true").E_0
    (Matrix([[1, 0, -1]]), Matrix([[1, 0, 0]]))
    >>> print(servo.transfer_function("zu"))
    (-1)/(q - 1/2)
    """
    if not is_one_of(performance, ("measured", "true")):
        raise InputError(f"performance is 'measured' or 'true', not {repr_of(performance)}")
    inputs = dict(zip(_SERVO_MATRICES, (A, B, D_1, C, D_0), strict=True))
    if G is not None:
        if any(value is not None for value in inputs.values()):
            raise InputError("give either a transfer function or matrices, not both")
        plant = transfer_function(G, variable, sample_time=sample_time)
        if not plant.is_strictly_proper:
            raise ImproperError(
                f"the plant {plant} is not strictly proper, so that a disturbance at its input "
                "does not reach the output as u does; give the matrices A, B, D_1, C, D_0"
            )
        inputs["A"], inputs["B"], inputs["C"], _ = controllable_canonical_form(plant)
        variable, sample_time = plant.variable, plant.sample_time
    missing = [name for name in ("A", "B", "C") if inputs[name] is None]
    if missing:
        raise InputError(f"the servo problem lacks {', '.join(missing)}; D_1 and D_0 are optional")
    matrices = {k: exact_matrix(v, k) for k, v in inputs.items() if v is not None}
    matrices.setdefault("D_1", matrices["B"])
    l_y, l_u = matrices["C"].rows, matrices["B"].cols
    matrices.setdefault("D_0", zero_matrix(l_y, l_u))
    symbol = "q" if variable is None else variable
    return _servo(matrices, performance, symbol, sample_time)


def _servo(
    matrices: dict[str, ImmutableMatrix],
    performance: str,
    variable: str | Symbol,
    sample_time: NumberLike | None,
) -> StandardProblem:
    A, D_1, C, D_0 = (matrices[name] for name in ("A", "D_1", "C", "D_0"))
    l_y, l_d = C.rows, D_1.cols
    if D_1.rows != A.rows:
        raise InputError(f"D_1 has {D_1.rows} rows but the plant has {A.rows} states")
    identity, no_command = identity_matrix(l_y), sympy.zeros(A.rows, l_y)
    no_disturbance = sympy.zeros(l_y, l_d)
    measured = sympy.Matrix.hstack(identity, no_disturbance, -identity)
    true = sympy.Matrix.hstack(identity, no_disturbance, sympy.zeros(l_y, l_y))
    return StandardProblem(
        A=A,
        B=matrices["B"],
        C=-C,
        D_1=sympy.Matrix.hstack(no_command, D_1, no_command),
        D_0=-D_0,
        D_2=measured,
        E_1=-C,
        E_2=-D_0,
        E_0=measured if performance == "measured" else true,
        variable=variable,
        sample_time=sample_time,
    )
