"""Which small errors in the C++ kernel the tests of the engine and of estimation find.

Run with: python benchmarks/kernel_mutants.py [COUNT] [SEED] [FILE OR FOLDER ...]

A mutant is a kernel in which one comparison, sign, connective or number is another, drawn with the
seed among those of all headers but the bindings'. It is compiled from a copy of the sources, and
another is drawn where it does not compile. The tests of KERNEL_TESTS run on it, each mutant in a
process of its own; what survives is a missing test, or a change that changes nothing.
"""

from __future__ import annotations

import glob
import importlib.util
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from mutants import ROOT, survives

NUMERIC = ROOT / "tests/rcac_numeric"
# A kernel's folder, and the tests that are about what stands in it.
KERNEL_TESTS = {
    "controller": ["engine", "controllers"],
    "estimation": ["estimation", "identification/online"],
    "lanes": ["engine"],
    "loop": ["engine"],
    "memory": ["engine", "estimation"],
    "plants": ["engine", "plants"],
    "simd": ["engine"],
    "updates": ["engine", "controllers"],
}
ALL_TESTS = sorted({one for tests in KERNEL_TESTS.values() for one in tests})

SWAPPED = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+",
    "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "&&": "||", "||": "&&",
}  # fmt: skip
# Comments, texts, what the preprocessor reads, errors and heads of templates stay as they are.
NO_PLACE = r"//[^\n]*|\"(?:\\.|[^\"\n])*\"|^ *#(?:[^\n]*\\\n)*[^\n]*|throw [^;]*;|template <[^\n]*"
OPERATOR = r"(?<= )(?:[<>]=?|[=!]=|[-+*/]=?|&&|\|\|)(?= )|(?<=[ (\[{])!(?=\w)"
NUMBER = r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])"


def places(text: str) -> Iterator[tuple[int, str, str]]:
    """Where the text may be changed, what stands there, and what is put in its place."""
    pattern = re.compile(f"({NO_PLACE})|({OPERATOR})|({NUMBER})", re.MULTILINE)
    for match in pattern.finditer(text):
        word = match.group()
        if match[2]:
            yield match.start(), word, SWAPPED.get(word, "")
        elif match[3]:
            value = float(word)
            other = 1 - value if 0 < value < 1 else 2 * value + 1
            yield match.start(), word, str(other if "." in word or "e" in word else int(word) + 1)


def headers(chosen: list[str]) -> list[Path]:
    """The headers of the folders that have tests, of all or of those chosen, below kernel/."""
    names = [Path(one).relative_to("kernel") for one in chosen] or [
        Path(one) for one in KERNEL_TESTS
    ]
    kernel = ROOT / "kernel"
    files = [
        f
        for one in names
        for f in ([kernel / one] if one.suffix else kernel.joinpath(one).rglob("*.hpp"))
    ]
    return sorted(f.relative_to(ROOT) for f in files)


def configured(folder: Path) -> None:
    """A copy of the kernel's sources in the folder, ready for `built`."""
    shutil.copytree(ROOT / "kernel", folder / "kernel")
    shutil.copy(ROOT / "CMakeLists.txt", folder)
    pip = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--target",
        str(folder / "nanobind"),
        "nanobind",
    ]
    subprocess.run(pip, check=True)
    (cmake_dir,) = folder.glob("nanobind/nanobind/cmake")
    cmake = ["cmake", "-G", "Ninja", "-S", str(folder), "-B", str(folder / "build")]
    options = [f"-Dnanobind_DIR={cmake_dir}", f"-DPython_EXECUTABLE={sys.executable}"]
    subprocess.run([*cmake, *options], check=True, capture_output=True)
    if not built(folder):
        raise SystemExit("The unchanged kernel does not compile; `pip install -e .` says why.")
    if not survives([NUMERIC / one for one in ALL_TESTS], kernel_in(folder), "kernel_mutants"):
        raise SystemExit("The tests find an error in the unchanged kernel.")


def kernel_in(folder: Path) -> str:
    """Where the compiled kernel of the copy stands, as a pattern."""
    return str(folder / "build/_kernel*.so")


def built(folder: Path) -> bool:
    """Whether the kernel of the copy compiles."""
    ninja = ["ninja", "-C", str(folder / "build")]
    return subprocess.run(ninja, check=False, capture_output=True).returncode == 0


def pytest_configure() -> None:
    """In the process of a mutant pytest has this file for a plugin, before it imports a test."""
    import rcac_numeric.engine

    name = "rcac_numeric.compiled._kernel"
    (path,) = glob.glob(os.environ["MUTANT"])
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    rcac_numeric.compiled._kernel = sys.modules[name] = importlib.util.module_from_spec(spec)  # type: ignore[attr-defined]
    spec.loader.exec_module(sys.modules[name])


def main(count: str = "20", seed: str = "0", *chosen: str) -> None:
    """Draw the mutants, compile and judge them."""
    every = [(f, p) for f in headers(list(chosen)) for p in places((ROOT / f).read_text())]
    order = random.Random(int(seed)).sample(every, len(every))
    judged = killed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        configured(folder)
        for file, (start, before, after) in order:
            if judged == int(count):
                break
            text = (ROOT / file).read_text()
            (folder / file).write_text(text[:start] + after + text[start + len(before) :])
            if compiles := built(folder):
                tests = [NUMERIC / one for one in KERNEL_TESTS[file.parts[1]]]
                survived = survives(tests, kernel_in(folder), "kernel_mutants")
                judged += 1
                killed += not survived
            (folder / file).write_text(text)
            verdict = "no C++  " if not compiles else "SURVIVES" if survived else "killed  "
            line = text.count("\n", 0, start)
            column = start - text.rfind("\n", 0, start)
            where = f"{file}:{line + 1}:{column}: {text.splitlines()[line].strip()}"
            print(f"{verdict} {where}    {before} -> {after or 'nothing'}", flush=True)
    print(f"{killed} of {judged} killed, drawn among {len(every)} with seed {seed}.")


if __name__ == "__main__":
    main(*sys.argv[1:])
