"""Drives the window as a person would, with keys and a mouse on an X server of its own: view_xvfb_test.py PROGRAM DATA_FOLDER.

Nothing is decided by how long something takes: keys are handled in the order in which they are pressed, and a picture that was asked for is
waited for.
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

PROGRAM = DATA = None
PATIENCE = 240  # seconds; only a failure takes them
WIDTH, HEIGHT = 320, 240
ROOM_LIGHT = "point:2.61,2.23,2.41"
CAMERA = "0.2,0.25,2.3,4,2.0,0.2"  # sees no two faces in one plane, which a depth buffer cannot tell apart
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


class View(unittest.TestCase):
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
                    f"the program ended with {self.program.returncode} before {what}: {self.program.stderr.read()}"
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
        """The share of pixels in which a technique's picture may differ from the fragments': at edges, as wide as a map's or texture's pixels."""
        return 0.02 if technique.startswith("shadow-") else 0.005

    def switch_to(self, technique):
        self.press(str(TECHNIQUES.index(technique) + 1))
        self.wait_for(lambda: self.server.title(self.window).endswith(" - " + technique), technique)

    # On the top of the desk, and where that goes.
    DESK, ELSEWHERE = (1.16, 0.7, 0.73), (2.0, 1.9, 0.73)

    def test_every_technique_shows_what_render_draws(self):
        self.start_room()
        pictures = {}
        for technique in TECHNIQUES[1:] + TECHNIQUES[:1]:
            self.switch_to(technique)
            pictures[technique] = self.screenshot()
            drawn = self.rendered(
                os.path.join(DATA, "room1.obj"),
                "--light",
                ROOM_LIGHT,
                "--camera",
                CAMERA,
                "--technique",
                technique,
            )
            self.assertLess(share_that_differs(pictures[technique], drawn), 0.0005, technique)
        for technique in TECHNIQUES:
            self.assertLess(
                share_that_differs(pictures["fragments"], pictures[technique]),
                self.limit(technique),
                technique,
            )
        self.press("Escape")
        self.ends()

    def test_an_object_is_dragged_put_back_removed_and_brought_back(self):
        for technique in ("fragments", "stencil-zfail"):
            self.start_room("--technique", technique)
            first = self.screenshot()
            start, end = pixel_of(self.DESK), pixel_of(self.ELSEWHERE)
            self.drag(start, end)
            moved = self.screenshot()
            self.assertGreater(share_that_differs(first, moved), 0.03)
            self.drag(end, start, let_go=False)
            self.assertGreater(share_that_differs(moved, self.screenshot()), 0.03)
            self.press("Escape")
            self.button(False)
            self.assertLess(share_that_differs(moved, self.screenshot()), 0.0005)
            self.press("Delete")
            removed = self.screenshot()
            self.assertGreater(share_that_differs(moved, removed), 0.03)
            self.press("u")
            self.assertLess(share_that_differs(moved, self.screenshot()), 0.0005)
            self.press("r")
            self.assertLess(share_that_differs(first, self.screenshot()), 0.0005)
            self.press("Escape")
            self.ends()

    def test_every_technique_follows_what_is_dragged(self):
        self.start_room()
        for technique in TECHNIQUES[1:]:
            self.switch_to(technique)
            before = self.screenshot()
            self.drag(pixel_of(self.DESK), pixel_of(self.ELSEWHERE))
            moved = self.screenshot()
            self.assertGreater(share_that_differs(before, moved), 0.03, technique)
            self.switch_to("fragments")
            self.assertLess(
                share_that_differs(self.screenshot(), moved), self.limit(technique), technique
            )
            self.press("r")
        self.press("Escape")
        self.ends()

    def test_lights_are_dragged_removed_and_brought_back_and_walls_hold_fast(self):
        camera = "0.3,1.2,0.9,3,2.4,1.7"
        self.start(
            os.path.join(DATA, "room1.obj"),
            "--light",
            ROOM_LIGHT,
            "--light",
            "point:1.2,3.6,2.2",
            "--camera",
            camera,
        )
        first = self.screenshot()
        start, end = pixel_of((2.61, 2.23, 2.41), camera), pixel_of((4.0, 2.23, 2.41), camera)
        self.drag(start, end)
        moved = self.screenshot()
        self.assertGreater(share_that_differs(first, moved), 0.02)
        self.drag((WIDTH // 2, HEIGHT - 20), (WIDTH // 2 + 60, HEIGHT - 60))
        self.assertEqual(share_that_differs(moved, self.screenshot(), by=0), 0)
        for technique in TECHNIQUES[1:] + TECHNIQUES[:1]:
            self.switch_to(technique)
            with_lamp = self.screenshot()
            self.assertLess(share_that_differs(moved, with_lamp), self.limit(technique), technique)
            self.point(*end)
            self.button(True)
            self.button(False)
            self.press("Delete")
            self.assertGreater(share_that_differs(with_lamp, self.screenshot()), 0.2, technique)
            self.press("Insert")
            self.assertLess(share_that_differs(with_lamp, self.screenshot()), 0.0005, technique)
        self.press("Escape")
        self.ends()

    def test_an_idle_window_does_nothing(self):
        self.start_room()
        self.screenshot()

        def rests():
            before = self.processor_time()
            time.sleep(0.3)
            return self.processor_time() == before

        self.wait_for(rests, "rest")
        self.window.unmap()
        self.server.display.sync()
        self.wait_for(rests, "rest of a hidden window")
        self.close_by_its_button()
        self.ends()

    def processor_time(self):
        with open(f"/proc/{self.program.pid}/stat", encoding="ascii") as stat:
            return sum(int(n) for n in stat.read().rsplit(")", 1)[1].split()[11:13])

    def test_walking_and_looking(self):
        self.start()
        first = self.screenshot()
        for key in ("w", "a", "s", "d", "q", "e", "Left", "Up"):
            # However short the key is held and however slow the machine: until the picture has changed.
            self.server.input(X.KeyPress, self.server.code(key))
            self.wait_for(
                lambda: share_that_differs(first, self.screenshot()) > 0.01,
                "the camera to follow " + key,
            )
            self.server.input(X.KeyRelease, self.server.code(key))
            self.press("Home")
            self.assertEqual(share_that_differs(first, self.screenshot(), by=0), 0, key)
        self.button(True, 3)
        self.point(WIDTH // 2 + 60, HEIGHT // 2 + 10)
        self.button(False, 3)
        turned = self.screenshot()
        self.assertGreater(share_that_differs(first, turned), 0.05)
        self.point(WIDTH // 2 - 20, HEIGHT // 2 - 30)
        self.assertEqual(share_that_differs(turned, self.screenshot(), by=0), 0)
        self.press("Escape")
        self.ends()

    def test_the_wind_blows_where_shadows_follow_it(self):
        self.start(
            os.path.join(DATA, "branch3.obj"),
            "--light",
            "point:1.13,-0.91,4.7",
            "--camera",
            "2.2,-2.4,2.6,0,0,0.9",
            "--technique",
            "stencil-kolic",
        )
        still = self.screenshot()
        for technique in ("stencil-kolic", "shadow-map"):
            self.switch_to(technique)
            self.press("v")
            self.wait_for(
                lambda: share_that_differs(still, self.screenshot()) > 0.01, "the branch to bend"
            )
            before = self.screenshot()
            self.wait_for(
                lambda: share_that_differs(before, self.screenshot()) > 0.002,
                "the branch to bend on",
            )
            self.press("v")
            self.assertLess(share_that_differs(still, self.screenshot()), self.limit("shadow-map"))
        self.press("v")
        self.switch_to("fragments")  # which no wind bends
        self.assertLess(share_that_differs(still, self.screenshot()), self.limit("fragments"))
        self.press("v")
        self.assertLess(share_that_differs(still, self.screenshot()), self.limit("fragments"))
        self.press("Escape")
        self.ends()

    def test_outlines_cells_and_the_overlay(self):
        self.start()  # no argument: the furnished room
        self.assertIn("furnished room", self.server.title(self.window))
        plain = self.screenshot()
        self.press("o")
        self.assertGreater(share_that_differs(plain, self.screenshot()), 0.01)
        self.press("o", "c")
        self.assertGreater(share_that_differs(plain, self.screenshot()), 0.3)
        self.press("c")
        self.assertEqual(share_that_differs(plain, self.screenshot(), by=0), 0)
        overlay = self.screenshot("p")
        self.assertGreater(share_that_differs(plain, overlay), 0.1)
        self.press("h")
        self.assertGreater(share_that_differs(overlay, self.screenshot("p")), 0.05)
        self.switch_to("shadow-map")
        self.press("o")
        self.assertGreater(share_that_differs(plain, self.screenshot()), 0.01)
        self.press("Escape")
        self.ends()

    def test_a_scene_without_a_light_gets_one(self):
        self.start(os.path.join(DATA, "room1.obj"))
        lit = self.screenshot()
        self.press("Delete")  # nothing is picked
        self.assertEqual(share_that_differs(lit, self.screenshot(), by=0), 0)
        colours = {p for p in lit[2]}
        self.assertGreater(len(colours), 50)  # ambient light alone gives each object one
        self.press("Escape")
        self.ends()

    def test_any_size(self):
        self.start_room()
        first = self.screenshot()
        for width, height in ((1, 1), (640, 200), (1, 300), (900, 700), (WIDTH, HEIGHT)):
            self.window.configure(width=width, height=height)
            self.server.display.sync()
            self.wait_for(
                lambda: self.screenshot()[:2] == (width, height), f"a picture of {width}x{height}"
            )
        self.assertEqual(share_that_differs(first, self.screenshot(), by=0), 0)
        # An unmapped window is a minimised one; it comes back as it was, and can be closed as it is.
        self.window.unmap()
        self.server.display.sync()
        self.window.map()
        self.server.display.sync()
        self.assertEqual(share_that_differs(first, self.screenshot(), by=0), 0)
        self.close_by_its_button()
        self.ends()

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

    def test_a_screenshot_that_cannot_be_written_ends_nothing(self):
        self.start_room()
        first = self.screenshot()
        shutil.rmtree(self.folder)
        self.press("F12")
        self.switch_to("stencil-zfail")  # handled after that
        os.mkdir(self.folder)
        self.press("Escape")
        self.ends()
        self.assertEqual(first[:2], (WIDTH, HEIGHT))

    def refused(self, *arguments, says, **changes):
        result = subprocess.run(
            [PROGRAM, "view", *arguments],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            cwd=self.folder,
            env=self.environment(**changes),
        )
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for word in says:
            self.assertIn(word, result.stderr)

    def test_what_is_missing_is_said_in_one_line(self):
        self.refused(says=["no display", "DISPLAY", "shadowcut render"])
        self.refused(DISPLAY=":98765", says=[":98765", "shadowcut render"])
        self.refused(DISPLAY=self.server.name, MESA_GL_VERSION_OVERRIDE="2.1", says=["OpenGL 3.3"])
        without_gl = Server("-extension", "GLX")
        self.refused(DISPLAY=without_gl.name, says=["OpenGL 3.3", "GLX"])
        without_gl.display.close()
        without_gl.end()
        on = {"DISPLAY": self.server.name}
        self.refused("--technique", "radiosity", says=["radiosity"], **on)
        self.refused("--size", "0x0", says=["--size"], **on)
        for size in ("100000x100000", "30000x20"):
            self.refused("--size", size, says=[size], **on)
        self.refused("--camera", "0,0,0,0,0,0", says=["camera"], **on)
        self.refused("none.obj", says=["none.obj"], **on)

    def test_a_display_that_goes_away_is_said_in_one_line(self):
        server = Server()
        self.start_on(server)
        server.end()
        self.ends(2, "display is gone")

    def start_on(self, server):
        ours, self.__class__.server = self.server, server
        try:
            self.start_room()
        finally:
            self.__class__.server = ours


if __name__ == "__main__":
    PROGRAM, DATA = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
