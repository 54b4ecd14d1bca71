"""One fingerprint for each statement, so that none is weakened unseen; standard library only.

A statement is its words, its hypotheses, the names of its evidence, the text of each check with all
that it uses, and for each theorem of Coq its source's statement, the type that Coq prints and the
definitions in it. Signed besides: the list of statements, the errata, and the trusted base, which
runs the checks and prints their outcome. ``python -m proofs.ledger.sign`` shows what
differs from what is signed.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from ..formal.rocq_sources import source, sources, stated, without_proofs
from ..formal.types import committed
from .code import ROOT, Code, digest
from .entries import Entry
from .ledger import read

Parts = dict[str, str]
FILE = Path("proofs/statements/signatures.txt")
ERRATA = Path("rcac_experiments/dissertation/errata_files")
_CHECKS = ("symbolic", "properties", "counterexamples")
_LIST_PARTS = "the list of statements and errata"
_MODULE_PARTS = "what modules do when they are imported"
_RUNNER_PARTS = "what runs the checks and prints their outcome"
_FILE_PARTS = "what surrounds the theorems"


@dataclass(frozen=True)
class Tree:
    """The ledger of a checkout, its Coq files and its checks, as texts.

    Examples
    --------
    >>> from proofs.ledger.signatures import Tree
    >>> Tree().differences()
    {}
    """

    root: Path = ROOT

    def parts(self) -> dict[str, Parts]:
        """Return for each statement, and for the Coq files, the digest of each of its parts."""
        rocq, code = self.root / "proofs" / "rocq", Code(self.root)
        if intrusions := code.intrusions():
            raise ValueError(f"a module changes what is not its own: {', '.join(intrusions)}")
        types = committed(rocq)
        parts = {
            entry.name: dict(_parts(entry, rocq, types, code))
            for entry in read(self.root / "proofs" / "statements")
        }
        parts[_FILE_PARTS] = {
            path.relative_to(rocq).as_posix(): digest(
                without_proofs(path.read_text(encoding="utf-8"))
            )
            for path in sources(rocq)
        }
        entries = list(parts)[:-1]
        errata = dict(_errata(self.root / ERRATA))
        parts |= {f"erratum {name}": words for name, words in errata.items()}
        parts[_LIST_PARTS] = {
            f"{len(entries)} statements": digest(*entries),
            f"{len(errata)} errata": digest(*errata),
        }
        parts[_MODULE_PARTS] = {
            name: code.own_code(name)
            for name in code.modules()
            if not name.startswith("proofs.ledger")
        }
        parts[_RUNNER_PARTS] = {
            path.relative_to(self.root).as_posix(): digest(
                " ".join(path.read_text(encoding="utf-8").split())
            )
            for path in self.trusted_base()
        }
        return parts

    def trusted_base(self) -> list[Path]:
        """List the files on which every outcome depends, besides Python, libraries and Coq."""
        proofs = self.root / "proofs"
        modules = [
            path
            for path in sorted(proofs.rglob("*.py"))
            if path.relative_to(proofs).parts[0] not in _CHECKS
        ]
        settings = [
            proofs / "unproved.toml",
            *(proofs / "rocq" / f for f in ("_CoqProject", "Makefile")),
        ]
        return [*modules, *settings]

    def signed(self) -> dict[str, Parts]:
        """Read what is signed.

        Raises
        ------
        ValueError
            If a fingerprint is not that of the parts below it.
        """
        signed: dict[str, Parts] = {}
        path = self.root / FILE
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        for block in filter(None, text.split("\n\n")):
            head, *lines = block.strip().splitlines()
            print_, _, name = head.partition("  ")
            parts = {line[14:].strip(): line[:14].strip() for line in lines}
            if fingerprint(parts) != print_:
                raise ValueError(f"{FILE}: the fingerprint of {name} is not that of its parts")
            signed[name] = parts
        return signed

    def differences(self) -> dict[str, list[str]]:
        """Say for each statement which parts are changed, new or gone since it was signed."""
        now, then = self.parts(), self.signed()
        differences = {}
        for name in [*now, *(name for name in then if name not in now)]:
            words = list(_differences(then.get(name), now.get(name)))
            if words:
                differences[name] = words
        return differences

    def sign(self) -> None:
        """Write the fingerprints of today."""
        blocks = []
        for name, parts in self.parts().items():
            lines = [f"{fingerprint(parts)}  {name}"]
            blocks.append(
                "\n".join(lines + [f"  {value}  {part}" for part, value in parts.items()])
            )
        (self.root / FILE).write_text("\n\n".join(blocks) + "\n", encoding="utf-8")


def _errata(folder: Path) -> Iterator[tuple[str, Parts]]:
    """List the errata with the digest of each of their parts."""
    for path in sorted(folder.glob("*.toml")):
        for erratum in tomllib.loads(path.read_text(encoding="utf-8"))["erratum"]:
            name = erratum.pop("name")
            yield (
                name,
                {"file": digest(path.stem)}
                | {
                    key: digest(str(sorted(value.items()) if isinstance(value, dict) else value))
                    for key, value in sorted(erratum.items())
                },
            )


def fingerprint(parts: Mapping[str, str]) -> str:
    """Return the one digest of a statement's parts.

    Examples
    --------
    >>> from proofs.ledger.signatures import fingerprint
    >>> fingerprint({"conclusion": "1 = 1"}) == fingerprint({"conclusion": "0 = 0"})
    False
    """
    return digest(*(f"{key} = {value}" for key, value in parts.items()))


def _differences(then: Parts | None, now: Parts | None) -> Iterator[str]:
    if then is None or now is None:
        yield "new" if then is None else "gone"
        return
    for part in [*now, *(part for part in then if part not in now)]:
        if then.get(part) != now.get(part):
            state = "new" if part not in then else "gone" if part not in now else "changed"
            yield f"{part}: {state}"


def _parts(
    entry: Entry, rocq: Path, types: Mapping[str, str], code: Code
) -> Iterator[tuple[str, str]]:
    """List the parts of a statement; evidence is named with its settings."""
    for words in ("chapter", "title", "source", "text", "difference"):
        yield words, digest(getattr(entry, words))
    yield "hypotheses", digest(*entry.hypotheses)
    yield "conclusion", digest(*entry.conclusion)
    yield "relied on by", digest(*entry.relied_on_by)
    for theorem in entry.formal:
        name = theorem.theorem
        yield f"Coq {name}", digest(theorem.says, str(theorem.of), _theorem(name, rocq, types))
    for identity in entry.symbolic:
        settings = str((identity.sizes, identity.extent, identity.of))
        yield (
            f"identity {identity.check}",
            digest(settings, _code("symbolic", identity.check, code)),
        )
    for claim in entry.properties:
        settings = str((claim.examples, claim.kept, claim.of))
        yield f"property {claim.check}", digest(settings, _code("properties", claim.check, code))
    for case in entry.counterexamples:
        settings = str((case.refutes, case.formal, case.in_text))
        theorem_digest = _theorem(case.formal, rocq, types) if case.formal else ""
        text = _code("counterexamples", case.check, code)
        yield f"refuted {case.check}: {case.refutes}", digest(settings, theorem_digest, text)


def _code(package: str, check: str, code: Code) -> str:
    module, _, name = check.partition(".")
    return code.digest(f"proofs.{package}.{module}", name)


def _theorem(name: str, rocq: Path, types: Mapping[str, str]) -> str:
    """Return the digest of a theorem's source, of its type, and of every definition in that."""
    texts, waiting, names = [stated(name, rocq)], [name], {name}
    while waiting:
        text = types.get(waiting.pop(), "")
        texts.append(text)
        words = _words(text)
        used = [
            known for known in types if known not in names and known.rpartition(".")[2] in words
        ]
        waiting += used
        names.update(used)
    return digest(source(name, rocq).stem, *texts)


@lru_cache(maxsize=1024)
def _words(text: str) -> frozenset[str]:
    return frozenset(re.findall(r"\w+", text))
