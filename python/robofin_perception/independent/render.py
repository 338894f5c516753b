"""Renders a scene with Cycles: light of each state of the coating, and dose and object at the centres of pixels."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .finish import set_state
from .nodes import Nodes

Floats = NDArray[np.float32]

PART_INDEX = 1
"""Object index of the workpiece; that of everything else is 0."""
MARGIN = 6
"""Pixels rendered about the workpiece, so that the denoiser has neighbours."""


@dataclass(frozen=True)
class Raster:
    """Pixels, samples of each pixel, threads (0: all) and the seed of Cycles."""

    size: tuple[int, int]
    samples: int
    threads: int
    seed: int


@dataclass(frozen=True)
class Rendered:
    """Linear light of three states, shape `[h, w, 3]`; dose and whether the workpiece is seen, shape `[h, w]`.

    The unsanded and the bare state are rendered only about the workpiece.
    """

    as_dosed: Floats
    unsanded: Floats
    bare: Floats
    dose: Floats
    on_part: NDArray[np.bool_]


def render(raster: Raster, folder: Path) -> Rendered:
    """Renders the scene that is built; files in the folder are written and removed."""
    prepare(raster)
    seen = centres(folder)
    on_part = seen[:, :, 1] > 0.5
    set_state("as dosed")
    as_dosed = shot(folder)
    frame_part(on_part)
    references = []
    for state in ("unsanded", "bare"):
        set_state(state)
        references.append(shot(folder))
    return Rendered(as_dosed, references[0], references[1], seen[:, :, 0], on_part)


def prepare(raster: Raster) -> None:
    """Settings of Cycles. The geometry is kept between renders, and all have the same noise."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = raster.size
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True
    scene.render.threads_mode = "FIXED" if raster.threads else "AUTO"
    scene.render.threads = max(raster.threads, 1)
    cycles = scene.cycles
    cycles.device, cycles.seed, cycles.samples = "CPU", raster.seed, raster.samples
    cycles.use_adaptive_sampling, cycles.use_denoising = False, True
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 3, 2, 2
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect, cycles.use_light_tree = 8.0, False


def frame_part(on_part: NDArray[np.bool_]) -> None:
    """Limits the following renders to the pixels of the workpiece, with a margin."""
    if not on_part.any():
        return
    render_settings = bpy.context.scene.render
    height, width = on_part.shape
    rows, columns = np.flatnonzero(on_part.any(axis=1)), np.flatnonzero(on_part.any(axis=0))
    render_settings.use_border = True
    render_settings.border_min_x = max(columns[0] - MARGIN, 0) / width
    render_settings.border_max_x = min(columns[-1] + 1 + MARGIN, width) / width
    render_settings.border_min_y = max(height - rows[-1] - 1 - MARGIN, 0) / height
    render_settings.border_max_y = min(height - rows[0] + MARGIN, height) / height


def shot(folder: Path) -> Floats:
    """Renders once; returns the colours, shape `[h, w, 3]`, from the top left."""
    scene = bpy.context.scene
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    path = folder / "shot.exr"
    scene.render.filepath = str(path)
    with silent():
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    path.unlink()
    return pixels.reshape(height, width, -1)[::-1, :, :3].copy()


@contextmanager
def silent() -> Iterator[None]:
    """Drops what Blender itself writes to standard output."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def centres(folder: Path) -> Floats:
    """Dose, object index and 0 at the surface point of each pixel's centre, shape `[h, w, 3]`.

    One ray a pixel, without depth of field, meets surfaces that emit these numbers.
    """
    scene = bpy.context.scene
    cycles, layer, focus = scene.cycles, scene.view_layers[0], scene.camera.data.dof
    changes: list[tuple[Any, str, Any]] = [
        (layer, "material_override", numbers_material()),
        (scene, "world", None),
        (focus, "use_dof", False),
        (cycles, "samples", 1),
        (cycles, "use_denoising", False),
        (cycles, "filter_width", 0.01),
    ]
    before = [(owner, name, getattr(owner, name)) for owner, name, _ in changes]
    for owner, name, value in changes:
        setattr(owner, name, value)
    seen = shot(folder)
    for owner, name, value in before:
        setattr(owner, name, value)
    return seen


def numbers_material() -> bpy.types.Material:
    """A material that emits the dose as red and the object index as green."""
    material = bpy.data.materials.new("numbers")
    nodes = Nodes(material)
    dose = nodes.add("ShaderNodeAttribute", attribute_name="dose")["Fac"]
    index = nodes.add("ShaderNodeObjectInfo")["Object Index"]
    numbers = nodes.add("ShaderNodeCombineXYZ", {0: dose, 1: index})[0]
    nodes.surface(nodes.add("ShaderNodeEmission", {"Color": numbers, "Strength": 1.0})[0])
    return material
