"""Text to exact SymPy expressions, without ever evaluating the text as Python code."""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, NoReturn

import sympy
from sympy import Expr, Integer, Rational, Symbol
from sympy.printing.str import StrPrinter

from compensator_theory._printing import SHORT, fraction_of
from compensator_theory.errors import Advice, InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._budget import ask, ask_for_number, limit_of, repr_of
from compensator_theory.polynomials._decidable import DEAD_TIME
from compensator_theory.polynomials._quotients import (
    Addition,
    Leaf,
    Power,
    Product,
    Quotient,
    Tree,
    multiplied_out,
)
from compensator_theory.polynomials._sympy_trees import (
    indexed_root,
    real_power,
    square_root,
    tree_of,
)

_SMALL = "²³¹¼-¾⁰-₎⅐-↋①-⓿"  # not in names: s² means the square of s
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_PASTED = str.maketrans("−·⋅×", "-***")  # characters copied from a printed page
_TOKEN = re.compile(
    r"(?P<space>\s*)(?:"
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<imaginary>[iIjJ](?!\w))?"
    rf"|(?P<name>[^\W\d{_SMALL}][^\W{_SMALL}]*)|(?P<operator>\*\*|[-+*/^(),])"
    r"|(?P<raised>[⁺⁻]?[⁰¹²³⁴-⁹]+)|(?P<end>\Z))"
)
_CONSTANTS = {"I": sympy.I, "j": sympy.I, "pi": sympy.pi, "π": sympy.pi}
_FUNCTIONS = ("sqrt", "CRootOf")
_TRANSCENDENTAL = {
    function.__name__: function
    for function in (sympy.exp, sympy.sin, sympy.cos, sympy.tan, sympy.sinh, sympy.cosh, sympy.tanh)
}
"""Names of functions if a parenthesis follows, else of symbols."""
_NOT_NUMBERS = frozenset({"nan", "inf", "infinity", "oo", "zoo"})
_GRAMMAR = "numbers, names, + - * / ** ^, parentheses, sqrt(...) and exp(...)"
WORDS = frozenset({*_CONSTANTS, *_FUNCTIONS, *_TRANSCENDENTAL})
"""Names in a text that are, or may be, no symbols."""


UNKNOWN, POSITIVE = "ʹ", "ʺ"
"""The last letter of the unknowns for positive functions of symbols; no variable."""


def parse_expression(text: str) -> Expr:
    r"""Read an arithmetic expression exactly: decimals become rationals.

    ``0.1`` :math:`= 1/10`, ``0.8j`` and ``0.8i`` :math:`= \tfrac{4}{5}\,\mathrm{j}`, and ``^``
    means ``**``. The signs of a printed page are read too: ``−``, ``·``, ``×``, ``s²``, ``π``.

    Parameters
    ----------
    text : str
        Numbers, names, ``+ - * / ** ^``, parentheses and ``sqrt``; ``exp``, ``sin``, ``cos``,
        ``tan``, ``sinh``, ``cosh`` and ``tanh`` with an argument in parentheses. ``j`` and ``I``
        are the imaginary unit, ``pi`` and ``π`` are the constant, every other name is a symbol. Two
        numbers with white space between them are refused, also as ``-1 -2``, which may mean -3 or
        two numbers.
        Attribute access, indexing, other calls and names with a double underscore are refused, and
        so is what the :class:`~compensator_theory.Budget` does not allow.

    Returns
    -------
    sympy.Expr
        The exact value, in lowest terms and multiplied out.

    Raises
    ------
    InputError
        If the text is empty, is not such an expression, divides by zero or is not finite.
    BudgetError
        If it is too long, too deeply nested, or multiplies out to too much.

    Examples
    --------
    >>> from compensator_theory import parse_expression
    >>> parse_expression("0.1*a + 1/3 - 0.8j")
    a/10 + 1/3 - 4*I/5
    """
    return read_text(text).value()


def read_tree(text: str) -> Tree:
    """Read a text without multiplying out."""
    ask("characters", len(text), "the expression")
    return _Reader(text, _tokens(text.translate(_PASTED))).whole()


def leaves_of(tree: Tree) -> Iterator[Expr]:
    """Yield the numbers, symbols and functions in a text that was read."""
    if isinstance(tree, Leaf):
        yield tree.value
    elif isinstance(tree, Power):
        yield from leaves_of(tree.base)
    else:
        for part in tree.terms if isinstance(tree, Addition) else (*tree.factors, *tree.divisors):
            yield from leaves_of(part)


def written_tree(tree: Tree, image: Callable[[Expr], Expr]) -> str:
    """Return a text with replaced leaves and the same structure."""
    if isinstance(tree, Leaf):
        return f"({_Readable({'order': None}).doprint(image(tree.value))})"
    if isinstance(tree, Power):
        return f"({written_tree(tree.base, image)})**({tree.exponent})"
    if isinstance(tree, Addition):
        return f"({'+'.join(written_tree(term, image) for term in tree.terms)})"
    factors = [written_tree(factor, image) for factor in tree.factors]
    return f"({'*'.join(factors + [f'(1/{written_tree(d, image)})' for d in tree.divisors])})"


class _Readable(StrPrinter):  # type: ignore[misc]
    """SymPy's printer in the syntax of the parser."""

    def _print_Exp1(self, number: Expr) -> str:
        return "exp(1)"


@roots_in_sympy()
def read_text(text: str) -> Quotient:
    """Read a text as a :class:`Quotient`, which keeps common factors.

    Products multiply numerators and denominators, sums use the product of two different
    denominators, so that an expression means the connection of blocks that it shows.
    """
    if not isinstance(text, str):
        raise InputError(
            f"{repr_of(text)} is not a string; write for instance 's**2 + 0.1*s + 1/3'"
        )
    ask("characters", len(text), "the expression")
    if not text.strip():
        raise InputError("the expression is empty; write for instance 's**2 + 0.1*s + 1/3'")
    quotient = multiplied_out(_Reader(text, _tokens(text.translate(_PASTED))).whole())
    if any(g.free_symbols and not g.is_Symbol for g in quotient.generators):  # sqrt(a)**1000
        return multiplied_out(Product(*((tree_of(side),) for side in quotient.sides())))
    return quotient


class _Token(NamedTuple):
    kind: str
    text: str
    is_spaced: bool
    is_imaginary: bool


def _tokens(text: str) -> list[_Token]:
    tokens: list[_Token] = []
    place = 0
    while not tokens or tokens[-1].kind != "end":
        match = _TOKEN.match(text, place)
        if match is None:
            wrong = repr(text[place:].lstrip()[:1])
            raise InputError(f"cannot read {_short(text)}: no {wrong} there; write {_GRAMMAR}")
        kind = "number" if (last := match.lastgroup or "") == "imaginary" else last
        tokens.append(_Token(kind, match[kind], bool(match["space"]), last == "imaginary"))
        place = match.end()
    return tokens


@dataclass
class _Reader:
    """Recursive descent; sums and products are read in a loop, without recursion."""

    text: str
    tokens: list[_Token]
    place: int = 0
    depth: int = 0
    has_symbols: bool = field(init=False)
    digits: int = field(init=False)
    nesting: int = field(init=False)

    def __post_init__(self) -> None:
        self.digits, self.nesting = min(SHORT, limit_of("digits")), limit_of("nesting")
        names = {token.text for token in self.tokens if token.kind == "name"}
        self.has_symbols = bool(names - set(_CONSTANTS) - set(_FUNCTIONS))

    def whole(self) -> Tree:
        tree = self.sum()
        if self.next.kind != "end":
            self.fail()
        return tree

    @property
    def next(self) -> _Token:
        return self.tokens[self.place]

    def take(self, *operators: str) -> str | None:
        if self.next.kind != "operator" or self.next.text not in operators:
            return None
        self.place += 1
        return self.tokens[self.place - 1].text

    def sum(self) -> Tree:
        terms = [self.product()]
        while sign := self.take("+", "-"):
            self.require_clear_sign()
            term = self.product()
            terms.append(term if sign == "+" else Product((Leaf(Integer(-1)), term)))
        return terms[0] if len(terms) == 1 else Addition(terms)

    def product(self) -> Tree:
        factors: list[Tree] = [self.signed()]
        divisors: list[Tree] = []
        while operator := self.take("*", "/"):
            (factors if operator == "*" else divisors).append(self.signed())
        return Product(factors, divisors) if divisors or len(factors) > 1 else factors[0]

    def signed(self) -> Tree:
        sign = 1
        while operator := self.take("+", "-"):
            sign = -sign if operator == "-" else sign
        tree = self.power()
        return tree if sign == 1 else Product((Leaf(Integer(-1)), tree))

    def power(self) -> Tree:
        base = self.atom()
        if self.next.kind == "raised":
            return Power(base, self.raised())
        if not self.take("**", "^"):
            return base
        self.deeper()
        written = self.signed()
        self.depth -= 1
        if isinstance(written, Leaf) and written.value.is_Rational:
            exponent = written.value
        else:
            exponent = multiplied_out(written).value()
        if exponent.is_Integer:
            return Power(base, int(exponent))
        return tree_of(real_power(multiplied_out(base).value(), exponent))

    def raised(self) -> int:
        digits = self.next.text.translate(_RAISED)
        ask("digits", len(digits), "an exponent")
        self.place += 1
        return int(digits)

    def atom(self) -> Tree:
        token = self.next
        self.place += 1
        if token.kind == "number":
            is_short = len(token.text) < self.digits and token.text.isdecimal()
            if is_short and not token.is_imaginary:
                return Leaf(Integer(int(token.text)))
            return _number(token)
        if token.kind == "name" and token.text in _FUNCTIONS:
            return self.function(token.text)
        if token.kind == "name" and token.text in _TRANSCENDENTAL and self.take("("):
            argument = multiplied_out(self.sum_inside()).value()
            return self.closed(tree_of(_TRANSCENDENTAL[token.text](argument)))
        if token.kind == "name":
            return Leaf(_named(token.text))
        if token.text == "(":
            return self.closed(self.sum_inside())
        self.place -= 1
        self.fail()

    def function(self, name: str) -> Tree:
        if not self.take("("):
            self.fail()
        argument = multiplied_out(self.sum_inside()).value()
        if name == "sqrt":
            return self.closed(tree_of(square_root(argument)))
        if not self.take(","):
            self.fail()
        index = multiplied_out(self.sum_inside()).value()
        return self.closed(tree_of(indexed_root(argument, index)))

    def sum_inside(self) -> Tree:
        self.deeper()
        tree = self.sum()
        self.depth -= 1
        return tree

    def closed(self, tree: Tree) -> Tree:
        if not self.take(")"):
            self.fail()
        return tree

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > self.nesting:
            ask("nesting", self.depth, f"the expression {_short(self.text)}")

    def require_clear_sign(self) -> None:
        """Refuse -1 -2, which is ambiguous: two numbers in a list, one number in a sum."""
        sign, following = self.tokens[self.place - 1], self.next
        if not self.has_symbols and sign.is_spaced and not following.is_spaced:
            raise InputError(
                f"{_short(self.text)} may be one number or several: there is white space before "
                f"{sign.text!r} and none after it; write 'a {sign.text} b' for one number, and "
                "commas between several"
            )

    def fail(self) -> NoReturn:
        token = self.next
        before = self.tokens[self.place - 1] if self.place else None
        where = "its end" if token.kind == "end" else repr(token.text)
        hint: str | Advice = "spell products out as in 2*s"
        if before and before.kind == token.kind == "number":
            hint = "put commas between several numbers"
        elif before and before.text == "exp" and token.text == "(":
            hint = DEAD_TIME
        elif before and before.kind == "name" and token.text == "(":
            hint = f"{before.text} is not a known function; {hint}"
        raise InputError(f"cannot read {_short(self.text)} at {where}: write {_GRAMMAR}; ", hint)


def _number(token: _Token) -> Tree:
    mantissa, _, exponent = token.text.lower().partition("e")
    size = abs(int(exponent)) if 0 < len(exponent) < 12 else 10 ** min(len(exponent), 300)
    ask("digits", len(mantissa) + (size if exponent else 0), "a number")
    value = fraction_of(token.text)
    ask_for_number(value.numerator, value.denominator)
    real = Leaf(Rational(value.numerator, value.denominator))
    return Product((real, Leaf(sympy.I))) if token.is_imaginary else real


def _named(name: str) -> Expr:
    name = "π" if unicodedata.normalize("NFKC", name) == "π" else name  # in italics too
    if name in _CONSTANTS:
        return _CONSTANTS[name]
    if name.lower() in _NOT_NUMBERS:
        raise InputError(f"{name!r} is not a finite number; exact data must be finite")
    if name == "i":
        raise InputError("'i' is ambiguous; write the imaginary unit as j or I, or as in 2i")
    if keyword.iskeyword(name):
        raise InputError(
            f"{name!r} is a reserved word of Python and cannot name a symbol; use another name, "
            "as in lamda or lambda_1"
        )
    if "__" in name or name.startswith("_"):
        raise InputError(f"{_short(name)} is not a name for a symbol; use letters and digits")
    return Symbol(name, positive=True) if name.endswith(POSITIVE) else Symbol(name)


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")
