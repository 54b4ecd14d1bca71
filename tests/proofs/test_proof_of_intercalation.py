"""The symbolic derivation's means of proof can tell true from false."""

import pytest

from proofs.symbolic import intercalation
from proofs.symbolic.intercalation import LOOP, D_c, G_c, G_yu, N_c, S, with_inverse


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
