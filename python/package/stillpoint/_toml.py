"""Python values as TOML has them, in one line."""

import json
from collections.abc import Mapping
from numbers import Integral, Real

import numpy as np


def masked(value) -> bool:
    """Whether some numbers of an array are masked: they would be shown by a cast."""
    return bool(np.ma.is_masked(value)) if hasattr(value, "mask") else False


def inline(value) -> str:
    """A value of TOML: booleans, numbers, texts, lists, dictionaries, and what numpy has of these."""
    if hasattr(value, "tolist"):
        if masked(value):
            raise ValueError(f"a scene has no masked numbers: {value!r}")
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, str):
        # TOML has the escapes of JSON.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{inline(str(key))} = {inline(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(inline(item) for item in value) + "]"
    raise TypeError(f"a scene has no values of type {type(value).__name__}: {value!r}")
