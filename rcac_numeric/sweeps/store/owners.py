"""Which process works on a chunk, and whether it is still there."""

from __future__ import annotations

import os
import secrets
import socket
from pathlib import Path


def this_owner() -> str:
    """A name for the work that begins now in this process."""
    pid = os.getpid()
    return f"{_machine()}/{pid}/{_start_of(pid)}/{secrets.token_hex(4)}"


def is_gone(owner: str) -> bool:
    """Whether a process of this machine has ended; of another machine only its lease can tell.

    Examples
    --------
    >>> from rcac_numeric.sweeps.store.owners import is_gone, this_owner
    >>> is_gone(this_owner())
    False
    """
    try:
        machine, pid, start, _ = owner.rsplit("/", 3)
        number = int(pid)
    except ValueError:
        return False
    if machine != _machine():
        return False
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    except OSError:  # of another user
        return False
    return _start_of(number) != start  # its number has been given to another process


def _machine() -> str:
    """The machine since it was started, as processes that can see each other know it."""
    boot = _text("/proc/sys/kernel/random/boot_id")[:8]
    try:
        seen = os.readlink("/proc/self/ns/pid")
    except OSError:
        seen = ""
    return f"{socket.gethostname()}:{boot}:{seen}".replace("/", "_")


def _start_of(pid: int) -> str:
    """When a process was started, in the system's own units; empty where it does not say."""
    after_name = _text(f"/proc/{pid}/stat").rpartition(")")[2].split()
    return after_name[19] if len(after_name) > 19 else ""


def _text(path: str) -> str:
    try:
        return Path(path).read_text()
    except OSError:
        return ""
