#!/usr/bin/env python3
"""Writes a set of FRFs that is larger than memory, in the HDF5 layout of Chladni: 20 modes, 2001 lines, noise 40 dB below the data.

    scripts/make_large_set.py OUT.h5 GIB [--single]     (needs numpy and h5py; memory stays below 1 GiB)

What `chladni fit OUT.h5` takes for it is in docs/pieces.md.
"""

import sys

import h5py
import numpy as np

LINES, MODES, REFERENCES, RESPONSES_AT_A_TIME = 2001, 20, 4, 500


def main(path, gib, single):
    random = np.random.default_rng(1)
    dtype = np.dtype([("r", "<f4"), ("i", "<f4")]) if single else np.dtype([("r", "<f8"), ("i", "<f8")])
    responses = int(gib * 2**30 / (REFERENCES * LINES * dtype.itemsize))
    frequency = np.linspace(10.0, 1010.0, LINES)
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
        frf = file.create_dataset("frf", (responses, REFERENCES, LINES), dtype)
        for first in range(0, responses, RESPONSES_AT_A_TIME):
            count = min(RESPONSES_AT_A_TIME, responses - first)
            shape = random.normal(size=(count, MODES))
            values = np.einsum("im,jm,mk->ijk", shape, drive, resonance, optimize=True)
            noise = random.standard_normal((count, REFERENCES, LINES, 2), dtype=np.float32).view(np.complex64)[..., 0]
            values += noise * (0.01 * rms / np.sqrt(2))
            frf[first : first + count] = values.astype(np.complex64 if single else np.complex128).view(dtype)
    with h5py.File(path + ".truth.h5", "w") as file:
        file["natural_frequency_hz"], file["loss_factor"] = natural / (2 * np.pi), loss


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], float(sys.argv[2]), "--single" in sys.argv)
