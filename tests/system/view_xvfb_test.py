"""Drives the window as a person would, with keys and a mouse on an X server of its own.

    view_xvfb_test.py PROGRAM DATA_FOLDER

Nothing is decided by how long something takes: keys are handled in the order in which they are
pressed, and a picture that was asked for is waited for.
"""
import os
import shutil
import subprocess
import sys
import time

from Xlib import X

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from view_window import (
    CAMERA,
    DATA,
    HEIGHT,
    PATIENCE,
    PROGRAM,
    ROOM_LIGHT,
    Server,
    TECHNIQUES,
    WIDTH,
    Window,
    pixel_of,
    share_that_differs,
    main,
)


class View(Window):
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
            # However short the key is held and however slow the machine: until the picture has
            # changed.
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
        # An unmapped window is a minimised one; the window comes back as it was, and can be closed
        # as it is.
        self.window.unmap()
        self.server.display.sync()
        self.window.map()
        self.server.display.sync()
        self.assertEqual(share_that_differs(first, self.screenshot(), by=0), 0)
        self.close_by_its_button()
        self.ends()

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
    main()
