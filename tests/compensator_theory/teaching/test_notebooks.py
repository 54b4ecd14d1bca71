"""Student notebooks: what is cleared, what is refused, and the command."""

import copy
import json
import subprocess
import sys

import pytest

from compensator_theory.errors import InputError
from compensator_theory.teaching import student_notebook

STUB = "# YOUR CODE HERE\nraise NotImplementedError()"
GRADED = {"nbgrader": {"solution": True, "grade_id": "one"}}


def notebook(source, metadata=GRADED, kind="code"):
    cell = {"cell_type": kind, "source": source, "metadata": metadata, "outputs": [1]}
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": [cell]}


@pytest.mark.parametrize(
    ("source", "student"),
    [
        ("### BEGIN SOLUTION\nx = 1\n### END SOLUTION", STUB),
        (
            "def f(a):\n    ### BEGIN SOLUTION\n    return a\n    ### END SOLUTION\n\nf(1)",
            "def f(a):\n    # YOUR CODE HERE\n    raise NotImplementedError()\n\nf(1)",
        ),
        (
            ["### BEGIN SOLUTION\n", "a\n", "### END SOLUTION\n", "b\n",
             "### BEGIN SOLUTION HERE\n", "### END SOLUTION"],
            f"{STUB}\nb\n{STUB}",
        ),
    ],
)  # fmt: skip
def test_solutions_are_replaced_with_their_indentation(source, student):
    teacher = notebook(source)
    before = copy.deepcopy(teacher)
    (cell,) = student_notebook(teacher)["cells"]
    assert "".join(cell["source"]) == student
    assert cell["outputs"] == [] and cell["metadata"] == GRADED and teacher == before


@pytest.mark.parametrize(
    "source",
    [
        None, [], {}, {"nbformat": 3, "cells": []}, {"nbformat": 4}, {"nbformat": 4, "cells": [1]},
        {"nbformat": 4, "cells": 5}, {"nbformat": 4, "cells": [{"source": 1}]},
        notebook("x = 1"), notebook("### BEGIN SOLUTION\nx"), notebook("x\n### END SOLUTION"),
        notebook("### BEGIN SOLUTION\nx\n### END SOLUTION", {}),
        notebook("### BEGIN SOLUTION\n### BEGIN SOLUTION\n### END SOLUTION\n### END SOLUTION"),
    ],
)  # fmt: skip
def test_what_would_give_a_solution_away_is_refused(source):
    with pytest.raises(InputError):
        student_notebook(source)


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "compensator_theory.teaching", *map(str, arguments)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.costly
def test_the_command_writes_a_folder(tmp_path):
    teacher, student = tmp_path / "teacher", tmp_path / "student"
    teacher.mkdir()
    source = notebook("### BEGIN SOLUTION\nsecret\n### END SOLUTION")
    for name in ("a.ipynb", "b.ipynb"):
        (teacher / name).write_text(json.dumps(source))
    done = run(teacher, student)
    assert done.returncode == 0 and done.stderr == ""
    assert [path.name for path in sorted(student.iterdir())] == ["a.ipynb", "b.ipynb"]
    for path in student.iterdir():
        assert json.loads(path.read_text()) == student_notebook(source)


@pytest.mark.costly
@pytest.mark.parametrize("case", ["nothing", "same", "empty", "broken", "missing"])
def test_a_wrong_call_says_why_and_writes_nothing(tmp_path, case):
    teacher, student = tmp_path / "teacher", tmp_path / "student"
    teacher.mkdir()
    if case == "broken":
        (teacher / "a.ipynb").write_text("{")
    if case == "same":
        (teacher / "a.ipynb").write_text(json.dumps(notebook("x", {})))
    arguments = {
        "nothing": (), "same": (teacher, teacher), "missing": (tmp_path / "none", student)
    }.get(case, (teacher, student))  # fmt: skip
    done = run(*arguments)
    assert done.returncode == 2 and done.stderr and "Traceback" not in done.stderr
    assert not student.exists()
