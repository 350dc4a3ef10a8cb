"""What the program refuses, in one line.

    cli_refusals_test.py PROGRAM DATA_FOLDER

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people
is not tested here.
"""
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_program import Cli, run, main


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
            "directional:0,0,0",
            "directional:1,2",
            "directional",
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
            "o good\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
            "o bad\nf 1 2 2\nf 1 2 3\nf 1 2 3\n",
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


if __name__ == "__main__":
    main()
