"""Write the student's version of notebooks: ``python -m compensator_theory.teaching FROM TO``."""

from __future__ import annotations

import sys
from pathlib import Path

from compensator_theory.errors import CompensatorError
from compensator_theory.teaching._notebooks import write_student_notebooks


def main(arguments: list[str]) -> int:
    """Return the exit status: 2 for a wrong call or a notebook that cannot be read."""
    if len(arguments) != 2:
        print("usage: python -m compensator_theory.teaching TEACHER STUDENT", file=sys.stderr)
        return 2
    teacher, student = map(Path, arguments)
    try:
        written = write_student_notebooks(teacher, student)
    except (CompensatorError, OSError) as error:
        print(f"compensator_theory.teaching: {error}", file=sys.stderr)
        return 2
    print(*written, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
