"""The program inside the package."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import robofin


def entry_point() -> str:
    found = shutil.which("robofin", path=str(Path(sys.executable).parent))
    assert found, "the wheel installs `robofin`"
    return found


def test_the_entry_point_is_the_program_with_its_exit_codes() -> None:
    shown = subprocess.run([entry_point(), "--version"], capture_output=True, text=True, check=True)
    assert shown.stdout.split() == ["robofin", robofin.__version__]
    refused = subprocess.run([entry_point(), "weld", "missing.stl", "--out", "x"], capture_output=True, text=True)
    assert refused.returncode == 2 and "missing.stl: no such file" in refused.stderr


def test_a_verb_answers_or_raises_with_the_programs_message() -> None:
    assert robofin.run("effects", "list")
    with pytest.raises(robofin.WrongUse, match="missing.stl: no such file"):
        robofin.run("weld", "missing.stl", "--out", "x")


def test_a_data_set_is_made_by_processes_of_the_package(tmp_path: Path) -> None:
    size = np.array([60.0, 40.0, 6.0])
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]) * size
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    lines = ["# millimetres"] + ["v " + " ".join(map(str, corner)) for corner in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1} {d + 1}" for a, b, c, d in quads]
    (tmp_path / "plate.obj").write_text("\n".join(lines) + "\n")
    robofin.dataset(tmp_path / "plate.obj", out=tmp_path / "set", per_part=2, voxel_mm=1.0, difficulty="easy")
    assets = sorted((tmp_path / "set").rglob("asset.json"))
    assert len(assets) == 2
    assert robofin.Workpiece.from_asset(assets[0].parent).welds


def test_a_comparison_shows_its_report_inline(trials: list[Path], tmp_path: Path) -> None:
    campaign = robofin.Campaign(trials[0])
    report = campaign.compare(tmp_path / "comparison")
    assert report.answer["agrees"] in (True, False) and report.answer["sentence"]
    assert report._repr_html_().startswith("<iframe") and "&lt;html" in report._repr_html_()
    residuals = campaign.residuals(robofin.Model("grinding"))
    (passes,) = residuals.values()
    assert len(passes) == campaign.trials()[0].passes
    assert all(np.nanstd(residual) < 1e-3 for residual in passes)
    with pytest.raises(robofin.WrongUse, match="no such folder"):
        robofin.Campaign(tmp_path / "nothing")
    with pytest.raises(robofin.WrongUse, match="study.json: no such file"):
        robofin.Study.open(tmp_path)
