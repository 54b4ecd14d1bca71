"""Linear plants in the form of the standard problem (2.1)-(2.3), in float64."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import attrs
import numpy as np

import compensator_theory
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._frames import StateSpace, control_state_space
from rcac_numeric.arrays._validation import (
    array_like,
    matrix,
    optional_array_like,
    positive_time,
    reads,
    require_dense,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import matrix_latex
from rcac_numeric.plants._any_plant import blocks_of_w

if TYPE_CHECKING:
    from sympy import Poly  # imported only for polynomials

MATRICES = ("A", "B", "D_1", "C", "D_0", "D_2", "E_1", "E_2", "E_0")


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
class Plant(Value):
    """The linear plant of the standard problem.

    x(k+1) = A x + B u + D_1 w,  y = C x + D_0 u + D_2 w,  z = E_1 x + E_2 u + E_0 w

    Parameters
    ----------
    A, B, D_1 : arrays of shape (n, n), (n, l_u), (n, l_w)
    C, D_0, D_2 : arrays of shape (l_y, n), (l_y, l_u), (l_y, l_w)
    E_1, E_2, E_0 : arrays of shape (l_z, n), (l_z, l_u), (l_z, l_w)
        D_0, D_2, E_2 and E_0 are zero and E_1 is C where they are left out.
    blocks : mapping from names to widths
        How w is divided, for example {"r": 1, "d": 1, "v": 1} for the servo problem.
    exact : compensator_theory.StandardProblem, optional
        What the matrices were rounded from.
    sample_time : float, optional
        In seconds, where one is known: controllers go out to other packages with it.

    Raises
    ------
    InputError
        Where a matrix has the wrong size or holds what is not a finite real number.

    Examples
    --------
    >>> from rcac_numeric import Plant
    >>> plant = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[2.0]])
    >>> plant
    Plant(n=1, l_u=1, l_w=1, l_y=1, l_z=1)
    """

    A: Array = attrs.field(converter=array_like)
    B: Array = attrs.field(converter=array_like)
    D_1: Array = attrs.field(converter=array_like)
    C: Array = attrs.field(converter=array_like)
    D_0: Array = attrs.field(default=None, converter=optional_array_like)
    D_2: Array = attrs.field(default=None, converter=optional_array_like)
    E_1: Array = attrs.field(default=None, converter=optional_array_like)
    E_2: Array = attrs.field(default=None, converter=optional_array_like)
    E_0: Array = attrs.field(default=None, converter=optional_array_like)
    blocks: Mapping[str, int] = attrs.field(factory=dict)
    exact: compensator_theory.StandardProblem | None = None
    sample_time: float | None = attrs.field(
        default=None, eq=False, metadata=reads(positive_time, optional=True)
    )

    def __attrs_post_init__(self) -> None:
        def read(name: str, rows: int | None, columns: int | None, default: Array) -> None:
            field_value = getattr(self, name)
            value = matrix(default if field_value is None else field_value, name, (rows, columns))
            object.__setattr__(self, name, value)

        none = np.zeros((0, 0))
        n = len(matrix(self.A, "A", (None, None)))
        for name, rows, columns in (("A", n, n), ("B", n, None), ("D_1", n, None), ("C", None, n)):
            read(name, rows, columns, none)
        read("E_1", None, n, self.C)
        for name, l_out, l_in in (
            ("D_0", self.l_y, self.l_u),
            ("D_2", self.l_y, self.l_w),
            ("E_2", self.l_z, self.l_u),
            ("E_0", self.l_z, self.l_w),
        ):
            read(name, l_out, l_in, np.zeros((l_out, l_in)))
        object.__setattr__(self, "blocks", blocks_of_w(self.blocks or {}, self.l_w))

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    @property
    def l_u(self) -> int:
        """Number of control inputs."""
        return int(self.B.shape[1])

    @property
    def l_w(self) -> int:
        """Number of exogenous inputs."""
        return int(self.D_1.shape[1])

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return int(self.C.shape[0])

    @property
    def l_z(self) -> int:
        """Number of performance variables."""
        return int(self.E_1.shape[0])

    @property
    def channels(self) -> list[str]:
        """Names of the channels of w, numbered from 1 where a block has several."""
        return [
            name if width == 1 else f"{name}{i + 1}"
            for name, width in self.blocks.items()
            for i in range(width)
        ]

    @property
    def y_needs_u(self) -> bool:
        """Whether y(k) depends on u(k)."""
        return bool(np.any(self.D_0))

    @property
    def z_needs_u(self) -> bool:
        """Whether z(k) depends on u(k)."""
        return bool(np.any(self.E_2))

    @cached_property
    def problem(self) -> compensator_theory.StandardProblem:
        """The exact standard problem; float64 entries mean their shortest decimals.

        Raises
        ------
        BudgetError
            Where the plant has more states than full matrices are computed for.
        """
        require_dense(self.n, "the plant")
        period = self.sample_time
        time = None if period is None else compensator_theory.exact_number(period)
        if self.exact is not None:
            known = time is None or self.exact.sample_time is not None
            return self.exact if known else replace(self.exact, sample_time=time)
        return compensator_theory.StandardProblem(
            **{name: getattr(self, name).tolist() for name in MATRICES},
            sample_time=time,
        )

    def to_control(self) -> StateSpace:
        """The python-control plant from [w; u] to [z; y], with the sample time of the plant."""
        B, C = np.hstack([self.D_1, self.B]), np.vstack([self.E_1, self.C])
        D = np.block([[self.E_0, self.E_2], [self.D_2, self.D_0]])
        return control_state_space(self.A, B, C, D, self.sample_time)

    def _repr_latex_(self) -> str:
        names = [name for name in MATRICES if getattr(self, name).any() or name in "ABC"]
        parts = (f"{name} = {matrix_latex(getattr(self, name))}" for name in names)
        joined = r",\; ".join(parts)
        return rf"$\displaystyle {joined}$"

    def scalar_map(self, name: str) -> tuple[Poly, Poly]:
        """Numerator and common denominator det(qI - A) of G_zu, G_yu, ...; scalar maps only."""
        sizes = {"z": self.l_z, "y": self.l_y, "u": self.l_u}
        for letter in name:
            if letter in sizes and sizes[letter] != 1:
                raise InputError(
                    f"G_{name} is not scalar: l_{letter} = {sizes[letter]}. Polynomials exist "
                    "for scalar maps; zero_direction_target and high_authority_target make targets "
                    "for several signals, or pass a TargetModel yourself."
                )
        return self.problem.numerator(name), self.problem.denominator

    def __repr__(self) -> str:
        sizes = (f"{name}={getattr(self, name)}" for name in ("n", "l_u", "l_w", "l_y", "l_z"))
        return f"Plant({', '.join(sizes)})"
