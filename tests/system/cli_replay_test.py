"""Scripts of edits.

    cli_replay_test.py PROGRAM DATA_FOLDER

Exact option forms, JSON keys and exit statuses are a contract; what is drawn and printed for people
is not tested here.
"""
import csv
import json
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_program import DATA, Cli, run, main
from replay_scene import Mirror, Solid, obj_text

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
        """The changes make a mirror that counts and measures as the engine does.

        In the end so does a fresh cast of the edited scene.
        """
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

    def test_position_and_direction_of_lights(self):
        self.first_lights = (self.LIGHT, "directional:1,2,-3")
        self.check_mirror(
            self.script(
                {"op": "light", "light": 0, "position": [-1.5, 2.25, 3]},
                {"op": "light", "light": 1, "direction": [0, 1, -1]},
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
            ({"op": "light", "light": 0, "at": [0, 0, 1], "position": [0, 0, 1]}, "only one"),
            ({"op": "light", "light": 0, "direction": [0, 0, 1]}, "position"),
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
        facet = (
            "facet normal 0 0 1\nouter loop\nvertex 0 0 %d\nvertex 1 0 %d\nvertex 0 1 %d\n"
            "endloop\nendfacet\n"
        )
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
        self.refused(
            "replay",
            self.scene,
            script,
            "--light",
            self.LIGHT,
            "--verify",
            "--min-feature",
            "0.1",
            says=["--verify", "--min-feature"],
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


if __name__ == "__main__":
    main()
