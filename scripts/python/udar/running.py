"""Runs of udar from Python: the program is started as on a command line, its errors become exceptions."""
from __future__ import annotations

import collections.abc
import os
import pathlib
import shutil
import subprocess
import tempfile
import typing
import warnings
import weakref

import numpy as np

from .frames import Path, Results
from .tools import UserError

Case = typing.Union[Path, "collections.abc.Mapping[str, typing.Any]", None]
IN_ORDER = {3: "by -ts_max_steps", 4: "by -wall_limit", 129: "by SIGHUP", 130: "by SIGINT", 138: "by SIGUSR1",
            140: "by SIGUSR2", 143: "by SIGTERM"}  # exit codes of runs whose files are whole
PATIENCE = 30  # s that a run has to end in order when Python is interrupted


class RunError(UserError):
    """The program failed: `message` is what it said, `code` its exit code (negative: killed by that signal)."""

    def __init__(self, message: str, code: int, log: str) -> None:
        super().__init__(message)
        self.message, self.code, self.log = message, code, log


class UdarWarning(UserWarning):
    """What a run warned of, or that it stopped before its end."""


def find_program() -> str:
    """The program: what the environment variable UDAR names, that of this module's build or installation, the PATH's.

    Raises UserError if there is none.
    """
    named = os.environ.get("UDAR")
    if named:
        found = shutil.which(named)
        if not found:
            raise UserError(f"UDAR: '{named}' is no program")
        return found
    above = pathlib.Path(__file__).resolve().parents
    own = [above[2] / "udar", above[3] / "build" / "udar", above[4] / "bin" / "udar"]  # of a build, sources, installed
    for program in own:
        if program.is_file() and os.access(program, os.X_OK):
            return str(program)
    found = shutil.which("udar")
    if not found:
        raise UserError("no program udar: neither beside the module nor in PATH; UDAR in the environment names it")
    return found


def as_text(key: str, value: typing.Any) -> str:
    """A value as PETSc's options have it: True is `true`, a list is joined by commas, numbers keep all their digits."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, np.ndarray, range)):
        if any(isinstance(part, (list, tuple, np.ndarray, collections.abc.Mapping)) for part in value):
            raise UserError(f"{key}: {value!r} is a list of lists; expected a number, a text, true, false or a list")
        return ",".join(as_text(key, part) for part in value)
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (int, np.integer, str, os.PathLike)):
        return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
    raise UserError(f"{key}: {value!r} is no number, text, true, false or list of these")


def arguments(options: collections.abc.Mapping[str, typing.Any]) -> list[str]:
    """Options on a command line; None leaves one out."""
    return [word for key, value in options.items() if value is not None
            for word in (f"-{key.lstrip('-')}", as_text(key, value))]


def start(words: list[str], ranks: int, timeout: float | None) -> str:
    """Runs the program to its end and returns what it said."""
    if ranks < 1:
        raise UserError(f"ranks = {ranks} is not allowed, expected a whole number >= 1")
    launch = [os.environ.get("MPIEXEC", "mpiexec"), "-n", str(ranks)] if ranks > 1 else []
    command = [*launch, find_program(), *words]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          errors="replace") as process:
        try:
            out, said = process.communicate(timeout=timeout)
        except BaseException as reason:
            process.terminate()  # the run ends in order; mpiexec passes it on
            try:
                process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
            if isinstance(reason, subprocess.TimeoutExpired):
                raise RunError(f"no end after {timeout:g} s", process.wait(), "") from None
            raise
    log = out + said
    if process.returncode and process.returncode not in IN_ORDER:
        errors = [line.removeprefix("udar: error: ") for line in said.splitlines() if line.startswith("udar: error: ")]
        rest = said.strip().splitlines()
        message = errors[0] if errors else rest[-1] if rest else f"ended with exit code {process.returncode}"
        raise RunError(message, process.returncode, log)
    if process.returncode:
        tell(f"stopped {IN_ORDER[process.returncode]} before its end")
    return log


def tell(text: str) -> None:
    warnings.warn(text, UdarWarning, stacklevel=4)  # at the call of run or resume


def with_warnings(results: Results, log: str) -> Results:
    results.log = log
    for text in results.warnings:
        tell(text)
    return results


def run(case: Case = None, out: Path | None = None, ranks: int = 1, timeout: float | None = None,
        **options: typing.Any) -> Results:
    """Runs a case to its end.

    `case`: a case file, or options by key, or None where the options say all. `out`: the folder for the results; None:
    a temporary one that goes with the `Results`. `ranks`: on so many, by `mpiexec` (the environment variable MPIEXEC).
    `timeout`: wall time [s] after which the run is ended. `options`: PETSc's, in SI units, and win over the case:
    `udar.run("case.yaml", filter_frequency=100, support_position=[2, 8], floor=True)`.

    Raises RunError with the message of the program, UserError for what is not as it should be before that. What a run
    warns of, and that it stopped early but in order, is a `UdarWarning`.
    """
    if "output_directory" in options:
        raise UserError("output_directory: the folder is given as out")
    given = {**case, **options} if isinstance(case, collections.abc.Mapping) else options
    words = [] if case is None or isinstance(case, collections.abc.Mapping) else [os.fspath(case)]
    temporary = tempfile.mkdtemp(prefix="udar-") if out is None else None
    folder = pathlib.Path(temporary, "run") if temporary else pathlib.Path(typing.cast(Path, out))
    try:
        log = start([*words, *arguments({**given, "output_directory": folder})], ranks, timeout)
        results = Results(folder)
    except BaseException:
        if temporary:
            shutil.rmtree(temporary, ignore_errors=True)
        raise
    if temporary:
        weakref.finalize(results, shutil.rmtree, temporary, ignore_errors=True)
    return with_warnings(results, log)


def resume(folder: Path, ranks: int = 1, timeout: float | None = None, **options: typing.Any) -> Results:
    """Goes on with a run that was stopped or killed, in its own folder and with its own options (`udar -continue`).

    `options` take the place of the run's, like `ts_max_time` [s]. Raises as `run` does.
    """
    log = start(arguments({"continue": folder, **options}), ranks, timeout)
    return with_warnings(Results(folder), log)
