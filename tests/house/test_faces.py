"""One question, one face: both libraries answer under one name, alike.

The table is that of docs/exact-or-numeric.md. A function that both libraries have is a row of
it, so that a new one is held by itself.
"""

import importlib
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import compensator_theory as exact
import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError
from docs.reference_pages import public_names, public_path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "exact-or-numeric.md"
FIRST = re.compile(
    r"\| (?P<question>[^|]+) \| \{py:func\}`~(?P<exact>[\w.]+)`"
    r" \| \{py:func\}`~(?P<numeric>[\w.]+)`"
    r" \| (?P<attributes>[^|]*)\| (?P<when>[^|]+) \|"
)
# Arguments that the exact half has alone: how many digits, and the letter of its polynomials.
OF_EXACT_ALONE = {
    "lqg_controller": {"digits"},
    "solve_riccati": {"digits", "variable"},
    "high_authority_target": {"digits"},
}


def read(path):
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(module), name)


ROWS = {}
for row in FIRST.finditer(PAGE.read_text(encoding="utf-8")):
    paths = row["exact"], row["numeric"]
    names = {path.rpartition(".")[2] for path in paths}
    assert len(names) == 1, paths
    attributes = re.findall(r"`(\w+)`", row["attributes"])
    ROWS[names.pop()] = (*map(read, paths), attributes, paths)


def functions(package):
    result = {}
    for name in public_names(package):
        value = read(public_path(package, name))
        if inspect.isfunction(value):
            result[name] = value
    return result


def test_every_function_that_both_have_is_a_row():
    exacts, numerics = functions("compensator_theory"), functions("rcac_numeric")
    assert len(exacts) > 100 and len(numerics) > 80
    assert {*exacts} & {*numerics} == {*ROWS}
    for name, (one, other, _, _) in ROWS.items():
        assert (exacts[name], numerics[name]) == (one, other)


@pytest.mark.parametrize("name", ROWS)
def test_arguments_have_the_same_names_in_the_same_order(name):
    one, other, _, _ = ROWS[name]

    def arguments(function, *, keyword):
        kinds = inspect.signature(function).parameters.items()
        return [n for n, p in kinds if (p.kind is p.KEYWORD_ONLY) == keyword]

    assert arguments(one, keyword=False) == arguments(other, keyword=False)
    mine, theirs = arguments(one, keyword=True), arguments(other, keyword=True)
    alone = OF_EXACT_ALONE.get(name, set())
    assert {*mine} - {*theirs} == alone
    shared = [n for n in theirs if n in mine]
    assert shared == [n for n in mine if n not in alone]


@pytest.mark.parametrize("name", ROWS)
def test_each_names_the_other(name):
    one, other, _, paths = ROWS[name]
    assert f"``{paths[1]}``" in inspect.getdoc(one), "the docstring of the exact half"
    assert paths[0] in inspect.getdoc(other), "the docstring of the numeric half"


def coefficients(target):
    """Numerator and denominator of a scalar target model, by descending powers of q."""
    numerator, denominator = target.numerator, target.denominator
    if isinstance(numerator, np.ndarray):
        return np.trim_zeros(numerator.ravel(), "f"), denominator.ravel()
    top, bottom = ([float(c) for c in p.coefficients] for p in (numerator, denominator))
    return top, bottom


def in_directions(target):
    """The taps of a filter in q with two inputs and outputs."""
    if hasattr(target, "transfer_matrix"):
        target = rcac.target_model(target.transfer_matrix)
    return target.numerator


def floats(*values):
    return [np.array(value, dtype=float).ravel() for value in values]


# Arguments that both read, options, and numbers of the answer that agree.
EXAMPLES = {
    "stability_margins": (
        ("1/(z - 1)", "(z - 1/4)/(2*(z + 1/3))"), {"feedback": -1},
        lambda f: floats(
            f.is_stable, *(getattr(f, m).value for m in ("gain_up", "gain_down", "phase", "delay")),
            f.phase.frequency, f.disk.alpha, f.disk.gain, f.disk.phase,
            f.disk.S_peak, f.disk.T_peak,
        ),
    ),
    "observer_forms": (
        ("4/((s + 1)*(s + 3))", "(33/4*s + 93/4)/(s**2 + 13*s + 49)"), {"feedback": -1},
        lambda f: floats(
            len(f.forms), f.plant.A, f.compensator.C,
            *(part for form in (f.best_conditioned(), f.fastest_observer(),
                                f.closest_to([[-5, -7]], [[2], [1]]))
              for part in (form.T, form.K, form.F)),
        ),
    ),
    "lqg_controller": (
        (exact.standard_problem("(q - 2)/(q**2 - 1/4)"),), {},
        lambda f: floats(f.cost, f.regulator.P, f.regulator.K, f.estimator.P, f.estimator.K),
    ),
    "solve_riccati": (
        ([[2, -1], [1, 0]], [[1], [0]], [[1, 0], [0, 2]], [[1]], [[0], [1]]), {"time": "discrete"},
        lambda f: floats(f.A, f.B, f.Q, f.R, f.N, f.P, f.K),
    ),
    "markov_parameters": (
        ("(z + 5)/(z**2 - z/2 + 1/8)", 6), {}, floats,
    ),
    "zero_direction_target": (
        ([[1, 0], [0, 2]], [(1.5, [1, -1])]), {"delays": 2, "taps": 1},
        lambda f: floats(in_directions(f)),
    ),
    "high_authority_target": (
        (exact.standard_problem("(q - 2)/(q**2 - 1/4)"),), {}, lambda f: floats(*coefficients(f)),
    ),
}  # fmt: skip
# Of the same function again, in the other time.
AGAIN = {
    "solve_riccati": (
        (), {"A": [[0, 1], [0, 0]], "B": [[0], [1]], "E_1": [[1, 0], [0, 0]], "E_2": [[0], [2]],
             "time": "continuous"},
        EXAMPLES["solve_riccati"][2],
    ),
    "observer_forms": (
        ("1/(z*(z - 1/2))", "(z/3 - 1/7)/(z**2 + z/5 + 1/11)"), {},
        lambda f: floats(f.plant.A, f.compensator.C),
    ),
    "stability_margins": (  # unstable
        ("2/(z - 2)", "z/(z - 1/2)"), {"feedback": 1},
        lambda f: floats(f.is_stable, f.gain_up is None, f.phase is None, f.disk is None),
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "example"),
    [*EXAMPLES.items(), *AGAIN.items()],
    ids=[*EXAMPLES, *(f"{name} again" for name in AGAIN)],
)
def test_both_answer_the_same(name, example):
    one, other, attributes, _ = ROWS[name]
    arguments, options, numbers = example
    mine, theirs = one(*arguments, **options), other(*arguments, **options)
    for attribute in attributes:
        assert hasattr(mine, attribute) and hasattr(theirs, attribute), attribute
    for a, b in zip(numbers(mine), numbers(theirs), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-9)


def test_every_row_has_an_example():
    assert {*EXAMPLES} == {*ROWS}


# Who cannot answer, and what its error says of the other half.
CANNOT = {
    "margins of a loop in s": (
        lambda: rcac.stability_margins("1/(s + 1)", feedback=-1),
        lambda: exact.stability_margins("1/(s + 1)", feedback=-1),
        "compensator_theory.stability_margins",
    ),
    "margins of an all-pass loop": (
        lambda: rcac.stability_margins("(1 - 2*z)/(z - 2)", feedback=-1),
        lambda: exact.stability_margins("(1 - 2*z)/(z - 2)", feedback=-1),
        "compensator_theory.stability_margins",
    ),
    "LQG in continuous time": (
        lambda: rcac.lqg_controller(exact.standard_problem("1/(s + 1)")),
        None,
        "compensator_theory",
    ),
    "LQG of a Plant": (
        lambda: exact.lqg_controller(rcac.standard_plant("1/(q - 2)")),
        lambda: rcac.lqg_controller(rcac.standard_plant("1/(q - 2)")),
        "rcac_numeric.lqg_controller",
    ),
    "a continuum of forms": (
        lambda: rcac.observer_forms(
            exact.Realisation([[1, 0], [0, 1]], [[1], [0]], [[1, 0]], variable="s"),
            exact.Realisation([[1, 0], [0, 1]], [[0], [1]], [[0, 1]], variable="s"),
        ),
        None,
        "compensator_theory.observer_forms",
    ),
    "more forms than the limit": (
        lambda: exact.observer_forms(
            "4/(s**2 + 4*s + 3)", "-(33/4*s + 93/4)/(s**2 + 13*s + 49)", limit=1
        ),
        lambda: rcac.observer_forms("4/(s**2 + 4*s + 3)", "-(33/4*s + 93/4)/(s**2 + 13*s + 49)"),
        "rcac_numeric.observer_forms",
    ),
}


@pytest.mark.parametrize("name", CANNOT)
def test_who_cannot_answer_names_who_can(name):
    refused, answered, words = CANNOT[name]
    with pytest.raises(CompensatorError, match=re.escape(words)):
        refused()
    if answered is not None:
        assert answered() is not None
