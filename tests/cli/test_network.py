#!/usr/bin/env python3
# ranks: 1; size: medium
"""Networks through the program: from YAML, from Gmsh meshes, made regular; what is wrong in them, and how they run."""

import re
import struct
import textwrap
import unittest

import h5py
import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, datasets, run

# A portal of two posts and a beam whose middle carries a mass, and a strut that is hinged at one end.
FRAME = """\
sections:
  - {name: post, shape: tube, radius: 0.1, inner_radius: 0.09}
  - {name: beam, shape: rectangle, width: 0.1, height: 0.2, young_modulus: 7e10, density: 2700, poisson_ratio: 0.33}
junctions:
  - {name: left foot, place: [0, 0, 0]}
  - {name: right foot, place: [4, 0, 0]}
  - {name: left knee, place: [0, 3, 0]}
  - {name: right knee, place: [4, 3, 0]}
  - {name: middle, place: [2, 3, 0], mass: 50}
members:
  - {name: left post, from: left foot, to: left knee}
  - {name: right post, from: right foot, to: right knee}
  - {name: left beam, from: left knee, to: middle}
  - {name: right beam, from: middle, to: right knee}
groups:
  - {name: feet, junctions: [left foot, right foot], held: pinned}
  - {name: posts, members: [left post, right post], section: post, elements: 6, orientation: [0, 0, 1]}
  - {name: beams, members: [left beam, right beam], section: beam, element_length: 0.5}
"""
# What the physical groups of its mesh mean.
GROUPS = """\
sections:
  - {name: post, shape: tube, radius: 0.1, inner_radius: 0.09}
  - {name: beam, shape: rectangle, width: 0.1, height: 0.2, young_modulus: 7e10, density: 2700, poisson_ratio: 0.33}
groups:
  - {name: feet, held: pinned}
  - {name: middle, mass: 50}
  - {name: posts, section: post, orientation: [0, 0, 1]}
  - {name: beams, section: beam}
"""
STEPS = 12  # of the fall in `Output`, some of them after the landing
RUN = {"structure_type": "network", "filter_frequency": 200, "ts_max_time": 0.02, "output_interval": 0.002,
       "gravity": 9.81, "initial_height": 0, "support_position": 2, "support_height": 2.99}
PAIR = {"network_grillage": "3,3", "support_height": -1, "pair_from_junction": "1 0 1", "pair_to_junction": "1 0 2",
        "pair_normal": "0,0,1"}


class Mesh:
    """Lines in space as Gmsh writes them: groups by dimension and number, entities numbered apart from these."""

    names = {(0, 1): "feet", (0, 2): "middle", (1, 1): "posts", (1, 2): "beams"}

    def __init__(self, grading=1.0):
        """Elements grow so many times along each curve."""
        corners = {1: (0, 0, 0), 2: (4, 0, 0), 3: (0, 3, 0), 4: (4, 3, 0), 5: (2, 3, 0)}
        curves = {1: (1, 3, 6, 1), 2: (2, 4, 6, 1), 3: (3, 5, 4, 2), 4: (5, 4, 4, 2)}  # from, to, elements, group
        self.corner_group = {1: 1, 2: 1, 3: 0, 4: 0, 5: 2}
        self.nodes = dict(corners)
        self.lines = []  # curve, group, from, to
        self.inner = {}
        for curve, (begin, end, elements, group) in curves.items():
            chain = [begin]
            sizes = grading ** (np.arange(elements) / (elements - 1))
            for at in (np.cumsum(sizes) / sizes.sum())[:-1]:
                self.nodes[len(self.nodes) + 1] = tuple(
                    a + (b - a) * float(at) for a, b in zip(corners[begin], corners[end]))
                chain.append(len(self.nodes))
            self.inner[curve] = chain[1:]
            chain.append(end)
            self.lines += [(curve, group, a, b) for a, b in zip(chain, chain[1:])]
        self.curve_group = {curve: value[3] for curve, value in curves.items()}
        self.ends = {curve: value[:2] for curve, value in curves.items()}

    def head(self, version, binary=False):
        rows = [f"{dim} {tag} \"{name}\"" for (dim, tag), name in self.names.items()]
        head = f"$MeshFormat\n{version} {int(binary)} 8\n".encode()
        head += struct.pack("<i", 1) + b"\n" if binary else b""
        return head + ("$EndMeshFormat\n$PhysicalNames\n" + "\n".join([str(len(rows)), *rows])
                       + "\n$EndPhysicalNames\n").encode()

    def point_elements(self):
        return [(corner, group) for corner, group in self.corner_group.items() if group]

    def version_2(self):
        nodes = [f"{tag} {x!r} {y!r} {z!r}" for tag, (x, y, z) in self.nodes.items()]
        elements = [f"15 2 {group} {corner} {corner}" for corner, group in self.point_elements()]
        elements += [f"1 2 {group} {curve} {a} {b}" for curve, group, a, b in self.lines]
        numbered = [f"{i} {element}" for i, element in enumerate(elements, 1)]
        return self.head(2.2) + "\n".join(
            ["$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements", str(len(numbered)), *numbered,
             "$EndElements", ""]).encode()

    def blocks(self):
        """Nodes and elements by entity: (dimension, entity, tags) and (dimension, entity, type, rows)."""
        nodes = [(0, corner, [corner]) for corner in self.corner_group]
        nodes += [(1, curve, inner) for curve, inner in self.inner.items()]
        elements = [(0, corner, 15, [(corner,)]) for corner, _ in self.point_elements()]
        elements += [(1, curve, 1, [(a, b) for of, _, a, b in self.lines if of == curve]) for curve in self.ends]
        return nodes, elements

    def version_4(self):
        nodes, elements = self.blocks()
        text = ["$Entities", f"{len(self.corner_group)} {len(self.ends)} 0 0"]
        for corner, group in self.corner_group.items():
            x, y, z = self.nodes[corner]
            text.append(f"{corner} {x!r} {y!r} {z!r} " + (f"1 {group}" if group else "0"))
        for curve, (a, b) in self.ends.items():
            low, high = (np.array([self.nodes[a], self.nodes[b]], float).__getattribute__(f)(axis=0) for f in
                         ("min", "max"))
            box = " ".join(repr(float(value)) for value in [*low, *high])
            text.append(f"{curve} {box} 1 {self.curve_group[curve]} 2 {a} {-b}")
        text += ["$EndEntities", "$Nodes", f"{len(nodes)} {len(self.nodes)} 1 {len(self.nodes)}"]
        for dim, entity, tags in nodes:
            text += [f"{dim} {entity} 0 {len(tags)}", *map(str, tags)]
            text += [" ".join(repr(value) for value in self.nodes[tag]) for tag in tags]
        count = sum(len(rows) for *_, rows in elements)
        text += ["$EndNodes", "$Elements", f"{len(elements)} {count} 1 {count}"]
        number = 0
        for dim, entity, kind, rows in elements:
            text.append(f"{dim} {entity} {kind} {len(rows)}")
            for row in rows:
                number += 1
                text.append(" ".join(map(str, (number, *row))))
        return self.head(4.1) + "\n".join([*text, "$EndElements", ""]).encode()

    def version_4_binary(self):
        nodes, elements = self.blocks()
        data = self.head(4.1, True) + b"$Entities\n" + struct.pack("<4q", len(self.corner_group), len(self.ends), 0, 0)
        for corner, group in self.corner_group.items():
            data += struct.pack("<i3d", corner, *self.nodes[corner])
            data += struct.pack("<qi", 1, group) if group else struct.pack("<q", 0)
        for curve, (a, b) in self.ends.items():
            pair = np.array([self.nodes[a], self.nodes[b]], float)
            data += struct.pack("<i6d", curve, *pair.min(axis=0), *pair.max(axis=0))
            data += struct.pack("<qiq2i", 1, self.curve_group[curve], 2, a, -b)
        data += b"\n$EndEntities\n$Nodes\n" + struct.pack("<4q", len(nodes), len(self.nodes), 1, len(self.nodes))
        for dim, entity, tags in nodes:
            data += struct.pack("<3iq", dim, entity, 0, len(tags)) + struct.pack(f"<{len(tags)}q", *tags)
            for tag in tags:
                data += struct.pack("<3d", *self.nodes[tag])
        count = sum(len(rows) for *_, rows in elements)
        data += b"\n$EndNodes\n$Elements\n" + struct.pack("<4q", len(elements), count, 1, count)
        number = 0
        for dim, entity, kind, rows in elements:
            data += struct.pack("<3iq", dim, entity, kind, len(rows))
            for row in rows:
                number += 1
                data += struct.pack(f"<{1 + len(row)}q", number, *row)
        return data + b"\n$EndElements\n"


class NetworkTest(UdarTest):
    def write(self, name, text):
        path = self.scratch / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def refused(self, *words, ranks=(0, 2), **options):
        for count in ranks:
            failed = run({"output_directory": self.scratch / "run", **RUN, **options}, count)
            self.assertEqual(failed.code, 1, failed)
            self.assertEqual(len(failed.errors), 1, failed)
            for word in words:
                self.assertIn(word, failed.errors[0])
        return failed.errors[0]


class Sources(NetworkTest):
    """The same network from everywhere."""

    def view(self, name, **options):
        shown = self.run_case({**RUN, "udar_view": True, **options}, name=name)
        return shown

    def test_meshes_give_the_network_of_the_yaml(self):
        mesh = Mesh()
        groups = self.write("groups.yaml", GROUPS)
        frame = self.view("yaml", network_file=self.write("frame.yaml", FRAME))
        self.assertIn("5 4 20", re.search(r"junctions, members, elements.*", frame.out).group())
        expected = self.modes(frame)
        self.assertGreater(len(expected), 5)
        for name, data in (("two", mesh.version_2()), ("four", mesh.version_4()), ("bytes", mesh.version_4_binary())):
            found = self.view(name, network_file=self.write(f"{name}.msh", data), network_groups=groups)
            self.assertEqual(self.described(found), self.described(frame), name)
            np.testing.assert_allclose(self.modes(found), expected, rtol=1e-4, err_msg=name)
        named = self.write("mesh.yaml", "mesh: two.msh\n" + GROUPS)  # beside this file
        self.assertEqual(self.described(self.view("named", network_file=named)), self.described(frame))

    def test_graded_elements_are_the_same_from_everywhere(self):
        graded = (FRAME.replace("elements: 6", "elements: 6, grading: 4")
                  .replace("element_length: 0.5", "elements: 4, grading: 4"))
        sizes = 4 ** (np.arange(4) / 3)
        listed = ", ".join(f"{size:.9g}" for size in 2 * sizes / sizes.sum())
        equal = self.view("equal", network_file=self.write("equal.yaml", FRAME))
        frame = self.view("graded", network_file=self.write("graded.yaml", graded))
        described = re.compile(r"(members of unequal elements|shortest element \[m\]) +(\S+)")
        self.assertEqual(dict(described.findall(equal.out)), {
            "members of unequal elements": "0", "shortest element [m]": "0.5"})
        found = dict(described.findall(frame.out))
        self.assertEqual(found["members of unequal elements"], "4")
        sizes = 4 ** (np.arange(6) / 5)
        self.assertAlmostEqual(float(found["shortest element [m]"]), min(2 / np.sum(4 ** (np.arange(4) / 3)),
                                                                         3 / sizes.sum()), delta=1e-4)
        lists = graded.replace("section: beam, elements: 4, grading: 4", f"section: beam, element_lengths: [{listed}]")
        self.assertIn("element_lengths", lists)
        groups = self.write("groups.yaml", GROUPS)
        mesh = Mesh(grading=4)
        for name, options in (
            ("lists", {"network_file": self.write("lists.yaml", lists)}),
            ("two", {"network_file": self.write("two.msh", mesh.version_2()), "network_groups": groups}),
            ("bytes", {"network_file": self.write("bytes.msh", mesh.version_4_binary()), "network_groups": groups}),
        ):
            other = self.view(name, **options)
            self.assertEqual(self.described(other), self.described(frame), name)
            self.assertEqual(dict(described.findall(other.out)), found, name)
            np.testing.assert_allclose(self.modes(other), self.modes(frame), rtol=1e-6, err_msg=name)
        self.assertGreater(np.abs(self.modes(equal) / self.modes(frame) - 1).max(), 1e-3)

    @staticmethod
    def modes(shown):
        rows = re.findall(r"^ +\d+ +([0-9.]+) ", shown.out, re.MULTILINE)
        return np.array(rows, float)

    def test_equal_elements_of_two_lengths_are_two_members(self):
        """Along one line: 4 equal ones, 3 equal ones of half the length, then graded ones, then a named point."""
        sizes = [1.0] * 4 + [0.5] * 3 + [0.6, 0.8, 1.1]
        places = np.concatenate([[0.0], np.cumsum(sizes)])
        nodes = [f"{i} {x!r} 0 0" for i, x in enumerate(map(float, places), 1)]
        lines = [f"{i} 1 2 1 1 {i} {i + 1}" for i in range(1, len(nodes))]
        mesh = "\n".join(["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", '1 1 "beams"',
                          "$EndPhysicalNames", "$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements",
                          str(len(lines)), *lines, "$EndElements", ""])
        groups = self.write("groups.yaml", GROUPS.split("groups:")[0] + "groups:\n  - {name: beams, section: beam}\n")
        shown = self.view("line", network_file=self.write("line.msh", mesh), network_groups=groups,
                          support_height=-1)
        # The last of the equal ones meets a longer one: no row of equal ones begins there.
        self.assertIn("3 2 10", re.search(r"junctions, members, elements.*", shown.out).group())
        self.assertEqual(re.search(r"members of unequal elements +(\S+)", shown.out).group(1), "1")

    def test_graded_elements_keep_energy_and_answer_alike_on_two_ranks(self):
        text = FRAME.replace(", held: pinned", ", mass: 1").replace("elements: 6", "elements: 6, grading: 0.25")
        path = self.write("frame.yaml", text.replace("element_length: 0.5", "element_lengths: [0.2, 0.5, 0.9, 0.4]"))
        options = {**RUN, "network_file": path, "support_position": None, "support_height": None, "floor": True,
                   "initial_height": 0.001, "initial_slope": 0.0002, "ts_max_time": 0.03, "ts_type": "rk",
                   "ts_rtol": 1e-11, "gauge_junction": "left knee"}
        alone, dealt = (self.run_case(options, ranks, name=f"np{ranks}") for ranks in (1, 2))
        self.assertGreater(alone.summary()["impacts"], 0)
        energy = alone.csv("energy.csv")
        self.assertGreater(np.abs(energy["line_strain"]).max(), 1e-3 * np.abs(energy["kinetic"]).max())
        self.assertLess(np.abs(energy["drift"]).max(), 1e-9)
        one, two = (of.csv("gauges.csv") for of in (alone, dealt))
        for column in ("mass_0", "line_0", "velocity_0"):
            self.assertLess(np.abs(one[column] - two[column]).max(), 1e-9, column)

    @staticmethod
    def described(shown):
        """What does not depend on the order of junctions and members."""
        return {line.strip() for line in shown.out.splitlines()
                if re.match(r" +(mass|extent|junctions, members|nodes|length) ?", line)}

    def test_a_run_is_the_same_on_two_ranks(self):
        options = {**RUN, "network_grillage": "3,3", "network_elements": 4, "support_position": "0,2",
                   "support_height": -1e-3, "ts_max_time": 0.016, "output_field_interval": 0,
                   "gauge_junction": "1 0 1,0 0 2", "gauge_place": "1.9,0,0.1"}
        one, two = (self.run_case(options, ranks, name=f"np{ranks}").csv("gauges.csv") for ranks in (1, 2))
        for column in ("mass_0", "line_1", "velocity_2"):
            # Sums of some hundred terms in another order; they meet at 14 ms.
            self.assertLess(np.abs(one[column] - two[column]).max(), 1e-10, column)
        self.assertGreater(np.ptp(one["mass_0"]), 5e-4, "it falls")

    def test_a_run_is_the_same_in_registers_of_any_width(self):
        """As far as the processor has them; partial packs, twist, and masses of a beam that meet a floor."""
        net = {**RUN, "network_grillage": "3,4", "network_elements": 5, "rotary_inertia": True,
               "support_position": "0,2", "support_height": -1e-3, "ts_max_time": 0.016,
               "gauge_junction": "1 0 1,0 0 2"}
        beam = {"beam_length": 10, "beam_elements": 50, "beam_radius": 0.1, "initial_height": 1e-3, "floor": True,
                "initial_slope": 1e-4, "filter_frequency": 200, "ts_max_time": 0.04, "output_interval": 0.004,
                "ts_type": "impact", "contact_restitution": 0.5, "gauge_position": "1.1,7"}
        for name, options in (("net", net), ("beam", beam)):
            narrow, *wider = (
                self.run_case(options, name=f"{name}{lanes}", environment=[("UDAR_LANES", lanes)]).csv("gauges.csv")
                for lanes in ("2", "4", "8"))
            self.assertGreater(np.ptp(narrow["velocity_1"]), 0.01, name)  # they meet
            for other in wider:
                for column, values in narrow.items():
                    self.assertLess(np.abs(values - other[column]).max(), 1e-9 * np.abs(values).max(), column)

    def test_a_lattice_is_what_its_numbers_say(self):
        options = {**RUN, "network_lattice": "3,2,4", "network_spacing": "1,2,0.5", "network_elements": 2,
                   "network_section": "rectangle", "network_section_width": 0.1, "network_section_height": 0.2,
                   "network_density": 1000, "support_height": None, "support_position": None}
        shown = self.run_case({**options, "udar_view": True}, name="lattice")
        along = (2 * 2 * 4, 3 * 1 * 4, 3 * 2 * 3)  # members along x, y, z
        members = sum(along)
        mass = 1000 * 0.02 * np.dot(along, (1, 2, 0.5))
        self.assertIn(f"24 {members} {2 * members}", shown.out)
        self.assertIn(f"{mass:g}", re.search(r"mass \[kg\].*", shown.out).group())
        self.assertIn("x 0 to 2 m, y 0 to 2 m, z 0 to 1.5 m", shown.out)


class Refusals(NetworkTest):
    """Every mistake names file, line, column and what is wrong."""

    def wrong(self, before, after, *words):
        """The frame with one change."""
        self.assertEqual(FRAME.count(before), 1, before)
        text = FRAME.replace(before, after)
        path = self.write("frame.yaml", text)
        self.refused("-network_file", str(path), *words, ranks=(0,), network_file=path)

    def test_of_the_yaml(self):
        for before, after, words in (
            ("name: middle, place", "name: middle, plaec", ["line 9 column", "'middle'", "place"]),
            ("mass: 50", "mas: 50", ["line 9 column 38", "'middle'", "unknown key 'mas'", "mass"]),
            ("[2, 3, 0]", "[2, 3]", ["line 9 column 27", "place", "a list of 3 numbers", "[m]"]),
            ("[2, 3, 0]", "[2, x, 0]", ["line 9 column 31", "place", "'x'", "[m]"]),
            ("mass: 50", "mass: -50", ["line 9 column 44", "mass", "'-50'", ">= 0", "[kg]"]),
            ("name: middle, place", "name: left knee, place", ["line 9 column 12", "another junction of this name"]),
            ("to: middle}", "to: midle}", ["line 13 column", "unknown junction 'midle'", "middle"]),
            ("from: middle, to: right knee", "from: middle, to: middle", ["line 14 column", "to itself"]),
            ("section: beam, element", "section: baem, element", ["line 18 column", "unknown section 'baem'", "beam"]),
            ("[left beam, right beam]", "[left beam, beam]", ["line 18 column", "unknown member 'beam'"]),
            (", element_length: 0.5", "", ["line 13 column", "'left beam'", "elements", "element_length"]),
            ("element_length: 0.5", "elements: 0", ["line 18 column", "elements", "'0'", ">= 1"]),
            ("element_length: 0.5", "elements: 2000000000", ["line 18 column", "elements", "1e9"]),
            ("element_length: 0.5", "elements: 300000000, grading: 2", ["GB of memory", "-structure_memory"]),
            ("element_length: 0.5", "element_length: 0.5, elements: 3", ["line 18", "expected one of them"]),
            ("element_length: 0.5", "element_lengths: 0.5", ["line 18", "element_lengths", "a list of numbers", "[m]"]),
            ("element_length: 0.5", "element_lengths: []", ["line 18", "element_lengths", "a list of numbers"]),
            ("element_length: 0.5", "element_lengths: [1, -1]", ["line 18", "element_lengths", "'-1'", "> 0", "[m]"]),
            ("element_length: 0.5", "element_lengths: [1, 0.9]", ["line 18", "'left beam'", "sum of 1.9 m", "of 2 m"]),
            ("element_length: 0.5", "elements: 2, element_lengths: [1, 1]", ["line 18", "expected one of them"]),
            ("element_length: 0.5", "element_length: 0.5, grading: 2", ["line 18", "grading needs elements"]),
            ("element_length: 0.5", "elements: 1, grading: 2", ["line 18", "grading needs elements", ">= 2"]),
            ("element_length: 0.5", "elements: 3, grading: 0", ["line 18", "grading", "'0'", "> 0"]),
            ("held: pinned", "held: [ux, tx]", ["line 16 column", "held", "'tx'", "clamped"]),
            ("held: pinned", "held: pinned, mass: 1, mass: 2", ["line 16 column", "'mass' again"]),
            ("inner_radius: 0.09", "inner_radius: 0.11", ["line 2 column", "inner_radius", "smaller"]),
            ("shape: tube, ", "shape: pipe, ", ["line 2 column", "'pipe'", "circle, tube or rectangle"]),
            ("width: 0.1, ", "", ["line 3 column 5", "'beam'", "width [m]"]),
            ("[0, 0, 1]}", "[0, 0, 0]}", ["line 17 column", "orientation", "length 0"]),
            ("groups:", "groups: ]", ["line 15 column", "YAML"]),
            ("members:\n", "members: 3\nothers:\n", ["line 10 column", "members", "'3'", "a list of maps"]),
            ("element_length: 0.5", "element_length: 0.5, hinge_to: [y, w]", ["line 18 column", "hinge_to", "'w'"]),
            ("element_length: 0.5", "element_length: 0.5, hinge_to: [y], joint_to: [0, 1, 2]",
             ["line 18 column", "hinge_to: 'y'", "joint_to", "expected 0"]),
        ):
            with self.subTest(after=after):
                self.wrong(before, after, *words)
        for before, after, words in (
            ("place: [2, 3, 0]", "place: [0, 3, 0]", ["left beam", "length", "> 0"]),
            ("place: [2, 3, 0]", "place: [4, 0, 0]", ["right foot", "middle", "both at (4, 0, 0)"]),
            ("[0, 0, 1]}", "[0, 1, 0]}", ["left post", "orientation"]),
        ):
            with self.subTest(after=after):
                self.refused(*words, network_file=self.write("frame.yaml", FRAME.replace(before, after)))
        twice = FRAME + "  - {name: more, junctions: [left foot], held: clamped}\n"
        path = self.write("frame.yaml", twice)
        self.refused("line 19 column", "line 16", "another group", network_file=path)
        self.refused("missing.yaml", "No such file", network_file=self.scratch / "missing.yaml")

    def mesh_refused(self, data, *words, groups=GROUPS, ranks=(0,)):
        mesh = self.write("frame.msh", data)
        return self.refused(*words, ranks=ranks, network_file=mesh, network_groups=self.write("groups.yaml", groups))

    def test_of_a_mesh(self):
        two = Mesh().version_2().decode()
        four = Mesh().version_4().decode()
        self.mesh_refused(two, "'feet'", "no group of this name",
                          groups=GROUPS.replace("  - {name: feet, held: pinned}\n", ""))
        self.mesh_refused(two, "line 6 column 12", "'mid'", "no physical group", "posts, beams, feet, middle",
                          groups=GROUPS.replace("name: middle, mass", "name: mid, mass"))
        self.mesh_refused(two, "line 7 column 34", "unknown key 'elements'",
                          groups=GROUPS.replace("section: post, orient", "section: post, elements: 3, orient"))
        self.mesh_refused(two.replace('1 2 "beams"', '1 9 "beams"'), "(0, 3, 0) m", "no physical group with a name")
        doubled = two.replace("\n5 2 3 0\n", "\n5 0 3 0\n")
        self.mesh_refused(doubled, "two nodes at (0, 3, 0) m", "frame.msh", ranks=(0, 2))
        last = two[:two.index("$EndElements")].splitlines()[-1].split()
        again = two.replace("$EndElements", " ".join([str(int(last[0]) + 1), *last[1:]]) + "\n$EndElements")
        count = int(last[0])
        self.mesh_refused(again.replace(f"$Elements\n{count}\n", f"$Elements\n{count + 1}\n"), "two lines from")
        self.mesh_refused(four.replace(" 1 1 2 1 -3\n", " 2 1 2 2 1 -3\n"), "2 physical groups", "line from (0, 0, 0)")
        self.mesh_refused(two.replace(" 1 2 1 1 1 6\n", " 1 2 1 1 1 99\n"), "frame.msh", "node 99")
        self.mesh_refused(re.sub(r"\n4 4 3 0\n", "\n5 4 3 0\n", two), "node 5 is given twice")
        self.mesh_refused("no mesh at all\n", "frame.msh", "Gmsh", ranks=(0, 2))
        self.mesh_refused(two[: len(two) // 2], "frame.msh", "Gmsh")
        triangle = textwrap.dedent("""\
            $MeshFormat
            2.2 0 8
            $EndMeshFormat
            $Nodes
            3
            1 0 0 0
            2 1 0 0
            3 0 1 0
            $EndNodes
            $Elements
            1
            1 2 2 1 1 1 2 3
            $EndElements
            """)
        self.mesh_refused(triangle, "dimension 2", "lines")
        more = f"$Elements\n{count + 1}\n"
        surface = again.replace(f"$Elements\n{count}\n", more).replace(
            "\n" + " ".join([str(int(last[0]) + 1), *last[1:]]), f"\n{count + 1} 2 2 1 1 1 2 3")
        self.mesh_refused(surface, "dimension 2", "lines", "save these alone")
        curved = again.replace(f"$Elements\n{count}\n", more).replace(
            "\n" + " ".join([str(int(last[0]) + 1), *last[1:]]), f"\n{count + 1} 8 2 1 1 1 2 3")
        self.mesh_refused(curved, "higher order", "two nodes each")

    def test_of_options(self):
        path = self.write("frame.yaml", FRAME)
        mesh = self.write("frame.msh", Mesh().version_2())
        for words, options in (
            (["-structure_type", "-network_file", "0 given"], {}),
            (["-structure_type", "2 given"], {"network_file": path, "network_grillage": "3,3"}),
            (["-network_file", "-network_groups"], {"network_file": path, "network_elements": 3}),
            (["-network_file", "-network_groups"], {"network_file": path, "network_grading": 2}),
            (["-network_grading", "0", "> 0"], {"network_grillage": "3,3", "network_grading": 0}),
            (["-network_groups", "frame.msh"], {"network_file": mesh}),
            (["-network_groups", ".msh"], {"network_file": path, "network_groups": path}),
            (["-network_file", ".yaml, .yml or .msh"], {"network_file": self.scratch / "frame.inp"}),
            (["-network_grillage", "3 values", "2"], {"network_grillage": "3,3,3"}),
            (["-network_lattice", "0", ">= 1"], {"network_lattice": "3,0,3"}),
            (["-network_section_width", "-network_section"], {"network_grillage": "3,3", "network_section_width": 1}),
            (["-network_section_inner_radius"], {"network_grillage": "3,3", "network_section": "tube"}),
            (["-network_lattice", "32 bits"], {"network_lattice": "2000,2000,2000"}),
            (["-network_lattice: 400,400,400", "GB of memory", "-structure_memory"],
             {"network_lattice": "400,400,400", "network_elements": 1}),
            (["-beam_length", "network"], {"network_grillage": "3,3", "beam_length": 3}),
            (["-structure_write", "network"], {"network_grillage": "3,3", "structure_write": "x"}),
            (["-structure_mass", "import"], {"network_grillage": "3,3", "structure_mass": "x"}),
            (["-gauge_junction", "'9 9 9'", "'0 0 0', '1 0 0'", "..."],
             {"network_grillage": "3,3", "gauge_junction": "9 9 9"}),
            (["-gauge_place", "three"], {"network_grillage": "3,3", "gauge_place": "1,2"}),
            (["-striker_junction", "'9 9 9'"],
             {"network_grillage": "3,3", "striker_junction": "9 9 9", "striker_mass": 1}),
            (["-striker_place", "three", "striker"],
             {"network_grillage": "3,3", "striker_place": "1,2", "striker_mass": 1}),
            (["-striker_place", "9", "from 0 to 2"],
             {"network_grillage": "3,3", "striker_place": "9,1,0", "striker_mass": 1}),
            (["-pair_from_junction", "'9 9 9'"],
             {"network_grillage": "3,3", "pair_from_junction": "9 9 9", "pair_to_junction": "1 0 1"}),
            (["-pair_to_place", "-pair_from_place", "0 nodes for the 1"],
             {"network_grillage": "3,3", "pair_from_place": "1,0,1"}),
            (["-pair_to_place", "three"], {"network_grillage": "3,3", "pair_to_place": "1,2"}),
            (["-pair_to_place", "another node", "-pair_from_place"], {**PAIR, "pair_to_junction": "1 0 1"}),
            (["-pair_normal", "1,0,0", "0.6,0.8"], {**PAIR, "pair_normal": "3,4,0"}),
            (["-pair_normal", "0,0,0"], {**PAIR, "pair_normal": "0,0,0"}),
            (["-pair_normal", "2 numbers for 1 pairs"], {**PAIR, "pair_normal": "1,0"}),
            (["-pair_normal", "nothing", "-pair_from_place"], {"network_grillage": "3,3", "pair_normal": "1,0,0"}),
            (["-pair_gap", "-1", ">= 0", "[m]"], {**PAIR, "pair_gap": -1}),
            (["-pair_gap", "nothing", "-pair_from_place"], {"network_grillage": "3,3", "pair_gap": 1}),
            (["-pair_restitution", "1.1", "from 0 to 1"], {**PAIR, "pair_restitution": 1.1}),
            (["-pair_yield_speed", "0", "> 0", "[m/s]"], {**PAIR, "pair_yield_speed": 0}),
            (["-pair_law", "glue", "hertz"], {**PAIR, "pair_law": "glue"}),
            (["-pair_stiffness", "0", "> 0"], {**PAIR, "pair_law": "hertz"}),
            (["-pair_exponent", "-pair_law hunt_crossley"], {**PAIR, "pair_exponent": 1.5}),
            (["-pair_restitution", "0.5", "-pair_law"],
             {**PAIR, "pair_law": "hertz", "pair_stiffness": 1e8, "pair_restitution": 0.5}),
            (["rk", "-pair_law", "impact"], {**PAIR, "pair_law": "hertz", "pair_stiffness": 1e8, "ts_type": "rk"}),
            (["moreau", "-pair_normal"], {**PAIR, "ts_type": "moreau"}),
            (["-contact_surface", "line", "-pair_*"], {**PAIR, "contact_surface": "line"}),
            (["-pair_*", "-ts_type modal"], {**PAIR, "ts_type": "modal"}),
            (["-filter_correct_modes", "-pair_*"], {**PAIR, "filter_correct_modes": 1}),
            (["-pair_from_place", "-pair_to_place", "no support", "floor"], {**PAIR, "floor": True}),
            (["-pair_from_junction", "-structure_type network"],
             {"structure_type": "beam", "pair_from_place": "1,0,0", "pair_to_place": "2,0,0"}),
            (["-initial_part", "5 numbers", "six"], {"network_grillage": "3,3", "initial_part": "0,1,0,1,0"}),
            (["-initial_part_velocity", "0 numbers for 1 boxes"],
             {"network_grillage": "3,3", "initial_part": "0,1,0,1,0,1"}),
            (["-initial_part_velocity", "-initial_part"],
             {"network_grillage": "3,3", "initial_part_velocity": "1,0,0"}),
            (["-network_*", "network"], {"structure_type": "beam", "network_grillage": "3,3"}),
            (["-network_*", "network"], {"structure_type": "beam", "network_partition": "metis"}),
            (["-network_partition", "scotch", "contiguous"],
             {"network_grillage": "3,3", "network_partition": "scotch"}),
            (["-filter_frequency", "none"], {"network_grillage": "3,3", "filter_frequency": "none", "ts_dt": 0.1}),
        ):
            with self.subTest(options=options):
                self.refused(*words, ranks=(0,), **options)


class Output(NetworkTest):
    """What its files say: vectors at nodes, numbers in the order of the user, whatever the ranks."""

    def fall(self, ranks=0, name="run", code=0, **changes):
        options = {**RUN, "network_file": self.write("frame.yaml", FRAME.replace(", held: pinned", ", mass: 1")),
                   "initial_height": 0.01, "support_position": None, "support_height": None, "floor": True,
                   "initial_slope": 0.002, "ts_max_time": 0.08, "output_field_interval": 0.01,
                   "gauge_junction": "left knee", **changes}
        return self.run_case(options, ranks, name=name, code=code)

    def test_nodes_have_vectors(self):
        alone, dealt = (self.fall(ranks, name=f"np{ranks}") for ranks in (1, 2))
        one, two = (datasets(run.file("results.h5")) for run in (alone, dealt))
        self.assertEqual(sorted(one), sorted(two))
        for name in ("x", "y", "mass", "node", "cells", "member", "member_radius", "radius"):
            np.testing.assert_array_equal(two[name], one[name], err_msg=name)
        for name in ("displacement_of_line", "displacement_of_masses", "mass_velocity", "axial_force", "moment_z"):
            rows = one[f"fields/{name}"]
            off = np.abs(two[f"fields/{name}"] - rows).max()
            self.assertLess(off, 1e-8 * np.abs(rows).max(), name)  # they land at 45 ms and hit many times
        self.assertEqual(one["fields/mass_velocity"].shape, (9, len(one["x"]), 3))
        self.assertEqual(one["fields/resting"].shape, (9, len(one["x"])))
        self.assertEqual(one["fields/moment_z"].shape, (9, len(one["cells"])))
        np.testing.assert_array_equal(one["node"], np.arange(len(one["x"])))
        # A gauge reads the height and the velocity of its node.
        gauge, table = int(one["gauge_node"][0]), alone.csv("gauges.csv")
        self.assertEqual((one["x"][gauge], one["y"][gauge]), (0, 3))
        every = np.rint(one["fields/time"] / 0.002).astype(int)
        for body, column in (("masses", "mass_0"), ("line", "line_0")):
            height = 3 + one[f"fields/displacement_of_{body}"][:, gauge, 1]
            np.testing.assert_allclose(height, table[column][every], rtol=0, atol=1e-14)
        np.testing.assert_allclose(one["fields/mass_velocity"][:, gauge, 1], table["velocity_0"][every], rtol=0,
                                   atol=1e-14)
        self.assertGreater(np.abs(one["fields/displacement_of_line"][:, :, 0]).max(), 1e-6, "it sways")
        # Members follow each other, each from end to end; tubes have the radius of the circle or one of the same area.
        self.assertEqual([int((one["member"] == k).sum()) for k in range(4)], [6, 6, 4, 4])
        beam = np.sqrt(0.1 * 0.2 / np.pi)
        np.testing.assert_allclose(one["member_radius"], np.repeat([0.1, beam], [12, 8]), rtol=1e-15)
        ends = one["cells"][one["member"] == 0]
        np.testing.assert_array_equal(ends[1:, 0], ends[:-1, 1])
        for x, y, radius in ((0, 3, 0.1), (2, 3, beam), (0, 0, 0.1)):
            at = np.flatnonzero((one["x"] == x) & (one["y"] == y))
            np.testing.assert_allclose(one["radius"][at], [radius], rtol=1e-15)

    def test_what_is_off_the_structure_is_told(self):
        table = self.write("load.csv", "0,1\n1,1\n")
        far = self.fall(gauge_place="2,30,7,2,3,0", load_place="2,3,4", load_table=table, gauge_junction=None,
                        ts_max_time=1e-3)
        (warning,) = [text for text in far.summary()["warnings"] if "nearest node" in text]
        self.assertIn("gauge 0 at (2, 30, 7) m is taken to the nearest node, at (2, 3, 0) m", warning)
        self.assertIn("load 0 at (2, 3, 4) m is taken to the nearest node, at (2, 3, 0) m", warning)
        self.assertNotIn("gauge 1", warning)

    def test_the_view_knows_the_nodes_of_the_files(self):
        for ranks in (0, 2):
            shown = self.fall(ranks, name=f"view{ranks}", gauge_place="2.1,3,0", gauge_junction="middle,right foot",
                              udar_view=True, ts_max_time=1e-3)
            lines = [line.split("m]")[-1].split() for line in shown.out.splitlines() if line.startswith("  gauge ")]
            self.assertEqual(lines, [text.split() for text in ("2.1 3 0 4 2 3 0", "2 3 0 4 2 3 0", "4 0 0 1 4 0 0")])

    def test_pictures_have_planes_where_they_are(self):
        fallen = self.fall(floor=None, support_position=2, support_width="inf", support_normal="-1,0,0",
                           support_height=-5, initial_slope=0, ts_max_time=0.01)
        with h5py.File(fallen.file("results.vtkhdf")) as file:
            wall = file["VTKHDF/Points"][()][2 * len(h5py.File(fallen.file("results.h5"))["x"]):]
            self.assertTrue(np.isfinite(file["VTKHDF/PointData/radius"][()]).all())
        self.assertEqual(len(wall), 5)
        np.testing.assert_allclose(wall[:, 0], 5, rtol=0, atol=1e-14)
        self.assertEqual((wall[:, 1].min(), wall[:, 1].max()), (0, 3))

    def test_envelopes_go_on_over_a_restart_on_other_ranks(self):
        whole = self.fall(1, name="whole")
        part = self.fall(1, name="part", code=STOPPED_BY_STEPS, ts_max_steps=STEPS)
        rest = self.fall(2, name="rest", restart_file=part.file("restart.h5"))
        expected, before, found = (datasets(run.file("results.h5")) for run in (whole, part, rest))
        kept = 0
        for name in (name for name in expected if name.startswith("envelope/")):
            size = np.abs(expected[name]).max()
            if size < 1.0:
                self.assertRegex(name, "shear_z|torque|moment_y", "across a plane frame")
                continue
            kept += int((np.abs(before[name] - expected[name]) < 1e-9 * size).sum())
            self.assertLess(np.abs(found[name] - expected[name]).max(), 1e-8 * size, name)
        self.assertGreater(kept, 20, "extremes of the first run")


if __name__ == "__main__":
    unittest.main()
