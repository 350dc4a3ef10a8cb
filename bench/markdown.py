#!/usr/bin/env python3
"""Wraps paragraphs and list items of Markdown at 100 columns. Tables, code, headings, pictures and
HTML stay as they are.

    bench/markdown.py FILE...
"""
import re
import sys
import textwrap

COLUMNS = 100
ITEM = re.compile(r"( *)([-*]|\d+\.) +")
# A word that would begin a list, a heading or a table at the start of a line.
BEGINS_BLOCK = re.compile(r" (?=([-+*|>]|#+|\d+[.)])( |$))")


def fill(text, first, rest):
    sticky = BEGINS_BLOCK.sub("\0", " ".join(text.split()))
    lines = textwrap.wrap(
        sticky, COLUMNS, initial_indent=first, subsequent_indent=rest,
        break_long_words=False, break_on_hyphens=False,
    )
    return [line.replace("\0", " ") for line in lines]


def is_fixed(line):
    return line.startswith(("|", "#", "![", "<", "```", "*Every ")) or not line.strip()


def wrap(text):
    out, paragraph, indents, in_code = [], [], ("", ""), False

    def flush():
        if paragraph:
            out.extend(fill(" ".join(paragraph), *indents))
        paragraph.clear()

    for line in text.split("\n"):
        if line.startswith("```"):
            flush()
            in_code = not in_code
            out.append(line)
            continue
        item = ITEM.match(line)
        if in_code or is_fixed(line) or (line.startswith("    ") and not paragraph):
            flush()
            out.append(line)
        elif item:
            flush()
            indents = (item[0], " " * len(item[0]))
            paragraph.append(line[len(item[0]):])
        else:
            if not paragraph:
                indents = ("", "")
            paragraph.append(line)
    flush()
    return "\n".join(out)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        with open(name, encoding="utf-8") as file:
            text = file.read()
        with open(name, "w", encoding="utf-8") as file:
            file.write(wrap(text))
