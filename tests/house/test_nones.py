"""A result that may be None says so by definition, or a test pins how often it is undecided."""

import ast
import dataclasses
import inspect
import tomllib
import types
import typing
from collections import Counter
from pathlib import Path

import control
import pytest
import sympy.physics.control

from tests.support.public import public_objects

ROOT = Path(__file__).resolve().parents[2]
TABLE = tomllib.loads(Path(__file__).with_name("nones.toml").read_text())
BY_DEFINITION = [name for names in TABLE["by_definition"].values() for name in names]
PINNED = [name for names in TABLE["pinned"].values() for name in names]
# What the packages import for type checking only, or under another name in a method.
LATE = {"control": control, "SympyTransferFunction": sympy.physics.control.TransferFunction}


def may_be_none(annotation):
    """Whether None is one of the values, or one of the entries of a container."""
    if annotation is type(None):
        return True
    inner = typing.get_origin(annotation)
    mixed = (typing.Union, types.UnionType, tuple, list, dict, set, frozenset)
    return inner in mixed and any(map(may_be_none, typing.get_args(annotation)))


def returned(function):
    result = typing.get_type_hints(function, localns=LATE).get("return")
    return None if result is type(None) else result  # a procedure answers nothing


def functions_of(cls):
    """(name, function) of every public method and property, inherited ones included."""
    for name in dir(cls):
        entry = inspect.getattr_static(cls, name)
        entry = getattr(entry, "fget", None) or getattr(entry, "func", None) or entry
        entry = getattr(entry, "__func__", entry)
        if not name.startswith("_") and inspect.isfunction(entry):
            yield name, entry


def annotations_of(name, item):
    """(name, annotation) of what a public function, or the fields and methods of a class, give."""
    if not inspect.isclass(item):
        if inspect.isfunction(item):
            yield name, returned(item)
        return
    if dataclasses.is_dataclass(item):
        hints = typing.get_type_hints(item, localns=LATE)
        for field in dataclasses.fields(item):
            yield f"{name}.{field.name}", hints[field.name]
    for method, function in functions_of(item):
        yield f"{name}.{method}", returned(function)


def ours_in(annotation):
    """The classes of the package in an annotation: results that are no public names themselves."""
    if inspect.isclass(annotation) and annotation.__module__.startswith("compensator_theory."):
        yield annotation
    for part in typing.get_args(annotation):
        yield from ours_in(part)


def nones_of_package():
    waiting = public_objects("compensator_theory")
    observed = {}
    while waiting:
        name, item = waiting.popitem()
        observed[name] = item
        for full, annotation in annotations_of(name, item):
            if may_be_none(annotation):
                yield full
            for cls in ours_in(annotation):
                if cls.__name__ not in observed:
                    waiting.setdefault(cls.__name__, cls)


NONES = sorted(set(nones_of_package()))


def test_every_none_stands_in_the_table():
    listed = set(BY_DEFINITION) | set(PINNED)
    assert set(NONES) - listed == set(), "say in nones.toml what None means, or what pins it"
    assert listed - set(NONES) == set(), "these are gone, or are never None any more"


def test_every_none_stands_there_once():
    assert max(Counter(BY_DEFINITION + PINNED).values()) == 1


@pytest.mark.parametrize("place", TABLE["pinned"])
def test_what_pins_a_none_is_a_test_that_looks_at_it(place):
    path, _, function = place.partition("::")
    text = ROOT.joinpath("tests", "compensator_theory", path).read_text()
    (node,) = [n for n in ast.parse(text).body if getattr(n, "name", None) == function]
    assert isinstance(node, ast.FunctionDef) and function.startswith("test_")


@pytest.mark.parametrize("name", NONES)
def test_the_docstring_says_when_it_is_none(name):
    """In the entry of the field, or in the docstring of the function or property."""
    head, _, tail = name.partition(".")
    item = public_objects("compensator_theory")[head]
    ours = dict(functions_of(item)).get(tail) if tail else item
    text = inspect.getdoc(ours or item)
    message = "None" in text if ours else "None" in entry_of(text, tail)
    assert message or name in OPTIONAL, f"{name}: say when it is None"


# Fields that a caller may leave out: "optional" stands in the docstring, and None means left out.
OPTIONAL = [name for name in BY_DEFINITION if name.partition(".")[2] in
            ("certificate", "feedback", "sample_time")]  # fmt: skip


def entry_of(docstring, field):
    """The lines on a field in the section Attributes or Parameters."""
    remaining, inside = [], False
    for line in docstring.splitlines():
        if line and not line.startswith(" "):
            inside = field in line.partition(" : ")[0].split(", ") and " : " in line
        if inside:
            remaining.append(line)
    return "\n".join(remaining)


def some_function(text: str) -> dict[str, tuple[int | None, ...]]: ...


@pytest.mark.parametrize(
    ("annotation", "answer"),
    [(int | None, True), (typing.Optional[int], True), (int, False), (type(None), True),  # noqa: UP045
     (returned(some_function), True), (tuple[int, ...], False), (type[int] | None, True)],
)  # fmt: skip
def test_none_is_seen_wherever_it_is(annotation, answer):
    assert may_be_none(annotation) is answer
