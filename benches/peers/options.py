"""The options of `run`."""

import argparse
import pathlib
import re


def arguments():
    parser = argparse.ArgumentParser(description="Measures stillpoint beside other simulators on the same models.")
    parser.add_argument(
        "--only", metavar="NAMES", help="these models (with --ode: problems) or families, as in chain,tree6"
    )
    parser.add_argument("--passes", type=int, metavar="N", help="how often each is measured; default 3, with --quick 1")
    parser.add_argument("--quick", action="store_true", help="one pass of short loops")
    parser.add_argument("--ode", action="store_true", help="error against time of the integrators, instead")
    parser.add_argument("--squeezer", action="store_true", help="Andrews' squeezing mechanism beside Exudyn, instead")
    parser.add_argument("--nets", action="store_true", help="equilibria of nets beside Exudyn and SciPy, instead")
    parser.add_argument("--many", action="store_true", help="cases per second beside MuJoCo's rollout, instead")
    parser.add_argument("--beams", action="store_true", help="beams beside Exudyn, MuJoCo and PyElastica, instead")
    parser.add_argument("--contact", action="store_true", help="contact at rest beside MuJoCo and Drake, instead")
    parser.add_argument(
        "--out", type=pathlib.Path, metavar="FOLDER", help="where results go; default: target/peers/results"
    )
    parser.add_argument("--docs", action="store_true", help="also put the tables into docs/speed.md")
    parser.add_argument(
        "--program", "--binary", type=pathlib.Path, metavar="PATH", help="a stillpoint that is built already"
    )
    return parser.parse_args()


def chosen(given, names):
    """Those of the names that --only asks for: by themselves, or by their family, a name without its number."""
    wanted = given.only.split(",") if given.only else names
    return [name for name in names if name in wanted or re.sub(r"\d+$", "", name) in wanted]
