"""The symbolic derivation holds, and its means of proof can tell true from false."""

import subprocess
import sys

import pytest

from proofs import intercalation
from proofs.intercalation import LOOP, D_c, G_c, G_yu, N_c, S, Step, steps, with_inverse


@pytest.mark.parametrize("step", steps(), ids=lambda step: step.equation)
def test_step_holds(step):
    assert step.holds


@pytest.mark.parametrize(
    "wrong",
    [S * (1 + LOOP), S - 1, (1 - 2 * LOOP) * S, S * (1 - G_c * G_yu),
     (D_c**-1 - G_c * S * G_yu * D_c**-1) * (D_c - N_c * G_yu)],
)  # fmt: skip
def test_false_identities_are_not_confirmed(wrong):
    assert with_inverse(wrong) != 1


def test_a_wrong_regressor_is_noticed(monkeypatch):
    monkeypatch.setattr(intercalation, "kronecker_product", lambda a, b: 2 * a)
    with pytest.raises((ValueError, AssertionError)):
        assert intercalation.regressor_layout()


def test_exit_code_tells_the_outcome(monkeypatch, capsys):
    run = subprocess.run(
        [sys.executable, "-m", "proofs.intercalation"], capture_output=True, text=True, check=True
    )
    assert run.stdout.count("holds") == len(intercalation.CHECKS)
    monkeypatch.setattr(intercalation, "steps", lambda: (Step("(0)", "false", False),))
    assert intercalation.main() == 1
    assert "FAILS" in capsys.readouterr().out
