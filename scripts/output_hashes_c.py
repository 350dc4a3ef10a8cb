#!/usr/bin/env python3
"""Hashes of all that the C library hands out; output_hashes.py calls it.

    scripts/output_hashes_c.py BUILD JOBS.json

Casts shadows in the scenes of JOBS.json, lets engines and vertex buffers follow their edits, and
prints one JSON object: name -> SHA-256. All numbers are hashed as doubles, arrays of the library's
and vertex buffers as they are in memory; output_hashes.mjs does the same through the WebAssembly
package, and both must stay in step.
"""
import ctypes
import hashlib
import json
import pathlib
import struct
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_uint32, c_uint64, c_void_p

# ---- All names and numbers of c.h that are used here ----------------------------------------

LIBRARY = "src/c/libshadowcut_c.so"
MESSAGE = "shadowcut_message"
# As called here -> as declared in c.h, all but the prefix.
PREFIX = "shadowcut_"
FUNCTIONS = {
    "mesh_create": "mesh_create",
    "mesh_destroy": "mesh_destroy",
    "mesh_set_vertices": "mesh_set_vertices",
    "mesh_add_face": "mesh_add_face",
    "settings_init": "object_settings_init",
    "light_init": "light_init",
    "scene_create": "scene_create",
    "scene_destroy": "scene_destroy",
    "scene_add_object": "scene_add_object",
    "scene_remove_object": "scene_remove_object",
    "scene_set_pose": "scene_set_pose",
    "scene_source": "scene_source",
    "scene_add_light": "scene_add_light",
    "scene_set_light": "scene_set_light",
    "scene_object_id": "scene_object_id",
    "scene_light_id": "scene_light_id",
    "object_init": "object_init",
    "scene_object": "scene_object",
    "counts_init": "scene_counts_init",
    "scene_count": "scene_count",
    "scene_faces": "scene_faces",
    "scene_facets": "scene_facets",
    "scene_corners": "scene_corners",
    "scene_vertices": "scene_vertices",
    "scene_edges": "scene_edges",
    "scene_planes": "scene_planes",
    "options_init": "options_init",
    "cast_shadows": "cast_shadows",
    "shadows_destroy": "shadows_destroy",
    "block_count": "shadows_block_count",
    "fragment_count": "shadows_fragment_count",
    "fragments": "shadows_fragments",
    "corners": "shadows_corners",
    "construction_count": "shadows_construction_count",
    "constructions": "shadows_constructions",
    "area_count": "shadows_area_count",
    "areas": "shadows_areas",
    "stats_init": "stats_init",
    "stats": "shadows_stats",
    "engine_create": "engine_create",
    "engine_destroy": "engine_destroy",
    "engine_update": "engine_update",
    "engine_compact": "engine_compact",
    "changes_init": "changes_init",
    "changes": "engine_changes",
    "light_changes_init": "light_changes_init",
    "light_changes": "engine_light_changes",
    "gone": "engine_gone",
    "added": "engine_added",
    "changed_areas": "engine_changed_areas",
    "engine_scene": "engine_scene",
    "engine_shadows": "engine_shadows",
    "uncertain_area": "engine_uncertain_area",
    "validate": "engine_validate",
    "overlay": "engine_overlay",
    "partition_destroy": "light_partition_destroy",
    "partition_count": "light_partition_count",
    "partition_fragments": "light_partition_fragments",
    "partition_masks": "light_partition_masks",
    "partition_corners": "light_partition_corners",
    "layout_init": "buffer_layout_init",
    "buffers_create": "buffers_create",
    "buffers_destroy": "buffers_destroy",
    "buffers_update": "buffers_update",
    "info_init": "buffers_info_init",
    "info": "buffers_get_info",
    "stream": "buffers_stream",
    "changed_vertices": "buffers_changed_vertices",
    "changed_indices": "buffers_changed_indices",
}
KINDS = {"point": 0, "directional": 1}
KERNELS = {"fast": 0, "exact": 1}
FORMS = {"pieces": 0, "merged": 1, "conforming": 2}
STREAMS = {"positions": 0, "normals": 1, "faces": 2, "objects": 3, "states": 4, "masks": 5,
           "indices": 6}
NONE = 0xFFFFFFFF
# Members that are not hashed: they depend on the machine, or are of use to the caller alone.
SKIPPED = {"size", "bytes", "build_ms", "emit_ms", "ms"}

# ---- The layout of its structs ---------------------------------------------------------------

u32, i32, u64, f64 = c_uint32, c_int32, c_uint64, c_double


def layout(name, *members):
    """A struct: (type, names) after one another."""
    fields = [(word, kind) for kind, words in members for word in words.split()]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


Id = layout("Id", (u32, "index generation scene"))
Settings = layout("Settings", (u32, "size"), (i32, "sides casts_shadows receives_shadows dynamic"),
                  (f64 * 16, "pose"), (c_char_p, "name"))
Light = layout("Light", (u32, "size"), (i32, "kind"), (f64 * 3, "position direction"),
               (f64, "range"), (i32, "has_spot"), (f64 * 3, "spot_axis"), (f64, "spot_half_angle"),
               (c_char_p, "name"))
Object = layout("Object", (u32, "size"), (i32, "sides casts_shadows receives_shadows dynamic"),
                (u32, "first_face face_count first_vertex vertex_count first_facet facet_count "
                      "first_edge edge_count aligned"),
                (f64, "aligned_by signed_volume"), (f64 * 16, "pose"), (c_char_p, "name"))
Counts = layout("Counts", (u32, "size objects lights faces facets corners vertices edges planes "
                                "issues"), (u64, "revision"))
Face = layout("Face", (u32, "object number first_facet facet_count"), (f64, "area"))
Facet = layout("Facet", (u32, "face plane first_corner corner_count"))
Pair = layout("Pair", (u32, "first second"))  # corners, edges and ranges
Plane = layout("Plane", (f64 * 3, "normal point exact_normal"), (f64, "flatness tilt"))
Tuning = layout("Tuning", (i32, "order"), (u64, "seed"), (u32, "facets_per_cell"),
                (i32, "incremental"), (u32, "join_threshold"))
Options = layout("Options", (u32, "size"), (i32, "kernel form"), (u32, "threads"),
                 (f64, "min_area min_solid_angle"), (i32, "constructions"), (Tuning, "tuning"))
FragmentId = layout("FragmentId", (u32, "cell piece place"))
Fragment = layout("Fragment", (FragmentId, "id"),
                  (u32, "face facet caster first_corner corner_count"), (i32, "lit"),
                  (f64, "area"))
LightLine = layout("LightLine", (i32, "crossing"), (f64 * 12, "v"))
Construction = layout("Construction", (LightLine, "in out"), (u32, "vertex"))
FaceArea = layout("FaceArea", (i32, "facing"), (f64, "area lit shadowed dropped"))
Stats = layout("Stats", (u32, "size"), (u64, "faces facing_faces facets"),
               (f64, "facing_area lit_area shadowed_area dropped_area"),
               (u64, "lit_fragments shadowed_fragments cells nodes sp_nodes pp_nodes pieces "
                     "crossing_lines predicates on by_identity by_filter by_exact depth bytes"),
               (f64, "build_ms emit_ms"),
               (u64, "marked_nodes longest_location_list cells_rebuilt joined deferred"))
Changes = layout("Changes", (u32, "size light_count"), (u64, "update"), (u32, "applied"),
                 (i32, "complete"), (f64, "ms"))
LightChanges = layout("LightChanges", (u32, "size light"), (i32, "rebuilt removed"),
                      (u32, "gone_count added_count area_count"))
Added = layout("Added", (FragmentId, "id"), (u32, "index"))
ChangedArea = layout("ChangedArea", (u32, "face"), (FaceArea, "area"))
PartitionFragment = layout("PartitionFragment", (u32, "face facet first_corner corner_count"))
Layout = layout("Layout", (u32, "size"),
                (i32, "doubles indexed normals faces objects states masks show"),
                (f64 * 3, "origin"), (f64, "hole_share"), (u32, "joined_gap"))
Info = layout("Info", (u32, "size vertex_count vertex_capacity index_count index_capacity "
                           "fragment_count hole_vertices mask_words"), (i32, "grown"),
              (u32, "changed_vertex_ranges changed_index_ranges"))
INITS = {Settings: "settings_init", Light: "light_init", Object: "object_init",
         Counts: "counts_init", Options: "options_init", Stats: "stats_init",
         Changes: "changes_init", LightChanges: "light_changes_init", Layout: "layout_init",
         Info: "info_init"}

# ---- Calls -----------------------------------------------------------------------------------

library = None  # loaded in main


def function(name):
    return getattr(library, PREFIX + FUNCTIONS[name])


def call(name, *args):
    status = function(name)(*args)
    if status != 0:
        raise RuntimeError(f"{name}: {status}: {getattr(library, MESSAGE)().decode()}")


def value(kind, name, *args):
    """What a function hands out through its last parameter."""
    out = kind()
    if kind in INITS:
        call(INITS[kind], byref(out))
    call(name, *args, byref(out))
    return out


def number(name, *args):
    return value(c_uint32, name, *args).value


def elements(kind, count, name, *args):
    out = (kind * max(count, 1))()
    call(name, *args, u32(0), u32(count), out)
    return out[:count]


def lent(kind, name, *args):
    """An array that stays the library's, and its length."""
    at, count = POINTER(kind)(), c_uint32()
    call(name, *args, byref(at), byref(count))
    return at, count.value


def with_members(kind, /, **members):
    out = kind()
    call(INITS[kind], byref(out))
    for name, member in members.items():
        setattr(out, name, member)
    return out


class Digest:
    """SHA-256 of numbers, each as a double, and of bytes."""

    def __init__(self):
        self.hash = hashlib.sha256()

    def add(self, *values):
        flat = []
        for x in values:
            flatten(x, flat)
        self.hash.update(struct.pack(f"<{len(flat)}d", *flat))

    def add_bytes(self, at, size):
        self.hash.update(ctypes.string_at(at, size))


def flatten(x, out):
    """A text is its length and its bytes; of a struct all members but SKIPPED."""
    if isinstance(x, (int, float)):
        out.append(x)
    elif isinstance(x, ctypes.Structure):
        for name, _ in x._fields_:
            if name not in SKIPPED:
                flatten(getattr(x, name), out)
    elif isinstance(x, bytes):
        out.extend([len(x), *x])
    else:
        for element in x:
            flatten(element, out)


# ---- What is hashed --------------------------------------------------------------------------


def add_scene(digest, scene):
    counts = value(Counts, "scene_count", scene)
    digest.add(counts)
    for index in range(counts.objects):
        try:
            object_id = value(Id, "scene_object_id", scene, u32(index))
        except RuntimeError:  # the place of one that was removed
            continue
        digest.add(index, value(Object, "scene_object", scene, byref(object_id)))
    digest.add(elements(Face, counts.faces, "scene_faces", scene),
               elements(Facet, counts.facets, "scene_facets", scene),
               elements(Pair, counts.corners, "scene_corners", scene),
               elements(c_double * 3, counts.vertices, "scene_vertices", scene),
               elements(Pair, counts.edges, "scene_edges", scene),
               elements(Plane, counts.planes, "scene_planes", scene))


def add_shadows(digest, shadows):
    for block in range(number("block_count", shadows)):
        b = u32(block)
        digest.add(elements(Fragment, number("fragment_count", shadows, b), "fragments", shadows,
                            b))
        digest.add_bytes(*in_bytes(lent(c_double, "corners", shadows, b), 24))
        digest.add(elements(Construction, number("construction_count", shadows, b),
                            "constructions", shadows, b))
    digest.add(elements(FaceArea, number("area_count", shadows), "areas", shadows),
               value(Stats, "stats", shadows))


def in_bytes(array, size):
    at, count = array
    return at, count * size


def add_changes(digest, engine):
    changes = value(Changes, "changes", engine)
    digest.add(changes.update, changes.applied, changes.complete)
    for i in range(changes.light_count):
        light = value(LightChanges, "light_changes", engine, u32(i))
        digest.add(light,
                   elements(FragmentId, light.gone_count, "gone", engine, u32(i)),
                   elements(Added, light.added_count, "added", engine, u32(i)),
                   elements(ChangedArea, light.area_count, "changed_areas", engine, u32(i)))


def add_combined(digest, engine):
    partition = value(c_void_p, "overlay", engine)
    count, words = c_uint32(), c_uint32()
    call("partition_count", partition, byref(count), byref(words))
    digest.add(count.value, words.value,
               elements(PartitionFragment, count.value, "partition_fragments", partition))
    masks = value(POINTER(c_uint64), "partition_masks", partition)
    digest.add_bytes(masks, 8 * count.value * words.value)
    digest.add_bytes(*in_bytes(lent(c_double, "partition_corners", partition), 24))
    function("partition_destroy")(partition)


def add_buffers(digest, buffers, streams):
    info = value(Info, "info", buffers)
    digest.add(info,
               elements(Pair, info.changed_vertex_ranges, "changed_vertices", buffers),
               elements(Pair, info.changed_index_ranges, "changed_indices", buffers))
    for name in streams:
        at, each = lent(ctypes.c_uint8, "stream", buffers, i32(STREAMS[name]))
        count = info.index_count if name == "indices" else info.vertex_count
        digest.add_bytes(at, count * each)


# Of one light, and of the partition by all lights.
LAYOUTS = [
    (0, {"objects": 1}, ["positions", "normals", "faces", "objects", "states"]),
    (NONE, {"doubles": 1, "indexed": 1, "masks": 1},
     ["positions", "normals", "faces", "states", "masks", "indices"]),
]

# ---- Scenes and edits ------------------------------------------------------------------------


def add_object(scene, record):
    mesh = value(c_void_p, "mesh_create")
    xyz = record["positions"]
    call("mesh_set_vertices", mesh, (c_double * len(xyz))(*xyz), i32(len(xyz) // 3))
    for face in record["faces"]:
        call("mesh_add_face", mesh, (c_uint32 * len(face))(*face), i32(len(face)))
    settings = with_members(Settings, name=record["name"].encode())
    added = value(Id, "scene_add_object", scene, mesh, byref(settings))
    function("mesh_destroy")(mesh)
    return added


def light_of(record):
    vector = "position" if record["kind"] == "point" else "direction"
    return with_members(Light, kind=KINDS[record["kind"]],
                        **{vector: (c_double * 3)(*record["at"])})


class Player:
    """A scene that edits are applied to, as `shadowcut replay` does."""

    def __init__(self, job):
        self.scene = value(c_void_p, "scene_create")
        self.ids = {record["name"]: add_object(self.scene, record) for record in job["objects"]}
        self.lights = [dict(record) for record in job["lights"]]
        for record in self.lights:
            value(Id, "scene_add_light", self.scene, byref(light_of(record)))
        self.removed = {}

    def apply(self, edit):
        name = edit.get("object")
        if edit["op"] == "light":
            self.lights[edit["light"]]["at"] = edit["at"]
            light_id = value(Id, "scene_light_id", self.scene, u32(edit["light"]))
            call("scene_set_light", self.scene, byref(light_id),
                 byref(light_of(self.lights[edit["light"]])))
        elif edit["op"] == "remove":
            mesh, settings = c_void_p(), with_members(Settings)
            call("scene_source", self.scene, byref(self.ids[name]), byref(mesh), byref(settings))
            settings.name = bytes(settings.name)  # a copy: it is lent
            self.removed[name] = mesh, settings
            call("scene_remove_object", self.scene, byref(self.ids[name]))
        elif edit["op"] == "add":
            mesh, settings = self.removed.pop(name)
            self.ids[name] = value(Id, "scene_add_object", self.scene, mesh, byref(settings))
            function("mesh_destroy")(mesh)
        elif edit["op"] == "pose":
            self.set_pose(name, edit["matrix"])
        elif edit["op"] == "move":
            pose = list(value(Object, "scene_object", self.scene, byref(self.ids[name])).pose)
            for k in range(3):
                pose[4 * k + 3] += edit["translate"][k]
            self.set_pose(name, pose)

    def set_pose(self, name, pose):
        call("scene_set_pose", self.scene, byref(self.ids[name]), (c_double * 16)(*pose))

    def destroy(self):
        for mesh, _ in self.removed.values():
            function("mesh_destroy")(mesh)
        function("scene_destroy")(self.scene)


def run(job):
    """Name of a part -> hash."""
    digests = {}

    def digest(name):
        return digests.setdefault(name, Digest())

    player = Player(job)
    kernel = KERNELS[job["kernel"]]
    for form in FORMS:
        for k, light in enumerate(player.lights):
            options = with_members(Options, kernel=kernel, form=FORMS[form], threads=1)
            shadows = value(c_void_p, "cast_shadows", player.scene, byref(light_of(light)),
                            byref(options))
            add_shadows(digest(f"cast_{form}_{k}"), shadows)
            function("shadows_destroy")(shadows)

    options = with_members(Options, kernel=kernel, threads=1, constructions=int(kernel == 1))
    engine = value(c_void_p, "engine_create", player.scene, byref(options))
    buffers = [value(c_void_p, "buffers_create", u32(light), byref(with_members(Layout, **members)))
               for light, members, _ in LAYOUTS]

    def see_changes():
        add_changes(digest("changes"), engine)
        for k, (_, _, streams) in enumerate(LAYOUTS):
            call("buffers_update", buffers[k], engine)
            add_buffers(digest(f"buffers_{k}"), buffers[k], streams)

    def see_all(when):
        scene = value(c_void_p, "engine_scene", engine)
        add_scene(digest(f"scene_{when}"), scene)
        for k in range(len(player.lights)):
            shadows = value(c_void_p, "engine_shadows", engine, u32(k))
            add_shadows(digest(f"shadows_{when}"), shadows)
            areas = (c_double * value(Counts, "scene_count", scene).faces)()
            call("uncertain_area", engine, u32(k), u32(len(areas)), areas)
            digest(f"undecided_{when}").add(areas)
        add_combined(digest(f"combined_{when}"), engine)

    call("engine_update", engine)
    see_changes()
    see_all("built")
    for edit in job["edits"]:
        if edit["op"] != "update":
            player.apply(edit)
            continue
        call("engine_update", engine)
        see_changes()
    see_all("edited")
    call("validate", engine)
    call("engine_compact", engine)
    see_changes()
    see_all("compacted")

    for handle in buffers:
        function("buffers_destroy")(handle)
    function("engine_destroy")(engine)
    player.destroy()
    return {name: d.hash.hexdigest() for name, d in digests.items()}


def main():
    global library
    library = ctypes.CDLL(str(pathlib.Path(sys.argv[1]) / LIBRARY))
    getattr(library, MESSAGE).restype = c_char_p
    jobs = json.loads(pathlib.Path(sys.argv[2]).read_text())
    print(json.dumps({f"{job['name']}/{part}": hash_ for job in jobs
                      for part, hash_ in run(job).items()}))


if __name__ == "__main__":
    main()
