#!/usr/bin/env python3
"""Writes a set of FRFs that is larger than memory, in the HDF5 layout of Chladni: 20 modes, noise 40 dB below the data.

Needs numpy and h5py; memory stays below 1 GiB. What `chladni fit OUT.h5` takes for it is in docs/pieces.md.
"""

import argparse

import h5py
import numpy as np

MODES, REFERENCES, RESPONSES_AT_A_TIME = 20, 4, 500


def main(path, gib, single, lines):
    random = np.random.default_rng(1)
    dtype = np.dtype([("r", "<f4"), ("i", "<f4")]) if single else np.dtype([("r", "<f8"), ("i", "<f8")])
    responses = int(gib * 2**30 / (REFERENCES * lines * dtype.itemsize))
    frequency = np.linspace(10.0, 1010.0, lines)
    omega = 2 * np.pi * frequency
    natural = 2 * np.pi * (np.linspace(40.0, 960.0, MODES) + random.uniform(-8, 8, MODES))
    loss = random.uniform(0.005, 0.02, MODES)
    resonance = 1j * omega / (natural[:, None] ** 2 * (1 + 1j * loss[:, None]) - omega**2)
    drive = random.normal(size=(REFERENCES, MODES))
    rms = np.sqrt((np.abs(resonance) ** 2).mean(axis=1).sum())
    dof = np.dtype([("node", "<u8"), ("dir", "i1")])
    with h5py.File(path, "w") as file:
        file.attrs.update(format="chladni", version=1, created_by="make_large_set.py", frf_kind="mobility", reference_unit="N", time_sign="+")
        file["freq"] = frequency
        file["freq"].attrs["unit"] = "Hz"
        file["response"] = np.array([(i + 1, 3) for i in range(responses)], dtype=dof)
        file["reference"] = np.array([(10_000_000 + j, 3) for j in range(REFERENCES)], dtype=dof)
        frf = file.create_dataset("frf", (responses, REFERENCES, lines), dtype)
        for first in range(0, responses, RESPONSES_AT_A_TIME):
            count = min(RESPONSES_AT_A_TIME, responses - first)
            shape = random.normal(size=(count, MODES))
            values = np.einsum("im,jm,mk->ijk", shape, drive, resonance, optimize=True)
            noise = random.standard_normal((count, REFERENCES, lines, 2), dtype=np.float32).view(np.complex64)[..., 0]
            values += noise * (0.01 * rms / np.sqrt(2))
            frf[first : first + count] = values.astype(np.complex64 if single else np.complex128).view(dtype)
    with h5py.File(path + ".truth.h5", "w") as file:
        file["natural_frequency_hz"], file["loss_factor"] = natural / (2 * np.pi), loss


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("out", metavar="OUT.h5")
    asked.add_argument("gib", type=float, metavar="GIB", help="size of the FRFs")
    asked.add_argument("--single", action="store_true", help="32-bit floats")
    asked.add_argument("--lines", type=int, default=2001)
    asked = asked.parse_args()
    main(asked.out, asked.gib, asked.single, asked.lines)
