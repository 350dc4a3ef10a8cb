"""An X server of its own, and the program's window on it.

A test calls main(), with PROGRAM DATA_FOLDER.
"""
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

from Xlib import X, XK, display
from Xlib.ext import xtest
from Xlib.protocol import event

PROGRAM, DATA = (os.path.abspath(argument) for argument in sys.argv[1:3])
PATIENCE = 240  # seconds; only a failure takes them
WIDTH, HEIGHT = 320, 240
ROOM_LIGHT = "point:2.61,2.23,2.41"
# Sees no two faces in one plane, which a depth buffer cannot tell apart.
CAMERA = "0.2,0.25,2.3,4,2.0,0.2"
TECHNIQUES = [
    "fragments",
    "stencil-standard",
    "stencil-zfail",
    "stencil-hybrid",
    "stencil-kolic",
    "shadow-texture",
    "shadow-map",
]


def read_png(path):
    """(width, height, pixels), each pixel a bytes of red, green, blue."""
    with open(path, "rb") as png:
        content = png.read()
    assert content[:8] == b"\x89PNG\r\n\x1a\n", path
    at, data = 8, b""
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at : at + 8])
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlaced = struct.unpack(
                ">IIBBBBB", content[at + 8 : at + 21]
            )
            assert (depth, colour, interlaced) == (8, 6, 0), path
        if kind == b"IDAT":
            data += content[at + 8 : at + 8 + length]
        at += 12 + length
    raw, row_size, pixels = zlib.decompress(data), 4 * width, []
    above = bytearray(row_size)
    for y in range(height):
        kind, row = raw[y * (row_size + 1)], bytearray(
            raw[y * (row_size + 1) + 1 : (y + 1) * (row_size + 1)]
        )
        for i in range(row_size) if kind else ():
            left, up, corner = (
                (row[i - 4] if i >= 4 else 0),
                above[i],
                (above[i - 4] if i >= 4 else 0),
            )
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            else:
                slope = left + up - corner
                guess = min(
                    (abs(slope - left), 0, left),
                    (abs(slope - up), 1, up),
                    (abs(slope - corner), 2, corner),
                )[2]
            row[i] = (row[i] + guess) & 255
        pixels += [bytes(row[i : i + 3]) for i in range(0, row_size, 4)]
        above = row
    return width, height, pixels


def share_that_differs(a, b, by=2):
    assert a[:2] == b[:2], (a[:2], b[:2])
    return sum(
        max(abs(p - q) for p, q in zip(x, y)) > by for x, y in zip(a[2], b[2]) if x != y
    ) / len(a[2])


def pixel_of(point, camera=CAMERA, fov=60):
    """Where a point is in the picture: for aiming the mouse."""
    numbers = [float(n) for n in camera.split(",")]
    eye, target = numbers[:3], numbers[3:6]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def dot(a, b):
        return sum(p * q for p, q in zip(a, b))

    def unit(a):
        return [p / dot(a, a) ** 0.5 for p in a]

    back = unit([e - t for e, t in zip(eye, target)])
    right = unit(cross([0, 0, 1], back))
    up = cross(back, right)
    way = [p - e for p, e in zip(point, eye)]
    scale = HEIGHT / (2 * math.tan(math.radians(fov) / 2)) / -dot(way, back)
    return round(WIDTH / 2 + scale * dot(way, right)), round(HEIGHT / 2 - scale * dot(way, up))


class Server:
    """An X server on a display number that was free, and its keyboard and mouse."""

    def __init__(self, *arguments):
        reading, writing = os.pipe()
        self.process = subprocess.Popen(
            [
                "Xvfb",
                "-displayfd",
                str(writing),
                "-screen",
                "0",
                "1280x1024x24",
                "-nolisten",
                "tcp",
                *arguments,
            ],
            pass_fds=(writing,),
            stderr=subprocess.DEVNULL,
        )
        os.close(writing)
        with os.fdopen(reading) as number:
            self.name = ":" + number.readline().strip()
        self.display = display.Display(self.name)

    def end(self):
        self.process.terminate()
        self.process.wait()

    def input(self, kind, detail=0, x=0, y=0):
        xtest.fake_input(self.display, kind, detail, x=x, y=y)
        self.display.sync()

    def code(self, key):
        return self.display.keysym_to_keycode(XK.string_to_keysym(key))

    def windows(self, below=None):
        for window in (below or self.display.screen().root).query_tree().children:
            yield window
            yield from self.windows(window)

    def title(self, window):
        text = window.get_full_property(self.display.intern_atom("_NET_WM_NAME"), X.AnyPropertyType)
        return text.value.decode() if text else ""


class Window(unittest.TestCase):
    """Starts the window, and works its keys and its mouse."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server()

    @classmethod
    def tearDownClass(cls):
        cls.server.display.close()
        cls.server.end()

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="shadowcut-view-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.program = None

    def environment(self, **changes):
        variables = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        sanitizer = (
            variables.get("ASAN_OPTIONS", "") + ":detect_leaks=0"
        )  # what libraries of the display that are unloaded leave behind
        variables.update(LIBGL_ALWAYS_SOFTWARE="1", ASAN_OPTIONS=sanitizer, **changes)
        return variables

    def start(self, *arguments, says="shadowcut - ", server=None):
        server = server or self.server
        self.program = subprocess.Popen(
            [PROGRAM, "view", "--size", f"{WIDTH}x{HEIGHT}", *arguments],
            cwd=self.folder,
            text=True,
            stderr=subprocess.PIPE,
            env=self.environment(DISPLAY=server.name),
        )
        self.addCleanup(self.program.stderr.close)
        self.addCleanup(self.program.wait)
        self.addCleanup(self.program.kill)

        def shown():
            for window in server.windows():
                if server.title(window).startswith(says) and server.title(window).endswith(
                    tuple(TECHNIQUES)
                ):
                    return window
            return None

        self.window = self.wait_for(shown, "the window with its first picture")
        self.point(WIDTH // 2, HEIGHT // 2)

    def wait_for(self, condition, what):
        start = time.monotonic()
        while time.monotonic() - start < PATIENCE:
            answer = condition()
            if answer:
                return answer
            if self.program.poll() is not None:
                self.fail(
                    f"the program ended with {self.program.returncode} before {what}: "
                    + self.program.stderr.read()
                )
            time.sleep(0.02)
        self.fail("waited too long for " + what)

    def ends(self, status=0, says=""):
        """Waits for the end of the program; nothing may be on stderr, or one line that says so."""
        self.assertEqual(self.program.wait(PATIENCE), status)
        text = self.program.stderr.read()
        if not says:
            self.assertEqual(text, "")
        else:
            self.assertEqual(len(text.splitlines()), 1, text)
            self.assertIn(says, text)

    def press(self, *keys):
        for key in keys:
            self.server.input(X.KeyPress, self.server.code(key))
            self.server.input(X.KeyRelease, self.server.code(key))

    def point(self, x, y):
        where = self.server.display.screen().root.translate_coords(self.window, 0, 0)
        self.server.input(X.MotionNotify, x=where.x + x, y=where.y + y)

    def button(self, down, number=1):
        self.server.input(X.ButtonPress if down else X.ButtonRelease, number)

    def drag(self, start, end, let_go=True):
        self.point(*start)
        self.button(True)
        for k in range(1, 9):
            self.point(*(round(s + (e - s) * k / 8) for s, e in zip(start, end)))
        if let_go:
            self.button(False)

    def screenshot(self, key="F12"):
        number = len([name for name in os.listdir(self.folder) if name.endswith(".png")]) + 1
        path = os.path.join(self.folder, f"shadowcut-{number:03}.png")
        self.press(key)
        self.wait_for(lambda: os.path.exists(path), path)
        return read_png(path)

    def rendered(self, *arguments):
        path = os.path.join(self.folder, "rendered.png.out")
        subprocess.run(
            [
                PROGRAM,
                "render",
                *arguments,
                "--size",
                f"{WIDTH}x{HEIGHT}",
                "--quiet",
                "-o",
                path[:-4],
            ],
            check=True,
            timeout=PATIENCE,
            env=self.environment(),
        )
        os.rename(path[:-4], path)  # not counted among the window's
        return read_png(path)

    def start_room(self, *arguments):
        self.start(
            os.path.join(DATA, "room1.obj"),
            "--light",
            ROOM_LIGHT,
            "--camera",
            CAMERA,
            *arguments,
            says="shadowcut - room1.obj - ",
        )

    @staticmethod
    def limit(technique):
        """The share of pixels in which a technique's picture may differ from the fragments'.

        At edges, as wide as a map's or texture's pixels.
        """
        return 0.02 if technique.startswith("shadow-") else 0.005

    def switch_to(self, technique):
        self.press(str(TECHNIQUES.index(technique) + 1))
        self.wait_for(lambda: self.server.title(self.window).endswith(" - " + technique), technique)

    def close_by_its_button(self):
        atom = self.server.display.intern_atom
        self.window.send_event(
            event.ClientMessage(
                window=self.window,
                client_type=atom("WM_PROTOCOLS"),
                data=(32, [atom("WM_DELETE_WINDOW"), X.CurrentTime, 0, 0, 0]),
            )
        )
        self.server.display.sync()


def main():
    del sys.argv[1:3]
    unittest.main()
