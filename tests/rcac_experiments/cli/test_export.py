"""`rcac export`: of an example and of a run that was kept, as a folder and as an FMU."""

import json

import pytest
from click.testing import CliRunner

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import load_example
from tests.support import core_builds
from tests.support.signals import noise

SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3]), update=rn.UD(0.05), k_w=3
)
PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")


def test_the_command(tmp_path):
    out = CliRunner().invoke(
        main, ["export", "4.7", "-o", str(tmp_path), "--real", "float32", "--json"]
    )
    assert out.exit_code == 0, out.output
    record = json.loads(out.output)["export"]
    assert record["real"] == "float32" and "src/rcac.c" in record["files"]


def test_the_command_on_a_run_that_was_kept(tmp_path):
    run = rn.simulate(PLANT, SETTINGS, noise(3, 300, 1))
    run.save(tmp_path / "run.npz")
    for more in ([], ["--fixed"]):
        command = ["export", str(tmp_path / "run.npz"), "-o", str(tmp_path / "out"), *more]
        assert CliRunner().invoke(main, command).exit_code == 0
    wrong = CliRunner().invoke(main, [*command, "--run", "UD"])
    assert wrong.exit_code and "is a saved run" in wrong.output
    wrong = CliRunner().invoke(main, ["export", "4.7", "-o", str(tmp_path), "--run", "none"])
    assert wrong.exit_code and "the runs are" in wrong.output


@pytest.mark.costly
@pytest.mark.skipif(core_builds.compiler() is None, reason="there is no C compiler on this machine")
def test_an_fmu_from_a_shell(tmp_path):
    fmpy = pytest.importorskip("fmpy", reason="needs fmpy: pip install it")
    file = tmp_path / "c.fmu"
    run = CliRunner().invoke
    done = run(main, ["export", "4.7", "-o", str(file), "--sample-time", "0.1", "--supervised"])
    assert done.exit_code == 0 and "FMI 2.0" in done.output
    assert fmpy.read_model_description(str(file)).modelName == "rcac"
    for more, words in (
        ([], "sample time"),
        (["--sample-time", "-1"], "x>0"),
        (["--sample-time", "1", "--real", "float32"], "--real apply"),
    ):
        wrong = run(main, ["export", "4.7", "-o", str(file), *more])
        assert wrong.exit_code == 2 and words in wrong.output


def test_an_experiment_is_no_controller(tmp_path):
    with pytest.raises(InputError, match="cannot be exported"):
        rn.export_controller(load_example("4.7"), tmp_path)


DESIGNED = """
[plant]
problem = "standard"
G = "1/(q - 0.5)"

[target]
model = "fir"

[controller]
n_c = 1
R_theta = 0.1

[signals]
w = { step = 1.0 }

[run]
steps = 30

[[runs]]
name = "fixed"
controller = { freeze = [[0]] }

[[runs]]
name = "RCAC"
"""


def exported(*arguments):
    return CliRunner().invoke(main, ["export", *map(str, arguments)])


@pytest.mark.parametrize(
    ("options", "words", "names_the_first"),
    [
        ((), "run 'fixed', the fixed controller theta(0): adaptation is frozen", False),
        (("--fixed",), "run 'fixed', its final controller, fixed.", False),
        (("--run", "RCAC"), "run 'RCAC', adaptive. The first run of", True),
    ],
)
def test_the_first_line_says_which_controller_was_exported(
    tmp_path, options, words, names_the_first
):
    case = tmp_path / "case.toml"
    case.write_text(DESIGNED)
    result = exported(case, "-o", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    text = " ".join(result.output.split())
    assert f"Exported: {words}" in text
    assert ("the verdict in the file of a design, is 'fixed'" in text) == names_the_first


def test_a_folder_of_other_files_is_refused(tmp_path):
    case, folder = tmp_path / "case.toml", tmp_path / "board"
    case.write_text(DESIGNED)
    folder.mkdir()
    assert exported(case, "-o", folder).exit_code == 0  # an empty one
    assert exported(case, "-o", folder, "--run", "RCAC").exit_code == 0  # an export
    (folder / "README.md").write_text("My board")
    before = (folder / "src" / "rcac_config.h").read_bytes()
    refused = exported(case, "-o", folder)
    assert refused.exit_code == 2 and "did not write" in refused.output
    assert (folder / "src" / "rcac_config.h").read_bytes() == before
