#!/usr/bin/env python3
"""Writes docs/accuracy.md's part of the dial, and its figure, from a run of shadowcut_bench_dial:

    bench/dial_report.py bench/baseline/dial.json docs/accuracy.md docs/accuracy-methods.svg

Of accuracy.md only what stands between the two lines BEGIN and END is replaced. Errors are shares
of the area turned to the light: for fragments that of the symmetric difference with the exact
regions, for samplers the sum over faces of what their areas are off by.
"""
import json
import math
import statistics
import sys

import markdown
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
    return {
        k: v
        for k, v in row["parameters"].items()
        if k not in ("kernel", "form", "order", "reference")
    }


def ours(rows, kernel, form="merged"):
    for r in of(rows, "shadowcut"):
        if (
            r["parameters"]["kernel"] == kernel
            and r["parameters"]["form"] == form
            and not is_other(r)
            and not dials(r)
        ):
            return r
    return None


def turned(rows, dial, value):
    """Fast, merged, with one of the dials turned."""
    return next(
        (
            r
            for r in of(rows, "shadowcut")
            if r["parameters"]["kernel"] == "fast" and dials(r) == {dial: value}
        ),
        None,
    )


def rays(rows, samples):
    return next((r for r in of(rows, "rays") if r["parameters"]["samples"] == samples), None)


def error(row):
    return (
        row["area_error_share"]
        if row["method"] in ("rays", "rays by area", "map")
        else row["symmetric_share"]
    )


# ---- the figure

COLUMNS, WIDTH, PLOT_HEIGHT, GAP_X, GAP_Y = 3, 1110, 250, 30, 58
LEFT, TOP = 74, 118
FIRST, FLOOR = 0, (
    -12,
    -18,
)  # powers of ten: where the upper part of the axis of errors begins, and the lower part
BREAK = (0.72, 0.80)  # shares of a panel's height between which the axis is broken
KERNELS = {"fast": "#1b6ca8", "exact": "#14724a"}
FORMS = {"pieces": "triangle", "merged": "diamond", "conforming": "square"}
DIALS = {
    "min_area_share": ' stroke-opacity="0.55"',
    "min_solid_angle": ' stroke-opacity="0.55" stroke-dasharray="3 3"',
}
SAMPLERS = {
    "rays": ("#d9822b", "circle", False),
    "rays by area": ("#b03a2e", "circle", True),
    "map": ("#777", "square", False),
}


class BrokenAxis:
    """Errors on two logarithmic stretches, downwards."""

    def __init__(self, last, top, height):
        self.last = last
        self.upper = Axis(last, FIRST, top + BREAK[0] * height, top)
        self.lower = Axis(FLOOR[1], FLOOR[0], top + height, top + BREAK[1] * height)
        self.cut = top + 0.5 * (BREAK[0] + BREAK[1]) * height

    def __call__(self, value):
        power = math.log10(max(value, 1e-300))
        if power >= self.last:
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
        if at < left + width - 1:  # the last would run into the next panel's first
            yield text(at, top + PLOT_HEIGHT + 17, time_text(value), "middle", 11, SOFT)
    for power in [*range(FIRST, y.last - 1, -1), *range(FLOOR[0], FLOOR[1] - 1, -2)]:
        at = y(10.0**power)
        yield line(left, at, left + width, at, GRID, 0.8)
        if is_first and power % 2 == 0:
            yield text(left - 8, at + 4, power_text(power), "end", 11.5, SOFT)
    yield (
        f'<rect x="{left}" y="{top}" width="{width:.1f}" height="{PLOT_HEIGHT}" fill="none" '
        f'stroke="{SOFT}"/>'
    )
    for side in (left, left + width):
        yield f'<rect x="{side - 4:.1f}" y="{y.cut - 4:.1f}" width="8" height="8" fill="white"/>'
        for shift in (-4, 4):
            yield line(side - 5, y.cut + shift + 2.5, side + 5, y.cut + shift - 2.5, SOFT)


def sampler(rows, method, x, y):
    """A curve; the ends of those of rays a face and of the map say what they are."""
    colour, shape, is_hollow = SAMPLERS[method]
    rows = of(rows, method)
    at = [(x(r["ms"]), y(error(r))) for r in rows]
    yield path(at, colour, ' stroke-opacity="0.55"')
    for px, py in at:
        yield mark(shape, px, py, colour, 3.4, is_hollow)
    if method == "rays":
        for (px, py), r in list(zip(at, rows))[:: max(1, len(rows) - 1)]:
            yield text(px + 7, py - 6, r["parameters"]["samples"], size=10.5, colour=colour)
    if method == "map" and rows:
        yield text(
            at[0][0] + 7, at[0][1] - 2, rows[0]["parameters"]["side"], size=10.5, colour=colour
        )
        yield text(
            at[-1][0] + 7, at[-1][1] + 9, rows[-1]["parameters"]["side"], size=10.5, colour=colour
        )


def engine(rows, x, y):
    names = []
    for kernel, colour in KERNELS.items():
        mine = [
            r
            for r in of(rows, "shadowcut")
            if r["parameters"]["kernel"] == kernel
            and not is_other(r)
            and not r["parameters"].get("reference")
            and "coplanarity_tolerance" not in r["parameters"]
        ]
        for dial in DIALS:
            yield path(
                [(x(r["ms"]), y(error(r))) for r in mine if dial in r["parameters"]],
                colour,
                DIALS[dial],
            )
        for r in sorted(mine, key=lambda r: r["parameters"]["form"] == "merged"):
            yield mark(
                FORMS[r["parameters"]["form"]],
                x(r["ms"]),
                y(error(r)),
                colour,
                2.6 if dials(r) else 4.4,
                r["parameters"]["form"] != "merged",
            )
        best = ours(rows, kernel)
        if best:
            names.append((x(best["ms"]), y(error(best)), kernel, colour))
    for px, py, kernel, colour in names:
        shift_x, shift_y, anchor = {
            "fast": (0, -11, "middle"),
            "exact": (0, 19, "middle"),
        }[kernel]
        yield text(px + shift_x, py + shift_y, kernel, anchor, 12, colour, ' font-weight="bold"')


def panel(key, rows, x, y, left, top, width, is_first):
    scene = rows[0]
    yield from frame(x, y, left, top, width, is_first)
    yield text(left, top - 8, key[0], size=13.5, more=' font-weight="bold"')
    yield text(
        left + width, top - 8, f'{scene["facing_faces"]} faces to the light', "end", 11.5, SOFT
    )
    for method in ("map", "rays by area", "rays"):
        yield from sampler(rows, method, x, y)
    yield from engine(rows, x, y)


def legend(kernels, dials_shown):
    at, y = LEFT, 62
    for method, words in (
        ("rays", "Embree rays, 1 to 4096 a face"),
        ("rays by area", "the same number, spread by area"),
        ("map", "shadow map, 256 to 8192 a side"),
    ):
        colour, shape, is_hollow = SAMPLERS[method]
        yield line(at, y - 4, at + 26, y - 4, colour, 2, ' stroke-opacity="0.55"') + mark(
            shape, at + 13, y - 4, colour, 3.4, is_hollow
        )
        yield text(at + 33, y, words, size=12.5)
        at += 262
    at, y = LEFT, 84
    yield text(at, y, "shadowcut:", size=12.5)
    at += 68
    for kernel in kernels:
        yield mark("diamond", at + 13, y - 4, KERNELS[kernel], 4.4) + text(
            at + 25, y, kernel, size=12.5
        )
        at += 74
    at += 12
    for form, shape in FORMS.items():
        yield mark(shape, at + 13, y - 4, INK, 4.2, form != "merged") + text(
            at + 27, y, form, size=12.5
        )
        at += 92
    at += 12
    colour = KERNELS["fast"]
    for dial, words in (
        ("min_area_share", "fast, smallest feature by area"),
        ("min_solid_angle", "by solid angle"),
    ):
        if dial not in dials_shown:
            continue
        yield line(at + 14, y - 4, at + 40, y - 4, colour, 2, DIALS[dial]) + mark(
            "diamond", at + 27, y - 4, colour, 2.6
        )
        yield text(at + 47, y, words, size=12.5)
        at += 238


def draw(groups):
    shown = [(key, rows) for key, rows in groups.items() if key[1] == "point"]
    every = [r["ms"] for _, rows in shown for r in rows if "ms" in r and r["method"] != "edits"]
    low, high = math.floor(math.log10(min(every))), math.ceil(math.log10(max(every)))
    last = min(
        math.floor(math.log10(e))
        for _, rows in shown
        for r in rows
        if "ms" in r and r["method"] != "edits"
        if "coplanarity_tolerance" not in r["parameters"]
        for e in [error(r)]
        if e > 10.0 ** FLOOR[0]
    )
    width = (WIDTH - LEFT - 24 - (COLUMNS - 1) * GAP_X) / COLUMNS
    lines = math.ceil(len(shown) / COLUMNS)
    height = TOP + lines * (PLOT_HEIGHT + GAP_Y) + 16
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 '
        f'{WIDTH} {height}" font-family="sans-serif">'
    )
    yield f'<rect width="{WIDTH}" height="{height}" fill="white"/>'
    yield text(LEFT, 32, "Time against error: lower left is better", size=18)
    kernels = [
        k
        for k in KERNELS
        if any(
            r["parameters"].get("kernel") == k for _, rows in shown for r in of(rows, "shadowcut")
        )
    ]
    turned_dials = {d for _, rows in shown for r in of(rows, "shadowcut") for d in dials(r)}
    yield from legend(kernels, turned_dials)
    for i, (key, rows) in enumerate(shown):
        left, top = LEFT + i % COLUMNS * (width + GAP_X), TOP + i // COLUMNS * (PLOT_HEIGHT + GAP_Y)
        yield from panel(
            key,
            rows,
            Axis(low, high, left, left + width),
            BrokenAxis(last, top, PLOT_HEIGHT),
            left,
            top,
            width,
            i % COLUMNS == 0,
        )
    yield text(WIDTH / 2, height - 12, "time of the whole job on one thread", "middle", 13.5)
    middle = TOP + lines * (PLOT_HEIGHT + GAP_Y) / 2
    yield text(
        20,
        middle,
        "error, as a share of the area turned to the light",
        "middle",
        13.5,
        more=f' transform="rotate(-90 20 {middle:.1f})"',
    )
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
    return f"{100 * share:.0f} %" if share >= 0.0995 else f"{100 * share:.2g} %"


def times_text(factor):
    return f"{factor:.0f}" if factor >= 9.95 else f"{factor:.1f}"


def name(key):
    return key[0] + (" (sun)" if key[1] == "sun" else "")


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
    return (
        f"map {p['side']}"
        if row["method"] == "map"
        else f"{p['samples']} a face{', by area' if row['method'] == 'rays by area' else ''}"
    )


def glance(groups):
    yield (
        "| scene | faces | fast, ms | error | exact, ms | best rays in fast's time | their error "
        "| quickest rays within 1 %, x fast's time | within 0.1 % | best map: side, ms | its "
        "error |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for key, rows in groups.items():
        fast, exact = ours(rows, "fast"), ours(rows, "exact")
        same = in_time(sampled(rows), fast["ms"])
        cells = [
            name(key),
            rows[0]["facing_faces"],
            ms_text(fast["ms"]),
            share_text(error(fast)),
            ms_text(exact["ms"]),
            what(same) if same else "none",
            share_text(error(same)) if same else "",
        ]
        for limit in (1e-2, 1e-3):
            best = cheapest(sampled(rows), limit)
            cells.append(
                f"{what(best)}: {times_text(best['ms'] / fast['ms'])}" if best else "not reached"
            )
        best = min(of(rows, "map"), key=error)
        cells += [f"{best['parameters']['side']}, {ms_text(best['ms'])}", share_text(error(best))]
        yield "| " + " | ".join(str(c) for c in cells) + " |"


def wrong_text(row):
    return (
        f"{row['lit_where_shadowed']} + {row['shadowed_where_lit']}, {row['missed']}" if row else ""
    )


def wrong_faces(groups):
    yield "| scene | faces | fast | exact | 16 rays | 256 rays | 4096 rays | map 1024 | map 8192 |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for key, rows in groups.items():
        maps = {r["parameters"]["side"]: r for r in of(rows, "map")}
        chosen = [
            ours(rows, "fast"),
            ours(rows, "exact"),
            rays(rows, 16),
            rays(rows, 256),
            rays(rows, 4096),
            maps.get(1024),
            maps.get(8192),
        ]
        yield f"| {name(key)} | {rows[0]['facing_faces']} | " + " | ".join(
            wrong_text(r) or "too slow" for r in chosen
        ) + " |"


SHARES = (1e-4, 1e-2, 1e-1)  # of the mean face: smallest features shown, where they were measured


def share_of(row, key):
    return row[key] / row["facing_area"]


def has_smallest(groups):
    return all(turned(rows, "min_area_share", s) for rows in groups.values() for s in SHARES)


def fewer(groups):
    shares = SHARES if has_smallest(groups) else ()
    heads = [f"smallest {s:g}: x time | x fragments | dropped | missed" for s in shares]
    yield "| " + " | ".join(["scene", "fast: error", "uncertain", *heads]) + " |"
    yield "|" + "---|" * (3 + 4 * len(shares))
    for key, rows in groups.items():
        fast = ours(rows, "fast")
        cells = [
            name(key),
            share_text(error(fast)),
            share_text(share_of(fast, "undecided_area")),
        ]
        for s in shares:
            r = turned(rows, "min_area_share", s)
            cells += [f"{r[k] / fast[k]:.2f}" for k in ("ms", "fragments")]
            cells += [share_text(share_of(r, "dropped_area")), r["missed"]]
        yield "| " + " | ".join(str(c) for c in cells) + " |"


def bounds(groups):
    """Whether what is said to be undecided holds the errors."""
    rows = [r for rows in groups.values() for r in of(rows, "shadowcut") if "undecided_area" in r]
    broken = [
        f"{name((r['scene'], r['light']))}, {r['parameters']['form']} "
        f"({share_text(error(r))} against {share_text(share_of(r, 'undecided_area'))}, "
        f"{r['beyond_undecided']} faces)"
        for r in rows
        if r["symmetric_difference"] > r["undecided_area"] or r["beyond_undecided"]
    ]
    held = "of the whole and of every face" if not broken else "but not in " + "; ".join(broken)
    yield (
        f"Kernel `fast`: in {len(rows) - len(broken)} of {len(rows)} rows the error is within "
        f"what `Engine::uncertain_area` says, {held}."
    )
    loose = [
        name((r["scene"], r["light"]))
        for r in rows
        if r["parameters"] == {"kernel": "fast", "form": "merged"}
        and r["undecided_area"] > 0.5 * r["facing_area"]
    ]
    if loose:
        yield (
            f"In {', '.join(loose)} that bound says nothing of kernel `fast`: see "
            "[below](#how-it-was-measured)."
        )


def shared_planes(groups):
    yield (
        "| model | kernel | facets put into a shared plane | x time | x nodes | x fragments | "
        "change of the lit region |"
    )
    yield "|---|---|---|---|---|---|---|"
    for key, rows in groups.items():
        for r in of(rows, "shadowcut"):
            if "coplanarity_tolerance" in r["parameters"]:
                own = ours(rows, r["parameters"]["kernel"])
                cells = [
                    name(key),
                    r["parameters"]["kernel"],
                    r["aligned_facets"],
                    *(f"{r[k] / own[k]:.2f}" for k in ("ms", "nodes", "fragments")),
                    share_text(error(r)),
                ]
                yield "| " + " | ".join(str(c) for c in cells) + " |"


def edits(groups):
    thresholds = (0, 2, 6, 16)
    yield "| scene | " + " | ".join(
        f"fast, {t}" for t in thresholds
    ) + " | exact, 2 | nodes against a fresh build, " + ", ".join(
        map(str, thresholds)
    ) + " | error, fast | exact |"
    yield "|---|" + "---|" * (len(thresholds) + 4)
    for key, rows in groups.items():
        found = {
            (r["parameters"]["kernel"], r["parameters"]["join_threshold"]): r
            for r in of(rows, "edits")
        }
        if not found:
            continue
        fast = [found["fast", t] for t in thresholds]
        exact = found["exact", 2]
        cells = [name(key)] + [f"{1000 * r['ms']:.0f}" for r in [*fast, exact]]
        cells += [
            ", ".join(f"{r['nodes'] / r['fresh_nodes']:.2f}" for r in fast),
            share_text(max(error(r) for r in fast)),
            share_text(error(exact)),
        ]
        yield "| " + " | ".join(cells) + " |"


def describe(row):
    p = row["parameters"]
    if row["method"] == "shadowcut":
        more = "".join(f", {k.replace('_', ' ')} {v:g}" for k, v in dials(row).items())
        return (
            f"{p['kernel']}, {p['form']}{more}"
            + (", random order" if is_other(row) else "")
            + (" (the reference)" if p.get("reference") else "")
        )
    return f"shadow map, {p['side']} a side" if row["method"] == "map" else f"rays, {what(row)}"


def structure_ms(row):
    """The engine's parts are by the steady clock, which on a busy machine runs ahead of the
    processor time of the whole.
    """
    return (
        row["structure_ms"]
        if "structure_ms" in row
        else row["ms"] * row["build_ms"] / (row["build_ms"] + row["emit_ms"])
    )


def details(key, rows):
    yield (
        f"<details><summary>{name(key)}: {rows[0]['facing_faces']} faces, "
        f"{share_text(rows[0]['lit_area'] / rows[0]['facing_area'])} lit</summary>"
    )
    yield ""
    yield (
        "| method | ms | of it, structure | symmetric difference | area error | mean of a face, "
        "absolute | most of a face | wrong: lit + shadowed, missed | uncertain | dropped | "
        "fragments | MB |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for r in rows:
        if r["method"] == "edits":
            continue
        if "skipped" in r:
            yield (
                f"| {describe(r)} | left out: about {r['skipped']['estimate_ms'] / 1000:.0f} s | "
                "| | | | | | | | | |"
            )
            continue
        cells = [
            describe(r),
            ms_text(r["ms"]),
            ms_text(structure_ms(r)),
            share_text(r["symmetric_share"]) if "symmetric_share" in r else "",
            share_text(r["area_error_share"]),
            f"{r['mean_abs_area_error']:.1e}",
            share_text(r["max_share_of_a_face"]),
            wrong_text(r),
            *(
                share_text(share_of(r, k)) if k in r else ""
                for k in ("undecided_area", "dropped_area")
            ),
            r.get("fragments", ""),
            f"{r['bytes'] / 1e6:.1f}" if "bytes" in r else "",
        ]
        yield "| " + " | ".join(str(c) for c in cells) + " |"
    yield ""
    yield "</details>"
    yield ""


# ---- advice


def span(values, as_text):
    low, high = as_text(min(values)), as_text(max(values))
    return low if low == high else f"{low} to {high}"


def middle_span(values, as_text):
    """Noise makes the ends of a span; the median says more."""
    return f"{as_text(statistics.median(values))} ({span(values, as_text)})"


def rays_by_area(rows, samples):
    return next(
        (r for r in of(rows, "rays by area") if r["parameters"]["samples"] == samples), None
    )


def advice(groups):
    scenes = list(groups.items())
    fast = {key: ours(rows, "fast") for key, rows in scenes}

    def against_fast(chosen):
        """Of a row of each scene, or none: its time by fast's."""
        return [row["ms"] / fast[key]["ms"] for (key, _), row in zip(scenes, chosen) if row]

    percent, tenth = (
        [cheapest(sampled(rows), limit) for _, rows in scenes] for limit in (1e-2, 1e-3)
    )

    def quicker(chosen):
        """Scenes in which these rows take no longer than fast, in words."""
        names = list(
            dict.fromkeys(
                key[0]
                for (key, _), row in zip(scenes, chosen)
                if row and row["ms"] <= fast[key]["ms"]
            )
        )
        return ", ".join(names) or "none of the scenes"

    moves = [
        r["ms"]
        for _, rows in scenes
        for r in of(rows, "edits")
        if r["parameters"] == {"kernel": "fast", "join_threshold": 2}
    ]
    maps = [error(min(of(rows, "map"), key=error)) for _, rows in scenes]
    # So many rays take the time of cutting a face.
    worth = statistics.median(
        fast[key]["ms"] / row["facing_faces"] * row["points"] / row["sample_ms"]
        for key, rows in scenes
        for row in [rays(rows, 64)]
    )
    few = [rays_by_area(rows, 4) for _, rows in scenes]
    exact = against_fast([ours(rows, "exact") for _, rows in scenes])
    welded = against_fast([ours(rows, "fast", "conforming") for _, rows in scenes])

    def beside_fast(chosen, figure):
        return middle_span(
            [row[figure] / fast[key][figure] for (key, _), row in zip(scenes, chosen)],
            "{:.2f}".format,
        )

    small, large = (
        [turned(rows, "min_area_share", s) for _, rows in scenes] for s in (SHARES[0], SHARES[-1])
    )
    yield "| use | advice |"
    yield "|---|---|"
    yield (
        "| walkthrough, VR | Cut once with `fast`, merged, and draw the fragments: no "
        "screen is too fine for their edges, and a moved object costs "
        f"{span(moves, '{:.2g}'.format)} ms in the median here, by what it touches. "
        "Where the light or most of the scene moves in every frame, a shadow map on the GPU "
        f"is the better choice: it needs no build, and its errors, {span(maps, share_text)} "
        "of the area at its best here, are a texel wide. |"
    )
    yield (
        "| solar access, area reports | `fast`, merged: areas to "
        f"{-math.ceil(math.log10(max(error(f) for f in fast.values())))} digits, where rays "
        f"within 0.1 % take {span(against_fast(tenth), times_text)} times as long, "
        f"if they get there at all, and are as quick in {quicker(tenth)} only. For totals "
        "within a per cent sampling is often the better choice: the right number of rays, "
        f"spread by area, takes {span(against_fast(percent), times_text)} times as long as "
        "`fast`, "
        f"and no longer in {quicker(percent)}. |"
    )
    yield (
        "| lightmaps | For point lights and suns, draw the fragments into the texels: each "
        "gets its true share of light, without a ray. For area lights and soft shadows "
        "sample, since a tree is of one point of the light; "
        f"and sample where a face has fewer than {worth:.0f} texels or so, since that many "
        "rays take the time of cutting it. |"
    )
    yield (
        f"| drawings | `fast`, merged, or conforming ({span(welded, times_text)} times as "
        "long) where outlines must meet without T-junctions; `exact` where the drawing must "
        "not depend on the order of its parts. "
        "Samplers have no outlines to draw. |"
    )
    yield (
        "| validation | `exact`: no combinatorial mistake in any order of insertion, for "
        f"{span(exact, times_text)} times the time of `fast`. "
        "Rays are a second opinion that shares no code with it: look where they differ by "
        "more than their noise, and expect faces that touch only up to rounding there. |"
    )
    yield (
        "| previews | Sample: four rays a face, spread by area, are within "
        f"{span([error(r) for r in few], share_text)} in "
        f"{span(against_fast(few), '{:.2f}'.format)} of `fast`'s time, and need not be asked "
        "of faces that are not seen. "
        "But they miss the shadow or the light of "
        f"{span([r['missed'] / r['facing_faces'] for r in few], share_text)} of the faces "
        "altogether, so go over to `fast` as soon as single faces count. |"
    )
    slivers = (
        "| slivers in the way | `min_feature`: fragments below a size are not handed out, so there "
        "are fewer to draw, store or mesh. The tree and all other fragments are the same. "
    )
    if has_smallest(groups):
        small, large = (
            [turned(rows, "min_area_share", s) for _, rows in scenes]
            for s in (SHARES[0], SHARES[-1])
        )
        dropped = [
            span([share_of(r, "dropped_area") for r in chosen], share_text)
            for chosen in (small, large)
        ]
        lost = span([r["missed"] / r["facing_faces"] for r in large], share_text)
        slivers += (
            f"A ten-thousandth of the mean face leaves {beside_fast(small, 'fragments')} of the "
            f"fragments and drops {dropped[0]} of the area. A tenth of it leaves "
            f"{beside_fast(large, 'fragments')}, drops {dropped[1]}, and loses the light or the "
            f"shadow of {lost} of the faces: at that price sampling is the better choice. "
        )
    yield slivers.rstrip() + " |"


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
    yield (
        "Faces reported lit, though wholly shadowed + shadowed in part, though wholly lit; then, "
        "missed: of the face over a hundredth is lit, or shadowed, and nothing of that is "
        "reported."
    )
    yield ""
    yield from wrong_faces(groups)
    yield ""
    yield "## Uncertain area"
    yield ""
    words = "Uncertain: the upper bound that the kernel itself reports (`Engine::uncertain_area`)."
    if has_smallest(groups):
        words += (
            " Then the smallest feature (`Options::min_feature`) by area, as a share of the mean "
            "face turned to the light. Dropped: neither lit nor shadowed (`FaceArea::dropped`). "
            "Missed as above. By solid angle: in the figure, and in the rows at the end."
        )
    yield words
    yield ""
    yield from fewer(groups)
    yield ""
    yield " ".join(bounds(groups))
    yield ""
    yield "## Coordinates that were once float"
    yield ""
    yield (
        "`Scene::coplanarity_tolerance` at 1e-6 instead of 1e-12, against the same kernel "
        "without; form merged."
    )
    yield ""
    yield from shared_planes(groups)
    yield ""
    yield "## Updates, and the join threshold"
    yield ""
    yield (
        "Median time of an update in microseconds, over 100 moves of objects by up to a tenth of "
        "their size, by kernel and `Options::Tuning::join_threshold`; and how far the result is "
        "then from the exact one."
    )
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
        out.write(
            before
            + BEGIN
            + "\n\n"
            + markdown.wrap("\n".join(report(groups, figure.split("/")[-1])).rstrip())
            + "\n\n"
            + END
            + after
        )


if __name__ == "__main__":
    main()
