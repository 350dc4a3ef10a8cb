#!/usr/bin/env python3
"""Renders docs/drag.gif: a desk and the computer on it are dragged through a furnished room and
back, with the shadows of the technique `fragments`.

    scripts/animation.py [OUTPUT.gif]

Needs build/release/bin/shadowcut (scripts/run.sh builds the program) and ffmpeg.
"""

import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / 'build/release/bin/shadowcut'
SCENE = ROOT / 'data/room4.obj'
DRAGGED = {'desk.7', 'computer.10'}
LIGHT = 'point:5.3613,3.7171,2.43'
CAMERA = '0.9,1.5,2.4,4.9,3.9,0.1,56'
# The desk's way, in metres from where the desk stands, as a spline through these points.
WAY = [(0, 0), (0.35, -1.75), (1.55, -3.15), (3.2, -3.1)]
STEPS = 32  # frames of one way; the animation runs there and back
SIZE = (720, 440)
OVERSAMPLING = 2  # each frame is drawn larger by this and scaled down, against steps along edges
FRAMES_PER_SECOND = 20


def way_at(share):
    """A Catmull-Rom spline through WAY, slow at both ends."""
    share = (1 - math.cos(math.pi * share)) / 2
    segment = min(int(share * (len(WAY) - 1)), len(WAY) - 2)
    t = share * (len(WAY) - 1) - segment
    p = [WAY[max(0, min(len(WAY) - 1, segment + k))] for k in (-1, 0, 1, 2)]
    return tuple(
        0.5 * (2 * p[1][i] + (p[2][i] - p[0][i]) * t
               + (2 * p[0][i] - 5 * p[1][i] + 4 * p[2][i] - p[3][i]) * t * t
               + (3 * p[1][i] - p[0][i] - 3 * p[2][i] + p[3][i]) * t * t * t)
        for i in (0, 1))


def moved(scene, by):
    """The text of an OBJ file in which the dragged objects stand elsewhere.

    Faces of screens are left out: a screen lies in the plane of its computer, and a depth buffer
    cannot order two faces in one plane.
    """
    lines, dragged, is_screen = [], False, False
    for line in scene.splitlines():
        words = line.split()
        if words[:1] == ['o']:
            dragged = words[1] in DRAGGED
            is_screen = words[1].startswith('screen')
        if is_screen and words[:1] == ['f']:
            continue
        if dragged and words[:1] == ['v']:
            x, y, z = map(float, words[1:4])
            line = f'v {x + by[0]!r} {y + by[1]!r} {z!r}'
        lines.append(line)
    return '\n'.join(lines) + '\n'


def main():
    output = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / 'docs/drag.gif')
    for tool in (str(PROGRAM), 'ffmpeg'):
        if not shutil.which(tool):
            sys.exit(f'animation.py: {tool} is missing')
    scene = SCENE.read_text()
    drawn = 'x'.join(str(OVERSAMPLING * side) for side in SIZE)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for step in range(STEPS):
            (folder / 'scene.obj').write_text(moved(scene, way_at(step / (STEPS - 1))))
            subprocess.run(
                [PROGRAM, 'render', folder / 'scene.obj', '--technique', 'fragments',
                 '--light', LIGHT, '--camera', CAMERA, '--size', drawn, '--quiet',
                 '-o', folder / f'{step:03}.png'], check=True)
            # The way back, without the two ends.
            if 0 < step < STEPS - 1:
                shutil.copy(folder / f'{step:03}.png', folder / f'{2 * STEPS - 2 - step:03}.png')
        subprocess.run(
            ['ffmpeg', '-v', 'error', '-y', '-framerate', str(FRAMES_PER_SECOND),
             '-i', folder / '%03d.png', '-filter_complex',
             f'scale={SIZE[0]}:{SIZE[1]}:flags=area,split[a][b];'
             '[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=none:diff_mode=rectangle',
             '-loop', '0', output], check=True)
    print(f'{output}: {output.stat().st_size / 1e6:.2f} MB')


main()
