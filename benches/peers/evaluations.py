"""Accelerations and their derivatives: stillpoint beside Pinocchio and MuJoCo. Called by `run`."""

import collections
import functools
import json
import os
import statistics
import subprocess
import sys

import models
import report
from environment import BASE, PROGRAMS, say, stop
from options import arguments, chosen

CHAINS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
NAMES = [
    *(f"chain{n}" for n in CHAINS),
    *(f"spherical{n}" for n in (10, 20, 50, 100)),
    *(f"tree{depth}" for depth in range(6, 11)),
    *models.ROBOTS,
]
# Two programs compute the same accelerations when they differ by no more than this.
AGREE = 1e-9

OURS = ("acceleration", "jacobian", "tangent_solve", "static_step")
Times = collections.namedtuple("Times", "min median")  # nanoseconds


def output(command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        stop(" ".join(map(str, command)) + "\n" + done.stderr)
    return done.stdout


def check(model, scenario, neutral):
    """The differences between the programs at the state of the model; ends everything where they are too large."""
    inspected = json.loads(output([os.environ["STILLPOINT"], "inspect", scenario, "--json"]))["accelerations"]
    ours = [x for index in range(len(model.bodies)) for x in inspected[f"b{index}"]]
    file = neutral.with_suffix(".accelerations")
    file.write_text(models.numbers(ours) + "\n")
    keys = ("to_local", "to_world", "residual", "residual_local", "residual_world")
    found = dict(zip(keys, map(float, output([PROGRAMS / "pinocchio", neutral, "--check", file]).split()), strict=True))
    found["to_mujoco"] = float(output([PROGRAMS / "mujoco", neutral, "--check", file]))
    # Where Pinocchio fails its own inverse dynamics there is nothing to agree with: then only that residual counts.
    comparable = found["residual_local"] <= AGREE
    # And where the peers are further than that from each other, no more can be asked of us (the iCub's small parts).
    apart = min(found["to_world"], found["to_mujoco"]) - found["to_local"]
    if not found["residual"] <= AGREE or (comparable and not found["to_local"] <= max(AGREE, apart)):
        stop(f"{model.name}: the programs compute different accelerations: {found}")
    return found


def peer_times(program, neutral, loops):
    for line in output([PROGRAMS / program, neutral, *loops]).splitlines():
        peer, model, quantity, least, median = line.split(",")
        yield model, f"{peer} {quantity}", Times(float(least), float(median))


def our_times(model, scenario):
    found = json.loads(output([os.environ["STILLPOINT"], "bench", scenario, "--json"]))
    for quantity in OURS:
        times = found.get(f"{quantity}_ns")
        if times:
            yield model.name, f"stillpoint {quantity}", Times(times["min"], times["median"])


def measure(ready, passes, loops):
    """All models in turn, both sides of each one after the other, `passes` times."""
    samples = collections.defaultdict(list)
    for number in range(passes):
        for model, scenario, neutral in ready:
            say(f"pass {number + 1} of {passes}: {model.name}")
            for times in (
                our_times(model, scenario),
                peer_times("pinocchio", neutral, loops),
                peer_times("mujoco", neutral, loops),
            ):
                for name, quantity, time in times:
                    samples[name, quantity].append(time)
    return {
        key: Times(min(t.min for t in times), statistics.median(t.median for t in times))
        for key, times in samples.items()
    }


def ratio(a, b):
    return f"{a.min / b.min:.2f} / {a.median / b.median:.2f}" if a and b else "–"


def goal(text, most, models, part, whole):
    """A row: for how many of the models the minimum of `part` is at most `most` times that of `whole`."""
    ratios = {model: part[model].min / whole[model].min for model in models if part.get(model) and whole.get(model)}
    if not ratios:
        return None
    missed = {model: x for model, x in ratios.items() if not x <= most}
    worst = max(ratios, key=ratios.get)
    names = ", ".join(f"{model} ({x:.2f})" for model, x in missed.items())
    return [text, f"{len(ratios) - len(missed)} of {len(ratios)}", f"{ratios[worst]:.2f} ({worst})", names]


def goals(ready, times):
    """What we mean to reach, and where we do not."""
    of = lambda quantity: {model: t for (model, name), t in times.items() if name == quantity}  # noqa: E731
    ours, derivatives = of("stillpoint acceleration"), of("pinocchio aba_derivatives")
    world, mujoco = of("pinocchio aba_world"), of("mujoco smooth")
    peers = {model: min(world[model], mujoco[model], key=lambda t: t.min) for model in world}
    everything = [model.name for model, _, _ in ready]
    small = [model.name for model, _, _ in ready if model.freedom <= 100]
    many = [model.name for model, _, _ in ready if model.freedom >= 5]
    tangent = of("stillpoint tangent_solve")
    rows = [
        goal("an acceleration in half the time of the faster peer", 0.5, everything, ours, peers),
        goal("a Jacobian in the time of Pinocchio's, to 100 dof", 1, small, of("stillpoint jacobian"), derivatives),
        goal("a tangent solve in less than Pinocchio's derivatives, from 5 dof", 1, many, tangent, derivatives),
        goal("a tangent solve in 5 accelerations at 10 links", 5, ["chain10"], tangent, ours),
        goal("a tangent solve in 4 accelerations at 1000 links", 4, ["chain1000"], tangent, ours),
    ]
    return report.Table(
        "Goals",
        "Ratios of minima.",
        ["goal", "met by", "worst ratio", "missed by"],
        [row for row in rows if row],
    )


def microseconds(times):
    return f"{times.min / 1e3:.3g} / {times.median / 1e3:.3g}" if times else "–"


def found_for(times, model, quantity):
    return times.get((model, quantity))


def tables(ready, checks, times):
    accelerations, tangents, agreement = [], [], []
    for model, _, _ in ready:
        at = functools.partial(found_for, times, model.name)
        local, world = at("pinocchio aba_local"), at("pinocchio aba_world")
        mujoco, ours = at("mujoco smooth"), at("stillpoint acceleration")
        # "The faster of" is taken for minima and medians each on its own.
        best = Times(min(world.min, mujoco.min), min(world.median, mujoco.median))
        row = [model.name, model.freedom, *map(microseconds, (local, world, mujoco, at("mujoco forward"), ours))]
        accelerations.append([*row, ratio(ours, best)])
        derivatives, jacobian = at("pinocchio aba_derivatives"), at("stillpoint jacobian")
        tangent, step = at("stillpoint tangent_solve"), at("stillpoint static_step")
        row = [
            model.name,
            model.freedom,
            microseconds(derivatives),
            microseconds(jacobian),
            ratio(jacobian, derivatives),
        ]
        row += [microseconds(tangent), ratio(tangent, derivatives), ratio(tangent, ours), microseconds(step)]
        tangents.append(row)
        found = checks[model.name]
        keys = ("to_local", "to_world", "to_mujoco", "residual", "residual_local", "residual_world")
        agreement.append([model.name, model.freedom, *(f"{found[key]:.0e}" for key in keys)])
    return [
        goals(ready, times),
        report.Table(
            "Accelerations",
            "Microseconds for one evaluation, minimum / median. The ratio is ours to the faster of Pinocchio's `aba` "
            "(WORLD) and MuJoCo's smooth dynamics.",
            ["model", "dof", "Pinocchio LOCAL", "Pinocchio WORLD", "MuJoCo smooth", "MuJoCo `mj_forward`"]
            + ["stillpoint", "ratio"],
            accelerations,
        ),
        report.Table(
            "Derivatives",
            "Microseconds, minimum / median. Pinocchio's `computeABADerivatives` and our `jacobian` give the dense "
            "∂q̈/∂q and ∂q̈/∂q̇; our tangent solve gives what a Newton step wants of them, by one sweep.",
            ["model", "dof", "Pinocchio derivatives", "our Jacobian", "ratio", "our tangent solve"]
            + ["to Pinocchio's derivatives", "to our acceleration", "our static step"],
            tangents,
        ),
        report.Table(
            "Agreement",
            "Relative distance of our accelerations to those of the peers, and the relative residual ‖ID(q̈) − τ‖ of "
            "each by Pinocchio's inverse dynamics.",
            ["model", "dof", "to LOCAL", "to WORLD", "to MuJoCo"] + ["residual of ours", "of LOCAL", "of WORLD"],
            agreement,
        ),
    ]


def main():
    given = arguments()
    passes = given.passes or (1 if given.quick else 3)
    # Loops, and seconds of each at least.
    loops = (5, 0.003) if given.quick else (11, 0.01)
    ready, checks = [], {}
    for name in chosen(given, NAMES):
        model = models.make(name)
        scenario, neutral = models.write(model, BASE / "models")
        ready.append((model, scenario, neutral))
        checks[name] = check(model, scenario, neutral)
    if not ready:
        stop(f"--only {given.only}: no such model; there are {', '.join(NAMES)}")
    say(f"{len(ready)} models: both sides compute the same accelerations")
    head = report.Head(sys.argv[1:], passes)
    times = measure(ready, passes, loops)
    rows = [(model, *quantity.split(" ", 1), *time) for (model, quantity), time in times.items()]
    columns = ["model", "program", "quantity", "min_ns", "median_ns"]
    report.write(given, "evaluations", head, tables(ready, checks, times), columns, rows)


if __name__ == "__main__":
    main()
