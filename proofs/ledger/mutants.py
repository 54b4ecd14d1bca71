"""Mutants of the checks: a check that holds whatever it says is none.

A mutant is the check's module with one thing changed in the check or in what it calls there: a
sign, a number, a comparison, or what a function returned. It is caught where the check then finds
something false; one that cannot be computed is caught by nothing. ``python -m
proofs.ledger.mutants`` runs all of them and lists those that live.
"""

import ast
import inspect
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from .checks import ForAll
from .code import Code
from .entries import Entry
from .ledger import ledger

Check = tuple[str, str]
"""A package of checks and the check's ``module.name``."""

_OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult}
_COMPARISONS = {
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE,
    ast.LtE: ast.Gt, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
_EXAMPLES = 15
_TRIES = 16


@dataclass(frozen=True)
class Mutant:
    """One change of a check's module.

    Attributes
    ----------
    check : Check
    change : str
        The expression that is changed, and into what.
    kind : str
        ``sign``, ``number``, ``result`` or ``comparison``; the last is no measure of a check that
        compares a thing with itself.
    tree : ast.Module
    """

    check: Check
    change: str
    kind: str
    tree: ast.Module

    @property
    def is_caught(self) -> bool:
        """Whether the changed check finds something false."""
        package, name = self.check
        module, _, function = name.partition(".")
        full = f"proofs.{package}.{module}"
        namespace: dict[str, Any] = {
            "__name__": full, "__package__": f"proofs.{package}", "_moved": moved,
        }  # fmt: skip
        try:
            exec(compile(self.tree, full, "exec"), namespace)
            return _finds_something_false(package, namespace[function])
        except Exception:  # what cannot be computed says nothing
            return False


def _finds_something_false(package: str, check: Any) -> bool:
    if isinstance(check, ForAll):
        outcome = check.run(_EXAMPLES, kept=0.01, shrinks=False)
        return outcome.detail.startswith("false for")
    if package == "counterexamples":
        return any(holds is False for _, holds in check())
    sizes = [1, 2] if inspect.signature(check).parameters else []
    answers = [check(n) for n in sizes] if sizes else [check()]
    return any(answer is False for answer in answers)


def checks_of(entry: Entry) -> Iterator[Check]:
    """List the checks that an entry names.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> from proofs.ledger.mutants import checks_of
    >>> list(checks_of(select(["lemma-1"])[0]))
    [('properties', 'polynomials.lemma_1'), ('counterexamples', 'placement.constant_zero')]
    """
    yield from (("symbolic", piece.check) for piece in entry.symbolic)
    yield from (("properties", piece.check) for piece in entry.properties)
    yield from (("counterexamples", piece.check) for piece in entry.counterexamples)


def mutants(package: str, check: str, code: Code | None = None) -> Iterator[Mutant]:
    """Generate the mutants of a check, those of its own text before those of what it calls.

    Examples
    --------
    >>> from proofs.ledger.mutants import mutants
    >>> mutant = next(mutants("symbolic", "joint_fit.unseen_direction"))
    >>> " -> " in mutant.change, mutant.is_caught
    (True, True)
    """
    module, _, name = check.partition(".")
    full = f"proofs.{package}.{module}"
    code = code or Code()
    nodes = [
        key.rpartition(".")[2] for key in code.closure(full, name) if key.startswith(f"{full}.")
    ]
    source = code.root.joinpath(*full.split(".")).with_suffix(".py").read_text(encoding="utf-8")
    tree = ast.parse(source)
    known = {n for node in tree.body if isinstance(node, ast.ImportFrom) for n in _names(node)}
    for node in sorted(tree.body, key=lambda node: not _defines(node, [name])):
        if not _defines(node, nodes) or _draws(node):
            continue
        inner = deepcopy(node)
        body = inner.body if isinstance(inner, ast.FunctionDef) else [inner]
        for kind, before, after, undo in _changes(body, known):
            changed = ast.Module([inner if n is node else n for n in tree.body], [])
            copy = ast.fix_missing_locations(deepcopy(changed))
            undo()
            yield Mutant((package, check), f"{before} -> {after}", kind, copy)


def first_caught(package: str, check: str, tries: int = _TRIES) -> Mutant | None:
    """Find a mutant that is caught, of another kind than a turned comparison; None if none is.

    Examples
    --------
    >>> from proofs.ledger.mutants import first_caught
    >>> first_caught("counterexamples", "resultants.multiple_roots").is_caught
    True
    """
    sharp = [mutant for mutant in mutants(package, check) if mutant.kind != "comparison"]
    step = max(1, len(sharp) // tries)
    for mutant in sharp[::step][: 2 * tries]:
        if mutant.is_caught:
            return mutant
    return None


def moved(value: Any) -> Any:
    """Change what a function returned: a truth is turned, a number or a polynomial is one more.

    A result that `holds` holds no more, or does.

    Raises
    ------
    TypeError
        If there is no such change of it.

    Examples
    --------
    >>> from proofs.ledger.mutants import moved
    >>> moved(3), moved(True), moved([1, 2])
    (4, False, [1])
    """
    if isinstance(value, bool):
        return not value
    if isinstance(value, list | tuple) and value:
        return value[:-1]
    if hasattr(value, "rows") and hasattr(value, "cols") and value.rows and value.cols:
        changed = value.as_mutable()
        changed[0, 0] += 1
        return changed
    if hasattr(value, "holds"):
        return SimpleNamespace(**{**vars(value), "holds": not value.holds})
    return value + 1


def _names(node: ast.ImportFrom) -> Iterator[str]:
    yield from (alias.asname or alias.name for alias in node.names)


def _defines(node: ast.stmt, names: list[str]) -> bool:
    if isinstance(node, ast.FunctionDef):
        return node.name in names
    targets = node.targets if isinstance(node, ast.Assign) else []
    return any(isinstance(n, ast.Name) and n.id in names for t in targets for n in ast.walk(t))


def _draws(node: ast.stmt) -> bool:
    """Whether a definition is a strategy: what is drawn is no claim."""
    if isinstance(node, ast.FunctionDef):
        return any(argument.arg == "draw" for argument in node.args.args)
    return any(isinstance(n, ast.Name) and n.id == "st" for n in ast.walk(node))


def _changes(
    body: list[ast.stmt], known: set[str]
) -> Iterator[tuple[str, str, str, Callable[[], None]]]:
    """Change one node at a time, in place: its kind, what it was and became, and how to undo it."""
    for statement in body:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
            continue  # the docstring
        for node in ast.walk(statement):
            for kind, change, undo in _of(node, known):
                shown = statement.value if isinstance(statement, ast.Return) else node
                before = ast.unparse(shown or node)
                change()
                after = ast.unparse(shown or node)
                if before != after:
                    yield kind, _short(before), _short(after), undo
                undo()


def _short(text: str) -> str:
    return text if len(text) < 90 else text[:87] + "..."


def _of(
    node: ast.AST, known: set[str]
) -> Iterator[tuple[str, Callable[[], None], Callable[[], None]]]:
    def assigned(attribute: str, new: object) -> tuple[Callable[[], None], Callable[[], None]]:
        old = getattr(node, attribute)
        return (lambda: setattr(node, attribute, new)), (lambda: setattr(node, attribute, old))

    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        yield "sign", *assigned("op", _OPERATORS[type(node.op)]())
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", *assigned("op", ast.UAdd())
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield "comparison", *assigned("value", not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int):
        yield "number", *assigned("value", node.value + 1)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _COMPARISONS:
        yield "comparison", *assigned("ops", [_COMPARISONS[type(node.ops[0])]()])
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in known:
        wrapped = ast.Call(ast.Name("_moved", ast.Load()), [deepcopy(node)], [])
        yield "result", *_replaced(node, wrapped)


def _replaced(node: ast.Call, new: ast.Call) -> tuple[Callable[[], None], Callable[[], None]]:
    old = (node.func, node.args, node.keywords)

    def put(func: ast.expr, args: list[ast.expr], keywords: list[ast.keyword]) -> None:
        node.func, node.args, node.keywords = func, args, keywords

    return (lambda: put(new.func, new.args, new.keywords)), (lambda: put(*old))


def main() -> int:
    """Run every mutant of every check; fail where one has none that is caught."""
    checks = dict.fromkeys(check for entry in ledger() for check in checks_of(entry))
    count = caught = blind = 0
    for check in checks:
        results = [(mutant, mutant.is_caught) for mutant in mutants(*check)]
        sharp = [is_caught for mutant, is_caught in results if mutant.kind != "comparison"]
        count, caught = count + len(results), caught + sum(is_caught for _, is_caught in results)
        print(f"{check[1]}: {sum(c for _, c in results)} of {len(results)} mutants caught")
        for mutant, is_caught in results:
            if not is_caught:
                print(f"    lives ({mutant.kind}): {mutant.change}")
        if not any(sharp):
            blind += 1
            print(f"BLIND  {check[1]}: none of its mutants is caught")
    print(f"{caught} of {count} mutants of {len(checks)} checks caught; {blind} checks are blind")
    return 1 if blind else 0


if __name__ == "__main__":
    sys.exit(main())
