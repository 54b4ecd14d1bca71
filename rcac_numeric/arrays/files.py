"""Files that are replaced as a whole or not at all."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from compensator_theory.errors import InputError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A new file beside `path` to write into, which takes its place when the block ends well.

    Whatever happens in between, a full disk, an exception or a kill, the file that was there
    stays whole. What is no ordinary file, such as a pipe, is written to as it is.

    Raises
    ------
    InputError
        Where the file cannot be written, and why.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric.arrays.files import replacing
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> with replacing(file) as new:
    ...     _ = new.write_text("u,y")
    >>> file.read_text(), len(list(file.parent.iterdir()))
    ('u,y', 1)
    """
    target = Path(os.path.realpath(path))  # a link stays one, and what it points to is replaced
    try:
        if target.exists() and not target.is_file():
            yield target
            return
        mode = _mode(target)
        # The suffix stays: writers of pictures and arrays choose their format by it.
        handle, name = tempfile.mkstemp(target.suffix, f".{target.stem[:40]}.", target.parent)
        os.close(handle)
        try:
            yield Path(name)
            _settle(name, mode)
            os.replace(name, target)
        finally:
            with suppress(OSError):
                os.unlink(name)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}.") from None


def _mode(target: Path) -> int:
    """The permissions of the file that is replaced, or those of any new file."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _settle(name: str, mode: int) -> None:
    """On disk before it is renamed, so that a loss of power leaves one of the two files."""
    os.chmod(name, mode)
    with open(name, "rb") as written:
        os.fsync(written.fileno())
