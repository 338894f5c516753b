"""The marks that a sanding pad leaves in metal: many thin arcs."""

from random import Random

import bpy
import numpy as np
from PIL import Image, ImageDraw, ImageFilter

PIXELS = 768
TILE = 0.12
"""Side of the square that repeats [m]."""


def marks(random: Random, radius: tuple[float, float]) -> Image.Image:
    """A tile of arcs with radii of a range [m], as depths about 128; it continues at its edges."""
    tile = Image.new("L", (PIXELS, PIXELS), 128)
    for count, widths, deepest in ((400, (6, 16), 60), (3000, (1, 2), 127)):
        draw = ImageDraw.Draw(tile)
        for _ in range(count):
            arc(draw, random, radius, (random.randint(*widths), 128 + random.randint(-deepest, deepest)))
        tile = tile.filter(ImageFilter.GaussianBlur(0.2 * widths[1]))
    return tile


def arc(draw: ImageDraw.ImageDraw, random: Random, radius: tuple[float, float], mark: tuple[int, int]) -> None:
    """Draws an arc of a width [pixels] and a depth anywhere on the tile."""
    size = random.uniform(*radius) / TILE * PIXELS
    x, y = random.uniform(0, PIXELS), random.uniform(0, PIXELS)
    start, sweep = random.uniform(0, 360), random.uniform(40, 250)
    for across in copies(x, size):
        for down in copies(y, size):
            box = (across - size, down - size, across + size, down + size)
            draw.arc(box, start, start + sweep, fill=mark[1], width=mark[0])


def copies(middle: float, reach: float) -> list[float]:
    """Middles at which an arc is drawn so that the tile continues at its edges."""
    before = [middle + PIXELS] if middle < reach else []
    after = [middle - PIXELS] if middle > PIXELS - reach else []
    return [middle, *before, *after]


def marks_texture(random: Random, radius: tuple[float, float]) -> bpy.types.Image:
    """The marks as a texture of Blender."""
    depths = np.asarray(marks(random, radius), dtype=np.float32)[::-1] / 255.0
    texture = bpy.data.images.new("swirl", PIXELS, PIXELS, float_buffer=True, is_data=True)
    pixels = np.ones((PIXELS, PIXELS, 4), dtype=np.float32)
    pixels[:, :, :3] = depths[:, :, None]
    texture.pixels.foreach_set(pixels.ravel())
    return texture
