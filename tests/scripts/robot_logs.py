#!/usr/bin/env python3
"""Small logs of robots: a bag of ROS 1 (written by rosbags) and a ULog of PX4 (written by hand, read back by pyulog): tests/data/records.

tests/reduction/formats.rs reads them and compares with the numbers that are computed here and there by the same formulas.
"""

import json
import math
import pathlib
import struct

import numpy as np
import pyulog
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

OUT = pathlib.Path(__file__).parent.parent / "data" / "records"
ROWS = 40
RATE = [[0.25 * math.sin(0.3 * k + axis) for k in range(ROWS)] for axis in range(3)]
FORCE = [[9.81 * math.cos(0.2 * k - axis) for k in range(ROWS)] for axis in range(3)]
FIRST_NS = 1_700_000_000_000_000_000


def bag(name, compression):
    store = get_typestore(Stores.ROS1_NOETIC)
    imu, header = store.types["sensor_msgs/msg/Imu"], store.types["std_msgs/msg/Header"]
    vector, quaternion = store.types["geometry_msgs/msg/Vector3"], store.types["geometry_msgs/msg/Quaternion"]
    time, text = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/String"]
    (OUT / name).unlink(missing_ok=True)
    writer = Writer(OUT / name)
    if compression:
        writer.set_compression(Writer.CompressionFormat.LZ4)
    with writer:
        own = writer.add_connection("/imu/data", imu.__msgtype__, typestore=store)
        other = writer.add_connection("/remarks", text.__msgtype__, typestore=store)
        for k in range(ROWS):
            at = FIRST_NS + 10_000_000 * k
            message = imu(
                header(k, time(at // 10**9, at % 10**9), "imu"), quaternion(0, 0, 0, 1), np.zeros(9),
                vector(*[RATE[axis][k] for axis in range(3)]), np.zeros(9),
                vector(*[FORCE[axis][k] for axis in range(3)]), np.zeros(9),
            )
            # messages arrive 3 ms after they were stamped
            writer.write(own, at + 3_000_000, store.serialize_ros1(message, imu.__msgtype__))
            if k % 10 == 0:
                writer.write(other, at, store.serialize_ros1(text("still"), text.__msgtype__))


def ulog(name):
    def message(kind, data):
        return struct.pack("<HB", len(data), ord(kind)) + data

    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)
    out += message("B", bytes(40))
    out += message("F", b"vibration:float level;uint8_t[4] _padding0;")
    out += message("F", b"sensor_combined:uint64_t timestamp;float[3] gyro_rad;int16_t temperature;vibration shake;char[4] tag;bool clipped;")
    out += message("F", b"remark:uint64_t timestamp;uint8_t kind;")
    out += message("A", struct.pack("<BH", 0, 7) + b"sensor_combined")
    out += message("A", struct.pack("<BH", 1, 9) + b"remark")
    for k in range(ROWS):
        data = struct.pack("<HQ3fhf4s4sB", 7, 2_000_000 + 4000 * k, *[RATE[axis][k] for axis in range(3)], 20 + k, 0.5 * k, b"", b"abcd", k % 2)
        out += message("D", data)
        if k == 5:
            out += message("O", struct.pack("<H", 12)) + message("D", struct.pack("<HQB", 9, 2_020_000, 3))
    # the power went off in the middle of a message
    out += message("D", bytes(30))[:9]
    (OUT / name).write_bytes(out)
    read = pyulog.ULog(str(OUT / name)).get_dataset("sensor_combined").data
    assert len(read["timestamp"]) == ROWS and read["timestamp"][3] == 2_012_000
    assert abs(read["gyro_rad[1]"][4] - RATE[1][4]) < 1e-7 and read["shake.level"][7] == 3.5 and read["clipped"][9] == 1


bag("ros1.bag", False)
bag("ros1-lz4.bag", True)
ulog("px4.ulg")
time = [10_000_000 * k / 1e9 for k in range(ROWS)]
imu = {"time_s": time} | {f"w_{a}": RATE[k] for k, a in enumerate("xyz")} | {f"a_{a}": FORCE[k] for k, a in enumerate("xyz")}
single = lambda values: [float(np.float32(v)) for v in values]
px4 = {"timestamp": [2_000_000 + 4000 * k for k in range(ROWS)], "temperature": [20 + k for k in range(ROWS)]}
px4 |= {f"gyro_rad[{k}]": single(RATE[k]) for k in range(3)}
px4 |= {"shake.level": single([0.5 * k for k in range(ROWS)]), "clipped": [k % 2 for k in range(ROWS)]}
(OUT / "robots.json").write_text(json.dumps({"ros1.bag": imu, "ros1-lz4.bag": imu, "px4.ulg": px4}))
