"""A scene of Blender: a workpiece with its dose, table, things, light and camera."""

from dataclasses import asdict, dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .clutter import ThingDraw, add_clutter, draw_clutter
from .finish import FinishDraw, finish_material
from .light import LightDraw, add_light
from .pose import PoseDraw, add_camera, place_on_table
from .render import PART_INDEX
from .sensor import SensorDraw
from .source import Surface
from .table import TableDraw, add_table


@dataclass(frozen=True)
class SceneDraw:
    """All drawn parameters of a picture."""

    pose: PoseDraw
    light: LightDraw
    finish: FinishDraw
    table: TableDraw
    clutter: tuple[ThingDraw, ...]
    sensor: SensorDraw

    @classmethod
    def draw(cls, placement_seed: str, picture_seed: str) -> "SceneDraw":
        """Draws pose and camera from the seed of the placement, the rest from that of the picture."""
        return cls(
            pose=PoseDraw.draw(placement_seed),
            light=LightDraw.draw(picture_seed),
            finish=FinishDraw.draw(picture_seed),
            table=TableDraw.draw(picture_seed),
            clutter=draw_clutter(picture_seed),
            sensor=SensorDraw.draw(picture_seed),
        )

    def record(self) -> dict[str, Any]:
        """As in the metadata."""
        return asdict(self)


def build(draw: SceneDraw, surface: Surface, dose: NDArray[np.float32], aspect: float) -> None:
    """Replaces the scene of Blender."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    part = bpy.data.objects.new("workpiece", part_mesh(surface, dose))
    part.pass_index = PART_INDEX
    part.data.materials.append(finish_material(draw.finish))
    bpy.context.scene.collection.objects.link(part)
    placed = place_on_table(part, draw.pose, surface.positions)
    camera = add_camera(draw.pose, placed, aspect)
    add_table(draw.table)
    add_clutter(draw.clutter, placed, camera)
    add_light(draw.light, camera)


def part_mesh(surface: Surface, dose: NDArray[np.float32]) -> bpy.types.Mesh:
    """A mesh with the attributes `dose` and `heat`, and with the normals of the field."""
    mesh = bpy.data.meshes.new("workpiece")
    corners = surface.triangles.astype(np.int32).ravel()
    mesh.vertices.add(len(surface.positions))
    mesh.vertices.foreach_set("co", surface.positions.astype(np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(len(surface.triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    for name, values in (("dose", dose), ("heat", surface.heat)):
        mesh.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", values)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(surface.triangles), dtype=np.bool_))
    mesh.normals_split_custom_set_from_vertices(surface.normals.tolist())
    return mesh
