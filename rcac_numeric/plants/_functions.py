"""Nonlinear plants: Python functions or compiled ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._any_plant import blocks_of_w

if TYPE_CHECKING:
    from scipy import LowLevelCallable

AdvanceFunction = Callable[[int, Array, Array, Array], ArrayLike]
OutputFunction = Callable[[int, Array, Array], tuple[ArrayLike, ArrayLike]]
ADVANCE = "int (int64_t, double *, double *, double *, double *, void *)"


@dataclass(frozen=True, eq=False, kw_only=True)
class FunctionPlant(Value):
    """A plant x(k+1) = f(k, x, u, w), y(k) and z(k) = h(k, x, w), given by two functions.

    u(k) acts on y and z through the state only.

    Parameters
    ----------
    advance : function or scipy.LowLevelCallable
        advance(k, x, u, w) returns x(k+1). Compiled:
        int advance(int64_t k, double* x, double* u, double* w, double* x_next, void* user_data).
    output : function or scipy.LowLevelCallable
        output(k, x, w) returns the pair (y, z). Compiled:
        int output(int64_t k, double* x, double* w, double* y, double* z, void* user_data).
        Compiled functions return 0; anything else ends the run. They see arrays of the sizes
        below and may run without the interpreter's lock.
    n, l_u, l_w, l_y, l_z : int
        Numbers of states, control inputs, exogenous inputs, measurements, performance variables.
    blocks : mapping from names to widths, optional
        How w is divided.

    Raises
    ------
    InputError
        Where a compiled function has another signature, or only one of the two is compiled.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import FunctionPlant
    >>> pendulum = FunctionPlant(
    ...     advance=lambda k, x, u, w: [x[0] + 0.1 * x[1],
    ...                                 x[1] - 0.1 * np.sin(x[0]) + 0.1 * (u[0] + w[0])],
    ...     output=lambda k, x, w: (x[:1], x[:1]),
    ...     n=2, l_u=1, l_w=1, l_y=1, l_z=1)
    >>> pendulum
    FunctionPlant(n=2, l_u=1, l_w=1, l_y=1, l_z=1, Python functions)
    """

    advance: AdvanceFunction | LowLevelCallable
    output: OutputFunction | LowLevelCallable
    n: int
    l_u: int
    l_w: int
    l_y: int
    l_z: int
    blocks: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, least in (("n", 0), ("l_u", 1), ("l_w", 0), ("l_y", 1), ("l_z", 1)):
            integer(getattr(self, name), name, at_least=least)
        object.__setattr__(self, "blocks", blocks_of_w(self.blocks, self.l_w))
        compiled = [_is_compiled(self.advance), _is_compiled(self.output)]
        if any(compiled) and not all(compiled):
            raise InputError("advance and output must both be compiled, or both Python functions.")
        for name in ("advance", "output"):
            function = getattr(self, name)
            if all(compiled):
                _require_signature(function, name)
            elif not callable(function):
                raise InputError(f"{name} = {function!r} is not a function.")

    @property
    def is_compiled(self) -> bool:
        """Whether the functions are compiled."""
        return _is_compiled(self.advance)

    @property
    def y_needs_u(self) -> bool:
        """False: u(k) acts through the state."""
        return False

    @property
    def z_needs_u(self) -> bool:
        """False: u(k) acts through the state."""
        return False

    def __repr__(self) -> str:
        kind = "compiled" if self.is_compiled else "Python functions"
        return (
            f"FunctionPlant(n={self.n}, l_u={self.l_u}, l_w={self.l_w}, l_y={self.l_y}, "
            f"l_z={self.l_z}, {kind})"
        )


def _is_compiled(function: object) -> bool:
    from scipy import LowLevelCallable  # imported here: only plants given by functions need SciPy

    return isinstance(function, LowLevelCallable)


def _require_signature(function: LowLevelCallable, name: str) -> None:
    """Raise unless the function takes a step, four arrays and user data, and returns an int."""
    signature = function.signature.replace(" ", "")
    steps = ("int64_t", "long", "longlong", "int64")
    if signature not in {ADVANCE.replace(" ", "").replace("int64_t", step) for step in steps}:
        raise InputError(
            f"the compiled {name} has the signature {function.signature!r}; {ADVANCE!r} is needed."
        )
