"""Keys of a table from the function that they are for: its signature and its docstring."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.values import Choice, Flag, Form, Integer, Numbers, Real, Text

# How a parameter of each type is read. Another one needs its form where the table is declared.
FORMS: dict[str, Form] = {
    "int": Integer(),
    "float": Real(),
    "str": Text(),
    "bool": Flag(),
    "ArrayLike": Numbers(),
    "float | ArrayLike": Numbers(),
    "Sequence[int]": ListOf(Integer()),
    "Sequence[float]": Numbers(),
}


@dataclass(frozen=True)
class Key:
    """A key of a table, and the parameter that it stands for.

    Attributes
    ----------
    name, parameter : str
        In the file and in Python, where lambda is written `lambda_`.
    form : Form
    is_required : bool
    default : object
    doc : str
        What the docstring says of the parameter.
    """

    name: str
    parameter: str
    form: Form
    is_required: bool
    default: object
    doc: str


def keys_of(
    make: Callable[..., Any],
    *,
    given: frozenset[str],
    forms: Mapping[str, Form],
    names: Mapping[str, str],
    docs: Mapping[str, str],
) -> tuple[Key, ...]:
    """The keys of the parameters of a function or class, in their order.

    Parameters
    ----------
    make : callable
    given : set of str
        Parameters that do not come from the file.
    forms, names, docs : mappings from parameters
        What differs from the annotation, the parameter's name and the docstring.

    Examples
    --------
    >>> from rcac_numeric import Step
    >>> from rcac_numeric.experiments.format.signatures import keys_of
    >>> nothing = {"given": frozenset(), "forms": {}, "names": {}, "docs": {}}
    >>> [(key.name, key.default, key.doc) for key in keys_of(Step, **nothing)]
    [('height', 1.0, 'Its value from `start` on.'), ('start', 0, 'First step with that value.')]
    """
    described = parameters_in(make.__doc__ or "")
    keys = []
    for name, parameter in inspect.signature(make).parameters.items():
        if name in given or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        kind, text = described.get(name, ("", ""))
        is_required = parameter.default is parameter.empty
        keys.append(
            Key(
                name=names.get(name, name.rstrip("_")),
                parameter=name,
                form=forms.get(name) or _form(make, parameter, kind),
                is_required=is_required,
                default=None if is_required else parameter.default,
                doc=docs.get(name, text),
            )
        )
    return tuple(keys)


def summary_of(make: Callable[..., Any]) -> str:
    """The first sentence of a docstring.

    Examples
    --------
    >>> from rcac_numeric import fir
    >>> from rcac_numeric.experiments.format.signatures import summary_of
    >>> summary_of(fir)
    'The FIR structure (2.34)-(2.35): every pole of the controller is at zero.'
    """
    return " ".join(inspect.cleandoc(make.__doc__ or "").split("\n\n")[0].split())


def parameters_in(doc: str) -> dict[str, tuple[str, str]]:
    """Types and descriptions under Parameters or Attributes of a numpydoc docstring.

    Examples
    --------
    >>> from rcac_numeric.experiments.format.signatures import parameters_in
    >>> parameters_in('''Do it.
    ...
    ... Parameters
    ... ----------
    ... a, b : int
    ...     Two
    ...     numbers.
    ... ''')
    {'a': ('int', 'Two numbers.'), 'b': ('int', 'Two numbers.')}
    """
    found: dict[str, tuple[str, str]] = {}
    names: list[str] = []
    is_inside = False
    lines = inspect.cleandoc(doc).splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if following.startswith("---"):
            is_inside, names = line in ("Parameters", "Attributes"), []
        elif not is_inside or line.startswith("---") or not line.strip():
            continue
        elif line.startswith(" "):
            for name in names:
                kind, text = found[name]
                found[name] = (kind, f"{text} {line.strip()}".strip())
        else:
            before, _, kind = line.partition(" : ")
            names = [name.strip() for name in before.split(",")]
            for name in names:  # a name may be described in two entries
                found[name] = (kind, found[name][1] if name in found else "")
    return found


def _form(make: Callable[..., Any], parameter: inspect.Parameter, described: str) -> Form:
    annotation = str(parameter.annotation).removesuffix(" | None")
    if annotation == "str" and (choices := re.match(r"\{(.*?)\}", described)):
        return Choice(tuple(re.findall(r'"([^"]*)"', choices[1])))
    if annotation not in FORMS:
        raise TypeError(
            f"{make.__qualname__}: no form is known for {parameter.name}: {annotation}; give one "
            "where its table is declared."
        )
    return FORMS[annotation]
