"""Parameters of functions and classes, and functions composed of several."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from functools import cached_property
from inspect import Parameter
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin, get_type_hints

import attrs

T = TypeVar("T")


def is_attrs_class(make: Any) -> bool:
    """Whether the fields of a class are the arguments of its constructor."""
    return isinstance(make, type) and attrs.has(make)


def parameters_of(make: Callable[..., Any]) -> list[Parameter]:
    """The fields of an attrs class, or the parameters of a function, each with its words.

    The words are a text in the annotation, or else what the docstring says of it.
    """
    if isinstance(make, Composed):
        return make.parameters
    is_plain_class = isinstance(make, type) and not is_attrs_class(make)
    hints = get_type_hints(make.__init__ if is_plain_class else make, include_extras=True)
    described = parameters_in(make.__doc__ or "")
    parameters = []
    for name, default in _defaults_of(make):
        hint: Any = Annotated[hints.get(name, Any), described.get(name, "")]
        parameters.append(Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=hint))
    return parameters


def _defaults_of(make: Any) -> Iterator[tuple[str, Any]]:
    if is_attrs_class(make):
        for one in attrs.fields(make):
            if one.init:
                is_factory = isinstance(one.default, attrs.Factory)  # type: ignore[arg-type]
                default = one.default.factory() if is_factory else one.default
                yield one.name, Parameter.empty if default is attrs.NOTHING else default
        return
    for name, parameter in inspect.signature(make).parameters.items():
        if parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            yield name, parameter.default


def words_of(hint: Any) -> str:
    """The text in an annotation such as Annotated[int, "Order, at least 1."]."""
    parts = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    return next((part for part in parts if isinstance(part, str)), "")


def summary_of(make: Callable[..., Any]) -> str:
    """The first sentence of a docstring.

    Examples
    --------
    >>> from rcac_numeric import fir
    >>> from rcac_experiments.format._signatures import summary_of
    >>> summary_of(fir)
    'The FIR structure (2.34)-(2.35): every pole of the controller is at zero.'
    """
    return " ".join(inspect.cleandoc(make.__doc__ or "").split("\n\n")[0].split())


def parameters_in(doc: str) -> dict[str, str]:
    """The texts under Parameters or Attributes of a numpydoc docstring.

    Examples
    --------
    >>> from rcac_experiments.format._signatures import parameters_in
    >>> parameters_in('''Do it.
    ...
    ... Parameters
    ... ----------
    ... a, b : int
    ...     Two
    ...     numbers.
    ... ''')
    {'a': 'Two numbers.', 'b': 'Two numbers.'}
    """
    descriptions: dict[str, str] = {}
    names: list[str] = []
    is_inside = False
    lines = inspect.cleandoc(doc).splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=False):
        if following.startswith("---"):
            is_inside, names = line in ("Parameters", "Attributes"), []
        elif not is_inside or line.startswith("---") or not line.strip():
            continue
        elif line.startswith(" "):
            for name in names:
                descriptions[name] = f"{descriptions[name]} {line.strip()}".strip()
        else:
            names = [name.strip() for name in line.partition(" : ")[0].split(",")]
            for name in names:  # a name may be described in two entries
                descriptions.setdefault(name, "")
    return descriptions


class Composed(Generic[T]):
    """A function whose arguments other functions make; it takes the parameters of those.

    Parameters
    ----------
    make : class or callable
    words : str
        Replaces its first sentence.
    **makers : classes or callables
        What makes the parameter of that name, of `make` or of another maker. Parameters of equal
        names are one; those without a default come first.

    Examples
    --------
    >>> from rcac_numeric import iir
    >>> from rcac_experiments.format._signatures import Composed, parameters_of
    >>> square = Composed(iir, l_u=lambda width: width, l_y=lambda width: width)
    >>> [parameter.name for parameter in parameters_of(square)]
    ['n_c', 'width', 'k_c']
    >>> square(n_c=3, width=2) == iir(3, 2, 2)
    True
    """

    def __init__(
        self, make: Callable[..., T], words: str = "", /, **makers: Callable[..., Any]
    ) -> None:
        self.make, self.names = make, [name for name, _ in _defaults_of(make)]
        self.parts: dict[str, Composed[Any]] = {}
        for one in (name for name in self.names if name in makers):
            others = {name: maker for name, maker in makers.items() if name != one}
            self.parts[one] = Composed(makers[one], **others)
        self.__doc__ = words or summary_of(make)
        self.__name__ = make.__name__

    @cached_property
    def parameters(self) -> list[Parameter]:
        """The parameters that it needs."""
        parameters: dict[str, Parameter] = {}
        for one in parameters_of(self.make):
            for inner in self.parts[one.name].parameters if one.name in self.parts else [one]:
                parameters.setdefault(inner.name, inner)
        return sorted(parameters.values(), key=lambda one: one.default is not one.empty)

    @cached_property
    def __signature__(self) -> inspect.Signature:
        return inspect.Signature(self.parameters)

    @cached_property
    def _names(self) -> tuple[frozenset[str], frozenset[str]]:
        """The names of its parameters, and of those without a default."""
        required = (one.name for one in self.parameters if one.default is one.empty)
        return frozenset(one.name for one in self.parameters), frozenset(required)

    def __call__(self, **values: Any) -> T:
        """Make it from a signature."""
        names_of_part, required = self._names
        if not required <= values.keys() <= names_of_part:
            self.__signature__.bind(**values)  # says which is missing or unknown
        arguments = {name: values[name] for name in self.names if name in values}
        for name, part in self.parts.items():
            known = part._names[0]
            arguments[name] = part(**{key: value for key, value in values.items() if key in known})
        return self.make(**arguments)
