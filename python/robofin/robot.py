"""Robots in the loop: another simulation carries the arm, and a tool here gives force and removal at each step.

`ContactTool` knows no engine: it takes a pose and returns a wrench. `MujocoTool` connects it to a site of a MuJoCo model.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._robofin import ContactTool

__all__ = ["ContactTool", "MujocoTool"]


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
