"""Draws the learning curve of `train_policy.py`."""

from __future__ import annotations

import numpy as np

#: Steps so far; mean bead left and depth of the gouges [mm] of the episodes that ended since the last row.
Curve = list[tuple[int, float, float]]


def drawn(curve: Curve, marks: dict[str, tuple[float, float]]) -> str:
    """The learning curve as SVG, bead left above depth of the gouges; `marks` are baselines, drawn as dashed lines."""
    last, half = curve[-1][0], 220
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {2 * half + 30}" font-family="sans-serif" '
             f'font-size="13"><rect width="640" height="{2 * half + 30}" fill="white"/>']
    for top, title, column, factor in ((0, "bead left [%]", 1, 100.0), (half, "depth of the gouges [µm]", 2, 1e3)):
        line = [(row[0] / last, factor * row[column]) for row in curve]
        levels = {name: factor * values[column - 1] for name, values in marks.items()}
        parts += _panel(line, levels, (top, half, title))
    parts.append(f'<text x="310" y="{2 * half + 18}" text-anchor="middle">steps in training, 0 to {last}; means of training '
                 "episodes</text></svg>")
    return "\n".join(parts) + "\n"


def _panel(line: list[tuple[float, float]], levels: dict[str, float], place: tuple[int, int, str]) -> list[str]:
    """A line over 0 to 1 and dashed levels in a panel of the drawing."""
    top, height, title = place
    high = 1.1 * max([value for _, value in line] + list(levels.values()))

    def at(share: float, value: float) -> str:
        return f"{60 + 490 * share:.1f},{top + height - 10 - (height - 45) * value / high:.1f}"

    parts = [f'<text x="60" y="{top + 22}">{title}</text>']
    for value in np.linspace(0.0, high / 1.1, 3):
        x, y = at(0.0, float(value)).split(",")
        parts.append(f'<path d="M{x} {y}H550" stroke="#ddd"/><text x="52" y="{float(y) + 4:.1f}" text-anchor="end">{value:.0f}'
                     "</text>")
    for name, value in levels.items():
        x, y = at(0.0, value).split(",")
        parts.append(f'<path d="M{x} {y}H550" stroke="#888" stroke-dasharray="6 4"/><text x="556" y="{float(y) + 4:.1f}">'
                     f"{name}</text>")
    x, y = at(*line[0]).split(",")
    parts.append(f'<polyline points="{" ".join(at(*row) for row in line)}" fill="none" stroke="#06c" stroke-width="2"/>'
                 f'<text x="{x}" y="{float(y) - 8:.1f}" text-anchor="end" fill="#06c">ppo</text>')
    return parts
