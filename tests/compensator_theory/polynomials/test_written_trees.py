"""A text whose functions are replaced by unknowns means the same."""

import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.polynomials._expressions import read_text, read_tree, written_tree

LEAVES = st.sampled_from(["s", "a", "2", "1/3", "5"])
TEXTS = st.recursive(
    LEAVES,
    lambda inner: (
        st.builds("({})".format, inner)
        | st.builds("({}){}({})".format, inner, st.sampled_from(["+", "-", "*", "/"]), inner)
        | st.builds("{}/({}*{})".format, LEAVES, inner, inner)
        | st.builds("({})**{}".format, inner, st.sampled_from(["2", "3", "(-1)"]))
    ),
    max_leaves=6,
)


@given(TEXTS)
def test_a_written_tree_reads_back(text):
    try:
        quotient = read_text(text)
    except InputError:  # it divides by zero
        return
    again = read_text(written_tree(read_tree(text), lambda leaf: leaf))
    assert sympy.cancel(again.value() - quotient.value()) == 0


def test_a_product_with_a_function_in_a_denominator():
    G = exact.transfer_function("1/(sin(a)*(s + 1)*(s + 2))", "s")
    assert G.order == 2
    assert G.subs("a", "pi/6") == exact.transfer_function("2/((s + 1)*(s + 2))")
