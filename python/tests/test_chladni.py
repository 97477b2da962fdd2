"""The package against numbers that it did not make: closed forms of single modes, NumPy's own sums, the command line's contract."""

import json
from pathlib import Path

import chladni
import numpy as np
import pytest

FIXTURES = Path(__file__).parents[2] / "fixtures"
FREQUENCY_HZ = np.arange(20.0, 240.0, 0.1)
NATURAL_HZ = np.array([52.0, 101.0, 160.0])
LOSS = np.array([0.012, 0.01, 0.015])


def mobility(shapes, participations):
    """v/F of structurally damped modes of unit modal mass, and white noise 60 dB below."""
    omega, omega_n = 2 * np.pi * FREQUENCY_HZ, 2 * np.pi * NATURAL_HZ
    factor = 1 / (omega_n[:, None] ** 2 * (1 + 1j * LOSS[:, None]) - omega**2)
    values = 1j * omega * np.einsum("ni,nj,nk->ijk", shapes, participations, factor)
    noise = np.random.default_rng(1)
    scale = 1e-3 * np.sqrt(np.mean(np.abs(values) ** 2) / 2)
    return values + scale * (noise.standard_normal(values.shape) + 1j * noise.standard_normal(values.shape))


@pytest.fixture(scope="module")
def shapes():
    return np.random.default_rng(7).standard_normal((3, 6))


@pytest.fixture(scope="module")
def frf(shapes):
    names = [f"{node}:+Z" for node in range(1, 7)]
    return chladni.FrfSet(FREQUENCY_HZ, mobility(shapes, shapes[:, :2]), responses=names, references=names[:2])


@pytest.fixture(scope="module")
def model(frf):
    return chladni.fit(frf)


def test_modes_of_a_numpy_array_are_the_closed_form_ones(model, shapes):
    assert model.trusted and model.trust == ["sure"] * 3
    assert np.all(np.abs(model.frequency_hz - NATURAL_HZ) < 5 * model.frequency_std_hz)
    assert np.all(np.abs(model.loss_factor - LOSS) < 5 * model.loss_factor_std)
    # unit modal mass, the sign of a shape free
    signs = np.sign(np.sum(model.shapes.real * shapes, axis=1))[:, None]
    assert np.allclose(signs * model.shapes, shapes, atol=2e-2)
    assert np.allclose(model.damping_ratio, model.loss_factor / 2)


def test_names_of_other_packages_mean_the_same(model, frf):
    assert np.array_equal(model.nat_freq, model.frequency_hz) and np.array_equal(model.nat_xi, model.damping_ratio)
    assert np.allclose(np.diag(model.autoMAC()), 1)
    u = model.shapes
    by_hand = np.abs(u.conj() @ u.T) ** 2 / np.outer(np.sum(abs(u) ** 2, 1), np.sum(abs(u) ** 2, 1))
    assert np.allclose(model.mac(), by_hand)
    rebuilt = model.FRF_reconstruct(FREQUENCY_HZ)
    assert np.linalg.norm(rebuilt - frf.values) < 3e-3 * np.linalg.norm(frf.values)


def test_arrays_out_are_views_and_read_only(frf):
    assert frf.values.base is not None and not frf.values.flags.writeable
    with pytest.raises(ValueError):
        frf.values[0, 0, 0] = 0
    kept = frf.values
    assert np.shares_memory(kept, frf.values)
    single = chladni.FrfSet(frf.frequency_hz, frf.values.astype(np.complex64))
    assert single.values.dtype == np.complex64 and np.array_equal(single.values, frf.values.astype(np.complex64))


def test_files_come_back_bit_by_bit(frf, model, tmp_path):
    frf.save(tmp_path / "set.h5")
    again = chladni.read(tmp_path / "set.h5")
    assert np.array_equal(again.values, frf.values) and again.responses == frf.responses and again.kind == "mobility"
    model.save(tmp_path / "model.json")
    loaded = chladni.load_model(tmp_path / "model.json")
    assert np.array_equal(loaded.frequency_hz, model.frequency_hz) and np.array_equal(loaded.shapes, model.shapes)
    assert json.loads(model.to_json())["format"] == "chladni.model" == model.to_dict()["format"]
    early = chladni.read(tmp_path / "set.h5", delay_s=1e-3)
    assert np.allclose(early.values, frf.values * np.exp(2j * np.pi * 1e-3 * frf.frequency_hz))
    with pytest.raises(chladni.ChladniError) as refused:
        frf.save(tmp_path / "set.h5")
    assert refused.value.code == 73 and str(tmp_path / "set.h5") == refused.value.file


def test_what_files_do_not_say_is_declared_as_on_the_command_line(tmp_path):
    for number in (1, 2):
        (tmp_path / f"p{number}.csv").write_text("f,mag [m/s/N],phase\n1,2,1.5\n2,4,-1.5\n")
    files = [tmp_path / "p1.csv", tmp_path / "p2.csv"]
    with pytest.raises(chladni.ChladniError, match="phase"):
        chladni.read(files)
    hammer = chladni.read(files, phase_unit="rad", response=7, reference=[1, 7])
    assert (hammer.responses, hammer.references) == (["7:+Z"], ["1:+Z", "7:+Z"])
    assert np.allclose(hammer.values[0, 0], [2 * np.exp(1.5j), 4 * np.exp(-1.5j)])
    rows = [("5:+Z", "101:+Z"), ("5:+Z", "102:-X")]
    listed = chladni.read(files, phase_unit="deg", dofs=rows)
    assert (listed.responses, listed.references) == (["5:+Z"], ["101:+Z", "102:-X"])
    (tmp_path / "dofs.txt").write_text("response,reference\n5:+Z,101:+Z\n5:+Z,102:-X\n")
    assert chladni.read(files, phase_unit="deg", dofs=tmp_path / "dofs.txt").references == listed.references
    with pytest.raises(chladni.ChladniError) as missing:
        chladni.read(files, dofs=tmp_path / "none.txt")
    assert missing.value.code == 66
    for name, value in (("phase_unit", "gon"), ("duplicates", "both")):
        with pytest.raises(chladni.ChladniError) as word:
            chladni.read(files, **{name: value})
        assert word.value.field == name and word.value.found == value


def test_errors_carry_the_fields_of_the_contract(frf, tmp_path):
    with pytest.raises(chladni.ChladniError) as missing:
        chladni.read(tmp_path / "nothing.uff")
    assert (missing.value.code, missing.value.kind) == (66, "no_input") and missing.value.dataset is None
    (tmp_path / "bad.csv").write_text("frequency_hz,re,im\n1,2,3\n2,2,abc\n")
    with pytest.raises(chladni.ChladniError) as bad:
        chladni.read(tmp_path / "bad.csv", frf_kind="mobility")
    assert bad.value.code == 65 and bad.value.line == 3 and "abc" in bad.value.found
    with pytest.raises(chladni.ChladniError) as word:
        chladni.fit(frf, method="magic")
    assert word.value.field == "method" and word.value.found == "magic" and "auto" in word.value.expected
    for modes in (-1, 0, 2.5):
        with pytest.raises(chladni.ChladniError) as number:
            chladni.fit(frf, modes=modes)
        assert (number.value.field, number.value.found) == ("modes", str(modes)) and "above 0" in number.value.expected
    for field in ("kind", "reference_unit"):
        with pytest.raises(chladni.ChladniError) as none:
            chladni.FrfSet(FREQUENCY_HZ, frf.values, **{field: None})
        assert none.value.field == field and none.value.found == "None" and none.value.expected
    with pytest.raises(chladni.ChladniError, match="no line of the data lies in the band") as outside:
        chladni.fit(frf, band=(1e4, 2e4))
    assert (outside.value.field, outside.value.found) == ("band", "10000:20000 Hz")
    assert "overlaps the data" in outside.value.expected and "within the data" in outside.value.help
    with pytest.raises(chladni.ChladniError) as sizes:
        chladni.FrfSet(FREQUENCY_HZ[:-1], frf.values)
    assert sizes.value.field == "frequency_hz"


def test_numbers_of_any_type_are_an_axis_and_values_may_be_lists(model):
    axis = np.arange(2, 12)
    values = np.ones((2, 1, 10), complex)
    for given in (axis, axis.astype(np.float32), axis.tolist(), axis[::-1][::-1]):
        taken = chladni.FrfSet(given, values.tolist(), nodes_m=[[0, 0, 0], [1, 0, 0], [2, 0, 0]])
        assert np.array_equal(taken.frequency_hz, axis) and taken.values.dtype == np.complex128
        assert np.array_equal(model.synthesise(given), model.synthesise(axis.astype(float)))
    noise = np.random.default_rng(3).integers(-100, 100, (1, 4096))
    casts = (np.asarray, lambda a: a.astype(np.float32), lambda a: a.tolist(), lambda a: a.astype(float))
    again = [chladni.estimate(cast(noise), cast(np.roll(noise, 1) + noise), 1000).values for cast in casts]
    assert all(np.array_equal(one, again[-1], equal_nan=True) for one in again)


def test_masked_values_are_missing():
    values = np.ma.masked_greater(np.arange(10.0).reshape(1, 1, 10) + 0j, 7.5)
    taken = chladni.FrfSet(np.arange(1, 11), values).values
    assert np.isnan(taken[0, 0, 8:]).all() and np.array_equal(taken[0, 0, :8], np.arange(8))
    axis = np.ma.array([1, 2, 3], mask=[False, True, False])
    with pytest.raises(chladni.ChladniError):
        chladni.FrfSet(axis, np.ones((1, 1, 3), complex))


def test_records_with_gaps_and_dofs_that_occur_twice_are_refused():
    noise = np.random.default_rng(5).standard_normal((1, 4096))
    pair = np.vstack([noise, 2 * noise])
    gap = pair.copy()
    gap[1, 7] = np.nan
    masked = np.ma.masked_where(np.isnan(gap), gap)
    for responses in (gap, masked):
        with pytest.raises(chladni.ChladniError, match="not finite"):
            chladni.estimate(noise, responses, 1000)
    with pytest.raises(chladni.ChladniError, match="occurs twice"):
        chladni.estimate(noise, pair, 1000, response_names=["1:+Z", "1:+Z"])


@pytest.mark.parametrize(
    "field, call",
    [
        ("frequency_hz", lambda frf, model: chladni.FrfSet(["a"], np.ones((1, 1, 1), complex))),
        ("frequency_hz", lambda frf, model: chladni.FrfSet([1j], np.ones((1, 1, 1), complex))),
        ("frequency_hz", lambda frf, model: chladni.FrfSet([[1.0]], np.ones((1, 1, 1), complex))),
        ("frequency_hz", lambda frf, model: model.synthesise([1.0, np.nan])),
        ("frequency_hz", lambda frf, model: model.synthesise([-1.0])),
        ("frequency_hz", lambda frf, model: model.synthesise([[1.0], [1.0, 2.0]])),
        ("values", lambda frf, model: chladni.FrfSet([1.0], np.ones((1, 1, 1)))),
        ("values", lambda frf, model: chladni.FrfSet([], np.ones((1, 1, 0), complex))),
        ("values", lambda frf, model: chladni.FrfSet([1.0], np.ones((0, 1, 1), complex))),
        ("nodes_m", lambda frf, model: chladni.FrfSet([1.0], np.ones((1, 1, 1), complex), nodes_m=[[0, 0, np.nan]])),
        ("nodes_m", lambda frf, model: chladni.FrfSet([1.0], np.ones((1, 1, 1), complex), nodes_m=[[0, 0]])),
        ("references", lambda frf, model: chladni.estimate([["a"]], [[1.0]], 1000.0)),
        ("modes", lambda frf, model: chladni.fit(frf, modes=0)),
        ("band", lambda frf, model: chladni.fit(frf, band=(100, 50))),
        ("band", lambda frf, model: chladni.fit(frf, band=(100,))),
        ("band", lambda frf, model: chladni.fit(frf, band=[100, "high"])),
        ("band", lambda frf, model: chladni.stabilization(frf, band=(100, 50))),
    ],
)
def test_what_no_array_or_option_can_be_names_the_argument(frf, model, field, call):
    with pytest.raises(chladni.ChladniError) as refused:
        call(frf, model)
    assert refused.value.field == field and refused.value.found and refused.value.expected and refused.value.code == 2


def test_progress_is_told_and_its_errors_come_through(frf):
    stages = []
    chladni.fit(frf, progress=stages.append)
    assert "sketch" in stages and "shapes" in stages

    def fail(_):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        chladni.fit(frf, progress=fail)


def test_a_panel_is_simulated_fitted_and_driven():
    frf, truth = chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)
    model = chladni.fit(frf)
    assert model.trusted and len(model) == len(truth)
    assert np.allclose(model.frequency_hz, truth.frequency_hz, rtol=1e-4)
    assert np.all(np.diag(model.mac(truth)) > 0.99)
    scene = FIXTURES / "scene-corner.toml"
    drive = chladni.render(model, scene, method="fast")
    assert drive.weights.shape == (len(drive.references),) and drive.velocity_m_per_s.shape == (len(drive.responses),)
    assert drive.to_dict()["format"] == "chladni.weights"
    judged = chladni.evaluate(drive, scene.read_text(), frf)
    assert 0 <= judged["indices"]["points"]["min_ratio"] <= 1


def test_a_measured_field_corrects_and_calibrates(tmp_path):
    _, truth = chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)
    scene = (FIXTURES / "scene-corner.toml").read_text()
    drive = chladni.render(truth, scene, method="fast")
    drive.save(tmp_path / "w0.json")
    rows = [f"{name},{float(v.real)!r},{float(v.imag)!r}" for name, v in zip(drive.responses, drive.velocity_m_per_s * 1.02)]
    head = [f"# frequency_hz = {drive.frequency_hz}", "# unit = m/s", "response,re,im"]
    (tmp_path / "f0.csv").write_text("\n".join(head + rows) + "\n")
    learned = tmp_path / "rig.json"
    corrected = chladni.correct(truth, scene, [tmp_path / "w0.json"], [tmp_path / "f0.csv"], calibration=learned)
    assert corrected["correction"]["iteration"] == 1 and corrected["format"] == "chladni.weights"
    calibration = json.loads(learned.read_text())
    gains = [gain["re"] for gain in calibration["gains"]]
    assert len(gains) == len(drive.references) and abs(np.mean(gains) - 1.02) < 0.02
    with pytest.raises(chladni.ChladniError):
        chladni.correct(truth, scene, [tmp_path / "w0.json"], [])


def test_a_correction_leaves_its_inputs_and_other_files_alone(tmp_path):
    _, truth = chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)
    scene = (FIXTURES / "scene-corner.toml").read_text()
    drive = chladni.render(truth, scene, method="fast")
    weights, field, kept = (tmp_path / name for name in ("w0.json", "f0.csv", "kept.json"))
    drive.save(weights)
    rows = [f"{name},{float(v.real)!r},{float(v.imag)!r}" for name, v in zip(drive.responses, drive.velocity_m_per_s)]
    field.write_text("\n".join([f"# frequency_hz = {drive.frequency_hz}", "# unit = m/s", "response,re,im", *rows]) + "\n")
    kept.write_text("kept")
    scene_file = tmp_path / "scene.toml"
    scene_file.write_text(scene)
    before = {path: path.read_text() for path in tmp_path.iterdir()}
    new = tmp_path / "new.json"
    for files in (
        {"output": weights, "force": True},
        {"calibration": field, "force": True},
        {"output": new, "calibration": new},
        {"output": new, "calibration": kept},
        {"output": tmp_path / "missing" / "w.json"},
        {"output": scene_file, "force": True},
    ):
        with pytest.raises(chladni.ChladniError):
            chladni.correct(truth, scene_file, [weights], [field], **files)
        assert {path: path.read_text() for path in tmp_path.iterdir()} == before, files
    corrected = chladni.correct(truth, scene, [weights], [field], output=new, calibration=kept, force=True)
    assert json.loads(new.read_text()) == corrected and json.loads(kept.read_text())["gains"]
