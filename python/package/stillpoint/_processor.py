"""Whether this processor has the instructions that the extension was compiled for."""

import platform

NEEDED = ("avx2", "fma", "bmi2")


def check() -> None:
    """Raises ImportError on an x86-64 processor that lacks them: loading the extension would end the interpreter."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            flags = next((line for line in file if line.startswith("flags")), None)
    except OSError:
        return
    missing = [name for name in NEEDED if flags is not None and name not in flags.split()]
    if missing:
        raise ImportError(f"stillpoint was built for processors with AVX2, FMA and BMI2; this one lacks {', '.join(missing)}")
