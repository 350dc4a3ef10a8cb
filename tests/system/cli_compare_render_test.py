"""Compare and render.

    cli_compare_render_test.py PROGRAM DATA_FOLDER

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people
is not tested here.
"""
import json
import os
import struct
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_program import PROGRAM, DATA, ROOM_LIGHT, Cli, run, main

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


if __name__ == "__main__":
    main()
