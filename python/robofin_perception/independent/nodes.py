"""Node trees of Blender, written as expressions."""

from typing import Any

import bpy

Socket = Any
"""An output of a node, or a constant that an input accepts."""


class Nodes:
    """The nodes of a material or a world."""

    def __init__(self, owner: Any) -> None:
        """Empties the owner's node tree."""
        owner.use_nodes = True
        self.tree = owner.node_tree
        self.tree.nodes.clear()

    def add(self, kind: str, inputs: dict[str | int, Socket] | None = None, **settings: Any) -> Any:
        """A new node with its inputs linked or set; returns its outputs."""
        node = self.tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for key, value in (inputs or {}).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[key])
            else:
                node.inputs[key].default_value = value
        return node.outputs

    def value(self, name: str, value: float) -> Socket:
        """A constant that can be changed by its name."""
        output = self.add("ShaderNodeValue", name=name)[0]
        output.default_value = value
        return output

    def math(self, operation: str, a: Socket, b: Socket = 0.0, c: Socket = 0.0) -> Socket:
        """A number computed from others."""
        return self.add("ShaderNodeMath", {0: a, 1: b, 2: c}, operation=operation)[0]

    def mix(self, factor: Socket, a: Socket, b: Socket) -> Socket:
        """A number between `a` and `b`."""
        return self.add("ShaderNodeMix", {0: factor, 2: a, 3: b}, data_type="FLOAT")[0]

    def blend(self, factor: Socket, a: Socket, b: Socket, how: str = "MIX") -> Socket:
        """A colour between `a` and `b`."""
        inputs: dict[str | int, Socket] = {0: factor, 6: a, 7: b}
        return self.add("ShaderNodeMix", inputs, data_type="RGBA", blend_type=how)[2]

    def step(self, value: Socket, low: float, high: float) -> Socket:
        """A smooth step from 0 at `low` to 1 at `high`."""
        return self.remap(value, (low, high), (0.0, 1.0), "SMOOTHSTEP")

    def remap(
        self, value: Socket, of: tuple[float, float], to: tuple[float, float], how: str = "LINEAR"
    ) -> Socket:
        """A number mapped from one range to another, within it."""
        inputs: dict[str | int, Socket] = {0: value, 1: of[0], 2: of[1], 3: to[0], 4: to[1]}
        return self.add("ShaderNodeMapRange", inputs, interpolation_type=how)[0]

    def noise(self, at: Socket, per_metre: float, detail: float = 2.0) -> Socket:
        """Noise about 0.5."""
        inputs: dict[str | int, Socket] = {"Vector": at, "Scale": per_metre, "Detail": detail}
        return self.add("ShaderNodeTexNoise", inputs)["Fac"]

    def principled(self, **inputs: Socket) -> Socket:
        """The principled surface; spaces in names of inputs are underscores."""
        named: dict[str | int, Socket] = {name.replace("_", " "): value for name, value in inputs.items()}
        return self.add("ShaderNodeBsdfPrincipled", named)[0]

    def surface(self, shader: Socket) -> None:
        """Makes a shader the surface of the material."""
        self.add("ShaderNodeOutputMaterial", {"Surface": shader})

    def bump(self, height: Socket) -> Socket:
        """The normal of a surface with heights [m]."""
        return self.add("ShaderNodeBump", {"Height": height, "Distance": 1.0, "Strength": 1.0})["Normal"]


def rgba(colour: tuple[float, float, float]) -> tuple[float, float, float, float]:
    """An opaque colour."""
    return (*colour, 1.0)
