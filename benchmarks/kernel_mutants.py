"""Which small errors in the updates of the C++ kernel the tests find, header by header.

Run with: python benchmarks/kernel_mutants.py [HEADER ...]  all that is judged: before a release
          python benchmarks/kernel_mutants.py --share 1 [HEADER ...]  every mutant of the headers
          python benchmarks/kernel_mutants.py --lot 12345           a few, drawn with the seed

kernel_updates.toml lists the headers of kernel/updates and their tests. In a mutant one comparison,
sign, connective or number is another. All of them are compiled at once: at each place the copy of
the source asks which mutant is chosen, and notes that it was reached. The rest is as in
verb_mutants.py: the tests are run once, so that each mutant meets the tests alone that reach its
place, the quickest first, in a fork in which it is chosen. A mutant that lives and has no reason in
kernel_updates.toml is an error (exit status 1). What must be known to the compiler (template
arguments, `constexpr`) is not changed.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mutants import ROOT, Judge, Verdicts, Worded, judged, numbered, options_of

HEADERS: dict[str, dict[str, Any]] = tomllib.loads(
    (Path(__file__).parent / "kernel_updates.toml").read_text()
)
LOT_HEADERS, LOT_MUTANTS = 3, 3

SWAPPED = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+",
    "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "&&": "||", "||": "&&",
}  # fmt: skip
# Of operators: the class of the object that takes the left side, by which operator, and by which
# one the right side. Those of assignments take the right side alone.
CLASSES = {
    "< <= > >=": ("Relation", "<", ">"), "== !=": ("Equality", "==", "=="),
    "+ -": ("Sum", "+", "+"), "* /": ("Product", "*", "*"), "&&": ("Both", "&&", "&&"),
    "||": ("Either", "||", "||"), "+= -=": ("Change", "", "|="), "*= /=": ("Scaling", "", "|="),
}  # fmt: skip
OBJECTS = {op: joined for ops, joined in CLASSES.items() for op in ops.split()}
# Comments, texts, what the preprocessor reads, errors, heads of templates, template arguments, pure
# virtual functions and constants of the compiler stay as they are.
NO_PLACE = (
    r"//[^\n]*|\"(?:\\.|[^\"\n])*\"|^ *#(?:[^\n]*\\\n)*[^\n]*|throw [^;]*;|template <[^\n]*"
    r"|<\d+>|= 0;(?<=\) = 0;)|(?<=const) = 0;|^constexpr [^\n]*"
)
OPERATOR = r"(?<= )(?:[<>]=?|[=!]=|[-+*/]=?|&&|\|\|)(?= )|(?<=[ (\[{])!(?=\w)"
NUMBER = r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])"

# An operator x op y is written  x op' Class{number, "op"} op'' y : the object takes x, then y.
SWITCHES = """\
#pragma once
#include <string_view>
extern "C" {
extern int rcac_mutant;
extern unsigned char rcac_reached[];
}
namespace rcac {
inline bool is_chosen(int number) {
    rcac_reached[number] = 1;
    return rcac_mutant == number;
}
template <class T> T one_of(int number, T kept, T other) {
    return is_chosen(number) ? other : kept;
}
#define RCAC_MUTANT(Class, front, behind)                                                  \\
    struct Class { int number; std::string_view op; };                                     \\
    template <class A> struct Class##Of { A a; Class c; };                                 \\
    template <class A> Class##Of<A> operator front(const A& a, Class c) { return {a, c}; } \\
    template <class A, class B> auto operator behind(const Class##Of<A>& left, const B& b)
#define RCAC_IS(first) ((left.c.op[0] == first) != is_chosen(left.c.number))
RCAC_MUTANT(Relation, <, >) {
    const bool is_strict = (left.c.op.size() == 1) != is_chosen(left.c.number);
    if (left.c.op[0] == '<') return is_strict ? left.a < b : left.a <= b;
    return is_strict ? left.a > b : left.a >= b;
}
RCAC_MUTANT(Equality, ==, ==) { return RCAC_IS('=') ? left.a == b : left.a != b; }
RCAC_MUTANT(Sum, +, +) { return RCAC_IS('+') ? left.a + b : left.a - b; }
RCAC_MUTANT(Product, *, *) { return RCAC_IS('*') ? left.a * b : left.a / b; }
RCAC_MUTANT(Both, &&, &&) { return RCAC_IS('&') ? left.a && b : left.a || b; }
RCAC_MUTANT(Either, ||, ||) { return RCAC_IS('|') ? left.a || b : left.a && b; }
struct Change { int number; std::string_view op; };
template <class B> B operator|=(Change c, const B& b) { return is_chosen(c.number) ? -b : b; }
struct Scaling { int number; std::string_view op; };
template <class B> B operator|=(Scaling c, const B& b) { return is_chosen(c.number) ? 1 / b : b; }
struct Negation { int number; };
inline bool operator==(Negation n, bool negated) { return is_chosen(n.number) != negated; }
}  // namespace rcac
"""


class Mutant(Worded):
    """A place in a header, and what is put there."""

    library: ctypes.CDLL

    def __init__(self, start: int, before: str, after: str, line: str) -> None:
        self.start, self.before, self.number = start, before, -1
        self.after = after
        self.words = f"{before}  ->  {after or 'nothing'}  in  {line}"

    @property
    def switch(self) -> str:
        """What stands at the place in the copy that is compiled."""
        if self.before == "!":
            return f"Negation{{{self.number}}} == !"
        if self.before in OBJECTS:
            name, front, behind = OBJECTS[self.before]
            return f'{front or self.before} {name}{{{self.number}, "{self.before}"}} {behind}'
        return f"one_of({self.number}, {self.before}, {self.after})"

    @property
    def keys(self) -> set[Any]:
        """What `Reached` says of tests that reach it."""
        return {self.number}

    def put(self) -> None:
        """Choose this mutant."""
        ctypes.c_int.in_dll(self.library, "rcac_mutant").value = self.number


def mutants_of(text: str) -> Iterator[Mutant]:
    """The mutants of a header, in the order of their places."""
    pattern = re.compile(f"({NO_PLACE})|({OPERATOR})|({NUMBER})", re.MULTILINE)
    lines = text.splitlines()
    for match in pattern.finditer(text):
        word, line = match.group(), lines[text.count("\n", 0, match.start())].strip()
        if match[2]:
            yield Mutant(match.start(), word, SWAPPED.get(word, ""), line)
        elif match[3]:
            value = float(word)
            other = 1 - value if 0 < value < 1 and value != 0.5 else 2 * value + 1
            after = str(other if "." in word or "e" in word else int(word) + 1)
            yield Mutant(match.start(), word, after, line)


def header_of(name: str) -> Path:
    """The header of that name below the root of the sources."""
    return Path("kernel/updates") / f"{name}.hpp"


def mutants_of_header(name: str) -> list[Mutant]:
    """Return the mutants of a header."""
    return numbered(mutants_of((ROOT / header_of(name)).read_text()))


def compiled(folder: Path, mutants: dict[str, list[Mutant]]) -> Path:
    """Compile a copy of the kernel in the folder that has all of the mutants; return its path."""
    shutil.copytree(ROOT / "kernel", folder / "kernel")
    settings = (ROOT / "CMakeLists.txt").read_text()
    # The calls that do nothing but ask which mutant is chosen must not cost a compiler's hour.
    settings = settings.replace("-O3", "-O1").replace("-Wall -Wextra", "-w")
    (folder / "CMakeLists.txt").write_text(settings)
    (folder / "kernel/mutant.hpp").write_text(SWITCHES)
    for name, places in mutants.items():
        text = (ROOT / header_of(name)).read_text()
        for place in reversed(places):
            text = text[: place.start] + place.switch + text[place.start + len(place.before) :]
        first = "#pragma once\n"
        text = text.replace(first, f'{first}#include "mutant.hpp"\n', 1)
        (folder / header_of(name)).write_text(text)
    count = 1 + max(place.number for places in mutants.values() for place in places)
    shown = '__attribute__((visibility("default")))'
    switches = f"{shown} int rcac_mutant = -1;\n{shown} unsigned char rcac_reached[{count}];"
    module = folder / "kernel/bindings/module.cpp"
    module.write_text(f'{module.read_text()}\nextern "C" {{\n{switches}\n}}\n')
    _ran("pip", sys.executable, "-m", "pip", "install", "--quiet", "--target", folder / "nanobind",
         "nanobind")  # fmt: skip
    (cmake_dir,) = folder.glob("nanobind/nanobind/cmake")
    _ran("CMake", "cmake", "-G", "Ninja", "-S", folder, "-B", folder / "build",
         f"-Dnanobind_DIR={cmake_dir}", f"-DPython_EXECUTABLE={sys.executable}",
         "-DCMAKE_CXX_FLAGS=-Wno-narrowing")  # fmt: skip
    _ran("the compiler", "ninja", "-C", folder / "build")
    (library,) = folder.glob("build/_kernel*.so")
    return library


def _ran(what: str, *command: str | Path) -> None:
    run = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True)
    if run.returncode:
        raise SystemExit(f"{what}: {run.stdout[-4000:]}{run.stderr[-4000:]}")


def loaded(path: Path) -> ctypes.CDLL:
    """Put the compiled kernel in the place of the installed one, before anything imports that."""
    name = "rcac_numeric.compiled._kernel"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[name])
    return ctypes.CDLL(str(path))


class Reached:
    """The tracer of `Judge` for the kernel, whose places note that they are reached."""

    def __init__(self, library: ctypes.CDLL, count: int) -> None:
        self.reached = (ctypes.c_ubyte * count).in_dll(library, "rcac_reached")
        self.reach: dict[Any, set[str]] = {}
        self.test = ""

    def start(self) -> None:
        """Forget what collecting the tests reached."""
        self.switch_context("")

    def switch_context(self, test: str) -> None:
        """Note what the last test reached; from now on it is another one that runs."""
        for number, is_reached in enumerate(self.reached):
            if is_reached and self.test:
                self.reach.setdefault(number, set()).add(self.test)
        ctypes.memset(self.reached, 0, len(self.reached))
        self.test = test

    def result(self) -> dict[Any, set[str]]:
        """Return which tests reach which mutants."""
        self.switch_context("")
        return self.reach


def main() -> int:
    """Compile the mutants and judge them, all that are listed as judged or a lot."""
    options = options_of(str(__doc__).partition("\n")[0], "HEADER")
    os.chdir(ROOT)
    os.environ["HYPOTHESIS_PROFILE"] = "ci"
    os.environ.pop("PYTEST_ADDOPTS", None)
    names, lot = options.names or list(HEADERS), None
    if options.lot is not None:
        lot = random.Random(options.lot), LOT_MUTANTS
        names = lot[0].sample(names, min(LOT_HEADERS, len(names)))
    every = {name: mutants_of_header(name) for name in HEADERS}
    for number, mutant in enumerate(m for mutants in every.values() for m in mutants):
        mutant.number = number
    with tempfile.TemporaryDirectory() as folder:
        Mutant.library = loaded(compiled(Path(folder), every))
        count = sum(map(len, every.values()))
        failures = 0
        for name in names:
            verdicts = Verdicts(name, HEADERS[name])
            chosen = verdicts.chosen(every[name], options.share, lot)
            judge = Judge(verdicts, chosen, Reached(Mutant.library, count))
            failures += judged(judge, [f"tests/{test}" for test in HEADERS[name]["tests"]])
    return int(failures > 0)


if __name__ == "__main__":
    raise SystemExit(main())
