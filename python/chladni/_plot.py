"""Pictures with matplotlib, which is imported only here, when one is asked for."""

import operator

import numpy as np

from . import _chladni

_KIND = {"receptance": "Receptance, m", "mobility": "Mobility, (m/s)", "accelerance": "Accelerance, (m/s²)"}
# powers of jω by which a kind differs from receptance
_POWER = {"receptance": 0, "mobility": 1, "accelerance": 2}


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
        Place (from the end where negative) or name of the DOFs, such as ``"12:+Z"``.
    frf : FrfSet, optional
        The measured FRFs, drawn below the model's, in the kind of the model.
    frequency_hz : array_like, optional
        Lines, Hz; those of `frf`, or 2000 over the band.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib.axes.Axes
    """
    i, j = _place("response", response, model.responses), _place("reference", reference, model.references)
    if frequency_hz is None:
        frequency_hz = np.linspace(*model.band_hz, 2000) if frf is None else frf.frequency_hz
    frequency_hz = _chladni.float64("frequency_hz", frequency_hz)
    names = model.responses[i], model.references[j]
    measured = None if frf is None else _measured(frf, model, *names)
    synthesised = np.abs(model._synthesise_one(i, j, frequency_hz))
    ax = _axes(ax)
    if measured is not None:
        ax.semilogy(frf.frequency_hz, measured, color="0.65", lw=2.5, label="measured")
    ax.semilogy(frequency_hz, synthesised, color="k", lw=0.9, label="model")
    ax.set(xlabel="Frequency, Hz", ylabel=f"{_KIND[model.kind]}/{model.reference_unit}", title=f"{names[0]} from {names[1]}")
    ax.legend()
    return ax


def _measured(frf, model, response, reference):
    """Amplitude of one measured FRF in the kind of the model; NaN at 0 Hz where that divides by 0."""
    if frf.kind is None:
        expected = "receptance, mobility or accelerance: give frf_kind to read, or kind to FrfSet"
        raise _chladni.refusal("frf", "the FRFs do not say their kind", "None in frf.kind", expected)
    if frf.reference_unit != model.reference_unit:
        expected = f"{model.reference_unit}, as the model"
        raise _chladni.refusal("frf", "the FRFs are per another unit of the reference than the model", frf.reference_unit, expected)
    for what, name, names in (("response", response, frf.responses), ("reference", reference, frf.references)):
        if name not in names:
            raise _chladni.refusal("frf", f"the FRFs do not have this {what} of the model", name, _some(names))
    amplitude = np.abs(frf.values[frf.responses.index(response), frf.references.index(reference)])
    power = _POWER[model.kind] - _POWER[frf.kind]
    if power == 0:
        return amplitude
    omega = 2 * np.pi * frf.frequency_hz
    return amplitude * np.where(omega > 0, omega, np.nan) ** float(power)


def plot_shape(model, mode=0, *, ax=None):
    """
    Real part of a mode shape over the plane of the responses, turned to its largest value.

    Parameters
    ----------
    mode : int
        Place of the mode, from 0; from the end where negative.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib.axes.Axes
    """
    mode = _index("mode", mode, len(model), "modes")
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


def _place(field, dof, names):
    """Place of a DOF, from its name or from an index as NumPy takes it."""
    if isinstance(dof, str):
        if dof not in names:
            raise _chladni.refusal(field, "the model has no DOF of this name", dof, _some(names))
        return names.index(dof)
    return _index(field, dof, len(names), f"{field}s")


def _index(field, index, count, what):
    """Place of an index as NumPy takes it: negative ones count from the end."""
    expected = f"an integer from {-count} to {count - 1}" if count else f"a model with {what}"
    try:
        place = operator.index(index)
    except TypeError:
        raise _chladni.refusal(field, f"no place among the {what}", repr(index), expected) from None
    if not -count <= place < count:
        raise _chladni.refusal(field, f"no place among the {count} {what}", str(place), expected)
    return place % count


def _some(names):
    return f"one of {', '.join(names[:5])}{', ...' if len(names) > 5 else ''}"
