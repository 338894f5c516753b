"""The table of a transfer: a network before training, trained on one set, and trained with a share of a second one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from .errors import WrongUse
from .evaluation import HEADER, NETWORK, Request, evaluate, row
from .folders import new_folder, write_json
from .metrics import Summary
from .training import Options, train


def table(options: Options, out: Path) -> str:
    """Trains three times and measures each network on the test images of the second set. Returns the Markdown table.

    `out` gets the runs, the evaluations, `table.md` and `table.json`.
    """
    if options.real is None:
        raise WrongUse("--real is missing; the table measures on the second set's test images")
    share = f"simulated + {100 * options.real_fraction:.0f} % real"
    trainings = {
        "no training": replace(options, real=None, updates=0),
        "simulated": replace(options, real=None),
        share: options,
    }
    rows: dict[str, Any] = {}
    with new_folder(out) as folder:
        for number, (name, each) in enumerate(trainings.items()):
            run = folder / f"run-{number}"
            train(each, run)
            request = Request(str(run), options.real, device=options.device)
            measured = evaluate(request, folder / f"evaluation-{number}")["rows"]
            rows[name] = measured.pop(NETWORK)
        rows |= measured
        write_json(folder / "table.json", rows)
        text = "\n".join([HEADER, *(row(name, Summary(**figures)) for name, figures in rows.items())]) + "\n"
        (folder / "table.md").write_text(text, encoding="utf-8")
    return text
