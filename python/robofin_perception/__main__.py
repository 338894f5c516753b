"""The command line: train, evaluate, table, export."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import PerceptionError

if TYPE_CHECKING:
    from .training import Options

#: Names in pip of the modules that can be missing.
INSTALLED_AS = {"PIL": "pillow", "segmentation_models_pytorch": "segmentation-models-pytorch"}


#: Formats that `export` writes.
FORMATS = ("bop", "webdataset", "parquet", "croissant")


def whole_number(least: int) -> Callable[[str], int]:
    """Reads whole numbers of at least `least`."""
    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} found, a whole number of at least {least} is accepted")
        return int(text)

    return read


def number(text: str, most: float = math.inf, open_below: bool = True) -> float:
    """Reads a number above 0, or from 0, up to `most`."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not ((0 < value if open_below else 0 <= value) and value <= most) or math.isinf(value):
        accepted = "a number above 0" if open_below else f"a number from 0 to {most:g}"
        raise argparse.ArgumentTypeError(f"{text!r} found, {accepted} is accepted")
    return value


def share(text: str) -> float:
    """Reads a share."""
    return number(text, most=1.0, open_below=False)


def size(text: str) -> tuple[int, int]:
    """Reads WxH."""
    width, _, height = text.partition("x")
    if not all(side.isdecimal() and 16 <= int(side) <= 4096 for side in (width, height)):
        raise argparse.ArgumentTypeError(f"{text!r} found, WxH with sides from 16 to 4096 is accepted, as 256x256")
    return int(width), int(height)


def parser() -> argparse.ArgumentParser:
    """All verbs and flags."""
    program = argparse.ArgumentParser(prog="python -m robofin_perception", description=__doc__, allow_abbrev=False)
    verbs = program.add_subparsers(dest="verb", required=True)
    helps = {"train": "train a network on a set of labelled images", "evaluate": "measure a network on held-out images",
             "table": "measure no training, training on one set and on two",
             "export": "write a set in another format"}
    train, evaluate, table, export = (
        verbs.add_parser(verb, help=text, allow_abbrev=False) for verb, text in helps.items())
    _add_training(train, needs_real=False)
    _add_evaluation(evaluate)
    _add_training(table, needs_real=True)
    _add_export(export)
    return program


def _add_training(verb: argparse.ArgumentParser, needs_real: bool) -> None:
    verb.add_argument("--data", type=Path, required=True, metavar="DIR", help="the set of labelled images")
    verb.add_argument("--real", type=Path, required=needs_real, metavar="DIR", help="a second set, as of real images")
    verb.add_argument("--real-fraction", type=share, default=0.2, metavar="F", help="share of the draws from --real")
    verb.add_argument("--model", default="unet", help="unet, sam2-random, a folder or a hub name of SAM 2")
    verb.add_argument("--updates", type=whole_number(0), default=512, metavar="N")
    verb.add_argument("--batch", type=whole_number(2), default=4, metavar="N", help="images of an update")
    verb.add_argument("--lr", type=number, help="rate; 1e-3 for random weights, 2e-5 for SAM 2")
    verb.add_argument("--seed", type=whole_number(0), default=0, metavar="S")
    verb.add_argument("--size", type=size, metavar="WxH", help="input of the U-Net, 256x256")
    verb.add_argument("--cache", type=Path, metavar="DIR", help="keep SAM 2's encoded images here, not in memory")
    _add_common(verb, "appearance", "sanded")


def _add_evaluation(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--run", required=True, metavar="DIR|MODEL", help="a run folder, or SAM 2 as it is")
    verb.add_argument("--data", type=Path, required=True, metavar="DIR", help="the set of labelled images")
    verb.add_argument("--split", choices=("train", "validation", "test"), default="test")
    _add_common(verb, None, None)


def _add_export(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--data", type=Path, required=True, metavar="DIR", help="the set of labelled images")
    verb.add_argument("--to", choices=FORMATS, required=True, help="the format")
    verb.add_argument("--shard", type=whole_number(1), default=1000, metavar="N",
                      help="images of a file of webdataset and parquet")
    verb.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")


def _add_common(verb: argparse.ArgumentParser, labels: str | None, target: str | None) -> None:
    verb.add_argument("--labels", choices=("appearance", "dose"), default=labels)
    verb.add_argument("--target", choices=("sanded", "unsanded"), default=target, help="the area to mark")
    verb.add_argument("--device", choices=("auto", "cpu", "cuda"), default="auto")
    verb.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")


def _options(values: dict[str, object]) -> Options:
    from .training import Options

    return Options(**values)  # type: ignore[arg-type]


def run(words: Sequence[str]) -> None:
    """Runs a command line."""
    values = vars(parser().parse_args(words))
    verb, out = values.pop("verb"), values.pop("out")
    if verb == "train":
        from .training import train

        card = train(_options(values), out)
        print(f"{out}: {len(card['loss'])} updates in {card['seconds']:.1f} s")
    elif verb == "table":
        from .table import table

        print(table(_options(values), out))
    elif verb == "export":
        from .export import Export, export

        print(f"{out}: {export(Export(**values), out)} images")
    else:
        from .evaluation import Request, evaluate, markdown

        print(markdown(evaluate(Request(**values), out)))


def how_to_install(module: str, verb: str) -> str:
    """The message that says how to install a missing module."""
    name = module.split(".")[0]
    package = INSTALLED_AS.get(name, name)
    if package == "robofin":
        return "robofin is not installed; pip install ./python"
    extra = "export" if verb == "export" else "perception"
    return f'{package} is not installed; pip install "./python[{extra}]", or pip install {package}'


def main(words: Sequence[str] | None = None) -> int:
    """Runs a command line and returns the exit code: 0, 1 for failures, 2 for wrong use."""
    words = sys.argv[1:] if words is None else words
    try:
        run(words)
    except PerceptionError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.code
    except ModuleNotFoundError as error:
        print(f"error: {how_to_install(str(error.name), words[0])}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
