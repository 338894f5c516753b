"""Renders the pictures of a set, one after another."""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from PIL import Image

from .dataset import Dataset, recipe_of
from .labels import Labels, agreement, code, labels, seen_share
from .plan import Planned, Shares, plan
from .render import Raster, Rendered, render
from .scene import SceneDraw, build
from .sensor import exposure, expose
from .source import SourceSet

NUMBERS = ("seed", "count", "samples", "states", "split")
"""Settings of a recipe, besides the size."""
RENDERER = f"Blender Cycles {bpy.app.version_string}"


@dataclass(frozen=True)
class Settings:
    """Settings of a production: folders, number of pictures, pixels, samples of each pixel, seed, threads (0: all).

    `states` and `split` are those of `Shares`.
    """

    data: Path
    out: Path
    count: int
    size: tuple[int, int]
    samples: int
    seed: int
    states: int
    split: str | None
    threads: int
    resume: bool


@dataclass(frozen=True)
class Picture:
    """A picture with both labels and its metadata."""

    image: Image.Image
    labels: dict[str, Labels]
    record: dict[str, Any]


def produce(settings: Settings) -> Iterator[tuple[Planned, float]]:
    """Renders what is missing; yields each picture with its seconds."""
    source = SourceSet(settings.data)
    options = {name: getattr(settings, name) for name in NUMBERS} | {"size": list(settings.size)}
    recipe = recipe_of(options, source.sha256, bpy.app.version_string)
    dataset = Dataset(settings.out, recipe, settings.resume)
    for planned in plan(source, settings.count, settings.seed, Shares(settings.states, settings.split)):
        if planned.id in dataset.done():
            continue
        start = time.monotonic()
        made = picture(source, planned, settings)
        dataset.add(planned, made.image, made.labels, made.record)
        yield planned, time.monotonic() - start


def picture(source: SourceSet, planned: Planned, settings: Settings) -> Picture:
    """Draws, builds and renders the scene of a picture."""
    placement_seed = f"{settings.seed}/{planned.workpiece}/{planned.placement}"
    draw = SceneDraw.draw(placement_seed, f"{settings.seed}/{planned.id}")
    dose = source.dose(planned.workpiece, planned.treatment)
    width, height = settings.size
    build(draw, source.surface(planned.workpiece), dose, width / height)
    raster = Raster(settings.size, settings.samples, settings.threads, draw.sensor.seed % 2**31)
    with tempfile.TemporaryDirectory() as folder:
        rendered = render(raster, Path(folder))
        made = developed(rendered, draw, Path(folder))
    identity = {
        "workpiece": planned.workpiece,
        "placement": planned.placement,
        "treatment": planned.treatment.record(),
        "split": planned.split,
        "renderer": RENDERER,
    }
    return Picture(made.image, made.labels, identity | made.record)


def developed(rendered: Rendered, draw: SceneDraw, folder: Path) -> Picture:
    """The picture that the sensor makes, and the labels, which know no noise."""
    on_part = rendered.on_part
    exposed = exposure(rendered.as_dosed, on_part, draw.sensor.aim)
    seen, unsanded, bare = (
        code(light, exposed) for light in (rendered.as_dosed, rendered.unsanded, rendered.bare)
    )
    by_appearance = labels(seen_share(seen, unsanded, bare), on_part)
    by_dose = labels(np.minimum(rendered.dose, 1.0), on_part)
    record = {
        "exposed_share": float((rendered.dose[on_part] >= 1.0).mean()) if on_part.any() else 0.0,
        "agreement": agreement(by_appearance, by_dose),
        "scene": draw.record(),
    }
    image = expose(rendered.as_dosed, exposed, draw.sensor, folder / "toned.png")
    return Picture(image, {"appearance": by_appearance, "dose": by_dose}, record)
