"""Measures a network on held-out images, beside trivial answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL.Image import Image

from .baselines import otsu, prefers_brighter, usual_side, whole
from .data import BACKGROUND, LABELS, TARGETS, Example, Mask, Record, fingerprint, open_example, read_split
from .errors import WrongUse
from .folders import new_folder, write_json
from .metrics import Counts, Summary, count, summarise
from .runs import CARD, Trained, find_device, read_run, versions
from .sheet import Tile, sheet
from .training import create

FORMAT = "robofin-perception-evaluation/1"
NETWORK = "network"
#: Images in each row of the sheet: the worst, those around the median, the best.
SHOWN = 4

Answer = Callable[[Example], Mask]


@dataclass(frozen=True)
class Request:
    """A network and the images on which it is evaluated. Labels and target are by default those of the run."""

    run: str
    data: Path
    split: str = "test"
    labels: str | None = None
    target: str | None = None
    device: str = "auto"


def open_network(request: Request) -> Trained:
    """The network of a run folder, or one by name that was not fine-tuned."""
    folder = Path(request.run)
    if request.run == "unet":
        raise WrongUse("--run unet is a network without weights; the folder of a run is accepted")
    if (folder / CARD).is_file():
        trained = read_run(folder)
        if request.target and request.target != trained.target:
            raise WrongUse(f"--target {request.target}: {folder} was trained for {trained.target}, which is accepted")
        labels = request.labels or trained.labels
    else:
        labels = request.labels or LABELS[0]
        trained = Trained(request.run, create(request.run, 0), labels, request.target or "sanded")
    trained.segmenter.to(find_device(request.device)).eval()
    return Trained(trained.name, trained.segmenter, labels, trained.target)


def trivial(request: Request, trained: Trained) -> dict[str, Answer]:
    """The trivial answers. Which side of a threshold to take is learned from the training images, if there are any."""
    wanted = TARGETS[trained.target]
    brighter = usual_side(wanted)
    if (request.data / "train" / "metadata.jsonl").is_file():
        records = read_split(request.data, "train", trained.labels)
        brighter = prefers_brighter(map(open_example, records), wanted)
    side = "brighter" if brighter else "darker"
    return {
        "all of the workpiece": whole,
        f"Otsu in the box, {side}": lambda example: otsu(example, brighter, example.inside()),
        f"Otsu on the workpiece, {side}": lambda example: otsu(example, brighter, example.label != BACKGROUND),
    }


def evaluate(request: Request, out: Path) -> dict[str, Any]:
    """Measures a network and writes the evaluation's folder. Returns the content of `evaluation.json`."""
    trained = open_network(request)
    records = read_split(request.data, request.split, trained.labels)
    wanted = TARGETS[trained.target]
    answers: dict[str, Answer] = {NETWORK: trained.segmenter.predict} | trivial(request, trained)
    with new_folder(out) as folder:
        counts: dict[str, list[Counts]] = {name: [] for name in answers}
        for record in records:
            example = open_example(record)
            for name, answer in answers.items():
                counts[name].append(count(answer(example), example.label, wanted))
        content = _content(request, trained, records, counts)
        write_json(folder / "evaluation.json", content)
        (folder / "evaluation.md").write_text(markdown(content), encoding="utf-8")
        _draw(trained, records, counts[NETWORK]).save(folder / "overlays.png")
    return content


def _content(request: Request, trained: Trained, records: Sequence[Record],
             counts: dict[str, list[Counts]]) -> dict[str, Any]:
    groups = [record.group for record in records]
    network = counts[NETWORK]
    absent = [each.true + each.missed == 0 for each in network]
    silent = [each.true + each.false == 0 for each in network]
    return {
        "format": FORMAT,
        "run": trained.name,
        "labels": trained.labels,
        "target": trained.target,
        "data": fingerprint(request.data, request.split),
        "versions": versions(),
        "images": len(records),
        "groups": len(set(groups)),
        "empty": {
            "label_and_mask": sum(a and s for a, s in zip(absent, silent, strict=True)),
            "label_only": sum(a and not s for a, s in zip(absent, silent, strict=True)),
            "mask_only": sum(s and not a for a, s in zip(absent, silent, strict=True)),
        },
        "rows": {name: asdict(summarise(each, groups)) for name, each in counts.items()},
        "each": [
            {"id": record.id, "group": record.group,
             "iou": {name: round(each[k].iou, 4) for name, each in counts.items()}}
            for k, record in enumerate(records)
        ],
    }


def markdown(content: dict[str, Any]) -> str:
    """The table for people."""
    empty = content["empty"]
    rows = [row(name, Summary(**figures)) for name, figures in content["rows"].items()]
    return "\n".join([
        f"`{content['run']}`, {content['target']} area, label by {content['labels']}: {content['images']} images of "
        f"`{content['data']['folder']}`, {content['data']['split']}, in {content['groups']} groups.\n",
        HEADER, *rows, "",
        f"Empty in label and mask: {empty['label_and_mask']}; in the label only: {empty['label_only']}; "
        f"in the mask only: {empty['mask_only']}.", ""])


HEADER = """| answer | mean IoU [%] | 95 % | pooled IoU [%] | Dice [%] | precision [%] | recall [%] |
|---|---|---|---|---|---|---|"""


def row(name: str, summary: Summary) -> str:
    """A line of a Markdown table."""
    interval = f"{percent(summary.low)} to {percent(summary.high)}"
    shares = (summary.pooled_iou, summary.dice, summary.precision, summary.recall)
    return f"| {name} | {percent(summary.mean_iou)} | {interval} | {' | '.join(map(percent, shares))} |"


def percent(share: float | None) -> str:
    """A share in percent, or a dash."""
    return "–" if share is None else f"{100 * share:.1f}"


def _draw(trained: Trained, records: Sequence[Record], counts: Sequence[Counts]) -> Image:
    """The worst, the median and the best images, a row each."""
    order = np.argsort([each.iou for each in counts], kind="stable")
    middle = max(0, (len(order) - SHOWN) // 2)
    tiles: list[list[Tile]] = []
    for kind, chosen in (("worst", order[:SHOWN]), ("median", order[middle:middle + SHOWN]), ("best", order[-SHOWN:])):
        tiles.append([])
        for k in chosen:
            example = open_example(records[k])
            caption = f"{kind}: {records[k].id}, IoU {percent(counts[k].iou)} %"
            tiles[-1].append(Tile(caption, example, trained.segmenter.predict(example), TARGETS[trained.target]))
    return sheet(tiles)
