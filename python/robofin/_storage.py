"""Places of results: a folder that machines share, or an address of fsspec such as `s3://bucket/set`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from ._robofin import WrongUse

Word = str | os.PathLike[str]

#: Name of the file that shows that an address can be written.
PROBE = ".robofin"
#: Ends of files of items that a mirror has whole: records and pictures, of which catalogues are made.
WHOLE = (".json", ".jsonl", ".png")


def is_address(place: Word) -> bool:
    """True for an address such as `s3://bucket/set`, false for a folder."""
    return "://" in os.fspath(place)


def open_place(place: Word) -> Folder | Storage:
    """Opens a folder, made if it is missing, or an address. Raises `WrongUse` for an address that cannot be written."""
    if not is_address(place):
        return Folder(Path(place).absolute())
    storage = Storage(os.fspath(place))
    storage.check()
    return storage


class Folder:
    """Files in a folder, which is made if it is missing."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder: Path | None = folder
        self.name = str(folder)
        self._root = folder

    def read(self, name: str) -> str | None:
        """Text of a file; `None` if it does not exist."""
        place = self._root / name
        return place.read_text() if place.is_file() else None

    def write(self, name: str, text: str) -> None:
        """Writes a file whole or not at all."""
        draft = self._root / f".{name}.{os.getpid()}"
        draft.write_text(text)
        draft.replace(self._root / name)

    def publish(self, draft: Path, name: str, last: str) -> None:
        """Moves the folder `name` from a draft on the same file system; it appears whole, with its file `last`."""
        (draft / name).rename(self._root / name)


class Storage:
    """Files below an address; names are relative to it. Keys and endpoints are those of each machine's environment."""

    def __init__(self, address: str) -> None:
        """Opens an address. Raises `WrongUse` if no installed package opens such addresses."""
        try:
            from fsspec.core import url_to_fs
        except ImportError as error:
            raise WrongUse(f'{address}: addresses need fsspec: pip install "robofin[ray]"') from error
        self.folder: Path | None = None
        self.name = address.rstrip("/")
        try:
            # Object stores have no folders; what makes folders there makes buckets, of mistyped names, too.
            options = {"auto_mkdir": True} if self.name.startswith("file:") else {}
            self._files, root = url_to_fs(self.name, **options)
        except (ImportError, ValueError) as error:
            raise WrongUse(f"{address} cannot be opened: {error}") from error
        self._root = root.rstrip("/")

    def check(self) -> None:
        """Writes a file and removes it. Raises `WrongUse` if that fails."""
        try:
            self.write(PROBE, "")
            self.remove([PROBE])
        except Exception as error:
            raise WrongUse(f"{self.name} cannot be written: {error}; check the address, and the keys in the environment"
                           ) from error

    def files(self, below: str = "") -> dict[str, int]:
        """Lengths of the files below a folder by name [bytes]."""
        self._files.invalidate_cache()
        found = self._files.find(self._at(below).rstrip("/"), detail=True)
        return {name[len(self._root) + 1:]: int(about["size"]) for name, about in found.items()}

    def read(self, name: str) -> str | None:
        """Text of a file; `None` if it does not exist."""
        try:
            return bytes(self._files.cat_file(self._at(name))).decode()
        except FileNotFoundError:
            return None

    def write(self, name: str, text: str) -> None:
        """Writes a file."""
        self._files.pipe_file(self._at(name), text.encode())

    def publish(self, draft: Path, name: str, last: str) -> None:
        """Copies the folder `name` of a draft, and at last its file `last`."""
        names = [each for each in stamps(draft) if each.startswith(f"{name}/") and each != f"{name}/{last}"]
        self.push(draft, names)
        self.push(draft, [f"{name}/{last}"])

    def pull(self, names: Iterable[str], folder: Path) -> None:
        """Copies files into a folder."""
        chosen = sorted(names)
        for name in chosen:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if chosen:
            self._files.get([self._at(name) for name in chosen], [str(folder / name) for name in chosen])

    def push(self, folder: Path, names: Iterable[str]) -> None:
        """Copies files of a folder to the address: data of items, then their records, then catalogues."""
        steps: list[list[str]] = [[], [], []]
        for name in sorted(names):
            steps[2 if "/" not in name else int(name.endswith(".json"))].append(name)
        for step in filter(None, steps):
            self._files.put([str(folder / name) for name in step], [self._at(name) for name in step])

    def remove(self, names: Iterable[str]) -> None:
        """Removes files."""
        for name in names:
            self._files.rm_file(self._at(name))

    def _at(self, name: str) -> str:
        return f"{self._root}/{name}"


Place = Folder | Storage


class Mirror:
    """A folder with the names and lengths of the files at an address: records and pictures are whole, others are holes.

    Names, lengths and records are all by which the program decides what is complete.
    """

    def __init__(self, storage: Storage, folder: Path) -> None:
        self.storage, self.folder = storage, folder
        self._seen: dict[str, tuple[int, int]] = {}
        folder.mkdir()
        self.pull()

    def pull(self) -> None:
        """Fetches what is new at the address."""
        new = {name: length for name, length in self.storage.files().items() if self._is_new(name, length)}
        whole = {name for name in new if "/" not in name or name.endswith(WHOLE)}
        self.storage.pull(whole, self.folder)
        for name, length in new.items():
            if name not in whole:
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                with (self.folder / name).open("wb") as hole:
                    hole.truncate(length)
        self._seen = stamps(self.folder)

    def push(self) -> None:
        """Copies what the program has changed to the address, and removes there what it has removed here."""
        now = stamps(self.folder)
        self.storage.push(self.folder, (name for name, stamp in now.items() if self._seen.get(name) != stamp))
        self.storage.remove(self._seen.keys() - now.keys())
        self._seen = now

    def _is_new(self, name: str, length: int) -> bool:
        place = self.folder / name
        return not place.is_file() or place.stat().st_size != length


def stamps(folder: Path) -> dict[str, tuple[int, int]]:
    """Length and time of change [ns] of the files of a folder by name, without hidden ones such as locks."""
    found = {}
    for place in folder.rglob("*"):
        if place.is_file() and not place.name.startswith("."):
            about = place.stat()
            found[place.relative_to(folder).as_posix()] = (about.st_size, about.st_mtime_ns)
    return found
