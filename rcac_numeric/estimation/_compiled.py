"""Conversion of models to the kernel's form.

A new kind of model is registered here: `@compiled_model.register(YourModel)`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from typing import Any

import numpy as np
import sympy

from compensator_theory.errors import InputError
from rcac_numeric.compiled._estimators import (
    EstimationModel,
    Tape,
    function_estimation_model,
    linear_estimation_model,
    tape_estimation_model,
)
from rcac_numeric.estimation._linear import LinearModel
from rcac_numeric.estimation._nonlinear import NonlinearModel
from rcac_numeric.estimation._symbolic import SymbolicModel


@singledispatch
def compiled_model(model: object) -> EstimationModel:
    """The model for the kernel."""
    kinds = [kind.__name__ for kind in compiled_model.registry if kind is not object]
    raise InputError(f"model = {model!r} is not a {' or '.join(kinds)}.")


@compiled_model.register(LinearModel)
def _(model: LinearModel) -> EstimationModel:
    compiled_model = linear_estimation_model(
        model.n, model.l_u, model.l_y, model.A, model.B, model.C, model.D
    )
    return _with_angles(compiled_model, model)


@compiled_model.register(NonlinearModel)
def _(model: NonlinearModel) -> EstimationModel:
    compiled_model = function_estimation_model(
        model.n,
        model.l_u,
        model.l_y,
        model.joint_dynamics if model.l_p else model.dynamics,
        model.joint_output if model.l_p else model.output,
        None if model.dynamics_jacobian is None else model.joint_dynamics_jacobian,
        None if model.output_jacobian is None else model.joint_output_jacobian,
        model.residual,
        model.scale,
    )
    return _with_angles(compiled_model, model)


@compiled_model.register(SymbolicModel)
def _(model: SymbolicModel) -> EstimationModel:
    f, h, F, H = model.f, model.h, model.F, model.H
    arguments = [*model.x, *model.inputs, model.step]
    sizes = model.n, model.l_u, model.l_y
    try:
        compiled_model = tape_estimation_model(
            *sizes,
            tape(f, arguments),
            tape(h, arguments),
            tape([*f, *F], arguments),
            tape([*h, *H], arguments),
        )
    except NoTapeError:  # Piecewise, special functions: Python calls for each step
        f_, h_, F_, H_ = map(model.function, (f, h, F, H))
        compiled_model = function_estimation_model(*sizes, f_, h_, F_, H_, None, np.ones(model.n))
    return _with_angles(compiled_model, model)


def _with_angles(
    compiled_model: EstimationModel, model: LinearModel | NonlinearModel | SymbolicModel
) -> EstimationModel:
    if model.angles:
        compiled_model.set_angles([place in model.angles for place in range(model.l_y)])
    return compiled_model


# SymPy expressions as a list of operations on registers, which the kernel runs without Python.

# The order is that of `Operation` in kernel/estimation/tape.hpp.
NAMES = (
    *("Add", "Sub", "Mul", "Div", "Pow", "Neg", "sqrt", "exp", "log", "sin", "cos", "tan"),
    *("asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "Abs", "sign", "Min", "Max"),
)
OPERATIONS = {name: number for number, name in enumerate(NAMES)}
SMALL_POWERS = range(2, 9)


class NoTapeError(Exception):
    """An expression contains an operation that the kernel does not have."""


class Writer:
    """Writes steps; registers are constants, x, u, k and then the result of each step.

    While writing, a register is ("constant", i), ("input", i) or ("step", i): how many constants
    there are is known at the end.
    """

    def __init__(self, symbols: Sequence[sympy.Symbol]) -> None:
        self.constants: dict[float, int] = {}
        self.places: dict[Any, tuple[str, int]] = {s: ("input", i) for i, s in enumerate(symbols)}
        self.steps: list[tuple[str, tuple[str, int], tuple[str, int]]] = []
        self.inputs = len(symbols)

    def constant(self, value: float) -> tuple[str, int]:
        """The register of a constant."""
        return "constant", self.constants.setdefault(value, len(self.constants))

    def step(self, name: str, a: tuple[str, int], b: tuple[str, int]) -> tuple[str, int]:
        """The register of one operation's result."""
        self.steps.append((name, a, b))
        return "step", len(self.steps) - 1

    def place(self, expression: Any) -> tuple[str, int]:
        """Return the register of an expression, and write it if it is new."""
        if expression not in self.places:
            self.places[expression] = self.written(expression)
        return self.places[expression]

    def written(self, expression: Any) -> tuple[str, int]:
        """Write a new expression and return its register."""
        if expression.is_number:
            try:
                return self.constant(float(expression))
            except (TypeError, ValueError, OverflowError):
                raise NoTapeError(str(expression)) from None
        if expression.is_Symbol:
            raise NoTapeError(str(expression))
        if expression.is_Add or expression.is_Mul:
            return self.chained(expression)
        if expression.is_Pow:
            return self.power(*expression.as_base_exp())
        name, arguments = expression.func.__name__, expression.args
        if name not in OPERATIONS:
            raise NoTapeError(name)
        if name in ("Min", "Max"):
            place = self.place(arguments[0])
            for other in arguments[1:]:
                place = self.step(name, place, self.place(other))
            return place
        operands = [self.place(argument) for argument in arguments]
        return self.step(name, operands[0], operands[-1])

    def chained(self, expression: Any) -> tuple[str, int]:
        """Sums and products, with differences and quotients where they are."""
        if expression.is_Mul and expression.args[0] == -1:
            place = self.place(expression.func(*expression.args[1:]))
            return self.step("Neg", place, place)
        forward, inverse = ("Add", "Sub") if expression.is_Add else ("Mul", "Div")
        plain, inverted = [], []
        for term in expression.args:
            if expression.is_Add and term.could_extract_minus_sign():
                inverted.append(-term)
            elif expression.is_Mul and term.is_Pow and term.exp.could_extract_minus_sign():
                inverted.append(1 / term)
            else:
                plain.append(term)
        start = self.place(plain[0]) if plain else self.constant(float(forward == "Mul"))
        for term in plain[1:]:
            start = self.step(forward, start, self.place(term))
        for term in inverted:
            start = self.step(inverse, start, self.place(term))
        return start

    def power(self, base: Any, exponent: Any) -> tuple[str, int]:
        """Powers, small ones as products: x*x is rounded once."""
        if exponent.could_extract_minus_sign():
            return self.step("Div", self.constant(1.0), self.place(base**-exponent))
        if base == sympy.E:
            operand = self.place(exponent)
            return self.step("exp", operand, operand)
        operand = self.place(base)
        if exponent == sympy.Rational(1, 2):
            return self.step("sqrt", operand, operand)
        if exponent.is_Integer and int(exponent) in SMALL_POWERS:
            place = operand
            for _ in range(int(exponent) - 1):
                place = self.step("Mul", place, operand)
            return place
        return self.step("Pow", operand, self.place(exponent))


def tape(expressions: Sequence[Any], arguments: Sequence[sympy.Symbol]) -> Tape:
    """The tape that computes the expressions from the given symbols."""
    real = {symbol: sympy.Dummy(symbol.name, real=True) for symbol in arguments}
    written = [expression.xreplace(real).doit() for expression in expressions]  # |e^x| is e^x
    writer = Writer(list(real.values()))
    shared, reduced = sympy.cse(written)
    for symbol, part in shared:
        writer.places[symbol] = writer.place(part)
    results = [writer.place(expression) for expression in reduced]
    count = len(writer.constants)
    first = {"constant": 0, "input": count, "step": count + writer.inputs}
    steps = [
        (OPERATIONS[name], first[a[0]] + a[1], first[b[0]] + b[1]) for name, a, b in writer.steps
    ]
    return (
        np.array(list(writer.constants), dtype=float),
        np.array(steps, dtype=np.int32).reshape(-1, 3),
        np.array([first[kind] + i for kind, i in results], dtype=np.int32),
    )
