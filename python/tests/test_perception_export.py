"""Exports of a drawn set: a ball, whose outline and depth are known, before a lens with distortion."""

import importlib.util
import json
import shutil
import math
import os
import tarfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import robofin

if importlib.util.find_spec("PIL") is None:
    NOT_TESTED = 'exports of labelled images are NOT TESTED: pillow is missing; pip install "./python[export]"'
    warnings.warn(NOT_TESTED, stacklevel=1)
    pytest.skip(NOT_TESTED, allow_module_level=True)

from PIL import Image

from robofin_perception.__main__ import main

WIDTH, HEIGHT, FOCUS = 96, 72, 110.0
DISTORTION = [-0.3, 0.09, 0.002, -0.003, 0.01]
#: In the frame of the part [m]; the picture's frame is turned by a right angle about its axis.
CENTRE, RADIUS = np.array([0.01, -0.02, 0.03]), 0.02
ROTATION = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
#: The ball is whole in the picture, and reaches over its right border once the distortion is gone.
TRANSLATION = np.array([0.0425, 0.015, 0.07])
SEED = 2**64 - 5


def needs(module: str) -> Any:
    """Skips a test without a package."""
    missing = importlib.util.find_spec(module) is None
    if missing:
        warnings.warn(f"an export is NOT TESTED: {module} is missing; pip install {module}", stacklevel=2)
    return pytest.mark.skipif(missing, reason=f"NOT TESTED: {module} is missing; pip install {module}")


def rays() -> tuple[np.ndarray, np.ndarray]:
    """Where a pinhole camera sees each pixel, relative to the focal length."""
    x, y = np.meshgrid(np.arange(WIDTH) - 0.5 * (WIDTH - 1), np.arange(HEIGHT) - 0.5 * (HEIGHT - 1))
    return x / FOCUS, y / FOCUS


def straightened(seen_x: np.ndarray, seen_y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """OpenCV's polynomial, turned round by repetition."""
    k1, k2, p1, p2, k3 = DISTORTION
    x, y = seen_x, seen_y
    for _ in range(200):
        r2 = x**2 + y**2
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
        x, y = ((seen_x - 2 * p1 * x * y - p2 * (r2 + 2 * x**2)) / radial,
                (seen_y - p1 * (r2 + 2 * y**2) - 2 * p2 * x * y) / radial)
    return x, y


def ball(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Depth [m] of the ball along the camera's axis, 0 where the ray misses it."""
    centre = ROTATION @ CENTRE + TRANSLATION
    squares, along = x**2 + y**2 + 1, x * centre[0] + y * centre[1] + centre[2]
    root = along**2 - squares * (centre @ centre - RADIUS**2)
    return np.where(root > 0, (along - np.sqrt(np.maximum(root, 0))) / squares, 0.0)


def colours(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.stack([128 + 250 * x, 128 + 250 * y, np.full_like(x, 90)], axis=2)


def sphere() -> robofin.Mesh:
    """The ball as a net of 64 by 32."""
    turn, rise = np.arange(64) * 2 * math.pi / 64, np.arange(1, 32) * math.pi / 32
    rings = np.array([[math.sin(r) * math.cos(t), math.sin(r) * math.sin(t), math.cos(r)] for r in rise for t in turn])
    points = np.vstack([rings, [[0, 0, 1], [0, 0, -1]]])
    top, bottom, last = len(rings), len(rings) + 1, len(rings) - 64
    triangles = []
    for k in range(64):
        after = (k + 1) % 64
        triangles += [[top, k, after], [bottom, last + after, last + k]]
        for ring in range(0, last, 64):
            triangles += [[ring + k, ring + 64 + k, ring + after], [ring + after, ring + 64 + k, ring + 64 + after]]
    return robofin.Mesh(CENTRE + RADIUS * points, np.array(triangles))


@pytest.fixture(scope="session")
def balls(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three images for training and two for tests."""
    root = tmp_path_factory.mktemp("balls") / "set"
    for folder in ("appearance", "dose", "views", "fields"):
        (root / folder).mkdir(parents=True)
    robofin.Field.bake(sphere(), 1e-3).write(root / "fields/ball.nvdb")
    x, y = straightened(*rays())
    depth = ball(x, y)
    Image.fromarray(np.rint(1e4 * depth).astype(np.uint16)).save(root / "views/ball-p00-depth.png")
    for kind in ("instances", "amodal"):
        Image.fromarray((depth > 0).astype(np.uint8)).save(root / f"views/ball-p00-{kind}.png")
    matrix = [[FOCUS, 0.0, 0.5 * (WIDTH - 1)], [0.0, FOCUS, 0.5 * (HEIGHT - 1)], [0.0, 0.0, 1.0]]
    view = {"id": "ball-p00", "camera": {"matrix": matrix, "distortion": DISTORTION}, "files": [],
            "part_to_camera_rotation": ROTATION.tolist(), "part_to_camera_translation_m": TRANSLATION.tolist()}
    (root / "views/ball-p00.json").write_text(json.dumps(view))
    image = np.clip(np.rint(colours(x, y)), 0, 255).astype(np.uint8)
    for split, count in (("train", 3), ("test", 2)):
        (root / split / "images").mkdir(parents=True)
        rows = [_write(root, split, f"{split}-{k}", (image, depth > 0)) for k in range(count)]
        (root / split / "metadata.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows[::-1]))
    return root


def _write(root: Path, split: str, name: str, drawn: tuple[np.ndarray, np.ndarray]) -> dict[str, Any]:
    image, mask = drawn
    Image.fromarray(image).save(root / split / "images" / f"{name}.png")
    labels = {label: f"{label}/{name}.png" for label in ("appearance", "dose")}
    for kind, path in enumerate(labels.values(), 1):
        Image.fromarray(kind * mask.astype(np.uint8)).save(root / path)
    treatment = {"kind": "stage", "pattern": "spiral", "stage": 1} if name.endswith("1") else {"kind": "bare"}
    views = {key: f"views/ball-p00{end}" for key, end in
             (("view", ".json"), ("instances", "-instances.png"), ("depth", "-depth.png"), ("amodal", "-amodal.png"))}
    return {"file_name": f"images/{name}.png", "id": name, "workpiece": "ball", "placement": 0, "treatment": treatment,
            "exposed_share": 0.25, "scene": {"sensor": {"seed": SEED}}} | labels | views


def write(data: Path, to: str, out: Path, *words: str) -> Path:
    assert main(["export", "--data", str(data), "--to", to, "--out", str(out), *words]) == 0
    return out


def opened(path: Path) -> Any:
    return json.loads(path.read_text())


def test_bop_has_the_outline_depth_and_colours_of_a_pinhole_camera(balls: Path, tmp_path: Path) -> None:
    out = write(balls, "bop", tmp_path / "bop")
    scene = out / "test/000000"
    known = ball(*rays())
    mask = np.asarray(Image.open(scene / "mask_visib/000001_000000.png"))
    assert set(np.unique(mask)) == {0, 255}
    wrong = (mask > 0) != (known > 0)
    assert wrong.sum() < 0.03 * (known > 0).sum()
    assert ((mask > 0) & (known > 0)).sum() / ((mask > 0) | (known > 0)).sum() > 0.97
    edge = sum(np.roll(known > 0, step, axis) != (known > 0) for step in (-1, 1) for axis in (0, 1))
    assert not wrong[edge == 0].any()
    depth = np.asarray(Image.open(scene / "depth/000001.png"))
    inner = (mask > 0) & (known > 0) & (known < np.median(known[known > 0]))
    assert depth.dtype == np.uint16 and np.abs(0.1 * depth - 1e3 * known)[inner].max() < 1.0
    middle = np.s_[4:-4, 4:-4]
    image = np.asarray(Image.open(scene / "rgb/000001.png")).astype(float)
    wanted = colours(*rays())
    seen = (wanted > 2).all(axis=2) & (wanted < 253).all(axis=2)
    assert np.abs(image - wanted)[middle][seen[middle]].max() <= 1.5
    info = opened(scene / "scene_gt_info.json")["1"][0]
    assert info["px_count_visib"] == info["px_count_valid"] == (mask > 0).sum()
    assert info["visib_fract"] == pytest.approx(info["px_count_visib"] / info["px_count_all"])
    assert (out / "train_pbr/000000/rgb/000002.jpg").exists() and not (out / "val").exists()


def test_bop_counts_what_lies_outside_the_picture_without_distortion(balls: Path, tmp_path: Path) -> None:
    out = write(balls, "bop", tmp_path / "bop")
    info = opened(out / "test/000000/scene_gt_info.json")["0"][0]
    x, y = np.meshgrid(*((np.arange(-side, 2 * side) - 0.5 * (side - 1)) / FOCUS for side in (WIDTH, HEIGHT)))
    rows, columns = np.nonzero(ball(x, y))
    assert info["px_count_all"] == pytest.approx(len(rows), rel=0.02)
    box = [columns.min() - WIDTH, rows.min() - HEIGHT, np.ptp(columns) + 1, np.ptp(rows) + 1]
    np.testing.assert_allclose(info["bbox_obj"], box, atol=1)
    assert info["bbox_obj"][0] + info["bbox_obj"][2] > WIDTH and info["visib_fract"] < 1


def test_the_model_of_bop_is_centred_and_its_pose_leads_to_the_ball(balls: Path, tmp_path: Path) -> None:
    out = write(balls, "bop", tmp_path / "bop")
    lines = (out / "models/obj_000001.ply").read_text().splitlines()
    assert lines[:2] == ["ply", "format ascii 1.0"]
    start = lines.index("end_header") + 1
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    rows = np.loadtxt(lines[start:start + count])
    positions, normals = rows[:, :3], rows[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 20.0, atol=0.2)
    assert (np.sum(positions * normals, axis=1) > 19).all()
    info = opened(out / "models/models_info.json")["1"]
    assert info["diameter"] == pytest.approx(40.0, abs=0.2) and info["min_x"] == pytest.approx(-20.0, abs=0.1)
    pose = opened(out / "test/000000/scene_gt.json")["0"][0]
    np.testing.assert_allclose(pose["cam_R_m2c"], ROTATION.ravel())
    np.testing.assert_allclose(pose["cam_t_m2c"], 1e3 * (ROTATION @ CENTRE + TRANSLATION), atol=0.05)
    targets = opened(out / "test_targets_bop19.json")
    assert targets == [{"im_id": k, "inst_count": 1, "obj_id": 1, "scene_id": 0} for k in (0, 1)]
    source = opened(out / "source.json")
    assert source["train_pbr"] == {"0": {"0": "train-0", "1": "train-1", "2": "train-2"}}


def test_a_shard_has_whole_samples_and_the_same_bytes_again(balls: Path, tmp_path: Path) -> None:
    first, again = (write(balls, "webdataset", tmp_path / name, "--shard", "2") for name in ("a", "b"))
    names = ["test-000000.tar", "train-000000.tar", "train-000001.tar"]
    assert sorted(path.name for path in first.iterdir()) == names
    assert all((first / name).read_bytes() == (again / name).read_bytes() for name in names)
    with tarfile.open(first / "train-000000.tar") as tar:
        suffixes = ("appearance.png", "dose.png", "json", "png")
        assert tar.getnames() == [f"train-{k}.{suffix}" for k in (0, 1) for suffix in suffixes]
        facts = json.load(tar.extractfile("train-1.json"))  # type: ignore[arg-type]
        image = tar.extractfile("train-1.png")
        assert image and image.read() == (balls / "train/images/train-1.png").read_bytes()
    assert facts["view"]["camera"]["distortion"] == DISTORTION and facts["scene"]["sensor"]["seed"] == SEED
    assert not {"file_name", "dose", "depth"} & facts.keys() and "files" not in facts["view"]


@needs("webdataset")
def test_webdataset_reads_the_shards(balls: Path, tmp_path: Path) -> None:
    import webdataset

    out = write(balls, "webdataset", tmp_path / "out")
    samples = list(webdataset.WebDataset(str(out / "train-000000.tar"), shardshuffle=False).decode("pil"))
    assert [sample["__key__"] for sample in samples] == ["train-0", "train-1", "train-2"]
    assert samples[0]["png"].size == (WIDTH, HEIGHT) and samples[0]["json"]["id"] == "train-0"


@needs("pyarrow")
@needs("datasets")
def test_datasets_reads_the_parquet_files(balls: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, "HF_HUB_OFFLINE", "1")
    import datasets

    out = write(balls, "parquet", tmp_path / "out", "--shard", "2")
    assert (out / "data/train-00001-of-00002.parquet").exists()
    read = datasets.load_dataset(str(out), cache_dir=str(tmp_path / "cache"))
    assert {split: len(rows) for split, rows in read.items()} == {"train": 3, "test": 2}
    row = read["train"][1]
    for column, path in (("image", "train/images/train-1.png"), ("dose", "dose/train-1.png")):
        np.testing.assert_array_equal(np.asarray(row[column]), np.asarray(Image.open(balls / path)))
    assert row["id"] == "train-1" and row["view"]["camera"]["distortion"] == DISTORTION
    assert row["treatment"] == {"kind": "stage", "pattern": "spiral", "stage": 1}
    assert json.loads(row["scene"])["sensor"]["seed"] == SEED


@needs("mlcroissant")
def test_mlcroissant_reads_the_records(balls: Path, tmp_path: Path) -> None:
    import mlcroissant

    out = write(balls, "croissant", tmp_path / "deep/out")
    records = list(mlcroissant.Dataset(str(out / "croissant.json")).records("train"))
    assert [record["train/id"] for record in records] == [b"train-2", b"train-1", b"train-0"]
    assert records[0]["train/file_name"] == b"images/train-2.png" and records[0]["train/exposed_share"] == 0.25


def test_croissant_states_the_licence_of_bundled_workpieces_only(balls: Path, tmp_path: Path) -> None:
    root = tmp_path / "set"
    shutil.copytree(balls, root)
    for kind, stated in (("shape", True), ("asset", False)):
        recipe = {"format": "robofin-images/3", "version": "0.1.0", "workpieces": [{"origin": {"kind": kind}}]}
        (root / "dataset.json").write_text(json.dumps(recipe))
        content = json.loads((write(root, "croissant", tmp_path / kind) / "croissant.json").read_text())
        assert content["version"] == "0.1.0" and ("license" in content) == stated


@pytest.mark.parametrize("to", ["bop", "webdataset", "croissant"])
def test_an_existing_folder_or_no_set_is_refused(
        to: str, balls: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "--data", str(balls), "--to", to, "--out", str(tmp_path)]) == 2
    assert "exists; a new folder is accepted" in capsys.readouterr().err
    assert main(["export", "--data", str(tmp_path), "--to", to, "--out", str(tmp_path / "out")]) == 2
    assert "has no train/metadata.jsonl" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_what_bop_needs_is_named(balls: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    root = tmp_path / "set"
    (root / "train").mkdir(parents=True)
    row = {"file_name": "images/a.png", "id": "a", "workpiece": "ball"}
    (root / "train/metadata.jsonl").write_text(json.dumps(row))
    words = ["export", "--data", str(root), "--to", "bop", "--out", str(tmp_path / "out")]
    assert main(words) == 2
    assert "ball.nvdb cannot be read" in capsys.readouterr().err
    (root / "fields").mkdir()
    (root / "fields/ball.nvdb").write_bytes((balls / "fields/ball.nvdb").read_bytes())
    assert main(words) == 2
    assert '"view" is None; the path of a file is accepted' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [root]
