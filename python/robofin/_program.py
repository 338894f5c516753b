"""The program itself, in this interpreter or as a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from . import _robofin

#: What starts the program again.
START = [sys.executable, "-m", "robofin"]
#: Exit code of a call that is refused.
WRONG_USE = 2

Word = str | os.PathLike[str]


def main() -> None:
    """The entry point `robofin`: runs the command line of this process, on a cluster if it names one, and ends it."""
    words = sys.argv[1:]
    if words[:1] == ["dataset"]:
        from . import _on

        if _on.is_meant(words):
            sys.exit(_on.main(words))
    sys.exit(_robofin.run(["robofin", *words], Path(_robofin.__file__), START))


def run(*words: Word) -> Any:
    """Runs a verb of the program as a process, with `--json`; text for people goes to standard error as it comes.

    Returns its answer: a dict, or a list of them where it prints one a line. Raises `WrongUse` or `RoboFinError` with the
    program's message.

        robofin.run("weld", "part.stl", "--out", "out/part", "--seed", "7")
    """
    command = [*START, *(os.fspath(word) for word in words), "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        answer, told = process.communicate()
    except BaseException:
        process.terminate()
        process.communicate()
        raise
    if process.returncode != 0:
        _, _, message = told.rpartition("error: ")
        kind = _robofin.WrongUse if process.returncode == WRONG_USE else _robofin.RoboFinError
        raise kind(message.strip() or f"robofin ended with code {process.returncode}")
    try:
        return json.loads(answer)
    except json.JSONDecodeError:
        return [json.loads(line) for line in answer.splitlines() if line.strip()]


def answers(answer: Any) -> list[dict[str, Any]]:
    """An answer of `run` as a list of its lines."""
    return answer if isinstance(answer, list) else [answer]


def demo(out: Word = "out/demo", *, force: bool = False) -> Any:
    """Welds, bakes, grinds, draws the bundled bracket, and studies a sealed example. Returns the program's answer.

    Prints the page that was made.
    """
    answer = run("demo", "--out", out, *(["--force"] if force else []))
    print(f"open {Path(out) / 'index.html'}")
    return answer


def dataset(*sources: Word, out: Word, per_part: int = 1, seed: int = 1, difficulty: str = "medium",
            jobs: int | None = None, resume: bool = False, voxel_mm: float | None = None) -> Any:
    """Welds files and folders of parts into a data set of assets, each in a process of its own. Returns the answer."""
    words: list[Word] = ["dataset", *sources, "--out", out, "--per-part", str(per_part), "--seed", str(seed)]
    words += ["--difficulty", difficulty]
    if jobs is not None:
        words += ["--jobs", str(jobs)]
    if voxel_mm is not None:
        words += ["--voxel-mm", str(voxel_mm)]
    return run(*words, *(["--resume"] if resume else []))
