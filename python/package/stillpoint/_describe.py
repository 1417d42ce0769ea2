"""Scenes in code."""

from ._stillpoint import Scene, parse
from ._toml import inline


def describe(scene=None, **tables) -> Scene:
    """A scene from dictionaries and lists with the names of scenario files.

    >>> describe(body=[{"name": "bob", "mass": 1.0, "center": [0, 0, -1],
    ...                 "hinge": {"type": "revolute", "axis": [0, 1, 0]}}])
    """
    every = {**(scene or {}), **tables}
    # A list with nothing in it says nothing.
    every = {key: value for key, value in every.items() if not (isinstance(value, (list, tuple)) and len(value) == 0)}
    return parse("".join(f"{inline(str(key))} = {inline(value)}\n" for key, value in every.items()), name="scene")
