"""A workbook of which one column has formulas whose values were not saved, as programs that write workbooks leave them to Excel: ../data/records/formulas.xlsx."""

import pathlib
import zipfile

MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
FORMATS = "application/vnd.openxmlformats-officedocument.spreadsheetml"


def text(cell, what):
    return f'<c r="{cell}" t="inlineStr"><is><t>{what}</t></is></c>'


def row(k):
    """An angle, a value, a formula with its value and one without."""
    value = [0.5, 1.5, 0.5, -0.5][k % 4]  # 0.5 + sin(angle)
    cells = f'<c r="A{k + 2}"><v>{90 * k}</v></c><c r="B{k + 2}"><v>{value}</v></c>'
    cells += f'<c r="C{k + 2}"><f>2*B{k + 2}</f><v>{2 * value}</v></c><c r="D{k + 2}"><f>3*B{k + 2}</f></c>'
    return f'<row r="{k + 2}">{cells}</row>'


titles = "".join(text(f"{column}1", title) for column, title in zip("ABCD", ["theta_deg", "once", "twice", "thrice"]))
sheet = f'<worksheet xmlns="{MAIN}"><sheetData><row r="1">{titles}</row>{"".join(map(row, range(8)))}</sheetData></worksheet>'
relations = '<Relationships xmlns="{}/relationships"><Relationship Id="rId1" Type="{}/{}" Target="{}"/></Relationships>'
parts = {
    "[Content_Types].xml": f'<Types xmlns="{PACKAGE}/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    f'<Default Extension="xml" ContentType="application/xml"/><Override PartName="/xl/workbook.xml" ContentType="{FORMATS}.sheet.main+xml"/>'
    f'<Override PartName="/xl/worksheets/sheet1.xml" ContentType="{FORMATS}.worksheet+xml"/></Types>',
    "_rels/.rels": relations.format(PACKAGE, OFFICE, "officeDocument", "xl/workbook.xml"),
    "xl/workbook.xml": f'<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets><sheet name="run" sheetId="1" r:id="rId1"/></sheets></workbook>',
    "xl/_rels/workbook.xml.rels": relations.format(PACKAGE, OFFICE, "worksheet", "worksheets/sheet1.xml"),
    "xl/worksheets/sheet1.xml": sheet,
}
at = pathlib.Path(__file__).parent.parent / "data/records/formulas.xlsx"
with zipfile.ZipFile(at, "w", zipfile.ZIP_DEFLATED) as book:
    for name, content in parts.items():
        book.writestr(zipfile.ZipInfo(name), '<?xml version="1.0" encoding="UTF-8"?>' + content)
