"""The package against the program: fields, forces and volumes, bit for bit."""

import json
from pathlib import Path

import numpy as np
import pytest

import robofin


def test_three_trials_are_simulated_as_the_program_does(trials: list[Path], tmp_path: Path) -> None:
    assert len(trials) == 3
    for folder in trials:
        out = tmp_path / folder.name
        robofin.run("simulate", folder, "--out", out, "--backend", "cpu")
        answer = json.loads((out / "simulation.json").read_text())
        trial = robofin.Trial.read(folder)
        passes, field = trial.simulate(robofin.Model(trial.process))
        assert [record.removed_volume * 1e9 for record, _ in passes] == answer["removed_by_law_mm3"]
        assert [record.impulse for record, _ in passes] == answer["impulse_ns"]
        assert [record.force_rms_error for record, _ in passes] == answer["force_rms_error_n"]
        for number, (record, scan) in enumerate(passes, start=1):
            assert record.log_csv() == (out / f"pass{number}_log.csv").read_text()
            assert np.isfinite(scan["heights"]).any()
        field.write(tmp_path / f"{folder.name}.nvdb")
        assert (tmp_path / f"{folder.name}.nvdb").read_bytes() == (out / "after.nvdb").read_bytes()


@pytest.fixture(scope="module")
def welded(plate: robofin.Mesh) -> robofin.Workpiece:
    return robofin.weld(plate, seed=3, voxel=5e-4, difficulty="easy", width=6e-3)


def test_a_weld_that_is_saved_is_an_asset_and_is_ground_as_the_program_does(
    welded: robofin.Workpiece, tmp_path: Path
) -> None:
    folder = welded.save(tmp_path / "asset")
    assert robofin.run("validate", folder, "--usd", "off")
    robofin.run("simulate", folder, "--out", tmp_path / "ground", "--passes", "2", "--backend", "cpu")
    answer = json.loads((tmp_path / "ground/grind.json").read_text())
    workpiece = robofin.Workpiece.from_asset(folder)
    assert workpiece.field == welded.field and workpiece.target == welded.target
    tool = robofin.Tool("wheel:radius=50mm,width=20mm")
    path, reach = workpiece.weld_path(tool, 5e-3)
    work = robofin.Simulation(workpiece, tool, robofin.Model("grinding"), search_reach=reach)
    records = [work.run(path), work.run(path.reversed())]
    assert [record.removed_volume * 1e9 for record in records] == answer["removed_by_law_mm3"]
    assert [record.pressure_max * 1e-6 for record in records] == answer["pressure_max_mpa"]
    assert [record.log_csv() for record in records] == [
        (tmp_path / f"ground/pass-{number}.csv").read_text() for number in (1, 2)
    ]
    ground = robofin.Field.read(tmp_path / "ground/ground.nvdb")
    assert np.array_equal(ground.bricks()[1], workpiece.field.bricks()[1])


def test_a_weld_knows_its_curve_and_is_photographed_with_its_labels(welded: robofin.Workpiece) -> None:
    (weld,) = welded.welds
    assert weld["width"] == pytest.approx(6e-3) and weld["position"].shape == weld["normal"].shape
    assert welded.target is not None
    assert welded.field.volume_beyond(welded.target) == pytest.approx(weld["volume"], rel=1e-9)
    picture = robofin.photograph(welded, size=(160, 120), samples=1, elevation=1.2)
    assert picture["rgb"].shape == (120, 160, 3) and picture["depth"].shape == (120, 160)
    shows_part = picture["seen"] == 1
    assert set(np.unique(picture["weld"])) == {0, 1} and np.isfinite(picture["depth"][shows_part]).all()
