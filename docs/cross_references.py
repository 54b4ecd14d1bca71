"""Where a name leads: to its own page, to the page of a type, to another project's docs."""

import importlib
import inspect
import zlib
from pathlib import Path
from typing import Any

from docs.reference_pages import PACKAGES, public_names, public_path

HOMES = {package: public_names(package) for package in PACKAGES}
INVENTORIES = Path(__file__).resolve().parent / "inventories"
PROJECTS = {
    "python": "https://docs.python.org/3",
    "numpy": "https://numpy.org/doc/stable",
    "scipy": "https://docs.scipy.org/doc/scipy",
    "sympy": "https://docs.sympy.org/latest",
    "control": "https://python-control.readthedocs.io/en/stable",
    "matplotlib": "https://matplotlib.org/stable",
}
OF_OTHERS = {
    "array": ":class:`array <numpy.ndarray>`",
    "arrays": ":class:`arrays <numpy.ndarray>`",
    "array_like": ":data:`array_like <numpy.typing.ArrayLike>`",
    "Symbol": ":class:`Symbol <sympy.Symbol>`",
    "Poly": ":class:`Poly <sympy.Poly>`",
    "Expr": ":class:`Expr <sympy.Expr>`",
    "Rational": ":class:`Rational <sympy.Rational>`",
    "StateSpace": ":class:`StateSpace <control.StateSpace>`",
    "python-control": ":class:`python-control <control.StateSpace>`",
    "scipy.signal": ":class:`scipy.signal <scipy.signal.dlti>`",
    "Figure": ":class:`Figure <matplotlib.figure.Figure>`",
    "Executor": ":class:`Executor <concurrent.futures.Executor>`",
    "Path": ":class:`Path <pathlib.Path>`",
    "mapping": ":term:`mapping <python:mapping>`",
    "polynomial": ":func:`polynomial <compensator_theory.polynomial>`",
    "realisation": ":func:`realisation <compensator_theory.realisation>`",
    **{
        name: f":class:`{name}`"
        for name in (
            "concurrent.futures.Executor",
            "matplotlib.figure.Figure",
            "numpy.random.Generator",
            "scipy.LowLevelCallable",
            "sympy.Expr",
            "sympy.ImmutableMatrix",
            "sympy.Matrix",
            "sympy.Poly",
            "sympy.Rational",
            "sympy.Symbol",
        )
    },
}


def intersphinx(target: Path) -> dict[str, tuple[str, tuple[str]]]:
    """Where other projects' names are: committed lists, so that no build asks the network."""
    target.mkdir(parents=True, exist_ok=True)
    for name in PROJECTS:
        lines = (INVENTORIES / f"{name}.txt").read_bytes().splitlines(keepends=True)
        packed = b"".join(lines[:4]) + zlib.compress(b"".join(lines[4:]))
        (target / f"{name}.inv").write_bytes(packed)
    return {name: (url, (str(target / f"{name}.inv"),)) for name, url in PROJECTS.items()}


def type_links() -> dict[str, str]:
    """What each word of a parameter's type links to; no other word is a link."""
    links = dict(OF_OTHERS)
    for package, homes in HOMES.items():
        for name in homes:
            path = public_path(package, name)
            links[path] = f":obj:`{name} <{path}>`"
            others = [p for p in HOMES if p != package and name in HOMES[p]]
            if name[0].isupper() and not others:
                links[name] = path
    return links


def public_target(target: str, module: str | None) -> str | None:
    """The public name of what a docstring calls by the module in which it is written.

    Examples
    --------
    >>> from docs.cross_references import public_target
    >>> public_target("rcac_numeric.engine._runs.Run.plot", None)
    'rcac_numeric.Run.plot'
    >>> public_target("realisation", "compensator_theory.observers._design")
    'compensator_theory.realisation'
    """
    for package, homes in HOMES.items():
        for name, home in homes.items():
            if f"{target}.".startswith(f"{home}.{name}."):
                return public_path(package, name) + target.removeprefix(f"{home}.{name}")
    package = (module or "").split(".")[0]
    name, dot, rest = target.partition(".")
    if name in HOMES.get(package, {}):
        return public_path(package, name) + dot + rest
    return None


def resolve_public(app: Any, env: Any, node: Any, contnode: Any) -> Any:
    """Lead a reference to where its object is documented: itself, or what holds it."""
    if node.get("refdomain") != "py":
        return None
    module, holder, target = node.get("py:module"), node.get("py:class"), node["reftarget"]
    domain = env.get_domain("py")
    name = public_target(target, module) or _only(domain, env, target) or _holder(target)
    if name is None and module and holder and _holder(f"{module}.{holder}.{target}"):
        name = f"{module}.{holder}"
    if name is None or name == target:
        return None
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", name, node, contnode)


def _only(domain: Any, env: Any, target: str) -> str | None:
    """The one object of this short name that is not public."""
    objects = domain.find_obj(env, None, None, target, None, 1)
    return objects[0][0] if len(objects) == 1 else None


def _holder(target: str) -> str | None:
    """The class of a field or the module of a constant, if it really has it."""
    path, _, name = target.rpartition(".")
    if path.partition(".")[0] not in PACKAGES:
        return None
    head, _, last = path.rpartition(".")
    for module, attribute in ((path, ""), (head, last)):
        try:
            holder: Any = importlib.import_module(module)
            holder = getattr(holder, attribute) if attribute else holder
        except (ImportError, AttributeError, ValueError):
            continue
        fields = getattr(holder, "__dataclass_fields__", getattr(holder, "__annotations__", ()))
        if name in fields or hasattr(holder, name):
            return public_target(path, None) or path
    return None


def skip_foreign(app: Any, what: str, name: str, obj: Any, skip: bool, options: Any) -> bool | None:
    """Leave out what a class inherits from Python and from the plumbing of values, and plain data.

    Fields of a class are in its section Attributes or Parameters.
    """
    if what != "class":
        return None
    function = inspect.unwrap(_function(obj))
    home = getattr(function, "__module__", None) or ""
    ours = home.split(".")[0] in PACKAGES and not home.endswith(".values")
    return None if ours and (inspect.isroutine(function) or inspect.isclass(function)) else True


def _function(obj: Any) -> Any:
    """What stands behind a property, a method of a class, a field."""
    for attribute in ("fget", "func", "__func__"):
        obj = getattr(obj, attribute, obj)
    return obj
