"""Recordings that are on their way."""

import os
import subprocess
import sys
import tempfile

from ._stillpoint import open as _open


def opened(recording: bytes):
    """The run of a recording."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "run.mcap")
        with open(path, "wb") as file:
            file.write(recording)
        return _open(path)


def report(recording: bytes, page) -> None:
    """Writes the report of a recording."""
    page = os.fspath(page)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "run.mcap")
        with open(path, "wb") as file:
            file.write(recording)
        # A process of its own: the program takes Ctrl-C for itself as long as it lives.
        command = [sys.executable, "-m", "stillpoint", "report", path, "-o", page, "--quiet"]
        command += ["--called", f"run.report({os.path.basename(page)!r})"]
        done = subprocess.run(command, capture_output=True, text=True)
    # 1: the report says that something is not fine; it is written all the same.
    if done.returncode not in (0, 1):
        raise OSError(f"the report `{page}` was not written: {done.stderr.strip()}")
