#!/usr/bin/env python3
"""Writes docs/speed.md's table from a run of shadowcut_bench:

    bench/report.py bench/baseline/cast.json > table.md

A row a scene: the minimum over the repetitions, on one and on two threads. Growth is the exponent
between a scene and the next smaller one of its kind.
"""
import json
import math
import sys

rows = {}
for b in json.load(open(sys.argv[1]))["benchmarks"]:
    if b.get("run_type") != "iteration":
        continue
    name, threads = b["name"].split("/")[:2]
    best = rows.setdefault(name, {}).get(threads)
    if best is None or b["build_ms"] + b["emit_ms"] < best["build_ms"] + best["emit_ms"]:
        rows[name][threads] = b

print(
    "| scene | faces | build ms | emit ms | ns a face | two threads, ms | nodes | lit + "
    "shadowed fragments | MB | growth |"
)
print("|---|---|---|---|---|---|---|---|---|---|")
last = {}
for name, r in rows.items():
    one, two = r["threads:1"], r.get("threads:2", r["threads:1"])
    if one["hash48"] != two["hash48"]:
        sys.exit(f"{name}: different results on one and two threads")
    total = one["build_ms"] + one["emit_ms"]
    kind = name.split(":")[0]
    growth = ""
    if kind in last and one["faces"] > 1.5 * last[kind][0]:
        growth = f"{math.log(total / last[kind][1]) / math.log(one['faces'] / last[kind][0]):.2f}"
    last[kind] = (one["faces"], total)
    print(
        f"| {name} | {one['faces']:.0f} | {one['build_ms']:.2f} | {one['emit_ms']:.2f} | "
        f"{one['ns_per_face']:.0f} | {two['build_ms'] + two['emit_ms']:.2f} "
        f"| {one['nodes']:.0f} | {one['lit']:.0f} + {one['shadowed']:.0f} | "
        f"{one['bytes'] / 1e6:.1f} | {growth} |"
    )
