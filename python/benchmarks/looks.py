"""What each look of the labelled images teaches: a network trained with all looks, with none, and without each in turn.

    python benchmarks/looks.py --out DIR --test SET [--looks NAME,...] [--seeds 3] [--size 256x192] ...

Makes the sets with `robofin dataset images`, trains and evaluates, and writes DIR/looks.md and DIR/looks.json after each
evaluation. What is complete in DIR is kept, so the same command goes on after an interruption. Every seed trains all
rows before the next begins. SET has a `test` split that no set of DIR shows, as that of the independent renderer.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from robofin_perception.differences import Difference, Noise, difference
from robofin_perception.evaluation import NETWORK, Request, evaluate
from robofin_perception.folders import write_json
from robofin_perception.training import Options, train

LOOKS = ("texture", "swirl", "primer", "studio", "optics", "compression", "clear-coat", "dust", "clutter", "heat-tint",
         "rust", "spatter", "table", "tool")
ALL, NONE = "all", "none"


def parser() -> argparse.ArgumentParser:
    """All flags."""
    flags = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    flags.add_argument("--out", type=Path, required=True, metavar="DIR", help="sets, runs, evaluations and the tables")
    flags.add_argument("--test", type=Path, required=True, metavar="SET", help="the set with the test images")
    flags.add_argument("--looks", default=",".join(LOOKS), metavar="NAME,...", help="looks to leave out, each in turn")
    flags.add_argument("--seeds", type=int, default=3, metavar="N", help="trainings of each row (3)")
    flags.add_argument("--size", default="256x192", metavar="WxH", help="of the images (256x192)")
    flags.add_argument("--placements", type=int, default=4, metavar="N", help="of each workpiece (4)")
    flags.add_argument("--limit", type=int, metavar="K", help="images of a set; all by default")
    flags.add_argument("--set-seed", type=int, default=5, metavar="S", help="seed of all sets (5)")
    flags.add_argument("--input", default="256x256", metavar="WxH", help="input of the U-Net (256x256)")
    flags.add_argument("--updates", type=int, default=1500, metavar="N")
    flags.add_argument("--batch", type=int, default=16, metavar="N")
    flags.add_argument("--device", choices=("auto", "cpu", "cuda"), default="auto")
    flags.add_argument("--program", default="robofin", help="the program that makes the sets (robofin)")
    return flags


def rows(left_out: list[str]) -> dict[str, list[str]]:
    """The looks of each row's set, by the row's name."""
    names = {ALL: list(LOOKS), NONE: [NONE]}
    return names | {f"without-{look}": [other for other in LOOKS if other != look] for look in left_out}


def make_set(flags: argparse.Namespace, name: str, looks: list[str]) -> Path:
    """The set of a row, continued if it is not complete."""
    out: Path = flags.out / "sets" / name
    words = [flags.program, "dataset", "images", "--out", out, "--looks", ",".join(looks), "--size", flags.size,
             "--placements", flags.placements, "--seed", flags.set_seed]
    words += ["--limit", flags.limit] if flags.limit else []
    words += ["--resume"] if out.exists() else []
    ended = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if ended.returncode:
        sys.exit(f"{' '.join(map(str, words))}\n{ended.stderr[-2000:]}")
    return out


def measured(flags: argparse.Namespace, name: str, looks: list[str], seed: int) -> dict[str, Any]:
    """The evaluation of a row's network of a seed, read if it exists."""
    run, out = (flags.out / kind / f"{name}-{seed}" for kind in ("runs", "evaluations"))
    found = out / "evaluation.json"
    if found.is_file():
        return dict(json.loads(found.read_text(encoding="utf-8")))
    if not run.exists():
        width, height = map(int, flags.input.split("x"))
        train(Options(make_set(flags, name, looks), updates=flags.updates, batch=flags.batch, seed=seed,
                      size=(width, height), device=flags.device), run)
    return evaluate(Request(str(run), flags.test, device=flags.device), out)


def summary(all_measured: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """Mean IoU of each row and seed, and what is lost without each look; `all` minus `none` for all looks."""
    each = all_measured[ALL][0]["each"]
    groups = {image["id"]: image["group"] for image in each}
    ious = {name: [{image["id"]: image["iou"][NETWORK] for image in one["each"]} for one in seeds]
            for name, seeds in all_measured.items()}
    means = {name: [float(np.mean(list(seed.values()))) for seed in seeds] for name, seeds in ious.items()}
    noise = Noise.of(list(means.values()))
    shares = {name: difference(ious[ALL], ious[name], groups, noise) for name in ious if name != ALL}
    trivial = {name: row["mean_iou"] for name, row in all_measured[ALL][0]["rows"].items() if name != NETWORK}
    return {"images": len(each), "groups": len(set(groups.values())), "mean_iou": means, "trivial": trivial,
            "noise": noise and asdict(noise), "shares": {name: asdict(share) for name, share in shares.items()}}


def markdown(found: dict[str, Any]) -> str:
    """The tables for people."""
    noise = found["noise"]
    words = (f"Seeds differ by {100 * noise['deviation']:.2f} points ({noise['freedom']} degrees of freedom)."
             if noise else "One seed each: no interval.")
    lines = [f"{found['images']} images in {found['groups']} groups. {words}", "",
             "| trained on | mean IoU [%] |", "|---|---|"]
    lines += [f"| {name} | {', '.join(f'{100 * mean:.1f}' for mean in means)} |"
              for name, means in found["mean_iou"].items()]
    lines += [f"| *trivial:* {name} | {100 * mean:.1f} |" for name, mean in found["trivial"].items()]
    lines += ["", "| all looks above | mean IoU [points] | 95 % |", "|---|---|---|"]
    for name, values in found["shares"].items():
        share = Difference(**values)
        interval = "–" if share.low is None or share.high is None else f"{100 * share.low:.1f} to {100 * share.high:.1f}"
        lines.append(f"| {name} | {100 * share.mean:.1f} | {interval} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Runs all that is missing."""
    flags = parser().parse_args()
    left_out = [look for look in flags.looks.split(",") if look]
    if unknown := set(left_out) - set(LOOKS):
        sys.exit(f"--looks {', '.join(sorted(unknown))}: {', '.join(LOOKS)} are accepted")
    flags.out.mkdir(parents=True, exist_ok=True)
    all_measured: dict[str, list[dict[str, Any]]] = {}
    for seed in range(flags.seeds):
        for name, looks in rows(left_out).items():
            all_measured.setdefault(name, []).append(measured(flags, name, looks, seed))
            found = summary(all_measured)
            write_json(flags.out / "looks.json", found)
            (flags.out / "looks.md").write_text(markdown(found), encoding="utf-8")
            print(f"{name}, seed {seed}: {100 * found['mean_iou'][name][-1]:.1f} %", flush=True)
    print(markdown(summary(all_measured)))


if __name__ == "__main__":
    main()
