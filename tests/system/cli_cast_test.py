"""Cast and inspect, what they write, and what they refuse of a scene.

    cli_cast_test.py PROGRAM DATA_FOLDER

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people
is not tested here.
"""
import csv
import json
import os
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_program import DATA, ROOM_LIGHT, Cli, polygon_area, run, main

MODELS = "/usr/share/assimp/models"
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
AREA_COLUMNS = ["light", "object", "face", "facing", "area", "lit_area", "shadowed_area"]


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
        closed = self.cast_json(box, "--light", "directional:1,2,-3")["lights"][0]
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
        # Nine tiles and a sheet upon them, turned before they were written: each corner is rounded
        # by itself.
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
            "ply\nformat ascii 1.0\nelement vertex 4\n"
            "property double x\nproperty double y\nproperty double z\n"
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
            "solid s\nfacet normal 0 0 1\nouter loop\n"
            "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
            "endsolid s\n",
        )
        self.assertEqual(self.cast_json(stl, "--light", "sun:0,0,-1")["lights"][0]["lit_area"], 0.5)


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
    main()
