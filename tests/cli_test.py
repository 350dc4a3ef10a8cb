"""Drives the program as a user's script would: cli_test.py PROGRAM DATA_FOLDER.

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people is not tested here.
"""
import csv
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = DATA = None
MODELS = "/usr/share/assimp/models"
ROOM_LIGHT = "point:2.61,2.23,2.41"

TOP_KEYS = {"scene", "kernel", "threads", "load_ms", "lights"}
LIGHT_KEYS = {"light", "faces", "facing_faces", "facing_area", "lit_area", "shadowed_area", "lit_fragments", "shadowed_fragments",
              "tree_nodes", "tree_depth", "build_ms", "emit_ms"}
AREA_COLUMNS = ["light", "object", "face", "facing", "area", "lit_area", "shadowed_area"]


def run(*arguments, cwd=None):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, cwd=cwd, timeout=120)


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
        lines = [line for line in result.stderr.strip().splitlines() if not (faces and ": face " in line)]
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
        self.assertAlmostEqual(light["lit_area"] + light["shadowed_area"], light["facing_area"], delta=1e-9)
        for key in ("load_ms",):
            self.assertGreaterEqual(report[key], 0)
        for key in ("build_ms", "emit_ms"):
            self.assertGreaterEqual(light[key], 0)
        for key in ("faces", "facing_faces", "lit_fragments", "shadowed_fragments", "tree_nodes", "tree_depth"):
            self.assertIsInstance(light[key], int)

    def test_json_to_a_file(self):
        target = self.path("report.json")
        self.cast(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet", "--json", target)
        with open(target, encoding="utf-8") as text:
            self.assertLessEqual(TOP_KEYS, set(json.load(text)))

    def test_quiet_says_nothing(self):
        result = self.cast(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet")
        self.assertEqual(result.stdout + result.stderr, "")

    def test_areas_match_the_reference(self):
        target = self.path("areas.csv")
        self.cast(os.path.join(DATA, "room2.obj"), "--light", ROOM_LIGHT, "--quiet", "--areas", target)
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
            self.assertAlmostEqual(float(row["lit_area"]), float(want["lit_area"]), delta=1e-9 * area)
            self.assertAlmostEqual(float(row["lit_area"]) + float(row["shadowed_area"]), area, delta=1e-9 * area)

    def test_areas_of_two_lights(self):
        target = self.path("areas.csv")
        report = json.loads(self.cast(os.path.join(DATA, "city8.obj"), "--light", "sun:1,2,-3", "--light", "point:2,3,9", "--quiet", "--areas",
                                      target, "--json", "-").stdout)
        self.assertEqual([light["light"] for light in report["lights"]], ["sun:1,2,-3", "point:2,3,9"])
        with open(target, encoding="utf-8", newline="") as text:
            rows = list(csv.DictReader(text))
        self.assertEqual(len(rows), 2 * 385)
        lights = sorted({row["light"] for row in rows})
        self.assertEqual(len(lights), 2)
        for name, light in zip(dict.fromkeys(row["light"] for row in rows), report["lights"]):
            lit = sum(float(row["lit_area"]) for row in rows if row["light"] == name)
            self.assertAlmostEqual(lit, light["lit_area"], delta=1e-9 * light["facing_area"])

    def test_forms_have_equal_areas(self):
        reports = [self.cast_json(os.path.join(DATA, "room3.obj"), "--light", ROOM_LIGHT, "--form", form)["lights"][0]
                   for form in ("pieces", "merged", "conforming")]
        for report in reports[1:]:
            self.assertAlmostEqual(report["lit_area"], reports[0]["lit_area"], delta=1e-9)

    def test_threads_change_no_byte(self):
        outputs = []
        for threads in ("1", "2", "4"):
            target = self.path("out%s.obj" % threads)
            self.cast(os.path.join(DATA, "city8.obj"), "--light", "sun:1,2,-3", "--threads", threads, "--quiet", "-o", target)
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

    def test_kernel_fast(self):
        self.assertEqual(self.cast_json(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--kernel", "fast")["kernel"], "fast")

    def test_lights_of_the_file(self):
        report = self.cast_json(os.path.join(DATA, "lamp.gltf"))
        self.assertEqual(len(report["lights"]), 1)
        listed = json.loads(run("inspect", os.path.join(DATA, "lamp.gltf"), "--json", "-").stdout)
        names = [o["name"] for o in listed["objects"]]
        self.assertEqual(sorted(names), ["cup", "floor", "leg.left", "leg.right", "top"])
        self.assertEqual({o["name"]: o["sides"] for o in listed["objects"]},
                         {"cup": "closed", "floor": "open", "leg.left": "closed", "leg.right": "closed", "top": "closed"})
        self.assertEqual(len(listed["lights"]), 1)

    def test_given_lights_take_the_place_of_the_files(self):
        report = self.cast_json(os.path.join(DATA, "lamp.gltf"), "--light", "sun:0,-1,0")
        self.assertEqual([light["light"] for light in report["lights"]], ["sun:0,-1,0"])

    def test_light_numbers_of_every_form(self):
        scene = self.path("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        for spec in ("point:1,2,3", "point:-1.5,2e3,.5", "point:1,-2.,3E-2", "sun:0,0,-1", "sun:1e-300,0,-1e-300"):
            self.assertEqual(len(self.cast_json(scene, "--light", spec)["lights"]), 1)


class Outputs(Cli):
    def areas(self):
        light = self.cast_json(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT)["lights"][0]
        return light["lit_area"], light["shadowed_area"]

    def write(self, name, *more):
        target = self.path(name)
        self.cast(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet", "-o", target, *more)
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
        gltf = json.loads(content[20:20 + size])
        rest, kind = struct.unpack("<I4s", content[20 + size:28 + size])
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
        self.cast(os.path.join(DATA, "room1.obj"), "--light", ROOM_LIGHT, "--quiet", "-o", a, "-o", b, "-o", c)
        for target in (a, b, c):
            self.assertGreater(os.path.getsize(target), 0)
        leftovers = set(os.listdir(self.folder)) - {"a.obj", "b.svg", "c.ply", "a.mtl"}
        self.assertEqual(leftovers, set())


class Refusals(Cli):
    def setUp(self):
        super().setUp()
        self.square = self.path("square.obj", "o square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")

    def test_missing_file(self):
        self.refused("cast", self.path("none.obj"), "--light", "sun:0,0,-1", says=["none.obj"])
        self.refused("inspect", self.path("none.obj"), says=["none.obj"])

    def test_missing_files_of_every_format(self):
        for extension in ("ply", "off", "stl", "gltf", "glb", "dae", "fbx", "ifc", "3ds"):
            self.refused("cast", self.path("none." + extension), "--light", "sun:0,0,-1", says=["none." + extension])

    def test_folder_for_a_scene(self):
        self.refused("cast", self.folder, "--light", "sun:0,0,-1")

    def test_empty_scenes(self):
        for name, text in (("a.obj", ""), ("b.obj", "# nothing\n"), ("c.obj", "v 0 0 0\n"), ("d.ply", ""), ("e.off", ""), ("f.stl", ""),
                           ("g.gltf", ""), ("h.gltf", '{"asset":{"version":"2.0"}}'), ("i.off", "OFF\n0 0 0\n"), ("j.dae", "<x/>")):
            self.refused("cast", self.path(name, text), "--light", "sun:0,0,-1", says=[name])

    def test_garbage(self):
        for extension in ("obj", "ply", "off", "stl", "gltf", "glb", "dae", "fbx", "ifc", "xyz"):
            scene = self.path("garbage." + extension, "\x01\x02 what is this? \x7f 1 2 3 f f f\nf 1 2 9999999999999\n" * 20)
            self.refused("cast", scene, "--light", "sun:0,0,-1", says=["garbage." + extension], faces=True)

    def test_unknown_light_syntax(self):
        for spec in ("", "lamp", "point", "point:", "point:1,2", "point:1,2,3,4", "point:a,b,c", "point:1,2,3x", "point: ", "sun:0,0,0", "sun:1,2",
                     "moon:1,2,3", "point:nan,0,0", "point:inf,0,0", "sun:0,0,nan", "POINT:1;2;3", "point:1,,3"):
            self.refused("cast", self.square, "--light", spec)

    def test_no_light(self):
        self.refused("cast", self.square, says=["light"])

    def test_unknown_options_and_values(self):
        light = ("--light", "sun:0,0,-1")
        for more in (("--kernel", "exactly"), ("--form", "round"), ("--sides", "both"), ("--threads", "-1"), ("--threads", "many"), ("--what",),
                     ("-o",)):
            self.refused("cast", self.square, *light, *more)
        self.refused()
        self.refused("cats", self.square)
        self.refused("cast")
        self.refused("inspect")

    def test_unwritable_outputs(self):
        light = ("--light", "sun:0,0,-1", "--quiet")
        nowhere = os.path.join(self.folder, "no", "such")
        for extension in ("obj", "ply", "gltf", "glb", "svg"):
            self.refused("cast", self.square, *light, "-o", os.path.join(nowhere, "out." + extension), says=["out." + extension])
        self.refused("cast", self.square, *light, "--areas", os.path.join(nowhere, "a.csv"), says=["a.csv"])
        self.refused("cast", self.square, *light, "--json", os.path.join(nowhere, "j.json"), says=["j.json"])
        self.refused("inspect", self.square, "--json", os.path.join(nowhere, "j.json"), says=["j.json"])

    def test_unknown_output_format(self):
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out.xyz"))
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out"))

    def test_bad_output_is_found_before_any_is_written(self):
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out.obj"), "-o", self.path("out.xyz"))

    def test_folder_in_the_place_of_an_output(self):
        os.mkdir(self.path("out.obj"))
        self.refused("cast", self.square, "--light", "sun:0,0,-1", "-o", self.path("out.obj"))

    def test_strict_refuses_what_is_listed(self):
        scene = self.path("bad.obj", "o good\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\no bad\nf 1 2 2\nf 1 2 3\nf 1 2 3\n")
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
        self.assertEqual(run("cast", self.square, "--light", "sun:0,0,-1", "--strict", "--quiet").returncode, 0)

    def test_every_face_refused(self):
        scene = self.path("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
        self.refused("cast", scene, "--light", "sun:0,0,-1", faces=True)


class ObjDetails(Cli):
    def test_negative_indices_polygons_groups(self):
        scene = self.path("s.obj", "o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 2 0\nv 0 1 0\nf -5 -4 -3 -2 -1\n"
                                   "o two\ng two_group\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 6/1/1 7//2 -1\n")
        listed = json.loads(run("inspect", scene, "--json", "-").stdout)
        self.assertEqual([o["faces"] for o in listed["objects"]], [1, 1])
        self.assertEqual(listed["objects"][0]["name"], "one")
        self.assertIn("two", listed["objects"][1]["name"])
        self.assertEqual(listed["issues"], [])

    def test_doubles_keep_their_digits(self):
        x = 0.1234567890123456
        scene = self.path("s.obj", "v 0 0 0\nv %.17g 0 0\nv %.17g 1 0\nv 0 1 0\nf 1 2 3 4\n" % (x, x))
        self.assertEqual(self.cast_json(scene, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], x)

    def test_ply_doubles_keep_their_digits(self):
        x = 0.1234567890123456
        header = ("ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n")
        scene = self.path("s.ply", header + "0 0 0\n%.17g 0 0\n%.17g 1 0\n0 1 0\n4 0 1 2 3\n" % (x, x))
        self.assertEqual(self.cast_json(scene, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], x)

    def test_off_and_stl(self):
        off = self.path("s.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        self.assertEqual(self.cast_json(off, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], 1)
        stl = self.path("s.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                                 "endsolid s\n")
        self.assertEqual(self.cast_json(stl, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], 0.5)


class RealModels(Cli):
    def check(self, path, faces, objects=1, light="sun:0.3,-0.8,-0.5"):
        if not os.path.exists(path):
            self.skipTest(path + " is not installed")
        report = self.cast_json(path, "--light", light)["lights"][0]
        self.assertGreaterEqual(report["faces"], faces)
        self.assertGreater(report["lit_area"], 0)
        self.assertGreater(report["shadowed_area"], 0)
        self.assertAlmostEqual(report["lit_area"] + report["shadowed_area"], report["facing_area"], delta=1e-8 * report["facing_area"])
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
