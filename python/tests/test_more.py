"""Sensitivities, controllers, stepping by hand, many runs, paths, recordings."""

import json
import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import stillpoint

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "scenarios"

SLIDER = {
    "gravity": [0, 0, 0],
    "simulate": {"start": "given", "duration": 2.0, "tolerance": 1e-11},
    "body": [
        {
            "name": "mass",
            "mass": 2.0,
            "hinge": {"type": "prismatic", "axis": [1, 0, 0], "stiffness": 50.0, "position": 0.3},
        }
    ],
    "motor": [{"name": "push", "type": "input", "hinge": "mass"}],
    "output": [
        {"name": "x", "type": "coordinate", "of": "mass"},
        {"name": "at", "type": "position", "of": {"body": "mass", "at": [0, 0, 0]}},
    ],
}


def program(*arguments):
    answer = subprocess.run([sys.executable, "-m", "stillpoint", *arguments], capture_output=True, text=True)
    return answer.returncode, answer.stdout, answer.stderr


def held(x, v, u, t):
    """The slider with its input held."""
    w, rest = math.sqrt(50.0 / 2.0), u / 50.0
    return rest + (x - rest) * math.cos(w * t) + v / w * math.sin(w * t), -(x - rest) * w * math.sin(w * t) + v * math.cos(w * t)


def test_sensitivities_are_those_of_the_program():
    path = str(SCENARIOS / "double_wishbone.toml")
    code, out, err = program("statics", path, "--json", "--sensitivity", "camber", "frequency[0]")
    assert code == 0, err
    told = json.loads(out)["sensitivities"]
    rest = stillpoint.load(path).equilibrium()
    # Distances of differences, and which way a number goes, may be others where one output is asked for alone.
    for name in ["camber", "frequency[0]"]:
        alone, floor = rest.sensitivity(name), 1e-12 * max(map(abs, filter(None, told[name].values())))
        assert alone == pytest.approx(told[name], rel=1e-8, abs=floor)
    bar = stillpoint.load(SCENARIOS / "four_bar.toml").equilibrium()
    several = bar.sensitivity("coupler point", ["gravity[0]"])["gravity[0]"]
    assert several == [bar.sensitivity(f"coupler point[{i}]", ["gravity[0]"])["gravity[0]"] for i in range(3)]
    with pytest.raises(KeyError, match="did you mean `camber`"):
        rest.sensitivity("cambr")
    with pytest.raises(KeyError, match="did you mean"):
        rest.sensitivity("camber", ["strut.lenght"])


def test_a_function_holds_its_input_between_instants():
    calls = []

    def control(time, outputs):
        calls.append((time, outputs["x"]))
        assert outputs["at"][0] == outputs["x"]
        return -30.0 * outputs["x"]

    run = stillpoint.describe(SLIDER).run(controller=control, period=0.125, rate=8)
    x, v = 0.3, 0.0
    for k in range(16):
        assert calls[k][0] == 0.125 * k and abs(calls[k][1] - x) < 1e-9 and abs(run["x"][k] - x) < 1e-9
        x, v = held(x, v, -30.0 * x, 0.125)
    assert len(calls) == 16 and abs(run.q[0] - x) < 1e-9
    assert abs(run["push.force"][0] + 9.0) < 1e-12


def test_inputs_by_name_in_a_list_or_left():
    scene = stillpoint.describe(SLIDER)
    runs = [scene.run(controller=lambda t, y: answer, period=0.5) for answer in (2.0, [2.0], {"push": 2.0})]
    assert runs[0].q[0] == runs[1].q[0] == runs[2].q[0] != scene.run(controller=lambda t, y: None, period=0.5).q[0]
    with pytest.raises(KeyError, match="did you mean `push`"):
        scene.run(controller=lambda t, y: {"pusch": 1.0}, period=0.5)
    with pytest.raises(ValueError, match="2 numbers for 1 inputs"):
        scene.run(controller=lambda t, y: [1.0, 2.0], period=0.5)
    with pytest.raises(ValueError, match="`push` is (nan|NaN)"):
        scene.run(controller=lambda t, y: math.nan, period=0.5)
    with pytest.raises(TypeError, match="belong together"):
        scene.run(controller=lambda t, y: 0.0)
    with pytest.raises(TypeError, match="sets the inputs .* is 'much' .* expected: a number, a list of 1, a dictionary with `push`"):
        scene.run(controller=lambda t, y: "much", period=0.5)
    with pytest.raises(TypeError, match="the input `push` is 'much' .* expected: a number"):
        scene.run(controller=lambda t, y: {"push": "much"}, period=0.5)


def test_an_exception_of_a_controller_ends_the_run_and_keeps_what_there_is():
    class Mine(Exception):
        pass

    def control(time, outputs):
        if time > 1.0:
            raise Mine("enough")
        return 0.0

    with pytest.raises(Mine, match="enough") as caught:
        stillpoint.describe(SLIDER).run(controller=control, period=0.25, rate=100)
    run = caught.value.run
    assert 1.23 < run.time[-1] <= 1.25 and abs(run["x"][-1] - held(0.3, 0, 0, run.time[-1])[0]) < 1e-9
    assert "enough" in run.as_dict()["error"]


def test_stepping_by_hand_is_a_run():
    scene = stillpoint.describe(SLIDER)
    simulator = scene.simulator()
    assert simulator.time == 0 and simulator.q[0] == 0.3 and simulator.inputs == {"push": 0.0}
    x, v = 0.3, 0.0
    for k in range(20):
        u = 5.0 * math.sin(k)
        simulator.step(0.1, inputs={"push": u} if k % 2 else [u])
        x, v = held(x, v, u, 0.1)
        assert abs(simulator.q[0] - x) < 1e-8 and abs(simulator.v[0] - v) < 1e-8 and simulator.inputs["push"] == u
        assert simulator.outputs["x"] == simulator.q[0]
    kept = pickle.loads(pickle.dumps(simulator.state()))
    simulator.advance(2.5)
    after = simulator.q[0]
    simulator.restore(kept)
    assert simulator.time == kept[0]
    simulator.advance(2.5)
    assert abs(simulator.q[0] - after) < 1e-9
    simulator.set(q=[0.1], v=[0.0], inputs=0.0, time=0.0)
    simulator.advance(0.7)
    assert abs(simulator.q[0] - held(0.1, 0, 0, 0.7)[0]) < 1e-8
    with pytest.raises(ValueError, match="not earlier than"):
        simulator.advance(0.1)
    with pytest.raises(ValueError, match="`q` has 2 numbers"):
        simulator.set(q=[0, 1])


def test_to_where_it_is_a_simulator_has_no_way_to_go():
    simulator = stillpoint.describe(SLIDER).simulator()
    simulator.advance(0)
    simulator.step(0.0, inputs=3.0)
    assert simulator.time == 0 and simulator.q[0] == 0.3 and simulator.inputs == {"push": 3.0}
    simulator.advance(0.5)
    simulator.advance(0.5)
    assert simulator.time == 0.5 and abs(simulator.q[0] - held(0.3, 0, 3.0, 0.5)[0]) < 1e-8


def test_stepping_by_hand_goes_on_as_contacts_do():
    """What bounces, is captured, or rests on feet is stepped through as a run goes, through pickles as well."""
    for name, until, step in [("contact/coin", 0.6, 0.05), ("contact/dropped_arm", 0.6, 0.1), ("contact/rubber_feet", 1.0, 0.1)]:
        simulator = stillpoint.load(SCENARIOS / f"{name}.toml").simulator()
        for k in range(1, round(until / step) + 1):
            simulator.advance(k * step)
            simulator.restore(pickle.loads(pickle.dumps(simulator.state())))
    assert [event["kind"] for event in simulator.events] == ["strikes"]


def test_stepping_by_hand_meets_stops():
    body = {"name": "ball", "mass": 1.0, "hinge": {"type": "prismatic", "axis": [0, 0, 1], "position": 1.0, "limits": {"low": 0.0, "restitution": 0.5}}}
    scene = stillpoint.describe(body=[body], simulate={"start": "given", "duration": 2.0, "tolerance": 1e-10})
    whole = scene.run(1.0)
    simulator = scene.simulator()
    for k in range(1, 11):
        simulator.advance(k / 10)
    np.testing.assert_allclose(simulator.q, whole.q, atol=1e-8)
    assert [event["kind"] for event in simulator.events] == [event["kind"] for event in whole.events] != []


def test_a_batch_has_the_bits_of_one_after_the_other():
    scene = stillpoint.load(SCENARIOS / "double_pendulum.toml", set={"simulate.duration": 1.0, "simulate.start": "given"})
    body = scene.bodies[0]
    sets = [{f"{body}.mass": 1.0 + 0.1 * k} for k in range(6)] + [{f"{body}.mass": -1.0}]
    together = scene.batch(sets, rate=20)
    for set_, run in zip(sets[:6], together):
        alone = scene.with_set(set_).run(rate=20)
        assert all((run[name] == alone[name]).all() for name in alone.columns) and len(run.time) == 21
    assert isinstance(together[6], stillpoint.SceneError)


def test_a_batch_in_lanes_agrees_to_round_off():
    scene = stillpoint.load(SCENARIOS / "double_pendulum.toml", set={"simulate.start": "given"})
    body = scene.bodies[0]
    sets = [{f"{body}.mass": 1.0 + 0.1 * k} for k in range(9)] + [{f"{body}.mass": -1.0}]
    for together, alone in zip(*(scene.batch(sets, 0.2, rate=20, integrator="dopri5", lanes=lanes) for lanes in (True, False))):
        if isinstance(alone, stillpoint.SceneError):
            assert str(together) == str(alone)
            continue
        assert together.columns == alone.columns and len(together.time) == 5
        for name in alone.columns:
            np.testing.assert_allclose(together[name], alone[name], rtol=1e-9, atol=1e-9)
    fallen = {"body": [{"name": "a", "mass": 1.0, "hinge": {"type": "prismatic", "axis": [0, 0, 1]}}]}
    refused = stillpoint.describe(fallen).batch([{}, {"a.mass": 2.0}], 0.1)
    assert [type(one) for one in refused] == [stillpoint.NoEquilibrium] * 2 and not refused[0].answer.residual < 1e-9
    with pytest.raises(ValueError, match="`duration` is -1"):
        scene.batch(sets, -1)


def test_ctrl_c_ends_a_batch_that_is_being_prepared():
    scene = stillpoint.load(SCENARIOS / "chain_of_twenty.toml", set={"simulate.start": "equilibrium"})
    sets = [{"link[0].position": 0.001 * k} for k in range(20_000)]
    for after in (0.02, 0.3):
        threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        begun = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            scene.batch(sets, 0.01)
        assert time.monotonic() - begun < after + 5.0


def test_no_equilibrium_survives_a_pickle():
    fallen = stillpoint.parse('[[body]]\nname = "a"\nmass = 1.0\nhinge = { type = "prismatic", axis = [0, 0, 1] }\n')
    with pytest.raises(stillpoint.NoEquilibrium) as raised:
        fallen.equilibrium()
    again = pickle.loads(pickle.dumps(raised.value))
    assert type(again) is stillpoint.NoEquilibrium and str(again) == str(raised.value)
    assert again.answer.notes == raised.value.answer.notes and (again.answer.q == raised.value.answer.q).all()


def test_the_package_says_that_it_has_no_library_of_fmus(tmp_path):
    call = [sys.executable, "-m", "stillpoint", "fmu", str(SCENARIOS / "pendulum.toml"), "-o", str(tmp_path / "x.fmu")]
    done = subprocess.run(call, capture_output=True, text=True)
    assert done.returncode == 2 and not (tmp_path / "x.fmu").exists()
    assert "the Python package has no library of FMUs" in done.stderr and "--library target/release/" in done.stderr


def test_what_is_wrong_with_numbers_is_said_of_the_number():
    scene = stillpoint.describe(SLIDER)
    simulator = scene.simulator()
    with pytest.raises(ValueError, match=r"`duration` is -1, allowed: a finite number ≥ 0"):
        simulator.step(-1)
    with pytest.raises(ValueError, match=r"`start\[0\]\[0\]` is NaN, allowed: finite numbers"):
        scene.run(1.0, start=([float("nan")], [0.0]))
    with pytest.raises(ValueError, match=r"`tolerance` is 1e-30, allowed: 1e-14 to 1"):
        scene.run(1.0, tolerance=1e-30)
    masked = np.ma.masked_array([0.1], mask=[True])
    with pytest.raises(ValueError, match="none masked"):
        scene.dynamics().acceleration(masked, [0.0])
    with pytest.raises(ValueError, match="none masked"):
        scene.run(1.0, start=(masked, [0.0]))
    with pytest.raises(ValueError, match="masked"):
        scene.with_set({"mass.position": masked})
    assert scene.dynamics().acceleration(np.ma.masked_array([0.1], mask=[False]), [0.0]) == scene.dynamics().acceleration([0.1], [0.0])


def test_a_sweep_has_a_row_a_case():
    table = stillpoint.load(SCENARIOS / "spring_arm.toml").sweep({"gravity[2]": [-9.81, -1.62, -3.71]})
    assert table["case"] == [0, 1, 2] and table["ok"] == [True] * 3 and list(table["gravity[2]"]) == [-9.81, -1.62, -3.71]
    for g, residual in zip((-9.81, -1.62, -3.71), range(3)):
        rest = stillpoint.load(SCENARIOS / "spring_arm.toml", set={"gravity[2]": g}).equilibrium()
        name = rest.positions and next(iter(rest.positions))
        column = next(key for key in table if key.startswith(f"{name}."))
        assert table[column][residual] == rest.positions[name][0]
    drawn = stillpoint.describe(SLIDER).sweep(vary={"mass.stiffness": "uniform(40, 60)"}, cases=8, seed=3, sample="sobol")
    assert len(drawn["case"]) == 8 and 40 <= min(drawn["mass.stiffness"]) < max(drawn["mass.stiffness"]) <= 60
    with pytest.raises(ValueError, match="did you mean `sobol`"):
        stillpoint.describe(SLIDER).sweep(vary={"mass.stiffness": "uniform(40, 60)"}, cases=8, sample="sobl")
    vary = {"mass.stiffness": "uniform(40, 60)"}
    for cases in (-1, 0, 10**10):
        with pytest.raises(ValueError, match=rf"`cases` is {cases}, allowed: a whole number from 1 to 1000000000"):
            stillpoint.describe(SLIDER).sweep(vary=vary, cases=cases)
    for seed in (-1, 2**64):
        with pytest.raises(ValueError, match=rf"`seed` is {seed}, allowed: a whole number from 0 to 18446744073709551615"):
            stillpoint.describe(SLIDER).sweep(vary=vary, cases=1, seed=seed)
    with pytest.raises(ValueError, match="mass.stifness|stiffness"):
        stillpoint.describe(SLIDER).sweep({"mass.stifness": [1, 2]})


def test_a_path_goes_around_folds():
    path = stillpoint.load(SCENARIOS / "snap_through.toml").path()
    kinds = [event["kind"] for branch in path.branches for event in branch.events]
    assert kinds.count("fold") == 2 and path.complete
    branch = path.branches[0]
    assert len(branch) == len(branch.parameter) == len(branch.verdicts) == len(branch.q) == len(branch.potential)
    with pytest.raises(KeyError, match="no output or coordinate"):
        branch["nothing"]
    slider = stillpoint.describe(SLIDER).path("mass.force", 0.0, 10.0, at=[5.0])
    branch = slider.branches[0]
    np.testing.assert_allclose(branch["x"], branch.parameter / 50.0, atol=1e-12)
    assert set(branch.verdicts) == {"stable"} and 5.0 in branch.parameter
    with pytest.raises(ValueError, match="which number moves"):
        stillpoint.describe(SLIDER).path()


def test_runs_become_recordings_and_come_back(tmp_path):
    run = stillpoint.load(SCENARIOS / "stops.toml").run(1.0, rate=50)
    run.save(tmp_path / "run.mcap")
    again = stillpoint.open(tmp_path / "run.mcap")
    assert again.columns == run.columns and again.units == run.units and again.as_dict() == run.as_dict()
    assert all((again[name] == run[name]).all() for name in run.columns) and (again.time == run.time).all()
    assert (again.q == run.q).all() and again.events == run.events
    code, out, err = program("info", str(tmp_path / "run.mcap"), "--json")
    assert code == 0, err
    pickled = pickle.loads(pickle.dumps(run))
    assert all((pickled[name] == run[name]).all() for name in run.columns)
    run.report(tmp_path / "run.html")
    assert "<html" in (tmp_path / "run.html").read_text(encoding="utf-8")[:200].lower()
    code, _, err = program("run", str(SCENARIOS / "stops.toml"), "--quiet", "--out", str(tmp_path / "program.mcap"), "--set", "simulate.duration=1", "--set", "record.rate=50")
    assert code == 0, err
    theirs = stillpoint.open(tmp_path / "program.mcap")
    assert all((theirs[name] == run[name]).all() for name in run.columns)
    with pytest.raises(ValueError, match="ends in .mcap"):
        run.save(tmp_path / "run.xlsx")
    with pytest.raises(FileNotFoundError):
        stillpoint.open(tmp_path / "none.mcap")
    assert "<code>run.report(&#39;run.html&#39;)</code>" in (tmp_path / "run.html").read_text(encoding="utf-8")


def test_equilibria_are_pickled():
    rest = stillpoint.load(SCENARIOS / "spring_arm.toml").equilibrium()
    again = pickle.loads(pickle.dumps(rest))
    assert (again.q == rest.q).all() and again.verdict == rest.verdict


def test_notebooks_show_tables():
    scene = stillpoint.describe(SLIDER)
    for thing in (scene, scene.equilibrium(), scene.run(0.1)):
        assert "<table>" in thing._repr_html_()


def test_stubs_name_what_there_is():
    import ast

    tree = ast.parse((Path(stillpoint.__file__).parent / "__init__.pyi").read_text(encoding="utf-8"))
    stubs = {node.name: {item.name for item in node.body if isinstance(item, ast.FunctionDef)} for node in tree.body if isinstance(node, ast.ClassDef)}
    for name in stillpoint.__all__:
        thing = getattr(stillpoint, name)
        if isinstance(thing, type) and not issubclass(thing, BaseException):
            public = {attribute for attribute in vars(thing) if not attribute.startswith("_")}
            assert public == {method for method in stubs[name] if not method.startswith("_")}, name


DRIVEN = {
    "simulate": {"start": "given", "duration": 3.0, "tolerance": 1e-10},
    "body": [
        {"name": "cart", "mass": 1.0, "inertia": [1, 1, 1], "hinge": {"type": "prismatic", "axis": [1, 0, 0]}},
        {
            "name": "bob",
            "mass": 1.0,
            "center": [0, 0, -0.5],
            "inertia": [0.1, 0.1, 0.1],
            "hinge": {"type": "revolute", "parent": "cart", "axis": [0, 1, 0]},
        },
    ],
    "drive": [{"hinge": "cart", "type": "sine", "amplitude": 0.2, "frequency": 1.3}],
}


def test_a_start_keeps_what_no_drive_decides():
    """The cart is as fast as its drive has it; the bob hangs as it was told to, at the rate that it was told."""
    scene = stillpoint.describe(DRIVEN)
    speed = 0.2 * 2 * math.pi * 1.3
    for angle, rate in [(0.3, 0.0), (0.3, -0.4), (-0.7, 1.5)]:
        run = scene.run(0.1, start=([0.0, angle], [0.0, rate]))
        assert abs(run["bob.angle"][0] - angle) < 1e-12
        assert abs(run["bob.rate"][0] - rate) < 1e-9
        simulator = scene.simulator()
        simulator.set(q=[0.0, angle], v=[0.0, rate])
        assert np.allclose(simulator.q, [0.0, angle], atol=1e-12)
        assert np.allclose(simulator.v, [speed, rate], atol=1e-9)
    for v in ([-speed, 0.0], [0.5 * speed, 0.0]):
        with pytest.raises(ValueError, match="`cart.speed` is"):
            scene.run(0.1, start=([0.0, 0.3], v))
    with pytest.raises(ValueError):
        scene.run(0.1, start=([0.0, math.nan], [0.0, 0.0]))


def test_what_an_import_lost_is_in_the_warnings(tmp_path):
    (tmp_path / "two.xml").write_text(
        '<mujoco><worldbody><body pos="0 0 1"><joint name="j" axis="0 1 0"/><geom type="box" size=".1 .2 .3" pos=".2 .1 0"/>'
        '<body pos=".4 0 0"><joint name="k" axis="1 0 1"/><geom size=".1" pos="0 .2 .1"/></body></body></worldbody>'
        '<tendon><fixed name="t" stiffness="3"><joint joint="j" coef="1"/><joint joint="k" coef="-2"/></fixed></tendon></mujoco>'
    )
    (tmp_path / "scene.toml").write_text('model = "two.xml"\n')
    warnings = stillpoint.load(tmp_path / "scene.toml").warnings
    assert "1 ignored" in warnings and "springs and dampers" in warnings
    assert stillpoint.describe(SLIDER).warnings == ""


TOUCHED = {
    "body": [
        {
            "name": "pendulum",
            "mass": 1.0,
            "center": [0, 0, -1],
            "inertia": [0.1, 0.1, 0.1],
            "hinge": {"type": "revolute", "axis": [0, 1, 0], "position": 0.1, "limits": [0.0, 1.0]},
        }
    ],
    "output": [{"name": "angle", "type": "coordinate", "of": "pendulum"}],
}


def test_notes_come_with_numbers():
    rest = stillpoint.describe(TOUCHED).equilibrium()
    by = rest.sensitivity("angle", "pendulum.force")
    assert isinstance(by, stillpoint.Sensitivities) and "bears next to nothing" in " ".join(by.notes)
    linear = rest.linearize()
    assert "bears next to nothing" in " ".join(linear.notes)
    bar = stillpoint.load(SCENARIOS / "four_bar.toml")
    assert "leaves the loops open" in bar.warnings
    energies = [{"name": of, "type": "energy", "of": of} for of in ("kinetic", "input")]
    energy = stillpoint.describe({**SLIDER, "output": energies}).equilibrium().linearize()
    assert energy.outputs == ["kinetic"] and energy.left_out == ["input"]
    assert "added up from the start of a run" in " ".join(energy.notes)
    with pytest.raises(ValueError, match="nothing feels the input"):
        stillpoint.describe({**TOUCHED, "output": []}).equilibrium().linearize("pendulum.force")


def test_frequency_responses_are_those_of_the_matrices():
    linear = stillpoint.load(SCENARIOS / "double_wishbone.toml").equilibrium().linearize("bump", ["camber", "travel"])
    A, B, C, D = linear.A, linear.B, linear.C, linear.D
    frequencies = np.array([0.0, 0.3, 2.0, 17.0])
    found, moved = linear.response(frequencies), linear.response(frequencies, displacement=True)
    assert found.shape == (4, 2, 1) and linear.units["bump"] in ("m/s²", "rad/s²")
    for k, hz in enumerate(frequencies[1:], 1):
        s = 2j * np.pi * hz
        expected = C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D
        assert found[k] == pytest.approx(expected, rel=1e-9)
        assert moved[k] == pytest.approx(expected * s**2, rel=1e-9)
    values = np.sort_complex(np.linalg.eigvals(A))
    assert np.sort_complex(linear.eigenvalues) == pytest.approx(values, abs=1e-8 * np.abs(values).max())
    step, fine = linear.discretize(0.01), linear.discretize(0.005)
    assert step[0] == pytest.approx(fine[0] @ fine[0], abs=1e-9 * np.abs(step[0]).max())
    assert step[1] == pytest.approx(fine[0] @ fine[1] + fine[1], abs=1e-9 * np.abs(step[1]).max())
    assert "eigenvalues" in linear._repr_html_()
    again = pickle.loads(pickle.dumps(linear))
    assert again.notes == linear.notes and again.units == linear.units


def test_what_a_foundation_feels_is_the_force_that_mounts_transmit():
    m, k, c = 12.0, 3000.0, 20.0
    hinge = {"type": "prismatic", "axis": [0, 0, 1], "stiffness": k, "damping": c}
    machine = {
        "body": [{"name": "machine", "mass": m, "inertia": [1, 1, 1], "hinge": hinge}],
        "force": [{"name": "shake", "type": "load", "on": "machine", "force": [0, 0, 0]}],
        "output": [{"name": "floor", "type": "reaction", "of": "machine", "component": "fz"}],
    }
    linear = stillpoint.describe(machine).linearize(inputs=["shake.force[2]"], outputs=["floor"])
    hz = np.array([0.1, 2.0, 2.5, 30.0])
    s = 2j * np.pi * hz
    assert linear.response(hz)[:, 0, 0] == pytest.approx(-(k + c * s) / (m * s**2 + c * s + k), rel=1e-9)
    none = stillpoint.describe(machine).linearize(inputs=[], outputs=[])
    assert none.B.shape == (2, 0) and none.C.shape == (0, 2)


def test_states_that_loops_do_not_agree_with_are_refused():
    bar = stillpoint.load(SCENARIOS / "four_bar.toml")
    rest = bar.equilibrium()
    q, v = np.array(rest.q), np.zeros(len(bar.velocities))
    simulator = bar.simulator(start=[q, v])
    for attempt in (
        lambda q: bar.run(0.1, start=(q, v)),
        lambda q: bar.simulator(start=(q, v)),
        lambda q: bar.linearize(start=(q, v)),
        lambda q: simulator.set(q=q),
    ):
        with pytest.raises(ValueError, match="Scene.close"):
            attempt(q + 0.1)
    near, still = bar.close(q + 0.1)
    assert np.abs(near - q).max() > 0.01 and np.all(still == 0.0)
    bar.simulator(start=(near, still))
    with pytest.raises(ValueError, match="finite"):
        simulator.restore((0.0, [math.nan] * len(q), [0.0] * len(v), *simulator.state()[3:]))
    with pytest.raises(ValueError, match="the time of the state is"):
        simulator.restore((math.nan, *simulator.state()[1:]))
    simulator.restore(simulator.state())
    free = stillpoint.describe(body=[{"name": "b", "mass": 1.0, "inertia": [1, 1, 1], "hinge": {"type": "free"}}])
    with pytest.raises(ValueError, match="quaternion of the hinge of `b` has norm 3"):
        free.simulator(start=([0, 0, 0, 3, 0, 0, 0], np.zeros(6)))


def test_arguments_are_taken_as_they_come():
    from types import MappingProxyType

    scene = stillpoint.describe(SLIDER)
    assert scene.with_set(MappingProxyType({"mass.mass": 3.0})).run(0.1).end_time == 0.1
    table = scene.sweep(MappingProxyType({"mass.mass": [1.0, 2.0]}))
    assert isinstance(table, stillpoint.Table) and isinstance(scene.equilibrium().modes, stillpoint.Modes)
    with pytest.raises(TypeError, match="`set` is"):
        scene.with_set([1.0])
    with pytest.raises(ValueError, match="`start` has 1 parts"):
        scene.run(0.1, start=[[0.3]])
    run = scene.run(0.5, rate=20)
    shown = run._repr_html_()
    assert "<iframe" in shown and "srcdoc" in shown and len(shown) < 3_000_000
    with pytest.raises(ValueError, match="at t = 0.1"):
        scene.run(1.0, controller=lambda t, y: math.nan if t > 0.05 else 0.0, period=0.1)
    try:
        scene.run(1.0, controller=lambda t, y: math.nan if t > 0.05 else 0.0, period=0.1)
    except ValueError as error:
        assert error.run.end_time <= 0.1 and "before its time" in repr(error.run)


def test_responses_at_no_frequency_are_limits():
    linear = stillpoint.load(SCENARIOS / "balanced_cart.toml").linearize()
    names, found = linear.outputs, linear.response(0.0)[0, :, 0]
    at = dict(zip(names, found))
    assert np.isinf(at["x"]) and np.isinf(at["speed"]) and not np.isnan(found).any()
    low = linear.response([1e-5])[0, names.index("angle"), 0]
    assert at["angle"] == pytest.approx(low, rel=1e-9) and at["rate"] == 0


def test_a_step_that_overflows_is_refused():
    linear = stillpoint.load(SCENARIOS / "balanced_cart.toml").linearize()
    with pytest.raises(ArithmeticError, match="over a step of 1000 s .* eigenvalue is 4"):
        linear.discretize(1000.0)


@pytest.mark.parametrize("scale", [0.0, 2.0, 1e300])
def test_quaternions_of_another_norm_are_refused_by_dynamics(scale):
    scene = stillpoint.load(SCENARIOS / "machine_on_mounts.toml")
    dynamics, q, v = scene.dynamics(), scene.q.copy(), scene.v
    q[3:] *= scale
    for call in (
        lambda: dynamics.jacobian("machine.left", q),
        lambda: dynamics.mass(q),
        lambda: dynamics.acceleration(q, v),
        lambda: dynamics.inverse(q, v, v),
        lambda: dynamics.derivatives(q, v),
    ):
        with pytest.raises(ValueError, match="the quaternion of the hinge of `machine` has norm .*, allowed: 1"):
            call()


def test_a_mass_matrix_that_is_not_finite_is_an_error():
    scene = stillpoint.load(SCENARIOS / "spring_arm.toml")
    q = scene.q.copy()
    q[3] = 1e300
    with pytest.raises(ArithmeticError):
        scene.dynamics().mass(q)


def test_a_run_says_where_it_starts(tmp_path):
    rest = stillpoint.load(SCENARIOS / "spring_arm.toml").equilibrium()
    run = rest.run(0.1)
    assert run.as_dict()["start"] == rest.as_dict()
    run.save(tmp_path / "run.mcap")
    assert stillpoint.open(tmp_path / "run.mcap").as_dict() == run.as_dict()
    assert stillpoint.describe(SLIDER).run(0.1).as_dict()["start"] == "given"


def test_wrong_arguments_are_named():
    scene = stillpoint.describe(SLIDER)
    for error, words, call in (
        (ValueError, r"`q\[0\]` is (nan|NaN)", lambda: scene.simulator().set(q=[math.nan])),
        (TypeError, r"`start` is .*, expected: \(q, v\)", lambda: scene.run(0.1, start=scene.q)),
        (TypeError, "`frequencies` is 'a'|`frequencies`", lambda: scene.linearize().response("a")),
        (TypeError, "`state` is 3 ", lambda: scene.simulator().restore(3)),
        (TypeError, r"`over\[\"mass.stiffness\"\]` is 900.0", lambda: scene.sweep({"mass.stiffness": 900.0})),
        (TypeError, "`sets` is 'abc'", lambda: scene.batch("abc", 0.1)),
        (ValueError, "`threads` is 0", lambda: scene.batch([{}], 0.1, threads=0)),
        (ValueError, "^`inputs`: nothing is called `foo`", lambda: scene.linearize(inputs="foo")),
        (KeyError, r"did you mean `frequency\[0\]`", lambda: scene.equilibrium().sensitivity("frequencies_hz[0]")),
        (ValueError, "one frequency", lambda: scene.equilibrium().sensitivity("frequency[9]")),
    ):
        with pytest.raises(error, match=words):
            call()
    with pytest.raises(KeyError) as caught:
        scene.run(0.1, controller=lambda time, outputs: {"pushh": 1}, period=0.02)
    assert caught.value.args[0].startswith("at t = 0 s: no input is called `pushh`")


def test_linearize_has_what_is_asked_for_in_that_order():
    springs = [dict(name=name, mass=1.0, inertia=[1.0, 1.0, 1.0], hinge=dict(type="prismatic", axis=[1.0, 0.0, 0.0], stiffness=stiff))
               for name, stiff in (("a", 1.0), ("b", 4.0))]
    outputs = [dict(name="x" + name, type="coordinate", of=name) for name in "ab"]
    found = stillpoint.describe(body=springs, output=outputs).equilibrium().linearize(
        inputs=["b.force", "a.force"], outputs=["xb", "xa"])
    assert list(found.outputs) == ["xb", "xa"]
    gain = np.asarray(found.D) - np.asarray(found.C) @ np.linalg.solve(found.A, found.B)
    assert np.allclose(gain, np.diag([0.25, 1.0]), atol=1e-12)


def test_degrees_of_freedom_are_what_loops_leave():
    four_bar = stillpoint.load(SCENARIOS / "four_bar.toml")
    assert four_bar.degrees_of_freedom == 1 and len(four_bar.velocities) == 3


def test_durations_and_lists_are_refused_in_the_terms_of_python():
    scene = stillpoint.describe(SLIDER)
    rest = scene.equilibrium()
    for wrong in (math.nan, 0.0, -1.0, math.inf):
        with pytest.raises(ValueError, match="`duration` is"):
            rest.run(wrong)
        with pytest.raises(ValueError, match="`rate` is"):
            rest.run(1.0, rate=wrong)
    with pytest.raises(ValueError, match=r'`over\["mass.mass"\]` is an empty list, expected: a list of values'):
        scene.sweep({"mass.mass": []})
    with pytest.raises(ValueError, match="is an empty text"):
        scene.sweep({"mass.mass": " "})
    with pytest.raises(ValueError, match="empty address"):
        scene.sweep({"": [1.0]})
    with pytest.raises(ValueError, match="`1` has no unit"):
        scene.sweep({"mass.mass": [1, 2, "3 g"]})


def test_numbers_without_a_derivative_say_what_to_do():
    scene = stillpoint.load(SCENARIOS / "double_wishbone.toml")
    rest = scene.equilibrium()
    body = scene.bodies[0]
    with pytest.raises(KeyError, match="no number that can be addressed here.*parameters.name"):
        rest.sensitivity("camber", addresses=[f"{body}.center[0]"])


@pytest.mark.parametrize("integrator", ["rk4", "dopri5", "dop853", "sdirk4", "radau5", "gauss", "adams", "auto"])
def test_a_state_that_is_restored_goes_on_to_the_same_bits(integrator):
    arm = {
        "simulate": {"start": "given", "integrator": integrator, "tolerance": 1e-9},
        "body": [
            {
                "name": "arm",
                "mass": 2.0,
                "center": [0.3, 0.0, -0.2],
                "inertia": [0.1, 0.12, 0.05],
                "hinge": {
                    "type": "universal",
                    "axes": [[0, 1, 0], [0, 0, 1]],
                    "stiffness": [12.0, 7.0],
                    "damping": [0.1, 0.2],
                    "position": [0.1, -0.3],
                    "velocity": [0.3, -0.4],
                },
            }
        ],
    }
    simulator = stillpoint.describe(arm).simulator()
    simulator.advance(0.3)
    kept = simulator.state()
    simulator.advance(1.0)
    first = simulator.q.copy()
    simulator.restore(pickle.loads(pickle.dumps(kept)))
    simulator.advance(1.0)
    assert np.array_equal(first, simulator.q)
    with pytest.raises(TypeError, match="what `Simulator.state\\(\\)` gave"):
        simulator.restore(kept[:5])
    with pytest.raises(ValueError, match="no integrator is called `euler`"):
        simulator.restore((*kept[:5], (kept[0], "euler", None, None, None)))


def test_namesakes_have_derivatives_of_their_own():
    hinge = {"type": "revolute", "axis": [0, 1, 0], "position": 0.3, "stiffness": 3.0}
    arm = {"name": "arm", "mass": 1.0, "center": [0.3, 0, 0], "inertia": [0.1, 0.1, 0.1], "hinge": hinge}
    scene = stillpoint.describe(
        body=[arm],
        motor=[{"name": "arm", "type": "pd", "hinge": "arm", "target": -0.4, "stiffness": 8.0}],
        output=[{"name": "q", "type": "coordinate", "of": "arm"}],
    )
    all = scene.equilibrium().sensitivity("q")
    assert all["motor[0].stiffness"] != pytest.approx(all["arm.stiffness"])
    for address, value in (("arm.stiffness", 3.0), ("motor[0].stiffness", 8.0)):
        ends = [scene.with_set({address: value + by}).equilibrium().outputs["q"] for by in (-1e-3, 1e-3)]
        assert all[address] == pytest.approx((ends[1] - ends[0]) / 2e-3, rel=1e-4)
