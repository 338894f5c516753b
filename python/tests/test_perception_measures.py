"""What networks that see the sanded area are measured and trained by."""

from pathlib import Path

from perception_shapes import HEIGHT, WIDTH, rewrite, small  # first: skips where packages are missing

import numpy as np
import pytest
import torch

from robofin_perception.baselines import otsu, prefers_brighter, threshold, whole
from robofin_perception.data import Example, open_example, read_split
from robofin_perception.differences import Noise, difference
from robofin_perception.metrics import Counts, count, summarise
from robofin_perception.models import Segmenter, UNet
from robofin_perception.training import loss_parts

__all__ = ["small"]


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


def test_the_noise_of_training_is_pooled_over_rows_and_needs_two_seeds() -> None:
    assert Noise.of([[0.5], [0.6], []]) is None
    # Squares about their means: 2 * 0.01² and 2 * 0.03², with one degree of freedom each.
    noise = Noise.of([[0.49, 0.51], [0.57, 0.63], [0.9]])
    assert noise is not None and noise.freedom == 2
    assert noise.deviation == pytest.approx((0.002 / 2) ** 0.5)


def test_a_difference_is_paired_by_image_and_its_interval_draws_groups_and_the_noise_of_training() -> None:
    random = np.random.default_rng(3)
    groups = {f"{group}-{image}": f"{group}" for group in range(30) for image in range(4)}
    hard = {name: float(random.uniform(0.1, 0.7)) for name in groups}
    gain = {name: 0.05 + 0.02 * np.sin(int(group)) for name, group in groups.items()}
    better = [{name: hard[name] + gain[name] + shift for name in groups} for shift in (-0.001, 0.001)]
    still = Noise(1e-9, 4)
    found = difference(better, [hard], groups, still)
    expected = float(np.mean(list(gain.values())))
    assert found.mean == pytest.approx(expected) and found.low is not None and found.high is not None
    # Hard and easy images cancel: the interval is that of the gains of 30 groups, not of 120 images.
    error = 1.96 * np.std([gain[f"{group}-0"] for group in range(30)]) / 30**0.5
    assert found.high - found.low == pytest.approx(2 * error, rel=0.15)
    wide = difference(better, [hard], groups, Noise(0.05, 4))
    # Student's 2.78 for four degrees of freedom; two seeds against one.
    assert wide.low is not None and wide.high is not None
    assert wide.high - wide.low == pytest.approx(2 * 2.78 * 0.05 * 1.5**0.5, rel=0.15)
    assert difference(better, [hard], groups, None).low is None


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
