"""Commands, disturbances and noise."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory import InputError


def test_values():
    k = np.arange(50)
    signal = 2 * rn.Harmonic(0.3, amplitude=1.5, phase=0.2) + rn.Step(-1, start=10)
    expected = 3.0 * np.cos(0.3 * k + 0.2) - (k >= 10)
    assert signal.samples(50) == pytest.approx(expected)
    assert rn.Levels([1, 2, 3], hold=2).samples(8).tolist() == [1, 1, 2, 2, 3, 3, 3, 3]


def test_ramp_and_pulse_are_sums_of_steps():
    k = np.arange(30)
    assert rn.Ramp(0.3, start=4).samples(30) == pytest.approx(
        sum((0.3 * rn.Step(1, start=j) for j in range(6, 30)), 0.3 * rn.Step(1, start=5)).samples(
            30
        )
    )
    by_steps = rn.Step(2, start=5) + rn.Step(-2, start=9)
    assert np.array_equal(rn.Pulse(2, start=5, length=4).samples(30), by_steps.samples(30))
    assert np.array_equal(rn.Pulse().samples(30), k == 0)


def test_a_record_ends_where_it_ends():
    """Alone, scaled and in a sum, whereas a sequence holds its last value."""
    record = rn.Recorded([1.0, 2.0, 3.0], "flight")
    combined = 2 * record + rn.Step() + rn.Recorded(np.arange(5.0))
    assert combined.samples(3).tolist() == [3, 6, 9]
    assert record.samples(2).tolist() == [1, 2]
    for signal in (record, combined):
        with pytest.raises(InputError, match=r"flight.* known for 3 steps, but 4 are requested"):
            signal.samples(4)
        with pytest.raises(InputError, match="known for 3 steps"):
            rn.exogenous([signal], 4)
    assert rn.Levels([1.0, 2.0]).samples(3).tolist() == [1, 2, 2]


def test_what_was_recorded_cannot_be_changed_from_outside():
    values = np.array([1.0, 2.0])
    signal = rn.Recorded(values)
    values[0] = signal.samples(2)[1] = 9.0
    assert signal.samples(2).tolist() == [1, 2]


def test_channels_of_a_record():
    table = np.arange(8.0).reshape(4, 2)
    assert np.array_equal(rn.exogenous(rn.recorded_channels(table), 4), table)
    noise = rn.exogenous([*rn.recorded_channels(table), rn.WhiteNoise()], 4, seed=1)
    assert np.array_equal(
        noise[:, 2], rn.exogenous([rn.Step(), rn.Step(), rn.WhiteNoise()], 4, seed=1)[:, 2]
    )


@pytest.mark.exact_data
def test_recordings_in_files(tmp_path):
    table = np.array([[0.1, -1e-300], [0.2, 3.0]])
    names, plain, binary = (tmp_path / name for name in ("a.csv", "b.CSV", "c.npy"))
    names.write_text("\ufeffr, d\n" + "\n\n".join(f"{a!r}, {b!r}" for a, b in table.tolist()))
    plain.write_text("\n".join(f"{a!r},{b!r}" for a, b in table.tolist()) + "\n")
    np.save(binary, table)
    for column in (0, 1):
        for file in (names, plain, binary):
            assert np.array_equal(rn.read_recording(file, column), table[:, column])
    assert np.array_equal(rn.read_recording(str(names), "d"), table[:, 1])
    np.save(binary, table[:, 0])
    assert np.array_equal(rn.read_recording(binary), table[:, 0])


@pytest.mark.parametrize(
    ("content", "column", "message"),
    [
        ("1,2\n3\n", 0, "line 2: 1 entries where 2 are needed"),
        ("1,2\n3,x", 1, "line 2, column 2: 'x' is not a number"),
        ("r,2\n3,4", 0, "line 1, column 1: 'r' is not a number"),
        ("r,d\n", 0, "no row of numbers"),
        ("", 0, "is empty"),
        ("r,d\n1,2", "v", "no column 'v'; it has r, d"),
        ("1,2", "r", "its columns have no names"),
        ("1,2", 2, "no column 2; it has 2"),
        ("1,2", -1, "column = -1"),
        ("1\nnan", 0, "must be finite"),
    ],
)
def test_bad_text_files_are_named(tmp_path, content, column, message):
    (tmp_path / "a.csv").write_text(content)
    with pytest.raises(InputError, match=message):
        rn.read_recording(tmp_path / "a.csv", column)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.npy", b"no array", "not an array of numbers"),
        ("a.npy", b"", "is empty"),
        ("a.csv", b"\xff\xfe\x00", "not a text file"),
        ("a.doc", b"", "use .csv, .txt"),
        ("missing.csv", None, "cannot be read: No such file"),
        ("missing.npy", None, "cannot be read: No such file"),
    ],
)
def test_bad_files_are_named(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        rn.read_recording(tmp_path / name)


def test_arrays_of_objects_are_not_unpickled(tmp_path):
    np.save(tmp_path / "a.npy", np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="not an array of numbers"):
        rn.read_recording(tmp_path / "a.npy")


def test_noise_is_reproducible_and_channels_are_independent():
    w = rn.exogenous([rn.WhiteNoise(2.0), rn.WhiteNoise(1.0)], 40_000, seed=3)
    assert np.array_equal(w, rn.exogenous([rn.WhiteNoise(2.0), rn.WhiteNoise(1.0)], 40_000, seed=3))
    # Standard errors: std / sqrt(2 n) = 0.007, correlation 1 / sqrt(n) = 0.005.
    assert w.std(axis=0) == pytest.approx([2.0, 1.0], abs=0.04)
    assert abs(np.corrcoef(w.T)[0, 1]) < 0.025
    alone = rn.exogenous([rn.WhiteNoise(2.0)], 40_000, seed=3)
    assert np.array_equal(alone[:, 0], w[:, 0])
    beside_a_step = rn.exogenous([rn.Step(), rn.WhiteNoise(1.0)], 40_000, seed=3)
    assert np.array_equal(beside_a_step[:, 1], w[:, 1]), "a channel does not disturb the others"


@pytest.mark.parametrize(
    "make",
    [
        lambda: rn.Step(float("nan")),
        lambda: rn.Step(1.0, start=-1),
        lambda: rn.Harmonic("fast"),
        lambda: rn.WhiteNoise(-1.0),
        lambda: rn.Levels([]),
        lambda: rn.Levels([1.0], hold=0),
        lambda: rn.Step() * float("inf"),
        lambda: rn.Ramp(float("nan")),
        lambda: rn.Ramp(1.0, start=-1),
        lambda: rn.Pulse(1.0, length=0),
        lambda: rn.Pulse(1.0, start=0.5),
        lambda: rn.Recorded([]),
        lambda: rn.Recorded([[1.0]]),
        lambda: rn.Recorded(["a"]),
        lambda: rn.recorded_channels([1.0]),
        lambda: rn.Step() + 1,
        lambda: rn.Piecewise(5),
        lambda: rn.Piecewise([5]),
        lambda: rn.Piecewise([(0, 1.0)]),
        lambda: rn.exogenous(5, 10),
        lambda: rn.exogenous([0.5], 10),
        lambda: rn.exogenous([], -1),
        lambda: rn.exogenous([], "long"),
    ],
)
def test_bad_input_is_named(make):
    with pytest.raises(InputError):
        make()
