"""The cases of an answer do not depend on what the parameters are called."""

import pytest

import compensator_theory as exact
from tests.support.bad_inputs import GOOD, NOT_DOORS
from tests.support.symbolic_inputs import PUBLIC, calls


def statuses(name, call, symbol):
    """How the cases end; None where the function cannot be asked so."""
    answer = call(symbol)
    try:
        if answer is None:
            return None
        cases = exact.exceptional_cases(PUBLIC[name], *answer[0], cases=5, **answer[1])
        return sorted(case.status for case in cases.cases)
    except exact.CompensatorError:
        return None


@pytest.mark.costly
@pytest.mark.parametrize("name", sorted(set(GOOD) - NOT_DOORS - {"exceptional_cases"}))
def test_parameters_may_be_called_as_variables_are(name):
    left = 2
    for call, argument in calls(name):
        usual = statuses(name, call, "c_user") if left else None
        if usual is None:
            continue
        left -= 1
        for letter in {"q", "z", "s", "y", "x"} - argument:
            result = statuses(name, call, letter)
            assert result in (usual, None), (letter, result, usual)


@pytest.mark.parametrize("letter", "aqzs")
def test_a_case_of_a_matrix_is_closed_whatever_its_symbol_is_called(letter):
    pair = [["p", 0], [0, letter]], [["p"], [letter]]
    assert exact.exceptional_cases(exact.is_controllable, *pair).is_complete
    assert exact.exceptional_cases(exact.solve_lyapunov, [[letter]], [[1]]).is_complete
    assert exact.exceptional_cases(exact.uncontrollable_polynomial, *pair).is_complete


def test_symbols_of_an_answer_are_no_arguments():
    """1 + w**2 y**2 is 1/cos(w T/2)**2, which is not 0; exp(-a T) = 1 is a = 0."""
    hold, matched = exact.sampling.zero_order_hold, exact.sampling.matched
    (case,) = exact.exceptional_cases(hold, "1/(s**2 + w**2)", "T", variable="s").cases
    assert case.conditions == "always"
    cases = exact.exceptional_cases(matched, "(s + a)/(s + b)", "T", variable="s")
    assert cases.is_complete and cases.at({"a": 0, "b": 1, "T": 1}).status == "answered"
