"""The files for Coq that certificates become: what they say, what is refused, what Coq accepts."""

import copy
import json
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.certificates._records import _WRITERS
from compensator_theory.certificates._signs import definite_factor, hurwitz_rows, schur_rows
from compensator_theory.errors import InputError
from proofs import recheck
from tests.compensator_theory.samples import SAMPLES

LIBRARY = Path(recheck.__file__).parent / "rocq"
NEEDED = ("theorems/CertifiedSigns.vo", "foundations/PositiveDefinite.vo")
KINDS = [kind for kind in _WRITERS if kind in SAMPLES]
SLOW = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]

needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="Coq is not installed")


@pytest.fixture(scope="module")
def library():
    """The folder of the compiled theorems."""
    if not all((LIBRARY / name).exists() for name in NEEDED):
        build = ["make", "-C", str(LIBRARY), "CoqMakefile"]
        subprocess.run(build, check=True, capture_output=True)
        subprocess.run(
            ["make", "-C", str(LIBRARY), "-f", "CoqMakefile", *NEEDED],
            check=True, capture_output=True,
        )  # fmt: skip
    return LIBRARY


def coq(text, folder, library):
    """Whether Coq accepts a file without axioms, and what it prints."""
    file = folder / "certificate.v"
    file.write_text(text, encoding="utf-8")
    command = ["coqc", "-q", "-w", "none", "-R", str(library), "Compensators", str(file)]
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    accepted = not run.returncode and run.stdout.strip() == "Closed under the global context"
    return accepted, run.stdout + run.stderr


@st.composite
def records(draw):
    kind = draw(st.sampled_from(KINDS))
    try:
        return json.loads(json.dumps(ct.certificate_record(draw(SAMPLES[kind]))))
    except InputError:  # irrational, empty, or known by enclosures alone
        return ct.certificate_record(ct.place_poles("1/(s - a)", [-1], feedback=-1))


@pytest.mark.costly
@needs_coq
@settings(max_examples=4, deadline=None, suppress_health_check=SLOW)
@given(record=records())
def test_coq_proves_drawn_certificates(record, tmp_path, library):
    accepted, words = coq(ct.to_coq(record), tmp_path, library)
    assert accepted, words


@pytest.mark.costly
@needs_coq
@settings(max_examples=3, deadline=None, suppress_health_check=SLOW)
@given(record=records(), data=st.data())
def test_coq_refuses_certificates_with_another_coefficient(record, data, tmp_path, library):
    changed = copy.deepcopy(record)
    names = sorted(name for name, m in record["matrices"].items() if any(m["entries"]))
    matrix = changed["matrices"][data.draw(st.sampled_from(names))]
    entry = data.draw(st.sampled_from([e for e in matrix["entries"] if e]))
    term = data.draw(st.sampled_from(entry))
    term[0] = str(Fraction(term[0]) + data.draw(st.sampled_from([1, -1, Fraction(1, 3)])))
    if not recheck.failures(changed):  # beside a factor 0, or still stable: the claim is true
        return
    try:
        text = ct.to_coq(changed)
    except InputError:  # no witness exists
        return
    assert not coq(text, tmp_path, library)[0]


def stable_loop():
    return ct.place_poles("1/((z - 2)*(z + 1/2))", ["1/2", "1/3", "-1/4"], feedback=-1)


@pytest.mark.costly
@needs_coq
@pytest.mark.parametrize(
    ("line", "before", "after"),
    [
        ("Definition p :", "term 24 [:: 3]", "term 25 [:: 3]"),  # an equation of numbers
        (
            "Lemma stable_p_check",
            "schur_rows [:: ",
            "schur_rows [:: 1",
        ),  # a polynomial that is not p
        ("Theorem equation_1", "[char Field]%R =i pred0", "true"),  # a field of characteristic 2
    ],
)
def test_coq_refuses_a_file_that_was_edited(line, before, after, tmp_path, library):
    text = ct.to_coq(stable_loop())
    head, _, rest = text.partition(line)
    assert before in rest
    assert coq(text, tmp_path, library)[0]
    assert not coq(head + line + rest.replace(before, after, 1), tmp_path, library)[0]


def number_matrix(rows):
    entries = [[[str(e), [0]]] if e else [] for row in rows for e in row]
    return {"rows": len(rows), "columns": len(rows), "entries": entries, "over": [["1", [0]]]}


def definite_record(rows):
    return {"kind": "form", "statement": "M > 0", "symbols": ["s"],
            "matrices": {"M": number_matrix(rows)}, "definite": ["M"]}  # fmt: skip


@pytest.mark.costly
@needs_coq
def test_a_checker_says_false_of_false_claims(tmp_path, library):
    """Each check of the library, evaluated on true claims and on false ones beside them."""
    one, two = "[:: term 1 [::]]", "[:: term 2 [::]]"
    lines = [
        "From mathcomp Require Import all_ssreflect all_algebra.",
        "From Compensators.theorems Require Import CertifiedEquations CertifiedSigns.",
        "From Coq Require Import ZArith.",
        f"Definition M (p : polynomial) := Entries 1 1 [:: [:: p]] {one}.",
        "Definition s_ (e : Z) : polynomial := [:: term 1 [:: 1]; term e [::]].",
        "Definition given : seq polynomial := [::].",
    ]
    definite, rows = (
        "is_definite (M {}) 2 [:: 1]%Z [:: [:: {}]]%Z",
        "{}_rows [:: {}]%Z [:: (1, [:: 1])]%Z",
    )
    spectrum = "has_spectrum given (M {}) (M (s_ {})) " + one + " [:: [:: term {} [::]]]"
    checks = [
        (f"agree given [::] 1%Z [::] (M {one}) (M {one})", True),
        (f"agree given [::] 1%Z [::] (M {one}) (M {two})", False),
        (f"agree given [::] 0%Z [::] (M {one}) (M {two})", False),  # 0 times anything
        (f"agree given [::] 1%Z [:: [:: {one}]] (M {one}) (M {two})", False),
        ("agree given [::] 1%Z [::] (Entries 1 1 [::] [::]) (M [::])", False),  # over 0
        ("agree given [::] 1%Z [::] (Entries 1 1 [::] (s_ 1)) (M [::])", False),  # over s + 1
        ("agree [:: s_ 1] [::] 1%Z [::] (Entries 1 1 [::] (s_ 1)) (M [::])", True),
        (f"is_regular given [:: [:: {one}]] {two} (M {two})", True),
        (f"is_regular given [:: [:: [::]]] [::] (M {two})", False),
        (f"is_regular given [:: [:: {one}]] {one} (M {two})", False),
        (spectrum.format(two, "(-2)", "(-2)"), True),
        (spectrum.format(two, "(-1)", "(-1)"), False),
        (spectrum.format(two, "(-2)", "(-1)"), False),
        (definite.format(one, "1"), True),
        (definite.format(one, "2"), False),
        (definite.format("[:: term (-1) [::]]", "0"), False),
        (definite.format("[::]", "0"), False),
        (rows.format("routh", "1; 1"), True),
        (rows.format("routh", "-1; 1"), False),
        (rows.format("routh", "0; 1"), False),
        (rows.format("schur", "1; 1"), False),
        (rows.format("schur", "2; 1"), False),
        ("schur_rows [:: 1; 2]%Z [:: (3, [:: 1])]%Z", True),
        ("schur_rows [:: 1; 2]%Z [::]", False),
    ]
    lines += [f"Eval vm_compute in ({check})." for check, _ in checks]
    _, words = coq("\n".join(lines), tmp_path, library)
    answers = [line.split()[1] for line in words.splitlines() if line.strip().startswith("= ")]
    assert answers == [str(truth).lower() for _, truth in checks], words


@given(st.lists(st.fractions(-3, 3, max_denominator=9), min_size=1, max_size=5), st.booleans())
def test_the_rows_exist_where_the_roots_are_stable(roots, discrete):
    p = ct.polynomial_from_roots(roots, "z" if discrete else "s")
    scaled = p.clear_denoms(convert=True)[1]
    rows = (schur_rows if discrete else hurwitz_rows)([int(c) for c in scaled.all_coeffs()[::-1]])
    assert (rows is not None) == all(abs(r) < 1 if discrete else r < 0 for r in roots)


@given(st.lists(st.lists(st.integers(-50, 50), min_size=4, max_size=4), min_size=1, max_size=5))
def test_the_factor_exists_where_a_matrix_is_definite(rows):
    """R'R is semidefinite, and definite where R has 4 independent columns."""
    gram = [[sum(r[i] * r[j] for r in rows) for j in range(4)] for i in range(4)]
    factor = definite_factor(gram)
    assert (factor is not None) == recheck.is_definite([[Fraction(e) for e in r] for r in gram])
    if factor is not None:
        scale, w, F = factor
        rest = [[scale * w[i] * gram[i][j] * w[j] - sum(f[i] * f[j] for f in F) for j in range(4)]
                for i in range(4)]  # fmt: skip
        assert all(row[i] > sum(map(abs, row)) - abs(row[i]) for i, row in enumerate(rest))


def test_an_ill_conditioned_matrix_has_a_factor():
    hilbert = [[Fraction(1, i + j + 1) for j in range(12)] for i in range(12)]
    whole = [[int(e * 5354228880) for e in row] for row in hilbert]  # lcm(1, ..., 23)
    assert definite_factor(whole) is not None
    whole[0][0] -= 5354228880  # no longer
    assert definite_factor(whole) is None


def test_the_file_says_what_it_proves():
    text = ct.to_coq(ct.place_poles("b/(s*(s + a))", "(s + w)**3", feedback=-1))
    head, rest = text.split("*)", 1)
    for words in ("D D_c + N N_c = lambda p", "coqc -w none -R", "D = s^2 + s*a", "certified_"):
        assert words in head
    assert "(D *m D_c + N *m N_c = lambda *m p)%R" in rest


def test_fractions_of_any_length_are_read():
    long = 3**2000
    record = definite_record([[1]])
    record["matrices"]["M"]["entries"] = [[[f"{long}/7", [0]]]]
    text = ct.to_coq(record)
    assert f"term 0x{long:x} [::]" in text and "M_over : polynomial := [:: term 7 [::]]" in text


def test_names_of_symbols_cannot_break_a_file():
    plant = ct.transfer_function("1/(s - forall)", "s")
    text = ct.to_coq(ct.place_poles(plant, ["-D", "-D_over"], 1, feedback=-1))
    theorem = text[text.index("Theorem equation_1") :]
    assert "(s D__ D_over_ forall_ : Field)" in theorem.splitlines()[0] or "forall_" in theorem
    assert "(* (*" not in ct.to_coq(definite_record([[1]]) | {"statement": '(* " *)'})[2:]


@pytest.mark.parametrize(
    ("record", "words"),
    [
        ({}, "no record"),
        ({"kind": "x", "statement": "y", "symbols": [], "matrices": {}}, "claims nothing"),
        (definite_record([[1]]) | {"matrices": {}}, "no record"),
        (definite_record([[1, 2], [2, 1]]), "definite"),
        (definite_record([[1, 1], [0, 1]]), "symmetric"),
        (definite_record([[0]]) | {"definite": [], "regular": ["M"]}, "singular"),
        (definite_record([[1]]) | {"definite": ["N"]}, "no record"),
        (definite_record([[0]]) | {"definite": [], "stable": [{"is": "M", "time": "discrete"}]},
         "not stable"),
        (definite_record([[1]]) | {"extension": [["1", [2]], ["-2", [0]]]}, "field"),
    ],
)  # fmt: skip
def test_what_is_no_certificate_is_refused(record, words):
    with pytest.raises(InputError, match=words):
        ct.to_coq(record)


def test_a_result_without_a_certificate_is_refused():
    with pytest.raises(InputError, match="certificate"):
        ct.to_coq(ct.transfer_function("1/s"))
    with pytest.raises(InputError, match="irrational"):
        ct.to_coq(ct.place_poles("1/(s - sqrt(2))", [-1], feedback=-1))
