"""Examples that run where `compensator_theory` is alone, as in a browser.

``python -m docs.browser.examples`` prints them by page, as JSON.
"""

import ast
import json
import re
import sys
from collections.abc import Collection, Iterator, Sequence
from itertools import compress
from pathlib import Path

INSTALLED = {"compensator_theory", "attr", "attrs", "flint", "hypothesis", "mpmath", "sympy"}
"""Packages that the browser has: the wheels under `exact` in pins.toml, by import name."""
LECTURE = INSTALLED | {"IPython"}
"""The same of the kernel of a lecture."""
FENCE = re.compile(
    r"^```(?P<cell>\{code-cell\} )?(?:python|pycon)\n(?:---\n.*?^---\n)?(?P<code>.*?)^```",
    re.M | re.S,
)
OPTION = re.compile(r"^:[\w-]+:.*\n?", re.M)  # of a code cell

GENERATED = ("_build", "reference", "notebooks", "jupyter_execute")  # by the build
MAGIC = re.compile(r"^[%!].*$", re.M)


def source(example: str) -> str:
    r"""The code of an example, without the prompts and the answers of a session.

    Examples
    --------
    >>> from docs.browser.examples import source
    >>> source(">>> for k in range(2):\n...     k\n0\n1\n>>> 2")
    'for k in range(2):\n    k\n2'
    """
    lines = example.splitlines()
    if not any(line.startswith(">>> ") for line in lines):
        return example
    return "\n".join(line[4:] for line in lines if line.startswith((">>>", "...")))


def pages() -> dict[str, list[str]]:
    """The examples that run alone, by page, of all pages that are written and have some.

    Examples
    --------
    >>> from docs.browser.examples import pages
    >>> "strategies" in pages()
    True
    """
    docs = Path(__file__).resolve().parents[1]
    alone = {}
    for path in sorted(docs.rglob("*.md")):
        name = path.relative_to(docs).with_suffix("")
        if name.parts[0] not in GENERATED:
            examples = examples_of_page(path.read_text("utf-8"))
            alone[name.as_posix()] = list(compress(examples, run_alone(examples)))
    return {name: examples for name, examples in alone.items() if examples}


def examples_of_page(text: str) -> list[str]:
    """The examples of a page that its build or its tests run, in their order."""
    return [
        OPTION.sub("", fence["code"])
        for fence in FENCE.finditer(text)
        if fence["cell"] or ">>> " in fence["code"]
    ]


def run_alone(examples: Sequence[str], installed: Collection[str] = INSTALLED) -> list[bool]:
    """Whether each example of a page runs where the exact half is alone, after those before it.

    It, or one before it that runs alone, imports `compensator_theory`; it imports nothing else,
    draws nothing, and uses no name that an example which does not run alone assigned.

    Examples
    --------
    >>> from docs.browser.examples import run_alone
    >>> run_alone(["import numpy as np", "from compensator_theory import resultant", "np.pi"])
    [False, True, False]
    >>> run_alone(["import sympy"])
    [False]
    """
    foreign: set[str] = set()
    answers, is_ours = [], False
    for example in examples:
        code = source(example)
        plain = MAGIC.sub("", code)
        try:
            tree = ast.parse(plain)
        except SyntaxError:  # a sketch, which no build runs
            answers.append(False)
            continue
        imports = set(_imports(tree))
        assigned: set[str] = set()
        alone = plain == code and imports <= {*installed, *sys.stdlib_module_names}
        alone = alone and not _draws(tree)
        for statement in tree.body:
            names = [node for node in ast.walk(statement) if isinstance(node, ast.Name)]
            used = {node.id for node in names if isinstance(node.ctx, ast.Load)}
            alone = alone and not used & (foreign - assigned)
            assigned |= {node.id for node in names if isinstance(node.ctx, ast.Store)}
            assigned |= set(_new(statement))
        is_ours |= alone and "compensator_theory" in imports
        answers.append(alone and is_ours)
        foreign = foreign - assigned if answers[-1] else foreign | assigned
    return answers


def _imports(tree: ast.AST) -> Iterator[str]:
    """The packages that a program imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (node.module or "").partition(".")[0]


def _new(tree: ast.AST) -> Iterator[str]:
    """The names that imports and definitions assign."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name


def _draws(tree: ast.AST) -> bool:
    """Whether a program asks a result for a picture, which needs the numeric half."""
    return any(isinstance(node, ast.Attribute) and node.attr == "plot" for node in ast.walk(tree))


if __name__ == "__main__":
    print(json.dumps(pages()))
