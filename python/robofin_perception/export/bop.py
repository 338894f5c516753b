"""A folder in the format of BOP (Benchmark for 6D Object Pose Estimation)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..data import Bytes, Mask, open_picture
from ..errors import WrongUse
from ..folders import write_json
from .lens import Lens, bilinear, nearest
from .samples import Sample
from .solid import Solid

#: Folder and kind of picture; the readers of BOP expect JPEG of images that were rendered for training.
SPLITS = {"train": ("train_pbr", "jpg"), "validation": ("val", "png"), "test": ("test", "png")}
DEPTH_SCALE = 0.1
#: Number of the tool in instance labels; lower ones belong to the workpiece.
TOOL_INSTANCE = 255
#: Pictures of a view: instance labels, depth, the whole workpiece.
VIEW_PICTURES = ("instances", "depth", "amodal")
INFO = """# Labelled images of sanding

Made from a set of `robofin dataset images` by `python -m robofin_perception export --to bop`. One scene for each
placement of a workpiece, one object for each workpiece. Colour, depth and masks are without the lens's distortion, with
the same camera matrix. `source.json` maps each image to its name in the set, where the labels of sanding are.
"""


@dataclass(frozen=True)
class Camera:
    """Of a placement: the lens, and the pose of the part's frame."""

    lens: Lens
    rotation: NDArray[np.float64]
    translation_mm: NDArray[np.float64]

    @classmethod
    def read(cls, sample: Sample) -> Camera:
        """The camera of an image."""
        view = sample.view()
        try:
            lens = Lens(np.array(view["camera"]["matrix"], dtype=float).reshape(3, 3), view["camera"]["distortion"])
            rotation = np.array(view["part_to_camera_rotation"], dtype=float).reshape(3, 3)
            translation = np.array(view["part_to_camera_translation_m"], dtype=float).reshape(3)
        except (KeyError, TypeError, ValueError) as error:
            raise WrongUse(f"{sample.path('view')}: {error!r}; one of `robofin dataset images` is accepted") from None
        if len(lens.coefficients) != 5:
            raise WrongUse(f"{sample.path('view')} has {len(lens.coefficients)} numbers for the distortion; "
                           "k1, k2, p1, p2 and k3 are accepted")
        return cls(lens, rotation, 1000.0 * translation)


def write_bop(samples: Sequence[Sample], folder: Path) -> None:
    """Writes models, scenes, targets, and the camera of the first scene."""
    names = sorted({str(sample.row.values.get("workpiece")) for sample in samples})
    solids = {name: Solid.read(samples[0].root / "fields" / f"{name}.nvdb") for name in names}
    _write_models(folder / "models", [solids[name] for name in names])
    source: dict[str, Any] = {"objects": {str(number): name for number, name in enumerate(names, 1)}}
    targets = []
    for split, (name, _) in SPLITS.items():
        of_split = sorted((sample for sample in samples if sample.split == split), key=_place)
        for scene, (_, group) in enumerate(groupby(of_split, key=lambda sample: sample.path("view"))):
            images = list(group)
            workpiece = str(images[0].row.values.get("workpiece"))
            number = names.index(workpiece) + 1
            _Scene(folder / name / f"{scene:06}", images, solids[workpiece], number).write()
            ids = {str(place): sample.id for place, sample in enumerate(images)}
            source.setdefault(name, {})[str(scene)] = ids
            if split == "test":
                targets += [{"im_id": place, "inst_count": 1, "obj_id": number, "scene_id": scene}
                            for place in range(len(images))]
    write_json(folder / "source.json", source)
    write_json(folder / "test_targets_bop19.json", targets)
    write_json(folder / "camera.json", _camera(samples[0]))
    (folder / "dataset_info.md").write_text(INFO, encoding="utf-8")


def _place(sample: Sample) -> tuple[Path, str]:
    return sample.path("view"), sample.id


def _write_models(folder: Path, solids: Sequence[Solid]) -> None:
    folder.mkdir()
    for number, solid in enumerate(solids, 1):
        solid.write(folder / f"obj_{number:06}.ply")
    write_json(folder / "models_info.json", {str(number): solid.info() for number, solid in enumerate(solids, 1)})


def _camera(sample: Sample) -> dict[str, float]:
    matrix = Camera.read(sample).lens.matrix
    width, height = open_picture(sample.path("file_name")).size
    return {"fx": matrix[0, 0], "fy": matrix[1, 1], "cx": matrix[0, 2], "cy": matrix[1, 2],
            "width": width, "height": height, "depth_scale": DEPTH_SCALE}


@dataclass(frozen=True)
class _Scene:
    folder: Path
    samples: list[Sample]
    solid: Solid
    obj_id: int

    def write(self) -> None:
        """Writes the pictures and truths of a placement, which differ in colour only."""
        for kind in ("rgb", "depth", "mask", "mask_visib"):
            (self.folder / kind).mkdir(parents=True)
        camera = Camera.read(self.samples[0])
        instances, depth, amodal = (np.asarray(open_picture(self.samples[0].path(key))) for key in VIEW_PICTURES)
        height, width = depth.shape
        margin = max(width, height)
        grid, wide = (camera.lens.grid((width, height), around) for around in (0, margin))
        masks = {"mask": nearest(amodal > 0, grid), "mask_visib": nearest((instances > 0) & (instances < TOOL_INSTANCE), grid)}
        depth = nearest(depth, grid)
        for place, sample in enumerate(self.samples):
            kind = SPLITS[sample.split][1]
            image = bilinear(self._colours(sample, (width, height)), grid)
            options: dict[str, Any] = {"quality": 95, "subsampling": 0} if kind == "jpg" else {}
            Image.fromarray(image).save(self.folder / "rgb" / f"{place:06}.{kind}", **options)
            Image.fromarray(depth).save(self.folder / "depth" / f"{place:06}.png")
            for name, mask in masks.items():
                Image.fromarray(mask.astype(np.uint8) * 255).save(self.folder / name / f"{place:06}_000000.png")
        self._truths("scene_camera", {"cam_K": camera.lens.matrix.ravel().tolist(), "depth_scale": DEPTH_SCALE})
        self._truths("scene_gt", [self._pose(camera)])
        self._truths("scene_gt_info", [_info(masks["mask_visib"], nearest(amodal > 0, wide), depth, margin)])

    def _colours(self, sample: Sample, size: tuple[int, int]) -> Bytes:
        path = sample.path("file_name")
        image = open_picture(path).convert("RGB")
        if image.size != size:
            raise WrongUse(f"{path} has {image.width}x{image.height} pixels and its depth {size[0]}x{size[1]}; "
                           "equal sizes are accepted")
        return np.asarray(image)

    def _truths(self, name: str, truth: Any) -> None:
        write_json(self.folder / f"{name}.json", {str(place): truth for place in range(len(self.samples))})

    def _pose(self, camera: Camera) -> dict[str, Any]:
        """The model's frame has its origin in the centre of the box."""
        translation = camera.rotation @ self.solid.centre_mm + camera.translation_mm
        return {"cam_R_m2c": camera.rotation.ravel().tolist(), "cam_t_m2c": translation.tolist(), "obj_id": self.obj_id}


def _info(mask: Mask, whole: Mask, depth: NDArray[np.uint16], margin: int) -> dict[str, Any]:
    """Counts and boxes. `whole` has a margin, for what lies outside the picture without distortion."""
    seen = int(mask.sum())
    return {
        "bbox_obj": _box(whole, margin),
        "bbox_visib": _box(mask, 0),
        "px_count_all": int(whole.sum()),
        "px_count_valid": int((mask & (depth > 0)).sum()),
        "px_count_visib": seen,
        "visib_fract": seen / max(int(whole.sum()), 1),
    }


def _box(mask: Mask, margin: int) -> list[int]:
    """Left, top, width and height."""
    rows, columns = np.nonzero(mask)
    if len(rows) == 0:
        return [-1, -1, -1, -1]
    left, top = int(columns.min()), int(rows.min())
    return [left - margin, top - margin, int(columns.max()) - left + 1, int(rows.max()) - top + 1]
