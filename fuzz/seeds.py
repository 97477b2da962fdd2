#!/usr/bin/env python3
"""Seeds of the targets that coverage guides, into fuzz/corpus: small sound files of each format, and the damaged ones of fixtures/malformed.

Needs the binary; sound files of other programs need numpy, scipy and h5py and are left out without them. Usage: fuzz/seeds.py [path of the binary; default target/release/chladni]
"""
import io
import pathlib
import subprocess
import sys
import tempfile
import wave

ROOT = pathlib.Path(__file__).resolve().parent.parent
BINARY = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/chladni").resolve()
# what a target begins with: folders of fixtures/malformed, and extensions of sound files
SEEDS = {
    "uff_text": (["uff-*"], [".unv", ".uf"]),
    "uff_binary": (["58b-*"], [".uff"]),
    "csv": (["csv-*"], [".csv"]),
    "hdf5": (["h5-*"], [".h5"]),
    "mat": (["mat-*"], [".mat"]),
    "numpy": (["npy-*", "npz-*"], [".npz"]),
    "wav": (["wav"], [".wav"]),
    "model_json": (["model-*", "base"], []),
    "weights_json": (["weights"], [".weights.json"]),
    "toml_inputs": (["scene", "panel", "selection"], [".toml"]),
    "model_render": (["model-*", "base"], []),
    "scene_threshold": (["scene"], [".pair"]),
}
# chunks of HDF5 take room
LARGEST = {"hdf5": 16384}


def convert(source, target, *flags):
    subprocess.run([BINARY, "convert", source, "-q", "-o", target, *flags], check=True)


def sound_files(folder):
    table = folder / "frf.csv"
    rows = [f"{k}.5,0.{k},-0.2{k},{k}.25e-3,0.{k}" for k in range(1, 7)]
    table.write_text("\n".join(["f,1:+Z re,1:+Z im,2:+Z re,2:+Z im", *rows]) + "\n")
    convert(table, folder / "frf.h5", "--reference", "101", "--frf-kind", "mobility")
    for name in ["frf.uff", "frf.unv", "frf.uf", "frf.npz", "again.csv"]:
        convert(folder / "frf.h5", folder / name)
    model = ROOT / "fixtures/malformed/base/model.json"
    for name in ["model.h5", "model.unv", "model.uff"]:
        convert(model, folder / name)
    with wave.open(str(folder / "record.wav"), "wb") as record:
        record.setnchannels(2)
        record.setsampwidth(2)
        record.setframerate(8000)
        record.writeframes(bytes(range(256)) * 2)
    weights = '{"format":"chladni.weights","version":1,"frequency_hz":300.0,"weights":[{"reference":"101:+Z","re":0.1,"im":0.0}]}'
    (folder / "two.weights.json").write_text(weights)
    for scene in (ROOT / "fixtures").glob("*.toml"):
        (folder / scene.name).write_text(scene.read_text())
    # as crates/chladni-render/tests/mutation/targets.rs parts them
    table = "\n---\nfrequency_hz,velocity_m_per_s\n10.0,1e-4\n# a remark\n400,2e-4\n"
    polygon = '[[zones.polygon]]\nkind = "hot"\nlevel_db = 1.5\npoints_m = [[-0.1, -0.1], [0.05, -0.1], [0.05, 0.2], [-0.1, 0.2]]\n'
    cells = "[zones]\ngrid = [2, 1]\nhot = [1]\ncells_m = [-0.05, -0.05, 0.15, 0.15]\ntransition_m = 0.0\n"
    for name, zones in (("polygon", polygon), ("cells", cells)):
        head = '[threshold]\nprofile = "table.csv"\nlimen_db = 2.0\n'
        rest = "[actuators]\nmax_force_n = 0.1\nmax_effort = 1.0\n[drift]\nfrequency_relative = 1e-3\ndrive_relative = 0.1\n"
        for hz in ("60.0", "[50.0, [70.0, 74.0]]"):
            (folder / f"{name}-{len(hz)}.pair").write_text(f"frequency_hz = {hz}\n{head}{zones}{rest}{table}")
    try:
        import h5py
        import numpy
        import scipy.io
    except ImportError:
        print("no numpy, scipy and h5py: seeds without files of these programs")
        return
    arrays = {"frf": numpy.arange(6) * (1 + 0.5j), "f": numpy.arange(1.0, 7.0)}
    for packed in [False, True]:
        content = io.BytesIO()
        scipy.io.savemat(content, {"panel": arrays, **arrays}, do_compression=packed)
        (folder / f"panel-{packed}.mat").write_bytes(content.getvalue())
    with h5py.File(folder / "plain.h5", "w") as file:
        for name, array in arrays.items():
            file[name] = array
    with h5py.File(folder / "chunked.h5", "w") as file:
        file.create_dataset("a/frf", data=arrays["frf"].reshape(2, 3), chunks=(1, 3), compression="gzip", shuffle=True)
        file["a/frf"].attrs["units"] = "m/s/N"
        file["a/f"] = arrays["f"][:3]


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    sound_files(folder)
    for target, (damaged, extensions) in SEEDS.items():
        corpus = ROOT / "fuzz/corpus" / target
        corpus.mkdir(parents=True, exist_ok=True)
        files = [file for pattern in damaged for file in (ROOT / "fixtures/malformed").glob(f"{pattern}/*")]
        files += [file for extension in extensions for file in folder.glob(f"*{extension}")]
        files = [file for file in files if file.stat().st_size <= LARGEST.get(target, 8192)]
        for file in files:
            (corpus / f"{file.parent.name if file.is_relative_to(ROOT) else 'sound'}-{file.name}").write_bytes(file.read_bytes())
        print(f"{target}: {len(files)} seeds")
