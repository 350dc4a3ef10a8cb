#!/usr/bin/env python3
"""Hashes of all output of a build, to show that a change leaves results the same to the bit.

    scripts/output_hashes.py BUILD [--wasm WEB_DIR] [-o FILE.json] [--compare FILE.json]
                             [--keep FOLDER] [--only WORDS]

BUILD is a build folder (build/release) with the programs and the C library; WEB_DIR is
web/shadowcut after the WebAssembly build. Writes one JSON object: name -> SHA-256, sorted.
--compare prints each name whose hash differs, is missing or is new; exit status 1 if any differs
or is missing. --keep keeps the files that were hashed, to look at a difference; --only runs
the jobs whose names hold WORDS, and compares no others.

The names: `cast/...`, `svg/...`, `replay/...`, `combined/...`, `compare/...`, `inspect/...` and
`render/...` are files of the program's; `c/...` and `wasm/...` come from output_hashes_c.py and
output_hashes.mjs, which do the same things, so that both should have the same hashes.
"""
import argparse
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

# Keys of the program's JSON, new -> old: mapped back to the old names before hashing.
RENAMED_KEYS = {}
# Not hashed: keys that depend on the machine, and all that end in _ms.
DROPPED_KEYS = {"bytes", "memory_bytes", "threads"}

KERNELS = ["fast", "exact"]
FORMS = ["pieces", "merged", "conforming"]
GENERATED = ["slater:3", "slater:10", "tetrahedron:6", "city:16", "city:40", "spheres:6",
             "triangles:1000", "branch:5", "sphere256", "solids96", "tetrahedra752:1",
             "tetrahedra752:2", "cubes1502", "branch2878", "spheres2037:3"]
SUN = "sun:0.37,0.23,-0.9"
DRAWN = ["room1", "room4", "city8", "tetrahedron3", "branch3", "spheres5"]
COMBINED = ["room1", "room3", "city8", "tetrahedron3", "triangles200", "branch3"]
COMPARED = ["room1", "room2", "tetrahedron3", "city8", "branch3", "slater3"]
# Scene, seed and number of edits of scripts for replay, and of those for the C library.
REPLAYED = [("room1", 1, 300), ("room4", 2, 300), ("tetrahedron3", 3, 200), ("city8", 4, 300),
            ("spheres5", 5, 100), ("triangles200", 6, 300), ("branch3", 7, 200),
            ("city16", 8, 300), ("cubes1502", 9, 100)]
LIBRARY = [("room1", 11, 100), ("city8", 12, 80), ("triangles200", 13, 80), ("branch3", 14, 60),
           ("room4", 15, 60)]
OPTIONS = {
    "three_threads": ["--threads", "3"],
    "open": ["--sides", "open"],
    "closed": ["--sides", "closed"],
    "min_area": ["--min-feature", "1e-3"],
    "min_angle": ["--min-feature", "1e-5sr"],
    "not_aligned": ["--coplanar", "0"],
    "as_given": ["--order", "as-given"],
    "random": ["--order", "random", "--seed", "5"],
    "small_cells": ["--facets-per-cell", "16"],
}
TECHNIQUES = ["fragments", "stencil-standard", "stencil-zfail", "stencil-hybrid", "stencil-kolic",
              "shadow-texture", "shadow-map"]
# Faces that are refused or repaired.
BROKEN = """o broken
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0.25
v 0.5 0 0
v 2 2 2
f 1 2 3 4
f 1 5 2
f 1 2 6
f 1 2 6
f 1 2 2 3
f 1 3 2 4
o whole
v 0 0 -1
v 3 0 -1
v 0 3 -1
f 7 8 9
"""


class Scene:
    """A scene file in the work folder: its light, and the box around it."""

    def __init__(self, path):
        text = path.read_text()
        self.name, self.file, self.text = path.stem, path.name, text
        self.light = re.search(r"light (point:\S+)", text)[1]
        vertices = [[float(x) for x in row.split()] for row in re.findall(r"^v (.*)", text, re.M)]
        self.low = [min(column) for column in zip(*vertices)]
        self.high = [max(column) for column in zip(*vertices)]

    def at(self, *shares):
        """A place in the box around the scene, by its shares along the axes."""
        return [a + s * (b - a) for a, b, s in zip(self.low, self.high, shares)]

    def camera(self):
        """A camera within the box, as the program wants it."""
        numbers = self.at(0.06, 0.08, 0.9) + self.at(0.8, 0.75, 0.1) + [75]
        return ",".join(repr(x) for x in numbers)

    def second_light(self):
        return "point:" + ",".join(repr(x) for x in self.at(0.31, 0.67, 0.93))

    def objects(self):
        """What the C library and the WebAssembly package are given."""
        objects, base = [], 1
        for part in re.split(r"^o ", self.text, flags=re.M)[1:]:
            rows = [line.split() for line in part.split("\n")[1:] if line]
            positions = [float(x) for row in rows if row[0] == "v" for x in row[1:]]
            faces = [[int(x) - base for x in row[1:]] for row in rows if row[0] == "f"]
            objects.append({"name": part.split("\n")[0], "positions": positions, "faces": faces})
            base += len(positions) // 3
        return objects


def light_record(spec):
    kind, numbers = spec.split(":")
    return {"kind": {"point": "point", "sun": "directional"}[kind],
            "at": [float(x) for x in numbers.split(",")]}


def prepare(programs, work):
    """All scenes and scripts of edits, in the work folder."""
    data = pathlib.Path(__file__).resolve().parent.parent / "data"
    for path in [*data.glob("*.obj"), data / "room4_edits.jsonl", data / "lamp.gltf"]:
        shutil.copy(path, work)
    subprocess.run([programs / "make_scenes", work, *GENERATED], check=True,
                   stdout=subprocess.DEVNULL)
    scenes = {path.stem: Scene(path) for path in sorted(work.glob("*.obj"))}
    (work / "broken.obj").write_text(BROKEN)
    for name, seed, count in REPLAYED + LIBRARY:
        at = scenes[name].light.split(":")[1]
        script = subprocess.run([programs / "make_edits", scenes[name].file, str(seed), str(count),
                                 "--light", at], cwd=work, check=True, stdout=subprocess.PIPE)
        (work / f"{name}_{seed}.jsonl").write_bytes(script.stdout)
    return scenes


def cast_jobs(scenes):
    files = [x for name in ["x.obj", "x.ply", "x.glb"] for x in ["-o", "OUT/" + name]]
    files += ["--areas", "OUT/areas.csv", "--json", "OUT/cast.json"]
    for scene in scenes.values():
        for kernel in KERNELS:
            for form in FORMS:
                yield (f"cast/{scene.name}/{kernel}/{form}",
                       ["cast", scene.file, "--light", scene.light, "--kernel", kernel,
                        "--form", form, *files])
            yield (f"cast/{scene.name}/{kernel}/sun",
                   ["cast", scene.file, "--light", SUN, "--kernel", kernel, *files])
    for name, options in OPTIONS.items():
        for scene in [scenes["room3"], scenes["city16"], scenes["triangles200"]]:
            for kernel in KERNELS:
                yield (f"cast/{scene.name}/{kernel}/{name}",
                       ["cast", scene.file, "--light", scene.light, "--kernel", kernel, *options,
                        *files])
    yield "cast/lamp/fast", ["cast", "lamp.gltf", "-o", "OUT/y.gltf", *files]


def several_lights_jobs(scenes):
    for scene in [scenes[name] for name in COMBINED]:
        for kernel in KERNELS:
            for count in [2, 3]:
                lights = [scene.light, SUN, scene.second_light()][:count]
                yield (f"combined/{scene.name}/{kernel}/{count}",
                       ["cast", scene.file, *[x for l in lights for x in ["--light", l]],
                        "--kernel", kernel, "-o", "OUT/x.obj", "-o", "OUT/x.ply", "-o", "OUT/x.glb",
                        "--areas", "OUT/areas.csv", "--json", "OUT/cast.json"])


def drawing_jobs(scenes):
    for scene in [scenes[name] for name in DRAWN]:
        face = re.search(r"^o (.*)", scene.text, re.M)[1] + ":0"
        height = repr(scene.at(0, 0, 0.6)[2])
        drawings = {"plan": "plan", "cut": "plan:" + height, "face": face, "camera": scene.camera()}
        yield (f"svg/{scene.name}",
               ["cast", scene.file, "--light", scene.light,
                *[x for name in drawings for x in ["-o", f"OUT/{name}.svg"]],
                *[x for drawing in drawings.values() for x in ["--svg", drawing]]])
    for technique in TECHNIQUES:
        scene = scenes["room1"]
        yield (f"render/{scene.name}/{technique}",
               ["render", scene.file, "--light", scene.light, "--camera", scene.camera(), "--size",
                "320x240", "--technique", technique, "-o", "OUT/x.png", "--json",
                "OUT/render.json"])


def replay_jobs(scenes):
    scripts = [("room4", "room4_edits")] + [(name, f"{name}_{seed}") for name, seed, _ in REPLAYED]
    for name, script in scripts:
        scene = scenes[name]
        for kernel in KERNELS:
            lights = ["--light", scene.light] + (["--light", SUN] if name == "room1" else [])
            yield (f"replay/{script}/{kernel}",
                   ["replay", scene.file, script + ".jsonl", *lights, "--kernel", kernel,
                    "--changes", "OUT/changes.jsonl", "--json", "OUT/replay.json"])


def other_jobs(scenes):
    for scene in [scenes[name] for name in COMPARED]:
        yield (f"compare/{scene.name}",
               ["compare", scene.file, "--light", scene.light, "--json", "OUT/compare.json"])
        yield (f"compare/{scene.name}/two_lights",
               ["compare", scene.file, "--light", scene.light, "--light", SUN, "--json",
                "OUT/compare.json"])
    for file in [scene.file for scene in scenes.values()] + ["lamp.gltf", "broken.obj"]:
        yield f"inspect/{file}", ["inspect", file, "--json", "OUT/inspect.json"]


def cleaned(value):
    """JSON without what depends on the machine, its keys as they once were."""
    if isinstance(value, list):
        return [cleaned(x) for x in value]
    if not isinstance(value, dict):
        return value
    old = {RENAMED_KEYS.get(key, key): cleaned(x) for key, x in value.items()}
    return {key: x for key, x in old.items() if key not in DROPPED_KEYS and key[-3:] != "_ms"}


def hash_of(path):
    content = path.read_bytes()
    if path.suffix in (".json", ".jsonl"):
        values = [json.loads(content)] if path.suffix == ".json" else \
            [json.loads(line) for line in content.splitlines()]
        content = json.dumps(cleaned(values), sort_keys=True).encode()
    return hashlib.sha256(content).hexdigest()


def run_program(program, work, job):
    name, args = job
    folder = work / "out" / name.replace("/", "_")
    folder.mkdir(parents=True)
    if args[0] in ("cast", "replay") and "--threads" not in args:
        args = [*args, "--threads", "1"]
    if args[0] != "inspect":
        args = [*args, "--quiet"]
    args = [arg.replace("OUT", str(folder.relative_to(work))) for arg in args]
    done = subprocess.run([program, *args], cwd=work, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{name}: shadowcut {' '.join(args)}: exit status {done.returncode}\n"
                 + done.stderr)
    return {f"{name}/{path.name}": hash_of(path) for path in sorted(folder.iterdir())}


def write_library_jobs(scenes, work):
    """Scenes and edits for output_hashes_c.py and output_hashes.mjs."""
    jobs = []
    for name, seed, _ in LIBRARY:
        lines = (work / f"{name}_{seed}.jsonl").read_text().splitlines()
        for kernel in KERNELS:
            lights = [light_record(scenes[name].light), light_record(SUN)]
            jobs.append({"name": f"{name}/{kernel}", "kernel": kernel, "lights": lights,
                         "objects": scenes[name].objects(),
                         "edits": [json.loads(line) for line in lines]})
    path = work / "library_jobs.json"
    path.write_text(json.dumps(jobs))
    return path


def run_library(command, name):
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{name}: {' '.join(map(str, command))}: exit status {done.returncode}")
    return {f"{name}/{key}": value for key, value in json.loads(done.stdout).items()}


def all_hashes(arguments, work):
    build = arguments.build.resolve()
    scripts = pathlib.Path(__file__).resolve().parent
    scenes = prepare(build / "bin", work)
    jobs = [job for make in [cast_jobs, several_lights_jobs, drawing_jobs, replay_jobs, other_jobs]
            for job in make(scenes) if arguments.only in job[0]]
    library_jobs = write_library_jobs(scenes, work)
    libraries = {"c": [sys.executable, scripts / "output_hashes_c.py", build, library_jobs]}
    if arguments.wasm:
        libraries["wasm"] = ["node", scripts / "output_hashes.mjs", arguments.wasm.resolve(),
                             library_jobs]
    hashes = {}
    with ThreadPoolExecutor(2) as pool:
        results = [pool.submit(run_library, command, name) for name, command in libraries.items()
                   if arguments.only in name + "/"]
        results += [pool.submit(run_program, build / "bin/shadowcut", work, job) for job in jobs]
        for result in results:
            try:
                hashes.update(result.result())
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    return dict(sorted(hashes.items()))


def print_differences(old, new):
    """Exit status."""
    differ = [name for name in new if name in old and old[name] != new[name]]
    missing = [name for name in old if name not in new]
    added = [name for name in new if name not in old]
    for word, names in [("differs", differ), ("missing", missing), ("new", added)]:
        for name in sorted(names):
            print(f"{word:8} {name}")
    print(f"{len(new)} hashes: {len(differ)} differ, {len(missing)} missing, {len(added)} new")
    return 1 if differ or missing else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--wasm", type=pathlib.Path, metavar="WEB_DIR")
    parser.add_argument("-o", dest="output", type=pathlib.Path, metavar="FILE.json")
    parser.add_argument("--compare", type=pathlib.Path, metavar="FILE.json")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--only", default="", metavar="WORDS")
    arguments = parser.parse_args()
    old = json.loads(arguments.compare.read_text()) if arguments.compare else None
    if not arguments.wasm:
        print("no --wasm: the WebAssembly package is left out", file=sys.stderr)
    with tempfile.TemporaryDirectory() as temporary:
        if arguments.keep:
            arguments.keep.mkdir(parents=True)
        hashes = all_hashes(arguments, (arguments.keep or pathlib.Path(temporary)).resolve())
    text = json.dumps(hashes, indent=1) + "\n"
    if arguments.output:
        arguments.output.write_text(text)
    if old is not None:
        left_out = () if arguments.wasm else ("wasm/",)
        old = {name: value for name, value in old.items()
               if arguments.only in name and not name.startswith(left_out)}
        return print_differences(old, hashes)
    if not arguments.output:
        print(text, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
