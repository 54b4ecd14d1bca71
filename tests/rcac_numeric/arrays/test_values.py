"""How data show themselves where they have nothing better."""

import re
import unicodedata

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcac_experiments import FigureRequest
from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
from rcac_numeric.arrays._values import WIDTH, Value, field_names
from rcac_numeric.estimation import EKF, Estimator, LinearModel
from tests.rcac_numeric.samples import SAMPLES, SEEDS

PLAIN = [cls for cls in SAMPLES if issubclass(cls, Value) and cls.__str__ is Value.__str__]


@pytest.mark.costly
@pytest.mark.cases(40)
@pytest.mark.parametrize("cls", PLAIN, ids=lambda cls: cls.__name__)
@settings(max_examples=3)
@given(seed=st.integers(0, SEEDS - 1))
def test_data_print_as_their_repr_or_field_by_field(cls, seed):
    value = SAMPLES[cls](seed)
    text = str(value)
    if text == repr(value):
        assert len(text) <= WIDTH and "\n" not in text
        return
    first, *rest = text.splitlines()
    assert first == cls.__name__
    shown = [line.split()[0] for line in rest if re.match(r"  \S", line)]
    held = [name for name in field_names(cls) if getattr(value, name) is not None]
    assert set(shown) <= set(held) and shown == sorted(shown, key=held.index) and shown
    assert max(map(len, rest)) <= 2 * WIDTH


@given(text=st.text(max_size=200))
def test_what_a_notebook_shows_is_escaped(text):
    cells = FigureRequest("responses", text)._repr_html_()
    inside = re.sub(r"</?(table|caption|tr|th|td|pre)( style='[\w:-]*')?>", "", cells)
    assert "<" not in inside and ">" not in inside


@given(text=st.text(max_size=200))
def test_a_strangers_text_reaches_no_terminal(text):
    for shown in (str(FigureRequest("responses", text + 90 * "y")), str([text])):
        assert not any(unicodedata.category(c) == "Cc" and c != "\n" for c in shown)
    assert str(FigureRequest("responses", "\x1b[31m\n" + 90 * "y")).count("\\x1b") == 1


def test_what_is_live_shows_where_it_stands():
    settings = ControllerSettings(structure=iir(1), target=TargetModel([0.0, 1.0]), update=UD(1.0))
    for made, settings_of in (
        (Controller(settings), "R_theta=1.0"),
        (Estimator(EKF(LinearModel(A=1, C=1), Q=1, R=1)), "LinearModel"),
    ):
        made.step([1.0], *([1.0],) * isinstance(made, Controller))
        assert "k=1" in repr(made) and settings_of in made._repr_html_()
