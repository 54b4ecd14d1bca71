"""Python in the reader's browser: its examples run alone, and its pins fit the project."""

import json
import subprocess
import sys
import tomllib
import zipfile
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from docs.browser import downloads
from docs.browser.check import differences
from docs.browser.downloads import PINS, PinsError, UnavailableError, distribution
from docs.browser.examples import INSTALLED, pages, run_alone
from docs.browser.lite import BROWSER, lock
from docs.browser.static import try_it

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXACT = dict(map(distribution, PINS["exact"]))
PAGES = pages()

# An interpreter with the wheels of the browser and no other, which runs the examples that it reads.
ALONE = f"""
import json, sys
from benchmarks.exact_doctests import failure_of_page
INSTALLED = {sorted({*INSTALLED, *(name.replace("-", "_") for name in EXACT)})!r}

class Absent:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in INSTALLED and top not in sys.stdlib_module_names and not top.startswith("_"):
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
print(failure_of_page(json.load(sys.stdin)))
"""


@pytest.mark.costly
@pytest.mark.parametrize("page", PAGES)
def test_the_examples_of_a_page_run_where_the_exact_half_is_alone(page):
    assert not failure_alone(PAGES[page])


def failure_alone(examples):
    return subprocess.run(
        [sys.executable, "-c", ALONE],
        input=json.dumps(examples), capture_output=True, text=True, check=True, cwd=ROOT,
    ).stdout.strip()  # fmt: skip


def test_an_interpreter_with_the_exact_half_alone_has_no_numpy():
    assert failure_alone(["1 + 1", "import numpy"]).endswith("No module named 'numpy'")
    assert "Expected:" in failure_alone([">>> 1 + 1\n3\n"])


@pytest.mark.parametrize(
    "needs", ["import numpy", "from rcac_numeric import simulate", "import control as ct", "%time"]
)
def test_an_example_that_uses_what_another_half_made_is_left_out(needs):
    ours = "from compensator_theory import resultant\nx = resultant('s', 's + 1')"
    assert run_alone([ours, f"{needs}\nx = 1", "x", ours, "x"]) == [True, False, False, True, True]


def test_a_picture_needs_the_numeric_half():
    assert run_alone(["import compensator_theory as ct", "ct.transfer_function('1/s').plot()"]) == [
        True,
        False,
    ]


def requirements(lines):
    """The requirements that hold in the browser."""
    for line in map(Requirement, lines):
        if line.marker is None or line.marker.evaluate(BROWSER):
            yield line


def test_the_pins_satisfy_the_project_and_each_other():
    """By what the installed packages of the same names require; the wheels say so when built."""
    extra = PROJECT["optional-dependencies"]["proofs"]
    needed = {"compensator-theory": list(requirements([*PROJECT["dependencies"], *extra]))}
    for name in EXACT:
        needed[name] = list(requirements(metadata.requires(name) or []))
    for name, lines in needed.items():
        for line in lines:
            version = EXACT[canonicalize_name(line.name)]
            assert line.specifier.contains(version), f"{name} needs {line}, pinned is {version}"


def test_examples_may_import_what_is_pinned():
    homes = metadata.packages_distributions()
    for package in INSTALLED - {"compensator_theory"}:
        assert {canonicalize_name(name) for name in homes[package]} & set(EXACT), package


@pytest.mark.parametrize("section", ["exact", "kernel"])
def test_a_compiled_wheel_is_for_the_pinned_pyodide(section):
    tags = [name.removesuffix(".whl").split("-")[2:] for name in PINS[section]]
    compiled = {tuple(tag[1:]) for tag in tags if tag[-1] != "any"}
    assert compiled <= {(f"cp{PINS['python'].replace('.', '')}", PINS["platform"])}


def wheel(folder, name, version="1.0", *required):
    path = folder / f"{name}-{version}-py3-none-any.whl"
    lines = [f"Requires-Dist: {line}" for line in required]
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr(f"{name}/__init__.py", "")
        packed.writestr(
            f"{name}-{version}.dist-info/METADATA",
            "\n".join([f"Name: {name}", f"Version: {version}", *lines, "", ""]),
        )
    return path


def test_a_lock_names_what_each_wheel_needs(tmp_path):
    needs = ("b_b >= 1", "tests; extra == 'test'", "windows; sys_platform == 'win32'")
    packages = lock([wheel(tmp_path, "A", "2.0", *needs), wheel(tmp_path, "b_b")])
    assert packages["a"]["depends"] == ["b-b"] and packages["b-b"]["imports"] == ["b_b"]
    path = tmp_path / packages["a"]["file_name"]
    assert packages["a"]["sha256"] == sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("needs", ["absent", "b > 1", "b < 1"])
def test_wheels_that_do_not_fit_together_are_refused(tmp_path, needs):
    with pytest.raises(PinsError, match="a needs"):
        lock([wheel(tmp_path, "a", "1.0", needs), wheel(tmp_path, "b")])


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache, and one pin of npm."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(downloads.shutil, "which", lambda name: name)
    pins = {"npm": {"a-1.0.tgz": sha256(b"a").hexdigest()}}
    monkeypatch.setattr(downloads, "PINS", pins)
    return downloads.cache_folder()


@pytest.mark.parametrize("stored", [None, b"other"])
def test_a_download_is_kept_if_it_is_the_pinned_file(cache, monkeypatch, stored):
    commands = []

    def serve(command, source, place):
        commands.append(command)
        Path(place, "a-1.0.tgz").write_bytes(b"a")

    monkeypatch.setattr(downloads, "_run", serve)
    if stored:
        (cache / "a-1.0.tgz").write_bytes(stored)
    for _ in range(2):
        assert downloads.downloaded("npm") == [cache / "a-1.0.tgz"]
    assert (cache / "a-1.0.tgz").read_bytes() == b"a"
    assert len(commands) == 1 and commands[0][-1] == "a@1.0"


def test_another_file_than_the_pinned_one_is_refused(cache, monkeypatch):
    def serve(command, source, place):
        Path(place, "a-1.0.tgz").write_bytes(b"other")

    monkeypatch.setattr(downloads, "_run", serve)
    with pytest.raises(PinsError, match=r"a-1\.0\.tgz"):
        downloads.downloaded("npm")
    assert not list(cache.iterdir())


def test_a_registry_that_does_not_answer_is_named(cache, tmp_path, monkeypatch):
    with pytest.raises(UnavailableError, match=r"^npm does not serve .*: no route$"):
        downloads._run(
            [sys.executable, "-c", "raise SystemExit('a hint\\nno route')"], "npm", tmp_path
        )
    monkeypatch.setattr(downloads.shutil, "which", lambda name: None)
    with pytest.raises(UnavailableError, match="npm is not installed"):
        downloads.downloaded("npm")
    assert downloads.main(["npm"]) == downloads.UNAVAILABLE


def answers(code, scope="page"):
    shown = []
    return try_it.run(code, scope, lambda *answer: shown.append(answer)), shown


def test_an_example_shows_what_it_prints_and_its_values():
    code = "from compensator_theory import transfer_function\nG = transfer_function('1/(s + a)')\nG"
    assert answers(code) == (None, [("", "", r"\frac{1}{s + a}")])
    error, shown = answers("print(G)  # as text\nfor k in (1, 2):\n    print(k)\n\nG.order\nNone")
    assert error is None and shown == [
        ("print(G)", "(1)/(s + a)", None),
        ("for k in (1, 2):\n    print(k)", "1\n2", None),
        ("G.order", "1", None),
    ]
    assert answers("G", "another page")[0] == "NameError: name 'G' is not defined (line 1)"


def test_what_was_shown_before_an_error_stays():
    error, shown = answers("print(1); 1/0")
    assert error == "ZeroDivisionError: division by zero (line 1)"
    assert shown == [("print(1)", "1", None)]


@given(st.text(), st.sampled_from(["ValueError", "KeyError", "SystemExit", "KeyboardInterrupt"]))
def test_an_error_is_one_line(message, name):
    error, shown = answers(f"\n\nraise {name}({message!r})")
    assert len(error.splitlines()) == 1 and error.startswith(name) and error.endswith("(line 3)")
    assert not shown


@pytest.mark.parametrize("code", ["x = (", "for", "1 1", "\x00"])
def test_a_syntax_error_is_one_line(code):
    error, _ = answers(code)
    assert error.startswith("SyntaxError: ") and len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("answers", "sentences"),
    [
        ([["1/2", "0.5"], ["x", None]], []),
        ([["1/2", "0.25"], ["x", None]], ["1/2 answers '0.25' instead of '0.5\\n'"]),
        ([["1/2", "0.5"]], ["1 answers instead of 2"]),
    ],
)
def test_an_answer_that_differs_from_the_page_is_named(answers, sentences):
    assert (
        list(differences(">>> 1/2\n0.5\n>>> x = 1\n>>> x  # a formula\n1\n", answers)) == sentences
    )
