"""From tables to experiments: what each key becomes, and which ones are refused."""

import copy
import tomllib

import numpy as np
import pytest
import scipy.signal

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_experiments import verify
from rcac_experiments.files._builder import build

CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 100},
}


def case(**tables):
    """CASE with the entries of some tables added; None takes a key away."""
    table = copy.deepcopy(CASE)
    for name, entries in tables.items():
        if isinstance(entries, dict):
            joined = {**table.get(name, {}), **entries}
            table[name] = {key: value for key, value in joined.items() if value is not None}
        else:
            table[name] = entries
    return table


def main_run(**tables):
    return build(case(**tables), "case").main_run


def settings(**controller):
    return main_run(controller=controller).settings


@pytest.mark.parametrize(
    ("keys", "structure"),
    [
        ({}, rn.iir(3)),
        ({"k_c": 0}, rn.iir(3, k_c=0)),
        ({"structure": "fir"}, rn.fir(3)),
        ({"structure": "pid", "n_c": None}, rn.pid()),
        ({"structure": "pid", "n_c": None, "terms": "PI"}, rn.pid("PI")),
        ({"structure": "quasi-fir"}, rn.quasi_fir(3)),
        ({"structure": "quasi-fir", "free_poles": 1}, rn.quasi_fir(3, 1)),
        ({"structure": "fir + integrator"}, rn.fir_integrator(3)),
        ({"structure": "fir + integrator", "F": [[2.0]]}, rn.fir_integrator(3, [[2.0]])),
        ({"structure": "feedforward"}, rn.feedforward(3)),
        (
            {"structure": "feedforward", "feedback": "fir", "first_r": 0},
            rn.feedforward(3, feedback="fir", first_r=0),
        ),
    ],
)
def test_structures(keys, structure):
    built = settings(**keys).structure
    assert built.taps == structure.taps and built.derived == structure.derived
    assert (built.n_c, built.l_r) == (structure.n_c, structure.l_r)


def test_a_table_of_taps():
    taps = [["u", 0, 2], ["y", 0, 1], ["derived", 0, 0]]
    derived = [{"now": [1.0, -1.0], "pole": 0.5}]
    structure = settings(structure="taps", taps=taps, derived=derived, n_c=None).structure
    assert structure.taps == (rn.Tap("u", 0, 2), rn.Tap("y", 0, 1), rn.Tap("derived", 0, 0))
    assert structure.derived == (rn.DerivedSignal((1.0, -1.0), (0.0, 0.0), 0.5),)
    assert (structure.l_r, structure.n_c) == (1, 2)
    plain = settings(structure="taps", taps=[["y", 0, 1]], n_c=4).structure
    assert (plain.l_r, plain.n_c) == (0, 4)


def test_updates_and_rules():
    assert settings().update == rn.UD(0.1)
    assert settings(update="covariance").update == rn.Covariance(0.1)
    assert main_run(run={"arithmetic": "covariance"}).settings.update == rn.Covariance(0.1)
    certified = main_run(run={"arithmetic": "reference"})
    assert certified.settings.update == rn.UD(0.1) and certified.reference
    assert settings(update="sliding window", window=50).update == rn.SlidingWindow(0.1, window=50)
    assert settings(update="gradient", step_size=0.01, R_theta=None).update == rn.Gradient(0.01)
    instantaneous = settings(update="instantaneous", form="filter")
    assert (instantaneous.update, instantaneous.form) == (rn.Instantaneous(0.1), "filter")
    assert settings(process_noise=1e-3).update == rn.UD(0.1, process_noise=1e-3)
    rule = {"short": 5, "long": 50, "gain": 0.2}
    forgetting = rn.VariableRateForgetting(5, 50, 0.2)
    assert settings(forgetting=rule).update == rn.UD(0.1, lambda_=forgetting)
    reset = rn.CovarianceReset(at=[50], every=20)
    assert settings(reset={"at": [50], "every": 20}).update == rn.UD(0.1, reset=reset)
    assert settings(freeze=[[20, 30], [60]]).freeze == ((20, 30), (60, None))
    assert settings(reflect_poles=True).reflect_poles
    assert settings(stop_where_unsupported=True).update == rn.UD(0.1, stop_where_unsupported=True)
    changed = settings(**{"lambda": 0.9, "lambda_changes": [[50, 1.0]]})
    assert changed.update == rn.UD(0.1, lambda_=rn.ScheduledForgetting({50: 1.0}, 0.9))
    later = settings(target_changes=[[40, {"model": "filter", "G_f": "-2/q"}]]).target_changes
    assert list(later) == [40] and later[40].numerator.ravel().tolist() == [0, -2]
    weights = settings(R_z={"z_squared": 1, "constant": 2}, R_u={"z_squared": 3})
    assert weights.R_z == rn.SignalWeight(1, 2) and weights.R_u == rn.SignalWeight(3)


def test_a_run_that_names_another_kind_drops_what_that_does_not_read():
    runs = [
        {"name": "a"},
        {"name": "b", "controller": {"structure": "pid"}},
        {"name": "c", "controller": {"update": "gradient", "step_size": 1e-3}},
        {
            "name": "d",
            "controller": {"structure": "lqg"},
            "target": {"model": "filter", "G_f": "-1/q"},
        },
        {"name": "e", "target": {"model": "pole placement", "poles": ["1/2"]}},
    ]  # fmt: skip
    table = case(runs=runs, target={"d_zu": 1, "H": -3})
    built = build(table, "case").runs
    assert built["b"].settings.structure.taps == rn.pid().taps
    assert built["c"].settings.update == rn.Gradient(1e-3)
    assert isinstance(built["d"].settings, rn.FixedController)
    assert built["d"].target.numerator.ravel().tolist() == [0, -1]
    assert built["a"].settings.target.numerator[1] == -3
    assert built["e"].settings.target.numerator[1] == -1, "H is the plant's again"


def test_several_controllers_share_what_they_do_not_say():
    both = [
        {"structure": "fir", "R_theta": 5},
        {"structure": "feedforward", "feedback": "none", "target": {"H": -2}},
    ]
    built = main_run(controllers=both).settings
    assert isinstance(built, rn.Decentralized) and not built.shared_u
    first, second = built.controllers
    assert first.structure.taps == rn.fir(3).taps and first.update == rn.UD(5.0)
    assert second.update == rn.UD(0.1) and second.structure.l_r == 1
    assert (first.target.numerator[1], second.target.numerator[1]) == (-1, -2)
    assert main_run(controller={"shared_u": True}, controllers=both).settings.shared_u


def test_saturation_is_applied():
    run = main_run(saturation={"high": 0.01}).execute().first.run
    assert run.u.max() > 0.01 and run.u_applied.max() == 0.01


def test_plant_changes_go_on_from_each_other():
    changes = [
        {"start": 20, "gain": "5/2"},
        {"start": 40, "delay": 3, "ramp": True},
        {"start": 60, "G": "(q - 1.5)/((q - 0.9)*(q - 0.3))"},
    ]
    plant = main_run(plant={"changes": changes}).plant
    assert isinstance(plant, rn.PlantSchedule)
    first, louder, late, moved = plant.changes
    assert (louder.plant.B == 2.5 * first.plant.B).all() and louder.plant.blocks == plant.blocks
    assert (louder.plant.D_1 == first.plant.D_1).all(), "only the control acts more strongly"
    assert (late.delay, late.ramp, moved.delay, moved.ramp) == (3, True, 3, False)
    assert (late.plant.B == louder.plant.B).all() and (moved.plant.B == louder.plant.B).all()
    assert not np.array_equal(moved.plant.C, first.plant.C)
    at_once = main_run(plant={"changes": [{"start": 0, "delay": 2}]})
    assert [c.delay for c in at_once.plant.changes] == [2]
    assert at_once.settings.target.relative_degree == 3, "the delay at step 0 is known to RCAC"


def test_a_run_may_have_a_plant_of_its_own():
    runs = [
        {"name": "a"},
        {"name": "b", "plant": {"changes": [{"start": 50, "gain": 2}]}},
        {"name": "c", "plant": {"problem": "servo", "A": [[0.5]], "B": [[1]], "C": [[1]]}},
    ]
    built = build(case(runs=runs), "case").runs
    assert built["a"].plant.n == 2 and built["c"].plant.n == 1
    assert [c.start for c in built["b"].plant.changes] == [0, 50]


def test_the_plant_of_the_first_run_is_not_that_of_the_others():
    other = {"problem": "servo", "A": [[0.5]], "B": [[1]], "C": [[1]]}
    built = build(case(runs=[{"name": "a", "plant": other}, {"name": "b"}, {"name": "c"}]), "case")
    alone = main_run().plant
    assert [run.plant.n for run in built.runs.values()] == [1, 2, 2]
    assert built.runs["b"].plant == built.runs["c"].plant == alone


def test_a_changing_plant_is_analysed_as_it_ends():
    """The last plant with its delay as states: the frozen loop repeats the end of the run."""
    table = case(plant={"changes": [{"start": 30, "gain": 1.5, "delay": 2}]})
    repetition = build(table, "case").main_run.execute().first
    plant = repetition.loop.plant
    assert plant.n == 4 and plant.blocks == {"r": 1, "d": 1, "v": 1}
    run, rng = repetition.run, np.random.default_rng(0)
    w = rng.standard_normal((40, 3))
    shifted = main_run(plant={"changes": [{"start": 0, "gain": 1.5, "delay": 2}]}).plant
    fixed = rn.simulate(plant, run.settings, w).z
    assert np.abs(fixed - rn.simulate(shifted, run.settings, w).z).max() < 1e-12
    with pytest.raises(InputError, match="changes during the run"):
        repetition.split  # noqa: B018


def test_the_split_and_the_zeros_of_a_controller_that_reads_the_command():
    repetition = main_run(controller={"structure": "feedforward"}).execute().first
    assert "the command too" in repetition.obstacle
    assert repetition.split.identity_error < 1e-10
    # A zero stops its frequency, and at it only that channel's.
    zero = repetition.zeros["r"][np.abs(repetition.zeros["r"].imag).argmax()]
    loop = repetition.loop
    A, B, C, D = loop.matrices
    value = C[:1] @ np.linalg.solve(zero * np.eye(len(A)) - A, B[:, :1]) + D[:1, :1]
    assert abs(value[0, 0]) < 1e-9
    with pytest.raises(InputError, match="exact comparison does not apply"):
        repetition.comparison  # noqa: B018


def test_zeros_in_float64_are_those_of_the_exact_half():
    repetition = main_run().execute().first
    rounded = repetition.loop.zeros()
    assert rounded.keys() == repetition.zeros.keys() == {"r", "d", "v"}
    for channel, exact in repetition.zeros.items():
        gaps = np.abs(np.asarray(exact)[:, None] - rounded[channel][None, :])
        assert len(exact) == len(rounded[channel])
        assert gaps.min(axis=1).max() < 1e-5  # zeros at 0 are multiple


def test_a_ratio_to_nothing_is_no_defect():
    """A measure that is 0 in the other run: the ratio is infinite or not a number."""
    check = {"measure": "guard_count", "relative_to": "main", "at_most": 1}
    table = case(claims=[{"text": "none", "checks": [check]}])
    (verdict,) = verify(build(table, "case")).verdicts
    assert verdict.verdict == "no answer" and "nan" in verdict.measured


DIVERGING = {"controller": {"R_theta": 1e-6}, "target": {"H": 1}, "run": {"steps": 400}}


@pytest.mark.parametrize(
    ("expected", "tables", "status"),
    [
        ("completed", {}, 0),
        ("diverged", {}, 1),
        ("completed", DIVERGING, 3),
        ("diverged", DIVERGING, 0),
    ],
)
def test_an_expected_divergence_is_no_surprise(expected, tables, status):
    run = {**tables.get("run", {}), "expected": expected}
    verification = verify(build(case(**{**tables, "run": run}), "case"))
    assert verification.exit_status == status
    assert verification.diverged == (["main"] if tables else [])


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"controller": {"terms": "PI"}}, "sets 'terms', which structure = \"iir\" does not read"),
        ({"controller": {"structure": "pid"}}, "sets 'n_c', which structure = \"pid\""),
        ({"controller": {"structure": "pdi"}}, "structure = 'pdi' must be one of"),
        ({"controller": {"structure": "taps", "n_c": None}}, "needs the key 'taps'"),
        ({"controller": {"structure": "taps", "taps": ["u"]}}, "taps: the entry 'u' must be"),
        ({"controller": {"structure": "taps", "taps": [["x", 0, 1]]}}, "'x' is not known"),
        ({"controller": {"n_c": None}}, "needs the key 'n_c'"),
        (
            {"controller": {"structure": "pid", "n_c": None, "terms": 3}},
            "terms = 3 must be a string",
        ),
        (
            {
                "controller": {
                    "structure": "taps",
                    "n_c": None,
                    "taps": [["derived", 0, 1]],
                    "derived": [{"now": [[1, 2]]}],
                }
            },
            "now must be a real number",
        ),
        ({"controller": {"shared_u": True}}, "which only [[controllers]] read"),
        ({"controller": {"reflect_poles": 1}}, "must be true or false"),
        ({"controller": {"freeze": 5}}, "freeze = 5 must be a list"),
        ({"controller": {"freeze": [5]}}, "freeze: the entry 5 must be"),
        ({"controller": {"lambda_changes": [[5]]}}, "must be a pair [step, value]"),
        ({"controller": {"lambda_changes": [[5, 0.9], [5, 1.0]]}}, "has step 5 twice"),
        ({"controller": {"target_changes": [[5, {"model": "fri"}]]}}, "model = 'fri'"),
        ({"controller": {"forgetting": {"short": 5, "long": 9}}}, "needs the key 'gain'"),
        ({"controller": {"forgetting": {"shrt": 5}}}, "Did you mean 'short'"),
        ({"controller": {"reset": {"at": 3}}}, "at = 3 must be a list"),
        ({"controller": {"R_u": {"z": 3}}}, "unknown key 'z' in [controller.R_u]"),
        ({"controller": {"window": 3}}, "sets 'window', which update = \"ud\" does not read"),
        (
            {
                "controller": {"update": "gradient", "step_size": 1, "R_theta": None},
                "run": {"arithmetic": "ud"},
            },
            "contradict each other",
        ),
        ({"run": {"arithmetic": "gradient"}}, "arithmetic = 'gradient' must be one of"),
        (
            {"controller": {"reflect_poles": True}, "run": {"arithmetic": "reference"}},
            "the reference does not know reflect_poles",
        ),
        (
            {"saturation": {"low": -1}, "run": {"arithmetic": "reference"}},
            "the reference runs without saturation",
        ),
        ({"run": {"expected": "unstable"}}, "expected = 'unstable' must be one of"),
        ({"saturation": {}}, "a saturation needs low, high or rate"),
        ({"saturation": {"lo": 1}}, "unknown key 'lo' in [saturation]"),
        ({"saturation": {"low": [1, 2]}}, "low has 2 entries"),
        ({"controllers": {"structure": "fir"}}, "must be an array of tables"),
        ({"controllers": [{"structure": "lqg"}]}, "structure = 'lqg' must be one of"),
        ({"controllers": [{}, {"target": {"poles": []}}]}, "[controllers.target] no. 2 sets"),
        ({"run": {"seed": "x"}, "runs": [{"name": "a", "run": {"seed": 1}}]}, "[run] seed must be"),
        (
            {"runs": [{"name": "a"}, {"name": "b", "run": {"seed": 0.5}}]},
            "[runs.run] of run 'b'",
        ),
        (
            {"runs": [{"name": "b", "controller": {"structure": "pid", "n_c": 4}}]},
            "[controller] of run 'b' sets 'n_c'",
        ),
        ({"runs": [{"name": "a"}, {"name": "b", "controller": {"k_w": 1}}]}, "run 'b': k_w = 1"),
        ({"controllers": [{"shared_u": True}]}, "unknown key 'shared_u' in [controllers]"),
        (
            {"controllers": [{}, {"structure": "fir"}], "saturation": {"high": 1}},
            "Set shared_u = true in [controller]",
        ),
        ({"plant": {"G": None}}, "[plant] needs the key 'G', or instead A, B, C"),
        ({"plant": {"changes": [{"gain": 2}]}}, "needs the key 'start'"),
        ({"plant": {"changes": [{"start": 5, "gian": 2}]}}, "Did you mean 'gain'"),
        ({"plant": {"changes": [{"start": 5, "gain": "g"}]}}, "gain = 'g' must be a real number"),
        ({"plant": {"changes": [{"start": 5, "ramp": True}]}}, "no plant follows"),
        ({"plant": {"changes": [{"start": 5}, {"start": 5}]}}, "does not follow"),
        ({"plant": {"changes": [{"start": 5, "G": "1/(q - 0.5)"}]}}, "give state_map"),
        ({"plant": {"changes": [{"start": 5, "C": [[1, 2]]}]}}, "needs the key 'A'"),
        ({"signals": {"r": {"piecewise": []}}}, "increasing steps are needed"),
        ({"signals": {"r": {"piecewise": [1]}}}, "must be a pair [start, signal]"),
        ({"signals": {"r": {"piecewise": [[5, 1], [5, 2]]}}}, "increasing steps are needed"),
    ],
)
def test_what_is_refused(tables, message):
    with pytest.raises(InputError) as error:
        build(case(**tables), "case")
    assert message in str(error.value) and str(error.value).startswith("case: ")


def test_a_command_needs_a_plant_that_has_one():
    table = case(controller={"structure": "feedforward"})
    table["plant"]["problem"], table["signals"] = "standard", {"w": 1}
    with pytest.raises(InputError, match="this plant's exogenous input has w"):
        build(table, "case")


WITH_SAMPLE_TIME = {
    "plant": {"problem": "standard", "G": "1/(q - 1/2)", "sample_time": 0.1},
    "signals": {"w": {"white_noise": 1}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 1, "R_theta": 1},
    "run": {"steps": 30},
}


@pytest.mark.parametrize("changes", [None, [{"start": 9, "gain": 2, "delay": 1}]])
def test_a_sample_time_goes_with_the_run_and_changes_no_number(changes, tmp_path):
    plant = WITH_SAMPLE_TIME["plant"] | ({} if changes is None else {"changes": changes})
    table = {**WITH_SAMPLE_TIME, "plant": plant}
    run = build(table, "case.toml").main_run.execute().first.run
    run.save(tmp_path / "run.npz")
    for one in (run, rn.load_run(tmp_path / "run.npz")):
        assert one.sample_time == one.compensator.to_control().dt == 0.1
        assert one.compensator_at(20).to_control().dt == 0.1
    without = {key: value for key, value in plant.items() if key != "sample_time"}
    other = build({**table, "plant": without}, "case.toml").main_run.execute().first.run
    assert other.sample_time is None and other.compensator.to_control().dt is True
    np.testing.assert_array_equal(other.theta, run.theta)


@pytest.mark.parametrize("wrong", [0, -1, "a", "1e400", [1.0]])
def test_a_sample_time_is_a_positive_number(wrong):
    plant = {**WITH_SAMPLE_TIME["plant"], "sample_time": wrong}
    with pytest.raises(InputError, match=r"\[plant\] sample_time"):
        build({**WITH_SAMPLE_TIME, "plant": plant}, "case.toml")


def test_a_file_without_target_is_given_the_lines_that_work():
    table = {key: value for key, value in WITH_SAMPLE_TIME.items() if key != "target"}
    with pytest.raises(InputError, match=r"the table \[target\]") as caught:
        build(table, "case.toml")
    lines = str(caught.value).partition("\n\n")[2]
    assert len(lines.splitlines()) == 3
    assert build({**table, **tomllib.loads(lines)}, "case.toml").main_run.steps == 30


@pytest.mark.parametrize("problem", ["standard", "servo"])
def test_a_plant_in_s_is_sampled_with_the_sample_time(problem):
    """As SciPy samples it: the same response to u, at 20 frequencies."""
    plant = {"problem": problem, "G": "(s + 3)/((s + 1)*(s + 1/2))", "sample_time": 0.2}
    built = build({**CASE, "plant": plant, "signals": {}}, "case.toml").main_run.plant
    num, den, _ = scipy.signal.cont2discrete(([1, 3], [1, 1.5, 0.5]), 0.2)
    z = np.exp(1j * np.linspace(0.05, 3.1, 20))
    for point in z:
        response = built.E_1 @ np.linalg.solve(point * np.eye(built.n) - built.A, built.B)
        sign = -1 if problem == "servo" else 1  # z = r - y
        expected = sign * np.polyval(num[0], point) / np.polyval(den, point)
        assert response[0, 0] == pytest.approx(expected, rel=1e-9)
    assert built.sample_time == 0.2
    del plant["sample_time"]
    with pytest.raises(InputError, match=r"is in s, .* Add sample_time"):
        build({**CASE, "plant": plant, "signals": {}}, "case.toml")
