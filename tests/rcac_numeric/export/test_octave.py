"""The MEX gateway in Octave: the bits of the host."""

import shutil
import subprocess

import numpy as np
import pytest

from rcac_numeric import UD, ControllerSettings, TargetModel, export_controller, feedforward, iir
from rcac_numeric.export._recording import recorded
from rcac_numeric.export._tables import core_tables

pytestmark = pytest.mark.skipif(
    shutil.which("octave-cli") is None or shutil.which("mkoctfile") is None,
    reason="Octave is not installed",
)
CASES = {
    "iir": ControllerSettings(
        structure=iir(2), target=TargetModel([0, 1.0, -0.3], [1, 0.3]), update=UD(0.05)
    ),
    "r": ControllerSettings(
        structure=feedforward(2), target=TargetModel([0, 1.0, -0.3]), update=UD(0.05)
    ),
}
# Numbers go through as hexadecimal digits of their bits.
SCRIPT = """
data = {name}; s = rcac_mex(); n = rows(data.y); u = zeros(n, 1);
for k = 1:n
  [u(k), s, theta, status] = rcac_mex(s, data.y(k, :), data.z(k, :), data.r(k, :));
  if status != 0 error("status %d", status); end
end
printf("%s\\n", num2hex([u; theta])');
failed = 0;
try rcac_mex(s, [1 2 3], 1); catch failed += 1; end
try rcac_mex(s(2:end), 1, 1, 1); catch failed += 1; end
try rcac_mex(bitxor(s, uint8(1)), 1, 1, 1); catch failed += 1; end
try rcac_mex(s); catch failed += 1; end
printf("failed %d\\n", failed);
"""


def written(array):
    rows = (" ".join(f"{v!r}" for v in row) for row in array.tolist())
    return f"[{'; '.join(rows)}]" if array.size else f"zeros({len(array)}, 0)"


@pytest.mark.costly
@pytest.mark.parametrize("name", CASES)
def test_the_bits_in_octave(tmp_path, name):
    export_controller(CASES[name], tmp_path, layout="mex")
    command = ["mkoctfile", "--mex", "-Isrc", "mex/rcac_mex.c", "src/rcac.c", "-o", "rcac_mex.mex"]
    subprocess.run(command, check=True, cwd=tmp_path, capture_output=True)
    recording = recorded(CASES[name], core_tables(CASES[name]))
    fields = ", ".join(f'"{n}", {written(getattr(recording, n))}' for n in "yzr")
    (tmp_path / "drive.m").write_text(SCRIPT.replace("{name}", f"struct({fields})"))
    done = subprocess.run(
        ["octave-cli", "--norc", "drive.m"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.split()
    expected = np.concatenate([recording.u[:, 0], recording.theta])
    assert lines[0] == expected.astype(">f8").tobytes().hex()
    assert lines[-2:] == ["failed", "4"]
