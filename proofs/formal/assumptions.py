"""What the theorems of the ledger rest on, asked of Coq; needs the standard library only."""

from collections.abc import Iterable
from pathlib import Path

from .questions import LIBRARY, ask, compiled
from .rocq_sources import SOURCES, missing, source

CLOSED = "Closed under the global context"


def axioms(answer: str) -> str:
    r"""Read the axioms out of an answer; empty if there are none, "?" for no answer.

    Examples
    --------
    >>> from proofs.formal.assumptions import axioms
    >>> axioms("Closed under the global context")
    ''
    >>> axioms("Axioms:\nchoice : exists f, f")
    'choice : exists f, f'
    """
    words = " ".join(answer.split())
    return "" if words == CLOSED else words.removeprefix("Axioms: ") or "?"


def unproved(names: Iterable[str], folder: Path = SOURCES) -> dict[str, str]:
    """Say of each theorem why it is not proved without axioms.

    Parameters
    ----------
    names : iterable of str
        ``folder.File.theorem``; the files must have been compiled.
    folder : Path

    Returns
    -------
    dict of str
        Empty strings where a theorem rests on no axiom.
    """
    answers = {name: missing(name, folder) for name in names}
    for name, reason in answers.items():
        if not reason and not compiled(name, folder):
            where = source(name, folder).relative_to(folder).as_posix()
            answers[name] = f"{where} does not compile"
    askable = [name for name, reason in answers.items() if not reason]
    if askable and _closed_together(askable, folder):
        return answers
    answers_of_coq, complaint = ask(dict.fromkeys(askable, "Print Assumptions {}."), folder)
    for name in askable:
        axioms_of_name = axioms(answers_of_coq.get(name, ""))
        unclear = "Coq gave no answer" + (f": {complaint}" if complaint else "")
        answers[name] = (
            unclear
            if axioms_of_name == "?"
            else f"rests on axioms: {axioms_of_name}"
            if axioms_of_name
            else ""
        )
    return answers


def _closed_together(names: list[str], folder: Path) -> bool:
    """Whether no theorem rests on an axiom, asked at once: what they share is then read once.

    In a tuple each component would carry the types of all behind it, and their sizes add up to the
    square; a local definition carries its own.
    """
    *others, last = names
    local = "\n".join(f"let _ := @{LIBRARY}.{name} in" for name in names)
    together = f"Definition together : Logic.True :=\n{local}\nLogic.I."
    question = f"{together}\nPrint Assumptions together."
    answers, _ = ask(dict.fromkeys(others, "") | {last: question}, folder)
    return bool(answers) and axioms(answers.get(last, "")) == ""
