#!/usr/bin/env python3
"""Small records in the formats of laboratories, and what is in them: tests/data/records.

Every file is written by the library of its own community (openpyxl, xlwt, odfpy, scipy, h5py, mcap with rosbags); tests/reduction/formats.rs
reads them and compares with expected.json, number by number.
"""

import json
import math
import pathlib

import h5py
import mcap.writer
import numpy as np
import odf.opendocument
import odf.table
import odf.text
import openpyxl
import rosbags.typesys
import scipy.io
import xlwt

OUT = pathlib.Path(__file__).parent.parent / "data" / "records"
ROWS = 40
# fifteen digits: what a workbook keeps
TIME = [round(0.01 * k, 2) for k in range(ROWS)]
RATE = [[round(0.25 * math.sin(0.3 * k + axis), 12) for k in range(ROWS)] for axis in range(3)]
FORCE = [[round(9.81 * math.cos(0.2 * k - axis), 12) for k in range(ROWS)] for axis in range(3)]
COUNTS = [(k * 7919) % 251 - 125 for k in range(ROWS)]

expected = {}


def excel():
    book = openpyxl.Workbook()
    notes = book.active
    notes.title = "Notes"
    notes.append(["recorded on the rate table"])
    sheet = book.create_sheet("Messung")
    sheet.append(["Logger 7"])
    sheet.append([])
    sheet.append(["t (s)", "Ausgang (mV)", "Stellung"])
    for k in range(ROWS):
        sheet.append([TIME[k], RATE[0][k], f"p{k // 10}"])
    for _ in range(3):
        sheet.append([None, None, None])
    book.save(OUT / "log.xlsx")
    expected["log.xlsx"] = {"t (s)": TIME, "Ausgang (mV)": RATE[0]}

    book = openpyxl.Workbook()
    for name, values in [("run 1", RATE[0]), ("run 2", RATE[1])]:
        sheet = book.create_sheet(name)
        sheet.append(["t", "V"])
        for row in zip(TIME, values):
            sheet.append(row)
    book.remove(book["Sheet"])
    book.save(OUT / "two-sheets.xlsx")
    expected["two-sheets.xlsx#run 2"] = {"t": TIME, "V": RATE[1]}

    # eight positions of a dividing head, the readings 2 mV + 1.3 V/g times the specific force
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Winkel (Grad)", "Spannung (mV)"])
    for k in range(8):
        sheet.append([45.0 * k, 1000 * (0.002 - 1.3 * math.sin(math.radians(45.0 * k)))])
    sheet.append([None, None])
    book.save(OUT / "readings.xlsx")

    book = xlwt.Workbook()
    sheet = book.add_sheet("log")
    for column, (title, values) in enumerate([("t", TIME), ("counts", COUNTS)]):
        sheet.write(0, column, title)
        for k, value in enumerate(values):
            sheet.write(k + 1, column, value)
    book.save(str(OUT / "log.xls"))
    expected["log.xls"] = {"t": TIME, "counts": COUNTS}

    book = odf.opendocument.OpenDocumentSpreadsheet()
    sheet = odf.table.Table(name="log")
    for row in [["t", "V"], *zip(TIME, RATE[2])]:
        line = odf.table.TableRow()
        for value in row:
            if isinstance(value, str):
                cell = odf.table.TableCell(valuetype="string")
                cell.addElement(odf.text.P(text=value))
            else:
                cell = odf.table.TableCell(valuetype="float", value=repr(value))
            line.addElement(cell)
        sheet.addElement(line)
    book.spreadsheet.addElement(sheet)
    book.save(str(OUT / "log.ods"))
    expected["log.ods"] = {"t": TIME, "V": RATE[2]}


def matlab():
    gyro = np.array(RATE).T
    force = np.array(FORCE)
    flat = {"t": np.array(TIME), "gyro": gyro, "force": force, "counts": np.array(COUNTS, dtype=np.int16), "rate_hz": 100.0, "who": "logger 7"}
    columns = {"t": TIME, "counts": COUNTS}
    columns |= {f"gyro_{k + 1}": RATE[k] for k in range(3)} | {f"force_{k + 1}": FORCE[k] for k in range(3)}
    for name, packed in [("flat.mat", False), ("flat-packed.mat", True)]:
        scipy.io.savemat(OUT / name, flat, do_compression=packed)
        expected[name] = columns
    nested = {"log": {"imu": {"t": np.array(TIME), "V": np.array(RATE[1], dtype=np.float32)}, "note": "x"}, "gains": np.arange(3.0)}
    scipy.io.savemat(OUT / "struct.mat", nested, do_compression=True)
    expected["struct.mat"] = {"t": TIME, "V": [float(np.float32(v)) for v in RATE[1]]}
    scipy.io.savemat(OUT / "several.mat", {"run1": gyro, "run2": force.T})
    several = {"run1": {"t": np.array(TIME), "V": gyro[:, 0]}, "run2": {"t": np.array(TIME), "V": gyro[:, 1]}}
    scipy.io.savemat(OUT / "several.mat", several)
    expected["several.mat#run2"] = {"t": TIME, "V": RATE[1]}
    scipy.io.savemat(OUT / "texts.mat", {"who": "logger 7"})


def hdf5():
    with h5py.File(OUT / "log.h5", "w") as file:
        imu = file.create_group("imu")
        imu.create_dataset("time_s", data=np.array(TIME))
        rates = imu.create_dataset("gyro", data=np.array(RATE).T, chunks=(16, 3), compression="gzip", shuffle=True)
        rates.attrs["units"] = "rad/s"
        imu.create_dataset("counts", data=np.array(COUNTS, dtype=">i4"))
        file.create_dataset("gains", data=np.arange(3.0))
        file.attrs["logger"] = "7"
    expected["log.h5"] = {"time_s": TIME, "counts": COUNTS} | {f"gyro_{k + 1}": RATE[k] for k in range(3)}

    kind = np.dtype([("t", "<f8"), ("V", "<f4"), ("n", "<i2")])
    rows = np.array(list(zip(TIME, RATE[0], COUNTS)), dtype=kind)
    with h5py.File(OUT / "records.h5", "w", libver="latest") as file:
        file.create_dataset("table", data=rows)
    expected["records.h5"] = {"t": TIME, "V": [float(np.float32(v)) for v in RATE[0]], "n": COUNTS}

    # as MATLAB writes level 7.3: HDF5 behind 512 bytes, arrays transposed, characters as numbers
    path = OUT / "log-v73.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in [("t", np.array([TIME])), ("gyro", np.array(RATE))]:
            file.create_dataset(name, data=values).attrs["MATLAB_class"] = np.bytes_("double")
        file.create_dataset("who", data=np.array([[ord(c)] for c in "x" * ROWS], dtype="u2")).attrs["MATLAB_class"] = np.bytes_("char")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  5 10:00:00 2026 HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")
    expected["log-v73.mat"] = {"t": TIME} | {f"gyro_{k + 1}": RATE[k] for k in range(3)}



def packed():
    """Packed after the conventions of netCDF: 0.5 counts + 2, the fourth of them absent (tests/reduction/formats.rs)."""
    with h5py.File(OUT / "packed.h5", "w") as file:
        values = np.array(COUNTS, dtype=np.int16)
        values[3] = -999
        data = file.create_dataset("V", data=values)
        data.attrs["scale_factor"] = np.float32(0.5)
        data.attrs["add_offset"] = np.int32(2)
        data.attrs["_FillValue"] = np.int16(-999)
        file.create_dataset("t", data=TIME)


def messages(store, ros1):
    types = store.types
    time_type = types["builtin_interfaces/msg/Time"]
    vector = types["geometry_msgs/msg/Vector3"]
    still = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    for k in range(ROWS):
        stamp = time_type(sec=1_700_000_000 + k // 25, nanosec=(k % 25) * 40_000_000)
        extra = {"seq": k} if ros1 else {}
        head = types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu_link", **extra)
        none = np.zeros(9)
        yield types["sensor_msgs/msg/Imu"](
            header=head,
            orientation=still,
            orientation_covariance=none,
            angular_velocity=vector(*[RATE[axis][k] for axis in range(3)]),
            angular_velocity_covariance=none,
            linear_acceleration=vector(*[FORCE[axis][k] for axis in range(3)]),
            linear_acceleration_covariance=none,
        )


def logs():
    names = ["w_x", "w_y", "w_z", "a_x", "a_y", "a_z"]
    columns = {"time_s": [(40 * k) / 1000 for k in range(ROWS)]} | dict(zip(names, RATE + FORCE))
    stores = rosbags.typesys.Stores
    two = rosbags.typesys.get_typestore(stores.ROS2_HUMBLE)
    one = rosbags.typesys.get_typestore(stores.ROS1_NOETIC)
    kinds = mcap.writer.CompressionType
    cases = [
        ("ros2.mcap", two, "cdr", kinds.ZSTD, ["/imu/data"]),
        ("ros2-lz4.mcap", two, "cdr", kinds.LZ4, ["/imu/data"]),
        ("ros1.mcap", one, "ros1", kinds.NONE, ["/imu/data"]),
        ("two-topics.mcap", two, "cdr", kinds.ZSTD, ["/imu/left", "/imu/right"]),
        ("no-imu.mcap", two, "cdr", kinds.ZSTD, []),
    ]
    for file, store, encoding, packed, topics in cases:
        kind = "sensor_msgs/msg/Imu" if encoding == "cdr" else "sensor_msgs/Imu"
        with open(OUT / file, "wb") as stream:
            writer = mcap.writer.Writer(stream, compression=packed, chunk_size=4096)
            writer.start(profile="ros2" if encoding == "cdr" else "ros1", library="test")
            text = "std_msgs/msg/String" if encoding == "cdr" else "std_msgs/String"
            schema = writer.register_schema(text, "ros2msg" if encoding == "cdr" else "ros1msg", b"string data")
            other = writer.register_channel("/chatter", encoding, schema)
            schema = writer.register_schema(kind, "ros2msg" if encoding == "cdr" else "ros1msg", b"Imu")
            channels = [writer.register_channel(topic, encoding, schema) for topic in topics]
            string = store.types["std_msgs/msg/String"](data="hello")
            for k, message in enumerate(messages(store, encoding == "ros1")):
                at = 1_700_000_000_000_000_000 + 40_000_000 * k
                name = "std_msgs/msg/String"
                pack = store.serialize_cdr if encoding == "cdr" else store.serialize_ros1
                writer.add_message(other, at, bytes(pack(string, name)), at)
                for channel in channels:
                    writer.add_message(channel, at, bytes(pack(message, "sensor_msgs/msg/Imu")), at)
            writer.finish()
        if len(topics) == 1:
            expected[file] = columns
        elif topics:
            expected[f"{file}#/imu/right"] = columns


OUT.mkdir(exist_ok=True)
excel()
matlab()
hdf5()
packed()
logs()
(OUT / "expected.json").write_text(json.dumps(expected, indent=0) + "\n")
