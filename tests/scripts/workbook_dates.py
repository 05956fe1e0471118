#!/usr/bin/env python3
"""Dates and times in workbooks of both epochs, 1900 and 1904, as openpyxl writes them: tests/data/records/dates-1900.xlsx and dates-1904.xlsx, and what
their cells mean in seconds (dates.json), by Python's own calendar."""

import datetime
import json
import pathlib

import openpyxl
from openpyxl.utils.datetime import CALENDAR_MAC_1904, CALENDAR_WINDOWS_1900

OUT = pathlib.Path(__file__).parent.parent / "data" / "records"
START = datetime.datetime(2026, 11, 20, 23, 59, 58, 500000)
# two days at midnight among them: a column of moments stays one
WHEN = [START + datetime.timedelta(milliseconds=250 * k) for k in range(12)]
DAYS = [datetime.date(2024, 2, 28) + datetime.timedelta(days=k) for k in range(12)]
CLOCK = [datetime.time(14, 3, k, 125000) for k in range(12)]
LASTED = [datetime.timedelta(hours=30, seconds=k + 0.5) for k in range(12)]
VOLTS = [0.5 + 0.25 * (k % 5) for k in range(12)]

for epoch, name in [(CALENDAR_WINDOWS_1900, "1900"), (CALENDAR_MAC_1904, "1904")]:
    book = openpyxl.Workbook()
    book.epoch = epoch
    # a fixed time of writing, so that the file is the same again
    book.properties.created = book.properties.modified = datetime.datetime(2026, 11, 26)
    sheet = book.active
    sheet.append(["when", "day", "clock", "lasted", "V (mV)"])
    for row in zip(WHEN, DAYS, CLOCK, LASTED, VOLTS):
        sheet.append(row)
    for row in sheet.iter_rows(min_row=2, min_col=4, max_col=4):
        row[0].number_format = "[h]:mm:ss.000"
    book.save(OUT / f"dates-{name}.xlsx")

UNIX = datetime.datetime(1970, 1, 1)
wanted = {
    "when": [(own - UNIX).total_seconds() for own in WHEN],
    "day": [(own - UNIX.date()).total_seconds() for own in DAYS],
    "clock": [own.hour * 3600 + own.minute * 60 + own.second + own.microsecond / 1e6 for own in CLOCK],
    "lasted": [own.total_seconds() for own in LASTED],
    "V (mV)": VOLTS,
}
(OUT / "dates.json").write_text(json.dumps(wanted) + "\n")
