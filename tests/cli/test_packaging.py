#!/usr/bin/env python3
# ranks: 1; size: short
"""Recipes of packages: one version everywhere, and files that their tools can read. None is built here."""

import re
import unittest

import jinja2
import yaml

from common import ROOT

PACKAGING = ROOT / "packaging"
VERSION = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE).group(1)
# Sections of a recipe, as conda-build's "Defining metadata" has them.
SECTIONS = {
    "package": {"name", "version"},
    "source": {"path"},
    "build": {"number", "skip"},
    "requirements": {"build", "host", "run"},
    "test": {"imports", "commands"},
    "about": {"summary", "license", "license_family", "license_file"},
}


class Recipes(unittest.TestCase):
    def test_debian_has_this_version(self):
        line = (PACKAGING / "debian" / "changelog").read_text(encoding="utf-8").splitlines()[0]
        self.assertRegex(line, rf"^udar \({re.escape(VERSION)}-\d+\) ")

    def test_debian_names_the_library_by_its_soname(self):
        minor = VERSION.rpartition(".")[0]
        self.assertIn(f"Package: libudar{minor}\n", (PACKAGING / "debian" / "control").read_text(encoding="utf-8"))
        self.assertTrue((PACKAGING / "debian" / f"libudar{minor}.install").exists())

    def test_spack(self):
        folder = PACKAGING / "spack" / "spack_repo" / "udar"
        path = folder / "packages" / "udar" / "package.py"
        text = path.read_text(encoding="utf-8")
        compile(text, path, "exec")
        self.assertIn(f'version("{VERSION}", tag="v{VERSION}")', text)
        repository = yaml.safe_load((folder / "repo.yaml").read_text(encoding="utf-8"))
        self.assertEqual(repository, {"repo": {"namespace": "udar", "api": "v2.0"}})

    def test_conda(self):
        folder = PACKAGING / "conda"
        template = jinja2.Environment(undefined=jinja2.StrictUndefined).from_string(
            (folder / "meta.yaml").read_text(encoding="utf-8"))
        recipe = yaml.safe_load(template.render(compiler=lambda language: f"{language}_linux-64",
                                                stdlib=lambda language: f"sysroot_{language}"))
        self.assertEqual({section: set(keys) for section, keys in recipe.items()}, SECTIONS)
        self.assertEqual(recipe["package"], {"name": "udar", "version": VERSION})
        self.assertTrue((folder / recipe["source"]["path"] / "CMakeLists.txt").exists())
        for license_file in recipe["about"]["license_file"]:
            self.assertTrue((ROOT / license_file).exists(), license_file)


if __name__ == "__main__":
    unittest.main()
