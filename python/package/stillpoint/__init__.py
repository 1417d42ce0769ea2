"""A multibody simulator that starts at rest.

>>> import stillpoint
>>> scene = stillpoint.load("scenarios/spring_arm.toml")
>>> rest = scene.equilibrium()
>>> rest.verdict, rest.modes[0].frequency
"""

from ._processor import check as _check

_check()

from ._stillpoint import (  # noqa: E402
    Branch,
    Dynamics,
    Equilibrium,
    Linear,
    Mode,
    NoEquilibrium,
    Path,
    Run,
    RunError,
    Scene,
    SceneError,
    Simulator,
    __version__,
    load,
    open,
    parse,
)
from ._describe import describe  # noqa: E402
from ._fit import Fit  # noqa: E402
from ._table import Modes, Sensitivities, Table  # noqa: E402

__all__ = [
    "Branch",
    "Dynamics",
    "Equilibrium",
    "Fit",
    "Linear",
    "Mode",
    "Modes",
    "NoEquilibrium",
    "Path",
    "Run",
    "RunError",
    "Scene",
    "SceneError",
    "Sensitivities",
    "Simulator",
    "Table",
    "__version__",
    "describe",
    "load",
    "open",
    "parse",
]
