"""The exercises of the exact half as tables, made from the tests that solve them."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from docs.errata_page import escaped
from docs.reference_pages import public_names

FOLDER = Path(__file__).resolve().parents[1] / "tests" / "compensator_theory" / "exercises"
PACKAGE = "compensator_theory"
# In the order of a course.
CHAPTERS = (
    "transfer_functions",
    "controllability_and_zeros",
    "canonical_forms",
    "polynomial_equations",
    "pole_placement",
    "observers",
    "stability",
    "root_locus_and_margins",
    "sampling",
    "matrix_equations",
    "riccati_and_lqg",
    "norms_and_interpolation",
    "stabilising_compensators",
    "decoupling",
    "descriptor_systems",
    "observer_based_compensators",
)


@dataclass(frozen=True)
class Exercise:
    """An exercise, posed in one line, and the public functions that its solution calls."""

    chapter: int
    number: int
    name: str
    poses: str
    functions: tuple[str, ...]


def sources() -> tuple[Path, ...]:
    """Every file of exercises, by chapter."""
    return tuple(FOLDER / f"test_{chapter}.py" for chapter in CHAPTERS)


def exercises(path: Path) -> Iterator[Exercise]:
    """Those of one file, in its order."""
    tree = ast.parse(path.read_text("utf-8"))
    for number, test in enumerate(_tests(tree), 1):
        yield Exercise(
            CHAPTERS.index(path.stem.removeprefix("test_")) + 1,
            number,
            test.name,
            ast.get_docstring(test) or "",
            _functions(test, {f.name: f for f in tree.body if isinstance(f, ast.FunctionDef)}),
        )


def exercises_page() -> str:
    """All of them as Markdown, a table for each chapter."""
    lines: list[str] = []
    for path in sources():
        title = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").rstrip(".")
        chapter = list(exercises(path))
        lines += ["", f"## {chapter[0].chapter}. {title}", ""]
        lines += [f"`{path.relative_to(FOLDER.parents[2])}`", ""]
        lines += ["| | exercise | solved by |", "|---|---|---|"]
        for e in chapter:
            solved = ", ".join(map(_link, e.functions))
            lines.append(f"| {e.chapter}.{e.number} | {escaped(e.poses)} | {solved} |")
    return "\n".join(lines).strip() + "\n"


def count() -> int:
    """How many there are."""
    return sum(len(list(exercises(path))) for path in sources())


def _tests(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield node


def _functions(test: ast.FunctionDef, local: dict[str, ast.FunctionDef]) -> tuple[str, ...]:
    """The public names that a test calls or hands on, also through helpers of its file."""
    nodes = list(ast.walk(test))
    named = [n for n in nodes if isinstance(n, ast.Name | ast.Attribute)]
    used = [n.id if isinstance(n, ast.Name) else n.attr for n in sorted(named, key=_place)]
    for name in dict.fromkeys(used):
        if name in local:
            used += _functions(local[name], {})
    public = public_names(PACKAGE)
    return tuple(dict.fromkeys(name for name in used if name in public))


def _place(node: ast.expr) -> tuple[int, int]:
    return node.lineno, node.col_offset


def _link(name: str) -> str:
    """To the reference of a public function or class."""
    role = "class" if name[0].isupper() else "func"
    return f"{{py:{role}}}`{name} <{public_names(PACKAGE)[name]}.{name}>`"
