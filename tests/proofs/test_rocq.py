"""The question to Coq: asked of theorems that are proved, admitted, axiomatic and missing."""

import shutil

import pytest

from proofs.formal.assumptions import axioms
from proofs.formal.questions import question_file, read_answers
from proofs.formal.rocq_build import compile_formal_part
from proofs.formal.rocq_sources import (
    SOURCES,
    assumed,
    defined,
    missing,
    stated,
    without_comments,
)
from proofs.formal.types import changed, commit, committed, printed_statements
from proofs.ledger.formal_check import report
from proofs.ledger.ledger import ledger, theorems

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


needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="Coq is not installed")


def formal_part(folder, **files):
    """A formal part with these files, built as the project's is."""
    for name in ("Makefile", "_CoqProject"):
        shutil.copy(SOURCES / name, folder)
    for name, text in files.items():
        (folder / f"{name}.v").write_text(text)
    return folder


def build(names, folder):
    """Compile, and commit what the theorems and definitions say."""
    compile_formal_part(names, folder)
    statements, complaint = printed_statements(names, defined(folder), folder)
    assert complaint == ""
    commit({name: text for name, text in statements.items() if text}, folder)


@pytest.fixture
def folder(tmp_path):
    return formal_part(tmp_path, Proved=PROVED, Assumed=ADMITTED)


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
    questions = dict.fromkeys(["A.x", "A.y", "b.B.z"], "Print Assumptions {}.")
    lines = question_file(questions).splitlines()
    assert lines[:2] == ["From Compensators Require A.", "From Compensators.b Require B."]
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
    assert {name: axioms(answer) for name, answer in read_answers(output).items()} == {
        "A.x": "",
        "A.y": "two_is_one : 2 = 1 classic : forall P : Prop, P",
        "A.z": "?",
    }


def test_the_report_fails_for_anything_assumed():
    assert report({"A.x": ""}, [])[1] is True
    assert report({"A.x": ""}, ["A.v: Admitted assumes instead of proving"])[1] is False
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


@pytest.mark.slow
@needs_coq
def test_an_older_compilation_answers_for_nothing(tmp_path):
    formal_part(
        tmp_path,
        Base="Theorem base : 1 = 1. Proof. reflexivity. Qed.",
        User="From Compensators Require Import Base.\n"
        "Theorem user : 1 = 1. Proof. exact base. Qed.",
        Alone="Theorem alone : 2 = 2. Proof. reflexivity. Qed.",
    )
    names = ["Base.base", "User.user", "Alone.alone"]
    build(names, tmp_path)
    assert compile_formal_part(names, tmp_path).holds
    (tmp_path / "Base.v").write_text("Theorem base : 1 = 2. Proof. reflexivity. Qed.")
    result = compile_formal_part(names, tmp_path)
    assert result.status == "failed"
    assert result.answers == {
        "Base.base": "Base.v does not compile",
        "User.user": "User.v does not compile",
        "Alone.alone": "",
    }


@pytest.mark.costly
@needs_coq
def test_coq_is_asked(folder):
    names = ["Proved.one_is_one", "Assumed.rests_on_it", "Assumed.nothing", "Absent.x"]
    build(names[:2], folder)
    formal_part = compile_formal_part(names, folder)
    assert formal_part.status == "compiled" and not formal_part.holds
    assert formal_part.answers["Proved.one_is_one"] == ""
    assert formal_part.answers["Assumed.rests_on_it"].startswith(
        "rests on axioms: Assumed.two_is_one"
    )
    assert formal_part.answers["Assumed.nothing"] == "Assumed.v states no theorem nothing"
    assert formal_part.answers["Absent.x"] == "proofs/rocq has no file Absent.v"


@pytest.mark.slow
@needs_coq
def test_a_file_that_does_not_compile_fails_and_the_others_are_asked(folder):
    build(["Proved.one_is_one"], folder)
    (folder / "Wrong.v").write_text("Theorem wrong : 1 = 2. Proof. reflexivity. Qed.")
    formal_part = compile_formal_part(["Wrong.wrong", "Proved.one_is_one"], folder)
    assert formal_part.status == "failed" and "Wrong.v" in formal_part.detail
    assert formal_part.answers == {
        "Wrong.wrong": "Wrong.v does not compile",
        "Proved.one_is_one": "",
    }


SUMS = """
Require Import Lia.
Definition twice (n : nat) := n + n.
Notation two := 2.
Section Sums.
Variable n : nat.
Theorem twice_a_sum (m : nat) : twice (n + m) = twice m + twice n.
Proof. discriminate || (intros; unfold twice; lia). Qed.
Theorem small : 1 < two.
Proof. discriminate || lia. Qed.
Theorem nothing : @nil nat = nil.
Proof. reflexivity. Qed.
End Sums.
"""


SUMMED = ["Sums.twice_a_sum", "Sums.small", "Sums.nothing"]


def slow(*edit):
    """What --long compiles, too."""
    return pytest.param(*edit, marks=pytest.mark.long)


@pytest.fixture(scope="module")
def sums(tmp_path_factory):
    """A formal part that was compiled and found to hold."""
    folder = formal_part(tmp_path_factory.mktemp("sums"), Sums=SUMS)
    build(SUMMED, folder)
    assert compile_formal_part(SUMMED, folder).holds
    return folder


@pytest.mark.costly
@needs_coq
@pytest.mark.parametrize(
    ("before", "after", "names"),
    [
        ("Variable n : nat.", "Variable n : nat. Hypothesis absurd : 1 = 0.", "twice_a_sum small"),
        slow("Variable n : nat.", "Variables (n : nat) (absurd : 1 = 0).", "twice_a_sum small"),
        slow("twice (n + m) =", "n < m -> twice (n + m) =", "twice_a_sum"),
        slow("twice m + twice n", "twice n + twice m", "twice_a_sum"),
        slow("n + n", "2 * n", "twice"),
        slow("two := 2", "two := (1 + 1)", "small"),  # a notation is no hiding place
        slow("@nil nat", "@nil bool", "nothing"),  # nor is an implicit argument
        ("Theorem small", "(* more *) Theorem small", ""),
    ],
)  # fmt: skip
def test_a_changed_statement_fails(sums, tmp_path, before, after, names, request):
    """Each of these compiles and rests on no axiom."""
    if request.node.get_closest_marker("long") and not request.config.getoption("--long"):
        pytest.skip("compiles once more; --long runs it")
    shutil.copytree(sums, tmp_path, dirs_exist_ok=True)
    assert before in SUMS
    (tmp_path / "Sums.v").write_text(SUMS.replace(before, after))
    assert defined(tmp_path) == ("Sums.twice",)
    formal_part = compile_formal_part(SUMMED, tmp_path)
    assert "does not compile" not in formal_part.detail, formal_part.detail
    changed_now = {name for name, reason in formal_part.answers.items() if reason}
    if formal_part.status == "failed":
        changed_now.add(formal_part.detail.split()[0])
    assert changed_now == {f"Sums.{name}" for name in names.split()}
    assert formal_part.holds == (not names)
    for reason in filter(None, formal_part.answers.values()):
        assert reason == "says something else than proofs/rocq/types/Sums.txt"


def test_what_is_committed_is_read_back(tmp_path):
    statements = {
        "b.B.x": "[0123abcd]\n  x\n       : 1 = 1",
        "A.y": "[4567cdef]\n  y =\n\n  Arguments y",
        "A.z": "[89abcdef]\n  z\n       : 2 = 2",
    }
    commit(statements, tmp_path)
    assert committed(tmp_path) == statements
    assert not any(changed(statements, tmp_path).values())
    reasons = changed({"A.y": "[00000000]\n  y", "A.new": "[1]\n  1", "A.z": ""}, tmp_path)
    assert reasons == {
        "A.y": "says something else than proofs/rocq/types/A.txt",
        "A.new": "what it says is not committed in proofs/rocq/types/A.txt",
        "A.z": "Coq does not print what it says",
    }
    commit({"A.z": statements["A.z"]}, tmp_path)  # what is gone does not stay behind
    assert committed(tmp_path) == {"A.z": statements["A.z"]}


def test_every_theorem_of_the_ledger_and_every_definition_is_committed():
    assert committed().keys() == {*theorems(ledger()), *defined()}
