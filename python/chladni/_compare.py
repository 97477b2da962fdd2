"""Two sets of modes side by side, with NumPy arrays."""

import json

import numpy as np

from . import _chladni
from ._html import table


class Comparison:
    """
    Modes of two models, paired by their shapes.

    Attributes
    ----------
    mac, mac_std, mac_noise_bias : ndarray, shape (mode of a, mode of b)
        MAC of every two shapes. That of the exact shapes lies within ``mac - mac_noise_bias ± 1.96 * mac_std`` in 95 % of cases.
    pairs : ndarray of int, shape (pair, 2)
        Places of the paired modes in a and b, from 0.
    frequency_shift_hz, frequency_shift_sigmas : ndarray, shape (pair,)
        b minus a, Hz, and in standard deviations (NaN where no error bar is known).
    loss_factor_shift, loss_factor_shift_sigmas : ndarray, shape (pair,)
        The same of the loss factors.
    only_in_a, only_in_b : ndarray of int
        Places of the modes without a partner.
    paired_by : {"name", "nearest"}
        How DOFs found their partners.
    common_dofs : int
        DOFs that both have.
    warnings : list of str
        What the user must know.
    """

    def __init__(self, found):
        self._found = found
        pairs = found["pairs"]

        def column(key):
            return np.array([np.nan if pair[key] is None else pair[key] for pair in pairs], dtype=float)

        # every mode has a partner or has none; of a model without modes the lists do not tell the other's number
        shape = tuple(len(pairs) + len(found[key]) for key in ("only_in_a", "only_in_b"))
        for key in ("mac", "mac_std", "mac_noise_bias"):
            setattr(self, key, np.array(found[key], dtype=float).reshape(shape))
        for key in ("frequency_shift_hz", "frequency_shift_sigmas", "loss_factor_shift", "loss_factor_shift_sigmas"):
            setattr(self, key, column(key))
        self.pairs = np.array([[pair["a"] - 1, pair["b"] - 1] for pair in pairs], dtype=int).reshape(-1, 2)
        for key in ("only_in_a", "only_in_b"):
            setattr(self, key, np.array([mode["mode"] - 1 for mode in found[key]], dtype=int))
        for key in ("paired_by", "common_dofs", "largest_distance_m", "warnings"):
            setattr(self, key, found[key])

    def to_dict(self):
        """Result as ``chladni compare --json`` prints it; modes are counted from 1."""
        return self._found

    def to_dataframe(self):
        """A pandas DataFrame with a row for each pair."""
        import pandas

        split = {"frequency_hz": ("frequency_a_hz", "frequency_b_hz"), "loss_factor": ("loss_factor_a", "loss_factor_b")}
        rows = []
        for pair in self._found["pairs"]:
            row = {key: value for key, value in pair.items() if key not in split}
            for key, names in split.items():
                row.update(zip(names, pair[key]))
            rows.append(row)
        return pandas.DataFrame(rows)

    def __repr__(self):
        return (
            f"Comparison({len(self.pairs)} pairs over {self.common_dofs} DOFs, "
            f"{len(self.only_in_a)} only in a, {len(self.only_in_b)} only in b)"
        )

    def _repr_html_(self):
        rows = [
            [
                pair["a"],
                pair["b"],
                f"{pair['frequency_hz'][0]:.6g}",
                f"{pair['frequency_shift_hz']:+.3g}",
                "" if pair["frequency_shift_sigmas"] is None else f"{pair['frequency_shift_sigmas']:+.1f}",
                f"{pair['mac']:.4f}",
            ]
            for pair in self._found["pairs"]
        ]
        return table(repr(self), ["a", "b", "Frequency a, Hz", "b − a, Hz", "in σ", "MAC"], rows)


def compare(a, b, *, pair_dofs="auto", least_mac=0.5):
    """
    Pairs the modes of two models by their shapes at the DOFs that both have.

    Parameters
    ----------
    a, b : Model or path
        Models, or files with shapes of a finite-element program (datasets 55 and 2414).
    pair_dofs : {"auto", "name", "nearest"}
        How DOFs find their partners.
    least_mac : float
        Least MAC of two modes that are one, 0 to 1.

    Returns
    -------
    Comparison
    """
    return Comparison(json.loads(_chladni.compare(a, b, pair_dofs, least_mac)))
