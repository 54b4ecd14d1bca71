"""Asking Coq: one file of questions, one answer for each."""

import subprocess
from collections.abc import Mapping
from pathlib import Path

from .rocq_sources import QUESTION, source

LIBRARY = "Compensators"
_MARK = "==> "
_SAY = 'Goal Logic.True. idtac "{}". exact Logic.I. Qed.'


def say(words: str) -> str:
    """Make Coq print some words.

    Examples
    --------
    >>> from proofs.formal.questions import say
    >>> say("next")
    'Goal Logic.True. idtac "next". exact Logic.I. Qed.'
    """
    return _SAY.format(words)


def question_file(questions: Mapping[str, str], preamble: str = "") -> str:
    """Write the Coq file that asks about each theorem or definition ``folder.File.name``.

    The files are required, not imported: a notation of theirs is not used in an answer, so that
    what it stands for is seen.

    Examples
    --------
    >>> from proofs.formal.questions import question_file
    >>> print(question_file({"theorems.Forms.form_is_unique": "Print Assumptions {}."}))
    From Compensators.theorems Require Forms.
    Goal Logic.True. idtac "==> theorems.Forms.form_is_unique". exact Logic.I. Qed.
    Print Assumptions Compensators.theorems.Forms.form_is_unique.
    """
    modules = dict.fromkeys(name.rpartition(".")[0] for name in questions)
    lines = [preamble] if preamble else []
    for module in modules:
        *folders, file = f"{LIBRARY}.{module}".split(".")
        lines.append(f"From {'.'.join(folders)} Require {file}.")
    for name, question in questions.items():
        lines.append(say(_MARK + name))
        lines.append(question.replace("{}", f"{LIBRARY}.{name}"))
    return "\n".join(lines)


def read_answers(output: str) -> dict[str, str]:
    r"""Cut what Coq printed into the answer of each name.

    Examples
    --------
    >>> from proofs.formal.questions import read_answers
    >>> read_answers('''==> A.b
    ... Closed under the global context
    ... ==> A.c
    ... Axioms:
    ... choice : exists f, f''')
    {'A.b': 'Closed under the global context', 'A.c': 'Axioms:\nchoice : exists f, f'}
    """
    parts = (part.partition("\n") for part in output.split(_MARK)[1:])
    return {name.strip(): answer.strip() for name, _, answer in parts}


def ask(
    questions: Mapping[str, str], folder: Path, preamble: str = ""
) -> tuple[dict[str, str], str]:
    """Ask Coq; return the answers, and what it complained of.

    Parameters
    ----------
    questions : dict of str
        For each name the commands, with {} in its place; the files must have been compiled.
    folder : Path
    preamble : str
        What stands at the head of the file.
    """
    answers: dict[str, str] = {}
    complaint, waiting = "", dict(questions)
    while waiting:
        (folder / QUESTION).write_text(question_file(waiting, preamble) + "\n", encoding="utf-8")
        command = ["coqc", "-q", "-w", "none", "-R", ".", LIBRARY, QUESTION]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        read = read_answers(run.stdout)
        if not run.returncode:
            return answers | read, complaint
        complaint = complaint or " ".join(run.stderr.split())
        if not read:  # a file cannot be required
            return answers, complaint
        *whole, broken = read  # Coq stops at the first question that it cannot answer
        answers |= {name: read[name] for name in whole} | {broken: ""}
        waiting = {name: words for name, words in waiting.items() if name not in read}
    return answers, complaint


def compiled(name: str, folder: Path) -> bool:
    """Whether the file of a theorem or definition has been compiled."""
    return source(name, folder).with_suffix(".vo").exists()
