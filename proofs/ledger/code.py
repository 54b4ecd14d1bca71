"""The text that a check consists of: itself and all that it uses, read and not run.

A name from outside the ledger counts as the import that binds it, so that no other function takes
its place unseen.
"""

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_TREES = ("proofs", "compensator_theory/strategies")
_RUNNERS = "proofs.ledger"  # what runs the checks is signed once, not with each of them
_MODULE = "(module)"  # what a module does besides defining names
_FORBIDDEN = {"setattr", "delattr", "globals", "load_profile", "register_profile", "import_module"}
"""Calls at the level of a module with which it would change what others are."""


@dataclass
class Code:
    """The definitions of the ledger's modules and of the strategies, by module and name.

    Examples
    --------
    >>> from proofs.ledger.code import Code
    >>> closure = Code().closure("proofs.symbolic.joint_fit", "unseen_direction")
    >>> "proofs.symbolic.letters.letters" in closure
    True
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
        waiting, visited = [(module, name)], set()
        while waiting:
            where, definition = waiting.pop()
            read = self.module(where)
            key = f"{where}.{definition}"
            if read is None or where.startswith(_RUNNERS) or key in visited:
                continue
            visited.add(key)
            if definition in read.imported:
                source, name = read.imported[definition]
                sources[key] = f"from {source} import {name}"
                waiting.append((source, name))
            elif definition in read.defined:
                texts, used = read.defined[definition]
                sources[key] = " ".join(" ".join(texts).split())
                waiting += [(where, other) for other in used]
            waiting += [(where, _MODULE), *((above, _MODULE) for above in _packages(where))]
        return sources

    def modules(self) -> list[str]:
        """List the modules of the trees."""
        names = []
        for tree in _TREES:
            for path in sorted((self.root / tree).rglob("*.py")):
                parts = path.relative_to(self.root).with_suffix("").parts
                names.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
        return names

    def own_code(self, module: str) -> str:
        """Return the digest of what a module does when it is imported, but for its definitions."""
        read = self.module(module)
        texts, _ = ([], set()) if read is None else read.defined.get(_MODULE, ([], set()))
        return digest(*(" ".join(text.split()) for text in texts))

    def intrusions(self) -> list[str]:
        """List the statements of modules that change what is not theirs."""
        sentences = []
        for name in self.modules():
            read = self.module(name)
            sentences += [f"{name}, line {line}" for line in (read.intrusions if read else ())]
        return sentences

    def digest(self, module: str, name: str) -> str:
        """Return the digest of a closure; that of nothing where there is no such definition."""
        return digest(
            *(f"{key} = {text}" for key, text in sorted(self.closure(module, name).items()))
        )


def _packages(module: str) -> list[str]:
    """List the packages that are imported before a module."""
    parts = module.split(".")
    return [".".join(parts[:size]) for size in range(1, len(parts))]


def digest(*texts: str) -> str:
    """Return 12 hexadecimal digits of texts, which differ where a text or its place does."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:12]


@dataclass
class _Module:
    """Top-level definitions: name, their texts, the names that they use; and what is imported."""

    defined: dict[str, tuple[list[str], set[str]]] = field(default_factory=dict)
    imported: dict[str, tuple[str, str]] = field(default_factory=dict)
    intrusions: list[int] = field(default_factory=list)

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
            if isinstance(node, ast.Import):
                for alias in node.names:
                    bound = alias.asname or alias.name.partition(".")[0]
                    read.imported[bound] = (alias.name, "")
                continue
            if _is_text(node):
                continue
            if _intrudes(node):
                read.intrusions.append(node.lineno)
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
        for target in _targets(node):
            yield target.id if isinstance(target, ast.Name) else _MODULE
    else:
        yield _MODULE


def _targets(node: ast.Assign | ast.AnnAssign) -> Iterator[ast.expr]:
    """List what an assignment binds, one by one."""
    waiting = list(node.targets) if isinstance(node, ast.Assign) else [node.target]
    while waiting:
        target = waiting.pop()
        if isinstance(target, ast.Tuple | ast.List):
            waiting += target.elts
        else:
            yield target.value if isinstance(target, ast.Starred) else target


def _intrudes(node: ast.stmt) -> bool:
    """Whether a statement of a module assigns an attribute or an item, or calls what may do so."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return False
    for part in ast.walk(node):
        if isinstance(part, ast.Attribute | ast.Subscript) and not isinstance(part.ctx, ast.Load):
            return True
        if isinstance(part, ast.Call):
            name = part.func.attr if isinstance(part.func, ast.Attribute) else part.func
            called = name.id if isinstance(name, ast.Name) else name
            if called in _FORBIDDEN:
                return True
    return False
