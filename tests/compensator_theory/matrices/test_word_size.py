"""The same answers with the primes of 32-bit words, as under Pyodide and on ARM."""

import flint
import pytest

import compensator_theory as ct
from compensator_theory.forms import frobenius_form, kronecker_form, minimal_basis
from compensator_theory.matrices import _residues

SPRINGS = [[0, 1, 0, 0], [-2, 0, 1, 0], [0, 0, 0, 1], [1, 0, -2, 0]]
LONG = "s**{0} + 3*s**{1} + 12345678901234567890/7"


def coprime_equation():
    return ct.solve_diophantine(LONG.format(24, 5), LONG.format(23, 7), "1")


def lyapunov():
    A = [[-(3 + i) if i == j else (i * j) % 3 for j in range(8)] for i in range(8)]
    return ct.solve_lyapunov(A, [[int(i == j) for j in range(8)] for i in range(8)]).X


@pytest.mark.parametrize(
    "question",
    [
        coprime_equation,
        lyapunov,
        lambda: ct.is_controllable(SPRINGS, [[0], [1], [0], [0]]),
        lambda: frobenius_form(SPRINGS),
        lambda: kronecker_form([[1, 2, 3], [4, 5, 6]], [[1, 0, 1], [0, 1, 1]]),
        lambda: minimal_basis([["s**2 + 1", "s", "s**3"]]),
        lambda: ct.solve_matrix_diophantine([["s - 1"]], [["s"]], [["s**2"]]),
        lambda: ct.observers.realisation_is_observer_based(
            ct.realisation("1/(s - 1)"), ct.realisation("-24/(s**2 + 7*s + 18)"), feedback=1
        ),
    ],
)
def test_answers_do_not_depend_on_the_word(question, monkeypatch):
    answers = []
    for word in (31, 62):
        monkeypatch.setattr(_residues, "WORD", word)
        answers.append(question())
    assert answers[0] == answers[1]


@pytest.mark.parametrize("word", [31, 62])
def test_primes_fit_the_word(word, monkeypatch):
    monkeypatch.setattr(_residues, "WORD", word)
    prime = _residues.large_prime()
    assert prime.bit_length() == word and flint.fmpz(prime).is_prime()
