"""Symbols stand for real numbers: one that is declared otherwise is refused, wherever it comes."""

import pytest
import sympy
from sympy import Basic, Matrix, MatrixBase, Poly, Symbol

import compensator_theory as exact
from tests.support.bad_inputs import GOOD, NOT_DOORS
from tests.support.symbolic_inputs import PUBLIC, calls

NAME = "d_user"
KINDS = [
    {"imaginary": True}, {"complex": True, "real": False}, {"extended_real": False},
    {"commutative": False},
]  # fmt: skip


def declared(value, symbol):
    """The same with the symbol of that name in SymPy's objects instead of texts."""
    if isinstance(value, str) and NAME in value:
        return declared(exact.parse_expression(value), symbol)
    if isinstance(value, Poly):
        return declared(value.as_expr(), symbol)
    if isinstance(value, exact.Realisation):
        matrices = (Matrix(m).subs(Symbol(NAME), symbol) for m in value.matrices)
        return exact.Realisation(*matrices, variable=value.variable)
    if isinstance(value, Basic | MatrixBase):
        return value.subs(Symbol(NAME), symbol)
    if type(value) in (list, tuple):
        return type(value)(declared(part, symbol) for part in value)
    return value


@pytest.mark.parametrize("name", sorted(set(GOOD) - NOT_DOORS - {"parse_expression"}))
def test_a_symbol_that_is_not_real_is_refused(name):
    for call, _ in calls(name):
        answer = call(NAME)
        if answer is None:
            continue
        for kind in KINDS:
            symbol = Symbol(NAME, **kind)
            with pytest.raises(exact.CompensatorError):
                PUBLIC[name](*declared(answer[0], symbol), **answer[1])
        return


def test_a_variable_may_be_complex():
    s = Symbol("s", complex=True)
    assert exact.decide_stability(s + 1, s).is_stable
    with pytest.raises(exact.InputError, match="declared imaginary"):
        exact.place_poles(1 / (s + sympy.Symbol("d", imaginary=True)), [-1], feedback=-1)
