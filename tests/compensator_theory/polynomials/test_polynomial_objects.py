"""Polynomials of other packages: each is read in the order that its package writes."""

import flint
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Chebyshev, Hermite, HermiteE, Laguerre, Legendre, Polynomial

import compensator_theory as exact
from tests.support.public import public_objects

PUBLIC = public_objects("compensator_theory")
x, y = sympy.symbols("x y")
INTEGERS = st.lists(st.integers(-9, 9), min_size=1, max_size=5).filter(lambda c: c[-1] != 0)
"""From the constant on."""


@given(INTEGERS)
def test_every_class_is_read_in_its_own_order(ascending):
    poly = exact.polynomial(ascending[::-1], "s")
    terms = sum(c * x**k for k, c in enumerate(ascending))
    for obj in (
        Polynomial(ascending), Polynomial([*ascending, 0]), flint.fmpz_poly(ascending),
        flint.fmpq_poly(ascending), flint.fmpq_series(ascending), flint.fmpz_series(ascending),
        np.poly1d(ascending[::-1]), np.array(ascending[::-1]), tuple(ascending[::-1]),
        sympy.Tuple(*ascending[::-1]),
    ):  # fmt: skip
        assert exact.polynomial(obj, "s") == poly, type(obj)
        assert exact.resultant(obj, "s + 2", variable="s") == exact.resultant(poly, "s + 2")
    ring = sympy.ring("x", sympy.QQ)[0]
    element = ring.from_expr(terms)
    assert exact.polynomial(element) == exact.polynomial(ascending[::-1], "x")


def test_a_target_that_is_a_polynomial_is_no_list_of_roots():
    poly = exact.polynomial("(s + 1)*(s + 2)*(s + 3)")
    for target in (
        Polynomial([6, 11, 6, 1]),
        np.poly1d([1, 6, 11, 6]),
        flint.fmpq_poly([6, 11, 6, 1]),
    ):
        assert exact.place_poles("1/(s**2 + s)", target, feedback=-1).target == poly


def test_the_name_of_the_variable_is_kept_where_it_was_given():
    assert exact.polynomial(Polynomial([1, 2], symbol="z")) == exact.polynomial("2*z + 1")
    assert exact.polynomial(np.poly1d([2, 1], variable="s")) == exact.polynomial("2*s + 1")
    with pytest.raises(exact.InputError, match="in z, not in s"):
        exact.polynomial(Polynomial([1, 2], symbol="z"), "s")
    two = sympy.ring("s, a", sympy.QQ)[0]
    assert exact.polynomial(two.from_expr(sympy.sympify("s**2 + a"))).gen == sympy.Symbol("s")


@pytest.mark.parametrize("kind", [Chebyshev, Legendre, Hermite, HermiteE, Laguerre])
def test_another_basis_is_converted_by_who_gives_it(kind):
    with pytest.raises(exact.InputError, match="convert"):
        exact.polynomial(kind([1, 2, 3]), "s")
    converted = kind([1, 2, 3]).convert(kind=Polynomial)
    assert exact.polynomial(converted, "s").degree() == 2


def test_another_domain_is_converted_by_who_gives_it():
    fitted = Polynomial.fit([0, 1, 2], [1, 3, 9], 2)
    with pytest.raises(exact.InputError, match="convert"):
        exact.polynomial(fitted, "s")
    assert exact.polynomial(fitted.convert(), "s").degree() == 2


class Backwards:
    """A polynomial that can be iterated, of a package that nobody here knows."""

    def __len__(self):
        return 2

    def __iter__(self):
        return iter([3, 1])

    def __getitem__(self, index):
        return [3, 1][index]


@pytest.mark.parametrize(
    "obj",
    [Backwards(), iter([1, 2]), (c for c in (1, 2)), {1, 2}, {0: 1}, dict.fromkeys("ab").keys(),
     np.ones((2, 1)), flint.arb_poly([1, 2]), flint.fmpq_mat(1, 2, [1, 2]),
     flint.nmod_poly([1, 2], 5), sympy.Matrix([1, 2]), sympy.FiniteSet(1, 2), memoryview(b"12"),
     np.ma.array([1, 2], mask=[0, 1])],
)  # fmt: skip
@pytest.mark.parametrize(
    "door", [exact.polynomial, lambda p, v: exact.transfer_function((p, [1, 2, 3]), v),
             lambda p, v: exact.resultant(p, "s + 1", variable=v)],
)  # fmt: skip
def test_whatever_else_can_be_iterated_is_no_list_of_coefficients(obj, door):
    with pytest.raises(exact.InputError):
        door(obj, "s")


@pytest.mark.parametrize("obj", [Polynomial([1, 2]), np.poly1d([1, 2]), Backwards()])
def test_a_list_of_numbers_is_no_polynomial(obj):
    for door in (
        lambda: PUBLIC["pade_approximant"](obj, 0, 1),
        lambda: PUBLIC["partial_realisation"](obj),
        lambda: exact.read_roots(obj),
        lambda: exact.polynomial_from_roots(obj, "s"),
        lambda: exact.Realisation(obj, [[1]], [[1]]),
    ):
        with pytest.raises(exact.InputError):
            door()
