"""What tests of clusters share: contents of folders, and processes with all that they started."""

import filecmp
from pathlib import Path

ROOT = Path(__file__).parents[2]
PART = ROOT / "data/bracket.obj"
SET = ["--per-part", "4", "--seed", "7", "--voxel-mm", "1", "--difficulty", "easy"]
IMAGES = ["--workpieces", "panel", "--placements", "1", "--patterns", "spots", "--stages", "2", "--size", "64x48",
          "--voxel-mm", "2"]


def files(folder: Path) -> list[str]:
    """Files below a folder, without locks and temporary ones."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*")
                  if path.is_file() and not path.name.startswith("."))


def assert_same(one: Path, other: Path) -> None:
    """Both folders have the same files with the same bytes."""
    assert files(one) and files(one) == files(other)
    assert filecmp.cmpfiles(one, other, files(one), shallow=False)[1:] == ([], [])


def descendants(process: int) -> list[int]:
    """A process and all that its threads started."""
    try:
        threads = list(Path(f"/proc/{process}/task").iterdir())
        children = [child for thread in threads for child in (thread / "children").read_text().split()]
    except OSError:
        return []
    return [process, *(each for child in children for each in descendants(int(child)))]
