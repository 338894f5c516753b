"""Robots in the loop: another simulation carries the arm, and a tool here gives force and removal at each step.

`ContactTool` knows no engine: it takes a pose and returns a wrench. `MujocoTool` connects it to a site of a MuJoCo model,
`NewtonTool` to a body of a Newton model.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._robofin import ContactTool

__all__ = ["ContactTool", "MujocoTool", "NewtonTool"]


class MujocoTool:
    """A tool at a site of a MuJoCo model: the arm moves the site, and the contact acts on the site's body.

    - `model`, `data`: `mujoco.MjModel` and its `mujoco.MjData`; a step lasts `model.opt.timestep`
    - `site`: name of the site at the tool's reference point, with x forward, y the axis of a wheel, z away from the part
    - `position` [m] and `rotation`, shape `[3, 3]`: pose of the workpiece's frame in the world

        mujoco.mj_step1(model, data)
        wrench = tool.step()
        mujoco.mj_step2(model, data)

    `step` overwrites `data.qfrc_applied`; add other generalised forces to it afterwards.
    """

    def __init__(self, tool: ContactTool, model: Any, data: Any, site: str, *, position: ArrayLike = (0.0, 0.0, 0.0),
                 rotation: ArrayLike | None = None) -> None:
        import mujoco

        self.tool, self.model, self.data = tool, model, data
        self._apply_at, self._site = mujoco.mj_applyFT, data.site(site)
        self._body = int(model.site(site).bodyid[0])
        self.position = np.asarray(position, dtype=np.float64)
        self.rotation = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)

    def step(self) -> NDArray[np.float64]:
        """Moves the tool to the site's pose, applies the wrench there, and returns it: force [N] and torque [N m] about
        the site in the world's frame, shape `[6]`."""
        point, turn = self._site.xpos.copy(), self._site.xmat.reshape(3, 3)
        at, axes = self.rotation.T @ (point - self.position), self.rotation.T @ turn
        wrench = self.tool.step(at.tolist(), axes.tolist(), float(self.model.opt.timestep))
        force, torque = wrench.reshape(2, 3) @ self.rotation.T
        self.data.qfrc_applied[:] = 0.0
        self._apply_at(self.model, self.data, force, torque, point, self._body, self.data.qfrc_applied)
        return np.concatenate([force, torque])


class NewtonTool:
    """A tool on a body of a Newton model: the arm moves the body, and the contact acts on it.

    - `model`: `newton.Model`; its frames and bodies stay in the memory of its device, and are copied at each step
    - `body`: index of the body
    - `at` [m] and `axes`, shape `[3, 3]`: the tool's reference point and axes in the body's frame: x forward, y the axis of
      a wheel, z away from the part
    - `position` [m] and `rotation`, shape `[3, 3]`: pose of the workpiece's frame in the world

        state.clear_forces()
        wrench = tool.step(state, dt)
        solver.step(state, next_state, control, contacts, dt)

    `step` adds to `state.body_f`, beside other forces.
    """

    def __init__(self, tool: ContactTool, model: Any, body: int, *, at: ArrayLike = (0.0, 0.0, 0.0),
                 axes: ArrayLike | None = None, position: ArrayLike = (0.0, 0.0, 0.0),
                 rotation: ArrayLike | None = None) -> None:
        self.tool, self.body = tool, body
        self._centre = np.asarray(model.body_com.numpy()[body], dtype=np.float64)
        self.at = np.asarray(at, dtype=np.float64)
        self.axes = np.eye(3) if axes is None else np.asarray(axes, dtype=np.float64)
        self.position = np.asarray(position, dtype=np.float64)
        self.rotation = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)

    def step(self, state: Any, duration: float) -> NDArray[np.float64]:
        """Moves the tool to the body's pose for a step of `duration` [s], adds the wrench to the body's forces, and
        returns it: force [N] and torque [N m] about the tool's reference point in the world's frame, shape `[6]`."""
        pose = np.asarray(state.body_q.numpy()[self.body], dtype=np.float64)
        turn = rotation_of(pose[3:])
        point = pose[:3] + turn @ self.at
        at, axes = self.rotation.T @ (point - self.position), self.rotation.T @ turn @ self.axes
        wrench = self.tool.step(at.tolist(), axes.tolist(), duration)
        force, torque = wrench.reshape(2, 3) @ self.rotation.T
        # Newton takes wrenches about the centre of mass.
        arm = turn @ (self.at - self._centre)
        forces = state.body_f.numpy()
        forces[self.body] += np.concatenate([force, torque + np.cross(arm, force)])
        state.body_f.assign(forces)
        return np.concatenate([force, torque])


def rotation_of(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix of a quaternion x, y, z, w, which is scaled to length 1 first."""
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
