"""Matrices of any size as letters that do not commute, and blocks of them."""

from collections.abc import Mapping

from sympy import Expr, Matrix, Symbol, expand, symbols, transpose


def letters(names: str) -> tuple[Symbol, ...]:
    """Return letters that do not commute, one for each name.

    Examples
    --------
    >>> from proofs.symbolic.letters import letters
    >>> A, B = letters("A B")
    >>> A * B == B * A
    False
    """
    return tuple(symbols(names, commutative=False, seq=True))


def reduced(expression: Expr, rules: Mapping[Expr, Expr]) -> Expr:
    """Expand and apply the rules, left side to right side, until nothing changes.

    Examples
    --------
    >>> from proofs.symbolic.letters import letters, reduced
    >>> U, V = letters("U V")
    >>> reduced((U - 1) * V, {U * V: V})
    0
    """
    previous, current = None, expand(expression)
    while current != previous:
        previous = current
        for left, right in rules.items():
            current = expand(current.subs(left, right))
    return current


def dual(expression: Expr, renamed: Mapping[Expr, Expr]) -> Expr:
    """Transpose and rename, as duality does; letters that are not renamed are symmetric.

    Examples
    --------
    >>> from proofs.symbolic.letters import dual, letters
    >>> from sympy import transpose
    >>> A, B, C, P, Q = letters("A B C P Q")
    >>> dual(P * A * B, {A: transpose(A), B: transpose(C), P: Q})
    C*A*Q
    """
    named = expression.subs(dict(renamed), simultaneous=True)
    new_letters = {value for value in renamed.values() if not value.args}
    symmetric = (expression.free_symbols - set(renamed)) | new_letters
    return expand(transpose(named)).subs({transpose(letter): letter for letter in symmetric})


def vanishes(matrix: Matrix) -> bool:
    """Whether every block is 0 after expansion.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from proofs.symbolic.letters import letters, vanishes
    >>> A, B = letters("A B")
    >>> vanishes(Matrix([[A * B - B * A]])), vanishes(Matrix([[A * (B + 1) - A * B - A]]))
    (False, True)
    """
    return all(expand(block) == 0 for block in matrix)
