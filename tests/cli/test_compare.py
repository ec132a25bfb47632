#!/usr/bin/env python3
# ranks: 1; size: medium
"""udar-compare: two runs, or a run and the curves of a CSV file, by a tolerance."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

from common import ENVIRONMENT, UdarTest, case, read_csv, run

BUILD = pathlib.Path(os.environ["UDAR_BUILD_DIR"])
FALL = case(ts_max_time=0.6, output_interval=0.002, contact_restitution=0.5)


def write_csv(path, columns):
    rows = zip(*columns.values())
    path.write_text("\n".join([",".join(columns), *(",".join(f"{value:.17g}" for value in row) for row in rows)]))
    return path


class Compare(UdarTest):
    @classmethod
    def setUpClass(cls):
        cls.runs = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        for name, changes in (("one", {}), ("stiff", {"filter_frequency": 150}), ("long", {"ts_max_time": 0.65}),
                              ("coarse", {"output_interval": 0.004})):
            done = run({**FALL, **changes, "output_directory": cls.runs / name})
            assert done.code == 0, done
        cls.gauges = read_csv(cls.runs / "one" / "gauges.csv")

    def compare(self, first, second, *arguments, code):
        paths = [self.runs / part if isinstance(part, str) else part for part in (first, second)]
        line = [str(BUILD / "udar-compare"), *map(str, paths), *arguments]
        done = subprocess.run(line, capture_output=True, text=True, env=ENVIRONMENT, timeout=60)
        self.assertEqual(done.returncode, code, f"{line}\n{done.stdout}{done.stderr}")
        return done.stderr if code == 2 else json.loads(done.stdout) if "--json" in arguments else done.stdout

    def refuse(self, second, words, *arguments, first="one"):
        said = self.compare(first, second, *arguments, code=2)
        self.assertEqual(len(said.splitlines()), 1, said)
        self.assertIn(words, said)

    def test_a_run_is_itself(self):
        found = self.compare("one", "one", "--tolerance", "0", "--json", code=0)
        self.assertTrue(found["within"])
        self.assertEqual(len(found["curves"]), 15 + 4 + 13)  # gauges, forces and impulses, energies
        self.assertEqual(max(curve["largest"] for curve in found["curves"]), 0)
        self.assertGreater(found["impacts"]["matched"], 5)
        self.assertIn("support_impulse_1", [number["name"] for number in found["scalars"]])

    def test_another_filter_frequency(self):
        found = self.compare("one", "stiff", "--json", code=1)
        self.assertEqual(found["options"], {"filter_frequency": ["100", "150"]})
        curves = {curve["name"]: curve for curve in found["curves"]}
        other = read_csv(self.runs / "stiff" / "gauges.csv")
        off = np.abs(other["line_2"] - self.gauges["line_2"])
        line = curves["line_2"]
        self.assertEqual((line["largest"], line["time"]), (off.max(), self.gauges["time"][off.argmax()]))
        self.assertAlmostEqual(line["relative"], off.max() / np.ptp(self.gauges["line_2"]), places=14)
        time = self.gauges["time"]
        self.assertAlmostEqual(line["rms"], np.sqrt(np.sum((off[1:]**2 + off[:-1]**2) / 2 * np.diff(time)) / time[-1]),
                               delta=0.02 * line["rms"])
        self.assertEqual(line["apart_from"], time[off > 0.01 * np.ptp(self.gauges["line_2"])][0])
        numbers = {number["name"]: number for number in found["scalars"]}
        self.assertGreater(line["apart_from"], numbers["first_contact_time"]["first"])
        first, second = (json.loads((self.runs / name / "summary.json").read_text())["support_impulse"][0]
                         for name in ("one", "stiff"))
        impulse = numbers["support_impulse_0"]
        self.assertEqual((impulse["first"], impulse["second"]), (first, second))
        self.assertAlmostEqual(impulse["relative"], abs(first - second) / max(first, second))
        page = self.compare("one", "stiff", code=1)
        for words in ("options    -filter_frequency: 100 and 150", "line_2", "verdict    beyond the tolerance"):
            self.assertIn(words, page)
        self.assertLessEqual(max(map(len, page.splitlines())), 120 + len(str(self.runs)))

    def test_tolerances(self):
        """Absolute ones by unit or by column, in place of the relative one."""
        largest = {curve["name"]: curve["largest"]
                   for curve in self.compare("one", "stiff", "--json", code=1)["curves"]}
        for tolerance, code in ((largest["line_2"] * 1.001, 0), (largest["line_2"] * 0.999, 1)):
            for name in ("m", "line_2"):
                self.compare("one", "stiff", "--columns", "line_2=line_2", "--tolerance", f"{name}={tolerance!r}",
                             code=code)
        self.compare("one", "stiff", "--columns", "line_2=line_2", "--tolerance", "2", code=0)
        self.compare("one", "stiff", "--columns", "line_2=line_2", "--tolerance", "2", "--tolerance", "m=0", code=1)
        for text in ("small", "-1", "m=", "m=x", "nan"):
            self.refuse("stiff", f"'{text}' is neither a number", "--tolerance", text)

    def test_impacts_are_paired(self):
        """A run whose impacts were edited: one later, one gone, one more, one faster."""
        edited = self.scratch / "edited"
        shutil.copytree(self.runs / "one", edited)
        (edited / "summary.json").unlink()  # impacts are then those of the CSV file
        lines = (edited / "impacts.csv").read_text().splitlines()
        rows = [line.split(",") for line in lines[1:]]
        rows[0][0] = repr(float(rows[0][0]) + 1e-5)
        rows[1][4] = repr(float(rows[1][4]) - 2e-3)
        gone = rows.pop(4)
        rows.append(["0.59", *rows[0][1:]])
        (edited / "impacts.csv").write_text("\n".join([lines[0], *map(",".join, rows)]) + "\n")
        found = self.compare("one", edited, "--tolerance", "1e-4", "--json", code=1)["impacts"]
        self.assertEqual([found[key] for key in ("matched", "missing", "extra")], [len(rows) - 1, 1, 1])
        self.assertAlmostEqual(found["time"], 1e-5, places=12)
        self.assertAlmostEqual(found["speed"], 2e-3, places=12)
        self.assertEqual(found["first_alone"], float(gone[0]))
        found = self.compare("one", edited, "--tolerance", "s=9e-6", "--json", code=1)["impacts"]
        self.assertEqual([found[key] for key in ("matched", "missing", "extra")], [len(rows) - 2, 2, 2])
        self.assertIn("edited has not ended: no summary.json", self.compare("one", edited, code=1))

    def test_runs_of_other_lengths_and_rows(self):
        found = self.compare("one", "long", "--json", code=1)
        self.assertEqual((found["begin"], found["end"]), (0, 0.6))
        self.assertEqual([number["name"] for number in found["scalars"] if not number["within"]], ["end_time"])
        self.assertEqual([curve["name"] for curve in found["curves"] if not curve["within"]], [])
        self.assertIn("301 and 151 rows, at the times of both, linear between rows, 0 to 0.6 s",
                      self.compare("one", "coarse", code=1))

    def test_measured_curves(self):
        """In other units, at other times, under other names; a shift in time is seen."""
        time = np.arange(0.1, 0.7, 0.0005)
        line = np.interp(time, self.gauges["time"], self.gauges["line_2"])
        same = write_csv(self.scratch / "same.csv", {"t [ms]": 1e3 * time, "deflection [mm]": 1e3 * line})
        columns = ("--columns", "time=t,line_2=deflection")
        found = self.compare("one", same, *columns, "--tolerance", "1e-12", "--json", code=0)
        self.assertAlmostEqual(found["begin"], 0.1)
        self.assertAlmostEqual(found["end"], 0.6)
        self.assertLess(found["curves"][0]["largest"], 1e-14)
        self.assertRegex(self.compare("one", same, *columns, code=0), "line_2 +m ")  # a few are listed if within, too
        shifted = write_csv(self.scratch / "shifted.csv", {"t": time + 0.01, "deflection": line})
        found = self.compare("one", shifted, *columns, "--json", code=1)["curves"][0]
        speed = np.abs(np.gradient(self.gauges["line_2"], self.gauges["time"])).max()
        self.assertAlmostEqual(found["largest"], 0.01 * speed, delta=0.001 * speed)

    def test_a_file_of_gauges_is_compared_by_names(self):
        found = self.compare("one", self.runs / "one" / "gauges.csv", "--tolerance", "0", "--json", code=0)
        self.assertEqual(len(found["curves"]), 15)
        more = write_csv(self.scratch / "more.csv", {"time": self.gauges["time"], "line_2": self.gauges["line_2"],
                                                     "temperature": self.gauges["line_2"]})
        self.assertIn("only in the second: temperature", self.compare("one", more, code=0))

    def test_what_cannot_be_compared_is_named(self):
        time, line = self.gauges["time"], self.gauges["line_2"]
        csv = self.scratch / "curves.csv"
        cases = (
            ({"time": time, "x": line}, "no curve of", ()),
            ({"time": time, "x": line}, "no curve 'y', there are x", ("--columns", "line_2=y")),
            ({"time": time, "line_2": line}, "no curve 'line_9', there are mass_0", ("--columns", "line_9=line_2")),
            ({"t": time, "line_2": line}, "no column 'time', only t, line_2", ()),
            ({"time": time, "line_2 [N]": line}, "line_2 has the unit N, expected m", ()),
            ({"time [h]": time, "line_2": line}, "time has the unit h, expected s", ()),
            ({"time": time + 9, "line_2": line}, "no time is in both", ()),
            ({"time": time[::-1], "line_2": line}, "time does not grow in row 2", ()),
            ({"time": time, "line_2": np.where(time == 0.02, np.nan, line)}, "line_2 is no number in row 11", ()),
            ({"time": time[:0], "line_2": line}, "no rows below the names", ()),
        )
        for columns, words, arguments in cases:
            self.refuse(write_csv(csv, columns), words, *arguments)
        csv.write_text("")
        self.refuse(csv, "no column 'time'")
        csv.write_text("time,line_2\n0,1\n0.1,\n")
        self.refuse(csv, "curves.csv: could not convert string")
        self.refuse(self.scratch / "none", "no such folder")
        self.refuse(csv, "no such folder", first=self.scratch / "none")
        self.refuse("stiff", "is not a list like", "--columns", "line_2")

    def test_no_number_is_never_within(self):
        broken = self.scratch / "broken"
        shutil.copytree(self.runs / "one", broken)
        lines = (broken / "gauges.csv").read_text().splitlines()
        lines[11] = lines[11].replace(lines[11].split(",")[3], "nan", 1)
        (broken / "gauges.csv").write_text("\n".join(lines) + "\n")
        for first, second in (("one", broken), (broken, "one"), (broken, broken)):
            found = self.compare(first, second, "--tolerance", "1e9", "--json", code=1)["curves"]
            self.assertEqual([curve["name"] for curve in found if not curve["within"]], ["line_0"])
            self.assertIsNone(found[2]["largest"])
            self.assertEqual(found[2]["time"], 0.02)


if __name__ == "__main__":
    unittest.main()
