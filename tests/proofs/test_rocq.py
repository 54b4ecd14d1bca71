"""The question to Coq: asked of theorems that are proved, admitted, axiomatic and missing."""

import shutil

import pytest

from proofs.assumptions import check_file, read_answers, report
from proofs.rocq_build import compile_formal_part
from proofs.rocq_sources import SOURCES, assumed, missing, stated, without_comments

PROVED = """
(* Theorem in_a_comment : False. (* nested *) *)
Theorem one_is_one : 1 = 1.
Proof. reflexivity. Qed.
"""
IN_SECTIONS = """
Section Outer.
Variable n : nat.
Hypothesis positive : 0 < n.
Context (small : n < 9).
Section Closed.
Hypothesis elsewhere : 1 < n.
End Closed.
Theorem there_is_a_predecessor : exists m,
  n = S m.
Proof. destruct n. inversion positive. eauto. Qed.
End Outer.
"""
ADMITTED = """
From Compensators Require Import Proved.
Theorem two_is_one : 2 = 1.
Proof. Admitted.
Theorem rests_on_it : 2 = 1 /\\ 1 = 1.
Proof. split. exact two_is_one. exact one_is_one. Qed.
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "Proved.v").write_text(PROVED)
    (tmp_path / "Assumed.v").write_text(ADMITTED)
    for name in ("Makefile", "_CoqProject"):
        shutil.copy(SOURCES / name, tmp_path)
    return tmp_path


def test_theorems_are_found_in_the_files(folder):
    assert missing("Proved.one_is_one", folder) == ""
    assert missing("Proved.in_a_comment", folder) == "Proved.v states no theorem in_a_comment"
    assert missing("Absent.x", folder) == "proofs/rocq has no file Absent.v"
    assert stated("Proved.one_is_one", folder) == "Theorem one_is_one : 1 = 1."
    (folder / "Sections.v").write_text(IN_SECTIONS)
    assert stated("Sections.there_is_a_predecessor", folder).splitlines() == [
        "Hypothesis positive : 0 < n.",
        "Context (small : n < 9).",
        "Theorem there_is_a_predecessor : exists m,",
        "  n = S m.",
    ]
    assert assumed(folder) == ("Assumed.v: Admitted",)
    assert without_comments("(* a (* b *) c *)x(**)") == "x"


def test_the_question_requires_each_file_once():
    lines = check_file(["A.x", "A.y", "B.z"]).splitlines()
    assert lines[:2] == ["From Compensators Require A.", "From Compensators Require B."]
    assert sum(line.startswith("Print Assumptions") for line in lines) == 3


def test_answers_of_several_lines():
    output = """==> A.x
Closed under the global context
==> A.y
Axioms:
two_is_one : 2 = 1
classic : forall P : Prop,
          P
==> A.z
"""
    assert read_answers(output) == {
        "A.x": "",
        "A.y": "two_is_one : 2 = 1 classic : forall P : Prop, P",
        "A.z": "?",
    }


def test_the_report_fails_for_anything_assumed():
    assert report({"A.x": ""}, [])[1] is True
    assert report({"A.x": ""}, ["A.v: Admitted"])[1] is False
    assert report({"A.x": "rests on axioms: y"}, [])[1] is False


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("Axiom a : False.", "Axiom"),
        ("Local Axiom a : False.", "Local Axiom"),
        ("#[local] Parameter a : False.", "#[local] Parameter"),
        ("Unset Guard Checking.", "Unset Guard Checking"),
        ("Unset  Universe\nChecking.", "Unset  Universe\nChecking"),
        ("#[bypass_check(guard)] Fixpoint f (n : nat) : False := f n.", "bypass_check"),
    ],
)
def test_every_way_to_assume_is_found(tmp_path, line, word):
    (tmp_path / "A.v").write_text(f"(* Axiom *)\n{line}\n")
    assert assumed(tmp_path) == (f"A.v: {word}",)


@pytest.mark.skipif(shutil.which("coqc") is None, reason="Coq is not installed")
def test_an_older_compilation_answers_for_nothing(tmp_path):
    for name in ("Makefile", "_CoqProject"):
        shutil.copy(SOURCES / name, tmp_path)
    (tmp_path / "Base.v").write_text("Theorem base : 1 = 1. Proof. reflexivity. Qed.")
    (tmp_path / "User.v").write_text(
        "From Compensators Require Import Base.\nTheorem user : 1 = 1. Proof. exact base. Qed."
    )
    (tmp_path / "Alone.v").write_text("Theorem alone : 2 = 2. Proof. reflexivity. Qed.")
    names = ["Base.base", "User.user", "Alone.alone"]
    assert compile_formal_part(names, tmp_path).holds
    (tmp_path / "Base.v").write_text("Theorem base : 1 = 2. Proof. reflexivity. Qed.")
    found = compile_formal_part(names, tmp_path)
    assert found.status == "failed"
    assert found.answers == {
        "Base.base": "Base.v does not compile",
        "User.user": "User.v does not compile",
        "Alone.alone": "",
    }


@pytest.mark.skipif(shutil.which("coqc") is None, reason="Coq is not installed")
def test_coq_is_asked(folder):
    names = ["Proved.one_is_one", "Assumed.rests_on_it", "Assumed.nothing", "Absent.x"]
    found = compile_formal_part(names, folder)
    assert found.status == "compiled" and not found.holds
    assert found.answers["Proved.one_is_one"] == ""
    assert found.answers["Assumed.rests_on_it"].startswith("rests on axioms: Assumed.two_is_one")
    assert found.answers["Assumed.nothing"] == "Assumed.v states no theorem nothing"
    assert found.answers["Absent.x"] == "proofs/rocq has no file Absent.v"


@pytest.mark.skipif(shutil.which("coqc") is None, reason="Coq is not installed")
def test_a_file_that_does_not_compile_fails_and_the_others_are_asked(folder):
    (folder / "Wrong.v").write_text("Theorem wrong : 1 = 2. Proof. reflexivity. Qed.")
    found = compile_formal_part(["Wrong.wrong", "Proved.one_is_one"], folder)
    assert found.status == "failed" and "Wrong.v" in found.detail
    assert found.answers == {"Wrong.wrong": "Wrong.v does not compile", "Proved.one_is_one": ""}
