"""Texts by grammar, and damaged ones, through every door of the exact half that reads a text.

expression_checks.py says what holds. A few are drawn by default, by HYPOTHESIS_PROFILE=thorough
100 000 texts. A long run grows by what Hypothesis remembers of the texts that it drew: 1189 MB
after 8000 lists of roots that nothing had read yet, and 5 MB more after 1500 of them were read and
placed. The limit is that of one input.
"""

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.fuzz.expression_checks import check_roots, check_text, warm

# Calls are counted while a text is read, which takes several times as long.
MANY = settings.default.max_examples
EXAMPLES = 100 * MANY if MANY >= 1000 else max(4, MANY // 4)

numbers = st.one_of(
    st.integers(0, 99).map(str),
    st.sampled_from(
        ["0", "1", "2", "0.1", ".5", "3.", "1e3", "1e-3", "1E+300", "1e300", "1e4000",
         "1e999999999",
         "12345678901234567890", "9" * 50, "9" * 3999, "2i", "2j", "0.8j", "1_0", "0x1", "1e",
         "007"]
    ),
    st.floats(0, 1e6, allow_nan=False).map(repr),
)  # fmt: skip
names = st.sampled_from(
    ["s", "s", "s", "z", "q", "a", "b", "x_1", "pi", "j", "I", "i", "E", "nan", "oo", "zeta",
     "lambda", "None", "__import__", "a.b", "S", "N", "Symbol", "gamma"]
)  # fmt: skip
spaces = st.sampled_from(["", "", "", " ", "  ", "\t", "\n"])
operators = st.sampled_from(["+", "-", "*", "/", "+", "-", "*", "/", "**", "^", "//", "%", "", ","])
calls = st.sampled_from(["sqrt", "sqrt", "CRootOf", "exp", "eval", "s", ""])
exponents = st.sampled_from(
    ["2", "3", "-1", "10", "1000", "1001", "0.5", "(1/3)", "1e300", "s", "-2"]
)


def joined(children):
    spaced = st.tuples(spaces, operators, spaces).map("".join)
    return st.one_of(
        st.tuples(children, spaced, children).map("".join),
        st.tuples(st.sampled_from(["-", "+", "- "]), children).map("".join),
        st.tuples(calls, children).map(lambda p: f"{p[0]}({p[1]})"),
        st.tuples(children, st.sampled_from(["**", "^"]), exponents).map(
            lambda p: f"({p[0]}){p[1]}{p[2]}"
        ),
        st.tuples(children, st.integers(2, 40)).map(lambda p: "+".join([p[0]] * p[1])),
        st.tuples(children, st.integers(2, 40)).map(lambda p: "*".join([f"({p[0]})"] * p[1])),
        st.tuples(children, st.integers(1, 70)).map(lambda p: "(" * p[1] + p[0] + ")" * p[1]),
        st.tuples(children, st.integers(1, 8)).map(lambda p: "sqrt(" * p[1] + p[0] + ")" * p[1]),
    )  # fmt: skip


grammatical = st.recursive(numbers | names, joined, max_leaves=12)


@st.composite
def damaged(draw):
    """Insert, remove or repeat a piece somewhere."""
    text = draw(grammatical)
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.integers(0, len(text)))
        piece = draw(
            st.text(max_size=3) | st.sampled_from(["(", ")", "**", "\u2212", "\x00", "__"])
        )
        text = text[:place] + piece + text[place + draw(st.integers(0, 2)) :]
    return text


texts = grammatical | damaged()
root_lists = st.tuples(
    st.lists(texts, min_size=1, max_size=5), st.sampled_from([", ", ",", " ", ";", " ; ", "  "])
).map(lambda p: p[1].join(p[0]))


@pytest.fixture(scope="module", autouse=True)
def warmed():
    warm()


@pytest.mark.costly
@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
@given(text=texts)
@example("sqrt(0.5-1e300**999)")
@example("j**1e300**999")
@example("9**9**9")
@example(f"({'9' * 3998})**(1/3)")
@example("sqrt(sqrt(sqrt(sqrt(sqrt(1E+300))))), sqrt(sqrt(sqrt(sqrt(sqrt(1e300)))))")
@example("-1 -2")
@example("s/sqrt(2)")
@example("s+s**-.5")
@example("0**-0.1")
@example("1 2")
@example("((+-255461)**10)/((1e300 + 2i)**5)")
@example("x - (0.49792366693993517/(1)/(x))/(0.011055127456464087**(-1/2))")
@example("(sqrt(b/0.8237219276497282 - sqrt(587727)))^1000")
@example("441374 + (0.036229641260683065 + z)/(sqrt(1e-3)-(0.7222695494051099)/(629456))")
@example("((1+pi)+(1+pi)+(1+pi))^1000")
@example("0.5877076538493217^-0.1+(I)/(-10)/a")
@example("+q/q-s-b - 007+2")
@example("(sqrt((S)+(²S)))**2")
@example("*".join(["((3.+0.45082763499547807 - I^.5)**(1/3))"] * 10))
@example("(s/3/j)/sqrt(724701*b)")
@example("s/(4*s + s/0.583146529421806**(1/3))")
@example("sqrt(+2i*1E+300 - 10)")
@example("(s - x_1/(0.8j) - 0.7)/sqrt(1.4/pi^-2)")
@example("(631166 - x_1/(0.8j) - 0.7083965152047808/297598)/sqrt(1.4142135623730951/pi^-2)")
@example("s + sqrt(1000000000000000007)*sqrt(1000000000000000009)")
@example("pi/(0.003^0.5 + z - 1E3)*(0.003^0.5 + z - 1E3)*(0.003^0.5 + z - 1E3)")
@example("s**2 + s/(j*sqrt(2*b))")
@example("s*j*sqrt(-b)")
@example("s/((sqrt(b) + j)*(sqrt(b) - j))")
@example("7/3/(sqrt(-2) - sqrt(1 + j))")
def test_a_text_is_refused_or_echoed(text):
    check_text(text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "((s+1)*(s+sqrt(-b)))/((s+1)*(b/s+sqrt(a*b)+a))",
        "(sqrt(7/3)+s+sqrt(-b))/(b/s+sqrt(a*b)+a)",
        "((2i + 1)^0.5*+2)^(-1/2)",
        "s/(s*(1+sqrt(b))+a)",
        "(sqrt(-b) - sqrt(a*b) - sqrt(sqrt(b)))/(sqrt(a*b)*s + sqrt(b)/(7/3))",
        "*".join(["((0.0405512345678901234/x_1)+s)"] * 30),
    ],
)
def test_a_text_that_takes_many_calls_is_refused_or_echoed(text):
    check_text(text)


@pytest.mark.costly
@settings(max_examples=EXAMPLES // 2, suppress_health_check=list(HealthCheck))
@example("j+j*sqrt(1.6866535829354996e-46)")
@example("+99999999999999999999  0.8934380951601534/0.14479776269673994^(10)**-1")
@given(text=root_lists)
@example("sqrt(sqrt(sqrt(sqrt(sqrt(1E+300))))), sqrt(sqrt(sqrt(sqrt(sqrt(1e300)))))")
@example("-1 -2")
@example("-1 - 2")
@example("1+2i 1-2i")
@example("z 1e1900 1e1900 1e1900")
@example("(3*0.1*x-nan_0)^1000")
@example("(s - 2i*1e300*x)**10, z")
def test_a_list_of_roots_is_refused_or_placed(text):
    check_roots(text)
