#!/usr/bin/env python3
"""One table in the formats that libraries write: tests/data/doors, which tests/program/doors.rs reads beside the same table in dialects of text.

Rows of serial, x, temperature in kelvin, time in minutes, volts in millivolts, on the line V = 1 + 0.5 x + 0.02 t_C + 0.001 t_s.
"""

import pathlib

import h5py
import numpy as np
import odf.opendocument
import odf.table
import odf.text
import openpyxl

OUT = pathlib.Path(__file__).parent.parent / "data" / "doors"
OUT.mkdir(exist_ok=True)
TITLES = ["serial", "x", "Temp (K)", "t (min)", "V [mV]"]
ROWS = []
for serial in ['6" rotor, left', "B"]:
    for k in range(16):
        x, celsius, seconds = 22.5 * k, 20 + 7 * k % 9, 30 * k * k
        ROWS.append([serial, x, celsius + 273.15, seconds / 60, 1000 + 500 * x + 20 * celsius + seconds])

book = openpyxl.Workbook()
sheet = book.active
sheet.append(["readings of two rotors"])
sheet.append(TITLES)
for row in ROWS:
    sheet.append(row)
book.save(OUT / "table.xlsx")

document = odf.opendocument.OpenDocumentSpreadsheet()
table = odf.table.Table(name="table")
for row in [TITLES, *ROWS]:
    line = odf.table.TableRow()
    for cell in row:
        if isinstance(cell, str):
            own = odf.table.TableCell(valuetype="string")
            own.addElement(odf.text.P(text=cell))
        else:
            own = odf.table.TableCell(valuetype="float", value=repr(float(cell)))
        line.addElement(own)
    table.addElement(line)
document.spreadsheet.addElement(table)
document.save(OUT / "table.ods")

# numbers alone: the serials are 1 and 2
with h5py.File(OUT / "table.h5", "w", libver="earliest") as file:
    file["serial"] = np.repeat([1.0, 2.0], 16)
    for k, (title, unit) in enumerate([("x", None), ("Temp", "K"), ("t", "min"), ("V", "mV")]):
        file[title] = np.array([row[k + 1] for row in ROWS], dtype=float)
        if unit:
            file[title].attrs["units"] = unit
