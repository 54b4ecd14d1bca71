"""Ways to make the ledger say more than its evidence does, as edits of its files.

The first 109 are those of a review, which found 83 of them unseen; the others are of other kinds.
"""
# ruff: noqa: E501  (data: a line each)

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

Edit = Callable[[Path], None]


class Tampering(NamedTuple):
    """An edit of a copy of the checkout, and what kind it is."""

    name: str
    kind: str
    edit: Edit


def replaced(file: str, before: str, after: str) -> Edit:
    """An edit that puts one text in the place of another, once."""

    def edit(root):
        path = root / file
        text = path.read_text(encoding="utf-8")
        assert before in text, (file, before)
        path.write_text(text.replace(before, after, 1), encoding="utf-8")

    return edit


def several(*edits: Edit) -> Edit:
    """All of some edits."""

    def edit(root):
        for one in edits:
            one(root)

    return edit


def without_block(file: str, start: str) -> Edit:
    """An edit that takes out a block of TOML, up to the next blank line or the next table."""

    def edit(root):
        path = root / file
        text = path.read_text(encoding="utf-8")
        first = text.index(start)
        after = re.search(r"\n\n *\[\[|\Z", text[first:])
        path.write_text(text[:first] + text[first + after.start() :].lstrip("\n"), encoding="utf-8")

    return edit


def with_new_types(name: str, after: str) -> Edit:
    """An edit that commits another type of a theorem, as ``make types`` would."""
    folder, file, theorem = name.split(".")

    def edit(root):
        path = root / f"proofs/rocq/types/{folder}/{file}.txt"
        text = path.read_text(encoding="utf-8")
        changed = re.sub(rf"(?ms)^{theorem}  \[\w+\]\n.*?(?=^\w|\Z)",
                         f"{theorem}  [0123456789ab]\n  {after}\n\n", text)  # fmt: skip
        assert changed != text, name
        path.write_text(changed, encoding="utf-8")

    return edit


def definitions(root: Path, package: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """The checks of a package, each with its file."""
    for path in sorted((root / "proofs" / package).glob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and is_check(package, node):
                yield f"proofs/{package}/{path.name}", node


def is_check(package, node):
    if package == "properties":
        return any("for_all" in ast.unparse(d) for d in node.decorator_list)
    if package == "counterexamples":
        return any(isinstance(inner, ast.Yield) for inner in ast.walk(node))
    returns = node.returns and ast.unparse(node.returns)
    return returns == "bool" and node.name[0] != "_" and node.name != "vanishes"


def gutted(file: str, node: ast.FunctionDef) -> Edit:
    """An edit that leaves of a check its statement and an answer."""
    first = node.body[1] if ast.get_docstring(node) else node.body[0]
    answer = '    yield "1 = 1", True\n' if "counterexamples" in file else "    return True\n"

    def edit(root):
        path = root / file
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        lines[first.lineno - 1 : node.end_lineno] = [answer]
        path.write_text("".join(lines), encoding="utf-8")

    return edit


INTERCALATION = "proofs/rocq/theorems/Intercalation.v"
POLES = "proofs/rocq/theorems/HighAuthorityPoles.v"
CHAPTER_2 = "proofs/statements/chapter_2.toml"
CHAPTER_7 = "proofs/statements/chapter_7_placement.toml"
OBSERVERS = "proofs/statements/chapter_7_observers.toml"
LEAST_SQUARES = "proofs/properties/least_squares.py"

COQ = {
    "a false hypothesis of a section": (
        replaced(INTERCALATION, "Hypotheses (nz_D", "Hypothesis absurd : 1 = 0 :> nat.\nHypotheses (nz_D"),
        "theorems.Intercalation.scalar_form_4_18",
    ),
    "a conclusion 0 = 0": (
        replaced(INTERCALATION, "(N_zu / D) * u = N_zu * D_c / Dtilde * u_bar", "0 = 0 :> R"),
        "theorems.Intercalation.external_perturbation_4_19",
    ),
    "a false hypothesis 0 = 1": (
        replaced(POLES, "  Q^T = Q ->", "  0 = 1 :> R -> Q^T = Q ->"),
        "theorems.HighAuthorityPoles.poles_of_high_authority_observer",
    ),
    "a narrower field": (
        replaced("proofs/rocq/theorems/CountOfForms.v", "Variables (R : fieldType)", "Variables (R : rcfType)"),
        "theorems.CountOfForms.count_of_forms",
    ),
    "a hidden not": (
        replaced("proofs/rocq/theorems/HiddenModes.v", "coprimep p_R u /\\ coprimep", "~ ~ coprimep p_R u /\\ coprimep"),
        "theorems.HiddenModes.hidden_mode_rule",
    ),
    "an absurd definition": (
        replaced(POLES, "complex_roots p z -> `|z| < 1.", "complex_roots p z -> `|z| < 1 /\\ p != p."),
        "theorems.HighAuthorityPoles.inside",
    ),
}  # fmt: skip


def of_the_review(root: Path) -> Iterator[Tampering]:
    """The review's."""
    for name, (edit, theorem) in COQ.items():
        yield Tampering(f"Coq: {name}", "statement in Coq", edit)
        yield Tampering(
            f"Coq: {name}, then make types", "types committed", with_new_types(theorem, "x : True")
        )
    yield Tampering("Admitted", "assumed", replaced(
        "proofs/rocq/counterexamples/ChangeOfBasis.v", "Section ChangeOfBasis.",
        "Lemma loose : 1 = 2 :> nat.\nProof. Admitted.\nSection ChangeOfBasis."))  # fmt: skip
    yield Tampering("an axiom", "assumed", replaced(
        "proofs/rocq/counterexamples/ChangeOfBasis.v", "Section ChangeOfBasis.",
        "Axiom loose : 1 = 2 :> nat.\nSection ChangeOfBasis."))  # fmt: skip
    yield Tampering("a theorem renamed", "statement in Coq", replaced(
        "proofs/rocq/theorems/HiddenModes.v", "Theorem hidden_mode_rule", "Theorem hidden_mode"))  # fmt: skip
    yield Tampering("a variable of a whole file", "assumed", replaced(
        "proofs/rocq/counterexamples/UnitCircle.v", "Section UnitCircle.",
        "Variable magic : forall P : Prop, P.\nLemma unused : 1 = 2 :> nat.\nProof. exact: magic. Qed.\n"
        "Section UnitCircle."))  # fmt: skip
    flips = ("separation", "return_difference", "least_squares", "duality", "intercalation")
    names = set()
    for package in ("properties", "counterexamples", "symbolic"):
        for file, node in definitions(root, package):
            module = Path(file).stem
            expected = (
                package != "symbolic" or module == "coefficients" or node.name == "regressor_layout"
            )
            if not expected and (module not in flips or module in names):
                continue
            if not expected:
                names.add(module)
            yield Tampering(f"{module}.{node.name} gutted", f"{package} gutted", gutted(file, node))
    yield Tampering(
        "an entry gone", "deleted", without_block(CHAPTER_7, '[[entry]]\nname = "lemma-1"')
    )
    yield Tampering("another entry gone", "deleted", without_block(CHAPTER_2, '[[entry]]\nname = "regressor"'))  # fmt: skip
    yield Tampering("a counterexample gone", "deleted", without_block(
        CHAPTER_7, '[[entry.counterexample]]\n  refutes = "N and D need not'))  # fmt: skip
    yield Tampering("a property gone", "deleted", replaced(
        CHAPTER_2, '  { check = "least_squares.unique_minimiser", examples = 60 },\n', ""))  # fmt: skip
    yield Tampering("a conclusion reversed", "words", replaced(
        CHAPTER_7, "bq + ap = 0 if and only if a = b = 0", "bq + ap = 0 only if a != 0"))  # fmt: skip
    yield Tampering("hypotheses emptied", "words", replaced(
        CHAPTER_7, '["deg N < n, n_c >= n - 1"]', "[]"))  # fmt: skip
    yield Tampering("the text's words changed", "words", replaced(
        CHAPTER_2, "Let P(0) = R_theta^-1, and", "Let P(1) = R_theta^-1, and"))  # fmt: skip
    yield Tampering("a refuted wording changed", "words", replaced(
        CHAPTER_7, "deg N_c <= n is enough", "deg N_c <= n + 1 is enough"))  # fmt: skip
    yield Tampering("evidence swapped", "evidence", several(
        replaced(CHAPTER_7, 'check = "placement.uniqueness"', 'check = "SWAP"'),
        replaced(CHAPTER_7, 'check = "placement.existence"', 'check = "placement.uniqueness"'),
        replaced(CHAPTER_7, 'check = "SWAP"', 'check = "placement.existence"')))  # fmt: skip
    yield Tampering("a part taken for the whole", "evidence", replaced(
        CHAPTER_7, 'any field", of = [1] },', 'any field", of = [1, 2] },'))  # fmt: skip
    yield Tampering(
        "sizes = [1]", "evidence", replaced(CHAPTER_7, "sizes = [1, 2, 3, 4]", "sizes = [1]")
    )
    yield Tampering(
        "examples = 1", "evidence", replaced(CHAPTER_2, "examples = 60", "examples = 1")
    )
    yield Tampering("a strategy narrowed", "draws", replaced(
        "proofs/properties/polynomials.py", "polynomials(max_degree=3), st.just(Poly(0, s))",
        "st.just(Poly(0, s))"))  # fmt: skip
    yield Tampering("another strategy narrowed", "draws", replaced(
        LEAST_SQUARES, "min_size=1, max_size=3", "min_size=1, max_size=1"))  # fmt: skip
    yield Tampering("a thing compared with itself", "check", replaced(
        "proofs/symbolic/separation.py",
        "S * closed_loop(A + B * K - F * C) - triangular() * S", "S * triangular() - S * triangular()"))  # fmt: skip
    yield Tampering("assume(False)", "draws", replaced(
        "proofs/properties/forms.py", "    forms = observer_forms(*loop)\n    return bool(",
        "    assume(False)\n    forms = observer_forms(*loop)\n    return bool("))  # fmt: skip
    yield Tampering("a broken predicate", "check", replaced(
        LEAST_SQUARES, "return bool(theta == batch(", "return bool(1 / 0 == batch("))  # fmt: skip
    yield Tampering("all but constants assumed away", "draws", replaced(
        "proofs/properties/polynomials.py", "    a, b = a * shared, b * shared\n",
        "    assume(a.degree() == 0)\n    a, b = a * shared, b * shared\n"))  # fmt: skip
    yield Tampering(
        "examples = 0", "evidence", replaced(CHAPTER_2, "examples = 60", "examples = 0")
    )


def of_other_kinds() -> Iterator[Tampering]:
    """Fifty that the review did not try."""
    v, s = "proofs/rocq/foundations/Vocabulary.v", "proofs/symbolic"
    kinds = {
        "words": [
            ("the source changed", replaced(CHAPTER_7, 'source = "Lemma 1"', 'source = "Lemma 2"')),
            ("the title changed", replaced(CHAPTER_7, 'title = "Lemma 1"', 'title = "The lemma"')),
            ("a difference withdrawn", replaced(CHAPTER_7, "None of the three is needed", "All are needed")),
            ("one hypothesis less", replaced(CHAPTER_7, '"deg N_c < deg D for both compensators"', "")),
            ("the software that relies on it changed", replaced(CHAPTER_7, "compensator_theory.bezout.sylvester_m\"", "compensator_theory.place_poles\"")),
            ("a chapter moved", replaced(CHAPTER_2, "(2.28)-(2.31)", "(2.28)-(2.30)")),
            ("<= for <", replaced(CHAPTER_7, "deg a <= deg b, deg p < deg q", "deg a <= deg b, deg p <= deg q")),
        ],
        "evidence": [
            ("in_text turned", replaced(CHAPTER_7, "in_text = false", "in_text = true")),
            ("a refutation in Coq withdrawn", replaced(CHAPTER_2, '  formal = "counterexamples.Recursions.first_covariance"\n', "")),
            ("another theorem named", replaced(CHAPTER_7, "theorems.Diophantine.lemma_1", "theorems.Diophantine.proposition_2")),
            ("what a theorem says changed", replaced(CHAPTER_7, "all degrees, any field", "all degrees, any ring")),
            ("a smaller share kept", replaced(CHAPTER_2, "examples = 60 },", "examples = 60, kept = 0.01 },")),
            ("another refutation named", replaced(CHAPTER_7, 'formal = "theorems.Resultants.proposition_3"', 'formal = "theorems.Resultants.proposition_4"')),
            ("an extent widened", replaced(CHAPTER_2, 'extent = "n = 2"', 'extent = "any n"')),
        ],
        "check": [
            ("a helper of a check gutted", replaced("proofs/properties/forms.py", "    plant, compensator, T = form.plant", "    return True\n    plant, compensator, T = form.plant")),
            ("reduced gives 0", replaced(f"{s}/letters.py", "    return current\n", "    return 0 * current\n")),
            ("vanishes gives True", replaced(f"{s}/letters.py", "return all(expand(block) == 0 for block in matrix)", "return True")),
            ("a definition of letters changed", replaced(f"{s}/least_squares.py", "(P - P * Phi_T * Upsilon**-1 * Phi * P) / forgetting", "P / forgetting")),
            ("a rule added", replaced(f"{s}/least_squares.py", "REDUCE = {", "REDUCE = {Phi: 0, ")),
            ("a check reassigned below", replaced(f"{s}/joint_fit.py", "{}) == 0)\n", "{}) == 0)\n\n\nunseen_direction = bool\n")),
            ("a docstring that says more", replaced("proofs/properties/polynomials.py", "for a_k not 0 and every formal degree", "for every a and every formal degree")),
            ("a counterexample's numbers changed", replaced("proofs/counterexamples/resultants.py", "def multiple_roots", "def multiple_roots_x")),
            ("answers before the work", replaced("proofs/properties/placement.py", "        return True  # a column", "        return True\n    if m_hat:\n        return True  # a column")),
        ],
        "draws": [
            ("fewer signs in a strategy of the package", replaced("compensator_theory/strategies/spectra.py", "return st.integers(0, (size - 1)", "return st.integers(0, 0 * (size - 1)")),
            ("letters of one size", replaced("compensator_theory/strategies/polynomials.py", "degree = draw(st.sampled_from(range(min_degree, max_degree + 1)))", "degree = min_degree")),
            ("a loop of order 1 only", replaced("proofs/properties/loops.py", "excess: int = 0, max_order: int = 3", "excess: int = 0, max_order: int = 1")),
        ],
        "runner": [
            ("anything is true", replaced("proofs/ledger/checks.py", "return answer is True", "return True")),
            ("errors confirm", replaced("proofs/ledger/checks.py", 'return Outcome(kind, name, statement_of(check), "fails", detail=detail)', 'return Outcome(kind, name, statement_of(check), "holds", detail=detail)')),
            ("any evidence is machine-checked", replaced("proofs/ledger/outcomes.py", '"property": "property-tested"', '"property": "machine-checked"')),
            ("what is rejected is not counted", replaced("proofs/ledger/checks.py", "answered < max(1, kept * begun)", "answered < 0")),
        ],
        "runner of Coq": [
            ("no axiom is read", replaced("proofs/formal/assumptions.py", 'return "" if words == CLOSED else', 'return "" if words else')),
            ("no witness is asked for", replaced("proofs/formal/rocq_build.py", 'or alone.get(name, "")', "")),
            ("a witness's axioms do not matter", replaced("proofs/formal/rocq_build.py", "            or _of_witness(shown.get(name), proved)\n", "")),
            ("what a theorem says is not compared", replaced("proofs/formal/types.py", '"" if text == known[name] else', '"" if text else')),
            ("any lemma is a witness", replaced("proofs/formal/witnesses.py", "can_be_met", "\\w+")),
            ("the definitions are not asked", replaced("proofs/formal/rocq_sources.py", "definitions += [f\"{module}.{name}\" for name in names]", "definitions += []")),
            ("sentences without evidence pass", replaced("proofs/ledger/ledger.py", "if about != set(range(1, sentences + 1)):", "if not about:")),
            ("a report without faults", replaced("proofs/ledger/formal_check.py", "proved == len(answers) and not faults", "True")),
            ("universes that contain themselves", replaced("proofs/rocq/_CoqProject", "-arg -w", "-arg -type-in-type -arg -w")),
            ("make check compiles only", replaced("proofs/rocq/Makefile", "check: all\n\tcd ../.. && $(PYTHON) -m proofs.ledger.formal_check", "check: all\n\ttrue")),
        ],
        "assumed": [
            ("a context of a whole file", replaced(v, "Section Systems.", "Context (magic : False).\nSection Systems.")),
            ("a local axiom", replaced(v, "Section Systems.", "#[local] Axiom magic : False.\nSection Systems.")),
            ("a parameter of a module type", replaced(v, "Section Systems.", "Module Type T.\nParameter x : False.\nEnd T.\nSection Systems.")),
            ("the guard unset", replaced(v, "Section Systems.", "Unset Guard Checking.\nSection Systems.")),
            ("equality redefined by a notation", replaced(v, "Section Systems.", 'Local Notation "a = b" := (True).\nSection Systems.')),
            ("a coercion", replaced(v, "Section Systems.", "Coercion is_true : bool >-> Sortclass.\nSection Systems.")),
            ("a canonical structure", replaced(v, "Section Systems.", "Canonical odd := rat.\nSection Systems.")),
        ],
        "statement in Coq": [
            ("controllable is always true", replaced(v, "\\rank (controllability_matrix A B) == n.", "true.")),
            ("a constructor dropped", replaced(v, "[/\\ T \\in unitmx, C_c *m T = K,", "[/\\ true, C_c *m T = K,")),
            ("a notation of a word changed", replaced(v, "degree_below p n := (size (p%R : {poly _}) <= n)", "degree_below p n := (size (p%R : {poly _}) <= n.+1)")),
        ],
    }  # fmt: skip
    for kind, result in kinds.items():
        for name, edit in result:
            yield Tampering(name, kind, edit)


ERRATA = "rcac_experiments/dissertation/errata_files"
POLYNOMIALS = "proofs/properties/polynomials.py"
LOOSE = "def for_all(**options):\n    return lambda check: True\n"


def appended(file: str, text: str) -> Edit:
    """An edit that adds text to the end of a file, which it creates if need be."""

    def edit(root):
        path = root / file
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        path.write_text(before + text, encoding="utf-8")

    return edit


def entry_and_signature_gone(file: str, name: str) -> Edit:
    """An edit that takes out a statement together with its block of signatures."""

    def edit(root):
        without_block(file, f'[[entry]]\nname = "{name}"')(root)
        path = root / "proofs/statements/signatures.txt"
        blocks = path.read_text(encoding="utf-8").strip("\n").split("\n\n")
        remaining = [b for b in blocks if b.splitlines()[0].partition("  ")[2] != name]
        assert len(remaining) == len(blocks) - 1
        path.write_text("\n\n".join(remaining) + "\n", encoding="utf-8")

    return edit


def exchanged(file: str, first: str, second: str) -> Edit:
    """An edit that exchanges two texts of a file."""
    return several(
        replaced(file, first, "EXCHANGED"), replaced(file, second, first),
        replaced(file, "EXCHANGED", second),
    )  # fmt: skip


def around_the_checks(root: Path) -> Iterator[Tampering]:
    """What a later review found unseen, and its kin: imports, packages, errata, printed outcomes."""
    imports = {
        "an oracle imported under another's name": replaced(POLYNOMIALS, "import determinant, rank", "import determinant, determinant as rank"),
        "two imports exchanged": replaced(POLYNOMIALS, "import sylvester_m1, sylvester_m2", "import sylvester_m2 as sylvester_m1, sylvester_m1 as sylvester_m2"),
        "strategies of another library": replaced(POLYNOMIALS, "from hypothesis import strategies as st", "from unittest import mock as st"),
        "Poly of another library": replaced(POLYNOMIALS, "from sympy import Poly, Symbol", "from sympy import Symbol, Symbol as Poly"),
        "assume that rejects nothing": replaced("proofs/properties/forms.py", "from hypothesis import assume", "from builtins import bool as assume"),
        "a loose for_all in a new file": several(
            appended("proofs/ledger/loose.py", LOOSE),
            replaced(POLYNOMIALS, "from ..ledger.checks import for_all", "from ..ledger.loose import for_all"),
        ),
        "a loose for_all beside the checks": several(
            appended("proofs/properties/loose.py", LOOSE),
            replaced(POLYNOMIALS, "from ..ledger.checks import for_all", "from .loose import for_all"),
        ),
        "a loose for_all from outside": replaced(POLYNOMIALS, "from ..ledger.checks import for_all", "from tests.loose import for_all"),
        "zeros imported as eye": replaced("proofs/properties/directions.py", "eye, zeros", "zeros as eye, zeros"),
        "a strategy's import": replaced("compensator_theory/strategies/polynomials.py", "from sympy import QQ, Poly, Rational, Symbol", "from sympy import QQ, Poly, Integer as Rational, Symbol"),
        "an import below the checks": appended(POLYNOMIALS, "\nfrom sympy import eye as rank\n"),
        "an import in a try": appended(POLYNOMIALS, "\ntry:\n    from sympy import eye as rank\nexcept ImportError:\n    pass\n"),
    }  # fmt: skip
    patches = {
        "sympy's == in {}": "\nimport sympy\nsympy.MatrixBase.__eq__ = lambda a, b: True\n",
        "sympy.expand in {}": "\nimport sympy\nsympy.expand = lambda *a, **k: sympy.S.Zero\n",
        "a profile of Hypothesis in {}": "\nfrom hypothesis import settings\nsettings.register_profile('x', max_examples=1)\nsettings.load_profile('x')\n",
        "setattr in {}": "\nimport sympy\nsetattr(sympy, 'expand', lambda *a: 0)\n",
    }
    places = ("proofs/__init__.py", "proofs/properties/__init__.py", "proofs/symbolic/__init__.py",
              "proofs/counterexamples/__init__.py", "compensator_theory/strategies/__init__.py")  # fmt: skip
    packages = {
        name.format(place): appended(place, text)
        for name, text in patches.items()
        for place in places
    }
    modules = {
        "an attribute at the end of a module": appended(POLYNOMIALS, "\nPoly.__eq__ = lambda a, b: True\n"),
        "an attribute in an if": appended(POLYNOMIALS, "\nif True:\n    Poly.__eq__ = lambda a, b: True\n"),
        "an attribute among others": appended(POLYNOMIALS, "\ns, Poly.__eq__ = s, lambda a, b: True\n"),
        "an item of globals": appended(POLYNOMIALS, '\nglobals()["lemma_1"] = bool\n'),
        "an attribute deleted": appended(POLYNOMIALS, "\ndel Poly.degree\n"),
        "an attribute in another module of checks": appended("proofs/symbolic/duality.py", "\nimport sympy\nsympy.expand = bool\n"),
        "a loop over attributes": appended(POLYNOMIALS, "\nfor Poly.gen in [1]:\n    pass\n"),
        "a function called at import": appended(POLYNOMIALS, "\ndef _patch():\n    Poly.__eq__ = bool\n_patch()\n"),
        "a decorator added": replaced(POLYNOMIALS, "def lemma_1(", "def lemma_1(  # loose\n    "),
    }  # fmt: skip
    errata = {
        "what is true": replaced(f"{ERRATA}/chapter_7.toml", "it is less where KF = 0.", "it is less where K = 0."),
        "what is printed": replaced(f"{ERRATA}/chapter_7.toml", "8.26 s + 23.25.", "8.27 s + 23.25."),
        "the kind": replaced(f"{ERRATA}/chapter_7.toml", 'kind = "misprint"', 'kind = "inconsistent"'),
        "the charitable reading": replaced(f"{ERRATA}/chapter_7.toml", "<= for =; the proof needs no more.", "None."),
        "the place": replaced(f"{ERRATA}/chapter_7.toml", 'where = "Proposition 1"', 'where = "Proposition 2"'),
        "the evidence": exchanged(f"{ERRATA}/chapter_7.toml", '"theorem_1.printed_sign"', '"theorem_1.example_7_1"'),
        "an erratum gone": without_block(f"{ERRATA}/chapter_7.toml", '[[erratum]]\nname = "degree-in-the-proof"'),
        "an erratum of chapter 2 gone": without_block(f"{ERRATA}/chapter_2.toml", "[[erratum]]"),
        "an erratum in another file": several(
            without_block(f"{ERRATA}/chapter_7.toml", '[[erratum]]\nname = "degree-in-the-proof"'),
            appended(f"{ERRATA}/chapter_8.toml", '\n[[erratum]]\nname = "degree-in-the-proof"\nwhere = "Proposition 1"\nkind = "misprint"\nprinted = "x"\ntrue = "y"\ncharity = "z"\nevidence = {}\n'),
        ),
    }  # fmt: skip
    printing = {
        f"{name} prints another outcome": appended(f"proofs/{name}", "\n\ndef loose():\n    return True\n")
        for name in (
            "__main__.py", "output/printing.py", "output/page.py", "output/records.py",
            "output/coverage.py", "output/blueprint.py", "output/rocq_pages.py",
            "ledger/outcomes.py", "ledger/verification.py", "ledger/sign.py",
        )
    }  # fmt: skip
    printing["the exit status"] = replaced(
        "proofs/__main__.py", "sys.exit(0 if all(", "sys.exit(0 if any("
    )
    printing["an equation waved through"] = appended("proofs/unproved.toml", '\n[loose]\nequations = ["2.43"]\n')  # fmt: skip
    deleted = {
        f"{name} gone with its signatures": entry_and_signature_gone(file, name)
        for file, name in ((CHAPTER_7, "lemma-1"), (CHAPTER_2, "regressor"), (OBSERVERS, "proposition-1"))
    }  # fmt: skip
    deleted["the chapter of a file"] = replaced(OBSERVERS, 'chapter = "7"', 'chapter = "8"')
    for kind, edits in {
        "import": imports, "package": packages, "module": modules, "erratum": errata,
        "printing": printing, "deleted with its signature": deleted,
    }.items():  # fmt: skip
        for name, edit in edits.items():
            yield Tampering(f"{kind}: {name}", kind, edit)


HARMLESS = [
    replaced("proofs/rocq/foundations/Vocabulary.v", "(* The rank conditions of Kalman. *)", "(* Ranks. *)"),
    replaced("proofs/rocq/theorems/Intercalation.v", "Proof.\npose X :=", "Proof.\nidtac; pose X :="),
    replaced("proofs/symbolic/joint_fit.py", "before = D_f * z", "before  =  D_f * z"),
]  # fmt: skip
"""Coq says of a proof whether it is one; comments and layout claim nothing."""
