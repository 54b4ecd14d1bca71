"""Jordan forms against what was disguised, ranks of powers, and SymPy's jordan_form."""

from collections import Counter

import mpmath
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Matrix, Poly, eye

from compensator_theory import CompensatorError, exceptional_cases
from compensator_theory.forms import jordan_form
from compensator_theory.matrices._nonsingularity import is_proven_nonsingular
from compensator_theory.strategies.plants import unimodular_matrices

s = sympy.Symbol("s")
FACTORS = {"1": s - 1, "-2": s + 2, "pair": s**2 + 2 * s + 5, "surd": s**2 - 2}


def companion(f, length):
    poly = Poly(f, s)
    C = Matrix([[-poly.eval(0)]]) if poly.degree() == 1 else Matrix(
        [[0, -poly.eval(0)], [1, -poly.coeff_monomial(s)]]
    )  # fmt: skip
    shift = Matrix(length, length, lambda i, j: int(j == i + 1))
    return sympy.kronecker_product(eye(length), C) + sympy.kronecker_product(
        shift, eye(poly.degree())
    )


@st.composite
def disguised(draw):
    """Blocks, and the matrix of them in another basis."""
    chosen = st.tuples(st.sampled_from(sorted(FACTORS)), st.integers(1, 2))
    parts = draw(st.lists(chosen, min_size=1, max_size=3))
    J = sympy.diag(*(companion(FACTORS[name], length) for name, length in parts))
    T = draw(unimodular_matrices(J.rows))
    return Counter((Poly(FACTORS[name], s), length) for name, length in parts), T * J * T.inv()


def zero(matrix):
    return matrix.applyfunc(lambda e: sympy.simplify(sympy.expand(e))).is_zero_matrix


@pytest.mark.costly
@settings(max_examples=15)
@given(disguised())
def test_blocks_that_were_disguised_are_found(case):
    blocks, A = case
    form = jordan_form(A)
    assert Counter((Poly(f.as_expr(), s), k) for f, k in form.blocks) == blocks
    assert form.T.det() != 0 and form.T * form.form * form.T.inv() == A
    for factor, _ in form.blocks:  # ranks of powers, by SymPy
        value = sum((c * A**i for i, c in enumerate(reversed(factor.all_coeffs()))), A * 0)
        for k in range(1, 4):
            lost = sum(min(k, length) for f, length in form.blocks if f == factor)
            assert A.rows - (value**k).rank() == lost * factor.degree()


@settings(max_examples=8)
@given(disguised(), st.sampled_from(["real", "complex"]))
def test_every_root_has_its_chain(case, over):
    blocks, A = case
    form = jordan_form(A, over=over)
    assert zero(A * form.T - form.T * form.form)
    with mpmath.workdps(40):  # SymPy's determinants of floats answered 0 where it is -512
        assert abs(mpmath.det(sympy.lambdify([], form.T, "mpmath")())) > 1e-25
    if over == "real":
        assert not form.form.has(sympy.I) and not form.T.has(sympy.I)
    else:
        lengths = Counter()
        start = 0
        for i in range(A.rows):
            if i + 1 == A.rows or form.form[i, i + 1] == 0:
                lengths[sympy.expand(form.form[i, i]), i + 1 - start] += 1
                start = i + 1
        expected = Counter()
        for (f, k), times in blocks.items():
            for root in sympy.roots(f):
                expected[root, k] += times
        assert lengths == expected


def test_the_same_blocks_as_sympy():
    A = Matrix([[5, 4, 2, 1], [0, 1, -1, -1], [-1, -1, 3, 0], [1, 1, -1, 2]])
    _, J = A.jordan_form()
    ours = jordan_form(A, over="complex")
    sizes = [sorted((block[0, 0], block.rows) for block in M.get_diag_blocks())
             for M in (J, Matrix(ours.form))]  # fmt: skip
    assert sizes[0] == sizes[1]


def test_a_factor_of_degree_three_has_a_block_of_its_own():
    A = companion(s - 1, 1).row_join(sympy.zeros(1, 3)).col_join(
        sympy.zeros(3, 1).row_join(Matrix([[0, 0, 2], [1, 0, 0], [0, 1, 0]]))
    )  # fmt: skip
    assert str(jordan_form(A)) == "rational Jordan blocks of (s - 1), (s**3 - 2)"
    with pytest.raises(CompensatorError, match="degree 3"):
        jordan_form(A, over="complex")


SYMBOLIC = [
    [["a", 1], [0, "b"]],
    [[0, 1], ["-w**2", "-2*d*w"]],
    [["a", 1, 0], [0, "a", 0], [1, 0, "b"]],
    [[0, 1, 0, 0], ["-k", 0, 1, 0], [0, 0, 0, 1], [0, 0, "-k", 0]],
    [["a", "b"], ["b", "1/a"]],
    [["a", 0, 1], [0, "a", "s"], [0, 0, "s"]],
]


@pytest.mark.costly
@settings(max_examples=12)
@given(st.sampled_from(SYMBOLIC), st.sampled_from(["rational", "complex"]), st.data())
def test_a_form_with_symbols_holds_at_every_point_that_is_not_excepted(matrix, over, data):
    """A similarity to what is a Jordan form, whatever the symbols are, decided by balls."""
    result, A = jordan_form(matrix, over=over), Matrix(matrix)
    values = {x: sympy.Rational(data.draw(st.integers(-6, 6)), 2) for x in A.free_symbols}
    if any(f.subs(values) == 0 for f in result.exceptional):
        return
    there, T, J = (M.subs(values) for M in (A, result.T, result.form))
    assert zero(there * T - T * J) and is_proven_nonsingular(Matrix(T))
    if over == "complex":
        above = {J[i, i + 1] for i in range(A.rows - 1)}
        assert above <= {0, 1} and all(J[i, i] == J[i + 1, i + 1]
                                       for i in range(A.rows - 1) if J[i, i + 1])  # fmt: skip


def test_the_eigenvalues_of_a_damped_oscillator():
    """w (-d +- sqrt(d^2 - 1)), and a chain where d = 1: from any text."""
    w, d = sympy.symbols("w d")
    form = jordan_form([[0, 1], ["-w**2", "-2*d*w"]], over="complex")
    roots = {sympy.expand(form.form[i, i].subs({w: 2, d: 3})) for i in (0, 1)}
    assert roots == {-6 + 4 * sympy.sqrt(2), -6 - 4 * sympy.sqrt(2)}
    assert set(form.exceptional) == {w, d - 1, d + 1}
    cases = exceptional_cases(jordan_form, [[0, 1], ["-w**2", "-2*d*w"]], over="complex")
    assert "(s + w)**2" in str(cases)


@pytest.mark.parametrize(
    ("matrix", "over", "words"),
    [([[1, 2]], "rational", "square"), ([[1]], "p", "over"),
     ([["a*sqrt(2)"]], "real", "irrational"),
     ([["sqrt(a + 1)"]], "rational", "rational"), ([["a", 1], ["b", "c"]], "real", "depends on"),
     ([[f"x{i}{j}" for j in range(4)] for i in range(4)], "rational", "terms"),
     ([["sqrt(2)"]], "real", "irrational"), ([[1]], None, "over")],
)  # fmt: skip
def test_refusals(matrix, over, words):
    with pytest.raises(CompensatorError, match=words):
        jordan_form(matrix, over=over)
