"""Public data are equal by content, and pickle to an equal object in a fresh process."""

from rcac_experiments import results, sweeps
from tests.rcac_experiments.samples import SAMPLES
from tests.support.equality import (  # noqa: F401
    both_once,
    classes_of,
    elsewhere,
    equality_of,
    pickling_of,
    printing_of,
)

DATA_CLASSES, OTHERS = classes_of("rcac_experiments")
NO_DATA = {sweeps.ProgressLine, sweeps.StoreError, sweeps.StudyInterrupted}
SLOW = {results.Tuned: SAMPLES[results.Tuned]}
QUICK = {cls: sample for cls, sample in SAMPLES.items() if cls not in SLOW}


def test_every_public_data_class_has_a_sample():
    assert not DATA_CLASSES - set(SAMPLES), "give it a line in tests/rcac_experiments/samples.py"
    assert OTHERS == NO_DATA


test_it_pickles_to_an_equal_object_in_a_fresh_process = pickling_of(QUICK, cases=5)
test_it_is_equal_where_all_that_it_holds_is_equal = equality_of(QUICK, cases=5)
test_what_takes_seconds_to_tune_does_so_once = both_once(SLOW)
test_data_print_as_their_repr_or_field_by_field = printing_of(QUICK, cases=5)
