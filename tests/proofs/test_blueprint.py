"""The blueprint: formulas that can be set, links that lead somewhere, a graph that goes one way."""

import re

import pytest
from math_core import LatexToMathML

from proofs.formal.declarations import blanked, declarations, files, rests_on
from proofs.formal.rocq_sources import without_comments
from proofs.formal.types import committed
from proofs.ledger.checks import ForAll, resolve, statement_of
from proofs.ledger.ledger import ledger, theorems
from proofs.ledger.mutants import checks_of
from proofs.output.blueprint import definitions, dependencies, graph, printed_type
from proofs.output.formulas import with_formulas
from proofs.output.page import page
from proofs.output.rocq_pages import rocq_pages

ENTRIES = ledger()


def sentences(entry):
    yield from (*entry.hypotheses, *entry.conclusion, entry.text, entry.difference)
    yield from (case.refutes for case in entry.counterexamples)
    for package, check in checks_of(entry):
        result = resolve(package, check)
        yield result.statement if isinstance(result, ForAll) else statement_of(result)


@pytest.mark.costly
@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_every_formula_can_be_set_and_none_is_left_as_text(entry):
    reader = LatexToMathML(fancy_error=False)
    for sentence in sentences(entry):
        written = with_formulas(sentence)
        assert not re.search(r"\\[_^\[~]", written), written
        for formula in re.findall(r"\$(.*?)\$", written):
            reader.convert_with_local_state(formula, displaystyle=False)
            assert formula.count("(") == formula.count(")"), formula


def test_prose_stays_prose():
    for sentence in ("A change of basis is a basis.", "I know a field."):
        assert with_formulas(sentence) == sentence


def test_every_named_theorem_and_committed_definition_is_declared_where_it_says():
    lines = {module: path.read_text().splitlines() for module, path in files()}
    for name in {*theorems(ENTRIES), *committed()}:
        module, _, short = name.rpartition(".")
        assert re.search(rf"\b{short}\b", lines[module][declarations()[name].line - 1]), name


@pytest.mark.costly
def test_blanks_are_comments_and_nothing_else():
    for _, path in files():
        text = path.read_text()
        assert blanked(text).count("\n") == text.count("\n")
        assert blanked(text).split() == without_comments(text).split()


@pytest.mark.costly
def test_links_of_the_pages_lead_to_the_declaration():
    pages = rocq_pages({"theorems.Diophantine.lemma_1": ["lemma-1"]})
    assert pages.keys() == dict(files()).keys()
    for text in pages.values():
        for module, line, word in re.findall(r'href="([\w.]+)\.html#L(\d+)">([\w.\']+)</a>', text):
            target = re.search(rf'id="L{line}"></span>(.*)', pages[module])[1]
            assert re.search(rf"\b{word.rpartition('.')[2]}(?![\w'])", target), (module, word)


def test_what_a_theorem_rests_on():
    theorem = "theorems.ForwardConvergence.forward_riccati_converges"
    named = theorems(ENTRIES)
    assert "theorems.StabilisingSolution.stabilising_solution" in rests_on(theorem, named)
    assert rests_on("theorems.Regressor.regressor_times_vec", named) == set()


def test_the_graph_has_every_statement_below_what_it_rests_on():
    needs = dependencies(ENTRIES)
    drawn = graph(ENTRIES)
    height = {
        name: int(y)
        for name, y in re.findall(r'<a href="#([\w-]+)">.*?<rect x="\d+" y="(\d+)"', drawn)
    }
    assert height.keys() == {entry.name for entry in ENTRIES}
    assert all(height[name] > height[other] for name in needs for other in needs[name])


def test_the_page_links_neighbours_and_places():
    text = page([entry for entry in ENTRIES if entry.name == "forward-riccati-limit"])
    assert "Rests on " in text and "[stabilising-solution](#stabilising-solution)" in text
    assert 'href="reference/rocq/theorems.ForwardConvergence.html#L' in text


def test_definitions_in_printed_types_lead_to_definitions_on_the_page():
    shown, types = definitions(), committed()
    for theorem in theorems(ENTRIES):
        for target in re.findall(r'href="#([\w-]+)"', printed_type(theorem, types)):
            assert f'id="{target}"' in shown or "-types-" in target, (theorem, target)
