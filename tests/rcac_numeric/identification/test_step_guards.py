"""Where a step test is refused, at the bounds: a sensor at its limit, each gate, no model."""

from types import SimpleNamespace

import numpy as np
import pytest

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.identification import _step_response as steps
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import KNOWN, Gate
from rcac_numeric.identification._process_search import FEW
from rcac_numeric.identification._step_models import SHARE
from rcac_numeric.identification._step_response import (
    OVERSHOOT,
    StepResponse,
    _gates,
    _kind,
    _require_range,
    identify_step_response,
)

# Distances from the extreme in its range of 20, so that 0.05, 0.5 and 0.9 of it are whole numbers.
RANGE = 20.0
RISE = (15.0, 12.0, 6.0, 3.0)  # resolved by five rows, and steep


def refusal(before, length, rows=100, after=10.0, start=()):
    """The words for distances before the extreme, which lasts; alike for the other extreme."""
    head = [*start, RANGE, *before]
    distance = np.array([*head, *[0.0] * length, *[after] * (rows - len(head) - length)])
    assert len(distance) == rows
    words = []
    for y in (RANGE - distance, distance, 2.0**-9 * (RANGE - distance), 64 * distance - 7):
        try:
            _require_range(y)
            words.append("")
        except UndecidedError as error:
            words.append(str(error))
    assert len({bool(one) for one in words}) == 1, "units and sign matter"
    return words[0]


def test_a_limit_is_named_with_its_rows():
    words = refusal(RISE, 50, start=(RANGE, 19.0))
    assert words.startswith("y stands at 20 from row 7 on for 50 rows")
    assert refusal(RISE, 95)  # until the end of the record


@pytest.mark.parametrize(
    ("length", "rows", "is_refused"),
    [
        (5, 100, False),
        (6, 100, True),
        (4, 60, False),
        (5, 60, True),
        (10, 200, False),
        (11, 200, True),
    ],
)
def test_a_limit_lasts_for_a_twentieth_and_more_than_four_rows(length, rows, is_refused):
    assert bool(refusal(RISE, length, rows)) == is_refused


def test_the_longest_of_two_limits_counts():
    for first, second in ((50, 6), (6, 50)):
        before = [*RISE, *[0.0] * first, 20.0, *RISE]
        words = refusal(before, second)
        row = 5 if first > second else 5 + first + 5
        assert f"from row {row} on for 50 rows" in words


@pytest.mark.parametrize(
    ("before", "is_refused"),
    [
        (RISE, True),
        (RISE[1:], False),  # four rows are not resolved
        ((18.0, *RISE[1:]), True),  # nine tenths of the range are no more than that
        ((18.5, *RISE[1:]), False),
        ((18.5, *RISE), True),
    ],
)
def test_the_change_is_resolved_by_five_rows(before, is_refused):
    assert bool(refusal(before, 50)) == is_refused


def test_a_limit_from_within_the_range_is_no_change():
    """No row before it is far from the extreme."""
    distance = np.array([10.0, 8.0, 6.0, 4.0, 3.0, 2.0, *[0.0] * 50, *[RANGE] * 44])
    _require_range(distance)
    _require_range(-distance)


@pytest.mark.parametrize(
    ("before", "length", "is_refused"),
    [
        # Of up to 39 rows at the limit, the three rows before decide.
        ((15.0, 8.0, 1.5, 0.9, 0.5), 30, True),
        ((15.0, 8.0, 1.0, 0.9, 0.5), 30, False),  # a twentieth of the range
        ((15.0, 8.0, 0.9, 0.8, 0.5), 30, False),
        ((15.0, 8.0, 0.7, 0.4, 0.2), 30, False),
        # Of 50 rows at the limit, the five before.
        ((15.0, 8.0, 1.5, 0.9, 0.8, 0.7, 0.5), 50, True),
        ((15.0, 8.0, 0.95, 0.9, 0.8, 0.7, 0.5), 50, False),
        ((15.0, 8.0, 6.0, 0.95, 0.9, 0.8, 0.7, 0.5), 50, False),
    ],
)
def test_the_change_before_a_limit_is_steep(before, length, is_refused):
    assert bool(refusal(before, length)) == is_refused


@pytest.mark.parametrize(
    ("before", "is_refused"),
    [
        ((15.0, 12.0, 6.0, 6.0, 6.0), False),  # of one level: rounding
        ((15.0, 12.0, 6.0, 6.0, 3.0), False),
        ((15.0, 12.0, 6.0, 4.0, 3.0), True),
        ((18.0, 17.0, 15.0, 12.0, 10.0), False),  # half of the range in one row: a jump
        ((18.0, 17.0, 15.0, 12.0, 9.0), True),
        ((18.0, 17.0, 9.0, 9.5, 12.0), False),
        ((18.0, 17.0, 16.0, 15.0, 14.0), False),
    ],
)
def test_the_change_has_three_levels_and_ends_within_half_the_range(before, is_refused):
    assert bool(refusal(before, 30)) == is_refused


def test_the_first_row_of_a_record_counts():
    """Of a limit of 60 rows the six rows before it decide, and the record has five."""
    assert refusal((0.9, 0.8, 0.7, 0.6), 60)
    assert not refusal((0.9, 0.8, 0.7, 0.6), 30)


# The gates.


def response(value):
    return lambda omega: np.array([value])


@pytest.fixture
def gates_of(monkeypatch):
    """The gates of a fit whose statistics are given."""

    def gates(
        *, moves=FEW, bic=100.0, without_u=200.0, of_jumps=200.0, jumps=(), dead_time=5.0,
        deviation=KNOWN / 2, others=(), steps_of_record=100, gain=2.0,
    ):  # fmt: skip
        evaluations = []
        monkeypatch.setattr(steps, "bic_of_jumps", lambda record: evaluations.append(1) or of_jumps)
        monkeypatch.setattr(steps, "bic_without_u", lambda record, fit: without_u)
        monkeypatch.setattr(steps, "gate_frequency", lambda fit: 0.25)
        monkeypatch.setattr(steps, "response_at", lambda fit, omega: 1j * np.ones(len(omega)))
        monkeypatch.setattr(steps, "gain_deviation", lambda samples, integrates, edge: deviation)
        misfit = Gate("misfit", True, 0.0, KNOWN, "", "")
        monkeypatch.setattr(steps, "_misfit", lambda fit, bic, box_jenkins, edge: misfit)
        monkeypatch.setattr(
            steps, "open_loop_gate",
            lambda u, y, delay, e, parameters: Gate("stability", True, delay, 0.0, "", ""),
        )  # fmt: skip
        fit = SimpleNamespace(
            bic=bic, jumps=jumps, theta=np.array([1.0, 0.5, dead_time]), integrates=False,
            gain=gain, e=None, parameters=4,
        )  # fmt: skip
        record = SimpleNamespace(moves=moves, steps=steps_of_record, u=None, y=None)
        worse = SimpleNamespace(bic=1e9, jumps=(), theta=np.array([1.0, 0.5, 0.0]))
        search = SimpleNamespace(record=record, fits=[fit, worse])
        rivals = SimpleNamespace(
            distinct=[SimpleNamespace(bic=one, response=response(value)) for one, value in others]
        )
        by_name = {gate.name: gate for gate in _gates(search, rivals, None)}
        return by_name, len(evaluations)

    return gates


def test_the_effect_of_u_is_the_difference_of_two_bic(gates_of):
    for without, passed in ((ODDS, False), (np.nextafter(ODDS, 99), True)):
        gate = gates_of(without_u=without, bic=0.0)[0]["effect of u"]
        assert (gate.passed, gate.value, gate.limit) == (passed, without, ODDS)
    # Level jumps count beside, where the fit has some.
    assert gates_of(of_jumps=101.0)[0]["effect of u"].value == 100.0
    assert gates_of(of_jumps=101.0, jumps=(7,))[0]["effect of u"].value == 1.0


@pytest.mark.parametrize(
    ("moves", "jumps", "has_gate", "evaluations"),
    [(FEW, (), True, 1), (FEW + 1, (), False, 0), (FEW + 1, (7,), False, 1), (1, (7,), True, 1)],
)
def test_few_moves_have_a_gate_of_level_jumps(gates_of, moves, jumps, has_gate, evaluations):
    gates, count = gates_of(moves=moves, jumps=jumps, of_jumps=130.0)
    assert ("level jumps" in gates) == has_gate and count == evaluations
    if has_gate:
        assert gates["level jumps"].value == 30.0 and gates["level jumps"].passed
    names = ["effect of u", *["level jumps"] * has_gate, "dead time", "gain", "sign"]
    assert list(gates) == [*names, "misfit", "stability"]


def test_the_dead_time_stays_below_the_longest_that_was_tried(gates_of):
    last = 100 / SHARE
    for dead_time, passed in ((last - 1, False), (np.nextafter(last - 1, 0), True), (last, False)):
        gate = gates_of(dead_time=dead_time)[0]["dead time"]
        assert (gate.passed, gate.value, gate.limit) == (passed, dead_time, last)


def test_the_gate_of_stability_has_the_dead_time_of_the_fit(gates_of):
    for dead_time, steps_late in ((5.0, 5), (5.6, 6), (0.0, 0)):
        assert gates_of(dead_time=dead_time)[0]["stability"].value == steps_late


def test_the_gain_is_known(gates_of):
    for deviation, passed in ((KNOWN, False), (np.nextafter(KNOWN, 0), True)):
        gate = gates_of(deviation=deviation)[0]["gain"]
        assert (gate.passed, gate.value) == (passed, deviation)


@pytest.mark.parametrize(
    ("others", "gain", "count"),
    [
        ([(100.0, 2j)], 2.0, 0),
        ([(100.0, -2j), (100.0, 2j)], 2.0, 1),
        ([(100.0, 2j)], -2.0, 1),
        ([(100.0, 0j)], 2.0, 1),
        ([(100.0, 1.0 + 0j)], 2.0, 1),  # a right angle
        ([(100 + ODDS - 1e-9, -1j), (100 + ODDS, -1j), (100 + ODDS + 1, -1j)], 2.0, 1),
        ([(100 - ODDS - 1, -1j), (100 - ODDS + 1, -1j)], 2.0, 2),
        ([(99.0, -1j)], 2.0, 1),
    ],
)
def test_the_sign_is_that_of_all_credible_models(gates_of, others, gain, count):
    gate = gates_of(others=others, gain=gain)[0]["sign"]
    assert (gate.passed, gate.value) == (not count, count)


# The kind, and the error of the dead time.


@pytest.mark.parametrize("damping", [np.nextafter(OVERSHOOT, 0), OVERSHOOT, 0.3, 2.0])
def test_an_oscillating_kind_has_an_overshoot_of_five_percent(damping):
    """Of 1/((s/w)^2 + 2 zeta s/w + 1), S = 2 zeta/w and rho = 1/(2 zeta)^2."""
    rho = 1 / (2 * damping) ** 2
    structure = SimpleNamespace(name="second order", lag=lambda theta: (1.0, rho))
    kind = _kind(SimpleNamespace(structure=structure, theta=None))
    assert kind == ("oscillating" if rho > 1 / (2 * OVERSHOOT) ** 2 else "second order")
    assert (kind == "oscillating") == (damping < OVERSHOOT)


@pytest.mark.parametrize(
    ("interval", "period", "error"),
    [((4.0, 7.0), 1.0, 3), ((2.0, 5.0), 1.0, 2), ((2.0, 5.0), 0.5, 4), ((3.9, 4.1), 1.0, 1),
     ((4.0, 4.0), 1.0, 1), ((4.0, 6.5), 2.0, 2)],
)  # fmt: skip
def test_the_error_of_the_dead_time_in_steps(interval, period, error):
    step = SimpleNamespace(dead_time=4.0, dead_time_interval=interval)
    assert StepResponse.delay_error(step, period) == error


# From a record to its answer.


def test_a_record_goes_to_its_models_from_rest_with_two_noises(monkeypatch):
    u, y = np.where(np.arange(50) < 10, 3.0, 5.0), np.linspace(0, 1, 50) ** 2
    u[1] = 2.5
    records, noises, fits = [], [], [1]
    distinct = [SimpleNamespace(noise=name) for name in ("white", "coloured", "drifting")]
    monkeypatch.setattr(
        steps, "ProcessSearch",
        lambda record: records.append(record) or SimpleNamespace(fits=distinct, is_closed=False),
    )  # fmt: skip
    monkeypatch.setattr(steps, "_require_step", lambda search, period: None)
    monkeypatch.setattr(
        steps, "StepSearch",
        lambda record, some: noises.append(some) or SimpleNamespace(fits=fits, record=record),
    )  # fmt: skip
    monkeypatch.setattr(steps, "step_samples", lambda record, fits: "samples")
    gates = [Gate("gain", True, 0, 0, "words", "advice")]
    monkeypatch.setattr(steps, "_gates", lambda *some: tuple(gates))
    monkeypatch.setattr(steps, "_response", lambda *some: some)
    *_, gates_of_response, period = identify_step_response(u, y, sample_time=0.5)
    assert gates_of_response == tuple(gates) and period == 0.5
    assert records[0].u[0] == 0 and noises == [("white", "coloured")]
    assert np.allclose(np.diff(records[0].u) * records[0].units[0], np.diff(u))
    gates += [Gate("sign", False, 1, 0, "both", "Excite u."), Gate("misfit", False, 1, 0, "x", "y")]
    with pytest.raises(UndecidedError, match=r"Failed: sign: both; misfit: x\. Excite u\."):
        identify_step_response(u, y)
    fits.clear()
    with pytest.raises(InputError, match="no model could be fitted"):
        identify_step_response(u, y)
