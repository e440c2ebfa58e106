"""The program ``superegg``, as the wheel installs it."""

from __future__ import annotations

import sys

from superegg import _superegg


def main() -> None:
    """Run the program with the arguments of this process, and end with its exit code."""
    sys.exit(_superegg.run(sys.argv))
