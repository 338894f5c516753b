"""What perception refuses, and what it says."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from perception_shapes import rewrite, small  # first: skips where packages are missing

import numpy as np
import pytest
from PIL import Image
from safetensors.torch import load_file, save_file

from robofin_perception import training
from robofin_perception.__main__ import main
from robofin_perception.sam2 import Sam2
from robofin_perception.training import Options, create

__all__ = ["small"]


def spoil_label(root: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    path = root / "appearance/train-00.png"
    Image.fromarray(change(np.asarray(Image.open(path)))).save(path)


@pytest.mark.parametrize(("spoil", "message"), [
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
def test_faulty_data_are_named(spoil: Callable[[Path], Any], message: str, small: Path, tmp_path: Path,
                               capsys: pytest.CaptureFixture[str]) -> None:
    spoil(small)
    words = ["train", "--data", str(small), "--size", "32x32", "--updates", "2", "--out", str(tmp_path / "run")]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert message in error and str(small) in error
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(("words", "message"), [
    (["train", "--batch", "1"], "--batch: '1' found, a whole number of at least 2 is accepted"),
    (["train", "--lr", "nan"], "--lr: 'nan' found, a number above 0 is accepted"),
    (["train", "--real-fraction", "1.5"], "--real-fraction: '1.5' found, a number from 0 to 1 is accepted"),
    (["train", "--size", "640"], "--size: '640' found, WxH"),
    (["train", "--target", "rust"], "--target: invalid choice: 'rust'"),
    (["table"], "--real"),
])
def test_wrong_flags_are_named(words: list[str], message: str, small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([*words, "--data", str(small), "--out", str(small / "run")])
    assert end.value.code == 2 and message in capsys.readouterr().err


@pytest.mark.parametrize(("words", "message"), [
    (["train", "--model", "sam2-random", "--size", "64x64"], "--size belongs to --model unet"),
    (["train", "--model", "unet", "--cache", "cache"], "--cache belongs to SAM 2"),
    (["train", "--model", "no/such/model"], "'no/such/model' is no model that can be read"),
    (["evaluate", "--run", "unet"], "--run unet is a network without weights"),
    (["evaluate", "--run", "sam2-random", "--split", "validation"], "validation/metadata.jsonl is missing"),
])
def test_what_does_not_fit_together_is_refused(words: list[str], message: str, small: Path, tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "--data", str(small), "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_weights_of_another_network_are_refused(
        tmp_path: Path, small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "model"
    create("sam2-random", 0).save(folder)
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


def test_the_target_is_the_one_of_the_run(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, run = ["--data", str(small)], str(tmp_path / "run")
    assert main(["train", *data, "--model", "sam2-random", "--updates", "0", "--target", "unsanded", "--out", run]) == 0
    words = ["evaluate", "--run", run, *data, "--out", str(tmp_path / "out")]
    assert main([*words, "--target", "sanded"]) == 2
    assert "was trained for unsanded" in capsys.readouterr().err and not (tmp_path / "out").exists()
    assert main(words) == 0
    assert json.loads((tmp_path / "out/evaluation.json").read_text())["target"] == "unsanded"


@pytest.mark.parametrize(("module", "package"), [("torch", "torch"), ("PIL", "pillow")])
def test_a_missing_package_is_named_in_one_line(module: str, package: str, small: Path, tmp_path: Path) -> None:
    program = (f"import sys; sys.modules[{module!r}] = None\n"
               "from robofin_perception.__main__ import main; sys.exit(main())")
    words = [sys.executable, "-c", program, "train", "--data", str(small), "--out", str(tmp_path / "run")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 1 and f"{package} is not installed; pip install" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_change_of_the_encoder_is_a_failure_and_leaves_no_run(
        small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def spoil(segmenter: Sam2, options: Options) -> list[dict[str, float]]:
        next(segmenter.sam.vision_encoder.parameters()).data += 1
        return []

    monkeypatch.setattr(training, "optimise", spoil)
    words = ["train", "--data", str(small), "--model", "sam2-random", "--out", str(tmp_path / "run")]
    assert main(words) == 1 and "encoder" in capsys.readouterr().err
    assert sorted(each.name for each in tmp_path.iterdir()) == ["set"]


def test_a_loss_that_is_not_finite_stops_the_training_and_names_the_update(
        small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["train", "--data", str(small), "--size", "32x32", "--updates", "9", "--lr", "1e30"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 1
    error = capsys.readouterr().err
    assert "the loss is not finite at update 1; try a smaller --lr than 1e+30" in error, error
    assert not (tmp_path / "run").exists()
