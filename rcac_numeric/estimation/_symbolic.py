"""A model written in SymPy, with its Jacobians."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np
import sympy
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value
from rcac_numeric.estimation._any_model import places_of_angles

Function = Callable[[int, Array, Array], ArrayLike]


@attrs.frozen(eq=False, slots=False)
class SymbolicModel(Value):
    """x(k+1) = dynamics + noise, y(k) = output + noise, as SymPy expressions.

    The Jacobians are taken symbolically. Where the expressions hold arithmetic, powers, roots,
    exp, log, trigonometric and hyperbolic functions, Abs, sign, Min and Max, each step runs in the
    compiled kernel; else as functions that `sympy.lambdify` makes.

    Parameters
    ----------
    dynamics : sequence of SymPy expressions
        x(k+1), one for each state.
    output : sequence of SymPy expressions
        y(k).
    states : sequence of symbols
    inputs : sequence of symbols
        Known inputs u(k).
    parameters : sequence of symbols
        Unknown parameters; they are estimated jointly as the last entries of x.
    step : symbol, optional
        k, where the model depends on it.
    angles : sequence of int
        Which measurements are angles, in radians: their innovations go the shorter way round.

    Raises
    ------
    InputError
        Where a symbol has no value, stands twice, or something is no expression.

    Examples
    --------
    >>> import sympy
    >>> from rcac_numeric.estimation import SymbolicModel
    >>> q, v, kappa, w = sympy.symbols("q v kappa w")
    >>> model = SymbolicModel(  # (8.68) with an unknown stiffness
    ...     dynamics=[q + v / 10, v + (w - 5 * v - kappa * q) / 10], output=[v],
    ...     states=[q, v], inputs=[w], parameters=[kappa])
    >>> model.F[1, :]
    Matrix([[-kappa/10, 1/2, -q/10]])
    """

    dynamics: Sequence[sympy.Expr]
    output: Sequence[sympy.Expr]
    states: Sequence[sympy.Symbol]
    inputs: Sequence[sympy.Symbol] = ()
    parameters: Sequence[sympy.Symbol] = ()
    step: sympy.Symbol = None
    angles: Sequence[int] = ()

    def __attrs_post_init__(self) -> None:
        set_, step = partial(object.__setattr__, self), self.step
        for name in ("dynamics", "output"):
            set_(name, _expressions(getattr(self, name), name))
        set_("angles", places_of_angles(self.angles, len(self.output)))
        for name in ("states", "inputs", "parameters"):
            set_(name, _symbols(getattr(self, name), name))
        (symbol,) = _symbols([sympy.Symbol("k") if step is None else step], "step")
        set_("step", symbol)
        known = [*self.states, *self.parameters, *self.inputs]
        if self.step not in known:
            known.append(self.step)
        elif step is not None:
            raise InputError(f"the step {step} is also the name of a state or an input.")
        else:
            set_("step", sympy.Dummy("k"))
        twice = {s for s in known if known.count(s) > 1}
        if twice:
            raise InputError(f"{', '.join(map(str, twice))}: a symbol occurs twice in the model.")
        if not self.states or not self.output or len(self.dynamics) != len(self.states):
            raise InputError(
                f"{len(self.states)} states, {len(self.dynamics)} expressions in dynamics and "
                f"{len(self.output)} in output: at least one state and one output are needed, "
                "and one expression for each state."
            )
        free = set().union(*(e.free_symbols for e in (*self.dynamics, *self.output))) - set(known)
        if free:
            raise InputError(
                f"{', '.join(sorted(map(str, free)))} has no value: give a number for it, or name "
                "it among states, inputs or parameters."
            )

    @property
    def n(self) -> int:
        """Number of states and parameters."""
        return len(self.states) + len(self.parameters)

    @property
    def l_u(self) -> int:
        """Number of known inputs."""
        return len(self.inputs)

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return len(self.output)

    @property
    def names(self) -> tuple[str, ...]:
        """The symbols of states and parameters."""
        return tuple(map(str, self.x))

    @property
    def x(self) -> tuple[sympy.Symbol, ...]:
        """[x; p]."""
        return (*self.states, *self.parameters)

    @property
    def f(self) -> sympy.Matrix:
        """[x(k+1); p]."""
        return sympy.Matrix([*self.dynamics, *self.parameters])

    @property
    def h(self) -> sympy.Matrix:
        """y(k)."""
        return sympy.Matrix(list(self.output))

    @property
    def F(self) -> sympy.Matrix:
        """The Jacobian of f with respect to [x; p]."""
        return _jacobian(self.f, self.x)

    @property
    def H(self) -> sympy.Matrix:
        """The Jacobian of h with respect to [x; p]."""
        return _jacobian(self.h, self.x)

    def function(self, of: sympy.Matrix) -> Function:
        """An expression of this model as a Python function of (k, x, u), by `sympy.lambdify`.

        Parameters
        ----------
        of : sympy.Matrix
            `model.f`, `model.H`, or another one in the model's symbols.
        """
        rows: Any = [list(of.row(i)) for i in range(of.rows)]
        arguments = [self.step, self.x, self.inputs]
        try:
            function = sympy.lambdify(arguments, rows, modules=["numpy", "scipy"], cse=True)
        except NotImplementedError as error:
            raise InputError(
                f"SymPy cannot turn this model, or its derivative, into numbers: {error}. Write it "
                "in other functions, or as a NonlinearModel."
            ) from None

        def evaluated(k: int, x: Array, u: Array) -> ArrayLike:
            return np.array(function(k, x, u), dtype=float)

        return evaluated


def _jacobian(of: sympy.Matrix, x: tuple[sympy.Symbol, ...]) -> sympy.Matrix:
    """The derivative for real x, almost everywhere: of |x| the sign, at corners no impulses."""
    real = {s: sympy.Dummy(s.name, real=True) for s in of.free_symbols | set(x)}
    jacobian = of.xreplace(real).jacobian([real[s] for s in x])
    jacobian = jacobian.replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)
    jacobian = jacobian.replace(sympy.Heaviside, lambda at, *_: (1 + sympy.sign(at)) / 2)
    return jacobian.xreplace({dummy: symbol for symbol, dummy in real.items()})


def _expressions(values: Iterable[sympy.Expr], name: str) -> tuple[sympy.Expr, ...]:
    try:
        entries = list(values)
    except TypeError:
        raise InputError(f"{name} = {values!r} must be a list of SymPy expressions.") from None
    for entry in entries:
        number = isinstance(entry, int | float) and not isinstance(entry, bool)
        if not (number or isinstance(entry, sympy.Expr)):
            raise InputError(f"{name} holds {entry!r}, which is no SymPy expression.")
    read = tuple(map(sympy.sympify, entries))
    for entry in read:
        if entry.has(sympy.nan, sympy.zoo, sympy.oo, sympy.I):
            raise InputError(f"{name} holds {entry}, which is not a finite real expression.")
    return read


def _symbols(values: Iterable[sympy.Symbol], name: str) -> tuple[sympy.Symbol, ...]:
    entries = _expressions(values, name)
    for entry in entries:
        if not entry.is_Symbol:
            raise InputError(f"{name} holds {entry!r}, which is no symbol.")
    return entries
