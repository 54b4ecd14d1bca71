"""The design model: what is a log, whose uncertainty counts, which structures a plant has."""

import numpy as np
import pytest

from compensator_theory.errors import InputError, NoSolutionError
from rcac_numeric import ControllerLog, Step, Uncertainty, fir, pid, standard_plant
from rcac_numeric.designing import _design as designs
from rcac_numeric.designing._design import _basis_of, _DesignOptions, _is_log
from rcac_numeric.designing._plants import read_plant, variations

LOG = ControllerLog(np.ones(40), np.ones(40))
LAG, WASHOUT = "1/(q - 0.9)", "(q - 1)/((q - 0.5)*(q - 0.9))"  # whose zero at 1 blocks a constant
SQUARE = [["1/(q - 0.9)", "0"], ["0", "1/(q - 0.5)"]]


@pytest.mark.parametrize(
    ("plant", "is_log"),
    [
        (LOG, True),
        ([LOG], True),
        ((LOG, LOG, LOG), True),
        ([], False),
        ((), False),
        ([LOG, LAG], False),
        ([LAG], False),
        (LAG, False),
        ("", False),
        (standard_plant(LAG), False),
        (None, False),
    ],
)
def test_logs_are_one_or_several_and_nothing_else(plant, is_log):
    assert _is_log(plant) is is_log


@pytest.fixture
def basis_of(monkeypatch):
    """The basis of a plant, with references that name their arguments."""
    monkeypatch.setattr(designs, "_reference_of", lambda grid, structure: ("reference", structure))
    monkeypatch.setattr(designs, "with_feedforward", lambda model, reference, expected: (
        "with feedforward", reference
    ))  # fmt: skip

    def basis(G, structure=None, *, usual=Uncertainty(), uncertainty=None, feedforward=False):
        options = _DesignOptions(Step(0.5), 0.1, None, None, uncertainty, structure, feedforward)
        return _basis_of(read_plant(G, None, 0.0), usual, options)

    return basis


def test_the_uncertainty_of_the_user_goes_before_that_of_the_plant(basis_of):
    usual, mine = Uncertainty(delay=3), Uncertainty(gain=(0.5, 1.0), delay=0)
    for uncertainty, expected in ((None, usual), (mine, mine)):
        basis = basis_of(LAG, usual=usual, uncertainty=uncertainty)
        assert basis.uncertainty is expected
        assert basis.cases == variations(basis.model, expected)


def test_feedforward_is_added_on_request(basis_of):
    assert basis_of(LAG).reference == ("reference", None)
    assert basis_of(LAG, feedforward=True).reference == ("with feedforward", ("reference", None))


def test_a_structure_is_of_one_input(basis_of):
    assert basis_of(LAG, pid("PI")).reference == ("reference", pid("PI"))
    assert basis_of(SQUARE).reference == ("reference", None)
    with pytest.raises(InputError, match="one input and output"):
        basis_of(SQUARE, fir(3))


def test_an_integrator_has_no_zero_at_rest_beside_it(basis_of):
    assert basis_of(WASHOUT).blocked == (0.0,) and basis_of(LAG).blocked == ()
    assert basis_of(WASHOUT).reference == ("reference", None)
    for structure in (pid("P"), fir(3)):
        assert basis_of(WASHOUT, structure).reference == ("reference", structure)
    for structure in (pid("PI"), pid("I")):
        with pytest.raises(NoSolutionError, match=r"integrates.*zero at rest"):
            basis_of(WASHOUT, structure)
