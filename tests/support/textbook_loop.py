"""Plants, actuators and loops from the text, as plain Python loops around the `Book`."""

import numpy as np

from tests.support.textbook import Book

MATRICES = ("A", "B", "D_1", "C", "D_0", "D_2", "E_1", "E_2", "E_0")


class BookPlant:
    """(2.1)-(2.3) with matrices that switch or ramp, a state that is mapped, a delayed input."""

    def __init__(self, plant, x_0=None):
        self.changes = getattr(plant, "changes", None)
        self.plant = plant
        self.x = np.zeros(plant.n) if x_0 is None else np.array(x_0, float)
        self.sent, self.k = [], 0

    def begin(self):
        self.m, self.delay = {name: getattr(self.plant, name, None) for name in MATRICES}, 0
        if self.changes is None:
            return
        number = max(i for i, change in enumerate(self.changes) if change.start <= self.k)
        now = self.changes[number]
        if now.start == self.k and now.state_map is not None:
            self.x = now.state_map @ self.x
        self.m, self.delay = {name: getattr(now.plant, name) for name in MATRICES}, now.delay
        if now.ramp:
            after = self.changes[number + 1]
            part = (self.k - now.start) / (after.start - now.start)
            self.m = {
                name: (1 - part) * getattr(now.plant, name) + part * getattr(after.plant, name)
                for name in MATRICES
            }

    def acting(self, u):
        """The input that acts at step k when u is sent at step k."""
        sent = [*self.sent, u]
        return sent[self.k - self.delay] if self.k >= self.delay else 0 * u

    def outputs(self, u, w):
        m, u = self.m, self.acting(u)
        y = m["C"] @ self.x + m["D_0"] @ u + m["D_2"] @ w
        return y, m["E_1"] @ self.x + m["E_2"] @ u + m["E_0"] @ w

    def advance(self, u, w):
        m = self.m
        self.x = m["A"] @ self.x + m["B"] @ self.acting(u) + m["D_1"] @ w
        self.sent.append(u)
        self.k += 1


def actuated(saturation, u, before):
    """u_a(k): within `rate` of u_a(k-1), then within [low, high]."""
    if saturation is None:
        return u
    low, high, rate = saturation.bounds(len(u))
    return np.minimum(
        np.maximum(np.minimum(np.maximum(u, before - rate), before + rate), low), high
    )


def book_loop(plant, parts, w, *, shared_u=True, saturation=None, x_0=None, forced=None):
    """Run Books on a plant; `parts` are pairs of settings and regressors.

    With `forced`, a kernel's run, every step starts from that run's own past (its u and u_a are
    what the histories hold), so that rounding is compared step by step and never amplified.
    """
    books, body = [Book(*part) for part in parts], BookPlant(plant, x_0)
    first = any(b.c.structure.measures_first or b.c.form == "filter" for b in books)
    u_a = np.zeros(plant.l_u)
    record = {name: [] for name in ("u", "u_applied", "y", "z", "theta", "x")}
    start = r_position(plant)
    for k, w_k in enumerate(w):
        body.begin()
        r = w_k[start : start + plant.blocks.get("r", 0)]
        if first:
            y, z = body.outputs(0 * u_a, w_k)
            for b in books:
                b.observe(y, r[: b.c.structure.l_r])
        for b in books:
            if b.c.form == "filter":
                b.adapt(z)
        record["theta"].append(np.concatenate([b.theta for b in books]))
        ours = [b.control() for b in books]
        u = sum(ours)
        u_a = actuated(saturation, u, u_a)
        record["u"].append(u)
        record["u_applied"].append(u_a)
        if forced is not None:
            u_a = forced.u_applied[k]
        y, z = body.outputs(u_a, w_k)
        record["y"].append(y)
        record["z"].append(z)
        for b, mine in zip(books, ours, strict=True):
            b.apply(u_a if shared_u or len(books) == 1 else mine)
            if not first:
                b.observe(y, r[: b.c.structure.l_r])
            if b.c.form != "filter":
                b.adapt(z)
            b.finish()
        body.advance(u_a, w_k)
    result = {name: np.array(values) for name, values in record.items()}
    result["theta_final"] = np.concatenate([b.theta for b in books])
    result["books"] = books
    return result


def r_position(plant):
    names = list(plant.blocks)
    return sum(plant.blocks[name] for name in names[: names.index("r")]) if "r" in names else 0


def assert_follows(run, parts, *, shared_u=True, tolerance=1e-9):
    """Every step of a kernel's run is what the text makes of the steps before it."""
    assert run.outcome == "completed"
    message = book_loop(
        run.plant,
        parts,
        run.w,
        shared_u=shared_u,
        saturation=run.saturation,
        x_0=run.x_0,
        forced=run,
    )
    size = max(1.0, np.abs(run.u_applied).max(), np.abs(run.y).max(), np.abs(run.z).max())
    for name in ("y", "z"):
        assert np.abs(message[name] - getattr(run, name)).max() <= 1e-12 * size
    # What a rounding error of the data does to theta grows with the data, squared.
    scale = max(1.0, np.abs(run.theta).max()) * size**2
    for name in ("theta", "theta_final"):
        assert np.abs(message[name] - getattr(run, name)).max() <= tolerance * scale, name
    for name in ("u", "u_applied"):
        assert np.abs(message[name] - getattr(run, name)).max() <= tolerance * scale * size, name
    return message
