"""Scenes as Python values: dictionaries, and masks over the points of a model."""

import math

import numpy as np

from . import _chladni

# points whose rows differ by less are in one row, m
_SAME_ROW_M = 1e-6


def _value(value):
    """A TOML value."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise _chladni.refusal("scene", "a number that a scene cannot hold", str(value), "finite numbers")
        return repr(float(value))
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_value(str(key))} = {_value(item)}" for key, item in value.items() if item is not None) + "}"
    raise TypeError(f"a scene takes numbers, texts, lists and dictionaries, not {type(value).__name__}")


def to_toml(scene):
    """
    The text of a scene file that holds a dictionary.

    Parameters
    ----------
    scene : dict
        Tables and keys of a scene file; None counts as absent.

    Returns
    -------
    str
    """
    return "".join(f"{key} = {_value(value)}\n" for key, value in scene.items() if value is not None)


def text_or_path(scene):
    """Scene as `render` and `evaluate` take it: a dictionary becomes the text of a file, an empty one an empty text."""
    return to_toml(scene) or "\n" if isinstance(scene, dict) else scene


def _rectangles(points_m, spacing_m):
    """Rectangles around points of a plane, neighbours of one row in one of them."""
    half = 0.5 * float(spacing_m)
    order = np.lexsort((points_m[:, 0], np.round(points_m[:, 1] / _SAME_ROW_M)))
    runs = []
    for x, y in points_m[order].tolist():
        if runs and abs(runs[-1][2] - y) < _SAME_ROW_M and x - runs[-1][1] < 1.01 * spacing_m:
            runs[-1][1] = x
        else:
            runs.append([x, x, y])
    return [[[a - half, y - half], [b + half, y - half], [b + half, y + half], [a - half, y + half]] for a, b, y in runs]


def _mask(name, values, count):
    """A mask with a value for each response; numbers count as one where all are 0 or 1."""
    expected = f"{count} values, True or False, one for each response; of places, mask = np.zeros({count}, bool); mask[places] = True"
    mask = np.asarray(values)
    if mask.shape != (count,):
        raise _chladni.refusal(name, "no mask of the responses", f"the shape {mask.shape}", expected)
    if mask.dtype.kind not in "biuf":
        raise _chladni.refusal(name, "no mask of the responses", f"values of the type {mask.dtype}", expected)
    odd = mask[(mask != 0) & (mask != 1)]
    if len(odd):
        raise _chladni.refusal(name, "no mask of the responses", str(odd[0]), expected)
    return mask.astype(bool)


def scene(model, frequency_hz, hot, *, cold=None, **tables):
    """
    A scene from masks over the responses of a model.

    Parameters
    ----------
    model : Model
        Its `points_m` are what the masks select. Responses that do not point along Z are not looked at, as in `render`.
    frequency_hz : float or sequence
        Drive frequency, Hz, or what sounds at once: frequencies, and bands ``[low, high]``.
    hot : array_like of bool, shape (response,)
        Points to be felt.
    cold : array_like of bool, shape (response,), optional
        Points to be quiet; the others are not judged. Without it all points that are not hot are cold.
    **tables : dict
        Further tables of a scene: ``threshold``, ``actuators``, ``drift``, ...; ``zones`` may hold ``transition_m`` and ``area_m``.

    Returns
    -------
    dict
        What `render` and `evaluate` take, and `scene_to_toml` writes.
    """
    along_z = np.array([name.rpartition(":")[2] in ("+Z", "-Z") for name in model.responses], dtype=bool)
    if not along_z.any():
        raise _chladni.refusal("model", "no response of the model points along Z", ", ".join(model.responses[:5]), "responses such as 12:+Z")
    points_m = np.asarray(model.points_m)[along_z, :2]
    given = {"hot": hot} if cold is None else {"hot": hot, "cold": cold}
    masks = {name: _mask(name, mask, len(along_z))[along_z] for name, mask in given.items()}
    if not np.isfinite(points_m).all():
        raise _chladni.refusal("model", "a model that does not know where its responses are", "NaN in points_m", "`nodes_m` given to FrfSet")
    if not masks["hot"].any():
        raise _chladni.refusal("hot", "no point is hot", "no True", "at least one True, at a response along Z")
    if cold is not None and (masks["hot"] & masks["cold"]).any():
        raise _chladni.refusal("cold", "a point is hot or cold, not both", "True in `hot` and `cold`", "one of them")
    apart = np.linalg.norm(points_m[:, None] - points_m[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    spacing_m = apart.min() if len(points_m) > 1 else 0.001
    if not spacing_m > 0:
        raise _chladni.refusal("model", "two responses are at the same place", "the same row of points_m twice", "a place for each response")
    polygons = [
        {"kind": kind, "points_m": corners}
        for kind, mask in masks.items()
        for corners in _rectangles(points_m[mask], spacing_m)
    ]
    zones = {"polygon": polygons, "transition_m": 0.0, **_beside_masks(tables.pop("zones", None))}
    return {"frequency_hz": _tones(frequency_hz), "zones": zones, **tables}


def _beside_masks(zones):
    """Keys of the table `zones` that say nothing of the places which the masks say."""
    zones = {} if zones is None else zones
    expected = "transition_m or area_m; or the whole scene as a dictionary, without masks"
    if not isinstance(zones, dict):
        raise _chladni.refusal("zones", "no table of a scene", repr(zones), f"a dictionary with {expected}")
    other = [key for key in zones if key not in ("transition_m", "area_m")]
    if other:
        raise _chladni.refusal("zones", "the masks say already what is hot and cold", ", ".join(map(str, other)), expected)
    return zones


def _tones(frequency_hz):
    """A frequency, or a list of frequencies and bands, as plain numbers."""
    expected = "a frequency in Hz, or a list of what sounds at once: frequencies, and bands [low, high]"
    try:
        if np.ndim(frequency_hz) == 0:
            return float(frequency_hz)
    except ValueError:  # frequencies beside bands: no array
        pass
    except TypeError:
        raise _chladni.refusal("frequency_hz", "no frequency", repr(frequency_hz), expected) from None
    try:
        return [float(tone) if np.ndim(tone) == 0 else [float(end) for end in tone] for tone in frequency_hz]
    except (TypeError, ValueError):
        raise _chladni.refusal("frequency_hz", "no frequency", repr(frequency_hz), expected) from None
