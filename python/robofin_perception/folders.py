"""New folders, written aside and renamed when complete."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .errors import PerceptionError, WrongUse


@contextmanager
def new_folder(out: Path) -> Iterator[Path]:
    """A folder to fill, which takes the name `out` at the end; nothing is left of it after an error."""
    if out.exists():
        raise WrongUse(f"--out {out} exists; a new folder is accepted")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    except OSError as error:
        raise WrongUse(f"--out {out} cannot be made: {error}") from None
    try:
        yield aside
        os.chmod(aside, 0o755)
        os.rename(aside, out)
    except OSError as error:
        raise PerceptionError(f"--out {out} cannot be written: {error}") from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def write_json(path: Path, content: Any) -> None:
    """Writes indented JSON."""
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
