"""Saved runs and states of strangers, with right checksums: refused by name, or as good as ours.

Reduced by default; `--long` reads 10^4 files. Sizes and times are measured by `hunt_files`.
"""

import copy
import json
import random
import zipfile

import numpy as np
import pytest

from compensator_theory.errors import CompensatorError
from rcac_numeric import ClosedLoop, SavedState, load_run, read_log, simulate
from rcac_numeric.arrays import _untrusted as untrusted
from rcac_numeric.arrays._record_files import KEY, _checksum, is_record
from tests.fuzz.hostile_files import (
    draw,
    hostile_run,
    nested,
    parts_of,
    require_harmless_run,
    require_ours,
    restorable,
    seeds,
    watched,
    write,
)


@pytest.fixture(scope="module")
def runs():
    return seeds()


@pytest.fixture(scope="module")
def parts(runs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("seeds")
    return [parts_of(run, folder) for run in runs]


@pytest.fixture(scope="module")
def states(runs):
    return [pair for run in runs for pair in restorable(run)]


@pytest.mark.costly
def test_hostile_runs_and_states(tmp_path, parts, states, in_full):
    """Some must be read and some refused, or the generator tries nothing."""
    ends = set()
    for seed in range(10_000 if in_full else 100):
        path = tmp_path / "hostile.npz"
        task = draw(path, seed, parts, states)
        try:
            ends.add(task() is None)
        except Exception:
            print(f"seed {seed}")
            raise
    assert ends == {True, False}


def test_what_was_not_touched_is_read(tmp_path, runs, parts):
    """The generator's own writing is no reason to refuse."""
    for run, (tree, arrays) in zip(runs, parts, strict=True):
        text = json.dumps(tree)
        signed = json.dumps({"checksum": _checksum(text, arrays), "record": text})
        write(tmp_path / "run.npz", random.Random(0), {KEY: signed}, arrays, packed=True)
        assert load_run(tmp_path / "run.npz") == run


def written(path, parts, change):
    """The first seed with something changed and the checksum of what it then holds."""
    tree, arrays = copy.deepcopy(parts[0][0]), dict(parts[0][1])
    text = change(tree, arrays) or json.dumps(tree)
    signed = json.dumps({"checksum": _checksum(text, arrays), "record": text})
    write(path, random.Random(0), {KEY: signed}, arrays, packed=True)
    return path


def put(*where):
    """A change of one place of the tree."""
    *path, value = where

    def change(tree, _):
        for key in path[:-1]:
            tree = tree[key]
        tree[path[-1]] = value

    return change


SETTINGS = ("parts", "settings", "is", "fields")
EXACT = ("parts", "plant", "is", "fields", "exact", "fields")


@pytest.mark.costly
@pytest.mark.cases(12)
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("parts", "failure", {"is": {"fraction": "1e400000000"}}), "no rational number"),
        (put("parts", "failure", {"is": {"fraction": "1/0"}}), "no rational number"),
        (put(*EXACT, "A", {"matrix": [], "shape": [10**13, 0]}), "too large"),
        (put(*EXACT, "A", {"poly": ["(s+1)**900"] * 200, "variable": "q"}), "no rational number"),
        (put(*EXACT, "A", {"matrix": [["1/7"]], "shape": [1, 1]}), "must be"),
        (put(*EXACT, "sample_time", {"number": "10**10**10"}), "no rational number"),
        (put("parts", "divergence_limit", {"is": {"float": "0x1p99999"}}), "no float"),
        (put("parts", "first_step", {"is": 10**40}), "digits"),
        (put("parts", "failure", {"is": nested(100)}), "nested more than 60 deep"),
        (lambda t, a: '{"a": ' * 5000 + "0" + "}" * 5000, "nested more than 60 deep"),
        (put("parts", "failure", {"is": {"tuple": [1] * 70_000}}), "more than 65536 parts"),
        (put(*SETTINGS, "structure", {"class": "Popen", "fields": {}}), "is not an allowed class"),
        (put(*SETTINGS, "structure", "fields", "taps", "tuple", 0, "fields", "delay", 10**15),
         "must be at most"),
        (put(*SETTINGS, "structure", "fields", "n_c", 10**9), "k_w"),
        (put("parts", "plant", "is", "fields", "blocks", {"dict": [["w"]]}), "not enough values"),
        (put("parts", "stride", {"is": "x"}), "stride of a Run is of type str"),
        (put("parts", "stride", {"is": 0}), "must be at least 1"),
        (put("parts", "changes", {"is": {"tuple": [1, 2]}}), "changes of a Run"),
        (put("parts", "outcome", {"is": "<script>\x1b[2J"}), r"outcome = '<script>\\x1b"),
        (put("parts", "plant", {"left out": "x", "words": "\x1b]0;t\x07"}), r"\\x1b\]0;t\\x07"),
        (lambda t, a: a.update(u=a["u"][:3]), "u has shape"),
        (lambda t, a: a.update(theta=a["theta"].astype("c16")), "theta of a Run"),
        (lambda t, a: a.update(w=np.full_like(a["w"], np.nan)), "must be finite"),
        (lambda t, a: a.update(zzz=np.zeros(3)), "unexpected keyword"),
        (lambda t, a: a.update(zzz=np.zeros((10**13, 0))), "more than 33554432 numbers"),
        (lambda t, a: a.update(zzz=np.zeros(2**25)), "more than 33554432 numbers"),
    ],
)  # fmt: skip
def test_a_hostile_run_is_refused_by_name(tmp_path, parts, change, words):
    path = written(tmp_path / "run.npz", parts, change)
    with watched(), pytest.raises(CompensatorError, match=words) as caught:
        load_run(path)
    require_ours(caught.value, path)


@pytest.mark.costly
@pytest.mark.parametrize("n_c", [5_000, 100_000])
def test_a_controller_of_many_lags_is_read_and_its_poles_are_refused(tmp_path, parts, n_c):
    def change(tree, _):
        fields = tree["parts"]["settings"]["is"]["fields"]
        fields["structure"]["fields"]["n_c"] = fields["k_w"] = fields["k_update"] = n_c

    run = require_harmless_run(written(tmp_path / "run.npz", parts, change), drawn=True)
    with pytest.raises(CompensatorError, match=f"{n_c} states"):
        run.compensator.poles()
    with pytest.raises(CompensatorError, match="states"):
        ClosedLoop(run.plant, run.compensator).poles()


def test_no_member_is_unpacked_that_claims_too_much(tmp_path, monkeypatch):
    """A bomb: the reader of arrays is not even asked."""
    monkeypatch.setattr(untrusted, "_array", lambda stream: pytest.fail("it was read"))
    path = tmp_path / "bomb.npz"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("bits.npy", "w") as stream,
    ):
        header = {"descr": "<i8", "fortran_order": False, "shape": (2**25 + 1,)}
        np.lib.format.write_array_header_1_0(stream, header)
        for _ in range(32):
            stream.write(bytes(2**20))
    for reader in (SavedState.load, load_run, read_log):
        with pytest.raises(CompensatorError, match="more than 33554432 numbers"):
            reader(path)
    assert not is_record(path)


@pytest.mark.costly
def test_an_archive_of_a_hundred_thousand_members_is_not_listed(tmp_path):
    path = tmp_path / "many.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(30_000):
            archive.writestr(f"{i}.npy", b"")
    for reader in (SavedState.load, load_run):
        with pytest.raises(CompensatorError, match="table of contents is too long"):
            reader(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_a_packing_that_chooses_its_memory_is_refused(tmp_path, runs, method):
    runs[0].save(tmp_path / "run.npz")
    with zipfile.ZipFile(tmp_path / "run.npz") as old:
        contents = {name: old.read(name) for name in old.namelist()}
    with zipfile.ZipFile(tmp_path / "other.npz", "w", method) as new:
        for name, data in contents.items():
            new.writestr(name, data)
    with pytest.raises(CompensatorError, match="packed by no usual method"):
        load_run(tmp_path / "other.npz")


def test_a_run_that_would_not_be_read_again_is_not_written(tmp_path, runs, monkeypatch):
    monkeypatch.setattr("rcac_numeric.arrays._record_files.MOST_NUMBERS", 100)
    with pytest.raises(CompensatorError, match="would not be read again"):
        runs[0].save(tmp_path / "run.npz")
    assert not list(tmp_path.iterdir())


def test_the_same_seed_writes_the_same_file(tmp_path, parts):
    for name in "ab":
        hostile_run(tmp_path / name, random.Random(5), parts)
    members = [zipfile.ZipFile(tmp_path / name).infolist() for name in "ab"]
    assert [m.CRC for m in members[0]] == [m.CRC for m in members[1]]


def test_a_loaded_run_goes_on(tmp_path, runs):
    runs[1].save(tmp_path / "run.npz")
    again, w = load_run(tmp_path / "run.npz"), np.ones((3, 1))
    one, other = (
        simulate(r.plant, r.settings, w, start=r.state, saturation=r.saturation)
        for r in (again, runs[1])
    )
    assert one == other
