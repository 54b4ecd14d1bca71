"""The exported folder: its bytes, its test, what is refused, and the command."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings

from compensator_theory.errors import BudgetError, DivergedError, InputError
from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    Covariance,
    DataDriven,
    Decentralized,
    FixedController,
    Gradient,
    Normalization,
    Saturation,
    SubspaceForgetting,
    TargetModel,
    export_controller,
    feedforward,
    fir,
    iir,
    simulate,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.export import _building as building
from rcac_numeric.export import _folder as folder
from rcac_numeric.export._recording import recorded
from rcac_numeric.export._tables import core_tables
from tests.support import core_builds
from tests.support.core_cases import core_settings
from tests.support.examples import EXAMPLE_4_7
from tests.support.signals import noise

SETTINGS = ControllerSettings(
    structure=iir(2), target=TargetModel([0, 1.0, -0.3]), update=UD(0.05), k_w=3
)
PLANT = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
compiles = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)


def contents(path):
    return {p.relative_to(path).as_posix(): p.read_bytes() for p in path.rglob("*") if p.is_file()}


@pytest.mark.costly
def test_the_same_settings_give_the_same_bytes(tmp_path):
    layouts = ["c", "arduino", "px4"]
    for name in ("a", "b"):
        exported = export_controller(SETTINGS, tmp_path / name, layout=layouts, real="float32")
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert set(contents(tmp_path / "a")) == set(exported.files)
    other = replace(SETTINGS, k_w=4)
    export_controller(other, tmp_path / "b", layout=layouts, real="float32")
    assert contents(tmp_path / "a") != contents(tmp_path / "b")


def test_a_machine_without_a_compiler_writes_the_same(tmp_path, monkeypatch):
    with_one = export_controller(SETTINGS, tmp_path / "a")
    monkeypatch.setattr(folder, "compiler", lambda: None)
    exported = export_controller(SETTINGS, tmp_path / "b")
    assert not exported.is_verified and "no C compiler" in str(exported)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert with_one.is_verified == (building.compiler() is not None)


@pytest.mark.costly
@pytest.mark.cases(4)
@compiles
@pytest.mark.parametrize("real", ["float64", "float32"])
@pytest.mark.parametrize(
    "controller",
    [
        SETTINGS,
        replace(SETTINGS, update=UD(1e-12, lambda_=0.99), form="filter"),
        ControllerSettings(
            structure=feedforward(2, l_u=2, l_y=1, l_r=2), update=UD(0.1),
            target=TargetModel(
                np.array([np.zeros((1, 2)), [[1.0, 0.5]]]), [np.eye(1), 0.1 * np.eye(1)]
            ),
        ),
        Compensator(0.3 * np.ones((2, 1, 1)), np.ones((3, 1, 2))),
    ],
)  # fmt: skip
def test_the_replay_of_the_folder(tmp_path, controller, real):
    exported = export_controller(controller, tmp_path, real=real)
    assert exported.is_verified
    assert real == "float32" or re.fullmatch(r"\d+ steps: the same bits", exported.replay)
    if real == "float32":  # a fixed controller reads no z
        name = "u" if isinstance(controller, Compensator) else "z"
        rms = re.match(rf"rms {name} (\S+), in float64 (\S+);", exported.agreement)
        assert float(rms[1]) == pytest.approx(float(rms[2]), rel=1e-2) != 0


@pytest.mark.costly
@compiles
def test_a_controller_that_was_changed_by_hand_is_noticed(tmp_path):
    """The positive control of the replay: every table matters."""
    export_controller(SETTINGS, tmp_path)
    config = tmp_path / "src" / "rcac_config.h"
    text = config.read_text()
    for name in ("D_0", "numerators", "theta_0", "regressor", "L"):
        pattern = rf"(rcac_{name}\[\d+\] = \{{\s+)([\d.e-]+)"
        changed = re.sub(pattern, lambda m: m[1] + ("1" if m[2] == "0" else "0.25"), text, count=1)
        assert changed != text
        config.write_text(changed.replace(" 0.25,", " 1,", int(name == "regressor")))
        agrees, message = building.replayed(tmp_path / "src", tmp_path / "test", "rcac")
        assert not agrees, (name, message)
    config.write_text(text)
    assert building.replayed(tmp_path / "src", tmp_path / "test", "rcac")[0]


@compiles
def test_an_export_that_does_not_agree_is_refused(tmp_path, monkeypatch):
    texts = dict(folder.core_texts())
    texts["rcac.c"] = texts["rcac.c"].replace("d * (before[c] / after[c])", "d * 0.999")
    monkeypatch.setattr(folder, "core_texts", lambda: texts)
    with pytest.raises(InputError, match="differs from its source"):
        export_controller(SETTINGS, tmp_path)


@compiles
def test_a_run_with_its_saturation(tmp_path):
    run = simulate(PLANT, SETTINGS, noise(3, 300, 1), saturation=Saturation(low=-0.1, high=0.1))
    exported = export_controller(run, tmp_path)
    assert exported.is_verified and "the run" in (tmp_path / "README.md").read_text()
    vector = (tmp_path / "test" / "rcac_vector.h").read_text()
    assert "0.1" in vector and "held within its bounds" in (tmp_path / "README.md").read_text()


@settings(max_examples=20)
@given(core_settings())
def test_every_controller_of_the_core_has_a_vector(case):
    controller, _ = case
    try:
        result = recorded(controller, core_tables(controller))
    except DivergedError:
        return
    sizes = [a.shape for a in (result.y, result.z, result.r, result.u)]
    widths = [controller.structure.l_y, controller.target.l_z, controller.l_r]
    assert sizes == [(result.steps, width) for width in [*widths, controller.structure.l_u]]
    assert np.isfinite(result.u).all() and result.steps > 0


def test_the_vector_of_a_run_is_a_closed_loop():
    """What the plant answered to other last digits would drive an unstable controller away."""
    run = EXAMPLE_4_7.run(200)
    poles = np.abs(run.compensator.poles())
    result = recorded(run.settings, core_tables(run.settings), run=run)
    assert poles.max() > 1.05 and result.steps == run.steps
    assert np.abs(result.u - run.u[: result.steps]).max() < 1e-6 * np.abs(run.u).max()


@pytest.mark.costly
@compiles
def test_two_controllers_in_one_program(tmp_path):
    other = replace(SETTINGS, structure=fir(3), theta_0=None)
    for prefix, one in (("roll", SETTINGS), ("pitch", other)):
        exported = export_controller(one, tmp_path / prefix, prefix=prefix, layout="px4")
        for name in exported.files:
            text = (tmp_path / prefix / name).read_text()
            assert not re.search(r"\b(rcac|RCAC)_(?!INSTRUCTION_SET)|rcac\.[ch]", text), name
        assert "RCAC_INSTRUCTION_SET=plain" in (tmp_path / prefix / "README.md").read_text()
    (tmp_path / "main.c").write_text(
        '#include "roll.h"\n#include "pitch.h"\nint main(void) { roll_state a; pitch_state b; '
        "roll_init(&a); pitch_init(&b); return ROLL_L_THETA == 4 && PITCH_L_THETA == 3 ? 0 : 1; }"
    )
    sources = [tmp_path / "roll/src/roll.c", tmp_path / "pitch/src/pitch.c", tmp_path / "main.c"]
    program = building.compiled(
        sources, tmp_path / "both", includes=[path.parent for path in sources]
    )
    assert subprocess.run([program], check=False).returncode == 0


@pytest.mark.costly
@compiles
@pytest.mark.skipif(shutil.which("cmake") is None, reason="there is no CMake on this machine")
def test_the_folder_is_a_cmake_package(tmp_path):
    """Built, tested, installed, and found by another project."""
    export_controller(SETTINGS, tmp_path / "core")

    def cmake(*arguments):
        subprocess.run(["cmake", *map(str, arguments)], check=True, capture_output=True)

    cmake(
        "-S", tmp_path / "core", "-B", tmp_path / "build", f"-DCMAKE_INSTALL_PREFIX={tmp_path}/at"
    )
    cmake("--build", tmp_path / "build")
    subprocess.run(
        ["ctest", "--test-dir", str(tmp_path / "build")], check=True, capture_output=True
    )
    log = subprocess.run(
        [tmp_path / "build" / "rcac_example"], check=True, capture_output=True, text=True
    ).stdout
    assert log.splitlines()[0] == "k,u[0],y[0],z[0],theta[0],theta[1],theta[2],theta[3]"
    assert len(log.splitlines()) == 201
    cmake("--install", tmp_path / "build")
    user = tmp_path / "user"
    user.mkdir()
    (user / "main.cpp").write_text(
        "#include <rcac.h>\nint main() { rcac_state s; rcac_init(&s); return 0; }\n"
    )
    for name, result in (
        ("installed", "find_package(rcac 1.0 REQUIRED)"),
        ("beside", f"add_subdirectory({tmp_path}/core rcac)"),
    ):
        (user / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.13...3.31)\nproject(user LANGUAGES CXX)\n{result}\n"
            "add_executable(user main.cpp)\ntarget_link_libraries(user rcac::rcac)\n"
        )
        cmake("-S", user, "-B", user / name, f"-DCMAKE_PREFIX_PATH={tmp_path}/at")
        cmake("--build", user / name)
        assert not list((user / name).rglob("rcac_replay*"))  # another project's tests stay its own


# ---- what the core does not know


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"update": Covariance(0.1)}, "Covariance"),
        ({"update": Gradient(0.1)}, "Gradient"),
        ({"update": UD(0.1, lambda_=SubspaceForgetting(0.9))}, "SubspaceForgetting"),
        ({"reflect_poles": True}, "reflect_poles"),
        ({"R_u": lambda k, y, z, u: 1.0}, "R_u as a function"),
        ({"z_normalization": Normalization(1.0, function="tanh")}, '"tanh"'),
        ({"target": DataDriven(order=4)}, "DataDriven"),
    ],
)
def test_what_the_core_does_not_know_is_refused_by_name(tmp_path, changes, words):
    argument = {"structure": iir(2), "target": TargetModel([0, 1.0]), "update": UD(0.1)}
    with pytest.raises(InputError, match=re.escape(words)):
        export_controller(ControllerSettings(**{**argument, **changes}), tmp_path)
    assert not list(tmp_path.iterdir())


def test_other_arguments_that_do_not_fit(tmp_path):
    changing = replace(SETTINGS, target_changes={9: TargetModel([0, 2.0])})
    for arguments, words in (
        ({"real": "float16"}, "float16"),
        ({"layout": "stm32"}, "stm32"),
        ({"prefix": "Roll-2"}, "Roll-2"),
        ({"live_order": -1}, "live_order"),
        ({"run": 3}, "run"),
        ({"layout": "px4", "prefix": "roll_rate_2"}, "16 at most"),
    ):
        with pytest.raises(InputError, match=words):
            export_controller(SETTINGS, tmp_path, **arguments)
    for wrong in (3, "4.7", None, PLANT):
        with pytest.raises(InputError, match="cannot be exported"):
            export_controller(wrong, tmp_path)
    with pytest.raises(InputError, match="each of its `controllers`"):
        export_controller(Decentralized([SETTINGS]), tmp_path)
    with pytest.raises(InputError, match="target_changes beside live_order"):
        core_tables(changing, live_order=2)
    with pytest.raises(InputError, match="no target model"):
        core_tables(Compensator([[[0.5]]], [[[0.0]], [[1.0]]]), live_order=2)
    with pytest.raises(BudgetError, match="l_theta"):
        core_tables(replace(SETTINGS, structure=fir(500), k_w=500, theta_0=None))
    with pytest.raises(InputError, match="strictly proper"):
        export_controller(
            replace(SETTINGS, target=TargetModel([1.0, 0.5])), tmp_path,
            saturation=Saturation(low=-1),
        )  # fmt: skip


@pytest.mark.costly
def test_the_ranges_of_float32(tmp_path):
    tiny = replace(SETTINGS, update=UD(1e-41))
    with pytest.raises(InputError, match="1e-40"):
        export_controller(tiny, tmp_path, real="float32")
    large = export_controller(replace(SETTINGS, update=UD(1e9)), tmp_path, real="float32")
    small = export_controller(replace(SETTINGS, update=UD(1e-16)), tmp_path, real="float32")
    assert "not tested" in large.warnings[0] and "rounding" in small.warnings[0]
    assert "rounding may decide" in (tmp_path / "README.md").read_text()
    with pytest.raises(InputError, match="below the normal numbers of float32"):
        export_controller(FixedController(Compensator([[[0.5]]], [[[0.0]], [[1e-44]]])), tmp_path,
                          real="float32")  # fmt: skip


# ---- the command


def test_a_name_cannot_bring_code_along(tmp_path):
    """What a structure is called may come from a file, and the export is compiled."""
    evil = replace(iir(2), name="*/ int main(void) { return 7; } /*")
    exported = export_controller(replace(SETTINGS, structure=evil), tmp_path)
    for name in exported.files:
        assert "return 7" not in (tmp_path / name).read_text()
    assert "a table of taps" in (tmp_path / "README.md").read_text()


ARDUINO = """
unsigned long micros(); int analogRead(int); void analogWrite(int, int);
template <class T> T constrain(T x, T a, T b) { return x < a ? a : x > b ? b : x; }
struct Port { void begin(long); void println(const char *); void println(int); };
extern Port Serial;
const int A0 = 14;
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no C compiler on this machine")
def test_the_sketch_is_c_plus_plus(tmp_path):
    """Against what Arduino declares; which board it is for does not matter to the sketch."""
    export_controller(SETTINGS, tmp_path, layout="arduino", prefix="roll")
    (tmp_path / "Arduino.h").write_text(ARDUINO)
    properties = (tmp_path / "library.properties").read_text()
    assert "name=roll" in properties and "includes=roll.h" in properties
    command = [
        "g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++",
        "-include", tmp_path / "Arduino.h", f"-I{tmp_path / 'src'}",
        tmp_path / "examples" / "roll" / "roll.ino",
    ]  # fmt: skip
    subprocess.run(command, check=True)


# What the skeleton uses of PX4, in one header that stands for all.
PX4 = """
#pragma once
#include <stdint.h>
#define __EXPORT
#define PX4_ERR(...) say(__VA_ARGS__)
#define PX4_INFO(...) say(__VA_ARGS__)
#define ORB_ID(name) #name
#define WITHOUT_ITS_BRACKETS(...) __VA_ARGS__
#define DEFINE_PARAMETERS(a, b) \\
    WITHOUT_ITS_BRACKETS a; WITHOUT_ITS_BRACKETS b; void updateParams() {}
void say(const char *, ...) __attribute__((format(printf, 1, 2)));
void px4_usleep(unsigned);
uint64_t hrt_absolute_time();
struct vehicle_angular_velocity_s { uint64_t timestamp, timestamp_sample; float xyz[3]; };
struct vehicle_torque_setpoint_s { uint64_t timestamp, timestamp_sample; float xyz[3]; };
struct parameter_update_s { uint64_t timestamp; };
namespace px4 {
enum class params { ROLL_SW, ROLL_LAMBDA };
namespace wq_configurations { static const int rate_ctrl = 0; }
struct WorkItem {
    WorkItem(const char *, int);
    virtual ~WorkItem();
    void ScheduleNow();
    virtual void Run() = 0;
};
struct atomic_bool {
    bool value;
    atomic_bool(bool first) : value(first) {}
    bool load() const { return value; }
    void store(bool now) { value = now; }
};
}
struct ModuleParams {
    explicit ModuleParams(ModuleParams *) {}
    virtual ~ModuleParams() {}
};
namespace uORB {
struct Subscription {
    Subscription(const char *) {}
    bool updated();
    bool copy(parameter_update_s *);
    bool update(vehicle_angular_velocity_s *);
};
struct SubscriptionCallbackWorkItem : Subscription {
    SubscriptionCallbackWorkItem(px4::WorkItem *, const char *name) : Subscription(name) {}
    bool registerCallback();
    void unregisterCallback();
};
template <class T> struct Publication {
    Publication(const char *) {}
    bool publish(const T &);
};
}
template <px4::params> struct ParamInt { int32_t get() const; };
template <px4::params> struct ParamFloat { float get() const; };
"""
# Starts the module, gives it rates and other parameters, and holds its torques against the core's.
PX4_RUNS = """
#include <string.h>
#include "px4.h"
#include "roll.h"
static px4::WorkItem *item;
static bool fresh, changed, listens;
static float rate, torque, lambda = 1;
static int32_t adapts = 1;
void say(const char *, ...) {}
void px4_usleep(unsigned) {}
uint64_t hrt_absolute_time() { return 0; }
px4::WorkItem::WorkItem(const char *, int) { item = this; }
px4::WorkItem::~WorkItem() { item = nullptr; }
void px4::WorkItem::ScheduleNow() { Run(); }
bool uORB::Subscription::updated() { return changed; }
bool uORB::Subscription::copy(parameter_update_s *) { changed = false; return true; }
bool uORB::Subscription::update(vehicle_angular_velocity_s *rates) {
    const bool was = fresh;
    rates->xyz[0] = rate;
    fresh = false;
    return was;
}
bool uORB::SubscriptionCallbackWorkItem::registerCallback() { return listens = true; }
void uORB::SubscriptionCallbackWorkItem::unregisterCallback() { listens = false; }
template <> bool uORB::Publication<vehicle_torque_setpoint_s>::publish(
    const vehicle_torque_setpoint_s &now) { torque = now.xyz[0]; return true; }
template <> int32_t ParamInt<px4::params::ROLL_SW>::get() const { return adapts; }
template <> float ParamFloat<px4::params::ROLL_LAMBDA>::get() const { return lambda; }
extern "C" int roll_main(int argc, char *argv[]);
static int ask(const char *command) {
    char name[] = "roll", word[8];
    char *words[] = {name, strcpy(word, command)};
    return roll_main(2, words);
}
int main() {
    roll_state s;
    roll_init(&s);
    if (ask("stop") || ask("start") || ask("start") || ask("status") || !listens) return 1;
    for (int k = 0; k < 200; ++k) {
        const float y[] = {(k % 7) * 0.1f - 0.3f};
        float u[1];
        if (k == 30) changed = true; // another parameter, within the planned freeze
        if (k == 100) changed = true, roll_set_lambda(&s, lambda = 0.95f);
        if (k == 150) changed = true, roll_freeze(&s, !(adapts = 0));
        roll_step(&s, y, y, nullptr, u);
        rate = y[0], fresh = true;
        item->Run();
        if (memcmp(u, &torque, sizeof torque)) return 2;
    }
    if (ask("stop") || item || listens) return 3;
    return ask("sing") == 0 || s.theta[0] == 0 ? 4 : 0;
}
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no C compiler on this machine")
def test_the_module_of_px4(tmp_path):
    """Against what it uses of PX4, and with the warnings that PX4 makes errors."""
    planned = replace(SETTINGS, freeze=((20, 40),))
    export_controller(planned, tmp_path, layout="px4", prefix="roll", real="float32")
    px4 = tmp_path / "px4"
    module = (px4 / "roll_module.cpp").read_text()
    for header in re.findall(r"#include <(\S+/\S+)>", module):
        (tmp_path / "stubs" / header).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "stubs" / header).write_text(f'#include "{tmp_path}/px4.h"\n')
    (tmp_path / "px4.h").write_text(PX4)
    (tmp_path / "runs.cpp").write_text(PX4_RUNS)
    parameters = re.findall(r"PARAM_DEFINE_\w+\((\w+)", (px4 / "roll_params.c").read_text())
    assert parameters == re.findall(r"px4::params::(\w+)", module) == ["ROLL_SW", "ROLL_LAMBDA"]
    names = re.findall(r"\S+\.c(?:pp)?\b", (px4 / "CMakeLists.txt").read_text())
    assert names == ["roll_module.cpp", "roll.c"]  # beside each other, as the README copies them
    options = [
        "-Wall", "-Wextra", "-Werror", "-Wshadow", "-Wdouble-promotion", "-Wfloat-equal",
        "-Wno-unused-parameter", '-DMODULE_NAME="roll"', f"-I{tmp_path / 'stubs'}",
        f"-I{tmp_path / 'src'}", "-c",
    ]  # fmt: skip
    plus = ["g++", "-std=gnu++14", "-fno-exceptions", "-fno-rtti", *options]
    subprocess.run([*plus, px4 / "roll_module.cpp"], check=True, cwd=tmp_path)
    subprocess.run([*plus, "-Wno-float-equal", "runs.cpp"], check=True, cwd=tmp_path)
    subprocess.run(["gcc", "-std=gnu11", *options, "src/roll.c"], check=True, cwd=tmp_path)
    objects = ["roll_module.o", "runs.o", "roll.o"]
    subprocess.run(["g++", *objects, "-o", "runs"], check=True, cwd=tmp_path)
    assert subprocess.run([tmp_path / "runs"], check=False, timeout=20).returncode == 0
