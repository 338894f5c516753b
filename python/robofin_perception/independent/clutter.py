"""Other things on the table, on the workpiece and before the camera."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from random import Random

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector
from numpy.typing import NDArray

from .nodes import Nodes, rgba

Colour = tuple[float, float, float]
Pieces = list[tuple[str, tuple[float, float, float], Matrix]]
"""Shapes, their sizes along x, y, z [m], and where they are in the thing."""

PLACES = ("beside", "on workpiece", "before camera")


@dataclass(frozen=True)
class ThingDraw:
    """A drawn thing: its place, its size [m], its material. `along` and `across` are 0 to 1 within the place."""

    kind: str
    place: str
    along: float
    across: float
    turn: float
    size: float
    ratio: float
    colour: Colour
    metallic: float
    roughness: float


def draw_clutter(seed: str) -> tuple[ThingDraw, ...]:
    """Draws up to six things beside the workpiece; in some pictures one lies on it, or a rod is before the camera."""
    random = Random(f"{seed}/clutter")
    places = ["beside"] * random.choice((0, 1, 2, 3, 4, 6))
    if random.random() < 0.25:
        places.append("on workpiece")
    if random.random() < 0.2:
        places.append("before camera")
    return tuple(draw_thing(place, random) for place in places)


def draw_thing(place: str, random: Random) -> ThingDraw:
    """Draws a thing for a place."""
    between = random.uniform
    metallic = float(random.random() < 0.5)
    grey = between(0.3, 0.7)
    dull = (between(0.02, 0.6), between(0.02, 0.6), between(0.02, 0.6))
    if place == "before camera":
        kind, size = "rod", between(0.006, 0.016)
    elif place == "on workpiece":
        kind, size = random.choice(("bolt", "block", "disc")), between(0.008, 0.02)
    else:
        kind, size = random.choice(("block", "cylinder", "bolt", "clamp", "disc")), between(0.02, 0.07)
    return ThingDraw(
        kind=kind,
        place=place,
        along=random.random(),
        across=random.random(),
        turn=between(0.0, math.tau),
        size=size,
        ratio=between(0.3, 1.0),
        colour=(grey, grey, grey) if metallic else dull,
        metallic=metallic,
        roughness=between(0.2, 0.7),
    )


def add_clutter(things: tuple[ThingDraw, ...], placed: NDArray[np.float64], camera: bpy.types.Object) -> None:
    """Adds things to the scene, about the placed vertices of the workpiece."""
    for thing in things:
        where = {"beside": beside, "on workpiece": on_workpiece}.get(thing.place)
        frame = where(thing, placed) if where else before_camera(thing, placed, camera)
        thing_object = bpy.data.objects.new(thing.kind, mesh_of(SHAPES[thing.kind](thing)))
        thing_object.matrix_world = frame @ Matrix.Rotation(thing.turn, 4, "Z")
        material = bpy.data.materials.new(thing.kind)
        nodes = Nodes(material)
        nodes.surface(
            nodes.principled(Base_Color=rgba(thing.colour), Metallic=thing.metallic, Roughness=thing.roughness)
        )
        thing_object.data.materials.append(material)
        bpy.context.scene.collection.objects.link(thing_object)


def beside(thing: ThingDraw, placed: NDArray[np.float64]) -> Matrix:
    """A place on the table, outside the workpiece."""
    angle = math.tau * thing.along
    towards = np.array([math.cos(angle), math.sin(angle)])
    distance = float((placed[:, :2] @ towards).max()) + 0.75 * thing.size + 0.1 * thing.across
    return Matrix.Translation((*(distance * towards), 0.0))


def on_workpiece(thing: ThingDraw, placed: NDArray[np.float64]) -> Matrix:
    """A place on the highest point of the workpiece within the thing's reach."""
    low, high = placed[:, :2].min(axis=0), placed[:, :2].max(axis=0)
    aim = low + (high - low) * (0.2 + 0.6 * np.array([thing.along, thing.across]))
    x, y = placed[np.argmin(np.linalg.norm(placed[:, :2] - aim, axis=1)), :2]
    near = np.linalg.norm(placed[:, :2] - (x, y), axis=1) < 0.6 * thing.size
    return Matrix.Translation((x, y, placed[near, 2].max()))


def before_camera(thing: ThingDraw, placed: NDArray[np.float64], camera: bpy.types.Object) -> Matrix:
    """A place between the camera and an edge of the workpiece, across the view."""
    frame = camera.matrix_world
    distance = frame.translation.length * 0.55
    extent = 0.25 * float(np.ptp(placed @ np.array(frame.col[0][:3])))
    sideways = extent * (thing.along - 0.5) * 1.6
    local = Matrix.Translation(Vector((sideways, extent * (thing.across - 0.5), -distance)))
    return frame @ local


def block(thing: ThingDraw) -> Pieces:
    """A block that stands on the table."""
    size = (thing.size, thing.size * thing.ratio, 0.6 * thing.size * thing.ratio)
    return [("box", size, Matrix.Translation((0.0, 0.0, 0.5 * size[2])))]


def cylinder(thing: ThingDraw) -> Pieces:
    """A standing cylinder."""
    size = (thing.size * thing.ratio, thing.size * thing.ratio, thing.size)
    return [("round", size, Matrix.Translation((0.0, 0.0, 0.5 * thing.size)))]


def disc(thing: ThingDraw) -> Pieces:
    """A flat disc, like that of a sander."""
    size = (1.5 * thing.size, 1.5 * thing.size, 0.002)
    return [("round", size, Matrix.Translation((0.0, 0.0, 0.001)))]


def bolt(thing: ThingDraw) -> Pieces:
    """A lying bolt with a hexagonal head."""
    wide = 0.3 * thing.size
    lying = Matrix.Translation((0.0, 0.0, 0.85 * wide)) @ Matrix.Rotation(0.5 * math.pi, 4, "Y")
    head = lying @ Matrix.Translation((0.0, 0.0, 0.5 * thing.size))
    return [("round", (wide, wide, thing.size), lying), ("hexagon", (2 * wide, 2 * wide, 0.65 * wide), head)]


def clamp(thing: ThingDraw) -> Pieces:
    """A lying C-clamp with its screw."""
    bar, reach = 0.2 * thing.size, 0.8 * thing.size
    rise = Matrix.Translation((0.0, 0.0, 0.5 * bar))
    jaw = (reach, bar, bar)
    screw = rise @ Matrix.Translation((0.4 * reach, -0.5 * thing.size, 0.0)) @ Matrix.Rotation(0.5 * math.pi, 4, "X")
    return [
        ("box", (bar, 2 * thing.size, bar), rise @ Matrix.Translation((-0.5 * reach, 0.0, 0.0))),
        ("box", jaw, rise @ Matrix.Translation((0.0, thing.size, 0.0))),
        ("box", jaw, rise @ Matrix.Translation((0.0, -thing.size, 0.0))),
        ("round", (0.7 * bar, 0.7 * bar, 1.6 * thing.size), screw),
    ]


def rod(thing: ThingDraw) -> Pieces:
    """A long rod, like a cable or a part of a robot."""
    lying = Matrix.Rotation(0.5 * math.pi, 4, "X") @ Matrix.Translation((0.0, 0.0, 0.5))
    return [("round", (thing.size, thing.size, 1.0), lying)]


SHAPES: dict[str, Callable[[ThingDraw], Pieces]] = {
    "block": block,
    "cylinder": cylinder,
    "disc": disc,
    "bolt": bolt,
    "clamp": clamp,
    "rod": rod,
}


def mesh_of(pieces: Pieces) -> bpy.types.Mesh:
    """A mesh with bevelled edges from pieces."""
    shape = bmesh.new()
    for kind, size, place in pieces:
        frame = place @ Matrix.Diagonal((*size, 1.0))
        if kind == "box":
            bmesh.ops.create_cube(shape, size=1.0, matrix=frame)
        else:
            sides = 6 if kind == "hexagon" else 32
            bmesh.ops.create_cone(
                shape, cap_ends=True, segments=sides, radius1=0.5, radius2=0.5, depth=1.0, matrix=frame
            )
    sharp = [edge for edge in shape.edges if edge.calc_face_angle(0.0) > 0.6]
    offset = 0.04 * min(min(size) for _, size, _ in pieces)
    bmesh.ops.bevel(shape, geom=sharp, offset=offset, segments=2, profile=0.5, affect="EDGES")
    mesh = bpy.data.meshes.new("thing")
    shape.to_mesh(mesh)
    shape.free()
    return mesh
