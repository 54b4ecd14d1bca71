"""What holds for any text at the doors of the exact half, whoever drew it.

Only errors of our tree come out, nothing is executed, nothing takes over CALLS calls or BYTES at
once, and what is accepted is echoed in a canonical form that reads back to the same.
"""

import sys
from contextlib import suppress

import sympy

import compensator_theory as exact
from tests.support.work import at_most, at_most_bytes

CALLS, BYTES = 10_000_000, 100_000_000
FORBIDDEN = {"exec", "compile", "open", "import", "os.system", "subprocess.Popen", "socket.connect"}
LIBRARIES = ("sympy", "mpmath", "flint")  # these import parts of themselves when they need them

_watch = {"on": False, "seen": []}


def _hook(event, arguments):
    if _watch["on"] and event in FORBIDDEN and not _is_lazy_import(event, arguments):
        _watch["seen"].append((event, str(arguments)[:200]))


def _source(text):
    return text.decode(errors="replace") if isinstance(text, bytes) else str(text)


def _is_lazy_import(event, arguments):
    if event == "import":
        return arguments[0].split(".")[0] in LIBRARIES
    if event == "compile" and _source(arguments[0]).lstrip().startswith("def monomial_"):
        return True  # SymPy writes the arithmetic of its monomials itself, for each number of them
    if (
        event == "exec"
        and arguments[0].co_names
        and all(name.startswith("monomial_") for name in arguments[0].co_names)
    ):
        return True
    place = {
        "exec": lambda: arguments[0].co_filename,
        "compile": lambda: arguments[1],
        "open": lambda: arguments[0],
    }.get(event, lambda: "")()
    place = place.decode() if isinstance(place, bytes) else str(place)
    return any(f"/{name}/" in place for name in LIBRARIES)


sys.addaudithook(_hook)


def warm():
    """Import everything that reading may need, so that no import is seen later; not counted."""
    for text in (
        "1/(s + sqrt(2))",
        "CRootOf(x**3 + x + 1, 0)",
        "a*s/(b + s)",
        "cos(1)",
        "2**(1/3)",
    ):
        with suppress(exact.CompensatorError):
            exact.canonical(text)
        with suppress(exact.CompensatorError):
            exact.polynomial(text, "s")
    for roots in ("-1, -2", "sqrt(2)*j, -sqrt(2)*j", "1 + sqrt(3), sqrt(2+sqrt(2))", "a, b"):
        with suppress(exact.CompensatorError):
            place(roots)
    with suppress(exact.CompensatorError):
        exact.exact_number("1/0")


def read(door, *arguments):
    """Return what a door makes of its input, or None where it refuses; check what it costs."""
    _watch["on"] = True
    try:
        with at_most(CALLS), at_most_bytes(BYTES):
            return door(*arguments)
    except exact.CompensatorError as error:
        assert str(error) and len(str(error)) < 5000
        return None
    finally:
        _watch["on"] = False


def place(roots):
    expected = exact.read_roots(roots)
    return exact.place_poles("1/s", expected, feedback=-1)


def raised():
    return exact.budget(
        characters=10**7, nesting=200, digits=10**7, degree=10**5, terms=10**5, field_degree=10**3
    )


def same(poly, other):
    """Whether two polynomials are equal; by value where SymPy has two forms of a coefficient."""
    if poly.gens == other.gens and (poly - other).is_zero:
        return True
    difference = sympy.Add(poly.as_expr(), -other.as_expr(), evaluate=False)
    free = sorted(difference.free_symbols, key=str)
    values = {symbol: sympy.Rational(7 + 4 * n, 13 + 6 * n) for n, symbol in enumerate(free)}
    size = abs(poly.as_expr().subs(values).evalf(60))
    return poly.gens == other.gens and abs(difference.subs(values).evalf(60)) <= 1e-50 * size


def check_text(text):
    """A text is refused, or echoed in a canonical form that reads back; return which."""
    _watch["seen"].clear()
    value = read(exact.exact_number, text)
    poly = read(exact.polynomial, text)
    forced = read(exact.polynomial, text, "s")
    system = read(exact.transfer_function, text)
    echo = read(exact.canonical, text)
    assert not _watch["seen"]
    assert (echo is None) == (value is None), "what is accepted is echoed"
    if echo is not None:
        try:
            assert exact.canonical(echo) == echo
        except exact.errors.BudgetError:  # what a budget allows may be written otherwise
            with raised():
                again = exact.canonical(echo)
                assert exact.canonical(again) == again
        with raised():
            if value.is_Rational:
                assert exact.exact_number(echo) == value
            if poly is not None:
                assert same(exact.polynomial(echo), poly)
            if forced is not None:
                assert same(exact.polynomial(exact.canonical(forced), "s"), forced)
            if system is not None:
                back = exact.transfer_function(exact.canonical(system), system.variable)
                assert same(back.numerator, system.numerator)
                assert same(back.denominator, system.denominator)
    return echo is not None


def check_roots(text):
    """A list of roots is refused, or echoed and placed; return which."""
    _watch["seen"].clear()
    roots = read(exact.read_roots, text)
    placed = read(place, text)
    assert not _watch["seen"]
    if roots is not None and all(root.is_number for root in roots):
        echoes = [read(exact.canonical, root) for root in roots]
        if None not in echoes:
            again = exact.read_roots(", ".join(echoes) if len(echoes) > 1 else echoes)
            assert [exact.canonical(root) for root in again] == echoes
    if placed is not None:
        assert placed.roots == roots and placed.residual.is_zero
        assert placed.target.degree() == len(roots)
    return placed is not None
