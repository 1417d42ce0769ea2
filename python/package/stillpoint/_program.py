"""The program, as it is on the path."""

import sys


def main() -> int:
    from . import _stillpoint

    return _stillpoint.program(sys.argv)
