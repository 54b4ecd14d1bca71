"""RCAC from the text, slowly: Phi(k) from histories, G_f on matrices, theta as a batch minimiser.

Nothing here knows the taps, channels and factorisations of the kernel. A `Book` is one
controller: call `observe`, `control`, `apply` and `adapt` once a step (in the filter form adapt
comes before control), and read `theta`. It minimises the accumulated cost by `lstsq` on stacked
square roots of weights; only process noise, which has no such cost, is a Kalman filter.
"""

from collections import defaultdict

import numpy as np

import rcac_numeric as rn


class Signals:
    """u, y, r and z by step; zero before step 0."""

    def __init__(self, **widths):
        self.widths = widths
        self.values = defaultdict(dict)

    def __call__(self, name, k):
        return np.zeros(self.widths[name]) if k < 0 else self.values[name][k]


def iir_regressor(n_c, k_c=1, lags_of_u=None, first_r=None):
    """(2.30); (2.34) without past u, (6.1) with two of them, figures 2.15 and 2.16 with r."""

    def phi(k, s):
        past_u = [s("u", k - i) for i in range(1, (n_c if lags_of_u is None else lags_of_u) + 1)]
        past_y = [] if k_c is None else [s("y", k - i) for i in range(k_c, n_c + 1)]
        past_r = [] if first_r is None else [s("r", k - i) for i in range(first_r, n_c + 1)]
        return np.concatenate(past_u + past_y + past_r)

    return phi


def pid_regressor(terms):
    """(2.58)-(2.62): e(k-1), gamma(k-1) with gamma(k) = gamma(k-1) + e(k-1), e(k-1) - e(k-2)."""

    def phi(k, s):
        gamma = np.zeros(s.widths["y"])  # gamma(0) = 0
        for i in range(1, k):  # up to gamma(k-1)
            gamma = gamma + s("y", i - 1)
        entries = {"P": s("y", k - 1), "I": gamma, "D": s("y", k - 1) - s("y", k - 2)}
        return np.concatenate([entries[term] for term in terms])

    return phi


def integrator_regressor(n_c, F, k_c=1):
    """(6.4)-(6.5): past y and gamma(k) = gamma(k-1) + F y(k)."""

    def phi(k, s):
        gamma = np.zeros(len(F))
        for i in range(k + 1):
            gamma = gamma + F @ s("y", i)
        return np.concatenate([*(s("y", k - i) for i in range(k_c, n_c + 1)), gamma])

    return phi


def table_regressor(taps, derived):
    """A tap table as its docstrings define it, with derived signals run from step 0."""

    def value(tap, k, s):
        if tap.signal != "derived":
            return s(tap.signal, k - tap.delay)[tap.component]
        signal, out = derived[tap.component], 0.0
        inputs = lambda i: np.concatenate([s("y", i), s("r", i)])  # noqa: E731
        for i in range(k - tap.delay + 1):
            out = signal.pole * out + np.dot(signal.now, inputs(i))
            out += np.dot(signal.before, inputs(i - 1))
        return out

    return lambda k, s: np.array([value(tap, k, s) for tap in taps])


def root(weight):
    """A with A'A = weight, for a positive semidefinite weight."""
    values, vectors = np.linalg.eigh(weight)
    return np.sqrt(np.maximum(values, 0))[:, None] * vectors.T


class Book:
    def __init__(self, settings, regressor):
        self.c, self.regressor, self.rule = settings, regressor, settings.update
        s = settings.structure
        self.s = Signals(u=s.l_u, y=s.l_y, r=s.l_r, z=settings.target.l_z)
        self.theta, self.k = settings.theta_0.copy(), 0
        self.Phi, self.Phi_f, self.u_f = [], [], []
        self.stages, self.lambdas = [], []  # since the prior was set
        if not isinstance(self.rule, rn.Gradient):
            self.R_theta = matrix(self.rule.R_theta, self.theta.size)
            self.prior, self.P = (self.R_theta, self.theta), np.linalg.inv(self.R_theta)
        self.last_reset, self.first = -1, settings.k_update
        self.resets = self.reflections = 0
        self.curvatures = [0.0]  # of a gradient's costs: of each step the largest

    def observe(self, y, r=None):
        self.s.values["y"][self.k] = np.array(y)
        self.s.values["r"][self.k] = np.zeros(0) if r is None else np.array(r)

    def control(self):
        if self.k < self.c.k_w:
            return np.zeros(self.c.structure.l_u)
        return self.Phi_now() @ self.theta

    def apply(self, u):
        self.s.values["u"][self.k] = np.array(u)

    def finish(self):
        self.k += 1

    def Phi_now(self):
        return np.kron(self.regressor(self.k, self.s), np.eye(self.c.structure.l_u))

    def latest(self, first, changes):
        return [first, *(value for step, value in sorted(changes.items()) if step <= self.k)][-1]

    def filtered(self, past_in, past_out):
        """G_f of a sequence of matrices up to step k, (2.40); zero inputs before k_filter."""
        target = self.latest(self.c.target, self.c.target_changes)
        N, D, out = target.numerator, target.denominator, 0.0
        for i in range(min(self.k, len(N) - 1) + 1):
            if N[i].any() and self.k - i >= self.c.k_filter:
                out = out + N[i] @ past_in(self.k - i)
            if i > 0:
                out = out - D[i] @ past_out[self.k - i]
        return out

    def adapt(self, z):
        k, c = self.k, self.c
        self.s.values["z"][k] = np.array(z)
        l_z = c.target.l_z
        self.Phi.append(self.Phi_now())
        self.Phi_f.append(
            self.filtered(self.Phi.__getitem__, self.Phi_f) + np.zeros((l_z, self.theta.size))
        )
        self.u_f.append(self.filtered(lambda i: self.s("u", i), self.u_f) + np.zeros(l_z))
        reset = self.rule.reset if isinstance(self.rule, rn.UD | rn.Covariance) else None
        if k in (reset.at if reset else ()):
            self.reset()
        frozen = any(a <= k and (b is None or k < b) for a, b in c.freeze)
        if k < c.k_update or frozen:
            return
        if reset and self.reset_is_due(reset):
            self.last_reset = k
            self.reset()
        R_z, R_u = self.weight(c.R_z), self.weight(c.R_u)
        A, b = root(R_z), root(R_u)  # rows of the cost of this step
        F = self.Phi_f[k]
        rows = np.vstack([A @ F, b @ F])
        goal = np.concatenate([-A @ (z - self.u_f[k]), np.zeros(l_z)])
        self.update(rows, goal)
        if c.reflect_poles:
            self.reflect()

    def weight(self, R):
        k, l_z = self.k, self.c.target.l_z
        z = self.s("z", k)
        if isinstance(R, rn.SignalWeight):
            return (R.constant + R.z_squared * (z @ z)) * np.eye(l_z)
        if not callable(R):
            return R
        u = self.s("u", k - 1 if self.c.form == "filter" else k)
        return R(k, self.s("y", k), z, u) * np.eye(l_z)

    def forgetting(self):
        rule = self.rule.lambda_
        if isinstance(rule, rn.ScheduledForgetting):
            return self.latest(rule.initial, rule.changes)
        if not isinstance(rule, rn.VariableRateForgetting):
            return rule
        excess = self.growth(rule.short, rule.long) - 1
        return max(rule.smallest, 1 / (1 + rule.gain * max(0.0, excess)))

    def growth(self, short, long):
        def rms(n):
            recent = [self.s("z", i) for i in range(max(self.k - n + 1, 0), self.k + 1)]
            return np.sqrt(np.mean([z @ z for z in recent]))

        return rms(short) / rms(long) if rms(long) > 0 else 1.0

    def update(self, rows, goal):
        rule = self.rule
        if isinstance(rule, rn.Gradient):
            self.curvatures.append(np.linalg.norm(rows, 2) ** 2)
            cost = lambda theta: np.sum((rows @ theta - goal) ** 2)  # noqa: E731
            steps = 1e-3 * np.eye(self.theta.size)  # differences of a quadratic are exact
            slope = [(cost(self.theta + d) - cost(self.theta - d)) / 2e-3 for d in steps]
            self.theta = self.theta - rule.step_size * np.array(slope) / 2
        elif isinstance(rule, rn.Instantaneous):
            self.theta = least_squares([(1.0, rows, goal)], self.R_theta, self.theta)
        elif isinstance(rule, rn.SlidingWindow):
            self.stages.append((rows, goal))
            remaining = self.stages[-rule.window :][::-1]
            aged = [(rule.lambda_**age, *stage) for age, stage in enumerate(remaining)]
            self.theta = least_squares(aged, self.R_theta, self.c.theta_0)
        elif rule.process_noise is not None:
            remaining = np.abs(rows).any(axis=1) | (goal != 0)
            C, y = rows[remaining], goal[remaining]  # measurements y = C theta + v, v of variance I
            gain = self.P @ C.T @ np.linalg.inv(np.eye(len(C)) + C @ self.P @ C.T)
            self.theta = self.theta + gain @ (y - C @ self.theta)
            left = np.eye(len(self.P)) - gain @ C
            self.P = left @ self.P @ left.T + gain @ gain.T + matrix(rule.process_noise, len(C.T))
        else:
            self.stages.append((rows, goal))
            self.lambdas.append(self.forgetting())
            weights = [np.prod(self.lambdas[i + 1 :]) for i in range(len(self.lambdas))]
            aged = [(w, *stage) for w, stage in zip(weights, self.stages, strict=True)]
            H, centre = self.prior
            self.H = np.prod(self.lambdas) * H
            self.theta = least_squares(aged, self.H, centre)
            self.H = self.H + sum(w * rows.T @ rows for w, rows, _ in aged)
            self.P = np.linalg.inv(self.H)

    def reset(self):
        """P <- P(0), theta stays: a new prior around the present theta, and no data."""
        self.resets += 1
        self.prior, self.P = (self.R_theta, self.theta), np.linalg.inv(self.R_theta)
        self.stages, self.lambdas = [], []

    def reset_is_due(self, rule):
        age = self.k - max(self.first, self.last_reset)
        every = rule.every and age > 0 and (self.k - self.first) % rule.every == 0
        trace = np.trace(self.P) < rule.trace_below * np.trace(np.linalg.inv(self.R_theta))
        growing = (
            rule.growth and age >= rule.long and self.growth(rule.short, rule.long) > rule.growth
        )
        return every or trace or growing

    def reflect(self):
        """Poles outside the unit circle to the reciprocals of their conjugates (6.2.2)."""
        structure = self.c.structure
        of_u = [j for j, tap in enumerate(structure.taps) if tap.signal == "u"]
        poles = np.roots([1.0, *(-self.theta[of_u])])
        if not (np.abs(poles) > 1).any():
            return
        poles = np.array([1 / p.conjugate() if abs(p) > 1 else p for p in poles])
        self.reflections += 1
        self.theta = self.theta.copy()
        self.theta[of_u] = -np.real(np.poly(poles))[1:]
        if isinstance(self.rule, rn.UD | rn.Covariance) and self.rule.process_noise is None:
            self.prior, self.stages, self.lambdas = (self.H, self.theta), [], []


def matrix(weight, size):
    """A number stands for that multiple of the identity."""
    return weight * np.eye(size) if np.ndim(weight) == 0 else weight


def least_squares(stages, H, centre):
    """argmin of sum w |rows theta - goal|^2 + (theta - centre)' H (theta - centre)."""
    base = root(H)
    A = np.vstack([base, *(np.sqrt(w) * rows for w, rows, _ in stages)])
    b = np.concatenate([base @ centre, *(np.sqrt(w) * goal for w, _, goal in stages)])
    return np.linalg.lstsq(A, b, rcond=None)[0]
