"""Files of logs as people have them, each written by the program that people use.

`LOGS` is the table: a name, the program, what it writes, and how it is read. `python -m
tests.rcac_numeric.signals.test_log_kinds` prints it.
"""

import gzip
import io
import shutil
import subprocess
import sys
from datetime import datetime, timedelta
from functools import partial

import numpy as np
import pandas as pd
import pytest
import scipy.io

from compensator_theory.errors import InputError
from rcac_numeric import inspect_log, read_log
from tests.support.ulogs import ulog

N = 24
T = np.round(0.1 * np.arange(N), 10)
RNG = np.random.default_rng(49)
U, Y = RNG.standard_normal((2, N)).round(3)
THETA = RNG.standard_normal((N, 4)).round(3)
FRAME = pd.DataFrame({"t": T, "u": U, "y": Y})
BEGIN = datetime(2024, 1, 31, 23, 59, 59)  # the stamps go over midnight and into another month
LOGS = {}


def log(program, name, suffix=".csv", *, period=0.1, tolerance=1e-12, **options):
    """Put a writer of (path) into the table, with the options of `read_log`."""

    def put(write):
        LOGS[f"{program}: {name}"] = (write, suffix, period, tolerance, options)
        return write

    return put


def text(name, contents, suffix=".csv", encoding="utf-8", program="text", **options):
    log(program, name, suffix, **options)(lambda path: path.write_bytes(contents.encode(encoding)))


def rows(separator=",", form=repr, end="", columns=(T, U, Y)):
    lines = (
        separator.join(form(float(v)) for v in row) + end for row in zip(*columns, strict=True)
    )
    return "\n".join(lines) + "\n"


def comma(value):
    return repr(value).replace(".", ",")


def stamped(form, separator=",", number=repr, step=0.1):
    stamps = [form(BEGIN + timedelta(seconds=step * k)) for k in range(N)]
    return "".join(
        separator.join([s, number(float(a)), number(float(b))]) + "\n"
        for s, a, b in zip(stamps, U, Y, strict=True)
    )


# Text: separators, decimal signs, heads, units, comments, encodings.
text("commas", "t,u,y\n" + rows())
text("semicolons", "t;u;y\n" + rows(";"))
text("tabs", "t\tu\ty\n" + rows("\t"), ".tsv")
text("vertical bars", "t|u|y\n" + rows("|"), ".txt")
text("blanks", "t u y\n" + rows("   "), ".dat")
text(
    "blanks before the numbers",
    "t u y\n" + "".join("  " + line + "\n" for line in rows("  ").splitlines()),
    ".txt",
)
text("comma and blank", "t, u, y\n" + rows(", "))
text("semicolons, decimal comma", "t;u;y\n" + rows(";", comma))
text("tabs, decimal comma", "t\tu\ty\n" + rows("\t", comma), ".txt")
text("blanks, decimal comma", "t u y\n" + rows(" ", comma), ".dat")
text("sep=; of Excel", "sep=;\nt;u;y\n" + rows(";", comma))
text("byte order mark", "\ufefft,u,y\n" + rows())
text("CRLF", ("t,u,y\n" + rows()).replace("\n", "\r\n"))
text("CR", ("t,u,y\n" + rows()).replace("\n", "\r"))
text("UTF-16", "t,u,y\n" + rows(), encoding="utf-16")
text("UTF-16 without a mark", "t,u,y\n" + rows(), encoding="utf-16-le")
text("Latin-1", "t [s],u [V],y [°C]\n" + rows(), encoding="latin-1")
text("units in the head", "t [s],u [V],y [degC]\n" + rows())
text("units in round brackets", "t (s),u (V),y (degC)\n" + rows())
text("units behind a slash", "t/s;u/V;y/mm\n" + rows(";", comma))
text("a row of units", "t,u,y\ns,V,degC\n" + rows())
text("a row of units in brackets, PicoScope", "Time,u,y\n(s),(V),(V)\n\n" + rows())
text("quotes", '"t","u","y"\n' + rows(form=lambda v: f'"{v}"'))
text("comments with #", "# logged by X\n# 2024-01-01\nt,u,y\n" + rows())
text("comments with % and names in one", "% t u y\n" + rows(" "), ".txt")
text("a comment in the middle", "# begin\nt,u,y\n" + rows().replace("0.5,", "# mark\n0.5,", 1))
text("lines of a device before the head", "Model,DL850\nRate,10,Hz\n\nt,u,y\n" + rows())
text("trailing separators", "t,u,y,\n" + rows(end=","))
text("trailing separators without one in the head", "t;u;y\n" + rows(";", end=";"))
text("capital letters", "Time,U,Y\n" + rows())
text("exponents of Fortran", "t,u,y\n" + rows(form=lambda v: f"{v:.6E}".replace("E", "D")))
text(
    "groups of thousands",
    "t;u;y\n"
    + rows(";", lambda v: f"{v:,.3f}".replace(",", "_").replace(".", ",").replace("_", ".")),
)
text(
    "a column of texts",
    "t,mode,u,y\n" + "".join(f"{a},AUTO,{b},{c}\n" for a, b, c in zip(T, U, Y, strict=True)),
)
text(
    "an empty column",
    "t,u,,y\n" + "".join(f"{a},{b},,{c}\n" for a, b, c in zip(T, U, Y, strict=True)),
)
text("no head, names given", rows(), columns=["t", "u", "y"])
text("no head, blanks, names given", rows(" "), ".dat", columns=["t", "u", "y"])
text("other names", "time,valve,level\n" + rows(), names={"u": "valve", "y": "level"})
text("components joined by +", "t,a,b\n" + rows(), names={"u": ["a"], "y": "b"})
text("an unfinished last line", "t,u,y\n" + rows() + "2.4,0.1")
text("time in ms", "time_ms,u,y\n" + rows(columns=(T * 1e3, U, Y)))
text("time in us by its unit", "t [us],u,y\n" + rows(columns=(T * 1e6, U, Y)))
text("seconds since 1970", "timestamp,u,y\n" + rows(columns=(T + 1.7e9, U, Y)))
text("ms since 1970", "timestamp,u,y\n" + rows(columns=(T * 1e3 + 1.7e12, U, Y)))
text(
    "days of a spreadsheet",
    "Date;u;y\n" + rows(";", lambda v: f"{v:.12f}", columns=(T / 86400 + 45292.5, U, Y)),
    tolerance=1e-9,
)
text("a counter of steps", "k,u,y\n" + rows(columns=(np.arange(N), U, Y)), period=None)
text("no time", "u,y\n" + rows(columns=(U, Y)), period=None)
text("ISO stamps", "time,u,y\n" + stamped(lambda s: s.isoformat()))
text("ISO stamps with a zone", "time,u,y\n" + stamped(lambda s: s.isoformat() + "+02:00"))
text(
    "stamps at the end",
    "u,y,time\n"
    + "".join(
        ",".join(line.split(",")[1:] + line.split(",")[:1]) + "\n"
        for line in stamped(lambda s: s.isoformat()).splitlines()
    ),
)
text(
    "German stamps, decimal comma",
    "Zeit;u;y\n" + stamped(lambda s: s.strftime("%d.%m.%Y %H:%M:%S,%f")[:-3], ";", comma),
)
text(
    "American stamps with AM and PM",
    "Time,u,y\n" + stamped(lambda s: s.strftime("%m/%d/%Y %I:%M:%S.%f %p")),
)
text(
    "whole seconds of ten rows",
    "Time,u,y\n" + stamped(lambda s: s.strftime("%d.%m.%Y %H:%M:%S")),
    tolerance=1e-9,
)
text("time of day over midnight", "Time,u,y\n" + stamped(lambda s: s.strftime("%H:%M:%S.%f")))
text(
    "date and time of day apart",
    "Date,Time,u,y\n" + stamped(lambda s: s.strftime("%Y-%m-%d,%H:%M:%S.%f")),
)

# pandas
log("pandas", "to_csv without an index")(lambda p: FRAME.to_csv(p, index=False))
log("pandas", "to_csv with its index")(FRAME.to_csv)
log("pandas", "to_csv, index alone", period=None)(FRAME[["u", "y"]].to_csv)
log("pandas", "to_csv with a time index")(lambda p: FRAME.set_index("t").to_csv(p))
DATED = FRAME[["u", "y"]].set_axis(pd.date_range(BEGIN, periods=N, freq="100ms"))
log("pandas", "to_csv with a DatetimeIndex")(DATED.to_csv)
log("pandas", "to_csv with a TimedeltaIndex")(
    lambda p: FRAME[["u", "y"]].set_axis(pd.to_timedelta(T, unit="s")).to_csv(p)
)
log("pandas", "to_csv, semicolons, decimal comma")(lambda p: FRAME.to_csv(p, sep=";", decimal=","))
log("pandas", "to_csv, packed", ".csv.gz")(FRAME.to_csv)
log("pandas", "to_csv of float32", tolerance=1e-7)(lambda p: FRAME.astype("float32").to_csv(p))
log("pandas", "to_string", ".txt", tolerance=1e-5)(
    lambda p: p.write_text(FRAME.to_string(index=False))
)
log("pandas", "to_excel", ".xlsx")(FRAME.to_excel)
log("pandas", "to_excel with stamps", ".xlsx", tolerance=1e-9)(DATED.to_excel)
log("pandas", "to_parquet", ".parquet")(FRAME.to_parquet)
log("pandas", "to_parquet with a DatetimeIndex", ".parquet")(DATED.to_parquet)
FRAMES = {
    "DataFrame": (FRAME, 0.1), "DatetimeIndex": (DATED, 0.1),
    "RangeIndex": (FRAME[["u", "y"]], None), "float index": (FRAME.set_index("t"), 0.1),
    "TimedeltaIndex": (FRAME[["u", "y"]].set_axis(pd.to_timedelta(T, unit="s")), 0.1),
    "stamps of whole minutes": (
        FRAME[["u", "y"]].set_axis(pd.date_range(BEGIN, periods=N, freq="1min")), 60.0),
    "index of texts": (FRAME[["u", "y"]].set_axis([f"row {k}" for k in range(N)]), None),
    "nullable types": (FRAME.convert_dtypes().assign(mode="AUTO"), 0.1),
    "zone": (DATED.tz_localize("Europe/Berlin"), 0.1),
}  # fmt: skip

# NumPy
log("NumPy", "savetxt with a head", ".txt")(lambda p: np.savetxt(p, np.c_[T, U, Y], header="t u y"))
log("NumPy", "savetxt with commas", tolerance=1e-9)(
    lambda p: np.savetxt(p, np.c_[T, U, Y], fmt="%.9g", delimiter=",", header="t,u,y", comments="")
)
log("NumPy", "savetxt without a head", ".txt", columns=["t", "u", "y"])(
    lambda p: np.savetxt(p, np.c_[T, U, Y])
)
log("NumPy", "savez", ".npz")(lambda p: np.savez(p, t=T, u=U, y=Y))
log("NumPy", "savez_compressed of float32", ".npz", tolerance=1e-6)(
    lambda p: np.savez_compressed(p, t=T, u=U.astype("f4"), y=Y.astype("f4"))
)
log("NumPy", "savez with datetime64", ".npz")(
    lambda p: np.savez(p, time=DATED.index.values, u=U, y=Y)
)
log("NumPy", "save", ".npy", columns=["t", "u", "y"])(lambda p: np.save(p, np.c_[T, U, Y]))

# SciPy, and what MATLAB's programs make of it
log("SciPy", "savemat of 1-D arrays, rows", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y})
)
log("SciPy", "savemat of columns", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y}, oned_as="column")
)
log("SciPy", "1 x N beside N x 1", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y[:, None]})
)
log("SciPy", "1 x N beside theta N x 4", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y, "theta": THETA})
)
log("SciPy", "1 x N beside theta 4 x N", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y, "theta": THETA.T})
)
log("SciPy", "version 4", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y}, format="4")
)
log("SciPy", "packed", ".mat")(
    lambda p: scipy.io.savemat(p, {"t": T, "u": U, "y": Y}, do_compression=True)
)
log("SciPy", "a struct with its sample time", ".mat")(
    lambda p: scipy.io.savemat(p, {"data": {"u": U, "y": Y, "Ts": 0.1}})
)
log("SciPy", "one matrix, names given", ".mat", columns=["t", "u", "y"])(
    lambda p: scipy.io.savemat(p, {"ans": np.c_[T, U, Y]})
)


def with_time(values, label=""):
    signals = {"values": values, "dimensions": 1.0, "label": label}
    return {"time": T[:, None], "signals": signals, "blockName": "model/To Workspace"}


SERIES = [{"Name": n, "Values": {"Time": T[:, None], "Data": v}} for n, v in (("u", U), ("y", Y))]
log("SciPy", "Simulink's structure with time", ".mat")(
    lambda p: scipy.io.savemat(p, {"u": with_time(U[:, None]), "y": with_time(Y[:, None])})
)
OUT = {"a": with_time(U.reshape(1, 1, N), "u"), "b": with_time(Y.reshape(1, 1, N), "y")}
log("SciPy", "structure with time, labels and 1 x 1 x N", ".mat")(
    lambda p: scipy.io.savemat(p, {"out": OUT})
)
log("SciPy", "logsout as structs", ".mat")(lambda p: scipy.io.savemat(p, {"logsout": SERIES}))
log("SciPy", "logsout as a cell of structs", ".mat")(
    lambda p: scipy.io.savemat(p, {"logsout": np.array(SERIES, dtype=object)})
)


@log("h5py", "MATLAB's version 7.3", ".mat")
def _(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in {"t": T, "u": U, "y": Y}.items():
            item = file.create_dataset(name, data=value[:, None].T)
            item.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


@log("h5py", "HDF5 with a group", ".h5")
def _(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, value in {"t": T, "u": U, "y": Y}.items():
            file[f"run/{name}"] = value


@log("pyarrow", "a list column of theta", ".parquet")
def _(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = {"t": T, "u": U, "y": Y, "theta": THETA.tolist(), "mode": ["AUTO"] * N}
    pq.write_table(pa.table(table), path)


STAMP = (1e6 + 1e5 * np.arange(N)).astype(np.uint64)


@log("ULog", "one topic, array of theta", ".ulg", tolerance=1e-6)
def _(path):
    fields = {
        "timestamp": STAMP,
        "u": U.astype("f4"),
        "y": Y.astype("f4"),
        "theta": THETA.astype("f4"),
    }
    path.write_bytes(ulog({"rcac": fields}))


@log("pyulog", "written back, two topics of one rate", ".ulg", tolerance=1e-6)
def _(path):
    pyulog = pytest.importorskip("pyulog")
    topics = {name: {"timestamp": STAMP, name: v.astype("f4")} for name, v in (("u", U), ("y", Y))}
    pyulog.ULog(io.BytesIO(ulog(topics))).write_ulog(str(path))


@log("openpyxl", "a title, names and units", ".xlsx")
def _(path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (
        ["Heater, test 3"],
        [],
        ["t", "u", "y"],
        ["s", "V", "degC"],
        *zip(T, U, Y, strict=True),
    ):
        sheet.append([v if isinstance(v, str) else float(v) for v in row])
    book.save(path)


COVER = [
    ["Heater, test 3"], [], ["Operator", "Max"], ["Date", BEGIN], ["Sample time", 0.1],
    ["rig", "revision", "gain"], [4, 2, 0.5],
]  # fmt: skip
TABLE = [["t", "u", "y"], *zip(T.tolist(), U.tolist(), Y.tolist(), strict=True)]


def workbook(path, sheets):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def without(*names):
    """The table without some columns."""
    columns = [j for j, name in enumerate(TABLE[0]) if name not in names]
    return [[row[j] for j in columns] for row in TABLE]


WORKBOOKS = {
    "a cover before": {"Cover": COVER, "Data": TABLE},
    "a cover of two texts": {"Cover": [["by Max"], ["for Eva"]], "Data": TABLE},
    "key figures behind": {"Data": TABLE, "Summary": [["", "mean"], ["u", 0.1], ["y", 0.2]]},
    "u and y on a sheet each": {"Cover": COVER, "Input": without("y"), "Output": without("u")},
    "lines of a .csv in one column": {
        "Data": [[",".join(f"{v:.12g}" if k else v for v in row)] for k, row in enumerate(TABLE)]
    },
}  # fmt: skip
for kind, sheets in WORKBOOKS.items():
    log("openpyxl", kind, ".xlsx", tolerance=1e-9)(partial(workbook, sheets=sheets))


def test_the_sheets_of_a_workbook_are_named(tmp_path):
    path = workbook(tmp_path / "log.xlsx", {"Cover": COVER, "Data": TABLE, "Notes": [["a"], ["b"]]})
    read = read_log(path)
    assert read.source == f"{path}, sheet 'Data'"
    assert read.notes == ("read: sheet 'Data'; without a table of numbers: 'Cover', 'Notes'",)
    assert read.notes == inspect_log(path).notes
    with pytest.raises(InputError, match="sheet 'Data' has no 'v', needed as u; it has t, u, y"):
        read_log(path, {"u": "v"})
    bare = workbook(tmp_path / "bare.xlsx", {"Cover": [["a", "b"], [1, 2]], "Data": TABLE[1:]})
    with pytest.raises(InputError, match="sheet 'Data' begins with numbers"):
        read_log(bare)
    assert read_log(bare, columns=["t", "u", "y"]).source == f"{bare}, sheet 'Data'"


def test_a_workbook_of_several_logs_asks_for_a_sheet(tmp_path):
    later = [[*TABLE[0], "r"], *([*row, 0.5] for row in TABLE[1 : N // 2])]
    path = workbook(tmp_path / "log.xlsx", {"Cover": COVER, "Run 1": TABLE, "Run 2": later})
    contents = inspect_log(path)
    assert contents.topics == ("Run 1", "Run 2")
    assert contents.unread.endswith('--names "u=Run 1.u".')
    with pytest.raises(InputError, match=r"2 columns 'u': Run 1.u, Run 2.u. .*'Run 1.u'"):
        read_log(path)
    first, second = (read_log(path, {"u": f"Run {i}.u"}) for i in (1, 2))
    assert first.steps == N and first.r is None  # Run 2.r is of another log
    assert np.array_equal(second.y[:, 0], Y[: N // 2 - 1]) and np.all(second.r == 0.5)
    assert read_log(path, {"y": "Run 2.y"}, time="t").sample_time == 0.1


OCTAVE = {
    "save -v7": ("o.mat", {}), "save -v6": ("o6.mat", {}), "save -v4": ("o4.mat", {}),
    "save of a struct": ("os.mat", {}), "save -hdf5": ("o.h5", {}),
    "csvwrite": ("o.csv", {"columns": ["t", "u", "y"]}),
    "dlmwrite with blanks": ("o.txt", {"columns": ["t", "u", "y"]}),
    "save -ascii": ("oa.dat", {"columns": ["t", "u", "y"]}), "rows of a script": ("or.mat", {}),
}  # fmt: skip


@pytest.mark.parametrize("kind", [*LOGS])
def test_the_signals_of_a_log(tmp_path, kind):
    write, suffix, period, tolerance, options = LOGS[kind]
    path = tmp_path / f"log{suffix}"
    write(path)
    same(read_log(path, **options), period, tolerance)
    contents = inspect_log(path, **options)
    assert not contents.unread and {"u", "y"} <= set(contents.roles)
    assert path.name in contents.report()


@pytest.mark.parametrize("kind", [*FRAMES])
def test_the_signals_of_a_data_frame(kind):
    frame, period = FRAMES[kind]
    same(read_log(frame), period, 1e-12)


@pytest.mark.costly
def test_the_files_of_octave(tmp_path):
    if shutil.which("octave-cli") is None:
        pytest.skip("Octave is not installed")
    lines = zip(T.tolist(), U.tolist(), Y.tolist(), strict=True)
    numbers = ";".join(" ".join(map(repr, line)) for line in lines)
    script = (
        f"M = [{numbers}]; t = M(:, 1); u = M(:, 2); y = M(:, 3);"
        "save -v7 o.mat t u y; save -v6 o6.mat t u y; save -v4 o4.mat t u y; save -hdf5 o.h5 t u y;"
        "s.t = t; s.u = u; s.y = y; save -v7 os.mat s; csvwrite('o.csv', M, 'precision', '%.17g');"
        "dlmwrite('o.txt', M, ' ', 'precision', '%.17g'); save -ascii oa.dat M;"
        "for k = 1:rows(M), uu(k) = u(k); yy(k) = y(k); tt(k) = t(k); end;"
        "u = uu; y = yy; t = tt; save -v7 or.mat t u y; save -text own.txt t u y;"
    )
    subprocess.run(
        ["octave-cli", "-q", "--eval", script], cwd=tmp_path, capture_output=True, check=False
    )
    for name, options in OCTAVE.values():
        same(read_log(tmp_path / name, **options), 0.1, 1e-8)
    with pytest.raises(ValueError, match="Octave's own text format"):
        read_log(tmp_path / "own.txt")


def same(result, period, tolerance):
    assert np.allclose(result.u[:, 0], U, rtol=0, atol=tolerance)
    assert np.allclose(result.y[:, 0], Y, rtol=0, atol=tolerance)
    assert result.sample_time == (None if period is None else pytest.approx(period, rel=1e-6))
    assert not result.missing.any()
    if result.theta is not None:
        assert np.allclose(result.theta, THETA, atol=max(tolerance, 1e-12))


def test_the_number_of_kinds():
    assert len(LOGS) + len(FRAMES) + len(OCTAVE) >= 80


def test_a_packed_text_that_is_damaged_or_too_long(tmp_path):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"u,y\n1,2\n" * 99)[:-9])
    with pytest.raises(ValueError, match=r"damaged \.gz"):
        read_log(path)


def test_a_missing_library_of_logs_is_installed_by_their_extra(monkeypatch, tmp_path):
    path = tmp_path / "log.parquet"
    path.write_bytes(b"PAR1")
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match=r"compensator-theory\[logs\]"):
        read_log(path)


def test_a_clock_of_a_topic_is_not_proposed_as_a_signal(tmp_path):
    path = tmp_path / "flight.ulg"
    path.write_bytes(ulog({"rates": {"timestamp": STAMP, "roll": U.astype("f4")}}))
    with pytest.raises(InputError, match=r"names=\{'u': 'rates.roll'\}"):
        read_log(path)


if __name__ == "__main__":
    names = [*LOGS, *(f"pandas: {k}" for k in FRAMES), *(f"Octave: {k}" for k in OCTAVE)]
    print("\n".join(f"{i:3} {name}" for i, name in enumerate(names, 1)))


@pytest.mark.parametrize(
    "frame",
    [
        pd.DataFrame(), pd.DataFrame({"t": [], "u": [], "y": []}),
        pd.DataFrame({"u": [], "y": []}, index=pd.DatetimeIndex([])),
        pd.DataFrame({"Time": pd.to_datetime([]), "u": [], "y": []}),
    ],
)  # fmt: skip
@pytest.mark.parametrize("read", [read_log, inspect_log])
def test_a_data_frame_without_rows(frame, read):
    with pytest.raises(InputError, match="the DataFrame has no row"):
        read(frame)


@pytest.mark.parametrize("at", [0, 20, 49])
def test_a_text_in_a_data_frame_is_quoted_with_its_row(at):
    texts = ["1.5"] * 50
    for entry, hint in (("Bad Input", ""), ("1,5", "Write decimals with a point")):
        texts[at] = entry
        words = (
            f"row {at + 1}, column TIC203.PV: '{entry}' is not a number.{' ' * bool(hint)}{hint}"
        )
        with pytest.raises(InputError, match=words):
            read_log(pd.DataFrame({"u": range(50), "TIC203.PV": texts}), {"y": "TIC203.PV"})
    texts[at] = "n/a"
    log = read_log(pd.DataFrame({"u": range(50), "TIC203.PV": texts}), {"y": "TIC203.PV"})
    assert np.flatnonzero(log.missing).tolist() == [at]
    clock = inspect_log(pd.DataFrame({"Time": ["0,5"] * 50})).clock
    assert "50 of 50 stamps are no times, the first '0,5' in row 1" in clock.problem
