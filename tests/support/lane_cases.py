"""A loop that runs in lanes, and the signals in which runs of it are compared."""

from rcac_numeric import UD, ControllerSettings, fir_target, iir, standard_plant
from rcac_numeric.engine._jobs import PreparedRun
from rcac_numeric.engine._loops import PreparedLoop

SIGNALS = ("u", "y", "z", "theta", "theta_final")
PLANT = standard_plant("(q - 0.5)/(q*(q - 0.9))")
GOOD = ControllerSettings(structure=iir(3), target=fir_target(PLANT), update=UD(R_theta=1.0))


def arguments(case):
    """What `simulate` takes, of a case that `simulate_many` takes."""
    return {"plant": case.plant, "settings": case.settings, "w": case.w, **case.options}


def ready_run(plant, settings, w, *, saturation=None, supervision=None, **options):
    """A run with its job, for who calls the kernel himself; arguments as for `simulate`."""
    run = PreparedRun(PreparedLoop(plant, settings, saturation, supervision), w, **options)
    run.make_ready()
    return run
