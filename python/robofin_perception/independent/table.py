"""The table: wood, concrete, steel, cloth or a mat, by procedural textures."""

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

import bpy

from .nodes import Nodes, Socket, rgba

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class TableDraw:
    """Drawn parameters of the table."""

    kind: str
    colour: Colour
    other: Colour
    roughness: float
    scale: float
    turn: float

    @classmethod
    def draw(cls, seed: str) -> "TableDraw":
        """Draws one of the kinds of table."""
        random = Random(f"{seed}/table")
        between = random.uniform
        kind = random.choice(tuple(KINDS))
        light = between(0.5, 1.4)
        colour, other = COLOURS[kind]
        if kind in ("cloth", "mat"):
            colour = (between(0.02, 0.5), between(0.02, 0.5), between(0.02, 0.5))
            other = (colour[0] * 0.5, colour[1] * 0.5, colour[2] * 0.5)
        scaled = [(one[0] * light, one[1] * light, one[2] * light) for one in (colour, other)]
        return cls(kind, scaled[0], scaled[1], between(0.25, 0.6), between(0.7, 1.5), between(0.0, 6.283))


def add_table(table: TableDraw) -> None:
    """Adds a square of four metres at z = 0."""
    mesh = bpy.data.meshes.new("table")
    mesh.from_pydata([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new("table")
    nodes = Nodes(material)
    place = nodes.add("ShaderNodeTexCoord")["Object"]
    size = (table.scale, table.scale, table.scale)
    at = nodes.add("ShaderNodeMapping", {"Vector": place, "Rotation": (0.0, 0.0, table.turn), "Scale": size})[0]
    nodes.surface(KINDS[table.kind](nodes, at, table))
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("table", mesh))


def wood(nodes: Nodes, at: Socket, table: TableDraw) -> Socket:
    """Planks with grain."""
    stretched = nodes.add("ShaderNodeMapping", {"Vector": at, "Scale": (1.0, 0.09, 1.0)})[0]
    inputs: dict[str | int, Socket] = {"Vector": stretched, "Scale": 11.0, "Distortion": 9.0, "Detail": 3.0}
    grain = nodes.add("ShaderNodeTexWave", inputs)["Fac"]
    fine = nodes.noise(stretched, 500.0, 4.0)
    colour = nodes.blend(nodes.math("MULTIPLY", grain, 0.6), rgba(table.colour), rgba(table.other))
    colour = nodes.blend(nodes.math("MULTIPLY", nodes.step(fine, 0.5, 0.75), 0.5), colour, rgba(table.other))
    planks: dict[str | int, Socket] = {
        "Vector": nodes.add("ShaderNodeMapping", {"Vector": at, "Rotation": (0.0, 0.0, 1.5708)})[0],
        "Color1": (1.0, 1.0, 1.0, 1.0),
        "Color2": (0.75, 0.75, 0.75, 1.0),
        "Mortar": (0.12, 0.1, 0.08, 1.0),
        "Scale": 1.0,
        "Mortar Size": 0.0012,
        "Brick Width": 1.3,
        "Row Height": 0.11,
    }
    planked = nodes.blend(1.0, colour, nodes.add("ShaderNodeTexBrick", planks)["Color"], "MULTIPLY")
    normal = nodes.bump(nodes.math("MULTIPLY", fine, 2e-4))
    return nodes.principled(Base_Color=planked, Roughness=table.roughness, Normal=normal)


def concrete(nodes: Nodes, at: Socket, table: TableDraw) -> Socket:
    """Clouds, pores and cracks."""
    clouds = nodes.remap(nodes.noise(at, 9.0, 8.0), (0.3, 0.7), (0.0, 1.0))
    pores = nodes.step(nodes.noise(at, 320.0, 3.0), 0.62, 0.72)
    bend = nodes.add("ShaderNodeTexNoise", {"Vector": at, "Scale": 12.0})["Color"]
    crooked = nodes.add("ShaderNodeVectorMath", {0: bend, 1: (0.05, 0.05, 0.0), 2: at}, operation="MULTIPLY_ADD")[0]
    edges = nodes.add("ShaderNodeTexVoronoi", {"Vector": crooked, "Scale": 2.2}, feature="DISTANCE_TO_EDGE")[0]
    cracks = nodes.math("SUBTRACT", 1.0, nodes.step(edges, 0.0, 0.004))
    dark = nodes.math("MAXIMUM", nodes.math("MULTIPLY", pores, 0.5), cracks)
    colour = nodes.blend(dark, nodes.blend(clouds, rgba(table.colour), rgba(table.other)), (0.05, 0.05, 0.05, 1.0))
    height = nodes.math("MULTIPLY", dark, -4e-4)
    return nodes.principled(Base_Color=colour, Roughness=0.85, Normal=nodes.bump(height))


def steel(nodes: Nodes, at: Socket, table: TableDraw) -> Socket:
    """A worn plate: brushed, scratched, with stains."""
    along = nodes.add("ShaderNodeMapping", {"Vector": at, "Scale": (1.0, 0.02, 1.0)})[0]
    brush = nodes.noise(along, 900.0, 2.0)
    stains = nodes.step(nodes.noise(at, 14.0, 6.0), 0.45, 0.7)
    inputs: dict[str | int, Socket] = {"Vector": at, "Scale": 14.0, "Distortion": 3.0, "Detail": 2.0}
    scratches = nodes.step(nodes.add("ShaderNodeTexWave", inputs)["Fac"], 0.992, 1.0)
    roughness = nodes.math("ADD", nodes.mix(brush, 0.2, 0.45), nodes.math("MULTIPLY", stains, 0.25))
    colour = nodes.blend(nodes.math("MULTIPLY", stains, 0.5), rgba(table.colour), rgba(table.other))
    height = nodes.math("MULTIPLY_ADD", scratches, -5e-5, nodes.math("MULTIPLY", brush, 2e-5))
    return nodes.principled(
        Base_Color=colour, Metallic=0.9, Roughness=roughness, Anisotropic=0.5, Normal=nodes.bump(height)
    )


def cloth(nodes: Nodes, at: Socket, table: TableDraw) -> Socket:
    """A weave with folds and worn patches."""
    weave = nodes.add("ShaderNodeTexChecker", {"Vector": at, "Scale": 900.0})["Fac"]
    folds = nodes.noise(at, 7.0, 1.0)
    worn = nodes.remap(nodes.noise(at, 25.0, 5.0), (0.3, 0.7), (0.0, 1.0))
    mixed = nodes.math("MULTIPLY", nodes.math("ADD", weave, worn), 0.5)
    colour = nodes.blend(mixed, rgba(table.colour), rgba(table.other))
    height = nodes.math("MULTIPLY_ADD", folds, 0.02, nodes.math("MULTIPLY", weave, 1e-4))
    return nodes.principled(Base_Color=colour, Roughness=0.95, Sheen_Weight=0.4, Normal=nodes.bump(height))


def mat(nodes: Nodes, at: Socket, table: TableDraw) -> Socket:
    """A cutting mat with a grid of lines every centimetre."""
    inputs: dict[str | int, Socket] = {
        "Vector": at,
        "Color1": rgba(table.colour),
        "Color2": rgba(table.colour),
        "Mortar": (0.5, 0.5, 0.4, 1.0),
        "Scale": 1.0,
        "Mortar Size": 0.0004,
        "Brick Width": 0.02,
        "Row Height": 0.02,
    }
    lines = nodes.add("ShaderNodeTexBrick", inputs, offset=0.0)["Color"]
    worn = nodes.step(nodes.noise(at, 20.0, 5.0), 0.45, 0.75)
    colour = nodes.blend(nodes.math("MULTIPLY", worn, 0.5), lines, rgba(table.other))
    return nodes.principled(Base_Color=colour, Roughness=table.roughness)


KINDS: dict[str, Callable[[Nodes, Socket, TableDraw], Socket]] = {
    "wood": wood,
    "concrete": concrete,
    "steel": steel,
    "cloth": cloth,
    "mat": mat,
}
COLOURS: dict[str, tuple[Colour, Colour]] = {
    "wood": ((0.4, 0.24, 0.12), (0.2, 0.1, 0.045)),
    "concrete": ((0.4, 0.39, 0.37), (0.24, 0.235, 0.23)),
    "steel": ((0.42, 0.42, 0.43), (0.16, 0.11, 0.08)),
    "cloth": ((0.1, 0.1, 0.1), (0.05, 0.05, 0.05)),
    "mat": ((0.1, 0.1, 0.1), (0.05, 0.05, 0.05)),
}
