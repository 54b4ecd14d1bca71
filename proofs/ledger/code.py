"""The text that a check consists of: itself and what it uses of the ledger, read and not run."""

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_TREES = ("proofs", "compensator_theory/strategies")
_RUNNERS = "proofs.ledger"  # what runs the checks is no part of what they say
_MODULE = "(module)"  # what a module does besides defining names


@dataclass
class Code:
    """The definitions of the ledger's modules and of the strategies, by module and name.

    Examples
    --------
    >>> from proofs.ledger.code import Code
    >>> sorted(Code().closure("proofs.symbolic.joint_fit", "unseen_direction"))[-2:]
    ['proofs.symbolic.letters.letters', 'proofs.symbolic.letters.reduced']
    """

    root: Path = ROOT
    _read: dict[str, "_Module | None"] = field(default_factory=dict)

    def module(self, name: str) -> "_Module | None":
        """Read a module of the trees; None for any other."""
        if name not in self._read:
            path = self.root.joinpath(*name.split("."))
            inside = any(name.replace(".", "/").startswith(tree) for tree in _TREES)
            file = path.with_suffix(".py") if not path.is_dir() else path / "__init__.py"
            known = inside and file.is_file()
            text = file.read_text(encoding="utf-8") if known else ""
            self._read[name] = _read(name, text, path.is_dir()) if known else None
        return self._read[name]

    def closure(self, module: str, name: str) -> dict[str, str]:
        """Collect the text of a definition and of all that it uses, each under its full name.

        Layout counts for nothing; docstrings count, since they are the statements.
        """
        sources: dict[str, str] = {}
        waiting = [(module, name)]
        while waiting:
            where, definition = waiting.pop()
            read = self.module(where)
            if read is None or where.startswith(_RUNNERS) or f"{where}.{definition}" in sources:
                continue
            if definition in read.imported:
                waiting.append(read.imported[definition])
            elif definition in read.defined:
                texts, used = read.defined[definition]
                sources[f"{where}.{definition}"] = " ".join(" ".join(texts).split())
                waiting += [(where, other) for other in used]
                if _MODULE in read.defined:
                    waiting.append((where, _MODULE))
        return sources

    def digest(self, module: str, name: str) -> str:
        """Return the digest of a closure; that of nothing where there is no such definition."""
        return digest(
            *(f"{key} = {text}" for key, text in sorted(self.closure(module, name).items()))
        )


def digest(*texts: str) -> str:
    """Return 12 hexadecimal digits of texts, which differ where a text or its place does."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:12]


@dataclass
class _Module:
    """Top-level definitions: name, their texts, the names that they use; and what is imported."""

    defined: dict[str, tuple[list[str], set[str]]] = field(default_factory=dict)
    imported: dict[str, tuple[str, str]] = field(default_factory=dict)

    @classmethod
    def read(cls, name: str, text: str, is_package: bool) -> "_Module":
        """Read a module's text."""
        read = cls()
        package = name if is_package else name.rpartition(".")[0]
        for node in _statements(ast.parse(text).body):
            if isinstance(node, ast.ImportFrom):
                above = package.split(".")[: len(package.split(".")) - max(node.level - 1, 0)]
                source = (
                    ".".join([*above, *filter(None, [node.module])]) if node.level else node.module
                )
                for alias in node.names:
                    read.imported[alias.asname or alias.name] = (source or "", alias.name)
                continue
            if isinstance(node, ast.Import) or _is_text(node):
                continue
            first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])
            segment = "\n".join(text.splitlines()[first - 1 : node.end_lineno])
            used = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
            for target in _names(node):
                texts, names = read.defined.setdefault(target, ([], set()))
                texts.append(segment)
                names |= used - {target}
        return read


_read = lru_cache(maxsize=256)(_Module.read)


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """List statements; those tried stand for the attempt, which has no name of its own."""
    for node in body:
        yield from _statements(node.body) if isinstance(node, ast.Try) else [node]


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _names(node: ast.stmt) -> Iterator[str]:
    """List the names that a statement defines; the module's own where it defines none."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        yield from {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}
    else:
        yield _MODULE
