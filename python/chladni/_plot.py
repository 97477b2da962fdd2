"""Pictures with matplotlib, which is imported only here, when one is asked for."""

import numpy as np

from . import _chladni

_KIND = {"receptance": "Receptance, m", "mobility": "Mobility, (m/s)", "accelerance": "Accelerance, (m/s²)"}


def _axes(ax):
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def plot_frf(model, response=0, reference=0, *, frf=None, frequency_hz=None, ax=None):
    """
    Amplitude of one FRF of the model, and of the measured one where `frf` is given.

    Parameters
    ----------
    response, reference : int or str
        Place or name of the DOFs, such as ``"12:+Z"``.
    frf : FrfSet, optional
        The measured FRFs, drawn below the model's.
    frequency_hz : array_like, optional
        Lines, Hz; those of `frf`, or 2000 over the band.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib.axes.Axes
    """
    ax = _axes(ax)
    i, j = _place(response, model.responses), _place(reference, model.references)
    if frequency_hz is None:
        frequency_hz = np.linspace(*model.band_hz, 2000) if frf is None else frf.frequency_hz
    frequency_hz = _chladni.float64("frequency_hz", frequency_hz)
    names = model.responses[i], model.references[j]
    if frf is not None:
        measured = frf.values[frf.responses.index(names[0]), frf.references.index(names[1])]
        ax.semilogy(frf.frequency_hz, np.abs(measured), color="0.65", lw=2.5, label="measured")
    ax.semilogy(frequency_hz, np.abs(model.synthesise(frequency_hz)[i, j]), color="k", lw=0.9, label="model")
    ax.set(xlabel="Frequency, Hz", ylabel=f"{_KIND[model.kind]} per unit of the reference", title=f"{names[0]} from {names[1]}")
    ax.legend()
    return ax


def plot_shape(model, mode=0, *, ax=None):
    """
    Real part of a mode shape over the plane of the responses, turned to its largest value.

    Parameters
    ----------
    mode : int
        Place of the mode, from 0.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib.axes.Axes
    """
    shape = model.shapes[mode]
    turned = np.real(shape * np.exp(-1j * np.angle(shape[np.argmax(np.abs(shape))])))
    title = f"Mode {mode + 1}, {model.frequency_hz[mode]:.2f} Hz"
    return _plane(model.points_m, turned, title, "Shape", ax, symmetric=True)


def plot_field(drive, *, ax=None):
    """
    Velocity amplitude at the responses, mm/s peak, that a drive makes in the model.

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib.axes.Axes
    """
    amplitude = 1e3 * np.abs(drive.velocity_m_per_s)
    return _plane(drive.points_m, amplitude, f"{drive.frequency_hz:g} Hz, {drive.method}", "Velocity, mm/s peak", ax)


def _plane(points_m, values, title, label, ax, symmetric=False):
    if not np.isfinite(points_m[:, :2]).all():
        raise _chladni.refusal("model", "positions of the responses are not known", "NaN in points_m", "`nodes_m` given to FrfSet")
    ax = _axes(ax)
    limit = {"vmin": -np.abs(values).max(), "vmax": np.abs(values).max(), "cmap": "RdBu_r"} if symmetric else {"cmap": "viridis"}
    drawn = ax.scatter(*points_m[:, :2].T, c=values, s=60, **limit)
    ax.set(xlabel="x, m", ylabel="y, m", title=title, aspect="equal")
    ax.figure.colorbar(drawn, ax=ax, label=label)
    return ax


def _place(dof, names):
    if isinstance(dof, str):
        if dof not in names:
            raise _chladni.refusal("model", "the model has no DOF of this name", str(dof), f"one of {', '.join(names[:5])}{', ...' if len(names) > 5 else ''}")
        return names.index(dof)
    return dof
