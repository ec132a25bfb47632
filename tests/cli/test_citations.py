#!/usr/bin/env python3
# ranks: 1 2; size: short
"""PETSc's -citations prints what CITATION.cff says of udar, and of the filter method where a filter works."""

import os
import pathlib
import re
import subprocess
import unittest

from common import ENVIRONMENT, MPIEXEC, ROOT, UDAR, UdarTest, case

RANKS = int(os.environ["UDAR_RANKS"])
CITATION = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
TITLE, METHOD = re.findall(r'^ *(?:- type: generic\n +)?title: "?(.*?)"?$', CITATION, re.MULTILINE)
VERSION = re.search(r"^version: (.*)$", CITATION, re.MULTILINE).group(1)


class Citations(UdarTest):
    def cited(self, text):
        """Titles by key, each cited once."""
        entries = re.findall(r"@Misc\{(udar[-\w]*),\n  author = \{(.*)\},\n  title  = \{\{(.*)\}\},\n", text)
        self.assertEqual(len(entries), len({key for key, *_ in entries}), text)
        return {key: title for key, _, title in entries}

    def test_a_filtered_run(self):
        out = self.run_case(case(ts_max_time=0.01, citations=True), RANKS).out
        self.assertEqual(self.cited(out), {"udar": TITLE, "udar-filter-method": METHOD})
        self.assertIn("author = {{udar developers}},", out)
        self.assertIn("author = {Nikitenko, V. I.},", out)
        self.assertIn(f"note   = {{version {VERSION}}},", out)
        self.assertIn("petsc", out.lower())
        self.assertNotIn("read by nobody", out)

    def test_what_is_not_used_is_not_cited(self):
        for name, changes in (("modes", {"filter_frequency": None, "contact_surface": "line"}),
                              ("lumped", {"filter_frequency": "none", "ts_type": "moreau", "ts_dt": 1e-4})):
            with self.subTest(name=name):
                out = self.run_case(case(ts_max_time=0.01, citations=True, **changes), RANKS, name).out
                self.assertEqual(self.cited(out), {"udar": TITLE})

    def test_nothing_without_the_option(self):
        self.assertEqual(self.cited(self.run_case(case(ts_max_time=0.01), RANKS).out), {})

    def test_a_study_cites_once(self):
        file = self.scratch / "cite.bib"
        study = pathlib.Path(UDAR).with_name("udar-study")
        options = {**case(ts_max_time=0.01, filter_frequency="50,100"), "output_directory": self.scratch / "study"}
        words = [word for key, value in options.items() for word in (f"-{key}", str(value))]
        call = [*([MPIEXEC, "-n", str(RANKS)] if RANKS > 1 else []), str(study), *words, "-citations"]
        done = subprocess.run([*call], capture_output=True, text=True, env=ENVIRONMENT, timeout=60, check=True)
        self.assertEqual(self.cited(done.stdout), {"udar": TITLE, "udar-filter-method": METHOD})
        call += [str(file), "-output_overwrite"]
        subprocess.run(call, capture_output=True, text=True, env=ENVIRONMENT, timeout=60, check=True)
        self.assertEqual(len(self.cited(file.read_text())), 2)


if __name__ == "__main__":
    unittest.main()
