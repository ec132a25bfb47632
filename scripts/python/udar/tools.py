"""What every script needs: errors of one line, a parser that raises them, the way a program ends, tables."""
import argparse
import importlib
import os
import sys

import numpy as np


class UserError(Exception):
    """Something the user must mend; its text is the one line that is printed."""


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise UserError(message)


def gauge_list(text):
    """Of an argument like 0,2,4."""
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of gauge numbers like 0,2,4") from None


def run_program(name, main):
    """A program, whose `main` gets the words of the command line and returns the exit code or None for 0: errors of the
    user are one line on standard error and the exit code 2."""
    try:
        sys.exit(main(sys.argv[1:]))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (UserError, OSError) as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        sys.exit(2)


def first_line(error):
    text = error.args[0] if isinstance(error, KeyError) and error.args else error
    return str(text).strip().splitlines()[0] if str(text).strip() else type(error).__name__


def one_line(text):
    return " ".join(str(text).split())


def read_csv(path, needed=(), whole=False):
    """Columns of a CSV file by name. Unless the file is whole, a last line without its newline is a row still being
    written: left out."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            header = file.readline().strip().split(",")
            body = file.read()
    except FileNotFoundError:
        raise UserError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise UserError(f"{path}: not a text file") from None
    missing = [name for name in needed if name not in header]
    if missing:
        raise UserError(f"{path}: the first line has no column '{missing[0]}'")
    if not whole:
        body = body[:body.rfind("\n") + 1]
    if "event" in header:
        body = body.replace("release", "1").replace("rest", "0")
        header[header.index("event")] = "release"
    lines = body.splitlines()
    try:
        values = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None) if lines else np.empty((0, len(header)))
    except ValueError as error:
        raise UserError(f"{path}: {first_line(error)}") from None
    if values.shape[1] != len(header):
        raise UserError(f"{path}: {values.shape[1]} columns below {len(header)} names")
    return {name: values[:, column] for column, name in enumerate(header)}


def need(module, package):
    """A module that only some of this needs."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"udar needs {module} for this (Debian: {package})") from None
