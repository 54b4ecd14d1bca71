"""Tables of a file, each made by a class or a function: one reader, one schema, one list of keys.

A table is read from the fields of an attrs class or the signature of a function, of the library as
they are. The annotation says which form a value has (`Literal` for a choice of words, a form in
`Annotated` where a type alone does not say it) and what it means: a text in `Annotated`, or else
the section Parameters of the docstring. The default says whether the key may be left out. What a
function asks for beside what stands in the file, such as the plant, it is given later: till then
it is a `PartialCall`. Where the file says an argument by keys of its own, the function is
`Composed`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import NoneType, UnionType
from typing import Annotated, Any, Generic, Literal, TypeVar, Union, get_args, get_origin

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.format._parts import Alias, PartialCall
from rcac_experiments.format._places import Errors, Location, did_you_mean, quoted
from rcac_experiments.format._signatures import (
    is_attrs_class,
    parameters_of,
    summary_of,
    words_of,
)
from rcac_experiments.format._values import (
    ByStep,
    Choice,
    Either,
    Flag,
    Form,
    Integer,
    ListOf,
    MapOf,
    Numbers,
    Real,
    Schema,
    String,
    is_number,
)  # fmt: skip

T = TypeVar("T")
Raw = Mapping[str, Any]
FORMS: dict[Any, Form] = {
    int: Integer(), float: Real(), str: String(), bool: Flag(), np.ndarray: Numbers(),
}  # fmt: skip
OF_ARRAYS = set(get_args(ArrayLike))


@dataclass(frozen=True)
class Key:
    """A key of a table, and the parameter that it stands for."""

    name: str
    parameter: str
    form: Form
    is_required: bool
    default: object
    doc: str


def keys_of(
    make: Any, forms: Mapping[str, Form] | None = None, supplied: Collection[str] = ()
) -> tuple[Key, ...]:
    """The keys of the fields of an attrs class, or of the parameters of a function, in order.

    Examples
    --------
    >>> import attrs
    >>> from typing import Annotated, Literal
    >>> from rcac_experiments.format._tables import keys_of
    >>> @attrs.frozen
    ... class Pid:
    ...     terms: Annotated[Literal["P", "PI"], "Which terms."] = "PI"
    >>> [(key.name, key.form.words, key.default, key.doc) for key in keys_of(Pid)]
    [('terms', 'one of P, PI', 'PI', 'Which terms.')]
    """
    keys = []
    for one in parameters_of(make):
        if one.name in supplied:
            continue
        try:
            form = (forms or {}).get(one.name) or form_of(one.annotation)
        except TypeError as error:
            raise TypeError(f"{make.__name__}: {error} for {one.name}") from None
        is_required = one.default is one.empty
        keys.append(
            Key(
                name=one.name.rstrip("_"),
                parameter=one.name,
                form=form,
                is_required=is_required,
                default=None if is_required else one.default,
                doc=words_of(one.annotation),
            )
        )
    return tuple(keys)


def form_of(hint: Any) -> Form:
    """Return the form of a type."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        declared = next((one for one in inner[1:] if isinstance(one, Form)), None)
        return declared or form_of(inner[0])
    if origin in (Union, UnionType):
        kinds = [one for one in inner if one is not NoneType]
        tables = [one for one in kinds if attrs.has(one)]
        others = [one for one in kinds if one not in tables]
        if any(get_origin(one) is np.ndarray for one in others) or set(inner) >= OF_ARRAYS:
            others = [np.ndarray]  # a number stands for an array where both may be
        if len(tables) + len(others) == 1:
            return form_of((*tables, *others)[0])
        if len(tables) == len(others) == 1:
            return Either(Table(tables[0]), form_of(others[0]))
    elif origin is Literal and all(isinstance(word, str) for word in inner):
        return Choice(inner)
    elif origin in (tuple, list, Sequence) and inner[1:] in ((), (Ellipsis,)):
        return ListOf(form_of(inner[0]))
    elif origin in (dict, Mapping):
        return (ByStep if inner[0] is int else MapOf)(form_of(inner[1]))
    elif isinstance(hint, type) and attrs.has(hint):
        return Table(hint)
    elif (known := FORMS.get(origin or hint)) is not None:
        return known
    raise TypeError(f"no form for the type {hint}")


class Table(Form, Generic[T]):
    """A table whose keys are the fields of an attrs class, or the parameters of a function.

    Parameters
    ----------
    make : class or callable
        Function or class of the table.
    given : sequence of str
        Fields or parameters that do not stand in the file. Those of a class keep their defaults; of
        a function that has any a `PartialCall` is made, to be called with them.
    needs : sequence of str
        Parameters that must be there though they have a default.
    forms, names, docs : mappings from fields
        Forms, names of keys and descriptions that belong to this table alone.
    elsewhere : pair of Table and str, optional
        Keys that may stand here too, and who alone reads them.
    is_later : bool
        Whether it is a `PartialCall` in any case: some of what it is made of is known later.

    Notes
    -----
    A field whose form is a `Kinds` is spread over the table: its key names the kind, and the keys
    of that kind stand beside it.
    """

    def __init__(
        self,
        make: Callable[..., T],
        *,
        supplied: Sequence[str] = (),
        needs: Sequence[str] = (),
        forms: Mapping[str, Form] | None = None,
        names: Mapping[str, str] | None = None,
        docs: Mapping[str, str] | None = None,
        elsewhere: tuple[Table[Any], str] | None = None,
        is_later: bool = False,
    ) -> None:
        self.make, self.supplied, self.elsewhere = make, tuple(supplied), elsewhere
        self._needs = needs
        self.is_later = is_later or (bool(supplied) and not self.is_class)
        self._forms, self._names, self._docs = forms or {}, names or {}, docs or {}

    @property
    def is_class(self) -> bool:
        """Whether the keys are the fields of a class."""
        return is_attrs_class(self.make)

    @cached_property
    def keys(self) -> tuple[Key, ...]:
        """The keys, in the order of the fields."""
        names, docs = self._names, self._docs
        return tuple(
            replace(
                key,
                name=names.get(key.parameter, key.name),
                doc=docs.get(key.parameter, key.doc),
                is_required=key.is_required or key.parameter in self._needs,
            )
            for key in keys_of(self.make, self._forms, self.supplied)
        )

    @cached_property
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

    def all_keys(self) -> Mapping[str, list[Key]]:
        """Every key that may stand in the table, those of all kinds too."""
        return self._all_keys

    @cached_property
    def _all_keys(self) -> Mapping[str, list[Key]]:
        every: dict[str, list[Key]] = {}
        for key in self.keys:
            every.setdefault(key.name, []).append(key)
            if isinstance(key.form, Kinds):
                for table in key.form.tables():
                    for name, inner in table.all_keys().items():
                        every.setdefault(name, []).extend(inner)
        if self.elsewhere is not None:
            every.update(self.elsewhere[0].all_keys())
        return every

    def read(self, value: object, place: Location) -> Any:
        """Read the table: no unknown keys, no missing keys, each value of its form."""
        scope = place.inside() if place.key else place
        table = require_table(value, scope)
        errors = Errors()
        with errors:
            self.require_known(table, scope)
        is_known = not errors.errors
        chosen: dict[str, Kind[Any]] = {}
        for name, kinds in self.kinds.items():
            with errors:
                chosen[name] = kinds.choose(name, table, scope)
        for selector, kind in chosen.items():
            if kind.is_whole and is_known:
                return kind.read_whole(selector, table, scope)
        if len(chosen) == len(self.kinds):
            with errors:
                self._require_read(table, chosen, scope)
        values: dict[str, Any] = {}
        for key in self.keys:
            with errors:
                if key.name in chosen:
                    values[key.parameter] = chosen[key.name].read_beside(table, scope, is_known)
                elif key.name in table:
                    values[key.parameter] = key.form.read(table[key.name], scope.at(key.name))
                elif key.is_required and is_known and not isinstance(key.form, Kinds):
                    raise scope.missing(key.name)
        errors.raise_any()
        return self._build(values, scope)

    def _build(self, values: dict[str, Any], scope: Location) -> Any:
        if self.is_later:
            return PartialCall(self.make, values)
        try:
            result: Any = self.make(**values)
            return result.build() if isinstance(result, Alias) else result
        except CompensatorError as error:
            where = (f"{scope.where}: ",) if scope.table else ()
            raise type(error)(f"{scope.file}: ", *where, *error.args).of(scope.file) from None

    def require_known(self, table: Raw, scope: Location) -> None:
        """Refuse keys that neither this table nor one of its kinds has."""
        known, errors = self.all_keys(), Errors()
        every = f" Known keys: {', '.join(sorted(known))}."
        for name in table:
            if name not in known:
                text = f"unknown key {quoted(name)} in {scope.where}.{did_you_mean(name, known)}"
                errors.add(scope.error(text + every))
                every = ""
        errors.raise_any()

    def _require_read(self, table: Raw, chosen: Mapping[str, Kind[Any]], scope: Location) -> None:
        """Refuse keys of kinds that were not chosen."""
        errors = Errors()
        known, names_of_keys = self.all_keys(), {key.name for key in self.keys}
        beside = {} if self.elsewhere is None else self.elsewhere[0].all_keys()
        allowed = names_of_keys.union(*(kind.variant(table).names for kind in chosen.values()))
        for name in table:
            if name in beside and self.elsewhere is not None:
                message = f"{scope.where} sets {name!r}, which {self.elsewhere[1]}."
                errors.add(scope.error(message))
            elif name not in allowed and name in known:
                selector = next(s for s, kinds in self.kinds.items() if kinds.has(name))
                errors.add(chosen[selector].unread(name, selector, table, scope))
        errors.raise_any()

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
    """A variant of a kind, selected by the key `marker`."""

    def __init__(self, table: Table[T] | type[T], marker: str = "") -> None:
        self.table = table if isinstance(table, Table) else Table(table)
        self.marker = marker

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of its keys."""
        return frozenset(key.name for key in self.table.keys)


class Kind(Generic[T]):
    """One kind of something: its variants, the first whose marker is there, else the last.

    With `is_whole` it replaces the table around it: no key beside its own is read.
    """

    def __init__(self, *variants: Variant[T], is_whole: bool = False) -> None:
        self.variants, self.is_whole, self.name = variants, is_whole, ""

    def variant(self, table: Raw) -> Variant[T]:
        """Return the variant of a table."""
        return next((v for v in self.variants if v.marker in table), self.variants[-1])

    def read_beside(self, table: Raw, scope: Location, is_known: bool = True) -> Any:
        """Read the keys of this kind from the table that contains them."""
        variant = self.variant(table)
        entries = {key: value for key, value in table.items() if key in variant.names}
        if not is_known:  # the missing key may be a misspelt one
            for key in variant.table.keys:
                if key.is_required and key.name not in entries:
                    return None
        required = [key.name for key in variant.table.keys if key.is_required]
        markers = [] if variant.marker else [one.marker for one in self.variants if one.marker]
        if markers and required and not set(required) & set(entries):
            raise scope.error(
                f"{scope.where} needs the key {' or '.join(map(repr, markers))}, "
                f"or instead {', '.join(required)}."
            )
        return variant.table.read(entries, scope)

    def read_whole(self, selector: str, table: Raw, scope: Location) -> Any:
        """Read the whole table, without the key that selects the kind."""
        entries = {key: value for key, value in table.items() if key != selector}
        errors = Errors()
        for name in entries:
            if name not in self.variant(entries).names:
                errors.add(self.unread(name, selector, entries, scope))
        errors.raise_any()
        return self.variant(entries).table.read(entries, scope)

    def unread(self, name: str, selector: str, table: Raw, scope: Location) -> InputError:
        """Return the error for a key of another kind, with the keys of this one."""
        variant = self.variant(table)
        extra = f" with {variant.marker}" if variant.marker else ""
        reads = [selector, *(key.name for key in variant.table.keys)]
        return scope.error(
            f'{scope.where} sets {name!r}, which {selector} = "{self.name}"{extra} does not read. '
            f"It reads {', '.join(reads)}."
        )


class Kinds(Form, Generic[T]):
    """A choice by name; the kind `default`, if any, where the file names none."""

    def __init__(
        self,
        kinds: Mapping[str, type[T] | Table[T] | Kind[T]],
        *,
        default: str | None = None,
    ) -> None:
        self.default, self.kinds = default, dict[str, Kind[T]]()
        for name, kind in kinds.items():
            self.kinds[name] = kind if isinstance(kind, Kind) else Kind(Variant(kind))
            self.kinds[name].name = name

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

    def choose(self, selector: str, table: Raw, scope: Location) -> Kind[T]:
        """Return the kind that a table selects."""
        name = table.get(selector, self.default)
        if name is None:
            raise scope.missing(selector)
        return self.kinds[self.read(name, scope.at(selector))]

    def read(self, value: object, place: Location) -> str:
        """The name of a kind."""
        return Choice(tuple(self.kinds)).read(value, place)

    def schema(self) -> Schema:
        """An enumeration of the names."""
        return {"enum": list(self.kinds)}


class ByKey(Form, Generic[T]):
    """A table in which one key names the kind, its value being the first field."""

    def __init__(self, what: str, *, number: Callable[[float], T]) -> None:
        self.what, self.number = what, number
        self.kinds: dict[str, Table[T]] = {}

    def register(self, name: str, make: Callable[..., Any], **options: Any) -> None:
        """Let a key name this kind; its value is the first field of `make`."""
        first = Table(make, **options).keys[0].parameter
        self.kinds[name] = Table(make, names={first: name}, **options)

    @property
    def words(self) -> str:
        """A number, or the keys that name a kind."""
        return f"{self.what}; use a number, or a table with one of {', '.join(self.kinds)}"

    def read(self, value: object, place: Location) -> Any:
        """The described class."""
        if is_number(value):
            return self.number(Real().read(value, place))
        if not isinstance(value, Mapping):
            raise place.error(f"{place} = {quoted(value)} is not {self.words}.")
        named = [name for name in self.kinds if name in value]
        for name in named:
            others = [other for other in named if not self._reads(name, other)]
            if not others:
                return self.kinds[name].read(value, place)
        if named:
            raise place.error(
                f"{place} = {quoted(dict(value))} is {' and '.join(named)} at once; give one of "
                "them"
                f"{', or their sum' if 'sum' in self.kinds else ''}."
            )
        hint = next((h for key in value if (h := did_you_mean(key, self.kinds))), "")
        raise place.error(f"{place} = {quoted(dict(value))} is not {self.words}.{hint}")

    def _reads(self, name: str, key: str) -> bool:
        return any(key == one.name for one in self.kinds[name].keys)

    def schema(self) -> Schema:
        """A reference: a kind may hold others."""
        return {"$ref": f"#/$defs/{self.what.split()[-1]}"}

    def definition(self) -> Schema:
        """The referenced table."""
        tables = [
            {**table.schema(), "required": [key.name for key in table.keys if key.is_required]}
            for table in self.kinds.values()
        ]
        return {"anyOf": [{"type": "number"}, *tables]}


@dataclass(frozen=True)
class PartialTable(Form):
    """A table that is joined with others before it is read.

    Where it stands its keys must be known and its values of the right form; which keys go together
    and which are missing is known once it is joined.

    Attributes
    ----------
    table : Table
    is_replaced : bool
        Whether a table that names a kind replaces the one before it as a whole.
    """

    table: Table[Any]
    is_replaced: bool = False

    @property
    def words(self) -> str:
        """Those of the table."""
        return self.table.words

    def read(self, value: object, place: Location) -> dict[str, Any]:
        """As it stands."""
        inside, errors = place.inside(), Errors()
        table = dict(require_table(value, inside))
        with errors:
            self.table.require_known(table, inside)
        keys = self.table.all_keys()
        for name, entry in table.items():
            with errors:
                _require_form([key.form for key in keys.get(name, ())], entry, inside.at(name))
        errors.raise_any()
        return table

    def schema(self) -> Schema:
        """That of the table."""
        return self.table.schema()

    def joined(self, base: Raw, override: Raw) -> dict[str, Any]:
        """`base` with the entries of `override`, inner tables joined likewise.

        Where `override` names another kind, keys that only the old kind reads are left out: they
        would mean nothing to the new one.
        """
        joined = dict(base)
        for selector, kinds in self.table.kinds.items():
            kind = kinds.kinds.get(str(override.get(selector)))
            if kind is None or override[selector] == base.get(selector, kinds.default):
                if selector in override and self.is_replaced:
                    joined = {}
                continue
            read = {name for variant in kind.variants for name in variant.names}
            shared = {key.name for key in self.table.keys}.union(
                name
                for other, others in self.table.kinds.items()
                if other != selector
                for one in others.kinds.values()
                if not one.is_whole  # such a kind stands beside no other
                for variant in one.variants
                for name in variant.table.all_keys()
            )
            joined = {
                name: value
                for name, value in joined.items()
                if not self.is_replaced
                and (
                    name in read or not (kind.is_whole or (kinds.has(name) and name not in shared))
                )
            }
        return merged(joined, override)


def merged(base: Mapping[str, Any], override: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the entries of `override`, table by table.

    Examples
    --------
    >>> from rcac_experiments.format._tables import merged
    >>> merged({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"c": 4}})
    {'a': {'b': 1, 'c': 4}, 'd': 3}
    """
    result = dict(base)
    for key, value in override.items():
        old = result.get(key)
        is_joined = isinstance(old, Mapping) and isinstance(value, Mapping)
        result[key] = merged(old, value) if is_joined else value  # type: ignore[arg-type]
    return result


def require_table(value: object, scope: Location) -> Raw:
    """Return `value` if it is a table; otherwise refuse it."""
    if not isinstance(value, Mapping):
        raise scope.error(f"{scope.where} must be a table, not {quoted(value)}.")
    return value


def _require_form(forms: Iterable[Form], value: object, place: Location) -> None:
    """Refuse a value that is invalid for every kind with this key."""
    refusal: CompensatorError | None = None
    for form in forms:
        try:
            form.read(value, place)
        except CompensatorError as error:
            refusal = refusal or error
        else:
            return
    if refusal is not None:
        raise refusal
