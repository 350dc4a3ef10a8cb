"""Runs the program as a user's script would. A test calls main(), with PROGRAM DATA_FOLDER."""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, DATA = (os.path.abspath(argument) for argument in sys.argv[1:3])
ROOM_LIGHT = "point:2.61,2.23,2.41"


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
        """Exit status 2, one line on stderr, nothing on stdout, no file made.

        With `faces`, lines for refused faces may come before.
        """
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


def main():
    del sys.argv[1:3]
    unittest.main()
