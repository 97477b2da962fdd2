"""Modal identification of plates from measured FRFs, and vibration rendering with it.

    import chladni
    frf = chladni.read("scan.uff", frf_kind="mobility")
    model = chladni.fit(frf, band=(20, 1900))
    model                                        # a notebook shows the table of modes
    chladni.compare(model, "fe_shapes.unv")      # MAC with its uncertainty, shifts, what has no partner
    drive = chladni.render(model, "corner.toml") # or a dictionary, or chladni.scene(model, 300.0, hot=mask)

Data larger than memory, or many machines: the same fit in pieces. Reduce every block of the FRFs, merge, solve; the first pass gives
`Poles`, a second pass with them the `Model`.

    found = None
    while not isinstance(found, chladni.Model):
        partials = (chladni.reduce_block(frf, number, poles=found) for number, frf in enumerate(blocks()))
        found = chladni.solve_poles(chladni.merge(partials))

Arrays are NumPy's, in SI units; names carry theirs. Errors are `ChladniError`, with the fields of the command line's `--json`.
"""

import json as _json
import os as _os

import numpy as _numpy

from . import _chladni, _html
from ._chladni import ChladniError, FrfSet, Model, Partial, Playing, Poles, Rendering, __version__
from ._chladni import cmif, load_model, merge, read, reduce_block, report, residues_block, simulate
from ._compare import Comparison, compare
from ._plot import plot_field as _plot_field
from ._plot import plot_frf as _plot_frf
from ._plot import plot_shape as _plot_shape
from ._progress import told as _told
from ._scene import scene, text_or_path as _text_or_path, to_toml as scene_to_toml

__all__ = [
    "ChladniError",
    "Comparison",
    "FrfSet",
    "Model",
    "Partial",
    "Playing",
    "Poles",
    "Rendering",
    "__version__",
    "cmif",
    "compare",
    "correct",
    "estimate",
    "evaluate",
    "fit",
    "load_model",
    "merge",
    "play",
    "read",
    "reduce_block",
    "render",
    "report",
    "residues_block",
    "scene",
    "scene_to_toml",
    "select",
    "simulate",
    "solve_poles",
    "stabilization",
]


def fit(frf, *, progress=None, **options):
    """
    Identifies the modes in an FRF set.

    Parameters
    ----------
    frf : FrfSet
        FRFs, shape (response, reference, line).
    band : sequence of two floats, optional
        Band, Hz; all lines without it.
    modes : int, optional
        Number of modes; decided by evidence without it.
    damping : {"structural", "viscous"}, optional
        Damping law; decided by evidence without it.
    method : {"auto", "lean", "vf", "lscf", "plscf", "aaa", "rfp", "grfp", "peak", "circle"}
        How poles are found.
    shapes : {"auto", "free", "rank1", "real"}
        What shapes may be while poles are refined.
    window : str, optional
        Window of the records that the FRFs were averaged from.
    exponential_window_per_s : float, optional
        Decay of a hammer test's window, 1/s: taken off the poles.
    rfp_weight : {"iv", "linear", "sk", "gn"}, optional
        What the polynomials of the methods ``"rfp"`` and ``"grfp"`` are fitted by.
    rfp_bands : int, optional
        Bands in which these look for poles; by the visible peaks without it.
    rfp_local : bool
        Their form of 1982: each FRF by itself.
    seed : int
        Of the random mixtures of FRFs.
    progress : bool or callable, optional
        True: a bar (with tqdm where installed). A function is called with the name of each stage; where it raises, the
        fit stops there. Ctrl-C stops it at its next stage.

    Returns
    -------
    Model
    """
    with _told(progress, "fit") as tell:
        return _chladni.fit(frf, progress=tell, **options)


def solve_poles(partial, *, progress=None, **options):
    """
    Poles of merged partials of the first pass, or the model of those of the second.

    Parameters
    ----------
    partial : Partial
        All blocks, merged.
    progress : bool or callable, optional
        As of `fit`.
    **options
        ``modes``, ``damping``, ``shapes``, ``exponential_window_per_s``, as of `fit`.

    Returns
    -------
    Poles or Model
        Blocks that are missing (``blocks`` of `reduce_block`) are a finding of the model, and a warning beside poles.
    """
    with _told(progress, "solve") as tell:
        return _chladni.solve_poles(partial, progress=tell, **options)


def estimate(
    references,
    responses,
    sample_rate_hz,
    *,
    reference_names=None,
    response_names=None,
    kind="mobility",
    reference_unit="N",
    estimator=None,
    window=None,
    exponential_window_per_s=None,
    block=None,
    overlap=None,
):
    """
    FRFs with coherence and variance from time records.

    Parameters
    ----------
    references : array_like, shape (reference, sample) or (run, reference, sample)
        Forces, N, or voltages, V.
    responses : array_like, shape (response, sample) or (run, response, sample)
        Displacements, velocities or accelerations, SI; `kind` says which.
    sample_rate_hz : float
        Samples per second.
    reference_names, response_names : list of str, optional
        DOFs such as ``"12:+Z"``; without them responses are nodes 1, 2, ... and references the nodes after those.
    kind : {"receptance", "mobility", "accelerance"}
        Kind of the FRFs.
    reference_unit : {"N", "V"}
        Unit of the references.
    estimator : {"lrm", "lpm", "h1", "h2", "hv"}, optional
        Local rational or polynomial method, or where averaged blocks take the noise to be.
        Without it: "lrm" for long records of continuous random excitation, else "h1".
    window : {"hann", "rectangular", "exponential"}, optional
        Without it: Hann for one long record, none for several runs, and for one whose force ends before it.
    exponential_window_per_s : float, optional
        Decay of an exponential window, 1/s.
    block : int, optional
        Samples of a block.
    overlap : float, optional
        Overlap of blocks, 0 to 0.95.

    Returns
    -------
    FrfSet
    """

    def runs(name, signals):
        signals = _numpy.atleast_2d(_chladni.float64(name, signals))
        if signals.ndim > 3:
            raise _chladni.refusal(name, "no records", f"{signals.ndim} axes", "the axes ([run,] channel, sample)")
        return list(signals if signals.ndim == 3 else signals[None])

    return _chladni.estimate(
        runs("references", references),
        runs("responses", responses),
        sample_rate_hz,
        reference_names,
        response_names,
        kind,
        reference_unit,
        estimator,
        window,
        exponential_window_per_s,
        block,
        overlap,
    )


def select(model, *, keep=None, drop=None, near_hz=(), within_hz=0.5, add=(), frf=None):
    """
    Keeps or drops modes by hand. Nothing is fitted again, unless modes are added.

    Parameters
    ----------
    model : Model
        What `fit` found.
    keep, drop : list of int or mask, optional
        Places of modes, from 0 as in the arrays of the model, or True or False for each mode; one of the
        two. Findings and the table of modes count from 1: their mode 9 is place 8 here.
    near_hz : list of float, optional
        Further modes by their frequency, Hz.
    within_hz : float
        Largest distance from `near_hz`, Hz.
    add : list of float, optional
        Frequencies of modes that the fit did not take, Hz: the FRFs are fitted anew with a
        mode at each, which is graded like all others. Places in `keep` and `drop` are
        those of `model`.
    frf : FrfSet, optional
        The FRFs that the model was fitted to; needed with `add`. Those without a DOF pair of the model are refused.

    Returns
    -------
    Model
    """
    lines = [f"add = [{', '.join(f'{{frequency_hz = {float(hz)}}}' for hz in add)}]"] if len(add) else []
    for name, places in (("keep", keep), ("drop", drop)):
        if places is not None:
            lines.append(f"{name} = {[place + 1 for place in _places(name, places, len(model))]}")
    lines += [f"[[mode]]\nnear_hz = {float(hz)}\nwithin_hz = {float(within_hz)}" for hz in near_hz]
    return _chladni.select(model, "\n".join(lines), frf)


def _places(name, places, count):
    """Places of modes, from a list of them or from a mask over the `count` modes."""
    expected = "a list of integers from 0, or a mask of the modes"
    places = places.tolist() if isinstance(places, _numpy.ndarray) else places
    if isinstance(places, str) or not _numpy.iterable(places):
        raise _chladni.refusal(name, "no places of modes", str(places), expected)
    places = list(places)
    kinds = {isinstance(place, (bool, _numpy.bool_)) for place in places}
    if kinds == {True}:
        if len(places) != count:
            raise _chladni.refusal(name, "no mask of the modes", f"{len(places)} values", f"one for each of the {count} modes")
        return [place for place, wanted in enumerate(places) if wanted]
    if kinds == {True, False} or not all(isinstance(place, (int, _numpy.integer)) for place in places):
        raise _chladni.refusal(name, "no places of modes", str(places), expected)
    for place in places:
        if not 0 <= place < count:
            raise _chladni.refusal(name, "no mode has this place", str(place), f"places from 0 to below {count}")
    return [int(place) for place in places]


def stabilization(frf, *, band=None):
    """
    Poles of rising order by the method lscf: the data of a stabilization diagram.

    Parameters
    ----------
    frf : FrfSet
        FRFs on an even axis.
    band : sequence of two floats, optional
        Band, Hz.

    Returns
    -------
    dict of ndarray
        ``order``, ``frequency_hz``, ``damping_ratio`` and ``stability`` ("new", "frequency" or "stable"), a value for each pole.
    """
    order, frequency_hz, damping_ratio, stability = _chladni.stabilization(frf, band)
    return {"order": order, "frequency_hz": frequency_hz, "damping_ratio": damping_ratio, "stability": _numpy.array(stability, dtype=str)}


def render(model, scene, **options):
    """
    Weights that move the panel in the hot zones of a scene and keep it quiet in the cold ones.

    Parameters
    ----------
    model : Model
        What the panel does.
    scene : path, str or dict
        Scene file, its TOML text, or the same as a dictionary (see `scene`).
    method : str
        default, fast, best, or one of the methods of ``chladni render``.
    modes, actuators : int or str
        "all", "auto" or a number.
    measured : FrfSet, optional
        FRFs whose line at the drive frequency judges ``modes="auto"``.

    Returns
    -------
    Rendering
    """
    return _chladni.render(model, _text_or_path(scene), **options)


def play(model, scene, **options):
    """
    The drive over time of a scene with a table ``[time]``: bursts, fades, moving spots.

    Parameters
    ----------
    model : Model
        What the panel does.
    scene : path, str or dict
        As of `render`.
    rendering : Rendering, optional
        Steady weights of the scene's own zones; rendered without it.
    ramps : {"modal", "plain", "program"}, optional
        How the drive comes and goes, in place of the scene's.
    method : str
        How steady weights are found, as of `render`.

    Returns
    -------
    Playing
        ``indices`` is a dictionary, ``save("drive.wav")`` writes what a rig plays, ``drive()`` the same as an array.
    """
    return _chladni.play(model, _text_or_path(scene), **options)


def correct(model, scene, weights, fields, *, output=None, calibration=None, force=False):
    """
    A drive corrected by the fields that were measured under earlier weights.

    Parameters
    ----------
    model : Model
        The model that the weights were rendered with.
    scene : path, str or dict
        As of `render`; a calibration that it names is where the correction starts.
    weights, fields : path or sequence of path
        Weights files that were played, oldest first, and the measured field of each.
    output, calibration : path, optional
        Weights file and calibration file to write, none of the files that are read.
    force : bool
        Overwrite existing ones.

    Returns
    -------
    dict
        The weights file.
    """
    files = [[paths] if isinstance(paths, (str, bytes, _os.PathLike)) else list(paths) for paths in (weights, fields)]
    return _json.loads(_chladni.correct(model, _text_or_path(scene), *files, output, calibration, force))


def evaluate(rendering, scene, on):
    """
    The indices of a drive on other data; on a model, and in a scene with a table ``[time]``, those in time beside them.

    Parameters
    ----------
    rendering : Rendering
        The drive.
    scene : path, str or dict
        As of `render`.
    on : FrfSet or Model
        What it is judged on.

    Returns
    -------
    dict
    """
    return _json.loads(_chladni.evaluate(rendering, _text_or_path(scene), on))


def _all_findings(self):
    """
    All findings: dictionaries with code, severity, modes, dofs, values, text and help. Modes
    are counted from 1, as in the table of modes; arrays and `select` count from 0.
    """
    return _json.loads(self._findings())


def _to_dict(self):
    """Everything the file holds, as a dictionary."""
    return _json.loads(self.to_json())


def _to_dataframe(self):
    """A pandas DataFrame with a row for each mode of the band."""
    import pandas

    columns = ("frequency_hz", "frequency_std_hz", "loss_factor", "loss_factor_std", "damping_ratio", "trust")
    return pandas.DataFrame({name: getattr(self, name) for name in columns})


def _frf_reconstruct(self, frequency_hz):
    """FRFs of the model on the lines given: the name that users of SDyPy-EMA know for `synthesise`."""
    return self.synthesise(frequency_hz)


def _auto_mac(self):
    """MAC of the shapes with each other: the name that users of SDyPy-EMA know for `mac()`."""
    return self.mac()


def _get_poles(self):
    """Poles, rad/s: the name that users of SDyPy-EMA know for `poles`, which are found by `fit` already."""
    return self.poles


def _modal_constants(self):
    """Residues of the first reference, receptance, (response, mode): SDyPy-EMA's A."""
    return (self.shapes * self.participations[:, :1] / (2j * self.poles.imag[:, None])).T


FrfSet.findings = property(_all_findings)
Model.findings = property(_all_findings)
Rendering.findings = property(_all_findings)
Model.to_dict = _to_dict
Model.to_dataframe = _to_dataframe
Model.FRF_reconstruct = _frf_reconstruct
Model.autoMAC = _auto_mac
Model.get_poles = _get_poles
Model.nat_freq = property(lambda self: self.frequency_hz, doc="Natural frequencies, Hz (SDyPy-EMA's name).")
Model.nat_xi = property(lambda self: self.damping_ratio, doc="Damping ratios (SDyPy-EMA's name).")
Model.A = property(_modal_constants, doc=_modal_constants.__doc__)
Model.plot_frf = _plot_frf
Model.plot_shape = _plot_shape
Model._repr_html_ = _html.model
FrfSet._repr_html_ = _html.frf_set
Playing.indices = property(lambda self: _json.loads(self._indices()), doc="How the ground does in time, by every measure.")
Rendering.to_dict = _to_dict
Rendering.plot_field = _plot_field
Rendering._repr_html_ = _html.rendering
