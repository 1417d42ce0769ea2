"""FMUs in other people's hands: validated and simulated by FMPy, against runs of the program itself.

Needs the program and the library (`cargo build`, `cargo build -p stillpoint-fmu`), FMPy and pytest.
"""

import ctypes
import json
import os
import random
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="needs FMPy: pip install -r tests/python/requirements.txt")

from fmpy.fmi1 import FMICallException  # noqa: E402
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("STILLPOINT", ROOT / "target/debug/stillpoint"))
SCENARIOS = ROOT / "scenarios"


def program(*arguments, folder=None):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=folder)


def asked(*arguments, folder=None):
    answer = program(*arguments, "--json", "--quiet", folder=folder)
    assert answer.returncode == 0, answer.stderr
    return json.loads(answer.stdout)


class Fmu:
    """An FMU, unpacked, and its instances."""

    def __init__(self, path, folder):
        self.description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path), unzipdir=str(folder))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}

    def reference(self, name):
        return self.variables[name].valueReference

    def library(self):
        identifier = self.description.coSimulation.modelIdentifier
        return os.path.join(self.folder, "binaries", fmpy.platform_tuple, identifier + fmpy.sharedLibraryExtension)

    def outputs(self):
        return [name for name, variable in self.variables.items() if variable.causality == "output"]

    def inputs(self):
        return [name for name, variable in self.variables.items() if variable.causality == "input"]

    def of(self, body):
        """Names of the positions, then of the velocities of a body's hinge."""
        return [name for name in self.outputs() if name.startswith(f"{body}.")]

    def instance(self, token=None, logging=False):
        return Instance(self, token, logging)


class Instance:
    """One instance: calls raise FMICallException, and `log` has what was said."""

    def __init__(self, fmu, token=None, logging=False):
        self.fmu, self.log = fmu, []

        def hear(environment, status, category, message):
            self.log.append((status, category.decode(), message.decode()))

        self.hear = fmi3LogMessageCallback(hear)
        self.slave = FMU3Slave(
            guid=token or fmu.description.guid,
            unzipDirectory=fmu.folder,
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.slave.instantiate(loggingOn=logging, logMessage=self.hear)

    def start(self, values=None, tolerance=None, stop=None):
        self.set(values or {})
        self.slave.enterInitializationMode(tolerance=tolerance, startTime=0.0, stopTime=stop)
        self.slave.exitInitializationMode()
        return self

    def get(self, *names):
        return self.slave.getFloat64([self.fmu.reference(name) for name in names])

    def set(self, values):
        if values:
            self.slave.setFloat64([self.fmu.reference(name) for name in values], list(values.values()))

    def step(self, time, size):
        return self.slave.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def free(self):
        self.slave.freeInstance()

    def refuses(self, words, call, *arguments, **keywords):
        """The call is an error, and the log says why."""
        before = len(self.log)
        with pytest.raises(FMICallException) as refused:
            call(*arguments, **keywords)
        assert refused.value.status == 3
        said = self.log[before:]
        assert len(said) == 1 and said[0][:2] == (3, "logStatusError"), said
        assert words in said[0][2], said


def written(folder, text, *arguments, name="scene"):
    """The FMU of a scenario."""
    scenario = folder / f"{name}.toml"
    scenario.write_text(text)
    return of_file(folder, scenario, *arguments, name=name)


def of_file(folder, scenario, *arguments, name="scene"):
    path = folder / f"{name}.fmu"
    asked("fmu", scenario, "-o", path, *arguments)
    assert validate_fmu(str(path)) == []
    return Fmu(path, folder / f"{name}.unpacked")


def scene(draw, start="equilibrium", integrator="dop853", extra=""):
    """A random tree of hinges with springs and dampers, inputs, parameters and outputs; it has an equilibrium."""
    count = draw.randint(1, 5)
    text = [f'title = "random <{draw.random():.3f}> & more"', "[parameters]", f"m = {draw.uniform(0.5, 2.0)!r}"]
    text += ["[simulate]", f'start = "{start}"', "duration = 1.0", "tolerance = 1e-12", f'integrator = "{integrator}"']
    if integrator == "rk4":
        text.append("step = 0.001")
    for i in range(count):
        kind = draw.choice(["revolute", "prismatic", "revolute", "spherical"])
        parent = draw.choice(["ground"] + [f"b{j}" for j in range(i)])
        mass = '"{m}"' if i == 0 else repr(draw.uniform(0.3, 3.0))
        text += ["[[body]]", f'name = "b{i}"', f"mass = {mass}"]
        text += [f"center = {[draw.uniform(-0.3, 0.3) for _ in range(3)]}", "inertia = [0.04, 0.05, 0.06]"]
        axis = [draw.uniform(-1, 1) for _ in range(3)]
        axis = [x / sum(y * y for y in axis) ** 0.5 for x in axis]
        of_axis = "" if kind == "spherical" else f"axis = {axis}, position = {draw.uniform(-0.2, 0.2)!r}, "
        text.append(
            f'hinge = {{ type = "{kind}", parent = "{parent}", at = {[draw.uniform(-0.5, 0.5) for _ in range(3)]}, {of_axis}'
            f"stiffness = {draw.uniform(40, 200)!r}, damping = {draw.uniform(0.1, 2)!r} }}"
        )
        text += ["[[output]]", f'name = "p{i}"', 'type = "position"', f'of = {{ body = "b{i}", at = [0.1, 0.2, 0.3] }}']
        text += ["[[output]]", f'name = "a{i}"', 'type = "acceleration"', f'of = {{ body = "b{i}", at = [0.1, 0.2, 0.3] }}']
        if kind != "spherical":
            text += ["[[motor]]", f'name = "u{i}"', 'type = "input"', f'hinge = "b{i}"', f"force = {draw.uniform(-1, 1)!r}"]
    return "\n".join(text) + "\n" + extra


def controlled(text, period, inputs):
    """The scene with a controller of its own that sets the inputs over time, by formulas of t."""
    for index, (name, formula) in enumerate(inputs.items()):
        text += f'\n[[controller]]\nname = "c{index}"\ntype = "expression"\nperiod = {period!r}\nsenses = "p0"\ndrives = "{name}"\nexpression = "{formula}"\n'
    return text


@pytest.mark.parametrize("seed", range(int(os.environ.get("FMU_CASES", "6"))))
def test_random_scenes_are_as_their_own_runs(tmp_path, seed):
    """Inputs that change at every communication point: a run whose controller sets them at the same instants gives the same."""
    draw = random.Random(seed)
    text = scene(draw, start=draw.choice(["equilibrium", "given"]))
    fmu = written(tmp_path, text)
    period = draw.choice([0.05, 0.1, 0.125])
    amplitudes = {name: draw.uniform(-3, 3) for name in fmu.inputs()}
    start = {name: fmu.variables[name].start for name in fmu.inputs()}
    # At t = 0 as the scene has it, so that the equilibrium is the same.
    formulas = {name: f"{float(start[name])!r} + {size!r} * sin(3 * t)" for name, size in amplitudes.items()}
    instance = fmu.instance().start()
    steps = round(1.0 / period)
    for step in range(steps):
        now = step * period
        instance.set({name: float(start[name]) + size * np.sin(3 * now) for name, size in amplitudes.items()})
        instance.step(now, period)
    own = tmp_path / "own.toml"
    own.write_text(controlled(text, period, formulas))
    expected = asked("run", own, "--out", tmp_path / "own.mcap", "--set", f"simulate.duration={steps * period!r}")
    ends = expected["final"]
    for body, position in ends["positions"].items():
        states = position + ends["velocities"][body]
        found = instance.get(*fmu.of(body))
        assert len(found) == len(states) > 0
        assert np.allclose(found, states, rtol=1e-8, atol=1e-8), np.abs(np.subtract(found, states)).max()
    instance.free()


@pytest.mark.parametrize("seed", range(int(os.environ.get("FMU_CASES", "4"))))
def test_states_are_kept_bit_for_bit(tmp_path, seed):
    draw = random.Random(100 + seed)
    fmu = written(tmp_path, scene(draw, integrator=draw.choice(["auto", "radau9", "rk4", "dop853"])))
    first, names = fmu.instance().start(), fmu.outputs()
    force = {name: draw.uniform(-2, 2) for name in fmu.inputs()}
    first.step(0.0, 0.07)
    first.set(force)
    state = first.slave.getFMUState()
    data = first.slave.serializeFMUState(state)

    def go_on(instance):
        answers = []
        for step in range(4):
            instance.step(0.07 + 0.03 * step, 0.03)
            answers.append(instance.get("time", *names))
        return np.array(answers).tobytes()

    once = go_on(first)
    first.slave.setFMUState(state)
    assert go_on(first) == once
    # In another instance, initialized or not.
    for other in (fmu.instance(), fmu.instance().start()):
        there = other.slave.deserializeFMUState(data)
        other.slave.setFMUState(there)
        assert other.get("time")[0] == 0.07
        assert go_on(other) == once
        other.slave.freeFMUState(there)
        other.refuses("no state of this instance", other.slave.setFMUState, state)
        other.free()
    first.slave.freeFMUState(state)
    first.free()


@pytest.mark.parametrize("seed", range(int(os.environ.get("FMU_CASES", "4"))))
def test_derivatives_are_those_of_the_outputs(tmp_path, seed):
    """Accelerations, reactions and powers are affine in the inputs: two values of them give the derivative but for rounding."""
    draw = random.Random(200 + seed)
    asks = [("energy", "kinetic"), ("energy", "potential"), ("power", "input"), ("power", "dissipated"), ("reaction", "b0")]
    passed = "".join(f'[[output]]\nname = "{of} {kind}"\ntype = "{kind}"\nof = "{of}"\n' for kind, of in asks)
    fmu = written(tmp_path, scene(draw, start="given", extra=passed))
    instance = fmu.instance().start()
    instance.step(0.0, 0.1)
    names, inputs = fmu.outputs(), fmu.inputs()
    seeds = [draw.uniform(-2, 2) for _ in inputs]
    found = instance.slave.getDirectionalDerivative(
        [fmu.reference(name) for name in names], [fmu.reference(name) for name in inputs], seeds
    )
    here = np.array(instance.get(*names))
    before = instance.get(*inputs) if inputs else []
    instance.set({name: at + by for name, at, by in zip(inputs, before, seeds)})
    there = np.array(instance.get(*names))
    scale = 1 + np.abs(here).max()
    assert np.allclose(found, there - here, rtol=1e-9, atol=1e-10 * scale), np.abs(found - (there - here)).max()
    assert not inputs or np.abs(found).max() > 1e-3
    instance.free()


@pytest.mark.parametrize("seed", range(int(os.environ.get("FMU_CASES", "4"))))
def test_parameters_and_inputs_make_another_equilibrium(tmp_path, seed):
    draw = random.Random(300 + seed)
    text = scene(draw)
    fmu = written(tmp_path, text, "--parameter", "b0.stiffness" if "spherical" not in text.split("[[output]]")[0] else "gravity[2]")
    added = [name for name, one in fmu.variables.items() if one.causality == "parameter"]
    assert added[0] == "parameters.m" and len(added) == 2
    values = {name: float(fmu.variables[name].start) * draw.uniform(0.5, 1.5) for name in added}
    values |= {name: draw.uniform(-2, 2) for name in fmu.inputs()}
    changes = [f"--set={name}{'' if name in added else '.force'}={value!r}" for name, value in values.items()]
    expected = asked("statics", tmp_path / "scene.toml", *changes)["positions"]
    names = [name for body, position in expected.items() for name in fmu.of(body)[: len(position)]]
    expected = [q for position in expected.values() for q in position]
    instance = fmu.instance()
    instance.set(values)
    assert instance.get(*values) == list(values.values())
    instance.start()
    assert np.allclose(instance.get(*names), expected, rtol=1e-12, atol=1e-12)
    # As it was again.
    instance.slave.reset()
    assert instance.get(*values) == [float(fmu.variables[name].start) for name in values]
    instance.start()
    assert not np.allclose(instance.get(*names), expected, rtol=1e-9, atol=1e-9)
    instance.free()


@pytest.mark.parametrize("name", ["machine_on_mounts", "double_wishbone", "arm_on_stop", "balanced_cart", "lift", "beam_cantilever"])
def test_shipped_scenes_stay_at_rest_in_a_simulation(tmp_path, name):
    path = tmp_path / f"{name}.fmu"
    asked("fmu", SCENARIOS / f"{name}.toml", "-o", path)
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    still = [one.name for one in description.modelVariables if one.causality == "output" and one.unit in ("m", "rad")]
    times = {"start_time": 0.0, "stop_time": 0.5, "output_interval": 0.05}
    result = fmpy.simulate_fmu(str(path), **times, output=still)
    assert len(result) == 11
    for column in still:
        assert np.ptp(result[column]) < 1e-6, (column, np.ptp(result[column]))


def test_files_come_along(tmp_path):
    """A robot in a folder beside, and the scenario in another one: nothing of it is needed any more."""
    shutil.copytree(SCENARIOS, tmp_path / "there" / "scenarios")
    fmu = of_file(tmp_path, tmp_path / "there" / "scenarios" / "arm_from_urdf.toml")
    alone = of_file(tmp_path, tmp_path / "there" / "scenarios" / "robots" / "arm.urdf", name="alone") if (
        tmp_path / "there" / "scenarios" / "robots" / "arm.urdf"
    ).exists() else None
    shutil.rmtree(tmp_path / "there")
    for one in filter(None, (fmu, alone)):
        instance = one.instance().start()
        instance.step(0.0, 0.1)
        instance.free()


HARD = """
[simulate]
start = "given"
[[body]]
name = "mass"
mass = 1.0
hinge = { type = "prismatic", axis = [0, 0, 1], position = 0.5, limits = [0.0, 1.0] }
[[motor]]
name = "push"
type = "input"
hinge = "mass"
[[output]]
name = "height"
type = "coordinate"
of = "mass"
"""


def test_calls_that_make_no_sense_are_refused(tmp_path):
    fmu = written(tmp_path, HARD)
    one = fmu.instance()
    height, push = fmu.reference("height"), fmu.reference("push")
    one.refuses("before initialization", one.step, 0.0, 0.1)
    one.refuses("before initialization", one.slave.exitInitializationMode)
    one.refuses("before initialization", one.slave.terminate)
    one.refuses("before initialization", one.get, "height")
    one.refuses("0 to", one.slave.getFloat64, [4711])
    one.refuses("all are `Float64`", one.slave.getInt32, [height])
    one.refuses("`push` is NaN", one.slave.setFloat64, [push], [float("nan")])
    one.refuses("it is an output", one.slave.setFloat64, [push, height], [5.0, 1.0])
    assert one.get("push") == [0.0], "one that is refused sets nothing"
    for wrong in (float("nan"), -1.0, float("inf")):
        one.refuses("start time", one.slave.enterInitializationMode, startTime=wrong)
    one.refuses("stop time", one.slave.enterInitializationMode, startTime=1.0, stopTime=0.5)
    one.refuses("tolerance", one.slave.enterInitializationMode, startTime=0.0, tolerance=0.0)
    one.slave.enterInitializationMode(startTime=0.0, stopTime=10.0)
    one.refuses("in initialization mode", one.slave.enterInitializationMode, startTime=0.0)
    one.refuses("in initialization mode", one.step, 0.0, 0.1)
    one.slave.exitInitializationMode()
    one.refuses("in step mode", one.slave.exitInitializationMode)
    for size in (0.0, -0.1, float("nan"), float("inf")):
        one.refuses("the step is", one.step, 0.0, size)
    one.refuses("communication point", one.step, 0.1, 0.1)
    one.refuses("communication point", one.step, float("nan"), 0.1)
    one.refuses("stop time", one.step, 0.0, 11.0)
    one.refuses("`push` is inf", one.slave.setFloat64, [push], [float("inf")])
    one.refuses("does not claim", one.slave.enterEventMode)
    one.refuses("no output", one.slave.getDirectionalDerivative, [push], [push], [1.0])
    one.refuses("no input", one.slave.getDirectionalDerivative, [height], [height], [1.0])
    one.refuses("0 to", one.slave.getDirectionalDerivative, [height], [99], [1.0])
    data = one.slave.serializeFMUState(one.slave.getFMUState())
    for damaged in (data[:-1], data.replace(b"position", b"posture", 1), b"", b"[]", b"\xff" * 40):
        one.refuses("no state of this FMU", one.slave.deserializeFMUState, damaged)
    assert one.get("time", "height") == [0.0, 0.5], "nothing of all this has moved it"
    one.step(0.0, 0.1)
    assert np.isclose(one.get("height")[0], 0.5 - 9.80665 * 0.01 / 2, atol=1e-9) or one.get("height")[0] < 0.5
    one.slave.terminate()
    one.refuses("terminated", one.step, 0.1, 0.1)
    one.refuses("terminated", one.slave.setFloat64, [push], [1.0])
    one.get("height")
    # FMPy unloads the library with an instance: this one stays.
    library, handle = ctypes.CDLL(fmu.library()), one.slave.component
    one.free()
    # What is not there any more, and what never was: errors, and no crash.
    for wrong in (handle, None, 12345):
        assert library.fmi3Terminate(ctypes.c_void_p(wrong)) == 3
        assert library.fmi3GetFloat64(ctypes.c_void_p(wrong), None, ctypes.c_size_t(0), None, ctypes.c_size_t(0)) == 3
        library.fmi3FreeInstance(ctypes.c_void_p(wrong))
    two, call = fmu.instance().start(), library.fmi3GetFloat64
    assert call(ctypes.c_void_p(two.slave.component), None, ctypes.c_size_t(2), None, ctypes.c_size_t(2)) == 3
    assert "null pointer" in two.log[-1][2]
    two.free()


def test_an_instance_that_cannot_be_is_none(tmp_path):
    fmu = written(tmp_path, HARD)
    with pytest.raises(Exception, match="instantiate"):
        fmu.instance(token="another")
    # An equilibrium that a parameter takes away.
    text = HARD.replace('"given"', '"equilibrium"').replace(', limits = [0.0, 1.0]', ', stiffness = "{k}"').replace("[simulate]", "[parameters]\nk = 100.0\n[simulate]")
    fmu = written(tmp_path, text, "--parameter", "mass.mass", name="soft")
    one = fmu.instance()
    one.set({"parameters.k": 0.0})
    one.slave.enterInitializationMode(startTime=0.0)
    one.refuses("equilibrium", one.slave.exitInitializationMode)
    one.refuses("equilibrium", one.get, "height")
    one.set({"parameters.k": 200.0, "mass.mass": -1.0})
    one.refuses("`mass` is -1", one.slave.exitInitializationMode)
    one.set({"mass.mass": 1.0})
    one.slave.exitInitializationMode()
    assert np.isclose(one.get("height")[0], -9.80665 / 200.0, rtol=1e-9)
    one.refuses("fixed parameter", one.set, {"parameters.k": 100.0})
    one.free()
    one = fmu.instance()
    one.slave.enterInitializationMode(startTime=1.0)
    one.refuses("at 0 s", one.slave.exitInitializationMode)
    one.free()
    # Without one at all there is no FMU.
    (tmp_path / "falls.toml").write_text(text.replace("k = 100.0", "k = 0.0"))
    answer = program("fmu", tmp_path / "falls.toml", "-o", tmp_path / "falls.fmu")
    assert answer.returncode == 1 and "equilibrium" in answer.stderr
    assert not (tmp_path / "falls.fmu").exists()


def test_events_are_told_and_end_the_simulation(tmp_path):
    fmu = written(tmp_path, HARD + '[[event]]\nname = "low"\nhinge = "mass"\nvalue = 0.2\naction = "stop"\n')
    one = fmu.instance(logging=True).start()
    answer = one.step(0.0, 1.0)
    fall = (2 * 0.3 / 9.80665) ** 0.5
    assert [bool(answer[i]) for i in range(3)] == [False, True, True], answer
    assert abs(answer[3] - fall) < 1e-7 and abs(one.get("time")[0] - fall) < 1e-7
    assert any(category == "logEvents" and "low" in message for _, category, message in one.log), one.log
    one.refuses("`low` has ended the run", one.step, answer[3], 0.1)
    one.free()


def test_instances_do_not_know_of_each_other(tmp_path):
    draw = random.Random(7)
    fmu = written(tmp_path, scene(draw))
    names = fmu.outputs()

    def go(force, answers):
        instance = fmu.instance().start()
        for step in range(20):
            instance.set({name: force * (1 + step) for name in fmu.inputs()})
            instance.step(step * 0.02, 0.02)
            answers.append(instance.get(*names))
        instance.free()

    alone = {force: [] for force in (0.1, -0.2, 0.3, 0.05)}
    together = {force: [] for force in alone}
    for force, answers in alone.items():
        go(force, answers)
    threads = [threading.Thread(target=go, args=item) for item in together.items()]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert together == alone
    assert not fmu.inputs() or alone[0.1] != alone[0.3]


def test_the_same_scene_makes_the_same_bytes(tmp_path):
    written(tmp_path, HARD)
    once = (tmp_path / "scene.fmu").read_bytes()
    written(tmp_path, HARD)
    assert (tmp_path / "scene.fmu").read_bytes() == once
    answer = program("fmu", tmp_path / "scene.toml", "--library", tmp_path / "scene.toml", "-o", tmp_path / "x.fmu")
    assert answer.returncode == 2 and "cargo build --release -p stillpoint-fmu" in answer.stderr
