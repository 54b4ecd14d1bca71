"""Roots in closed form against the polynomial itself and SymPy's own solver."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.roots import closed_form_roots
from compensator_theory.strategies import rationals

s, a, b, c = sympy.symbols("s a b c")
FACTORS = st.sampled_from([s + a, s, s**2 + a * s + b, s**2 + c**2, s**2 - 2, s + sympy.sqrt(2)])


@given(
    st.lists(st.tuples(FACTORS, st.integers(1, 2)), min_size=1, max_size=3),
    rationals(),
    rationals(),
)
def test_the_polynomial_is_the_product_of_its_roots(parts, x, y):
    p = sympy.prod([factor**k for factor, k in parts])
    roots = closed_form_roots(p, "s")
    product = sympy.prod([(s - root.value) ** root.multiplicity for root in roots])
    difference = (product - p).subs({a: x, b: y, c: x - y})
    values = [complex(difference.subs(s, at).evalf(30)) for at in (sympy.Rational(1, 3), 2)]
    assert max(map(abs, values)) < 1e-20
    assert len({root.value for root in roots}) == len(roots)


@given(rationals(), rationals())
def test_systems_have_poles_of_both_kinds(x, y):
    symbolic = ct.transfer_function("(s + c)/(s**2 + a*s + b)", "s")
    numbers = symbolic.subs({"a": x, "b": y})
    values = [complex(r.value.subs({a: x, b: y}).evalf(20)) for r in symbolic.poles()]
    certified = [r.value for r in numbers.poles() for _ in range(r.multiplicity)]
    key = lambda z: (round(z.real, 9), round(z.imag, 9))  # noqa: E731
    near = zip(sorted(values, key=key), sorted(certified, key=key), strict=True)
    assert all(abs(u - v) < 1e-7 for u, v in near)
    assert [r.value for r in symbolic.zeros()] == [-c]


def test_state_space_and_matrices():
    spring = ct.realisation(([[0, 1], ["-k/m", 0]], [[0], [1]], [[1, 0]]), "s")
    k, m = sympy.symbols("k m")
    assert {sympy.simplify(root.value**2 + k / m) for root in spring.poles()} == {0}
    G = ct.transfer_matrix([["1/(s + a)", 0], [0, "1/(s + a)"]], "s")
    assert [(r.value, r.multiplicity) for r in G.poles()] == [(-a, 2)]


def test_refusals():
    with pytest.raises(NoSolutionError, match="stability_conditions"):
        ct.transfer_function("1/(s**3 + a*s + 1)", "s").poles()
    with pytest.raises(InputError):
        closed_form_roots("0", "s")
