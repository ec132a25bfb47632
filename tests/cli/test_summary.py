#!/usr/bin/env python3
# size: medium
"""The end of a run on the terminal: the page, -udar_summary, -output_monitor, and the numbers behind them."""

import json
import math
import re
import unittest

import numpy as np

from common import ROOT, UdarTest, case, read_csv

PREFIXES = {"": 1.0, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}


def page_of(result):
    """Lines between what is said at the start and the last one."""
    lines = result.out.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("output "))
    last = next(i for i, line in enumerate(lines) if line.startswith("udar: finished"))
    return lines[first + 1:last]


def quantity(text, unit):
    """The first number of a text in that unit, prefix considered."""
    number, prefix = re.search(rf"(-?[\d.e+-]+) ([mkMG]?){unit}(?!\w)", text).groups()
    return float(number) * PREFIXES[prefix]


class Page(UdarTest):
    def line(self, lines, words):
        found = [line for line in lines if line.startswith(words + " ")]
        self.assertEqual(len(found), 1, f"{words} in {lines}")
        return found[0]

    def test_says_what_summary_and_files_say(self):
        options = case(beam_yield_stress=235e6, ts_max_time=1.2, contact_restitution=0.8)
        for ranks in (0, 2):
            with self.subTest(ranks=ranks):
                done = self.run_case(options, ranks, name=f"run-{ranks}")
                page, summary = page_of(done), done.summary()
                self.assertLessEqual(len(page), 24)
                self.assertLessEqual(max(map(len, page)), 120)
                for words, key, unit in (("moment", "max_moment", "N m"), ("shear", "max_shear", "N"),
                                         ("stress", "max_bending_stress", "Pa"),
                                         ("deflection", "max_deflection", "m")):
                    line = self.line(page, words)
                    self.assertAlmostEqual(quantity(line, unit) / summary[key], 1, delta=1e-3, msg=line)
                    self.assertIn(f"x = {summary[key + '_x']:.4g} m, t = {summary[key + '_time']:.4g} s", line)
                self.assertAlmostEqual(quantity(self.line(page, "utilisation"), "%") / 100,
                                       summary["max_utilisation"], delta=1e-3)
                envelope = read_csv(done.file("envelope.csv"))
                for key in ("moment", "shear"):
                    largest = np.nanmax(np.abs([envelope[f"{key}_min"], envelope[f"{key}_max"]]))
                    self.assertEqual(summary[f"max_{key}"], largest)
                events = [read_csv(done.file(name)) for name in ("impacts.csv", "rests.csv")]
                for support, line in enumerate(page[1:3]):
                    times = np.concatenate([table["time"][table["support"] == support] for table in events])
                    self.assertEqual(summary["support_first_contact"][support], times.min())
                    self.assertEqual(summary["support_last_contact"][support], times.max())
                    self.assertAlmostEqual(quantity(line, "N") / summary["peak_support_force"][support], 1, delta=1e-3)
                energy = read_csv(done.file("energy.csv"))
                for key in ("kinetic", "line_strain", "fictitious_springs", "lost_in_impacts"):
                    self.assertEqual(summary["energy"][key], energy[key][-1])

    def test_rebound_is_that_of_a_rigid_body(self):
        """A beam on one wide support, so stiff that nothing rings, comes back with e times its speed."""
        stiff = case(beam_young_modulus=2.1e17, filter_frequency=3000, beam_elements=10, support_position=5,
                     support_width=20, contact_restitution=0.6, initial_height=0.2, ts_max_time=0.3,
                     ts_type="chebyshev")
        summary = self.run_case(stiff, name="stiff").summary()
        speed = math.sqrt(2 * 9.81 * 0.2)
        self.assertAlmostEqual(summary["impact_velocity"], -speed, delta=1e-9)
        self.assertAlmostEqual(summary["rebound_velocity"], 0.6 * speed, delta=1e-6 * speed)
        self.assertLess(summary["max_deflection"], 1e-9)

    def test_what_lay_on_its_supports_has_no_rebound(self):
        lying = self.run_case(case(initial_height=0, ts_max_time=0.05), name="lying")
        self.assertIsNone(lying.summary()["impact_velocity"])
        self.assertGreater(lying.summary()["peak_support_force"][0], 0)
        self.assertNotIn("rebound", "\n".join(page_of(lying)))

    def test_deflection_of_a_held_beam_is_its_displacement(self):
        """A pinned beam under a sudden load at its middle swings to twice the static sag."""
        load, length = 1000.0, 10.0
        (self.scratch / "load.csv").write_text(f"0,{-load}\n")
        held = case(support_position=None, beam_left_end="pinned", beam_right_end="pinned", gravity=0,
                    initial_height=40, load_position=5, load_table=self.scratch / "load.csv", ts_max_time=0.2,
                    filter_frequency=3000, beam_elements=40)
        summary = self.run_case(held, name="held").summary()
        stiffness = 2.1e11 * math.pi * 0.1**4 / 4
        sag = load * length**3 / (48 * stiffness)
        self.assertAlmostEqual(summary["max_displacement"] / (2 * sag), 1, delta=0.02)
        self.assertEqual(summary["max_displacement_x"], 5)
        self.assertIsNone(summary["impact_velocity"])
        self.assertNotIn("max_deflection", summary)

    def test_many_supports_and_space(self):
        floor = self.run_case({"structure_type": "network", "network_grillage": "2,2", "network_spacing": 1,
                               "network_elements": 3, "network_section": "tube", "network_section_radius": 0.02,
                               "network_section_inner_radius": 0.017, "floor": "true", "initial_height": 0.05,
                               "filter_frequency": 400, "contact_restitution": 0.5, "ts_max_time": 0.2,
                               "ts_type": "impact"}, name="net")
        page = page_of(floor)
        self.assertRegex(self.line(page, "moment about z"), r"in member \d+, t = ")
        self.assertRegex(self.line(page, "deflection"), r"at \(.*\) m, t = ")
        many = self.run_case(case(support_position=",".join(str(0.5 * i) for i in range(21)), ts_max_time=0.6),
                             name="many")
        page = page_of(many)
        self.assertLessEqual(len(page), 24)
        self.assertIn("     15 more with smaller forces, in summary.json", page)

    def test_none_and_json(self):
        options = case(ts_max_time=0.5)
        none = self.run_case(options | {"udar_summary": "none"}, name="none")
        self.assertEqual(page_of(none), [])
        for ranks in (0, 2):
            told = self.run_case(options | {"udar_summary": "json", "filter_frequency": "auto"}, ranks,
                                 name=f"json-{ranks}")
            self.assertEqual(json.loads(told.out), told.summary())
            self.assertIn("udar: finished", told.err)

    def test_monitor(self):
        done = self.run_case(case(output_monitor=0.1, ts_max_time=0.75), 2, name="monitor")
        rows = [line.split() for line in done.out.splitlines() if re.match(r" +\d", line) and "x =" not in line]
        table = np.array(rows, dtype=float)
        np.testing.assert_allclose(table[:, 0], [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75], rtol=1e-6)
        energy = read_csv(done.file("energy.csv"))
        kinetic = np.interp(table[:, 0], energy["time"], energy["kinetic"])
        np.testing.assert_allclose(table[:, 1], kinetic, rtol=1e-4)
        self.assertEqual(sum(line.startswith("# ") for line in done.out.splitlines()), 1)

    def test_documented_page(self):
        """README shows the page of its first command; where both supports are alike, either may have the largest."""
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        shown = re.search(r"```\n(support  .*?)```", text, re.DOTALL).group(1).splitlines()
        done = self.run_case({"options_file": ROOT / "examples/01-falling-beam/case.yaml", "beam_elements": 80,
                              "contact_surface": "line", "filter_frequency": "auto", "filter_modes": 3,
                              "ts_rtol": 1e-7, "ts_max_time": 0.75}, name="01")
        page = page_of(done)

        def told(lines):
            return [line.partition(" at x")[0] for line in lines if "balance" not in line]

        self.assertEqual(told(page), told(shown))


if __name__ == "__main__":
    unittest.main()
