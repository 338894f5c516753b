"""Campaigns of measured trials, and studies of them with their reports."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._program import Word, run
from ._robofin import Model, Trial, WrongUse

#: Height of a report in a notebook [pixels].
SHOWN = 720


class Report:
    """The answer of a verb, with its report page; a notebook shows the page."""

    def __init__(self, folder: Word, answer: Any) -> None:
        self.folder = Path(folder)
        self.answer = answer

    @property
    def page(self) -> str:
        """The report as HTML that needs no other file."""
        return (self.folder / "report.html").read_text(encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.page, quote=True)
        return f'<iframe srcdoc="{page}" width="100%" height="{SHOWN}" style="border:0"></iframe>'

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self.folder)!r})"


class Study(Report):
    """A study: compare, calibrate, diagnose, add, repeated until nothing more is found."""

    @classmethod
    def open(cls, folder: Word) -> Study:
        """A study that was made before."""
        record = Path(folder) / "study.json"
        if not record.is_file():
            raise WrongUse(f"{record}: no such file; a folder that `robofin study` made is expected")
        return cls(folder, json.loads(record.read_text(encoding="utf-8")))

    @property
    def model(self) -> Model:
        """The model with what was found."""
        return Model.read(self.folder / "model.toml")


class Campaign:
    """A folder of trial folders, one trial folder, or a folder with a table."""

    def __init__(self, folder: Word) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise WrongUse(f"{self.folder}: no such folder")

    def trials(self) -> list[Trial]:
        """The trials, in the order of their names."""
        folders = [self.folder, *sorted(self.folder.iterdir())]
        return [Trial.read(folder) for folder in folders if (folder / "trial.toml").is_file()]

    def residuals(self, model: Model) -> dict[str, list[NDArray[np.float64]]]:
        """Measured minus simulated scans of each trial and pass, shape `[ny, nx]`, as the files have them.

        Heights in m; where a coating was sanded, differences of exposure. NaN where a scan has no value.
        """
        found = {}
        for trial in self.trials():
            passes, _ = trial.simulate(model)
            pairs = zip(trial.scans(), passes, strict=True)
            found[trial.name] = [_values(measured) - _values(seen) for measured, (_, seen) in pairs]
        return found

    def compare(self, out: Word, *, model: Word | None = None, force: bool = False) -> Report:
        """Where a model fails; nothing of it is fitted."""
        return Report(out, self._verb("compare", out, model, force))

    def calibrate(self, out: Word, *, model: Word | None = None, force: bool = False) -> Report:
        """Fits a model, step by step from the base law to its last effect."""
        return Report(out, self._verb("calibrate", out, model, force))

    def diagnose(self, out: Word, *, model: Word | None = None, force: bool = False) -> Report:
        """Which effect the model lacks."""
        return Report(out, self._verb("diagnose", out, model, force))

    def study(self, out: Word, *, model: Word | None = None, force: bool = False) -> Study:
        """The whole course."""
        return Study(out, self._verb("study", out, model, force))

    def attempt(self, formula: str, *, keep: bool = False) -> Any:
        """One hypothesis, a formula with unknown parameters, beside the current model; returns the ledger's entry."""
        return run("try", self.folder, formula, *(["--keep"] if keep else []))

    def _verb(self, verb: str, out: Word, model: Word | None, force: bool) -> Any:
        words: list[Word] = [verb, self.folder, "--out", out]
        if model is not None:
            words += ["--model", model]
        return run(*words, *(["--force"] if force else []))

    def __repr__(self) -> str:
        return f"Campaign({str(self.folder)!r})"


def _values(scan: dict[str, Any]) -> NDArray[np.float64]:
    """The values of a scan."""
    values: NDArray[np.float64] = scan["heights"] if "heights" in scan else scan["exposed"]
    return values
