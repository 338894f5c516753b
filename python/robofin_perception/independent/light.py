"""Light: a sky, a studio, a workshop or a lamp at the camera."""

import math
from dataclasses import dataclass
from random import Random

import bpy
from mathutils import Vector

from .nodes import Nodes, Socket, rgba

Colour = tuple[float, float, float]

KINDS = ("sky", "overcast", "studio", "workshop", "ring")


@dataclass(frozen=True)
class LampDraw:
    """A rectangular lamp that faces the workpiece; angles in radians, lengths [m], power [W]."""

    azimuth: float
    elevation: float
    distance: float
    size: tuple[float, float]
    colour: Colour
    power: float


@dataclass(frozen=True)
class LightDraw:
    """Drawn surroundings and lamps."""

    kind: str
    strength: float
    colour: Colour
    sun_elevation: float
    sun_turn: float
    haze: float
    panels: tuple[float, float]
    lamps: tuple[LampDraw, ...]

    @classmethod
    def draw(cls, seed: str) -> "LightDraw":
        """Draws one of the kinds of light."""
        random = Random(f"{seed}/light")
        between = random.uniform
        kind = random.choice(KINDS)
        least, most = {"sky": (0, 1), "overcast": (0, 1), "studio": (1, 3), "workshop": (0, 2), "ring": (1, 2)}[kind]
        return cls(
            kind=kind,
            strength={"sky": 0.12, "overcast": 0.25, "studio": 0.12, "workshop": 0.6, "ring": 0.5}[kind]
            * math.exp(between(-0.7, 0.7)),
            colour=warmth(random, 0.2),
            sun_elevation=math.radians(between(12.0, 70.0)),
            sun_turn=between(0.0, math.tau),
            haze=between(0.3, 4.0),
            panels=(between(0.8, 2.5), between(0.3, 1.2)),
            lamps=tuple(draw_lamp(random) for _ in range(random.randint(least, most))),
        )


def warmth(random: Random, most: float) -> Colour:
    """White light, from the yellow of a bulb to the blue of a clear sky."""
    warm = random.uniform(-most, most)
    return (1.0 + warm, 1.0, 1.0 - warm)


def draw_lamp(random: Random) -> LampDraw:
    """Draws a lamp, from a small torch to a wide softbox."""
    between = random.uniform
    side = math.exp(between(math.log(0.05), math.log(0.8)))
    return LampDraw(
        azimuth=between(0.0, math.tau),
        elevation=math.radians(between(15.0, 85.0)),
        distance=between(0.6, 1.5),
        size=(side, side * between(0.2, 1.0)),
        colour=warmth(random, 0.3),
        power=math.exp(between(math.log(4.0), math.log(25.0))),
    )


def add_light(light: LightDraw, camera: bpy.types.Object) -> None:
    """Adds the world and the lamps to the scene; the first lamp of a ring light is at the camera."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", 256
    nodes = Nodes(world)
    colour = surroundings(nodes, light)
    background = nodes.add("ShaderNodeBackground", {"Color": colour, "Strength": light.strength})[0]
    nodes.add("ShaderNodeOutputWorld", {"Surface": background})
    for number, lamp in enumerate(light.lamps):
        at_camera = camera.matrix_world.translation * 1.05 if light.kind == "ring" and number == 0 else None
        add_lamp(lamp, at_camera)


def add_lamp(lamp: LampDraw, at: Vector | None) -> None:
    """Adds a lamp at a place, or where it was drawn."""
    data = bpy.data.lights.new("lamp", "AREA")
    data.shape, data.size, data.size_y = "RECTANGLE", *lamp.size
    data.color, data.energy = lamp.colour, lamp.power
    level = math.cos(lamp.elevation) * lamp.distance
    drawn = (level * math.cos(lamp.azimuth), level * math.sin(lamp.azimuth), lamp.distance * math.sin(lamp.elevation))
    place = at or Vector(drawn)
    source = bpy.data.objects.new("lamp", data)
    source.location, source.rotation_euler = place, place.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(source)


def surroundings(nodes: Nodes, light: LightDraw) -> Socket:
    """Colour of the surroundings by direction."""
    if light.kind == "sky":
        return nodes.add(
            "ShaderNodeTexSky",
            sky_type="NISHITA",
            sun_elevation=light.sun_elevation,
            sun_rotation=light.sun_turn,
            sun_size=math.radians(2.0),
            sun_intensity=0.1,
            dust_density=light.haze,
        )[0]
    towards = nodes.add("ShaderNodeTexCoord")["Generated"]
    x, y, up = nodes.add("ShaderNodeSeparateXYZ", {0: towards})[:3]
    if light.kind == "overcast":
        brightness = nodes.remap(up, (-0.1, 1.0), (0.25, 1.0))
        return nodes.blend(brightness, (0.05, 0.05, 0.05, 1.0), rgba(light.colour))
    if light.kind == "workshop":
        return workshop(nodes, (x, y, up), light)
    cloudy = nodes.noise(towards, 1.7, 1.0)
    return nodes.blend(nodes.step(cloudy, 0.45, 0.6), (0.15, 0.16, 0.17, 1.0), rgba(light.colour))


def workshop(nodes: Nodes, towards: tuple[Socket, Socket, Socket], light: LightDraw) -> Socket:
    """Rows of bright panels under a dark ceiling, light walls with a window, a dark floor."""
    x, y, up = towards
    height = nodes.math("MAXIMUM", up, 0.02)
    rows = lit(nodes, nodes.math("DIVIDE", x, height), light.panels[0], 0.25)
    lamps = lit(nodes, nodes.math("DIVIDE", y, height), light.panels[1], 0.6)
    panels = nodes.math("MULTIPLY", nodes.math("MULTIPLY", rows, lamps), nodes.step(up, 0.3, 0.4))
    side = nodes.math("MULTIPLY_ADD", x, math.cos(light.sun_turn), nodes.math("MULTIPLY", y, math.sin(light.sun_turn)))
    low = nodes.math("MULTIPLY", nodes.step(up, 0.05, 0.1), nodes.math("SUBTRACT", 1.0, nodes.step(up, 0.4, 0.45)))
    window = nodes.math("MULTIPLY", nodes.step(side, 0.75, 0.8), low)
    walls = nodes.blend(nodes.step(up, -0.1, 0.35), (0.08, 0.07, 0.06, 1.0), (0.3, 0.3, 0.28, 1.0))
    glow = nodes.math("MULTIPLY_ADD", panels, 9.0, nodes.math("MULTIPLY", window, 4.0))
    glowing = nodes.add("ShaderNodeVectorMath", {0: light.colour, "Scale": glow}, operation="SCALE")[0]
    return nodes.add("ShaderNodeVectorMath", {0: walls, 1: glowing}, operation="ADD")[0]


def lit(nodes: Nodes, along: Socket, period: float, share: float) -> Socket:
    """One where a coordinate is in the lit share of a period, else zero."""
    part = nodes.math("FRACT", nodes.math("DIVIDE", along, period))
    return nodes.math("LESS_THAN", part, share)

