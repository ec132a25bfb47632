#!/usr/bin/env python3
# ranks: 1; size: medium
"""udar-report: pages of runs, opened from `file:` by Chromium without a window. UDAR_REPORT: the program."""
import os
import re
import shutil
import subprocess
import sys
import time
import types
import unittest
import unittest.mock

import h5py
import numpy as np
from selenium import webdriver
from selenium.webdriver.common.by import By

from common import ROOT, UdarTest, case, command, run, start

sys.path.insert(0, str(ROOT / "scripts" / "python"))

from udar.report import events  # noqa: E402, its place comes first
from udar.report.streams import RecordTable  # noqa: E402
from udar.results import rest_intervals  # noqa: E402

TOOL = os.environ.get("UDAR_REPORT") or str(ROOT / "scripts" / "udar-report.py")
NETWORK = {"structure_type": "network", "network_grillage": "4,3", "network_spacing": "2,1.5", "network_elements": 4}
NASTY = "<script>alert('x')</script> & \"quoted\""


def report(*words, cwd):
    return subprocess.run([TOOL, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=60)


class Browser:
    """One Chromium for all tests: starting it takes longer than a page."""

    driver = None

    @classmethod
    def open(cls):
        if cls.driver is None:
            options = webdriver.ChromeOptions()
            for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         "--window-size=1200,900", "--host-resolver-rules=MAP * ~NOTFOUND"):
                options.add_argument(word)
            options.binary_location = shutil.which("chromium")
            options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
            service = webdriver.chrome.service.Service(shutil.which("chromedriver"))
            cls.driver = webdriver.Chrome(service=service, options=options)
        return cls.driver


def tearDownModule():
    if Browser.driver is not None:
        Browser.driver.quit()


class ReportTest(UdarTest):
    """Runs, their page, and what a browser makes of it."""

    def page_of(self, *folders, words=(), notes=None):
        """Writes the page of these runs and opens it; says what is wrong in the browser's console."""
        done = report(*folders, "--output", self.scratch / "page.html", *words, cwd=self.scratch)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, f"{self.scratch / 'page.html'}\n")
        if notes is None:
            self.assertEqual(done.stderr, "")
        else:
            self.assertIn(notes, done.stderr)
        self.text = (self.scratch / "page.html").read_text(encoding="utf-8")
        self.browser = Browser.open()
        self.browser.get((self.scratch / "page.html").as_uri())
        self.assertEqual(self.script("return document.body.dataset.ready"), "yes", self.browser.get_log("browser"))
        self.assertEqual(self.browser.get_log("browser"), [])

    def script(self, text, *values):
        return self.browser.execute_script(text, *values)

    def seen(self, section):
        return self.browser.find_element(By.ID, section).text

    def charts(self, section):
        """How many charts there are in a section whose canvas has been drawn on."""
        return self.script("""
            return [...document.querySelectorAll(`#${arguments[0]} .uplot canvas`)].filter((canvas) => {
              const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
              return pixels.some((value) => value > 0);
            }).length""", section)

    def picture(self, section):
        return self.script("return document.querySelector(`#${arguments[0]} canvas`).toDataURL()", section)

    def move_slider(self, share):
        self.script("""
            const slider = document.getElementById("frame");
            slider.value = Math.round(arguments[0] * slider.max);
            slider.dispatchEvent(new Event("input"))""", share)

    def assert_slider_moves(self, section):
        self.move_slider(0.0)
        first, told = self.picture(section), self.seen("motion-controls")
        self.move_slider(0.9)
        self.assertTrue(self.picture(section) != first, "the picture is the same")
        self.assertNotEqual(self.seen("motion-controls"), told)

    def assert_refused(self, expected, *words):
        done = report(*words, cwd=self.scratch)
        self.assertEqual((done.returncode, done.stdout, len(done.stderr.splitlines())), (2, "", 1), done.stderr)
        self.assertTrue(done.stderr.startswith("udar-report: "), done.stderr)
        self.assertIn(expected, done.stderr)


class OneRun(ReportTest):
    def test_a_falling_beam(self):
        folder = self.run_case(case(output_field_interval=0.005)).directory
        self.page_of(folder, words=("--title", NASTY))
        self.assertEqual(self.browser.find_element(By.TAG_NAME, "h1").text, NASTY)
        self.assertIn("wf = 100 rad/s lowers the first frequency, 57.", self.seen("verdict"))
        for text in ("Energy balance", "the line sinks", "Largest force, support 0, x = 2 m", "kN, mean over",
                     "MPa at x =", "-filter_frequency auto would keep it to 1 %"):
            self.assertIn(text, self.seen("verdict").replace("\u00a0", " "))
        self.assertRegex(self.seen("verdict"), r"Largest bending moment\s+[^\n]* m, t = \d")
        self.assertIn("-filter_frequency", [word.text for word in self.browser.find_elements(By.CLASS_NAME, "whole")])
        self.assertIn("10 m", self.browser.find_element(By.CSS_SELECTOR, "svg.sketch").text)
        self.assertIn("impacts", self.seen("contacts"))
        for section, least in (("contacts", 2), ("gauges", 5), ("envelopes", 4), ("energy", 2), ("spectra", 5),
                               ("motion", 1)):
            self.assertGreaterEqual(self.charts(section), least, section)
        self.assert_slider_moves("line-chart")
        self.browser.find_element(By.CSS_SELECTOR, "#gauge-charts .u-legend .u-series:nth-child(2)").click()
        shown = self.script("return charts.filter(([made]) => made.series.some((one) => !one.show)).length")
        self.assertEqual(shown, 1, "a click on a name hides its curve")
        told = self.script("""
            const made = charts.find(([made]) => made.tip)[0], { impacts } = report.runs[0].contact;
            const left = made.valToPos(impacts.t[0] / timeScale, "x"), top = made.valToPos(impacts.x[0], "y");
            made.setCursor({ left, top });
            return `${made.tip.style.display}: ${made.tip.textContent}`""")
        self.assertRegex(told, "^block: t = 0.45.* s, x = 2 m: 4.4.* m/s, 1.* kN s$")
        self.script("document.getElementById('view').value = 'deformation';"
                    "document.getElementById('view').dispatchEvent(new Event('change'))")
        self.assertEqual(self.browser.get_log("browser"), [])
        self.assertIn("deformation", self.script("return motion.views[0].chart.axes[1].label"))
        for word in ("http:", "https:"):  # links of the library's licence are no requests
            self.assertNotIn(f'src="{word}', self.text)
            self.assertNotIn(f'href="{word}', self.text)

    def test_its_curves_are_those_of_the_files(self):
        finished = self.run_case(case(ts_max_time=0.5))
        self.page_of(finished.directory)
        gauges, contact = finished.csv("gauges.csv"), finished.csv("contact.csv")
        drawn = self.script("return [report.gauges[2].curves[0].t, report.gauges[2].curves[0].line].map((a) => [...a])")
        np.testing.assert_allclose(drawn[0], gauges["time"])
        np.testing.assert_allclose(drawn[1], gauges["line_2"], rtol=1e-6, atol=1e-7)
        force = self.script("return [...report.runs[0].forces.curves[1].values]")
        np.testing.assert_allclose(force, contact["force_1"], rtol=1e-6)
        impacts = finished.csv("impacts.csv")
        speeds = self.script("return [...report.runs[0].contact.impacts.speed]")
        np.testing.assert_allclose(speeds, np.abs(impacts["velocity_before"]), rtol=1e-6)
        self.script("zoomTime(0.46, 0.48)")
        time.sleep(0.1)
        ranges = self.script("return timeCharts.map((made) => [made.scales.x.min, made.scales.x.max])")
        self.assertEqual({tuple(pair) for pair in ranges}, {(0.46, 0.48)})

    def test_the_estimate_of_a_run_by_modes(self):
        finished = self.run_case(case(contact_surface="line", filter_frequency=None, support_stiffness=1e7))
        self.page_of(finished.directory)
        summary = finished.summary()
        off = max(summary["modal_estimate"]["peak_support_force"]) / max(summary["peak_support_force"])
        said = re.search(r"off a run with (\d+) modes by: .*peak forces ([\d.e-]+) %",
                         self.seen("verdict").replace("\u00a0", " "))
        self.assertEqual(int(said[1]), summary["modal_estimate"]["modes"])
        self.assertAlmostEqual(float(said[2]) / (100.0 * off), 1.0, delta=0.05)  # two digits
        self.assertIn("none: the lowest modes move exactly", self.seen("verdict"))

    def test_without_gauges_supports_and_impacts(self):
        folder = self.run_case(case(gauge_position=None, support_position=None, ts_max_time=0.1)).directory
        self.page_of(folder)
        self.assertIn("This run has no gauges.", self.seen("gauges"))
        self.assertIn("This run has no supports.", self.seen("contacts"))
        self.assertGreaterEqual(self.charts("energy"), 2)

    def test_without_a_contact(self):
        folder = self.run_case(case(ts_max_time=0.2)).directory
        self.page_of(folder)
        self.assertIn("no contact", self.seen("contacts"))
        self.assertEqual(self.charts("contacts"), 2)

    def test_names_from_outside_are_text(self):
        finished = self.run_case(case(ts_max_time=0.1))
        summary = finished.file("summary.json")
        summary.write_text(summary.read_text().replace('"warnings": [', '"warnings": ["</script><b id=bad>x</b>; no",'))
        self.page_of(finished.directory)
        self.assertIn("</script><b id=bad>x</b>", self.seen("verdict"))
        self.assertEqual(self.browser.find_elements(By.ID, "bad"), [])

    def test_what_is_no_number_leaves_gaps(self):
        finished = self.run_case(case(ts_max_time=0.3))
        table = finished.file("gauges.csv")
        lines = table.read_text().splitlines()
        lines[5] = ",".join(["0.04", *(["nan"] * 7), "inf", *(["nan"] * 7)])
        table.write_text("\n".join(lines) + "\n")
        with h5py.File(finished.file("results.h5"), "a") as file:
            file["fields/line_position"][3] = np.nan
        self.page_of(finished.directory)
        self.assertEqual(self.charts("gauges"), 5)
        self.assert_slider_moves("line-chart")


class Decimation(ReportTest):
    """Long tables keep their peaks, and as many events as a screen has room for."""

    def test_no_peak_is_lost(self):
        finished = self.run_case(case(ts_max_time=0.1))
        rows, gauges = 200_000, 5
        table = np.zeros((rows, 1 + 3 * gauges))
        table[:, 0] = 1e-6 * np.arange(rows)
        table[123_456, 3] = 7.0   # line_0
        table[150_001, 13] = -3.0  # mass_4
        header = finished.file("gauges.csv").read_text().splitlines()[0]
        np.savetxt(finished.file("gauges.csv"), table, "%.9g", ",", header=header, comments="")
        with h5py.File(finished.file("results.h5"), "a") as file:
            impacts = np.zeros(300_000, file["impacts"].dtype)
            impacts["time"], impacts["x"] = np.linspace(0.0, 0.1, 300_000), 2.0
            impacts["velocity_before"], impacts["impulse"] = -1.0, 0.5
            impacts["velocity_before"][77_777] = -9.0
            del file["impacts"]
            file["impacts"] = impacts
        self.page_of(finished.directory)
        line, mass = self.script("return [report.gauges[0].curves[0].line, report.gauges[4].curves[0].mass]"
                                 ".map((values) => span([values]))")
        self.assertEqual((line[1], mass[0]), (7.0, -3.0))
        self.assertLess(self.script("return report.gauges[0].curves[0].t.length"), 30_000)
        marks = self.script("const { speed, count, impulse } = report.runs[0].contact.impacts;"
                            "const sum = (values) => values.reduce((a, b) => a + b, 0);"
                            "return [largest([speed]), sum(count), sum(impulse), count.length]")
        self.assertEqual(marks[:3], [9.0, 300_000.0, 150_000.0])
        self.assertLess(marks[3], 20_000)
        self.assertIn("300\u202f000 impacts, counted in cells of", self.seen("contacts"))
        self.assertIn("Of each 100 successive rows", self.seen("gauges"))
        self.assertNotIn("Shown:", self.seen("motion"))
        self.assertLess(len(self.text), 4_000_000)


class Rests(unittest.TestCase):
    """Rests are paired a block at a time as all at once."""

    def test_blocks_do_not_matter(self):
        random = np.random.default_rng(5)
        rows = []
        for node in range(30):
            times = np.sort(random.uniform(0.0, 1.0, random.integers(0, 9)))
            released = (np.arange(len(times)) + node % 2) % 2  # some rest from the start
            rows += [(at, node, 0.1 * node, 0, release) for at, release in zip(times, released)]
        kinds = [("time", "f8"), ("node", "i8"), ("x", "f8"), ("support", "i8"), ("release", "i8")]
        records = np.array(sorted(rows), dtype=kinds)
        grid = events.Grid.over(0.0, 1.0, np.linspace(0.0, 3.0, 31))
        found = []
        for block in (7, 1000):
            with unittest.mock.patch.object(events, "BLOCK", block):
                marks, supports = events.gather_rests(RecordTable(records), grid)
            found.append(sorted(zip(marks["x"], marks["t0"], marks["t1"])))
            self.assertEqual(list(supports), [0])
        self.assertEqual(*found)
        run = types.SimpleNamespace(rests=records, begin=0.0, end=1.0)
        self.assertEqual(found[0], sorted(zip(*rest_intervals(run))))
        with unittest.mock.patch.object(events, "MOST_MARKS", 10):
            cells, _ = events.gather_rests(RecordTable(records), grid)
        whole, of_cells = (sum(marks["t1"] - marks["t0"]) for marks in (marks, cells))
        self.assertLess(abs(of_cells - whole), 2 * len(records) / events.COLUMNS)


class Networks(ReportTest):
    def test_a_grillage_in_space(self):
        options = case(**{name: None for name in case() if name.startswith("beam_")}, **NETWORK,
                       gauge_position=None, gauge_junction="0 0 0,1 0 1", support_position="2,4",
                       contact_surface="line", initial_height=0.1, ts_max_time=0.3, output_field_interval=0.01)
        folder = self.run_case(options).directory
        self.page_of(folder)
        self.assertRegex(self.seen("verdict"), r"Largest torque\s+[^\n]* in member \d+, t = \d")
        self.assertIn("x: 6 m", self.browser.find_element(By.CSS_SELECTOR, "svg.sketch").text)
        self.assertEqual(self.charts("gauges"), 2)
        self.assertIn("member", self.seen("envelopes"))
        self.assert_slider_moves("space-view")
        before = self.picture("space-view")
        webdriver.ActionChains(self.browser).drag_and_drop_by_offset(
            self.browser.find_element(By.CSS_SELECTOR, "#space-view canvas"), 80, 30).perform()
        self.assertTrue(self.picture("space-view") != before, "not turned by the mouse")


class SeveralRuns(ReportTest):
    def test_are_laid_over_each_other(self):
        folders = [self.run_case(case(filter_frequency=wf, ts_max_time=0.5), name=f"wf{wf}").directory
                   for wf in (50, 100)]
        self.page_of(*folders)
        self.assertEqual(self.charts("gauges"), 5)
        labels = self.script("return charts.map(([made]) => made.series.map((series) => series.label).join())")
        for label in ("wf = 50 rad/s: line", "wf = 100 rad/s: line"):
            self.assertEqual(sum(label in words for words in labels), 6, labels)  # five gauges and the motion
        self.assertEqual(self.charts("contacts"), 4)
        self.browser.find_element(By.CSS_SELECTOR, "#case details summary").click()
        differ = [row.text for row in self.browser.find_elements(By.CSS_SELECTOR, "#case details[open] tr.differ")]
        self.assertEqual(differ[0], "filter_frequency 50 100")
        self.assert_slider_moves("line-chart")


class UnfinishedRuns(ReportTest):
    def test_a_killed_run_and_a_damaged_file(self):
        folder = self.scratch / "run"
        process = start(command(case(ts_max_time=500, output_interval=1e-3, output_directory=folder)))
        deadline = time.monotonic() + 20
        while not (folder / "gauges.csv").exists() or len((folder / "gauges.csv").read_bytes()) < 200_000:
            self.assertLess(time.monotonic(), deadline, "it does not get on")
            time.sleep(0.02)
        process.kill()
        process.communicate()
        self.page_of(folder, notes="there is no summary.json, so the run is still going on or was killed")
        self.assertIn("Doubtful", self.seen("verdict"))
        self.assertEqual(self.charts("gauges"), 5)
        (folder / "results.h5").write_bytes((folder / "results.h5").read_bytes()[:200])
        self.page_of(folder, notes="results.h5 cannot be read")
        self.assertIn("results.h5 cannot be read", self.seen("verdict"))
        self.assertEqual(self.charts("gauges"), 5)
        self.assertGreaterEqual(self.charts("energy"), 2)

    def test_what_is_no_run_is_refused(self):
        (self.scratch / "empty").mkdir()
        self.assert_refused("no such folder", self.scratch / "nowhere")
        self.assert_refused("not a run folder of udar", self.scratch / "empty")
        self.assert_refused("RUN")
        finished = run({**case(ts_max_time=0.01), "output_directory": self.scratch / "run"})
        self.assertEqual(finished.code, 0, finished)
        self.assert_refused("no gauge 7", self.scratch / "run", "--gauges", "7")
        self.assert_refused("'a' is not a list", self.scratch / "run", "--gauges", "a")


if __name__ == "__main__":
    unittest.main()
