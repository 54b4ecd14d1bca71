"""Tables of a file: each declared by the function or class that its keys are arguments of."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Generic, TypeVar

from compensator_theory.errors import InputError
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place, brief, did_you_mean
from rcac_numeric.experiments.format.signatures import Key, keys_of, summary_of
from rcac_numeric.experiments.format.values import Form, Schema

T = TypeVar("T")
Raw = Mapping[str, Any]


class Table(Form, Generic[T]):
    """A table whose keys are the parameters of a function or class.

    Parameters
    ----------
    make : callable
        Its signature says which keys there are, which are needed and what the others default to;
        its docstring what they mean.
    given : sequence of str
        Parameters that do not stand in the file; a plant for instance.
    forms, names, docs : mappings from parameters
        Forms that the annotation does not say; keys that are called otherwise in the file;
        descriptions that belong to the file alone.
    elsewhere : pair of Table and str, optional
        Keys that may stand here too, and who alone reads them.

    Notes
    -----
    A parameter whose form is a `Kinds` is spread over the table: its key names the kind, and the
    keys of that kind stand beside it.

    Examples
    --------
    >>> from rcac_numeric import Step
    >>> from rcac_numeric.experiments.format.places import Place
    >>> from rcac_numeric.experiments.format.tables import Table
    >>> place = Place("case.toml", "signals.r")
    >>> Table(Step).read({"height": 2}, place).build()
    Step(height=2.0, start=0)
    >>> Table(Step).read({"hight": 2}, place)
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: case.toml: unknown key 'hight' in [signals.r]. Did you
    mean 'height'? Known keys: height, start.
    """

    def __init__(
        self,
        make: Callable[..., T],
        *,
        given: Sequence[str] = (),
        forms: Mapping[str, Form] | None = None,
        names: Mapping[str, str] | None = None,
        docs: Mapping[str, str] | None = None,
        elsewhere: tuple[Table[Any], str] | None = None,
    ) -> None:
        self.make, self.given, self.elsewhere = make, tuple(given), elsewhere
        self._forms, self._names, self._docs = forms or {}, names or {}, docs or {}

    @cached_property
    def keys(self) -> tuple[Key, ...]:
        """The keys, in the order of the parameters."""
        return keys_of(
            self.make,
            given=frozenset(self.given),
            forms=self._forms,
            names=self._names,
            docs=self._docs,
        )

    @property
    def kinds(self) -> dict[str, Kinds[Any]]:
        """The choices that are spread over this table, by key."""
        return {key.name: key.form for key in self.keys if isinstance(key.form, Kinds)}

    @property
    def words(self) -> str:
        """A table, and its keys."""
        return f"a table with {', '.join(key.name for key in self.keys)}"

    @property
    def summary(self) -> str:
        """The first sentence of the docstring."""
        return summary_of(self.make)

    def all_keys(self) -> dict[str, list[Key]]:
        """Every key that may stand in the table, those of all kinds too."""
        found: dict[str, list[Key]] = {}
        for key in self.keys:
            found.setdefault(key.name, []).append(key)
            if isinstance(key.form, Kinds):
                for table in key.form.tables():
                    for name, inner in table.all_keys().items():
                        found.setdefault(name, []).extend(inner)
        if self.elsewhere is not None:
            found.update(self.elsewhere[0].all_keys())
        return found

    def read(self, value: object, place: Place) -> Part[T]:
        """What is to be made: all keys known, none missing, each of its form."""
        here = place.inside() if place.key else place
        table = require_table(value, here)
        self.require_known(table, here)
        chosen = {name: kinds.choose(name, table, here) for name, kinds in self.kinds.items()}
        for selector, kind in chosen.items():
            if kind.is_whole:
                return kind.read_whole(selector, table, here)
        self._require_read(table, chosen, here)
        arguments: dict[str, Any] = {}
        for key in self.keys:
            if key.name in chosen:
                arguments[key.parameter] = chosen[key.name].read_beside(table, here)
            elif key.name in table:
                arguments[key.parameter] = key.form.read(table[key.name], here.at(key.name))
            elif key.is_required:
                raise here.error(f"{here.where} needs the key {key.name!r}.")
        return Part(self.make, arguments, self.given)

    def require_known(self, table: Raw, here: Place) -> None:
        """Refuse a key that neither this table nor a kind that is spread over it has."""
        known = self.all_keys()
        for name in table:
            if name not in known:
                raise here.error(
                    f"unknown key {brief(name)} in {here.where}.{did_you_mean(name, known)} "
                    f"Known keys: {', '.join(sorted(known))}."
                )

    def _require_read(self, table: Raw, chosen: Mapping[str, Kind[Any]], here: Place) -> None:
        """Refuse a key that another kind than the chosen one reads."""
        own = {key.name for key in self.keys}
        if self.elsewhere is not None:
            for name in table.keys() & self.elsewhere[0].all_keys():
                raise here.error(f"{here.where} sets {name!r}, which {self.elsewhere[1]}.")
        allowed = own.union(*(kind.variant(table).names for kind in chosen.values()))
        for name in table:
            if name not in allowed:
                selector = next(s for s, kinds in self.kinds.items() if kinds.has(name))
                raise chosen[selector].unread(name, selector, table, here)

    def schema(self) -> Schema:
        """Properties with their descriptions, in any combination."""
        properties = {}
        for name, keys in self.all_keys().items():
            forms = [key.form.schema() for key in keys]
            different = [form for i, form in enumerate(forms) if form not in forms[:i]]
            merged = different[0] if len(different) == 1 else {"anyOf": different}
            described = next((key.doc for key in keys if key.doc), "")
            properties[name] = {**merged, **({"description": described} if described else {})}
        return {"type": "object", "properties": properties, "additionalProperties": False}


class Variant(Generic[T]):
    """One way to write a kind: the keys that go with `marker`, where that key is there."""

    def __init__(self, table: Table[T], marker: str = "") -> None:
        self.table, self.marker = table, marker

    @property
    def names(self) -> set[str]:
        """The names of its keys."""
        return {key.name for key in self.table.keys}


class Kind(Generic[T]):
    """One kind of something: its variants, the first whose marker is there, else the last.

    With `is_whole` it replaces the table around it: no key beside its own is read.
    """

    def __init__(self, *variants: Variant[T], is_whole: bool = False) -> None:
        self.variants, self.is_whole, self.name = variants, is_whole, ""

    def variant(self, table: Raw) -> Variant[T]:
        """The variant that a table is written as."""
        return next((v for v in self.variants if v.marker in table), self.variants[-1])

    def read_beside(self, table: Raw, here: Place) -> Part[T]:
        """The keys of this kind out of the table that it is spread over."""
        variant = self.variant(table)
        return variant.table.read({k: v for k, v in table.items() if k in variant.names}, here)

    def read_whole(self, selector: str, table: Raw, here: Place) -> Part[T]:
        """The whole table, without the key that chose this kind."""
        own = {key: value for key, value in table.items() if key != selector}
        for name in own:
            if name not in self.variant(own).names:
                raise self.unread(name, selector, own, here)
        return self.variant(own).table.read(own, here)

    def unread(self, name: str, selector: str, table: Raw, here: Place) -> InputError:
        """That a key is not read by this kind, and which ones are."""
        variant = self.variant(table)
        extra = f" with {variant.marker}" if variant.marker else ""
        reads = [selector, *(key.name for key in variant.table.keys)]
        return here.error(
            f'{here.where} sets {name!r}, which {selector} = "{self.name}"{extra} does not read. '
            f"It reads {', '.join(reads)}."
        )


class Kinds(Form, Generic[T]):
    """A choice by name: the kinds of something, each registered in one line.

    Parameters
    ----------
    kinds : mapping from names to functions, tables or kinds
        A function is enough where its signature says how its parameters are read.
    default : str, optional
        The kind where the file names none.
    given : sequence of str
        The parameters of functions that do not stand in the file.

    Examples
    --------
    >>> from rcac_numeric import fir, iir
    >>> from rcac_numeric.experiments.format.tables import Kinds
    >>> structures = Kinds({"iir": iir, "fir": fir}, default="iir", given=["l_u", "l_y"])
    >>> sorted(structures.kinds["fir"].variants[0].names)
    ['k_c', 'n_c']
    """

    def __init__(
        self,
        kinds: Mapping[str, Callable[..., T] | Table[T] | Kind[T]],
        *,
        default: str | None = None,
        given: Sequence[str] = (),
    ) -> None:
        self.default, self.kinds = default, {n: _kind(kind, given) for n, kind in kinds.items()}
        for name, kind in self.kinds.items():
            kind.name = name

    @property
    def words(self) -> str:
        """The names."""
        return f"one of {', '.join(self.kinds)}"

    def tables(self) -> Iterator[Table[T]]:
        """The tables of all variants of all kinds."""
        return (variant.table for kind in self.kinds.values() for variant in kind.variants)

    def has(self, name: str) -> bool:
        """Whether some kind reads this key."""
        return any(name in table.all_keys() for table in self.tables())

    def choose(self, selector: str, table: Raw, here: Place) -> Kind[T]:
        """The kind that a table names."""
        name = table.get(selector, self.default)
        if name is None:
            raise here.error(f"{here.where} needs the key {selector!r}.")
        return self.kinds[self.read(name, here.at(selector))]

    def read(self, value: object, place: Place) -> str:
        """The name of a kind."""
        if not isinstance(value, str):
            raise place.refuse(value, "a string")
        if value not in self.kinds:
            hint = did_you_mean(value, self.kinds)
            raise place.error(f"{place} = {brief(value)} is not known; choose {self.words}.{hint}")
        return value

    def schema(self) -> Schema:
        """An enumeration of the names."""
        return {"enum": list(self.kinds)}


def require_table(value: object, here: Place) -> Raw:
    """`value` if it is a table."""
    if not isinstance(value, Mapping):
        raise here.error(f"{here.where} must be a table, not {brief(value)}.")
    return value


def _kind(kind: Callable[..., T] | Table[T] | Kind[T], given: Sequence[str]) -> Kind[T]:
    if isinstance(kind, Kind):
        return kind
    if isinstance(kind, Table):
        return Kind(Variant(kind))
    parameters = inspect.signature(kind).parameters
    return Kind(Variant(Table(kind, given=[name for name in given if name in parameters])))
