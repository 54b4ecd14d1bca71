"""The page of named constructions is true: functions, oracles and examples are there."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

from docs.constructions_page import constructions
from tests.support.public import public_objects

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "constructions.md").read_text()
HEAD, _, REST = PAGE.partition("## Examples")
PUBLIC = public_objects("compensator_theory")
EXAMPLES, _, LEFT_OUT = REST.partition("## Left out")
ROWS = constructions()


def test_no_number_is_missing():
    numbers = [row["number"] for row in ROWS]
    numbers += [int(n) for n in re.findall(r"^\| (\d+) ", LEFT_OUT, re.M)]
    assert "<!-- the constructions -->" in HEAD
    assert sorted(numbers) == list(range(1, len(numbers) + 1))


@pytest.mark.parametrize("row", ROWS, ids=[str(row["number"]) for row in ROWS])
def test_a_row_names_what_is_there(row):
    modules = {path.rpartition(".")[2]: path.rpartition(".")[0] for path in row["functions"]}
    assert modules
    for name, module in modules.items():
        assert PUBLIC[name].__module__ == module
    text = (ROOT / row["test"]).read_text()
    assert any(re.search(rf"\b{name}\b", text) for name in modules), row["test"]
    called = {
        node.func.attr
        for node in ast.walk(
            ast.parse("\n".join(re.findall(r">>> (.*)", example_of(row["number"]))))
        )
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }
    assert called & set(modules)


def test_the_drawn_tests_of_each_row_are_there():
    """What benchmarks/construction_oracles.py draws 10 000 cases for."""
    named = tomllib.loads((ROOT / "benchmarks" / "construction_tests.toml").read_text())
    assert set(named) == {str(row["number"]) for row in ROWS}
    for row in ROWS:
        number, path = str(row["number"]), row["test"]
        drawn = {
            node.name
            for node in ast.parse((ROOT / path).read_text()).body
            if isinstance(node, ast.FunctionDef)
            and any("given" in ast.unparse(decorator) for decorator in node.decorator_list)
        }
        assert named[number]
        assert {name.partition("[")[0] for name in named[number]} <= drawn, path


def example_of(number):
    """The lines of the one example that carries this number."""
    result = re.search(rf"^>>> (?:.*  )?# {number}\n(?:>>> .*\n)?", EXAMPLES, re.M)
    assert result, f"construction {number} has no example"
    return result.group()
