"""Evaluates formulas with Python's own `eval`, and differentiates them with fifty digits.

Reads [[text, {name: value}, variable], …] from the file; prints for each null where Python finds no real number, else
[value, first derivative, second derivative], the derivatives null where they are not asked for (no variable).
"""

import ast
import json
import math
import sys

import mpmath

mpmath.mp.dps = 50

SAME = ["sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
        "log", "sqrt", "cbrt", "hypot", "floor", "ceil"]
PLAIN = {name: getattr(math, name) for name in [*SAME, "trunc", "log2", "log10", "radians", "degrees"]}
PLAIN |= {"ln": math.log, "pi": math.pi, "tau": math.tau, "e": math.e, "abs": abs, "min": min, "max": max, "round": round}
PLAIN |= {"sign": lambda x: (x > 0) - (x < 0), "fract": lambda x: x - math.trunc(x)}
# The absolute value of a complex number is none of ours, and a zero keeps its sign.
PLAIN |= {"abs": math.fabs}


def power(a, b):
    found = a**b
    if isinstance(found, complex):
        raise ArithmeticError("complex numbers are none of ours")
    return found


PLAIN |= {"power": power}


class WithPower(ast.NodeTransformer):
    """`a**b` as `power(a, b)`."""

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow):
            return node
        return ast.Call(ast.Name("power", ast.Load()), [node.left, node.right], [])


def signed(function):
    return lambda x: math.copysign(function(x), x) if function(x) == 0 else function(x)


PLAIN |= {name: signed(PLAIN[name]) for name in ["floor", "ceil", "trunc", "round"]}
# math.pow is that of C; the built-in one is `**`.
PLAIN |= {"pow": math.pow}


def truncated(x):
    return mpmath.floor(x) if x >= 0 else mpmath.ceil(x)


EXACT = {name: getattr(mpmath, name) for name in SAME}
EXACT |= {"ln": mpmath.log, "pi": mpmath.pi, "tau": 2 * mpmath.pi, "e": mpmath.e, "abs": abs, "min": min, "max": max}
EXACT |= {"round": mpmath.nint, "trunc": truncated, "fract": lambda x: x - truncated(x), "sign": mpmath.sign}
EXACT |= {"log2": lambda x: mpmath.log(x, 2), "log10": mpmath.log10, "pow": lambda a, b: a**b, "power": lambda a, b: a**b}
EXACT |= {"radians": mpmath.radians, "degrees": mpmath.degrees}


def plain(code, values):
    try:
        found = eval(code, {"__builtins__": {}}, PLAIN | values)
        return None if isinstance(found, complex) else float(found)
    except (ArithmeticError, ValueError, TypeError):
        return None


def derivative(code, values, variable, order):
    def function(x):
        return mpmath.mpf(eval(code, {"__builtins__": {}}, EXACT | values | {variable: x}))

    try:
        return float(mpmath.diff(function, values[variable], order, h=mpmath.mpf(10) ** -15))
    except (ArithmeticError, ValueError, TypeError):
        return None


def answer(text, values, variable):
    tree = ast.fix_missing_locations(WithPower().visit(ast.parse(text, mode="eval")))
    code = compile(tree, "formula", "eval")
    value = plain(code, values)
    if value is None or not math.isfinite(value):
        return None
    if variable is None:
        return [value, None, None]
    exact = {name: mpmath.mpf(number) for name, number in values.items()}
    return [value, derivative(code, exact, variable, 1), derivative(code, exact, variable, 2)]


def main(file):
    with open(file) as cases:
        json.dump([answer(*case) for case in json.load(cases)], sys.stdout)


if __name__ == "__main__":
    main(*sys.argv[1:])
