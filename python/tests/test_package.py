"""The package against the program, closed forms and differences."""

import copy
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

PENDULUM = {
    "gravity": [0, 0, -9.81],
    "simulate": {"start": "given", "duration": 1.0, "tolerance": 1e-10},
    "body": [
        {
            "name": "bob",
            "mass": 2.0,
            "center": [0, 0, -0.5],
            "markers": {"tip": [0, 0, -0.5]},
            "hinge": {"type": "revolute", "axis": [0, 1, 0], "position": 0.4},
        }
    ],
}


def program(*arguments):
    """What the program prints, which comes with the package."""
    answer = subprocess.run([sys.executable, "-m", "stillpoint", *arguments], capture_output=True, text=True)
    return answer.returncode, answer.stdout, answer.stderr


def test_the_program_and_the_package_give_one_answer():
    path = str(SCENARIOS / "spring_arm.toml")
    code, out, err = program("statics", path, "--json")
    assert code == 0, err
    told = json.loads(out)
    rest = stillpoint.load(path).equilibrium()
    mine = rest.as_dict()
    for key in ("positions", "bodies", "reactions", "frequencies_hz", "stability", "residual_force"):
        assert mine[key] == told[key]
    assert rest.verdict == "stable" and rest.positions == told["positions"]
    assert list(rest.frequencies) == told["frequencies_hz"]


def test_a_pendulum_from_dictionaries_swings_as_gravity_has_it():
    scene = stillpoint.describe(PENDULUM)
    rest = scene.equilibrium()
    assert abs(rest.q[0]) < 1e-12 and rest.verdict == "stable"
    assert math.isclose(rest.modes[0].frequency, math.sqrt(9.81 / 0.5) / (2 * math.pi), rel_tol=1e-9)
    force, moment = rest.reactions["bob"]
    np.testing.assert_allclose(force, [0, 0, 2 * 9.81], atol=1e-9)
    run = scene.run()
    assert run.time[0] == 0.0 and run.time[-1] == 1.0
    energy = run["kinetic"] + run["potential"]
    assert np.ptp(energy) < 1e-8
    still = rest.run(5.0)
    assert np.ptp(still["bob.angle"]) < 1e-12


def test_columns_are_arrays_that_nobody_writes_to():
    run = stillpoint.describe(PENDULUM).run(rate=200)
    angle = run["bob.angle"]
    assert angle is not None and angle.dtype == np.float64 and not angle.flags.writeable
    assert angle.ctypes.data == run["bob.angle"].ctypes.data
    assert set(run.columns) >= {"bob.angle", "bob.rate", "kinetic"} and run.units["bob.angle"] == "rad"
    with pytest.raises(KeyError, match="did you mean `bob.angle`"):
        run["bob.angel"]


def test_dynamics_equal_differences():
    scene = stillpoint.load(SCENARIOS / "spring_arm.toml")
    dynamics = scene.dynamics()
    random = np.random.default_rng(7)
    for _ in range(20):
        q, v = random.uniform(-1, 1, dynamics.nq), random.uniform(-1, 1, dynamics.nv)
        a = dynamics.acceleration(q, v)
        np.testing.assert_allclose(dynamics.inverse(q, v, a), 0, atol=1e-9)
        force = random.uniform(-1, 1, dynamics.nv)
        pushed = a + np.linalg.solve(dynamics.mass(q), force)
        np.testing.assert_allclose(dynamics.inverse(q, v, pushed), force, atol=1e-9)
        by_q, by_v = dynamics.derivatives(q, v)
        h = 1e-6
        for j in range(dynamics.nv):
            step = np.zeros(dynamics.nv)
            step[j] = h
            # Differences of accelerations: their rounding over the step.
            slack = 1e-6 + 1e-15 * np.abs(a).max() / h * 10
            change = dynamics.acceleration(q + step, v) - dynamics.acceleration(q - step, v)
            np.testing.assert_allclose(by_q[:, j], change / (2 * h), rtol=1e-6, atol=slack)
            change = dynamics.acceleration(q, v + step) - dynamics.acceleration(q, v - step)
            np.testing.assert_allclose(by_v[:, j], change / (2 * h), rtol=1e-6, atol=slack)


def test_the_jacobian_of_a_point_gives_its_velocity():
    dynamics = stillpoint.describe(PENDULUM).dynamics()
    jacobian = dynamics.jacobian("bob.tip", [0.3])
    np.testing.assert_allclose(jacobian[:, 0], [-0.5 * math.cos(0.3), 0, 0.5 * math.sin(0.3)], atol=1e-12)
    whole = dynamics.jacobian(("bob", [0, 0, -0.5]), [0.3], angular=True)
    np.testing.assert_allclose(whole[:, 0], [*jacobian[:, 0], 0, 1, 0], atol=1e-12)
    with pytest.raises(KeyError, match="did you mean `bob.tip`"):
        dynamics.jacobian("bob.tipp", [0.3])


def test_problems_come_with_line_and_caret():
    with pytest.raises(stillpoint.SceneError) as caught:
        stillpoint.parse('[[body]]\nname = "bob"\nmas = 1.0\nhinge = { type = "free" }\n')
    assert "did you mean `mass`" in str(caught.value) and "scene.toml:3:1" in str(caught.value)
    with pytest.raises(stillpoint.SceneError, match="did you mean"):
        stillpoint.describe(PENDULUM).with_set({"bob.masss": 1.0})
    with pytest.raises(FileNotFoundError, match="no scenario"):
        stillpoint.load("there/is/none.toml")
    with pytest.raises(IsADirectoryError):
        stillpoint.load(SCENARIOS)


def test_wrong_numbers_are_named():
    dynamics = stillpoint.describe(PENDULUM).dynamics()
    with pytest.raises(ValueError, match="`q` has 2 numbers, the scene 1"):
        dynamics.acceleration([0, 1], [0])
    with pytest.raises(TypeError, match="none complex"):
        dynamics.acceleration(np.array([0.1 + 1j]), [0])
    with pytest.raises(ValueError, match=r"`v\[0\]` is nan|`v\[0\]` is NaN"):
        dynamics.acceleration([0], [math.nan])
    with pytest.raises(TypeError, match=r"`q` is \['a'\] \(type `list`\), expected: a list of 1 numbers"):
        dynamics.acceleration(["a"], [0])
    for wrong in (np.zeros((1, 1)), [[0.0]]):
        with pytest.raises(ValueError, match=r"`q` has the shape \(1, 1\), expected: a list of 1 numbers"):
            dynamics.acceleration(wrong, [0])
    with pytest.raises(ValueError, match=r"the place in `point` is (nan|NaN) at \[2\]"):
        dynamics.jacobian(("bob", [0, 0, math.nan]), [0])
    with pytest.raises(ValueError, match=r"the place in `point` has 2 numbers, expected: \[x, y, z\]"):
        dynamics.jacobian(("bob", [0, 0]), [0])
    with pytest.raises(TypeError, match="`point` is 3 .*expected: .body.marker."):
        dynamics.jacobian(3, [0])
    with pytest.raises(ValueError, match="allowed: above 0"):
        stillpoint.describe(PENDULUM).run(-1)


def test_what_falls_for_ever_is_no_equilibrium():
    scene = stillpoint.describe(body=[{"name": "stone", "mass": 1.0, "hinge": {"type": "prismatic", "axis": [0, 0, 1]}}])
    with pytest.raises(stillpoint.NoEquilibrium):
        scene.equilibrium()


def test_scenes_are_pickled_and_changed():
    scene = stillpoint.describe(PENDULUM)
    heavier = pickle.loads(pickle.dumps(scene.with_set({"bob.mass": 3.0})))
    force, _ = heavier.equilibrium().reactions["bob"]
    assert abs(force[2] - 3 * 9.81) < 1e-9


def test_modes_linear_equations_and_dynamics_are_pickled():
    scene = stillpoint.describe(PENDULUM)
    rest = scene.equilibrium()
    mode, linear, dynamics = (pickle.loads(pickle.dumps(one)) for one in (rest.modes[0], rest.linearize(), scene.dynamics()))
    assert (mode.frequency, mode.damping_ratio) == (rest.modes[0].frequency, rest.modes[0].damping_ratio)
    for name in "ABCD":
        assert np.array_equal(getattr(linear, name), getattr(rest.linearize(), name))
    assert linear.states == rest.linearize().states
    assert dynamics.acceleration([0.3], [0.1]) == scene.dynamics().acceleration([0.3], [0.1])


def test_a_scene_is_its_own_whatever_becomes_of_its_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text((SCENARIOS / "pendulum.toml").read_text(), encoding="utf-8")
    scene = stillpoint.load(path)
    path.write_text("", encoding="utf-8")
    bodies = scene.bodies
    assert scene.with_set({"simulate.duration": 1.0}).bodies == bodies == copy.deepcopy(scene).bodies
    assert pickle.loads(pickle.dumps(scene)).bodies == bodies
    error = pickle.loads(pickle.dumps(stillpoint.SceneError("x")))
    assert isinstance(error, stillpoint.SceneError)


def test_arrays_of_any_layout_are_taken():
    dynamics = stillpoint.load(SCENARIOS / "spring_arm.toml").dynamics()
    both = np.random.default_rng(2).uniform(-1, 1, (2 * dynamics.nv, 7))
    q, v = both[: dynamics.nv, 3], both[dynamics.nv :, 3]
    plain = dynamics.acceleration(q.copy(), v.copy())
    assert (dynamics.acceleration(q, v) == plain).all()
    assert (dynamics.acceleration(list(q), tuple(v)) == plain).all()
    assert len(dynamics.coordinates) == dynamics.nq and len(dynamics.velocities) == dynamics.nv


def test_samples_beyond_memory_are_refused():
    with pytest.raises(MemoryError, match="samples"):
        stillpoint.describe(PENDULUM).run(10.0, rate=1e15)


def test_linear_equations_are_those_of_the_program_and_of_the_modes():
    path = str(SCENARIOS / "double_wishbone.toml")
    code, out, err = program("linearize", path, "--json", "--quiet", "--input", "bump")
    assert code == 0, err
    told = json.loads(out)
    rest = stillpoint.load(path).equilibrium()
    linear = rest.linearize(inputs=["bump"])
    for name in "ABCD":
        assert np.array_equal(getattr(linear, name), np.array(told[name]).reshape(getattr(linear, name).shape))
    assert linear.states == told["states"] and set(linear.outputs) <= set(rest.outputs)
    scene = stillpoint.load(path)
    assert np.array_equal(scene.linearize(["bump"], ["camber"]).C, rest.linearize(["bump"], ["camber"]).C)
    swing = stillpoint.describe(PENDULUM)
    by_position, by_velocity = swing.dynamics().derivatives([0.4], [0.3])
    about = swing.linearize(start=([0.4], [0.3])).A
    assert np.allclose(about[1:], np.hstack([by_position, by_velocity]), rtol=1e-9, atol=1e-9)
    with pytest.raises(ValueError, match="`start` has 2 positions"):
        swing.linearize(start=([0.4, 0.1], [0.3]))
    pendulum = stillpoint.describe(PENDULUM).equilibrium()
    roots = np.linalg.eigvals(pendulum.linearize().A)
    assert np.allclose(np.abs(roots.imag), 2 * math.pi * pendulum.modes[0].frequency, rtol=1e-9)
    with pytest.raises(ValueError, match="did you mean"):
        rest.linearize(outputs=["cambr"])


def test_threads_share_dynamics():
    dynamics = stillpoint.load(SCENARIOS / "spring_arm.toml").dynamics()
    states = np.random.default_rng(3).uniform(-1, 1, (200, 2, dynamics.nv))
    alone = [dynamics.acceleration(q, v) for q, v in states]
    together = [None] * len(states)

    def work(first):
        for at in range(first, len(states), 4):
            together[at] = dynamics.acceleration(*states[at])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all((a == b).all() for a, b in zip(alone, together))


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_an_interrupt_ends_a_run():
    scene = stillpoint.describe(PENDULUM)
    main = threading.get_ident()
    threading.Timer(0.05, lambda: signal.pthread_kill(main, signal.SIGINT)).start()
    before = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        scene.run(1e6, rate=1e-3)
    assert time.monotonic() - before < 5


def test_import_is_quick_and_a_call_cheap():
    code = "import time; b = time.perf_counter(); import numpy; c = time.perf_counter(); import stillpoint; print(time.perf_counter() - c)"
    answer = min(float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout) for _ in range(3))
    assert answer < 0.1
