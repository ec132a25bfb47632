#!/usr/bin/env python3
# size: long
"""What a run does when something it stands on fails: the message and the exit code of docs/faults.md, and what is left.

Also what it does when nothing does: runs of the same case are the same to the bit.
"""

import concurrent.futures
import errno
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest

import h5py
import numpy as np

from common import ENVIRONMENT, ROOT, Finished, UdarTest, case, command, read_csv, run, start

LAUNCHES = (0, 2)  # without mpiexec, and on two ranks
# Rows and checkpoints several times in a run of a tenth of a second.
OFTEN = {"output_interval": 5e-4, "output_field_interval": 5e-3, "restart_interval": 0.02, "ts_type": "impact",
         "contact_restitution": 0.5, "initial_height": 0.05, "ts_max_time": 0.3}


def documented():
    """Exit code and message by fault, from docs/faults.md."""
    rows = {}
    for line in (ROOT / "docs" / "faults.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if len(cells) == 5 and line.startswith("| ") and cells[0] != "fault":
            rows[cells[0].lstrip("| ")] = cells
    return rows


class Faults(UdarTest):
    def check(self, fault, result):
        """One line of error, as the page has it."""
        _, code, message, *_ = documented()[fault]
        self.assertEqual(result.code, int(code), result)
        self.assertEqual(len(result.errors), 1, result)
        pattern = ".*".join(re.escape(part) for part in message.split("…"))
        self.assertRegex(result.errors[0].removeprefix("udar: error: "), f"^{pattern}$", result)
        for noise in ("PETSC ERROR", "HDF5-DIAG", "terminate called"):
            self.assertNotIn(noise, result.err + result.out, result)

    def fail_writing(self, name, error, ranks, **changes):
        """Writes into a file fail from the second checkpoint on."""
        faults = {"LD_PRELOAD": os.environ["UDAR_FAULTS"], "FAULT_FILE": name, "FAULT_AFTER": "restart.previous.h5",
                  "FAULT_ERROR": str(error)}
        shutil.rmtree(self.scratch / "run", ignore_errors=True)
        options = case(output_directory=self.scratch / "run", **{**OFTEN, **changes})
        return run(options, ranks, environment=faults, timeout=180)

    def check_left(self, end=True):
        """Rows are whole, and the run goes on to its end."""
        gauges = read_csv(self.scratch / "run" / "gauges.csv")
        np.testing.assert_allclose(gauges["time"], 5e-4 * np.arange(len(gauges["time"])), rtol=1e-12)
        with h5py.File(self.scratch / "run" / "results.h5") as file:
            self.assertGreater(len(file["energy"]), 0)
        if end:
            rest = run({"continue": self.scratch / "run"})
            self.assertEqual(rest.code, 0, rest)
            gauges = read_csv(self.scratch / "run" / "gauges.csv")
            np.testing.assert_allclose(gauges["time"], 5e-4 * np.arange(601), rtol=1e-12)

    def test_disk_full(self):
        for ranks in LAUNCHES:
            for name, fault in (("gauges.csv", "disk full"), ("results.h5", "disk full, in `results.h5`")):
                with self.subTest(ranks=ranks, name=name):
                    self.check(fault, self.fail_writing(name, errno.ENOSPC, ranks))
                    self.check_left()

    def test_failing_disk(self):
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                self.check("failing disk", self.fail_writing("contact.csv", errno.EIO, ranks))
                self.check_left()

    def test_checkpoint_that_cannot_be_written(self):
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                self.check("checkpoint that cannot be written", self.fail_writing("restart.h5.", errno.ENOSPC, ranks))
                self.check_left()

    def test_output_folder_removed(self):
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                options = case(output_directory=self.scratch / "run", ts_max_time=1e4, output_interval=0.5,
                               output_field_interval=0, support_position=None)
                line = command(options, ranks)
                process = start(line)
                for _ in range(600):
                    if process.poll() is not None or (self.scratch / "run" / "energy.csv").exists():
                        break
                    time.sleep(0.02)
                while (self.scratch / "run").exists():  # files come while others go
                    shutil.rmtree(self.scratch / "run", ignore_errors=True)
                process.send_signal(signal.SIGUSR1)
                out, err = process.communicate(timeout=60)
                directory = options["output_directory"]
                result = Finished(line, process.returncode, out, err, directory)
                self.check("output folder removed under the run", result)

    def test_memory_short(self):
        options = case(output_directory=self.scratch / "run", beam_elements=40000000)
        limit = 3 << 30  # [bytes]: MPI, PETSc and HDF5 map half of it
        process = subprocess.run(command(options), env=ENVIRONMENT, capture_output=True, text=True, timeout=240,
                                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        errors = [line for line in process.stderr.splitlines() if line.startswith("udar: error:")]
        self.assertEqual((process.returncode, len(errors)), (1, 1), process.stderr)
        self.assertIn("memory ran out", errors[0])

    def test_memory_short_in_a_run(self):
        """On the last rank alone, from the second checkpoint on."""
        faults = {"LD_PRELOAD": os.environ["UDAR_FAULTS"],
                  "FAULT_MEMORY_AFTER": str(self.scratch / "run" / "restart.previous.h5")}
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                shutil.rmtree(self.scratch / "run", ignore_errors=True)
                self.check("memory short in a run, on one rank",
                           run(case(output_directory=self.scratch / "run", **OFTEN), ranks, environment=faults))
                self.check_left()

    def test_rank_killed(self):
        endless = {**OFTEN, "ts_max_time": 1e4, "output_allow_large": True}
        options = case(output_directory=self.scratch / "run", **endless)
        process = start(command(options, 2))
        for _ in range(600):
            if process.poll() is not None or (self.scratch / "run" / "restart.previous.h5").exists():
                break
            time.sleep(0.02)
        ranks = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=True).stdout
        os.kill(int(ranks.split()[-1]), signal.SIGKILL)
        _, err = process.communicate(timeout=60)
        _, code, message, *_ = documented()["rank killed"]
        self.assertEqual(process.returncode, int(code), err)
        self.assertIn(message.split("…")[1], err)
        self.check_left(end=False)

    def test_numbers_that_are_none(self):
        """NaN and infinity for every number that a key takes, and in every table."""
        page = (ROOT / "docs" / "options.md").read_text(encoding="utf-8")
        numbers = [(key, takes) for key, takes in re.findall(r"^\| `-(\w+)` \|[^|]*\| ([^|]*) \|", page, re.MULTILINE)
                   if takes.startswith(("number", "list of numbers"))]
        self.assertGreater(len(numbers), 40)
        done = self.run_case(case(ts_max_time=0.01), name="run")
        before = done.file("summary.json").read_text()
        tries = [(key, {key: value}) for key, takes in numbers for value in ("nan", "inf", "-inf")
                 if not (value == "inf" and "inf" in takes)]
        for number, cell in enumerate(("nan", "inf", "-inf")):
            for key, text in (("load_table", f"0,0\n1,{cell}\n"), ("support_motion", f"0,{cell}\n1,0\n"),
                              ("ground_profile", f"0,-1\n10,{cell}\n"), ("initial_shape", f"0,0\n10,{cell}\n")):
                (self.scratch / f"{key}-{number}.csv").write_text(text)
                beside = {"load_position": 5} if key == "load_table" else {}
                tries.append((key, {key: self.scratch / f"{key}-{number}.csv", **beside}))
        with concurrent.futures.ThreadPoolExecutor(2) as workers:
            results = workers.map(lambda one: run(case(**{"ts_max_time": 0.01, "output_overwrite": True,
                                                        "output_directory": done.directory, **one[1]})), tries)
        for (key, changes), result in zip(tries, results, strict=True):
            with self.subTest(**{key: str(changes[key])}):
                self.assertEqual((result.code, len(result.errors)), (1, 1), result)
                self.assertIn(f"-{key}", result.errors[0])
        self.assertEqual(done.file("summary.json").read_text(), before, "the finished run is untouched")

    def test_line_solve(self):
        """A solver that serves a straight line and not one that has hit something."""
        # In flight the right-hand side, and what the check sees of it, is below the absolute tolerance.
        poor = {"filter_ksp_type": "gmres", "filter_pc_type": "jacobi", "filter_ksp_max_it": 3, "filter_ksp_atol": 1e4,
                "ts_type": "rk", "gravity": 0, "initial_velocity": -30, "initial_height": 5, "ts_max_time": 0.3}
        for fault, changes in {"line solve that does not converge": {"filter_check_interval": 0},
                               "line solve that is wrong": {"filter_ksp_max_it": 3000}}.items():
            for ranks in LAUNCHES:
                with self.subTest(fault=fault, ranks=ranks):
                    shutil.rmtree(self.scratch / "run", ignore_errors=True)
                    self.check(fault, run(case(output_directory=self.scratch / "run", **{**poor, **changes}), ranks))

    def test_steps(self):
        steps = {"ts_type": "rk", "ts_adapt_type": "none"}
        for fault, changes in {
            "steps too long": {**steps, "ts_dt": 1, "ts_max_time": 3},
            "steps without length": {**steps, "ts_dt": 1e-300},
            "energy balance off, `-udar_guard stop`":
                {**steps, "ts_dt": 0.04, "ts_max_time": 0.8, "filter_frequency": 50, "udar_guard": "stop"},
        }.items():
            for ranks in LAUNCHES:
                with self.subTest(fault=fault, ranks=ranks):
                    shutil.rmtree(self.scratch / "run", ignore_errors=True)
                    result = run(case(output_directory=self.scratch / "run", **changes), ranks)
                    self.check(fault, result)
                    self.assertTrue(result.file("restart.h5").exists(), "the last good step is kept")

    def test_guard_warns_once_and_goes_on(self):
        coarse = {"ts_type": "rk", "ts_adapt_type": "none", "ts_dt": 0.04, "ts_max_time": 0.8, "filter_frequency": 50}
        warned = self.run_case(case(**coarse), name="warned", ranks=2)
        said = [text for text in warned.summary()["warnings"] if "energy balance" in text]
        self.assertEqual(len(said), 1, warned)
        self.assertRegex(said[0], r"^the energy balance is off by \S+ of the energy at t = 0\.\d+ s, allowed 0\.001 of")
        self.assertEqual(warned.err.count(said[0]), 1, warned)
        self.assertTrue(warned.summary()["completed"])

    def test_time_of_day_that_jumps(self):
        """Clocks that only go forward are asked, if any."""
        jumps = {"LD_PRELOAD": os.environ["UDAR_FAULTS"], "FAULT_CLOCK": "1"}
        for ranks in LAUNCHES:
            plain = self.run_case(case(**OFTEN), ranks, name=f"plain-{ranks}")
            jumping = self.run_case(case(**OFTEN), ranks, name=f"jumping-{ranks}", environment=jumps)
            self.assertEqual(plain.out.replace("plain", ""), jumping.out.replace("jumping", ""))
            for name in ("gauges.csv", "energy.csv", "contact.csv", "impacts.csv"):
                self.assertEqual(plain.file(name).read_bytes(), jumping.file(name).read_bytes())
            for seconds in jumping.summary()["wall_seconds"].values():
                self.assertTrue(0 <= seconds < 60, seconds)

    def test_page_names_tests_that_are_there(self):
        for fault, (*_, tests) in documented().items():
            for name in re.findall(r"\w+\.\w+", tests):
                label, stem = name.split(".")
                found = list((ROOT / "tests" / label).glob(f"*{stem}*"))
                self.assertTrue(found, f"{fault}: {name}")


if __name__ == "__main__":
    unittest.main()
