"""What is asked of a run before it starts: that it fits together and could adapt."""

from __future__ import annotations

from compensator_theory.errors import InputError
from rcac_numeric.controllers.decentralized import Decentralized
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.engine.compatibility import controllers_of, require_fit
from rcac_numeric.engine.reference.run import require_supported
from rcac_numeric.experiments.experiment import RunSpecification


def require_sense(run: RunSpecification) -> None:
    """Refuse a run that does not fit together or could not adapt."""
    require_fit(run.plant, run.settings)
    if run.saturation is not None:
        run.saturation.bounds(run.plant.l_u)
        if isinstance(run.settings, Decentralized) and not run.settings.shared_u:
            raise InputError(
                "with saturation, controllers that hold their own u cannot know which part of it "
                "was applied. Set shared_u = true in [controller]."
            )
    if run.seeds > 1 and run.repetitions > 1:
        raise InputError(
            f"seeds = {run.seeds} and repetitions = {run.repetitions}: give one of them. Seeds "
            "change the noise, repetitions only the last digits of the data."
        )
    if run.x_0 is not None and run.x_0.shape != (run.plant.n,):
        raise InputError(f"x_0 has {run.x_0.size} entries; the plant has {run.plant.n} states.")
    if run.reference and (run.x_0 is not None or run.x_0_deviation):
        raise InputError('arithmetic = "reference" starts from rest; leave x_0 out.')
    if run.reference:
        require_supported(run.plant, run.settings, run.saturation)
    for controller in controllers_of(run.settings):
        if isinstance(controller, FixedController):
            continue
        for name in ("k_w", "k_update"):
            if (start := getattr(controller, name)) >= run.steps:
                raise InputError(
                    f"{name} = {start} is not before the end of the run of {run.steps} steps, so "
                    "nothing would be adapted. Use more steps."
                )
    for signal in run.signals:
        signal.require_length(run.steps)
