"""How data show themselves where they have nothing better."""

import re
import unicodedata

from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric import UD, Controller, ControllerLog, ControllerSettings, TargetModel, iir
from rcac_numeric.estimation import EKF, Estimator, LinearModel
from tests.rcac_numeric.samples import SAMPLES
from tests.support.equality import printing_of

test_data_print_as_their_repr_or_field_by_field = printing_of(SAMPLES, cases=35)


def named(text):
    """Data that hold a text of somebody else, the name of a file."""
    return ControllerLog([0.0], [0.0], source=text)


@given(text=st.text(max_size=200))
def test_what_a_notebook_shows_is_escaped(text):
    cells = named(text)._repr_html_()
    inside = re.sub(r"</?(table|caption|tr|th|td|pre)( style='[\w:-]*')?>", "", cells)
    assert "<" not in inside and ">" not in inside


@given(text=st.text(max_size=200))
def test_a_strangers_text_reaches_no_terminal(text):
    for shown in (str(named(text + 90 * "y")), str([text])):
        assert not any(unicodedata.category(c) == "Cc" and c != "\n" for c in shown)
    assert str(named("\x1b[31m\n" + 90 * "y")).count("\\x1b") == 1


def test_what_is_live_shows_where_it_stands():
    settings = ControllerSettings(structure=iir(1), target=TargetModel([0.0, 1.0]), update=UD(1.0))
    for built, settings_of in (
        (Controller(settings), "R_theta=1.0"),
        (Estimator(EKF(LinearModel(A=1, C=1), Q=1, R=1)), "LinearModel"),
    ):
        built.step([1.0], *([1.0],) * isinstance(built, Controller))
        assert "k=1" in repr(built) and settings_of in built._repr_html_()
