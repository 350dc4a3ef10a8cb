#!/usr/bin/env python3
"""Writes docs/papers.md and its chart:

    bench/papers_report.py papers.json edits.json joining.json image_space.json \\
      docs/papers.md docs/growth.svg

The printed figures are those of M. Slater, "A comparison of three shadow volume algorithms" (1992),
tables 1 to 3, and of Y. Chrysanthou and M. Slater, "Shadow volume BSP trees for computation of
shadows in dynamic scenes" (1995), tables 1 and 2. Ours come from shadowcut_bench_papers,
shadowcut_bench_edits and shadowcut_bench_joining. Whether a conclusion of theirs holds is decided
here, from the figures. The papers that draw with graphics hardware are image_space_report.py's.
"""
import json
import math
import sys

import image_space_report
import markdown
from plot import GRID, SOFT, Axis, count_text, decades, line, mark, path, text, time_text
from tables import ms, percent, ratio, rows_of, verdict

# Slater 1992, table 1: N, lights, polygons after the BSP, seconds of basic, tiling, SVBSP.
SLATER_ROOMS = [
    (138, 1, 228, 0.6, 0.8, 1.2),
    (174, 1, 308, 0.8, 0.9, 1.3),
    (192, 1, 358, 1.4, 1.2, 1.7),
    (210, 1, 412, 1.0, 1.1, 1.4),
    (228, 1, 438, 1.6, 1.3, 1.7),
    (264, 1, 542, 1.8, 1.5, 1.9),
    (246, 1, 614, 2.7, 1.8, 2.4),
    (264, 1, 668, 2.4, 1.7, 2.2),
    (282, 1, 694, 3.1, 2.0, 2.5),
    (318, 1, 798, 3.5, 2.1, 2.6),
    (138, 2, 228, 2.5, 2.6, 4.0),
    (174, 2, 308, 3.2, 3.2, 4.7),
    (192, 2, 358, 5.8, 4.9, 6.3),
    (210, 2, 412, 4.3, 3.9, 4.8),
    (228, 2, 438, 6.8, 5.5, 7.0),
    (264, 2, 542, 8.2, 6.3, 7.0),
    (246, 2, 614, 10.8, 7.9, 9.6),
    (264, 2, 668, 9.4, 7.0, 8.3),
    (282, 2, 694, 12.2, 8.7, 10.4),
    (318, 2, 798, 14.0, 9.6, 10.7),
]
# Tables 2 and 3: N, after the BSP, seconds, and polygons put out, of basic, tiling, SVBSP.
SLATER_TETRAHEDRA = [
    (65, 83, (0.2, 0.3, 0.4), (158, 158, 178)),
    (257, 299, (1.9, 1.6, 1.6), (649, 649, 773)),
    (1025, 1135, (21.3, 10.8, 7.3), (2672, 2672, 3268)),
]
# Chrysanthou and Slater 1995, table 1: initial, after the BSP; seconds and shadow polygons of
# S-SVBSP, U-SVBSP after BSP, U-SVBSP.
CS95 = [
    (133, 178, (0.46, 332), (0.45, 237), (0.28, 172)),
    (211, 286, (0.72, 526), (0.74, 384), (0.51, 292)),
    (313, 579, (1.25, 892), (1.16, 677), (0.63, 389)),
    (745, 1830, (4.65, 3820), (3.70, 2458), (1.51, 1063)),
]
# Table 2, second row of each scene: first and next move, percent of a rebuild of the unordered and
# of the ordered tree.
CS95_MOVES = {
    "room:1 computer": (12, 9, 7, 5),
    "room:2 computer": (14, 6, 10, 4),
    "room:2 bookcase": (37, 18, 26, 13),
    "room:3 computer": (8, 5, 4, 2),
    "room:4 computer": (8, 3, 3, 1),
    "room:4 computer and desk": (11, 5, 3, 2),
}

OURS = ("basic", "tiling", "svbsp")
GROWING = (  # name in the rows, in the chart, colour, mark
    ("brute", "brute force", "#8a5a44", "square"),
    ("tiling", "shadow tiling", "#b5832a", "triangle"),
    ("ordered", "ordered SVBSP", "#1b6ca8", "diamond"),
    ("unordered", "unordered SVBSP (ours)", "#c0392b", "circle"),
    ("clipper", "Clipper, face by face", "#6b6b6b", "square"),
    ("rays", "Embree, 256 rays a face", "#3a8f5c", "triangle"),
    ("cgal", "CGAL, exact", "#7d4fa0", "diamond"),
)


# ---- Slater 1992


def slater_rooms(report):
    rooms = [r for r in report["slater1992"] if r["scene"].startswith("slater")]
    yield "### Table 1: rooms\n"
    yield (
        "Seconds there, milliseconds here; then each algorithm as a share of basic in the same "
        "row.\n"
    )
    rows = []
    for ours, (n, lights, after, *theirs) in zip(rooms, SLATER_ROOMS):
        times = [ours[k]["shadow_ms"] for k in OURS]
        rows.append(
            (
                n,
                ours["basic"]["faces_in"],
                lights,
                after,
                ours["basic"]["faces_after_bsp"],
                " ".join(map(str, theirs)),
                " ".join(map(ms, times)),
                " ".join(ratio(t / theirs[0]) for t in theirs[1:]),
                " ".join(ratio(t / times[0]) for t in times[1:]),
                ms(ours["engine"]["shadow_ms"]),
            )
        )
    yield from rows_of(
        (
            "N",
            "ours",
            "lights",
            "after BSP",
            "ours",
            "basic, tiling, SVBSP: theirs, s",
            "ours, ms",
            "tiling, SVBSP / basic: theirs",
            "ours",
            "engine, ms",
        ),
        rows,
    )
    yield ""
    one = [(o, t) for o, t in zip(rooms, SLATER_ROOMS) if t[1] == 1]
    first, last = one[0], one[-1]
    growth = [last[0][k]["shadow_ms"] / first[0][k]["shadow_ms"] for k in OURS]
    printed = [last[1][i] / first[1][i] for i in (3, 4, 5)]
    yield from verdict(
        "Basic grows faster than the other two.",
        growth[0] > max(growth[1:]),
        f"From the smallest room to the largest, one light: {', '.join(map(ratio, printed))} "
        "times there, "
        f"{', '.join(map(ratio, growth))} times here (basic, tiling, SVBSP).",
    )
    tiling_first = sum(o["tiling"]["shadow_ms"] < o["svbsp"]["shadow_ms"] for o in rooms)
    best = min(
        (r for r in report["resolutions"] if r["scene"] == "slater10"), key=lambda r: r["shadow_ms"]
    )
    yield from verdict(
        "Tiling is consistently a little faster than the SVBSP tree.",
        tiling_first == len(rooms),
        f"Here it is faster in {tiling_first} of {len(rooms)} rows.",
        "His SVBSP tree paid for allocating nodes one by one, ours takes them from one "
        "array; and 128 x 128 tiles, his best, cost "
        f"more to fill and read today than the plane tests they save: with {best['tiles']} x "
        f"{best['tiles']} the largest room takes "
        f"{ms(best['shadow_ms'])} ms in place of {ms(rooms[9]['tiling']['shadow_ms'])}, the "
        "SVBSP tree "
        f"{ms(rooms[9]['svbsp']['shadow_ms'])}.",
    )


def slater_tetrahedra(report):
    made = [r for r in report["slater1992"] if r["scene"].startswith("tetrahedron")]
    yield "\n### Tables 2 and 3: the recursive tetrahedron\n"
    yield (
        "Polygons put out: those of the BSP and the shadows on them (basic and tiling: "
        "overlapping, one for each pair; SVBSP: its fragments). "
        "Ours needs no split in the BSP, because the parts touch in vertices to the bit.\n"
    )
    rows = []
    put_out = []
    for ours, (n, after, times, counts) in zip(made, SLATER_TETRAHEDRA):
        mine = [ours[k]["shadow_ms"] for k in OURS]
        polygons = [
            ours["basic"]["faces_after_bsp"] + ours["basic"]["shadow_polygons"],
            ours["tiling"]["faces_after_bsp"] + ours["tiling"]["shadow_polygons"],
            ours["svbsp"]["faces_after_bsp"] + ours["svbsp"]["shadowed_fragments"],
        ]
        put_out.append(polygons)
        rows.append(
            (
                n,
                ours["basic"]["faces_in"],
                after,
                ours["basic"]["faces_after_bsp"],
                " ".join(map(str, times)),
                " ".join(map(ms, mine)),
                " ".join(map(str, counts)),
                " ".join(map(str, polygons)),
                ours["engine"]["shadowed_fragments"],
                ms(ours["engine"]["shadow_ms"]),
            )
        )
    yield from rows_of(
        (
            "N",
            "ours",
            "after BSP",
            "ours",
            "basic, tiling, SVBSP: theirs, s",
            "ours, ms",
            "put out: theirs",
            "ours",
            "engine: shadowed, reunited",
            "engine, ms",
        ),
        rows,
    )
    yield ""
    large = made[-1]
    yield from verdict(
        "With 1025 polygons the SVBSP tree is faster than tiling, and both are faster than basic.",
        large["svbsp"]["shadow_ms"] < large["tiling"]["shadow_ms"] < large["basic"]["shadow_ms"],
        "Basic, tiling, SVBSP: 21.3, 10.8, 7.3 s there, "
        + ", ".join(ms(large[k]["shadow_ms"]) for k in OURS)
        + " ms here.",
    )
    yield from verdict(
        "Basic and tiling make the same polygons, the SVBSP tree more.",
        all(p[0] == p[1] < p[2] for p in put_out),
        f"SVBSP over basic: {', '.join(ratio(c[3][2] / c[3][0]) for c in SLATER_TETRAHEDRA)} "
        "there, "
        f"{', '.join(ratio(p[2] / p[0]) for p in put_out)} here.",
    )
    growth = made[2]["svbsp"]["shadow_ms"] / made[1]["svbsp"]["shadow_ms"]
    yield (
        "- From 257 to 1025 polygons the SVBSP tree takes 4.6 times as long there, 6.1 times in "
        f"Chin and Feiner's paper, {growth:.1f} times here."
    )
    yield "\nTiles, and milliseconds of tiling:\n"
    scenes = sorted({r["scene"] for r in report["resolutions"]})
    sizes = sorted({r["tiles"] for r in report["resolutions"]})
    found = {(r["scene"], r["tiles"]): r["shadow_ms"] for r in report["resolutions"]}
    yield from rows_of(
        ("scene", *[f"{n} x {n}" for n in sizes]),
        [(s, *[ms(found[s, n]) for n in sizes]) for s in scenes],
    )


# ---- Chrysanthou and Slater 1995


def cs95_builds(report):
    yield "\n### Table 1: building\n"
    yield (
        "Time, and shadow polygons, as shares of the ordered tree's (S-SVBSP). Shadow "
        "polygons here are fragments as they lie in the tree, "
        "shadowed; beside them, what is left of them when those of one face and one state "
        "are reunited.\n"
    )
    rows, shares = [], []
    names = ("u_svbsp_after_bsp", "u_svbsp")
    for ours, (n, after, standard, *theirs) in zip(report["cs95"], CS95):
        base = ours["s_svbsp"]
        time = [ours[k]["shadow_ms"] / base["shadow_ms"] for k in names]
        polygons = [ours[k]["shadowed_fragments"] / base["shadowed_fragments"] for k in names]
        shares.append((time, polygons))
        rows.append(
            (
                ours["scene"],
                n,
                base["faces_in"],
                after,
                base["faces_after_bsp"],
                f"{standard[0]} s, {standard[1]}",
                f"{ms(base['shadow_ms'])} ms, {base['shadowed_fragments']} "
                f"({ours['s_svbsp_reunited']['shadowed_fragments']})",
                *[f"{ratio(t / standard[0])}, {ratio(p / standard[1])}" for t, p in theirs],
                *[
                    f"{ratio(t)}, {ratio(p)} ({ours[k + '_reunited']['shadowed_fragments']})"
                    for t, p, k in zip(time, polygons, names)
                ],
            )
        )
    yield from rows_of(
        (
            "scene",
            "polygons",
            "ours",
            "after BSP",
            "ours",
            "S-SVBSP: theirs",
            "ours",
            "U after BSP: theirs",
            "U: theirs",
            "U after BSP: ours",
            "U: ours",
        ),
        rows,
    )
    yield ""
    yield from verdict(
        "On the scene BSP's polygons the unordered tree takes no more time to build than the "
        "ordered one.",
        all(t[0] <= 1.05 for t, _ in shares),
        f"Here {', '.join(ratio(t[0]) for t, _ in shares)} of its time.",
        "The engine's time holds what the ordered tree does without: sorting by solid angle, "
        "error bounds, areas and ids of fragments.",
    )
    yield from verdict(
        "It results in fewer shadow polygons.",
        all(p[0] < 1 for _, p in shares),
        f"Here {', '.join(ratio(p[0]) for _, p in shares)} of them.",
    )
    yield from verdict(
        "Without the scene BSP it is faster still, and makes fewer.",
        all(t[1] < t[0] and p[1] < p[0] for t, p in shares),
        f"Here {', '.join(ratio(t[1]) for t, _ in shares)} of the ordered tree's time and "
        f"{', '.join(ratio(p[1]) for _, p in shares)} of "
        "its shadow polygons.",
    )


def cs95_moves(report, edits):
    yield "\n### Table 2: moving\n"
    yield (
        "Medians of many moves, as shares of a rebuild of the unordered tree, and of the "
        "ordered tree's (through the ratio of both in table 1). "
        "Ours hand out what changed. An update of ours is compared with a rebuild that is "
        "about a thousand times as fast as theirs.\n"
    )
    builds = {
        r["scene"]: r["u_svbsp_reunited"]["shadow_ms"] / r["s_svbsp"]["shadow_ms"]
        for r in report["cs95"]
    }
    rows, below = [], 0
    moves = [r for r in edits["rows"] if r["group"] == "table2"]
    for row in moves:
        first, following, first_standard, next_standard = CS95_MOVES[row["name"]]
        to_standard = builds[row["name"].split()[0].replace(":", "")]
        below += 100 * row["next_share"] < following
        rows.append(
            (
                row["name"],
                f"{row['moved_faces']} of {row['faces']}",
                f"{first} %, {following} %",
                f"{percent(row['first_share'])}, {percent(row['next_share'])}",
                f"{first_standard} %, {next_standard} %",
                f"{percent(row['first_share'] * to_standard)}, "
                f"{percent(row['next_share'] * to_standard)}",
                ms(row["next"]["update_ms"]["median"]),
            )
        )
    yield from rows_of(
        (
            "scene, object",
            "faces",
            "of U, first, next: theirs",
            "ours",
            "of S, first, next: theirs",
            "ours",
            "next, ms",
        ),
        rows,
    )
    yield ""
    yield from verdict(
        "Next moves take less than first moves.",
        all(r["next_share"] < r["first_share"] for r in moves),
        "",
    )
    yield from verdict(
        "Ours are a smaller share of a rebuild than theirs.",
        below == len(moves),
        f"In {below} of {len(moves)} rows.",
        "A rebuild here costs little more a face than an update does: cells of the tree are "
        "small, there is no scene BSP and no "
        "allocation; while an update also takes out what was there, keeps location lists, "
        "and lists what is gone and new. In large "
        "scenes the share falls with the size (docs/speed.md): 0.01 % in a city of 10 000 "
        "buildings.",
    )


def joining(report):
    yield "\n### Section 3.2: joining subtrees\n"
    yield (
        "Their tree as printed (src/compare/published_tree.hpp), and the move of one object, "
        "out and in again: joined by their filter of shadow "
        "volumes, by the general merge of BSP trees (Naylor, Amanatides, Thibault 1990) that "
        "they found \"very slow\", or taken to pieces and "
        "inserted again. The tree only; the engine's update, beside them, hands out "
        "fragments and areas too. First moves: median (mean), ms. "
        "Size: of the tree after all moves, of a fresh one's.\n"
    )
    rows, medians, means = [], [], []
    for row in report["rows"]:
        way = {w["joining"]: w for w in row["ways"]}
        first = {k: w["first"] for k, w in way.items()}
        medians.append(first["merge"]["median_ms"] / first["filter"]["median_ms"])
        means.append((first["merge"]["mean_ms"] / first["filter"]["mean_ms"], row["scene"]))
        rows.append(
            (
                row["scene"],
                row["polygons"],
                *[
                    f"{ms(first[k]['median_ms'])} ({ms(first[k]['mean_ms'])})"
                    for k in ("filter", "merge", "reinsert", "engine")
                ],
                " / ".join(ms(way[k]["next"]["median_ms"]) for k in ("filter", "merge", "engine")),
                percent(way["filter"]["next"]["median_ms"] / way["filter"]["build_ms"]),
                " / ".join(ratio(way[k]["growth"]) for k in ("filter", "merge")),
            )
        )
    yield from rows_of(
        (
            "scene",
            "polygons",
            "filter",
            "merge",
            "insert again",
            "engine",
            "next: filter / merge / engine",
            "next, filter: of its build",
            "size: filter / merge",
        ),
        rows,
    )
    yield ""
    yield from verdict(
        "The general merge is slower than their filter.",
        min(medians) > 1,
        f"Merge over filter, first moves: {ratio(min(medians))} to {ratio(max(medians))} by "
        f"the median, {ratio(min(means)[0])} ({min(means)[1]}) to "
        f"{ratio(max(means)[0])} ({max(means)[1]}) by the mean.",
    )
    yield (
        "- Why: it visits fewer nodes, but every step clips and splits a plane that has to "
        "be bounded to its region first. Where shadow volumes overlap much, "
        "the filter must cut them open and send every piece down again, and there the merge "
        "is the faster one, at the price of a larger tree. Very "
        "slow then, it is within a factor of three now."
    )


# ---- growth


def exponent(points):
    """Least squares through the larger half of the points, at least three, as powers of the number
    of faces.
    """
    points = sorted(points)[-max(3, len(points) // 2) :]
    if len(points) < 3:
        return None
    xs, ys = [math.log(n) for n, _ in points], [math.log(t) for _, t in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def total(row):
    return row["order_ms"] + row["shadow_ms"]


def points_of(report, family, algorithm):
    return [
        (r["faces"], total(r))
        for r in report["growth"]
        if r["family"] == family and r["algorithm"] == algorithm
    ]


def families(report):
    return list(dict.fromkeys(r["family"] for r in report["growth"]))


def growth_tables(report):
    yield "\n## Growth\n"
    yield (
        "Everything included: scene BSP (best of eight candidates), order, shadows. Each "
        "algorithm goes on to scenes of twice the size (the "
        "tetrahedron: four times) until one takes over ten seconds. The largest scene done, "
        "its time, and the exponent fitted to the larger "
        "half of the sizes.\n"
    )
    yield "![time against the number of faces](growth.svg)\n"
    rows = []
    for key, name, _, _ in GROWING:
        cells = []
        for family in families(report):
            points = points_of(report, family, key)
            power = exponent(points)
            cells.append(
                f"{count_text(points[-1][0])} faces, {ms(points[-1][1])} ms, n^{power:.2f}"
                if power
                else "-"
            )
        rows.append((name, *cells))
    yield from rows_of(("algorithm", *families(report)), rows)
    yield (
        "\nThe larger scenes differ in more than size: a city's shadows overlap no more when "
        "it grows, the tetrahedron's and the triangles' do, "
        "and there the fragments themselves grow faster than the faces. Rays sample: 256 a "
        "face leave a mean error (docs/accuracy.md); Clipper "
        "rounds to 2^-30 of each face, and gives areas and outlines but no convex fragments."
    )


WIDTH, HEIGHT, TOP, BOTTOM, LEFT, GAP, PANEL = 1240, 470, 60, 66, 74, 52, 270


def short(count):
    return (
        f"{count / 1e6:g} M"
        if count >= 1e6
        else f"{count / 1e3:g} k"
        if count >= 1e3
        else f"{count:g}"
    )


def panel(report, family, left, y, first):
    right = left + PANEL
    points = [p for key, *_ in GROWING for p in points_of(report, family, key)]
    x = Axis(*decades([n for n, _ in points]), left, right)
    for value, is_major in x.ticks():
        yield line(x(value), TOP, x(value), HEIGHT - BOTTOM, GRID, 1 if is_major else 0.4)
        if is_major:
            yield text(x(value), HEIGHT - BOTTOM + 18, short(value), "middle", 11.5, SOFT)
    for value, is_major in y.ticks():
        yield line(left, y(value), right, y(value), GRID, 1 if is_major else 0.4)
        if is_major and first:
            yield text(left - 8, y(value) + 4, time_text(value), "end", 12, SOFT)
    yield (
        f'<rect x="{left}" y="{TOP}" width="{PANEL}" height="{HEIGHT - TOP - BOTTOM}" '
        f'fill="none" stroke="{SOFT}"/>'
    )
    yield text((left + right) / 2, TOP - 8, family, "middle", 14, more=' font-weight="bold"')
    for key, _, colour, shape in GROWING:
        places = [(x(n), y(t)) for n, t in sorted(points_of(report, family, key))]
        yield path(places, colour)
        for px, py in places:
            yield mark(shape, px, py, colour, 3.6)


def chart(report):
    times = [total(r) for r in report["growth"]]
    y = Axis(*decades(times), HEIGHT - BOTTOM, TOP)
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
        f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">'
    )
    yield f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
    yield text(
        LEFT, 26, "Time to find all shadows, against the number of faces (one thread)", size=17
    )
    for k, family in enumerate(families(report)):
        yield from panel(report, family, LEFT + k * (PANEL + GAP), y, k == 0)
    yield text(LEFT + 1.5 * PANEL + GAP, HEIGHT - 16, "faces", "middle", 14)
    column, at = LEFT + 3 * (PANEL + GAP), TOP + 10
    for _, name, colour, shape in GROWING:
        yield line(column, at, column + 30, at, colour, 2) + mark(
            shape, column + 15, at, colour, 3.6
        )
        yield text(column + 38, at + 4.5, name, size=12.5)
        at += 26
    yield "</svg>"


def page(report, edits, joins, image_space):
    yield "# The papers' tables, made again\n"
    yield (
        "Written by bench/papers_report.py from bench/baseline/papers.json "
        "(`shadowcut_bench_papers`) and bench/baseline/edits.json "
        "(`shadowcut_bench_edits`) and bench/baseline/joining.json "
        "(`shadowcut_bench_joining`). Their machines were a SPARCstation 1+ and 2, so times "
        "compare only as ratios between algorithms; "
        "polygon counts compare as counts. The rooms are ours, with the papers' numbers of "
        "polygons and kinds of furniture; the tetrahedron "
        "is a public definition. All algorithms find the same lit area of every face: "
        "tests/system/published_algorithms_test.cpp holds each against the exact "
        "oracle. How each departs from its paper stands at the top of its file in src/compare.\n"
    )
    yield "## Slater 1992: basic, tiling, SVBSP\n"
    yield from slater_rooms(report)
    yield from slater_tetrahedra(report)
    yield "\n## Chrysanthou and Slater 1995: ordered and unordered tree"
    yield from cs95_builds(report)
    yield from cs95_moves(report, edits)
    yield from joining(joins)
    yield from growth_tables(report)
    yield from image_space_report.page(image_space)


def load(name):
    with open(name, encoding="utf-8") as text_in:
        return json.load(text_in)


def write(name, lines):
    content = "\n".join(lines) + "\n"
    if name.endswith(".md"):
        content = markdown.wrap(content)
    with open(name, "w", encoding="utf-8") as out:
        out.write(content)


def main():
    report, edits, joins, image_space = (load(name) for name in sys.argv[1:5])
    write(sys.argv[5], page(report, edits, joins, image_space))
    write(sys.argv[6], chart(report))


if __name__ == "__main__":
    main()
