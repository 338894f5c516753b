"""The type stubs: strict, and those of the module as it is."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=PACKAGE / "tests")


@pytest.mark.parametrize("package", ["robofin", "robofin_perception"])
def test_the_package_is_strictly_typed(package: str) -> None:
    needed = ["safetensors", "torch", "transformers"] if package == "robofin_perception" else []
    if missing := [name for name in needed if not importlib.util.find_spec(name)]:
        pytest.skip(f"the types of {package} are NOT TESTED: {', '.join(missing)} missing")
    told = run("mypy", "--strict", "--config-file", str(PACKAGE / "pyproject.toml"), "-p", package)
    assert told.returncode == 0, told.stdout


def test_the_stubs_are_those_of_the_module() -> None:
    told = run("mypy.stubtest", "robofin._robofin", "--ignore-missing-stub")
    assert told.returncode == 0, told.stdout
