#!/usr/bin/env python3
"""Checks `chladni compare` on the demo's panel, whose exact shapes are known.

Needs Python alone. Usage: scripts/check_compare.py [path of the binary; default target/release/chladni] [--seeds N]

For each seed of the noise the panel is simulated and fitted, and the model compared with the truth, with the model of another
seed, and the truth with spoiled copies of the model: two modes that have changed places, one missing, the DOFs in another
order, half of them missing, and all of that together. Checked: every mode has its right partner or none, and the exact MAC
lies within 1.96 of the stated standard deviations in 95 % (three binomial standard errors below at most), for the pairs and
for modes that are not the same. Exit 1 where not.
"""
import argparse
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

SIGMAS_95 = 1.96
# the level of noise of the panel file, and one at which the bars are ten times as long
LEVELS_DB = (40, 20)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary", nargs="?", default="target/release/chladni")
    parser.add_argument("--seeds", type=int, default=10)
    asked = parser.parse_args()
    binary = pathlib.Path(asked.binary).resolve()
    panel = pathlib.Path(__file__).resolve().parent.parent / "fixtures/panel.toml"
    wrong = False
    for level in LEVELS_DB:
        with tempfile.TemporaryDirectory() as folder:
            shares = Shares()
            panel_at(binary, panel, pathlib.Path(folder), level, asked.seeds, shares)
            wrong |= shares.tell(f"{level} dB, {asked.seeds} seeds")
    sys.exit(int(wrong))


def panel_at(binary, panel, folder, level, seeds, shares):
    run(binary, "simulate", panel, "-o", folder / "panel.h5", "--truth", folder / "truth.json", "--snr-db", level)
    truth = json.loads((folder / "truth.json").read_text())
    previous = None
    for seed in range(1, seeds + 1):
        run(binary, "simulate", panel, "-o", folder / "panel.h5", "--snr-db", level, "--seed", seed, "--force")
        run(binary, "fit", folder / "panel.h5", "-o", folder / "model.json", "--force")
        model = json.loads((folder / "model.json").read_text())
        exact = exact_shapes(truth, model)
        cases = [("its truth", (truth, exact_shapes(truth, truth)), (model, exact))]
        if previous is not None:
            cases.append(("a second seed", previous, (model, exact)))
        cases += [(name, cases[0][1], other) for name, other in spoiled(model, exact, seed)]
        previous = (model, exact)
        for name, (a, of_a), (b, of_b) in cases:
            dofs = sorted(set(a["responses"]) & set(b["responses"]))
            shares.check(name, compared(binary, folder, a, b), of_a, of_b, dofs)


def run(binary, *arguments):
    done = subprocess.run([binary, *map(str, arguments), "-q"], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"chladni {' '.join(map(str, arguments))}: exit {done.returncode}\n{done.stderr}")
    return done.stdout


def compared(binary, folder, a, b):
    for name, model in (("a.json", a), ("b.json", b)):
        (folder / name).write_text(json.dumps(model))
    return json.loads(run(binary, "compare", folder / "a.json", folder / "b.json", "--json"))["comparisons"][0]


def modes_of(model):
    """The modes that `compare` numbers."""
    return [mode for mode in model["modes"] if mode["in_band"] and mode["trust"] != "rejected"]


def shape_of(mode):
    return [complex(re, im) for re, im in zip(mode["shape"]["re"], mode["shape"]["im"])]


def exact_shapes(truth, model):
    """For each mode of the model: the place of the truth's mode that it is, and that mode's exact shape by DOF."""
    known = modes_of(truth)
    exact = []
    for mode in modes_of(model):
        place = min(range(len(known)), key=lambda n: abs(known[n]["frequency_hz"] - mode["frequency_hz"]))
        half_bandwidth = known[place]["frequency_hz"] * known[place]["loss_factor"] / 2
        is_known = abs(known[place]["frequency_hz"] - mode["frequency_hz"]) < half_bandwidth
        exact.append((place, dict(zip(truth["responses"], shape_of(known[place])))) if is_known else None)
    return exact


def spoiled(model, exact, seed):
    """Copies of the model with the places and exact shapes of their modes."""
    draw = random.Random(seed)
    count = len(modes_of(model))
    one, other = draw.sample(range(count), 2)
    order = list(range(len(model["responses"])))
    draw.shuffle(order)
    half = order[: len(order) // 2]

    def swapped(model, exact):
        exact = list(exact)
        a, b = modes_of(model)[one], modes_of(model)[other]
        for key in ("shape", "shape_std", "scale_std", "participation"):
            a[key], b[key] = b.get(key), a.get(key)
        exact[one], exact[other] = exact[other], exact[one]
        return exact

    def missing(model, exact):
        gone = modes_of(model)[one]
        model["modes"] = [mode for mode in model["modes"] if mode is not gone]
        return [shape for n, shape in enumerate(exact) if n != one]

    def at(places):
        def change(model, exact):
            model["responses"] = [model["responses"][k] for k in places]
            model["residual_terms"]["terms"] = []
            for mode in model["modes"]:
                mode["shape_std"] = [mode["shape_std"][k] for k in places]
                for part in ("re", "im"):
                    mode["shape"][part] = [mode["shape"][part][k] for k in places]
            return exact

        return change

    def all_of_it(model, exact):
        return at(half)(model, missing(model, swapped(model, exact)))

    for name, change in (
        ("two modes swapped", swapped),
        ("a mode missing", missing),
        ("DOFs permuted", at(order)),
        ("half of the DOFs", at(half)),
        ("all of it", all_of_it),
    ):
        copy = json.loads(json.dumps(model))
        shapes = change(copy, exact)
        yield name, (copy, shapes)


def exact_mac(a, b, dofs):
    product = sum(a[dof].conjugate() * b[dof] for dof in dofs)
    return abs(product) ** 2 / (sum(abs(a[dof]) ** 2 for dof in dofs) * sum(abs(b[dof]) ** 2 for dof in dofs))


class Shares:
    """Pairs that are right and exact MACs within their bounds, by what was compared."""

    def __init__(self):
        self.rows = {}

    def check(self, name, found, of_a, of_b, dofs):
        row = self.rows.setdefault(name, {"pairs": [0, 0], "like": [0, 0], "unlike": [0, 0]})
        places = {shape[0]: m for m, shape in enumerate(of_b) if shape}
        expected = {(n + 1, places[shape[0]] + 1) for n, shape in enumerate(of_a) if shape and shape[0] in places}
        got = {(pair["a"], pair["b"]) for pair in found["pairs"]}
        count(row["pairs"], len(expected & got), len(expected | got))
        for n, a in enumerate(of_a):
            for m, b in enumerate(of_b):
                if a and b:
                    error = found["mac"][n][m] - found["mac_noise_bias"][n][m] - exact_mac(a[1], b[1], dofs)
                    inside = abs(error) <= SIGMAS_95 * found["mac_std"][n][m]
                    count(row["like" if a[0] == b[0] else "unlike"], inside, 1)

    def tell(self, title):
        """Prints the shares; true where one is too small."""
        print(f"{title}\n  {'compared with':20} {'pairs right':>16} {'MAC of pairs in bar':>20} {'of others':>16}")
        wrong = False
        for name, row in self.rows.items():
            parts = [f"{inside}/{all_} {100 * inside / max(all_, 1):5.1f} %" for inside, all_ in row.values()]
            print(f"  {name:20} {parts[0]:>16} {parts[1]:>20} {parts[2]:>16}", flush=True)
            wrong |= row["pairs"][0] < row["pairs"][1]
            wrong |= any(inside < all_ * (0.95 - 3 * math.sqrt(0.95 * 0.05 / max(all_, 1))) for inside, all_ in (row["like"], row["unlike"]))
        return wrong


def count(of, inside, all_):
    of[0] += inside
    of[1] += all_


if __name__ == "__main__":
    main()
