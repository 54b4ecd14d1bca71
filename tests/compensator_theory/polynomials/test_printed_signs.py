"""Texts that were copied from a printed page: their signs are those that a keyboard has."""

import pytest
import sympy

import compensator_theory as exact

s = sympy.Symbol("s")


@pytest.mark.parametrize(
    ("printed", "typed"),
    [("s² + 2·s − 3", "s**2 + 2*s - 3"), ("2×s³⋅a", "2*s**3*a"), ("s⁻¹", "1/s"),
     ("(s + 1)¹²", "(s + 1)**12"), ("−2²", "-4"), ("1e−3", "1/1000"), ("2²/3", "4/3"),
     ("π*s", "pi*s"), ("𝜋*s", "pi*s"), ("s⁺²", "s**2"), ("√", None), ("s²³**2", None),
     ("s²a", None), ("s^−1", "1/s"), ("2 − 3", "-1"), ("s⁹⁹⁹⁹⁹⁹⁹⁹⁹⁹", None)],
)  # fmt: skip
def test_signs_of_a_printed_page(printed, typed):
    if typed is None:
        with pytest.raises(exact.InputError):
            exact.parse_expression(printed)
    else:
        assert exact.parse_expression(printed) == exact.parse_expression(typed)


def test_pi_is_the_number_in_both_scripts():
    verdict = exact.decide_stability("s**2 + (π - 3)*s + 1")
    assert verdict == exact.decide_stability("s**2 + (pi - 3)*s + 1")
    assert bool(verdict) is True
    for name in ("π", "pi", "𝜋"):
        with pytest.raises(exact.InputError, match="cannot be a variable"):
            exact.polynomial([1, 2], name)


def test_minus_signs_between_roots():
    assert exact.read_roots("−1, −2") == exact.read_roots("−1 −2") == (-1, -2)
    with pytest.raises(exact.InputError, match="one number or several"):
        exact.exact_number("−1 −2")
