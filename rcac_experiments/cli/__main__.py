"""The program `rcac`: Ctrl-C has an answer before anything heavy is imported."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
from collections.abc import Callable  # and nothing of typing, which takes as long as all of these
from contextlib import suppress
from types import FrameType

INTERRUPTED = 130  # as exits.INTERRUPTED, which is not imported yet


def main() -> None:
    """Run the command that the arguments name, and leave with its exit status.

    Half a second goes into the imports of most commands. Nothing is half done by then, so Ctrl-C
    ends the process at once: an exception could be raised where Python can only ignore it, and
    would be a traceback. What is left to Python itself is its own start, and `rcac_numeric`.
    """
    # A shell starts what runs in its background with Ctrl-C ignored, and so it stays.
    is_ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    _answer(is_ignored, _leave)
    gc.disable()  # imports leave nothing to collect, and looking for it takes a tenth of them
    program = importlib.import_module("rcac_experiments.cli._main")
    with suppress(Exception):  # it will come again, where it has an answer
        for name in sys.argv[1:2]:
            importlib.import_module(program.COMMANDS[name][0].partition(":")[0])
    gc.freeze()
    gc.enable()
    try:
        _answer(is_ignored, signal.default_int_handler)
        program.main(prog_name="rcac")
    except KeyboardInterrupt:
        _leave()
    finally:
        _answer(is_ignored, signal.SIG_DFL)  # an exception would be a traceback while Python ends


def _answer(
    is_ignored: bool, handler: Callable[[int, FrameType | None], None] | signal.Handlers
) -> None:
    if not is_ignored:
        signal.signal(signal.SIGINT, handler)


def _leave(number: int = signal.SIGINT, frame: FrameType | None = None) -> None:
    with suppress(OSError):
        os.write(2, b"rcac: interrupted.\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
