"""The exported FMU under FMPy: valid, and the bits of `Controller` in a closed loop."""

import shutil
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory.errors import InputError
from tests.support import core_builds
from tests.support.core_cases import Loop
from tests.support.ellipsoids import ellipsoid
from tests.support.signals import noise

fmpy = pytest.importorskip("fmpy", reason="needs fmpy: pip install it")
pytestmark = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3]), update=rn.UD(0.05), k_w=3
)
PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
BOUNDED = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3]), update=rn.UD(0.05),
    bounds=ellipsoid(1, 4, center=np.zeros(4)),
)  # fmt: skip


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")


class Slave:
    """An FMU of either version, opened by FMPy."""

    def __init__(self, file, version):
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        self.folder = fmpy.extract(file)
        model = fmpy.read_model_description(file)
        token = model.guid if version == "2.0" else model.instantiationToken
        kind = FMU2Slave if version == "2.0" else FMU3Slave
        self.fmu = kind(
            guid=token, unzipDirectory=self.folder, modelIdentifier="rcac", instanceName="one",
        )  # fmt: skip
        self.version, self.model = version, model
        self.fmu.instantiate()
        if version == "2.0":
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def read(self, name, width=1):
        if self.version == "3.0":
            reference = [v.valueReference for v in self.model.modelVariables if v.name == name]
            return np.array(self.fmu.getFloat64(reference, nValues=width))
        result = [v for v in self.model.modelVariables if v.name.startswith(f"{name}[")]
        return np.array(self.fmu.getReal([v.valueReference for v in result]))

    def write(self, name, values):
        if self.version == "3.0":
            reference = [v.valueReference for v in self.model.modelVariables if v.name == name]
            self.fmu.setFloat64(reference, list(values))
            return
        result = [v for v in self.model.modelVariables if v.name.startswith(f"{name}[")]
        self.fmu.setReal([v.valueReference for v in result], list(values))

    def step(self, k, y, z):
        self.write("y", y)
        self.write("z", z)
        self.fmu.doStep(currentCommunicationPoint=0.1 * k, communicationStepSize=0.1)

    def status(self):
        reference = [v.valueReference for v in self.model.modelVariables if v.name == "status"]
        get = self.fmu.getInt32 if self.version == "3.0" else self.fmu.getInteger
        return get(reference)[0]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


@pytest.mark.costly
@pytest.mark.parametrize("settings", [SETTINGS, BOUNDED], ids=["free", "kept in an ellipsoid"])
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_closed_loop_with_the_digits_of_the_controller(tmp_path, version, settings):
    from fmpy.validation import validate_fmu

    file = rn.export_fmu(settings, tmp_path / "c.fmu", sample_time=0.1, version=version)
    assert validate_fmu(str(file)) == []
    slave, controller = Slave(str(file), version), rn.Controller(settings)
    loop = Loop(PLANT, 0, 1000, 1)
    state = "FMUState" if version == "3.0" else "FMUstate"
    for k in range(1000):
        u = slave.read("u")
        y, z, _ = loop.signals(k)
        assert u.tobytes() == controller.step(y, z).tobytes()
        if k == 500:
            saved, x = (
                (slave.fmu.getFMUState if version == "3.0" else slave.fmu.getFMUstate)(),
                loop.x,
            )
        slave.step(k, y, z)
        loop.move(k, u)
    assert slave.read("theta", 4).tobytes() == controller.theta.tobytes()
    last, loop.x = u, x
    getattr(slave.fmu, f"set{state}")(saved)
    for k in range(500, 1000):
        u = slave.read("u")
        y, z, _ = loop.signals(k)
        slave.step(k, y, z)
        loop.move(k, u)
    assert u.tobytes() == last.tobytes()
    slave.close()


@pytest.mark.costly
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_fmpy_runs_it_with_the_signals_of_a_run(tmp_path, version):
    run = rn.simulate(PLANT, SETTINGS, noise(1, 200, 1))
    file = rn.export_fmu(run, tmp_path / "c.fmu", sample_time=0.1, version=version)
    names = ("y[1]", "z[1]") if version == "2.0" else ("y", "z")
    inputs = np.zeros(200, dtype=[("time", float)] + [(name, float) for name in names])
    inputs[names[0]], inputs[names[1]] = run.y[:, 0], run.z[:, 0]
    inputs["time"] = 0.1 * np.arange(200)
    files = [file]
    if shutil.which("cmake"):
        files.append(built_from_its_sources(file, tmp_path / "built.fmu"))
    for one in files:
        out = fmpy.simulate_fmu(
            str(one), stop_time=19.9, step_size=0.1, output_interval=0.1, input=inputs,
            output=["u[1]" if version == "2.0" else "u"],
        )  # fmt: skip
        u = out["u[1]" if version == "2.0" else "u"].reshape(-1)
        assert len(u) == 200 and u.tobytes() == run.u[:, 0].tobytes()


def built_from_its_sources(file, target):
    """An FMU without its binary, and what another machine makes of it."""
    with zipfile.ZipFile(file) as argument, zipfile.ZipFile(target, "w") as bare:
        for name in argument.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, argument.read(name))
    subprocess.run(
        [sys.executable, "-m", "fmpy", "compile", target], check=True, capture_output=True
    )
    return target


@pytest.mark.costly
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_supervised_one_goes_on_without_samples_and_says_so(tmp_path, version):
    """Where z is missed it is `Controller` bit for bit; where y is, u stays finite."""
    supervision = rn.Supervision(limit=2.0)
    file = rn.export_fmu(
        SETTINGS, tmp_path / "c.fmu", sample_time=0.1, version=version, supervision=supervision
    )
    slave, controller = Slave(str(file), version), rn.Controller(SETTINGS, supervision)
    loop, rng, noted = Loop(PLANT, 0, 600, 1), np.random.default_rng(0), 0
    for k in range(500):
        u = slave.read("u")
        y, z, _ = loop.signals(k)
        if rng.random() < 0.1:
            z = np.array([np.nan])
        assert u.tobytes() == controller.step(y, z).tobytes()
        slave.step(k, y, z)
        noted |= slave.status()
        loop.move(k, u)
    assert slave.read("theta", 4).tobytes() == controller.theta.tobytes()
    assert "missed sample" in controller.record.troubles and noted & core_builds.MISSED
    assert ("large z" in controller.record.troubles) == bool(noted & core_builds.LARGE_Z)
    for k in range(500, 600):
        slave.step(k, np.array([np.nan]), np.array([np.inf]))
        assert np.isfinite(slave.read("u")).all()
    slave.close()


@pytest.mark.costly
def test_the_same_settings_give_the_same_bytes(tmp_path):
    files = [rn.export_fmu(SETTINGS, tmp_path / f"{i}.fmu", sample_time=0.1) for i in range(2)]
    assert files[0].read_bytes() == files[1].read_bytes()
    names = zipfile.ZipFile(files[0]).namelist()
    assert "sources/rcac.c" in names and "modelDescription.xml" in names


def test_what_an_fmu_cannot_be(tmp_path):
    direct = rn.Compensator([[[0.5]]], [[[0.1]], [[0.2]]])
    for controller, more, words in (
        (direct, {}, "before y"),
        (SETTINGS, {"sample_time": 0.0}, "sample_time"),
        (SETTINGS, {"version": "1.0"}, "1.0"),
    ):
        with pytest.raises(InputError, match=words):
            rn.export_fmu(controller, tmp_path / "c.fmu", **{"sample_time": 0.1, **more})
    with pytest.raises(InputError, match=r"\.fmu"):
        rn.export_fmu(SETTINGS, tmp_path / "c.zip", sample_time=0.1)


@pytest.mark.costly
def test_another_step_is_refused(tmp_path):
    file = rn.export_fmu(SETTINGS, tmp_path / "c.fmu", sample_time=0.1)
    slave = Slave(str(file), "2.0")
    with pytest.raises(Exception, match="failed"):
        slave.fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.05)
    slave.close()
