"""The surface of a workpiece: paint and primer over metal that is bare where the dose has removed them."""

import colorsys
from dataclasses import dataclass
from random import Random

import bpy

from .nodes import Nodes, Socket, rgba
from .swirl import TILE, marks_texture

Colour = tuple[float, float, float]

MATERIAL = "workpiece"
STATES = {"as dosed": (1.0, 0.0), "unsanded": (0.0, 0.0), "bare": (0.0, 1.0)}
"""Factor of the vertices' dose, and what is added to it."""
PRIMERS: tuple[Colour, ...] = (
    (0.42, 0.43, 0.42),
    (0.19, 0.2, 0.2),
    (0.27, 0.07, 0.04),
    (0.5, 0.45, 0.26),
    (0.6, 0.6, 0.58),
)
METALS: tuple[Colour, ...] = ((0.5, 0.49, 0.47), (0.58, 0.57, 0.55), (0.8, 0.81, 0.82), (0.66, 0.66, 0.68))


@dataclass(frozen=True)
class FinishDraw:
    """Drawn parameters of paint, primer, metal and dirt."""

    paint: Colour
    paint_roughness: float
    clear_coat: float
    orange_peel_m: float
    flake: float
    primer: Colour
    primer_from: float
    metal_from: float
    feather: float
    raggedness: float
    metal: Colour
    metal_roughness: float
    anisotropy: float
    marks_radius_m: tuple[float, float]
    marks_depth_m: float
    dirt: float
    dirt_colour: Colour
    seed: str

    @classmethod
    def draw(cls, seed: str) -> "FinishDraw":
        """Draws paint of any colour, with or without primer, over steel or aluminium."""
        random = Random(f"{seed}/finish")
        between = random.uniform
        with_primer = random.random() < 0.75
        primer_from = between(0.3, 0.45)
        wide = random.random() < 0.4
        return cls(
            paint=paint_colour(random),
            paint_roughness=between(0.12, 0.6),
            clear_coat=between(0.3, 1.0) if random.random() < 0.6 else 0.0,
            orange_peel_m=between(0.0, 2.5e-5),
            flake=between(0.3, 0.8) if random.random() < 0.25 else 0.0,
            primer=random.choice(PRIMERS),
            primer_from=primer_from,
            metal_from=between(0.62, 0.82) if with_primer else primer_from,
            feather=between(0.08, 0.25),
            raggedness=between(0.15, 0.6),
            metal=random.choice(METALS),
            metal_roughness=between(0.3, 0.58),
            anisotropy=between(0.0, 0.6),
            marks_radius_m=(0.006, between(0.012, 0.03)) if wide else (0.0015, between(0.003, 0.006)),
            marks_depth_m=between(4e-6, 2e-5),
            dirt=between(0.0, 0.35) if random.random() < 0.6 else 0.0,
            dirt_colour=(between(0.15, 0.4), between(0.13, 0.32), between(0.1, 0.25)),
            seed=seed,
        )


def paint_colour(random: Random) -> Colour:
    """Any hue, or white, grey or black, as on machines."""
    if random.random() < 0.3:
        grey = random.choice((0.03, 0.12, 0.3, 0.55, 0.75)) * random.uniform(0.8, 1.15)
        return (grey, grey * random.uniform(0.96, 1.04), grey * random.uniform(0.94, 1.08))
    return colorsys.hsv_to_rgb(random.random(), random.uniform(0.5, 0.98), random.uniform(0.08, 0.75))


def set_state(state: str) -> None:
    """Shows the workpiece as dosed, unsanded or bare."""
    nodes = bpy.data.materials[MATERIAL].node_tree.nodes
    for name, value in zip(("factor", "added"), STATES[state], strict=True):
        nodes[name].outputs[0].default_value = value


def finish_material(finish: FinishDraw) -> bpy.types.Material:
    """The material of the workpiece; it reads the attributes `dose` and `heat` of the vertices."""
    material = bpy.data.materials.new(MATERIAL)
    nodes = Nodes(material)
    random = Random(f"{finish.seed}/offset")
    place = nodes.add("ShaderNodeTexCoord")["Object"]
    offset = tuple(random.uniform(0.0, 1.0) for _ in range(3))
    at = nodes.add("ShaderNodeMapping", {"Vector": place, "Location": offset})[0]
    marks = swirl(nodes, at, finish, random)
    gone = gone_share(nodes, at, marks, finish)
    bare = nodes.step(gone, finish.metal_from, min(finish.metal_from + finish.feather, 0.99))
    primed = nodes.step(gone, finish.primer_from, finish.primer_from + finish.feather)
    dull = nodes.step(gone, 0.03, 0.35)
    nodes.surface(shader(nodes, at, (gone, dull, primed, bare, marks), finish))
    return material


def swirl(nodes: Nodes, at: Socket, finish: FinishDraw, random: Random) -> Socket:
    """Depth of the pad's marks, about 0.5, on three sides of the workpiece."""
    place = nodes.add("ShaderNodeVectorMath", {0: at, "Scale": 1.0 / TILE}, operation="SCALE")[0]
    texture = marks_texture(random, finish.marks_radius_m)
    return nodes.add("ShaderNodeTexImage", {"Vector": place}, image=texture, projection="BOX", projection_blend=0.2)[0]


def gone_share(nodes: Nodes, at: Socket, marks: Socket, finish: FinishDraw) -> Socket:
    """Share of the coating that is gone: min(D, 1), uneven between 0 and 1 by noise and the pad's marks."""
    attribute = nodes.add("ShaderNodeAttribute", attribute_name="dose")["Fac"]
    dose = nodes.math("MULTIPLY_ADD", attribute, nodes.value("factor", 1.0), nodes.value("added", 0.0))
    within = nodes.math("MINIMUM", dose, 1.0)
    between = nodes.math("MULTIPLY", nodes.math("MULTIPLY", within, nodes.math("SUBTRACT", 1.0, within)), 4.0)
    uneven = nodes.math("ADD", nodes.noise(at, 260.0, 3.0), nodes.math("MULTIPLY", marks, 0.8))
    uneven = nodes.math("MULTIPLY", nodes.math("SUBTRACT", uneven, 0.9), finish.raggedness)
    return nodes.math("MULTIPLY_ADD", uneven, between, within)


def shader(
    nodes: Nodes, at: Socket, layers: tuple[Socket, Socket, Socket, Socket, Socket], finish: FinishDraw
) -> Socket:
    """One principled surface whose inputs follow the layers."""
    gone, dull, primed, bare, marks = layers
    dirty = dirt(nodes, at, finish)
    flake = flakes(nodes, at, finish)
    paint = nodes.blend(nodes.math("MULTIPLY", flake, 0.35), rgba(finish.paint), (1.0, 1.0, 1.0, 1.0), "SCREEN")
    coated = nodes.blend(primed, paint, rgba(finish.primer))
    coloured = nodes.blend(bare, coated, metal_colour(nodes, at, marks, finish))
    roughness = nodes.mix(primed, nodes.mix(dull, finish.paint_roughness, 0.6), 0.75)
    cloudy = nodes.remap(nodes.noise(at, 45.0, 3.0), (0.3, 0.7), (-0.07, 0.09))
    scratched = nodes.math("MULTIPLY_ADD", marks, 0.3, nodes.math("ADD", cloudy, finish.metal_roughness - 0.15))
    roughness = nodes.mix(bare, roughness, scratched)
    metallic = nodes.mix(bare, nodes.math("MULTIPLY", flake, nodes.math("SUBTRACT", 1.0, primed)), 1.0)
    clear = nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, dull), finish.clear_coat)
    clean = nodes.math("SUBTRACT", 1.0, dirty)
    return nodes.principled(
        Base_Color=nodes.blend(dirty, coloured, rgba(finish.dirt_colour)),
        Metallic=nodes.math("MULTIPLY", metallic, clean),
        Roughness=nodes.mix(dirty, roughness, 0.9),
        Coat_Weight=nodes.math("MULTIPLY", clear, clean),
        Coat_Roughness=0.05,
        Anisotropic=nodes.math("MULTIPLY", bare, finish.anisotropy),
        Tangent=brushed(nodes, at, marks),
        Normal=relief(nodes, at, (gone, bare, marks), finish),
    )


def metal_colour(nodes: Nodes, at: Socket, marks: Socket, finish: FinishDraw) -> Socket:
    """The metal, darker in its marks, and tinted by heat near a weld."""
    clouds = nodes.remap(nodes.noise(at, 30.0, 4.0), (0.3, 0.7), (0.62, 0.85))
    shade = nodes.math("MULTIPLY_ADD", marks, 0.6, nodes.math("SUBTRACT", clouds, 0.05))
    grey = nodes.add("ShaderNodeCombineColor", {0: shade, 1: shade, 2: shade})[0]
    plain = nodes.blend(1.0, rgba(finish.metal), grey, "MULTIPLY")
    heat = nodes.add("ShaderNodeAttribute", attribute_name="heat")["Fac"]
    tint = nodes.blend(nodes.step(heat, 0.3, 0.75), (0.55, 0.38, 0.2, 1.0), (0.25, 0.27, 0.42, 1.0))
    return nodes.blend(nodes.math("MULTIPLY", nodes.step(heat, 0.0, 0.5), 0.45), plain, tint)


def brushed(nodes: Nodes, at: Socket, marks: Socket) -> Socket:
    """Tangents whose direction changes from mark to mark, as that of sanding does."""
    angle = nodes.math("MULTIPLY_ADD", marks, 6.0, nodes.math("MULTIPLY", nodes.noise(at, 150.0, 2.0), 14.0))
    along: dict[str | int, Socket] = {0: nodes.math("COSINE", angle), 1: nodes.math("SINE", angle)}
    return nodes.add("ShaderNodeCombineXYZ", along)[0]


def flakes(nodes: Nodes, at: Socket, finish: FinishDraw) -> Socket:
    """Share of metallic flake in the paint, cell by cell."""
    cells = nodes.add("ShaderNodeTexVoronoi", {"Vector": at, "Scale": 2500.0})["Color"]
    share = nodes.add("ShaderNodeSeparateColor", {0: cells})[0]
    return nodes.math("MULTIPLY", share, finish.flake)


def dirt(nodes: Nodes, at: Socket, finish: FinishDraw) -> Socket:
    """Share of the surface that dust and dirt cover."""
    clouds = nodes.step(nodes.noise(at, 38.0, 5.0), 0.42, 0.75)
    specks = nodes.step(nodes.noise(at, 900.0, 2.0), 0.66, 0.74)
    return nodes.math("MULTIPLY", nodes.math("MAXIMUM", clouds, specks), finish.dirt)


def relief(nodes: Nodes, at: Socket, layers: tuple[Socket, Socket, Socket], finish: FinishDraw) -> Socket:
    """The normal with orange peel in the paint, marks in the metal, and a step of a tenth of a millimetre between."""
    gone, bare, marks = layers
    peel = nodes.math("MULTIPLY", nodes.noise(at, 550.0, 1.0), finish.orange_peel_m)
    grooves = nodes.math("MULTIPLY", marks, finish.marks_depth_m)
    step = nodes.math("MULTIPLY", gone, -1e-4)
    return nodes.bump(nodes.math("ADD", nodes.mix(bare, peel, grooves), step))
