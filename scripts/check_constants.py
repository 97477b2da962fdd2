#!/usr/bin/env python3
"""Finds numeric constants that stand outside the tables of constants.

A constant that decides something (a threshold, a tolerance, a limit, a number of steps)
stands in the table of its room: `limits.rs`, `tolerances.rs` (with its folder) or, for
pictures, `sizes.rs`. Beside the code stand only what FACTS names (codes of a format, laws
of nature, random streams, the look of one picture), public constants, which the
documentation shows, and constants of tests.

A table `limits.rs` has headings: comments that name files beside it. A constant under one
is used by one of these files.

    scripts/check_constants.py            # lists them; exit code 1 where there are any
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLES = {"limits.rs", "tolerances.rs", "sizes.rs"}
CONSTANT = re.compile(
    r"^ *(pub(?:\(\w+\))? )?const ([A-Z][A-Z0-9_]*): "
    r"(?:f64|f32|usize|u64|u32|u16|i32|Duration|\[(?:f64|usize|u32|i32);|\((?:f64|usize)|(?:std::ops::)?Range<)"
)
TABLED = re.compile(r"pub(?:\([^)]*\))? const ([A-Z][A-Z0-9_]*):")
# `path:NAME` below crates/, or its beginning, and why such constants stand beside the code
FACTS = {
    "chladni-io/src/uff/": "codes, columns and fields of universal files",
    "chladni-io/src/mat/": "codes of MAT files",
    "chladni-io/src/hdf5/": "reading in stretches, measured there",
    "chladni-io/src/numpy/npy.rs": "header of NPY files",
    "chladni-io/src/document.rs": "codes of dataset 58",
    "chladni-io/src/runs.rs": "codes of dataset 58",
    "chladni-io/src/assemble/mod.rs": "codes of dataset 58",
    "chladni-io/src/assemble/record.rs": "columns of dataset 58",
    "chladni-io/src/model_file.rs": "version of a format",
    "chladni-io/src/model_shapes.rs": "components of a node",
    "chladni-io/src/shape.rs": "components of a node",
    "chladni-io/src/unit_label/": "units",
    "chladni-io/src/wav.rs": "codes of sound files",
    "chladni-io/src/bulk.rs": "reading in stretches, measured there",
    "chladni-cli/src/streaming/resume.rs": "version of a format",
    "chladni-plate/src/synthetic.rs": "random streams",
    "chladni-plate/src/time.rs": "random streams",
    "chladni-plate/src/noise.rs": "random streams",
    "chladni-report/src/figures/": "the look of one picture",
    "chladni-report/src/chart/": "the look of charts",
    "chladni-report/src/drawing/": "formats of pictures",
    "chladni-report/src/page/": "the list of modules; vision of colours",
    "chladni-report/src/data/": "codes that the page reads",
    "chladni-rfp/src/data/window/kernel.rs": "coefficients of window functions",
    "chladni-rfp/src/damping/basis.rs:RESIDUAL_POWERS": "powers of a law",
    "chladni-signal/src/local_basis.rs:TERMS": "follows from the degree",
    "chladni-render/src/time/envelope.rs:SIGNED": "coefficients of a difference",
    "chladni-render/src/scene/threshold.rs": "standard gravity",
    "chladni-render/src/time/wav_file.rs": "header of sound files",
}


def is_fact(constant):
    """True where `path:NAME` may stand beside its code."""
    return any(constant.startswith(fact) for fact in FACTS)


def outside(path):
    """(line, name) of every constant of a file that should stand in a table."""
    relative = path.relative_to(ROOT / "crates").as_posix()
    if path.name in TABLES or "/tolerances/" in relative or "tests" in relative:
        return
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith(("#[cfg(test)]", "mod tests")):
            return
        found = CONSTANT.match(line)
        if found and found[1] != "pub " and not is_fact(f"{relative}:{found[2]}"):
            yield number, found[2]


def misplaced(table):
    """(line, name) of every constant of a table that no file of its heading uses."""
    files = []
    for number, line in enumerate(table.read_text().splitlines(), 1):
        if line.startswith("// "):
            files = [table.parent / name for name in re.findall(r"[\w/]+\.rs", line)]
        found = TABLED.match(line)
        if found and files:
            word = re.compile(rf"\b{found[1]}\b")
            if not any(file.exists() and word.search(file.read_text()) for file in files):
                yield number, found[1]


def listed(paths, find, words):
    """Number of the constants that `find` names in these files; prints them."""
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {name}"
        for path in sorted(paths)
        for number, name in find(path)
    ]
    print("\n".join([*wrong, f"{len(wrong)} constants {words}"]))
    return len(wrong)


def main():
    crates = ROOT / "crates"
    wrong = listed(crates.glob("*/src/**/*.rs"), outside, "stand outside the tables")
    tables = crates.glob("*/src/**/limits.rs")
    wrong += listed(tables, misplaced, "stand under the heading of another file")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
