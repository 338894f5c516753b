"""Makes the tables beside it.

belt-sanding/trials.csv: a belt sander at six loads, two recipes, three months.
two-passes/passes.csv: welds ground twice at one force, the wheel dressed before each weld.

    python3 data/tables/make_tables.py

The removed depth follows K (p / p_ref)^0.75 p_ref v t with a gain of 1.3 for the coarse belt and 3 % of scatter; one row was
written down wrongly by a factor of ten.

In two-passes the bead is flatter in the second pass, so that the same force makes 4 % less pressure and a law
k (p - p_c) removes at least 4 % less, 5 % with p_c = 0.3 MPa; the real wheel removes 12 % more, with 2 % of scatter.

The same Python gives the same bytes.
"""

import csv
import datetime
import math
import pathlib
import random

ROWS = 72
AREA = 25e-4
"""Of the contact [m²]."""
REFERENCE = 8e3
"""p_ref [Pa]."""
RATE = 2.5e-11
"""K [1/Pa]: depth per pressure and way."""
EXPONENT = 0.75
COARSE = 1.3
SCATTER = 0.03
MISTAKE = 40
"""Row that is ten times too large."""


WELDS = 18
PRESSURES = [1.50, 1.44]
"""Mean pressure of the first and the second pass [MPa]."""
VOLUME = 130.0
"""Removed by a first pass [mm³]."""
RISE = 1.12
"""Of the volume, from the first pass to the second."""
SCATTER_TWO = 0.02


def belt_sanding():
    draw = random.Random(20240301)
    day = datetime.date(2024, 3, 4)
    path = pathlib.Path(__file__).parent / "belt-sanding" / "trials.csv"
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["date", "recipe", "load", "belt", "t", "depth", "humidity"])
        for row in range(ROWS):
            load = draw.choice([10, 15, 20, 25, 30, 40])
            speed = draw.choice([6, 9, 12])
            time = draw.choice([20, 30, 45])
            recipe = draw.choice(["fine", "coarse"])
            pressure = load / AREA
            depth = RATE * REFERENCE * (pressure / REFERENCE) ** EXPONENT * speed * time
            depth *= (COARSE if recipe == "coarse" else 1.0) * math.exp(draw.gauss(0.0, SCATTER))
            depth *= 10.0 if row == MISTAKE else 1.0
            humidity = round(draw.uniform(35, 60))
            table.writerow([day.isoformat(), recipe, load, speed, time, f"{1e3 * depth:.4f}", humidity])
            day += datetime.timedelta(days=draw.choice([1, 1, 2]))


def two_passes():
    draw = random.Random(20240302)
    path = pathlib.Path(__file__).parent / "two-passes" / "passes.csv"
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["weld", "pass", "wheel", "dressed", "pressure", "rpm", "t", "volume"])
        for weld in range(WELDS):
            for number, pressure in enumerate(PRESSURES):
                volume = VOLUME * RISE**number * math.exp(draw.gauss(0.0, SCATTER_TWO))
                dressed = "yes" if number == 0 else "no"
                table.writerow([weld + 1, number + 1, "A", dressed, pressure, 6000, 24, f"{volume:.2f}"])


belt_sanding()
two_passes()
