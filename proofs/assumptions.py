"""What the theorems of the ledger rest on, asked of Coq; needs the standard library only.

``python -m proofs.assumptions`` is the last step of ``make -C proofs/rocq check``. It exits with 1
if a theorem is missing or rests on an axiom, or if a file assumes instead of proving.
"""

import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from .ledger import ledger, theorems
from .rocq_sources import SOURCES, assumed, missing

LIBRARY = "Compensators"
CLOSED = "Closed under the global context"
_MARK = "==> "


def check_file(names: Iterable[str]) -> str:
    """Write the Coq file that asks for the assumptions of each theorem.

    Examples
    --------
    >>> from proofs.assumptions import check_file
    >>> print(check_file(["Forms.form_is_unique"]))
    From Compensators Require Forms.
    Goal True. idtac "==> Forms.form_is_unique". exact I. Qed.
    Print Assumptions Compensators.Forms.form_is_unique.
    """
    names = tuple(names)
    files = dict.fromkeys(name.split(".", maxsplit=1)[0] for name in names)
    lines = [f"From {LIBRARY} Require {file}." for file in files]
    for name in names:
        lines.append(f'Goal True. idtac "{_MARK}{name}". exact I. Qed.')
        lines.append(f"Print Assumptions {LIBRARY}.{name}.")
    return "\n".join(lines)


def read_answers(output: str) -> dict[str, str]:
    """Read what Coq printed: the axioms of each theorem, empty if there are none.

    Examples
    --------
    >>> from proofs.assumptions import read_answers
    >>> read_answers('''==> A.b
    ... Closed under the global context
    ... ==> A.c
    ... Axioms:
    ... choice : exists f, f''')
    {'A.b': '', 'A.c': 'choice : exists f, f'}
    """
    answers: dict[str, str] = {}
    for part in output.split(_MARK)[1:]:
        name, _, answer = part.partition("\n")
        words = " ".join(answer.split())
        answers[name.strip()] = "" if words == CLOSED else words.removeprefix("Axioms: ") or "?"
    return answers


def ask_coq(names: Iterable[str], folder: Path = SOURCES) -> dict[str, str]:
    """Compile the question; return the axioms of each theorem, or why there is no answer.

    Parameters
    ----------
    names : iterable of str
        ``File.theorem``; the files must have been compiled.
    folder : Path

    Returns
    -------
    dict of str
        Empty strings where a theorem rests on no axiom.
    """
    answers = {name: missing(name, folder) for name in names}
    for name, reason in answers.items():
        compiled = folder / (name.split(".", maxsplit=1)[0] + ".vo")
        if not reason and not compiled.exists():
            answers[name] = f"{compiled.stem}.v does not compile"
    askable = [name for name, reason in answers.items() if not reason]
    if not askable:
        return answers
    (folder / "Check.v").write_text(check_file(askable) + "\n", encoding="utf-8")
    command = ["coqc", "-q", "-R", ".", LIBRARY, "Check.v"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    given = read_answers(run.stdout)
    unanswered = " ".join(run.stderr.split()) or "Coq gave no answer"
    for name in askable:
        axioms = given.get(name, "?")
        unclear = axioms == "?"
        answers[name] = unanswered if unclear else f"rests on axioms: {axioms}" if axioms else ""
    return answers


def report(answers: Mapping[str, str], files: Iterable[str]) -> tuple[str, bool]:
    """Put the answers into words; the second value is whether all is well.

    Examples
    --------
    >>> from proofs.assumptions import report
    >>> text, is_well = report({"A.b": "", "A.c": "proofs/rocq has no file A.v"}, [])
    >>> print(text)
    no axioms  A.b
    FAILS      A.c: proofs/rocq has no file A.v
    1 of 2 theorems of the ledger are proved without axioms
    >>> is_well
    False
    """
    lines = [
        f"FAILS      {name}: {reason}" if reason else f"no axioms  {name}"
        for name, reason in answers.items()
    ]
    files = tuple(files)
    lines += [f"FAILS      {file} assumes instead of proving" for file in files]
    proved = sum(not reason for reason in answers.values())
    lines.append(f"{proved} of {len(answers)} theorems of the ledger are proved without axioms")
    return "\n".join(lines), proved == len(answers) and not files


def main() -> int:
    """Ask about every theorem of the ledger and print the answers."""
    text, is_well = report(ask_coq(theorems(ledger())), assumed())
    print(text)
    return 0 if is_well else 1


if __name__ == "__main__":
    sys.exit(main())
