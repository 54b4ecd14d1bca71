"""``python -m proofs``: what it prints, its JSON, its exit status."""

import json
import re

import pytest
from click.testing import CliRunner

from proofs.__main__ import main
from proofs.formal import rocq_build
from proofs.formal.rocq_sources import SOURCES
from proofs.symbolic import separation


def run(*arguments):
    return CliRunner().invoke(main, list(arguments))


def refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def test_it_prints_statement_text_difference_and_evidence():
    outcome = run("theorem-a1", "--quick")
    assert outcome.exit_code == 0
    words = " ".join(outcome.stdout.split())
    for part in ("a_k is not 0", "l <= k is not needed", "polynomials.rank_of_m1", "refuted",
                 "Quick: a tenth of the examples", "1 entry"):  # fmt: skip
        assert part in words, part


def test_json_is_one_strict_object():
    outcome = run("B", "--quick", "--json")
    assert outcome.exit_code == 0
    record = json.loads(outcome.stdout, parse_constant=refuse)
    assert record["holds"] is True and record["effort"] == "quick"
    assert record["formal"]["status"] == "not asked"
    assert [entry["name"] for entry in record["entries"]] == [
        "theorem-a1", "theorem-a2", "resultant-determinants",
    ]  # fmt: skip
    for entry in record["entries"]:
        for evidence in entry["evidence"]:
            assert evidence["status"] in ("holds", "fails", "not compiled", "missing")
            if evidence["kind"] == "counterexample":
                assert evidence["facts"] and all(fact["holds"] for fact in evidence["facts"])
            if evidence["kind"] == "property":
                assert re.match(r"\d+ examples of ", evidence["scope"])


def test_what_fails_is_named_and_the_exit_status_says_so(monkeypatch):
    monkeypatch.setattr(separation, "similarity", lambda: False)
    outcome = run("separation")
    assert outcome.exit_code == 1
    assert "FAILS  separation: separation.similarity: the sides differ" in outcome.stdout
    record = json.loads(run("separation", "--json").stdout)
    assert record["holds"] is False and record["entries"][0]["holds"] is False


def test_names_are_whole_on_a_narrow_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "50")
    printed = "".join(run("hidden-mode-rule", "--quick").stdout.split())
    assert "counterexamples.Realisations.hidden_mode_is_double_pole" in printed


def test_unknown_names_are_refused():
    outcome = run("lemma-7")
    assert outcome.exit_code == 2 and "no entry or chapter lemma-7" in outcome.stderr


def test_names_only():
    outcome = run("--list", "8")
    assert outcome.exit_code == 0
    assert [line.split()[1] for line in outcome.stdout.splitlines()] == [
        "riccati-duality", "forward-riccati", "forward-riccati-limit", "forward-riccati-observer",
        "subsystem-recursion", "retrospective-input", "extended-performance",
        "unscented-transformation",
        "unscented-filter", "past-inputs",
    ]  # fmt: skip


def test_without_coq_it_says_so(monkeypatch):
    monkeypatch.setattr(rocq_build.shutil, "which", lambda tool: None)
    outcome = run("lemma-1", "--quick", "--formal")
    words = " ".join(outcome.stdout.split())
    assert outcome.exit_code == 0
    assert "The formal part was NOT compiled: coqc, coq_makefile, make not found" in words
    assert "machine-checked" not in words
    record = json.loads(run("lemma-1", "--quick", "--formal", "--json").stdout)
    assert record["formal"]["status"] == "not installed"


def test_without_hypothesis_it_says_what_to_install(monkeypatch):
    import builtins
    import sys

    real = builtins.__import__

    def without(name, *rest):
        if name.split(".")[0] == "hypothesis":
            raise ModuleNotFoundError("No module named 'hypothesis'", name="hypothesis")
        return real(name, *rest)

    for module in [m for m in sys.modules if m.startswith("proofs.properties.polynomials")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setattr(builtins, "__import__", without)
    outcome = run("lemma-1", "--quick")
    assert outcome.exit_code == 2 and "pip install 'compensator-theory[test]'" in outcome.stderr


@pytest.mark.parametrize("formal", [True, False])
def test_a_theorem_counts_as_machine_checked_only_where_coq_said_so(monkeypatch, formal):
    answers = {"theorems.Diophantine.lemma_1": ""}
    compiled = rocq_build.Compilation("compiled", "the formal part compiles", answers)
    monkeypatch.setattr("proofs.__main__.compile_formal_part", lambda theorems: compiled)
    record = json.loads(run("lemma-1", "--quick", "--json", *["--formal"] * formal).stdout)
    expected = "machine-checked" if formal else "property-tested"
    assert record["entries"][0]["strength"] == expected


def test_an_axiom_fails(monkeypatch):
    answers = {"theorems.Diophantine.lemma_1": "rests on axioms: classic"}
    compiled = rocq_build.Compilation("compiled", "the formal part compiles", answers)
    monkeypatch.setattr("proofs.__main__.compile_formal_part", lambda theorems: compiled)
    outcome = run("lemma-1", "--quick", "--formal")
    assert outcome.exit_code == 1 and "rests on axioms: classic" in outcome.stdout


def test_the_formal_part_has_its_makefile():
    text = (SOURCES / "Makefile").read_text()
    assert "check: all" in text and "proofs.ledger.formal_check" in text


def test_a_theorem_about_a_part_is_no_proof_of_the_whole(monkeypatch):
    answers = {"theorems.InvariantSubspaces.invariant_subspace_is_a_graph": ""}
    compiled = rocq_build.Compilation("compiled", "the formal part compiles", answers)
    monkeypatch.setattr("proofs.__main__.compile_formal_part", lambda theorems: compiled)
    record = json.loads(run("youla-chains", "--quick", "--json", "--formal").stdout)
    assert record["entries"][0]["strength"] == "machine-checked in part"
