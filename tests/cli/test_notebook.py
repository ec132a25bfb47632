#!/usr/bin/env python3
# ranks: 1; size: short
"""The notebook of examples/python runs from its first cell to its last, draws, and says what it should."""

import json
import os
import shutil
import unittest

import nbclient
import nbformat
import numpy as np

from common import ALONE, ENVIRONMENT, ROOT, UDAR, UdarTest

FOLDER = ROOT / "examples" / "python"
TOLD = "import json; print(json.dumps({name: list(table[name]) for name in ('initial_height', 'peak_force')}))"


class Notebook(UdarTest):
    def test_the_force_grows_with_the_root_of_the_height(self):
        notebook = nbformat.read(FOLDER / "drop_height.ipynb", as_version=4)
        nbformat.validate(notebook)
        self.assertEqual([cell.outputs for cell in notebook.cells if cell.cell_type == "code" and cell.outputs], [])
        shutil.copytree(ROOT / "examples" / "01-falling-beam", self.scratch / "01-falling-beam")
        (self.scratch / "python").mkdir()
        notebook.cells.append(nbformat.v4.new_code_cell(TOLD))
        os.environ.update({**ENVIRONMENT, **ALONE, "UDAR": UDAR, "PYTHONPATH": str(ROOT / "scripts" / "python"),
                           "IPYTHONDIR": str(self.scratch), "PYDEVD_DISABLE_FILE_VALIDATION": "1",
                           "JUPYTER_RUNTIME_DIR": str(self.scratch)})
        nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3",
                                resources={"metadata": {"path": str(self.scratch / "python")}}).execute()
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
        pictures = [output for output in outputs if "image/png" in output.get("data", ())]
        self.assertEqual(len(pictures), 3)
        self.assertEqual([output.text for output in outputs if output.get("name") == "stderr"], [])
        told = json.loads(outputs[-1].text)
        force = np.array(told["peak_force"])
        self.assertGreater(force.min(), 2466 * 9.81)
        # A blow goes with the speed at impact; the weight, put on two supports at once, adds 24 kN at most.
        blow = force[-1] * np.sqrt(np.array(told["initial_height"]) / 2.0)
        np.testing.assert_allclose(force, blow, rtol=0, atol=2466 * 9.81)


if __name__ == "__main__":
    unittest.main()
