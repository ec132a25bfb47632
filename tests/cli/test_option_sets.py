#!/usr/bin/env python3
# ranks: 1; size: long
"""Every file in petsc-options runs and agrees with the default; docs/options.md is what -help says."""

import subprocess
import unittest

from common import ENVIRONMENT, ROOT, UdarTest, case, command


class OptionSets(UdarTest):
    def test_each_set_runs_and_agrees(self):
        options = case(ts_max_time=0.47, ts_rtol=1e-11)
        reference = self.run_case(options, name="default")
        sets = sorted((ROOT / "petsc-options").glob("*.opts"))
        self.assertGreaterEqual(len(sets), 5)
        for file in sets:
            for ranks in (1, 2):
                if file.stem == "block-lu" and ranks > 1:
                    continue  # of one rank only
                with self.subTest(set=file.stem, ranks=ranks):
                    run = self.run_case(options, ranks, f"{file.stem}-{ranks}", extra=["-options_file", str(file)])
                    # 1e-8: ten times the true error of the default at this tolerance, over one impact.
                    self.assert_same_curves(reference, run, **{"m": 1e-8, "m/s": 1e-8})


class OptionManual(UdarTest):
    def test_page_is_what_the_program_says(self):
        help_text = subprocess.run(
            command({"help": True}), capture_output=True, text=True, env=ENVIRONMENT, timeout=60, check=True
        ).stdout
        page = subprocess.run(
            [str(ROOT / "scripts" / "options-page")], input=help_text, capture_output=True, text=True, check=True
        ).stdout
        self.assertIn("-filter_frequency", page)
        self.assertEqual(
            page,
            (ROOT / "docs" / "options.md").read_text(),
            "run: build/udar -help | scripts/options-page > docs/options.md"
        )


if __name__ == "__main__":
    unittest.main()
