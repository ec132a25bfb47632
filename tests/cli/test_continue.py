#!/usr/bin/env python3
# size: long
"""`udar -continue RUN`: what a killed, stopped or damaged run comes to when it goes on in its own folder."""

import ctypes
import os
import shutil
import signal
import time
import unittest

import h5py
import numpy as np

import same_run
from common import ROOT, UdarTest, case, command, read_csv, run, start

RANKS = 2
OFTEN = {"output_interval": 5e-4, "output_field_interval": 2e-3, "restart_interval": 4e-3}
LOW = {"initial_height": 0.05, "gauge_position": "0,5,10", "ts_max_time": 0.2}
NETWORK = {
    "structure_type": "network", "network_lattice": "2,2,2", "network_spacing": 0.5, "network_elements": 4,
    "network_section": "tube", "network_section_radius": 0.02, "network_section_inner_radius": 0.017,
    "network_rotation": "0,0,0.02", "initial_height": 0.02, "floor": "true", "contact_restitution": 0.5,
    "filter_frequency": 300, "ts_max_time": 0.15,
}
KINDS = {
    "chebyshev": case(**LOW, **OFTEN, ts_type="chebyshev", contact_restitution=0.7),
    "impact": case(**LOW, **OFTEN, ts_type="impact", support_width=0.9, contact_restitution=0.7, filter_frequency=500),
    "modal": case(**LOW, **OFTEN, ts_type="modal", contact_surface="line", contact_restitution=1),
    "rk": case(**LOW, **OFTEN, ts_type="rk", contact_restitution=0.7),
    "striker": case(**LOW, **OFTEN, ts_type="impact", contact_restitution=0.7, striker_position="4,7",
                    striker_mass="30,200", striker_velocity="-3,0", striker_law="crush,hertz",
                    striker_stiffness="1e6,1e8", striker_plateau_force=5e3),
    "network": {**NETWORK, **OFTEN, "ts_type": "impact"},
    "pair": {key: value for key, value in {**NETWORK, **OFTEN, "ts_type": "impact"}.items()
             if key not in ("floor", "contact_restitution")} | {
                 "initial_part": "-1,1,0.4,1,-1,1", "initial_part_velocity": "0,-0.1,0",
                 "pair_from_junction": "0 0 0,1 0 1", "pair_to_junction": "0 1 0,1 1 0", "pair_gap": "1e-5,1e-6",
                 "pair_law": "hertz,none", "pair_stiffness": 1e8},
}
IN_THE_FOLDER = {"output_directory": "run"}
AGAIN = {"continue": "run"}


def killed(number):
    """The program is killed in the middle of its number-th flush of results.h5."""
    return {"LD_PRELOAD": os.environ["UDAR_KILL_AT_RESIZE"], "KILL_AT_RESIZE": str(number)}


class Continued(UdarTest):
    def in_folder(self, name, options, ranks=RANKS, code=0, **keywords):
        folder = self.scratch / name
        folder.mkdir(exist_ok=True)
        result = run(options, ranks, cwd=folder, **keywords)
        if code is not None:
            self.assertEqual(result.code, code, result)
        return result, folder / "run"

    def kill(self, name, options, flush, ranks=RANKS):
        """The folder of a run that was killed at that flush, or at the first one after a checkpoint."""
        for number in range(flush, flush + 40):
            shutil.rmtree(self.scratch / name, ignore_errors=True)
            result, folder = self.in_folder(name, options | IN_THE_FOLDER, ranks, code=None,
                                            environment=killed(number))
            self.assertFalse((folder / "summary.json").exists(), f"the run is to be killed\n{result}")
            # On a slow machine flushes come by the clock, too.
            if flush == 1 or (folder / "restart.previous.h5").exists():
                return folder
        raise AssertionError("no checkpoint")

    def straight(self, options, ranks=RANKS):
        shutil.rmtree(self.scratch / "straight", ignore_errors=True)
        return self.in_folder("straight", options | IN_THE_FOLDER, ranks)[1]

    def assert_same(self, one, other):
        self.assertEqual(same_run.differences(one, other), [])

    def test_every_kind_goes_on_to_the_same_bits(self):
        """Killed in the midst of a flush, twice, then left to its end."""
        for kind, ranks in (("chebyshev", 2), ("impact", 0), ("modal", 2), ("rk", 0), ("network", 2), ("striker", 2),
                            ("pair", 2)):
            with self.subTest(kind=kind):
                straight = self.straight(KINDS[kind], ranks)
                folder = self.kill("killed", KINDS[kind], 8, ranks)
                self.in_folder("killed", AGAIN, ranks, code=None, environment=killed(4))
                self.assertFalse((folder / "summary.json").exists(), "it is to be killed again")
                result, _ = self.in_folder("killed", AGAIN, ranks)
                self.assertIn("goes on at t = ", result.out)
                self.assert_same(straight, folder)

    def test_before_the_first_step(self):
        """Killed while results.h5 is made: it is known which run was to begin."""
        options = KINDS["chebyshev"]
        straight = self.straight(options, 0)
        folder = self.kill("killed", options, 1, ranks=0)
        self.assertEqual(run({"restart_file": folder / "restart.h5", "filter_frequency": 100}).code, 1)
        result, _ = self.in_folder("killed", AGAIN, 0)
        self.assertIn("has no step yet: it begins", result.out)
        self.assert_same(straight, folder)

    def test_damaged_restart_file(self):
        options = KINDS["impact"]
        straight = self.straight(options, 0)
        folder = self.kill("killed", options, 8, ranks=0)
        files = [folder / "restart.h5", folder / "restart.previous.h5"]
        whole = [file.read_bytes() for file in files]
        for file in files:
            data = bytearray(file.read_bytes())
            data[len(data) // 2] ^= 4
            file.write_bytes(data)
        result, _ = self.in_folder("killed", AGAIN, 0, code=1)
        self.assertIn("option -continue", result.errors[0])
        self.assertIn("restart.previous.h5: damaged", result.errors[0])
        files[1].write_bytes(whole[1])
        result, _ = self.in_folder("killed", AGAIN, 0)
        self.assertIn("the run goes on from the restart file before", result.out)
        self.assert_same(straight, folder)
        for name in ("gauges.csv", "results.h5"):  # shorter than the restart file says
            with self.subTest(cut=name):
                self.kill("killed", options, 8, ranks=0)
                os.truncate(folder / name, 100)
                result, _ = self.in_folder("killed", AGAIN, 0, code=1)
                self.assertIn("it is shorter than when the restart file was written", result.errors[0])

    def test_damaged_results(self):
        """What HDF5 writes over comes from the restart file, whatever has become of it."""
        options = KINDS["impact"]
        straight = self.straight(options, 0)
        folder = self.kill("killed", options, 8, ranks=0)
        with open(folder / "results.h5", "r+b") as file:
            file.write(b"\0" * 512)  # not even the signature is left
        self.in_folder("killed", AGAIN, 0)
        self.assert_same(straight, folder)

    def test_changes(self):
        options = KINDS["chebyshev"]
        folder = self.kill("killed", options, 8, ranks=0)
        for change, words in (
            ({"filter_frequency": 120}, ("-continue", "120", "100")),
            ({"gauge_position": "0,5"}, ("gauges.csv", "gauge 2: (10, 0, 0) m there, none here")),
            ({"gauge_position": "0,5,9"}, ("gauges.csv", "gauge 2: (10, 0, 0) m there, (9, 0, 0) m here")),
            ({"output_directory": "other"}, ("-output_directory", "-continue")),
            ({"restart_file": "run/restart.h5"}, ("-restart_file", "-continue")),
        ):
            with self.subTest(change=change):
                result, _ = self.in_folder("killed", AGAIN | change, 0, code=1)
                for word in words:
                    self.assertIn(word, result.errors[0])
        end = {"ts_max_time": 0.25, "ts_rtol": 1e-7, "output_field_interval": 4e-3}
        self.in_folder("killed", AGAIN | end, 0)
        times = read_csv(folder / "gauges.csv")["time"]
        np.testing.assert_allclose(times, 5e-4 * np.arange(501), rtol=1e-12)
        before = (folder / "summary.json").read_bytes()
        result, _ = self.in_folder("killed", AGAIN, 0)
        self.assertIn("has reached its end", result.out)
        self.assertEqual((folder / "summary.json").read_bytes(), before)
        self.in_folder("killed", AGAIN | {"ts_max_time": 0.26}, 0)
        times = read_csv(folder / "gauges.csv")["time"]
        np.testing.assert_allclose(times, 5e-4 * np.arange(521), rtol=1e-12, err_msg="neither gap nor double row")

    def test_integrator_may_change(self):
        folder = self.kill("killed", KINDS["chebyshev"], 8, ranks=0)
        result, _ = self.in_folder("killed", AGAIN | {"ts_type": "impact"}, 0)
        self.assertIn("impact takes over masses and contact", result.out)
        self.assertEqual(len(read_csv(folder / "gauges.csv")["time"]), 401)

    def test_semaphores_that_a_killed_run_left(self):
        """Open MPI names them after the file alone: another run would wait for them for ever."""
        library = ctypes.CDLL(None)
        library.sem_open.restype = ctypes.c_void_p
        for file in ("restart.h5.tmp", "results.h5", "results.vtkhdf.tmp"):
            name = f"/OMPIO_{file}".encode()
            self.assertTrue(library.sem_open(name, os.O_CREAT, 0o600, 0))  # locked
            self.addCleanup(library.sem_unlink, name)
        self.in_folder("left", KINDS["impact"] | IN_THE_FOLDER | {"ts_max_time": 0.01})

    def test_from_another_folder(self):
        """Files that options name are looked for where they were, and a run that was moved is found."""
        (self.scratch / "load.csv").write_text("0,0\n0.1,-100\n1,-100\n")
        options = KINDS["chebyshev"] | {"load_position": 5, "load_table": "../load.csv"}
        folder = self.kill("killed", options, 8, ranks=0)
        result = run({"continue": folder}, 0, cwd=self.scratch)
        self.assertEqual(result.code, 0, result)
        self.assertIn("files are looked for from", result.out)
        moved = self.scratch / "moved"
        shutil.rmtree(folder)
        self.kill("killed", options, 8, ranks=0).rename(moved)
        self.assertEqual(run({"continue": moved}, 0, cwd=self.scratch).code, 0)
        self.assertTrue((moved / "summary.json").exists())
        self.assertFalse(folder.exists())

    def test_not_a_run(self):
        (self.scratch / "run").mkdir()
        for options, word in ((AGAIN, "it holds no restart.h5"), ({"continue": "nowhere"}, "it holds no restart.h5")):
            result = run(options, cwd=self.scratch)
            self.assertEqual(result.code, 1)
            self.assertIn(word, result.errors[0])
        (self.scratch / "run" / "summary.json").write_text("{}")
        result = run(AGAIN, extra=["-options_file", str(ROOT / "examples" / "01-falling-beam" / "case.yaml")],
                     cwd=self.scratch)
        self.assertIn("it holds results, and no restart.h5", result.errors[0])

    def test_case_begins_where_there_is_nothing(self):
        """The line of a batch script is the same at the first start and at all later ones."""
        file = ["-options_file", str(ROOT / "examples" / "01-falling-beam" / "case.yaml")]
        options = AGAIN | {"filter_frequency": 100, "ts_max_time": 0.6}
        first = run(options | {"ts_max_steps": 4}, extra=file, cwd=self.scratch)
        self.assertEqual(first.code, 3, first)
        self.assertIn("the run begins", first.out)
        last = run(options | {"ts_max_steps": 1000}, extra=file, cwd=self.scratch)
        self.assertEqual(last.code, 0, last)
        self.assertIn("goes on at t = ", last.out)

    def test_run_that_is_still_going(self):
        options = case(output_directory=self.scratch / "run", ts_max_time=1e5, output_allow_large=True)
        process = start(command(options, RANKS), cwd=self.scratch)
        while not (self.scratch / "run" / "energy.csv").exists() and process.poll() is None:
            time.sleep(0.05)
        files = [self.scratch / "run" / name for name in ("results.h5", "gauges.csv", "restart.h5")]
        before = [file.stat().st_ino for file in files]
        for options in (AGAIN, case(output_directory="run", output_overwrite=True)):
            result = run(options, cwd=self.scratch)
            self.assertEqual(result.code, 1)
            self.assertIn("is in use: another udar writes into it", result.errors[0])
        self.assertEqual([file.stat().st_ino for file in files], before, "all are left as they are")
        process.send_signal(signal.SIGUSR1)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 138)

    def test_limits_by_the_clock(self):
        options = case(ts_max_time=1e5, output_allow_large=True, output_interval=0.5, restart_wall_minutes=0.001)
        result, folder = self.in_folder("late", options | IN_THE_FOLDER | {"wall_limit": 1.5}, code=4)
        self.assertIn("go on with udar -continue run", result.out)
        self.assertTrue((folder / "restart.previous.h5").exists(), "by the clock")
        reached = read_csv(folder / "gauges.csv")["time"][-1]
        self.in_folder("late", AGAIN | {"ts_max_time": reached + 2.0, "wall_limit": 0})
        times = read_csv(folder / "gauges.csv")["time"]
        np.testing.assert_allclose(np.diff(times)[:-1], 0.5, rtol=1e-9)

    def test_other_numbers_of_ranks(self):
        """1, 3, then 2 ranks, each killed but the last: to round-off, before chaos."""
        for kind, options in KINDS.items():
            options = options | {"ts_max_time": 0.15}
            with self.subTest(kind=kind):
                straight = self.straight(options, 0)
                folder = self.kill("killed", options, 6, ranks=0)
                self.in_folder("killed", AGAIN, 3, code=None, environment=killed(3))
                self.assertFalse((folder / "summary.json").exists(), "it is to be killed again")
                self.in_folder("killed", AGAIN, 2)
                # 1e-9 of the size of a curve, of which its range is twice at most.
                self.assert_same_curves(straight, folder, tolerance=0.5e-9)
                rows = [h5py.File(path / "results.h5")["energy"]["total"] for path in (straight, folder)]
                np.testing.assert_allclose(*rows, rtol=1e-9)

    def test_overwrite_says_what_goes(self):
        """Results that a kept restart file belongs to do not go unseen."""
        folder = self.kill("killed", KINDS["chebyshev"], 8, ranks=0)
        here = IN_THE_FOLDER | {"restart_file": "run/restart.h5", "output_overwrite": True}
        result, _ = self.in_folder("killed", KINDS["chebyshev"] | here, 0)
        self.assertIn("-output_overwrite removes the results in 'run' that its restart file belongs to", result.err)
        self.assertGreater(read_csv(folder / "gauges.csv")["time"][0], 0.0)


if __name__ == "__main__":
    unittest.main()
