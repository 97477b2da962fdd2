"""A set larger than any worker's memory, fitted on a Dask cluster by the four calls of a fit in pieces (docs/pieces.md).

    pip install ./python h5py "dask[distributed]"
    python examples/dask_fit.py scan.h5 --workers 4         # FRFs as `chladni convert` writes them
    python examples/dask_fit.py --workers 1 2 --compare     # a generated set, by one worker, by two, and whole in memory

On a cluster of many machines, replace `LocalCluster` by what the site offers (dask-jobqueue, dask-kubernetes); the rest stays.
"""

import argparse
import hashlib
import tempfile
from pathlib import Path
from time import perf_counter

import chladni
import h5py
import numpy as np
from dask.distributed import Client, LocalCluster
from dask.utils import format_bytes, parse_bytes

AXES = ["S", "X", "Y", "Z", "RX", "RY", "RZ"]
TOGETHER = 8  # partials that one task merges
TASKS = 4  # of a pass, for each worker at least


# %% what workers run: a block is read where it is reduced
def read_block(path, start, stop):
    """Responses start to stop of a set in Chladni's HDF5 layout (docs/formats.md)."""

    def names(dofs):
        return [f"{node}:{'-' if code < 0 else '+' if code else ''}{AXES[abs(code)]}" for node, code in dofs.tolist()]

    with h5py.File(path) as file:
        return chladni.FrfSet(
            file["freq"][:],
            file["frf"][start:stop],
            responses=names(file["response"][start:stop]),
            references=names(file["reference"][:]),
            kind=file.attrs["frf_kind"],
            reference_unit=file.attrs["reference_unit"],
        )


def reduce(path, rows, first, poles):
    """Neighbouring blocks, one in memory at a time: their sums become one, and little is sent."""
    return chladni.merge(chladni.reduce_block(read_block(path, *ends), first + n, poles=poles) for n, ends in enumerate(rows))


def left_over(path, start, stop, model):
    """What the poles of the model leave of a block."""
    return chladni.residues_block(read_block(path, start, stop), model).relative_error


# %% what the cluster is asked for
def merged(client, partials):
    """A tree: any grouping gives the same bits, this one keeps every task small."""
    while len(partials) > 1:
        partials = [client.submit(chladni.merge, partials[n : n + TOGETHER]) for n in range(0, len(partials), TOGETHER)]
    return partials[0]


def fit(client, path, blocks, workers):
    """Two passes over the blocks; a further one where the second shows that poles must be sought once more."""
    share = max(len(blocks) // (TASKS * workers), 1)
    share = 2 ** (share.bit_length() - 1)  # sums over a power of two of blocks are those of the tree
    found = None
    while not isinstance(found, chladni.Model):
        start = perf_counter()
        poles = client.scatter(found, broadcast=True) if found is not None else None
        partials = [client.submit(reduce, path, blocks[n : n + share], n, poles) for n in range(0, len(blocks), share)]
        partial = merged(client, partials)
        del partials  # or the cluster keeps them
        found = chladni.solve_poles(partial.result())  # here, on all cores: workers have one each, and would wait
        print(f"  {perf_counter() - start:6.2f} s  {found}")
    return found


def fit_on(workers, path, blocks, memory_limit):
    # one thread each: the cluster hands out the cores
    with LocalCluster(n_workers=workers, threads_per_worker=1, memory_limit=memory_limit, env={"RAYON_NUM_THREADS": "1"}) as cluster:
        with Client(cluster) as client:
            client.wait_for_workers(workers)
            client.run(lambda: chladni.__version__)  # imported, and so not timed
            print(f"{workers} worker(s) of at most {format_bytes(parse_bytes(memory_limit))}")
            start = perf_counter()
            model = fit(client, path, blocks, workers)
            fitted = perf_counter()
            held = client.scatter(model, broadcast=True)
            left = client.gather([client.submit(left_over, path, *rows, held) for rows in blocks])
            worst = int(np.argmax(left))
            print(f"  {perf_counter() - fitted:6.2f} s  residues: block {worst} fits worst, {100 * left[worst]:.3g} % of it are left")
    return model, fitted - start


# %% a set to try it on
def generate(path, gigabytes, lines=2001, references=3, modes=20):
    """Mobilities of structurally damped modes with smooth shapes, and white noise 40 dB below; written slab by slab."""
    random = np.random.default_rng(1)
    frequency_hz = np.linspace(20, 1020, lines)
    omega = 2 * np.pi * frequency_hz
    omega_n = 2 * np.pi * np.sort(random.uniform(40, 1000, modes))
    factor = 1j * omega / (omega_n[:, None] ** 2 * (1 + 0.008j) - omega**2)
    waves = random.uniform(0.5, 6, (modes, 2))
    shapes = lambda xy: np.cos(np.pi * (xy @ waves.T))
    at_references = shapes(random.uniform(0, 1, (references, 2)))
    count = max(int(gigabytes * 1e9 / (16 * lines * references)), 64)
    dof = np.dtype([("node", "u8"), ("dir", "i1")])
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "chladni", "version": 1, "created_by": "dask_fit.py", "frf_kind": "mobility"})
        file.attrs.update({"reference_unit": "N", "time_sign": "+"})
        file["freq"] = frequency_hz
        file["response"] = np.array([(node, 3) for node in range(1, count + 1)], dof)
        file["reference"] = np.array([(node, 3) for node in range(count + 1, count + references + 1)], dof)
        values = file.create_dataset("frf", (count, references, lines), complex)
        scale = None
        for start in range(0, count, 256):
            here = shapes(random.uniform(0, 1, (min(256, count - start), 2)))
            slab = np.einsum("in,jn->ijn", here, at_references) @ factor
            scale = scale or 1e-2 * np.sqrt(np.mean(np.abs(slab) ** 2) / 2)
            slab.real += scale * random.standard_normal(slab.shape)
            slab.imag += scale * random.standard_normal(slab.shape)
            values[start : start + 256] = slab


# %% run
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", help="FRFs in Chladni's HDF5 layout [default: generated]")
    parser.add_argument("--workers", type=int, nargs="+", default=[2], help="several numbers: one run for each")
    parser.add_argument("--memory-limit", default="512MB", help="of each worker")
    parser.add_argument("--blocks", type=int, default=32)
    parser.add_argument("--gigabytes", type=float, default=1.5, help="size of the generated set")
    parser.add_argument("--compare", action="store_true", help="fit the whole in this process's memory too")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = args.file or str(Path(folder) / "generated.h5")
        if not args.file:
            generate(path, args.gigabytes)
        with h5py.File(path) as file:
            shape = file["frf"].shape
        ends = np.linspace(0, shape[0], min(args.blocks, shape[0]) + 1).astype(int).tolist()
        print(f"{shape[0] * shape[1]} FRFs x {shape[2]} lines, {format_bytes(Path(path).stat().st_size)}, {len(ends) - 1} blocks")
        runs = {n: fit_on(n, path, list(zip(ends, ends[1:])), args.memory_limit) for n in args.workers}
        models = [model for model, _ in runs.values()]
        model = models[0]
        print("sha256 of the model:", ", ".join({hashlib.sha256(model.to_json().encode()).hexdigest()[:16] for model in models}))
        first, time = args.workers[0], runs[args.workers[0]][1]
        for n in args.workers[1:]:
            print(f"{n} workers against {first}: {time / runs[n][1]:.2f} times as fast")
        if args.compare:
            start = perf_counter()
            whole = chladni.fit(chladni.read(path))
            print(f"in memory, read and fitted: {perf_counter() - start:.2f} s  {whole}")
            assert len(whole) == len(model), "the numbers of modes differ"
            apart = np.abs(model.frequency_hz - whole.frequency_hz) / whole.frequency_std_hz
            print(f"in pieces and whole differ by at most {apart.max():.2g} error bars; least MAC {np.diag(model.mac(whole)).min():.8f}")
            assert apart.max() < 0.05
        assert all(other.to_json() == model.to_json() for other in models), "the result depends on the number of workers"


if __name__ == "__main__":
    main()
