"""The clock of a log: the sample time, gaps, jitter, and stamps that give none."""

import re

import numpy as np
import pandas
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import (
    ControllerLog,
    check_controller,
    design,
    inspect_log,
    read_log,
    standard_plant,
)
from rcac_numeric.controllers._compensator import compensator_of
from rcac_numeric.identification import identify_step_response
from rcac_numeric.signals._clock import clock_of, in_seconds
from tests.support.strategies import seeds
from tests.support.ulogs import ulog

PERIODS = st.sampled_from([0.001, 0.004, 0.02, 0.1, 1 / 3, 1.0, 7.5, 60.0])


def lost(rng, steps, share):
    """Rows of a log that lost some, the first and the last one kept."""
    is_present = rng.random(steps) >= share
    is_present[[0, 1, -1]] = True
    return is_present


@given(seeds, PERIODS, st.integers(30, 400), st.floats(0, 0.4), st.floats(0, 0.1))
def test_the_steps_of_a_log_with_gaps_and_jitter(seed, period, steps, share, jitter):
    rng = np.random.default_rng(seed)
    is_present = lost(rng, steps, share)
    times = period * (np.arange(steps) + jitter * rng.uniform(-1, 1, steps))
    clock = clock_of(times[is_present] + 5, "t")
    assert clock.is_regular, clock.problem
    assert np.array_equal(clock.step_of_row, np.flatnonzero(is_present))
    assert clock.sample_time == pytest.approx(period, rel=1e-6 + 4 * jitter / steps)
    assert clock.missing == np.count_nonzero(~is_present)
    assert clock.jitter <= 2 * jitter + 1e-6 + 8 * jitter / steps * clock.longest_gap


@given(seeds, PERIODS, st.integers(60, 400), st.integers(2, 30))
def test_coarse_stamps_of_even_rows(seed, period, steps, rows_a_stamp):
    """Whole seconds, for instance, of which several rows have the same one."""
    unit = period * rows_a_stamp
    clock = clock_of(np.floor(np.arange(steps) / rows_a_stamp) * unit, "t")
    assume(steps > 4 * rows_a_stamp)
    if clock.resolution:
        assert clock.missing == 0
        assert clock.sample_time == pytest.approx(period, rel=2 * rows_a_stamp / steps)
    else:
        assert clock.repeated and "stamp of the row before" in clock.problem


@given(seeds, PERIODS)
def test_irregular_repeated_and_turning_stamps_are_refused(seed, period):
    rng = np.random.default_rng(seed)
    even = period * np.arange(100.0)
    assert "irregular" in clock_of(np.cumsum(rng.exponential(period, 100)), "t").problem
    at = int(rng.integers(2, 98))
    repeated = np.insert(even + period * 0.01 * rng.random(100), at, 0)
    repeated[at] = repeated[at - 1]
    clock = clock_of(repeated, "t")
    assert clock.repeated == 1 and f"row {at + 1}" in clock.problem
    clock = clock_of(np.concatenate([even[:at], even]), "t")
    assert clock.turning == 1 and f"row {at + 1}" in clock.problem
    assert "pauses" in clock_of(np.concatenate([even, even + 1e5 * period]), "t").problem


def record(steps=400, seed=0):
    rng = np.random.default_rng(seed)
    u, y = np.repeat(rng.choice([-1.0, 1.0], steps // 5), 5), np.zeros(steps)
    for k in range(1, steps):
        y[k] = 0.9 * y[k - 1] + 0.1 * u[k - 1]
    return u, y + 1e-3 * rng.standard_normal(steps)


def test_gaps_become_missing_rows_and_are_named():
    u, y = record()
    is_present = lost(np.random.default_rng(1), len(u), 0.2)
    log = read_log({"t": 0.1 * np.flatnonzero(is_present), "u": u[is_present], "y": y[is_present]})
    assert log.steps == len(u) and log.sample_time == 0.1
    assert np.array_equal(log.missing, ~is_present)
    assert (
        np.array_equal(log.y[is_present, 0], y[is_present]) and np.isnan(log.y[~is_present]).all()
    )
    assert "rows are missing" in log.clock


def test_resampling_fills_gaps_and_states_its_error():
    u, y = record()
    is_present = lost(np.random.default_rng(2), len(u), 0.2)
    table = {"t": 0.1 * np.flatnonzero(is_present), "u": u[is_present], "y": y[is_present]}
    log = read_log(table, resample=0.1)
    assert log.steps == len(u) and not log.missing.any() and log.sample_time == 0.1
    assert np.allclose(log.y[is_present, 0], y[is_present], atol=1e-9)
    error = np.sqrt(np.mean((log.y[:, 0] - y)[~is_present] ** 2)) / y.std()
    stated = float(log.notes[1].split("error of ")[1].split("%")[0]) / 100
    assert error <= stated < 1


def test_irregular_times_are_resampled_on_request_only():
    t = np.cumsum(np.random.default_rng(3).exponential(0.1, 500))
    table = {"t": t, "u": np.sign(np.sin(t)), "y": np.sin(t)}
    with pytest.raises(InputError, match=r"irregular.*resample="):
        read_log(table)
    log = read_log(table, resample=0.05)
    steps = t[0] + 0.05 * np.arange(log.steps)
    assert np.abs(log.y[:, 0] - np.sin(steps)).max() < np.diff(t).max() ** 2 / 8 + 1e-9
    assert read_log(table, time="none").steps == 500


@pytest.mark.parametrize("seconds", [0.04, 0.0041, 0.7])
def test_a_sample_time_that_the_stamps_contradict(seconds):
    u, y = record(100)
    table = {"timestamp": 4000 * np.arange(100), "u": u, "y": y}
    assert read_log(table, sample_time=0.004).sample_time == 0.004
    with pytest.raises(InputError, match="sample_time"):
        read_log(table, sample_time=seconds)
    assert read_log(table, sample_time=seconds, time="none").sample_time == seconds


@given(seeds, PERIODS, st.integers(30, 2000), st.integers(1, 3), st.booleans())
@example(seed=0, period=1.0, steps=600, copies=1, has_gap=False)
def test_rows_that_stand_twice_are_refused(seed, period, steps, copies, has_gap):
    """Every later row would be late by one step."""
    rng = np.random.default_rng(seed)
    at = np.sort(rng.choice(np.arange(1, steps - 1), copies, replace=False))
    times = np.insert(period * np.arange(steps), at, period * at)
    if has_gap:
        times = np.delete(times, min(int(at[-1]) + copies + 3, len(times) - 1))
    clock = clock_of(times, "t")
    assert clock.repeated >= 1 and f"in row {at[0] + 2}" in clock.problem


def clock_of_column(name, times, sample_time=None):
    """The clock of a column of numbers."""
    seconds, unit = in_seconds(np.asarray(times, float), name, "", sample_time)
    return clock_of(seconds, name, unit=unit)


@pytest.mark.cases(100)
@pytest.mark.parametrize("name", ["Time", "t", "Zeit", "local time"])
@pytest.mark.parametrize("decimals", [5, 6, 9, 11])
@pytest.mark.parametrize("seconds", [2, 5, 10, 15, 60, 300])
@pytest.mark.parametrize("begin", [20001.25, 45720.58564, 79000.7, 739680.58564])
def test_days_of_a_spreadsheet(name, decimals, seconds, begin):
    days = np.round(begin + seconds * np.arange(400) / 86400, decimals)
    clock = clock_of_column(name, days)
    writer = "MATLAB" if begin > 1e5 else "a spreadsheet"
    assert clock.unit == f"days of {writer}, assumed" and clock.missing == 0
    assert clock.sample_time == pytest.approx(seconds, rel=2e-3)


@pytest.mark.parametrize("period", [0.0001, 0.001, 0.002, 0.0025, 0.004, 0.005, 0.008, 0.01, 0.1])
@pytest.mark.parametrize("drift", [0, 2e-5, -1e-4])
def test_seconds_since_a_device_was_started_are_no_days(period, drift):
    for begin in (45720.5, 739680.5):
        clock = clock_of_column("t", begin + period * (1 + drift) * np.arange(400))
        assert clock.unit == "s, assumed" and clock.sample_time == pytest.approx(period, rel=1e-3)
    assert clock_of_column("elapsed", 45720.58564 + np.arange(400) / 43200).unit == "s, assumed"


def test_the_sample_time_decides_between_days_and_seconds():
    times = 45720.5 + 0.001 * np.arange(400)
    assert clock_of_column("t", times, 86.4).sample_time == 86.4
    assert clock_of_column("t", times, 0.001).sample_time == 0.001


def test_stamps_of_fourteen_digits():
    stamps = np.datetime64("2024-02-28T23:59:01") + 7 * np.arange(90_000).astype("timedelta64[s]")
    digits = [int(re.sub(r"\D", "", str(stamp))) for stamp in stamps]
    clock = clock_of_column("Time", digits)
    assert clock.unit == "YYYYMMDDhhmmss" and clock.sample_time == 7.0 and clock.missing == 0
    for wrong in (20250229120000, 20250304240000, 20250304126000, 20251301120000, 20250300120000):
        assert clock_of_column("Time", [*digits[:20], wrong]).unit != "YYYYMMDDhhmmss"


@given(seeds, st.sampled_from([0.001, 1.0]), st.integers(100, 2000), st.floats(0.05, 0.4))
@example(1, 0.001, 1001, 0.25)  # stamps below 1 s: three decimals are three digits
def test_stamps_of_one_step_with_jitter_are_rounded(seed, period, steps, jitter):
    """0, 1, 1, 3 ms of 1 kHz: a row is late, and the next is in time."""
    rng = np.random.default_rng(seed)
    times = np.floor(np.arange(steps) + 0.1 + jitter * rng.uniform(-1, 1, steps)) * period
    assume(np.count_nonzero(np.diff(times) == 0) > 10 and (np.diff(times) >= 0).all())
    clock = clock_of(times, "t")
    assert clock.is_regular and clock.missing == 0, clock.problem


def test_a_repeated_stamp_in_a_file_has_row_line_and_remedy(tmp_path):
    u, y = record(600)
    t = np.insert(np.arange(599.0), 300, 299.0)
    path = tmp_path / "log.csv"
    np.savetxt(path, np.c_[t, u, y], delimiter=",", header="t,u,y", comments="", fmt="%.6g")
    with pytest.raises(InputError, match=r"first in row 301 \(line 302\)\. Resample") as error:
        read_log(path)
    assert "none" not in str(error.value)
    log = read_log(path, resample=1.0)
    assert log.steps == 599 and np.allclose(log.y[400:, 0], y[401:], rtol=1e-5)


def test_every_reader_of_a_log_refuses_another_sample_time():
    u, y = record(200)
    log = read_log({"t": np.arange(200.0), "u": u, "y": y})
    compensator = compensator_of("0.1", "controller")
    readers = (
        lambda log, h: design(log, sample_time=h),
        lambda log, h: design([log, log], sample_time=h),
        lambda log, h: identify_step_response(log, sample_time=h),
        lambda log, h: check_controller(log, compensator=compensator, sample_time=h),
    )
    for read in readers:
        with pytest.raises(InputError, match=r"every 1 s, and sample_time = 2\. Leave"):
            read(log, 2.0)
    for resample, sample_time in ((0.5, 1.0), (1.0, 0.5)):
        with pytest.raises(InputError, match=rf"every {resample:g} s by resample, and"):
            read_log({"t": np.arange(200.0), "u": u, "y": y},
                     resample=resample, sample_time=sample_time)  # fmt: skip


STAMPS = np.datetime64("2025-03-04T14:03:20") + np.arange(60).astype("timedelta64[s]")
FORMS = ("%d-%b-%y %H:%M:%S", "%d %b %y %H:%M:%S", "%d/%b/%Y %H:%M:%S", "%Y-%m-%d %H:%M:%S")


@pytest.mark.parametrize("form", FORMS)
def test_stamps_with_the_name_of_a_month(form):
    texts = [stamp.strftime(form) for stamp in STAMPS.tolist()]
    frame = pandas.DataFrame({"Time": texts, "u": np.arange(60.0), "y": np.ones(60)})
    assert inspect_log(frame).clock.sample_time == 1.0


def numbered(k):
    return f"{0.5 * k}"


@pytest.mark.cases(16)
@pytest.mark.parametrize("name", ["Time", "DateTime", "t", "Zeit"])
@pytest.mark.parametrize("stamp", [str, numbered])
@pytest.mark.parametrize("kind", ["csv", "frame"])
@pytest.mark.parametrize("at", [0, 29, 59])
def test_a_stamp_that_is_no_time_is_named(tmp_path, name, stamp, kind, at):
    """One bad stamp must not turn the seconds of a log into steps, not even beside a counter."""
    texts = [stamp(one) for one in (STAMPS if stamp is str else range(60))]
    texts[at] = "<bad>"
    frame = pandas.DataFrame({"index": np.arange(60), name: texts, "u": 1.0, "y": np.arange(60.0)})
    log, place = frame, f"in row {at + 1}"
    if kind == "csv":
        log, place = tmp_path / "log.csv", f"in row {at + 1} (line {at + 4})"
        log.write_text("# site 4\n\n" + frame.to_csv(index=False))
    words = re.escape(f"column {name}: 1 of 60 stamps is no time: '<bad>' {place}. Mend it")
    for time in (None, name):
        assert re.search(words[:-8], inspect_log(log, time=time).unread)
        with pytest.raises(InputError, match=words):
            read_log(log, time=time)
        with pytest.raises(InputError, match=words):
            read_log(log, time=time, resample=0.5)
    assert read_log(log, time="none", sample_time=2.0).sample_time == 2.0


@pytest.mark.parametrize("name", ["Time", "time [s]", "t [s]", "timestamp", "elapsed_time"])
@pytest.mark.parametrize("times", [np.full(60, 5.0), 60.0 - np.arange(60)])
def test_times_that_never_rise_are_no_steps(name, times):
    """A stopped or a falling clock must not turn the seconds of a log into steps."""
    frame = pandas.DataFrame({name: times, "u": 1.0, "y": np.arange(60.0)})
    with pytest.raises(InputError, match=r"in every row|turns back"):
        read_log(frame)
    assert read_log(frame, time="none", sample_time=2.0).sample_time == 2.0
    assert read_log(frame.assign(k=0.5 * np.arange(60)), time="k").sample_time == 0.5


@pytest.mark.parametrize("name", ["T", "t", "Date", "timer"])
def test_signals_that_fall_are_no_clock(name):
    frame = pandas.DataFrame({name: 60.0 - np.arange(60), "u": 1.0, "y": np.arange(60.0)})
    assert read_log(frame).sample_time is None


def test_texts_beside_another_clock_are_no_clock():
    frame = pandas.DataFrame({"Date": ["today"] * 60, "t": 0.5 * np.arange(60), "u": 1.0, "y": 2.0})
    assert read_log(frame).sample_time == 0.5
    with pytest.raises(InputError, match=r"60 of 60 stamps are no times, the first 'today'"):
        read_log(frame, time="Date")
    frame = pandas.DataFrame({"batch": ["12:30", "12:31", *["AB-7"] * 58], "u": 1.0, "y": 2.0})
    assert read_log(frame).clock == "index counts 60 steps"


def test_topics_of_two_rates(tmp_path):
    """y every 8 ms, u and theta every 4 ms with a fifth of the messages lost."""
    rng, steps = np.random.default_rng(4), 400
    t = 1_000_000 + 4000 * np.arange(steps)
    is_present = lost(rng, steps, 0.2)
    u, y = rng.standard_normal((2, steps)).astype("f4")
    theta = rng.standard_normal((steps, 6)).astype("f4")
    control = {"timestamp": t[is_present], "u": u[is_present], "theta": theta[is_present]}
    path = tmp_path / "log.ulg"
    path.write_bytes(ulog({"control": control, "sensor": {"timestamp": t[::2] + 300, "y": y[::2]}},
                          dropouts=[120, 40]))  # fmt: skip
    contents = inspect_log(path)
    assert contents.clocks["control"].sample_time == 0.004
    assert contents.clocks["control"].missing == np.count_nonzero(~is_present)
    assert any("2 dropouts of 0.16 s" in note for note in contents.notes)
    log = read_log(path)
    assert log.sample_time == 0.008 and log.steps == steps // 2
    assert np.allclose(log.y[:, 0], y[::2])
    has_value = is_present[::2]
    assert np.array_equal(log.missing, ~has_value)
    assert np.allclose(log.u[has_value, 0], u[::2][has_value])
    assert np.allclose(log.theta[has_value], theta[::2][has_value])
    assert any(note.startswith("u of control (every 0.004 s)") for note in log.notes)


def test_a_log_keeps_what_its_clock_says():
    with pytest.raises(InputError, match="must be positive"):
        ControllerLog(u=[1, 2], y=[3, 4], sample_time=-1.0)
    with pytest.raises(InputError, match="gaps"):
        ControllerLog(u=[1, np.nan], y=[3, 4])
    log = ControllerLog(u=[1, np.nan], y=[3, 4], has_gaps=True)
    assert log.missing.tolist() == [False, True]
    with pytest.raises(InputError, match="gaps"):
        ControllerLog(u=[1, np.inf], y=[3, 4], has_gaps=True)


def test_a_check_of_a_log_with_times_has_seconds():
    """The picture's axes, and the delay margin."""
    rng, y = np.random.default_rng(5), [0.3]
    for _ in range(79):
        y.append(0.1 * y[-1] + 0.01 * rng.standard_normal())
    table = {"t": 0.02 * np.arange(80), "y": np.array(y), "u": -1.9 * np.array(y)}
    compensator, plant = compensator_of("-1.9", "controller"), standard_plant("1/(q - 2)")
    check = check_controller(read_log(table), compensator=compensator, plant=plant)
    assert {axis.get_xlabel() for axis in check.plot().axes} >= {"time $t$, s"}
    margins = check_controller(
        read_log(table, time="none"), compensator=compensator, plant=plant, sample_time=0.02
    ).margins
    assert check.margins == margins


TURNING = [20.0 + (-1) ** k for k in range(40)]


@pytest.mark.parametrize(
    ("name", "values", "note"),
    [
        ("T", TURNING, "T turns back in 20 of 40 rows"),
        ("t", TURNING, "t turns back in 20 of 40 rows"),
        ("t", [5.0] * 40, "t has the same value in all rows"),
        ("date", ["2026-03-04"] * 40, "date has the same value in all rows"),
        ("Date", ["04.03.2026"] * 40, "Date has the same value in all rows"),
        ("date", [20260304] * 40, "date has the same value in all rows"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("has_counter", [False, True])
def test_columns_with_names_of_times_that_are_none_are_named(name, values, note, has_counter):
    table = {name: values, "u": np.arange(40) % 3, "y": np.arange(40) % 5}
    table |= {"k": np.arange(40)} if has_counter else {}
    frame = pandas.DataFrame(table)
    log = read_log(frame.set_index("k") if has_counter else frame[[*table]], time=None)
    assert (
        log.notes == (f"{note}, and is not read as times",)
        and log.steps == 40
        and log.sample_time is None
    )
    with pytest.raises(InputError, match=r"turns back|same stamp"):
        read_log(frame, time=name)


@pytest.mark.parametrize("table", [
    {"time": 0.1 * np.arange(40), "T": TURNING},
    {"date": ["2026-03-04"] * 40, "time": [f"12:00:{k:02d}.0" for k in range(40)]},
    {"date": [""] * 40}, {"T": TURNING[:1] * 40, "t": 0.1 * np.arange(40)},
])  # fmt: skip
def test_nothing_is_said_of_them_beside_a_clock(table):
    signals = {"u": np.arange(40) % 3, "y": np.arange(40) % 5}
    assert read_log(pandas.DataFrame(table | signals)).notes == ()


def test_a_temperature_that_is_a_signal_is_no_clock():
    log = read_log({"T": TURNING, "u": np.arange(40) % 3}, names={"y": "T"})
    assert log.notes == () and log.clock == ""
