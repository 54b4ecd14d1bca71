"""Each result can be held against what it was made from, or it is said here why not."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory import results
from compensator_theory.loops._siso import closed_loop_of_pair
from compensator_theory.matrices._certificates import Certified

from .samples import SAMPLES

CLASSES = {name: getattr(results, name) for name in dir(results) if name[0].isupper()}
WITHOUT = {
    "a number, a ball, a count or a matrix": """AffineMap Certificate Enclosure FieldMatrix
        NumberField PolynomialEnclosure PolynomialMatrix Root RootCount""",
    "a part of a result that is certified, or of one below": """ButterworthPattern DelayCrossing
        ExceptionalCase GainCrossover HighAuthorityLimit LocusAngles LocusBreak LocusCrossing
        PartialFraction PhaseCrossover StabilityCell StabilitySlab UnstableRealZero
        ZeroDirection""",
    "irrational by nature: balls enclose it, and SpectralFactor.residual encloses 0": """
        HInfinityNorm HighAuthorityLimits HighAuthorityTarget LQGPoles RegulatorLocus
        StabilityMargins""",
    "a decision by signs or counts, which is no identity": """IntervalStability ObserverDecision
        PickInterpolation RealnessDecision StabilityDecision StabilityDelays StabilityIntervals
        StabilityRegion StrongStabilisability""",
    "its parts have one: the regulator and the estimator": "LQGController",
    "it is both sides of an identity": "PropositionCheck",
    "determinants; the multipliers that would show them in the ideal are not kept": "Subresultants",
    "answers of another function, whose certificate speaks of each": "ExceptionalCases",
}
TAMPERED = {
    results.BezoutIdentity: "x",
    results.Equivalence: "U",
    results.FixedModes: "polynomial",
    results.ObserverForm: "regulator",
    results.ObserverForms: "characteristic_polynomial",
    results.PolePlacement: "numerator",
    results.RootLocus: "numerator",
    results.StateFeedbackFamily: "polynomial",
    results.YoulaForm: "parameter",
}


def has_certificate(cls):
    return hasattr(cls, "certificate") or "certificate" in cls.__dataclass_fields__


CERTIFIED = [cls for cls in CLASSES.values() if has_certificate(cls)]


def test_each_result_has_a_certificate_or_a_reason():
    named = [name for names in WITHOUT.values() for name in names.split()]
    assert len(named) == len(set(named))
    assert set(named) == {name for name, cls in CLASSES.items() if not has_certificate(cls)}


@pytest.mark.parametrize("cls", CERTIFIED, ids=lambda c: c.__name__)
@settings(max_examples=3, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_certificates_hold(cls, data):
    found = data.draw(SAMPLES[cls]).certificate
    assert found is None or (found.holds and found.identity)


def test_each_class_that_is_evaluated_anew_is_tampered_with_below():
    certified = {cls for cls in CLASSES.values() if issubclass(cls, Certified)}
    assert certified == {*TAMPERED, results.ObserverGainFamily}


@pytest.mark.parametrize("cls", TAMPERED, ids=lambda c: c.__name__)
@settings(max_examples=3, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_what_was_tampered_with_is_seen(cls, data):
    found, name = data.draw(SAMPLES[cls]), TAMPERED[cls]
    assert found.is_verified
    part = getattr(found, name)
    wrong = replace(found, **{name: part + (part.gen if hasattr(part, "gen") else part)})
    assert not wrong.is_verified and str(wrong.certificate).endswith("FAILS")
    if cls is results.StateFeedbackFamily:
        assert not results.ObserverGainFamily(wrong).is_verified


def test_what_a_search_or_a_factorisation_found_is_held_against_the_question():
    """A loop that is another one, one that is not stable, and a product that is not the given."""
    alone = exact.stable_compensator("(s - 2)/(s**2 - 1)", feedback=-1)
    both = exact.decide_simultaneous_stabilisability("1/(z - 2)", "1/(z - 3)", feedback=-1)
    chi = exact.spectral_factor("z - 2", "z", 0)
    unstable = exact.transfer_function("1/(s - 9)")
    for wrong in (
        replace(alone, compensator=alone.compensator + 1),
        replace(alone, plant=unstable,
                characteristic_polynomial=closed_loop_of_pair(unstable, alone.compensator, -1)),
        replace(both, plants=both.plants[::-1]),
        replace(both, characteristic_polynomials=(exact.polynomial("z - 2"),) * 2),
        replace(chi, polynomial=chi.polynomial + 1), replace(chi, degree=chi.degree + 1),
    ):  # fmt: skip
        assert not wrong.certificate.holds
    assert alone.certificate.holds and both.certificate.holds and chi.certificate.holds
    assert exact.spectral_factor("z - 2", "z", 3).certificate is None
    assert exact.stable_compensator("(s - 1)/(s*(s - 2))", feedback=-1).certificate is None
