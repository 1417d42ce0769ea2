"""What the pages show runs."""

import os
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def snippets():
    for page in ("docs/guide/python.md", "docs/guide/notebook.md", "README.md"):
        for number, code in enumerate(re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)):
            yield pytest.param(code, id=f"{page}-{number}")


@pytest.mark.parametrize("code", snippets())
def test_snippets_run(code):
    before = Path.cwd()
    os.chdir(ROOT)
    try:
        exec(compile(code, "snippet", "exec"), {})
    finally:
        os.chdir(before)
