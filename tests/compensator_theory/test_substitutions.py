"""Whatever takes values for symbols takes them as SymPy does, in each of its idioms."""

import inspect

import pytest
import sympy
from sympy import Rational, Symbol, symbols

import compensator_theory as exact
from compensator_theory import results

a, b = symbols("a b")
MATRICES = [["a", "b"], [0, 1]], [[1], [1]], [[1, "b"]]
EXAMPLES = [
    exact.transfer_function("b/(s + a)", "s"),
    exact.transfer_function("exp(-b*s)/(s + a)", "s"),
    exact.transfer_matrix([["1/(s + a)", "b/s"]], "s"),
    exact.Realisation(*MATRICES),
    exact.DescriptorSystem([[1, 0], [0, "b"]], *MATRICES),
    exact.standard_problem("(q - b)/(q**2 - a)", "q"),
    exact.polynomial_matrix([["s + a", "b"]], "s"),
    exact.riccati_formula([["b"]], [[1]], Q=[["a"]], R=[[1]], time="continuous"),
    exact.exceptional_cases(exact.solve_diophantine, "s - a", "s - b", "1", variable="s"),
    exact.exceptional_cases(exact.solve_diophantine, "s - a", "s - b", "1", variable="s").cases[0],
]
"""One of each class that takes values for symbols, with the symbols a and b."""
POSITIVE = Symbol("a", positive=True), Symbol("b", positive=True)
IDIOMS = [
    {"a": 2, "b": "1/2"},
    {a: 2, b: Rational(1, 2)},
    {"a": 2, b: 0.5},
    dict(zip(POSITIVE, (2, 0.5), strict=True)),
    sympy.Dict({a: 2, b: Rational(1, 2)}),
    [(a, 2), (b, Rational(1, 2))],
    (("a", "2"), ("b", "1/2")),
    [("b", "a/4"), ("a", 2)],  # one after the other
]


def methods(kind):
    """The methods that take values for symbols."""
    for name, method in inspect.getmembers_static(kind, inspect.isfunction):
        argument = [str(one.annotation) for one in inspect.signature(method).parameters.values()]
        if not name.startswith("_") and any("Substitutions" in kind for kind in argument):
            yield name


def public_classes():
    for module in (exact, results):
        for name in dir(module):
            kind = getattr(module, name)
            if inspect.isclass(kind):
                yield kind


def test_every_class_that_takes_values_has_an_example():
    taking = {kind for kind in public_classes() if [*methods(kind)]}
    assert taking == {type(example) for example in EXAMPLES}


def test_there_is_one_reader_of_values():
    """No public method or function has a type of its own for them, and subs is always of it."""
    for kind in public_classes():
        for name, method in inspect.getmembers_static(kind, inspect.isfunction):
            if not name.startswith("_"):
                assert "Mapping[str | Symbol" not in str(inspect.signature(method)), (kind, name)
                assert name != "subs" or name in methods(kind)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: type(example).__name__)
def test_idioms_of_sympy(example):
    for name in methods(type(example)):
        method = getattr(example, name)
        first, *others = (method(values) for values in IDIOMS)
        assert all(result == first for result in others)
        for refused in ({a}, 3, "a", [("a", 1, 2)], [a, 2], None):
            with pytest.raises(exact.InputError):
                method(refused)
        for values in ({a: 2}, [(b, 1)]):  # SymPy's third way is that of one symbol
            ((symbol, number),) = dict(values).items()
            for pair in ((symbol, number), (symbol.name, number)):
                assert answer(method, *pair) == answer(method, values)


def answer(method, *arguments):
    """What it answers, or the words of its refusal."""
    try:
        return method(*arguments)
    except exact.InputError as error:
        return str(error)


def test_a_formula_names_what_is_missing():
    formula = exact.riccati_formula([["b"]], [[1]], Q=[["a"]], R=[[1]], time="continuous")
    with pytest.raises(exact.InputError, match="give a value for b, too"):
        formula.at("a", 2)
    assert formula.at({"a": 2, "b": 1, "c": 3}) == formula.at({"a": 2, "b": 1})


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda one: type(one).__name__)
def test_of_several_values_those_of_symbols_that_do_not_occur_change_nothing(example):
    """As in SymPy, where one table of values serves many expressions."""
    for name in methods(type(example)):
        plain, more = {"a": 2, "b": "1/2"}, {"a": 2, "c": 7, "b": "1/2", "tau": 0}
        assert getattr(example, name)(more) == getattr(example, name)(plain)
        assert getattr(example, name)([*more.items()]) == getattr(example, name)(plain)
