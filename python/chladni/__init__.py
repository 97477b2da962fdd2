"""Modal identification of plates from measured FRFs, and vibration rendering with it.

    import chladni
    frf = chladni.read("scan.uff", frf_kind="mobility")
    model = chladni.fit(frf, band=(20, 1900))
    print(model.frequency_hz, model.loss_factor, model.trust)
    drive = chladni.render(model, "corner.toml")

Data larger than memory, or many machines: the same fit in pieces. Reduce every block of the FRFs, merge, solve; the first pass gives
`Poles`, a second pass with them the `Model`.

    found = None
    while not isinstance(found, chladni.Model):
        partials = (chladni.reduce_block(frf, number, poles=found) for number, frf in enumerate(blocks()))
        found = chladni.solve_poles(chladni.merge(partials))

Arrays are NumPy's, in SI units; names carry theirs. Errors are `ChladniError`, with the fields of the command line's `--json`.
"""

import json as _json

import numpy as _numpy

from ._chladni import ChladniError, FrfSet, Model, Partial, Poles, Rendering, __version__
from ._chladni import fit, load_model, merge, read, reduce_block, render, residues_block, simulate, solve_poles
from ._chladni import evaluate as _evaluate

__all__ = [
    "ChladniError",
    "FrfSet",
    "Model",
    "Partial",
    "Poles",
    "Rendering",
    "__version__",
    "evaluate",
    "fit",
    "load_model",
    "merge",
    "read",
    "reduce_block",
    "render",
    "residues_block",
    "simulate",
    "solve_poles",
]


def evaluate(rendering, scene, on):
    """The indices of a `Rendering` in a scene on other data (an `FrfSet` or a `Model`), as a dictionary."""
    return _json.loads(_evaluate(rendering, scene, on))


def _to_dict(self):
    """Everything the model file holds, as a dictionary."""
    return _json.loads(self.to_json())


def _frf_reconstruct(self, frequency_hz):
    """FRFs of the model on the lines given: the name that users of SDyPy-EMA know for `synthesise`."""
    return self.synthesise(_numpy.ascontiguousarray(frequency_hz, dtype=float))


def _auto_mac(self):
    """MAC of the shapes with each other: the name that users of SDyPy-EMA know for `mac()`."""
    return self.mac()


Model.to_dict = _to_dict
Model.FRF_reconstruct = _frf_reconstruct
Model.autoMAC = _auto_mac
Model.nat_freq = property(lambda self: self.frequency_hz, doc="Natural frequencies, Hz (SDyPy-EMA's name).")
Model.nat_xi = property(lambda self: self.damping_ratio, doc="Damping ratios (SDyPy-EMA's name).")
Rendering.to_dict = lambda self: _json.loads(self.to_json())
