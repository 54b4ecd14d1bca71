"""Every exact result is a formula in a notebook, and the formula is one that a parser reads."""

import inspect
import re

import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from math_core import LatexError, LatexToMathML

import compensator_theory as exact
from compensator_theory._latex import displayed, latex, words
from compensator_theory.polynomials._values import ExactValue
from tests.compensator_theory.samples import SAMPLES
from tests.rcac_numeric.samples import SAMPLES as NUMERIC
from tests.support.public import public_objects

RESULTS = [
    cls
    for cls in public_objects("compensator_theory").values()
    if inspect.isclass(cls) and issubclass(cls, ExactValue)
]
READER = LatexToMathML(fancy_error=False)  # which sets the formulas of the docs


def require_formula(text):
    """Refuse what is no formula, and what a parser of LaTeX does not know."""
    assert text.startswith(r"$\displaystyle ") and text.endswith("$")
    formula = text.removeprefix(r"$\displaystyle ").removesuffix("$")
    assert formula.strip() and not re.search(r"(?<!\\)\$", formula)
    symbols = re.sub(r"\\text\{.*?\}", "", formula)
    assert not re.search(r"\b(None|True|False|Poly|Matrix|Enclosure)\b", symbols)
    READER.convert_with_local_state(formula, displaystyle=True)


@pytest.mark.parametrize("cls", RESULTS, ids=lambda cls: cls.__name__)
def test_every_exact_result_has_a_formula(cls):
    assert "_repr_latex_" in vars(cls), "see compensator_theory._latex"


@pytest.mark.costly
@pytest.mark.cases(40)
@pytest.mark.parametrize("cls", RESULTS, ids=lambda cls: cls.__name__)
@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=2)
@given(data=st.data())
def test_the_formula_is_read(cls, data):
    value = data.draw(SAMPLES[cls])
    require_formula(value._repr_latex_())
    require_sympy_writes_it(value)


def require_sympy_writes_it(value):
    """SymPy's `latex` writes what a notebook shows, of the value and of what holds it."""
    formula = value._repr_latex_().removeprefix(r"$\displaystyle ").removesuffix("$")
    assert sympy.latex(value) == formula
    for holder in ([value], (value, 1), {"G": value}):
        assert formula in sympy.latex(holder)


FORMULAS = [
    cls
    for cls in public_objects("rcac_numeric").values()
    if inspect.isclass(cls) and "_repr_latex_" in vars(cls)
]


@pytest.mark.parametrize("cls", FORMULAS, ids=lambda cls: cls.__name__)
def test_sympy_writes_the_formulas_of_the_numeric_half(cls):
    require_sympy_writes_it(NUMERIC[cls](1))


@pytest.mark.parametrize(
    "broken",
    [
        "x = 1",
        r"$\displaystyle x_{1$",
        r"$\displaystyle \left(x$",
        r"$\displaystyle \frac{1}$",
        r"$\displaystyle \nosuchcommand$",
        r"$\displaystyle \begin{matrix} 1 \end{bmatrix}$",
        r"$\displaystyle F = None$",
        r"$\displaystyle a $ b$",
        r"$\displaystyle $",
    ],
)
def test_a_broken_formula_is_seen(broken):
    with pytest.raises((AssertionError, LatexError)):
        require_formula(broken)


@given(st.text(st.characters(codec="ascii"), min_size=1).filter(str.strip))
def test_any_words_may_stand_in_a_formula(text):
    formula = displayed(words(text))
    bare = re.sub(r"\\[{}\\_#$%&^~]", "", formula)
    assert bare.count("{") == bare.count("}") and not set(bare[1:-1]) & set("$#%&")


def test_a_result_inside_another_loses_its_signs():
    lag = exact.transfer_function("1/(s + a)", "s")
    assert latex(lag) == r"\frac{1}{s + a}"
    assert latex((lag, 2)) == r"\left(\frac{1}{s + a}, 2\right)"


def test_a_polynomial_descends_whatever_its_symbols_are():
    assert latex(exact.polynomial("a*s + b - s**2", "s")) == "- s^{2} + a s + b"
