#!/usr/bin/env python3
"""udar-report: one HTML page about a run of udar, or about several laid over each other (udar.report.cli)."""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
FOLDERS = (HERE / "python", HERE.parent / "share" / "udar" / "python")  # of the sources and the build, installed
sys.path.insert(0, str(next((folder for folder in FOLDERS if (folder / "udar").is_dir()), FOLDERS[0])))

from udar.report import cli  # noqa: E402, its place comes first

cli.run()
