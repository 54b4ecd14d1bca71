"""What a run that learns its target model is warned of, and that the named remedy cures it."""

import numpy as np
import pytest

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.checks._health import excitation_of
from rcac_numeric.reports._loop import health_lines, health_record

LIGHT = rn.standard_plant("(q - 0.8)*(q - 1.5)/((q - 0.5)*(q**2 - 1.9*q + 1))")
DOUBLING = rn.standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))")
OURS = {"nothing learnt", "low order", "poor excitation", "unstable start"}


def health_of(plant, target, n_c=15, R_theta=0.5, steps=6000, seed=0):
    settings = rn.ControllerSettings(structure=rn.iir(n_c), target=target, update=rn.UD(R_theta))
    run = rn.simulate(plant, settings, rn.exogenous([rn.WhiteNoise(0.01)], steps, seed))
    return run, rn.loop_health(run)


def ours(health):
    return {warning.code for warning in health.warnings} & OURS


@pytest.mark.parametrize("seed", range(3))
def test_an_order_below_that_of_plant_and_noise(seed):
    """The plant has order 3, its noise is of high order: 4 is too small, 20 is enough."""
    _, low = health_of(LIGHT, rn.DataDriven(order=4, seed=seed), seed=seed)
    _, enough = health_of(LIGHT, rn.DataDriven(order=20, seed=seed), seed=seed)
    assert ours(low) == {"low order"} and not ours(enough)
    (warning,) = [w for w in low.warnings if w.code == "low order"]
    assert "ARX(4)" in warning.sentence and "order = 8" in warning.next_step


def test_too_small_a_dither():
    _, health = health_of(LIGHT, rn.DataDriven(order=20, dither=1e-6))
    assert ours(health) == {"nothing learnt"} and health.warnings[0].is_grave
    assert health.excitation is None  # there is no target model that would filter the data
    _, mended = health_of(LIGHT, rn.DataDriven(order=20, dither=0.01))
    assert not ours(mended)


def test_a_start_that_is_too_long_for_an_unstable_plant():
    _, lost = health_of(DOUBLING, rn.DataDriven(), n_c=8, R_theta=1e-6)
    assert ours(lost) == {"unstable start"}
    first = lost.warnings[0]
    assert first.code == "diverged" and "known d_zu and H" in first.next_step
    short = rn.DataDriven(order=2, start=12, dither=0.1, d_zu=1, H=1.0)
    run, mended = health_of(DOUBLING, short, n_c=8, R_theta=1e-6)
    assert run.outcome == "completed" and not ours(mended)


def test_it_stands_in_the_lines_and_in_the_record():
    _, health = health_of(LIGHT, rn.DataDriven(order=2))
    assert any("Warning (low order)" in line.words for line in health_lines(health))
    assert "low order" in {w["code"] for w in health_record(health)["warnings"]}


def test_excitation_is_that_of_the_target_that_was_learnt():
    """As that of the same data with the learnt model told."""
    run, _ = health_of(LIGHT, rn.DataDriven(order=20), steps=2000)
    settings = rn.ControllerSettings(
        structure=rn.iir(15), target=run.changes[-1].change.target, update=rn.UD(0.5), k_w=300
    )
    assert excitation_of(run) == excitation_of(replace(run, settings=settings, changes=()))
    assert not ours(health_of(LIGHT, rn.fir_target(LIGHT), steps=500)[1])
    assert np.isfinite(run.z).all()
