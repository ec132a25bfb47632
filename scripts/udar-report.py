#!/usr/bin/env python3
"""udar-report: one HTML page about a run of udar, or about several laid over each other (udar.report.cli)."""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
if (HERE / "python" / "udar").is_dir():  # of the sources and the build
    sys.path.insert(0, str(HERE / "python"))
else:  # installed; behind Python's own places, which have the other modules
    sys.path += map(str, HERE.parent.glob("lib/python3*/dist-packages"))

from udar.report import cli  # noqa: E402, its place comes first

cli.run()
