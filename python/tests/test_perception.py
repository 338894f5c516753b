"""Networks that see the sanded area are trained and measured on drawn shapes."""

import json
from collections.abc import Callable
from pathlib import Path

from perception_shapes import one_thread, shapes, small  # first: skips where packages are missing

import numpy as np
import pytest
import torch
from PIL import Image

from robofin_perception.__main__ import main
from robofin_perception.data import fingerprint, read_split
from robofin_perception.models import sha256_of
from robofin_perception.sam2 import Sam2
from robofin_perception.training import Options, Store, create, draws

__all__ = ["one_thread", "shapes", "small"]

#: Enough updates for each network to learn the shapes, and its flags.
LEARNERS = {"unet": ["--size", "48x48", "--updates", "50"], "sam2-random": ["--updates", "160"]}


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
