"""The exit status of every command, and the message of an error."""

from __future__ import annotations

import errno
import io
import os
import sys
import traceback
from collections.abc import Callable
from typing import Any, TypeVar

import click

from compensator_theory.errors import Advice, CompensatorError, UndecidedError
from rcac_numeric.arrays._wording import printable, shortened

DONE = 0
NO = 1  # a verdict has changed, a log contradicts itself or its model, u = 0 is better
BAD_INPUT = 2  # invalid input, or a file that cannot be read or written, or too little memory
DIVERGED = 3  # a loop diverged unexpectedly
UNSTABLE = 5  # the logged loop is unstable
MISSED = 6  # the logged loop is stable and misses the poles of its target model
UNDECIDED = 7  # the log does not decide the question
DEFECT = 4  # a defect of rcac
INTERRUPTED = 130  # 128 + SIGINT: Ctrl-C
CLOSED_PIPE = 141  # 128 + SIGPIPE: the reader closed the pipe

EXIT_STATUS = """
Exit status: 0 success; 1 the answer is no (a verdict has changed, a log contradicts itself or
leaves its plant open, a design is worse than u = 0); 2 invalid input, or a file that cannot be read
or written; 3 a loop diverged unexpectedly; 4 a defect of rcac; rcac check also returns 5 (unstable
loop), 6 (poles missed) and 7 (undecided); 130 interrupted; 141 output closed.
"""
# The option that replaces an argument of Python, by function and first argument; a function with an
# empty argument stands for all its arguments.
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
        "leave the exponential out and pass its dead time in seconds to rcac design as "
        "--dead-time {value}, or sample it as 1/q**d"
    ),
    ("read_log", "columns"): "Name them with --columns t,u,y",
    ("read_log", "resample"): "resample it with --resample {value}",
    ("read_log", "time"): "take the rows as steps of equal distance with --time none "
    "and --sample-time",
    ("check_controller", ""): "rcac check LOG --plant FILE",
    ("Decentralized", "shared_u"): "Write shared_u = true in [[controllers]]",
    ("ClosedLoop.poles", ""): "The poles are in the report",
}
LONGEST = 2000  # characters of a message

Result = TypeVar("Result")


class ClosedPipeError(Exception):
    """The reader closed the pipe; click would handle a BrokenPipeError itself."""


def piped(call: Callable[[], Result]) -> Result:
    """Return the result of `call`; translate a closed pipe, which click would catch."""
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
        sys.stdout.flush()  # reports a full disk here, and not when Python ends
    except BaseException as error:
        return _after(error)
    return status if isinstance(status, int) else DONE


def _after(error: BaseException) -> int:
    """Print the message of an error, and return its status."""
    match error:
        case SystemExit():
            return error.code if isinstance(error.code, int) else NO
        case click.exceptions.Exit():
            return error.exit_code
        case KeyboardInterrupt() | click.Abort():
            return _report("interrupted.", INTERRUPTED)
        case BrokenPipeError() | ClosedPipeError():
            _discard_output()
            return CLOSED_PIPE
        case click.ClickException():
            return _usage(error)
        case UndecidedError():
            return _report(error.message_for(at_the_shell), NO)
        case CompensatorError():
            return _report(error.message_for(at_the_shell), BAD_INPUT)
        case MemoryError():
            return _report("not enough memory; reduce the problem.", BAD_INPUT)
        case OSError() if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO):
            _discard_output()
            return _report(f"the output cannot be written: {error.strerror}.", BAD_INPUT)
    lines = "".join(traceback.format_exception(error))
    click.echo(shortened(printable(lines), 5 * LONGEST), err=True)
    return _report("this is a defect of rcac itself; please report it.", DEFECT)


def at_the_shell(advice: Advice) -> str:
    """Return the advice in terms of command-line options."""
    argument, value = (*advice.arguments, ("", ""))[0]
    words = AT_THE_SHELL.get((advice.function, argument))
    if words is None:
        words = AT_THE_SHELL.get((advice.function, ""))
    return str(advice) if words is None else words.format(argument=argument, value=value)


def _usage(error: click.ClickException) -> int:
    """Print the message of click about a wrong option, with its hint."""
    message = io.StringIO()
    error.show(message)
    click.echo(shortened(printable(message.getvalue()), LONGEST), err=True, nl=False)
    return error.exit_code


def _report(message: str, status: int) -> int:
    try:
        click.echo(f"rcac: {shortened(printable(message), LONGEST)}", err=True)
    except OSError:  # stderr is closed
        _discard_output()
    return status


def _discard_output() -> None:
    """Discard buffered output, so that Python does not fail to write it at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
