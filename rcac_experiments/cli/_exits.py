"""How every command ends: its exit status, and what is said where it does not end well."""

from __future__ import annotations

import errno
import io
import os
import sys
import traceback
from collections.abc import Callable
from typing import Any, TypeVar

import click

from compensator_theory.errors import Advice, CompensatorError
from rcac_numeric.arrays._wording import printable, shortened

DONE = 0  # what was asked is answered
NO = 1  # the answer is no: a verdict has changed, a log contradicts itself, no control is better
BAD_INPUT = 2  # what was given cannot be used, read, written or held in memory
DIVERGED = 3  # a loop diverged that was not expected to
UNSTABLE = 5  # the loop of a log is unstable
MISSED = 6  # it is stable, and misses the poles that its target asks for
UNDECIDED = 7  # a log does not tell what was asked of it
DEFECT = 4  # rcac itself is at fault
INTERRUPTED = 130  # as of any program that Ctrl-C ends: 128 + SIGINT
CLOSED_PIPE = 141  # 128 + SIGPIPE: who read the output has seen enough

EXIT_STATUS = """
Exit status: 0 done; 1 the answer is no (a verdict has changed, a log contradicts itself, a design
is worse than u = 0); 2 bad input, or what cannot be read or written; 3 a loop diverged
unexpectedly; 4 a defect of rcac; of rcac check 5 the loop is unstable, 6 poles were missed, 7
undecided; 130 interrupted; 141 the output was closed.
"""
# What an option does that is an argument in Python, by function and first argument; a function
# without an argument stands for every argument of it.
AT_THE_SHELL = {
    ("compensator_theory.budget", ""): "--budget {argument}={value}",
    ("ExperimentBudget", ""): "--budget {argument}={value}",
    ("plant_of", "sample_time"): (
        "Sample it first, by the c2d of MATLAB, Octave or python-control, and write it in q"
    ),
    ("polynomial", "variable"): (
        "name it by --variable {value} (rcac place, rcac observer); a plant of RCAC is written in q"
    ),
    ("transfer_function", "variable"): "",
    ("TransferFunction.reduced", ""): "or cancel the factor in the plant",
    ("realisation_is_observer_based", ""): "cancel the common factor",
    ("place_poles", "n_c"): "From --order {value} on",
    ("transfer_matrix", "rows"): (
        'write a transfer function such as "1/(q - 0.5)", or rows of them, "1/q, 0; 0, 2/q" '
        '(in a file [["1/q", 0], [0, "2/q"]])'
    ),
    ("transfer_function", "obj"): 'such as "1/(q + 2)"',
    ("design", "dead_time"): (
        "a dead time is given apart: as --dead-time to rcac design, sampled as 1/q**d"
    ),
    ("check_controller", ""): "rcac check LOG --plant FILE",
    ("Decentralized", "shared_u"): "Write shared_u = true in [[controllers]]",
    ("ClosedLoop.poles", ""): "The poles are in the report",
}
LONGEST = 2000  # characters of a message

Result = TypeVar("Result")


class ClosedPipeError(Exception):
    """Nobody reads the output any more; click answers a BrokenPipeError by itself."""


def piped(call: Callable[[], Result]) -> Result:
    """What `call` returns; a closed pipe is kept from click."""
    try:
        return call()
    except BrokenPipeError:
        raise ClosedPipeError from None


def ended(command: Callable[[], Any]) -> int:
    """Run a command and return its exit status, whatever happens.

    A command returns its status, or nothing for 0. No error leaves this function.
    """
    try:
        status = command()
        sys.stdout.flush()  # here and not when Python ends: a full disk is seen by then
    except BaseException as error:
        return _after(error)
    return status if isinstance(status, int) else DONE


def _after(error: BaseException) -> int:
    """What is said of an error, and the status that it stands for."""
    match error:
        case SystemExit():
            return error.code if isinstance(error.code, int) else NO
        case click.exceptions.Exit():
            return error.exit_code
        case KeyboardInterrupt() | click.Abort():
            return _said("interrupted.", INTERRUPTED)
        case BrokenPipeError() | ClosedPipeError():
            _discard_output()
            return CLOSED_PIPE
        case click.ClickException():
            return _usage(error)
        case CompensatorError():
            return _said(error.message_for(at_the_shell), BAD_INPUT)
        case MemoryError():
            return _said("there is not enough memory for this; ask for less.", BAD_INPUT)
        case OSError() if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO):
            _discard_output()
            return _said(f"the output cannot be written: {error.strerror}.", BAD_INPUT)
    lines = "".join(traceback.format_exception(error))
    click.echo(shortened(printable(lines), 5 * LONGEST), err=True)
    return _said("this is a defect of rcac itself; please report it.", DEFECT)


def at_the_shell(advice: Advice) -> str:
    """The same next step for who writes commands."""
    argument, value = (*advice.arguments, ("", ""))[0]
    words = AT_THE_SHELL.get((advice.function, argument))
    if words is None:
        words = AT_THE_SHELL.get((advice.function, ""))
    return str(advice) if words is None else words.format(argument=argument, value=value)


def _usage(error: click.ClickException) -> int:
    """What click says of a wrong option, with its hint."""
    message = io.StringIO()
    error.show(message)
    click.echo(shortened(printable(message.getvalue()), LONGEST), err=True, nl=False)
    return error.exit_code


def _said(message: str, status: int) -> int:
    try:
        click.echo(f"rcac: {shortened(printable(message), LONGEST)}", err=True)
    except OSError:  # nobody listens
        _discard_output()
    return status


def _discard_output() -> None:
    """Leave nothing for Python to write, and to fail at, when it ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
