"""`rcac check` decides which problem a log is of, and its status says what it found."""

import numpy as np
from click.testing import CliRunner

import rcac_numeric as rn
from rcac_experiments.cli._exits import DONE, MISSED, NO, UNDECIDED, UNSTABLE
from rcac_experiments.cli._main import main

G = "0.1*(q - 0.4)/((q - 0.9)*(q - 0.7))"
PLANTS = {"standard": rn.standard_plant(G), "servo": rn.servo_plant(G)}


def servo_run(steps=600, noise=0.05, **others):
    plant = PLANTS["servo"]
    settings = rn.ControllerSettings(
        structure=rn.iir(2),
        target=others.pop("target", rn.fir_target(plant)),
        update=rn.UD(1e-4),
        **others,
    )
    return rn.simulate(
        plant, settings, rn.exogenous([rn.Step(), rn.WhiteNoise(noise), rn.Step(0)], steps)
    )


def csv_of(run, path, u=None):
    columns = {"u": run.u[:, 0] if u is None else u, "y": run.y[:, 0]}
    columns |= {f"theta[{i}]": column for i, column in enumerate(run.theta.T)}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    return str(path)


def checked(path, *options):
    arguments = ["check", path, "--n-c", "2", "--plant", G, *options]
    return CliRunner().invoke(main, arguments)


def test_the_log_that_was_certified_with_the_wrong_sign(tmp_path):
    """The servo run without r was called UNSTABLE as the standard problem, with status 0."""
    path = csv_of(servo_run(), tmp_path / "log.csv")
    result = checked(path)
    assert result.exit_code == DONE, result.output
    assert "from the log: servo" in result.output and "is stable" in result.output
    wrong = checked(path, "--problem", "standard")
    assert wrong.exit_code == NO or "UNSTABLE" in wrong.output
    quiet = servo_run(steps=600, noise=0.0)
    idle = csv_of(quiet, tmp_path / "idle.csv", u=np.zeros(600))
    assert checked(idle).exit_code in (NO, UNDECIDED)


def test_unstable_and_missed_have_a_status(tmp_path):
    plant = PLANTS["servo"]
    requested = ["0.1", "0.2", "0.3", "0.4"]
    target = rn.pole_placement_target(plant, requested[:3])
    run = servo_run(noise=0.0, target=target, k_w=4)
    path = csv_of(run, tmp_path / "missed.csv")
    words = f"{' + '.join(f'({c:.17g})*q**{-i}' for i, c in enumerate(target.numerator[:, 0, 0]))}"
    lower = " + ".join(f"({c:.17g})*q**{-i}" for i, c in enumerate(target.denominator[:, 0, 0]))
    result = checked(path, "--problem", "servo", "--target", f"({words})/({lower})")
    assert result.exit_code == MISSED, result.output
    theta = np.tile(run.theta[-1], (len(run.theta), 1))
    theta[-1, 2:] *= -40  # the last coefficients make the loop unstable
    unstable = tmp_path / "unstable.npz"
    np.savez(unstable, u=run.u, y=run.y, theta=theta[-1])
    assert checked(str(unstable), "--problem", "servo").exit_code in (UNSTABLE, NO)
