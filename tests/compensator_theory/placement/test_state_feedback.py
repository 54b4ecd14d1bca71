"""Gains for several inputs, against SciPy's place_poles, ranks and characteristic polynomials."""

import numpy as np
import pytest
import scipy.signal
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Matrix, Rational

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError, NotControllableError, NotObservableError
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.strategies import matrices, spectra
from compensator_theory.strategies.plants import disguised, unimodular_matrices
from tests.support.structure_cases import fewer

s, a, b = sympy.symbols("s a b")
A_NOTES, B_NOTES = [[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0, 0], [1, 0], [1, 1]]


@st.composite
def pairs(draw, max_order=4, max_inputs=3):
    """Controllable pairs: disguised chains under feedback, dependent inputs now and then."""
    m = draw(st.integers(1, max_inputs))
    sizes = draw(st.lists(st.integers(0, 2), min_size=m, max_size=m).filter(any))
    n = sum(sizes)
    if n > max_order:
        sizes, n = [2, 2, *([0] * (m - 2))], 4
    A, B, end = sympy.zeros(n, n), sympy.zeros(n, m), 0
    for i, size in enumerate(sizes):
        for k in range(end, end + size - 1):
            A[k, k + 1] = 1
        end += size
        if size:
            B[end - 1, i] = 1
    B = B * Matrix(draw(unimodular_matrices(m)))
    A = A + B * Matrix(draw(matrices(m, n)))
    basis = draw(unimodular_matrices(n))
    a, b, _ = disguised(ImmutableMatrix(A), ImmutableMatrix(B), ImmutableMatrix.eye(n), basis)
    return a, b


def charpoly(matrix):
    return ct.polynomial(Matrix(matrix).charpoly(s).as_expr(), "s")


@given(pairs())
def test_brunovskys_form(pair):
    A, B = pair
    n = A.rows
    form = ct.brunovsky_form(A, B)
    T, F, W = form.T, form.F, form.W
    assert T.inv() * (A + B * F) * T == form.A_c and T.inv() * B * W == form.B_c
    assert W.det() != 0 and sum(form.indices) == n
    # rank [B AB ... A^(k-1) B] = the sum of min(kappa_i, k): the definition of the indices
    columns = sympy.zeros(n, 0)
    for k in range(1, n + 1):
        columns = columns.row_join(A ** (k - 1) * B)
        assert rank(columns) == sum(min(index, k) for index in form.indices)


def test_all_gains_are_those_that_are_similar():
    """K = -2I gives the poles -1, -1 too, and no Jordan block: it is none of the cyclic family."""
    unit = sympy.eye(2)
    cyclic = ct.state_feedback_family(unit, unit, [-1, -1])
    assert "and A + BK cyclic" in str(cyclic) and cyclic.parameters_of(-2 * unit) == ()
    diagonal = ct.state_feedback_family(unit, unit, Lambda=-unit)
    assert "similar to [[-1, 0], [0, -1]]" in str(diagonal)
    basis = diagonal.parameters_of(-2 * unit)
    generic = sum((p * i**2 for i, p in enumerate(basis, 1)), sympy.zeros(2, 2))
    assert diagonal.gain(generic) == -2 * unit
    assert "cyclic" not in str(ct.state_feedback_family(unit, unit, [-1, -2]))


@fewer(2)
@given(pairs(), st.data())
def test_every_member_places_the_poles(pair, data):
    A, B = pair
    n, m = B.shape
    poles = data.draw(spectra(n))
    family = ct.state_feedback_family(A, B, poles)
    poly = ct.polynomial_from_roots(poles, "s")
    K = family.gain()
    assert charpoly(A + B * K) == poly
    phi = data.draw(matrices(m, n))
    if family.determinant(phi) == 0:
        with pytest.raises(NoSolutionError, match="det X = 0"):
            family.gain(phi)
        return
    X, K = family.basis(phi), family.gain(phi)
    assert charpoly(A + B * K) == poly
    assert ((A + B * K) * X - X * family.Lambda).is_zero_matrix


@fewer(2)
@given(pairs(), st.data())
def test_every_gain_is_a_member(pair, data):
    """Any K whose closed loop is cyclic comes back from parameters."""
    A, B = pair
    n, m = B.shape
    K = data.draw(matrices(m, n))
    closed = A + B * K
    krylov = sympy.zeros(n, 0)
    start = data.draw(matrices(n, 1))
    for _ in range(n):
        krylov = krylov.row_join(start)
        start = closed * start
    assume(rank(krylov) == n)  # cyclic, with this vector
    family = ct.state_feedback_family(A, B, charpoly(closed))
    parameters = family.parameters_of(K)
    assert len(parameters) == n  # the commutant of a cyclic matrix
    weights = [Rational(7 * i * i + 3 * i + 1, i + 2) for i in range(n)]
    phi = sum((w * x for w, x in zip(weights, parameters, strict=True)), sympy.zeros(m, n))
    assume(family.determinant(phi) != 0)
    assert family.gain(phi) == K


@fewer(2)
@given(pairs(max_inputs=2))
def test_against_scipys_place_poles(pair):
    """SciPy's robust gain is a member, as far as float64 says."""
    A, B = (np.array(x, dtype=float) for x in pair)
    n = len(A)
    assume(np.linalg.matrix_rank(B) == B.shape[1])
    poles = [-1 - k for k in range(n)]
    theirs = scipy.signal.place_poles(A, B, poles)
    family = ct.state_feedback_family(*pair, poles)
    K = np.array(family.gain(), dtype=float)
    for gain in (K, -theirs.gain_matrix):
        placed = np.poly(A + B @ gain)
        np.testing.assert_allclose(placed, np.poly(poles), rtol=1e-5, atol=1e-5)
    if B.shape[1] == 1:
        np.testing.assert_allclose(K, -theirs.gain_matrix, rtol=1e-5, atol=1e-5)
        assert family.gain() == ct.regulator_gain(*pair, poles)


@fewer(2)
@given(pairs(), st.data())
def test_the_dual(pair, data):
    A, C = pair[0].T, pair[1].T
    poles = data.draw(spectra(A.rows))
    F = ct.observer_gain_family(A, C, poles).gain()
    assert charpoly(A - F * C) == ct.polynomial_from_roots(poles, "s")


def test_the_example_of_the_notes():
    assert ct.brunovsky_form(A_NOTES, B_NOTES).indices == (2, 1)
    family = ct.state_feedback_family(A_NOTES, B_NOTES, Lambda=sympy.diag(-1, -2, -3))
    K = Matrix([[-102, -145, 24], [36, 84, -96]]) / 31
    assert family.gain(sum(family.parameters_of(K), sympy.zeros(2, 3))) == K
    # Their excluded set for eigenvectors (lambda I - A)^-1 B f with f = (1, u).
    u = sympy.symbols("u1:4")
    A, B = Matrix(A_NOTES), Matrix(B_NOTES)
    directions = [Matrix([1, v]) for v in u]
    X = Matrix.hstack(
        *(
            (x * sympy.eye(3) - A).inv() * B * f
            for x, f in zip((-1, -2, -3), directions, strict=True)
        )
    )
    excluded = 6 * u[0] - 32 * u[1] + 27 * u[2] + 1
    assert sympy.rem(sympy.together(X.det()).as_numer_denom()[0], excluded, *u) == 0
    assignment = ct.assign_eigenstructure(
        A,
        B,
        [-1, -2, -3],
        [list(X[:, k].subs(dict(zip(u, (0, 1, 0), strict=True)))) for k in range(3)],
    )
    assert assignment.K == K
    double = Matrix([[-2, -3, 0], [Rational(2, 3), Rational(5, 3), -2]])
    closed = A + B * double
    assert (closed + sympy.eye(3)).rank() == 1
    assert ct.state_feedback_family(A, B, Lambda=sympy.diag(-1, -1, -2)).parameters_of(double)


@fewer(2)
@given(pairs(), st.data())
def test_eigenvectors_in_reach_are_assigned(pair, data):
    A, B = pair
    n = A.rows
    values, vectors = [], []
    for k in range(n):
        value = Rational(-1 - 2 * k, 3)
        space = ct.reachable_eigenvectors(A, B, value)
        assert space.cols == rank(B)
        weights = data.draw(matrices(space.cols, 1))
        values.append(value)
        vectors.append(list(space * weights))
    V = Matrix(vectors).T
    if V.det() == 0:
        with pytest.raises(NoSolutionError, match="dependent"):
            ct.assign_eigenstructure(A, B, values, vectors)
        return
    assignment = ct.assign_eigenstructure(A, B, values, vectors)
    assert ((A + B * assignment.K) * V - V * sympy.diag(*values)).is_zero_matrix


def test_chains_and_complex_pairs():
    A, B = Matrix([[0, 1], [0, 0]]), Matrix([0, 1])
    assignment = ct.assign_eigenstructure(A, B, [-2], [[(1, -2), (0, 1)]])
    assert charpoly(A + B * assignment.K) == ct.polynomial("(s + 2)**2")
    pair = ct.assign_eigenstructure(A, B, ["-1+2j"], [(1, "-1+2j")])
    assert charpoly(A + B * pair.K) == ct.polynomial("s**2 + 2*s + 5")
    with pytest.raises(NoSolutionError, match="no feedback makes"):
        ct.assign_eigenstructure(A, B, [-1, -2], [(1, 0), (0, 1)])


def test_a_chain_of_a_complex_pair():
    """Four integrators: eigenvectors (1, l, l^2, l^3), and its derivative after it in the chain."""
    A, B = Matrix(4, 4, lambda i, j: int(j == i + 1)), Matrix([0, 0, 0, 1])
    chain = [("1", "-1+j", "-2j", "2+2j"), ("0", "1", "-2+2j", "-6j")]
    assignment = ct.assign_eigenstructure(A, B, ["-1+j"], [chain])
    assert charpoly(A + B * assignment.K) == ct.polynomial("(s**2 + 2*s + 2)**2")
    conjugate = [[sympy.conjugate(ct.exact_number(e)) for e in v] for v in chain]
    lower = ct.assign_eigenstructure(A, B, ["-1-j"], [conjugate])
    both = ct.assign_eigenstructure(A, B, ["-1+j", "-1-j"], [chain, conjugate])
    assert assignment.K == lower.K == both.K


@pytest.mark.costly
@fewer(4)
@given(pairs(), st.data())
def test_complex_eigenvectors_in_reach_are_assigned(pair, data):
    A, B = pair
    n = A.rows
    assume(n >= 2)
    values = [Rational(-1, 2) + sympy.I * data.draw(st.integers(1, 3))]
    values += [Rational(-k) for k in range(2, n)]
    vectors = []
    for value in values:
        space = ct.reachable_eigenvectors(A, B, value)
        assert space.cols == rank(B)
        v = space * data.draw(matrices(space.cols, 1))
        vectors.append([sympy.expand(e) for e in v])
        # It is in reach: (value I - A) v lies in the image of B.
        expected = (value * sympy.eye(n) - A) * v
        assert B.row_join(expected.applyfunc(sympy.expand)).rank() == rank(B)
    try:
        assignment = ct.assign_eigenstructure(A, B, values, vectors)
    except NoSolutionError:
        return  # dependent
    first = Matrix(vectors[0])
    assert (
        ((A + B * assignment.K - values[0] * sympy.eye(n)) * first)
        .applyfunc(sympy.expand)
        .is_zero_matrix
    )


def test_jordan_structures_within_rosenbrocks_inequalities():
    """Indices (2, 1): two blocks of sizes 2 and 1 are in reach, three of size 1 are not."""
    for blocks, reachable in (([2, 1], True), ([3], True), ([1, 1, 1], False)):
        J = sympy.diag(*(sympy.jordan_cell(-2, size) for size in blocks))
        family = ct.state_feedback_family(A_NOTES, B_NOTES, Lambda=J)
        if reachable:
            closed = Matrix(A_NOTES) + Matrix(B_NOTES) * family.gain()
            assert 3 - (closed + 2 * sympy.eye(3)).rank() == len(blocks)
        else:
            with pytest.raises(NoSolutionError, match="Rosenbrock"):
                family.gain()


def test_symbols_say_where_they_hold():
    family = ct.state_feedback_family([["a", 1], [0, "b"]], [[1], [1]], [-1, -2])
    at = a - b + 1
    assert family.exceptional == (at,)
    assert charpoly(Matrix([[a, 1], [0, b]]) + Matrix([1, 1]) * family.gain()) == ct.polynomial(
        "(s + 1)*(s + 2)"
    )


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (
            lambda: ct.state_feedback_family([[1, 0], [0, 2]], [[1], [0]], [-1, -2]),
            NotControllableError,
        ),
        (lambda: ct.observer_gain_family([[1, 0], [0, 2]], [[1, 0]], [-1, -2]), NotObservableError),
        (lambda: ct.state_feedback_family([[1]], [[1]], [-1, -2]), ct.InputError),
        (lambda: ct.state_feedback_family([[1]], [[1]]), ct.InputError),
        (lambda: ct.state_feedback_family([[1]], [[1]], [-1], Lambda=[[-1]]), ct.InputError),
        (lambda: ct.state_feedback_family([[1]], [[1]], Lambda=[[-1, 0]]), ct.InputError),
        (lambda: ct.state_feedback_family([[1]], [[1]], [-1]).gain([[1, 2]]), ct.InputError),
        (lambda: ct.state_feedback_family([[1]], [[1]], [-1]).gain([[0]]), NoSolutionError),
        (lambda: ct.assign_eigenstructure([[1]], [[1]], [-1], []), ct.InputError),
        (lambda: ct.assign_eigenstructure([[1]], [[1]], [-1], [(1, 2)]), ct.InputError),
        (lambda: ct.assign_eigenstructure([[1]], [[1]], ["-1-1j"], [("1j",)]), ct.InputError),
        (
            lambda: ct.assign_eigenstructure(
                [[0, 1], [0, 0]], [[0], [1]], ["-1+j", "-1-j"], [("j", "-1-j"), ("j", "-1+j")]
            ),
            ct.InputError,
        ),
        (lambda: ct.assign_eigenstructure([[1]], [[1]], [-1], ["x"]), ct.InputError),
        (lambda: ct.reachable_eigenvectors([[1]], [[1], [2]], -1), ct.InputError),
        (lambda: ct.reachable_eigenvectors([[1]], [[1]], "sqrt(2)"), ct.InputError),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()


@given(pairs())
def test_deadbeat(pair):
    A, B = pair
    n = A.rows
    K = ct.state_feedback_family(A, B, [0] * n, variable="z").gain()
    assert ((A + B * K) ** n).is_zero_matrix
    # In the least time: chains as long as the controllability indices.
    indices = [index for index in ct.brunovsky_form(A, B).indices if index]
    blocks = sympy.diag(*(sympy.jordan_cell(0, size) for size in indices))
    fast = ct.state_feedback_family(A, B, variable="z", Lambda=blocks).gain()
    assert ((A + B * fast) ** max(indices)).is_zero_matrix
