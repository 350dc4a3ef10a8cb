#!/usr/bin/env python3
"""Draws docs/updates.svg, the time of an update against the size of the scene:

    bench/edits_plot.py bench/baseline/edits.json docs/updates.svg

Both axes are logarithmic. For cities and for spheres: the full rebuild, and the next move of one
object: its median, with a bar up to the 99.9th percentile.
"""
import json
import sys

from plot import GRID, SOFT, Axis, count_text, decades, line, path, text, time_text

WIDTH, HEIGHT = 900, 560
LEFT, RIGHT, TOP, BOTTOM = 86, 236, 56, 70
SERIES = (  # group, name of what moves, colour
    ("city", "one building of a city", "#1b6ca8"),
    ("spheres", "one sphere of many", "#b5532a"),
)


def grid(x, y):
    for value, is_major in x.ticks():
        at = x(value)
        yield line(at, TOP, at, HEIGHT - BOTTOM, GRID, 1 if is_major else 0.4)
        if is_major:
            yield text(at, HEIGHT - BOTTOM + 20, count_text(value), "middle", colour=SOFT)
    for value, is_major in y.ticks():
        at = y(value)
        yield line(LEFT, at, WIDTH - RIGHT, at, GRID, 1 if is_major else 0.4)
        if is_major:
            yield text(LEFT - 9, at + 4.5, time_text(value), "end", colour=SOFT)
    yield (
        f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH - LEFT - RIGHT}" '
        f'height="{HEIGHT - TOP - BOTTOM}" fill="none" stroke="{SOFT}"/>'
    )
    yield text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 22, "faces turned to the light", "middle", 14)
    middle = (TOP + HEIGHT - BOTTOM) / 2
    yield text(
        24,
        middle,
        "time (steady clock)",
        "middle",
        14,
        more=f' transform="rotate(-90 24 {middle:.1f})"',
    )


def curves(rows, x, y, colour):
    rebuild = [(x(r["facing_faces"]), y(r["rebuild_ms"]["median"])) for r in rows]
    update = [(x(r["facing_faces"]), y(r["next"]["update_ms"]["median"])) for r in rows]
    yield path(rebuild, colour, ' stroke-dasharray="7 4"')
    for px, py in rebuild:
        yield (
            f'<rect x="{px - 3.5:.1f}" y="{py - 3.5:.1f}" width="7" height="7" fill="white" '
            f'stroke="{colour}" stroke-width="1.6"/>'
        )
    for (px, py), r in zip(update, rows):
        top = y(r["next"]["update_ms"]["p999"])
        yield line(px, py, px, top, colour, 1.2) + line(px - 4, top, px + 4, top, colour, 1.2)
    yield path(update, colour)
    for px, py in update:
        yield f'<circle cx="{px:.1f}" cy="{py:.1f}" r="4.2" fill="{colour}"/>'


def legend(shown):
    at, column = TOP + 12, WIDTH - RIGHT + 22
    for _, name, colour in shown:
        yield text(column, at, name, size=13.5, more=' font-weight="bold"')
        yield line(column, at + 19, column + 34, at + 19, colour, 2, ' stroke-dasharray="7 4"')
        yield (
            f'<rect x="{column + 13.5}" y="{at + 15.5}" width="7" height="7" fill="white" '
            f'stroke="{colour}" stroke-width="1.6"/>'
        )
        yield text(column + 44, at + 24, "full rebuild")
        yield line(column, at + 42, column + 34, at + 42, colour, 2)
        yield f'<circle cx="{column + 17}" cy="{at + 42}" r="4.2" fill="{colour}"/>'
        yield text(column + 44, at + 47, "update after a move,")
        yield text(column + 44, at + 63, "median; bar: 99.9 %")
        at += 104


def draw(report):
    shown = [s for s in SERIES if any(r["group"] == s[0] for r in report["rows"])]
    chosen = {
        s[0]: sorted(
            (r for r in report["rows"] if r["group"] == s[0]), key=lambda r: r["facing_faces"]
        )
        for s in shown
    }
    rows = [r for group in chosen.values() for r in group]
    if not rows:
        sys.exit("no rows of cities or spheres")
    x = Axis(*decades([r["facing_faces"] for r in rows]), LEFT, WIDTH - RIGHT)
    times = [
        t
        for r in rows
        for t in (
            r["rebuild_ms"]["median"],
            r["next"]["update_ms"]["median"],
            r["next"]["update_ms"]["p999"],
        )
    ]
    y = Axis(*decades(times), HEIGHT - BOTTOM, TOP)
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
        f'viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif">'
    )
    yield f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
    yield text(LEFT, 32, "The cost of moving one object, against the size of the scene", size=17)
    yield from grid(x, y)
    for group, _, colour in shown:
        yield from curves(chosen[group], x, y, colour)
    yield from legend(shown)
    yield "</svg>"


def main():
    with open(sys.argv[1], encoding="utf-8") as text_in:
        picture = "\n".join(draw(json.load(text_in))) + "\n"
    with open(sys.argv[2], "w", encoding="utf-8") as out:
        out.write(picture)


if __name__ == "__main__":
    main()
