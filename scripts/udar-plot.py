#!/usr/bin/env python3
"""udar-plot: pictures of one run of udar, of several runs laid over each other, or of a study (udar.cli)."""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
if (HERE / "python" / "udar").is_dir():  # of the sources and the build
    sys.path.insert(0, str(HERE / "python"))
else:  # installed; behind Python's own places, which have the other modules
    sys.path += map(str, HERE.parent.glob("lib/python3*/dist-packages"))

from udar import cli  # noqa: E402, its place comes first

cli.run()
