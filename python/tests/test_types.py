"""The type stubs: strict, and those of the module as it is."""

import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=PACKAGE / "tests")


def test_the_package_is_strictly_typed() -> None:
    told = run("mypy", "--strict", "--config-file", str(PACKAGE / "pyproject.toml"), "-p", "robofin")
    assert told.returncode == 0, told.stdout


def test_the_stubs_are_those_of_the_module() -> None:
    told = run("mypy.stubtest", "robofin._robofin", "--ignore-missing-stub")
    assert told.returncode == 0, told.stdout
