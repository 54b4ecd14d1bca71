"""Functions of symbols carried through a public function as unknowns, and written back."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from fractions import Fraction
from functools import cached_property, wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

import sympy
from sympy import EX, Basic, Expr, ImmutableMatrix, MatrixBase, Poly, Symbol

from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.polynomials._decidable import require_decidable
from compensator_theory.polynomials._expressions import leaves_of, read_tree, written_tree
from compensator_theory.polynomials._functions import NotCarriedError, Unknowns, functions_in
from compensator_theory.polynomials._letters import reserved
from compensator_theory.polynomials._poly import from_coefficients
from compensator_theory.polynomials._quotients import Tree

P = ParamSpec("P")
Result = TypeVar("Result")

_CALL = re.compile(
    r"(?<![^\W\d])(?:exp|sqrt|sin|cos|tan|sinh|cosh|tanh)\s*\(|(?:\*\*|\^)\s*(?:\(|\d*\.)"
)
_NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")
_BETWEEN = re.compile(r"([,;])")
_BINARY = ("add", "sub", "mul", "truediv", "matmul", "pow")
_OPERATORS = {f"__{side}{name}__" for name in _BINARY for side in ("", "r")}
_OPERATORS |= {"__neg__", "__pos__", "__call__", "__getitem__", "_sympy_"}
MARK = "_carried"
"""Attribute of a result with functions: its form in unknowns; None after pickling."""

_SIMPLE = {int, float, bool, type(None), Fraction, Symbol, type(sympy.S.One), type(sympy.S.Half)}
_SIMPLE |= {type(sympy.S.Zero), type(sympy.S.NegativeOne), sympy.Integer, sympy.Rational}


def carrying(*, real: bool = False) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """Decorate a function to take functions of symbols, each as an unknown in it.

    For a function that takes symbols as unknowns over the rationals, and whose answer is made of
    them by arithmetic. Where not all functions are carried, it is called with them as they stand,
    and the domains of coefficients refuse them.
    """

    def decorate(function: Callable[P, Result]) -> Callable[P, Result]:
        needs_sign = _needs_sign(function)

        @wraps(function)
        def carried(*arguments: P.args, **options: P.kwargs) -> Result:
            if needs_sign and "feedback" not in options:
                raise _no_sign(function)
            if not has_functions((arguments, options)):
                return function(*arguments, **options)
            call_arguments: Any = arguments, options
            answer = _through(
                call_arguments, lambda at: function(*at[0], **at[1]), real, _bare(call_arguments)
            )
            return answer.with_functions()  # type: ignore[no-any-return]

        carried.carries = "reals" if real else "all"  # type: ignore[attr-defined]
        return carried

    return decorate


def carried_by(kind: str) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """Decorate a function that passes functions of symbols to one that carries or refuses them."""

    def decorate(function: Callable[P, Result]) -> Callable[P, Result]:
        if not _needs_sign(function):
            function.carries = kind  # type: ignore[attr-defined]
            return function

        @wraps(function)
        def signed(*arguments: P.args, **options: P.kwargs) -> Result:
            if "feedback" not in options:
                raise _no_sign(function)
            return function(*arguments, **options)

        signed.carries = kind  # type: ignore[attr-defined]
        return signed

    return decorate


def _needs_sign(function: Callable[..., Any]) -> bool:
    """Whether a function asks for the sign of feedback, which has no default."""
    parameter = signature(function).parameters.get("feedback")
    if parameter is None or parameter.kind is not parameter.KEYWORD_ONLY:
        return False
    return bool(parameter.default is parameter.empty)


def _no_sign(function: Callable[..., Any]) -> TypeError:
    """The error of a call without the sign: other programs assume -1."""
    return TypeError(
        f"{function.__name__}(): the sign is missing; write feedback=-1 for u = -K y (loops "
        "1 + G K, as in other programs) or feedback=1 for u = K y"
    )


def carry_methods(cls: type, result: type) -> None:
    """Let the methods of a result class take and return functions of symbols.

    Its own methods and attributes, and those of its bases that are no results.
    """
    bases = [base for base in cls.__mro__[1:] if not issubclass(base, result)]
    mixed = [base for base in bases if base not in result.__mro__]
    names = {k: v for base in reversed(mixed) for k, v in vars(base).items()}
    for name, member in {**names, **vars(cls)}.items():
        if name in ("__init__", "__post_init__") and name in vars(cls):
            setattr(cls, name, _constructor(name, member))
        elif (name not in _OPERATORS and name.startswith("_")) or name in ("subs", "variable"):
            continue
        elif isinstance(member, property):
            setattr(cls, name, property(_method(name, member.fget), doc=member.__doc__))
        elif isinstance(member, cached_property):
            again = cached_property(_method(name, member.func))
            again.__set_name__(cls, name)
            setattr(cls, name, again)
        elif hasattr(member, "__code__"):
            setattr(cls, name, _method(name, member))


def refusing(function: Callable[P, Result]) -> Callable[P, Result]:
    """Decorate a function to refuse functions of symbols, with the message of the domains.

    A `step` may be a logarithm, and is read by the function itself.
    """
    names = [*signature(function).parameters]
    place = names.index("step") if "step" in names else len(names)
    needs_sign = _needs_sign(function)

    @wraps(function)
    def refused(*arguments: P.args, **options: P.kwargs) -> Result:
        if needs_sign and "feedback" not in options:
            raise _no_sign(function)
        others = {name: value for name, value in options.items() if name != "step"}
        require_no_functions((arguments[:place], arguments[place + 1 :], others))
        return function(*arguments, **options)

    refused.carries = "none"  # type: ignore[attr-defined]
    return refused


def require_no_functions(value: Any) -> None:
    """Refuse functions of symbols, and numbers that are carried as such."""
    if has_functions(value):
        require_decidable(functions_in(_expressions(value)))


def has_functions(value: Any) -> bool:
    """Return whether a value has functions of symbols, or numbers that are treated as such."""
    return not _is_simple(value) and any(True for _ in functions_in(_expressions(value)))


def _is_simple(value: Any) -> bool:
    """Whether the types show that a value has no functions: the fast path of nearly all calls."""
    kind = type(value)
    if kind in _SIMPLE:
        return True
    if isinstance(value, str):
        return not _CALL.search(value)
    if kind is tuple or kind is list or kind is dict:
        parts = value.values() if kind is dict else value
        return _SIMPLE.issuperset(map(type, parts)) or all(map(_is_simple, parts))
    if kind is Poly:
        return _is_of_symbols(value.domain)
    if hasattr(kind, "__dataclass_fields__"):
        return MARK not in vars(value)
    if kind.__module__ == "numpy":
        return getattr(getattr(value, "dtype", None), "kind", "O") in "biufc"
    return isinstance(value, MatrixBase) and (
        hasattr(value, "flint_form") or _is_of_symbols(value._rep.domain)
    )


def polynomial_with_functions(descending: list[Expr], variable: Symbol) -> Poly:
    """Return a polynomial with functions of symbols in its coefficients."""
    if any(True for _ in functions_in(descending)):
        return Poly(descending, variable, domain=EX)
    return from_coefficients(descending, variable)


@dataclass
class _Carried:
    """The answer of a function in unknowns."""

    raw: Any
    unknowns: Unknowns | None

    def with_functions(self) -> Any:
        return self.raw if self.unknowns is None else _with_functions(self.raw, self.unknowns)


def _through(
    value: Any,
    call: Callable[[Any], Any],
    real: bool = False,
    bare: set[str] = frozenset(),  # type: ignore[assignment]
) -> _Carried:
    """Call a function with unknowns in place of functions of symbols."""
    try:
        unknowns, plain = _in_unknowns(value, real, bare)
        raw = _call_in_unknowns(unknowns, plain, call)
        if isinstance(raw, int) and unknowns.angles:
            unknowns, plain = _in_unknowns(value, real, bare, shifted=True)
            again = _call_in_unknowns(unknowns, plain, call)
            raw = raw if raw == again else None
    except NotCarriedError as error:
        require_decidable([error.part] if error.part is not None else ())
        raise InputError(
            f"{error.part} is not supported as an unknown; write a symbol in its place"
        ) from None
    return _Carried(raw, unknowns)


def _in_unknowns(
    value: Any, real: bool, bare: set[str], *, shifted: bool = False
) -> tuple[Unknowns, Any]:
    symbols = set(_symbols(value))
    names = {symbol.name for symbol in symbols}
    unknowns = Unknowns(_expressions(value), names, real=real, shifted=shifted)
    hidden = {symbol.name: symbol for symbol in unknowns.inner}
    clash = {s for name, s in hidden.items() if name in bare}  # the variable, it may be
    clash |= {hidden[s.name] for s in symbols if hidden.get(s.name, s) != s}
    clash |= {s for s in map(hidden.get, _variables(value)) if s is not None}
    if clash:
        raise NotCarriedError(unknowns.function_of(clash))
    return unknowns, _plain(value, unknowns)


def _variables(value: Any) -> Iterator[str]:
    """Names of the variables of polynomials and systems."""
    if isinstance(value, Poly):
        yield from (str(generator) for generator in value.gens)
    elif not isinstance(value, Basic | MatrixBase):
        if isinstance(variable := getattr(value, "variable", None), Symbol):
            yield variable.name
        for part in _parts(value):
            yield from _variables(part)


def _call_in_unknowns(unknowns: Unknowns, plain: Any, call: Callable[[Any], Any]) -> Any:
    """Call a function in unknowns; its errors name the functions."""
    hidden = {symbol.name for symbol in unknowns.inner}
    try:
        with reserved(hidden):
            raw = call(plain)
    except CompensatorError as error:
        error.args = tuple(unknowns.words(x) if isinstance(x, str) else x for x in error.args)
        if error.unless is not None:
            error.holding(
                (_with_functions(x, unknowns) for x in error.unless),
                unknowns.conditions(x for x in error.exceptional if isinstance(x, Expr)),
            )
        raise
    new = {s.name for s in _symbols(raw, texts=False)} - {s.name for s in _symbols(plain)}
    if clash := sorted(new & hidden):
        raise InputError(
            f"the answer introduces the symbol {clash[0]}, which an input function has too; "
            "rename the symbol in the function"
        )
    return raw


def _constructor(name: str, function: Any) -> Any:
    @wraps(function)
    def carried(self: Any, *arguments: Any, **options: Any) -> None:
        attributes = vars(self)
        inputs: Any = dict(attributes) if name == "__post_init__" else (arguments, options)
        if not has_functions(inputs):
            return function(self, *arguments, **options)  # type: ignore[no-any-return]

        def construct(at: Any) -> Any:
            attributes.clear()
            if name == "__post_init__":
                attributes.update(at)
                function(self)
            else:
                function(self, *at[0], **at[1])
            raw = object.__new__(type(self))
            vars(raw).update(attributes)
            return raw

        bare = set() if name == "__post_init__" else _bare(inputs)
        result = _through(inputs, construct, bare=bare).with_functions()
        attributes.clear()
        attributes.update(vars(result))
        return None

    return carried


def _printed(function: Any) -> Any:
    """Print with the functions; where the domains refuse them, print in unknowns and substitute."""

    @wraps(function)
    def carried(self: Any) -> Any:
        mark = vars(self).get(MARK)
        if mark is None:
            return function(self)
        try:
            return function(self)
        except InputError:
            written = _call_in_unknowns(mark.unknowns, mark.raw, function)
            return mark.unknowns.words(written, as_latex=function.__name__ == "_repr_latex_")

    return carried


def _method(name: str, function: Any) -> Any:
    @wraps(function)
    def carried(self: Any, *arguments: Any, **options: Any) -> Any:
        marked = MARK in vars(self)
        more = bool(arguments or options) and has_functions((arguments, options))
        if more and not (marked or self._CARRIES):
            require_no_functions((arguments, options))
        if not (marked or more):
            return function(self, *arguments, **options)
        mark, answer = vars(self).get(MARK), None
        inputs: Any
        if mark is not None and not more:
            known = {symbol.name for symbol in _symbols((arguments, options))}
            if not known & {symbol.name for symbol in mark.unknowns.inner}:
                inputs = mark.raw, arguments, options
                raw = _call_in_unknowns(
                    mark.unknowns, inputs, lambda at: function(at[0], *at[1], **at[2])
                )
                if not (isinstance(raw, int) and mark.unknowns.angles):
                    answer = _Carried(raw, mark.unknowns)
        if answer is None:
            inputs = self, arguments, options
            bare = set() if name.startswith("__") else _bare((arguments, options))
            real = self._CARRIES == "reals"
            answer = _through(inputs, lambda at: function(at[0], *at[1], **at[2]), real, bare)
        if name == "exceptional" and answer.unknowns:
            return tuple(answer.unknowns.conditions(answer.raw))
        result = answer.with_functions()
        return result.evalf() if name == "evalf" and answer.unknowns else result

    return carried


def _bare(value: Any) -> set[str]:
    """Return the string arguments that may be the name of a variable."""
    arguments, options = value
    names = {str(value) for value in (*arguments, *options.values()) if isinstance(value, Symbol)}
    texts = [value for value in (*arguments, *options.values()) if isinstance(value, str)]
    return names | {text.strip() for text in texts if _NAME.fullmatch(text.strip())}


def _parts(value: Any) -> Iterator[Any]:
    """Yield the parts of a value."""
    if isinstance(value, dict):
        yield from value.values()
    elif isinstance(value, list | tuple | set | frozenset | sympy.Tuple):
        yield from value
    elif _is_result(value):
        yield from (getattr(value, field.name) for field in fields(value))
    elif str(getattr(value, "dtype", "")) == "object":
        yield from value.tolist() if value.shape else [value.item()]


def _expressions(value: Any) -> Iterator[Expr]:
    """Expressions in which there may be functions."""
    if _is_simple(value):
        return
    if isinstance(value, str):
        for tree in _trees(value):
            yield from () if isinstance(tree, str) else leaves_of(tree)
    elif isinstance(value, Poly):
        yield from value.all_coeffs() if len(value.gens) == 1 else [value.as_expr()]
    elif isinstance(value, MatrixBase):
        yield from value.flat()
    elif isinstance(value, Expr):
        yield value
    else:
        for part in _parts(value):
            yield from _expressions(part)


def _is_of_symbols(domain: Any) -> bool:
    if domain.is_Composite:
        return all(symbol.is_Symbol for symbol in domain.symbols) and _is_of_symbols(domain.domain)
    return not (domain.is_EX or domain.is_EXRAW)


def _symbols(value: Any, *, texts: bool = True) -> Iterator[Symbol]:
    if isinstance(value, str):
        yield from map(Symbol, _NAME.findall(value) if texts else ())
    elif isinstance(value, Basic | MatrixBase):
        yield from value.free_symbols
    else:
        for part in _parts(value):
            yield from _symbols(part, texts=texts)


def _plain(value: Any, unknowns: Unknowns) -> Any:
    """Replace functions by unknowns."""
    if not _is_concerned(value, unknowns):
        return value
    if isinstance(value, str):
        written = _written(value, unknowns)
        unknowns.texts[written] = value
        return written
    if isinstance(value, Poly) and len(value.gens) > 1:
        return value  # its reader refuses it
    if isinstance(value, Poly):
        return from_coefficients([*map(unknowns.image, value.all_coeffs())], value.gen)
    if isinstance(value, MatrixBase):
        return ImmutableMatrix(*value.shape, [*map(unknowns.image, value.flat())])
    if isinstance(value, Expr):
        return unknowns.image(value)
    return _rebuilt(value, lambda part: _plain(part, unknowns))


def _is_concerned(value: Any, unknowns: Unknowns) -> bool:
    names = {symbol.name for symbol in _symbols(value)}
    return bool(names & unknowns.renamed) or has_functions(value) or _has_powers_of_e(value)


def _has_powers_of_e(value: Any) -> bool:
    return any(x.has(sympy.E, sympy.exp) for x in _expressions(value))


def _with_functions(value: Any, unknowns: Unknowns) -> Any:
    """Replace unknowns by functions."""
    if isinstance(value, str):
        return unknowns.words(value)
    concerned = any(symbol in unknowns.functions for symbol in _symbols(value))
    if not (concerned or (unknowns.angles and _holds_result(value))):
        return value
    if isinstance(value, Poly):
        return polynomial_with_functions(
            [*map(unknowns.with_functions, value.all_coeffs())], value.gen
        )
    if isinstance(value, MatrixBase):
        return ImmutableMatrix(*value.shape, [*map(unknowns.with_functions, value.flat())])
    if isinstance(value, Basic) and not isinstance(value, sympy.Tuple):
        return unknowns.with_functions(value)
    rebuilt = _rebuilt(value, lambda part: _with_functions(part, unknowns))
    if _is_result(rebuilt):
        if "exceptional" in vars(rebuilt):
            vars(rebuilt)["exceptional"] = tuple(unknowns.conditions(value.exceptional))
        vars(rebuilt)[MARK] = _Carried(value, unknowns)
    return rebuilt


def _is_result(value: Any) -> bool:
    return is_dataclass(value) and not isinstance(value, type)


def _holds_result(value: Any) -> bool:
    return _is_result(value) or any(map(_holds_result, _parts(value)))


def _rebuilt(value: Any, change: Callable[[Any], Any]) -> Any:
    if isinstance(value, dict):
        return {key: change(part) for key, part in value.items()}
    if _is_result(value):
        copy = object.__new__(type(value))
        vars(copy).update({f.name: change(getattr(value, f.name)) for f in fields(value)})
        return copy
    if isinstance(value, sympy.Tuple):
        return sympy.Tuple(*map(change, value))
    if isinstance(value, list | tuple | set | frozenset):
        return type(value)(map(change, value))
    if str(getattr(value, "dtype", "")) == "object" and value.shape:
        copy = value.copy()
        copy.flat = [change(part) for part in value.flat]
        return copy
    return value


def _trees(text: str) -> list[Tree | str]:
    """Yield the expressions between commas, and other text unchanged."""
    parts = _BETWEEN.split(text)
    try:
        return [part if k % 2 else read_tree(part) for k, part in enumerate(parts)]
    except CompensatorError:
        return []


def _written(text: str, unknowns: Unknowns) -> str:
    written = (t if isinstance(t, str) else written_tree(t, unknowns.image) for t in _trees(text))
    return "".join(written) or text
