"""Drives the program as a user's script would: cli_test.py PROGRAM DATA_FOLDER.

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people is not tested here.
"""
import csv
import json
import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = DATA = None
MODELS = "/usr/share/assimp/models"
ROOM_LIGHT = "point:2.61,2.23,2.41"

TOP_KEYS = {"scene", "kernel", "threads", "load_ms", "aligned", "lights"}
LIGHT_KEYS = {
    "light",
    "faces",
    "facing_faces",
    "facing_area",
    "lit_area",
    "shadowed_area",
    "lit_fragments",
    "shadowed_fragments",
    "tree_nodes",
    "tree_depth",
    "build_ms",
    "emit_ms",
    "predicates",
    "by_identity",
    "by_filter",
    "by_exact",
}
REPLAY_KEYS = {"updates", "rebuild_ms", "max_area_error", "aligned"}
UPDATE_KEYS = {
    "update",
    "edits",
    "update_ms",
    "fragments_gone",
    "fragments_new",
    "lit_area",
    "tree_nodes",
    "marked_nodes",
}
COMPARE_KEYS = {
    "algorithm",
    "faces_in",
    "faces_after_bsp",
    "lit_area",
    "lit_fragments",
    "shadowed_fragments",
    "order_ms",
    "shadow_ms",
    "memory_bytes",
}
AREA_COLUMNS = ["light", "object", "face", "facing", "area", "lit_area", "shadowed_area"]


def run(*arguments, cwd=None):
    return subprocess.run(
        [PROGRAM, *arguments], capture_output=True, text=True, cwd=cwd, timeout=120
    )


def polygon_area(points):
    sums = [0.0, 0.0, 0.0]
    for (ax, ay, az), (bx, by, bz) in zip(points[1:], points[2:]):
        ux, uy, uz = (a - o for a, o in zip((ax, ay, az), points[0]))
        vx, vy, vz = (b - o for b, o in zip((bx, by, bz), points[0]))
        sums[0] += uy * vz - uz * vy
        sums[1] += uz * vx - ux * vz
        sums[2] += ux * vy - uy * vx
    return 0.5 * math.sqrt(sum(s * s for s in sums))


def read_obj(path):
    """Area by material, and the names of objects."""
    vertices, areas, names, material = [], {}, [], None
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                vertices.append(tuple(float(w) for w in words[1:4]))
            elif words[0] in ("o", "g"):
                names.append(" ".join(words[1:]))
            elif words[0] == "usemtl":
                material = words[1]
            elif words[0] == "f":
                corners = [int(w.split("/")[0]) for w in words[1:]]
                points = [vertices[c - 1 if c > 0 else c] for c in corners]
                areas[material] = areas.get(material, 0.0) + polygon_area(points)
    return areas, names


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="shadowcut-cli-")
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name, text=None):
        path = os.path.join(self.folder, name)
        if text is not None:
            with open(path, "w", encoding="utf-8") as out:
                out.write(text)
        return path

    def cast(self, *arguments):
        result = run("cast", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def cast_json(self, *arguments):
        return json.loads(self.cast(*arguments, "--quiet", "--json", "-").stdout)

    def refused(self, *arguments, says=(), faces=False):
        """Exit status 2, one line on stderr (after those for refused faces, if there may be any), nothing on stdout, no file made."""
        before = sorted(os.listdir(self.folder))
        result = run(*arguments)
        self.assertEqual(result.returncode, 2, (arguments, result.stdout, result.stderr))
        self.assertEqual(result.stdout, "", arguments)
        lines = [
            line for line in result.stderr.strip().splitlines() if not (faces and ": face " in line)
        ]
        self.assertEqual(len(lines), 1, (arguments, result.stderr))
        for word in says:
            self.assertIn(word, result.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before, arguments)
        return result


class Results(Cli):
    def test_json_has_the_agreed_keys(self):
        room = os.path.join(DATA, "room1.obj")
        report = self.cast_json(room, "--light", ROOM_LIGHT, "--threads", "1")
        self.assertLessEqual(TOP_KEYS, set(report))
        self.assertEqual(report["kernel"], "fast")
        self.assertEqual(report["threads"], 1)
        self.assertEqual(report["scene"], room)
        self.assertEqual(len(report["lights"]), 1)
        light = report["lights"][0]
        self.assertLessEqual(LIGHT_KEYS, set(light))
        self.assertEqual(light["light"], ROOM_LIGHT)
        self.assertEqual(light["faces"], 133)
        self.assertAlmostEqual(
            light["lit_area"] + light["shadowed_area"], light["facing_area"], delta=1e-9
        )
        for key in ("load_ms",):
            self.assertGreaterEqual(report[key], 0)
        for key in ("build_ms", "emit_ms"):
            self.assertGreaterEqual(light[key], 0)
        for key in (
            "faces",
            "facing_faces",
            "lit_fragments",
            "shadowed_fragments",
            "tree_nodes",
            "tree_depth",
        ):
            self.assertIsInstance(light[key], int)

    def test_json_to_a_file(self):
        target = self.path("report.json")
        self.cast(
            os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet", "--json", target
        )
        with open(target, encoding="utf-8") as text:
            self.assertLessEqual(TOP_KEYS, set(json.load(text)))

    def test_quiet_says_nothing(self):
        result = self.cast(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet")
        self.assertEqual(result.stdout + result.stderr, "")

    def test_areas_match_the_reference(self):
        target = self.path("areas.csv")
        self.cast(
            os.path.join(DATA, "room2.obj"), "--light", ROOM_LIGHT, "--quiet", "--areas", target
        )
        with open(target, encoding="utf-8", newline="") as text:
            reader = csv.DictReader(text)
            rows = list(reader)
        self.assertEqual(reader.fieldnames, AREA_COLUMNS)
        with open(os.path.join(DATA, "room2.areas.csv"), encoding="utf-8", newline="") as text:
            wanted = list(csv.DictReader(text))
        self.assertEqual(len(rows), len(wanted))
        for row, want in zip(rows, wanted):
            self.assertEqual((row["object"], row["face"]), (want["object"], want["face"]))
            area = float(want["area"])
            self.assertAlmostEqual(float(row["area"]), area, delta=1e-9 * area)
            self.assertAlmostEqual(
                float(row["lit_area"]), float(want["lit_area"]), delta=1e-9 * area
            )
            self.assertAlmostEqual(
                float(row["lit_area"]) + float(row["shadowed_area"]), area, delta=1e-9 * area
            )

    def test_areas_of_two_lights(self):
        target = self.path("areas.csv")
        report = json.loads(
            self.cast(
                os.path.join(DATA, "city8.obj"),
                "--light",
                "sun:1,2,-3",
                "--light",
                "point:2,3,9",
                "--quiet",
                "--areas",
                target,
                "--json",
                "-",
            ).stdout
        )
        self.assertEqual(
            [light["light"] for light in report["lights"]], ["sun:1,2,-3", "point:2,3,9"]
        )
        with open(target, encoding="utf-8", newline="") as text:
            rows = list(csv.DictReader(text))
        self.assertEqual(len(rows), 2 * 385)
        lights = sorted({row["light"] for row in rows})
        self.assertEqual(len(lights), 2)
        for name, light in zip(dict.fromkeys(row["light"] for row in rows), report["lights"]):
            lit = sum(float(row["lit_area"]) for row in rows if row["light"] == name)
            self.assertAlmostEqual(lit, light["lit_area"], delta=1e-9 * light["facing_area"])

    def test_forms_have_equal_areas(self):
        reports = [
            self.cast_json(os.path.join(DATA, "room3.obj"), "--light", ROOM_LIGHT, "--form", form)[
                "lights"
            ][0]
            for form in ("pieces", "merged", "conforming")
        ]
        for report in reports[1:]:
            self.assertAlmostEqual(report["lit_area"], reports[0]["lit_area"], delta=1e-9)

    def test_threads_change_no_byte(self):
        outputs = []
        for threads in ("1", "2", "4"):
            target = self.path("out%s.obj" % threads)
            self.cast(
                os.path.join(DATA, "city8.obj"),
                "--light",
                "sun:1,2,-3",
                "--threads",
                threads,
                "--quiet",
                "-o",
                target,
            )
            with open(target, "rb") as data:
                outputs.append(data.read().replace(b"out" + threads.encode(), b"out"))
        self.assertEqual(outputs[0], outputs[1])
        self.assertEqual(outputs[0], outputs[2])

    def test_sides_are_honoured(self):
        box = os.path.join(DATA, "city8.obj")
        closed = self.cast_json(box, "--light", "sun:1,2,-3")["lights"][0]
        opened = self.cast_json(box, "--light", "sun:1,2,-3", "--sides", "open")["lights"][0]
        self.assertEqual(closed["facing_faces"], 193)
        self.assertEqual(opened["facing_faces"], 385)

    def test_kernels(self):
        reports = {
            k: self.cast_json(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--kernel", k)
            for k in ("fast", "exact")
        }
        for kernel, report in reports.items():
            light = report["lights"][0]
            self.assertEqual(report["kernel"], kernel)
            self.assertEqual(
                light["by_identity"] + light["by_filter"] + light["by_exact"], light["predicates"]
            )
        fast, exact = (reports[k]["lights"][0] for k in ("fast", "exact"))
        self.assertAlmostEqual(fast["lit_area"], exact["lit_area"], places=9)
        self.assertEqual(fast["by_filter"], fast["predicates"])
        self.assertGreater(exact["by_identity"], 0)
        self.assertGreater(exact["by_exact"], 0)

    def test_coplanar_faces_share_a_plane(self):
        # Nine tiles and a sheet upon them, turned before they were written: each corner is rounded by itself.
        corners = [(x, y) for x in range(3) for y in range(3)]
        text, count = "", 0
        for x, y, w in [(0.3 * x, 0.3 * y, 0.3) for x, y in corners] + [(0.11, 0.17, 0.55)]:
            for u, v in ((x, y), (x + w, y), (x + w, y + w), (x, y + w)):
                text += "v %.17g %.17g %.17g\n" % (0.36 * u - 0.8 * v, 0.48 * u + 0.6 * v, 0.8 * u)
            text += "f %d %d %d %d\n" % tuple(range(count + 1, count + 5))
            count += 4
        scene, lit, crossing = self.path("tiles.obj", text), {}, {}
        for tolerance, more in (
            ("default", ()),
            ("0", ("--coplanar", "0")),
            ("1e-13", ("--coplanar", "1e-13")),
        ):
            listed = json.loads(run("inspect", scene, "--json", "-", *more).stdout)["objects"][0]
            report = self.cast_json(scene, "--light", "sun:0.3,0.2,-1", "--kernel", "exact", *more)
            self.assertEqual(report["aligned"], listed["aligned"])
            self.assertEqual(listed["aligned"] > 0, tolerance != "0")
            self.assertLess(listed["aligned_by"], 1e-15)
            lit[tolerance], crossing[tolerance] = (
                report["lights"][0]["lit_area"],
                report["lights"][0]["stats"]["crossing_lines"],
            )
        self.assertAlmostEqual(lit["default"], 9 * 0.3**2 + 0.55**2, delta=1e-12)
        self.assertEqual((crossing["default"], crossing["1e-13"]), (0, 0))
        self.assertNotAlmostEqual(
            lit["0"], lit["default"], delta=1e-3
        )  # tiles and sheet shadow each other at random
        self.assertRegex(
            run("inspect", scene).stdout, r"facets put into a plane common with others"
        )

    def test_replay_with_the_exact_kernel(self):
        result = run(
            "replay",
            os.path.join(DATA, "room4.obj"),
            os.path.join(DATA, "room4_edits.jsonl"),
            "--light",
            ROOM_LIGHT,
            "--kernel",
            "exact",
            "--verify",
            "--json",
            "-",
            "--quiet",
        )
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertLess(json.loads(result.stdout)["max_area_error"], 1e-9)

    def test_lights_of_the_file(self):
        report = self.cast_json(os.path.join(DATA, "lamp.gltf"))
        self.assertEqual(len(report["lights"]), 1)
        listed = json.loads(run("inspect", os.path.join(DATA, "lamp.gltf"), "--json", "-").stdout)
        names = [o["name"] for o in listed["objects"]]
        self.assertEqual(sorted(names), ["cup", "floor", "leg.left", "leg.right", "top"])
        self.assertEqual(
            {o["name"]: o["sides"] for o in listed["objects"]},
            {
                "cup": "closed",
                "floor": "open",
                "leg.left": "closed",
                "leg.right": "closed",
                "top": "closed",
            },
        )
        self.assertEqual(len(listed["lights"]), 1)

    def test_given_lights_take_the_place_of_the_files(self):
        report = self.cast_json(os.path.join(DATA, "lamp.gltf"), "--light", "sun:0,-1,0")
        self.assertEqual([light["light"] for light in report["lights"]], ["sun:0,-1,0"])

    def test_light_numbers_of_every_form(self):
        scene = self.path("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        for spec in (
            "point:1,2,3",
            "point:-1.5,2e3,.5",
            "point:1,-2.,3E-2",
            "sun:0,0,-1",
            "sun:1e-300,0,-1e-300",
        ):
            self.assertEqual(len(self.cast_json(scene, "--light", spec)["lights"]), 1)


class Outputs(Cli):
    def areas(self):
        light = self.cast_json(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT)["lights"][0]
        return light["lit_area"], light["shadowed_area"]

    def write(self, name, *more):
        target = self.path(name)
        self.cast(
            os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet", "-o", target, *more
        )
        self.assertGreater(os.path.getsize(target), 0)
        return target

    def test_obj_keeps_names_and_areas(self):
        areas, names = read_obj(self.write("out.obj"))
        lit, shadowed = self.areas()
        self.assertIn("desk.1", " ".join(names))
        self.assertEqual(set(areas), {"lit", "shadowed"})
        self.assertAlmostEqual(areas["lit"], lit, delta=1e-9 * lit)
        self.assertGreater(areas["shadowed"], shadowed * (1 - 1e-9))  # and the sides turned away

    def test_obj_reads_back(self):
        target = self.write("out.obj")
        listed = json.loads(run("inspect", target, "--json", "-").stdout)
        self.assertGreater(sum(o["faces"] for o in listed["objects"]), 133)

    def test_ply(self):
        target = self.write("out.ply")
        with open(target, "rb") as data:
            self.assertTrue(data.read().startswith(b"ply"))
        self.assertEqual(run("inspect", target).returncode, 0)

    def test_gltf_names_and_materials(self):
        with open(self.write("out.gltf"), encoding="utf-8") as text:
            gltf = json.load(text)
        self.assertEqual(gltf["asset"]["version"], "2.0")
        self.assertEqual({m["name"] for m in gltf["materials"]}, {"lit", "shadowed"})
        self.assertIn("desk.1", {n.get("name") for n in gltf["nodes"]})

    def test_glb_is_framed_right(self):
        with open(self.write("out.glb"), "rb") as data:
            content = data.read()
        magic, version, length = struct.unpack("<4sII", content[:12])
        self.assertEqual((magic, version, length), (b"glTF", 2, len(content)))
        size, kind = struct.unpack("<I4s", content[12:20])
        self.assertEqual(kind, b"JSON")
        gltf = json.loads(content[20 : 20 + size])
        rest, kind = struct.unpack("<I4s", content[20 + size : 28 + size])
        self.assertEqual(kind, b"BIN\0")
        self.assertEqual(28 + size + rest, length)
        self.assertLessEqual(gltf["buffers"][0]["byteLength"], rest)

    def test_svg_is_xml_with_a_scale_bar(self):
        import xml.etree.ElementTree

        tree = xml.etree.ElementTree.parse(self.write("out.svg"))
        self.assertTrue(tree.getroot().tag.endswith("svg"))
        text = "".join(tree.getroot().itertext())
        self.assertRegex(text, r"\d")

    def test_several_outputs_at_once(self):
        a, b, c = self.path("a.obj"), self.path("b.svg"), self.path("c.ply")
        self.cast(
            os.path.join(DATA, "room1.obj"),
            "--light",
            ROOM_LIGHT,
            "--quiet",
            "-o",
            a,
            "-o",
            b,
            "-o",
            c,
        )
        for target in (a, b, c):
            self.assertGreater(os.path.getsize(target), 0)
        leftovers = set(os.listdir(self.folder)) - {"a.obj", "b.svg", "c.ply", "a.mtl"}
        self.assertEqual(leftovers, set())


class Refusals(Cli):
    def setUp(self):
        super().setUp()
        self.square = self.path(
            "square.obj", "o square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
        )

    def test_missing_file(self):
        self.refused("cast", self.path("none.obj"), "--light", "sun:0,0,-1", says=["none.obj"])
        self.refused("inspect", self.path("none.obj"), says=["none.obj"])

    def test_missing_files_of_every_format(self):
        for extension in ("ply", "off", "stl", "gltf", "glb", "dae", "fbx", "ifc", "3ds"):
            self.refused(
                "cast",
                self.path("none." + extension),
                "--light",
                "sun:0,0,-1",
                says=["none." + extension],
            )

    def test_folder_for_a_scene(self):
        self.refused("cast", self.folder, "--light", "sun:0,0,-1")

    def test_empty_scenes(self):
        for name, text in (
            ("a.obj", ""),
            ("b.obj", "# nothing\n"),
            ("c.obj", "v 0 0 0\n"),
            ("d.ply", ""),
            ("e.off", ""),
            ("f.stl", ""),
            ("g.gltf", ""),
            ("h.gltf", '{"asset":{"version":"2.0"}}'),
            ("i.off", "OFF\n0 0 0\n"),
            ("j.dae", "<x/>"),
        ):
            self.refused("cast", self.path(name, text), "--light", "sun:0,0,-1", says=[name])

    def test_garbage(self):
        for extension in ("obj", "ply", "off", "stl", "gltf", "glb", "dae", "fbx", "ifc", "xyz"):
            scene = self.path(
                "garbage." + extension,
                "\x01\x02 what is this? \x7f 1 2 3 f f f\nf 1 2 9999999999999\n" * 20,
            )
            self.refused(
                "cast", scene, "--light", "sun:0,0,-1", says=["garbage." + extension], faces=True
            )

    def test_unknown_light_syntax(self):
        for spec in (
            "",
            "lamp",
            "point",
            "point:",
            "point:1,2",
            "point:1,2,3,4",
            "point:a,b,c",
            "point:1,2,3x",
            "point: ",
            "sun:0,0,0",
            "sun:1,2",
            "moon:1,2,3",
            "point:nan,0,0",
            "point:inf,0,0",
            "sun:0,0,nan",
            "POINT:1;2;3",
            "point:1,,3",
        ):
            self.refused("cast", self.square, "--light", spec)

    def test_no_light(self):
        self.refused("cast", self.square, says=["light"])

    def test_unknown_options_and_values(self):
        light = ("--light", "sun:0,0,-1")
        for more in (
            ("--kernel", "exactly"),
            ("--form", "round"),
            ("--sides", "both"),
            ("--coplanar", "-1e-12"),
            ("--coplanar", "nan"),
            ("--coplanar", "2"),
            ("--coplanar", "1,1"),
            ("--coplanar", "much"),
            ("--threads", "-1"),
            ("--threads", "many"),
            ("--what",),
            ("-o",),
        ):
            self.refused("cast", self.square, *light, *more)
        self.refused()
        self.refused("cats", self.square)
        self.refused("cast")
        self.refused("inspect")

    def test_unwritable_outputs(self):
        light = ("--light", "sun:0,0,-1", "--quiet")
        nowhere = os.path.join(self.folder, "no", "such")
        for extension in ("obj", "ply", "gltf", "glb", "svg"):
            self.refused(
                "cast",
                self.square,
                *light,
                "-o",
                os.path.join(nowhere, "out." + extension),
                says=["out." + extension],
            )
        self.refused(
            "cast", self.square, *light, "--areas", os.path.join(nowhere, "a.csv"), says=["a.csv"]
        )
        self.refused(
            "cast", self.square, *light, "--json", os.path.join(nowhere, "j.json"), says=["j.json"]
        )
        self.refused(
            "inspect", self.square, "--json", os.path.join(nowhere, "j.json"), says=["j.json"]
        )

    def test_unknown_output_format(self):
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out.xyz"))
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out"))

    def test_bad_output_is_found_before_any_is_written(self):
        self.refused(
            "cast",
            self.square,
            "--light",
            "sun:0,0,-1",
            "-o",
            self.path("out.obj"),
            "-o",
            self.path("out.xyz"),
        )

    def test_folder_in_the_place_of_an_output(self):
        os.mkdir(self.path("out.obj"))
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out.obj"))

    def test_strict_refuses_what_is_listed(self):
        scene = self.path(
            "bad.obj",
            "o good\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\no bad\nf 1 2 2\nf 1 2 3\nf 1 2 3\n",
        )
        self.refused("cast", scene, "--light", "sun:0,0,-1", "--strict", faces=True)
        result = run("cast", scene, "--light", "sun:0,0,-1", "--json", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("bad", result.stderr)
        listed = json.loads(run("inspect", scene, "--json", "-").stdout)
        self.assertEqual(len(listed["issues"]), 2)
        text = run("inspect", scene)
        self.assertEqual(text.returncode, 0)
        for word in ("bad.obj", "bad", "fewer than three", "duplicate"):
            self.assertIn(word, (text.stdout + text.stderr).lower())

    def test_strict_takes_a_clean_scene(self):
        self.assertEqual(
            run("cast", self.square, "--light", "sun:0,0,-1", "--strict", "--quiet").returncode, 0
        )

    def test_every_face_refused(self):
        scene = self.path("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
        self.refused("cast", scene, "--light", "sun:0,0,-1", faces=True)


class ObjDetails(Cli):
    def test_negative_indices_polygons_groups(self):
        scene = self.path(
            "s.obj",
            "o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 2 0\nv 0 1 0\nf -5 -4 -3 -2 -1\n"
            "o two\ng two_group\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 6/1/1 7//2 -1\n",
        )
        listed = json.loads(run("inspect", scene, "--json", "-").stdout)
        self.assertEqual([o["faces"] for o in listed["objects"]], [1, 1])
        self.assertEqual(listed["objects"][0]["name"], "one")
        self.assertIn("two", listed["objects"][1]["name"])
        self.assertEqual(listed["issues"], [])

    def test_doubles_keep_their_digits(self):
        x = 0.1234567890123456
        scene = self.path(
            "s.obj", "v 0 0 0\nv %.17g 0 0\nv %.17g 1 0\nv 0 1 0\nf 1 2 3 4\n" % (x, x)
        )
        self.assertEqual(self.cast_json(scene, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], x)

    def test_ply_doubles_keep_their_digits(self):
        x = 0.1234567890123456
        header = (
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
        scene = self.path(
            "s.ply", header + "0 0 0\n%.17g 0 0\n%.17g 1 0\n0 1 0\n4 0 1 2 3\n" % (x, x)
        )
        self.assertEqual(self.cast_json(scene, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], x)

    def test_off_and_stl(self):
        off = self.path("s.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        self.assertEqual(self.cast_json(off, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], 1)
        stl = self.path(
            "s.stl",
            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
            "endsolid s\n",
        )
        self.assertEqual(self.cast_json(stl, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], 0.5)


class Solid:
    """A box in a Python scene, which is moved here as the script moves it there."""

    def __init__(self, low, high):
        self.home = [tuple((low, high)[k >> axis & 1][axis] for axis in range(3)) for k in range(8)]
        self.faces = [
            (0, 2, 3, 1),
            (4, 5, 7, 6),
            (0, 1, 5, 4),
            (2, 6, 7, 3),
            (0, 4, 6, 2),
            (1, 3, 7, 5),
        ]
        self.matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
        self.there = True

    def move(self, by):
        for axis in range(3):
            self.matrix[4 * axis + 3] += by[axis]

    def corners(self):
        rows = [self.matrix[4 * axis : 4 * axis + 4] for axis in range(3)]
        return [
            tuple(sum(a * b for a, b in zip(row, v)) + row[3] for row in rows) for v in self.home
        ]


def obj_text(solids):
    text, base = "", 1
    for name, solid in solids.items():
        if not solid.there:
            continue
        text += "o %s\n" % name
        text += "".join("v %.17g %.17g %.17g\n" % v for v in solid.corners())
        text += "".join("f %s\n" % " ".join(str(base + i) for i in face) for face in solid.faces)
        base += 8
    return text


class Mirror:
    """The fragments of every light, from nothing but the changes."""

    def __init__(self):
        self.fragments, self.areas = {}, {}

    def apply(self, change):
        light = self.fragments.setdefault(change["light"], {})
        for key in map(tuple, change["gone"]):
            del light[key]
        for added in change["added"]:
            key = tuple(added["id"])
            assert key not in light, key
            light[key] = added
        for area in change["areas"]:
            self.areas[change["light"], area["face"]] = area

    def count(self):
        return sum(len(light) for light in self.fragments.values())

    def lit_areas(self, light):
        sums = {}
        for f in self.fragments.get(light, {}).values():
            key = f["object"], f["number"]
            sums[key] = sums.get(key, 0.0) + (polygon_area(f["corners"]) if f["lit"] else 0.0)
        return sums


class Replay(Cli):
    LIGHT = "point:1.3,0.7,4.1"

    def setUp(self):
        super().setUp()
        self.solids = {
            "floor": Solid((-5, -5, -0.5), (5, 5, 0)),
            "box": Solid((0, 0, 0), (1, 1, 1)),
            "on": Solid((0.25, 0.25, 1), (0.75, 0.75, 1.5)),
            "by": Solid((2, -1, 0), (2.5, 2, 0.75)),
        }
        self.scene = self.path("scene.obj", obj_text(self.solids))

    def script(self, *edits, name="edits.jsonl", end="\n"):
        return self.path(
            name, "".join((e if isinstance(e, str) else json.dumps(e)) + end for e in edits)
        )

    def replay(self, script, *arguments, scene=None, lights=(LIGHT,)):
        shine = [word for light in lights for word in ("--light", light)]
        result = run(
            "replay",
            scene or self.scene,
            script,
            *shine,
            "--quiet",
            "--verify",
            "--json",
            "-",
            *arguments,
        )
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return json.loads(result.stdout)

    def fresh_areas(self, light):
        """Lit areas of the Python scene as it stands, from a cast of its own."""
        scene, target = self.path("fresh.obj", obj_text(self.solids)), self.path("fresh.csv")
        self.cast(scene, "--light", light, "--quiet", "--areas", target)
        with open(target, encoding="utf-8", newline="") as text:
            return {
                (row["object"], int(row["face"])): (float(row["lit_area"]), float(row["area"]))
                for row in csv.DictReader(text)
            }

    def check_mirror(self, script, final_lights):
        """The changes make a mirror that counts and measures as the engine does, and in the end what a fresh cast of the edited scene does."""
        changes = self.path("changes.jsonl")
        report = self.replay(
            script, "--changes", changes, lights=getattr(self, "first_lights", (self.LIGHT,))
        )
        self.assertLess(report["max_area_error"], 1e-9)
        lines = {}
        with open(changes, encoding="utf-8") as text:
            for line in text:
                change = json.loads(line)
                lines.setdefault(change["update"], []).append(change)
        mirror = Mirror()
        for update in [report["build"]] + report["updates"]:
            mine = lines.pop(update["update"], [])
            for change in mine:
                mirror.apply(change)
            self.assertEqual(mirror.count(), update["fragments"])
            self.assertEqual(sum(len(c["gone"]) for c in mine), update["fragments_gone"])
            self.assertEqual(sum(len(c["added"]) for c in mine), update["fragments_new"])
        self.assertEqual(lines, {})
        for k, light in enumerate(final_lights):
            fresh, mine = self.fresh_areas(light), mirror.lit_areas(k)
            self.assertEqual(set(mine), set(fresh))
            for key, (lit, area) in fresh.items():
                self.assertAlmostEqual(mine[key], lit, delta=1e-9 * area, msg=str(key))
            stated = sum(a["lit"] for (of, _), a in mirror.areas.items() if of == k)
            self.assertAlmostEqual(
                stated,
                sum(lit for lit, _ in fresh.values()),
                delta=1e-9 * sum(area for _, area in fresh.values()),
            )
        return report

    def test_json_has_the_agreed_keys(self):
        script = self.script(
            {"op": "move", "object": "box", "translate": [0.1, 0, 0]},
            {"op": "move", "object": "on", "translate": [0.1, 0, 0]},
            {"op": "update"},
            {"op": "remove", "object": "on"},
            {"op": "update"},
            {"op": "update"},
        )
        report = self.replay(script)
        self.assertLessEqual(REPLAY_KEYS, set(report))
        self.assertEqual([u["update"] for u in report["updates"]], [1, 2, 3])
        self.assertEqual([u["edits"] for u in report["updates"]], [2, 1, 0])
        for update in report["updates"]:
            self.assertLessEqual(UPDATE_KEYS, set(update))
            for key in ("edits", "fragments_gone", "fragments_new", "tree_nodes", "marked_nodes"):
                self.assertIsInstance(update[key], int)
            self.assertGreaterEqual(update["update_ms"], 0)
        self.assertEqual(report["updates"][2]["fragments_gone"], 0)
        self.assertEqual(report["updates"][2]["fragments_new"], 0)
        self.assertGreaterEqual(report["rebuild_ms"], 0)
        self.assertLess(report["max_area_error"], 1e-9)

    def test_without_verify_there_is_no_error_to_tell(self):
        result = run(
            "replay",
            self.scene,
            self.script({"op": "update"}),
            "--light",
            self.LIGHT,
            "--json",
            "-",
        )
        self.assertIsNone(json.loads(result.stdout)["max_area_error"])

    def test_move_is_relative(self):
        for _ in range(2):
            self.solids["box"].move((0.5, 0.25, 0))
        edit = {"op": "move", "object": "box", "translate": [0.5, 0.25, 0]}
        self.check_mirror(self.script(edit, {"op": "update"}, edit, {"op": "update"}), [self.LIGHT])

    def test_pose_is_absolute(self):
        self.solids["by"].matrix = [0.8, -0.6, 0, 0.5, 0.6, 0.8, 0, -0.25, 0, 0, 1.5, 0]
        pose = {"op": "pose", "object": "by", "matrix": self.solids["by"].matrix + [0, 0, 0, 1]}
        self.check_mirror(
            self.script(
                {"op": "move", "object": "by", "translate": [1, 1, 1]},
                {"op": "update"},
                pose,
                {"op": "update"},
            ),
            [self.LIGHT],
        )

    def test_remove(self):
        self.solids["box"].there = False
        self.check_mirror(
            self.script({"op": "remove", "object": "box"}, {"op": "update"}), [self.LIGHT]
        )

    def test_add_brings_back_where_it_was(self):
        self.solids["box"].move((-1, 0.125, 0))
        self.check_mirror(
            self.script(
                {"op": "move", "object": "box", "translate": [-1, 0.125, 0]},
                {"op": "remove", "object": "box"},
                {"op": "update"},
                {"op": "add", "object": "box"},
                {"op": "update"},
            ),
            [self.LIGHT],
        )

    def test_everything_goes_and_comes_back(self):
        edits = [{"op": op, "object": name} for op in ("remove", "add") for name in self.solids]
        edits.insert(len(self.solids), {"op": "update"})
        report = self.check_mirror(self.script(*edits, {"op": "update"}), [self.LIGHT])
        self.assertEqual(report["updates"][0]["fragments"], 0)
        self.assertEqual(report["updates"][0]["lit_area"], 0)
        self.assertEqual(report["updates"][1]["lit_area"], report["build"]["lit_area"])

    def test_lights(self):
        self.first_lights = (self.LIGHT, "sun:1,2,-3")
        self.check_mirror(
            self.script(
                {"op": "light", "light": 0, "at": [-1.5, 2.25, 3]},
                {"op": "update"},
                {"op": "light", "light": 1, "at": [0, 1, -1]},
            ),
            ["point:-1.5,2.25,3", "sun:0,1,-1"],
        )

    def test_a_group_without_an_update_gets_one_at_the_end(self):
        edit = {"op": "move", "object": "on", "translate": [0, 0, 0.25]}
        self.assertEqual([u["edits"] for u in self.replay(self.script(edit, edit))["updates"]], [2])
        self.assertEqual(
            [u["edits"] for u in self.replay(self.script(edit, {"op": "update"}, edit))["updates"]],
            [1, 1],
        )
        self.assertEqual(self.replay(self.script(""))["updates"], [])

    def test_line_ends_and_blank_lines(self):
        edit = {"op": "move", "object": "on", "translate": [0, 0, 0.25]}
        self.assertEqual(
            len(self.replay(self.script("", edit, "  ", {"op": "update"}, end="\r\n"))["updates"]),
            1,
        )

    def test_long_random_script(self):
        dice = random.Random(5)
        edits, lights = [], [self.LIGHT, "sun:1,2,-3"]
        self.first_lights = tuple(lights)
        names = list(self.solids)
        for _ in range(120):
            name = dice.choice(names)
            solid, kind = self.solids[name], dice.randrange(10)
            if not solid.there:
                edits.append({"op": "add", "object": name})
                solid.there = True
            elif kind == 0:
                edits.append({"op": "remove", "object": name})
                solid.there = False
            elif kind == 1:
                solid.matrix = [
                    0,
                    -1,
                    0,
                    dice.randrange(-8, 8) / 8,
                    1,
                    0,
                    0,
                    0,
                    0,
                    0,
                    1,
                    dice.randrange(8) / 8,
                ]
                edits.append({"op": "pose", "object": name, "matrix": solid.matrix + [0, 0, 0, 1]})
            elif kind == 2:
                at = [dice.randrange(-16, 16) / 8, 0.7, 4.1]
                edits.append({"op": "light", "light": 0, "at": at})
                lights[0] = "point:%.17g,%.17g,%.17g" % tuple(at)
            else:
                by = [
                    dice.randrange(-8, 9) / 8,
                    dice.randrange(-8, 9) / 8,
                    dice.choice((0, 0, 0.125, -0.125)),
                ]
                edits.append({"op": "move", "object": name, "translate": by})
                solid.move(by)
            if dice.randrange(3) == 0:
                edits.append({"op": "update"})
        self.check_mirror(self.script(*edits, {"op": "update"}), lights)

    def test_threads_change_nothing(self):
        script = os.path.join(DATA, "room4_edits.jsonl")
        one, two = (
            self.replay(
                script,
                "--threads",
                n,
                scene=os.path.join(DATA, "room4.obj"),
                lights=["point:5.3613,3.7171,2.43"],
            )
            for n in "12"
        )
        self.assertEqual(len(one["updates"]), 40)
        for a, b in zip(one["updates"], two["updates"]):
            for key in (
                "fragments",
                "fragments_gone",
                "fragments_new",
                "lit_area",
                "tree_nodes",
                "marked_nodes",
            ):
                self.assertEqual(a[key], b[key])

    def test_people_get_a_table(self):
        script = self.script(
            *([{"op": "move", "object": "on", "translate": [0, 0, 0.25]}, {"op": "update"}] * 3)
        )
        result = run("replay", self.scene, script, "--light", self.LIGHT)
        self.assertEqual(result.returncode, 0, result.stderr)
        for word in ("build", "first update", "next, median", "rebuild", "gone", "new"):
            self.assertIn(word, result.stdout)
        self.assertEqual(
            run("replay", self.scene, script, "--light", self.LIGHT, "--quiet").stdout, ""
        )

    def refuses(self, edits, line, *says, scene=None):
        """The script is refused at that line, and nothing is left of any output."""
        script = edits if isinstance(edits, str) else self.script(*edits)
        before = sorted(os.listdir(self.folder))
        result = self.refused(
            "replay",
            scene or self.scene,
            script,
            "--light",
            self.LIGHT,
            "--changes",
            self.path("c.jsonl"),
            "--json",
            self.path("j.json"),
            says=["%s:%d: " % (script, line), *says],
        )
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        return result

    def test_bad_lines(self):
        good = {"op": "move", "object": "box", "translate": [0, 0, 1]}
        identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        for bad, says in (
            ("{", "JSON"),
            ("no", "JSON"),
            ("[1]", "object"),
            ("{}", "op"),
            ('{"op":1}', "op"),
            ('{"op":"fly","object":"box"}', "fly"),
            ('{"op":"update"} {"op":"update"}', "JSON"),
            ('{"op":"update","object":"box"}', "object"),
            ('{"op":"remove","object":"box","object":"on"}', "twice"),
            ('{"op":"remove"}', "object"),
            ('{"op":"remove","object":3}', "string"),
            ({"op": "remove", "object": "nobody"}, "nobody"),
            ({"op": "move", "object": "box", "translate": [1, 2]}, "translate"),
            ({"op": "move", "object": "box"}, "translate"),
            ({"op": "move", "object": "box", "translate": [1, 2, "3"]}, "translate"),
            ('{"op":"move","object":"box","translate":[1,2,NaN]}', "JSON"),
            ('{"op":"move","object":"box","translate":[1,2,1e999]}', "JSON"),
            ({"op": "pose", "object": "box", "matrix": identity[:15]}, "16"),
            ({"op": "pose", "object": "box", "matrix": identity + [0]}, "16"),
            ({"op": "pose", "object": "box", "matrix": identity[:15] + [2]}, "last row"),
            ({"op": "pose", "object": "box", "matrix": [0] * 15 + [1]}, "invertible"),
            ({"op": "add", "object": "box"}, "already"),
            ({"op": "light", "light": 1, "at": [0, 0, 1]}, "light 1"),
            ({"op": "light", "light": -1, "at": [0, 0, 1]}, "light"),
            ({"op": "light", "light": 0.5, "at": [0, 0, 1]}, "light"),
            ({"op": "light", "light": 0}, "at"),
            ({"op": "light", "light": 0, "at": [0, 0]}, "at"),
        ):
            self.refuses([good, {"op": "update"}, "", bad, good], 4, says)

    def test_removed_objects_cannot_be_edited(self):
        gone = {"op": "remove", "object": "box"}
        for bad in (
            gone,
            {"op": "move", "object": "box", "translate": [0, 0, 1]},
            {
                "op": "pose",
                "object": "box",
                "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
            },
        ):
            self.refuses([gone, {"op": "update"}, bad], 3, "removed")
        self.refuses(
            [gone, {"op": "add", "object": "box"}, {"op": "add", "object": "box"}], 3, "already"
        )

    def test_moves_out_of_the_world(self):
        self.refuses([{"op": "move", "object": "box", "translate": [1e308, 0, 0]}] * 3, 2, "finite")

    def test_a_name_of_two_objects_is_ambiguous(self):
        facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 %d\nvertex 1 0 %d\nvertex 0 1 %d\nendloop\nendfacet\n"
        scene = self.path(
            "two.stl", "".join("solid twin\n" + facet % (z, z, z) + "endsolid\n" for z in (0, 1))
        )
        self.refuses([{"op": "remove", "object": "twin"}], 1, "ambiguous", "twin", scene=scene)

    def test_other_refusals(self):
        script = self.script({"op": "update"})
        self.refused(
            "replay",
            self.scene,
            self.path("none.jsonl"),
            "--light",
            self.LIGHT,
            says=["none.jsonl"],
        )
        self.refused(
            "replay", self.path("none.obj"), script, "--light", self.LIGHT, says=["none.obj"]
        )
        self.refused("replay", self.scene, script, says=["light"])
        self.refused("replay", self.scene, "--light", self.LIGHT)
        nowhere = os.path.join(self.folder, "no", "such")
        for option in ("--changes", "--json"):
            self.refused(
                "replay",
                self.scene,
                script,
                "--light",
                self.LIGHT,
                "--quiet",
                option,
                os.path.join(nowhere, "out"),
                says=["out"],
            )
        both = self.path("both")
        self.refused(
            "replay",
            self.scene,
            script,
            "--light",
            self.LIGHT,
            "--changes",
            both,
            "--json",
            both,
            says=["both"],
        )
        os.mkdir(self.path("folder"))
        self.refused(
            "replay",
            self.scene,
            script,
            "--light",
            self.LIGHT,
            "--quiet",
            "--json",
            self.path("folder"),
            "--changes",
            self.path("c.jsonl"),
        )


class Compare(Cli):
    ALGORITHMS = ["brute", "ordered", "tiling", "unordered"]

    def rows(self, name, *arguments):
        result = run("compare", os.path.join(DATA, name), *arguments, "--json", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_json_has_the_agreed_keys(self):
        rows = self.rows("room1.obj", "--light", ROOM_LIGHT)
        self.assertEqual([row["algorithm"] for row in rows], self.ALGORITHMS)
        for row in rows:
            self.assertLessEqual(COMPARE_KEYS, set(row))
            self.assertEqual(row["faces_in"], 133)
            self.assertGreaterEqual(row["faces_after_bsp"], 133)
            for key in (
                "faces_in",
                "faces_after_bsp",
                "lit_fragments",
                "shadowed_fragments",
                "memory_bytes",
            ):
                self.assertIsInstance(row[key], int)
            for key in ("order_ms", "shadow_ms"):
                self.assertGreaterEqual(row[key], 0)

    def test_all_agree_with_cast(self):
        for name, light in (
            ("room2.obj", ROOM_LIGHT),
            ("tetrahedron3.obj", "sun:0.3,0.4,-1"),
            ("city8.obj", "sun:1,2,-1"),
            ("triangles200.obj", "point:0.5,0.4,3"),
        ):
            cast = self.cast_json(os.path.join(DATA, name), "--light", light)["lights"][0]
            for row in self.rows(name, "--light", light):
                self.assertAlmostEqual(
                    row["lit_area"],
                    cast["lit_area"],
                    delta=1e-9 * cast["facing_area"],
                    msg=(name, row["algorithm"]),
                )

    def test_tetrahedra_have_the_papers_polygons(self):
        for depth, faces in ((2, 65), (3, 257), (4, 1025)):
            (row,) = self.rows(
                f"tetrahedron{depth}.obj",
                "--light",
                "point:2.71,-0.43,3.37",
                "--algorithms",
                "brute",
            )
            self.assertEqual(row["faces_in"], faces)

    def test_algorithms_are_chosen_and_keep_their_order(self):
        rows = self.rows("room1.obj", "--light", ROOM_LIGHT, "--algorithms", "tiling,brute")
        self.assertEqual([row["algorithm"] for row in rows], ["tiling", "brute"])

    def test_a_row_for_each_light(self):
        lights = (ROOM_LIGHT, "point:1,1,2", "sun:0,1,-1")
        rows = self.rows("room1.obj", *(word for light in lights for word in ("--light", light)))
        self.assertEqual(
            [(row["algorithm"], row["light"]) for row in rows],
            [(a, light) for a in self.ALGORITHMS for light in lights],
        )
        for k in range(len(lights)):
            areas = [row["lit_area"] for row in rows[k :: len(lights)]]
            self.assertLess(max(areas) - min(areas), 1e-9 * max(areas))

    def test_resolution_of_the_tiling_changes_no_area(self):
        areas = [
            self.rows(
                "city8.obj", "--light", "point:4,4,9", "--algorithms", "tiling", "--tiles", n
            )[0]["lit_area"]
            for n in ("1", "5", "300")
        ]
        self.assertLess(max(areas) - min(areas), 1e-9 * max(areas))

    def test_people_get_a_table(self):
        result = run("compare", os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT)
        self.assertEqual(result.returncode, 0)
        self.assertEqual(len(result.stdout.splitlines()), 5)
        quiet = run("compare", os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet")
        self.assertEqual(quiet.stdout + quiet.stderr, "")

    def test_refusals(self):
        room = os.path.join(DATA, "room1.obj")
        for algorithms in ("", "fast", "brute,", "brute,,tiling", "brute,brute", "Brute"):
            self.refused(
                "compare",
                room,
                "--light",
                ROOM_LIGHT,
                "--algorithms",
                algorithms,
                says=["--algorithms"],
            )
        for more in (
            ("--tiles", "0"),
            ("--tiles", "many"),
            ("--candidates", "0"),
            ("--kernel", "fast"),
        ):
            self.refused("compare", room, "--light", ROOM_LIGHT, *more)
        self.refused("compare", room, "--light", "lamp")
        self.refused("compare", room, says=["light"])
        self.refused("compare", self.path("none.obj"), "--light", ROOM_LIGHT, says=["none.obj"])
        self.refused(
            "compare",
            room,
            "--light",
            ROOM_LIGHT,
            "--json",
            os.path.join(self.folder, "no", "out"),
            says=["out"],
        )


class Render(Cli):
    CAMERA = "0.4,0.4,2.3,5,4,0.3"

    def picture(self, technique, *arguments):
        target = self.path(technique + ".png")
        result = run(
            "render",
            os.path.join(DATA, "room1.obj"),
            "--light",
            ROOM_LIGHT,
            "--technique",
            technique,
            "--camera",
            self.CAMERA,
            "-o",
            target,
            *arguments,
        )
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(target, "rb") as png:
            content = png.read()
        self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
        return struct.unpack(">II", content[16:24]), result

    def test_every_technique_makes_a_picture(self):
        for technique in (
            "fragments",
            "stencil-standard",
            "stencil-zfail",
            "stencil-hybrid",
            "stencil-kolic",
            "shadow-texture",
            "shadow-map",
        ):
            size, _ = self.picture(technique, "--size", "64x48", "--quiet")
            self.assertEqual(size, (64, 48))

    def test_maps_and_wind_have_settings(self):
        self.picture(
            "shadow-map",
            "--size",
            "64x48",
            "--map-size",
            "256",
            "--bias",
            "2,8,1",
            "--wind",
            "0.01,0.02",
        )
        self.picture("shadow-texture", "--size", "64x48", "--map-size", "256")
        self.picture("stencil-kolic", "--size", "64x48", "--wind", "0.01,0.02")

    def test_json(self):
        _, result = self.picture("stencil-hybrid", "--size", "80x60", "--json", "-")
        report = json.loads(result.stdout)
        self.assertLessEqual(
            {"scene", "technique", "width", "height", "draw_ms", "lights", "figures"}, set(report)
        )
        self.assertLess(
            report["figures"]["shadow_polygons"], report["figures"]["shadow_polygons_before"]
        )

    def test_refusals(self):
        room, light = os.path.join(DATA, "room1.obj"), ("--light", ROOM_LIGHT)
        good = ("--technique", "fragments", "--camera", self.CAMERA)
        out = self.path("out.png")
        self.refused(
            "render",
            room,
            *light,
            "--technique",
            "radiosity",
            "--camera",
            self.CAMERA,
            "-o",
            out,
            says=["radiosity"],
        )
        for camera in (
            "",
            "1,2,3",
            "1,2,3,4,5,6,7,8",
            "1,2,3,1,2,3",
            "a,b,c,d,e,f",
            "0,0,0,1,0,0,0",
            "0,0,0,1,0,0,180",
            "nan,0,0,1,0,0",
        ):
            self.refused(
                "render",
                room,
                *light,
                "--technique",
                "fragments",
                "--camera",
                camera,
                "-o",
                out,
                says=["camera"],
            )
        for size in (
            "0x10",
            "10x0",
            "-5x5",
            "10",
            "10x",
            "x10",
            "10x10x10",
            "1e2x5",
            "100000000x1",
            "99999999999x1",
        ):
            self.refused("render", room, *light, *good, "--size", size, "-o", out)
        for options in (("--map-size", "512"), ("--bias", "1,2,3"), ("--wind", "0.1,0")):
            self.refused("render", room, *light, *good, *options, "-o", out)
        map_of = ("--technique", "shadow-map", "--camera", self.CAMERA)
        for options in (
            ("--map-size", "0"),
            ("--map-size", "100000000"),
            ("--bias", "1,2"),
            ("--wind", "a,b"),
            ("--wind", "1,2,3"),
        ):
            self.refused("render", room, *light, *map_of, *options, "-o", out)
        self.refused("render", room, *light, *good, "-o", self.path("out.jpg"), says=["out.jpg"])
        self.refused(
            "render",
            room,
            *light,
            *good,
            "-o",
            os.path.join(self.folder, "no", "out.png"),
            says=["out.png"],
        )
        self.refused("render", room, *light, *good)
        self.refused("render", room, *good, "-o", out, says=["light"])
        self.refused("render", self.path("none.obj"), *light, *good, "-o", out, says=["none.obj"])

    def test_without_a_driver_there_is_one_clear_error(self):
        environment = dict(
            os.environ, __EGL_VENDOR_LIBRARY_FILENAMES="/none.json", LIBGL_DRIVERS_PATH="/none"
        )
        result = subprocess.run(
            [
                PROGRAM,
                "render",
                os.path.join(DATA, "room1.obj"),
                "--light",
                ROOM_LIGHT,
                "--technique",
                "fragments",
                "--camera",
                self.CAMERA,
                "-o",
                self.path("a.png"),
            ],
            capture_output=True,
            text=True,
            timeout=60,
            env=environment,
        )
        self.assertEqual(result.returncode, 2)
        self.assertIn("OpenGL", result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)


class RealModels(Cli):
    def check(self, path, faces, objects=1, light="sun:0.3,-0.8,-0.5"):
        if not os.path.exists(path):
            self.skipTest(path + " is not installed")
        report = self.cast_json(path, "--light", light)["lights"][0]
        self.assertGreaterEqual(report["faces"], faces)
        self.assertGreater(report["lit_area"], 0)
        self.assertGreater(report["shadowed_area"], 0)
        self.assertAlmostEqual(
            report["lit_area"] + report["shadowed_area"],
            report["facing_area"],
            delta=1e-8 * report["facing_area"],
        )
        listed = json.loads(run("inspect", path, "--json", "-").stdout)
        self.assertGreaterEqual(len(listed["objects"]), objects)
        return listed

    def test_bunny(self):
        self.check("/usr/share/glmark2/models/bunny.obj", 10000)

    def test_ifc_house_keeps_hundreds_of_names(self):
        listed = self.check(MODELS + "/IFC/AC14-FZK-Haus.ifc", 1000, 100)
        self.assertGreaterEqual(len({o["name"] for o in listed["objects"]}), 100)

    def test_spider_obj(self):
        self.check(MODELS + "/OBJ/spider.obj", 1000, 10)

    def test_duck_dae(self):
        self.check(MODELS + "/Collada/duck.dae", 1000)

    def test_milk_truck_gltf(self):
        self.check(MODELS + "/glTF/CesiumMilkTruck/CesiumMilkTruck.gltf", 1000, 2)

    def test_wuson_ply(self):
        self.check(MODELS + "/PLY/Wuson.ply", 1000)


if __name__ == "__main__":
    PROGRAM, DATA = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
