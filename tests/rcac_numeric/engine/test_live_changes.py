"""What is set while a controller runs: against the text's formulas, against cuts, and refused."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.signal import lfilter

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import DivergedError, FunctionFailedError, ImproperError
from rcac_numeric.engine._changes import nmp_zero_count
from tests.support import textbook
from tests.support.engine_cases import cases
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes, targets

PLANT = rn.standard_plant("(q - 1.2)/((q - 0.5)*(q - 0.7))")
FIR, OTHER = rn.TargetModel([0, 1, -1.2]), rn.TargetModel([0, 0.9, -0.4])
FILTER = rn.TargetModel([0, 1.0, -1.2], [1, -0.5, 0.1])


def settings_of(**changes):
    chosen = {"structure": rn.iir(n_c=3), "target": FIR, "update": rn.UD(R_theta=0.1)}
    return rn.ControllerSettings(**chosen | changes)


def steps(settings, count, seed=0):
    s, rng = settings.structure, np.random.default_rng(seed)
    l_z = settings.target.l_z
    return [
        (
            rng.standard_normal(s.l_y),
            rng.standard_normal(l_z),
            rng.standard_normal(s.l_r) if s.l_r else None,
        )
        for _ in range(count)
    ]


def run(controller, data):
    return np.array([controller.step(*one) for one in data])


class ChangedBook(textbook.Book):
    """The text's controller with its target replaced: all of its past filtered by the new one."""

    own = None

    def latest(self, first, changes):
        model = isinstance(first, rn.TargetModel) and self.own is not None
        return self.own if model else super().latest(first, changes)

    def set_target(self, target):
        self.own = target
        done, self.k = self.k, 0
        old, self.Phi_f, self.u_f = len(self.Phi), [], []
        for self.k in range(old):
            wide = np.zeros((target.l_z, self.theta.size))
            self.Phi_f.append(self.filtered(self.Phi.__getitem__, self.Phi_f) + wide)
            u_f = self.filtered(lambda i: self.s("u", i), self.u_f)
            self.u_f.append(u_f + np.zeros(target.l_z))
        self.k = done


def compared(settings, regressor, data, changes, covariance):
    """theta of the kernel and of the text, after targets told at the steps of `told`."""
    controller, book = rn.Controller(settings), ChangedBook(settings, regressor)
    for k, (y, z, r) in enumerate(data):
        if k in changes:
            done = controller.set_target(changes[k], covariance)
            book.set_target(changes[k])
            if done.covariance == "reset":
                book.reset()
        u = controller.step(y, z, r)
        book.observe(y, r)
        if settings.form == "filter":
            book.adapt(z)
        book.apply(u)  # the signals are the kernel's, so that only theta is compared
        if settings.form != "filter":
            book.adapt(z)
        book.finish()
    return controller.theta, book.theta


@given(st.data(), sizes, sizes, sizes, st.integers(0, 1), st.sampled_from(["keep", "reset"]), seeds)
def test_the_filter_is_as_if_the_target_had_always_been_there(
    data, l_u, l_y, l_z, l_r, option, seed
):
    form = data.draw(st.sampled_from(["predictor", "filter"]))
    update = data.draw(st.sampled_from([rn.UD, rn.Covariance]))
    fixed = {"form": form, "strictly_proper": form == "filter", "update": update, "k_filter": 0}
    settings, regressor = data.draw(cases(l_u, l_y, l_z, l_r, **fixed))
    message = {}
    for k in data.draw(st.lists(st.integers(0, 24), max_size=2)):
        new = data.draw(targets(l_z, l_u))
        N, D = np.array(new.numerator), np.array(new.denominator)
        message[k] = rn.TargetModel(np.concatenate([0 * N[:1], N]), D) if form == "filter" else new
    result, book = compared(settings, regressor, steps(settings, 25, seed), message, option)
    assert np.allclose(result, book, rtol=1e-7, atol=1e-7 * (1 + np.abs(book).max()))


@pytest.mark.parametrize("update", [rn.UD, rn.Covariance])
@pytest.mark.parametrize("target", [OTHER, FILTER])
def test_a_replay_is_the_batch_of_the_remembered_steps(update, target):
    """theta minimises their cost and |theta - theta(k)|^2 weighted by R_theta, by least squares."""
    settings = settings_of(update=update(R_theta=0.7))
    controller, data = rn.Controller(settings), steps(settings, 260)
    u = run(controller, data)[:, 0]
    theta = controller.theta
    controller.set_target(target, "replay")
    y, z = (np.array([row[i][0] for row in data]) for i in (0, 1))
    oldest = 260 - (3 + 200 + 2 + 1)  # n_c, the rows, n_f of the settings, and now
    u_f, y_f = (
        np.r_[np.zeros(oldest), lfilter(target.numerator.ravel(), target.denominator.ravel(), one)]
        for one in (u[oldest:], y[oldest:])
    )
    rows = [[*u_f[k - 3 : k][::-1], *y_f[k - 3 : k][::-1]] for k in range(60, 260)]
    A = np.vstack([rows, np.sqrt(0.7) * np.eye(6)])
    b = np.concatenate([u_f[60:] - z[60:], np.sqrt(0.7) * theta])
    assert np.allclose(controller.theta, np.linalg.lstsq(A, b, rcond=None)[0], rtol=1e-8, atol=1e-8)
    assert np.allclose(controller.P, np.linalg.inv(A.T @ A), rtol=1e-7, atol=1e-10)


def test_blend_inflates_the_factors_by_what_was_lost():
    for update in (rn.UD, rn.Covariance):
        settings = settings_of(update=update(R_theta=0.1), target=OTHER)
        controller = rn.Controller(settings)
        run(controller, steps(settings, 40))
        before = controller.P
        applied = controller.set_target(rn.TargetModel([0, 0.9, -0.3]))
        assert applied.covariance == "blend" and 0 < applied.distance < 0.5
        d, U = factors(before)
        grown = np.maximum(d, np.minimum(d / (1 - applied.distance), 1 / 0.1))
        assert (grown > d).any()
        assert np.allclose(controller.P, U @ np.diag(grown) @ U.T, rtol=1e-9)


def factors(P):
    """d and the unit upper U of P = U diag(d) U', by Cholesky from the last row on."""
    L = np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]
    return np.diag(L) ** 2, L / np.diag(L)


def test_the_same_target_changes_nothing():
    for target in (FIR, FILTER):
        settings = settings_of(target=target)
        one, other, data = rn.Controller(settings), rn.Controller(settings), steps(settings, 90)
        run(one, data[:50]), run(other, data[:50])
        assert one.set_target(rn.TargetModel(target.numerator, target.denominator)).distance == 0
        assert np.array_equal(run(one, data[50:]), run(other, data[50:]))


@given(st.integers(1, 59), st.sampled_from(["keep", "reset", "blend", "replay"]), st.booleans())
def test_a_run_cut_across_changes_is_the_run(cut, covariance, window):
    """Also where the order grows, and back, and where weights and lambda were set."""
    longer = rn.TargetModel([0, 0.8, -1.1, 0.2, 0.1, 0.05])
    changes = {
        10: rn.ControllerChange(longer, covariance=covariance),
        25: rn.ControllerChange(FILTER, covariance=covariance, lambda_=0.97),
        40: rn.ControllerChange(OTHER, R_z=2.0, R_u=rn.SignalWeight(0.1)),
    }
    update = rn.SlidingWindow(0.5, window=7) if window else rn.UD(R_theta=0.1)
    settings, w = settings_of(update=update), noise(3, 60, 1)
    hook = {"on_step": lambda run: changes.get(run.first_step + run.steps), "every": 5}
    whole = rn.simulate(PLANT, settings, w, divergence_limit=1e9, **hook)
    first = rn.simulate(PLANT, settings, w[:cut], divergence_limit=1e9, **hook)
    rest = rn.simulate(PLANT, settings, w[cut:], start=first.state, divergence_limit=1e9, **hook)
    assert whole.outcome == "completed"
    assert np.array_equal(np.concatenate([first.u, rest.u]), whole.u)
    assert rest.state.values.tobytes() == whole.state.values.tobytes()
    # A change before step `cut` itself belongs to the run that goes on.
    assert first.changes + rest.changes == whole.changes
    assert [applied.k for applied in whole.changes] == [10, 25, 40]


def test_a_run_in_lanes_can_be_changed_when_it_goes_on():
    """The lanes keep what a change needs: what follows is what follows the ordinary run."""
    settings, w = settings_of(), noise(1, 500, 1)
    case = rn.SimulationCase(PLANT, settings, w[:450])
    (lane,), plain = rn.simulate_many([case] * 1, lanes=True), rn.simulate(PLANT, settings, w[:450])
    hook = {"on_step": lambda run: rn.ControllerChange(FILTER, covariance="replay"), "every": 450}
    ends = [rn.simulate(PLANT, settings, w[450:], start=r.state, **hook) for r in (lane, plain)]
    assert len(ends[0].changes) == 1
    assert np.allclose(ends[0].z, ends[1].z, rtol=1e-6, atol=1e-9)


def test_set_weights_and_lambda_are_those_of_the_settings():
    """From step 0 on they are the controller that was made with them."""
    R_u = rn.SignalWeight(0.3, 0.1)
    settings = settings_of(R_z=2.0, R_u=R_u, update=rn.UD(R_theta=0.1, lambda_=0.95))
    one, other, data = rn.Controller(settings), rn.Controller(settings_of()), steps(settings, 60)
    other.set_weights(R_z=2.0, R_u=R_u)
    other.set_lambda(0.95)
    assert np.array_equal(run(one, data), run(other, data))


def test_a_changed_controller_restores_and_pickles(tmp_path):
    controller, data = rn.Controller(settings_of()), steps(settings_of(), 80)
    run(controller, data[:30])
    early = controller.state
    controller.set_target(rn.TargetModel([0, 1, 0.3, 0.2, 0.1]), "keep")
    controller.set_weights(R_u=0.2)
    run(controller, data[30:50])
    late = controller.state
    going_on = run(controller, data[50:])
    controller.restore(early)
    assert controller.target == FIR  # what was set later is gone
    other = rn.Controller(settings_of())
    other.restore(late)
    assert np.array_equal(run(other, data[50:]), going_on)
    assert other.target.n_f == 4


@pytest.mark.parametrize(
    ("target", "error", "words"),
    [
        (rn.TargetModel(np.ones((2, 1, 2))), InputError, "1 x 2"),
        (rn.TargetModel(np.ones((2, 2, 1))), InputError, "2 x 1"),
        (rn.TargetModel(np.eye(1, 301).ravel() + 1), InputError, "n_f = 300"),
        ("1/q", InputError, "target"),
        (rn.TargetModel([1.0, 0.5]), ImproperError, "strictly"),
    ],
)
def test_what_does_not_fit_is_refused_and_nothing_is_applied(target, error, words):
    form = "filter" if error is ImproperError else "predictor"
    controller, data = rn.Controller(settings_of(form=form)), steps(settings_of(), 30)
    run(controller, data)
    before = controller.state
    with pytest.raises(error, match=words):
        controller.set_target(target)
    with pytest.raises(InputError):  # the last part does not fit: none is applied
        controller.change(rn.ControllerChange(OTHER, lambda_=0.9, R_z=np.eye(2)))
    with pytest.raises(InputError, match="function"):
        controller.set_weights(R_z=lambda k, y, z, u: 1.0)
    with pytest.raises(InputError, match="covariance"):
        controller.set_target(OTHER, "forget")
    assert controller.state.values.tobytes() == before.values.tobytes()


@given(st.floats(0, 1, exclude_max=True), st.floats(-9, 9))
@example(0.0, 5.0)
def test_after_a_takeover_the_difference_fades_by_powers(fade, last):
    """A frozen FIR controller reads no past u, so that its twin makes the same requests."""
    settings = settings_of(structure=rn.fir(3), theta_0=[0.5, -0.2, 0.1])
    controller, twin, data = rn.Controller(settings), rn.Controller(settings), steps(settings, 9)
    for one in (controller, twin):
        one.freeze()
        run(one, data[:4])
    controller.take_over(last, fade=fade)
    requests = run(twin, data[4:])[:, 0]
    expected = requests + (last - requests[0]) * fade ** np.arange(5)
    assert run(controller, data[4:])[:, 0] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_a_takeover_that_does_not_fade_is_refused():
    for fade in (1, 1.0, -0.1, np.nan, True):
        with pytest.raises(InputError, match="fade"):
            rn.Controller(settings_of()).take_over(0.0, fade=fade)


def test_rules_that_set_lambda_are_not_overruled():
    for update in (
        rn.UD(1.0, lambda_=rn.VariableRateForgetting(2, 9, 0.5)),
        rn.UD(1.0, process_noise=0.1),
        rn.Gradient(0.1),
    ):
        with pytest.raises(InputError):
            rn.Controller(settings_of(update=update)).set_lambda(0.9)
    controller = rn.Controller(settings_of(update=rn.Gradient(0.1)))
    assert controller.set_target(OTHER).covariance == "keep"
    with pytest.raises(InputError, match="replay"):
        controller.set_target(OTHER, "replay")


@pytest.mark.parametrize("every", [1, 2, 7])
@pytest.mark.parametrize("begun", [0, 1, 4])
def test_a_hook_is_called_before_every_multiple_but_step_0(every, begun):
    w, calls = noise(0, 20, 1), []
    start = rn.simulate(PLANT, settings_of(), w[:begun]).state if begun else None
    hook = {"on_step": lambda run: calls.append(run.first_step + run.steps), "every": every}
    rn.simulate(PLANT, settings_of(), w[begun:], start=start, **hook)
    assert calls == [k for k in range(begun, 20) if k and k % every == 0]


def test_hooks_that_fail_are_named_and_the_run_so_far_is_kept():
    w = noise(0, 50, 1)
    for hook in (
        lambda run: 1 / 0,
        lambda run: "1/q",
        lambda run: rn.ControllerChange(R_z=np.eye(3)),
    ):
        with pytest.raises(FunctionFailedError, match="step 20") as caught:
            rn.simulate(PLANT, settings_of(), w, on_step=hook, every=20)
        assert caught.value.run.steps == 20
    both = rn.Decentralized([settings_of()])
    for arguments in ({"on_step": 3}, {"on_step": len, "every": 0}):
        with pytest.raises(InputError):
            rn.simulate(PLANT, settings_of(), w, **arguments)
    with pytest.raises(InputError, match="one adaptive"):
        rn.simulate(PLANT, both, w, on_step=lambda run: None)


def test_a_changed_run_has_no_twin():
    hook = {"on_step": lambda run: rn.ControllerChange(OTHER), "every": 25}
    with pytest.raises(InputError, match="changed"):
        rn.frozen_twin(rn.simulate(PLANT, settings_of(), noise(0, 50, 1), **hook), 10)


def test_an_overflow_in_a_replay_leaves_the_controller():
    settings = settings_of(update=rn.UD(R_theta=1e-300))
    controller = rn.Controller(settings)
    for _ in range(30):
        controller.step(1.0, 1.0)
    before = controller.state
    with pytest.raises(DivergedError):
        controller.set_target(rn.TargetModel([0, 1e308, -1e308]), "replay")
    assert controller.state.values.tobytes() == before.values.tobytes()


def test_strictness_follows_the_target():
    controller, data = rn.Controller(settings_of()), steps(settings_of(), 30)
    run(controller, data)
    controller.set_target(rn.TargetModel([1.0, 0.5]))
    with pytest.raises(InputError, match="strictly"):
        controller.step(*data[0], u_applied=0.0)
    controller.set_target(OTHER)
    controller.step(*data[0], u_applied=0.0)


@pytest.mark.parametrize(
    ("target", "count"),
    [
        (rn.TargetModel([0, 1, -1.5]), 1),
        (rn.TargetModel([0, 2, -1, 3]), 2),  # 2 q^2 - q + 3: modulus 1.22
        (rn.TargetModel([0, 1]), 0),
        (rn.TargetModel(np.array([np.zeros((2, 2)), np.eye(2), np.diag([-1.5, -0.5])])), 1),
        (rn.TargetModel(np.ones((2, 2, 1))), None),
    ],
)
def test_nmp_zeros_are_counted(target, count):
    assert nmp_zero_count(target.numerator) == count
