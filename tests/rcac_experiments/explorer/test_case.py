"""What of an experiment the page can hold, what is refused by name, and the page as text."""

import base64
import json
import re
import tomllib
from fractions import Fraction
from functools import partial
from importlib import resources

import numpy as np
import pytest
from click.testing import CliRunner

from compensator_theory.errors import InputError
from rcac_experiments.cli._cases import read_case_table
from rcac_experiments.cli._main import main
from rcac_experiments.explorer import _compiling as compiling
from rcac_experiments.explorer import _modules as modules
from rcac_experiments.explorer._case import SCENES, case_of, scene_texts, scenes
from rcac_experiments.explorer._ellipsoids import stored_ellipsoids
from rcac_experiments.explorer._page import SCRIPTS, bundled, explorer_page, in_a_script
from rcac_experiments.files._builder import build
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import core_tables
from tests.support.explorer_cases import CASE, needs_clang, own
from tests.support.pages import Page


def numbers(text):
    return np.frombuffer(base64.b64decode(text), "<f8")


FOLDER = resources.files("rcac_experiments.explorer")


def test_the_dials_are_those_of_the_file():
    case = case_of(own(), "own.toml")
    assert case["poles"] == [[0.5, 0.0], [0.5, 0.0], [0.2, 0.4]]  # a double pole stays two
    assert Fraction(case["gain"]) == Fraction(3, 2)  # H over the plant's 1/3
    assert (case["n_c"], case["k_w"], case["steps"], case["seed"]) == (2, 7, 90, 11)
    assert (case["R_theta"], case["lambda"]) == ("0.25", "0.999")
    assert case["signal"] == "file" and case["signals"] == tomllib.loads(CASE)["signals"]


def test_a_limit_of_u_is_a_dial():
    assert case_of(own(), "own.toml")["bound"] == "none"
    assert case_of(own(saturation={"low": -2, "high": 2}), "own.toml")["bound"] == "2.0"


def test_the_sign_of_the_servo_problem_is_not_an_error_of_the_gain():
    case = case_of(*read_case_table("4.6"))
    assert case["problem"] == "servo" and case["gain"] == "1" and case["signal"] == "command"


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_an_experiment_that_ends_as_it_says(name):
    table = tomllib.loads(FOLDER.joinpath("scenes", f"{name}.toml").read_text("utf-8"))
    run = build(table, name).main_run
    assert run.execute().as_expected
    assert run.expected == ("diverged" if name in ("untold", "certified") else "completed")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"controller": [{"structure": "pid", "k_w": 9, "R_theta": 1}]}, "structure 'PID'"),
        ({"controller": {"structure": "fir"}}, "structure 'FIR'"),
        ({"controller": {"k_c": 0}}, "k_c = 1"),
        ({"controller": {"update": "covariance"}}, "the update Covariance"),
        ({"controller": {"R_u": 1}}, "R_u"),
        ({"controller": {"k_update": 9}}, "k_update"),
        ({"controller": {"freeze": [[50]]}}, "freeze"),
        ({"controller": {"bounds": {"low": -1}}}, "bounds of single coefficients"),
        ({"controller": {"process_noise": 1e-3}}, "process_noise"),
        ({"controller": {"reset": {"every": 20}}}, "reset of the update"),
        ({"controller": {"lambda": None, "subspace_lambda": 0.9}}, "a number as lambda"),
        ({"controller": {"R_theta": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}},
         "a matrix R_theta"),
        ({"controller": {"n_c": 21, "k_w": 30}}, "n_c = 21"),
        ({"saturation": {"low": -1, "high": 2}}, "the same in both directions"),
        ({"saturation": {"high": 2}}, "the same in both directions"),
        ({"saturation": {"low": -1, "high": 1, "rate": 0.1}}, "a saturation of the rate"),
        ({"run": {"steps": 5001}}, "5001 steps"),
        ({"run": {"x_0": [1, 0]}}, "an initial state"),
        ({"run": {"arithmetic": "reference"}, "controller": {"lambda": None}}, "ball arithmetic"),
        ({"plant": {"changes": [{"start": 30, "gain": 2}]}}, "a plant that changes"),
        ({"plant": [{"problem": "standard", "A": [[0.5]], "B": [[1]], "D_1": [[2]], "C": [[1]]}]},
         "is neither"),
        ({"plant": {"G": "1/q**13"}, "controller": {"k_w": 13}}, "order 13"),
        ({"target": [{"model": "filter", "G_f": "(q - 0.5)/q**2"}]}, "zero 0.5 inside"),
        ({"target": [{"model": "filter", "numerator": [0, 1]}]}, "float coefficients"),
        ({"target": {"poles": [0.5] * 13}, "controller": {"k_w": 13}}, "order 13"),
    ],
)  # fmt: skip
def test_what_has_no_dial_is_refused_by_name(changes, words):
    with pytest.raises(InputError, match=re.escape(words)):
        case_of(own(**changes), "own.toml")


def test_a_run_that_is_not_there_is_named():
    with pytest.raises(InputError, match="'main'"):
        case_of(own(), "own.toml", "other")


def test_a_page_needs_no_compiler(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "page.html"
    result = CliRunner().invoke(main, ["explore", "-o", str(file)])
    assert result.exit_code == 0, result.output
    assert file.stat().st_size > 100_000
    monkeypatch.delenv("CLANG", raising=False)
    with pytest.raises(InputError, match="clang and wasm-ld cannot be found"):
        compiling.compiler_version()


@pytest.mark.parametrize(("name", "words"), [("a.pdf", ".html"), ("no/a.html", "no folder")])
def test_where_the_page_cannot_be_it_is_said_first(tmp_path, name, words):
    result = CliRunner().invoke(main, ["explore", "-o", str(tmp_path / name)])
    assert result.exit_code == 2 and words in " ".join(result.output.split())


def test_the_command_writes_a_page_that_asks_for_nothing(tmp_path, monkeypatch):
    small = partial(explorer_page, orders=[2])
    monkeypatch.setattr("rcac_experiments.cli._explore.explorer_page", small)
    (tmp_path / "own.toml").write_text(CASE)
    file = tmp_path / "own.html"
    arguments = [str(tmp_path / "own.toml"), "-o", str(file), "--set", "run.steps=60"]
    result = CliRunner().invoke(main, ["explore", *arguments])
    assert result.exit_code == 0, result.output
    page = Page(file.read_text())
    assert not page.open
    (policy,) = (m["content"] for m in page.all("meta") if "http-equiv" in m)
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "'wasm-unsafe-eval'" in policy and "http" not in policy and "unsafe-inline'; i" in policy
    assert not [e for _, e in page.elements if {"src", "srcset"} & set(e)]
    (data,) = (json.loads(text) for tag, text in page.sources if text.startswith('{"cases"'))
    assert data["cases"][0]["title"] == "</script><b>Mine</b>"
    assert data["cases"][0]["steps"] == 60 and len(data["cases"]) == 1 + len(SCENES)
    assert data["core"]["orders"] == sorted({2, *(one["n_c"] for one in scenes())})


def test_the_modules_of_the_package_are_those_of_the_sources():
    """Otherwise: `python -m rcac_experiments.explorer._compiling`."""
    stored = modules.stored()
    assert stored["sources"] == compiling.digest()
    codes = [modules.module(n_c, in_ellipsoid=bounded) for n_c, bounded in compiling.MODULES]
    assert {code[:4] for code in codes} == {b"\0asm"} and len(set(codes)) == len(codes)
    assert [len(code) for code in codes] == stored["lengths"]


@pytest.mark.costly
@needs_clang
def test_the_same_compiler_gives_the_same_bytes():
    if compiling.compiler_version() != modules.stored()["compiler"]:
        pytest.skip("another clang than that of the modules")
    for n_c, bounded in [(1, False), (2, True), (modules.LARGEST_N_C, False)]:
        assert compiling.compiled(n_c, in_ellipsoid=bounded) == modules.module(
            n_c, in_ellipsoid=bounded
        )


def test_the_ellipsoids_of_the_scenes_are_proved_on_their_plants():
    """Otherwise: `python -m rcac_experiments.explorer._compiling`."""
    stored = stored_ellipsoids()
    assert stored["scenes"] == compiling.scenes_digest() and list(stored["ellipsoids"]) == [*SCENES]
    proved = set()
    for name, text in scene_texts().items():
        table, ellipsoid = tomllib.loads(text), stored["ellipsoids"][name]
        settings = build(table, name).main_run.settings
        if "reason" in ellipsoid:
            plant = build(table, name).main_run.plant  # theta_0 = 0 leaves it as it is
            assert not settings.theta_0.any() and max(abs(np.linalg.eigvals(plant.A))) > 1
            continue
        bounds = {key: numbers(ellipsoid[key]).tolist() for key in ("center", "factor")}
        n = len(bounds["center"])
        bounds["factor"] = np.reshape(bounds["factor"], (n, n)).tolist()
        table["controller"]["bounds"] = bounds
        again = case_of(table, name)
        assert again["kept"] and again["ellipsoid"] == ellipsoid and ellipsoid["is_proved"]
        bounds["factor"] = (4 * np.array(bounds["factor"])).tolist()
        assert not case_of(table, name)["ellipsoid"]["is_proved"]
        proved.add(name)
    assert proved == {"unasked", "servo", "certified"}


def test_no_word_of_a_file_ends_the_script():
    text = str(in_a_script({"title": "</script><!-- & \u2028"}))
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text)["title"] == "</script><!-- & \u2028"


def test_each_module_stands_behind_those_that_it_imports():
    assert not re.search(r"^(import|export)\b", bundled(), re.MULTILINE)
    stands = set()
    for name in SCRIPTS:
        text = FOLDER.joinpath("scripts", f"{name}.js").read_text("utf-8")
        for names, source in re.findall(r'^import \{(.*)\} from "\./(\w+)\.js";$', text, re.M):
            assert source in stands
            there = FOLDER.joinpath("scripts", f"{source}.js").read_text("utf-8")
            for one in names.split(","):
                pattern = rf"^export (const|class|(async )?function) {one.strip()}\b|^export const .*, {one.strip()} ="  # noqa: E501
                assert re.search(pattern, there, re.MULTILINE), f"{name}: {one}"
        assert text.count("import ") == len(re.findall(r"^import .*;$", text, re.MULTILINE))
        stands.add(name)


def test_only_what_a_page_writes_is_no_constant():
    tables = core_tables(build(own(), "own.toml").main_run.settings)
    before = config_header(tables).splitlines()
    after = config_header(tables, changing=compiling.CHANGING).splitlines()
    arrays = {line for line in before if line.startswith("static const")} - set(after)
    names = {re.search(r" rcac_(\w+)\[", line)[1] for line in arrays}
    assert names == {"theta_0", "D_0", "lambda", "numerators", "denominators"}
    assert "#define RCAC_K_W rcac_K_W" in after and "static int64_t rcac_K_W;" in after
