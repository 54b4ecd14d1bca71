"""A teacher's notebook and the student's: nbgrader's marks and metadata, and nothing installed."""

from __future__ import annotations

import copy
import json
import os
import re
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeAlias

from compensator_theory.errors import InputError

Notebook: TypeAlias = dict[str, Any]

_SOLUTION = re.compile(
    r"^([ \t]*)### BEGIN SOLUTION[^\n]*\n.*?^[ \t]*### END SOLUTION[^\n]*$", re.M | re.S
)
_STUB = "{0}# YOUR CODE HERE\n{0}raise NotImplementedError()"
"""That of nbgrader, whose student version is the same."""
_BEGIN = "### BEGIN SOLUTION"
_MARK = re.compile(r"### (?:BEGIN|END) SOLUTION")


def student_notebook(notebook: Notebook) -> Notebook:
    """Return a notebook without its solutions and without outputs.

    Parameters
    ----------
    notebook : dict
        A notebook of format 4 as JSON has it. In the cells that nbgrader marks as solutions, the
        lines from ``### BEGIN SOLUTION`` to ``### END SOLUTION`` are replaced by a
        ``NotImplementedError``, with their indentation.

    Returns
    -------
    dict
        A new notebook; metadata, and so nbgrader's grades and locks, are the same.

    Raises
    ------
    InputError
        If it is no notebook, a mark has no partner, or a cell that is graded as a solution has
        none.

    Notes
    -----
    ``python -m compensator_theory.teaching TEACHER STUDENT`` does so for a folder. The marks and
    the metadata are those of nbgrader (``ClearSolutions``), which can grade the notebooks, too.

    Examples
    --------
    >>> from compensator_theory.teaching import student_notebook
    >>> source = '''
    ... def gain(a):
    ...     ### BEGIN SOLUTION
    ...     return -a
    ...     ### END SOLUTION
    ... '''
    >>> cell = {"cell_type": "code", "source": source.strip(), "outputs": [],
    ...         "metadata": {"nbgrader": {"solution": True, "grade_id": "gain"}}}
    >>> notebook = student_notebook({"nbformat": 4, "cells": [cell]})
    >>> print("".join(notebook["cells"][0]["source"]))
    def gain(a):
        # YOUR CODE HERE
        raise NotImplementedError()
    """
    if not isinstance(notebook, dict) or notebook.get("nbformat") != 4 or not _has_cells(notebook):
        raise InputError("a notebook must be a dict of nbformat 4 with cells, as JSON has it")
    result = copy.deepcopy(notebook)
    for number, cell in enumerate(result["cells"]):
        text = "".join(cell["source"])
        if cell.get("metadata", {}).get("nbgrader", {}).get("solution"):
            cleared, replaced = _SOLUTION.subn(lambda found: _STUB.format(found[1]), text)
            if not replaced:
                raise InputError(f"cell {number} is marked as a solution and has no {_BEGIN!r}")
        else:
            cleared = text
        if _MARK.search(cleared):
            raise InputError(
                f"cell {number}: each '### BEGIN SOLUTION' needs an '### END SOLUTION', and "
                "nbgrader's metadata with solution = true"
            )
        cell["source"] = cleared.splitlines(keepends=True)
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    return result


def _has_cells(notebook: Notebook) -> bool:
    """Whether every cell has its kind, its source and its metadata."""
    cells = notebook.get("cells")
    return isinstance(cells, list) and all(
        isinstance(cell, dict)
        and isinstance(cell.get("cell_type"), str)
        and isinstance(cell.get("source"), str | list)
        and all(isinstance(line, str) for line in cell["source"])
        and isinstance(cell.get("metadata", {}), dict)
        and isinstance(cell.get("metadata", {}).get("nbgrader", {}), dict)
        for cell in cells
    )


def write_student_notebooks(teacher: Path, student: Path) -> list[Path]:
    """Write the student's version of a notebook, or of all in a folder; the files written."""
    if not teacher.exists():
        raise InputError(f"there is no file and no folder {str(teacher)!r}")
    if teacher.resolve() == student.resolve():
        raise InputError("the student's folder must not be the teacher's")
    sources = sorted(teacher.glob("*.ipynb")) if teacher.is_dir() else [teacher]
    if not sources:
        raise InputError(f"the folder {str(teacher)!r} has no notebook *.ipynb")
    notebooks = {path.name: student_notebook(_read(path)) for path in sources}
    _require_own(student, notebooks)
    for name, notebook in notebooks.items():
        text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
        (student / name).write_text(text, encoding="utf-8")
    return [student / name for name in notebooks]


def _require_own(student: Path, names: Iterable[str]) -> None:
    """Make the folder; refuse a link or a device under a name in it, which leads out of it."""
    try:
        student.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"the folder {str(student)!r} cannot be made: {error.strerror}") from None
    for path in (student / name for name in names):
        if os.path.lexists(path) and not stat.S_ISREG(os.lstat(path).st_mode):
            raise InputError(f"{str(path)!r} is no regular file and is not written; remove it")


def _read(path: Path) -> Notebook:
    try:
        notebook: Notebook = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{str(path)!r} is no notebook: {error}") from None
    return notebook
