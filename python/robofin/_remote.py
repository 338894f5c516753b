"""Data sets and images at an address: workers make items in folders of their own and copy them to the address.

The driver keeps a mirror of the set, in which the program starts the set, says what is missing, and writes the catalogue.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ._items import Progress, run_items
from ._program import answers, run
from ._robofin import RoboFinError, WrongUse
from ._storage import Mirror, Storage, stamps

#: A share of a data set that has no items: a run of it checks flags and starts the set.
NO_ITEMS = ("--shard", f"1/{2**32 - 1}")
#: Flags that choose among the items of a part.
CHOICES = ("--per-part", "--item", "--limit")
#: What follows the name of a workpiece, simulation, view or image in the names of its files.
ENDING = re.compile(r"(-instances|-depth|-amodal)?\.\w+$")


def assets(sources: Sequence[str], address: str, flags: Sequence[str], progress: Progress | None) -> Any:
    """A data set of assets at an address. Returns the answer of the program's last run."""
    with _mirror(address) as mirror:
        words = _words(["dataset", *sources], mirror.folder, flags)
        _start(mirror, [*words, *NO_ITEMS])
        planned = answers(run(*words, "--dry-run"))
        missing = [f"{line['index']} {line['source']}" for line in planned if not line["is_there"]]
        run_items(partial(_make_asset, address, without(flags, CHOICES)), missing, progress=progress)
        return _finish(mirror, words)


def images(address: str, flags: Sequence[str], limits: Sequence[str], progress: Progress | None) -> Any:
    """Labelled images at an address. Returns the answer of the program's last run."""
    with _mirror(address) as mirror:
        words = _words(["dataset", "images"], mirror.folder, flags)
        planned = answers(run(*words, *limits, "--dry-run"))
        _start(mirror, [*words, "--only", planned[0]["task"]])
        missing = [line for line in answers(run(*words, *limits, "--dry-run")) if not line["is_there"]]
        needs = {line["task"]: line["needs"] for line in missing}
        make = partial(_make_image, address, list(flags), {line["task"]: line["needs"] for line in planned})
        run_items(make, list(needs), needs=needs, progress=progress)
        return _finish(mirror, [*words, *limits])


@contextmanager
def _mirror(address: str) -> Iterator[Mirror]:
    """A mirror of an address that can be written, for as long as the set is made; messages name the address."""
    storage = Storage(address)
    storage.check()
    with TemporaryDirectory(prefix="robofin-") as scratch:
        folder = Path(scratch) / "set"
        try:
            yield Mirror(storage, folder)
        except RoboFinError as error:
            raise type(error)(str(error).replace(str(folder), storage.name)) from error


def _words(verb: Sequence[str], folder: Path, flags: Sequence[str]) -> list[str]:
    """The command line of a run in a folder."""
    return [*verb, "--out", str(folder), *flags, "--resume", "--jobs", "1"]


def _start(mirror: Mirror, words: Sequence[str]) -> None:
    """Starts a set, or refuses one of other flags, before any work. What fails here is tried again by a worker."""
    try:
        run(*words)
    except WrongUse:
        raise
    except RoboFinError:
        pass
    mirror.push()


def _finish(mirror: Mirror, words: Sequence[str]) -> Any:
    """Fetches what workers have made, tries once more what failed, and writes the catalogue."""
    mirror.pull()
    try:
        return run(*words)
    finally:
        mirror.push()


def _make_asset(address: str, flags: Sequence[str], item: str) -> None:
    """Makes an asset, named by its number and its source, and copies it, or the record of its failure."""
    index, _, source = item.partition(" ")
    with TemporaryDirectory(prefix="robofin-") as scratch:
        folder = Path(scratch) / "set"
        try:
            run(*_words(["dataset", source, "--item", index], folder, flags))
        finally:
            Storage(address).push(folder, (name for name in stamps(folder) if "/" in name))


def _make_image(address: str, flags: Sequence[str], needs: Mapping[str, Sequence[str]], task: str) -> None:
    """Fetches what a task of a set of images needs, does it, and copies its files, or the record of its failure."""
    storage = Storage(address)
    with TemporaryDirectory(prefix="robofin-") as scratch:
        folder = Path(scratch) / "set"
        there = storage.files("fields") | storage.files("views")
        storage.pull(["dataset.json", *(name for name in there if _is_of(name, needs[task]))], folder)
        try:
            run(*_words(["dataset", "images"], folder, flags), "--only", task)
        finally:
            storage.push(folder, (name for name in stamps(folder) if _is_of(name, [task])))


def _is_of(name: str, tasks: Sequence[str]) -> bool:
    """True if a file is that of one of the tasks."""
    return any(ENDING.sub("", part) in tasks for part in name.split("/"))


def without(flags: Sequence[str], left_out: Sequence[str]) -> list[str]:
    """Flags without some of them and their values."""
    kept, words = [], iter(flags)
    for word in words:
        if word in left_out:
            next(words, None)
        elif word.partition("=")[0] not in left_out:
            kept.append(word)
    return kept
