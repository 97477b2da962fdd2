"""FRFs as a NumPy array to modes and MAC: what a notebook would hold, cell by cell.

    pip install ./python matplotlib
    python examples/modes_and_mac.py            # writes modes_and_mac.png
"""

# %% FRFs as one would have them from anywhere: an array (response, reference, line) and its axis
from pathlib import Path

import chladni
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

measured, truth = chladni.simulate(Path(__file__).parents[1] / "fixtures" / "panel-driving-points.toml")
frequency_hz, values = np.array(measured.frequency_hz), np.array(measured.values)

# %% modes: ten lines from here to the picture's data
frf = chladni.FrfSet(frequency_hz, values, responses=measured.responses, references=measured.references, kind="mobility")
model = chladni.fit(frf)
for f, std, loss, trust in zip(model.nat_freq, model.frequency_std_hz, model.loss_factor, model.trust):
    print(f"{f:9.4f} Hz ± {std:.4f}   loss factor {loss:.5f}   {trust}")
rebuilt = model.FRF_reconstruct(frequency_hz)
auto_mac, against_truth = model.autoMAC(), model.mac(truth)
print("residual", f"{model.relative_error:.4f}", "of the data; least MAC with the truth", f"{np.diag(against_truth).min():.6f}")

# %% pictures
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
left.semilogy(frequency_hz, np.abs(values[0, 0]), color="0.6", lw=2.5, label="measured")
left.semilogy(frequency_hz, np.abs(rebuilt[0, 0]), color="k", lw=0.9, label="model")
left.set(xlabel="Frequency, Hz", ylabel="Mobility, (m/s)/N", title=f"{measured.responses[0]} from {measured.references[0]}")
left.legend()
image = right.imshow(auto_mac, cmap="Greys", vmin=0, vmax=1)
right.set(xlabel="Mode", ylabel="Mode", title="MAC of the shapes")
figure.colorbar(image, label="MAC, –")
figure.savefig("modes_and_mac.png", dpi=120)
