"""The command `rcac place` and the conditioning that it reports."""

import json

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

from compensator_theory import (
    InputError,
    place_poles,
    polynomial_from_roots,
    to_coq,
    transfer_function,
)
from compensator_theory.errors import RoundingWarning
from rcac_experiments.cli._main import main
from rcac_numeric import placement_conditioning


@pytest.fixture
def rcac():
    return lambda *arguments: CliRunner().invoke(main, list(arguments))


def hard_case(n):
    """Poles -1 .. -n, interlaced zeros, closed-loop poles -(k/2 + 1/4): section 7 at its worst."""
    half = sympy.Rational(1, 2)
    plant = transfer_function(
        zeros=[-(k + half) for k in range(1, n)], poles=[-k for k in range(1, n + 1)],
        variable="s",
    )  # fmt: skip
    return plant, [-(k * half + half / 2) for k in range(1, 2 * n + 1)]


def test_example_7_5(rcac):
    arguments = ("place", "--plant", "4/((s + 1)*(s + 3))", "--poles", "-6, -5, -4, -2")
    result = rcac(*arguments)
    assert result.exit_code == 0
    assert "(33*s/4 + 93/4)/(s**2 + 13*s + 49)" in result.output
    assert "in float64: condition number" in result.output
    data = json.loads(rcac(*arguments, "--json").output)
    assert data["numerator"] == ["33/4", "93/4"] and data["denominator"] == ["1", "13", "49"]
    assert data["residual_is_zero"] and data["is_unique"] and data["feedback"] == -1
    positive = json.loads(rcac(*arguments, "--json", "--feedback", "+1").output)
    assert positive["numerator"] == ["-33/4", "-93/4"]


def test_order_and_symbols(rcac):
    plant = ("place", "--plant", "1/(s**2 + 3*s + 2)", "--poles")
    assert rcac(*plant, "-1+j, -1-j, -2", "--order", "1").exit_code == 0
    result = rcac(*plant, "-1+j, -1-j, -2", "--order", "2")
    assert result.exit_code == 2
    assert "gives 3 poles" in result.stderr and "--order 1" in result.stderr
    symbolic = rcac("place", "--plant", "b/(s + a)", "--poles", "-p, -r", "--json")
    assert symbolic.exit_code == 0 and json.loads(symbolic.output)["float64"] is None


@pytest.mark.parametrize(
    ("plant", "poles", "message"),
    [
        ("1/s", "-1,,-2", "empty entry"),
        ("1/s", "-1+j, -2", "lacks its conjugate"),
        ("1/s", "nan", "finite"),
        ("s**2/(s + 1)", "-1", "improper"),
        ("1/(s", "-1", "cannot read"),
        ("(s + 1)/((s + 1)*(s + 2))", "-3, -4, -5", "share the factor s + 1"),
        ("1/(s**2 + 3*s + 2)", "-1, -6", "t_1"),
        ("__import__('os')", "-1", "cannot read"),
        ("(a + b + c + d + s)**500/s", "-1", "terms"),
    ],
)
def test_bad_input_is_status_2(rcac, plant, poles, message):
    result = rcac("place", "--plant", plant, "--poles", poles)
    assert result.exit_code == 2 and not result.stdout
    assert message in result.stderr


def test_missing_or_wrong_options_are_status_2(rcac):
    assert rcac("place", "--plant", "1/s").exit_code == 2
    assert rcac("place", "--plant", "1/s", "--poles", "-1", "--feedback", "0").exit_code == 2
    assert rcac("place", "--plant", "1/s", "--poles", "-1", "--order", "x").exit_code == 2


def test_well_conditioned():
    for n in (2, 3):
        conditioning = placement_conditioning(*hard_case(n), feedback=-1)
        assert conditioning.digits > 10 and conditioning.float64_is_stable
        rebuilt = conditioning.matrix @ np.array(
            [float(c) for c in conditioning.exact.denominator.all_coeffs()]
            + [float(c) for c in conditioning.exact.numerator.all_coeffs()]
        )
        assert rebuilt == pytest.approx([float(c) for c in conditioning.exact.target.all_coeffs()])


def test_at_order_20_the_float64_solve_is_unstable_and_the_exact_answer_is_right():
    plant, poles = hard_case(20)
    with pytest.warns(RoundingWarning, match="UNSTABLE"):
        conditioning = placement_conditioning(plant, poles, feedback=-1)
    assert conditioning.target_is_stable and not conditioning.float64_is_stable
    assert (
        conditioning.abscissa > 0
        and conditioning.condition_number > 1e15
        and conditioning.digits < 1
    )
    exact = conditioning.exact
    assert exact.residual.is_zero
    assert exact.closed_loop_polynomial(exact.compensator) == polynomial_from_roots(poles, "s")
    system = exact.to_control()  # rounding the exact answer is harmless, so it does not warn
    assert system.num[0][0][0] == float(exact.numerator.LC())


def test_rounding_that_is_dangerous_by_itself_warns():
    # Poles at -1e-18, next to the boundary: the coefficients 1 + 1e-18 and 1 round to the same.
    placed = place_poles("1/(s - 1)", [sympy.Rational(-1, 10**18)], feedback=-1)
    with pytest.warns(RoundingWarning, match="UNSTABLE"):
        placed.to_control()
    with pytest.warns(RoundingWarning, match="moves a closed-loop pole"):
        place_poles("1/(z - 2)", [sympy.Rational(10**16 - 1, 10**16)], feedback=1).to_control()


def test_bad_input_of_conditioning():
    with pytest.raises(InputError, match="condition number"):
        placement_conditioning("1/(s**2 + 3*s + 2)", "s**2 + 3*s + 7", feedback=-1)
    with pytest.raises(InputError):
        placement_conditioning("1/(s + a)", [-1, -2], feedback=-1)
    with pytest.raises(InputError):
        placement_conditioning("1/s", [-1], feedback=0)
    with pytest.raises(InputError, match="range"):
        placement_conditioning("1/s", [-(10**400), -1], feedback=-1)


def test_keeping_the_plants_own_poles_needs_no_compensator():
    result = CliRunner().invoke(main, ["place", "--plant", "1/(s+1)", "--poles=-1,-4"])
    assert result.exit_code == 0, result.output
    assert "G_c = (0)/(s + 4)" in result.output


@pytest.mark.parametrize(
    ("poles", "words"),
    [
        ("(z + 1)**3", "in z, and the plant in s"),
        ("s + 1, s + 2", "an entry in the variable s"),
        ("s - s + 2", "no roots"),
        ("-1", "the plant alone has 2"),
        ("-1, -2, -3, -4", "--order 2"),
    ],
)
def test_what_is_wrong_with_the_poles(rcac, poles, words):
    result = rcac("place", "--plant", "1/(s**2 + 3*s + 3)", "--poles", poles, "--order", "1")
    if poles == "-1":
        result = rcac("place", "--plant", "1/(s**2 + 3*s + 3)", "--poles", poles)
    assert result.exit_code == 2 and words in result.stderr
    assert "(" not in result.stderr.replace(poles, "").replace("(s + 1)**3", "")


def test_poles_are_given_by_their_polynomial_too(rcac):
    plant = ("place", "--plant", "4/((s + 1)*(s + 3))", "--json", "--poles")
    by_roots, written = (rcac(*plant, p).stdout for p in ("-2, -2, -5", "(s + 2)**2*(s + 5)"))
    assert by_roots == written
    irrational = json.loads(rcac(*plant, "s**3 + 2").stdout)
    assert irrational["closed_loop"] == ["1", "0", "0", "2"] and irrational["residual_is_zero"]


def test_no_feedback_is_said_in_words(rcac):
    plant = ("place", "--plant", "4/((s + 1)*(s + 3))", "--poles")
    assert "There is no feedback" in rcac(*plant, "-1, -3").output
    assert "D_c has the others" in rcac(*plant, "-1, -3, -7").output
    assert "There is no feedback" not in rcac(*plant, "-1, -3.5").output


def test_a_constant_is_given_its_variable(rcac):
    requested = ("place", "--plant", "3", "--poles", "-1")
    refused = rcac(*requested)
    assert refused.exit_code == 2 and "--variable s" in refused.stderr
    assert "=" not in refused.stderr
    assert rcac(*requested, "--variable", "s").exit_code == 0


@pytest.mark.parametrize(
    ("plant", "poles", "words"),
    [("1/(z - 1)", "-1, -2", "inside the unit circle"), ("1/(s - 1)", "1, -2", "imaginary axis")],
)
def test_poles_that_are_unstable_where_they_are_asked_for_are_said_first(rcac, plant, poles, words):
    first = rcac("place", "--plant", plant, "--poles", poles).output.splitlines()[1]
    assert "requested closed loop is UNSTABLE" in first and words in first
    assert "UNSTABLE" not in rcac("place", "--plant", plant, "--poles", "-1/2, -1/3").output


def test_a_plant_with_a_function_of_a_symbol_is_placed(rcac):
    """z - e^-T and the gain e^-T add to z."""
    result = rcac("place", "--plant", "1/(z - exp(-T))", "--poles", "0", "--feedback", "-1")
    assert result.exit_code == 0, result.output
    assert "G_c = (exp(-T))/(1)" in result.output


def test_the_certificate_for_coq(rcac, tmp_path):
    plant = ("place", "--plant", "b/(s + a)", "--poles", "-1, -2", "--coq")
    file = tmp_path / "design.v"
    result = rcac(*plant, str(file))
    assert result.exit_code == 0 and f"Coq: {file}" in result.output
    design = place_poles("b/(s + a)", [-1, -2], feedback=-1)
    assert file.read_text(encoding="utf-8") == to_coq(design)
    for wrong in ("design.txt", "none/design.v"):
        result = rcac(*plant, str(tmp_path / wrong))
        assert result.exit_code == 2 and "--coq" in result.stderr
    assert list(tmp_path.iterdir()) == [file]
