#!/usr/bin/env python3
"""Figures of the source code: sizes of files, functions and classes, assertions, long lines.

    scripts/code_metrics.py [FOLDER...] [--json] [--build]

FOLDER is a git work tree of the project (none: the one that this script is in); several stand
side by side. Only files that git tracks are counted. --build also measures the CPU time of a
clean release build, and of scripts/run.sh in a fresh clone: minutes. Needs git and universal-ctags;
functions and classes are those that it finds in C and C++.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import tempfile

# Folders of src/core, each of which may include those before it.
ORDER = ["support", "numbers", "scene", "light_space", "predicates", "clipping", "facets",
         "svbsp", "fragments", "engine"]
LONG_FUNCTION = 40
LONG_LINE = 100
CODE = {".cpp", ".hpp", ".h", ".c", ".js", ".mjs", ".ts", ".py"}
LINED = CODE | {".md", ".cmake", ".sh"}  # and CMakeLists.txt
COMPILED = {".cpp", ".hpp", ".h", ".c"}


def tracked(root):
    listed = subprocess.run(["git", "-C", root, "ls-files", "-z"], check=True,
                            stdout=subprocess.PIPE, text=True).stdout
    paths = [pathlib.PurePosixPath(path) for path in listed.split("\0") if path]
    return [path for path in paths if (root / path).is_file()]


def lines_of(root, path):
    return (root / path).read_text(encoding="utf-8", errors="replace").splitlines()


def is_within(path, folder):
    return str(path).startswith(folder + "/")


def tags_of(root, paths):
    done = subprocess.run(
        ["ctags", "--output-format=json", "--fields=+neKZ", "--kinds-C=+p", "--kinds-C++=+p",
         "-f", "-", "-L", "-"], cwd=root, check=True, stdout=subprocess.PIPE, text=True,
        input="\n".join(map(str, paths)))
    tags = [json.loads(line) for line in done.stdout.splitlines()]
    return [tag for tag in tags if tag["_type"] == "tag" and not is_lambda(tag)]


def is_lambda(tag):
    return tag["kind"] == "function" and tag["name"].startswith("__anon")


def length(tag):
    return tag.get("end", tag["line"]) - tag["line"] + 1


def ninth_decile(values):
    return sorted(values)[-(-9 * len(values) // 10) - 1]  # the smallest that 90 % do not exceed


def largest_class(tags):
    """The class that declares most functions and data members (not those of classes within it)."""
    best = (-1, "", 0, 0)
    for tag in tags:
        if tag["kind"] not in ("class", "struct") or "end" not in tag:
            continue
        name = "::".join(filter(None, [tag.get("scope"), tag["name"]]))
        inside = [t for t in tags if t["path"] == tag["path"] and t.get("scope") == name
                  and tag["line"] <= t["line"] <= tag["end"]]
        functions = sum(t["kind"] in ("prototype", "function") for t in inside)
        members = sum(t["kind"] == "member" for t in inside)
        best = max(best, (functions + members, name, functions, members))
    return best[1:]


def includes_against_order(root, paths):
    """How many includes of src/core name a later folder; None while it has no folders."""
    core = [path for path in paths if is_within(path, "src/core")]
    folder_of = {path: path.parts[2] for path in core if path.parts[2] in ORDER}
    if not folder_of:
        return None
    count = 0
    for path, folder in folder_of.items():
        for line in lines_of(root, path):
            included = re.match(r'\s*#\s*include\s*"(?:.*/)?([^/"]+)/[^/"]+"', line)
            if included and included[1] in ORDER:
                count += ORDER.index(included[1]) > ORDER.index(folder)
    return count


def assertions(root, paths):
    code = [line.split("//")[0] for path in paths for line in lines_of(root, path)]
    return sum(len(re.findall(r"\b(?:assert|SHADOWCUT_ASSERT)\s*\(", line)) for line in code
               if not re.match(r"\s*#\s*define", line))


def long_lines(root, paths):
    """By ending: lines above LONG_LINE columns, but for rows of tables and lines with addresses."""
    counts = {}
    for path in paths:
        if path.suffix not in LINED and path.name != "CMakeLists.txt":
            continue
        is_table = path.suffix == ".md"
        count = sum(len(line) > LONG_LINE and "http" not in line
                    and not (is_table and line.lstrip().startswith("|"))
                    for line in lines_of(root, path))
        kind = path.suffix if path.suffix in LINED else path.name
        counts[kind] = counts.get(kind, 0) + count
    return counts


def metrics(root):
    paths = tracked(root)
    code = [path for path in paths if path.suffix in CODE]
    areas = sorted({f"src/{path.parts[1]}" for path in code if path.parts[0] == "src"})
    areas += ["include", "data", "tests", "bench", "web", "scripts"]
    sizes = {path: len(lines_of(root, path)) for path in code}
    out = {}
    for area in areas:
        here = [sizes[path] for path in code if is_within(path, area)]
        out[f"{area}: files"], out[f"{area}: lines"] = len(here), sum(here)

    tags = tags_of(root, [path for path in code if path.suffix in COMPILED])
    in_core = [tag for tag in tags if is_within(tag["path"], "src/core")]
    lengths = [length(tag) for tag in tags if tag["kind"] == "function"]
    core_lengths = [length(tag) for tag in in_core if tag["kind"] == "function"]
    out["src/core: functions"] = len(core_lengths)
    out[f"src/core: functions above {LONG_FUNCTION} lines"] = sum(
        n > LONG_FUNCTION for n in core_lengths)
    out[f"all: functions above {LONG_FUNCTION} lines"] = sum(n > LONG_FUNCTION for n in lengths)
    out["src/core: function lines, median"] = statistics.median(core_lengths)
    out["src/core: function lines, p90"] = ninth_decile(core_lengths)
    longest = max((tag for tag in in_core if tag["kind"] == "function"), key=length)
    out["src/core: longest function"] = f"{longest['name']} {length(longest)}"

    public = in_core + [tag for tag in tags if is_within(tag["path"], "include")]
    name, functions, members = largest_class(public)
    out["src/core, include: largest class"] = re.sub(r"^shadowcut::", "", name)
    out["  its functions"], out["  its data members"] = functions, members
    core = [path for path in code if is_within(path, "src/core")]
    largest = max(core, key=sizes.get)
    out["src/core: largest file"] = f"{largest.relative_to('src/core')} {sizes[largest]}"
    against = includes_against_order(root, paths)
    out["src/core: includes against the order"] = "flat" if against is None else against

    count = assertions(root, core)
    out["src/core: assertions"] = count
    core_lines = sum(map(sizes.get, core))
    out["src/core: lines per assertion"] = round(core_lines / count) if count else "-"
    for kind, count in sorted(long_lines(root, paths).items()):
        out[f"lines above {LONG_LINE} columns: {kind}"] = count
    out[f"lines above {LONG_LINE} columns: all"] = sum(long_lines(root, paths).values())
    return out


def cpu_seconds(command, folder):
    """User and system time of a command and all that it starts; no compiler cache."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "CCACHE_DISABLE": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def build_metrics(root):
    with tempfile.TemporaryDirectory() as folder:
        build, clone = f"{folder}/build", f"{folder}/clone"
        seconds = cpu_seconds(["cmake", "--preset", "release", "-B", build], root)
        seconds += cpu_seconds(["cmake", "--build", build], root)
        subprocess.run(["git", "clone", "-q", root, clone], check=True)
        run = cpu_seconds(["bash", "scripts/run.sh"], clone)
    return {"release build: CPU s": round(seconds, 1), "scripts/run.sh: CPU s": round(run, 1)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    here = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("folders", nargs="*", type=pathlib.Path, default=[here], metavar="FOLDER")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--build", action="store_true")
    arguments = parser.parse_args()
    columns = {}
    for folder in arguments.folders:
        columns[str(folder)] = metrics(folder.resolve())
        if arguments.build:
            columns[str(folder)].update(build_metrics(folder.resolve()))
    if arguments.json:
        print(json.dumps(columns, indent=1))
        return
    names = list(dict.fromkeys(name for column in columns.values() for name in column))
    width = max(map(len, names)) + 2
    if len(columns) > 1:
        heads = [pathlib.Path(folder).resolve().name for folder in columns]
        print(" " * width + "".join(f"{head:>28}" for head in heads))
    for name in names:
        values = [str(column.get(name, "")) for column in columns.values()]
        print(name.ljust(width) + "".join(f"{value:>28}" for value in values))


if __name__ == "__main__":
    main()
