"""Continua of invariant subspaces: counts over finite fields, invariance, observer forms."""

import itertools

import numpy as np
import pytest
import sympy
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational

from compensator_theory import InputError, Realisation, observer_forms
from compensator_theory.errors import BudgetError
from compensator_theory.matrices._cyclic_families import sample_subspaces
from compensator_theory.matrices._invariant_subspaces import (
    joined,
    primary_components,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    rank,
    solve_affine,
)
from compensator_theory.matrices._open_cells import families, grassmannian_cell
from compensator_theory.matrices._strata import (
    continuum_size,
    littlewood_richardson,
    partitions,
    strata,
)
from compensator_theory.observers import youla_forms
from compensator_theory.strategies.plants import unimodular_matrices

s = sympy.Symbol("s")


def nilpotent(blocks, dtype=int):
    size = sum(blocks)
    zeros_of_plant = np.zeros((size, size), dtype)
    ends = set(np.cumsum(blocks))
    for i in range(size - 1):
        zeros_of_plant[i, i + 1] = i + 1 not in ends
    return zeros_of_plant


def number_of_invariant_subspaces(matrix, k, p):
    """Count over F_p by all reduced echelon forms: V is invariant if V A reduces to zero."""
    n, total = len(matrix), 0
    for pivots in itertools.combinations(range(n), k):
        free = [(i, j) for i in range(k) for j in range(n) if j > pivots[i] and j not in pivots]
        values = np.indices((p,) * len(free)).reshape(len(free), p ** len(free)).T
        bases = np.zeros((len(values), k, n), int)
        for i, j in enumerate(pivots):
            bases[:, i, j] = 1
        for column, (i, j) in enumerate(free):
            bases[:, i, j] = values[:, column]
        images = bases @ matrix.T
        rest = (images - images[:, :, list(pivots)] @ bases) % p
        total += int((rest == 0).all(axis=(1, 2)).sum())
    return total


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_dimension_and_components_by_counts_over_finite_fields(n):
    """The count is a polynomial in p of degree at most 4: five primes give it, a sixth confirms."""
    primes, x = [2, 3, 5, 7, 11, 13], sympy.Symbol("x")
    for blocks, k in itertools.product(partitions(n), range(n + 1)):
        counts = [number_of_invariant_subspaces(nilpotent(blocks), k, p) for p in primes]
        poly = Poly(sympy.interpolate(list(zip(primes[:-1], counts[:-1], strict=True)), x), x)
        assert poly.eval(13) == counts[-1]
        every = strata(blocks, k)
        largest = every[0].dimension
        assert (poly.degree(), poly.LC()) == (
            largest, sum(stratum.components for stratum in every if stratum.dimension == largest)
        )  # fmt: skip


def test_five_dimensions_at_two_primes_are_near_the_leading_term(in_full):
    """n = 5: the counts at 2, 3 and 5 grow as fast as the dimension says."""
    cases = list(itertools.product(partitions(5), (2, 3)))
    for blocks, k in cases if in_full else cases[::3]:
        every = strata(blocks, k)
        two, three, five = (
            number_of_invariant_subspaces(nilpotent(blocks), k, p) for p in (2, 3, 5)
        )
        top = sum(c.components for c in every if c.dimension == every[0].dimension)
        assert top * 5 ** every[0].dimension <= five
        assert abs(np.log(five / three) / np.log(5 / 3) - every[0].dimension) < 0.8
        assert two < three < five or every[0].dimension == 0


@pytest.mark.parametrize("size", [4, 5])
def test_littlewood_richardson_by_dimensions_of_representations(size):
    """Both sides count standard fillings: sum of c f_mu f_nu (n choose k)^-1 ... = f_lambda."""

    def standard(shape):
        if not sum(shape):
            return 1
        total = 0
        for i, row in enumerate(shape):
            if row and (i + 1 == len(shape) or shape[i + 1] < row):
                total += standard((*shape[:i], row - 1, *shape[i + 1 :]))
        return total

    for whole, k in itertools.product(partitions(size), range(size + 1)):
        total = sum(
            littlewood_richardson(whole, mu, nu) * standard(mu) * standard(nu)
            for mu in partitions(k) for nu in partitions(size - k)
        )  # fmt: skip
        assert total == standard(whole)


def test_symmetry_of_the_strata():
    """Duality exchanges subspace and quotient."""
    for blocks in partitions(5):
        one = {(c.subspace, c.quotient, c.dimension, c.components) for c in strata(blocks, 2)}
        two = {(c.quotient, c.subspace, c.dimension, c.components) for c in strata(blocks, 3)}
        assert one == two


def component_of(blocks, T, factor=None):
    """A disguised matrix with these blocks for s, or for a quadratic factor."""
    if factor is None:
        matrix = T * Matrix(nilpotent(blocks)) * T.inv()
    else:
        C = Matrix([[0, -factor.eval(0)], [1, -factor.coeff_monomial(s)]])
        parts = [
            sympy.kronecker_product(sympy.eye(b), C)
            + sympy.kronecker_product(Matrix(nilpotent((b,))), sympy.eye(2))
            for b in blocks
        ]
        matrix = T * sympy.diag(*parts) * T.inv()
    (part,) = primary_components(matrix, characteristic_polynomial(matrix, s))
    return matrix, part


@st.composite
def derogatory(draw):
    factor = draw(st.sampled_from([None, None, Poly(s**2 + 1, s), Poly(s**2 - 2, s)]))
    sizes = (2, 3, 4) if factor is None else (2, 3)
    blocks = draw(st.sampled_from([b for n in sizes for b in partitions(n) if len(b) > 1]))
    T = draw(unimodular_matrices(sum(blocks) * (1 if factor is None else 2)))
    matrix, part = component_of(blocks, T, factor)
    powers = [e for e in range(part.multiplicity) if part.has_continuum(e)]
    return blocks, matrix, part, draw(st.sampled_from(powers))


@pytest.mark.costly
@settings(max_examples=10, phases=[Phase.generate])
@given(derogatory(), st.data())
def test_families_are_invariant_and_have_as_many_parameters(case, data):
    blocks, matrix, part, e = case
    assert part.block_lengths == blocks
    size, _ = continuum_size([(part, e)])
    result = families(matrix, [(part, e)])
    assert result
    spans = []
    for index, (basis, parameters) in enumerate(result):
        assert (parameters or len(result) == 1) and len(parameters) <= size
        assert len(set(parameters)) == len(parameters)
        for _ in range(2):
            values = {
                p: data.draw(st.fractions(-3, 3, max_denominator=2).map(Rational))
                for p in parameters
            }
            V = basis.subs(values)
            if V.has(sympy.zoo, sympy.nan) or rank(V) < basis.cols:
                continue  # the thin set
            assert V.cols == e * part.degree
            M = joined(V.cols, [solve_affine(V, (matrix * V)[:, k]).particular
                                for k in range(V.cols)])  # fmt: skip
            assert (matrix * V - V * M).is_zero_matrix
            assert characteristic_polynomial(M, s) == part.factor**e
            spans.append((values, V, index))
    for (first, V, one), (second, W, two) in itertools.combinations(spans, 2):
        if one == two and first != second:  # each subspace once
            assert rank(V.row_join(W)) > V.cols


@settings(max_examples=10)
@given(st.integers(2, 4).flatmap(lambda n: st.tuples(st.just(n), st.integers(1, n - 1))), st.data())
def test_a_scalar_block_has_every_subspace(sizes, data):
    """The open cell has dimension k (n - k) and is all of them, but those that miss a minor."""
    n, k = sizes
    matrix = sympy.eye(n) * 3
    (part,) = primary_components(matrix, Poly((s - 3) ** n, s))
    basis, parameters = grassmannian_cell(matrix, part, k, iter(sympy.symbols("x:99")))
    assert len(parameters) == k * (n - k) == continuum_size([(part, k)])[0]
    drawn = Matrix(n, k, lambda i, j: data.draw(st.integers(-3, 3)))
    if drawn[:k, :].det() != 0:  # in the cell: found by its reduced form
        reduced = drawn * drawn[:k, :].inv()
        values = sympy.solve(list(basis - reduced), parameters, dict=True)
        assert len(values) == 1 and (basis.subs(values[0]) - reduced).is_zero_matrix


def loop_of(whole):
    """Plant and compensator with B = C = I whose closed loop is any matrix of even order."""
    n = whole.rows // 2
    one = sympy.eye(n)
    plant = Realisation(whole[:n, :n], one, one, variable="s")
    return plant, Realisation(whole[n:, n:], whole[n:, :n], whole[:n, n:], variable="s")


@pytest.mark.parametrize(
    ("blocks", "others", "dimension", "components"),
    [
        ((1, 1, 1), [5], 2, 1),  # planes in a space of dimension 3: no cyclic one
        ((1, 1, 1, 1), [], 4, 1),
        ((2, 1, 1), [], 2, 2),
        ((2, 2), [], 2, 1),
        ((2, 1), [4], 1, 1),
    ],
)
def test_observer_forms_of_derogatory_loops(blocks, others, dimension, components):
    n = (sum(blocks) + len(others)) // 2
    T = Matrix(2 * n, 2 * n, lambda i, j: 1 if i == j else (i + 2 * j) % 3 - 1 if i > j else 0)
    T = T * T.T if T.det() else T
    J = sympy.diag(Matrix(nilpotent(blocks)) - 2 * sympy.eye(sum(blocks)), *others)
    plant, compensator = loop_of(T * J * T.inv())
    forms = observer_forms(plant, compensator)
    regulator = Poly((s + 2) ** n, s, domain="QQ")
    assert (regulator, dimension, components) in forms.continua
    (family,) = [form for form in forms.families if form.regulator == regulator]
    assert len(family.parameters) == dimension and family.is_verified
    for values in itertools.islice(itertools.product([1, Rational(1, 3), -2], repeat=9), 0, 60, 19):
        try:
            form = family.at(values[:dimension])
        except InputError:  # in the thin set
            continue
        assert form.is_verified and not form.parameters


def test_a_continuum_that_fails_is_rejected_when_all_of_it_is_one_variety():
    """Every plane of a scalar block of four: T is singular for all of them, and it is said so."""
    plant = Realisation(-2 * sympy.eye(2), sympy.eye(2), sympy.eye(2), variable="s")
    zero = sympy.zeros(2, 2)
    compensator = Realisation(-2 * sympy.eye(2), zero, zero, variable="s")
    assert observer_forms(plant, compensator).families[0].parameters
    lost = Realisation(sympy.diag(-2, -3), zero, zero, variable="s")
    forms = observer_forms(plant, lost)
    assert not forms.families and len(forms.rejections) == 2 and not forms.undecided


def test_many_blocks_are_refused_by_the_budget_and_scalar_ones_are_not():
    assert strata((1,) * 30, 15)[0].dimension == 225
    with pytest.raises(BudgetError, match="strata"):
        strata((2, *(1,) * 28), 15)


def test_refusals_name_the_dimension():
    with pytest.raises(InputError, match=r"lengths 1, 1, 1.*dimension 2 for its power 1, 2 for"):
        youla_forms("1/(s + 5)", Realisation(-5 * sympy.eye(2), [[0], [0]], [[0, 0]]))
    (part,) = primary_components(sympy.zeros(4, 4), Poly(s**4, s, domain="QQ"))
    assert next(sample_subspaces(sympy.zeros(4, 4), part, 3)).shape == (4, 3)
