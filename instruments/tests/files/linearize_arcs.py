"""Writes the points through which pygcode goes for `arcs.nc`: arcs as lines, at most 1 um off.

    pip install pygcode==0.2.1
    python linearize_arcs.py arcs.nc > arcs_pygcode.csv
"""

import sys

from pygcode import Line, Machine
from pygcode.gcodes import GCodeArcMove, GCodeLinearMove, GCodeRapidMove
from pygcode.transform import ArcLinearizeInside, linearize_arc


def show(vector):
    print(",".join(f"{number:.6f}" for number in (vector.x, vector.y, vector.z)))


def main():
    machine = Machine()
    print("x_mm,y_mm,z_mm")
    for text in open(sys.argv[1]):
        if text.startswith("%"):
            continue
        line = Line(text)
        arcs = [code for code in line.block.gcodes if isinstance(code, GCodeArcMove)]
        others = [code for code in line.block.gcodes if not isinstance(code, GCodeArcMove)]
        modal = [] if arcs or others else line.block.modal_params
        assert not modal, text
        machine.process_gcodes(*others)
        if any(isinstance(code, (GCodeLinearMove, GCodeRapidMove)) for code in others):
            show(machine.pos.vector)
        for arc in arcs:
            start = machine.pos
            lines = linearize_arc(
                arc, start, plane=machine.mode.plane_selection, method_class=ArcLinearizeInside,
                dist_mode=machine.mode.distance, max_error=0.001, decimal_places=6,
            )
            for code in lines:
                if isinstance(code, GCodeLinearMove):
                    machine.process_gcodes(code)
                    show(machine.pos.vector)


main()
