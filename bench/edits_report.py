#!/usr/bin/env python3
"""Writes docs/speed.md's tables of updates from a run of shadowcut_bench_edits:

    bench/edits_report.py bench/baseline/edits.json > tables.md

Shares are of the median rebuild of the same row. What the paper had is its table 2, "compared to
U-SVBSP", second row of each scene.
"""
import json
import sys

PAPER = {
    "room:1 computer": (12, 9),
    "room:2 computer": (14, 6),
    "room:2 bookcase": (37, 18),
    "room:3 computer": (8, 5),
    "room:4 computer": (8, 3),
    "room:4 computer and desk": (11, 5),
}


def ms(value):
    return f"{value:.4f}" if value < 0.1 else f"{value:.3f}" if value < 10 else f"{value:.1f}"


def share(value):
    return f"{100 * value:.1f} %" if value >= 0.01 else f"{100 * value:.3g} %"


report = json.load(open(sys.argv[1]))
rows = report["rows"]

print(
    "| scene, object | moved of all faces | rebuild ms | first move ms | next move ms | "
    "first, share | next, share | the paper's |"
)
print("|---|---|---|---|---|---|---|---|")
for r in rows:
    if r["group"] == "table2":
        first, following = PAPER[r["name"]]
        print(
            f"| {r['name']} | {r['moved_faces']} of {r['faces']} | "
            f"{ms(r['rebuild_ms']['median'])} | {ms(r['first']['update_ms']['median'])} "
            f"| {ms(r['next']['update_ms']['median'])} | {share(r['first_share'])} | "
            f"{share(r['next_share'])} | {first} %, {following} % |"
        )

print()
print(
    "| row | faces | facing | moved | rebuild ms | first ms | next ms, median | 99.9 % | "
    "with the edit, median | 99.9 % | next, share | gone + new |"
)
print("|---|---|---|---|---|---|---|---|---|---|---|---|")
for r in rows:
    if r["group"] != "table2":
        update, total = r["next"]["update_ms"], r["next"]["edit_and_update_ms"]
        print(
            f"| {r['name']} | {r['faces']} | {r['facing_faces']} | {r['moved_faces']} | "
            f"{ms(r['rebuild_ms']['median'])} "
            f"| {ms(r['first']['update_ms']['median'])} | {ms(update['median'])} | "
            f"{ms(update['p999'])} | {ms(total['median'])} | {ms(total['p999'])} "
            f"| {share(r['next_share'])} | {r['next']['gone']:.0f} + {r['next']['new']:.0f} |"
        )

if "long" in report:
    print()
    print("| moves | median ms | 99.9 % | nodes | of a rebuild's | marked | MB | rebuild ms |")
    print("|---|---|---|---|---|---|---|---|")
    for p in report["long"]:
        print(
            f"| {p['moves']} | {ms(p['update_ms']['median'])} | {ms(p['update_ms']['p999'])} "
            f"| {p['nodes']} | {p['nodes'] / p['rebuild_nodes']:.3f} "
            f"| {p['marked_nodes']} | {p['bytes'] / 1e6:.1f} | {ms(p['rebuild_ms'])} |"
        )
