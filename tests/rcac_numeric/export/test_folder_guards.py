"""What an export refuses and warns of at its bounds, and what it takes of a run."""

from types import SimpleNamespace

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    Plant,
    Saturation,
    TargetModel,
    export_controller,
    iir,
    simulate,
)
from rcac_numeric.export import _folder as folder
from rcac_numeric.export._recording import Recording
from rcac_numeric.export._tables import core_tables

SETTINGS = ControllerSettings(structure=iir(1), target=TargetModel([0, 1.0]), update=UD(0.05))
FIXED = Compensator([[[0.5]]], [[[0.0]], [[0.25]]])
PLANT = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], sample_time=0.05)


@pytest.fixture
def uncompiled(monkeypatch):
    """No compiler: the texts alone."""
    monkeypatch.setattr(folder, "compiler", lambda: None)


def run_of(**options):
    w = np.random.default_rng(1).standard_normal((30, 1))
    return simulate(PLANT, SETTINGS, w, **options)


# The arguments.


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"prefix": 3}, "prefix = 3"),
        ({"prefix": ""}, "prefix = ''"),
        ({"prefix": "Roll"}, "prefix = 'Roll'"),
        ({"prefix": "r" * 32}, "a name of C"),
        ({"prefix": "r" * 10, "layout": "px4"}, "has 10 letters"),
        ({"prefix": "r" * 10, "layout": ["c", "px4"]}, "has 10 letters"),
        ({"layout": ["c", "avr"]}, "layout"),
        ({"layout": "avr"}, "layout"),
        ({"layout": 3}, "layout"),
        ({"real": "float16"}, "real"),
        ({"run": SETTINGS}, "run"),
    ],
)
def test_arguments_that_are_refused_write_nothing(tmp_path, uncompiled, options, words):
    with pytest.raises(InputError, match=words):
        export_controller(SETTINGS, tmp_path / "export", **options)
    assert not (tmp_path / "export").exists()


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"prefix": "r" * 9, "layout": "px4"}, f"px4/{'r' * 9}_module.cpp"),
        ({"prefix": "r" * 31}, f"src/{'r' * 31}.c"),
        ({"layout": ("arduino", "px4")}, "px4/Kconfig"),
        ({"layout": ("arduino", "px4")}, "library.properties"),
    ],
)
def test_arguments_at_their_bounds(tmp_path, uncompiled, options, name):
    exported = export_controller(FIXED, tmp_path, **options)
    assert name in exported.files and (tmp_path / name).is_file()
    assert exported.real == "float64" and exported.agreement == "" and exported.warnings == ()


def test_a_run_brings_its_settings_limits_and_signals(tmp_path, uncompiled, monkeypatch):
    limits = Saturation(low=-0.5, high=0.25)
    run = run_of(saturation=limits)
    tables = []
    monkeypatch.setattr(
        folder,
        "core_tables",
        lambda *some, **more: tables.append(more) or core_tables(*some, **more),
    )
    vectors = []
    for i, (source, options) in enumerate(
        [(run, {}), (SETTINGS, {"saturation": limits, "run": run}), (SETTINGS, {})]
    ):
        export_controller(source, tmp_path / str(i), **options)
        vectors.append((tmp_path / str(i) / "test" / "rcac_vector.h").read_text())
    assert vectors[0] == vectors[1] != vectors[2]
    readmes = [(tmp_path / str(i) / "README.md").read_text() for i in range(3)]
    assert ["0.05 s" in readme for readme in readmes] == [True, True, False]
    narrower = Saturation(low=-0.1, high=0.1)
    export_controller(run, tmp_path / "narrower", saturation=narrower)
    assert [one["saturation"] for one in tables] == [limits, limits, None, narrower]
    other = simulate(PLANT, SETTINGS, np.ones((30, 1)))
    export_controller(run, tmp_path / "other", run=other, saturation=limits)
    assert (tmp_path / "other" / "test" / "rcac_vector.h").read_text() != vectors[0]


# float32 beside float64.


@pytest.fixture
def in_float32(monkeypatch):
    """The agreement of a loop in float32 with one in float64 whose z is 1."""

    def agreement(z, largest=1.0, z_64=1.0, settings=SETTINGS, steps=4):
        ones = np.ones((steps, 1))
        source = Recording(
            largest * ones, z_64 * ones, 0 * ones, z_64 * ones, np.zeros(2), "a loop"
        )

        def compiled(sources, program, *, includes):
            assert (
                all(one.is_file() for one in sources) and (includes[0] / "rcac_config.h").is_file()
            )
            return program

        def recording(program, tables, run, steps):
            theta = np.array([0.5, 0.25])
            return Recording(source.y, z * ones, source.r, z * ones, theta, "a loop")

        monkeypatch.setattr(folder, "compiled", compiled)
        monkeypatch.setattr(folder, "compiled_recording", recording)
        return folder._in_float32(core_tables(settings), source, None)[1]

    return agreement


@pytest.mark.parametrize(
    ("z", "largest", "z_64", "is_refused"),
    [
        (1.5, 1.0, 1.0, False),  # the worst ratio
        (1.5625, 1.0, 1.0, True),
        (1.25, 1.0, 1.0, False),
        (0.5, 1.0, 1.0, False),
        (2.0, 1e6, 1.0, False),  # 1e-6 of the largest signal
        (1.75, 1e6, 1.0, False),
        (2.5, 1e6, 1.0, True),
        (1.75, 1e7, 1.0, False),
        (2.0**-10, 1.0, 0.0, True),  # where float64 leaves nothing
        (2.0**-22, 1.0, 0.0, False),
        (0.0, 1.0, 0.0, False),
        (2.0**-22, 0.0, 0.0, True),
    ],
)
def test_float32_may_leave_half_more_than_float64(in_float32, z, largest, z_64, is_refused):
    if is_refused:
        with pytest.raises(InputError, match="Use float64"):
            in_float32(z, largest, z_64)
    else:
        assert in_float32(z, largest, z_64).startswith(f"rms z {z:.4g}, in float64 {z_64:.4g};")


def test_a_fixed_controller_is_compared_by_its_u(in_float32):
    assert in_float32(1.25).endswith("theta differs by 0.5 where its largest entry is 0")
    sentence = in_float32(1.25, settings=FIXED)
    assert sentence == ("rms u 1.25, in float64 1; u differs by 0.25 where its largest entry is 1")


def test_float32_goes_through_its_guards(tmp_path, uncompiled, monkeypatch):
    monkeypatch.setattr(folder, "_in_float32", lambda tables, source, run: (source, "as far as"))
    monkeypatch.setattr(folder, "_ranges", lambda *some: ("a warning.",))
    exported = export_controller(SETTINGS, tmp_path / "32", real="float32")
    assert exported.agreement == "as far as" and exported.warnings == ("a warning.",)
    exported = export_controller(SETTINGS, tmp_path / "64")
    assert exported.agreement == "" and exported.warnings == ()


@pytest.mark.parametrize(
    ("D_0", "row", "words"),
    [
        ((1.0, 4.0), 0.0, ()),
        ((2.0**100, 1.0), 0.0, ()),
        ((2.0**101, 1.0), 0.0, None),
        ((1.0, 2.0**-20), 0.0, ()),
        ((1.0, 2.0**-21), 0.0, ("above",)),
        ((1.0, 0.5), 1e12, ()),
        ((2.0, 0.5), 1e12, ("below",)),
        ((2.0, 2.0**-21), 1e12, ("above", "below")),
        ((1.0, 0.5), 2e12, ("below",)),
    ],
)
def test_the_ranges_of_R_theta(monkeypatch, D_0, row, words):
    """R_theta is 1/D(0); with bounds that are powers of two, and 1e-12 of the row 1."""
    monkeypatch.setattr(folder, "SMALLEST_R_THETA", 2.0**-100)
    monkeypatch.setattr(folder, "LARGEST_R_THETA", 2.0**20)
    monkeypatch.setattr(folder, "_largest_row", lambda settings, recording: row)
    tables = SimpleNamespace(D_0=D_0)
    assert folder._ranges(FIXED, SimpleNamespace(), None) == ()
    if words is None:
        with pytest.raises(InputError, match="below"):
            folder._ranges(SETTINGS, tables, None)
    else:
        warnings = folder._ranges(SETTINGS, tables, None)
        assert len(warnings) == len(words)
        assert all(word in one for word, one in zip(words, warnings, strict=True))
