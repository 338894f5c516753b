"""The independent renderer: rule of the labels, plan, layout, and pictures of known doses."""

import json
import math
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import robofin
from robofin_perception.independent import __main__ as command
from robofin_perception.independent.labels import IGNORE, SANDED, UNSANDED, agreement, code, labels, seen_share
from robofin_perception.independent.plan import STATES, Shares, plan
from robofin_perception.independent.source import SourceSet

WITHOUT_BPY = "NOT TESTED: bpy is not installed (pip install bpy==4.5.*, Python 3.11)"
needs_bpy = pytest.mark.skipif(find_spec("bpy") is None, reason=WITHOUT_BPY)

SIZE = (64, 48)


@pytest.fixture(scope="session")
def source_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A set of the program: the panel at 2 mm, two stages of two paths."""
    folder = tmp_path_factory.mktemp("source") / "set"
    options = "--workpieces panel --voxel-mm 2 --patterns along-x,spiral --stages 3 --placements 1 --size 64x48"
    robofin.run("dataset", "images", "--out", str(folder), *options.split())
    return folder


def test_the_share_seen_is_the_distance_from_the_paint_relative_to_both() -> None:
    unsanded, bare = np.full((1, 4, 3), 0.2, np.float32), np.full((1, 4, 3), 0.6, np.float32)
    bare[0, 3] = 0.2 + 0.059 / math.sqrt(3)
    seen = np.array([[[0.2, 0.2, 0.2], [0.3, 0.3, 0.3], [0.6, 0.6, 0.2], [0.2, 0.2, 0.2]]], np.float32)
    share = seen_share(seen, unsanded, bare)
    np.testing.assert_allclose(share[0, :3], [0.0, 0.25, math.sqrt(2) / (1 + math.sqrt(2))], rtol=1e-5)
    assert np.isnan(share[0, 3])
    codes = code(np.array([[[0.25, 1.0, 9.0]]], np.float32), 0.5)
    np.testing.assert_allclose(codes, [[[0.125 ** (1 / 2.2), 0.5 ** (1 / 2.2), 1.0]]], rtol=1e-6)


def test_classes_have_limits_and_a_border_that_is_ignored() -> None:
    share = np.array([[0.0, 0.0, 0.1, 0.25, 0.26, 0.74, 0.75, 1.0, np.nan, 1.0, 0.0]] * 3, np.float32)
    on_part = np.array([[False] + [True] * 10] * 3)
    expected = [IGNORE, IGNORE, UNSANDED, UNSANDED, IGNORE, IGNORE, SANDED, SANDED, IGNORE, IGNORE, IGNORE]
    np.testing.assert_array_equal(labels(share, on_part), [expected] * 3)
    upright = labels(share.T.copy(), on_part.T.copy())
    np.testing.assert_array_equal(upright.T, [expected] * 3)


def test_agreement_counts_pixels_with_a_class_in_both_labels() -> None:
    one = np.array([[SANDED, UNSANDED, IGNORE, SANDED, 0]], np.uint8)
    other = np.array([[SANDED, SANDED, SANDED, SANDED, 0]], np.uint8)
    assert agreement(one, other) == pytest.approx(2 / 3)
    assert agreement(one, np.zeros_like(one)) is None


def test_pictures_share_cameras_and_splits_have_their_shares(source_folder: Path) -> None:
    source = SourceSet(source_folder)
    pictures = plan(source, 120, 1, Shares())
    assert len({picture.id for picture in pictures}) == 120 and plan(source, 120, 1, Shares()) == pictures
    assert plan(source, 120, 2, Shares()) != pictures
    splits = {(picture.workpiece, picture.placement): picture.split for picture in pictures}
    counts = [list(splits.values()).count(split) for split in ("train", "validation", "test")]
    assert counts == [8, 2, 10] and len(splits) == 20
    kinds = [picture.treatment.kind for picture in pictures]
    assert kinds.count("unsanded") == kinds.count("bare") == 10
    stages = [picture.treatment.name for picture in pictures if picture.treatment.kind == "stage"]
    assert all(15 <= stages.count(f"{pattern}-s{stage}") <= 19 for pattern in source.patterns for stage in (1, 2, 3))


@pytest.mark.parametrize("states", range(1, STATES + 1))
def test_a_set_of_one_split_has_as_many_placements_as_its_states_allow(source_folder: Path, states: int) -> None:
    pictures = plan(SourceSet(source_folder), 60, 1, Shares(states, "test"))
    assert {picture.split for picture in pictures} == {"test"} and len({picture.id for picture in pictures}) == 60
    of = [[picture for picture in pictures if picture.placement == place] for place in range(-(-60 // states))]
    assert [len(each) for each in of] == [states] * (60 // states) + [60 % states] * (60 % states > 0)
    kinds = [picture.treatment.kind for picture in pictures]
    assert 4 <= kinds.count("unsanded") <= 6 and 4 <= kinds.count("bare") <= 6


def test_a_folder_that_is_no_set_is_refused(tmp_path: Path) -> None:
    with pytest.raises(robofin.WrongUse, match=r"--data .*dataset\.json.*robofin dataset images"):
        SourceSet(tmp_path)
    (tmp_path / "dataset.json").write_text('{"format": "robofin-dataset/3"}')
    with pytest.raises(robofin.WrongUse, match=r"robofin-dataset/3; robofin-images/N is accepted"):
        SourceSet(tmp_path)


def test_the_dose_of_a_stage_grows_along_the_path(source_folder: Path) -> None:
    source = SourceSet(source_folder)
    stages = [picture.treatment for picture in plan(source, 60, 1, Shares()) if picture.treatment.pattern == "spiral"]
    doses = {stage.stage: source.dose("panel", stage) for stage in stages}
    assert np.all(doses[1] <= doses[2]) and np.all(doses[2] <= doses[3])
    assert 0 < (doses[1] >= 1).sum() < (doses[3] >= 1).sum() < len(doses[3])


def test_the_command_says_what_is_missing_or_accepted(
    source_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["independent", "--data", str(source_folder), "--out", str(tmp_path / "set")]
    monkeypatch.setattr("sys.argv", words)
    monkeypatch.setattr(command, "find_spec", lambda _: None)
    assert command.main() == 2 and "pip install 'bpy==4.5.*'" in capsys.readouterr().err
    monkeypatch.setattr("sys.argv", [*words, "--size", "3x3"])
    with pytest.raises(SystemExit, match="2"):
        command.main()
    assert "--size: 3x3: WIDTHxHEIGHT with 16 to 4096 pixels a side is accepted" in capsys.readouterr().err
    monkeypatch.setattr("sys.argv", [*words, "--states", "7"])
    with pytest.raises(SystemExit, match="2"):
        command.main()
    assert "--states: 7: a whole number from 1 to 6 is accepted" in capsys.readouterr().err


@needs_bpy
def test_the_dose_label_is_the_known_dose_of_a_half_coated_box(field: robofin.Field, tmp_path: Path) -> None:
    import bpy

    from robofin_perception.independent.produce import developed
    from robofin_perception.independent.render import Raster, render
    from robofin_perception.independent.scene import SceneDraw, build
    from robofin_perception.independent.source import Surface

    mesh = field.surface()
    positions = mesh.positions
    surface = Surface(positions, field.normal(positions), mesh.triangles, np.zeros(len(positions), np.float32))
    draw = SceneDraw.draw("a", "b")
    pose = replace(draw.pose, turn=0.4, lean=0.0, elevation=1.2, azimuth=2.0, fill=0.8, shift=(0.1, -0.2), f_number=0.5)
    draw = replace(draw, pose=pose, clutter=(), finish=replace(draw.finish, paint=(0.6, 0.02, 0.02), dirt=0.0))
    build(draw, surface, np.float32(1.5 * (positions[:, 0] > 0.03)), 4 / 3)
    rendered = render(Raster(SIZE, 4, 1, 1), tmp_path)
    assert all((light[rendered.on_part].sum(axis=1) > 0).all() for light in (rendered.unsanded, rendered.bare))
    made = developed(rendered, draw, tmp_path)
    label = made.labels["dose"]

    # The ray through each pixel's centre meets the upper side, at z = 6 mm, at a known place.
    camera = bpy.context.scene.camera
    axes, eye = np.array(camera.matrix_world)[:3, :3], np.array(camera.matrix_world)[:3, 3]
    slope = math.tan(0.5 * pose.vertical_field_of_view)
    u, v = np.meshgrid((np.arange(64) + 0.5) / 32 - 1, 1 - (np.arange(48) + 0.5) / 24)
    rays = np.stack([u * slope * 4 / 3, v * slope, -np.ones_like(u)], axis=2) @ axes.T
    met = eye + rays * ((0.006 - eye[2]) / rays[:, :, 2])[:, :, None]
    frame = np.linalg.inv(np.array(bpy.data.objects["workpiece"].matrix_world))
    x, y = np.moveaxis(met @ frame[:3, :3].T + frame[:3, 3], 2, 0)[:2]
    top = (abs(x - 0.03) < 0.029) & (abs(y - 0.02) < 0.019)
    assert top.sum() > 500 and rendered.on_part[top].all()
    known = np.isin(label, (SANDED, UNSANDED)) & top & (abs(x - 0.03) > 5e-4)
    np.testing.assert_array_equal(label[known] == SANDED, x[known] > 0.03)
    assert known.sum() > 0.8 * top.sum()
    assert all((made.labels["appearance"][top] == kind).sum() > 0.3 * top.sum() for kind in (SANDED, UNSANDED))
    assert made.record["agreement"] > 0.95 and made.record["exposed_share"] == pytest.approx(0.5, abs=0.1)
    assert not rendered.on_part[(abs(x - 0.03) > 0.045) | (abs(y - 0.02) > 0.035)].any()


@needs_bpy
def test_an_interrupted_set_goes_on_and_has_the_layout(source_folder: Path, tmp_path: Path) -> None:
    from PIL import Image

    from robofin_perception.independent.produce import Settings, produce

    out = tmp_path / "set"
    settings = Settings(source_folder, out, 3, SIZE, 2, 5, STATES, None, 1, False)
    first, _ = next(produce(settings))
    with pytest.raises(robofin.WrongUse, match="--resume"):
        next(produce(settings))
    with pytest.raises(robofin.WrongUse, match="started with samples 2, not 4"):
        next(produce(replace(settings, samples=4, resume=True)))
    rest = [planned for planned, _ in produce(replace(settings, resume=True))]
    assert [first, *rest] == plan(SourceSet(source_folder), 3, 5, Shares())
    assert not list(produce(replace(settings, resume=True)))

    folder = out / first.split
    records = [json.loads(line) for line in (folder / "metadata.jsonl").read_text().splitlines()]
    assert {record["id"] for record in records} == {planned.id for planned in (first, *rest)}
    for record in records:
        assert record["renderer"].startswith("Blender Cycles 4.5") and 0 <= record["exposed_share"] <= 1
        with Image.open(folder / record["file_name"]) as image:
            assert image.size == SIZE and image.mode == "RGB" and np.ptp(np.asarray(image)) > 50
        for kind in ("appearance", "dose"):
            with Image.open(out / record[kind]) as label:
                assert label.size == SIZE and set(np.unique(np.asarray(label))) <= {0, SANDED, UNSANDED, IGNORE}
            label_of = np.asarray(Image.open(out / record[kind]))
            state = record["treatment"]["kind"]
            assert (state == "unsanded") == (not (label_of == SANDED).any()), kind
            assert (state == "bare") == (not (label_of == UNSANDED).any()), kind
    assert not list(out.rglob("*.part"))
    recipe = json.loads((out / "dataset.json").read_text())
    assert recipe["format"] == "robofin-independent/2" and recipe["size"] == [64, 48] and recipe["count"] == 3
