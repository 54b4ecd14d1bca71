"""The check of the folder of a study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rcac_experiments.sweeps._folder import CHUNKS, Folder
from rcac_numeric.arrays._values import Value


@dataclass(frozen=True)
class StoreCheck(Value):
    """Result of the check of a store.

    Attributes
    ----------
    path : str
    done, total : int
        Intact stored runs, and runs of the study.
    failed : int
        Failed runs among the intact ones.
    damaged : tuple of (int, int)
        First and last run of each damaged chunk.
    faults : tuple of str
        Description of each damage.
    """

    path: str
    done: int
    total: int
    failed: int
    damaged: tuple[tuple[int, int], ...]
    faults: tuple[str, ...]

    @property
    def is_whole(self) -> bool:
        """Whether nothing is damaged."""
        return not self.faults

    def __str__(self) -> str:
        if not self.total:
            return f"{self.path}: the store contains no study yet; nothing is damaged."
        words = f"{self.path}: {self.done} of {self.total} runs are stored and intact"
        words += f", {self.failed} of them failed" if self.failed else ""
        if self.is_whole:
            return f"{words}; nothing is damaged."
        lost = sum(last - first + 1 for first, last in self.damaged)
        lines = [f"{words}; {lost} are damaged."] if lost else [f"{words}."]
        lines += self.faults
        if lost:
            lines.append("The same `run_study` repeats the damaged runs.")
        return "\n".join(lines)


def check_store(store: str | Path) -> StoreCheck:
    """Compare all files of a store with their digests and with the plan of the study.

    The store is not changed. Missing runs are no damage, and neither is a store without a study, as
    after a sweep that was killed before its first chunk. The same call of `run_study` repeats
    damaged runs.

    Raises
    ------
    StoreError
        If the folder is no store, or if its study is damaged, so that no run can be checked.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_experiments.sweeps import Metric, Study, check_store, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"}, "signals": {"w": {"step": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 50}}
    >>> study, store = Study(base, [], [Metric("steps")]), tempfile.mkdtemp() + "/study"
    >>> _ = run_study(study, store, workers=0)
    >>> check_store(store).is_whole
    True
    >>> chunk = pathlib.Path(store) / "chunks" / "00000001.parquet"
    >>> _ = chunk.write_bytes(chunk.read_bytes().replace(b"completed", b"diverged!"))
    >>> check_store(store).damaged
    ((0, 0),)
    >>> _ = run_study(study, store, workers=0)
    >>> check_store(store).is_whole
    True
    """
    with Folder(store) as opened:
        if opened.is_new:
            return StoreCheck(str(opened.path), 0, 0, 0, (), ())
        total, done, failed = opened.study.plan.runs, 0, 0
        damaged: list[tuple[int, int]] = []
        faults: list[str] = []
        for chunk in opened.read():
            if chunk.fault:
                damaged.append((chunk.first, chunk.last))
                faults.append(chunk.fault_words)
            else:
                done += chunk.last - chunk.first + 1
                failed += chunk.failed
        faults += [
            f"{CHUNKS}/{name} is no chunk of this study, and other readers of {CHUNKS}/*.parquet "
            "would include its rows: move it to another folder"
            for name in opened.strangers()
        ]
    return StoreCheck(str(opened.path), done, total, failed, tuple(damaged), tuple(faults))
