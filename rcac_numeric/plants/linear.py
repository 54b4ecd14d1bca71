"""Plants in the form of the standard problem (2.1)-(2.3), in float64."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import Read, instance_of, integer, matrix, real_array, rounded
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.simulator import Simulator

if TYPE_CHECKING:
    from sympy import Poly

    from compensator_theory import StandardProblem


@dataclass(frozen=True, eq=False)
class Plant:
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

    Examples
    --------
    >>> from rcac_numeric import Plant
    >>> plant = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[2.0]])
    >>> plant
    Plant(n=1, l_u=1, l_w=1, l_y=1, l_z=1)
    """

    A: Read
    B: Read
    D_1: Read
    C: Read
    D_0: Read = None
    D_2: Read = None
    E_1: Read = None
    E_2: Read = None
    E_0: Read = None
    blocks: Mapping[str, int] = field(default_factory=dict)
    exact: StandardProblem | None = None

    def __post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        A = matrix(self.A, "A", (None, None))
        n = A.shape[0]
        set_("A", matrix(A, "A", (n, n)))
        set_("B", matrix(self.B, "B", (n, None)))
        set_("D_1", matrix(self.D_1, "D_1", (n, None)))
        set_("C", matrix(self.C, "C", (None, n)))
        set_("E_1", self.C if self.E_1 is None else matrix(self.E_1, "E_1", (None, n)))
        rows = {"D_0": self.l_y, "D_2": self.l_y, "E_2": self.l_z, "E_0": self.l_z}
        columns = {"D_0": self.l_u, "D_2": self.l_w, "E_2": self.l_u, "E_0": self.l_w}
        for name, l_rows in rows.items():
            value = getattr(self, name)
            shape = (l_rows, columns[name])
            set_(name, np.zeros(shape) if value is None else matrix(value, name, shape))
        set_("blocks", blocks_of_w(self.blocks, self.l_w))

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
    def channels(self) -> list[str]:
        """Names of the channels of w, numbered from 1 where a block has several."""
        return [
            name if width == 1 else f"{name}{i + 1}"
            for name, width in self.blocks.items()
            for i in range(width)
        ]

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return int(self.C.shape[0])

    @property
    def l_z(self) -> int:
        """Number of performance variables."""
        return int(self.E_1.shape[0])

    @cached_property
    def problem(self) -> StandardProblem:
        """The exact standard problem; float64 entries mean their shortest decimals."""
        if self.exact is not None:
            return self.exact
        from compensator_theory import StandardProblem

        return StandardProblem(**{name: getattr(self, name).tolist() for name in MATRICES})

    def scalar_map(self, name: str) -> tuple[Poly, Poly]:
        """Numerator and common denominator det(qI - A) of G_zu, G_yu, ...; scalar maps only."""
        sizes = {"z": self.l_z, "y": self.l_y, "u": self.l_u}
        for letter in name:
            if letter in sizes and sizes[letter] != 1:
                raise InputError(
                    f"G_{name} is not scalar: l_{letter} = {sizes[letter]}. Polynomials exist "
                    "for scalar maps; pass the modelling information or a TargetModel yourself."
                )
        return self.problem.numerator(name), self.problem.denominator

    def simulator(self, x_0: ArrayLike | None = None) -> Simulator:
        """A compiled copy of the plant for a loop in Python."""
        return Simulator(self.compiled(x_0), self.l_u, self.l_w)

    def compiled(self, x_0: ArrayLike | None = None) -> _kernel.Plant:
        """The plant for the kernel."""
        matrices = [getattr(self, name) for name in MATRICES]
        segments = [(0, matrices, False, np.zeros(0), 0)]
        sizes = (self.n, self.l_u, self.l_w, self.l_y, self.l_z)
        return _kernel.linear_plant(sizes, segments, initial_state(x_0, self.n))

    @property
    def y_needs_u(self) -> bool:
        """Whether y(k) depends on u(k)."""
        return bool(np.any(self.D_0))

    @property
    def z_needs_u(self) -> bool:
        """Whether z(k) depends on u(k)."""
        return bool(np.any(self.E_2))

    def __repr__(self) -> str:
        sizes = (f"{name}={getattr(self, name)}" for name in ("n", "l_u", "l_w", "l_y", "l_z"))
        return f"Plant({', '.join(sizes)})"


def blocks_of_w(blocks: Any, l_w: int) -> dict[str, int]:
    """How w is divided; one block "w" where nothing is said."""
    given = instance_of(blocks, "blocks", Mapping)
    read = {
        instance_of(name, "the name of a block", str): integer(width, f"the width of {name!r}")
        for name, width in given.items()
    } or {"w": l_w}
    if sum(read.values()) != l_w:
        raise InputError(f"the blocks {read} of w do not add up to l_w = {l_w}.")
    return read


def initial_state(x_0: Any, n: int) -> Array:
    """x(0) as an array of n entries; zero where it is left out."""
    start = np.zeros(n) if x_0 is None else real_array(x_0, "x_0").reshape(-1)
    if start.size != n:
        raise InputError(f"x_0 has {start.size} entries; the plant has {n} states.")
    return start


MATRICES = tuple(f.name for f in fields(Plant) if f.name not in ("blocks", "exact"))


def from_problem(problem: StandardProblem, blocks: Mapping[str, int] | None = None) -> Plant:
    """An exact standard problem, each entry rounded once to float64."""
    matrices = {
        name: rounded(list(getattr(problem, name)), name).reshape(getattr(problem, name).shape)
        for name in MATRICES
    }
    return Plant(**matrices, blocks=dict(blocks or {}), exact=problem)


def standard_plant(G: Any) -> Plant:
    """The standard problem of a transfer function: y = z and w matched with u, (2.15).

    Parameters
    ----------
    G : anything `compensator_theory.transfer_function` accepts
        Strictly proper or exactly proper, in q or z.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))")
    Plant(n=2, l_u=1, l_w=1, l_y=1, l_z=1)
    """
    from compensator_theory import standard_problem

    return from_problem(_discrete(standard_problem(G)))


def servo_plant(G: Any = None, **matrices: Any) -> Plant:
    """The servo problem (2.16)-(2.27) of a transfer function (d and u colocated) or of matrices.

    Parameters
    ----------
    G : transfer function, optional
        Anything `compensator_theory.transfer_function` accepts.
    **matrices
        A, B, D_1, C and D_0 of (2.16)-(2.17) in place of G; and
        performance="measured" (z = e_n, the default) or "true" (z = e_0).

    Returns
    -------
    Plant
        With w = [r; d; v] and y = e_n.

    Examples
    --------
    >>> from rcac_numeric import servo_plant
    >>> servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))").blocks
    {'r': 1, 'd': 1, 'v': 1}
    """
    from compensator_theory import servo_problem

    problem = _discrete(servo_problem(G, **matrices))
    l_y = problem.C.shape[0]
    return from_problem(problem, {"r": l_y, "d": problem.D_1.shape[1] - 2 * l_y, "v": l_y})


def _discrete(problem: StandardProblem) -> StandardProblem:
    if str(problem.variable) not in ("q", "z"):
        raise InputError(
            f"the plant is a transfer function in {problem.variable}; RCAC runs in discrete time. "
            "Discretise it first, for example with control.c2d, and write it in q."
        )
    return problem
