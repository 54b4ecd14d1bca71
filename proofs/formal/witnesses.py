"""For each theorem with hypotheses a witness, a lemma that they can be met; standard library only.

``Lemma NAME : ltac:(can_be_met (@File.NAME)).`` says that the type of the theorem, with False in
the place of its conclusion, is false. A hypothesis that contradicts the others leaves no proof.
"""

import re
from collections.abc import Iterable
from pathlib import Path

from .questions import ask, compiled
from .rocq_sources import SOURCES, sources, without_comments

_FOLDER = "witnesses"
_WITNESS = re.compile(r"^Lemma (\w+) :\s+ltac:\(can_be_met \(@(\w+)\.(\w+)\)\)\.", re.M)
_NEEDED = "it has hypotheses"
_QUESTION = f"""\
Goal ltac:(let T := type of (@{{}}) in exact T).
cbv zeta; intros; try match goal with H : ?P |- _ =>
  lazymatch type of P with Prop => idtac "{_NEEDED}" end end.
Abort."""


def witnesses(folder: Path = SOURCES) -> dict[str, str]:
    """Find the witnesses, ``folder.File.name``, by the ``File.name`` of their theorems.

    Examples
    --------
    >>> from proofs.formal.witnesses import witnesses
    >>> witnesses()["Diophantine.lemma_1"]
    'witnesses.Placement.lemma_1'
    """
    witnessed = {}
    for path in sources(folder):
        if path.parent.name == _FOLDER:
            text = without_comments(path.read_text(encoding="utf-8"))
            for name, file, theorem in _WITNESS.findall(text):
                if name == theorem:
                    witnessed[f"{file}.{theorem}"] = f"{_FOLDER}.{path.stem}.{name}"
    return witnessed


def without_witness(theorems: Iterable[str], folder: Path = SOURCES) -> dict[str, str]:
    """Say of compiled theorems with hypotheses that nothing shows that they can be met."""
    known = witnesses(folder)
    alone = [
        name for name in theorems if name.partition(".")[2] not in known and compiled(name, folder)
    ]
    answers, _ = ask(dict.fromkeys(alone, _QUESTION), folder)
    return {
        name: "nothing in witnesses shows that its hypotheses can be met"
        for name in alone
        if _NEEDED in answers.get(name, _NEEDED)
    }
