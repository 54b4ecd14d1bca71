"""The certificate of a set in the second harness, which knows rational numbers alone."""

import json
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proofs import recheck
from rcac_numeric import certified_set
from tests.support.certified_loops import loops


@pytest.mark.costly
@settings(max_examples=12)
@given(loops(), st.data())
def test_the_harness_confirms_a_set_and_refuses_a_falsified_one(loop, data):
    region = certified_set(*loop)
    record = json.loads(json.dumps(region.certificate_record()))
    assert recheck.failures(record) == []
    names = [name for name in record["matrices"] if name[0] in "PRS"]  # beside no zero
    name = data.draw(st.sampled_from(sorted(names)))
    entries = [entry for entry in record["matrices"][name]["entries"] if entry]
    term = data.draw(st.sampled_from(data.draw(st.sampled_from(entries))))
    term[0] = str(Fraction(term[0]) * 2)
    assert recheck.failures(record)


@pytest.mark.costly
@settings(max_examples=4)
@given(loops())
def test_a_set_becomes_a_file_for_coq(loop):
    """Each member has a theorem for the equation of S and one for each definite matrix."""
    text = certified_set(*loop).to_coq()
    members = text.count("Theorem equation_")
    assert (
        members and text.count("Theorem definite_P") == text.count("Theorem definite_S") == members
    )
