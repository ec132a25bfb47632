"""Shared helpers of the tests that run the program: one call to run it, readers for its files.

The program is taken from the environment variable UDAR (default: build/udar of this checkout), mpiexec from MPIEXEC.
"""

import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
UDAR = os.environ.get("UDAR", str(ROOT / "build" / "udar"))
MPIEXEC = os.environ.get("MPIEXEC", "mpiexec")
EXPORTS = re.findall(r"^export (\w+)=(.*)$", (ROOT / "scripts" / "env.sh").read_text(), re.MULTILINE)
ENVIRONMENT = {
    **{name: value for name, value in os.environ.items() if name not in ("PETSC_OPTIONS", "SLEPC_OPTIONS")},
    **dict(EXPORTS),
    "LC_ALL": "C",
}

sys.path.insert(0, str(ROOT / "scripts" / "python"))

from udar import compare_cli, comparing  # noqa: E402, its settings are none of ENVIRONMENT

# What a program without mpiexec needs in its environment, from where the C++ tests have it, too.
ALONE = dict(re.findall(r"^export (\w+)=(.*)$", (ROOT / "tests" / "support" / "alone.sh").read_text(), re.MULTILINE))

# The paper's steel beam falling flat from 1 m on two point supports; tests override single entries.
BEAM = {
    "beam_length": 10,
    "beam_elements": 20,
    "beam_section": "circle",
    "beam_radius": 0.1,
    "beam_young_modulus": 2.1e11,
    "beam_density": 7850,
    "beam_theory": "euler_bernoulli",
    "gravity": 9.81,
    "initial_height": 1,
    "filter_frequency": 100,
    "support_position": "2,8",
    "gauge_position": "0,2.5,5,7.5,10",
    "output_interval": 0.01,
    "ts_max_time": 0.6,
}
STEEL_MASS = 7850 * np.pi * 0.1**2 * 10  # [kg], of BEAM


def case(**changes):
    """BEAM with some options changed; None removes an option."""
    merged = {**BEAM, **changes}
    return {key: value for key, value in merged.items() if value is not None}


def arguments(options):
    """Command line of an option dictionary: True gives a bare flag, None and False nothing."""
    line = []
    for key, value in options.items():
        if value is True:
            line.append(f"-{key}")
        elif value is not None and value is not False:
            line += [f"-{key}", str(value)]
    return line


class Finished:
    """What a run left behind."""

    def __init__(self, command, code, out, err, directory):
        self.command, self.code, self.out, self.err, self.directory = command, code, out, err, directory

    @property
    def errors(self):
        """Lines of stderr in which the program names an error (mpiexec writes lines of its own)."""
        return [line for line in self.err.splitlines() if line.startswith("udar: error:")]

    def file(self, name):
        return self.directory / name

    def csv(self, name):
        return read_csv(self.file(name))

    def summary(self):
        return json.loads(self.file("summary.json").read_text())

    def __str__(self):
        text = f"\n  {' '.join(self.command)}\n  exit code {self.code}\n{self.out[-1500:]}{self.err[-3000:]}"
        return text.replace("\r", "\n")


def command(options, ranks=0, extra=()):
    """The full command; one rank needs no mpiexec."""
    start = [MPIEXEC, "-n", str(ranks)] if ranks > 1 else []
    return start + [UDAR] + arguments(options) + list(extra)


def environment_of(line):
    """What a command needs in its environment."""
    return ENVIRONMENT if line[0] == MPIEXEC else {**ENVIRONMENT, **ALONE}


def start(line, environment=(), **keywords):
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(line, text=True, env={**environment_of(line), **dict(environment)}, **pipes, **keywords)


def run(options, ranks=0, extra=(), timeout=60, cwd=None, environment=()):
    """Runs the program to its end; a run that hangs is ended and raises TimeoutError."""
    line = command(options, ranks, extra)
    process = start(line, environment, cwd=cwd)
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.terminate()  # mpiexec passes it on to its ranks
        try:
            out, err = process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            out, err = process.communicate()
        raise TimeoutError(f"no end after {timeout} s: {' '.join(line)}\n{out[-1000:]}{err[-2000:]}") from None
    return Finished(line, process.returncode, out, err, pathlib.Path(options.get("output_directory", ".")))


def read_csv(path):
    """Columns of a CSV file by name: floats where every entry is a number, text otherwise."""
    lines = pathlib.Path(path).read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    columns = {}
    for index, name in enumerate(lines[0].split(",")):
        values = [row[index] for row in rows]
        try:
            columns[name] = np.array(values, dtype=float)
        except ValueError:
            columns[name] = np.array(values)
    return columns


def datasets(path):
    """All datasets of an HDF5 file, read into memory, by full path."""
    found = {}
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


def digest(directory):
    """Hash of every file under a directory, to see whether anything was touched."""
    return {
        str(path.relative_to(directory)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(pathlib.Path(directory).rglob("*"))
        if path.is_file()
    }


class UdarTest(unittest.TestCase):
    """A test case with a scratch directory of its own, removed afterwards."""

    maxDiff = None

    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="udar-test-"))
        self.addCleanup(shutil.rmtree, self.scratch, ignore_errors=True)

    def run_case(self, options, ranks=0, name="run", timeout=120, code=0, **keywords):
        """Runs into <scratch>/<name> and expects an end without error."""
        result = run({"output_directory": self.scratch / name, **options}, ranks, timeout=timeout, **keywords)
        self.assertEqual(result.code, code, result)
        self.assertEqual(result.errors, [], result)
        return result

    def refuse_case(self, options, words, ranks=0):
        """Expects exit code 1 and one line of error with all the words."""
        refused = run({"output_directory": self.scratch / "run", **options}, ranks)
        self.assertEqual(refused.code, 1, refused)
        self.assertEqual(len(refused.errors), 1, refused)
        for word in words:
            self.assertIn(word, refused.errors[0])

    def assert_same_curves(self, expected, found, *names, tolerance=0.0, **absolute):
        """Expects these curves of two runs, or those of all gauges, at the same times and within a tolerance: relative
        to their ranges, or absolute for all of them, by unit."""
        folders = [getattr(part, "directory", part) for part in (expected, found)]
        names = names or [name for name in read_csv(folders[0] / "gauges.csv") if name != "time"]
        compared = comparing.compare(*folders, tolerance, absolute, dict(zip(names, names)))
        self.assertTrue(compared.same_times and compared.within, "\n".join(["", *compare_cli.page(compared)]))

    def interrupt(self, process, after, timeout=60):
        """Sends SIGINT after some seconds and waits for the end."""
        try:
            process.wait(timeout=after)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
        try:
            return process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            self.fail(f"no end {timeout} s after SIGINT")


def grouped_by_node(impacts, slowest=1e-3):
    """Times and velocities of the impacts faster than `slowest` [m/s], in order, per node."""
    nodes = {}
    for time, node, velocity in zip(impacts["time"], impacts["node"], impacts["velocity_before"]):
        if abs(velocity) > slowest:
            nodes.setdefault(int(node), []).append((time, velocity))
    return {node: np.array(rows) for node, rows in sorted(nodes.items())}


STOPPED_BY_STEPS = 3  # exit code of a run that -ts_max_steps ended


def lumped_masses(elements):
    """Masses of the nodes of BEAM [kg]."""
    mass = np.full(int(elements) + 1, STEEL_MASS / int(elements))
    mass[[0, -1]] /= 2
    return mass
