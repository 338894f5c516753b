"""Writes the sample bags of ROS 2 from formulas.

    pip install rosbags==0.11.9 mcap==1.6.0 mcap-ros2-support==0.6.0
    python make_bags.py FOLDER

`press.db3` and `press.mcap` are written by rosbags, `press_lz4.mcap` and `press_zstd.mcap` by mcap with mcap-ros2-support,
`big_endian.db3` by rosbags and then with its messages in the other byte order.

At time t: the pose is (0.3 + 0.01 t, -0.2, 0.1 + 0.002 t), the force (1, 2, -20 t), the torque (0.1, 0.2, 0.3), the speed
of the spindle 600 + t, the joints a and b at 2 t and -t; poses every 0.01 s from 100 s on, forces every 0.004 s from
100.002 s on.
"""

import shutil
import sqlite3
import sys
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 100_000_000_000


def kind(name):
    return STORE.types[name]


def header(ns):
    stamp = kind("builtin_interfaces/msg/Time")(sec=ns // 10**9, nanosec=ns % 10**9)
    return kind("std_msgs/msg/Header")(stamp=stamp, frame_id="base_link")


def vector(x, y, z):
    return kind("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)


def messages():
    """Topic, type, time of the record [ns] and message, in the order of time."""
    found = []
    quaternion = kind("geometry_msgs/msg/Quaternion")(x=0.0, y=0.0, z=0.6, w=0.8)
    for k in range(50):
        ns = START + 10_000_000 * k
        t = 0.01 * k
        point = kind("geometry_msgs/msg/Point")(x=0.3 + 0.01 * t, y=-0.2, z=0.1 + 0.002 * t)
        pose = kind("geometry_msgs/msg/Pose")(position=point, orientation=quaternion)
        found.append(("/tool/pose", kind("geometry_msgs/msg/PoseStamped")(header=header(ns), pose=pose), ns))
        if k % 5 == 0:
            transform = kind("geometry_msgs/msg/Transform")(translation=vector(t, 0.0, 1.0), rotation=quaternion)
            stamped = kind("geometry_msgs/msg/TransformStamped")(
                header=header(ns), child_frame_id="tool0", transform=transform
            )
            found.append(("/tf", kind("tf2_msgs/msg/TFMessage")(transforms=[stamped]), ns))
            twist = kind("geometry_msgs/msg/Twist")(linear=vector(t, 0.0, 0.0), angular=vector(0.0, 0.0, -t))
            found.append(("/twist", kind("geometry_msgs/msg/TwistStamped")(header=header(ns), twist=twist), ns))
            found.append(("/note", kind("std_msgs/msg/String")(data="pressing"), ns))
    for k in range(100):
        ns = START + 2_000_000 + 4_000_000 * k
        t = 0.002 + 0.004 * k
        wrench = kind("geometry_msgs/msg/Wrench")(force=vector(1.0, 2.0, -20.0 * t), torque=vector(0.1, 0.2, 0.3))
        stamped = kind("geometry_msgs/msg/WrenchStamped")(header=header(ns), wrench=wrench)
        # The record is made a little later.
        found.append(("/ft", stamped, ns + 300_000))
        found.append(("/spindle", kind("std_msgs/msg/Float64")(data=600.0 + t), ns))
        joints = kind("sensor_msgs/msg/JointState")(
            header=header(ns), name=["a", "b"], position=np.array([2 * t, -t]), velocity=np.array([]), effort=np.array([])
        )
        found.append(("/joints", joints, ns))
        layout = kind("std_msgs/msg/MultiArrayLayout")(dim=[], data_offset=0)
        array = kind("std_msgs/msg/Float64MultiArray")(layout=layout, data=np.array([t, 7.0]))
        found.append(("/array", array, ns))
    found.sort(key=lambda row: row[2])
    return found


def with_rosbags(path, plugin, suffix):
    folder = path.with_suffix("")
    shutil.rmtree(folder, ignore_errors=True)
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for topic, message, ns in messages():
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=STORE)
            writer.write(connections[topic], ns, STORE.serialize_cdr(message, message.__msgtype__))
    shutil.move(next(folder.glob(f"*.{suffix}")), path)
    shutil.rmtree(folder)


def plain(message):
    """A message as the dictionaries and lists that mcap-ros2-support takes."""
    if hasattr(message, "__msgtype__"):
        fields = (name for name in message.__dataclass_fields__ if name != "__msgtype__")
        return {name: plain(getattr(message, name)) for name in fields}
    if isinstance(message, list):
        return [plain(one) for one in message]
    return message.tolist() if hasattr(message, "tolist") else message


def with_mcap(path, compression):
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=8192, compression=compression)
        schemas = {}
        for topic, message, ns in messages():
            name = message.__msgtype__
            if name not in schemas:
                text, _ = STORE.generate_msgdef(name, ros_version=2)
                schemas[name] = writer.register_msgdef(name.replace("/msg/", "/"), text)
            writer.write_message(topic, schemas[name], plain(message), log_time=ns, publish_time=ns)
        writer.finish()


def big_endian(source, path):
    """The bag with every message in the other byte order."""
    shutil.copy(source, path)
    base = sqlite3.connect(path)
    types = dict(base.execute("select id, type from topics"))
    for row, topic, data in base.execute("select id, topic_id, data from messages").fetchall():
        message = STORE.deserialize_cdr(data, types[topic])
        swapped = bytes(STORE.serialize_cdr(message, types[topic], little_endian=False))
        base.execute("update messages set data = ? where id = ?", (swapped, row))
    base.commit()
    base.execute("vacuum")
    base.close()


def main():
    out = Path(sys.argv[1])
    with_rosbags(out / "press.db3", StoragePlugin.SQLITE3, "db3")
    with_rosbags(out / "press.mcap", StoragePlugin.MCAP, "mcap")
    with_mcap(out / "press_lz4.mcap", CompressionType.LZ4)
    with_mcap(out / "press_zstd.mcap", CompressionType.ZSTD)
    big_endian(out / "press.db3", out / "big_endian.db3")


main()
