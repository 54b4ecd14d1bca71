"""Names of other programs are answered by what is typed here, which exists."""

import copy
import pickle
import re

import pytest

import compensator_theory as exact
from compensator_theory.libraries import _FUNCTIONS_OF_SYSTEMS, ELSEWHERE

SYSTEMS = [
    exact.transfer_function("1/(s + 1)"),
    exact.realisation("1/(s + 1)"),
    exact.transfer_matrix([["1/(s + 1)"]]),
]
TABLES = {**ELSEWHERE, **_FUNCTIONS_OF_SYSTEMS}


@pytest.mark.parametrize("name", sorted(ELSEWHERE))
def test_a_name_of_another_program_leads_to_ours(name):
    with pytest.raises(AttributeError, match=r"has no attribute .*; write ") as refused:
        getattr(exact, name)
    assert ELSEWHERE[name] in str(refused.value)


@pytest.mark.parametrize("name", sorted(TABLES))
def test_what_is_to_be_typed_exists(name):
    typed = TABLES[name]
    code = re.sub("'[^']*'", "text", typed)
    functions = re.findall(r"(?<![\w.])([a-z_]+(?:\.[a-z_]+)?)\(", code)
    for function in functions:
        owner = exact
        for part in function.split("."):
            owner = getattr(owner, part)
        assert callable(owner)
    for method in re.findall(r"\bG\.([a-z_]+)", typed):
        assert hasattr(SYSTEMS[0], method)


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: type(system).__name__)
def test_a_missing_attribute_of_a_system(system):
    with pytest.raises(AttributeError, match=r"write step_response\(G\)"):
        system.step_response()
    with pytest.raises(AttributeError, match=r"has no attribute 'nothing'$"):
        _ = system.nothing
    assert not hasattr(system, "__array__") and not hasattr(system, "_repr_html_")
    assert copy.deepcopy(system) == pickle.loads(pickle.dumps(system)) == system


@pytest.mark.parametrize(
    "call",
    [
        exact.stability_margins,
        exact.root_locus,
        lambda G: exact.feedback_connection(G, 1),
        lambda G: exact.place_poles(G, [-1]),
        exact.stabilising_gains,
        lambda G: exact.sensitivity_function(G, 1),
    ],
)
def test_a_missing_sign_is_asked_for_by_its_two_meanings(call):
    with pytest.raises(TypeError, match=r"feedback=-1 for u = -K y.*feedback=1 for u = K y"):
        call(SYSTEMS[0])


def test_the_number_zero_is_a_zero_matrix():
    plant = exact.Realisation([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0)
    assert plant == exact.Realisation([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    with pytest.raises(exact.InputError, match="D = 1"):
        exact.Realisation([[0]], [[1]], [[1]], 1)


def test_numerator_and_denominator_as_two_lists_lead_to_the_call():
    with pytest.raises(exact.InputError) as refused:
        exact.transfer_function([1], [1, 2])
    (call,) = re.findall(r"transfer_function\(.*?'s'\)", str(refused.value))
    assert eval(f"exact.{call}", {"exact": exact}) == exact.transfer_function("1/(s + 2)")
