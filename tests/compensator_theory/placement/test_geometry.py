"""Subspaces, decoupling and fixed modes against zeros, ranks, limits and drawn gains."""

import itertools

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError
from compensator_theory.forms import smith_mcmillan_form
from compensator_theory.geometry import (
    controlled_invariant_subspaces,
    decentralised_fixed_modes,
    decouple,
    decouple_disturbance,
    interactor,
)
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.strategies import matrices
from compensator_theory.strategies.plants import unimodular_matrices
from tests.support.structure_cases import fewer, realisations, transfer_matrices

s = sympy.Symbol("s")
SMALL = st.integers(-1, 1)


@st.composite
def sparse_plants(draw, max_order=4, max_signals=2, square=False):
    """Realisations of small integers, so that subspaces are neither zero nor everything."""
    n, m = draw(st.integers(1, max_order)), draw(st.integers(1, max_signals))
    p = m if square else draw(st.integers(1, max_signals))
    shapes = (n, n), (n, m), (p, n)
    A, B, C = (
        Matrix(r, c, draw(st.lists(SMALL, min_size=r * c, max_size=r * c))) for r, c in shapes
    )
    return A, B, C


def output_nulling(A, B, C, D, steps):
    """States with an input sequence that keeps the output zero for so many steps: by one system."""
    n, m = B.shape
    rows = []
    for k in range(steps):
        row = C * A**k
        for j in range(steps):
            block = C * A ** (k - 1 - j) * B if j < k else D if j == k else sympy.zeros(C.rows, m)
            row = row.row_join(block)
        rows.append(row)
    kernel = Matrix.vstack(*rows).nullspace()
    if not kernel:
        return 0
    return Matrix.hstack(*kernel)[:n, :].rank()


@fewer(2)
@given(realisations(max_block=1) | sparse_plants())
def test_the_largest_subspace(plant):
    """V* is the set of states that some input keeps at zero output (Silverman), for n steps."""
    subspaces = controlled_invariant_subspaces(plant, variable="s")
    A, B, C, D = (plant.A, plant.B, plant.C, plant.D) if hasattr(plant, "A") else (*plant, None)
    D = sympy.zeros(C.rows, B.cols) if D is None else D
    assert subspaces.certificate.holds
    assert subspaces.V.cols == output_nulling(A, B, C, D, A.rows)
    closed = A + B * subspaces.F
    if subspaces.V.cols:
        assert rank(subspaces.V.row_join(closed * subspaces.V)) == subspaces.V.cols
        assert ((C + D * subspaces.F) * subspaces.V).is_zero_matrix
    # the motion in V* modulo R* is that of the invariant zeros
    assert subspaces.zero_polynomial == ct.invariant_zeros((A, B, C, D), variable="s").polynomial


@fewer(3)
@given(sparse_plants())
def test_what_inputs_reach_inside(plant):
    """R* is what B G reaches under A + BF, for inputs that do not leave V*."""
    A, B, _ = plant
    subspaces = controlled_invariant_subspaces(plant, variable="s")
    n, R, V = A.rows, subspaces.R, subspaces.V
    inside = [
        vector[: B.cols, :]
        for vector in B.row_join(-V).nullspace()
    ] if V.cols else []  # fmt: skip
    inputs = Matrix.hstack(sympy.zeros(n, 0), *(B * g for g in inside))
    reached = Matrix.hstack(inputs, *((A + B * subspaces.F) ** k * inputs for k in range(n)))
    assert R.cols == reached.rank() == reached.row_join(R).rank()


@fewer(2)
@given(sparse_plants(), st.data())
def test_disturbances_are_hidden(plant, data):
    A, B, C = plant
    n = A.rows
    E = data.draw(st.sampled_from([(n, 1)]).flatmap(lambda _: matrices(n, 1)))
    space = controlled_invariant_subspaces(plant, variable="s").V
    if space.cols and data.draw(st.booleans()):
        E = space * Matrix(data.draw(matrices(space.cols, 1)))
    decoupling = decouple_disturbance(plant, E, variable="s")
    steps = range(n)
    # solvable if and only if some input cancels the first n outputs to a pulse of the disturbance
    zero = sympy.zeros(C.rows, B.cols)
    rows = Matrix.vstack(
        *(
            Matrix.hstack(*(C * A ** (k - 1 - j) * B if j < k else zero for j in steps))
            for k in steps
        )
    )
    observed = Matrix.vstack(*(C * A**k * E for k in steps))
    assert decoupling.is_solvable == (rows.rank() == rows.row_join(observed).rank())
    if decoupling.is_solvable:
        assert decoupling.certificate.holds
        assert all((C * (A + B * decoupling.F) ** k * E).is_zero_matrix for k in steps)


@fewer(2)
@given(transfer_matrices())
def test_the_interactor(G):
    """The limit exists and has full rank; its degree counts the zeros at infinity."""
    form = smith_mcmillan_form(G)
    if len(form.numerators) < G.shape[0]:
        with pytest.raises(NoSolutionError, match="combination"):
            interactor(G)
        return
    if any(order < 0 for order in form.orders_at_infinity):
        with pytest.raises(ct.CompensatorError):
            interactor(G)
        return
    interactor_matrix = interactor(G)
    xi = interactor_matrix.matrix.as_matrix()
    product = (xi * G.as_matrix()).applyfunc(sympy.cancel)
    limit = product.applyfunc(lambda e: sympy.limit(e, s, sympy.oo))
    assert limit == interactor_matrix.limit and limit.rank() == G.shape[0]
    assert sum(interactor_matrix.powers) == sum(form.orders_at_infinity)
    for i, j in itertools.product(range(xi.rows), repeat=2):
        below = Poly(sympy.cancel(xi[i, j] / s ** interactor_matrix.powers[j]), s)
        assert below.is_zero if i < j else below == Poly(1, s) if i == j else below.eval(0) == 0


def test_the_interactor_of_the_notes():
    interactor_matrix = interactor([["1/(s + 1)", "1/(s + 2)"], ["1/(s + 3)", "1/(s + 4)"]])
    assert interactor_matrix.matrix.as_matrix() == Matrix([[s, 0], [2 * s**2 - s**3, s**3]])
    assert interactor_matrix.limit == Matrix([[1, 1], [6, 8]])
    assert interactor([["a/(s + 1)"]], "s").exceptional == (sympy.Symbol("a"),)
    with pytest.raises(ct.CompensatorError):
        interactor([["s"]])


@fewer(2)
@given(sparse_plants(square=True, max_signals=2), st.data())
def test_decoupling(plant, data):
    A, B, C = plant
    G = (C * (s * sympy.eye(A.rows) - A).adjugate() * B).applyfunc(sympy.expand)
    size = A.rows
    degrees = [
        min((size - Poly(e, s).degree() for e in G[i, :] if e != 0), default=None)
        for i in range(C.rows)
    ]
    if None in degrees:
        with pytest.raises(NoSolutionError, match="reaches"):
            decouple(plant, variable="s")
        return
    star = Matrix(
        [
            [Poly(e, s).coeff_monomial(s ** (size - d)) for e in G[i, :]]
            for i, d in enumerate(degrees)
        ]
    )
    if star.det() == 0:
        with pytest.raises(NoSolutionError, match="singular"):
            decouple(plant, variable="s")
        return
    roots = [[-data.draw(st.integers(1, 3)) for _ in range(d)] for d in degrees]
    targets = [ct.polynomial_from_roots(row, "s") for row in roots]
    decoupling = decouple(plant, targets, variable="s")
    assert decoupling.matrix == star and list(decoupling.relative_degrees) == degrees
    point = Rational(17, 3)
    loop = C * (point * sympy.eye(size) - A - B * decoupling.F).inv() * B * decoupling.W
    assert loop == sympy.diag(*(1 / p.eval(point) for p in targets))
    # what becomes unobservable are zeros of the plant: the rest of the closed loop
    assert decoupling.hidden.degree() == size - sum(degrees)
    hidden = ct.kalman_decomposition((A + B * decoupling.F, B * decoupling.W, C), variable="s")
    assert (hidden.output_decoupling.rem(decoupling.hidden)).is_zero


@st.composite
def channelled_plants(draw):
    """Plants in a basis that hides their form, with two or three channels of one or two signals."""
    n, m, p = draw(st.integers(1, 3)), draw(st.integers(2, 3)), draw(st.integers(2, 3))
    modes = draw(st.lists(st.integers(-2, 2), min_size=n, max_size=n))
    A = Matrix(draw(matrices(n, n))) if draw(st.booleans()) else sympy.diag(*modes)
    entries = st.lists(SMALL, min_size=n * max(m, p), max_size=n * max(m, p))
    B, C = Matrix(n, m, draw(entries)[: n * m]), Matrix(p, n, draw(entries)[: n * p])
    S = Matrix(draw(unimodular_matrices(n)))
    cut_in, cut_out = draw(st.integers(1, m - 1)), draw(st.integers(1, p - 1))
    channels = [
        (list(range(cut_in)), list(range(cut_out))),
        (list(range(cut_in, m)), list(range(cut_out, p))),
    ]
    return S * A * S.inv(), S * B, C * S.inv(), channels


@fewer(2)
@given(channelled_plants(), st.randoms(use_true_random=False))
def test_fixed_modes_against_drawn_gains(case, random):
    A, B, C, channels = case
    modes = decentralised_fixed_modes((A, B, C), channels, variable="s")
    common = Poly(A.charpoly(s).as_expr(), s)
    for _ in range(6):
        K = sympy.zeros(B.cols, C.rows)
        for inputs, outputs in channels:
            for i, j in itertools.product(inputs, outputs):
                K[i, j] = Rational(random.randint(-999, 999), random.randint(1, 99))
        common = common.gcd(Poly((A + B * K * C).charpoly(s).as_expr(), s))
    assert ct.polynomial(common.monic().as_expr(), "s") == modes.polynomial
    moved = Poly((A + B * modes.gains * C).charpoly(s).as_expr(), s)
    assert moved.gcd(Poly(A.charpoly(s).as_expr(), s)).degree() == modes.polynomial.degree()
    whole = ct.kalman_decomposition((A, B, C), "s")
    observed = whole.block_polynomials[1]
    assert modes.centralised * observed == ct.polynomial(A.charpoly(s).as_expr(), "s")
    assert modes.polynomial.rem(modes.centralised).is_zero


def test_the_fixed_mode_of_the_notes():
    A, B, C = sympy.diag(2, 1, 3), [[1, 0], [1, 0], [0, 1]], [[1, 0, 0], [0, 1, 1]]
    modes = decentralised_fixed_modes((A, B, C), [([0], [0]), ([1], [1])], variable="s")
    assert modes.polynomial == ct.polynomial("s - 1") and modes.centralised.degree() == 0
    assert [root.value for root in modes.modes()] == [1]


@pytest.mark.parametrize(
    "channels",
    [[], [([0], [0]), ([0], [1])], [([5], [0])], [0, 1], [([True], [0])], "ab", None,
     [([10**5000], [0])], [([0], range(10**7))], [([0], itertools.count())]],
)  # fmt: skip
def test_bad_channels(channels):
    with pytest.raises(ct.InputError):
        decentralised_fixed_modes(([[1]], [[1, 1]], [[1], [1]]), channels, variable="s")


@pytest.mark.parametrize(
    "call",
    [lambda: decentralised_fixed_modes((["a"], [[1]], [[1]]), [([0], [0])], variable="s"),
     lambda: decentralised_fixed_modes(([["a"]], [[1]], [[1]]), [([0], [0])], variable="s"),
     lambda: decentralised_fixed_modes("(s + 2)/(s + 1)", [([0], [0])]),
     lambda: decouple(([[1]], [[1, 1]], [[1]]), variable="s"), lambda: decouple("1/s", ["s**2"]),
     lambda: decouple("1/s", True), lambda: decouple("1/s", itertools.count()),
     lambda: decouple("1/s", "s"), lambda: decouple("1/s", ["2*s"]), lambda: decouple("s"),
     lambda: decouple_disturbance("1/s", [[1], [2]]), lambda: decouple_disturbance("1/s", "E"),
     lambda: controlled_invariant_subspaces("s**2"), lambda: interactor([]),
     lambda: controlled_invariant_subspaces(([[1, 2]], [[1]], [[1]]), variable="s")],
)  # fmt: skip
def test_bad_input(call):
    with pytest.raises(ct.CompensatorError):
        call()


def test_symbols_say_where_they_hold():
    a = sympy.Symbol("a")
    subspaces = controlled_invariant_subspaces(
        ([[0, 1], [0, 0]], [[0], [1]], [["a", 1]]), variable="s"
    )
    assert subspaces.zero_polynomial == ct.polynomial("s + a", "s")
    assert Matrix([[1, -a]]) == subspaces.V.T
    assert subspaces.exceptional == (a,)
    assert decouple(([[0]], [["a"]], [[1]]), variable="s").exceptional == (a,)


def test_fixed_modes_of_a_large_plant_in_other_coordinates():
    n = 12
    modes = [-k for k in range(1, n + 1)]
    T = Matrix(n, n, lambda i, j: int(i == j) + int(j == i + 1) * (i % 3 - 1))
    B = Matrix(n, 2, lambda i, j: int(i % 3 == j) * (i + 1))  # every third mode has no input
    C = Matrix(2, n, lambda i, j: j % 5 + i + 1)
    plant = T * sympy.diag(*modes) * T.inv(), T * B, C * T.inv()
    result = decentralised_fixed_modes(plant, [([0], [0]), ([1], [1])], variable="s")
    expected = ct.polynomial_from_roots([modes[i] for i in range(n) if i % 3 == 2], "s")
    assert result.polynomial == expected == result.centralised


@pytest.mark.parametrize("read", [list, ct.transfer_matrix])
def test_decoupling_asks_a_transfer_matrix_for_states(read):
    G = [["1/(s + 1)", "1/(s + 2)"], ["1/(s + 3)", "2/(s + 4)"]]
    with pytest.raises(ct.InputError, match=r"minimal_realisation\(G\)\.realisation"):
        decouple(read(G))
    decoupling = decouple(ct.minimal_realisation(G).realisation)
    assert decoupling.relative_degrees == interactor(G).powers, "it is diagonal where that can be"
