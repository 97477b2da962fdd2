#!/usr/bin/env python3
"""Checks that other programs read what chladni writes, and chladni what they write.

Needs numpy, h5py, pyuff and scipy. Usage: scripts/check_interop.py [path of the binary; default target/release/chladni]

* binary universal files (pyuff), HDF5 (h5py) and NPZ (numpy): bit-equal
* text universal files: to the printed digit
* mode shapes (55, 2414), nodes (15, 2411), trace lines (82), elements (2412): to the printed digit
* drive signals (scipy, numpy): rate, channels and values of f32, i24 and i16 against the table in newtons
* files written by pyuff, h5py, scipy and numpy: read bit-equal
* random sets, written by Python and handed on through all formats: bit-equal
* speed: text 58 against pyuff, 58b against its raw bytes, in processor time
"""
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np
import pyuff
import scipy.io
import scipy.io.wavfile

BINARY = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "target/release/chladni").resolve()
FAILED = []


def chladni(*arguments):
    done = subprocess.run([BINARY, *map(str, arguments), "--force", "-q"], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"chladni {' '.join(map(str, arguments))}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def check(what, good):
    print(("ok    " if good else "WRONG ") + what)
    if not good:
        FAILED.append(what)


def pairs(datasets):
    """FRFs by (response node, reference node)."""
    return {(one["rsp_node"], one["ref_node"]): one for one in datasets if one["type"] == 58 and one["func_type"] == 4}


def sets(path):
    read = pyuff.UFF(str(path)).read_sets()
    return read if isinstance(read, list) else [read]


def data(seed=1, responses=3, references=2, lines=64):
    random = np.random.default_rng(seed)
    frf = random.normal(size=(responses, references, lines)) + 1j * random.normal(size=(responses, references, lines))
    # every exponent that a text field can print with two digits
    frf *= 10.0 ** random.integers(-90, 90, size=frf.shape)
    return frf, 1.0 + 0.3125 * np.arange(lines)


def written_files(folder):
    frf, freq = data()
    source = folder / "source.npz"
    np.savez(source, frf=frf, freq=freq, unit="m/s/N", response=["1:+Z", "2:-X", "3:+RY"], reference=["101:+Z", "102:+Z"])
    nodes = [1, 2, 3]
    for extension in ("h5", "npz", "uff", "unv"):
        chladni("convert", source, "-o", folder / f"out.{extension}")
    with h5py.File(folder / "out.h5") as h5:
        check("h5py: complex128", h5["frf"].dtype == np.complex128)
        check("h5py: FRFs bit-equal", np.array_equal(h5["frf"][()], frf))
        check("h5py: axis bit-equal", np.array_equal(h5["freq"][()], freq))
        check("h5py: DOFs", list(h5["response"]["node"]) == nodes and list(h5["response"]["dir"]) == [3, -1, 5])
    with np.load(folder / "out.npz") as npz:
        check("numpy: FRFs and axis bit-equal", np.array_equal(npz["frf"], frf) and np.array_equal(npz["freq"], freq))
        check("numpy: DOFs", list(npz["response"]) == ["1:+Z", "2:-X", "3:+RY"])
    for extension, name in (("uff", "binary 58"), ("unv", "text 58")):
        read = pairs(sets(folder / f"out.{extension}"))
        check(f"pyuff: {name}, all pairs", len(read) == 6)
        exact = digits = axis = True
        for (response, reference), one in read.items():
            truth = frf[nodes.index(response), reference - 101]
            exact &= np.array_equal(one["data"], truth)
            # 13 digits are printed
            digits &= bool(np.all(np.abs(one["data"].real - truth.real) <= 5.1e-13 * np.abs(truth.real)))
            digits &= bool(np.all(np.abs(one["data"].imag - truth.imag) <= 5.1e-13 * np.abs(truth.imag)))
            axis &= bool(np.allclose(one["x"], freq, rtol=1e-5))
            axis &= one["ordinate_spec_data_type"] == 11 and one["orddenom_spec_data_type"] == 13
        check(f"pyuff: {name}, values " + ("bit-equal" if extension == "uff" else "to the printed digit"), exact if extension == "uff" else digits)
        check(f"pyuff: {name}, axis and quantity codes", axis)


def shapes(folder):
    (folder / "panel.toml").write_text("[responses]\ngrid = [4, 3]\nspacing_m = 0.05\n[references]\nedge_count = [1, 1]\n[frf]\nstart_hz = 20.0\nstop_hz = 200.0\n")
    chladni("simulate", folder / "panel.toml", "-o", folder / "panel.h5", "--truth", folder / "truth.json")
    model = json.loads((folder / "truth.json").read_text())
    modes = [mode for mode in model["modes"] if mode["in_band"]]
    chladni("convert", folder / "truth.json", "-o", folder / "shapes.uf")
    chladni("convert", folder / "truth.json", "-o", folder / "shapes.unv")
    for extension, number in (("uf", 55), ("unv", 2414)):
        datasets = sets(folder / f"shapes.{extension}")
        read = [one for one in datasets if one["type"] == number]
        check(f"pyuff: one {number} per mode", len(read) == len(modes))
        good = True
        for one, mode in zip(read, modes):
            truth = np.array(mode["shape"]["re"])
            z = np.asarray(one["r3"]).ravel() if number == 55 else np.array([node[2] for node in one["data_at_node"]])
            good &= bool(np.allclose(z, truth, rtol=1e-5, atol=1e-30))
            frequency = one["freq"] if number == 55 else one["record12_field2"]
            good &= abs(frequency - mode["frequency_hz"]) <= 1e-5 * mode["frequency_hz"]
        check(f"pyuff: {number}, shapes and frequencies to the printed digit", good)
        kind = 15 if extension == "uf" else 2411
        nodes = next(one for one in datasets if one["type"] == kind)
        xyz = np.array([node["xyz_m"] for node in model["nodes"]])
        read_xyz = np.column_stack([np.asarray(nodes[axis]) for axis in "xyz"])
        check(f"pyuff: {kind}, positions", bool(np.allclose(read_xyz, xyz, rtol=1e-5 if kind == 15 else 0, atol=0 if kind == 15 else 1e-15)))


def foreign_files(folder):
    frf, freq = data(2, references=1)
    node = dict(type=2411, node_nums=[1, 2, 3], def_cs=[0] * 3, disp_cs=[0] * 3, color=[1] * 3, x=[0.1, 0.2, 0.3], y=[0.0] * 3, z=[0.0] * 3)
    for binary in (0, 1):
        path = folder / f"pyuff-{binary}.uff"
        path.unlink(missing_ok=True)
        file = pyuff.UFF(str(path))
        file.write_sets(dict(type=151, model_name="m", description="d", db_app="a", date_db_created="", time_db_created="", version_db1=0, version_db2=0, file_type=0, date_db_saved="", time_db_saved="", program="p", date_file_written="", time_file_written=""), "overwrite")
        file.write_sets(dict(type=164, units_code=1, units_description="SI", temp_mode=1, length=1.0, force=1.0, temp=1.0, temp_offset=0.0), "add")
        file.write_sets(node, "add")
        for k in range(3):
            one = dict(type=58, func_type=4, func_id=1, ver_num=0, load_case_id=0, z_axis_value=0, binary=binary, ord_data_type=6, num_pts=freq.size)
            one |= dict(rsp_ent_name="NONE", rsp_node=k + 1, rsp_dir=3, ref_ent_name="NONE", ref_node=101, ref_dir=3)
            one |= dict(abscissa_spacing=1, abscissa_min=freq[0], abscissa_inc=0.3125, data=frf[k, 0], x=freq)
            one |= {f"id{line}": "NONE" for line in range(1, 6)}
            for axis, code in dict(abscissa=18, ordinate=11, orddenom=13, z_axis=0).items():
                one |= {f"{axis}_spec_data_type": code, f"{axis}_axis_lab": "NONE", f"{axis}_axis_units_lab": "NONE"}
                one |= {f"{axis}_{kind}_unit_exp": 0 for kind in ("len", "force", "temp")}
            file.write_sets(one, "add")
        chladni("convert", path, "-o", folder / "back.h5")
        with h5py.File(folder / "back.h5") as h5:
            got = h5["frf"][()]
        # pyuff prints text with 11 digits
        good = np.array_equal(got, frf) if binary else np.allclose(got, frf, rtol=1e-10, atol=0)
        check(f"pyuff wrote {'58b' if binary else '58'}: " + ("bit-equal" if binary else "to the printed digit"), bool(good))
    with h5py.File(folder / "h5py.h5", "w", libver="earliest") as h5:
        h5.create_dataset("data/H", data=frf, compression="gzip", shuffle=True)
        h5["data/freq"] = freq
    scipy.io.savemat(folder / "v5.mat", dict(frf=frf, f=freq))
    scipy.io.savemat(folder / "v7.mat", dict(s=dict(frf=frf, f=freq)), do_compression=True)
    np.savez_compressed(folder / "packed.npz", frf=np.asfortranarray(frf), freq=freq)
    for name in ("h5py.h5", "v5.mat", "v7.mat", "packed.npz"):
        chladni("convert", folder / name, "-o", folder / "back.npz")
        with np.load(folder / "back.npz") as npz:
            check(f"{name}: bit-equal", np.array_equal(npz["frf"], frf) and np.array_equal(npz["freq"], freq))


def random_sets(folder, count=20):
    """Sets of any size, precision and order of axes, from every writer of Python and back through every writer of ours."""
    random = np.random.default_rng(5)
    bad = []
    for number in range(count):
        responses, references, lines = random.integers(1, 5), random.integers(1, 4), random.integers(5, 9)
        frf = random.normal(size=(responses, references, lines)) + 1j * random.normal(size=(responses, references, lines))
        frf = (frf * 10.0 ** random.integers(-30, 30)).astype(random.choice(["<c16", "<c8", ">c16"]))
        freq = np.cumsum(random.integers(1, 999, lines)) / 64
        axes = random.permutation(3)
        names = "-".join(np.array(["response", "reference", "line"])[axes])
        stored = frf.transpose(axes)
        path = folder / ["random.npz", "random.mat", "random.h5"][number % 3]
        if path.suffix == ".npz":
            np.savez(path, frf=random.choice([np.asfortranarray, np.ascontiguousarray])(stored), freq=freq)
        elif path.suffix == ".mat":
            scipy.io.savemat(path, dict(frf=stored, freq=freq), do_compression=bool(random.integers(2)))
        else:
            with h5py.File(path, "w") as h5:
                h5.create_dataset("frf", data=stored, chunks=bool(random.integers(2)) or None)
                h5["freq"] = freq
        place = "" if path.suffix == ".npz" else "/"
        chladni("convert", path, "--map", f"frf={place}frf,freq={place}freq,axes={names}", "--frf-kind", "mobility", "-o", folder / "first.h5")
        source = folder / "first.h5"
        for extension in random.permutation(["npz", "mat", "csv", "uff", "h5"]):
            target = folder / f"chain-{number}.{extension}"
            chladni("convert", source, "--frf-kind", "mobility", "-o", target)
            source = target
        chladni("convert", source, "--frf-kind", "mobility", "-o", folder / "last.npz")
        with np.load(folder / "last.npz") as npz:
            # text has the digits of single precision
            same = npz["frf"].shape == frf.shape and np.array_equal(npz["frf"].astype(frf.dtype), frf) and np.allclose(npz["freq"], freq, rtol=1e-12, atol=0)
        if not same:
            bad.append(f"{number} ({path.suffix}, {names})")
    check(f"{count} random sets of numpy, scipy and h5py through npz, mat, csv, uff and h5: bit-equal" + "".join(f"; not {one}" for one in bad), not bad)


SCENE = """frequency_hz = 330.0
[zones]
grid = [2, 2]
hot = [1]
cells_m = [0.0, 0.0, 0.268, 0.170]
[time]
[[time.burst]]
duration_s = 0.1
ramp_s = 0.015
"""


def signals(folder):
    (folder / "panel.toml").write_text("[frf]\nstart_hz = 2\nstop_hz = 1000\nstep_hz = 99.8\n")
    (folder / "burst.toml").write_text(SCENE)
    chladni("simulate", folder / "panel.toml", "-o", folder / "few.h5", "--truth", folder / "truth.json")
    play = ("play", folder / "truth.json", folder / "burst.toml", "--method", "fast", "--rate", 44100)
    chladni(*play, "-o", folder / "drive.csv")
    chladni(*play, "-o", folder / "drive.npz")
    drive = np.loadtxt(folder / "drive.csv", delimiter=",", skiprows=1)[:, 1:]
    held = np.load(folder / "drive.npz")
    check("a drive in NPZ has rate, names and values of the table", held["rate_hz"] == 44100 and held["reference"][0] == "101:+Z" and np.array_equal(held["drive"], drive))
    for form, dtype, steps in (("f32", np.float32, 2.0**24), ("i24", np.int32, 2.0**23), ("i16", np.int16, 2.0**15)):
        chladni(*play, "-o", folder / "drive.wav", "--format", form)
        rate, samples = scipy.io.wavfile.read(folder / "drive.wav")
        sidecar = json.loads((folder / "drive.json").read_text())
        check(f"a drive in {form} has the stated rate, channels, frames and kind", rate == sidecar["rate_hz"] == 44100 and samples.shape == drive.shape == (sidecar["frames"], 34) and samples.dtype == dtype)
        # 24-bit samples lie in the upper bytes of 32-bit ones
        whole = {"f32": 1.0, "i24": 2.0**31, "i16": 2.0**15}[form]
        scale = np.array([channel["full_scale"] for channel in sidecar["channels"]])
        error = np.abs(samples / whole * scale - drive).max() / scale.max()
        check(f"its values are those of the table to half a step ({error * steps:.2f} steps)", error * steps <= 0.51)


def speed(folder):
    random = np.random.default_rng(3)
    frf, freq = random.normal(size=(40, 2, 3200)) * (1 - 0.5j), 1.0 + 0.3125 * np.arange(3200)
    np.savez(folder / "large.npz", frf=frf, freq=freq, unit="m/s/N")
    for extension in ("unv", "uff"):
        chladni("convert", folder / "large.npz", "-o", folder / f"large.{extension}")
    # processor time, the least of several runs: a busy machine changes it least
    def least(work, spent):
        times = [spent()]
        for _ in range(5):
            work()
            times.append(spent())
        return np.diff(times).min()

    def of_children():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    theirs = least(lambda: sets(folder / "large.unv"), time.process_time)
    whole = least(lambda: chladni("info", folder / "large.unv"), of_children)
    size = (folder / "large.unv").stat().st_size / 1e6
    print(f"      text 58, {size:.1f} MB: pyuff {theirs:.3f} s of processor time; `chladni info`, checksum and checks included, {whole:.3f} s, ratio {theirs / whole:.1f}")
    reader = BINARY.parent / "examples" / "reading_time"
    if not reader.exists():
        print("      reading alone was not timed: cargo build --release -p chladni-io --example reading_time")
        return
    done = subprocess.run([reader, folder / "large.unv", folder / "large.uff"], capture_output=True, text=True, check=True)
    (text, _), (binary, raw) = (map(float, line.split()[:2]) for line in done.stdout.splitlines())
    print(f"      reading alone: text {text:.4f} s, ratio {theirs / text:.1f}; 58b {binary:.4f} s, its raw bytes {raw:.4f} s, ratio {binary / raw:.2f}")
    check("text 58 is read at least ten times as fast as by pyuff", theirs >= 10 * text)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for part in (written_files, shapes, foreign_files, random_sets, signals, speed):
            part(folder)
    if FAILED:
        raise SystemExit(f"{len(FAILED)} wrong")
    print("all is read as it was written")


if __name__ == "__main__":
    main()
