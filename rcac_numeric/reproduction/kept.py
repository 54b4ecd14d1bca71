"""Cases that are done, kept in a folder so that none is made twice."""

from __future__ import annotations

import hashlib
import io
import json
import pickle
import re
from dataclasses import dataclass
from pathlib import Path

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays.files import replacing, require_readable
from rcac_numeric.arrays.untrusted import parsed_json
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.reports.page.cases import Case


def digest_of(experiment: Experiment) -> str:
    """A name for all that decides the case of an experiment: its data and our version.

    Examples
    --------
    >>> from rcac_numeric import load_example
    >>> from rcac_numeric.reproduction.kept import digest_of
    >>> digest_of(load_example("7.1")) == digest_of(load_example("7.1"))
    True
    """
    data = io.BytesIO()
    pickler = pickle.Pickler(data, protocol=5)
    pickler.fast = True  # no references: whether two equal texts are one object is chance
    pickler.dump(experiment)
    return hashlib.sha256(exact.__version__.encode() + b"\0" + data.getvalue()).hexdigest()


@dataclass(frozen=True, eq=False)
class KeptCases(Value):
    """A folder with one file for each case, replaced whole or not at all.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_numeric import load_example, verify
    >>> from rcac_numeric.reports.page.cases import case_of
    >>> from rcac_numeric.reproduction.kept import KeptCases
    >>> kept, example = KeptCases(tempfile.mkdtemp()), load_example("B.1")
    >>> kept.find(example) is None
    True
    >>> kept.keep(example, case_of(verify(example)))
    >>> kept.find(example).id
    'B.1'
    """

    folder: Path | str

    def find(self, experiment: Experiment) -> Case | None:
        """The case of an experiment; None where it is not there, or of other data."""
        try:
            require_readable(self._file(experiment))
            record = parsed_json(self._file(experiment).read_text("utf-8"))
            if record["digest"] != digest_of(experiment):
                return None
            return Case.from_record(record["case"])
        except (OSError, ValueError, KeyError, TypeError, InputError):
            return None  # a file that is not whole, or not ours: it is made anew

    def keep(self, experiment: Experiment, case: Case) -> None:
        """Write the case of an experiment.

        Raises
        ------
        InputError
            Where the folder cannot be written.
        """
        file = self._file(experiment)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{file.parent} cannot be made: {error.strerror}.") from None
        record = {"digest": digest_of(experiment), "case": case.to_record()}
        with replacing(file) as new:
            new.write_text(json.dumps(record), encoding="utf-8")

    def _file(self, experiment: Experiment) -> Path:
        name = re.sub(r"[^A-Za-z0-9.-]+", "-", experiment.id)[:60] or "case"
        return Path(self.folder) / f"{name}.json"
