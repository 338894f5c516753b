"""The command `python -m robofin_perception.independent`."""

import argparse
import re
import sys
from importlib.util import find_spec
from pathlib import Path

import robofin

from .plan import SPLITS, STATES

MOST_PIXELS = 4096


def size_of(word: str) -> tuple[int, int]:
    """Width and height of a word such as 320x240."""
    match = re.fullmatch(r"(\d+)x(\d+)", word)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if not all(16 <= side <= MOST_PIXELS for side in size):
        raise argparse.ArgumentTypeError(f"{word}: WIDTHxHEIGHT with 16 to {MOST_PIXELS} pixels a side is accepted")
    return size


def positive(word: str) -> int:
    """A whole number from 1."""
    if not word.isdecimal() or int(word) < 1:
        raise argparse.ArgumentTypeError(f"{word}: a whole number from 1 is accepted")
    return int(word)


def natural(word: str) -> int:
    """A whole number from 0."""
    if not word.isdecimal():
        raise argparse.ArgumentTypeError(f"{word}: a whole number from 0 is accepted")
    return int(word)


def states(word: str) -> int:
    """Pictures of a placement."""
    if not word.isdecimal() or not 1 <= int(word) <= STATES:
        raise argparse.ArgumentTypeError(f"{word}: a whole number from 1 to {STATES} is accepted")
    return int(word)


def parser() -> argparse.ArgumentParser:
    """The options of the command."""
    options = argparse.ArgumentParser(
        prog="python -m robofin_perception.independent",
        description="Renders the workpieces of an image set with Blender's Cycles, with labels.",
    )
    options.add_argument("--data", type=Path, required=True, help="a folder made by `robofin dataset images`")
    options.add_argument("--out", type=Path, required=True, help="the set to make")
    options.add_argument("--count", type=positive, default=200, help="pictures (200)")
    options.add_argument("--size", type=size_of, default=(320, 240), help="pixels (320x240)")
    options.add_argument("--seed", type=natural, default=1, help="of everything that is drawn (1)")
    options.add_argument("--samples", type=positive, default=32, help="samples of each pixel (32)")
    options.add_argument("--states", type=states, default=STATES, help=f"pictures of each placement ({STATES})")
    options.add_argument("--split", choices=SPLITS, help="of all pictures; otherwise placements are divided")
    options.add_argument("--threads", type=natural, default=0, help="threads of Cycles; 0: one for each core (0)")
    options.add_argument("--resume", action="store_true", help="go on with a set that was interrupted")
    return options


def main() -> int:
    """Runs the command; returns its exit code: 0 all pictures exist, 1 something failed, 2 wrong use."""
    chosen = parser().parse_args()
    if find_spec("bpy") is None:
        print("bpy is not installed: pip install 'bpy==4.5.*', which needs exactly Python 3.11", file=sys.stderr)
        return 2
    from .produce import Settings, produce

    try:
        for number, (planned, seconds) in enumerate(produce(Settings(**vars(chosen))), 1):
            print(f"{number} {planned.split}/{planned.id} {seconds:.1f} s", file=sys.stderr, flush=True)
    except robofin.WrongUse as error:
        print(error, file=sys.stderr)
        return 2
    except (robofin.RoboFinError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
