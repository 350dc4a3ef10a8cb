"""docs/papers.md's part of the papers that draw with graphics hardware.

bench/papers_report.py calls it.

The printed figures are those of H. Batagelo and I. Costa Junior, "Real-time shadow generation using
BSP trees and stencil buffers" (1999), tables 2 and 3, of I. Kolic, Z. Mihajlovic and L. Budin,
"Stencil shadow volumes for complex and deformable objects" (2004), table 1, and of K.-S. Oh and
B.-S. Shin, "An efficient method for dynamic shadow texture generation" (2005), section 4. Ours come
from shadowcut_bench_image_space. Whether a conclusion of theirs holds is decided here, from the
figures.
"""
import math

from tables import percent, ratio, rows_of, verdict

# Batagelo & Costa, table 2 (phases A to G and their total) and table 3 (A to D and their total),
# ms. "> 0,00" is 0 here.
HYBRID = {
    "sphere256": (1.75, 0.10, 0.35, 2.40, 0.40, 0.15, 0.60, 5.75),
    "solids96": (0.40, 0, 0.15, 0.55, 0.35, 0.05, 0.75, 2.25),
    "tetrahedra752:1": (3.40, 0.30, 2.05, 8.50, 0.70, 0.75, 12.75, 28.45),
    "tetrahedra752:2": (3.25, 0.30, 1.35, 2.15, 0.35, 0.15, 2.20, 9.75),
    "cubes1502": (6.30, 1.20, 3.90, 16.70, 1.10, 1.70, 18.00, 48.90),
}
STANDARD = {
    "sphere256": (1.75, 0.05, 0.65, 6.15, 8.60),
    "solids96": (0.60, 0, 0.30, 3.20, 4.10),
    "tetrahedra752:1": (5.30, 0.25, 3.10, 43.85, 52.50),
    "tetrahedra752:2": (5.40, 0.20, 3.15, 48.80, 57.55),
    "cubes1502": (10.35, 0.60, 6.55, 148.50, 166.00),
}
# Kolic et al., table 1: frames a second on a full screen and in a window, of the new method,
# Heidmann's, and without shadow.
KOLIC = {
    (640, 480): ((52.88, 43.23, 76.22), (82.1, 52.91, 641.03)),
    (800, 600): ((45.7, 36.36, 74.4), (61.54, 46.73, 534.76)),
    (1024, 768): ((32.82, 28.19, 73.53), (42.66, 34.98, 427.53)),
}
# Oh & Shin, section 4: the speedup of the whole frame with a tenth of the objects dynamic.
OH_SPEEDUP = 0.234

CLOCKS = {
    "processor": "Our times are processor time: with all drawing done by the processor that is "
    "the work, "
    "whatever else runs; but the hybrid's phases B to F, which it takes itself, are wall "
    "clock, and G is what is left.",
    "wall": "Our times are wall clock.",
}
NOISE = 0.05  # by which a share of a frame's time may differ from run to run
PHASES = (
    "its_B_sort_ms",
    "its_C_volumes_ms",
    "its_D_svbsp_ms",
    "its_E_silhouette_ms",
    "its_F_caps_ms",
)
LARGE, SMALL = (640, 480), (160, 120)


def ms(value):
    return (
        f"{value:.3f}"
        if value < 1
        else f"{value:.2f}"
        if value < 10
        else f"{value:.1f}"
        if value < 100
        else f"{value:.0f}"
    )


def found(rows, motion, size, scene=None):
    """Figures by technique."""
    return next(
        r
        for r in rows
        if r["motion"] == motion
        and (r["width"], r["height"]) == size
        and scene in (None, r["scene"])
    )["techniques"]


def fixed_ms(small, large):
    """What would be left of a picture's time if it had no pixels: the line through two sizes."""
    n, m = SMALL[0] * SMALL[1], LARGE[0] * LARGE[1]
    return max(0.0, (small * m - large * n) / (m - n))


def exponent(points):
    """Least squares, as powers."""
    xs, ys = [math.log(n) for n, _ in points], [math.log(t) for _, t in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def listed(words):
    return ", ".join(words)


# ---- Batagelo & Costa 1999


class Comparison:
    """One scene of theirs:

    milliseconds of both methods, by phase, at one size. The BSP tree is made beforehand, as theirs.
    """

    def __init__(self, rows, scene, size, motion="light"):
        t = found(rows, motion, size, scene)
        eye = t["ambient"]["draw_ms"]
        hybrid, standard = t["stencil-hybrid"], t["stencil-standard"]
        middle = [hybrid[p] for p in PHASES]
        self.scene, self.figures = scene, t
        self.bsp = hybrid["update_ms"]
        self.hybrid = [
            eye,
            *middle,
            max(0.0, hybrid["draw_ms"] - eye - sum(middle)),
            hybrid["draw_ms"],
        ]
        self.standard = [
            eye,
            standard["update_ms"],
            max(0.0, standard["draw_ms"] - eye),
            standard["frame_ms"],
        ]
        self.gain = self.standard[-1] / self.hybrid[-1]
        self.before, self.after = (
            hybrid["its_shadow_polygons_before"],
            hybrid["its_shadow_polygons"],
        )


def batagelo_tables(runs):
    yield "\n### Tables 2 and 3: time by phase\n"
    yield (
        "Milliseconds, and shares of the total. A: the eye's view (ours: in ambient light). "
        "B: sorting or finding casters, C: volumes, D: the SVBSP "
        "tree, E: silhouettes, F: caps, G: drawing the shadows (ours: and the light where "
        "there are none). B and C of standard are one figure here. "
        "The BSP tree is made beforehand, in both.\n"
    )
    rows = []
    for c in runs:
        theirs = HYBRID[c.scene]
        rows.append(
            (
                c.scene,
                "hybrid, theirs",
                *[percent(v / theirs[-1]) for v in theirs[:-1]],
                f"{theirs[-1]:g}",
            )
        )
        rows.append(
            (
                "",
                "hybrid, ours",
                *[percent(v / c.hybrid[-1]) for v in c.hybrid[:-1]],
                ms(c.hybrid[-1]),
            )
        )
        a, b, volumes, drawing, total = STANDARD[c.scene]
        rows.append(
            (
                "",
                "standard, theirs",
                percent(a / total),
                f"B + C: {percent((b + volumes) / total)}",
                "",
                "",
                "",
                "",
                percent(drawing / total),
                f"{total:g}",
            )
        )
        a, volumes, drawing, total = c.standard
        rows.append(
            (
                "",
                "standard, ours",
                percent(a / total),
                f"B + C: {percent(volumes / total)}",
                "",
                "",
                "",
                "",
                percent(drawing / total),
                ms(total),
            )
        )
    yield from rows_of(("scene", "method", *"ABCDEFG", "total, ms"), rows)


def batagelo_gains(runs, small, moved):
    yield "\n### Figures 9 and 10: the gain, and shadow polygons\n"
    yield (
        "The gain is standard's time over the hybrid's. Filling: the share of a 640 x 480 "
        "picture's time that grows with its pixels, by the line through its "
        "time and that at 160 x 120. Shadow polygons: sides of volumes, of standard; of the "
        "hybrid before the SVBSP tree and the silhouettes (of the BSP "
        "tree's polygons), and after. The engine: its update after the light has moved, a "
        "new build, and drawing.\n"
    )
    rows = []
    for c, s in zip(runs, small):
        fill = [
            1 - fixed_ms(s.figures[k]["draw_ms"], c.figures[k]["draw_ms"]) / c.figures[k]["draw_ms"]
            for k in ("stencil-standard", "stencil-hybrid")
        ]
        engine = c.figures["fragments"]
        rows.append(
            (
                c.scene,
                ratio(STANDARD[c.scene][-1] / HYBRID[c.scene][-1]),
                ratio(c.gain),
                ratio(s.gain),
                " / ".join(map(percent, fill)),
                f"{c.figures['stencil-standard']['its_shadow_polygons']:.0f}",
                f"{c.before:.0f} / {c.after:.0f}",
                f"{ms(engine['update_ms'])} + {ms(engine['draw_ms'])}",
                ms(c.figures["unshadowed"]["draw_ms"]),
            )
        )
    yield from rows_of(
        (
            "scene",
            "gain: theirs",
            "ours",
            "ours, 160 x 120",
            "filling: standard / hybrid",
            "shadow polygons: standard",
            "hybrid: before / after",
            "engine, ms",
            "no shadow, ms",
        ),
        rows,
    )
    yield ""
    yield from batagelo_verdicts(runs, small, moved)


def batagelo_verdicts(runs, small, moved):
    gains = {c.scene: c.gain for c in runs}
    printed = {s: STANDARD[s][-1] / HYBRID[s][-1] for s in gains}
    yield from verdict(
        "The hybrid is faster than standard in every scene.",
        min(gains.values()) > 1,
        f"{ratio(min(printed.values()))} to {ratio(max(printed.values()))} times there, "
        f"{ratio(min(gains.values()))} to {ratio(max(gains.values()))} here.",
        f"It is not in {listed(s for s, g in gains.items() if g <= 1)}.",
    )
    best = max(gains, key=gains.get)
    one, two = gains["tetrahedra752:1"], gains["tetrahedra752:2"]
    yield from verdict(
        "It gains most where much is hidden, as in the second scene of tetrahedra.",
        best == "tetrahedra752:2",
        "The same tetrahedra with the ground below and above them: "
        f"{ratio(printed['tetrahedra752:1'])} and {ratio(printed['tetrahedra752:2'])} times "
        "there, "
        f"{ratio(one)} and {ratio(two)} here.",
        f"The most is {ratio(gains[best])} times, in {best}: what the silhouettes leave out "
        "counts as much as what is hidden. Of the two scenes the one "
        f"where much is hidden gains {'more' if two > one else 'less'}, as printed.",
    )
    cut = {c.scene: c.after / c.before for c in runs}
    yield from verdict(
        "The SVBSP tree and the silhouettes together leave fewer shadow polygons (figure 10).",
        max(cut.values()) < 1,
        f"Of those before, {percent(min(cut.values()))} ({min(cut, key=cut.get)}) to "
        f"{percent(max(cut.values()))} ({max(cut, key=cut.get)}) are left here.",
    )
    yield from cubes_verdict(
        next(c for c in runs if c.scene == "cubes1502"),
        next(c for c in small if c.scene == "cubes1502"),
    )
    yield (
        "- Theirs is \"limited to static scenes\": where an object moves the BSP tree has "
        f"to be made again, here {ms(moved[0].bsp)} ms ({moved[0].scene}) to "
        f"{ms(moved[-1].bsp)} ms ({moved[-1].scene}) a frame; with it the hybrid's gain in "
        "the five scenes is "
        f"{listed(ratio(c.standard[-1] / (c.bsp + c.hybrid[-1])) for c in moved)}."
    )


def cubes_verdict(cubes, small):
    tree, drawing, total = cubes.hybrid[3], cubes.hybrid[6], cubes.hybrid[-1]
    theirs = HYBRID["cubes1502"]
    saved = 6 * 125 - cubes.after
    worth = saved * drawing / cubes.after
    yield from verdict(
        "The scene of cubes gains nothing from the SVBSP tree: "
        "its making costs as much as drawing.",
        tree > worth,
        f"The tree takes {percent(theirs[3] / theirs[-1])} of the time there (16.70 of 48.90 "
        f"ms), {percent(tree / total)} here ({ms(tree)} of {ms(total)} ms).",
        f"Silhouettes alone would leave at most six edges of each of 125 cubes, {saved:.0f} "
        "more than the tree leaves; at the mean price of a side those would take "
        f"{ms(worth)} ms. Planes are cheaper than they were, and pixels dearer: at 160 x 120 "
        f"the tree takes {percent(small.hybrid[3] / small.hybrid[-1])}, and there the "
        f"sides would take {ms(saved * small.hybrid[6] / small.after)} ms.",
    )


def batagelo(rows):
    yield "\n## Batagelo and Costa 1999: the hybrid of SVBSP tree and stencil buffer\n"
    yield (
        "Five scenes of their kinds and numbers of polygons (data/scenes.hpp), 640 x 480, "
        "one light in ten places on a dome; the mean of the ten. Standard draws "
        "the volume of every polygon that faces the light, the hybrid those that the SVBSP "
        "tree leaves, by their silhouettes."
    )
    scenes = list(HYBRID)
    runs = [Comparison(rows, s, LARGE) for s in scenes]
    small = [Comparison(rows, s, SMALL) for s in scenes]
    yield from batagelo_tables(runs)
    yield from batagelo_gains(runs, small, [Comparison(rows, s, LARGE, "object") for s in scenes])
    yield (
        "- Wrong by design: standard begins to count at the near plane and takes the eye to "
        "be in the light. Where the eye is in shadow, or a volume is cut by "
        "the near plane, the picture comes out wrong: "
        "Render.StandardIsWrongWhereTheCameraIsInShadow in tests/system/render_test.cpp. The "
        "hybrid's caps mend it, and it "
        "draws what rays see in the same places (Render.EveryTechniqueDrawsWhatRaysSee)."
    )


# ---- Kolic et al. 2004


def kolic(rows):
    yield "\n## Kolić, Mihajlović and Budin 2004: volumes without silhouettes\n"
    first = found(rows, "light", LARGE)
    sides, triangles = (
        2 * first["stencil-standard"]["its_shadow_polygons"],
        first["stencil-kolic"]["its_volume_triangles"],
    )
    yield (
        "A branch of 2 878 triangles. Theirs: frames a second on a full screen, in a window. "
        "Ours: milliseconds a frame while the light moves. Their Heidmann finds "
        "the branch's silhouette on the processor in every frame. Ours, stencil-standard, "
        "finds none: it makes the volume of every triangle that faces the light "
        "(a leaf, which is open, always does), in every frame, and uploads them: "
        "\"processor\" in the table, part of its time. The hybrid does find silhouettes, "
        "after "
        "the SVBSP tree; its BSP tree is made beforehand. The new method does nothing on the "
        "processor: its mesh is uploaded once, and that is not counted.\n"
    )
    table, gains = [], {}
    for size in (*KOLIC, SMALL):
        t = found(rows, "light", size)
        standard, new, none = (
            t["stencil-standard"],
            t["stencil-kolic"]["draw_ms"],
            t["unshadowed"]["draw_ms"],
        )
        gains[size] = standard["frame_ms"] / new
        printed = KOLIC.get(size)
        hybrid, engine = t["stencil-hybrid"], t["fragments"]
        table.append(
            (
                f"{size[0]} x {size[1]}",
                *(
                    [", ".join(f"{w[k]:g}" for w in printed) for k in range(3)]
                    if printed
                    else ("",) * 3
                ),
                ", ".join(ratio(w[0] / w[1]) for w in printed) if printed else "",
                ms(new),
                f"{ms(standard['frame_ms'])} ({ms(standard['update_ms'])})",
                f"{ms(hybrid['draw_ms'])} ({ms(sum(hybrid[p] for p in PHASES))})",
                ms(none),
                ratio(gains[size]),
                ratio(hybrid["draw_ms"] / new),
                f"{ms(engine['update_ms'])} + {ms(engine['draw_ms'])}",
            )
        )
    yield from rows_of(
        (
            "size",
            "new: theirs",
            "Heidmann: theirs",
            "no shadow: theirs",
            "new / Heidmann",
            "new: ours, ms",
            "Heidmann: ours (processor)",
            "hybrid (processor)",
            "no shadow: ours",
            "Heidmann / new",
            "hybrid / new",
            "engine, ms",
        ),
        table,
    )
    yield ""
    printed = [w[0] / w[1] for both in KOLIC.values() for w in both]
    here = [gains[s] for s in KOLIC]
    update = first["stencil-standard"]["update_ms"] / first["stencil-standard"]["frame_ms"]
    yield from verdict(
        "The new method is faster than Heidmann's in every size.",
        min(here) > 1,
        f"{ratio(min(printed))} to {ratio(max(printed))} times there, {ratio(min(here))} to "
        f"{ratio(max(here))} here.",
        f"It saves the processor's part, and that is {percent(update)} of a frame of "
        "Heidmann's here at 640 x 480: there is no silhouette in it, and all the rest, "
        "triangles and pixels, is done by the same processor. It draws "
        f"{ratio(triangles / sides)} times as many triangles.",
    )
    yield from verdict(
        "Heidmann's method draws less than half as much.",
        sides < 0.5 * triangles,
        f"{sides:.0f} triangles of {triangles:.0f} here.",
        "Ours has no silhouettes.",
    )
    hybrid = first["stencil-hybrid"]
    drawn = [
        [found(rows, "light", s)[t]["draw_ms"] for t in ("stencil-hybrid", "stencil-kolic")]
        for s in KOLIC
    ]
    yield from verdict(
        "For a tree silhouettes are complicated and poorly justified.",
        hybrid["draw_ms"] > first["stencil-standard"]["frame_ms"],
        f"At 640 x 480 the hybrid takes {ms(hybrid['draw_ms'])} ms, "
        f"{ms(sum(hybrid[p] for p in PHASES))} of them on the processor before anything is "
        "drawn; volumes of all triangles "
        f"{ms(first['stencil-standard']['frame_ms'])}. Where prisms of wood grow out of one "
        "another the BSP tree cuts them up, and it leaves "
        f"{hybrid['its_shadow_polygons']:.0f} shadow polygons, "
        f"beside {sides / 2:.0f} of standard's. The new method is faster than the hybrid in "
        f"{sum(hybrid_ms > kolic_ms for hybrid_ms, kolic_ms in drawn)} of "
        f"{len(KOLIC)} sizes.",
    )
    growth = {
        k: found(rows, "light", (1024, 768))[k]["draw_ms"] / first[k]["draw_ms"]
        for k in ("stencil-kolic", "stencil-standard", "unshadowed")
    }
    theirs = [KOLIC[640, 480][0][k] / KOLIC[1024, 768][0][k] for k in range(3)]
    yield from verdict(
        "Shadows cost more in larger pictures.",
        min(growth.values()) > 1,
        "From 640 x 480 to 1024 x 768, 2.56 times the pixels (new, Heidmann, no shadow; "
        f"full screen): {listed(map(ratio, theirs))} times there, "
        f"{listed(map(ratio, growth.values()))} here, where each pixel is work of the processor.",
    )
    yield (
        "- Where the balance shifts: at 160 x 120, a sixteenth of the pixels, Heidmann over "
        f"new is {ratio(gains[SMALL])}. Without pixels to fill there is still "
        "the vertex work of eight triangles in place of one, on the same processor."
    )
    yield (
        "- Wrong by design: seven triangles a triangle leave the volume open at its far end. "
        "A ray of the eye that ends in the volume's depth then fails the depth test "
        "once and not twice, and the next volume before it makes a shadow of that; ours "
        "draws an eighth (src/render/stencil_kolic.cpp). And the paper says nothing of a "
        "camera within a volume, of which only one side is seen: "
        "Render.KolicIsWrongWhereTheCameraIsInAVolume in tests/system/render_test.cpp. On "
        "edges of volumes a pixel may be "
        "left half done even so; Render.EveryTechniqueDrawsWhatRaysSee allows it two pixels "
        "a picture."
    )


# ---- Oh & Shin 2005


def update_and_draw(technique):
    return f"{ms(technique['update_ms'])} + {ms(technique['draw_ms'])}"


def oh_growth(rows):
    yield "\n### Figure 7: growth\n"
    yield (
        "N spheres of 2 037 vertices, 4 070 triangles each, 800 x 600; every texture and "
        "buffer is made again in every frame. Milliseconds: making textures + drawing "
        "with them. Drawn: objects drawn into the light's views to make all textures, "
        "besides the receivers themselves.\n"
    )
    table, points = [], {"quadratic": [], "sz-buffer": []}
    for row in rows:
        t, n = row["techniques"], row["count"]
        for k, p in points.items():
            p.append((n, t[k]["update_ms"], t[k]["its_objects_drawn"], t["unshadowed"]["draw_ms"]))
        table.append(
            (
                n,
                f"{t['sz-buffer']['its_textures']:.0f}",
                *[update_and_draw(t[k]) for k in points],
                *[f"{t[k]['its_objects_drawn']:.0f}" for k in points],
                ratio(t["quadratic"]["frame_ms"] / t["sz-buffer"]["frame_ms"]),
                ms(t["unshadowed"]["draw_ms"]),
                f"{ms(t['fragments']['first_update_ms'])}, {ms(t['fragments']['draw_ms'])}",
            )
        )
    yield from rows_of(
        (
            "N",
            "textures",
            "quadratic",
            "SZ-buffer",
            "drawn: quadratic",
            "SZ-buffer",
            "quadratic / SZ-buffer, frame",
            "no shadow",
            "engine: first build, drawing",
        ),
        table,
    )
    yield ""
    drawn = {k: exponent([(n, d) for n, _, d, _ in p]) for k, p in points.items()}
    beside = {k: [u / none for _, u, _, none in (p[0], p[-1])] for k, p in points.items()}
    few, many = points["quadratic"][0][0], points["quadratic"][-1][0]

    def growth(k):
        return (
            f"Objects drawn for the textures grow as N^{drawn[k]:.2f} here. Making them "
            f"takes {ratio(beside[k][0])} times the picture without shadows of {few} "
            "spheres, "
            f"{ratio(beside[k][1])} times that of {many}"
        )

    yield from verdict(
        "Their method's time grows with N.",
        drawn["sz-buffer"] < 1.2,
        f"{growth('sz-buffer')}: six views of 2048 x 2048 pixels are cleared whatever N is.",
    )
    yield from verdict(
        "The time of the method before grows with N^2.",
        drawn["quadratic"] > 1.6,
        f"{growth('quadratic')}.",
        "\"All objects between the object and the light\" are here those whose rectangles in "
        "the light's view meet the receiver's. Our crowd is as dense for any N, so a "
        "receiver has as many more of them as the crowd is deeper, the cube root of N: "
        "N^1.33 in all. N^2 needs a crowd that grows denser.",
    )
    last = points["quadratic"][-1][1] / points["sz-buffer"][-1][1]
    yield from verdict(
        "It is an order of magnitude faster.",
        last >= 10,
        f"With {points['quadratic'][-1][0]} spheres textures are made {ratio(last)} times as "
        "fast here.",
        "For the same reason; and both make the same textures, to the bit "
        "(ShadowTexture.IsTheQuadraticMethodsToTheBit in tests/unit/sz_buffer_test.cpp), "
        "which costs "
        "both the drawing of every receiver, of its triangles' rims too, and a copy.",
    )


def oh_coherence(rows):
    yield "\n### Figure 8: coherence\n"
    yield (
        f"{rows[0]['count']} spheres, of which a share moves in every frame. Milliseconds as "
        "above. The speedup of the whole frame is the time without coherence over that with "
        "it, "
        "less one.\n"
    )
    table, speedups = [], {}
    for row in rows:
        t, share = row["techniques"], row["dynamic_percent"]
        without, coherent = t["sz-buffer"], t["sz-buffer-coherent"]
        speedups[share] = without["frame_ms"] / coherent["frame_ms"] - 1
        table.append(
            (
                f"{share} %",
                update_and_draw(without),
                update_and_draw(coherent),
                percent(speedups[share]),
                percent(without["update_ms"] / coherent["update_ms"] - 1)
                if share
                else "nothing to make",
                f"{coherent['its_textures_made']:.0f} of {coherent['its_textures']:.0f}",
                update_and_draw(t["fragments"]),
                ms(t["engine-merged"]["update_ms"]),
            )
        )
    yield from rows_of(
        (
            "dynamic",
            "without",
            "with",
            "speedup, frame",
            "speedup, textures",
            "textures made",
            "engine",
            "its update, merged",
        ),
        table,
    )
    yield ""
    order = [speedups[s] for s in sorted(speedups)]
    yield from verdict(
        "The smaller the share of dynamic objects, the larger the speedup.",
        all(a > b - NOISE for a, b in zip(order, order[1:])) and order[0] > order[-1],
        f"From {100 * order[-1]:.0f} % where all move, and {100 * speedups[50]:.0f} % with "
        f"half, when nearly every texture is disturbed, to {percent(order[0])} where none "
        "does.",
    )
    ten = next(r["techniques"] for r in rows if r["dynamic_percent"] == 10)
    textures = ten["sz-buffer"]["update_ms"] / ten["sz-buffer-coherent"]["update_ms"] - 1
    yield from verdict(
        "With 10 % dynamic the whole frame gains, the making of textures much more.",
        textures > speedups[10] > 0,
        f"The frame {percent(OH_SPEEDUP)} there, {percent(speedups[10])} here; textures "
        f"{percent(textures)} here. Theirs are made by a card that fills fast; here "
        f"they are {percent(ten['sz-buffer']['update_ms'] / ten['sz-buffer']['frame_ms'])} "
        "of a frame without coherence, so there is more to gain.",
    )


def oh(growth, coherence):
    yield "\n## Oh and Shin 2005: shadow textures with an SZ-buffer"
    yield from oh_growth(growth)
    yield from oh_coherence(coherence)
    yield (
        "- Wrong by design: a texture has pixels. Away from the edges of faces and shadows, "
        "by more than one of its pixels, the picture is as rays have it; within that it is "
        "not, "
        "and the engine's fragments are (ShadowTexture.DrawsRandomThingsAsShadowVolumesDo in "
        "tests/unit/sz_buffer_test.cpp counts both). One texture an object cannot say that "
        "an "
        "object shadows itself: ours divides objects into receivers that cannot "
        "(src/render/receivers.hpp). The plain shadow map, beside them for comparison, has "
        "both limits and a "
        "bias besides."
    )


def engine(document):
    yield "\n## The engine in the same frames\n"
    yield (
        "Its own way for the frames above, at the papers' first size: fragments from "
        "nothing; brought up to date after the light has moved (all is new), after one "
        "object has (the last "
        "of the scene: the whole sphere or tetrahedron, one cube, one leaf); and drawn. "
        "Beside it the fastest of the papers' techniques in the same frames, milliseconds a "
        "frame, "
        "without the hybrid's BSP tree. Fragments are drawn in the conforming form, which "
        "leaves a rasteriser no cracks, and of which every update hands out everything again "
        "(docs/design.md); in brackets the same updates in the merged form, which "
        "is the engine's default and hands out what changed.\n"
    )
    rows, faster = [], 0
    for name, scene in [("batagelo1999", s) for s in HYBRID] + [("kolic2004", "branch2878")]:
        light, moved = (
            found(document[name], motion, LARGE, scene) for motion in ("light", "object")
        )
        others = [
            min(
                (t[k]["frame_ms"] if k == "stencil-standard" else t[k]["draw_ms"], k)
                for k in ("stencil-standard", "stencil-hybrid", "stencil-kolic")
                if k in t
            )
            for t in (light, moved)
        ]
        mine = light["fragments"]
        faster += mine["frame_ms"] < others[0][0]
        rows.append(
            (
                scene,
                ms(mine["first_update_ms"]),
                *[
                    f"{ms(t['fragments']['update_ms'])} ({ms(t['engine-merged']['update_ms'])})"
                    for t in (light, moved)
                ],
                ms(mine["draw_ms"]),
                ms(light["unshadowed"]["draw_ms"]),
                *[f"{ms(t)} ({k.removeprefix('stencil-')})" for t, k in others],
            )
        )
    yield from rows_of(
        (
            "scene",
            "from nothing",
            "light moved",
            "object moved",
            "drawing",
            "no shadow",
            "light moved: papers",
            "object moved: papers",
        ),
        rows,
    )
    crowd = next(
        r["techniques"] for r in document["oh2005_coherence"] if r["dynamic_percent"] == 10
    )
    yield (
        "\nWith the light moving, update and drawing together are less than the fastest of "
        f"the papers' in {faster} of {len(rows)} scenes; a scene that stands still costs the "
        "drawing "
        "alone. Not so with the spheres: with ten of a hundred moving, 40 700 triangles of "
        f"407 000, the update takes {ms(crowd['fragments']['update_ms'])} ms, in the merged "
        "form "
        f"{ms(crowd['engine-merged']['update_ms'])} ms, beside "
        f"{ms(crowd['sz-buffer-coherent']['update_ms'])} ms of the SZ-buffer and its "
        "textures. Every small triangle is a face to the "
        "engine, and a few pixels to them."
    )


def balance(document):
    yield "\n## Where software rasterising shifts the balance\n"
    rows = document["kolic2004"]
    shares = []
    for key, name in (
        ("unshadowed", "no shadow"),
        ("stencil-standard", "standard"),
        ("stencil-kolic", "Kolić"),
        ("fragments", "engine"),
    ):
        small, large = (found(rows, "light", s)[key]["draw_ms"] for s in (SMALL, LARGE))
        fixed = fixed_ms(small, large)
        shares.append((name, ms(small), ms(large), ms(fixed), percent(1 - fixed / large)))
    yield (
        f"There is no graphics card here: the driver is {document['driver']}, with "
        f"LP_NUM_THREADS={document['lp_num_threads'] or 'unset'}, so that one processor sets "
        "up every vertex and fills "
        "every pixel. Drawing the branch, milliseconds; the part that is left without "
        "pixels, by the line through both sizes; and the share of the pixels at 640 x 480:\n"
    )
    yield from rows_of(("", "160 x 120", "640 x 480", "without pixels", "filling"), shares)
    pairs = [
        [Comparison(document["batagelo1999"], s, size).gain for size in (LARGE, SMALL)]
        for s in HYBRID
    ]
    yield (
        "\n- Filling is dear. What draws large volumes over the whole picture (standard, "
        "Kolić) pays for them by the pixel; the papers' cards filled faster than their "
        "processors could feed "
        "them. Methods that spend the processor's time to save pixels (the hybrid's SVBSP "
        "tree, the engine's fragments) gain more here than on a card. "
        "The hybrid's gain is larger at 640 x 480 than with a sixteenth of the pixels in "
        f"{sum(a > b for a, b in pairs)} of Batagelo and Costa's five scenes: "
        f"{listed(map(ratio, (g for g, _ in pairs)))} and "
        f"{listed(map(ratio, (g for _, g in pairs)))}.\n"
        "- Vertex work is not free. Moving it from the processor to the card, which is "
        "Kolić's point, moves it here from the processor to the processor.\n"
        "- The engine's update costs the same with any driver. Its drawing is that of the "
        "picture without shadows but for more vertices, and on a card would be near nothing."
    )


def page(document):
    yield "\n## With graphics hardware\n"
    yield (
        "Written from bench/baseline/image_space.json (`shadowcut_bench_image_space`). The "
        "machines were a Celeron 466 MHz with a Riva TNT, a Pentium 4 2.8 GHz with a Radeon "
        "9700, "
        "and a Pentium 4 2.66 GHz with a Radeon 9800 XT; all figures of ours are from one "
        "run, and only ratios compare. "
        f"{CLOCKS[document['clock']]} Of each "
        "frame the smaller of several rounds is taken, and techniques take turns, because "
        "the machine had other work meanwhile: ratios within a row are surer than between "
        "rows. Every technique's pictures are held against rays "
        "(tests/system/render_test.cpp, tests/unit/sz_buffer_test.cpp), and how each departs "
        "from its paper stands at the top of its file in src/render. Beside each stands what "
        "the engine's "
        "fragments cost in the same frames. Figures 9 to 11, 7 and 8 are curves without "
        "numbers: of those only the conclusions compare."
    )
    yield from batagelo(document["batagelo1999"])
    yield from kolic(document["kolic2004"])
    yield from oh(document["oh2005_growth"], document["oh2005_coherence"])
    yield from engine(document)
    yield from balance(document)
