"""The command `rcac check`: every layout of a log, strict JSON, pictures, and bad logs."""

import json

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import CompensatorError
from rcac_experiments.cli._check import read_case
from rcac_experiments.cli._main import main

OCTAVE = "examples/octave/rcac_loop.mat"
CASE = "examples/octave/example_4_7.toml"
PLANT = "(q**2 - 1.44*q + 0.81)/((q - 0.9)*(q**2 - 1.71*q + 0.903))"


def run(*arguments):
    return CliRunner().invoke(main, ["check", *map(str, arguments)])


def strict(text):
    def refuse(token):
        raise AssertionError(f"{token} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture(scope="module")
def signals():
    contents = scipy.io.loadmat(OCTAVE)
    return {name: contents[name] for name in ("u", "y", "z", "w", "theta")}


def write_csv(path, signals, names=None):
    names = names or {}
    columns = []
    for name, values in signals.items():
        shown = names.get(name, name)
        width = values.shape[1]
        heads = [shown] if width == 1 else [f"{shown}{i + 1}" for i in range(width)]
        columns += [(head, values[:, i]) for i, head in enumerate(heads)]
    rows = [",".join(head for head, _ in columns)]
    rows += [",".join(repr(float(v[k])) for _, v in columns) for k in range(len(columns[0][1]))]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.costly
def test_the_worked_example(tmp_path):
    picture = tmp_path / "check.png"
    result = run(OCTAVE, "--plant", CASE, "--plot", picture)
    assert result.exit_code == 0, result.output
    for words in ("has converged", "rejects constant signals", "gain up", "LQG optimum: 2.36"):
        assert words in result.output
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_json_is_strict_and_complete():
    answer = strict(run(OCTAVE, "--plant", CASE, "--json", "--sample-time", "0.1").output)
    assert answer["replay"]["agrees"] and answer["loop"]["is_stable"]
    assert answer["replay"]["of"] == "theta"
    assert answer["target"]["worst_pole_distance"] < 1e-5 and answer["match"]["worst"] < 1e-5
    assert answer["residual"]["identity_error"] < 1e-10 and answer["unanswered"] == {}
    delay = answer["margins"]["u"]["delay"]
    assert abs(delay["radius_at"] - 1) < 1e-6
    assert np.isclose(answer["margins"]["u"]["delay_time"], 0.1 * delay["value"])


def test_json_stays_strict_where_numbers_are_infinite(tmp_path):
    answer = strict(run(OCTAVE, "--n-c", 4, "--plant", "1/(q - 3)", "--target", "1/q",
                        "--json").output)  # fmt: skip
    assert answer["h2"]["cost"] is None and not answer["loop"]["is_stable"]
    np.savez(tmp_path / "still.npz", u=np.full(9, 0.1), y=np.ones(9), D_c=[1, 0], N_c=[0.1])
    still = strict(run(tmp_path / "still.npz", "--plant", "1/(q - 0.5)", "--json").output)
    lag = still["margins"]["u"]["phase_lag"]
    assert lag["value"] is None and not lag["is_reached"]
    assert still["replay"]["of"] == "the compensator"
    assert still["replay"]["agrees"] and still["unanswered"]["convergence"] == "no theta was logged"


@pytest.mark.parametrize("kind", ["csv", "mat", "npz", "renamed csv", "rows"])
def test_every_layout_gives_the_same_answer(tmp_path, signals, kind):
    options = ["--plant", CASE, "--json"]
    if kind in ("csv", "renamed csv"):
        names = {"u": "input", "y": "output", "theta": "gain_"} if kind != "csv" else {}
        path = write_csv(tmp_path / "log.csv", signals, names)
        if names:
            options += ["--names", "u=input, y=output, theta=gain"]
    elif kind == "npz":
        path = tmp_path / "log.npz"
        np.savez(path, **signals)
    else:
        path = tmp_path / "log.mat"
        turned = {name: v.T if kind == "rows" else v for name, v in signals.items()}
        scipy.io.savemat(path, turned)
        options += ["--transpose"] if kind == "rows" else []
    answers = [strict(run(source, *options[:3 if source == OCTAVE else None]).output)
               for source in (path, OCTAVE)]  # fmt: skip
    for answer in answers:
        answer.pop("source")
    assert answers[0] == answers[1]


def test_a_plant_by_its_matrices_inside_the_log_or_in_a_file(tmp_path, signals):
    from rcac_numeric import standard_plant

    plant = standard_plant(PLANT)
    matrices = {name: getattr(plant, name) for name in ("A", "B", "D_1", "C")}
    both = tmp_path / "both.mat"
    scipy.io.savemat(both, {**signals, **matrices})
    apart = tmp_path / "plant.npz"
    np.savez(apart, **matrices)
    options = ("--n-c", 4, "--json")
    inside = strict(run(both, *options).output)
    beside = strict(run(OCTAVE, "--plant", apart, *options).output)
    formula = strict(run(OCTAVE, "--plant", PLANT, *options).output)
    assert inside["loop"] == beside["loop"]
    assert np.isclose(inside["h2"]["cost"], formula["h2"]["cost"])
    assert run(OCTAVE, "--plant", OCTAVE).exit_code == 2


@pytest.mark.parametrize(
    "text",
    ["1/(q - 0.5), 0; 0.2/(q - 0.1), 2/(q - 0.3)",
     "[[1/(q - 0.5), 0], [0.2/(q - 0.1), 2/(q - 0.3)]]"],
)  # fmt: skip
def test_a_plant_is_written_as_for_rcac_design(text):
    rows = [["1/(q - 0.5)", "0"], ["0.2/(q - 0.1)", "2/(q - 0.3)"]]
    assert read_case(text, "standard")[0] == rn.plant_of(rows)
    assert read_case(text, "servo")[0] == rn.servo_plant(rows)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace(",", ";"),
        lambda text: text.replace(",", "\t"),
        lambda text: "\n" + text.replace("\n", "\n\n", 3),
        lambda text: text.replace("theta1", '"theta1"').replace("\n1.0,", '\n"1.0",'),
    ],
    ids=["byte order mark", "CRLF", "semicolons", "tabs", "blank lines", "quotes"],
)
def test_dialects_of_csv(tmp_path, change):
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    text = "u,y,theta1,theta2\n" + "1.0,2.0,-0.5,0.25\n" * 9
    plain.write_text(text, encoding="utf-8", newline="")
    other.write_text(change(text), encoding="utf-8", newline="")
    expected, result = rn.read_log(plain), rn.read_log(other)
    for name in ("u", "y", "theta"):
        assert (getattr(expected, name) == getattr(result, name)).all()
    assert result.theta.shape == (9, 2)


@pytest.mark.exact_data
def test_variables_that_the_check_does_not_need_do_not_matter(tmp_path):
    np.savez(tmp_path / "log.npz", u=np.ones(9), y=np.ones(9), theta=0.5, poles=1j * np.ones(3),
             note=np.array("hot day"))  # fmt: skip
    log = rn.read_log(tmp_path / "log.npz")
    assert log.theta.tolist() == [0.5]
    with pytest.raises(CompensatorError, match="complex"):
        rn.read_log(tmp_path / "log.npz", {"y": "poles"})


def test_the_noise_of_the_cost_is_that_of_the_option(tmp_path, signals):
    def h2(*options):
        return strict(run(OCTAVE, "--plant", CASE, "--json", *options).output)["h2"]

    one, two = h2(), h2("--noise", "w = 2.25")
    assert two["by_noise"].keys() == {"w"}
    for key in ("cost", "lqg"):
        assert np.isclose(two[key], 2.25 * one[key], rtol=1e-9)
    np.savez(tmp_path / "log.npz", **{name: signals[name] for name in ("u", "y", "theta")})
    servo = ("--n-c", 4, "--plant", "1/(q - 0.5)", "--problem", "servo")
    answer = strict(run(tmp_path / "log.npz", *servo, "--noise", "v=0.25,d=1", "--json").output)
    assert answer["h2"]["by_noise"].keys() == {"v", "d"}


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        ("w", "--noise: the entry 'w' must be NAME=VALUE, for instance d=1,v=0.25"),
        ("w=", "--noise: the entry 'w=' must be"),
        ("w=loud", "'loud' must be a number"),
        ("w=1_0", "'1_0' must be a number"),
        ("w=1,w=2", "twice"),
        ("v=1", "w has no block or channel 'v'; it has w"),
        ("w=-1", "positive semidefinite"),
        ("w=nan", "finite"),
        ("w=1e999", "finite"),
    ],
)
def test_noise_that_is_none(noise, words):
    result = run(OCTAVE, "--plant", CASE, "--noise", noise)
    assert result.exit_code == 2 and words in result.output, result.output


def test_a_log_that_contradicts_itself_ends_with_status_1(tmp_path, signals):
    other = {**signals, "u": 1.1 * signals["u"] + 1}
    np.savez(tmp_path / "log.npz", **other)
    result = run(tmp_path / "log.npz", "--plant", CASE)
    assert result.exit_code == 1 and "is NOT the output" in result.output


def as_text(text):
    return lambda path: path.write_text(text)


GOOD = "u,y,theta1,theta2\n" + "0,1,0.5,0.5\n" * 20
BAD = [
    ("log.csv", as_text(""), "is empty"),
    ("log.csv", as_text("u,y\n"), "no row of numbers"),
    ("log.csv", as_text("1,2\n3,4\n"), "must name the columns"),
    ("log.csv", as_text("u,z\n1,2\n"), "has no 'y', needed as y; it has u, z"),
    ("log.csv", as_text("u,output\n1,2\n"), "has no 'y'"),
    ("log.csv", as_text("u,y\n1,2\n3\n"), "line 3: 1 entries where 2"),
    ("log.csv", as_text("u,y\n1,abc\n"), "line 2, column y: 'abc' is not a number"),
    ("log.csv", as_text("u,u\n1,2\n"), "distinct name"),
    ("log.csv", as_text("u,y\n1,2\n1,inf\n3,4\n"), "y has 1 gaps.*step 1"),
    ("log.csv", as_text(GOOD.replace("theta2", "x")), "theta has 1 coefficients.*has 2"),
    ("log.csv", lambda path: path.write_bytes(b"\xff\xfe\x00"), "not a text file"),
    ("log.mat", lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n" + b"\0" * 200), "mat"),
    ("log.mat", lambda path: path.write_bytes(
        b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + b"\0" * 400),
     "version 7.3.*-v7"),
    ("log.mat", lambda path: path.write_bytes(b"no log at all" * 40),
     "not a .mat file that can be read"),
    ("log.mat", as_text("# Created by Octave 6.4.0\n# name: u\n# type: matrix\n 1\n"),
     "Octave's own text or binary format.*'-v7', 'log.mat'"),
    ("log.mat", lambda path: path.write_bytes(b"Octave-1-L" + b"\0" * 200),
     "Octave's own text or binary format.*'-v7', 'log.mat'"),
    ("log.npz", lambda path: path.write_bytes(b"no archive"), "not an .npz"),
    ("log.csv", as_text("u,y\n1,2\n'0;5',1\n"), "column u: .*0;5.* is not a number"),
    ("log.csv", as_text("u,y\n1_0,2\n"), "column u: '1_0' is not a number"),
    ("log.csv", as_text("u,y\n0,5,1,5\n"), "line 2: 4 entries where 2"),
    ("log.npz", lambda path: np.savez(path, u=np.ones(9), y=np.ones(9), theta=np.ones(9)),
     "has 9 coefficients"),
    ("log.doc", as_text("u,y\n1,2\n"), "use .csv, .txt"),
    ("log.bag", as_text("u,y\n1,2\n"), "Export its topics to .csv"),
    ("log.mat", lambda path: scipy.io.savemat(path, {"input": np.ones((9, 1))}), "has no 'u'"),
    ("log.mat", lambda path: scipy.io.savemat(path, {"u": np.ones((2, 9)), "y": np.ones((2, 9))}),
     "u has shape \\(2, 9\\).*transposed"),
    ("log.mat", lambda path: scipy.io.savemat(path, {"u": np.ones((9, 1)), "y": np.ones((8, 1))}),
     "y has 8 steps where u has 9"),
    ("log.mat", lambda path: scipy.io.savemat(path, {"u": 1j * np.ones(9), "y": np.ones(9)}),
     "u must be an array of real numbers.*complex"),
    ("log.npz", lambda path: np.savez(path, u=np.array([None, 1], dtype=object)), "not an .npz"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "write", "words"), BAD, ids=range(len(BAD)))
def test_a_bad_log_ends_with_status_2_and_says_why(tmp_path, name, write, words):
    import re

    write(tmp_path / name)
    result = run(tmp_path / name, "--n-c", 1)
    assert result.exit_code == 2, result.output
    assert re.search(words, result.output, re.S) and "Traceback" not in result.output


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "give their structure.*--n-c 4"),
        (["--n-c", 5], "has 8 coefficients.*has 10"),
        (["--n-c", 4, "--names", "u"], "entry 'u'"),
        (["--n-c", 4, "--names", "u=a,u=b"], "twice"),
        (["--n-c", 4, "--names", "q=u"], "'q' is not known"),
        (["--n-c", 4, "--names", "u=uu"], "has no 'uu'.*Did you mean 'u'"),
        (["--n-c", 4, "--plant", "1/(s + 1)"], "discrete"),
        (["--n-c", 4, "--plant", "missing.toml"], "cannot be read"),
        (["--n-c", 4, "--plant", "1/(q - 2"], "cannot read"),
        (["--n-c", 4, "--plot", "check.txt"], "must end in"),
        (["--n-c", 4, "--plant", "1/(q - 2)", "--sample-time", -1], "positive"),
        (["--structure", "fir"], "n_c"),
    ],
)
def test_bad_options(options, words):
    import re

    result = run(OCTAVE, *options)
    assert result.exit_code == 2, result.output
    assert re.search(words, result.output, re.S) and "Traceback" not in result.output


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('[controller]\nn_c = 4\nk_w = "soon"', "k_w must be an integer"),
        ("controller = 3", "must be a table"),
        ("[controller]\nn_cc = 4", "Did you mean 'n_c'"),
        ('[controller]\nn_c = 4\n[target]\nmodel = "fire"', "model"),
        (
            "[controller]\nn_c = 4\n[[plant.changes]]\nstart = 9\ngain = 2",
            "the plant changes during the run",
        ),
    ],
)
def test_bad_experiment_files(tmp_path, table, words):
    top, *rest = table.split("\n") if table.startswith("controller") else ("", table)
    path = tmp_path / "case.toml"
    path.write_text(f'{top}\n[plant]\nproblem = "standard"\nG = "1/(q - 0.5)"\n' + "\n".join(rest))
    result = run(OCTAVE, "--plant", path)
    assert result.exit_code == 2 and words in result.output, result.output
    assert "Traceback" not in result.output


@settings(max_examples=60)
@given(st.data())
def test_a_damaged_file_never_ends_in_a_foreign_error(tmp_path_factory, data):
    kind = data.draw(st.sampled_from(["mat", "npz"]))
    path = tmp_path_factory.mktemp("damaged") / f"log.{kind}"
    if kind == "mat":
        scipy.io.savemat(path, {"u": np.ones((9, 1)), "y": np.zeros((9, 1))})
    else:
        np.savez(path, u=np.ones(9), y=np.zeros(9))
    contents = bytearray(path.read_bytes())
    del contents[data.draw(st.integers(1, len(contents))) :]
    for _ in range(data.draw(st.integers(0, 3))):
        contents[data.draw(st.integers(0, len(contents) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(contents)
    try:
        rn.read_log(path)
    except CompensatorError as error:
        assert str(path) in str(error)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The log of a static gain -1.9 on 1/(q - 2), in columns of other names."""
    folder, rng = tmp_path_factory.mktemp("logs"), np.random.default_rng(1)
    y, rows = 0.3, []
    for k in range(80):
        u = -1.9 * y + 0.05 * rng.standard_normal()
        rows.append((k, u, y, -1.9))
        y = 2 * y + u
    for name, head in (("log", "k,u,y,gain"), ("other", "time,force,y,gain"), ("servo", "k,u,y,r")):
        lines = [",".join(map(repr, row)) for row in rows]
        (folder / f"{name}.csv").write_text("\n".join([head, *lines]))
    return folder


OPTIONS = ("--names", "theta=gain", "--structure", "FIR", "--n-c", 1)


@pytest.mark.parametrize(
    ("log", "options", "words"),
    [
        ("log", (), r"--names theta=gain with --structure and --n-c"),
        ("other", (), r"--names u=force"),
        ("other", ("--names", "u=speed"), r"no 'speed'.*--names u=force"),
        ("log", ("--names", "theta=gain"), r"1 coefficient;.*--structure fir --n-c 1"),
        ("log", ("--structure", "IIR"), r"--structure iir needs its order n_c: give --n-c"),
        ("log", ("--structure", "irr"), r"Did you mean|is not one of 'iir'"),
        ("servo", ("--plant", "1/(q - 2)"), r"servo.csv has no theta"),
        ("log", (*OPTIONS, "--plant", "1/(s - 2)"), r"give --sample-time"),
        ("log", (*OPTIONS, "--plant", "2"), r"written in q"),
    ],
)
def test_a_stranger_is_told_what_to_type(logs, log, options, words):
    """What is proposed is there, and nothing that only Python has is told."""
    import re

    result = run(logs / f"{log}.csv", *options)
    assert result.exit_code == 2 and re.search(words, result.output, re.S), result.output
    assert not re.search(r"\w\(\w+=|variable='|servo_plant|iir\(", result.output)
    for proposed in re.findall(r"--names \w+=(\w+)", result.output):
        assert proposed in (logs / f"{log}.csv").read_text().splitlines()[0].split(",")


def test_the_plant_is_doubted_before_anything_else_is_said(logs):
    right = run(logs / "log.csv", *OPTIONS, "--plant", "1/(q - 2)")
    assert "The plant fits the log" in right.output and "The log is NOT" not in right.output
    for message, words in (("1/(q + 0.5)", "another"), ("-1/(q - 2)", "sign")):
        result = run(logs / "log.csv", *OPTIONS, "--plant", message, "--problem", "standard")
        first = " ".join(result.output.partition("The closed loop")[0].split())
        assert "NOT" in first and words in first
        outcome = run(
            logs / "log.csv", *OPTIONS, "--plant", message, "--problem", "standard", "--json"
        )
        assert strict(outcome.output)["plant_residual"]["is_doubtful"]
    # The plant of the other sign is that of a servo loop with no command.
    other = run(logs / "log.csv", *OPTIONS, "--plant", "-1/(q - 2)")
    assert "from the log: servo" in " ".join(other.output.split())


def test_the_status_is_that_of_the_first_line(tmp_path):
    """Status 1 where the plant does not explain the log; its loop is not called that of the log."""
    right = rn.servo_plant("0.68/(q - 0.82)")
    settings = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.fir_target(right), update=rn.UD(1e-3)
    )
    ran = rn.simulate(right, settings, np.outer(np.arange(600) // 100 % 2, [1.0, 0, 0]))
    log = write_csv(tmp_path / "log.csv", {
        "u": ran.u, "y": ran.y, "r": ran.w[:, :1], "theta": ran.theta})  # fmt: skip
    options = ("--problem", "servo", "--structure", "iir", "--n-c", 2)
    wrong = run(log, "--plant", "0.55/(q - 0.82)", *options)
    words = " ".join(wrong.output.split())
    assert wrong.exit_code == 1 and "The log is NOT explained by this plant" in words
    assert "The loop of this plant and this controller, which did not run, is" in words
    assert "The closed loop is" not in words
    fits = run(log, "--plant", "0.68/(q - 0.82)", *options)
    assert fits.exit_code == 0 and "The closed loop is stable" in fits.output


def test_the_plant_is_compared_with_the_signal_that_the_controller_reads(tmp_path):
    """A log of the plant's output beside r, from a controller that reads r - y."""
    right = rn.servo_plant("0.68/(q - 0.82)")
    settings = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.fir_target(right), update=rn.UD(1e-3)
    )
    ran = rn.simulate(right, settings, np.outer(np.arange(600) // 50 % 2, [1.0, 0, 0]))
    r = ran.w[:, :1]
    log = write_csv(tmp_path / "log.csv", {
        "u": ran.u, "y": r - ran.y, "r": r, "theta": ran.theta[:, [2, 3, 0, 1]]})  # fmt: skip
    options = ("--problem", "servo", "--structure", "iir", "--n-c", 2)
    first = " ".join(run(log, "--plant", "0.68/(q - 0.82)", *options).output.split())
    assert '--convention "r - y for y, y first"' in first and "The plant fits the log" in first
    wrong = " ".join(run(log, "--plant", "0.55/(q - 0.82)", *options).output.split())
    assert "The log is NOT explained by this plant" in wrong


def test_a_fixed_controller_is_given_as_its_transfer_function(tmp_path):
    """A PI controller that ran elsewhere, with a load that nobody logged."""
    plant, pi = "0.2*(q + 0.8)/((q - 0.9)*(q - 0.7))", "-(0.5*q - 0.4)/(q - 1)"
    ran = rn.simulate(plant, rn.FixedController(pi), rn.exogenous([rn.Step()], 200))
    log = tmp_path / "pi.csv"
    write_csv(log, {"u": ran.u, "y": ran.y})
    options = (str(log), "--plant", plant, "--problem", "standard", "--json")
    outcome = run(*options, "--controller", pi)
    assert outcome.exit_code == 0 and strict(outcome.output)["replay"]["agrees"]
    assert run(*options, "--controller", "-(0.5*q - 0.3)/(q - 1)").exit_code == 1
    assert "--controller" in run(*options).output
    assert "in continuous time" in run(*options, "--controller", "1/(s + 1)").output
    both = run(*options, "--controller", pi, "--structure", "iir", "--n-c", "1")
    assert both.exit_code == 2 and "the complete controller" in both.output


def other_program(words, theta, y):
    """A program in another convention: u, and theta as it logs it (one u, one y, two lags)."""
    u = np.zeros(len(y))
    for k in range(2, len(y)):
        part_u, part_y = [u[k - 1], u[k - 2]], [y[k - 1], y[k - 2]]
        if "-y" in words:
            part_y = [-one for one in part_y]
        phi = [*part_y, *part_u] if "y first" in words else [*part_u, *part_y]
        u[k] = theta[k] @ phi
    return u


@pytest.mark.parametrize("words", ["-y", "y first", "-y, y first"])
def test_a_foreign_convention_is_named_with_the_option_that_reads_it(tmp_path, words):
    """The first line names it, no stability is claimed, and the option gives the same verdict."""
    rng = np.random.default_rng(0)
    y = rng.standard_normal(200)
    theta = rng.uniform(-0.3, 0.3, (200, 4))
    log = write_csv(tmp_path / "log.csv", {
        "u": other_program(words, theta, y)[:, None], "y": y[:, None], "theta": theta})  # fmt: skip
    plain = run(log, "--n-c", 2, "--plant", "1/(q - 0.5)", "--problem", "standard")
    first = plain.output.splitlines()[1]
    assert plain.exit_code == 1 and f'--convention "{words}"' in first
    assert "UNSTABLE" not in plain.output and "closed loop is stable" not in plain.output
    answer = strict(run(log, "--n-c", 2, "--plant", "1/(q - 0.5)", "--json").output)
    assert answer["conventions"]["matches"][0]["convention"] == words
    assert answer["health"]["is_stable"] is None and "loop" not in answer
    right = strict(run(log, "--n-c", 2, "--convention", words, "--json").output)
    assert right["replay"]["agrees"] and "conventions" not in right


def test_a_log_that_no_convention_explains_has_no_verdict_on_stability(tmp_path, signals):
    damaged = {**signals, "theta": signals["theta"] * np.linspace(1, 1.01, 300)[:, None]}
    result = run(write_csv(tmp_path / "log.csv", damaged), "--n-c", 4, "--plant", PLANT)
    assert result.exit_code == 1 and "under any of" in result.output.splitlines()[1]
    assert "UNSTABLE" not in result.output and "closed loop is stable" not in result.output


@pytest.mark.costly
def test_the_problem_is_honoured_for_matrices_or_refused(tmp_path):
    """A servo log of a 2 x 2 plant: the option, the log and the file say the same."""
    A, B, C = np.diag([0.5, 0.3]), np.eye(2), np.array([[1.0, 0.2], [0.0, 1.0]])
    np.savez(tmp_path / "plant.npz", A=A, B=B, C=C)
    np.savez(tmp_path / "complete.npz", A=A, B=B, C=C, D_1=B)
    (tmp_path / "plant.toml").write_text(
        f'[plant]\nproblem = "servo"\nA = {A.tolist()}\nB = {B.tolist()}\nC = {C.tolist()}\n'
    )
    plant = rn.servo_plant(rn.Plant(A=A, B=B, D_1=B, C=C))
    theta = np.concatenate([0.1 * np.eye(2).ravel(), 0.2 * np.eye(2).ravel()])
    controller = rn.FixedController(rn.iir(1, 2, 2).compensator(theta))
    w = rn.exogenous([rn.WhiteNoise()] * 2 + [rn.Step(0)] * 4, 300, 0)
    loop = rn.simulate(plant, controller, w)
    log = tmp_path / "log.npz"
    np.savez(log, u=loop.u, y=loop.y, r=loop.w[:, :2], theta=np.tile(theta, (300, 1)))
    results = [run(log, "--n-c", 1, "--json", *options) for options in (
        ("--plant", tmp_path / "plant.npz", "--problem", "servo"),
        ("--plant", tmp_path / "plant.npz"),
        ("--plant", tmp_path / "plant.toml"),
        ("--plant", tmp_path / "plant.toml", "--problem", "servo"),
    )]  # fmt: skip
    radii = {strict(one.output)["loop"]["spectral_radius"] for one in results}
    assert len(radii) == 1
    for options in (
        ("--plant", tmp_path / "plant.toml", "--problem", "standard"),
        ("--plant", tmp_path / "complete.npz", "--problem", "servo"),
        ("--problem", "servo"),
    ):
        refused = run(log, "--n-c", 1, *options)
        assert refused.exit_code == 2 and "--problem" in refused.output


def test_minus_z_as_y_costs_what_y_equal_to_z_costs(tmp_path):
    """One loop logged twice: a controller on -z, theta with the other sign of its y part."""
    plant = rn.standard_plant("1/(q - 0.5)")
    settings = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.fir_target(plant), update=rn.UD(1e-2)
    )
    loop = rn.simulate(plant, settings, rn.exogenous([rn.Step()], 300))
    answers = []
    for sign in (1, -1):
        log = tmp_path / f"log{sign}.npz"
        theta = loop.theta * [1, 1, sign, sign]
        np.savez(log, u=loop.u, y=sign * loop.y, z=loop.z, theta=theta)
        answers.append(strict(run(log, "--n-c", 2, "--plant", "1/(q - 0.5)", "--json").output))
    first, second = answers
    assert second["problem"]["decided"] == "negated" and first["problem"]["decided"] == "standard"
    assert np.isclose(first["h2"]["cost"], second["h2"]["cost"], rtol=1e-12)
    assert np.isclose(first["h2"]["lqg"], second["h2"]["lqg"], rtol=1e-9)


def test_a_plant_in_s_is_sampled_as_by_design(signals):
    plant = read_case("1/(s + 1), 0; 0.2/(s + 1), 2/(s + 3)", "standard", 0.1)[0]
    rows = [["1/(s + 1)", "0"], ["0.2/(s + 1)", "2/(s + 3)"]]
    assert plant == rn.plant_of(rows, sample_time=0.1)
