"""A contact sheet: images with what was marked rightly, wrongly and not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from .data import IGNORE, Example, Mask

#: Green: rightly marked. Red: wrongly marked. Blue: missed.
RIGHT, WRONG, MISSED = (60, 200, 90), (230, 60, 50), (60, 110, 240)
BOX = (255, 220, 0)
WIDTH, CAPTION, GAP = 240, 14, 6


@dataclass(frozen=True)
class Tile:
    """An image of the sheet."""

    caption: str
    example: Example
    marked: Mask
    target: int


def overlay(tile: Tile) -> Image.Image:
    """The image beside the same with coloured areas and the box."""
    label, marked = tile.example.label, tile.marked
    wanted = label == tile.target
    areas = ((marked & wanted, RIGHT), (marked & ~wanted & (label != IGNORE), WRONG), (~marked & wanted, MISSED))
    tinted = tile.example.image.copy()
    for area, colour in areas:
        tinted[area] = tinted[area] // 2 + np.array(colour, dtype=np.uint8) // 2
    left, top, right, bottom = tile.example.box
    picture = Image.fromarray(tinted)
    ImageDraw.Draw(picture).rectangle((left, top, right - 1, bottom - 1), outline=BOX)
    height = max(1, WIDTH * picture.height // picture.width)
    both = Image.new("RGB", (2 * WIDTH, height + CAPTION), "white")
    for column, each in enumerate((Image.fromarray(tile.example.image), picture)):
        both.paste(each.resize((WIDTH, height), Image.Resampling.BILINEAR), (column * WIDTH, CAPTION))
    ImageDraw.Draw(both).text((2, 1), tile.caption, fill="black")
    return both


def sheet(rows: Sequence[Sequence[Tile]]) -> Image.Image:
    """Rows of overlays under each other."""
    drawn = [[overlay(tile) for tile in row] for row in rows]
    width = max(len(row) for row in drawn) * (2 * WIDTH + GAP)
    heights = [max(each.height for each in row) + GAP for row in drawn]
    page = Image.new("RGB", (width, sum(heights)), "white")
    for number, row in enumerate(drawn):
        for column, each in enumerate(row):
            page.paste(each, (column * (2 * WIDTH + GAP), sum(heights[:number])))
    return page
