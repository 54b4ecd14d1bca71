"""How every command ends: one status and one sentence, whoever reads, interrupts or is at fault."""

import errno
import importlib
import os
import signal
import subprocess
import sys
import time

import click
import pytest
from click.testing import CliRunner

from compensator_theory.errors import InputError
from rcac_experiments.cli import _exits as exits
from rcac_experiments.cli import _main as main

RCAC = [sys.executable, "-c", "from rcac_experiments.cli._main import main; main()"]
PLACE = ["place", "--plant", "1/s", "--poles=-1,-2"]
OBSERVER = ["observer", "--plant", "1/s", "--compensator", "1/s"]
CHECK = ["check", "examples/octave/rcac_loop.mat", "--n-c", "4"]
QUICK = [
    ["list"],
    ["schema"],
    ["--help"],
    PLACE,
    [*OBSERVER, "--json"],
    CHECK,
    ["verify", "2.2", "--json"],
]


def run(arguments, output):
    command = [*RCAC, *arguments]
    return subprocess.run(command, stdout=output, stderr=subprocess.PIPE, text=True, check=False)


def failing(monkeypatch, error):
    """A command that ends as a defect or a user would end it."""

    @click.command("failing")
    def command():
        raise error

    monkeypatch.setattr(main, "COMMANDS", {"failing": ("a:command", "Fail.")})
    module = type("Module", (), {"command": command})
    monkeypatch.setattr(main.importlib, "import_module", lambda name: module)
    return CliRunner().invoke(main.main, ["failing"])


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (InputError("u is missing."), exits.BAD_INPUT, "rcac: u is missing."),
        (ZeroDivisionError("oh"), exits.DEFECT, "a defect of rcac itself; please report it."),
        (KeyboardInterrupt(), exits.INTERRUPTED, "rcac: interrupted."),
        (MemoryError(), exits.BAD_INPUT, "not enough memory"),
        (OSError(errno.ENOSPC, "No space left on device"), exits.BAD_INPUT, "No space left"),
        (BrokenPipeError(errno.EPIPE, "Broken pipe"), exits.CLOSED_PIPE, ""),
        (SystemExit(3), exits.DIVERGED, ""),
    ],
)
def test_what_an_error_means(monkeypatch, error, status, words):
    result = failing(monkeypatch, error)
    assert result.exit_code == status and words in result.stderr
    assert ("Traceback" in result.stderr) == (status == exits.DEFECT)


def test_messages_are_short_and_command_no_terminal(monkeypatch):
    result = failing(monkeypatch, InputError("\x1b[31m" + "x" * 10**6))
    assert len(result.stderr) < 3000 and "\x1b" not in result.stderr
    wrong = CliRunner().invoke(main.main, ["verify", "1", "--" + "x" * 10**6])
    assert wrong.exit_code == exits.BAD_INPUT and len(wrong.stderr) < 3000


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.parametrize("arguments", QUICK, ids=lambda a: a[0])
def test_a_closed_pipe_is_no_error(arguments):
    """`rcac ... | true`: the reader has gone before the first word."""
    read, write = os.pipe()
    os.close(read)
    ended = run(arguments, write)
    os.close(write)
    assert ended.returncode in (0, 141) and ended.stderr == ""


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a full device")
@pytest.mark.parametrize("arguments", QUICK, ids=lambda a: a[0])
def test_a_full_disk_is_a_sentence(arguments):
    with open("/dev/full", "w") as full:
        ended = run(arguments, full)
    assert ended.returncode == exits.BAD_INPUT
    assert ended.stderr == "rcac: the output cannot be written: No space left on device.\n"


STARTED = """
import os, signal
signal.signal(signal.SIGINT, lambda *_: os._exit(130))  # until main() has an answer of its own
from rcac_experiments.cli.__main__ import main
os.write({begun}, b".")
main()
"""


def test_control_c(in_full, at_a_terminal):
    """At any moment after Python itself, which has words of its own, has started."""
    for delay in [0.0, 0.4, 0.8, 1.5, 3.0] * 10 if in_full else [0.0, 0.8]:
        read, write = os.pipe()
        process = subprocess.Popen(
            [sys.executable, "-c", STARTED.format(begun=write), "verify", "4.6"],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, pass_fds=[write],
        )  # fmt: skip
        os.close(write)
        os.read(read, 1)
        os.close(read)
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate()
        assert process.returncode in (exits.INTERRUPTED, 0), errors
        assert "Traceback" not in errors


@pytest.mark.parametrize(("ignored", "status"), [(False, exits.INTERRUPTED), (True, exits.DONE)])
def test_control_c_while_a_command_is_imported(ignored, status, at_a_terminal):
    """Every import is interrupted; what a shell has put into its background ignores it."""
    code = (
        "import importlib, os, signal\n"
        f"if {ignored}: signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from rcac_experiments.cli.__main__ import main\n"
        "load = importlib.import_module\n"
        "importlib.import_module = lambda name: os.kill(os.getpid(), signal.SIGINT) or load(name)\n"
        "main()"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, "list"], capture_output=True, text=True, check=False
    )
    assert ended.returncode == status
    assert ended.stderr == ("" if ignored else "rcac: interrupted.\n")
    assert bool(ended.stdout) == ignored


def test_the_program_answers_control_c_before_it_imports_anything():
    code = (
        "import sys, rcac_experiments.cli.__main__; print({'typing', 'click'} & set(sys.modules))"
    )
    shown = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path}; {code}"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert shown.stdout == "set()\n"


def test_the_table_of_commands_is_that_of_the_commands():
    """`rcac --help` imports no command, so what it says of each is compared here."""
    for name, (place, help_text) in main.COMMANDS.items():
        module, _, function = place.partition(":")
        command = getattr(importlib.import_module(module), function)
        assert command.name == name
        text = command.help.split("\n")[0].rstrip(".").lower()
        message = help_text.rstrip(".").lower()
        assert set(message.split()) & set(text.split()) - {"a", "the", "is", "that"}, name
    shown = CliRunner().invoke(main.main, ["--help"]).stdout
    assert all(f"\n  {name} " in shown for name in main.COMMANDS)


def test_help_of_a_command_tells_the_statuses():
    for name in main.COMMANDS:
        result = CliRunner().invoke(main.main, [name, "--help"])
        assert result.exit_code == 0 and "4 a defect of rcac" in " ".join(result.stdout.split())


def test_help_is_quick_to_import():
    code = (
        "import sys; from rcac_experiments.cli._main import main\n"
        "main(['--help'], standalone_mode=False); "
        "print({'numpy', 'sympy', 'scipy', 'matplotlib'} & set(sys.modules))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.splitlines()[-1] == "set()"


def placed(poles):
    return CliRunner().invoke(main.main, ["place", "--plant", "1/s", "--poles", poles])


def test_two_numbers_are_not_one():
    """-1 -2 was once read as -3; the reader is that of the exact half."""
    assert "s**2 + 3*s + 2" in placed("-1 -2").stdout
    for same in ("-1+2j, -1-2j", "-1 + 2j, -1 - 2j", "-1+2j,-1-2j", "-1+2j -1-2j", "-1+2i;-1-2i"):
        assert "s**2 + 2*s + 5" in placed(same).stdout
    for poles, words in (("-1 - 2", "'-'"), ("-1 -2, -3", "'-1 -2'"), (",", "empty entry")):
        wrong = placed(poles)
        assert wrong.exit_code == 2 and words in wrong.stderr, wrong.stderr


@pytest.mark.costly
@pytest.mark.parametrize(
    ("command", "limit"),
    [
        (["place", "--plant", "1/(s**30 + 1)", "--poles", ",".join(["-1"] * 59)], "degree"),
        (["observer", "--plant", "1/(s**30 + 1)", "--compensator", "0"], "degree"),
        (["verify", "2.2"], "operations"),
        (["verify", "2.2"], "memory"),
        (["verify", "2.2"], "digits"),
    ],
)
def test_a_budget_can_be_lowered_and_raised(command, limit):
    """An error names the option, whose value then lets the same pass."""
    refused = CliRunner().invoke(main.main, [*command, "--budget", f"{limit}=1"])
    assert refused.exit_code == 2 and f"with --budget {limit}=" in refused.stderr, refused.stderr
    passed = CliRunner().invoke(main.main, [*command, "--budget", f"{limit}=1000000000, degree=99"])
    assert passed.exit_code == 0, passed.stderr


@pytest.mark.parametrize(
    "text", ["degree", "degree=0", "degree=-1", "degree=1e3", "x=2", "degree=2;"]
)
def test_what_is_no_budget(text):
    wrong = CliRunner().invoke(main.main, [*PLACE, "--budget", text])
    assert wrong.exit_code == 2 and "--budget" in wrong.stderr
    assert placed("-1 -2").exit_code == 0, "a limit ends with its command"


@pytest.mark.costly
def test_coefficients_below_the_normal_range_are_no_defect(tmp_path):
    import numpy as np

    log = tmp_path / "log.npz"
    np.savez(log, u=np.zeros(9), y=np.zeros(9), theta=[5e-324] * 4)
    for plant in ("1/(q-0.5)", "(q-0.5)/(q*(q-0.9))", "1/(q-2)"):
        arguments = ["check", str(log), "--n-c", "2", "--plant", plant, "--target", "1/q"]
        assert CliRunner().invoke(main.main, arguments).exit_code == exits.UNDECIDED
        arguments += ["--problem", "standard"]
        expected = exits.UNSTABLE if plant == "1/(q-2)" else exits.DONE
        assert CliRunner().invoke(main.main, arguments).exit_code == expected
