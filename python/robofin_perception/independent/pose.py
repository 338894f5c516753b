"""Pose of a workpiece on its table, and its camera: the same for all pictures of a placement."""

import math
from dataclasses import dataclass
from random import Random

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector
from numpy.typing import NDArray


@dataclass(frozen=True)
class PoseDraw:
    """Drawn pose and camera; angles in radians."""

    turn: float
    lean: float
    lean_towards: float
    azimuth: float
    elevation: float
    vertical_field_of_view: float
    fill: float
    shift: tuple[float, float]
    roll: float
    f_number: float

    @classmethod
    def draw(cls, seed: str) -> "PoseDraw":
        """Draws cameras from oblique to almost overhead, from long to wide lenses."""
        random = Random(f"{seed}/pose")
        between = random.uniform
        return cls(
            turn=between(0.0, math.tau),
            lean=between(0.02, 0.2) if random.random() < 0.35 else 0.0,
            lean_towards=between(0.0, math.tau),
            azimuth=between(0.0, math.tau),
            elevation=math.radians(between(25.0, 86.0)),
            vertical_field_of_view=math.radians(math.exp(between(math.log(11.0), math.log(62.0)))),
            fill=between(0.6, 1.08),
            shift=(between(-0.5, 0.5), between(-0.5, 0.5)),
            roll=between(-0.25, 0.25),
            f_number=math.exp(between(math.log(4.0), math.log(32.0))),
        )

    def rotation(self) -> Matrix:
        """Rotation of the workpiece: it turns about the vertical, then leans as on a wedge."""
        axis = Vector((math.cos(self.lean_towards), math.sin(self.lean_towards), 0.0))
        return Matrix.Rotation(self.lean, 4, axis) @ Euler((0.0, 0.0, self.turn)).to_matrix().to_4x4()


def place_on_table(part: bpy.types.Object, pose: PoseDraw, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places the workpiece so that its lowest point touches the table at z = 0; returns its placed vertices [m]."""
    turned = positions @ np.array(pose.rotation().to_3x3()).T
    middle = 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    shift = np.array([-middle[0], -middle[1], -turned[:, 2].min()])
    part.matrix_world = Matrix.Translation(shift) @ pose.rotation()
    return np.asarray(turned + shift)


def add_camera(pose: PoseDraw, placed: NDArray[np.float64], aspect: float) -> bpy.types.Object:
    """A camera that frames the placed vertices; with a fill above 1 some are outside the picture."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle_y, data.clip_start = "VERTICAL", pose.vertical_field_of_view, 0.005
    camera = bpy.data.objects.new("camera", data)
    bpy.context.scene.collection.objects.link(camera)
    axes, distance, shift = framing(pose, placed, aspect)
    centre = 0.5 * (placed.min(axis=0) + placed.max(axis=0))
    eye = centre + axes[2] * distance + shift
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, eye
    camera.matrix_world = Matrix(matrix.tolist())
    data.dof.use_dof, data.dof.aperture_fstop = True, pose.f_number
    data.dof.focus_distance = distance - 0.3 * float(np.ptp(placed @ axes[2]))
    bpy.context.scene.camera = camera
    return camera


def framing(
    pose: PoseDraw, placed: NDArray[np.float64], aspect: float
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Unit vectors to the right, up and back of the camera, its distance [m] from the centre, and its shift [m]."""
    level = math.cos(pose.elevation)
    back = np.array([level * math.cos(pose.azimuth), level * math.sin(pose.azimuth), math.sin(pose.elevation)])
    side = np.array([-math.sin(pose.azimuth), math.cos(pose.azimuth), 0.0])
    rise = np.cross(back, side)
    right = side * math.cos(pose.roll) + rise * math.sin(pose.roll)
    axes = np.array([right, np.cross(back, right), back])
    slope = math.tan(0.5 * pose.vertical_field_of_view) * np.array([aspect, 1.0])
    away = (placed - 0.5 * (placed.min(axis=0) + placed.max(axis=0))) @ axes.T
    distance = float(((np.abs(away[:, :2]) / (slope * pose.fill)).max(axis=1) + away[:, 2]).max())
    spare = max(1.0 - pose.fill, 0.08) * distance * slope * np.array(pose.shift)
    return axes, distance, axes[0] * spare[0] + axes[1] * spare[1]
