#!/usr/bin/env python3
"""Writes docs/accuracy.md's part of the extremes, from what tests/system/extremes_test.cpp records:

    SHADOWCUT_RECORD=extremes.json extremes_test
    bench/extremes_report.py extremes.json docs/accuracy.md

Of accuracy.md only what stands between the two lines BEGIN and END is replaced. What the kinds of
scenes are is read from tests/support/exact_scenes.hpp.
"""
import json
import pathlib
import re
import sys

import markdown
from dial_report import share_text

BEGIN, END = "<!-- extremes -->", "<!-- /extremes -->"
KINDS = pathlib.Path(__file__).parent.parent / "tests" / "support" / "exact_scenes.hpp"


def sentences():
    """What each kind is, in the header's order."""
    body = re.search(
        r"enum class ExactKind \{(.*?)\};", KINDS.read_text(encoding="utf-8"), re.DOTALL
    ).group(1)
    return dict(re.findall(r"^\s*(\w+),?\s*// (.*)$", body, re.MULTILINE))


def of_area(share):
    """Errors may be many times the area:

    of a face whose area a kernel takes for nothing, for one.
    """
    if share is None:
        return "none"
    return share_text(share) if share <= 1 else f"{share:.3g} x the area"


def report(rows):
    found = {(r["kind"], r["kernel"]): r for r in rows}
    yield "| kind | what it is | scenes, faces | exact | fast: error | bound | wrong faces |"
    yield "|---|---|---|---|---|---|---|"
    for kind, words in sentences().items():
        if (kind, "fast") not in found:
            continue
        fast = found[kind, "fast"]
        cells = [
            kind.replace("_", " "),
            words,
            f"{fast['scenes']}, {fast['faces']}",
            "equal",
            of_area(fast["error"]),
            of_area(fast["bound"]),
            fast["wrong_faces"],
        ]
        yield "| " + " | ".join(str(c) for c in cells) + " |"
    fast = [r for r in rows if r["kernel"] == "fast"]
    faces = sum(r["faces"] for r in fast)
    outside = ", ".join(
        f"{r['kind'].replace('_', ' ')} ({r['beyond']})" for r in fast if r["beyond"]
    )
    yield ""
    yield (
        f"Kernel `fast`: of {faces} faces {sum(r['wrong_faces'] for r in fast)} are wrong, "
        f"and {sum(r['beyond'] for r in fast)} off by more than the kernel's own bound"
        + (f": {outside}." if outside else ".")
    )


def main():
    source, page = sys.argv[1:3]
    with open(source, encoding="utf-8") as text_in:
        rows = json.load(text_in)
    with open(page, encoding="utf-8") as text_in:
        before, rest = text_in.read().split(BEGIN)
    after = rest.split(END)[1]
    with open(page, "w", encoding="utf-8") as out:
        written = markdown.wrap("\n".join(report(rows)))
        out.write(before + BEGIN + "\n\n" + written + "\n\n" + END + after)


if __name__ == "__main__":
    main()
