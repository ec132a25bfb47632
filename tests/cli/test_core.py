#!/usr/bin/env python3
# size: medium
"""udar.core: cases, models and results in memory, with mpi4py and petsc4py; on one rank here, on more by mpiexec."""

import ast
import contextlib
import gc
import inspect
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import unittest
import warnings
import weakref

import h5py
import numpy as np

from common import ALONE, ENVIRONMENT, MPIEXEC, ROOT, UdarTest, case, read_csv

BUILD = pathlib.Path(os.environ.get("UDAR_BUILD_DIR", ROOT / "build"))
RANKED = len(sys.argv) > 2 and sys.argv[1] == "--on-ranks"  # one of the functions at the end, by mpiexec
if not RANKED:
    os.environ.update({**ENVIRONMENT, **ALONE})
import udar  # noqa: E402, what MPI reads comes first

udar.__path__.append(str(BUILD / "python" / "udar"))  # the extension, beside the sources of the package
from mpi4py import MPI  # noqa: E402
from petsc4py import PETSc  # noqa: E402
from udar import core  # noqa: E402

TABLES = ("gauges", "energy", "impacts", "rests")
FALL = {**case(ts_max_time=0.6, output_interval=0.01), "support_position": [2, 8]}
STRUCK = case(support_position=None, beam_left_end="pinned", beam_right_end="pinned", initial_height=0, gravity=0,
              gauge_position=[3, 5], striker_position=5, striker_mass=80, striker_velocity=-3, striker_gap=0.06,
              ts_max_time=0.3)
GRILLAGE = {"structure_type": "network", "network_grillage": [3, 3], "network_elements": 4, "filter_frequency": 200,
            "ts_max_time": 0.02, "initial_height": 0, "support_position": [0, 2], "support_height": -1e-3,
            "output_interval": 0.002, "gauge_place": [1.9, 0, 0.1]}


def digits_of(vector):
    """The numbers of this rank, as bytes: equal to the bit or not."""
    return vector.getArray(readonly=True).tobytes()


def model_of(options, comm=None):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", core.UdarWarning)
        return core.Model(core.Case(options, comm))


def assert_same_table(test, file, table, label):
    expected = read_csv(file)
    names = {"event": "release"} if "event" in expected else {}
    test.assertEqual([names.get(name, name) for name in expected], list(table.dtype.names), label)
    for name, values in expected.items():
        values = values == "release" if name == "event" and len(values) else values
        np.testing.assert_array_equal(table[names.get(name, name)], values, f"{label}: {name}")


class Files(UdarTest):
    """What is in memory is what the program writes, to the bit."""

    def files_of(self, options):
        text = {key: udar.running.as_text(key, value) for key, value in options.items()}
        return self.run_case({**text, "output_field_interval": text["output_interval"],
                              "output_overwrite": "true"}).directory

    def assert_same_as_files(self, options, folder, move, fields=("mass_position", "moment")):
        model = model_of(options)
        recording = model.record(fields=fields)
        move(model)
        self.assertTrue(model.finished)
        for name in TABLES:
            assert_same_table(self, folder / f"{name}.csv", getattr(recording, name)(), name)
        contact = read_csv(folder / "contact.csv")
        for name in ("time", "masses", "x_min", "x_max"):
            np.testing.assert_array_equal(recording.contact()[name], contact[name], name)
        for k, (force, impulse) in enumerate(zip(recording.support_force().T, recording.support_impulse().T)):
            np.testing.assert_array_equal(force, contact[f"force_{k}"])
            np.testing.assert_array_equal(impulse, contact[f"impulse_{k}"])
        results = udar.open(folder)
        self.assertEqual(recording.peak_force().tolist(), results.summary["peak_support_force"])
        self.assertEqual(model.support_impulses.tolist(), results.summary["support_impulse"])
        for name in ("steps", "impacts", "rests", "releases", "rejected_steps"):
            self.assertEqual(model.counts[name], results.summary[name], name)
        with h5py.File(results.path) as file:
            for name in fields:
                np.testing.assert_array_equal(recording.field(name), file[f"fields/{name}"], name)
        self.assertGreater(len(recording.impacts()) + recording.contact()["masses"].sum(), 0)
        return recording

    def in_one_go(self, model):
        self.assertEqual(model.advance(), model.end_time)

    def in_pieces(self, model):
        """Steps, times, a callback that reads the state, which nobody notices."""
        seen = []

        def see(now):
            seen.append((now.time, now.line_position().norm()))
            return len(seen) == 5

        model.step()
        model.advance(0.3 * model.end_time)
        self.assertGreaterEqual(model.time, 0.3 * model.end_time)
        model.advance(callback=see)
        times = [time for time, _ in seen]
        self.assertEqual((times, model.time), (sorted(set(times)), times[-1]))
        self.assertTrue(len(seen) == 5 or model.finished)
        model.advance(model.end_time)

    def test_of_each_integrator(self):
        for options in ({"ts_type": "chebyshev"}, {"ts_type": "impact"}, {"ts_type": "rk", "ts_rtol": 1e-8},
                        {"ts_type": "moreau", "filter_frequency": "none", "ts_dt": 1e-4, "ts_max_time": 0.5},
                        {"ts_type": "modal", "modal_modes": 8, "filter_frequency": None, "modal_estimate": False},
                        {"filter_correct_modes": 2}, {"contact_surface": "line"}):
            given = {key: value for key, value in {**FALL, **options}.items() if value is not None}
            with self.subTest(**options):
                folder = self.files_of(given)
                for move in (self.in_one_go, self.in_pieces):
                    self.assert_same_as_files(given, folder, move)

    def test_of_strikers(self):
        folder = self.files_of(STRUCK)
        recording = self.assert_same_as_files(STRUCK, folder, self.in_pieces)
        assert_same_table(self, folder / "strikers.csv", recording.strikers(), "strikers")

    def test_of_a_network(self):
        self.assert_same_as_files(GRILLAGE, self.files_of(GRILLAGE), self.in_pieces, fields=[])

    def test_of_a_case_file(self):
        """Its keys, those that win over it, and files named in it, from where it lies."""
        path = self.scratch / "case.yaml"
        shutil.copy(ROOT / "examples" / "01-falling-beam" / "case.yaml", path)
        given = core.Case(path, filter_frequency=100, ts_max_time=0.5)
        self.assertEqual((given.filter_frequency, given.end_time, given.supports), (100.0, 0.5, 2))
        self.assertEqual(given.options["support_position"], "2.0,8.0")
        folder = self.run_case({"options_file": path, "filter_frequency": 100, "ts_max_time": 0.5}).directory
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            model = core.Model(given)
        self.assertEqual({warning.category for warning in told}, {core.UdarWarning})
        self.assertLessEqual({str(warning.message) for warning in told}, set(udar.open(folder).warnings))
        recording = model.record()
        model.advance()
        assert_same_table(self, folder / "gauges.csv", recording.gauges(), "gauges")


class Solver(unittest.TestCase):
    """The filter's operator and solver, as objects of petsc4py."""

    def assert_solved(self, operator, unknowns, right):
        """By the normwise backward error, which is rounding: some hundred units in the last place."""
        row_sums, unit, column = 0, unknowns.duplicate(), unknowns.duplicate()
        for index in range(unit.getSize()):
            unit.set(0)
            unit[index] = 1
            unit.assemble()
            operator.mult(unit, column)
            row_sums = row_sums + np.abs(column.getArray())
        largest = PETSc.NormType.NORM_INFINITY
        size = row_sums.max() * unknowns.norm(largest) + right.norm(largest)
        self.assertLess((operator * unknowns - right).norm(largest), 1e-13 * size)

    def test_solves_by_the_handed_ksp(self):
        for options, kind in ((FALL, "chain"), ({**FALL, "filter_pc_type": "lu"}, "lu"), (GRILLAGE, "network")):
            with self.subTest(kind=kind), contextlib.closing(model_of(options)) as model:
                self.assertEqual((model.ksp.getOptionsPrefix(), model.pc.getType()), ("filter_", kind))
                model.advance()
                displacement = model.mass_position()
                force = displacement.duplicate()
                force.setRandom()
                force.scale(1e3)
                right = model.right_hand_side(displacement, force)
                unknowns = right.duplicate()
                model.ksp.solve(right, unknowns)
                self.assert_solved(model.operator, unknowns, right)
                by_ksp, by_udar = model.stretch(unknowns, displacement), model.solve(displacement, force)
                self.assertGreater(by_udar.norm(), 1e-3)
                # Rounding of members condensed to their junctions: 7e-13 found, 0 of beams.
                self.assertLess((by_ksp - by_udar).norm(), 1e-11 * by_udar.norm())

    def test_serves_another_ksp_and_matrix(self):
        """Its PC inside of a Krylov method of petsc4py's own making."""
        model = model_of(FALL)
        solver = PETSc.KSP().create(model.comm)
        solver.setOperators(model.operator)
        solver.setType("gmres")
        solver.setPC(model.pc)
        displacement = model.mass_position()
        displacement.setRandom()
        right = model.right_hand_side(displacement)
        unknowns = right.duplicate()
        solver.solve(right, unknowns)
        self.assertLessEqual(solver.getIterationNumber(), 1)
        self.assert_solved(model.operator, unknowns, right)

    def test_refuses_other_vectors(self):
        model = model_of(FALL)
        short = PETSc.Vec().createSeq(3)
        with self.assertRaisesRegex(core.UserError, "displacement: 3 numbers on a rank are not allowed, expected 21"):
            model.solve(short)
        with self.assertRaisesRegex(core.UserError, "force: expected a Vec of petsc4py"):
            model.solve(model.mass_position(), np.zeros(21))


class Lives(unittest.TestCase):
    """Who keeps whom."""

    def test_vectors_outlive_the_model(self):
        model = model_of(FALL)
        position = model.mass_position()
        expected, references = digits_of(position), position.getRefCount()
        self.assertEqual(references, 1)
        model.advance(0.1)
        self.assertNotEqual(digits_of(model.mass_position()), expected)
        del model
        gc.collect()
        self.assertEqual((digits_of(position), position.getRefCount()), (expected, 1))

    def test_the_solver_keeps_what_it_needs_and_lets_go(self):
        for name in ("ksp", "pc", "operator"):
            with self.subTest(name=name):
                model = model_of(FALL)
                right = model.right_hand_side(model.mass_position())
                held, mark = getattr(model, name), type("Mark", (), {})()
                held.setAttr("mark", mark)
                gone = weakref.ref(mark)
                before, after = right.duplicate(), right.duplicate()
                use = {"ksp": lambda: held.solve(right, after), "pc": lambda: held.apply(right, after),
                       "operator": lambda: held.mult(right, after)}[name]
                use()
                after.copy(before)
                model.close()
                del model, mark
                gc.collect()
                after.set(0)
                use()
                self.assertEqual(digits_of(after), digits_of(before))
                self.assertIsNotNone(gone())
                del held, use
                model_of(FALL).close()  # looks after what was given up before
                gc.collect()
                self.assertIsNone(gone())

    def test_a_model_goes_with_its_last_name(self):
        model = model_of(FALL)
        mark = type("Mark", (), {})()
        model.ksp.setAttr("mark", mark)
        gone = weakref.ref(mark)
        del mark, model
        self.assertIsNone(gone())

    def test_a_recording_keeps_its_model(self):
        with model_of(FALL) as model:
            recording = model.record()
            model.advance(0.2)
            expected = recording.gauges()
        with self.assertRaisesRegex(core.UserError, "the model is closed"):
            model.step()
        del model
        np.testing.assert_array_equal(recording.gauges(), expected)
        self.assertGreater(len(expected), 15)


class Errors(UdarTest):
    """What goes wrong is an exception with the program's own message; all goes on after it."""

    def test_messages_are_the_programs(self):
        for change in ({"support_restitution": 1.5}, {"beam_length": "long"}, {"filter_frequencyy": 3},
                       {"support_position": [2, 30]}, {"gauge_position": 11}, {"contact_surface": "lines"},
                       {"filter_pc_type": "lu", "ksp_type": "cg"}, {"ts_max_time": -1}):
            with self.subTest(**change), self.assertRaises(core.UserError) as refused:
                model_of({**FALL, **change})
            text = {key: udar.running.as_text(key, value) for key, value in change.items()}
            self.refuse_case(case(**text), [str(refused.exception)])
        self.assertEqual(model_of(FALL).time, 0.0)

    def test_keys_of_the_program_are_refused(self):
        for key in ("help", "restart_file", "continue", "options_file"):
            with self.subTest(key=key), self.assertRaisesRegex(core.UserError, f"option -{key} is not allowed"):
                core.Case(FALL, **{key: "x"})

    def test_files(self):
        with self.assertRaisesRegex(core.UserError, "cannot read '/no/case.yaml': No such file"):
            core.Case("/no/case.yaml")
        with self.assertRaisesRegex(core.FileError, "no.yaml"):
            core.Case(structure_type="network", network_file="no.yaml", filter_frequency=100)
        (self.scratch / "case.yaml").write_text("beam: [1, 2", encoding="utf-8")
        with self.assertRaisesRegex(core.UserError, "case.yaml.* line 1"):
            core.Case(self.scratch / "case.yaml")

    def test_solvers_that_fail(self):
        with self.assertRaisesRegex(core.SolveError, "the line solve did not converge: .*DIVERGED"):
            model_of({**FALL, "filter_ksp_type": "cg", "filter_pc_type": "none", "filter_ksp_max_it": 1}).advance()
        with self.assertRaises(PETSc.Error) as kept:  # petsc4py's own handler is in its place again
            PETSc.KSP().create(PETSc.COMM_SELF).setType("nonsense")
        self.assertIn("nonsense", str(kept.exception))

    def test_a_callback_that_fails_ends_the_call_alone(self):
        expected = model_of(FALL)
        expected.advance()
        model = model_of(FALL)
        with self.assertRaises(ZeroDivisionError):
            model.advance(callback=lambda now: 1 / (now.time < 0.3))
        self.assertGreaterEqual(model.time, 0.3)
        model.advance()
        self.assertEqual(digits_of(model.mass_position()), digits_of(expected.mass_position()))

    def test_an_interrupt_comes_through(self):
        def ring(*_):
            raise TimeoutError("that is long enough")

        model = model_of({**FALL, "ts_max_time": 1e6, "ts_type": "impact"})
        before = signal.signal(signal.SIGALRM, ring)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        try:
            with self.assertRaisesRegex(TimeoutError, "long enough"):
                model.advance()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        reached = model.time
        self.assertGreater(reached, 0.0)
        self.assertGreater(model.step(), reached)

    def test_udar_is_not_called_by_its_own_solvers(self):
        model = model_of({**FALL, "filter_pc_type": "lu"})
        refused = []

        def look(_solver, _iteration, _norm):
            try:
                model.step()
            except core.UserError as error:
                refused.append(str(error))

        model.ksp.setMonitor(look)
        model.solve(model.mass_position())
        self.assertTrue(refused and all("udar is at work" in text for text in refused), refused)

    def test_recordings_begin_at_the_start(self):
        model = model_of(FALL)
        with self.assertRaisesRegex(core.UserError, "field 'torque' is not allowed, expected one of mass_position"):
            model.record(fields=["torque"])
        with self.assertRaisesRegex(core.UserError, "interval: -1"):
            model.record(-1)
        model.step()
        with self.assertRaisesRegex(core.UserError, "before the first step"):
            model.record()


class Options(unittest.TestCase):
    def test_of_a_case_are_its_own(self):
        """Those of the process do not reach it, nor its own them, nor another case's."""
        database = PETSc.Options()
        database["beam_length"] = "7"
        first, second = core.Case(FALL, beam_length=5, support_position=[1, 4], gauge_position=0), core.Case(FALL)
        self.assertEqual((first.options["beam_length"], second.options["beam_length"]), ("5", "10"))
        self.assertEqual(database.getAll().get("beam_length"), "7")
        self.assertNotIn("support_position", database.getAll())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", core.UdarWarning)
            models = [core.Model(each) for each in (first, second, first)]
        self.assertEqual([model.places[-1, 0] for model in models], [5.0, 10.0, 5.0])
        self.assertAlmostEqual(models[1].masses.sum(), 7850 * np.pi * 0.1**2 * 10, places=6)
        database.delValue("beam_length")

    def test_may_be_auto(self):
        given = core.Case(FALL, filter_frequency="auto", filter_accuracy=0.05)
        self.assertGreater(given.filter_frequency, 50)

    def test_comm_is_a_communicator(self):
        with self.assertRaisesRegex(TypeError, "expected a communicator of mpi4py or petsc4py"):
            core.Case(FALL, comm=3)
        with self.assertRaisesRegex(core.UserError, "null communicator"):
            core.Case(FALL, comm=MPI.COMM_NULL)
        self.assertEqual(core.Case(FALL, comm=PETSc.COMM_SELF).comm, MPI.COMM_SELF)


class Package(UdarTest):
    def test_types_are_those_of_the_module(self):
        tree = ast.parse((ROOT / "scripts" / "python" / "udar" / "_core.pyi").read_text(encoding="utf-8"))
        typed = {node.name: {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
                 for node in tree.body if isinstance(node, ast.ClassDef)}
        for name in ("Case", "Model", "Recording"):
            kind = getattr(core, name)
            found = {member for member in vars(kind) if not member.startswith("_")}
            self.assertEqual({member for member in typed[name] if not member.startswith("_")}, found, name)
            for member in found:
                self.assertGreater(len(inspect.getdoc(getattr(kind, member))), 10, f"{name}.{member}")

    def python(self, program, **environment):
        folder = BUILD / "python"
        return subprocess.run([sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, cwd=ROOT,
                              timeout=60, env={**ENVIRONMENT, **ALONE, "PYTHONPATH": str(folder), **environment})

    def test_the_page_runs_from_the_build_folder(self):
        page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        programs = [block for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "core" in block]
        self.assertEqual(len(programs), 2)
        for program in programs:
            done = self.python(program)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("impacts", done.stdout)

    def test_it_says_nothing(self):
        """What the program tells of modes and of the frequency it has chosen."""
        done = self.python("from udar import core\n"
                           "core.Model(core.Case('examples/01-falling-beam/case.yaml', filter_frequency='auto',\n"
                           "                     filter_correct_modes=2)).advance(0.1)\n")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_another_petsc_is_refused(self):
        """A copy of the library under another name is another one, with a state of its own."""
        maps = pathlib.Path("/proc/self/maps").read_text(encoding="utf-8")
        library = next(path for path in re.findall(r"/\S+", maps) if "libpetsc" in path)
        other = self.scratch / "libpetsc_other.so"
        other.write_bytes(pathlib.Path(library).read_bytes().replace(b"libpetsc", b"libpetzc"))  # in its SONAME, too
        (self.scratch / "petsc4py").mkdir()
        (self.scratch / "petsc4py" / "__init__.py").write_text("", encoding="utf-8")
        (self.scratch / "petsc4py" / "PETSc.py").write_text(
            f"import ctypes\n__file__ = {str(other)!r}\nctypes.CDLL(__file__)\n", encoding="utf-8")
        done = self.python("import udar.core", PYTHONPATH=f"{self.scratch}:{BUILD / 'python'}")
        self.assertEqual(done.returncode, 1, done)
        self.assertRegex(done.stderr.splitlines()[-1],
                         f"ImportError: petsc4py is of another library than udar: .*'{other}', udar that of '.*petsc")

    def test_what_is_missing_is_named(self):
        (self.scratch / "petsc4py.py").write_text("raise ModuleNotFoundError('no', name='petsc4py')", encoding="utf-8")
        done = self.python("import udar.core", PYTHONPATH=f"{self.scratch}:{BUILD / 'python'}")
        self.assertIn("ImportError: udar needs petsc4py.PETSc for this (Debian: python3-petsc4py, ", done.stderr)
        done = self.python("import udar.core", PYTHONPATH=str(ROOT / "scripts" / "python"))
        self.assertIn("ImportError: udar was built without its extension", done.stderr)


class Ranks(UdarTest):
    """Each runs a function at the end of this file on so many ranks, which prints `passed` on each."""

    def on_ranks(self, ranks, function):
        command = [MPIEXEC, "-n", str(ranks), sys.executable, __file__, "--on-ranks", function.__name__]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stdout.count("passed")), (0, ranks), done)

    def test_two_ranks_are_one(self):
        self.on_ranks(2, two_ranks)

    def test_ranks_may_go_their_own_ways(self):
        self.on_ranks(2, own_ways)

    def test_all_ranks_fail_together(self):
        self.on_ranks(2, failures)


def two_ranks(test):
    """Results are the same on both ranks, and those of one rank."""
    together, alone = model_of(FALL), model_of(FALL, MPI.COMM_SELF)
    tables = []
    for model in (together, alone):
        recording = model.record()
        model.advance(0.25)
        model.advance(callback=lambda now: False)
        tables.append([getattr(recording, name)() for name in (*TABLES, "contact")])
    test.assertLess(len(together.masses), len(alone.masses))
    test.assertEqual(together.comm.allreduce(len(together.masses)), len(alone.masses))
    for shared in tables[0]:
        digits = b"".join(shared[column].tobytes() for column in shared.dtype.names)
        test.assertTrue(all(other == digits for other in together.comm.allgather(digits)))
    for shared, own in zip(*tables):
        for column in own.dtype.names:
            if column != "drift":  # rounding alone
                scale = np.nanmax(np.abs(own[column]), initial=1)
                np.testing.assert_allclose(shared[column], own[column], atol=1e-9 * scale, err_msg=column)
    displacement = together.mass_position()
    right = together.right_hand_side(displacement)
    unknowns = right.duplicate()
    together.ksp.solve(right, unknowns)
    test.assertLess((together.operator * unknowns - right).norm() / right.norm(), 1e-12)
    test.assertLess((together.stretch(unknowns, displacement) - together.solve(displacement)).norm(),
                    1e-11 * displacement.norm())


def own_ways(test):
    """Each rank has a communicator and a case of its own, which goes while the model stays."""
    rank = MPI.COMM_WORLD.rank
    comm = MPI.COMM_WORLD.Split(rank, 0)
    options = {**FALL, "filter_frequency": 100 + 50 * rank}
    model, expected = model_of(options, comm), model_of(options, MPI.COMM_SELF)
    comm.Free()
    for _ in range(1 + rank):
        model.step()
    for each in (model, expected):
        each.advance()
    test.assertEqual(digits_of(model.mass_position()), digits_of(expected.mass_position()))
    alone = MPI.COMM_WORLD.Split(0 if rank == 0 else MPI.UNDEFINED, 0)
    if rank == 0:
        path = ROOT / "examples" / "01-falling-beam" / "case.yaml"
        test.assertEqual(core.Case(path, alone, filter_frequency=100).supports, 2)


def failures(test):
    with test.assertRaisesRegex(core.UserError, "option -beam_length"):
        core.Case(FALL, beam_length=-1)
    with test.assertRaisesRegex(core.UserError, "cannot read '/no/case.yaml'"):
        core.Case("/no/case.yaml")
    model = model_of(FALL)
    size = len(model.masses) + MPI.COMM_WORLD.rank
    with test.assertRaisesRegex(core.UserError, "displacement: "):
        model.solve(PETSc.Vec().createMPI((size, None), comm=model.comm))

    def fail(now):
        if MPI.COMM_WORLD.rank == 1 and now.time > 0.1:
            raise KeyError("here")

    kind = KeyError if MPI.COMM_WORLD.rank == 1 else core.SolveError
    with test.assertRaisesRegex(kind, "here"):
        model.advance(callback=fail)
    stopped = model.advance(callback=lambda now: MPI.COMM_WORLD.rank == 0)
    test.assertEqual(len(set(MPI.COMM_WORLD.allgather(stopped))), 1)
    model.advance()
    test.assertTrue(model.finished)


if __name__ == "__main__":
    if RANKED:
        globals()[sys.argv[2]](unittest.TestCase())
        print("passed", flush=True)
    else:
        unittest.main()
