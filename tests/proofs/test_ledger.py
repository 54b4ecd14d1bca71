"""The ledger is complete: what it names exists, and what exists it names."""

import importlib
import inspect
import pkgutil
import tomllib

import pytest

import proofs.counterexamples
import proofs.properties
import proofs.symbolic
from compensator_theory.errors import InputError
from proofs.formal.rocq_sources import missing
from proofs.ledger import ledger as ledger_module
from proofs.ledger.checks import ForAll, resolve, statement_of
from proofs.ledger.ledger import STATEMENTS, LedgerError, ledger, select, theorems
from proofs.output.page import page

ENTRIES = ledger()
NAMED = {
    "symbolic": {e.check for entry in ENTRIES for e in entry.symbolic},
    "properties": {e.check for entry in ENTRIES for e in entry.properties},
    "counterexamples": {e.check for entry in ENTRIES for e in entry.counterexamples},
}


def is_check(value, module):
    if isinstance(value, ForAll):
        return value.predicate.__module__ == module.__name__
    if not inspect.isfunction(value) or value.__module__ != module.__name__:
        return False
    if inspect.isgeneratorfunction(value):
        return True
    return value.__annotations__.get("return") is bool and value.__name__[0] != "_"


def existing(package):
    for info in pkgutil.iter_modules(package.__path__):
        module = importlib.import_module(f"{package.__name__}.{info.name}")
        if info.name in ("letters", "loops"):
            continue
        for name, value in vars(module).items():
            if is_check(value, module) and name not in ("is_form",):
                yield f"{info.name}.{name}"


@pytest.mark.parametrize("package", [proofs.symbolic, proofs.properties, proofs.counterexamples])
def test_every_check_is_named_by_an_entry_and_exists(package):
    assert set(existing(package)) == NAMED[package.__name__.split(".")[1]]


@pytest.mark.parametrize(
    ("kind", "check"), [(kind, check) for kind, checks in NAMED.items() for check in sorted(checks)]
)
def test_every_check_states_what_it_checks(kind, check):
    result = resolve(kind, check)
    statement = result.statement if isinstance(result, ForAll) else statement_of(result)
    assert len(statement) > 15
    if isinstance(result, ForAll):
        assert result.name == check


def test_names_are_unique_and_every_entry_has_evidence():
    names = [entry.name for entry in ENTRIES]
    assert len(set(names)) == len(names)
    for entry in ENTRIES:
        assert entry.conclusion and entry.text and entry.source, entry.name
        assert entry.symbolic or entry.properties, entry.name


def test_the_statements_that_the_software_rests_on_are_there():
    expected = {
        "least-squares-update", "intercalation", "intercalation-scalar", "external-perturbation",
        "lemma-1", "proposition-1", "proposition-2", "proposition-3", "proposition-4",
        "proposition-5", "theorem-1-pairs", "theorem-1-transfer-functions",
        "theorem-1-realisations", "forms-are-subspaces", "count-of-forms", "hidden-mode-rule",
        "youla-chains", "lqg-spectrum", "return-difference", "spectral-factorisation",
        "high-authority-poles", "innovation-weight", "theorem-a1", "theorem-a2",
        "riccati-duality", "forward-riccati", "subsystem-recursion", "contraction",
        "small-gain-ellipsoid", "predictive-control-limit", "parity-interlacing",
        "all-compensators", "routh-hurwitz", "kharitonov", "schur-cohn",
    }  # fmt: skip
    assert expected <= {entry.name for entry in ENTRIES}


@pytest.mark.parametrize(
    "check",
    ["printed_sign", "example_7_1", "multiplicity", "distinct_roots", "common_factors",
     "disconnected", "hidden_mode", "real_roots_and_no_form", "several_signals"],
)  # fmt: skip
def test_what_is_false_of_theorem_1_has_its_counterexample(check):
    assert f"theorem_1.{check}" in NAMED["counterexamples"]


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_the_software_that_relies_on_an_entry_exists(entry):
    assert entry.relied_on_by
    for name in entry.relied_on_by:
        module, attribute = name.rsplit(".", 1)
        assert hasattr(importlib.import_module(module), attribute), name


def test_theorems_have_the_form_of_a_file_and_a_name():
    for theorem in theorems(ENTRIES):
        folder, file, name = theorem.split(".")
        assert folder in ("theorems", "counterexamples"), theorem
        assert file.isidentifier() and name.isidentifier(), theorem
        assert (
            missing(theorem) == "" or "proofs/rocq" in missing(theorem) or name in missing(theorem)
        )


def test_selection_by_chapter_and_name():
    assert {entry.chapter for entry in select(["a", "B"])} == {"A", "B"}
    assert [entry.name for entry in select(["lemma-1"])] == ["lemma-1"]
    assert select([]) == ENTRIES
    with pytest.raises(LedgerError, match="no entry or chapter lemma-7"):
        select(["lemma-7"])


def test_a_misspelt_key_is_named():
    table = {"name": "x", "hypotheses": [], "conclusoin": ""}
    with pytest.raises(LedgerError, match="conclusoin"):
        ledger_module._entry("7", table, "chapter_7.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("chapter = ", "wrong.toml is not TOML"),
        ('chapter = "7"', "wrong.toml needs the keys chapter and entry"),
        ('chapter = "7"\n[[entry]]\nname = "x"', r"entry x .* lacks .*'conclusion'"),
        ('chapter = "7"\n[[entry]]\ntitle = "x"', r"without a name.* lacks .*'name'"),
        ("WHOLE\nformal = [{ theorm = 'A.b' }]", "entry x.*theorm"),
        ("WHOLE\nsymbolic = [{ sizes = [1] }]", "entry x.*check"),
    ],
)
def test_a_broken_file_is_named(monkeypatch, tmp_path, text, words):
    whole = 'chapter = "7"\n[[entry]]\nname = "x"\ntitle = ""\nsource = ""\nconclusion = ""\n'
    whole += 'text = ""\nhypotheses = []\nrelied_on_by = []'
    (tmp_path / "wrong.toml").write_text(text.replace("WHOLE", whole))
    monkeypatch.setattr(ledger_module, "STATEMENTS", tmp_path)
    with pytest.raises(LedgerError, match=words):
        ledger_module.ledger.__wrapped__()


def test_what_the_text_does_not_say_is_not_held_against_it():
    text = page(select(["theorem-a1"]))
    assert 'false, and not said by the text: "$a_{k}$ and $b_{l}$ may both be 0"' in text
    assert r'- false: "$l\leq k$ is necessary"' in text


def test_a_check_that_does_not_exist_is_named():
    for check in ("separation.nothing", "nowhere.similarity"):
        with pytest.raises(InputError, match=check):
            resolve("symbolic", check)


@pytest.mark.costly
def test_the_page_holds_every_entry_and_check():
    text = page(ENTRIES)
    for entry in ENTRIES:
        assert f"`{entry.name}`" in text
    for checks in NAMED.values():
        assert all(f"`{check}`" in text for check in checks)


def test_files_of_statements_are_one_chapter_each():
    for path in STATEMENTS.glob("*.toml"):
        data = tomllib.loads(path.read_text())
        assert data["chapter"].lower() in path.stem.split("_"), path.name
