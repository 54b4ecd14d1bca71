"""The notebooks of the course: nbgrader's metadata, pure exact theory, outputs as stored."""

import ast
import json
import re
import sys
from pathlib import Path

import pytest

from compensator_theory.teaching import course_exercises, student_notebook

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks" / "course").glob("*.ipynb"))
PAGE = (ROOT / "docs" / "teaching.md").read_text("utf-8")


def cells(path, kind="code"):
    """The cells of one kind."""
    notebook = json.loads(path.read_text("utf-8"))
    return [cell for cell in notebook["cells"] if cell["cell_type"] == kind]


def grading(cell):
    return cell["metadata"].get("nbgrader", {})


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_each_exercise_is_posed_answered_and_graded(path):
    step = int(path.stem[:2])
    numbers = [number for number in course_exercises() if number.split(".")[0] == str(step)]
    posed = re.findall(r"\*\*Exercise (\S+)\.\*\*", str(cells(path, "markdown")))
    answers = [cell for cell in cells(path) if grading(cell).get("solution")]
    checks = [cell for cell in cells(path) if grading(cell).get("grade")]
    assert posed == numbers and len(answers) == len(checks) == len(numbers)
    for number, answer, check in zip(numbers, answers, checks, strict=True):
        assert grading(answer)["grade_id"] == f"answer-{number.replace('.', '-')}"
        assert grading(check)["grade_id"] == f"check-{number.replace('.', '-')}"
        assert grading(check)["locked"] and grading(check)["points"] == 1
        assert "".join(check["source"]).startswith(f'check("{number}", ')
        assert "Right" in str(check["outputs"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_needs_the_exact_half_alone(path):
    for cell in cells(path):
        assert all(output["output_type"] != "error" for output in cell["outputs"])
        for node in ast.walk(ast.parse("".join(cell["source"]))):
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                modules = [node.module]
            else:
                continue
            roots = {module.split(".")[0] for module in modules}
            assert roots <= {"compensator_theory", "sympy"} | sys.stdlib_module_names


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_student_has_no_solution_and_every_check(path):
    teacher = json.loads(path.read_text("utf-8"))
    student = student_notebook(teacher)
    for before, after in zip(teacher["cells"], student["cells"], strict=True):
        code = "".join(after["source"])
        assert "SOLUTION" not in code and not after.get("outputs")
        if grading(before).get("solution"):
            assert "NotImplementedError" in code and ast.parse(code)
        else:
            assert code == "".join(before["source"])


def test_the_page_lists_every_notebook():
    listed = re.findall(r"^notebooks/course/(\S+)$", PAGE, re.M)
    assert listed == [path.stem for path in NOTEBOOKS] and len(listed) == 10


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.filterwarnings("ignore")  # of Jupyter's own machinery
def test_a_notebook_runs(path, in_full):
    if not in_full:
        pytest.skip("with --long; the docs build runs it")
    import nbformat
    from nbclient import NotebookClient

    NotebookClient(nbformat.read(path, as_version=4), timeout=600).execute()
