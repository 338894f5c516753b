"""Reads the triangle meshes of a binary glTF file written by RoboFin, in the part's own frame (m, z up)."""

import json
import struct
from dataclasses import dataclass

import numpy

COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3}


@dataclass
class Part:
    name: str
    positions: numpy.ndarray  # [n, 3] f32, m
    normals: numpy.ndarray  # [n, 3] f32
    weld_ids: numpy.ndarray  # [n] int
    triangles: numpy.ndarray  # [m, 3] int, into positions
    material: dict  # the glTF material

    def merged(self):
        """Positions without repetition and triangles over them: normals split vertices, solids do not."""
        positions, index = numpy.unique(self.positions, axis=0, return_inverse=True)
        return positions, index.reshape(-1)[self.triangles]


def read(path):
    """The parts of a file, in its order."""
    data = open(path, "rb").read()
    if len(data) < 20 or struct.unpack_from("<4sII", data) != (b"glTF", 2, len(data)):
        raise ValueError(f"{path}: not a complete binary glTF 2 file")
    header_length = struct.unpack_from("<I", data, 12)[0]
    header = json.loads(data[20 : 20 + header_length])
    binary = memoryview(data)[20 + header_length + 8 :]

    def array(number):
        accessor = header["accessors"][number]
        view = header["bufferViews"][accessor["bufferView"]]
        kind, width = numpy.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        stride = view.get("byteStride", kind.itemsize * width)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        shape, strides = (accessor["count"], width), (stride, kind.itemsize)
        return numpy.ndarray(shape, kind, binary, start, strides).copy()

    def part(mesh):
        (primitive,) = mesh["primitives"]
        names = primitive["attributes"]
        return Part(
            name=mesh["name"],
            positions=array(names["POSITION"]),
            normals=array(names["NORMAL"]),
            weld_ids=array(names["_WELD_ID"]).reshape(-1).astype(numpy.int32),
            triangles=array(primitive["indices"]).reshape(-1, 3).astype(numpy.int32),
            material=header["materials"][primitive["material"]],
        )

    return [part(mesh) for mesh in header["meshes"]]
