"""Scenes as Python values: dictionaries, and masks over the points of a model."""

import math

import numpy as np

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
            raise ValueError(f"a scene takes finite numbers, not {value}")
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
    """Scene as `render` and `evaluate` take it: a dictionary becomes the text of a file."""
    return to_toml(scene) if isinstance(scene, dict) else scene


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


def scene(model, frequency_hz, hot, *, cold=None, **tables):
    """
    A scene from masks over the responses of a model.

    Parameters
    ----------
    model : Model
        Its `points_m` are what the masks select.
    frequency_hz : float
        Drive frequency, Hz.
    hot : array_like of bool, shape (response,)
        Points to be felt.
    cold : array_like of bool, shape (response,), optional
        Points to be quiet; the others are not judged. Without it all points that are not hot are cold.
    **tables : dict
        Further tables of a scene: ``threshold``, ``actuators``, ``drift``, ...

    Returns
    -------
    dict
        What `render` and `evaluate` take, and `scene_to_toml` writes.
    """
    points_m = np.asarray(model.points_m)[:, :2]
    masks = {"hot": np.asarray(hot, dtype=bool), "cold": None if cold is None else np.asarray(cold, dtype=bool)}
    for name, mask in masks.items():
        if mask is not None and mask.shape != (len(points_m),):
            raise ValueError(f"{name} has the shape {mask.shape}; expected ({len(points_m)},), one value for each response")
    if not np.isfinite(points_m).all():
        raise ValueError("the model does not know where its responses are; give `nodes_m` to FrfSet")
    if not masks["hot"].any():
        raise ValueError("no point is hot; set at least one value of `hot`")
    if cold is not None and (masks["hot"] & masks["cold"]).any():
        raise ValueError("a point is hot or cold, not both")
    apart = np.linalg.norm(points_m[:, None] - points_m[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    spacing_m = apart.min() if len(points_m) > 1 else 0.001
    if not spacing_m > 0:
        raise ValueError("two responses are at the same place")
    polygons = [
        {"kind": kind, "points_m": corners}
        for kind, mask in masks.items()
        if mask is not None
        for corners in _rectangles(points_m[mask], spacing_m)
    ]
    zones = {"polygon": polygons, "transition_m": 0.0, **tables.pop("zones", {})}
    return {"frequency_hz": float(frequency_hz), "zones": zones, **tables}
