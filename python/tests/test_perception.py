"""Networks that see the sanded area: data, measures, training, evaluation. The images are drawn here."""

import importlib.util
import json
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

NEEDED = ("torch", "torchvision", "transformers", "segmentation_models_pytorch", "safetensors")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
if MISSING:
    NOT_TESTED = f"robofin_perception is NOT TESTED: {', '.join(MISSING)} missing; pip install \"./python[perception]\""
    warnings.warn(NOT_TESTED, stacklevel=1)
    pytest.skip(NOT_TESTED, allow_module_level=True)

import torch

from robofin_perception import training
from robofin_perception.__main__ import main
from robofin_perception.baselines import otsu, prefers_brighter, threshold, whole
from robofin_perception.data import Example, fingerprint, open_example, read_split
from robofin_perception.metrics import Counts, count, summarise
from robofin_perception.models import Segmenter, UNet, sha256_of
from robofin_perception.sam2 import Sam2
from robofin_perception.training import Options, Store, create, draws, loss_parts

WIDTH, HEIGHT = 64, 48
#: Coating and metal of the same grey value: no threshold tells them apart.
COATING, METAL = np.array([70.0, 110.0, 176.0]), np.array([135.0, 105.0, 52.0])
#: Enough updates for each network to learn the shapes, and its flags.
LEARNERS = {"unet": ["--size", "48x48", "--updates", "50"], "sam2-random": ["--updates", "160"]}


def draw(random: np.random.Generator, sanded: float) -> tuple[np.ndarray, np.ndarray]:
    """A workpiece on a table, sanded on this share of its width from the left or the right, with its label."""
    label = np.zeros((HEIGHT, WIDTH), dtype=np.uint8)
    left, top = random.integers(3, 14), random.integers(3, 10)
    right, bottom = random.integers(46, 61), random.integers(34, 45)
    label[top:bottom, left:right] = 2
    part = label[top:bottom, left:right]
    across = round(sanded * part.shape[1])
    label[top:bottom, left:right][:, slice(0, across) if random.random() < 0.5 else slice(part.shape[1] - across, None)] = 1
    image = np.empty((HEIGHT, WIDTH, 3))
    image[:] = random.uniform(40, 220)
    image[label == 1], image[label == 2] = METAL, COATING
    light = np.linspace(random.uniform(0.7, 1.0), random.uniform(1.0, 1.3), WIDTH)[None, :, None]
    return np.clip(image * light + random.normal(0, 4, image.shape), 0, 255).astype(np.uint8), label


def write_set(root: Path, counts: dict[str, int], seed: int) -> Path:
    """A set in the layout of `robofin dataset images`; the first image of each split is unsanded."""
    random = np.random.default_rng(seed)
    (root / "appearance").mkdir(parents=True)
    for split, number in counts.items():
        (root / split / "images").mkdir(parents=True)
        rows = []
        for k in range(number):
            name = f"{split}-{k:02}"
            image, label = draw(random, 0.0 if k == 0 else random.uniform(0.2, 0.7))
            Image.fromarray(image).save(root / split / "images" / f"{name}.png")
            Image.fromarray(label).save(root / "appearance" / f"{name}.png")
            rows.append({"file_name": f"images/{name}.png", "id": name, "workpiece": "block", "placement": k // 2,
                         "appearance": f"appearance/{name}.png"})
        (root / split / "metadata.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return root


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)


@pytest.fixture(scope="session")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("shapes") / "set", {"train": 24, "test": 8}, 1)


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A set that a test may spoil."""
    return write_set(tmp_path / "set", {"train": 2, "test": 2}, 2)


@pytest.fixture(scope="session")
def trained(shapes: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The run of a model, trained when it is first asked for."""
    folder = tmp_path_factory.mktemp("runs")

    def run(model: str) -> Path:
        if not (folder / model).exists():
            words = ["train", "--data", str(shapes), "--model", model, "--out", str(folder / model), *LEARNERS[model]]
            assert main(words) == 0
        return folder / model

    return run


def example(label: np.ndarray, image: np.ndarray | None = None) -> Example:
    rows, columns = np.nonzero(label)
    box = (int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1)
    return Example(np.zeros((*label.shape, 3), dtype=np.uint8) if image is None else image, label, box)


def test_counts_are_those_by_hand_and_ignored_pixels_do_not_count() -> None:
    label = np.array([[1, 1, 2, 0], [1, 255, 255, 2]], dtype=np.uint8)
    marked = np.array([[1, 0, 1, 1], [0, 1, 0, 0]], dtype=np.bool_)
    counts = count(marked, label, 1)
    assert counts == Counts(true=1, false=2, missed=2)
    assert (counts.iou, counts.dice, counts.precision, counts.recall) == (1 / 5, 2 / 6, 1 / 3, 1 / 3)


@pytest.mark.parametrize(("counts", "iou", "precision", "recall"), [
    (Counts(0, 0, 0), 1.0, None, None), (Counts(0, 3, 0), 0.0, 0.0, None), (Counts(0, 0, 3), 0.0, None, 0.0)])
def test_two_empty_areas_agree_and_one_empty_area_does_not(
        counts: Counts, iou: float, precision: float | None, recall: float | None) -> None:
    assert (counts.iou, counts.dice, counts.precision, counts.recall) == (iou, iou, precision, recall)


def test_means_are_of_images_and_pooled_figures_of_summed_counts() -> None:
    summary = summarise([Counts(1, 0, 0), Counts(0, 0, 9)], ["a", "b"])
    assert (summary.mean_iou, summary.pooled_iou, summary.dice, summary.recall) == (0.5, 0.1, 2 / 11, 0.1)
    assert (summary.low, summary.high) == (0.0, 1.0)


def test_the_interval_draws_groups_and_not_images() -> None:
    right, wrong = Counts(1, 0, 0), Counts(0, 1, 0)
    mixed = summarise([right, wrong, right, wrong], ["a", "a", "b", "b"])
    parted = summarise([right, right, wrong, wrong], ["a", "a", "b", "b"])
    assert (mixed.low, mixed.high) == (0.5, 0.5) and (parted.low, parted.high) == (0.0, 1.0)


def test_otsu_parts_two_grey_values_and_the_training_images_choose_the_side() -> None:
    assert 20 <= threshold(np.array([10, 20, 20, 90, 100])) < 90
    label = np.array([[0, 0, 0, 0], [0, 1, 2, 2]], dtype=np.uint8)
    image = np.repeat(np.array([[0, 0, 0, 0], [0, 40, 200, 210]], dtype=np.uint8)[..., None], 3, axis=2)
    seen = example(label, image)
    np.testing.assert_array_equal(otsu(seen, False, seen.inside()), label == 1)
    np.testing.assert_array_equal(otsu(seen, True, seen.inside()), label == 2)
    assert not prefers_brighter([seen], 1) and prefers_brighter([seen], 2)
    assert whole(seen).sum() == 3


class Fixed(Segmenter):
    """Marks the left half of a frame that is larger than the box, and is as sure of the area as it is told."""

    grid = (4, 2)

    def __init__(self, presence: float) -> None:
        super().__init__()
        self.presence = torch.nn.Parameter(torch.tensor([presence]))

    def frame(self, example: Example) -> tuple[int, int, int, int]:
        return 0, 0, 8, 4

    def encode(self, example: Example) -> dict[str, torch.Tensor]:
        return {"row": torch.tensor([9.0, 9.0, -9.0, -9.0])}

    def forward(self, batch: dict[str, torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
        return batch["row"][:, None].expand(-1, 2, -1), self.presence

    def save(self, folder: Path) -> None:
        raise NotImplementedError


def test_masks_are_enlarged_clipped_to_the_box_and_empty_where_the_area_is_denied() -> None:
    label = np.zeros((4, 10), dtype=np.uint8)
    label[1:3, 2:9] = 2
    marked = np.zeros(label.shape, dtype=np.bool_)
    marked[1:3, 2:4] = True
    np.testing.assert_array_equal(Fixed(1.0).predict(example(label)), marked)
    assert not Fixed(-1.0).predict(example(label)).any()


def test_targets_leave_out_ignored_pixels_and_those_outside_the_box() -> None:
    label = np.zeros((4, 8), dtype=np.uint8)
    label[:, 2:8] = np.array([1, 1, 255, 255, 2, 2])
    np.testing.assert_array_equal(Fixed(1.0).target(example(label), 1), [[255, 1, 255, 0]] * 2)


def test_the_loss_is_the_one_by_hand_and_ignored_pixels_have_no_gradient() -> None:
    logits = torch.tensor([[[0.0, 0.0, 5.0]]], requires_grad=True)
    parts = loss_parts((logits, torch.zeros(1)), torch.tensor([[[1, 0, 255]]]), torch.ones(1))
    assert parts["cross_entropy"].item() == pytest.approx(np.log(2)) == parts["presence"].item()
    assert parts["dice"].item() == pytest.approx(1 - (2 * 0.5 + 1) / (0.5 + 0.5 + 1 + 1))
    torch.stack(list(parts.values())).sum().backward()
    assert logits.grad is not None and logits.grad[0, 0, 2] == 0 and logits.grad[0, 0, 0] < 0 < logits.grad[0, 0, 1]


@pytest.mark.parametrize("model", LEARNERS)
def test_a_network_learns_and_beats_every_trivial_answer_on_held_out_images(
        model: str, shapes: Path, trained: Callable[[str], Path], tmp_path: Path) -> None:
    run = trained(model)
    card = json.loads((run / "run.json").read_text())
    loss = [each["total"] for each in card["loss"]]
    assert np.mean(loss[-10:]) < 0.5 * np.mean(loss[:10])
    assert main(["evaluate", "--run", str(run), "--data", str(shapes), "--out", str(tmp_path / "out")]) == 0
    content = json.loads((tmp_path / "out/evaluation.json").read_text())
    rows = {name: figures["mean_iou"] for name, figures in content["rows"].items()}
    network = rows.pop("network")
    assert len(rows) == 3 and network > max(rows.values()) + 0.1, (network, rows)
    assert content["images"] == 8 and content["groups"] == 4
    assert network == pytest.approx(np.mean([each["iou"]["network"] for each in content["each"]]), abs=1e-4)
    assert "| network |" in (tmp_path / "out/evaluation.md").read_text()
    assert Image.open(tmp_path / "out/overlays.png").width > 1000


def test_the_image_encoder_stays_as_it_was_and_the_decoder_does_not(trained: Callable[[str], Path]) -> None:
    run = trained("sam2-random")
    card = json.loads((run / "run.json").read_text())
    start, end = create("sam2-random", 0), Sam2.read(str(run / "model"))
    assert card["encoder_sha256"]["before"] == card["encoder_sha256"]["after"] == sha256_of(start.frozen())
    assert sha256_of(end.frozen()) == sha256_of(start.frozen())
    before, after = start.state_dict(), end.state_dict()
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert {name.split(".")[1] for name in changed} == {"prompt_encoder", "mask_decoder"}
    assert "sam.mask_decoder.pred_obj_score_head.proj_out.weight" in changed
    assert not {"sam.mask_decoder.conv_s0.weight", "sam.mask_decoder.conv_s1.weight"} & changed


def test_a_change_of_the_encoder_is_a_failure_and_leaves_no_run(
        small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def spoil(segmenter: Sam2, options: Options) -> list[dict[str, float]]:
        next(segmenter.sam.vision_encoder.parameters()).data += 1
        return []

    monkeypatch.setattr(training, "optimise", spoil)
    words = ["train", "--data", str(small), "--model", "sam2-random", "--out", str(tmp_path / "run")]
    assert main(words) == 1 and "encoder" in capsys.readouterr().err
    assert sorted(each.name for each in tmp_path.iterdir()) == ["set"]


@pytest.mark.parametrize("model", ["unet", "sam2-random"])
def test_the_same_seed_gives_the_same_weights_and_another_one_others(model: str, small: Path, tmp_path: Path) -> None:
    size = ["--size", "32x32"] if model == "unet" else []
    hashes = []
    for name, seed in (("a", "5"), ("b", "5"), ("c", "6")):
        words = ["train", "--data", str(small), "--model", model, "--updates", "2", "--seed", seed, *size]
        assert main([*words, "--out", str(tmp_path / name)]) == 0
        card = json.loads((tmp_path / name / "run.json").read_text())
        assert card["data"] == [fingerprint(small, "train")]
        hashes.append(card["weights_sha256"])
    assert hashes[0] == hashes[1] != hashes[2]


def test_an_image_is_encoded_once_and_a_cache_gives_the_same_tensors(
        small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network, record = create("sam2-random", 0), read_split(small, "train", "appearance")[1]
    kept, filed = Store(network, 1, None), Store(network, 1, tmp_path / "cache")
    first, written = kept[record], filed[record]
    monkeypatch.setattr(Sam2, "encode", lambda *_: pytest.fail("encoded again"))
    again, read = kept[record], filed[record]
    assert first.keys() == read.keys() >= {"features0", "box", "target", "present"}
    assert all(torch.equal(first[name], each[name]) for name in first for each in (again, written, read))
    with pytest.raises(pytest.fail.Exception, match="encoded again"):
        Store(create("sam2-random", 1), 1, tmp_path / "cache")[record]


@pytest.mark.parametrize("fraction", [0.0, 0.25, 1.0])
def test_the_real_set_has_its_share_of_the_draws(fraction: float, shapes: Path, small: Path) -> None:
    batches = draws(Options(shapes, real=small, real_fraction=fraction, batch=8))
    drawn = [record for _ in range(250) for record in next(batches)]
    share = np.mean([small in record.image.parents for record in drawn])
    assert share == pytest.approx(fraction, abs=4 * np.sqrt(fraction * (1 - fraction) / 2000))


def test_every_image_is_drawn_once_before_any_is_drawn_again(shapes: Path) -> None:
    batches = draws(Options(shapes))
    for _ in range(2):
        assert len({record.id for _ in range(6) for record in next(batches)}) == 24


def spoil_label(root: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    path = root / "appearance/train-00.png"
    Image.fromarray(change(np.asarray(Image.open(path)))).save(path)


def rewrite(root: Path, change: Callable[[str], str]) -> None:
    path = root / "train/metadata.jsonl"
    path.write_text(change(path.read_text()))


@pytest.mark.parametrize(("spoil", "told"), [
    (lambda root: shutil.rmtree(root / "train"), "train/metadata.jsonl is missing"),
    (lambda root: rewrite(root, lambda text: ""), "lists no image"),
    (lambda root: rewrite(root, lambda text: text + "{"), "metadata.jsonl, line 3"),
    (lambda root: rewrite(root, lambda text: text + "3\n"), "line 3 is a int; a JSON object"),
    (lambda root: rewrite(root, lambda text: text.replace('"appearance"', '"other"', 1)), '"appearance" is None'),
    (lambda root: rewrite(root, lambda text: text.replace("train-01\"", "train-00\"")), "the same id twice"),
    (lambda root: (root / "train/images/train-00.png").unlink(), "train-00.png is missing"),
    (lambda root: (root / "train/images/train-00.png").write_bytes(b"no"), "train-00.png cannot be opened"),
    (lambda root: spoil_label(root, lambda label: label[1:]), "has 64x47 pixels"),
    (lambda root: spoil_label(root, lambda label: label + 3), "has the label 3"),
    (lambda root: spoil_label(root, lambda label: np.stack([label] * 3, axis=2)), "has the mode RGB; L, P"),
    (lambda root: spoil_label(root, np.zeros_like), "no pixel of the workpiece"),
])
def test_faulty_data_are_named(spoil: Callable[[Path], Any], told: str, small: Path, tmp_path: Path,
                               capsys: pytest.CaptureFixture[str]) -> None:
    spoil(small)
    words = ["train", "--data", str(small), "--size", "32x32", "--updates", "2", "--out", str(tmp_path / "run")]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert told in error and str(small) in error
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(("words", "told"), [
    (["train", "--batch", "1"], "--batch: '1' found, a whole number of at least 2 is accepted"),
    (["train", "--lr", "nan"], "--lr: 'nan' found, a number above 0 is accepted"),
    (["train", "--real-fraction", "1.5"], "--real-fraction: '1.5' found, a number from 0 to 1 is accepted"),
    (["train", "--size", "640"], "--size: '640' found, WxH"),
    (["train", "--target", "rust"], "--target: invalid choice: 'rust'"),
    (["table"], "--real"),
])
def test_wrong_flags_are_named(words: list[str], told: str, small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([*words, "--data", str(small), "--out", str(small / "run")])
    assert end.value.code == 2 and told in capsys.readouterr().err


@pytest.mark.parametrize(("words", "told"), [
    (["train", "--model", "sam2-random", "--size", "64x64"], "--size belongs to --model unet"),
    (["train", "--model", "unet", "--cache", "cache"], "--cache belongs to SAM 2"),
    (["train", "--model", "no/such/model"], "'no/such/model' is no model that can be read"),
    (["evaluate", "--run", "unet"], "--run unet is a network without weights"),
    (["evaluate", "--run", "sam2-random", "--split", "validation"], "validation/metadata.jsonl is missing"),
])
def test_what_does_not_fit_together_is_refused(words: list[str], told: str, small: Path, tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "--data", str(small), "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_weights_of_another_network_are_refused(trained: Callable[[str], Path], tmp_path: Path, small: Path,
                                                capsys: pytest.CaptureFixture[str]) -> None:
    from safetensors.torch import load_file, save_file

    folder = shutil.copytree(trained("sam2-random") / "model", tmp_path / "model")
    weights = load_file(folder / "model.safetensors")
    save_file({name: each for name, each in weights.items() if "mask_decoder" not in name},
              folder / "model.safetensors", {"format": "pt"})
    assert main(["train", "--data", str(small), "--model", str(folder), "--out", str(tmp_path / "run")]) == 2
    assert "mask_decoder" in capsys.readouterr().err
    (folder / "model.safetensors").write_bytes(b"no weights")
    assert main(["train", "--data", str(small), "--model", str(folder), "--out", str(tmp_path / "run")]) == 2


def test_results_are_never_overwritten(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/note").write_text("kept")
    for verb in (["train"], ["evaluate", "--run", "sam2-random"]):
        assert main([*verb, "--data", str(small), "--out", str(tmp_path / "mine")]) == 2
        assert "exists; a new folder is accepted" in capsys.readouterr().err
    assert [each.name for each in (tmp_path / "mine").iterdir()] == ["note"]


def test_a_faulty_run_is_named(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    run.mkdir()
    for card in ("{", "[]", '{"format": "other", "kind": "unet", "options": {"labels": "dose", "target": "sanded"}}'):
        (run / "run.json").write_text(card)
        assert main(["evaluate", "--run", str(run), "--data", str(small), "--out", str(tmp_path / "out")]) == 2
        assert str(run) in capsys.readouterr().err


def test_the_target_is_the_one_of_the_run(trained: Callable[[str], Path], shapes: Path, tmp_path: Path,
                                          capsys: pytest.CaptureFixture[str]) -> None:
    words = ["evaluate", "--run", str(trained("unet")), "--data", str(shapes), "--out", str(tmp_path / "out")]
    assert main([*words, "--target", "unsanded"]) == 2
    assert "was trained for sanded" in capsys.readouterr().err


def test_the_table_has_a_row_for_each_training_and_trivial_answer(
        shapes: Path, small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["table", "--data", str(shapes), "--real", str(small), "--size", "32x32", "--updates", "2"]
    assert main([*words, "--real-fraction", "0.5", "--out", str(tmp_path / "out")]) == 0
    rows = json.loads((tmp_path / "out/table.json").read_text())
    assert list(rows)[:3] == ["no training", "simulated", "simulated + 50 % real"] and len(rows) == 6
    assert capsys.readouterr().out.strip() == (tmp_path / "out/table.md").read_text().strip()
    cards = [json.loads((tmp_path / f"out/run-{k}/run.json").read_text()) for k in range(3)]
    assert [len(card["loss"]) for card in cards] == [0, 2, 2]
    assert [len(card["data"]) for card in cards] == [1, 1, 2]
    tested = json.loads((tmp_path / "out/evaluation-1/evaluation.json").read_text())["data"]
    assert tested == fingerprint(small, "test")


@pytest.mark.parametrize(("module", "package"), [("torch", "torch"), ("PIL", "pillow")])
def test_a_missing_package_is_named_in_one_line(module: str, package: str, small: Path, tmp_path: Path) -> None:
    program = (f"import sys; sys.modules[{module!r}] = None\n"
               "from robofin_perception.__main__ import main; sys.exit(main())")
    told = subprocess.run([sys.executable, "-c", program, "train", "--data", str(small), "--out", str(tmp_path / "run")],
                          capture_output=True, text=True)
    assert told.returncode == 1 and f"{package} is not installed; pip install" in told.stderr
    assert told.stderr.count("\n") == 1


def test_the_crop_of_the_unet_is_the_box_with_a_margin() -> None:
    label = np.zeros((40, 80), dtype=np.uint8)
    label[0:32, 16:48] = 2
    network, seen = UNet.random((32, 32)), example(label)
    assert network.frame(seen) == (12, 0, 52, 36)
    channel = network.encode(seen)["image"][3]
    assert channel[0, 16] == 255 and channel[31, 16] == 0 and channel[0, 0] == 0


def test_an_image_without_its_own_placement_is_its_own_group(small: Path) -> None:
    rewrite(small, lambda text: text.replace('"placement": 0, ', "", 1))
    records = read_split(small, "train", "appearance")
    assert [record.group for record in records] == ["train-00", "block, placement 0"]
    assert open_example(records[0]).label.shape == (HEIGHT, WIDTH)
