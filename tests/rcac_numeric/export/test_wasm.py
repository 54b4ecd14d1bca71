"""The exported core as WebAssembly: reproducible, and the bits of the host in Node and Chromium."""

import base64
import json
import shutil
import subprocess

import numpy as np
import pytest

import rcac_numeric as rn
from rcac_numeric.export._recording import recorded
from rcac_numeric.export._tables import core_tables
from tests.support import core_builds
from tests.support.ellipsoids import ellipsoid

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.skipif(
        shutil.which("clang") is None or shutil.which("wasm-ld") is None,
        reason="clang and wasm-ld are not installed",
    ),
    pytest.mark.skipif(
        core_builds.compiler() is None, reason="there is no C compiler on this machine"
    ),
]
CASES = {
    "iir": rn.ControllerSettings(
        structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3], [1, 0.3]), update=rn.UD(0.05)
    ),
    "two": rn.ControllerSettings(
        structure=rn.fir(2, l_u=2, l_y=2), update=rn.UD(0.1, lambda_=0.99),
        target=rn.TargetModel(
            np.array([np.zeros((1, 2)), [[1.0, -0.5]]]), [np.eye(1), np.zeros((1, 1))]
        ),
    ),
    "ellipsoid": rn.ControllerSettings(
        structure=rn.iir(5), target=rn.TargetModel([0, 1.0]), update=rn.UD(0.05),
        bounds=ellipsoid(1, 10, center=np.zeros(10)),
    ),
    "fixed": rn.Compensator([[[0.5]], [[-0.2]]], [[[0.1]], [[0.3]], [[0.2]]]),
}  # fmt: skip
DRIVE = """
const core = await load(new Response(Uint8Array.from(atob(MODULE), (c) => c.charCodeAt(0))));
const out = { u: [], theta: null, status: 0 };
for (const row of ROWS) {
  out.u.push(core.step(row[0], row[1], row[2]));
  out.status |= core.status;
  if (out.u.length === 50) core.save();
}
out.theta = core.theta;
core.restore();  // and on from step 50 with the same signals
out.again = ROWS.slice(50).map((row) => core.step(row[0], row[1], row[2]));
"""


def built(path, name):
    """(the module, its JavaScript, what it should answer)."""
    rn.export_controller(CASES[name], path, layout="wasm")
    module = []
    for _ in range(2):
        subprocess.run(["sh", path / "wasm" / "build.sh"], check=True, capture_output=True)
        module.append((path / "wasm" / "rcac.wasm").read_bytes())
    assert module[0] == module[1]
    script = (path / "wasm" / "rcac.js").read_text().replace("export ", "")
    recording = recorded(CASES[name], core_tables(CASES[name]))
    rows = [
        [list(v) for v in row] for row in zip(recording.y, recording.z, recording.r, strict=True)
    ]
    head = f"const MODULE = {json.dumps(base64.b64encode(module[0]).decode())};\n"
    head += f"const ROWS = {json.dumps(rows)};\n"
    return module[0], script + head + DRIVE, recording


def agree(answer, recording, name):
    assert answer["status"] == (core_builds.BOUNDED if name == "ellipsoid" else 0)
    assert np.array(answer["u"]).tobytes() == recording.u.tobytes()
    assert np.array(answer["theta"]).tobytes() == recording.theta.tobytes()
    assert np.array(answer["again"]).tobytes() == recording.u[50:].tobytes()


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("name", CASES)
def test_the_bits_in_chromium(tmp_path, name):
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="needs playwright: pip install it"
    )
    if CHROMIUM is None:
        pytest.skip("there is no Chromium on this machine")
    module, script, recording = built(tmp_path, name)
    assert len(module) < 9000
    flags = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags)
        page = browser.new_page()
        answer = page.evaluate(f"async () => {{ {script}; return JSON.stringify(out); }}")
        browser.close()
    agree(json.loads(answer), recording, name)


@pytest.mark.costly
@pytest.mark.skipif(shutil.which("node") is None, reason="Node is not installed")
@pytest.mark.parametrize("name", ["iir", "ellipsoid"])
def test_the_bits_in_node(tmp_path, name):
    _, script, recording = built(tmp_path, name)
    (tmp_path / "drive.mjs").write_text(script + "console.log(JSON.stringify(out));")
    out = subprocess.run(
        ["node", tmp_path / "drive.mjs"], capture_output=True, text=True, check=True
    ).stdout
    agree(json.loads(out), recording, name)
