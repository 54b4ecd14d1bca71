"""Loops of the dissertation's examples as data, for tests of what lies below experiment files."""

from dataclasses import dataclass

import rcac_numeric as rn

STILL = rn.Step(0)


@dataclass(frozen=True)
class Loop:
    """A plant, the settings that adapt to it, and the signals that act on it."""

    plant: rn.Plant
    settings: rn.ControllerSettings
    signals: tuple[rn.Signal, ...]
    steps: int

    def w(self, steps: int | None = None):
        return rn.exogenous(self.signals, steps or self.steps)

    def run(self, steps: int | None = None, **options) -> rn.Run:
        return rn.simulate(self.plant, self.settings, self.w(steps), **options)


def placed(plant, poles, n_c, k_w, R_theta, signals) -> Loop:
    target = rn.pole_placement_target(plant, poles)
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c), target=target, update=rn.UD(R_theta), k_w=k_w
    )
    return Loop(plant, settings, signals, 100)


def following(G, command, n_c, R_theta, steps) -> Loop:
    plant = rn.servo_plant(G)
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c), target=rn.fir_target(plant), update=rn.UD(R_theta)
    )  # fmt: skip
    return Loop(plant, settings, (command, STILL, STILL), steps)


EXAMPLE_2_1 = {
    f"R_theta = {R_theta}": following(
        "(q - 0.85)/((q - 0.8)*(q - 0.9))", rn.Step(), 3, R_theta, 100_000
    )
    for R_theta in (0.2, 20)
}
EXAMPLE_2_3 = following("(q - 0.8)/((q - 0.95)*(q - 0.99))", rn.Harmonic(0.5), 5, 0.2, 300)
EXAMPLE_4_6 = placed(
    rn.servo_plant("(q**2 - 1.4*q + 0.85)/((q - 1.05)*(q**2 - 1.6*q + 0.89))"),
    ["0.3", "0.4", "0.6", "0.1j", "-0.1j"],
    n_c=4, k_w=50, R_theta=1e-20, signals=(rn.Step(), STILL, STILL),
)  # fmt: skip
EXAMPLE_4_7 = placed(
    rn.standard_plant("(q**2 - 1.44*q + 0.81)/((q - 0.9)*(q**2 - 1.71*q + 0.903))"),
    ["0.5", "-0.5", "0.8j", "-0.8j"], n_c=4, k_w=50, R_theta=1e-10, signals=(rn.Step(),),
)  # fmt: skip
EXAMPLE_4_8 = placed(
    rn.standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))"),
    ["0.1", "0.3", "0.5", "0.3j", "-0.3j"], n_c=3, k_w=5, R_theta=1e-40, signals=(rn.Step(),),
)  # fmt: skip
# By name of the example and of its run, as its file has them.
LOOPS = {
    **{("2.1", name): loop for name, loop in EXAMPLE_2_1.items()},
    ("2.3", "IIR"): EXAMPLE_2_3,
    ("4.6", "k_w = 50, 1e-20, UD"): EXAMPLE_4_6,
    ("4.7", "UD"): EXAMPLE_4_7,
    ("4.8", "UD"): EXAMPLE_4_8,
}
