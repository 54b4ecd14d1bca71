"""Theta and D_f fitted together: the batch minimiser as oracle, limits, refusals, the trade-off."""

import numpy as np
import pytest
import scipy.signal

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    Controller,
    ControllerSettings,
    JointUD,
    SimulationCase,
    TargetModel,
    fir_target,
    h2_cost,
    iir,
    joint_null_dimension,
    load_run,
    lqg_controller,
    simulate,
    simulate_many,
    standard_plant,
)
from rcac_numeric.reports._loop import fitted_section

PLANT = standard_plant("(q**2 - 1.52*q + 0.9025)/((q - 0.85)*(q**2 - 1.8*q + 1))")  # (6.1)


def settings(update, n_c=15, plant=PLANT, **more):
    return ControllerSettings(
        structure=iir(n_c=n_c), target=fir_target(plant), update=update, **more
    )


def noise(seed, steps, std=0.01):
    return std * np.random.default_rng(seed).standard_normal((steps, 1))


def outcome(update, seed, steps=100_000, n_c=15):
    """J over that of LQG, and the modulus of the largest controller pole."""
    chosen = settings(update, n_c)
    run = simulate(PLANT, chosen, noise(seed, steps), stride=steps)
    c = chosen.compensator_of(run.theta_final)
    return float(h2_cost(PLANT, c)) / lqg_controller(PLANT).cost.value, np.abs(c.poles()).max()


@pytest.mark.parametrize("n_d", [1, 2, 3])
@pytest.mark.parametrize("steps", [30, 300])
def test_the_recursion_is_the_batch_minimiser(steps, n_d):
    """(theta, d) by one dense least squares problem on the recorded u and z."""
    n_c, rho, R = 3, 0.7, 0.05
    plant = standard_plant("(q - 1.4)/(q**2 - 0.9*q + 0.3)")
    update = JointUD(R, n_d=n_d, rho=rho)
    chosen = settings(update, n_c, plant)
    run = simulate(plant, chosen, noise(3, steps, 1.0))
    u, z, k_w = run.u[:, 0], run.z[:, 0], chosen.k_w
    H = chosen.target.numerator[:, 0, 0]

    def delayed(x, i):
        return np.concatenate([np.zeros(i), x[: len(x) - i]])

    u_f, z_f = (scipy.signal.lfilter(H, [1.0], x) for x in (u, z))
    columns = [delayed(u_f, i) for i in range(1, n_c + 1)]
    columns += [delayed(z_f, i) for i in range(1, n_c + 1)]
    columns += [delayed(z, i) for i in range(1, n_d + 1)]
    rows, right = [np.eye(2 * n_c + n_d) * np.sqrt(R)], [np.zeros(2 * n_c + n_d)]
    power = 0.0
    for count, k in enumerate(range(k_w, steps), 1):
        power += z[k] ** 2
        penalty = np.zeros(2 * n_c + n_d)
        penalty[2 * n_c + count % n_d] = np.sqrt(n_d * rho * power / count)
        rows += [np.array([[c[k] for c in columns]]), penalty[None]]
        right += [np.array([u_f[k] - z[k]]), np.zeros(1)]
    both, *_ = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)
    order = [(t.signal, t.delay) for t in chosen.structure.taps]
    place = {("u", i): i - 1 for i in range(1, n_c + 1)}
    place |= {("y", i): n_c + i - 1 for i in range(1, n_c + 1)}
    expected = [both[place[key]] for key in order]
    assert np.allclose(run.theta_final, expected, rtol=1e-7, atol=1e-9)
    assert run.D_f[0] == 1 and np.allclose(run.D_f[1:], both[2 * n_c :], rtol=1e-7, atol=1e-9)
    controller = Controller(chosen)
    assert controller.D_f.tolist() == [1.0, *[0.0] * n_d]
    for y, z_k in zip(run.y, run.z, strict=True):
        controller.step(y, z_k)
    assert np.array_equal(controller.D_f, run.D_f)
    again = Controller(chosen)
    again.restore(controller.state)
    assert np.array_equal(again.D_f, run.D_f)


def test_who_fits_no_denominator_has_none(tmp_path):
    run = simulate(PLANT, settings(UD(0.1)), noise(0, 50))
    assert run.D_f is None and Controller(run.settings).D_f is None
    empty = simulate(PLANT, settings(JointUD(0.1, n_d=0, rho=1.0)), noise(0, 50))
    assert empty.D_f.tolist() == [1.0]
    (many,) = simulate_many([SimulationCase(PLANT, run.settings, run.w)], lanes=True)
    assert many.D_f is None
    joint = simulate(PLANT, settings(JointUD(0.1, n_d=2, rho=1.0)), noise(0, 50))
    joint.save(tmp_path / "run.npz")
    assert load_run(tmp_path / "run.npz") == joint


def test_the_report_says_d_f():
    """The coefficients and their largest root, in the sheet and in the record."""
    section = fitted_section(np.array([1.0, -0.7, 0.1]))
    assert section.record["D_f"] == [1.0, -0.7, 0.1]
    assert abs(section.record["D_f_spectral_radius"] - 0.5) < 1e-12
    (fact,) = section.blocks
    assert fact.value == "1 -0.7 q^-1 +0.1 q^-2; spectral radius 0.5"
    assert not fitted_section(None).blocks


def test_no_coefficients_is_the_standard_update_bit_for_bit():
    w = noise(0, 2000)
    runs = [simulate(PLANT, settings(u), w) for u in (UD(0.1), JointUD(0.1, n_d=0, rho=1.0))]
    assert (runs[0].theta == runs[1].theta).all()


def test_a_cut_run_goes_on_bit_for_bit():
    w, chosen = noise(0, 600), settings(JointUD(0.1, n_d=3, rho=2.0))
    whole, half = simulate(PLANT, chosen, w), simulate(PLANT, chosen, w[:301])
    rest = simulate(PLANT, chosen, w[301:], start=half.state)
    assert (rest.theta_final == whole.theta_final).all()


def test_example_6_2_has_a_stable_controller_without_reflection(request):
    """rho = 2: poles below 0.98 and at most 3 % above LQG, which is itself unstable here."""
    seeds = 8 if request.config.getoption("--long") else 3
    for seed in range(seeds):
        cost, pole = outcome(JointUD(0.1, n_d=2, rho=2.0), seed)
        assert cost <= 1.03 and pole < 0.98
    standard, pole = outcome(UD(0.1), 0)
    near, same = outcome(JointUD(0.1, n_d=2, rho=100.0), 0)
    assert abs(near / standard - 1) < 0.01 and min(pole, same) > 1.05


def test_the_less_rho_the_more_it_costs():
    costs = [outcome(JointUD(0.1, n_d=2, rho=rho), 0, 20_000)[0] for rho in (10.0, 3.0, 1.0, 0.3)]
    assert costs == sorted(costs) and costs[-1] > 1.2


@pytest.mark.parametrize("n_c", [2, 8])
@pytest.mark.parametrize("n_d", [1, 2, 6])
@pytest.mark.parametrize("N_f", [[0, 1.0], [0, 1.0, -1.1], [0, 0, 2.0, 1.0, 0.5]])
def test_the_null_space_on_random_data(n_c, n_d, N_f):
    """The rank of the regressor of unrelated random u and y is that lower."""
    rng = np.random.default_rng(0)
    u, y = rng.standard_normal((2, 400))
    filtered = [scipy.signal.lfilter(N_f, [1.0], x) for x in (u, y)]
    columns = [np.roll(x, i) for x in filtered for i in range(1, n_c + 1)]
    columns += [np.roll(y, i) for i in range(1, n_d + 1)]
    rows = np.array(columns).T[30:]
    lost = rows.shape[1] - np.linalg.matrix_rank(rows, tol=1e-8)
    assert joint_null_dimension(TargetModel(N_f), n_c, n_d) == lost


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: settings(JointUD(0.1, n_d=6, rho=0.0)), "does not change along 5 directions"),
        (lambda: JointUD(0.1, n_d=2, rho=-1.0), "must be positive"),
        (lambda: JointUD(0.1, n_d=2, rho=np.inf), "rho"),
        (lambda: JointUD(0.1, n_d=-1, rho=1.0), "n_d"),
        (lambda: settings(JointUD(0.1, n_d=2, rho=1.0), R_u=0.1), "R_u belongs"),
        (
            lambda: ControllerSettings(
                structure=iir(n_c=2),
                target=TargetModel([0, 1.0], [1, -0.5]),
                update=JointUD(0.1, n_d=1, rho=1.0),
            ),
            "FIR",
        ),
        (
            lambda: ControllerSettings(
                structure=iir(n_c=2, l_u=2, l_y=2),
                target=TargetModel(np.array([np.zeros((2, 2)), np.eye(2)])),
                update=JointUD(0.1, n_d=1, rho=1.0),
            ),
            "scalar z",
        ),
    ],
)
def test_refusals(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_running_joint_fit_is_not_changed():
    controller = Controller(settings(JointUD(0.1, n_d=2, rho=2.0), n_c=3))
    controller.step(0.1, 0.1)
    before = controller.state
    for change in (
        lambda: controller.set_weights(R_u=1.0),
        lambda: controller.set_target(TargetModel([0, 1.0], [1, -0.5])),
        lambda: controller.set_lambda(0.9),
    ):
        with pytest.raises(InputError, match="during a run"):
            change()
    assert controller.state == before
