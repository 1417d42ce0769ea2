"""What notebooks show."""

from html import escape


def _table(title, rows):
    lines = "".join(f"<tr><th style='text-align:left'>{escape(str(a))}</th><td>{escape(str(b))}</td></tr>" for a, b in rows)
    return f"<b>{escape(title)}</b><table>{lines}</table>"


def scene(scene) -> str:
    bodies = scene.bodies
    shown = ", ".join(bodies[:12]) + (f" … and {len(bodies) - 12} more" if len(bodies) > 12 else "")
    return _table(scene.title or "Scene", [("bodies", shown), ("degrees of freedom", scene.degrees_of_freedom)])


def equilibrium(rest) -> str:
    modes = ", ".join(f"{mode.frequency:.6g}" for mode in rest.modes[:6])
    rows = [("verdict", rest.verdict), ("residual", f"{rest.residual:.1e}"), ("frequencies [Hz]", modes)]
    rows += list(rest.positions.items())[:12] + list(rest.outputs.items())[:12]
    return _table("Equilibrium", rows)


def run(run) -> str:
    rows = [("end [s]", run.end_time), ("samples", len(run.time)), ("columns", len(run)), ("events", len(run.events))]
    return _table("Run", rows)
