"""What the command line refuses, Python refuses too; what memory cannot hold is an error, not the end of the interpreter."""

import json
import subprocess
import sys
from pathlib import Path

import chladni
import numpy as np
import pytest
from test_chladni import FREQUENCY_HZ, mobility

FIXTURES = Path(__file__).parents[2] / "fixtures"
SCENE = FIXTURES / "scene-corner.toml"
NAMES = [f"{node}:+Z" for node in range(1, 7)]


@pytest.fixture(scope="module")
def frf():
    shapes = np.random.default_rng(7).standard_normal((3, 6))
    return chladni.FrfSet(FREQUENCY_HZ, mobility(shapes, shapes[:, :2]), responses=NAMES, references=NAMES[:2])


@pytest.fixture(scope="module")
def model(frf):
    return chladni.fit(frf)


@pytest.fixture(scope="module")
def panel():
    return chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)


def refused(field, call, *arguments, **keywords):
    with pytest.raises(chladni.ChladniError) as wrong:
        call(*arguments, **keywords)
    assert wrong.value.field == field and wrong.value.found and wrong.value.expected, vars(wrong.value)
    return wrong.value


def test_arrays_that_memory_cannot_hold_are_refused(model):
    error = refused("values", chladni.FrfSet, np.arange(1.0, 11.0), np.broadcast_to(1j, (10**5,) * 3))
    assert "memory" in str(error) and "GiB" in error.found and "100000 x 100000 x 100000" in error.found and error.help
    assert "memory" in str(refused("frequency_hz", model.synthesise, np.broadcast_to(1.0, 10**15)))


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory is one of Linux")
def test_a_synthesis_beyond_the_limit_of_the_process_is_refused(model, tmp_path):
    model.save(tmp_path / "model.json")
    script = """
import resource, sys
import chladni, numpy as np
model, lines = chladni.load_model(sys.argv[1]), np.linspace(1, 1000, 20_000_000)
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
try:
    model.synthesise(lines)
except chladni.ChladniError as error:
    print(error.field, error.found)
"""
    run = subprocess.run([sys.executable, "-c", script, tmp_path / "model.json"], capture_output=True, text=True, timeout=120)
    assert run.stdout.split()[:3] == ["frequency_hz", "3.576", "GiB"], run


@pytest.mark.parametrize("decay", [-1.0, 0.0, np.nan, np.inf])
def test_a_decay_of_a_window_is_a_number_above_0(frf, decay):
    field = "exponential_window_per_s"
    refused(field, chladni.fit, frf, exponential_window_per_s=decay)
    refused(field, chladni.solve_poles, chladni.reduce_block(frf, 0), exponential_window_per_s=decay)
    noise = np.random.default_rng(5).standard_normal((1, 4096))
    refused(field, chladni.estimate, noise, noise, 1000.0, exponential_window_per_s=decay)


def test_numbers_out_of_range_are_refused(frf, model):
    for least_mac in (-1.0, 2.0, np.nan):
        assert "from 0 to 1" in refused("least_mac", chladni.compare, model, model, least_mac=least_mac).expected
    for bands in (0, 10**6, -1, 1.5):
        assert "1 to 1000" in refused("rfp_bands", chladni.fit, frf, method="rfp", rfp_bands=bands).expected
    assert len(chladni.fit(frf, method="rfp", rfp_bands=np.int64(3))) > 0


def test_extensions_that_name_no_format_are_refused(panel, tmp_path):
    drive = chladni.render(panel[1], SCENE, method="fast")
    for name in ("w.h5", "w"):
        assert refused("path", drive.save, tmp_path / name).expected == ".json"
    played = chladni.play(panel[1], {"frequency_hz": 330.0, "zones": {"grid": [2, 2], "hot": [1]}}, method="mls")
    assert ".wav" in refused("path", played.save, tmp_path / "drive.mp3").expected
    assert not list(tmp_path.iterdir())
    drive.save(tmp_path / "w.json")


def test_a_sound_file_and_its_sidecar_are_written_both_or_not_at_all(panel, tmp_path):
    burst = {"frequency_hz": 330.0, "zones": {"grid": [2, 2], "hot": [1]}, "time": {"burst": [{"duration_s": 0.1, "ramp_s": 0.015}]}}
    played = chladni.play(panel[1], burst, method="mls")
    sound, sidecar = tmp_path / "x.wav", tmp_path / "x.json"
    for old, new in ((sound, sidecar), (sidecar, sound)):
        old.write_text("old")
        with pytest.raises(chladni.ChladniError) as exists:
            played.save(sound)
        assert exists.value.code == 73 and old.read_text() == "old" and list(tmp_path.iterdir()) == [old], new
        old.unlink()
    played.save(sound)
    assert sound.exists() and sidecar.exists()


def test_a_mode_is_added_by_the_frfs_of_the_model_alone(model, frf, panel):
    strange = refused("frf", chladni.select, model, add=[130.0], frf=chladni.FrfSet(FREQUENCY_HZ, frf.values, references=["8:+Z", "9:+Z"]))
    assert "no DOF pair" in str(strange) and "measured" not in strange.help
    per_volt = chladni.FrfSet(FREQUENCY_HZ, frf.values, responses=NAMES, references=NAMES[:2], reference_unit="V")
    assert refused("frf", chladni.select, model, add=[130.0], frf=per_volt).expected == "N"
    with pytest.raises(chladni.ChladniError, match="method auto"):
        chladni.select(chladni.fit(frf, method="lean"), add=[130.0], frf=frf)
    moved = chladni.FrfSet(FREQUENCY_HZ, np.roll(frf.values, 150, axis=2), responses=NAMES, references=NAMES[:2])
    with pytest.warns(UserWarning, match="another structure"):
        chladni.select(model, add=[130.0], frf=moved)


def test_what_no_scene_can_be_is_told(model, panel):
    refused("hot", chladni.scene, panel[1], 300.0, None)
    with pytest.raises(chladni.ChladniError, match="frequency_hz"):
        chladni.render(panel[1], {})
    with pytest.raises(chladni.ChladniError, match="frequency_hz"):
        chladni.render(panel[1], {"frequency_hz": None})
    hot = np.arange(len(panel[1].responses)) < 3
    for zones in ({"polygon": []}, {"grid": [2, 2], "hot": [1]}, []):
        refused("zones", chladni.scene, panel[1], 300.0, hot, zones=zones)
    assert chladni.scene(panel[1], 300.0, hot, zones={"transition_m": 0.01})["zones"]["transition_m"] == 0.01
    for tones in (None, "loud", [260.0, "loud"], {"a": 1}):
        refused("frequency_hz", chladni.scene, panel[1], tones, hot)


def test_masks_take_what_dictionaries_take(panel):
    truth = panel[1]
    x, y = truth.points_m[:, :2].T
    hot = (x < np.median(x)) & (y < np.median(y))
    for tones in ([260.0, 335.0], np.array([260, 335]), (260.0, [330.0, 340.0])):
        drive = chladni.render(truth, chladni.scene(truth, tones, hot), method="fast")
        assert drive.frequency_hz == 260.0 and drive.other_tones
    assert chladni.scene(truth, np.float32(300), hot) == chladni.scene(truth, 300, hot) == chladni.scene(truth, 300.0, hot)


def test_masks_of_models_with_three_axes_select_what_moves_along_z(panel):
    """The same panel, with two more responses at each point."""
    truth = panel[1]
    x, y = truth.points_m[:, :2].T
    hot = (x < np.median(x)) & (y < np.median(y))
    held = truth.to_dict()
    nodes = [name.split(":")[0] for name in truth.responses]
    held["responses"] = [f"{node}:{axis}" for node in nodes for axis in ("+X", "+Y", "+Z")]
    held["residual_terms"]["terms"] = []
    for mode in held["modes"]:
        mode["shape_std"] = np.repeat(mode["shape_std"], 3).tolist()
        for part in ("re", "im"):
            mode["shape"][part] = np.repeat(mode["shape"][part], 3).tolist()
    three = chladni.Model._from_json(json.dumps(held))
    assert chladni.scene(three, 300.0, np.repeat(hot, 3)) == chladni.scene(truth, 300.0, hot)
    assert len(chladni.render(three, chladni.scene(three, 300.0, np.repeat(hot, 3)), method="fast").responses) == len(nodes)
    held["responses"] = [name.replace("+Z", "+RZ") for name in held["responses"]]
    refused("model", chladni.scene, chladni.Model._from_json(json.dumps(held)), 300.0, np.repeat(hot, 3))


def test_models_without_modes_keep_the_axes_of_arrays(model):
    empty = chladni.select(model, drop=range(len(model)))
    assert chladni.compare(empty, model).mac.shape == (0, len(model))
    assert chladni.compare(model, empty).mac.shape == chladni.compare(model, empty).mac_std.shape == (len(model), 0)
    assert chladni.compare(empty, empty).mac.shape == (0, 0)


def test_the_byte_order_does_not_change_the_precision(frf):
    for code in ("c8", "c16"):
        taken = [chladni.FrfSet(FREQUENCY_HZ, np.array(frf.values, dtype=order + code)).values for order in "<>"]
        assert taken[1].dtype == np.dtype(code) and np.array_equal(*taken)


def test_one_pair_of_files_corrects(panel, tmp_path):
    truth = panel[1]
    drive = chladni.render(truth, SCENE, method="fast")
    weights, field = tmp_path / "weights-1.json", tmp_path / "field-1.csv"
    drive.save(weights)
    rows = [f"{name},{float(v.real)!r},{float(v.imag)!r}" for name, v in zip(drive.responses, drive.velocity_m_per_s * 1.02)]
    field.write_text("\n".join([f"# frequency_hz = {drive.frequency_hz}", "# unit = m/s", "response,re,im", *rows]) + "\n")
    listed = chladni.correct(truth, SCENE, [weights], [field])
    assert listed["weights"] == chladni.correct(truth, SCENE, str(weights), str(field))["weights"]
    assert listed["weights"] == chladni.correct(truth, SCENE, weights, field)["weights"]


def test_a_picture_shows_both_frfs_in_one_kind_and_unit(frf, model):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    omega = 2j * np.pi * FREQUENCY_HZ
    receptance = chladni.FrfSet(FREQUENCY_HZ, frf.values / omega, responses=NAMES, references=NAMES[:2], kind="receptance")
    axes = model.plot_frf(2, 1, frf=receptance)
    assert np.allclose(axes.lines[0].get_ydata(), np.abs(frf.values[2, 1])) and axes.get_ylabel() == "Mobility, (m/s)/N"
    voltage = chladni.FrfSet(FREQUENCY_HZ, frf.values, responses=NAMES, references=NAMES[:2], reference_unit="V")
    per_volt = chladni.fit(voltage)
    assert per_volt.reference_unit == "V" and per_volt.plot_frf().get_ylabel() == "Mobility, (m/s)/V"
    assert "N" in refused("frf", model.plot_frf, frf=voltage).expected
    lacking = chladni.FrfSet(FREQUENCY_HZ, frf.values[:3], responses=NAMES[:3], references=NAMES[:2])
    assert refused("frf", model.plot_frf, 5, frf=lacking).found == "6:+Z"


def test_places_of_pictures_are_those_of_numpy(model, panel):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    last = model.plot_frf(-1, np.int64(-1))
    assert last.get_title() == "6:+Z from 2:+Z"
    assert np.array_equal(last.lines[0].get_ydata(), model.plot_frf(5, 1).lines[0].get_ydata())
    for field, places in (("response", (6, 0)), ("reference", (0, -3)), ("response", (1.5, 0)), ("response", (None, 0))):
        refused(field, model.plot_frf, *places)
    truth = panel[1]
    assert truth.plot_shape(-1).get_title() == truth.plot_shape(len(truth) - 1).get_title()
    refused("mode", truth.plot_shape, len(truth))


def test_a_picture_of_one_frf_synthesises_one(model, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    lines = np.linspace(30.0, 200.0, 500)
    drawn = np.abs(model.synthesise(lines)[3, 1])

    def all_of_them(*_):
        raise AssertionError("all FRFs")

    monkeypatch.setattr(chladni.Model, "synthesise", all_of_them)
    assert np.allclose(model.plot_frf(3, 1, frequency_hz=lines).lines[0].get_ydata(), drawn, rtol=1e-12)
