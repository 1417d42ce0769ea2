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


def linear(linear) -> str:
    values = ", ".join(f"{value:.4g}" for value in linear.eigenvalues[:12])
    rows = [("states", linear.states), ("inputs", linear.inputs), ("outputs", linear.outputs), ("eigenvalues [1/s]", values)]
    rows = [(name, ", ".join(of) if isinstance(of, list) else of) for name, of in rows]
    return _table("Linear", rows + [("note", note) for note in linear.notes])


# A notebook keeps what it shows: pages above this size are left to `Run.report`.
_MOST_BYTES = 3_000_000


def run(run) -> str:
    rows = [("end [s]", run.end_time), ("samples", len(run.time)), ("columns", len(run)), ("events", len(run.events))]
    return _table("Run", rows) + _picture(run)


def _picture(run) -> str:
    """The report of a run, whose picture turns and plays, in a frame of its own."""
    from pathlib import Path
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        page = Path(folder, "run.html")
        try:
            run.report(page)
        except (OSError, RuntimeError, ValueError):
            # What cannot be drawn is no reason to show nothing.
            return ""
        text = page.read_text(encoding="utf-8")
    if len(text) > _MOST_BYTES:
        return ""
    style = "width: 100%; height: 640px; border: 1px solid #ddd"
    return f"<iframe sandbox='allow-scripts allow-downloads' style='{style}' srcdoc=\"{escape(text, quote=True)}\"></iframe>"
