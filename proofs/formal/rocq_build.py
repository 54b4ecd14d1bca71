"""Compiling the formal part, where Coq is installed."""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .assumptions import unproved
from .rocq_sources import SOURCES, defined, sources
from .types import changed, printed_statements
from .witnesses import without_witness, witnesses

PACKAGES = (
    "coq libcoq-mathcomp libcoq-mathcomp-real-closed libcoq-mathcomp-algebra-tactics "
    "libcoq-mathcomp-zify"
)
"""Debian's names of what the formal part needs."""


@dataclass(frozen=True)
class Compilation:
    """The result of compiling the formal part.

    Attributes
    ----------
    status : str
        ``not asked``, ``not installed``, ``compiled`` or ``failed``.
    detail : str
        In words.
    answers : dict of str
        For each theorem why it is not proved; empty strings where it is, without axioms, and says
        what is committed.
    """

    status: str
    detail: str
    answers: dict[str, str]

    @property
    def holds(self) -> bool:
        """Whether nothing failed; what was not compiled has not failed."""
        return self.status != "failed" and not any(self.answers.values())


NOT_COMPILED = Compilation(
    "not asked", "the formal part was not compiled in this run; --formal does", {}
)


def compile_formal_part(theorems: Iterable[str], folder: Path = SOURCES) -> Compilation:
    """Compile every file and ask Coq what the theorems rest on and what they say.

    Examples
    --------
    >>> from proofs.formal.rocq_build import compile_formal_part
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
    if not sources(folder):
        return Compilation("failed", f"{folder} holds no Coq files", unproved(theorems, folder))
    run = subprocess.run(
        ["make", "-k", "all"], cwd=folder, capture_output=True, text=True, check=False
    )
    if run.returncode:
        _remove_outdated(folder)  # an older .vo would answer for a file that no longer compiles
    answers, definitions = examine(theorems, folder)
    if run.returncode:
        errors = [line for line in run.stderr.splitlines() if "Error" in line or "File" in line]
        return Compilation("failed", "does not compile: " + " ".join(errors[:4]), answers)
    wrong = [f"{name} {reason}" for name, reason in definitions.items() if reason]
    if wrong:
        return Compilation("failed", "; ".join(wrong[:4]), answers)
    return Compilation("compiled", "the formal part compiles", answers)


def examine(
    theorems: Iterable[str], folder: Path = SOURCES
) -> tuple[dict[str, str], dict[str, str]]:
    """Ask Coq about theorems and about every definition; the files must have been compiled.

    Returns
    -------
    theorems, definitions : dict of str
        Why a theorem is not proved or not the committed one, why a definition is not the committed
        one; empty where all is well.
    """
    theorems = tuple(theorems)
    known = witnesses(folder)
    shown = {name: known[key] for name in theorems if (key := name.partition(".")[2]) in known}
    proved, every = unproved([*theorems, *shown.values()], folder), defined(folder)
    alone = without_witness(theorems, folder)
    answers = {name: proved[name] for name in theorems}
    statements, _ = printed_statements(answers, every, folder)
    differs = changed(statements, folder)
    return (
        {
            name: reason
            or differs[name]
            or alone.get(name, "")
            or _of_witness(shown.get(name), proved)
            for name, reason in answers.items()
        },
        {name: differs[name] for name in every},
    )


def _of_witness(witness: str | None, proved: dict[str, str]) -> str:
    """Say why a theorem's witness shows nothing; empty if it does, or if there is none."""
    reason = proved[witness] if witness else ""
    return f"its witness {witness}: {reason}" if reason else ""


def _remove_outdated(folder: Path) -> None:
    """Remove each .vo whose file, or one that it needs, has changed since."""
    for compiled in folder.rglob("*.vo"):
        target = compiled.relative_to(folder).as_posix()
        question = ["make", "-q", "-f", "CoqMakefile", target]
        if subprocess.run(question, cwd=folder, capture_output=True, check=False).returncode:
            compiled.unlink()
