"""Damaged and misshapen logs: only errors of our own tree, little work, nothing executed.

Reduced by default; `--long` runs 10^4 files. Each kind of damage is written from a seed, so that a
failure names the file that it came from.
"""

import pickle
import zipfile

import numpy as np
import pandas as pd
import pytest
import scipy.io
import scipy.sparse

from compensator_theory.errors import CompensatorError
from rcac_numeric import inspect_log, read_log, read_recording
from rcac_numeric.signals._data_files import read_variables
from tests.support.ulogs import ulog
from tests.support.work import at_most, at_most_bytes

CALLS, BYTES = 1_000_000, 300_000_000  # at most 2**25 numbers are read, 268 MB
KINDS = ("mat", "packed mat", "mat 4", "npz", "packed npz", "csv", "npy", "structs.mat", "txt",
         "csv.gz", "parquet", "xlsx", "h5", "ulg")  # fmt: skip
TABLES = KINDS[8:]


class Trap:
    """Unpickling it is the end of the test."""

    def __reduce__(self):
        return (pytest.fail, ("a log was unpickled",))


def contents(rng):
    """Signals of random widths and types beside things that are no signals."""
    steps = int(rng.integers(1, 30))
    result = {
        name: rng.standard_normal((steps, int(rng.integers(1, 4)))).astype(
            rng.choice(["f8", "f4", "i4", "u1", "c16"], p=[0.6, 0.1, 0.1, 0.1, 0.1])
        )
        for name in ("u", "y", "z", "theta")
    }
    result["A"] = scipy.sparse.random(3, 4, 0.5, "csc", random_state=int(rng.integers(1000)))
    return result | {"note": "hot day", "cell": np.array([1, "a"], dtype=object)}


def written(folder, kind, rng):
    path = folder / f"log.{kind.split()[-1] if kind != 'mat 4' else 'mat'}"
    path = path.with_name("log.mat") if kind == "structs.mat" else path
    result = contents(rng)
    signals = {name: result[name] for name in ("u", "y", "z", "theta")}
    if kind in TABLES:
        write_table(path, rng)
    elif kind == "structs.mat":
        cell = np.array([1, "a", result["u"].real], dtype=object)
        series = {"time": result["y"].real, "signals": {"values": result["u"].real, "label": "u"}}
        scipy.io.savemat(path, {"out": series, "y": {"Time": 1.0, "Data": cell}})
    elif kind == "mat 4":
        plain = {name: value.real.astype("f8") for name, value in signals.items()}
        scipy.io.savemat(path, plain | {"A": result["A"]}, format="4")
    elif path.suffix == ".mat":
        scipy.io.savemat(path, result, do_compression=kind == "packed mat")
    elif path.suffix == ".npz":
        (np.savez_compressed if kind == "packed npz" else np.savez)(path, **signals)
    elif path.suffix == ".npy":
        np.save(path, result["u"])
    else:
        rows = [",".join(signals)] + [
            ",".join(str(v[k, 0].real) for v in signals.values()) for k in range(len(result["u"]))
        ]
        path.write_text("\n".join(rows))
    return path


def write_table(path, rng):
    """A table in the format of a library, or a text with stamps and decimal commas."""
    steps = int(rng.integers(2, 30))
    u, y = rng.standard_normal((2, steps))
    frame = pd.DataFrame({"u": u, "y": y}, index=pd.date_range("2024", periods=steps, freq="1s"))
    if path.suffix == ".ulg":
        stamps = 4000 * np.arange(steps)
        path.write_bytes(
            ulog({"a": {"timestamp": stamps, "u": u}, "b": {"timestamp": stamps, "y": y}})
        )
    elif path.suffix == ".h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            file["u"], file["group/y"] = u, y
    elif path.suffix == ".txt":
        path.write_text("# a log\n" + frame.to_csv(sep="\t", decimal=","))
    elif path.suffix == ".xlsx":
        frame.to_excel(path)
    else:
        (frame.to_parquet if path.suffix == ".parquet" else frame.to_csv)(path)


def damaged(data, rng):
    """Bytes changed, cut out, repeated, or set to what sizes and counts are made of."""
    data = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(0, max(len(data), 1)))
        match int(rng.integers(0, 6)):
            case 0:
                data[at : at + 1] = bytes([rng.integers(0, 256)])
            case 1:
                del data[at : at + int(rng.integers(1, 20))]
            case 2:
                data[at:at] = data[at : at + int(rng.integers(1, 40))]
            case 3:
                special = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**24)
                data[at : at + 4] = int(rng.choice(special)).to_bytes(4, "little")
            case 4:
                del data[at:]
            case _:
                data[at : at + 8] = b"\xff" * 8
    return bytes(data)


def read(path):
    """Every way in; what is refused is refused by an error of ours that names the file."""
    for way in (read_variables, read_log, read_recording, inspect_log):
        try:
            way(path)
        except CompensatorError as error:
            assert str(path) in str(error) and len(str(error)) < 3000


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_logs(tmp_path, kind, in_full):
    for seed in range(1500 if in_full else 60):
        rng = np.random.default_rng([seed, KINDS.index(kind)])
        path = written(tmp_path, kind, rng)
        path.write_bytes(damaged(path.read_bytes(), rng))
        try:
            with at_most(CALLS), at_most_bytes(BYTES):
                read(path)
        except BaseException:
            print(f"kind {kind!r}, seed {seed}")
            raise


@pytest.mark.parametrize("compressed", [True, False])
def test_every_byte_of_a_small_mat_file(tmp_path, compressed, in_full):
    """One of these changes ended SciPy's reader in a segmentation fault: b[145] = 0xff."""
    path = tmp_path / "log.mat"
    signals = {"u": np.ones((9, 1)), "y": np.zeros((9, 1))}
    scipy.io.savemat(path, signals, do_compression=compressed)
    whole = path.read_bytes()
    for at in range(116, len(whole)) if in_full else (*range(116, 200), 145):
        for value in (0xFF, 0x00, 0x80, 14):
            path.write_bytes(whole[:at] + bytes([value]) + whole[at + 1 :])
            read(path)


def test_files_that_ask_for_all_memory(tmp_path):
    """A few hundred bytes that claim to hold a terabyte, or unpack to gigabytes of zeros."""
    claims = tmp_path / "claims.npy"
    with claims.open("wb") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**11,)}
        np.lib.format.write_array_header_1_0(file, header)
    with zipfile.ZipFile(tmp_path / "claims.npz", "w") as archive:
        archive.write(claims, "u.npy")
    bomb = tmp_path / "bomb.mat"
    scipy.io.savemat(bomb, {"u": np.zeros((2**25 + 1, 1), "u1")}, do_compression=True)
    sparse = tmp_path / "sparse.mat"
    scipy.io.savemat(sparse, {"u": scipy.sparse.csc_matrix((10**6, 10**4))})
    for path in (claims, claims.with_suffix(".npz"), bomb, sparse):
        reader = read_recording if path.suffix == ".npy" else read_variables
        expected = pytest.raises(CompensatorError, match="more than 33554432 numbers")
        with at_most(CALLS), at_most_bytes(100_000_000), expected:
            reader(path)


@pytest.mark.parametrize("kind", ["npy", "npz"])
def test_a_header_of_gigabytes_is_not_read(tmp_path, kind):
    path = tmp_path / f"log.{kind}"
    header = b"\x93NUMPY\x02\x00\xff\xff\xff\xff"
    path.write_bytes(header)
    if kind == "npz":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("u.npy", header + bytes(10**8))
    with at_most_bytes(10_000_000), pytest.raises(CompensatorError, match="not one of plain"):
        (read_recording if kind == "npy" else read_variables)(path)


def test_nothing_is_unpickled(tmp_path):
    trapped = np.empty(1, dtype=object)
    trapped[0] = Trap()
    np.savez(tmp_path / "log.npz", u=trapped)
    (tmp_path / "log.npy").write_bytes(pickle.dumps(Trap()))
    for path in tmp_path.iterdir():
        read(path)


def test_devices_and_endless_names(tmp_path):
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    with pytest.raises(CompensatorError, match="not a regular file"):
        read_variables(tmp_path / "zero.csv")
    wide = tmp_path / "wide.csv"
    width = 300_000
    wide.write_text(",".join(f"x{i}_" for i in range(width)) + "\n" + ",".join("1" * width))
    with pytest.raises(CompensatorError) as caught:
        read_log(wide)
    assert len(str(caught.value)) < 1500
