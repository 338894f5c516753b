"""Draws the figures of `scale.py`: assets a second over workers.

    python benchmarks/scale_figure.py benchmarks/scale.json ../docs/clusters.svg
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

#: Exponents of ten at the ends of the axes: workers, and assets a second.
ACROSS, UP = (0, 4), (-1, 4)
#: Place of the axes in the drawing [px].
LEFT, RIGHT, TOP, BOTTOM = 70, 520, 34, 330


def main() -> None:
    """Reads the figures and writes the drawing."""
    found = json.loads(Path(sys.argv[1]).read_text())
    Path(sys.argv[2]).write_text(drawn(found))


def drawn(found: dict[str, Any]) -> str:
    """Ideal line, real workers, simulated ones, and the rate at which a driver is busy, as SVG."""
    limit, rate = found["driver"][0]["items_per_second"], 1.0 / found["asset_seconds"]
    x, y = at(10 ** ACROSS[1], limit)
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 390" font-family="sans-serif" font-size="13">'
             '<rect width="640" height="390" fill="white"/>', *axes()]
    parts += [line((1.0, rate), (min(10 ** ACROSS[1], 10 ** UP[1] / rate), min(10 ** UP[1], rate * 10 ** ACROSS[1])), "#888"),
              line((1.0, limit), (10 ** ACROSS[1], limit), "#c33"),
              f'<text x="{x + 6:.1f}" y="{y + 4:.1f}" fill="#c33">one driver</text>',
              f'<text x="{LEFT + 12}" y="{at(1.0, rate)[1] - 22:.1f}" fill="#888">an asset in {found["asset_seconds"]} s</text>']
    real = [(row["workers"], row["assets"] / row["seconds"]) for row in found["assets"]]
    simulated = [(row["workers"], row["items_per_second"]) for row in found["simulated"]]
    parts += dots(real, "#06c", "assets, two cores") + dots(simulated, "#390", "simulated nodes")
    return "\n".join([*parts, "</svg>"]) + "\n"


def at(workers: float, rate: float) -> tuple[float, float]:
    """Place in the drawing, both axes logarithmic [px]."""
    across = (math.log10(workers) - ACROSS[0]) / (ACROSS[1] - ACROSS[0])
    up = (math.log10(rate) - UP[0]) / (UP[1] - UP[0])
    return LEFT + (RIGHT - LEFT) * across, BOTTOM - (BOTTOM - TOP) * up


def axes() -> list[str]:
    """Lines and numbers at powers of ten."""
    parts = []
    for exponent in range(ACROSS[0], ACROSS[1] + 1):
        x, _ = at(10 ** exponent, 1.0)
        parts.append(f'<path d="M{x:.1f} {TOP}V{BOTTOM}" stroke="#ddd"/><text x="{x:.1f}" y="{BOTTOM + 18}" '
                     f'text-anchor="middle">{10 ** exponent}</text>')
    for exponent in range(UP[0], UP[1] + 1):
        _, y = at(1.0, 10 ** exponent)
        parts.append(f'<path d="M{LEFT} {y:.1f}H{RIGHT}" stroke="#ddd"/><text x="{LEFT - 8}" y="{y + 4:.1f}" '
                     f'text-anchor="end">{10.0 ** exponent:g}</text>')
    return [*parts, f'<text x="{(LEFT + RIGHT) / 2:.0f}" y="{BOTTOM + 42}" text-anchor="middle">workers</text>',
            f'<text x="{LEFT - 50}" y="{TOP - 16}">assets a second</text>']


def line(start: tuple[float, float], end: tuple[float, float], colour: str) -> str:
    """A dashed line."""
    (x, y), (to_x, to_y) = at(*start), at(*end)
    return f'<path d="M{x:.1f} {y:.1f}L{to_x:.1f} {to_y:.1f}" stroke="{colour}" stroke-dasharray="6 4"/>'


def dots(points: list[tuple[float, float]], colour: str, name: str) -> list[str]:
    """Points, and their name right of the last one."""
    parts = []
    for point in points:
        x, y = at(*point)
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>')
    x, y = at(*points[-1])
    return [*parts, f'<text x="{x + 8:.1f}" y="{y + 14:.1f}" fill="{colour}">{name}</text>']


if __name__ == "__main__":
    main()
