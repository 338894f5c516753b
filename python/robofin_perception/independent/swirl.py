"""The marks that a sanding pad leaves in metal: many thin arcs."""

from random import Random

import bpy
import numpy as np
from PIL import Image, ImageDraw, ImageFilter

PIXELS = 768
TILE = 0.12
"""Side of the square that repeats [m]."""


def marks(random: Random, radius: tuple[float, float], count: int) -> Image.Image:
    """A tile of arcs with radii of a range [m], as depths about 128; it continues at its edges."""
    tile = Image.new("L", (PIXELS, PIXELS), 128)
    draw = ImageDraw.Draw(tile)
    for _ in range(count):
        size = random.uniform(*radius) / TILE * PIXELS
        x, y = random.uniform(0, PIXELS), random.uniform(0, PIXELS)
        start, depth = random.uniform(0, 360), random.randrange(256)
        sweep = random.uniform(40, 300) if size < 0.05 * PIXELS else random.uniform(20, 90)
        for dx in (-PIXELS, 0, PIXELS):
            for dy in (-PIXELS, 0, PIXELS):
                box = (x + dx - size, y + dy - size, x + dx + size, y + dy + size)
                draw.arc(box, start, start + sweep, fill=depth)
    return tile.filter(ImageFilter.GaussianBlur(0.7))


def marks_texture(random: Random, radius: tuple[float, float]) -> bpy.types.Image:
    """The marks as a texture of Blender."""
    depths = np.asarray(marks(random, radius, 3500), dtype=np.float32)[::-1] / 255.0
    texture = bpy.data.images.new("swirl", PIXELS, PIXELS, float_buffer=True, is_data=True)
    pixels = np.ones((PIXELS, PIXELS, 4), dtype=np.float32)
    pixels[:, :, :3] = depths[:, :, None]
    texture.pixels.foreach_set(pixels.ravel())
    return texture
