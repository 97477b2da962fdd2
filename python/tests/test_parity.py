"""The verbs of the command line, from Python: comparison, selection, records, diagrams, scenes as values, tables and pictures."""

import json
from pathlib import Path

import chladni
import numpy as np
import pytest

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="module")
def simulated():
    return chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)


@pytest.fixture(scope="module")
def frf(simulated):
    return simulated[0]


@pytest.fixture(scope="module")
def truth(simulated):
    return simulated[1]


@pytest.fixture(scope="module")
def model(frf):
    return chladni.fit(frf)


def rearranged(model, places):
    """The model at some of its responses, in another order."""
    held = model.to_dict()
    held["responses"] = [held["responses"][k] for k in places]
    held["residual_terms"]["terms"] = []
    for mode in held["modes"]:
        mode["shape_std"] = [mode["shape_std"][k] for k in places]
        for part in ("re", "im"):
            mode["shape"][part] = [mode["shape"][part][k] for k in places]
    return chladni.Model._from_json(json.dumps(held))


def test_mac_pairs_responses_by_name_not_by_position(model):
    count = len(model.responses)
    assert np.allclose(model.mac(rearranged(model, list(range(count))[::-1])), model.mac())
    half = rearranged(model, list(range(1, count, 2)))
    u = model.shapes[:, 1::2]
    power = np.sum(abs(u) ** 2, axis=1)
    assert np.allclose(model.mac(half), abs(u.conj() @ u.T) ** 2 / np.outer(power, power))
    strange = model.to_dict()
    strange["responses"] = [f"{9000 + k}:+Z" for k in range(count)]
    with pytest.raises(chladni.ChladniError, match="no DOF in common"):
        model.mac(chladni.Model._from_json(json.dumps(strange)))


def test_a_fit_is_compared_with_its_truth(model, truth):
    found = chladni.compare(model, truth)
    assert np.array_equal(found.pairs[:, 0], np.arange(len(model))) and len(found.only_in_b) == 0
    assert np.all(np.abs(found.frequency_shift_sigmas) < 5)
    diagonal = found.mac[tuple(found.pairs.T)], found.mac_noise_bias[tuple(found.pairs.T)], found.mac_std[tuple(found.pairs.T)]
    assert np.all(np.abs(1 - (diagonal[0] - diagonal[1])) < 5 * diagonal[2])
    assert found.paired_by == "name" and found.common_dofs == len(model.responses)
    assert "<table>" in found._repr_html_() and "MAC" in found._repr_html_()
    with pytest.raises(chladni.ChladniError) as wrong:
        chladni.compare(model, truth, pair_dofs="magic")
    assert wrong.value.field == "pair_dofs" and "nearest" in wrong.value.expected


def test_modes_are_dropped_by_their_place(model):
    left = chladni.select(model, drop=[1])
    assert np.allclose(left.frequency_hz, np.delete(model.frequency_hz, 1))
    one = chladni.select(model, near_hz=[model.frequency_hz[2]], within_hz=0.1)
    assert len(one) == 1 and one.frequency_hz[0] == model.frequency_hz[2]
    assert chladni.compare(model, left).only_in_a.tolist() == [1]


def test_modes_are_chosen_by_a_mask(model):
    above = model.frequency_hz > np.median(model.frequency_hz)
    assert np.array_equal(chladni.select(model, keep=above).frequency_hz, model.frequency_hz[above])
    assert np.array_equal(chladni.select(model, drop=list(above)).frequency_hz, model.frequency_hz[~above])
    for places in (above[1:], [1.7], [-1], [len(model)], "sure", [[0]], [[0], [1, 2]], [True, 2], 3):
        with pytest.raises(chladni.ChladniError) as wrong:
            chladni.select(model, keep=places)
        assert wrong.value.field == "keep" and wrong.value.expected
    with pytest.raises(chladni.ChladniError) as beyond:
        chladni.select(model, drop=[0, len(model)])
    assert beyond.value.found == str(len(model)) and f"below {len(model)}" in beyond.value.expected


def test_a_mode_is_added_by_a_new_fit(frf, model):
    few = chladni.fit(frf, modes=len(model) - 4)
    missing = [hz for hz in model.frequency_hz if np.min(np.abs(few.frequency_hz / hz - 1)) > 1e-3]
    more = chladni.select(few, add=missing, frf=frf)
    assert missing and all(np.min(np.abs(more.frequency_hz / hz - 1)) < 1e-4 for hz in missing)
    with pytest.raises(chladni.ChladniError) as wrong:
        chladni.select(few, add=missing)
    assert wrong.value.field == "add"


def test_frfs_of_records_are_those_of_the_filter():
    noise = np.random.default_rng(2).standard_normal((1, 16384))
    taps = np.array([0.5, 0.3, -0.2])
    answer = np.convolve(noise[0], taps)[: noise.shape[1]][None]
    frf = chladni.estimate(noise, answer, 1000.0, kind="accelerance", response_names=["1:+Z"], reference_names=["1:+Z"])
    z = np.exp(-2j * np.pi * frf.frequency_hz / 1000.0)
    assert np.max(np.abs(frf.values[0, 0] - np.polynomial.polynomial.polyval(z, taps))) < 0.05
    assert frf.kind == "accelerance" and frf.responses == ["1:+Z"]
    with pytest.raises(chladni.ChladniError) as uneven:
        chladni.estimate(noise, answer[:, :-1], 1000.0)
    assert uneven.value.field == "samples"
    with pytest.raises(chladni.ChladniError, match="h1"):
        chladni.estimate(noise, answer, 1000.0, estimator="magic")
    for field, value in (("block", -1), ("block", 256.5), ("block", "256"), ("block", 2), ("kind", None), ("kind", 3), ("reference_unit", None)):
        with pytest.raises(chladni.ChladniError) as wrong:
            chladni.estimate(noise, answer, 1000.0, **{field: value})
        assert wrong.value.field == field and str(value) in wrong.value.found and wrong.value.expected, field


def test_cmif_is_the_singular_values_of_each_line(frf):
    lines = chladni.cmif(frf)
    by_hand = np.linalg.svd(np.moveaxis(np.array(frf.values), 2, 0), compute_uv=False)
    assert lines.shape == by_hand.shape and np.allclose(lines, by_hand)


def test_the_stabilization_diagram_has_a_stable_pole_at_each_mode(frf, model):
    diagram = chladni.stabilization(frf)
    stable = diagram["frequency_hz"][diagram["stability"] == "stable"]
    assert set(diagram["stability"]) <= {"new", "frequency", "stable"} and len(diagram["order"]) == len(diagram["damping_ratio"])
    assert all(np.min(np.abs(stable - f)) < 0.01 * f for f in model.frequency_hz)


def test_scenes_are_dictionaries_and_masks_too(model):
    file = FIXTURES / "scene-corner.toml"
    import sys

    if sys.version_info >= (3, 11):
        import tomllib

        as_dict = tomllib.loads(file.read_text())
        assert tomllib.loads(chladni.scene_to_toml(as_dict)) == as_dict
        same = chladni.render(model, as_dict, method="fast").weights
        assert np.allclose(same, chladni.render(model, file, method="fast").weights)
    x, y = model.points_m[:, :2].T
    hot = (x < np.median(x)) & (y < np.median(y))
    drive = chladni.render(model, chladni.scene(model, 300.0, hot), method="fast")
    amplitude = np.abs(drive.velocity_m_per_s)
    assert amplitude[hot].mean() > 2 * amplitude[~hot].mean()
    assert drive.points_m.shape == (len(drive.responses), 2)
    with pytest.raises(ValueError, match="expected"):
        chladni.scene(model, 300.0, hot[:-1])
    with pytest.raises(ValueError, match="not both"):
        chladni.scene(model, 300.0, hot, cold=hot)
    as_numbers = chladni.scene(model, 300.0, hot.astype(float))
    assert as_numbers == chladni.scene(model, 300.0, hot)
    for mask in (np.where(hot, 1.0, np.nan), np.arange(len(hot)), hot.astype(str)):
        with pytest.raises(chladni.ChladniError, match="True or False") as refused:
            chladni.scene(model, 300.0, mask)
        assert refused.value.field == "hot"


def test_a_number_of_modes_is_a_number(model):
    scene = FIXTURES / "scene-corner.toml"
    counted = [chladni.render(model, scene, method="fast", modes=modes).weights for modes in (9, "9", np.int64(9))]
    assert all(np.array_equal(one, counted[0]) for one in counted)
    for field, word in (("modes", 0), ("actuators", 1.5), ("method", "hocus")):
        with pytest.raises(chladni.ChladniError) as refused:
            chladni.render(model, scene, **{field: word})
        assert refused.value.field == field and str(refused.value).count("; found") == 1


def test_a_report_is_one_page(model, frf, tmp_path):
    drive = chladni.render(model, FIXTURES / "scene-corner.toml", method="fast")
    chladni.report(tmp_path / "report.html", model, measured=frf, renderings=[drive])
    assert (tmp_path / "report.html").read_text().lstrip().lower().startswith("<!doctype html")
    with pytest.raises(chladni.ChladniError) as exists:
        chladni.report(tmp_path / "report.html", model)
    assert exists.value.code == 73


def test_names_that_users_of_other_packages_look_for(model):
    poles = model.get_poles()
    assert np.allclose(np.abs(poles), 2 * np.pi * model.nat_freq) and np.allclose(-poles.real / np.abs(poles), model.nat_xi)
    assert model.A.shape == (len(model.responses), len(model))
    omega_d = poles.imag
    assert np.allclose(model.A[0] * 2j * omega_d, model.shapes[:, 0] * model.participations[:, 0])


def test_notebooks_show_tables(model, frf):
    assert f"{model.frequency_hz[0]:.6g}" in model._repr_html_() and "mobility" in frf._repr_html_()
    drive = chladni.render(model, FIXTURES / "scene-corner.toml", method="fast")
    assert drive.references[0] in drive._repr_html_()


def test_a_table_for_pandas(model):
    pytest.importorskip("pandas", reason="pandas is not installed")
    table = model.to_dataframe()
    assert list(table["frequency_hz"]) == list(model.frequency_hz) and len(table) == len(model)
    assert len(chladni.compare(model, model).to_dataframe()) == len(model)


def test_pictures_are_drawn_where_matplotlib_is(model, frf):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    axes = model.plot_frf(model.responses[0], 0, frf=frf)
    assert np.allclose(axes.lines[1].get_ydata(), np.abs(model.synthesise(np.array(frf.frequency_hz))[0, 0]))
    assert model.plot_shape(0).get_xlabel() == "x, m"
    assert chladni.render(model, FIXTURES / "scene-corner.toml", method="fast").plot_field().collections
    with pytest.raises(ValueError, match="no DOF"):
        model.plot_frf("999:+Z")


def test_importing_the_package_imports_nothing_heavy():
    import subprocess
    import sys

    asked = "import sys, chladni; print(sorted({'matplotlib', 'pandas', 'tqdm'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_progress_is_a_bar(frf, capsys):
    chladni.fit(frf, progress=True)
    assert "fit" in capsys.readouterr().err


BURST = {
    "frequency_hz": 330.0,
    "zones": {"grid": [2, 2], "hot": [1], "cells_m": [0.0, 0.0, 0.268, 0.170]},
    "time": {"burst": [{"duration_s": 0.1, "ramp_s": 0.015}]},
}


def test_bursts_are_played_judged_and_written(truth, tmp_path):
    played = chladni.play(truth, BURST, method="mls")
    assert played.indices["peak"]["ever_over_ratio"] == 0.0 and "modal" not in repr(played)
    plain = chladni.play(truth, BURST, method="mls", ramps="plain")
    assert plain.indices["peak"]["worst_cold_db"] > played.indices["peak"]["worst_cold_db"] + 1.0
    assert played.time_s.shape == played.cold_db.shape == played.hot_db.shape == played.largest_drive.shape
    drive = played.drive(44_100)
    assert drive.shape == (int(np.ceil(0.1 * 44_100)) + 1, len(played.references))
    for form, step in (("f32", 2.0**-24), ("i16", 2.0**-15)):
        played.save(tmp_path / f"{form}.wav", 44_100, format=form)
        sidecar = json.loads((tmp_path / f"{form}.json").read_text())
        scale = sidecar["channels"][0]["full_scale"]
        assert sidecar["format"] == "chladni.signal" and sidecar["frames"] == len(drive)
        bytes_of = (tmp_path / f"{form}.wav").read_bytes()
        samples = np.frombuffer(bytes_of[-drive.size * (4 if form == "f32" else 2) :], dtype="<f4" if form == "f32" else "<i2")
        values = samples.astype(float).reshape(drive.shape) * (scale if form == "f32" else scale * 2.0**-15)
        assert np.abs(values - drive).max() <= 0.51 * step * scale
    played.save(tmp_path / "drive.npz", 44_100)
    held = np.load(tmp_path / "drive.npz")
    assert np.array_equal(held["drive"], drive) and list(held["reference"]) == played.references
    channels = [(k + 2, name, 2.0) for k, name in enumerate(played.references)]
    moved = played.drive(44_100, channel_map=channels)
    assert moved.shape[1] == drive.shape[1] + 1 and np.all(moved[:, 0] == 0.0) and np.array_equal(moved[:, 1:], drive)
    with pytest.raises(chladni.ChladniError, match="full_scale|clips"):
        played.save(tmp_path / "loud.wav", full_scale=1e-9)
    with pytest.raises(chladni.ChladniError, match="rate_hz"):
        played.drive(600)
    assert not (tmp_path / "loud.wav").exists()


def test_weights_are_judged_in_time_where_the_scene_has_one(truth):
    drive = chladni.render(truth, BURST, method="mls")
    judged = chladni.evaluate(drive, BURST, truth)
    assert judged["time"] == chladni.play(truth, BURST, rendering=drive).indices
