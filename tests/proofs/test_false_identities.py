"""A false identity is not confirmed: every sign of the symbolic part is flipped in turn."""

import ast
import inspect
from types import SimpleNamespace

import pytest
from hypothesis import Phase, find, settings
from hypothesis import strategies as st

from compensator_theory.bezout import sylvester_m, sylvester_m1, sylvester_m2
from proofs.counterexamples import placement, theorem_1
from proofs.ledger.checks import for_all, run_counterexample, run_property, run_symbolic
from proofs.ledger.entries import Counterexample, Property, Symbolic
from proofs.properties import forms, observer_based, polynomials
from proofs.properties import least_squares as recursions
from proofs.symbolic import (
    coefficients,
    duality,
    intercalation,
    least_squares,
    return_difference,
    separation,
)
from proofs.symbolic.coefficients import polynomials_of


def signs(tree):
    """The binary sums and differences of the checks and of what they are built from."""
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub)
    ]


def confirmed(tree, module):
    """Whether every check of the changed module is confirmed."""
    namespace = {"__name__": module.__name__, "__package__": module.__package__}
    exec(compile(tree, module.__file__, "exec"), namespace)
    checks = [
        value
        for name, value in namespace.items()
        if inspect.isfunction(value)
        and value.__module__ == module.__name__
        and value.__annotations__.get("return") is bool
        and name[0] != "_"
    ]
    return all(check() for check in checks)


HARMLESS = {"k + i"}  # the index of y in (4.7), which stands on both sides
MODULES = (separation, return_difference, least_squares, duality, intercalation)


@pytest.mark.slow
@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.split(".")[-1])
def test_every_flipped_sign_is_noticed(module):
    source = inspect.getsource(module)
    count = len(signs(ast.parse(source)))
    assert count > 3 and confirmed(ast.parse(source), module)
    unnoticed = []
    for i in range(count):
        tree = ast.parse(source)
        node = signs(tree)[i]
        node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        try:
            if confirmed(tree, module):
                unnoticed.append(ast.unparse(node))
        except (ValueError, TypeError, IndexError, RecursionError):
            pass  # a check that cannot be computed confirms nothing
    assert set(unnoticed) <= HARMLESS


@pytest.mark.parametrize(
    ("name", "wrong", "check"),
    [
        ("sylvester_m", lambda D, N, *rest: sylvester_m(D, -N, *rest), "placement_equation"),
        ("sylvester_m1", lambda a, b, k, l: 2 * sylvester_m1(a, b, k, l), "resultant_determinants"),
        ("sylvester_m2", lambda a, b: sylvester_m2(b, a), "resultant_determinants"),
        ("polynomials_of", lambda A, B, C: polynomials_of(A, B, 2 * C), "closed_loop_polynomial"),
        ("polynomials_of", lambda A, B, C: polynomials_of(A, 2 * B, C), "separated_polynomial"),
        ("_on_circle", lambda p: p * p, "reflected_spectrum"),
    ],
)  # fmt: skip
def test_a_wrong_matrix_or_polynomial_is_noticed(monkeypatch, name, wrong, check):
    evidence = Symbolic(f"coefficients.{check}", (1, 2))
    assert run_symbolic(evidence).status == "holds"
    monkeypatch.setattr(coefficients, name, wrong)
    result = run_symbolic(evidence)
    assert result.status == "fails" and "false for sizes" in result.detail


@pytest.mark.costly
@pytest.mark.parametrize(
    ("module", "name", "wrong", "check"),
    [
        (polynomials, "sylvester_m1", lambda a, b, k, l: sylvester_m1(b, a, l, k)[:, :-1] * 0,
         "rank_of_m1"),
        (observer_based, "real_share", lambda roots, n: None, "theorem_1_pairs"),
        (forms, "count_observer_forms", lambda poly, n: 1, "as_many_as_divisors"),
        (recursions, "batch", lambda *data: data[2], "recursion_is_batch"),
    ],
)  # fmt: skip
def test_a_false_property_is_refuted(monkeypatch, module, name, wrong, check):
    monkeypatch.setattr(module, name, wrong)
    short = module.__name__.split(".")[-1]
    result = run_property(Property(f"{short}.{check}", 50))
    assert result.status == "fails"
    assert result.detail.startswith("false for ")


@pytest.mark.parametrize(
    ("module", "name", "wrong", "check"),
    [
        (theorem_1, "number_of_real_roots", lambda p: p.count_roots(), "multiplicity"),
        (theorem_1, "is_lqg_suboptimal", lambda *a, **k: SimpleNamespace(answer=True),
         "suboptimality"),
        (placement, "determinant", lambda matrix: 0, "more_states_than_the_plant"),
    ],
)  # fmt: skip
def test_a_counterexample_that_is_none_is_noticed(monkeypatch, module, name, wrong, check):
    short = module.__name__.split(".")[-1]
    evidence = Counterexample("a wording", f"{short}.{check}")
    assert run_counterexample(evidence).status == "holds"
    monkeypatch.setattr(module, name, wrong)
    result = run_counterexample(evidence)
    assert result.status == "fails" and result.detail.startswith("not so: ")


def test_the_smallest_refutation_is_shown_and_errors_confirm_nothing(monkeypatch):
    @for_all(x=st.integers(0, 100))
    def below(x):
        """Every number is below 17."""
        return x < 17

    assert below.run(examples=200).detail == "false for x = 17"

    @for_all(x=st.integers())
    def broken(x):
        """A property that cannot be computed."""
        return 1 / 0

    monkeypatch.setattr(polynomials, "lemma_1", broken)
    result = run_property(Property("polynomials.lemma_1", 5))
    assert (result.status, result.detail) == ("fails", "ZeroDivisionError: division by zero")
    monkeypatch.setattr(separation, "similarity", lambda: 1 / 0)
    assert run_symbolic(Symbolic("separation.similarity")).status == "fails"
    monkeypatch.setattr(theorem_1, "multiplicity", lambda: 1 / 0)
    assert run_counterexample(Counterexample("", "theorem_1.multiplicity")).status == "fails"
    monkeypatch.setattr(theorem_1, "multiplicity", lambda: iter([("1 = 1", "yes")]))
    assert run_counterexample(Counterexample("", "theorem_1.multiplicity")).status == "fails"
    monkeypatch.setattr(theorem_1, "multiplicity", lambda: iter(()))
    assert run_counterexample(Counterexample("", "theorem_1.multiplicity")).status == "fails"


def test_lemma_1_meets_pairs_that_satisfy_its_equation():
    case = polynomials.unequal_degrees().flatmap(
        lambda d: st.tuples(st.just(d), polynomials.pairs(d))
    )

    def satisfied(drawn):
        (p, q), (a, b) = drawn
        return (b * q + a * p).is_zero and not b.is_zero

    first = settings(database=None, phases=[Phase.generate])  # not the smallest one
    _, (a, b) = find(case, satisfied, settings=first)
    assert a.degree() > b.degree()  # what the lemma excludes


@pytest.mark.parametrize(
    "answer", [None, "yes", 1, (x for x in "yes")], ids=lambda a: type(a).__name__
)
def test_only_true_confirms(monkeypatch, answer):
    monkeypatch.setattr(separation, "similarity", lambda: answer)
    assert run_symbolic(Symbolic("separation.similarity")).status == "fails"

    @for_all(x=st.integers())
    def vague(x):
        """A predicate without an answer."""
        return answer

    monkeypatch.setattr(polynomials, "lemma_1", vague)
    assert run_property(Property("polynomials.lemma_1", 5)).status == "fails"
