#!/usr/bin/env python3
"""Writes docs/accuracy.md's part of the dial, and its figure, from a run of shadowcut_bench_dial:

    bench/dial_report.py bench/baseline/dial.json docs/accuracy.md docs/accuracy-methods.svg

Of accuracy.md only what stands between the two lines BEGIN and END is replaced. Errors are shares of the area turned to the light: for
fragments that of the symmetric difference with the exact regions, for samplers the sum over faces of what their areas are off by.
"""
import json
import math
import statistics
import sys

from plot import GRID, INK, SOFT, Axis, line, mark, path, text, time_text

BEGIN, END = "<!-- dial: begin; written by bench/dial_report.py -->", "<!-- dial: end -->"

# ---- rows


def group(rows):
    """By scene and light, in the order of the run."""
    groups = {}
    for r in rows:
        groups.setdefault((r["scene"], r["light"]), []).append(r)
    return groups


def of(rows, method):
    return [r for r in rows if r["method"] == method and "skipped" not in r]


def is_other(row):
    """The exact kernel in another order: what the comparison cannot tell apart."""
    return "order" in row["parameters"]


def dials(row):
    """The parameters beside kernel, form and order."""
    return {k: v for k, v in row["parameters"].items() if k not in ("kernel", "form", "order", "reference")}


def ours(rows, kernel, form="merged"):
    for r in of(rows, "shadowcut"):
        if r["parameters"]["kernel"] == kernel and r["parameters"]["form"] == form and not is_other(r) and not dials(r):
            return r
    return None


def rays(rows, samples):
    return next((r for r in of(rows, "rays") if r["parameters"]["samples"] == samples), None)


def error(row):
    return row["area_error_share"] if row["method"] in ("rays", "rays by area", "map") else row["symmetric_share"]


# ---- the figure

COLUMNS, WIDTH, PLOT_HEIGHT, GAP_X, GAP_Y = 3, 1110, 250, 26, 58
LEFT, TOP = 74, 118
FIRST, LAST, FLOOR = 0, -8, (-13, -17)  # powers of ten: the upper part of the axis of errors, and the lower one
BREAK = (0.72, 0.80)                    # shares of a panel's height between which the axis is broken
KERNELS = {"fast": "#1b6ca8", "exact": "#14724a", "single": "#7a4fa3"}
FORMS = {"pieces": "triangle", "merged": "diamond", "conforming": "square"}
SAMPLERS = {"rays": ("#d9822b", "circle", False), "rays by area": ("#b03a2e", "circle", True), "map": ("#777", "square", False)}
LABELLED = {"rays": (1, 16, 256, 4096), "rays by area": (), "map": (256, 1024, 8192)}


class BrokenAxis:
    """Errors on two logarithmic stretches, downwards."""

    def __init__(self, top, height):
        self.upper = Axis(LAST, FIRST, top + BREAK[0] * height, top)
        self.lower = Axis(FLOOR[1], FLOOR[0], top + height, top + BREAK[1] * height)
        self.cut = top + 0.5 * (BREAK[0] + BREAK[1]) * height

    def __call__(self, value):
        power = math.log10(max(value, 1e-300))
        if power >= LAST:
            return self.upper(value)
        return self.lower(min(max(value, 10.0 ** FLOOR[1]), 10.0 ** FLOOR[0]))


def power_text(power):
    return "1" if power == 0 else f'10<tspan dy="-5" font-size="9">{power}</tspan>'


def frame(x, y, left, top, width, is_first):
    for value, is_major in x.ticks():
        if not is_major:
            continue
        at = x(value)
        yield line(at, top, at, top + PLOT_HEIGHT, GRID, 0.8)
        yield text(at, top + PLOT_HEIGHT + 17, time_text(value), "middle", 11, SOFT)
    for power in [*range(FIRST, LAST - 1, -2), *range(FLOOR[0], FLOOR[1] - 1, -2)]:
        at = y(10.0 ** power)
        yield line(left, at, left + width, at, GRID, 0.8)
        if is_first:
            yield text(left - 8, at + 4, power_text(power), "end", 11.5, SOFT)
    yield f'<rect x="{left}" y="{top}" width="{width:.1f}" height="{PLOT_HEIGHT}" fill="none" stroke="{SOFT}"/>'
    for side in (left, left + width):
        yield f'<rect x="{side - 4:.1f}" y="{y.cut - 4:.1f}" width="8" height="8" fill="white"/>'
        for shift in (-4, 4):
            yield line(side - 5, y.cut + shift + 2.5, side + 5, y.cut + shift - 2.5, SOFT)


def short(n):
    return f"{n // 1024}k" if n >= 1024 else str(n)


def sampler(rows, method, x, y):
    colour, shape, is_hollow = SAMPLERS[method]
    rows = of(rows, method)
    at = [(x(r["ms"]), y(error(r))) for r in rows]
    yield path(at, colour, ' stroke-opacity="0.55"')
    for (px, py), r in zip(at, rows):
        yield mark(shape, px, py, colour, 3.4, is_hollow)
        n = r["parameters"].get("samples", r["parameters"].get("side"))
        if n in LABELLED[method]:
            yield text(px, py - 8 if method == "rays" else py + 16, short(n), "middle", 10.5, colour)


def engine(rows, x, y):
    names = []
    for kernel, colour in KERNELS.items():
        mine = [r for r in of(rows, "shadowcut") if r["parameters"]["kernel"] == kernel and not is_other(r) and not r["parameters"].get("reference")]
        turned = sorted((r for r in mine if dials(r)), key=lambda r: r["ms"])
        if turned:
            yield path([(x(r["ms"]), y(error(r))) for r in turned], colour, ' stroke-opacity="0.55"')
        for r in sorted(mine, key=lambda r: r["parameters"]["form"] == "merged"):
            yield mark(FORMS[r["parameters"]["form"]], x(r["ms"]), y(error(r)), colour, 2.6 if dials(r) else 4.4, r["parameters"]["form"] != "merged")
        best = ours(rows, kernel)
        if best:
            names.append((x(best["ms"]), y(error(best)), kernel, colour))
    for px, py, kernel, colour in names:
        yield text(px, py - 11, kernel, "middle", 12, colour, ' font-weight="bold"')


def panel(key, rows, x, y, left, top, width, is_first):
    scene = rows[0]
    yield from frame(x, y, left, top, width, is_first)
    yield text(left, top - 8, key[0], size=13.5, more=' font-weight="bold"')
    yield text(left + width, top - 8, f'{scene["facing_faces"]} faces to the light', "end", 11.5, SOFT)
    for method in ("map", "rays by area", "rays"):
        yield from sampler(rows, method, x, y)
    yield from engine(rows, x, y)


def legend(kernels):
    at, y = LEFT, 62
    for method, words in (("rays", "Embree rays, 1 to 4096 a face"), ("rays by area", "the same number, spread by area"), ("map", "shadow map, 256 to 8192 a side")):
        colour, shape, is_hollow = SAMPLERS[method]
        yield line(at, y - 4, at + 26, y - 4, colour, 2, ' stroke-opacity="0.55"') + mark(shape, at + 13, y - 4, colour, 3.4, is_hollow)
        yield text(at + 33, y, words, size=12.5)
        at += 262
    at, y = LEFT, 84
    for kernel in kernels:
        yield mark("diamond", at + 13, y - 4, KERNELS[kernel], 4.4) + text(at + 33, y, f"shadowcut, {kernel}", size=12.5)
        at += 150
    for form, shape in FORMS.items():
        yield mark(shape, at + 13, y - 4, INK, 4.2, form != "merged") + text(at + 27, y, form, size=12.5)
        at += 92


def draw(groups):
    shown = [(key, rows) for key, rows in groups.items() if key[1] == "point"]
    every = [r["ms"] for _, rows in shown for r in rows if "ms" in r and r["method"] != "edits"]
    low, high = math.floor(math.log10(min(every))), math.ceil(math.log10(max(every)))
    width = (WIDTH - LEFT - 24 - (COLUMNS - 1) * GAP_X) / COLUMNS
    lines = math.ceil(len(shown) / COLUMNS)
    height = TOP + lines * (PLOT_HEIGHT + GAP_Y) + 16
    yield f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">'
    yield f'<rect width="{WIDTH}" height="{height}" fill="white"/>'
    yield text(LEFT, 32, "Time against error: lower left is better", size=18)
    kernels = [k for k in KERNELS if any(r["parameters"].get("kernel") == k for _, rows in shown for r in of(rows, "shadowcut"))]
    yield from legend(kernels)
    for i, (key, rows) in enumerate(shown):
        left, top = LEFT + i % COLUMNS * (width + GAP_X), TOP + i // COLUMNS * (PLOT_HEIGHT + GAP_Y)
        yield from panel(key, rows, Axis(low, high, left, left + width), BrokenAxis(top, PLOT_HEIGHT), left, top, width, i % COLUMNS == 0)
    yield text(WIDTH / 2, height - 12, "time of the whole job on one thread", "middle", 13.5)
    middle = TOP + lines * (PLOT_HEIGHT + GAP_Y) / 2
    yield text(20, middle, "error, as a share of the area turned to the light", "middle", 13.5, more=f' transform="rotate(-90 20 {middle:.1f})"')
    yield "</svg>"


# ---- tables


def ms_text(ms):
    return f"{ms:.0f}" if ms >= 100 else f"{ms:.3g}"


def share_text(share):
    if share == 0:
        return "0"
    if share < 1e-4:
        mantissa, power = f"{share:.0e}".split("e")
        return f"{mantissa}e{int(power)}"
    return f"{100 * share:.2g} %"


def times_text(factor):
    return f"{factor:.0f}" if factor >= 9.95 else f"{factor:.1f}"


def name(key):
    return key[0] + (", sun" if key[1] == "sun" else "")


def sampled(rows):
    return of(rows, "rays") + of(rows, "rays by area")


def cheapest(rows, limit):
    """The quickest that stays within an error."""
    return min((r for r in rows if error(r) <= limit), key=lambda r: r["ms"], default=None)


def in_time(rows, ms):
    """The best that takes no longer."""
    return min((r for r in rows if r["ms"] <= ms), key=error, default=None)


def what(row):
    p = row["parameters"]
    return f"map {p['side']}" if row["method"] == "map" else f"{p['samples']} {'by area' if row['method'] == 'rays by area' else 'a face'}"


def glance(groups):
    yield "| scene | faces | fast, ms | error | exact, ms | best rays in fast's time | their error | rays within 1 % | within 0.1 % | best map: side, ms | its error |"
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for key, rows in groups.items():
        fast, exact = ours(rows, "fast"), ours(rows, "exact")
        same = in_time(sampled(rows), fast["ms"])
        cells = [name(key), rows[0]["facing_faces"], ms_text(fast["ms"]), share_text(error(fast)), ms_text(exact["ms"]),
                 what(same) if same else "none", share_text(error(same)) if same else ""]
        for limit in (1e-2, 1e-3):
            best = cheapest(sampled(rows), limit)
            cells.append(f"{what(best)}: {times_text(best['ms'] / fast['ms'])} x" if best else "not reached")
        best = min(of(rows, "map"), key=error)
        cells += [f"{best['parameters']['side']}, {ms_text(best['ms'])}", share_text(error(best))]
        yield "| " + " | ".join(str(c) for c in cells) + " |"


def wrong_text(row):
    return f"{row['lit_where_shadowed']} + {row['shadowed_where_lit']}, {row['missed']}" if row else ""


def wrong_faces(groups):
    yield "| scene | faces | fast | exact | 16 rays | 256 rays | 4096 rays | map 1024 | map 8192 |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for key, rows in groups.items():
        maps = {r["parameters"]["side"]: r for r in of(rows, "map")}
        chosen = [ours(rows, "fast"), ours(rows, "exact"), rays(rows, 16), rays(rows, 256), rays(rows, 4096), maps.get(1024), maps.get(8192)]
        yield f"| {name(key)} | {rows[0]['facing_faces']} | " + " | ".join(wrong_text(r) or "too slow" for r in chosen) + " |"


def edits(groups):
    thresholds = (0, 2, 6, 16)
    yield "| scene | " + " | ".join(f"fast, {t}" for t in thresholds) + " | exact, 2 | nodes against a fresh build, " + ", ".join(map(str, thresholds)) + " | error, fast | exact |"
    yield "|---|" + "---|" * (len(thresholds) + 4)
    for key, rows in groups.items():
        found = {(r["parameters"]["kernel"], r["parameters"]["join_threshold"]): r for r in of(rows, "edits")}
        if not found:
            continue
        fast = [found["fast", t] for t in thresholds]
        exact = found["exact", 2]
        cells = [name(key)] + [f"{1000 * r['ms']:.0f}" for r in [*fast, exact]]
        cells += [", ".join(f"{r['nodes'] / r['fresh_nodes']:.2f}" for r in fast), share_text(max(error(r) for r in fast)), share_text(error(exact))]
        yield "| " + " | ".join(cells) + " |"


def describe(row):
    p = row["parameters"]
    if row["method"] == "shadowcut":
        more = "".join(f", {k.replace('_', ' ')} {v:g}" for k, v in dials(row).items())
        return f"{p['kernel']}, {p['form']}{more}" + (", random order" if is_other(row) else "") + (" (the reference)" if p.get("reference") else "")
    return f"shadow map, {p['side']} a side" if row["method"] == "map" else f"rays, {what(row)}"


def details(key, rows):
    yield f"<details><summary>{name(key)}: {rows[0]['facing_faces']} faces, {share_text(rows[0]['lit_area'] / rows[0]['facing_area'])} lit</summary>"
    yield ""
    yield "| method | ms | of it, structure | symmetric difference | area error | mean of a face, absolute | most of a face | wrong: lit + shadowed, missed | fragments | MB |"
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for r in rows:
        if r["method"] == "edits":
            continue
        if "skipped" in r:
            yield f"| {describe(r)} | left out: about {r['skipped']['estimate_ms'] / 1000:.0f} s | | | | | | | | |"
            continue
        cells = [describe(r), ms_text(r["ms"]), ms_text(r.get("structure_ms", r.get("build_ms"))), share_text(r["symmetric_share"]) if "symmetric_share" in r else "",
                 share_text(r["area_error_share"]), f"{r['mean_abs_area_error']:.1e}", share_text(r["max_share_of_a_face"]), wrong_text(r),
                 r.get("fragments", ""), f"{r['bytes'] / 1e6:.1f}" if "bytes" in r else ""]
        yield "| " + " | ".join(str(c) for c in cells) + " |"
    yield ""
    yield "</details>"
    yield ""


# ---- advice


def span(values, as_text):
    values = sorted(values)
    return f"{as_text(values[0])} to {as_text(values[-1])}"


def advice(groups):
    pairs = [(key, rows, ours(rows, "fast"), ours(rows, "exact")) for key, rows in groups.items()]
    moves = [1000 * r["ms"] for _, rows, _, _ in pairs for r in of(rows, "edits") if r["parameters"] == {"kernel": "fast", "join_threshold": 2}]
    percent = [cheapest(sampled(rows), 1e-2) for _, rows, _, _ in pairs]
    tenth = [cheapest(sampled(rows), 1e-3) for _, rows, _, _ in pairs]
    cost1 = [r["ms"] / f["ms"] for r, (_, _, f, _) in zip(percent, pairs) if r]
    cost2 = [r["ms"] / f["ms"] for r, (_, _, f, _) in zip(tenth, pairs) if r]
    cheaper = [name(key) for r, (key, _, f, _) in zip(percent, pairs) if r and r["ms"] < f["ms"]]
    exact = [e["ms"] / f["ms"] for _, _, f, e in pairs]
    welded = [ours(rows, "fast", "conforming")["ms"] / f["ms"] for _, rows, f, _ in pairs]
    single = [(r, f) for _, rows, f, _ in pairs for r in [rays(rows, 1)] if r]
    dense = {key: rows for key, rows in groups.items() if key[0] in ("spheres:12", "bunny")}
    few = [rays(rows, 1) for rows in dense.values()]
    few_cost = [rays(rows, 1)["ms"] / ours(rows, "fast")["ms"] for rows in dense.values()]
    map_best = [error(min(of(rows, "map"), key=error)) for _, rows, _, _ in pairs]
    yield "| use | advice |"
    yield "|---|---|"
    yield (f"| walkthrough, VR | Cut once with `fast`, merged, draw the fragments, and follow moves with `Engine`: {span(moves, '{:.0f}'.format)} us for the median move here, and edges that no screen "
           f"is too fine for. Where the light itself or most of the scene moves in every frame, draw a shadow map on the GPU: at 8192 a side or less its error stays at {span(map_best, share_text)}, but it costs no build. |")
    yield (f"| solar access, area reports | `fast`, merged: areas to 13 digits or more, while rays within 0.1 % take {span(cost2, times_text)} times as long (where they get there at all). "
           f"For sums within a per cent over many suns, rays spread by area take {statistics.median(cost1):.1f} times `fast`'s time in the median"
           + (f" and are the better choice in {', '.join(cheaper)}." if cheaper else ".") + " |")
    yield ("| lightmaps | For point lights and suns, rasterise the fragments: each texel gets its true share, without a ray. For area lights and soft shadows sample, since one tree is one point of the light; "
           f"and where texels are fewer than a face's {statistics.median(f['ms'] / max(1e-9, (r['ms'] - r['structure_ms']) / r['points']) / f['facing_faces'] for r, f in single):.0f} or so, a ray a texel costs less than cutting the face. |")
    yield (f"| drawings | `fast`, conforming ({span(welded, times_text)} times the time of merged) when outlines must close without T-junctions, merged otherwise; `exact` where a drawing must not change with the order of its parts. "
           "Samplers have no outlines to draw. |")
    yield (f"| validation | `exact`, pieces: no combinatorial mistake, in any order of insertion, for {span(exact, times_text)} times the time of `fast`. "
           "Rays are the second opinion that shares no code: where they differ from it by more than their own noise, look. |")
    yield (f"| previews | Sample, when faces are smaller than what you look at: one ray a face is within {span([error(r) for r in few], share_text)} on {' and '.join(k[0] for k in dense)} in {span(few_cost, '{:.2f}'.format)} of `fast`'s time. "
           "Where faces are large (rooms, cities) `fast` takes about as long as a few dozen rays a face, and there is nothing to preview. |")


def report(groups, figure):
    yield f"![time against error, for kernels, forms, rays and shadow maps]({figure})"
    yield ""
    yield "## At a glance"
    yield ""
    yield from glance(groups)
    yield ""
    yield "## Which to use"
    yield ""
    yield from advice(groups)
    yield ""
    yield "## Wrong faces"
    yield ""
    yield ("Faces reported lit though wholly shadowed + shadowed though wholly lit, then missed: faces of which over a hundredth is lit, or shadowed, and none of that is reported.")
    yield ""
    yield from wrong_faces(groups)
    yield ""
    yield "## Updates, and the join threshold"
    yield ""
    yield "Median time of an update in microseconds, over 100 moves of objects by up to a tenth of their size, by kernel and `Options::join_threshold`; and how far the result is then from the exact one."
    yield ""
    yield from edits(groups)
    yield ""
    yield "## Every row"
    yield ""
    for key, rows in groups.items():
        yield from details(key, rows)


def main():
    source, page, figure = sys.argv[1:4]
    with open(source, encoding="utf-8") as text_in:
        groups = group(json.load(text_in)["rows"])
    with open(page, encoding="utf-8") as text_in:
        before, rest = text_in.read().split(BEGIN)
    after = rest.split(END)[1]
    with open(figure, "w", encoding="utf-8") as out:
        out.write("\n".join(draw(groups)) + "\n")
    with open(page, "w", encoding="utf-8") as out:
        out.write(before + BEGIN + "\n\n" + "\n".join(report(groups, figure.split("/")[-1])).rstrip() + "\n\n" + END + after)


if __name__ == "__main__":
    main()
