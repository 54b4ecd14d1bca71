"""The command `rcac`: what it prints, draws and answers, and how it refuses."""

import json
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main
from rcac_experiments.dissertation._examples import example_ids

USER_CASE = """
title = "My plant"

[plant]
problem = "servo"
G = "(q - 0.5)/((q - 0.9)*(q - 0.3))"

[signals]
r = { step = 1 }
d = { harmonic = "pi/8", amplitude = 0.1 }

[target]
model = "fir"

[controller]
n_c = 4
R_theta = 1e-3

[run]
steps = 400

[[claims]]
text = "The error becomes small."
checks = [{ measure = "rms", start = 300, at_most = 0.05 }]
verdict = "holds"
"""

DIVERGING = """
[plant]
problem = "standard"
G = "1/(q - 3)"

[signals]
w = 1

[target]
model = "filter"
G_f = "-1/q"

[controller]
n_c = 1
R_theta = 1e6

[run]
steps = 1000
"""


@pytest.fixture
def rcac():
    return lambda *arguments: CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture
def case(tmp_path):
    def write(text, *changes):
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


def test_list(rcac):
    result = rcac("list")
    assert result.exit_code == 0
    numbers = [line.split()[0] for line in result.output.splitlines()]
    chapters = [n for n in numbers if n[0].isdigit()]
    assert chapters == sorted(chapters, key=lambda n: [int(p) for p in n.split(".")])
    assert numbers == [*chapters, "A.1", "A.2", *(f"B.{i}" for i in range(1, 6))]
    count = {"1": 3, "2": 8, "3": 2, "4": 8, "5": 6, "6": 5, "7": 6, "8": 7, "9": 5}
    assert set(chapters) == {f"{c}.{i + 1}" for c, many in count.items() for i in range(many)}
    absent = [line.split()[0] for line in result.output.splitlines() if "(not here yet: " in line]
    assert not set(absent) & set(example_ids()) and set(numbers) == {*absent, *example_ids()}


@pytest.mark.costly
def test_report_of_an_example(rcac, tmp_path):
    picture = tmp_path / "sheet.png"
    result = rcac("verify", "4.7", "--plot", picture)
    assert result.exit_code == 0
    for words in ("target, exact", "1559/10000", "reproduced", "largest pole distance"):
        assert words in result.output
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.costly
def test_the_figures_of_an_example(rcac, tmp_path):
    result = rcac("verify", "4.7", "--figures", str(tmp_path / "new" / "folder"))
    assert result.exit_code == 0 and "Figures: 3 in" in result.output
    drawn = sorted(path.name for path in (tmp_path / "new" / "folder").iterdir())
    assert drawn == ["4.7-1.svg", "4.7-2.svg", "4.7-3.svg"]
    (tmp_path / "file").write_text("")
    refused = rcac("verify", "4.7", "--figures", str(tmp_path / "file" / "inside"))
    assert refused.exit_code == 2 and "cannot be made: Not a directory" in refused.output


def test_a_case_that_asks_for_no_figure_is_drawn_by_the_usual_ones(rcac, tmp_path):
    (tmp_path / "own.toml").write_text(
        '[plant]\nproblem = "standard"\nG = "1/(q - 0.9)"\n[signals]\nw = { step = 1 }\n'
        '[target]\nmodel = "fir"\n[controller]\nn_c = 2\nR_theta = 1\n[run]\nsteps = 40\n'
    )
    result = rcac("verify", str(tmp_path / "own.toml"), "--figures", str(tmp_path / "drawn"))
    assert result.exit_code == 0 and "Figures: 4 in" in result.output
    assert len(list((tmp_path / "drawn").iterdir())) == 4
    exact = rcac("verify", "7.1", "--figures", str(tmp_path / "none"))
    assert exact.exit_code == 0 and "Figures: none; nothing ran." in exact.output


def test_json_is_one_object(rcac):
    result = rcac("verify", "4.7", "--json")
    data = json.loads(result.output)
    assert data["id"] == "4.7" and len(data["poles"]) == 7
    assert data["match"]["worst"] < 1e-5
    for claim in data["claims"]:
        assert {"text", "measured", "verdict"} <= claim.keys()
    assert data["characteristic_polynomial"]["requested"][3] == "-351/625"


def test_a_users_case(rcac, case):
    result = rcac("verify", case(USER_CASE))
    assert result.exit_code == 0 and "My plant" in result.output


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("number", "words"),
    [
        ("2.6", ["without the saturation", "saturation low = -0.2", "target, exact"]),
        ("2.7", ["reads the command too", "diverged at", "as expected", "zeros from r to z"]),
        ("2.8", ["reads the command too", "structure = fir; structure = feedforward"]),
    ],
)
def test_what_the_exact_comparison_cannot_say(rcac, tmp_path, number, words):
    """Saturated, feedforward and decentralised loops: a report and a picture all the same."""
    picture = tmp_path / "sheet.png"
    result = rcac("verify", number, "--plot", picture)
    assert result.exit_code == 0
    report = " ".join(result.output.split())
    assert all(word in report for word in words)
    assert picture.read_bytes().startswith(b"\x89PNG")
    data = json.loads(rcac("verify", number, "--json").output)
    assert ("obstacle" in data) == (number != "2.6")


@pytest.mark.costly
def test_a_changing_plant(rcac, case, tmp_path):
    change = ("[signals]", "[[plant.changes]]\nstart = 200\ngain = 1.1\n\n[signals]")
    result = rcac("verify", case(USER_CASE, change), "--plot", tmp_path / "sheet.png")
    assert result.exit_code == 0
    assert "Split of the residual (4.14): not evaluated: the plant changes" in result.output


VECTOR_CASE = """
[plant]
problem = "servo"
A = [[0.5, 0.1], [0.0, 0.7]]
B = [[1, 0], [0.2, 1]]
C = [[1, 0], [0, 1]]
D_1 = [[1, 0], [0.2, 1]]

[signals]
r = [{ step = 1 }, { step = -1, start = 50 }]

[target]
model = "filter"
numerator = [[[0, 0], [0, 0]], [[-1, 0], [-0.2, -1]]]

[controller]
n_c = 3
R_theta = 1e-3

[run]
steps = 300

[[claims]]
text = "Both commands are followed."
checks = [{ measure = "rms", start = 250, at_most = 0.01 }]
verdict = "holds"
"""


@pytest.mark.costly
def test_vector_signals(rcac, case, tmp_path):
    """Poles, match and picture of a 2 x 2 loop; the exact comparison is for scalar ones."""
    result = rcac("verify", case(VECTOR_CASE), "--plot", tmp_path / "sheet.pdf")
    assert result.exit_code == 0 and "closed-loop poles" in result.output
    assert len(json.loads(rcac("verify", case(VECTOR_CASE), "--json").output)["poles"]) == 8
    bad = rcac("verify", case(VECTOR_CASE, ("r = [{ step = 1 }, ", "r = [")))
    assert bad.exit_code == 2 and "r has 1 components; it needs 2" in bad.stderr


def test_a_changed_verdict_is_status_1(rcac, case):
    path = case(USER_CASE, ("at_most = 0.05", "at_most = 1e-30"))
    result = rcac("verify", path)
    assert result.exit_code == 1
    assert "does not hold" in result.output and "recorded verdict:" in result.output


@pytest.mark.costly
def test_divergence_is_status_3_and_is_drawn(rcac, case, tmp_path):
    warnings_before = np.geterr()
    picture = tmp_path / "diverged.svg"
    result = rcac("verify", case(DIVERGING), "--plot", picture)
    assert result.exit_code == 3
    assert "diverged after step" in result.output
    assert b"<svg" in picture.read_bytes()
    assert rcac("verify", case(DIVERGING), "--json").exit_code == 3
    assert np.geterr() == warnings_before, "the command leaves no global state behind"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("n_c = 4", "n_cc = 4"), "unknown key 'n_cc' in [controller]. Did you mean 'n_c'?"),
        (("n_c = 4", "n_c = 4\nk_w = 2"), "k_w = 2 is shorter than max(n_c, n_f) = max(4, 1) = 4"),
        (("(q - 0.5)/", "(q - 0.5)**3/"), "strictly proper"),
        (("(q - 0.5)/", "(q - 0.5)*(q - 0.9)/"), "share the factor q - 9/10"),
        (("r = { step = 1 }", "w = { step = 1 }"), "sets 'w'; this plant's exogenous input has r"),
        (('"rms"', '"rsm"'), "Did you mean 'rms'?"),
        ((", at_most = 0.05", ""), "a check without a bound cannot fail"),
        (('"holds"', '"proved"'), "verdict = 'proved' must be one of"),
        (("r = { step = 1 }", "r = { sum = [] }"), "must be a list of signals"),
        (("[plant]", "[plant"), "is not valid TOML"),
        (("steps = 400", "steps = 3"), "k_w = 4 must be before the end of the run of 3 steps"),
        (("steps = 400", "steps = 100000000000"), "the limit is"),
    ],
)
def test_bad_files_are_status_2_and_name_the_fault(rcac, case, change, message):
    """One of each reader of a file; the tests of these have the rest."""
    path = case(USER_CASE, change)
    result = rcac("verify", path)
    assert result.exit_code == 2, result.output
    assert message in result.stderr.replace("\n", " ")
    assert str(path) in result.stderr or "claim" in result.stderr or "run" in result.stderr
    assert not result.stdout, "nothing is printed before the file is known to be good"


def test_other_bad_input(rcac, tmp_path, case):
    assert "there is no example '9.9'" in rcac("verify", "9.9").stderr
    assert "cannot be read" in rcac("verify", tmp_path / "none.toml").stderr
    wrong = rcac("verify", "4.7", "--plot", tmp_path / "sheet.docx")
    assert wrong.exit_code == 2 and "must end in one of .pdf, .png, .svg" in wrong.stderr
    wrong = rcac("verify", "4.7", "--plot", tmp_path / "none" / "sheet.png")
    assert wrong.exit_code == 2 and "there is no folder" in wrong.stderr
    assert rcac("verify").exit_code == 2


def test_list_needs_no_heavy_import():
    """`rcac list` answers at once because it imports neither NumPy nor SymPy."""
    code = (
        "import sys; from rcac_experiments.cli._main import main\n"
        "main(['list'], standalone_mode=False); "
        "print({'numpy', 'sympy', 'scipy', 'control', 'matplotlib'} & set(sys.modules))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.splitlines()[-1] == "set()"


def test_a_mistyped_command_is_answered_with_the_one_meant():
    result = CliRunner().invoke(main, ["verfy", "4.7"])
    assert result.exit_code == 2 and "Did you mean 'verify'?" in result.stderr
    assert "Did you mean" not in CliRunner().invoke(main, ["xyzzy"]).stderr


@pytest.mark.parametrize("plant", ["-0.7*(q - 1.7)/(q - 0.5)", "-(q - 2)/q", "-s/(s + 1)"])
def test_a_plant_with_a_minus_sign_is_no_option(rcac, plant):
    """It is read, and what it lacks is said; a value of an option stays as it is."""
    result = rcac("design", plant)
    assert result.exit_code == 2 and "No such option" not in result.stderr
    assert "not strictly proper" in result.stderr
    assert "--noise" in rcac("design", "-0.7/(q - 0.5)").stderr
    options = ("--plant", "1/s", "--poles", "-1", "--order", "0", "--feedback", "-1")
    assert rcac("place", *options).exit_code == 0
    assert "No such option" in rcac("design", "-x", plant).stderr


def test_a_dead_time_in_a_formula_that_contradicts_the_option_is_refused(rcac):
    both = rcac("design", "exp(-0.5*s)/(s + 1)", "--sample-time", "1", "--dead-time", "2")
    assert both.exit_code != 0 and "dead" in both.stderr
    unsampled = rcac("design", "exp(-0.5*s)/(s + 1)", "--assume")
    assert "--sample-time" in unsampled.stderr
