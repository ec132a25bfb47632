#!/usr/bin/env python3
"""udar-plot: pictures of one run of udar, of several runs laid over each other, or of a study (udar.cli)."""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
FOLDERS = (HERE / "python", HERE.parent / "share" / "udar" / "python")  # of the sources and the build, installed
sys.path.insert(0, str(next((folder for folder in FOLDERS if (folder / "udar").is_dir()), FOLDERS[0])))

from udar import cli  # noqa: E402, its place comes first

cli.run()
