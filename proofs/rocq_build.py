"""Compiling the formal part, where Coq is installed."""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .assumptions import ask_coq
from .outcomes import Outcome
from .rocq_sources import SOURCES, missing

PACKAGES = (
    "coq libcoq-mathcomp libcoq-mathcomp-real-closed libcoq-mathcomp-algebra-tactics "
    "libcoq-mathcomp-zify"
)
"""Debian's names of what the formal part needs."""


@dataclass(frozen=True)
class Compilation:
    """What compiling the formal part gave.

    Attributes
    ----------
    status : str
        ``not asked``, ``not installed``, ``compiled`` or ``failed``.
    detail : str
        In words.
    answers : dict of str
        For each theorem why it is not proved; empty strings where it is, without axioms.
    """

    status: str
    detail: str
    answers: dict[str, str]

    @property
    def holds(self) -> bool:
        """Whether nothing failed; what was not compiled has not failed."""
        return self.status != "failed" and not any(self.answers.values())


NOT_ASKED = Compilation(
    "not asked", "the formal part was not compiled in this run; --formal does", {}
)


def compile_formal_part(theorems: Iterable[str], folder: Path = SOURCES) -> Compilation:
    """Compile every file and ask Coq for the assumptions of the theorems.

    Examples
    --------
    >>> from proofs.rocq_build import compile_formal_part
    >>> import shutil
    >>> if shutil.which("coqc") is None:
    ...     assert compile_formal_part([]).status == "not installed"
    """
    absent = [tool for tool in ("coqc", "coq_makefile", "make") if shutil.which(tool) is None]
    if absent:
        return Compilation(
            "not installed",
            f"the formal part was NOT compiled: {', '.join(absent)} not found. On Debian: "
            f"apt-get install --no-install-recommends make {PACKAGES}",
            {},
        )
    if not any(folder.glob("*.v")):
        return Compilation("failed", f"{folder} holds no Coq files", ask_coq(theorems, folder))
    run = subprocess.run(
        ["make", "-k", "all"], cwd=folder, capture_output=True, text=True, check=False
    )
    if run.returncode:
        _remove_outdated(folder)  # an older .vo would answer for a file that no longer compiles
    answers = ask_coq(theorems, folder)
    if run.returncode:
        errors = [line for line in run.stderr.splitlines() if "Error" in line or "File" in line]
        return Compilation("failed", "does not compile: " + " ".join(errors[:4]), answers)
    return Compilation("compiled", "the formal part compiles", answers)


def _remove_outdated(folder: Path) -> None:
    """Remove each .vo whose file, or one that it needs, has changed since."""
    for compiled in folder.glob("*.vo"):
        question = ["make", "-q", "-f", "CoqMakefile", compiled.name]
        if subprocess.run(question, cwd=folder, capture_output=True, check=False).returncode:
            compiled.unlink()


def formal_outcome(
    kind: Literal["formal", "refutation"], theorem: str, says: str, compilation: Compilation
) -> Outcome:
    """Say what is known about a theorem after this run.

    Examples
    --------
    >>> from proofs.rocq_build import NOT_ASKED, formal_outcome
    >>> formal_outcome("formal", "Nowhere.nothing", "any n", NOT_ASKED).status
    'missing'
    """
    if compilation.status in ("not asked", "not installed"):
        reason = missing(theorem)
        return Outcome(kind, theorem, says, "missing" if reason else "not compiled", detail=reason)
    reason = compilation.answers.get(theorem, "not asked of Coq")
    if reason:
        return Outcome(kind, theorem, says, "fails", detail=reason)
    return Outcome(kind, theorem, says, "holds", "no axioms")
