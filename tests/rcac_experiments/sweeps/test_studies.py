"""Studies as data: seeds, fingerprints, what is refused before anything runs."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.sweeps import (
    Axis,
    Metric,
    RandomAxis,
    Study,
    load_study,
    read_table,
    run_study,
)
from rcac_experiments.sweeps._canonical import canonical_json
from rcac_experiments.sweeps._cells import PERTURBATION, WHOLE_RUN, Cells, generator, words_of
from rcac_experiments.sweeps._files import study_of, study_schema
from rcac_experiments.sweeps._measures import STUDY_MEASURES
from rcac_experiments.sweeps._study import with_value
from rcac_experiments.sweeps._worker import ONCE_FOR_A_CELL, run_in_full
from tests.support import studies

plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner,
                                                                max_size=3),
    max_leaves=8,
)  # fmt: skip


@given(plain)
def test_equal_data_have_one_text_and_others_another(value):
    text = canonical_json(value)
    assert canonical_json(json.loads(text)) == text
    assert canonical_json([value, value]) != text
    reversed_keys = dict(reversed(list(value.items()))) if isinstance(value, dict) else value
    assert canonical_json(reversed_keys) == text


@given(
    st.floats(allow_nan=False, allow_infinity=False, width=64, min_value=-1e300, max_value=1e300),
    st.booleans(),
)
def test_two_numbers_that_differ_in_a_bit_have_two_texts(value, step):
    other = float(np.nextafter(value, np.inf if step else -np.inf))
    if np.isfinite(other):
        assert (canonical_json(other) == canonical_json(value)) == (other == value)


def test_the_fingerprint_is_that_of_what_decides_the_results():
    one = studies.study()
    same = studies.study(title="in other words", file="elsewhere/study.toml")
    others = [
        studies.study(seed=4), studies.study(19), studies.study(lanes=False),
        studies.study(keep=[Metric("rms")]), studies.study(common_noise=True),
        studies.study(base=with_value(studies.BASE, "run.steps", 121)),
        studies.over_R_theta([1.0], studies.deadly), studies.over_R_theta([1.0], studies.raising),
    ]  # fmt: skip
    assert same.fingerprint == one.fingerprint
    assert len({one.fingerprint, *(other.fingerprint for other in others)}) == 1 + len(others)


@pytest.mark.costly
def test_the_fingerprint_is_the_same_in_every_process():
    code = "from tests.support import studies; print(studies.over_R_theta([1.0], studies.deadly)"
    out = subprocess.run(
        [sys.executable, "-c", f"{code}.fingerprint)"],
        capture_output=True, text=True, check=True, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    assert out.stdout.strip() == studies.over_R_theta([1.0], studies.deadly).fingerprint


def test_a_data_file_that_changes_changes_the_fingerprint(tmp_path):
    base = {**studies.BASE, "signals": {"w": {"recorded": "w.csv"}}}
    built = []
    for value in (1.0, 2.0):
        np.savetxt(tmp_path / "w.csv", np.full(120, value), header="w", comments="")
        built.append(studies.study(base=base, file=str(tmp_path / "s.toml"), axes=[]).fingerprint)
    assert built[0] != built[1]


@given(st.integers(1, 30), st.integers(0, 30), st.sampled_from(["uniform", "normal"]))
def test_more_draws_go_on_where_fewer_ended(few, more, distribution):
    def drawn(count):
        return RandomAxis("gain", distribution, [0, 1], count).drawn(seed=9).values

    assert drawn(few + more)[:few] == drawn(few)


def test_noise_belongs_to_coordinates_and_repetition():
    """Whatever other values there are: that is what makes a study grow."""
    small, large = studies.study(), studies.study(
        axes=[
            Axis("R_theta", [5.0, 0.01, 100.0], sets="controller.R_theta"),
            Axis("noise", [2.0, 1.5], sets="signals.w.white_noise"),
        ]
    )  # fmt: skip
    place = {"R_theta": 0.01, "noise": 2}
    w = [Cells(s).cell(place).w(7) for s in (small, large)]
    assert np.array_equal(*w)
    others = [Cells(small).cell(place).w(8), Cells(small).cell({**place, "R_theta": 1.0}).w(7)]
    assert not any(np.array_equal(w[0], other) for other in others)
    common = Cells(studies.study(common_noise=True))
    a, b = (common.cell({**place, "R_theta": R}).w(7) for R in (0.01, 1.0))
    assert np.array_equal(a, b)
    assert words_of({"a": 1}) != words_of({"a": 1.5})


@given(
    st.sampled_from([0, 1, 2**32 - 1, 2**32, 2**62, 2**64, 2**100]),
    st.sampled_from([(), (0, 0, 0, 0), (7, 2**32 - 1, 0, 5)]),
    st.sampled_from([0, 1, 10**7, 2**32 - 1, 2**32]),
    st.sampled_from([0, 3, PERTURBATION, WHOLE_RUN]),
)
def test_noise_is_that_of_a_seed_sequence_with_a_spawn_key(seed, words, repetition, channel):
    """As docs say it, however the words are handed over."""
    sequence = np.random.SeedSequence(seed, spawn_key=(*words, repetition, channel))
    expected = np.random.Generator(np.random.PCG64(sequence))
    drawn = generator(seed, words, repetition, channel).standard_normal(3)
    assert drawn.tolist() == expected.standard_normal(3).tolist()


@given(st.integers(1, 3), st.integers(1, 300), st.integers(0, 2**32 - 1))
def test_rms_is_the_root_of_the_mean_over_steps(channels, steps, seed):
    z = np.random.default_rng(seed).standard_normal((steps, channels)) * 1e100
    run = SimpleNamespace(run=SimpleNamespace(z=z, steps=steps))
    assert STUDY_MEASURES["rms"](run) == np.sqrt(np.mean(np.sum(z**2, axis=1)))


def test_a_perturbation_leaves_the_first_repetition_alone():
    base = with_value(studies.BASE, "run.perturbation", 1e-3)
    cells = Cells(studies.study(base={**base, "signals": {"w": {"step": 1.0}}}, axes=[]))
    first, second = (cells.cell({}).w(repetition) for repetition in (0, 1))
    assert (first == 1.0).all() and 0 < np.abs(second - 1).max() < 0.01


FILE = """
signals.w = { white_noise = 1 }
target.model = "fir"
controller = { n_c = 2, R_theta = 1 }
run.steps = 50
[plant]
problem = "standard"
G = "1/(q - 0.9)"
[study]
"""
R = "axes.R_theta.sets = 'controller.R_theta'\naxes.R_theta."


@pytest.mark.parametrize(
    ("study", "words"),
    [
        ("repetitions = 0", r"\[study\] repetitions = 0 must be at least 1"),
        ("repetition = 2", "unknown key 'repetition' in \\[study\\]. Did you mean 'repetitions'"),
        ("keep = [{ measure = 'rmss' }]", "'rmss' must be one of.*Did you mean 'rms'"),
        ("keep = [{ measure = 'rms', strat = 3 }]", "unknown key 'strat'.*Did you mean 'start'"),
        ("keep = [{ measure = 'rms' }, { measure = 'rms' }]", "two columns are called 'rms'"),
        ("keep = [{ measure = 'rms', name = 'run' }]", "a column cannot be called 'run'"),
        ("axes.a.values = [1]", r"\[study.axes.a\] needs the key 'sets'"),
        ("axes.a = { sets = 'controller.R_theta' }", "does not say which values it takes"),
        (R + "values = []", "a list of values, not an empty one"),
        (R + "values = [1, 1.0]", "has the value 1.0 twice"),
        (R + "values = 3", "must be a list of values"),
        (R + "values = [1]\naxes.R_theta.range = [0, 3]", "has values and range"),
        (R + "range = [3, 0]", "its range from 3 to 0 is empty"),
        (R + "range = [0, 2.5]", "in integers"),
        (R + "range = [0, 1000000000]", "1000000001 values; at most 1000000"),
        (R + "grid = [0, 1]", "has grid and needs points too"),
        (R + "decades = [0, 1]\naxes.R_theta.points = 1", "points = 1 must be at least 2"),
        (R + "values = [1]\naxes.R_theta.draws = 3", "has draws, which values does not take"),
        (R + "log_uniform = [0, 1]\naxes.R_theta.draws = 3", "needs positive numbers"),
        (R + "normal = [0, 0]\naxes.R_theta.draws = 3", "standard deviation 0.0 must be positive"),
        ("axes.R_theta = { sets = 'controler.R_theta', values = [1] }",
         "'controler.R_theta' leads nowhere.*Did you mean 'controller'"),
        ("axes.R_theta = { sets = 'plant.changes.0.gain', values = [1] }", "leads nowhere"),
        ("axes.seed = { sets = 'run.seed', values = [1] }", "seed of \\[run\\] has no place"),
        ("axes.a-b = { sets = 'run.steps', values = [1] }", "an axis cannot be called 'a-b'"),
        ("axes.a = { sets = 'run.steps', values = [1] }\n"
         "axes.b = { sets = 'run.steps', values = [1] }", "two axes' paths are called"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_when_it_is_read(tmp_path, study, words):
    file = tmp_path / "case.toml"
    file.write_text(FILE + study)
    with pytest.raises(InputError, match=words) as caught:
        load_study(file)
    assert str(caught.value).startswith(str(file))


@pytest.mark.parametrize(
    ("study", "words"),
    [
        (R + "values = [1, -1]", "the axis 'R_theta' at -1: .*R_theta"),
        (R + "values = [1, 'much']", "the axis 'R_theta' at 'much'"),
        ("axes.a = { sets = 'controller.R_tehta', values = [1] }",
         "unknown key 'R_tehta' in \\[controller\\]. Did you mean 'R_theta'"),
        ("axes.a = { sets = 'plant.G', values = ['1/(q - 2)', '1/(q - 0.9) +'] }", "the axis 'a'"),
        ("repetitions = 1000000000", "1000000000 runs.*must be requested.*--yes"),
    ],
)  # fmt: skip
def test_a_value_that_makes_no_run_is_refused_before_anything_runs(tmp_path, study, words):
    file, store = tmp_path / "case.toml", tmp_path / "store"
    file.write_text(FILE + study)
    with pytest.raises(CompensatorError, match=words):
        run_study(load_study(file), store, workers=0)
    assert not store.exists()


def test_a_file_that_is_no_study_says_so(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(FILE.replace("[study]", ""))
    with pytest.raises(InputError, match=r"the table \[study\].*is missing"):
        load_study(file)


def test_functions_must_be_found_by_workers():
    with pytest.raises(InputError, match="at the top of a module"):
        Study(lambda rng: None, [], [])
    with pytest.raises(InputError, match=r"the measure 'deadly': .*argument"):
        Metric(studies.deadly, arguments={"much": 1})


def test_keywords_in_the_wrong_place_are_told_the_right_one():
    with pytest.raises(InputError, match=r"as arguments=\{'start': 200\}") as message:
        Metric("rms", start=200)
    assert "not start" in str(message.value)
    assert Metric("rms", arguments={"start": 200}).arguments == {"start": 200}
    with pytest.raises(InputError, match=r"not kept\. Did you mean 'keep'\?"):
        Study(studies.BASE, [], kept=[Metric("rms")])
    with pytest.raises(InputError, match="Did you mean 'repetitions'"):
        Study(studies.BASE, [], [Metric("rms")], repetition=3)
    assert Study(studies.BASE, []) == Study(studies.BASE, [], [])


@pytest.mark.costly
def test_the_schema_has_what_the_reader_reads():

    table = {
        **studies.BASE,
        "study": {
            "repetitions": 2,
            "keep": [{"measure": "rms", "start": 3, "name": "late"}],
            "axes": {
                "R_theta": {"sets": "controller.R_theta", "decades": [-2, 2], "points": 3},
                "steps": {"sets": "run.steps", "values": [30, 40]},
            },
        },
    }
    assert study_of(table, "case.toml").runs == 12
    jsonschema.validate(table, study_schema())
    table["study"]["repetition"] = 2
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(table, study_schema())


SHIPPED = sorted(Path("examples/studies").glob("*.toml"))


def always(path):
    """The study of the README runs always, the others with --long."""
    return path if path.stem == "gain_change" else pytest.param(path, marks=pytest.mark.slow)


@pytest.mark.costly
@pytest.mark.parametrize("path", [always(path) for path in SHIPPED], ids=lambda path: path.stem)
def test_a_shipped_study_runs(path, tmp_path):
    """Its first and its last cell, one run of each; the whole is run by hand."""
    jsonschema.validate(tomllib.loads(path.read_text()), study_schema())
    study = load_study(path)
    ends = [Axis(a.name, [a.values[0], a.values[-1]], sets=a.sets) for a in study.axes[:1]]
    rest = [Axis(a.name, a.values[:1], sets=a.sets) for a in study.axes[1:]]
    small = Study(study.base, [*ends, *rest], study.keep, seed=study.seed, file=study.file)
    run_study(small, tmp_path / "store", workers=0)
    table = read_table(tmp_path / "store")
    assert len(table) == 2 and not any(table["failure"])
    assert len(SHIPPED) >= 4


def test_faster_measures_agree_with_those_of_claims():
    """Margins with python-control; the float64 assignment of poles with the certified one."""
    import control

    study = studies.study(base={**studies.BASE, "run": {"steps": 2000}}, axes=[])
    r = run_in_full(Cells(study), {}, 3)
    quick, exact = (STUDY_MEASURES["worst_pole_distance"](r, exact=e) for e in (False, True))
    assert quick == pytest.approx(exact, rel=1e-6)
    plant = control.tf([1, -0.5], np.polymul([1, -0.9], [1, -1.1]), True)
    c = r.run.compensator
    L = -plant * control.tf(c.numerator, c.denominator, True)
    gain, phase, *_ = control.stability_margins(L, returnall=True)
    assert STUDY_MEASURES["spectral_radius"](r) < 1
    above = min((g for g in gain if g > 1), default=np.inf)
    assert STUDY_MEASURES["gain_margin"](r) == pytest.approx(above, rel=1e-4)
    least = min(min(abs(p), 360 - abs(p)) for p in phase)
    assert STUDY_MEASURES["phase_margin"](r) == pytest.approx(least, rel=1e-4)
    assert 0 < STUDY_MEASURES["disk_margin"](r) < 2 and STUDY_MEASURES["delay_margin"](r) > 0


@pytest.mark.parametrize("name", ONCE_FOR_A_CELL)
@pytest.mark.parametrize("arguments", [{}, {"direct": False}, {"noise": {"w": 0.25}}])
def test_what_is_found_once_for_a_cell_is_the_measure(name, arguments):
    """With every argument that the measure has, and again from what is remembered."""
    study = studies.study(base={**studies.BASE, "run": {"steps": 500}}, axes=[])
    cells = Cells(study)
    cell, run = cells.cell({}), run_in_full(cells, {}, 1)
    expected = STUDY_MEASURES[name](run, **arguments)
    assert [ONCE_FOR_A_CELL[name](cell, run, **arguments) for _ in range(2)] == [expected] * 2
