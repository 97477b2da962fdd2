"""Other tools for modal identification on exported FRFs: one row per case and tool, for the charts of `chladni bench accuracy --peers`."""

import argparse
import contextlib
import csv
import glob
import io
import json
import os
import re
import statistics
import sys
import time

import h5py
import numpy as np

# Model order of the polynomial methods, as a user would choose it for some ten modes.
ORDER = 40
# Pole pairs of vector fitting beyond the modes of the case.
SPARE_PAIRS = 6
COLUMNS = [
    "case",
    "method",
    "time_s",
    "frequency_rmse_with_missed_over_crlb",
    "missed",
    "modes",
    "seeds",
]


def receptance(path):
    """Frequency axis in Hz, and receptances with the axes (response, reference, line)."""
    with h5py.File(path) as file:
        frequency = file["freq"][:]
        raw = file["frf"][:]
        kind = file.attrs["frf_kind"]
    kind = kind.decode() if isinstance(kind, bytes) else kind
    frf = raw["r"] + 1j * raw["i"] if raw.dtype.names else raw
    j_omega = 2j * np.pi * frequency
    return frequency, frf / j_omega ** {"receptance": 0, "mobility": 1, "accelerance": 2}[kind]


def structural(poles):
    """Natural frequencies in Hz of poles s in rad/s, read as s^2 = -w^2 (1 + j eta)."""
    square = -np.asarray(poles, dtype=complex) ** 2
    return np.sqrt(np.abs(square.real)) / (2 * np.pi)


def sdypy_lscf(frequency, frf, modes):
    """LSCF of sdypy-EMA at 90 % of its highest order."""
    from sdypy import EMA

    stacked = frf.reshape(-1, frf.shape[-1])
    model = EMA.Model(
        stacked, frequency, lower=frequency[0], upper=frequency[-1], pol_order_high=ORDER, frf_form="receptance"
    )
    model.get_poles(method="lscf", show_progress=False)
    order = int(0.9 * len(model.pole_freq)) - 1
    f, xi = (np.asarray(values[order]) for values in (model.pole_freq, model.pole_xi))
    omega = 2 * np.pi * f
    return -xi * omega + 1j * omega * np.sqrt(np.maximum(1 - xi**2, 0))


def packed(frf, frequency):
    """The FRFs as the entries of a square network of order one in size; entries that are left over repeat the first FRF."""
    import skrf

    columns = frf.reshape(-1, frf.shape[-1])
    ports = int(np.ceil(np.sqrt(len(columns))))
    rows = [columns[k] if k < len(columns) else columns[0] for k in range(ports * ports)]
    values = np.stack(rows, axis=-1).reshape(len(frequency), ports, ports)
    return skrf.Network(f=frequency, f_unit="Hz", s=values / np.abs(values).max(), name="frf")


def skrf_vector_fitting(frequency, frf, modes):
    """Vector fitting of scikit-rf with some spare pole pairs."""
    from skrf.vectorFitting import VectorFitting

    fitting = VectorFitting(packed(frf, frequency))
    fitting.vector_fit(n_poles_real=2, n_poles_cmplx=modes + SPARE_PAIRS, init_pole_spacing="lin")
    return fitting.poles


def skrf_auto_fit(frequency, frf, modes):
    """Vector fitting of scikit-rf that is told nothing."""
    from skrf.vectorFitting import VectorFitting

    fitting = VectorFitting(packed(frf, frequency))
    fitting.auto_fit()
    return fitting.poles


def pyfbs_plscf(frequency, frf, modes):
    """Poly-reference LSCF of pyFBS at 90 % of its highest order."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from pyfbs.modal_id import ModalID

    with contextlib.redirect_stdout(io.StringIO()):
        # it folds what lies above the width of the band: the axis begins at zero, and the poles are moved back
        model = ModalID(frequency - frequency[0], np.moveaxis(frf, -1, 0))
        model.p_lscf(max_order=ORDER)
    return np.asarray(model.poles[int(0.9 * len(model.poles)) - 1][0]) + 2j * np.pi * frequency[0]


TOOLS = {
    "sdypy-EMA lscf": sdypy_lscf,
    "pyFBS plscf": pyfbs_plscf,
    "scikit-rf vf": skrf_vector_fitting,
    "scikit-rf auto_fit": skrf_auto_fit,
}


def errors(found, known, bandwidth):
    """Error of each known natural frequency in Hz, NaN where no pole lies within half its half-power bandwidth."""
    pairs = sorted(
        (abs(f - k), n, m)
        for n, (k, b) in enumerate(zip(known, bandwidth))
        for m, f in enumerate(found)
        if abs(f - k) <= 0.5 * b
    )
    result, taken = np.full(len(known), np.nan), set()
    for distance, n, m in pairs:
        if np.isnan(result[n]) and m not in taken:
            result[n] = distance
            taken.add(m)
    return result


def bounds(folder):
    """Cramer-Rao bounds of the natural frequencies, Hz, by case, as the bench wrote them."""
    result = {}
    with open(os.path.join(folder, "accuracy-modes.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row["frequency_crlb_hz"]:
                result.setdefault(row["case"], {})[int(row["mode"])] = float(row["frequency_crlb_hz"])
    return {case: np.array([by_mode[n] for n in sorted(by_mode)]) for case, by_mode in result.items()}


def row(case, name, tool, files, truth, bound):
    """One tool on all seeds of a case."""
    modes = [mode for mode in truth["modes"] if mode["in_band"]]
    known = np.array([mode["frequency_hz"] for mode in modes])
    bandwidth = known * np.array([mode["loss_factor"] for mode in modes])
    times, all_errors = [], []
    for path in files:
        frequency, frf = receptance(path)
        start = time.perf_counter()
        poles = np.asarray(tool(frequency, frf, len(modes)))
        times.append(time.perf_counter() - start)
        all_errors.append(errors(structural(poles[poles.imag > 0]), known, bandwidth))
    all_errors = np.array(all_errors)
    counted = np.where(np.isnan(all_errors), 0.5 * bandwidth, all_errors) / bound
    missed = np.isnan(all_errors).sum() / len(files)
    return [case, name, statistics.median(times), np.sqrt(np.mean(counted**2)), missed, len(modes), len(files)]


def kept(path):
    """Rows of an earlier run by case and method; those that are run again are replaced."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return {(line["case"], line["method"]): [line[column] for column in COLUMNS] for line in csv.DictReader(file)}


def write(path, rows):
    """All rows so far."""
    text = [[value if isinstance(value, str) else f"{value:.6g}" for value in rows[key]] for key in sorted(rows)]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(text)


def main():
    """Runs every tool on every exported case of a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="folder that `chladni bench accuracy --export` wrote into")
    parser.add_argument("--tool", action="append", choices=sorted(TOOLS), help="tools to run; may be repeated [default: all]")
    parser.add_argument("--case", action="append", help="cases to run; may be repeated [default: all that were exported]")
    parser.add_argument("--seeds", type=int, help="files of each case [default: all]")
    arguments = parser.parse_args()
    bound, output = bounds(arguments.folder), os.path.join(arguments.folder, "accuracy-peers.csv")
    rows = kept(output)
    for truth_file in sorted(glob.glob(os.path.join(arguments.folder, "truth-*.json"))):
        case = re.fullmatch(r"truth-(.*)\.json", os.path.basename(truth_file)).group(1)
        pattern = re.compile(rf"frf-{re.escape(case)}-\d+\.h5")
        files = sorted(path for path in glob.glob(os.path.join(arguments.folder, "frf-*.h5")) if pattern.fullmatch(os.path.basename(path)))
        files = files[: arguments.seeds]
        if case not in bound or not files or (arguments.case and case not in arguments.case):
            continue
        with open(truth_file, encoding="utf-8") as file:
            truth = json.load(file)
        for name, tool in TOOLS.items():
            if arguments.tool and name not in arguments.tool:
                continue
            print(f"{case}: {name}, {len(files)} seeds", file=sys.stderr, flush=True)
            try:
                rows[case, name] = row(case, name, tool, files, truth, bound[case])
                write(output, rows)
            except Exception as error:  # a tool that is missing or breaks must not stop the others
                print(f"  left out: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
    print(output)


if __name__ == "__main__":
    main()
