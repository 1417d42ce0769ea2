"""Everything the comparison needs, under target/peers: Python packages at pinned versions, compiled timing programs,
and our own release binary. Standard library only."""

import hashlib
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BASE = ROOT / "target" / "peers"
PYTHON = BASE / "venv" / "bin" / "python"
PROGRAMS = BASE / "bin"
EIGEN = pathlib.Path("/usr/include/eigen3")

# What Pinocchio's own package sets: without them boost::fusion does not compile.
BOOST = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
]
# The packages that a table needs, and those of all others.
USUAL = ("drake", "example-robot-data", "exudyn", "matplotlib", "mujoco", "numpy", "pin", "scipy")
NEEDS = {
    "nets": ("numpy", "scipy", "exudyn"),
    "many": ("numpy", "mujoco", "mujoco-mjx"),
    "beams": ("numpy", "scipy", "exudyn", "mujoco", "pyelastica"),
    "contact": ("numpy", "mujoco", "drake"),
}
MODELS_ONLY = ("mujoco-mjx",)
OPTIMIZED = ["-std=c++17", "-O3", "-march=native", "-DNDEBUG"]


def say(text):
    print(f"peers: {text}", file=sys.stderr, flush=True)


def stop(text):
    sys.exit(f"peers: {text}")


def call(command, **more):
    """Runs at low priority; the first failure ends it all."""
    command = ["nice", "-n", "10", *map(str, command)]
    if subprocess.run(command, **more).returncode != 0:
        stop("failed: " + " ".join(command))


def prepare(table):
    """The virtual environment, and the timing programs of `ode` and of the evaluations (None); what is there already is
    kept."""
    BASE.mkdir(parents=True, exist_ok=True)
    install(NEEDS.get(table, USUAL))
    if table == "ode":
        compile_mujoco("mujoco_integrate")
    elif table is None:
        compile_mujoco("mujoco")
        compile_pinocchio()


def pinned(names):
    """The lines of requirements.txt for these packages."""
    lines = (HERE / "requirements.txt").read_text().split()
    return [line for line in lines if line.split("==")[0] in names]


def install(names):
    """What is needed of requirements.txt into target/peers/venv, which may be a link to another folder."""
    stamp = BASE / "venv" / "installed"
    present = stamp.read_text().split() if stamp.exists() else []
    missing = [line for line in pinned(names) if line not in present]
    if not missing:
        return
    say("installing into target/peers/venv: " + " ".join(missing))
    if not PYTHON.exists():
        call([sys.executable, "-m", "venv", BASE / "venv"])
    pip = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    # Of these the files of models are wanted, not what they would run with.
    alone = [line for line in missing if line.split("==")[0] in MODELS_ONLY]
    if len(alone) < len(missing):
        call([*pip, *(line for line in missing if line not in alone)])
    if alone:
        call([*pip, "--no-deps", *alone])
    stamp.write_text("\n".join([*present, *missing]) + "\n")


def packages():
    return next((BASE / "venv" / "lib").glob("python3*")) / "site-packages"


def compile_program(name, flags, inputs, libraries=()):
    """Compiles cpp/NAME.cpp unless that was done with the same sources, flags and packages."""
    PROGRAMS.mkdir(exist_ok=True)
    command = ["g++", *OPTIMIZED, *map(str, flags), str(HERE / "cpp" / f"{name}.cpp")]
    command += ["-o", str(PROGRAMS / name), *map(str, libraries)]
    content = hashlib.sha256("\0".join(command).encode())
    for path in [HERE / "cpp" / f"{name}.cpp", *inputs, HERE / "requirements.txt"]:
        content.update(path.read_bytes())
    stamp = PROGRAMS / f"{name}.hash"
    if stamp.exists() and stamp.read_text() == content.hexdigest():
        return
    say(f"compiling {name}")
    call(command)
    stamp.write_text(content.hexdigest())


def compile_mujoco(name):
    package = packages() / "mujoco"
    library = next(package.glob("libmujoco.so.*"))
    headers = [HERE / "cpp" / header for header in ("model.hpp", "mujoco.hpp")]
    compile_program(name, [f"-I{package}/include"], headers, [library, f"-Wl,-rpath,{package}"])


def compile_pinocchio():
    """Header-only: the wheel's own libraries are built for another instruction set than -march=native."""
    if not EIGEN.is_dir():
        stop("Pinocchio needs the headers of Eigen 3: apt-get install libeigen3-dev")
    prefix = packages() / "cmeel.prefix"
    overlay = BASE / "overlay"
    data = overlay / "pinocchio/src/multibody/data.hxx"
    data.parent.mkdir(parents=True, exist_ok=True)
    data.write_text(without_cubes((prefix / "include/pinocchio/src/multibody/data.hxx").read_text()))
    if not (PROGRAMS / "pinocchio.hash").exists():
        say("compiling pinocchio takes some minutes and up to 5 GB of memory")
    includes = [f"-I{overlay}", f"-I{prefix}/include", f"-I{EIGEN}"]
    compile_program("pinocchio", ["-w", *BOOST, *includes], [HERE / "cpp" / "model.hpp", data])


def without_cubes(source):
    """Pinocchio's Data allocates tensors of n³ numbers for second derivatives, 32 GB at n = 1000; nothing that is timed
    here touches them, so they are left empty."""
    source, second = re.subn(r"(d2tau_d[a-z]+)\(model\.nv, model\.nv, model\.nv\)", r"\1(0, 0, 0)", source)
    source, hessians = re.subn(r"kinematic_hessians\(6, model\.nv, model\.nv\)", "kinematic_hessians(6, 0, 0)", source)
    if (second, hessians) != (4, 1):
        stop("this is another Pinocchio than the pinned one: its data.hxx has changed")
    return source


def build_ours():
    """Our release binary, without the viewer, as anybody would build it."""
    call(["cargo", "build", "--release", "--locked", "--no-default-features", "--features", "cli", "--quiet"], cwd=ROOT)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return (ROOT / target / "release" / "stillpoint").resolve()


def built(given):
    """The stillpoint that is measured without being built here: the one that was given, or the release binary."""
    path = (given or ROOT / "target" / "release" / "stillpoint").resolve()
    if not path.is_file():
        stop(
            f"there is no {path}: build it with `cargo build --release --no-default-features --features cli,friction,parquet`, or name another "
            "with --program"
        )
    return path
