#!/usr/bin/env python3
"""Writes fixtures/malformed: damaged files by class, and cases.json with what must be said about each.

Everything but the HDF5 files needs the standard library only; these need h5py and are left as they are without it.
Same script (and zlib, and h5py), same bytes. Usage: scripts/make_malformed.py
"""
import io
import json
import pathlib
import shutil
import struct
import wave
import zipfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent / "fixtures" / "malformed"
CASES = []


def case(folder, name, content, message, command="convert", **places):
    """One damaged file; `message` must be part of what is said, `places` parts of field, found or expected."""
    path = ROOT / folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    CASES.append({"file": f"{folder}/{name}", "command": command, "message": message, **places})


# ---------------------------------------------------------------------------------------------------- universal files
IDS = "NONE\n" * 5
RECORD_6 = "    4         0    0         0 NONE               5   3 NONE             101   3\n"
AXES = (
    "        18    0    0    0 Frequency            Hz                  \n"
    "        11    0    0    0 Velocity             m/s                 \n"
    "        13    0    0    0 Force                N                   \n"
    "         0    0    0    0 NONE                 NONE                \n"
)
HEADER_151 = "    -1\n   151\nNONE\nNONE\nNONE\n\n\nNONE\n\n    -1\n"
UNITS = (
    "    -1\n   164\n         1SI                           2\n"
    "  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00\n"
    "  2.73149999999999980D+02\n    -1\n"
)


def record_7(kind, count, even, step=0.5):
    return f"{kind:10}{count:10}{even:10}{'  1.00000E+00'}{step:13.5E}{'  0.00000E+00'}\n"


def e13(x):
    return f"{x:13.5E}"


def e20(x):
    return f"{x:20.12E}"


def data(kind, even, points):
    """Lines of the data of one 58, in the layout of its type and spacing."""
    double, complex_, lines, line, width = kind in (4, 6), kind in (5, 6), [], "", 0
    per_line = {(False, False): 78, (False, True): 78, (True, True): 80}.get((double, bool(even)), 53 if complex_ else 66)
    for k in range(points):
        fields = ([] if even else [e13(1.0 + 0.5 * k)]) + [(e20 if double else e13)(0.25 * k + part) for part in range(1 + complex_)]
        for field in fields:
            line += field
            width += len(field)
            if width >= per_line:
                lines.append(line)
                line, width = "", 0
    return "".join(part + "\n" for part in lines + ([line] if line else []))


def text_58(record=None, body=None, record_6=RECORD_6, axes=AXES, end="    -1\n"):
    record = record_7(6, 4, 1) if record is None else record
    body = data(6, 1, 4) if body is None else body
    return f"    -1\n    58\n{IDS}{record_6}{record}{axes}{body}{end}"


def uff(*parts):
    return HEADER_151 + UNITS + "".join(parts)


def universal_text():
    whole = uff(text_58())
    for k, cut in enumerate((8, 30, 61, 90, 120)):
        case("uff-cut-in-data", f"{k}.uff", whole[:-cut], "the file ends inside this dataset" if k == 0 else "disagree")
    for k, record in enumerate((1, 3, 5, 6, 7, 8, 10)):
        head = "".join(text_58().splitlines(True)[: 2 + record])
        case("uff-cut-in-header", f"record{record}.uff", uff(head), "ends inside its header", dataset=58)
        case("uff-header-short", f"record{record}.uff", uff(head, "    -1\n"), "ends inside its header", dataset=58)
    for kind in (2, 4, 5, 6):
        for even in (0, 1):
            name = f"type{kind}-{'even' if even else 'uneven'}.uff"
            case("uff-count-too-high", name, uff(text_58(record_7(kind, 9, even), data(kind, even, 4))), "disagree", field="number of values")
            case("uff-count-too-low", name, uff(text_58(record_7(kind, 2, even), data(kind, even, 7))), "disagree", field="number of values")
    case("uff-count-absurd", "nine-digits.uff", uff(text_58(record_7(6, 999999999, 1))), "disagree", field="number of values")
    case("uff-count-absurd", "ten-digits.uff", uff(text_58(record_7(2, 9999999999, 1), data(2, 1, 4))), "disagree", field="number of values")
    case("uff-count-absurd", "negative.uff", uff(text_58(record_7(6, -4, 1))), "unknown code", field="number of values")
    lines = data(6, 1, 4)
    for name, word in (("stars", "*" * 20), ("few-stars", "*****".rjust(20))):
        for at in (0, 20, 60, 81):
            case("uff-overflow", f"{name}-{at}.uff", uff(text_58(body=lines[:at] + word + lines[at + 20:])), "did not fit its field", found="*")
    for word in ("NaN", "Inf", "-Inf", "1.0E+999", "-1.0D+400"):
        case("uff-not-finite", word.lower().replace("+", "") + ".uff", uff(text_58(body=word.rjust(20) + lines[20:])), "not finite", found=word)
    for k, word in enumerate(("abc", "1.2.3", "0x1F", "1,5", "--2", "1.0E+")):
        case("uff-text-for-number", f"{k}.uff", uff(text_58(body=word.rjust(20) + lines[20:])), "text instead of a number", found=word)
    for kind in (0, 1, 3, 7, 99):
        case("uff-ordinate-type", f"{kind}.uff", uff(text_58(record_7(kind, 4, 1))), "unknown code", field="ordinate type", found=str(kind))
    for even in (2, 7, -1):
        case("uff-spacing", f"{even}.uff", uff(text_58(record_7(6, 4, even))), "unknown code", field="spacing", found=str(even))
    for name, record, field in (
        ("type-text", RECORD_6.replace("    4 ", "  abc ", 1), "function type"),
        ("node-text", RECORD_6.replace("         5", "      five"), "node"),
        ("node-negative", RECORD_6.replace("         5", "        -5"), "node"),
        ("direction-9", RECORD_6.replace("   3 NONE", "   9 NONE"), "direction"),
        ("direction-minus-7", RECORD_6.replace("101   3", "101  -7"), "direction"),
        ("node-fraction", RECORD_6.replace("         5", "       5.5"), "node"),
    ):
        case("uff-record-6", name + ".uff", uff(text_58(record_6=record)), "", field=field)
    for name, axis in (("quantity-text", "       abc"), ("quantity-fraction", "      11.5")):
        case("uff-axis-record", name + ".uff", uff(text_58(axes=AXES.replace("        11", axis))), "")
    for k, text in enumerate(("    -1\n", "    -1\n    -1\n", "    -1\n\n\n", "    -1\n    -1\n    -1\n\n")):
        case("uff-no-dataset", f"{k}.uff", text, "no dataset of a universal file")
    for k, number in enumerate(("  abc", "  5x8", "", "58.5")):
        if number:
            case("uff-no-number", f"{k}.uff", f"    -1\n{number}\nNONE\n    -1\n", "no dataset number", found=number.strip())
    for name, factors, field in (
        ("zero", "  0.00000000000000000D+00  1.00000000000000000D+00", "length factor"),
        ("negative", "  1.00000000000000000D+00 -1.00000000000000000D+00", "force factor"),
        ("text", "                      abc  1.00000000000000000D+00", "length factor"),
        ("stars", "*" * 25 + "  1.00000000000000000D+00", "length factor"),
    ):
        case("uff-units", name + ".uff", f"    -1\n   164\n         1SI\n{factors}\n    -1\n" + text_58(), "", dataset=164, field=field)
    case("uff-units", "short.uff", "    -1\n   164\n         1SI\n    -1\n" + text_58(), "too short", dataset=164)
    case("uff-units", "code.uff", "    -1\n   164\n       abcSI\n  1.0D+00\n    -1\n" + text_58(), "text instead of a number", dataset=164)


def dataset(number, body):
    return f"    -1\n{number:6}\n{body}    -1\n"


def universal_geometry():
    node = "{:10}{:10}{:10}{:10}\n".format
    xyz = "   1.0000000000000000D-01   2.0000000000000000D-01   0.0000000000000000D+00\n"
    for name, body, message in (
        ("odd", node(1, 0, 0, 11) + xyz + node(2, 0, 0, 11), "ends after a node's first record"),
        ("negative", node(-1, 0, 0, 11) + xyz, "must be positive"),
        ("zero", node(0, 0, 0, 11) + xyz, "must be positive"),
        ("text", node("one", 0, 0, 11) + xyz, "text instead of a number"),
        ("nan", node(1, 0, 0, 11) + xyz.replace("1.0000000000000000D-01", "                   NaN"), "not finite"),
        ("stars", node(1, 0, 0, 11) + "*" * 25 + xyz[25:], "did not fit its field"),
    ):
        case("uff-2411", name + ".uff", uff(dataset(2411, body)), message, dataset=2411)
    fields = "{:10}{:10}{:10}{:10}{}{}{}\n".format
    for name, body, message in (
        ("text", fields(1, 0, 0, 1, e13(1), "         left", e13(0)), "text instead of a number"),
        ("negative", fields(-7, 0, 0, 1, e13(1), e13(2), e13(0)), "must be positive"),
        ("fraction", fields("1.5", 0, 0, 1, e13(1), e13(2), e13(0)), "whole number"),
        ("stars", fields(1, 0, 0, 1, e13(1), "*" * 13, e13(0)), "did not fit its field"),
    ):
        case("uff-15", name + ".uff", uff(dataset(15, body)), message, dataset=15)
    head = "{:10}{:10}{:10}\nNONE\n".format
    for name, body, message in (
        ("more-declared", head(1, 5, 7) + "".join(f"{k:10}" for k in range(1, 4)) + "\n", "fewer labels than declared"),
        ("fewer-declared", head(1, 2, 7) + "".join(f"{k:10}" for k in range(1, 4)) + "\n", "more labels than declared"),
        ("absurd", head(1, 999999999, 7) + f"{1:10}\n", "fewer labels than declared"),
        ("negative", head(1, 2, 7) + f"{1:10}{-3:10}\n", "cannot be negative"),
        ("text", head(1, 2, 7) + f"{1:10}      next\n", "text instead of a number"),
        ("negative-count", head(1, -2, 7) + f"{1:10}{3:10}\n", "cannot be negative"),
    ):
        case("uff-82", name + ".uff", uff(dataset(82, body)), message, dataset=82)
    element = "{:10}{:10}{:10}{:10}{:10}{:10}\n".format
    for name, body, message in (
        ("nodes-missing", element(1, 94, 1, 1, 7, 4) + "".join(f"{k:10}" for k in (1, 2, 3)) + "\n", "fewer labels than declared"),
        ("no-nodes", element(1, 94, 1, 1, 7, 4), "fewer labels than declared"),
        ("beam-cut", element(1, 21, 1, 1, 7, 2), "fewer labels than declared"),
        ("node-zero", element(1, 91, 1, 1, 7, 3) + f"{1:10}{0:10}{3:10}\n", "must be positive"),
        ("absurd", element(1, 91, 1, 1, 7, 9999999), "impossible count of nodes"),
        ("text", element(1, "shell", 1, 1, 7, 3) + f"{1:10}{2:10}{3:10}\n", "text instead of a number"),
    ):
        case("uff-2412", name + ".uff", uff(dataset(2412, body)), message, dataset=2412)
    row = "   1.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00\n"
    for number, name, body, message in (
        (2420, "cut", f"{1:10}\nPart\n{4:10}{0:10}{8:10}\nCS4\n{row}{row}", "ends inside a coordinate system"),
        (2420, "type", f"{1:10}\nPart\n{4:10}{7:10}{8:10}\nCS4\n{row * 4}", "unknown code"),
        (2420, "text", f"{1:10}\nPart\n{4:10}{0:10}{8:10}\nCS4\n{row * 3}{'origin':>25}\n", "text instead of a number"),
        (18, "cut", f"{1:10}{0:10}{0:10}{1:10}{1:10}\nCS1\n", "ends inside a coordinate system"),
        (18, "type", f"{1:10}{5:10}{0:10}{1:10}{1:10}\nCS1\n", "unknown code"),
        (18, "text", f"{'one':>10}{0:10}{0:10}{1:10}{1:10}\nCS1\n", "text instead of a number"),
    ):
        case("uff-systems", f"{number}-{name}.uff", uff(dataset(number, body)), message, dataset=number)


def universal_shapes():
    types = "{:10}{:10}{:10}{:10}{:10}{:10}\n".format
    reals = "  1.00000E+01  1.00000E+00  5.00000E-03  0.00000E+00\n"
    good = f"{5:10}\n{e13(1)}{e13(2)}{e13(3)}\n"
    head = IDS + types(1, 2, 2, 8, 2, 3) + f"{2:10}{4:10}{1:10}{1:10}\n" + reals
    for name, body, message in (
        ("ids-only", IDS, "too short"),
        ("no-reals", IDS + types(1, 2, 2, 8, 2, 3) + f"{2:10}{4:10}{1:10}{1:10}\n", "too short"),
        ("node-without-values", head + good + f"{6:10}\n", "too short"),
        ("node-twice", head + good + good, "occurs twice"),
        ("node-zero", head + good.replace("         5", "         0"), "must be positive"),
        ("values-text", head + good.replace(e13(2), "         high"), "text instead of a number"),
        ("values-stars", head + good.replace(e13(2), "*" * 13), "did not fit its field"),
        ("values-nan", head + good.replace(e13(2), "          NaN"), "not finite"),
        ("data-type", IDS + types(1, 2, 2, 8, 3, 3) + f"{2:10}{4:10}{1:10}{1:10}\n" + reals + good, "unknown code"),
        ("no-components", IDS + types(1, 2, 2, 8, 2, 0) + f"{2:10}{4:10}{1:10}{1:10}\n" + reals + good, "unknown code"),
        ("absurd-components", IDS + types(1, 2, 2, 8, 2, 999999999) + f"{2:10}{4:10}{1:10}{1:10}\n" + reals + good, "unknown code"),
        ("absurd-counts", IDS + types(1, 2, 2, 8, 2, 3) + f"{2:10}{999999999:10}{1:10}{1:10}\n" + reals + good, "impossible counts"),
        ("types-text", IDS + types("one", 2, 2, 8, 2, 3) + f"{2:10}{4:10}\n" + reals + good, "text instead of a number"),
    ):
        case("uff-55", name + ".uff", uff(dataset(55, body)), message, dataset=55)
    zeros = "  0.00000E+00" * 6 + "\n"
    start = f"{1:10}\nMode 1\n{1:10}\n{IDS}"
    integers = "".join(f"{k:10}" for k in (1, 0, 1, 0, 1, 1, 0, 0)) + f"\n{0:10}{0:10}\n"
    for name, body, message in (
        ("label-only", f"{1:10}\n", "too short"),
        ("location", f"{1:10}\nMode 1\n{4:10}\n{IDS}" + types(1, 2, 2, 8, 2, 3) + integers + zeros * 2 + good, "unknown code"),
        ("no-reals", start + types(1, 2, 2, 8, 2, 3) + integers, "too short"),
        ("node-without-values", start + types(1, 2, 2, 8, 2, 3) + integers + zeros * 2 + f"{6:10}\n", "too short"),
        ("node-twice", start + types(1, 2, 2, 8, 2, 3) + integers + zeros * 2 + good + good, "occurs twice"),
        ("data-type", start + types(1, 2, 2, 8, 7, 3) + integers + zeros * 2 + good, "unknown code"),
        ("components", start + types(1, 2, 2, 8, 2, -3) + integers + zeros * 2 + good, "unknown code"),
        ("values-text", start + types(1, 2, 2, 8, 2, 3) + integers + zeros * 2 + good.replace(e13(2), "         high"), "text instead of a number"),
    ):
        case("uff-2414", name + ".uff", uff(dataset(2414, body)), message, dataset=2414)


def identifier(order, form, count, lines="          11"):
    return f"    58b{order:>6}{form:>6}{lines:>12}{count:>12}{0:6}{0:6}{0:12}{0:12}\n"


def binary_58(payload, record, ident=None, end=b"    -1\n"):
    ident = identifier(1, 2, len(payload)) if ident is None else ident
    return uff(f"    -1\n{ident}{IDS}{RECORD_6}{record}{AXES}").encode() + payload + end


def universal_binary():
    doubles = struct.pack("<8d", *range(8))
    for k, cut in enumerate((1, 8, 16, 40, 63)):
        case("58b-cut", f"{k}.uff", binary_58(doubles[:-cut], record_7(6, 4, 1), identifier(1, 2, 64), b""), "do not end where", dataset=58)
    for name, count, end in (("more", 5, b"    -1\n"), ("many", 2508876, b"    -1\n"), ("fewer", 3, b"    -1\n"), ("absurd", 9999999999, b"    -1\n")):
        case("58b-count", name + ".uff", binary_58(doubles, record_7(6, count, 1), end=end), "disagree", dataset=58, field="number of values")
    case("58b-count", "both-wrong.uff", binary_58(doubles, record_7(6, 5, 1), identifier(1, 2, 99)), "do not end where", dataset=58)
    case("58b-count", "no-marker.uff", binary_58(doubles, record_7(6, 4, 1), end=b""), "do not end where", dataset=58)
    floats = struct.pack("<8f", *range(8))
    for name, payload, kind in (("single-as-double", floats, 6), ("double-as-single", doubles, 5), ("real-single-as-double", floats[:16], 4), ("real-double-as-single", doubles[:32], 2)):
        case("58b-precision", name + ".uff", binary_58(payload, record_7(kind, 4, 1)), "precision, but the data are written in", field="ordinate type")
    for name, order, form, field in (("dec", 1, 1, "DEC"), ("ibm", 2, 3, "IBM"), ("form-0", 1, 0, "IEEE"), ("order-0", 0, 2, "endian"), ("order-3", 3, 2, "endian")):
        case("58b-floats", name + ".uff", binary_58(doubles, record_7(6, 4, 1), identifier(order, form, 64)), "cannot be read", expected=field)
    case("58b-identifier", "text.uff", binary_58(doubles, record_7(6, 4, 1), identifier("one", 2, 64)), "text instead of a number")
    case("58b-identifier", "bytes-text.uff", binary_58(doubles, record_7(6, 4, 1), identifier(1, 2, "many")), "text instead of a number")
    case("58b-identifier", "type.uff", binary_58(doubles, record_7(9, 4, 1)), "unknown code", field="ordinate type")
    case("58b-header-cut", "record5.uff", uff(f"    -1\n{identifier(1, 2, 64)}{IDS}"), "ends inside its header", dataset=58)
    case("58b-header-cut", "marker.uff", uff(f"    -1\n{identifier(1, 2, 64)}{IDS}    -1\n"), "ends inside its header", dataset=58)


# --------------------------------------------------------------------------------------------------------- text tables
def tables():
    rows = "f,re,im\n1.0,0.1,0.2\n2.0,0.3,0.4\n3.0,0.5,0.6\n"
    for name, text in (
        ("short-row", rows.replace("2.0,0.3,0.4", "2.0,0.3")),
        ("long-row", rows.replace("2.0,0.3,0.4", "2.0,0.3,0.4,0.5")),
        ("cut", rows[:-6]),
    ):
        case("csv-row-length", name + ".csv", text, "another length" if name != "cut" else "")
    for k, word in enumerate(("abc", "0.3x", "1e", "#N/A", "0x10", "inf", "1e999", "-")):
        case("csv-cell", f"{k}.csv", rows.replace("0.3", word), "not a finite number", found=word)
    for name, text, message in (
        ("falls", rows.replace("3.0,", "1.5,"), "falls"),
        ("twice", rows.replace("3.0,", "2.0,"), "occurs twice"),
        ("falls-at-once", rows.replace("1.0,", "9.0,"), "falls"),
    ):
        case("csv-axis", name + ".csv", text, message, found="after")
    case("csv-decimal-comma", "three.csv", "f,re,im\n1,0,0,1,0,2\n2,0,0,3,0,4\n", "", expected="decimal point")
    case("csv-decimal-comma", "unquoted.csv", "f,re,im\n1,5,0,1,0,2\n2,5,0,3,0,4\n", "", expected="decimal point")
    long = "node,dir,ref_node,ref_dir,f,re,im\n1,3,101,3,1.0,0.1,0.2\n1,3,101,3,2.0,0.3,0.4\n"
    for name, text in (
        ("node-text", long.replace("1,3,101,3,2.0", "one,3,101,3,2.0")),
        ("direction-9", long.replace("1,3,101,3,2.0", "1,9,101,3,2.0")),
        ("node-negative", long.replace("1,3,101,3,2.0", "-1,3,101,3,2.0")),
        ("value-text", long.replace("0.3", "high")),
        ("short-row", long.replace(",0.3,0.4", ",0.3")),
        ("frequency-text", long.replace("2.0,", "two,")),
        ("frequency-negative", long.replace("2.0,", "-2.0,")),
    ):
        case("csv-long", name + ".csv", text, "")
    for key, value in (("frf_kind", "speed"), ("frf_kind", ""), ("time_sign", "x"), ("reference_unit", "kg"), ("response", "here"), ("reference", "12:Q")):
        if value:
            case("csv-remark", f"{key}-{value.replace(':', '')}.csv", f"# {key} = {value}\n{rows}", "", field=key, found=value)
    for name, text in (("words", "no numbers here\nnone at all\n"), ("header", "f,re,im\n"), ("remarks", "# only\n# remarks\n"), ("blank", "\n\n\n")):
        case("csv-no-numbers", name + ".csv", text, "no row of numbers")
    for name, text in (("python", "(1+2j)\n(3-4j)\n"), ("python-many", "(1.5+2.5j)\n(3.5-4.5j)\n(1e-3+1e-5j)\n")):
        case("csv-complex-list", name + ".txt", text, "")
    times = "t [s],101:+Z [N],1:+Z [m/s]\n0.0,1.0,0.1\n0.1,0.5,0.2\n0.2,0.2,0.3\n"
    case("csv-time", "falls.csv", times.replace("0.2,0.2", "0.05,0.2"), "does not rise", command="estimate")
    case("csv-time", "gap.csv", times.replace("0.1,0.5,0.2", "0.1,,0.2"), "a sample is missing", command="estimate")
    case("csv-time", "uneven.csv", times.replace("0.2,0.2", "0.9,0.2"), "not evenly spaced", command="estimate")


# ----------------------------------------------------------------------------------------------------- MATLAB and NumPy
def mat_element(kind, payload, pad=True):
    padding = b"\0" * (-len(payload) % 8) if pad else b""
    return struct.pack("<II", kind, len(payload)) + payload + padding


def mat_array(name, dims, values, flags=6, im=None):
    parts = mat_element(6, struct.pack("<II", flags, 0)) + mat_element(5, struct.pack(f"<{len(dims)}i", *dims))
    parts += mat_element(1, name.encode()) + mat_element(9, values)
    return mat_element(14, parts + (mat_element(9, im) if im is not None else b""))


def mat_file(*elements, mark=b"IM"):
    return b"MATLAB 5.0 MAT-file, made for tests".ljust(124) + struct.pack("<H", 0x0100) + mark + b"".join(elements)


def matlab():
    eight = struct.pack("<8d", *range(8))
    freq = mat_array("f", [8, 1], eight)
    frf = mat_array("frf", [8, 1], eight, 6 | 0x0800, eight)
    good = mat_file(freq, frf)
    for k, cut in enumerate((1, 20, 70, 130, 190)):
        case("mat-cut", f"{k}.mat", good[:-cut], "", field="size of the element" if cut < 250 else "")
    case("mat-header", "cut.mat", good[:120], "header of the MATLAB file is damaged")
    case("mat-header", "mark.mat", mat_file(freq, frf, mark=b"XX"), "header of the MATLAB file is damaged", found="XX")
    case("mat-header", "only.mat", good[:60], "header of the MATLAB file is damaged")
    for name, dims in (("more", [9, 1]), ("fewer", [7, 1]), ("absurd", [2**31 - 1, 2**31 - 1]), ("huge", [2**30, 1])):
        case("mat-dimensions", name + ".mat", mat_file(mat_array("f", dims, eight), frf), "", field="/f")
    case("mat-dimensions", "negative.mat", mat_file(mat_array("f", [-8, 1], eight), frf), "cannot be negative")
    case("mat-parts", "imaginary-short.mat", mat_file(freq, mat_array("frf", [8, 1], eight, 6 | 0x0800, eight[:56])), "differ in length")
    case("mat-parts", "imaginary-missing.mat", mat_file(freq, mat_array("frf", [8, 1], eight, 6 | 0x0800)), "ends early", field="imaginary")
    case("mat-parts", "text-for-numbers.mat", mat_file(freq, mat_element(14, mat_element(6, struct.pack("<II", 6, 0)) + mat_element(5, struct.pack("<2i", 8, 1)) + mat_element(1, b"x") + mat_element(16, b"12345678"))), "no numbers")
    case("mat-parts", "odd-bytes.mat", mat_file(freq, mat_array("frf", [8, 1], eight[:61])), "no numbers", expected="multiple")
    case("mat-parts", "flags-only.mat", mat_file(mat_element(14, mat_element(6, struct.pack("<II", 6, 0)))), "ends early", field="dimensions")
    packed = zlib.compress(frf)
    case("mat-packed", "cut.mat", mat_file(mat_element(15, packed[:-9], pad=False)), "damaged")
    case("mat-packed", "changed.mat", mat_file(mat_element(15, packed[:12] + b"\xff\xff" + packed[14:], pad=False)), "damaged")
    case("mat-packed", "no-array.mat", mat_file(mat_element(15, zlib.compress(mat_element(9, eight)), pad=False)), "holds no array")
    case("mat-packed", "bomb.mat", mat_file(mat_element(15, zlib.compress(bytes(40 << 20), 9), pad=False)), "unfold to more than is plausible")
    deep = eight
    nested = mat_array("", [1, 1], deep[:8])
    for _ in range(60):
        cell = mat_element(6, struct.pack("<II", 1, 0)) + mat_element(5, struct.pack("<2i", 1, 1)) + mat_element(1, b"")
        nested = mat_element(14, cell + nested)
    case("mat-nested", "cells.mat", mat_file(nested), "nested too deeply")


def npy(descr, shape, payload, order="False", version=1):
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"
    text += " " * (-(11 + len(text)) % 64) + "\n"
    return b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H", len(text)) + text.encode() + payload


def npz(**members):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name + ".npy"), content)
    return out.getvalue()


def numpy_files():
    eight = struct.pack("<8d", *range(8))
    for name, content in (
        ("no-shape", npy("'<f8'", "8", eight)),
        ("order", npy("'<f8'", "(8,)", eight, order="Maybe")),
        ("negative", npy("'<f8'", "(-8,)", eight)),
        ("version", npy("'<f8'", "(8,)", eight, version=9)),
        ("cut", npy("'<f8'", "(8,)", eight)[:40]),
        ("only-signature", b"\x93NUMPY"),
    ):
        case("npy-header", name + ".npy", content, "header of the array is damaged")
    case("npy-header", "records.npy", npy("[('a', '<f8')]", "(8,)", eight), "values of a type that cannot be read")
    for name, shape, payload in (("short", "(8,)", eight[:-3]), ("long", "(7,)", eight), ("absurd", "(99999999999, 99999999999)", eight), ("empty", "(8,)", b"")):
        case("npy-size", name + ".npy", npy("'<f8'", shape, payload), "does not fit the shape")
    for name, code, width in (("pickle", "'|O'", 0), ("half", "'<f2'", 2), ("long-double", "'<f16'", 16), ("date", "'<M8'", 8)):
        case("npy-type", name + ".npy", npy(code, "(4,)", bytes(4 * width)), "" if width == 0 else "cannot be read")
    freq, frf = npy("'<f8'", "(8,)", eight), npy("'<c16'", "(8,)", eight * 2)
    good = npz(freq=freq, frf=frf)
    case("npz-archive", "cut.npz", good[:-30], "archive is damaged")
    case("npz-archive", "half.npz", good[: len(good) // 2], "archive is damaged")
    case("npz-archive", "changed.npz", good[:200] + b"\xaa" * 8 + good[208:], "archive is damaged")
    case("npz-archive", "array.npz", npz(freq=freq[:-8], frf=frf), "does not fit the shape")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        archive.writestr(zipfile.ZipInfo("freq.npy"), npy("'<f8'", "(5242880,)", bytes(40 << 20)), zipfile.ZIP_DEFLATED, 9)
    case("npz-archive", "bomb.npz", packed.getvalue(), "unfolds to more than is plausible")
    case("npz-choice", "two-frfs.npz", npz(freq=freq, a=frf, b=frf), "not clear which datasets")
    case("npz-choice", "two-axes.npz", npz(freq=freq, f=freq, frf=frf), "not clear which datasets")
    case("npz-choice", "square.npz", npz(freq=npy("'<f8'", "(2,)", eight[8:24]), frf=npy("'<c16'", "(2, 2)", eight)), "axes are as long as")


def sounds():
    out = io.BytesIO()
    with wave.open(out, "wb") as sound:
        sound.setnchannels(2)
        sound.setsampwidth(2)
        sound.setframerate(1000)
        sound.writeframes(struct.pack("<200h", *range(200)))
    good = out.getvalue()
    case("wav", "cut.wav", good[:-40], "", command="estimate")
    case("wav", "header.wav", good[:20], "damaged", command="estimate")
    case("wav", "no-data.wav", good[:36], "damaged", command="estimate")
    case("wav", "channels.wav", good[:22] + b"\0\0" + good[24:], "", command="estimate")
    case("wav", "bits.wav", good[:34] + b"\x07\0" + good[36:], "", command="estimate")
    out = io.BytesIO()
    nan = struct.pack("<4f", 0.5, float("nan"), 0.25, 0.125)
    chunk = b"fmt " + struct.pack("<IHHIIHH", 16, 3, 1, 1000, 4000, 4, 32) + b"data" + struct.pack("<I", len(nan)) + nan
    case("wav", "nan.wav", b"RIFF" + struct.pack("<I", 4 + len(chunk)) + b"WAVE" + chunk, "not finite", command="estimate")


# ---------------------------------------------------------------------------------------------------------------- JSON
def model():
    return {
        "format": "chladni.model", "version": 1, "created_by": "test", "source": [], "options": {},
        "frf_kind": "mobility", "reference_unit": "N", "band_hz": [10.0, 100.0], "damping": "structural", "scaling": "unscaled",
        "responses": ["1:+Z", "2:+Z"], "references": ["101:+Z"],
        "nodes": [{"label": 1, "xyz_m": [0.0, 0.0, 0.0]}, {"label": 2, "xyz_m": [0.1, 0.0, 0.0]}],
        "method": "auto",
        "modes": [{
            "frequency_hz": 50.0, "frequency_std_hz": 0.01, "loss_factor": 0.01, "loss_factor_std": 0.001, "damping_ratio": 0.005,
            "in_band": True, "trust": "sure", "reasons": [], "mpc": 1.0, "shape": {"re": [1.0, -0.5], "im": [0.0, 0.0]},
            "shape_std": [0.01, 0.01], "participation": {"re": [0.2], "im": [0.0]},
        }],
        "residual_terms": {"omega_scale_rad_per_s": 600.0, "terms": []},
        "quality": {"relative_error": 0.01, "chi2_per_dof": 1.0, "trusted": True, "warnings": []},
    }


def changed(change):
    altered = model()
    change(altered)
    return json.dumps(altered, indent=1)


def models():
    (ROOT / "base").mkdir(parents=True, exist_ok=True)
    (ROOT / "base" / "model.json").write_text(json.dumps(model(), indent=1))
    text = json.dumps(model(), indent=1)
    for k, cut in enumerate((1, 10, 200, len(text) // 2, len(text) - 30)):
        case("model-cut", f"{k}.json", text[:-cut], "")
    case("model-syntax", "comma.json", text.replace('"method": "auto",', '"method": "auto"'), "no valid JSON")
    case("model-syntax", "quote.json", text.replace('"auto"', '"auto'), "no valid JSON")
    case("model-syntax", "nan.json", text.replace("50.0", "NaN"), "no valid JSON")
    for key in ("modes", "responses", "frf_kind", "band_hz", "residual_terms", "quality"):
        case("model-missing", f"{key}.json", changed(lambda m: m.pop(key)), "missing field", field=key)
    case("model-missing", "version.json", changed(lambda m: m.pop("version")), "missing field", field="version")
    for name, change in (
        ("shape-short", lambda m: m["modes"][0]["shape"].update(re=[1.0], im=[0.0])),
        ("shape-parts", lambda m: m["modes"][0]["shape"].update(im=[0.0])),
        ("participation", lambda m: m["modes"][0]["participation"].update(re=[0.2, 0.1], im=[0.0, 0.0])),
        ("shape-std", lambda m: m["modes"][0].update(shape_std=[0.1])),
        ("term", lambda m: m["residual_terms"].update(terms=[{"power": 0, "re": [[1.0]], "im": [[0.0]]}])),
        ("term-ragged", lambda m: m["residual_terms"].update(terms=[{"power": 0, "re": [[1.0], []], "im": [[0.0], [0.0]]}])),
        ("response-twice", lambda m: m.update(responses=["1:+Z", "1:+Z"])),
        ("node-twice", lambda m: m["nodes"].append(m["nodes"][0])),
    ):
        case("model-sizes", name + ".json", changed(change), "")
    for name, change in (
        ("frequency-text", lambda m: m["modes"][0].update(frequency_hz="fifty")),
        ("kind", lambda m: m.update(frf_kind="speed")),
        ("trust", lambda m: m["modes"][0].update(trust="perhaps")),
        ("dof", lambda m: m.update(references=["101:Q"])),
        ("huge", lambda m: m["modes"][0].update(frequency_hz=1e400)),
        ("negative-label", lambda m: m["nodes"][0].update(label=-1)),
    ):
        case("model-values", name + ".json", changed(change).replace("Infinity", "1e400"), "")
    case("model-format", "other.json", changed(lambda m: m.update(format="other.model")), "JSON of unknown format", found="other.model")
    case("model-format", "none.json", changed(lambda m: m.pop("format")), "JSON of unknown format")
    case("model-format", "version.json", changed(lambda m: m.update(version=99)), "another version", found="99")
    nested = '{"format": "chladni.model", "version": 1, "options": ' + '{"a": ' * 400 + "1" + "}" * 400 + "}"
    case("model-nested", "objects.json", nested, "")
    weights = {"format": "chladni.weights", "version": 1, "frequency_hz": 300.0, "weights": [{"reference": "101:+Z"}]}
    for name, text in (("missing", json.dumps({k: v for k, v in weights.items() if k != "weights"})), ("cut", json.dumps(weights)[:-12]), ("type", json.dumps({**weights, "frequency_hz": "300"}))):
        case("weights", name + ".json", text, "", command="info")


# ---------------------------------------------------------------------------------------------------------------- TOML
def inputs(folder, command, named):
    """One case for each (name, text) of a command's input."""
    for name, text in named:
        case(folder, name + ".toml", text, "", command=command)


def scenes():
    good = "frequency_hz = 50.0\n[zones]\ngrid = [2, 1]\nhot = [1]\ncells_m = [0.0, 0.0, 0.1, 0.1]\n"
    named = (
        ("no-frequency", good.replace("frequency_hz = 50.0\n", "")),
        ("frequency-text", good.replace("50.0", '"fast"')),
        ("frequency-negative", good.replace("50.0", "-50.0")),
        ("frequency-nan", good.replace("50.0", "nan")),
        ("unknown-key", good.replace("hot =", "hott =")),
        ("hot-out-of-grid", good.replace("hot = [1]", "hot = [7]")),
        ("hot-zero", good.replace("hot = [1]", "hot = [0]")),
        ("grid-empty", good.replace("grid = [2, 1]", "grid = [0, 1]")),
        ("grid-huge", good.replace("grid = [2, 1]", "grid = [999999999, 999999999]")),
        ("area-turned", good + "area_m = [0.2, 0.0, 0.1, 0.1]\n"),
        ("syntax", good.replace("[zones]", "[zones")),
        ("profile", good + '[threshold]\nprofile = "loud"\n'),
        ("force", good + "[actuators]\nmax_force_n = -1.0\n"),
        ("not-text", "\x00\x01\x02"),
    )
    inputs("scene", "render", named)
    panel = "[plate]\nlength_m = 0.2\n[responses]\ngrid = [2, 2]\n[references]\nedge_count = [1, 1]\n[frf]\nstart_hz = 10.0\nstop_hz = 20.0\nstep_hz = 1.0\n"
    named = (
        ("length-negative", panel.replace("length_m = 0.2", "length_m = -0.2")),
        ("length-nan", panel.replace("length_m = 0.2", "length_m = nan")),
        ("unknown-key", panel.replace("length_m", "lenght_m")),
        ("poisson", panel.replace("length_m = 0.2", "poisson_ratio = 0.9")),
        ("edges", panel.replace("length_m = 0.2", 'edges = "FFXF"')),
        ("grid-huge", panel.replace("grid = [2, 2]", "grid = [999999, 999999]")),
        ("step-zero", panel.replace("step_hz = 1.0", "step_hz = 0.0")),
        ("step-tiny", panel.replace("step_hz = 1.0", "step_hz = 1e-12")),
        ("band-turned", panel.replace("stop_hz = 20.0", "stop_hz = 5.0")),
        ("kind", panel + 'kind = "speed"\n'),
        ("syntax", panel.replace("[frf]", "[frf")),
    )
    inputs("panel", "simulate", named)
    named = (
        ("unknown-key", "dropp = [1]\n"),
        ("both", "drop = [1]\nkeep = [2]\n"),
        ("out-of-range", "drop = [99]\n"),
        ("zero", "drop = [0]\n"),
        ("text", 'drop = ["first"]\n'),
        ("near-nothing", "[[mode]]\nnear_hz = 500.0\nwithin_hz = 0.5\n"),
    )
    inputs("selection", "select", named)


def strangers():
    case("not-a-format", "empty.uff", b"", "empty")
    case("not-a-format", "zip.zip", b"PK\x03\x04" + bytes(26) + b"xl/workbook.xml", "not a format")
    case("not-a-format", "binary.svd", bytes(range(256)), "not a format")
    case("not-a-format", "zeros.bin", bytes(64), "not a format")


def hdf5():
    try:
        import h5py
        import numpy as np
    except ImportError:
        print("h5py is not installed: the HDF5 cases are left as they are")
        known = json.loads((ROOT / "cases.json").read_text()) if (ROOT / "cases.json").exists() else []
        CASES.extend(old for old in known if old["file"].startswith("h5"))
        return
    def file(fill):
        out = io.BytesIO()
        with h5py.File(out, "w", libver="earliest", track_order=False) as h5:
            fill(h5)
        return out.getvalue()
    axis, values = np.arange(1.0, 9.0), np.arange(8) * (1 + 0.5j)
    dof = np.array([(1, 3)], dtype=[("node", "<u8"), ("dir", "i1")])
    def own(h5, **without):
        h5.attrs.update(format="chladni", version=1, frf_kind="mobility", time_sign="+")
        for name, array in dict(freq=axis, frf=values.reshape(1, 1, 8), response=dof, reference=dof).items():
            if name not in without:
                h5.create_dataset(name, data=without.get("set", {}).get(name, array), track_times=False)
    good = file(own)
    for k, cut in enumerate((1, 100, len(good) // 2, len(good) - 600)):
        case("h5-cut", f"{k}.h5", good[:-cut], "")
    # keys of the index of chunks (stored bytes, filters left out, place along each axis and within the element) with the address of each between
    def packed(h5):
        own(h5, frf=None)
        h5.create_dataset("frf", data=values.reshape(1, 1, 8), chunks=(1, 1, 4), compression="gzip", track_times=False)
    whole = bytearray(file(packed))
    first = whole.index(struct.pack("<IQQQQ", 0, 0, 0, 4, 0)) - 4 - (40 + 8)
    whole[first:first + 4] = struct.pack("<I", 0xFFFF_FFF0)
    case("h5-cut", "chunk.h5", bytes(whole), "a piece of the dataset ends beyond the file", found="4294967280 bytes")
    for name in ("freq", "frf", "response", "reference"):
        if name != "frf":
            case("h5-missing", f"{name}.h5", file(lambda h5: own(h5, **{name: None})), "a dataset is missing", field=name)
    def with_attr(**attrs):
        def fill(h5):
            own(h5)
            h5.attrs.update(attrs)
        return file(fill)
    case("h5-attributes", "version.h5", with_attr(version=7), "another version", found="7")
    case("h5-attributes", "kind.h5", with_attr(frf_kind="speed"), "", field="frf_kind")
    case("h5-attributes", "time-sign.h5", with_attr(time_sign="x"), "", field="time_sign")
    case("h5-attributes", "reference-unit.h5", with_attr(reference_unit="kg"), "unknown unit", found="kg")
    for name, arrays in (
        ("axis-short", dict(freq=axis[:7])),
        ("axis-falls", dict(freq=axis[::-1])),
        ("axis-nan", dict(freq=np.where(axis == 3, np.nan, axis))),
        ("responses", dict(response=np.repeat(dof, 2))),
        ("rank", dict(frf=values)),
        ("real", dict(frf=values.real.reshape(1, 1, 8))),
        ("dofs", dict(response=np.array([1.5]))),
    ):
        case("h5-sizes", name + ".h5", file(lambda h5: own(h5, set=arrays)), "")
    endless = np.zeros((2**44, 0, 8), dtype=complex)
    case("h5-sizes", "endless.h5", file(lambda h5: own(h5, set=dict(frf=endless))), "claims more values than the file can hold")
    def foreign(h5):
        h5["frf"], h5["freq"] = endless, axis
    case("h5-sizes", "endless-foreign.h5", file(foreign), "claims more values than the file can hold")
    # bits of a whole number that no register counts
    node = bytes([0x10, 0, 0, 0, 8, 0, 0, 0, 0, 0, 64, 0])
    wide = file(own).replace(node, bytes([0x10, 0, 0, 0, 8, 0, 0, 0x54, 0, 0, 64, 0]), 1)
    case("h5-sizes", "wide-number.h5", wide, "values of a type that cannot be read")
    def two(h5):
        h5["a"], h5["b"], h5["freq"] = values, values, axis
    case("h5-choice", "two-frfs.h5", file(two), "not clear which datasets")
    def square(h5):
        h5["frf"], h5["freq"] = np.ones((8, 8)) * (1 + 1j), axis
    case("h5-choice", "square.h5", file(square), "axes are as long as")


# What is said about files that are listed without a message above.
MESSAGES = {
    '`12:Q` is no DOF': ['csv-remark/reference-12Q.csv'],
    '`FFXF` names no four edges': ['panel/edges.toml'],
    '`here` is no DOF': ['csv-remark/response-here.csv'],
    '`speed` is no FRF kind': ['csv-remark/frf_kind-speed.csv', 'h5-attributes/kind.h5'],
    '`x` is no time sign': ['csv-remark/time_sign-x.csv', 'h5-attributes/time-sign.h5'],
    'a DOF occurs twice': ['model-sizes/response-twice.json'],
    'a node occurs twice': ['model-sizes/node-twice.json'],
    'a row of another length': ['csv-long/short-row.csv', 'csv-row-length/cut.csv'],
    'a selection either keeps or drops': ['selection/both.toml'],
    'a unit factor must be positive': ['uff-units/negative.uff', 'uff-units/zero.uff'],
    'a whole number must stand here': ['uff-axis-record/quantity-fraction.uff', 'uff-record-6/node-fraction.uff'],
    'an empty rectangle': ['scene/area-turned.toml'],
    'begins like JSON: no valid JSON': ['model-cut/0.json', 'model-cut/1.json', 'model-cut/2.json', 'model-cut/3.json', 'model-cut/4.json', 'weights/cut.json'],
    'complex numbers in Python notation, without a frequency axis': ['csv-complex-list/python-many.txt', 'csv-complex-list/python.txt'],
    'missing': ['scene/no-frequency.toml'],
    'model: `101:Q` is no DOF; write node and direction like 12:+Z': ['model-values/dof.json'],
    'model: invalid type': ['model-values/frequency-text.json'],
    'model: invalid value': ['model-values/negative-label.json'],
    'model: no valid JSON': ['model-nested/objects.json', 'model-values/huge.json'],
    'model: re and im must be rectangular and of one size': ['model-sizes/term-ragged.json'],
    'model: re has 2 entries and im 1': ['model-sizes/shape-parts.json'],
    'model: unknown variant `perhaps`': ['model-values/trust.json'],
    'model: unknown variant `speed`': ['model-values/kind.json'],
    'more columns than names; do the numbers have a decimal comma?': ['csv-decimal-comma/three.csv', 'csv-decimal-comma/unquoted.csv'],
    'must be greater than zero': ['scene/force.toml', 'scene/frequency-negative.toml'],
    'neither a threshold profile nor a file': ['scene/profile.toml'],
    "no isotropic material has this Poisson's ratio": ['panel/poisson.toml'],
    'no mode there': ['selection/near-nothing.toml'],
    'no such cell': ['scene/hot-out-of-grid.toml', 'scene/hot-zero.toml'],
    'no such degree of freedom': ['uff-record-6/direction-9.uff', 'uff-record-6/direction-minus-7.uff', 'uff-record-6/node-negative.uff'],
    'no such mode': ['selection/out-of-range.toml'],
    'not a count': ['scene/grid-empty.toml', 'selection/zero.toml'],
    'not a degree of freedom': ['csv-long/direction-9.csv', 'csv-long/node-negative.csv', 'csv-long/node-text.csv'],
    'not a finite number': ['csv-long/frequency-text.csv', 'csv-long/value-text.csv'],
    'not a number that can be used': ['scene/frequency-nan.toml', 'scene/frequency-text.toml'],
    'not a usable value': ['panel/length-nan.toml', 'panel/length-negative.toml', 'panel/step-zero.toml'],
    'not a whole number': ['selection/text.toml'],
    'sizes disagree': ['h5-sizes/axis-short.h5', 'h5-sizes/responses.h5'],
    'text instead of a number': ['uff-axis-record/quantity-text.uff', 'uff-record-6/node-text.uff', 'uff-record-6/type-text.uff', 'uff-units/text.uff'],
    'the HDF5 library cannot read this': ['h5-cut/0.h5', 'h5-cut/1.h5', 'h5-cut/2.h5', 'h5-cut/3.h5'],
    'the array claims more values than are there': ['mat-dimensions/absurd.mat', 'mat-dimensions/huge.mat'],
    'the count of values does not fit the dimensions': ['mat-dimensions/fewer.mat', 'mat-dimensions/more.mat'],
    'the file ends inside an element': ['mat-cut/0.mat', 'mat-cut/1.mat', 'mat-cut/2.mat', 'mat-cut/3.mat', 'mat-cut/4.mat'],
    'the frequency axis ends before it starts': ['panel/band-turned.toml'],
    'the frequency axis falls': ['csv-long/frequency-negative.csv'],
    'the frequency axis must be finite, not negative and strictly rising': ['h5-sizes/axis-falls.h5', 'h5-sizes/axis-nan.h5'],
    'the number did not fit its field when the file was written': ['uff-units/stars.uff'],
    'the points do not fit on the plate': ['panel/grid-huge.toml'],
    'the sound file is damaged': ['wav/bits.wav', 'wav/channels.wav', 'wav/cut.wav'],
    'this is no TOML: key with no value': ['scene/not-text.toml'],
    'this is no TOML: unclosed table': ['panel/syntax.toml', 'scene/syntax.toml'],
    'this panel needs more memory than is allowed': ['panel/step-tiny.toml'],
    'too many cells': ['scene/grid-huge.toml'],
    'unknown key': ['panel/unknown-key.toml', 'scene/unknown-key.toml', 'selection/unknown-key.toml'],
    'unknown unit of the reference': ['csv-remark/reference_unit-kg.csv'],
    'unknown variant `speed`': ['panel/kind.toml'],
    'values of a type that cannot be read': ['npy-type/pickle.npy'],
    'values of the wrong type': ['h5-sizes/dofs.h5', 'h5-sizes/rank.h5', 'h5-sizes/real.h5'],
    'weights: invalid type': ['weights/type.json'],
    'weights: missing field `weights`': ['weights/missing.json'],
    'wrong size': ['model-sizes/participation.json', 'model-sizes/shape-short.json', 'model-sizes/shape-std.json', 'model-sizes/term.json'],
}


def main():
    for folder in ROOT.iterdir() if ROOT.exists() else ():
        if folder.is_dir() and not folder.name.startswith("h5"):
            shutil.rmtree(folder)
    for part in (universal_text, universal_geometry, universal_shapes, universal_binary, tables, matlab, numpy_files, sounds, models, scenes, strangers, hdf5):
        part()
    said = {file: message for message, files in MESSAGES.items() for file in files}
    for entry in CASES:
        entry["message"] = entry["message"] or said[entry["file"]]
    CASES.sort(key=lambda entry: entry["file"])
    lines = ",\n".join(json.dumps(entry, sort_keys=True) for entry in CASES)
    (ROOT / "cases.json").write_text(f"[\n{lines}\n]\n")
    folders = {entry["file"].split("/")[0] for entry in CASES}
    print(f"{len(CASES)} files in {len(folders)} classes")


if __name__ == "__main__":
    main()
