"""Each result can be held against what it was made from, or it is said here why not."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from compensator_theory import results
from compensator_theory.matrices.certificates import Certified

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
        HInfinityNorm HighAuthorityLimits HighAuthorityTarget LQGPoles RegulatorLocus SpectralFactor
        StabilityMargins""",
    "a decision by signs or counts, which is no identity": """IntervalStability ObserverDecision
        PickInterpolation RealnessDecision SimultaneousStabilisability StabilityDecision
        StabilityDelays StabilityIntervals StabilityRegion StableCompensator
        StrongStabilisability""",
    "its parts have one: the regulator and the estimator": "LQGController",
    "it is both sides of an identity": "PropositionCheck",
    "determinants; the multipliers that would show them in the ideal are not kept": "Subresultants",
    "answers of another function, whose certificate speaks of each": "ExceptionalCases",
}
TAMPERED = {
    results.BezoutIdentity: "x",
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
    poly = getattr(found, name)
    wrong = replace(found, **{name: poly + poly.gen})
    assert not wrong.is_verified and str(wrong.certificate).endswith("FAILS")
    if cls is results.StateFeedbackFamily:
        assert not results.ObserverGainFamily(wrong).is_verified
