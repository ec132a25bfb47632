#!/usr/bin/env python3
"""udar-compare: a run against another one, or against curves from elsewhere (udar.compare_cli)."""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
if (HERE / "python" / "udar").is_dir():  # of the sources and the build
    sys.path.insert(0, str(HERE / "python"))
else:  # installed; behind Python's own places, which have the other modules
    sys.path += map(str, HERE.parent.glob("lib/python3*/dist-packages"))

from udar import compare_cli  # noqa: E402, its place comes first

compare_cli.run()
