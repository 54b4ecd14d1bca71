"""Saved runs and states as a stranger may write them: right checksums, anything else wrong.

`hostile_file` mutates what the library saved itself, in its structure: types, depths, numbers,
shapes, texts, keys and arrays; the checksum is computed anew, as anybody can. `require_harmless`
opens such a file in every way, and uses what was read.
"""

import copy
import io
import json
import random
import re
import sys
import zipfile
from contextlib import contextmanager

import numpy as np

import rcac_numeric as r
from compensator_theory.errors import CompensatorError
from rcac_numeric.arrays._record_files import KEY, _checksum
from rcac_numeric.arrays._values import fingerprint
from rcac_numeric.engine._states import _checksum as state_checksum
from rcac_numeric.reports._check import check_sheet
from rcac_numeric.reports._terminal import as_text

ESCAPES = "\x1b]0;title\x07\x1b[2J\u202egpj.\r\n<script>alert(1)</script>$\\frac{"
FORBIDDEN = ("os.system", "os.exec", "os.spawn", "os.posix_spawn", "subprocess.Popen",
             "pickle.find_class", "socket.connect", "os.remove", "os.rename")  # fmt: skip
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


class Trap:
    """What unpickles it has executed the file."""

    def __reduce__(self):
        return (sys.exit, ("a file was unpickled",))


def nested(depth, inside=0, kind="tuple"):
    for _ in range(depth):
        inside = {kind: [inside]}
    return inside


DEEP = "thousands of brackets"  # put in as text: no library writes them
ODD = [
    None, True, False, 0, 1, -1, 2, 3, 10**9, 2**31, 2**53, 2**62, 2**63, 10**19, 10**28, -(10**28),
    10**4000, 0.5, -2.5, "", "x", "iir", "u", "completed", "1e400000000", ESCAPES,
    "__import__('os').system('id')", "\ud800", "a" * 5000, [], [[]], {}, [1, 2, 3], {"a": 1},
    {"float": "0x1.8p+0"}, {"float": "0x1.0p+1023"}, {"float": "0x0.0000000000001p-1022"},
    {"float": "0x1p99999"}, {"float": "nan"}, {"float": "inf"}, {"float": "-inf"},
    {"float": "-0x1.8000000000000p-1"}, {"float": "0x0.0p+0"},
    {"float": "1"}, {"fraction": "1/3"}, {"fraction": "1/0"}, {"fraction": "1e400000000"},
    {"fraction": "9" * 3999 + "/7"}, {"fraction": "9" * 10**6}, {"number": "10**10**10"},
    {"number": "1/7"}, {"number": "sqrt(2)"}, {"symbol": "__import__('os').system('id')"},
    {"symbol": "q"}, {"symbol": "lambda"}, {"symbol": ESCAPES}, {"array": "w"}, {"array": "theta"},
    {"array": "part_0"}, {"array": "nothing"}, {"array": ESCAPES}, {"array": KEY},
    {"tuple": []}, {"list": []}, {"dict": []},
    {"tuple": [{"tuple": [5, 9]}]}, {"dict": [[1, 1]]}, {"dict": [["w"]]}, {"dict": [[[], 1]]},
    {"dict": [[{"list": []}, 1]]}, {"dict": [[3, {"float": "0x1.8p-1"}]]},
    {"matrix": [], "shape": [10**13, 0]}, {"matrix": [], "shape": [-3, 0]},
    {"matrix": [], "shape": [0, 0]}, {"matrix": [["1"]], "shape": [1, 1]},
    {"matrix": [["(s+1)**900"]], "shape": [1, 1]}, {"matrix": [["1/3", "2"]], "shape": [1, 2]},
    {"matrix": [["9" * 3000] * 30] * 30, "shape": [30, 30]}, {"matrix": [[]], "shape": [1, 1]},
    {"poly": ["(s+1)**900"] * 200, "variable": "q"}, {"poly": ["1", "-1/2"], "variable": "q"},
    {"poly": ["1"] * 3000, "variable": "z"}, {"poly": [], "variable": "q"},
    {"poly": ["1", "2"], "variable": "__import__('os')"}, {"class": "Popen", "fields": {}},
    {"class": "system", "fields": {"command": "id"}}, {"class": "Records", "fields": {}},
    {"class": "Tap", "fields": {"signal": "u", "component": 0, "delay": 10**5}},
    {"class": "Tap", "fields": {"signal": "y", "component": 0, "delay": 5 * 10**4}},
    {"class": "Plant", "fields": {}}, {"class": "Gradient", "fields": {"step_size": 1}},
    {"class": "Gradient", "fields": {"step_size": {"float": "nan"}}},
    {"class": "FixedController", "fields": {}}, {"class": "TransferFunction", "fields": {}},
    {"class": "Run", "fields": {}}, {"class": "__class__", "fields": {"__init__": 1}},
    {"class": "Normalization", "fields": {"limit": 1}}, nested(40), nested(55, kind="list"),
    nested(100), DEEP, {"tuple": [1] * 1000}, {"tuple": [nested(20)] * 100},
]  # fmt: skip
DTYPES = ["f4", ">f8", "c16", "i8", "i4", "u1", "?", "f2", "U5", "S3", "M8[s]", "O", "g",
          "f8,i4"]  # fmt: skip


def seeds():
    """Runs of every kind, small enough to be mutated ten thousand times, and their files' parts."""
    plant = r.standard_plant("(q - 3/2)/((q - 1/2)*(q - 9/10))")
    settings = r.ControllerSettings(
        structure=r.iir(2), target=r.fir_target(plant), update=r.UD(R_theta=1.0)
    )
    pid = r.ControllerSettings(
        structure=r.pid("PID"), target=r.TargetModel([0, -1.0]), update=r.Covariance(1.0),
        bounds=r.CoefficientBounds(gains={"K_P": (0.0, 5.0)}),
        z_normalization=r.Normalization(2.0), R_u=r.SignalWeight(0.1),
    )  # fmt: skip
    joint = r.ControllerSettings(
        structure=r.iir(1), target=r.TargetModel([0, 1.0]), update=r.JointUD(1.0, n_d=2, rho=2.0)
    )
    window = r.ControllerSettings(
        structure=r.fir(2), target=r.TargetModel([0, 1.0]), freeze=((9, 12),),
        update=r.SlidingWindow(R_theta=1.0, window=3), target_changes={15: r.TargetModel([0, 2.0])},
    )  # fmt: skip
    first = r.standard_plant("1/(q - 1/2)")
    schedule = r.PlantSchedule(
        [
            r.PlantChange(start=0, plant=first),
            r.PlantChange(start=10, plant=r.standard_plant("2/(q - 1/3)"), delay=1),
        ]
    )
    learning = r.ControllerSettings(
        structure=r.iir(2), target=r.DataDriven(order=4, start=20, every=10), update=r.UD(1e-2)
    )
    rng = np.random.default_rng(0)
    w = rng.standard_normal((30, 1))
    with np.errstate(all="ignore"):
        return [
            r.simulate(plant, settings, w),
            r.simulate(plant, settings, w, saturation=r.Saturation(low=-1.0, high=1.0), stride=4),
            r.simulate(first, pid, w, x_0=[0.5]),
            r.simulate(first, joint, w),
            r.simulate(schedule, window, w),
            r.simulate(first, r.Decentralized([window, window], shared_u=True), w),
            r.simulate(first, r.FixedController(r.lqg_controller(first).compensator), w),
            r.simulate(first, learning, rng.standard_normal((60, 1))),
        ]


def parts_of(run, folder):
    """The tree and the arrays in the file of a run."""
    run.save(folder / "seed.npz")
    with np.load(folder / "seed.npz") as data:
        arrays = {name: data[name] for name in data.files}
    signed = json.loads(str(arrays.pop(KEY)[()]))
    return json.loads(signed["record"]), arrays


def places(tree, path=()):
    """Every place in a tree, as the path that leads there."""
    yield path
    pairs = (
        tree.items() if isinstance(tree, dict) else enumerate(tree) if type(tree) is list else ()
    )
    for key, inner in pairs:
        yield from places(inner, (*path, key))


def at(tree, path):
    for key in path:
        tree = tree[key]
    return tree


def mutated_tree(rng, tree, others):
    """A record with one to four things changed."""
    tree = copy.deepcopy(tree)
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        # Small parts as often as large ones: most places lie deep inside.
        path = rng.choice([p for p in places(tree) if p])
        path = path[: rng.randrange(1, len(path) + 1)] if rng.random() < 0.3 else path
        holder, key = at(tree, path[:-1]), path[-1]
        match rng.randrange(8):
            case 0 if isinstance(holder, dict):
                del holder[key]
            case 1 if isinstance(holder, dict):
                holder[rng.choice(["x", "is", "words", "left out", "__class__", ESCAPES])] = (
                    holder.pop(key)
                )
            case 2:
                other = rng.choice(others)
                holder[key] = copy.deepcopy(at(other, rng.choice(list(places(other)))))
            case 3 if isinstance(holder[key], list):
                holder[key] = holder[key] * rng.choice([0, 2, 3, 100])
            case 4 if isinstance(holder[key], int):
                holder[key] = rng.choice([0, -1, 1, 2, 7, 1000, 10**5, 10**9, 10**15, 10**25])
            case 5 if isinstance(holder[key], str):
                holder[key] = rng.choice([ESCAPES, holder[key] + "x", "u", "y", "derived", "r"])
            case 6:
                place = {"float": rng.choice([1e-300, 0.5, -1.0, 2.0, 1e6, 1e300, 1e-5]).hex()}
                holder[key] = place
            case _:
                holder[key] = copy.deepcopy(rng.choice(ODD))
    return tree


def mutated_arrays(rng, arrays):
    """Arrays of other shapes, types, entries and names; some as bytes that claim what is not."""
    arrays = dict(arrays)
    for _ in range(rng.choice([1, 1, 2, 3])):
        name = rng.choice(sorted(arrays))
        value = arrays[name]
        if isinstance(value, bytes):
            continue
        number = rng.choice([0.0, np.nan, np.inf, -np.inf, 1e308, -1e-308, 5e-324, 1e16])
        match rng.randrange(12):
            case 0:
                del arrays[name]
            case 1:
                other = rng.choice(sorted(arrays))
                arrays[name], arrays[other] = arrays[other], arrays[name]
            case 2:
                arrays[rng.choice(["zzz", "part_99", "w", ESCAPES, "../../x", ""])] = value
            case 3:
                arrays[name] = value[: rng.randrange(3)] if value.ndim else value
            case 4:
                arrays[name] = value.reshape(rng.choice([(-1,), (1, -1), (1, 1, -1)]))
            case 5:
                arrays[name] = np.full(value.shape, number)
            case 6 if value.size:
                value = value.copy()
                if value.dtype.kind == "f":
                    value.reshape(-1)[rng.randrange(value.size)] = number
                arrays[name] = value
            case 7:
                kind = rng.choice(DTYPES)
                odd = np.empty(value.shape, "O") if kind == "O" else np.zeros(value.shape, kind)
                if kind == "O":
                    odd.fill(Trap())
                arrays[name] = odd
            case 8:
                shape = rng.choice(
                    [(10**13, 0), (0, 10**9), (10**11,), (2**24,), (0,), (), (1,) * 33, (2**62, 4)]
                )
                header = {"descr": rng.choice(["<f8", "<f8", "|O", "<U1000000", "<f8,<i4"]),
                          "fortran_order": rng.random() < 0.3, "shape": shape}  # fmt: skip
                stream = io.BytesIO()
                np.lib.format.write_array_header_2_0(stream, header)
                arrays[name] = stream.getvalue() + b"\0" * rng.choice([0, 8, 100])
            case 9:
                stream = io.BytesIO()
                np.save(stream, value)
                data = stream.getvalue()
                arrays[name] = data[: rng.randrange(len(data))]
            case 10:
                words = rng.choice(
                    ["(" * 5000, "{" * 9000, "__import__('os').system('id')", "9" * 50]
                )
                head = words.encode() + b"\n"
                arrays[name] = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head
            case _:
                arrays[name] = np.tile(
                    value, (rng.choice([2, 50]),) + (1,) * max(value.ndim - 1, 0)
                )
    return arrays


def write(path, rng, texts, arrays, packed=None):
    """An archive of texts and arrays; `arrays` may hold the bytes of a member as they are."""
    how = zipfile.ZIP_DEFLATED if packed or rng.random() < 0.3 else zipfile.ZIP_STORED
    how = rng.choice([zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2]) if rng.random() < 0.01 else how
    with zipfile.ZipFile(path, "w", how) as archive:
        for name, value in [*texts.items(), *arrays.items()]:
            stream = io.BytesIO()
            if isinstance(value, bytes):
                stream.write(value)
            else:
                np.save(stream, np.asarray(value), allow_pickle=True)
            archive.writestr(f"{name}.npy", stream.getvalue())


def readable(arrays):
    """What the reader will find in them, for the checksum."""
    return {name: value for name, value in arrays.items() if not isinstance(value, bytes)}


def hostile_run(path, rng, parts):
    """Write a run with a right checksum over whatever it holds."""
    tree, arrays = rng.choice(parts)
    others = [one for one, _ in parts]
    if rng.random() < 0.75:
        tree = mutated_tree(rng, tree, others)
    if rng.random() < 0.4:
        arrays = mutated_arrays(rng, arrays)
    text = json.dumps(tree)
    text = text.replace(json.dumps(DEEP), '{"tuple": [' * 5000 + "0" + "]}" * 5000)
    try:
        checksum = _checksum(text, {k: v for k, v in readable(arrays).items() if v.dtype != "O"})
    except (ValueError, TypeError):
        checksum = "0"
    signed = json.dumps({"checksum": checksum, "record": text})
    if rng.random() < 0.03:
        signed = rng.choice(
            ["", "null", "[1, 2]", "[" * 10**5, '{"record": 3}', "9" * 10**6, signed[:-9],
             json.dumps({"checksum": "0", "record": "{"})]
        )  # fmt: skip
    write(path, rng, {KEY: signed}, arrays)


def hostile_state(path, rng, state):
    """Write a state with a right checksum, and the fingerprint of settings that exist."""
    values = state.values.copy()
    bits = values.view(np.int64)
    for _ in range(rng.choice([0, 1, 1, 3])):
        place = rng.randrange(len(bits))
        bits[place] = rng.choice(
            [0, 1, -1, 7, 2**31, 2**62, -(2**62), rng.getrandbits(62), 0x7FF8 << 48, 0x7FF0 << 48]
        )
    values = values[: rng.choice([len(values), len(values), len(values) - 1, 0])]
    k = rng.choice([state.k, state.k, -1, 0, 2**62, 2**63 - 1])
    kind = rng.choice([state.kind] * 5 + ["loop", "controller", ESCAPES, ""])
    scale = rng.choice([state.scale, 0.0, np.nan, np.inf, -1.0, 1e300])
    of = rng.choice([state.fingerprint] * 5 + ["0" * 16, ESCAPES, "x"])
    arrays = {
        "kind": kind, "k": np.array(k), "bits": values.view(np.int64), "fingerprint": of,
        "checksum": state_checksum(kind, k, values, of, float(scale)), "scale": np.array(scale),
    }  # fmt: skip
    arrays = {name: np.asarray(value) for name, value in arrays.items()}
    if rng.random() < 0.4:
        arrays = mutated_arrays(rng, arrays)
    write(path, rng, {}, arrays)


@contextmanager
def watched():
    """Events of the interpreter that no reading of a file may cause."""
    if not _HOOKED:
        sys.addaudithook(_hook)
        _HOOKED.append(True)
    _EVENTS.clear()
    _WATCHING.append(True)
    try:
        yield
    finally:
        _WATCHING.clear()
    assert not _EVENTS, f"reading a file did {_EVENTS}"


_HOOKED, _WATCHING, _EVENTS = [], [], []


def _hook(event, _):
    if _WATCHING and event in FORBIDDEN:
        _EVENTS.append(event)


def require_ours(error, path):
    """What is said of a file is short, names it, and commands no terminal."""
    words = str(error)
    assert str(path) in words and len(words) < 3000, words[:500]
    assert not CONTROL.search(words), repr(words[:500])


def require_harmless_run(path, *, drawn=False):
    """Read a run and use it: refused by an error of ours, or good for what a run is good for."""
    with watched(), np.errstate(all="ignore"):
        try:
            run = r.load_run(path)
        except CompensatorError as error:
            require_ours(error, path)
            return None
        assert not CONTROL.search(repr(run) + str(run))
        assert run == run  # noqa: PLR0124
        assert fingerprint(run) and hash(run) is not None
        for change in run.changes:
            assert not CONTROL.search(str(change))
        with_errors(lambda: poles_of(run))
        health = with_errors(lambda: r.loop_health(run))
        assert health is None or not CONTROL.search(health.report())
        result = with_errors(lambda: as_text(check_sheet(r.check_controller(run))))
        assert result is None or not CONTROL.search(result)
        if run.state is not None:
            more = np.ones((3, run.plant.l_w))
            with_errors(
                lambda: r.simulate(
                    run.plant, run.settings, more, start=run.state, saturation=run.saturation
                )
            )
        if drawn:
            page = with_errors(run._repr_html_)
            assert page is None or ("<script" not in page and not CONTROL.search(page))
    return run


def poles_of(run):
    """Poles of its last controller."""
    return run.compensator.poles()


def with_errors(ask):
    """What a question gives; None where it is refused by an error of ours."""
    try:
        return ask()
    except CompensatorError as error:
        assert len(str(error)) < 3000 and not CONTROL.search(str(error))
        return None


def require_harmless_state(path, resume):
    """Read a state and go on from it."""
    with watched(), np.errstate(all="ignore"):
        try:
            state = r.SavedState.load(path)
        except CompensatorError as error:
            require_ours(error, path)
            return None
        assert not CONTROL.search(repr(state)) and state == state  # noqa: PLR0124
        with_errors(lambda: resume(state))
    return state


def restorable(run):
    """A state of a controller and of a loop, and what goes on from each."""
    w = np.ones((5, run.plant.l_w))
    result = [
        (
            run.state,
            lambda state: r.simulate(
                run.plant, run.settings, w, start=state, saturation=run.saturation
            ),
        )
    ]
    if isinstance(run.settings, r.ControllerSettings):
        controller = r.Controller(run.settings)
        with np.errstate(all="ignore"):
            for k in range(5):
                with_errors(lambda k=k: controller.step(float(k % 3), float(k % 2)))

        def resume(state):
            fresh = r.Controller(run.settings)
            fresh.restore(state)
            return fresh.step(1.0, 1.0)

        result.append((controller.state, resume))
    return [(state, resume) for state, resume in result if state is not None]


def draw(path, seed, parts, states):
    """Write the file of a seed; what reads it."""
    rng = random.Random(seed)
    if rng.random() < 0.7:
        hostile_run(path, rng, parts)
        return lambda: require_harmless_run(path, drawn=seed % 8 == 0)
    state, resume = rng.choice(states)
    hostile_state(path, rng, state)
    return lambda: require_harmless_state(path, resume)
