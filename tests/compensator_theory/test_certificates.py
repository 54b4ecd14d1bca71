"""Each result can be held against what it was made from, or it is said here why not."""

from dataclasses import fields, replace
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sympy import ImmutableMatrix

import compensator_theory as exact
from compensator_theory import results
from compensator_theory.loops._siso import closed_loop_of_pair
from compensator_theory.matrices._certificates import Certified

from .samples import SAMPLES

CLASSES = {name: getattr(results, name) for name in dir(results) if name[0].isupper()}
WITHOUT = {
    "a number, a ball, a count or a matrix": """AffineMap Certificate Enclosure FieldMatrix
        NumberField PolynomialEnclosure PolynomialMatrix Root RootCount RootFormula""",
    "a part of a result that is certified, or of one below": """ButterworthPattern DelayCrossing
        ExceptionalCase GainCrossover HighAuthorityLimit LocusAngles LocusBreak LocusCrossing Margin
        Mode PartialFraction PhaseCrossover StabilityCell StabilitySlab SymmetricDiskMargin
        UnstableRealZero ZeroDirection""",
    "irrational by nature: balls enclose it, and SpectralFactor.residual encloses 0": """
        DelayedStabilityMargins EnclosedHInfinityNorm EnclosedStabilityMargins HInfinityNorm
        HighAuthorityLimits HighAuthorityTarget LQGPoles
        RegulatorLocus StabilityMargins""",
    "a decision by signs or counts, which is no identity": """IntervalStability ObserverDecision
        PickInterpolation RealnessDecision StabilityDecision StabilityDelays StabilityIntervals
        StabilityRegion StrongStabilisability""",
    "an array by its definition, compared with exact counts": "JuryArray RouthArray",
    "its parts have one: the regulator and the estimator": "LQGController",
    "it is both sides of an identity": "PropositionCheck",
    "determinants; the multipliers that would show them in the ideal are not kept": "Subresultants",
    "an answer to an exercise: a counterexample recomputes, a right one was drawn": "Judgement",
    "answers of another function, whose certificate speaks of each": "ExceptionalCases",
}
# The fields that the identity of a class holds against each other.
TAMPERED = {
    results.BezoutIdentity: "x",
    results.BrunovskyForm: "A B T F W",
    results.CoprimeFractions: "source D_r N_r D_l N_l X_r Y_r X_l Y_l",
    results.DiophantineSolution: "a b c x y dx dy",
    results.DoublyCoprimeFractions: "M_r N_r U_r V_r M_l N_l U_l V_l",
    results.Equivalence: "matrix form U V U_inverse V_inverse",
    results.FixedModes: "polynomial",
    results.MatrixDiophantineSolution: "C",  # what the others multiply may be zero
    results.MatrixPlacement: "D_l targets N_c D_c",
    results.MinimalBasis: "matrix basis left_inverse",
    results.ObserverForm: "regulator",
    results.ObserverForms: "characteristic_polynomial",
    results.PolePlacement: "numerator",
    results.PredictiveCostCompensator: "K regulator",
    results.RootLocus: "numerator",
    results.StateFeedbackFamily: "polynomial",
    results.TimeResponse: "transform",
    results.TransitionMatrix: "A",
    results.YoulaForm: "parameter",
}
# Of fields with these names the identity needs more than they hold: the roots as letters with their
# squares, the inputs that are not known, the field of the roots, and the plant.
STORED = {"FunctionalObserver", "RiccatiFormula", "RiccatiSolution", "Interactor", "Decoupling"}


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
    result = data.draw(SAMPLES[cls]).certificate
    assert result is None or (result.holds and result.identity)


def test_a_result_that_holds_its_question_computes_its_certificate():
    """What is stored may be stale; a class that keeps A, B or a plant has what it takes."""
    question = {"A", "a", "plant", "source", "matrix"}
    stored = {
        name for name, cls in CLASSES.items()
        if (names := {f.name for f in fields(cls)}) & question and "certificate" in names
    }  # fmt: skip
    assert stored - {"Realisation"} == STORED


def test_each_class_that_is_evaluated_anew_is_tampered_with_below():
    certified = {cls for cls in CLASSES.values() if issubclass(cls, Certified)}
    assert certified == {*TAMPERED, results.ObserverGainFamily}


def falsified(value):
    """The same value with one coefficient changed, once for each of its entries."""
    if isinstance(value, ImmutableMatrix):
        for i, j in product(range(value.rows), range(value.cols)):
            changed = value.as_mutable()
            changed[i, j] += 1
            yield changed.as_immutable()
    elif isinstance(value, tuple):
        for i, part in enumerate(value):
            for one in falsified(part):
                yield (*value[:i], one, *value[i + 1 :])
    elif isinstance(value, exact.PolynomialMatrix):
        yield from map(exact.PolynomialMatrix, falsified(value.rows))
    elif isinstance(value, exact.TransferMatrix):
        yield from (replace(value, numerators=one) for one in falsified(value.numerators))
    elif value is not None:
        yield value + (value.gen if hasattr(value, "gen") else value)


@pytest.mark.parametrize("cls", TAMPERED, ids=lambda c: c.__name__)
@settings(max_examples=3, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_what_was_tampered_with_is_seen(cls, data):
    result = data.draw(SAMPLES[cls])
    if cls is results.MinimalBasis:  # of a null space that is not zero
        result = exact.forms.minimal_basis([["s", data.draw(st.integers(0, 9)), "s**2 + 1"]], "s")
    assert result.is_verified
    for name in TAMPERED[cls].split():
        wrong = [replace(result, **{name: one}) for one in falsified(getattr(result, name))]
        verified = [one for one in wrong if not one.is_verified]
        assert verified or not wrong, name
        assert all(str(one.certificate).endswith("FAILS") for one in verified[:1])
        if cls is results.StateFeedbackFamily:
            assert not results.ObserverGainFamily(wrong[0]).is_verified


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
