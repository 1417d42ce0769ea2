"""Fits beside SciPy's, and tables in the hands of polars, pandas and pyarrow."""

import csv
from pathlib import Path

import numpy as np
import pytest

import stillpoint

ROOT = Path(__file__).resolve().parents[2]
FITS = ROOT / "scenarios" / "fits"
G = 9.80665


def columns(name):
    with open(FITS / name, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return np.array(rows[1:], dtype=float).T


def test_standard_errors_are_those_of_curve_fit():
    optimize = pytest.importorskip("scipy.optimize")
    force, degrees = columns("test_rig_static.csv")
    angle = np.radians(degrees)

    def model(force, stiffness, rest):
        balance = lambda f: lambda q: stiffness * (q - rest) + (1.2 * G * 0.2 - f * 0.4) * np.cos(q)
        return np.array([optimize.brentq(balance(f), -1.5, 1.5, xtol=1e-15) for f in force])

    values, covariance = optimize.curve_fit(model, force, angle, p0=[25.0, 0.0], xtol=1e-14, ftol=1e-14)
    scene = stillpoint.load(FITS / "test_rig.toml")
    fit = scene.fit({"weight.force[2]": force, "angle": angle}, ["arm.stiffness", "arm.rest"])
    assert fit.converged and list(fit.values) == ["arm.stiffness", "arm.rest"]
    # curve_fit's Jacobian is a forward difference: it has some 1e-8 of the values, and errors some 1e-6.
    np.testing.assert_allclose(list(fit.values.values()), values, rtol=1e-6)
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-4)
    np.testing.assert_allclose(fit.residuals["angle"], model(force, *values) - angle, atol=1e-8)
    # The file with its units is the same table, and the fitted scene answers as the model.
    again = scene.fit(FITS / "test_rig_static.csv", {"arm.stiffness": None, "arm.rest": (0.0, -1.0, 1.0)})
    assert again.values == pytest.approx(fit.values, rel=1e-9)
    rest = fit.scene.equilibrium()
    assert rest.outputs["angle"] == pytest.approx(model([0.0], *fit.values.values())[0], abs=1e-9)
    assert "arm.stiffness" in repr(fit) and "<table>" in fit._repr_html_()


def test_a_run_is_fitted():
    time, degrees = columns("test_rig_swing.csv")
    scene = stillpoint.load(FITS / "test_rig.toml")
    fit = scene.fit({"time": time, "angle": np.radians(degrees)}, ["arm.stiffness", "arm.rest", "arm.damping=0.1"], run=True)
    # The data were made with these, and noise.
    for address, true in {"arm.stiffness": 32.5, "arm.rest": 0.12, "arm.damping": 0.18}.items():
        assert abs(fit.values[address] - true) < 4 * fit.errors[address]


def test_what_does_not_fit_together_is_said():
    scene = stillpoint.load(FITS / "test_rig.toml")
    data = {"weight.force[2]": [0.0, -10.0], "angle": [0.05, 0.0]}
    with pytest.raises(ValueError, match="did you mean `angle`"):
        scene.fit({**data, "angel": [0.1, 0.2]}, ["arm.stiffness"])
    with pytest.raises(ValueError, match="did you mean `stiffness`"):
        scene.fit(data, ["arm.stifness"])
    with pytest.raises(TypeError, match="a list of addresses"):
        scene.fit(data, "arm.stiffness")
    with pytest.raises(ValueError, match="rows"):
        scene.fit({"weight.force[2]": [0.0], "angle": [0.05, 0.0]}, ["arm.stiffness"])


def test_what_runs_off_has_not_converged():
    scene = stillpoint.load(FITS / "test_rig.toml")
    fit = scene.fit({"weight.force[2]": [0.0, -5.0, -9.0], "angle": [0.05, 0.09, 0.12]}, ["arm.stiffness"])
    assert not fit.converged and np.isnan(fit.errors["arm.stiffness"])
    assert "runs off" in repr(fit) and "no minimum" in fit.notes[0]


def run():
    return stillpoint.load(ROOT / "scenarios" / "spring_arm.toml").run(0.5)


def test_runs_are_arrow_tables_that_share_their_numbers():
    pyarrow = pytest.importorskip("pyarrow")
    result = run()
    table = pyarrow.table(result)
    assert table.column_names == ["time", *result.columns]
    for name in table.column_names:
        np.testing.assert_array_equal(table[name].to_numpy(), result[name])
    assert table.schema.field("time").metadata[b"unit"] == b"s"
    # Where they lie: no copy.
    address = table["kinetic"].chunk(0).buffers()[1].address
    assert address == result["kinetic"].__array_interface__["data"][0]
    # The table keeps them alive.
    expected = result["kinetic"].copy()
    del result
    np.testing.assert_array_equal(table["kinetic"].to_numpy(), expected)


def test_cells_without_an_answer_are_empty():
    pyarrow = pytest.importorskip("pyarrow")
    scene = stillpoint.load(ROOT / "scenarios" / "spring_arm.toml")
    sweep = scene.sweep({"shoulder_spring.stiffness": [330.0, -1.0]})
    table = pyarrow.RecordBatchReader.from_stream(sweep).read_all()
    assert table["ok"].to_pylist() == [True, False] and table["case"].to_pylist() == [0, 1]
    assert table["upper_arm.angle"].null_count == 1 and table["upper_arm.angle"][0].as_py() == sweep["upper_arm.angle"][0]
    assert table["error"].to_pylist()[0] is None and "stiffness" in table["error"].to_pylist()[1]


def test_polars_and_pandas_take_runs_sweeps_paths_and_modes():
    polars, pandas = pytest.importorskip("polars"), pytest.importorskip("pandas")
    result = run()
    frame = polars.DataFrame(result)
    assert frame.shape == (len(result.time), len(result) + 1)
    assert frame["kinetic"].max() == result["kinetic"].max()
    scene = stillpoint.load(ROOT / "scenarios" / "spring_arm.toml")
    sweep = scene.sweep({"shoulder_spring.stiffness": [330.0, -1.0]})
    table = polars.DataFrame(sweep)
    assert table["ok"].to_list() == [True, False] and table["error"].null_count() == 1
    assert list(sweep) == table.columns
    if hasattr(pandas.DataFrame, "from_arrow"):
        assert list(pandas.DataFrame.from_arrow(result).columns) == frame.columns
    modes = polars.DataFrame(scene.equilibrium().modes)
    assert modes.columns == ["frequency", "damping_ratio", "decay_rate"] and len(modes) == len(scene.equilibrium().modes)
    path = scene.path("gravity[2]", 0.0, -9.80665)
    branch = polars.DataFrame(path.branches[0])
    assert branch.columns[0] == "gravity[2]" and set(branch["verdict"]) <= {"stable", "unstable", "neutral"}


def test_a_column_without_a_measurement_is_an_error():
    scene = stillpoint.load(FITS / "test_rig.toml")
    with pytest.raises(ValueError, match="nothing was measured in `angle`"):
        scene.fit({"angle": [float("nan")]}, ["arm.stiffness"])
