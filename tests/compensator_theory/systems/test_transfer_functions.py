"""Transfer functions keep what they are given."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from sympy.physics.control import TransferFunction as SympyTransferFunction

import compensator_theory as ct
from compensator_theory.errors import ImproperError
from compensator_theory.strategies import polynomials, strictly_proper_plants

s, a = sympy.symbols("s a")


@given(strictly_proper_plants(), polynomials(min_degree=1, max_degree=2, is_monic=True))
def test_common_factor_is_kept_until_it_is_removed(G, factor):
    H = ct.TransferFunction(G.numerator * factor, G.denominator * factor)
    assert H.order == G.order + factor.degree()
    assert H.common_factor() == factor
    assert H.reduced() == G
    assert (G.is_coprime, H.is_coprime) == (True, False)
    assert eval(repr(H), {"transfer_function": ct.transfer_function}) == H
    assert ct.standard_problem(H).transfer_function("zu") == H


def test_common_factors_in_text():
    assert ct.transfer_function("(s + 1)/((s + 1)*(s + 2))").order == 2
    assert ct.transfer_function("1/(s + 1) + 1/(s + 2)").order == 2
    assert ct.transfer_function("(q - 0.85)/((q - 0.8)*(q - 0.9))").zeros()[0].value == 0.85


@given(strictly_proper_plants(max_order=3))
def test_python_control_round_trip(G):
    system = G.to_control()
    point = 0.3 + 2.1j
    exact = complex(G.numerator.eval(point)) / complex(G.denominator.eval(point))
    assert system(point) == pytest.approx(exact, rel=1e-9)
    back = ct.transfer_function(system)
    for new, old in ((back.numerator, G.numerator), (back.denominator, G.denominator)):
        assert np.allclose(list(map(float, new.all_coeffs())), list(map(float, old.all_coeffs())))


def test_the_other_descriptions():
    expected = ct.transfer_function("(3*s + 0.3)/(s**2 + 0.2*s)")
    assert ct.transfer_function(([3, 0.3], [1, "1/5", 0]), "s") == expected
    assert ct.transfer_function(zeros=[-0.1], poles=[0, -0.2], gain=3, variable="s") == expected
    assert ct.transfer_function({"zeros": [-0.1], "poles": [0, -0.2], "gain": 3}, "s") == expected
    assert ct.transfer_function((3 * s + 0.3) / (s**2 + 0.2 * s)) == expected
    assert ct.transfer_function(SympyTransferFunction(30 * s + 3, 10 * s**2 + 2 * s, s)) == expected
    assert ct.transfer_function(control.tf([3, 0.3], [1, 0.2, 0])) == expected
    assert ct.transfer_function(expected) is expected
    sampled = control.ss([[0.1, 0.2], [0.3, 0.4]], [[1], [2]], [[1, 0]], [[0.5]], 0.1)
    assert str(ct.transfer_function(sampled)) == "(z**2/2 + 3*z/4 - 1/100)/(z**2 - z/2 - 1/50)"


@pytest.mark.parametrize(
    ("obj", "options"),
    [("1/(s*z)", {}), ("3", {}), (None, {}), ("s/(s - s)", {}), (([1], [0]), {"variable": "s"}),
     (([1], [1, float("nan")]), {"variable": "s"}), (None, {"zeros": [1], "variable": "s"}),
     (None, {"poles": [1]}), ("1/s", {"poles": [1]}), ({"pole": [1]}, {"variable": "s"}),
     (ct.transfer_function("1/s"), {"variable": "q"}), (control.tf([1], [1, 1], None), {}),
     (control.ss(np.eye(2), np.eye(2), np.eye(2), 0 * np.eye(2)), {}), ("sqrt(s)/(s + 1)", {})],
)  # fmt: skip
def test_refused(obj, options):
    with pytest.raises(ct.InputError):
        ct.transfer_function(obj, **options)


def test_predicates_and_undecided_ones():
    assert ct.transfer_function("s/(s + 1)").is_proper is True
    assert ct.transfer_function("s/(s + 1)").is_strictly_proper is False
    assert ct.transfer_function("s**2/(s + 1)").is_proper is False
    assert ct.transfer_function("(a*s**2 + 1)/(s + 1)", "s").is_proper is None
    assert ct.transfer_function("(s + a)/(s + 1)", "s").is_coprime is None
    assert ct.transfer_function("(s + a)/(s**2 + a*s)", "s").is_coprime is False
    p = sympy.Symbol("p", positive=True)
    assert ct.transfer_function(1 / (s + p), "s").is_coprime is True
    assert ct.transfer_function((s + p) / s, "s").is_coprime is True
    zero = ct.transfer_function("0/(s + 1)")
    assert (zero.is_strictly_proper, str(zero)) == (True, "(0)/(s + 1)")
    with pytest.raises(ct.InputError):
        _ = zero.relative_degree
    with pytest.raises(ct.InputError):
        ct.transfer_function("a/(s + 1)", "s").to_control()
    with pytest.raises(ImproperError):
        ct.standard_problem("s**2/(s + 1)")
    with pytest.raises(ct.InputError):
        ct.TransferFunction(ct.polynomial("s"), ct.polynomial("q"))


def test_latex_and_matrices():
    assert "frac" in ct.transfer_function("1/(s + 1)")._repr_latex_()
    p = ct.polynomial("s + 1")
    assert "begin" in ct.TransferMatrix(((p, p),), p)._repr_latex_()
    for rows in ((), ((),), ((p,), (p, p))):
        with pytest.raises(ct.InputError):
            ct.TransferMatrix(rows, p)
    with pytest.raises(ct.InputError):
        ct.TransferMatrix(((p, p),), p).scalar()


@pytest.mark.parametrize("text", ["1/s", "q", "2*s/q"])
def test_another_operator_alone_is_no_parameter(text):
    """1/s read in z was a static gain, and a placement around it fed nothing back."""
    with pytest.raises(ct.InputError, match="use one variable"):
        ct.transfer_function(text, "z")


@pytest.mark.parametrize("text", ["(z + s)/z**2", "z/(z + q)", "q*z"])
def test_beside_a_variable_that_was_named_another_letter_is_a_parameter(text):
    with pytest.raises(ct.InputError, match="not evident"):
        ct.transfer_function(text)
    renamed = ct.transfer_function(text.replace("s", "a").replace("q", "b"), "z")
    assert ct.transfer_function(text, "z") == renamed.subs(
        {name: {"a": "s", "b": "q"}[name] for name in "ab" if name in str(renamed)}
    )
    assert ct.transfer_function(text.replace("s", "a").replace("q", "b"), "z").variable.name == "z"
