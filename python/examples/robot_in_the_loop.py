"""A robot grinds a weld: MuJoCo carries the arm at 1 kHz, and the contact and the removal come from here.

    pip install "./python[robot]" && pip install --no-deps robosuite
    python python/examples/robot_in_the_loop.py

The arm is the UR5e of the package robosuite, which is under the MIT licence; only its file of links, masses and motors is
read. Its joints have torque motors. An impedance controller (Hogan 1985) pulls the centre of a wheel towards a point that
moves along the weld and lies below it, so it presses with a force that falls as the bead does.

The last lines compare the removed volume with a pass that follows the recorded motion as a whole.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import robofin
from robofin.robot import ContactTool, MujocoTool

Array = NDArray[np.float64]

#: Step of both simulations [s].
STEP = 1e-3
#: Wheel: radius [m] and text.
RADIUS, WHEEL = 0.04, "wheel:radius=40mm,width=12mm"
#: Impedance: stiffness [N/m, N m/rad] and damping [N s/m, N m s/rad] of position and rotation.
STIFFNESS, DAMPING = np.array([[4000.0], [200.0]]), np.array([[250.0], [8.0]])
#: Height above the weld at the start [m], time of the way down [s], and feed [m/s].
ABOVE, DOWN, FEED = 2e-3, 0.3, 10e-3
#: Coefficient of friction of the wheel on steel.
FRICTION = 0.3
#: Joint angles from which the arm is brought over the weld [rad].
HOME = np.array([0.0, -1.6, 2.0, -2.0, -1.57, 0.0])
#: Pose of the plate in the world: position [m]; its axes are those of the world.
PLATE = np.array([0.40, 0.06, 0.10])


def packaged_arm() -> Path:
    """The file of the UR5e in robosuite, which is found without importing the package."""
    found = find_spec("robosuite")
    if found is None or found.origin is None:
        raise SystemExit("robosuite is not installed: pip install --no-deps robosuite, or give --arm FILE")
    return Path(found.origin).parent / "models/assets/robots/ur5e/robot.xml"


def arm_with_spindle(file: Path) -> Any:
    """The arm with a spindle of 1.5 kg at its flange, and the site "tool" in the centre of the wheel."""
    spec = mujoco.MjSpec.from_file(str(file))
    for each in [*spec.geoms, *spec.meshes]:
        spec.delete(each)
    flange = spec.body("right_hand")
    spindle = flange.add_body(name="spindle", pos=[0, 0, 0.1], mass=1.5, inertia=[2e-3] * 3, explicitinertial=True)
    # The flange's z axis points at the part, the tool's away from it.
    spindle.add_site(name="tool", quat=[0, 0, 1, 0])
    spec.option.timestep = STEP
    return spec.compile()


def plate_with_weld(seed: int) -> robofin.Workpiece:
    """A plate with a bead 6 mm wide."""
    size = np.array([0.12, 0.08, 0.01])
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]) * size
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    plate = robofin.Mesh(corners, [row for a, b, c, d in quads for row in ([a, b, c], [a, c, d])])
    return robofin.weld(plate, seed=seed, voxel=5e-4, difficulty="easy", width=6e-3, length=(0.025, 0.04))


class Course:
    """Places of the wheel's centre over time: down on the weld's first point, then to and fro along it."""

    def __init__(self, weld: dict[str, Any], deep: float) -> None:
        self.points, self.deep, self.height = PLATE + weld["position"], deep, float(weld["height"])
        self.axes = np.stack([weld["tangent"], np.cross(weld["normal"], weld["tangent"]), weld["normal"]], axis=2)
        ways = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        self.arcs = np.concatenate([[0.0], np.cumsum(ways)])

    def at(self, moment: float) -> tuple[Array, Array]:
        """Position [m] and axes, shape `[3, 3]`, to which the controller pulls the tool at a time [s]."""
        length, way = self.arcs[-1], FEED * max(moment - DOWN, 0.0)
        arc = length - abs(way % (2.0 * length) - length)
        point = np.array([np.interp(arc, self.arcs, column) for column in self.points.T])
        axes = self.axes[int(np.argmin(np.abs(self.arcs - arc)))]
        lift = self.height + ABOVE - (ABOVE + self.deep) * min(moment / DOWN, 1.0)
        return point + axes[:, 2] * (RADIUS + lift), axes


class Impedance:
    """Joint torques of a spring and a damper between the tool and a wanted pose, with the arm's weight balanced."""

    def __init__(self, model: Any, data: Any) -> None:
        self.model, self.data, self.site = model, data, model.site("tool").id
        self.jacobian = np.zeros((6, model.nv))

    def error(self, position: Array, axes: Array) -> Array:
        """Way and turn to the wanted pose [m, rad], shape `[2, 3]`."""
        now, turn = self.data.site_xpos[self.site], np.zeros(4)
        mujoco.mju_mat2Quat(turn, (axes @ self.data.site_xmat[self.site].reshape(3, 3).T).ravel())
        rotation = np.zeros(3)
        mujoco.mju_quat2Vel(rotation, turn, 1.0)
        return np.stack([position - now, rotation])

    def torques(self, position: Array, axes: Array) -> Array:
        """Torques of the motors [N m]."""
        mujoco.mj_jacSite(self.model, self.data, self.jacobian[:3], self.jacobian[3:], self.site)
        twist = (self.jacobian @ self.data.qvel).reshape(2, 3)
        pull = STIFFNESS * self.error(position, axes) - DAMPING * twist
        wanted = self.jacobian.T @ pull.ravel() + self.data.qfrc_bias
        low, high = self.model.actuator_ctrlrange.T
        torques: Array = np.clip(wanted, low, high)
        return torques

    def bring(self, position: Array, axes: Array) -> None:
        """Brings the arm to a pose by damped least squares (Wampler 1986), without time."""
        for _ in range(200):
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            mujoco.mj_jacSite(self.model, self.data, self.jacobian[:3], self.jacobian[3:], self.site)
            square = self.jacobian @ self.jacobian.T + 1e-4 * np.eye(6)
            self.data.qpos += self.jacobian.T @ np.linalg.solve(square, self.error(position, axes).ravel())
        mujoco.mj_forward(self.model, self.data)


@dataclass(frozen=True)
class Run:
    """What a run gives; one row for each step."""

    #: Wrench on the tool in the world [N, N m], shape `[n, 6]`, and poses in the plate's frame.
    wrenches: Array
    positions: Array
    axes: Array
    removed_volume: float
    contact_time: float
    #: Wall time [s], and the part of it in the contact.
    wall: float
    in_contact: float
    before: robofin.Workpiece
    after: robofin.Workpiece

    def replayed(self) -> float:
        """Volume removed by a pass that follows the recorded motion [m³]."""
        times = STEP * np.arange(len(self.positions))
        lowest = self.positions - RADIUS * self.axes[:, :, 2]
        path = robofin.Path(times, lowest, self.axes[:, :, 2], self.axes[:, :, 1])
        simulation = robofin.Simulation(robofin.Workpiece(self.before.field), robofin.Tool(WHEEL), robofin.Model("grinding"),
                                        controller="replay")
        return simulation.run(path).removed_volume


def run(arm: Path, seconds: float, force: float, seed: int) -> Run:
    """Grinds for some time [s] with a wheel that presses with up to about `force` [N]."""
    workpiece = plate_with_weld(seed)
    model = arm_with_spindle(arm)
    data = mujoco.MjData(model)
    contact = ContactTool(workpiece, robofin.Tool(WHEEL), robofin.Model("grinding"), friction=FRICTION)
    tool = MujocoTool(contact, model, data, "tool", position=PLATE)
    course, arm_control = Course(workpiece.welds[0], force / float(STIFFNESS[0, 0])), Impedance(model, data)
    data.qpos[:] = HOME
    arm_control.bring(*course.at(0.0))
    count = round(seconds / STEP)
    wrenches, positions, axes = np.zeros((count, 6)), np.zeros((count, 3)), np.zeros((count, 3, 3))
    begun, in_contact = time.perf_counter(), 0.0
    for step in range(count):
        mujoco.mj_step1(model, data)
        asked = time.perf_counter()
        wrenches[step] = tool.step()
        in_contact += time.perf_counter() - asked
        positions[step] = data.site("tool").xpos - PLATE
        axes[step] = data.site("tool").xmat.reshape(3, 3)
        data.ctrl[:] = arm_control.torques(*course.at(STEP * step))
        mujoco.mj_step2(model, data)
    wall = time.perf_counter() - begun
    return Run(wrenches, positions, axes, contact.removed_volume, contact.contact_time, wall, in_contact, workpiece,
               contact.workpiece())


def main() -> None:
    """Grinds and prints."""
    parser = argparse.ArgumentParser(description="A UR5e in MuJoCo grinds a weld; contact and removal come from RoboFin.")
    parser.add_argument("--arm", type=Path, help="MJCF file of an arm with torque motors and a body right_hand")
    parser.add_argument("--seconds", type=float, default=8.0, help="simulated time")
    parser.add_argument("--force", type=float, default=25.0, help="force on the first touch [N]")
    parser.add_argument("--seed", type=int, default=1, help="of the weld")
    given = parser.parse_args()
    done = run(given.arm or packaged_arm(), given.seconds, given.force, given.seed)
    touching = done.wrenches[np.linalg.norm(done.wrenches[:, :3], axis=1) > 0.0]
    if len(touching):
        mean, most = touching[:, :3].mean(axis=0), touching[:, 2].max()
        print(f"force in contact: mean {mean[0]:.1f}, {mean[1]:.1f}, {mean[2]:.1f} N, at most {most:.1f} N up; "
              f"in contact for {done.contact_time:.2f} of {given.seconds:.2f} s")
    target = done.before.target
    assert target is not None
    left = done.after.field.volume_beyond(target) / done.before.field.volume_beyond(target)
    print(f"removed {1e9 * done.removed_volume:.2f} mm³; {100 * left:.1f} % of the bead is left")
    print(f"{given.seconds / done.wall:.2f} of real time, {100 * done.in_contact / done.wall:.0f} % of it for the contact: "
          f"{1e6 * done.in_contact / len(done.wrenches):.0f} µs a step")
    replayed = done.replayed()
    print(f"the recorded motion as one pass removes {1e9 * replayed:.2f} mm³, "
          f"{100 * (done.removed_volume / replayed - 1.0):+.2f} % from that")


if __name__ == "__main__":
    main()
