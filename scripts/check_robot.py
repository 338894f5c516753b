"""Loads the robot models of an asset folder with MuJoCo and yourdfpy: an opinion from outside on mass and inertia.

    python check_robot.py FOLDER

Prints one line of JSON: {"mjcf": MODEL, "urdf": MODEL} with MODEL = {"mass", "centre", "inertia", "faces", "box"}: kg, m,
kg m^2 about the centre along the axes of the part's frame as three rows, triangles of the visual and the collision mesh,
lowest and highest corner of the visual mesh in the part's frame [m]. Needs mujoco 4 and yourdfpy.
"""

import json
import os
import sys

import mujoco
import numpy
import yourdfpy


def mjcf(path):
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    body, geom = model.body("workpiece"), model.geom("visual")
    turn = numpy.zeros(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    axes = turn.reshape(3, 3).copy()
    mesh = model.mesh("visual")
    vertices = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
    mujoco.mju_quat2Mat(turn, geom.quat)
    points = vertices @ turn.reshape(3, 3).T + geom.pos
    return {
        "mass": float(body.mass[0]),
        "centre": body.ipos.tolist(),
        "inertia": (axes @ numpy.diag(body.inertia) @ axes.T).tolist(),
        "faces": [int(model.mesh(name).facenum[0]) for name in ("visual", "collision")],
        "box": [points.min(0).tolist(), points.max(0).tolist()],
    }


def urdf(path):
    robot = yourdfpy.URDF.load(path, load_collision_meshes=True, build_collision_scene_graph=True)
    link = robot.link_map["workpiece"]
    scenes = robot.scene, robot.collision_scene
    return {
        "mass": link.inertial.mass,
        "centre": link.inertial.origin[:3, 3].tolist(),
        "inertia": link.inertial.inertia.tolist(),
        "faces": [sum(len(mesh.faces) for mesh in scene.geometry.values()) for scene in scenes],
        "box": robot.scene.bounds.tolist(),
    }


if __name__ == "__main__":
    folder = sys.argv[1]
    print(json.dumps({
        "mjcf": mjcf(os.path.join(folder, "part.mjcf.xml")),
        "urdf": urdf(os.path.join(folder, "part.urdf")),
    }))
