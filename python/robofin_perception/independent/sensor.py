"""From linear light to a picture file: lens, noise, tone curve, compression."""

import io
import math
from dataclasses import dataclass
from pathlib import Path
from random import Random

import bpy
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

Floats = NDArray[np.float32]

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of red, green and blue (ITU-R BT.709)."""
VIEWS = (
    ("Standard", "None"),
    ("Filmic", "Medium High Contrast"),
    ("Filmic", "High Contrast"),
    ("AgX", "AgX - Medium High Contrast"),
    ("AgX", "AgX - Punchy"),
    ("Khronos PBR Neutral", "None"),
)
"""Tone curves of Blender, and looks."""


@dataclass(frozen=True)
class SensorDraw:
    """Drawn parameters of the sensor."""

    aim: float
    view: str
    look: str
    white_balance: tuple[float, float]
    gamma: float
    vignette: float
    full_well: float
    read_noise: float
    sharpening: float
    jpeg_quality: int
    colour_halved: bool
    seed: int

    @classmethod
    def draw(cls, seed: str) -> "SensorDraw":
        """Draws a clean or a poor sensor and its processing."""
        random = Random(f"{seed}/sensor")
        between = random.uniform
        view, look = random.choice(VIEWS)
        return cls(
            aim=math.exp(between(math.log(0.14), math.log(0.42))),
            view=view,
            look=look,
            white_balance=(between(0.88, 1.14), between(0.88, 1.14)),
            gamma=between(0.75, 1.1),
            vignette=between(0.0, 0.45),
            full_well=math.exp(between(math.log(1200.0), math.log(3e4))),
            read_noise=between(2.0, 14.0),
            sharpening=between(0.3, 1.2) if random.random() < 0.4 else 0.0,
            jpeg_quality=random.randint(45, 96),
            colour_halved=random.random() < 0.7,
            seed=random.getrandbits(32),
        )


def exposure(light: Floats, on_part: NDArray[np.bool_], aim: float) -> float:
    """Exposure at which the mean luminance of the workpiece is the aim."""
    seen = light[on_part] @ np.array(LUMINANCE, dtype=np.float32)
    return aim / float(seen.mean()) if seen.size and seen.mean() > 0.0 else 1.0


def expose(light: Floats, exposed: float, sensor: SensorDraw, beside: Path) -> Image.Image:
    """The picture of linear light, shape `[h, w, 3]`; a file beside the picture is written and removed."""
    balance = np.array([sensor.white_balance[0], 1.0, sensor.white_balance[1]], dtype=np.float32)
    signal = light * exposed * balance * (1.0 - sensor.vignette * radius_squared(light)[:, :, None])
    picture = toned(noisy(signal, sensor), sensor, beside)
    if sensor.sharpening:
        picture = picture.filter(ImageFilter.UnsharpMask(1.0, int(100 * sensor.sharpening), 0))
    picture = picture.point([round(255 * (k / 255) ** sensor.gamma) for k in range(256)] * 3)
    packed = io.BytesIO()
    picture.save(packed, "JPEG", quality=sensor.jpeg_quality, subsampling=2 if sensor.colour_halved else 0)
    return Image.open(packed).convert("RGB")


def radius_squared(light: Floats) -> Floats:
    """Squared distance of pixels from the picture's centre, 1 in its corners."""
    rows, columns = (np.linspace(-1.0, 1.0, size, dtype=np.float32) for size in light.shape[:2])
    return np.asarray(0.5 * (rows[:, None] ** 2 + columns[None] ** 2))


def noisy(signal: Floats, sensor: SensorDraw) -> Floats:
    """The signal with the noise of photons and of the read-out; a saturated pixel is 1 or more."""
    random = np.random.default_rng(sensor.seed)
    electrons = np.clip(signal, 0.0, 8.0) * sensor.full_well
    counted = random.normal(electrons, np.sqrt(electrons + sensor.read_noise**2))
    return np.asarray(np.maximum(counted / sensor.full_well, 0.0), dtype=np.float32)


def toned(signal: Floats, sensor: SensorDraw, beside: Path) -> Image.Image:
    """The signal under a tone curve of Blender, as eight-bit sRGB."""
    height, width = signal.shape[:2]
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[:, :, :3] = signal[::-1]
    image = bpy.data.images.new("signal", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    scene = bpy.context.scene
    scene.view_settings.view_transform, scene.view_settings.look = sensor.view, sensor.look
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode, scene.render.image_settings.color_depth = "RGB", "8"
    image.save_render(str(beside), scene=scene)
    bpy.data.images.remove(image)
    with Image.open(beside) as written:
        picture = written.convert("RGB")
    beside.unlink()
    return picture
