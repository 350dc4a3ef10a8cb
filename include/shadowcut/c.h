/* The C interface: everything that scene.hpp, shadows.hpp and buffers.hpp offer, as functions on
 * opaque handles. Those headers define the terms (fragment, facet, side, range, kernel, form).
 *
 * Conventions. Every function that can fail returns a status. Its results are written through its
 * last parameters, and only if the status is SHADOWCUT_OK. No exception, C++ type or callback
 * crosses the interface. All ids and counts are 32 bits wide, so that JavaScript can call every
 * function directly. A parameter or member that holds the value of an enum is an int32_t; a value
 * outside of that enum is an error.
 *
 * Units and frame: one right-handed world frame in the caller's unit of length. Areas are in that
 * unit squared, angles in radians. A position is three numbers x, y, z. A pose is sixteen doubles,
 * row by row, from the object's frame to the world frame; its last row is 0 0 0 1.
 *
 * Ownership: the caller owns the results of all *_create functions, shadowcut_scene_copy,
 * shadowcut_scene_source, shadowcut_cast_shadows and shadowcut_engine_overlay, and passes them to
 * the *_destroy function of their type, which also accepts null. All other results are borrowed:
 * each function states for how long they are valid. Arrays and strings passed to a function are
 * copied before it returns. An engine keeps its scene alive.
 *
 * Structs that may grow in later versions begin with their size, set by their *_init function;
 * a struct of any other size is an error. Structs without a size will not change. Functions that
 * copy array elements take the index of the first one and a count, and an array with room for
 * them; a range outside of the array is an error.
 *
 * Thread safety: as in C++. Any number of threads may read one handle (const); a thread that
 * changes it needs exclusive access. An engine reads its scene during update and compact.
 * Different handles are independent, and each thread has its own message. Cost: that of the C++
 * function of the same name; a function without one takes constant time or time proportional to
 * what it copies. */
#ifndef SHADOWCUT_C_H
#define SHADOWCUT_C_H

#include <shadowcut/version.h>
#include <stdint.h>

#if defined(__EMSCRIPTEN__)
#define SHADOWCUT_API __attribute__((used, visibility("default")))
#elif defined(__GNUC__)
#define SHADOWCUT_API __attribute__((visibility("default")))
#else
#define SHADOWCUT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t shadowcut_status;
enum {
  SHADOWCUT_OK = 0,
  /* Misuse: a null pointer, a count or range out of bounds, an invalid enum value, a wrong struct
   * size. */
  SHADOWCUT_INVALID_ARGUMENT = 1,
  /* The value is not usable: a pose that is not invertible, a light that is not finite, ... */
  SHADOWCUT_REFUSED = 2,
  /* Nothing was done: the object or light of this id has been removed. */
  SHADOWCUT_STALE = 3,
  /* Nothing was done: the id belongs to another scene, or to no scene. */
  SHADOWCUT_FOREIGN = 4,
  /* The object, light, fragment or stream does not exist at present. */
  SHADOWCUT_NOT_FOUND = 5,
  /* Nothing was done. An engine that runs out of memory in an update must be compacted. */
  SHADOWCUT_OUT_OF_MEMORY = 6,
  /* The engine ran out of memory in an update; shadowcut_engine_compact rebuilds it. */
  SHADOWCUT_MUST_COMPACT = 7,
  /* A bug in the library. */
  SHADOWCUT_INTERNAL_ERROR = 8
};

/* One line in English about the last call in this thread that did not return SHADOWCUT_OK, or "".
 * Valid until the next call in this thread. */
SHADOWCUT_API const char* shadowcut_message(void);
/* The name of the constant without its prefix, such as "OUT_OF_MEMORY", or "". */
SHADOWCUT_API const char* shadowcut_status_name(shadowcut_status status);
/* The version of the library, such as "0.1.0". */
SHADOWCUT_API const char* shadowcut_version(void);
/* The same as three numbers; a pointer may be null. */
SHADOWCUT_API void shadowcut_version_numbers(uint32_t* major, uint32_t* minor, uint32_t* patch);

/* Stands for "no index". */
#define SHADOWCUT_INVALID_INDEX UINT32_C(0xFFFFFFFF)

/* ---- Meshes: the faces of an object ------------------------------------------------------- */

typedef struct shadowcut_mesh shadowcut_mesh;

/* These functions check pointers and counts only; a scene checks the faces and reports those that
 * are not usable as issues. A mesh that ran out of memory can only be destroyed. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_create(shadowcut_mesh** mesh);
SHADOWCUT_API void shadowcut_mesh_destroy(shadowcut_mesh* mesh);
/* Replaces all vertices: 3 * vertex_count numbers, in the frame of the object. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_set_vertices(shadowcut_mesh* mesh, const double* xyz,
                                                           int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_set_vertices_float(shadowcut_mesh* mesh,
                                                                 const float* xyz,
                                                                 int32_t vertex_count);
/* Appends a face: the vertex indices of its outer loop, convex or concave, counter-clockwise seen
 * from the front of the face. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_face(shadowcut_mesh* mesh,
                                                       const uint32_t* corners,
                                                       int32_t corner_count);
/* Adds a hole to the last face; the loop may run either way. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_hole(shadowcut_mesh* mesh,
                                                       const uint32_t* corners,
                                                       int32_t corner_count);
/* Appends face_count faces without holes: the corners of all faces one after another, and the
 * number of corners of each face (null: all are triangles). */
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_faces(shadowcut_mesh* mesh,
                                                        const uint32_t* corners,
                                                        const int32_t* corner_counts,
                                                        int32_t face_count);
/* The contents of a mesh. Pointers are valid until the mesh changes. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_vertices(const shadowcut_mesh* mesh,
                                                       const double** xyz, uint32_t* vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_face_count(const shadowcut_mesh* mesh,
                                                         uint32_t* face_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_loop_count(const shadowcut_mesh* mesh, uint32_t face,
                                                         uint32_t* loop_count);
/* Loop 0 is the outer loop, the others are holes. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_loop(const shadowcut_mesh* mesh, uint32_t face,
                                                   uint32_t loop, const uint32_t** corners,
                                                   uint32_t* corner_count);

/* ---- Scenes --------------------------------------------------------------------------------- */

typedef struct shadowcut_scene shadowcut_scene;

/* Identifies an object or a light of one scene. The index is used again after the object has been
 * removed; the generation distinguishes the two. Compare ids member by member. */
typedef struct {
  uint32_t index, generation, scene;
} shadowcut_object_id;
typedef struct {
  uint32_t index, generation, scene;
} shadowcut_light_id;

enum { SHADOWCUT_SIDES_AUTOMATIC = 0, SHADOWCUT_SIDES_CLOSED = 1, SHADOWCUT_SIDES_OPEN = 2 };

typedef struct {
  uint32_t size;
  int32_t sides;         /* SHADOWCUT_SIDES_... */
  int32_t casts_shadows; /* 0 or 1, as the next two */
  int32_t receives_shadows;
  int32_t dynamic; /* expected to move: inserted last, at the leaves of the tree */
  double pose[16];
  const char* name; /* UTF-8; null: "" */
} shadowcut_object_settings;
/* Automatic sides, casts and receives shadows, not dynamic, the identity pose, no name. */
SHADOWCUT_API shadowcut_status shadowcut_object_settings_init(shadowcut_object_settings* settings);

enum { SHADOWCUT_POINT = 0, SHADOWCUT_DIRECTIONAL = 1 };

typedef struct {
  uint32_t size;
  int32_t kind;        /* SHADOWCUT_POINT, SHADOWCUT_DIRECTIONAL */
  double position[3];  /* of a point light */
  double direction[3]; /* of the rays of a directional light; any length except zero */
  double range;        /* of a point light; INFINITY: unlimited, as for a directional light */
  int32_t has_spot;    /* point lights only: 1 restricts the light to a cone */
  double spot_axis[3];
  double spot_half_angle; /* radians, in (0, pi] */
  const char* name;       /* null: "" */
} shadowcut_light;
/* A point light at 0, 0, 0 with unlimited range, without spot or name. */
SHADOWCUT_API shadowcut_status shadowcut_light_init(shadowcut_light* light);

SHADOWCUT_API shadowcut_status shadowcut_scene_create(shadowcut_scene** scene);
/* An independent copy, in which the ids of the original are valid. */
SHADOWCUT_API shadowcut_status shadowcut_scene_copy(const shadowcut_scene* scene,
                                                    shadowcut_scene** copy);
SHADOWCUT_API void shadowcut_scene_destroy(shadowcut_scene* scene);

/* Scene::flatness_tolerance (default 1e-6) and Scene::coplanarity_tolerance (default 1e-12; 0:
 * every face keeps a plane of its own). To be set before objects are added. SHADOWCUT_REFUSED
 * unless both are finite and not negative. */
SHADOWCUT_API shadowcut_status shadowcut_scene_set_tolerances(shadowcut_scene* scene,
                                                              double flatness, double coplanarity);
SHADOWCUT_API shadowcut_status shadowcut_scene_tolerances(const shadowcut_scene* scene,
                                                          double* flatness, double* coplanarity);

/* settings: null stands for the defaults. Faces that are not usable are left out and reported as
 * issues. */
SHADOWCUT_API shadowcut_status shadowcut_scene_add_object(shadowcut_scene* scene,
                                                          const shadowcut_mesh* mesh,
                                                          const shadowcut_object_settings* settings,
                                                          shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_remove_object(shadowcut_scene* scene,
                                                             const shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_pose(shadowcut_scene* scene,
                                                        const shadowcut_object_id* id,
                                                        const double* pose);
/* vertex_count must be the number of vertices of the object's mesh; in the frame of the object. */
SHADOWCUT_API shadowcut_status shadowcut_scene_set_vertices(shadowcut_scene* scene,
                                                            const shadowcut_object_id* id,
                                                            const double* xyz,
                                                            int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_vertices_float(shadowcut_scene* scene,
                                                                  const shadowcut_object_id* id,
                                                                  const float* xyz,
                                                                  int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_casts_shadows(shadowcut_scene* scene,
                                                                 const shadowcut_object_id* id,
                                                                 int32_t casts_shadows);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_receives_shadows(shadowcut_scene* scene,
                                                                    const shadowcut_object_id* id,
                                                                    int32_t receives_shadows);
/* The arguments of shadowcut_scene_add_object that recreate the object in its present state: a
 * mesh, owned by the caller, and settings (may be null), whose name is valid until the scene
 * changes. */
SHADOWCUT_API shadowcut_status shadowcut_scene_source(const shadowcut_scene* scene,
                                                      const shadowcut_object_id* id,
                                                      shadowcut_mesh** mesh,
                                                      shadowcut_object_settings* settings);

/* SHADOWCUT_REFUSED: a coordinate is not finite, a direction is zero, a range or spot is out of
 * bounds, or a directional light has a range or a spot. */
SHADOWCUT_API shadowcut_status shadowcut_scene_add_light(shadowcut_scene* scene,
                                                         const shadowcut_light* light,
                                                         shadowcut_light_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_remove_light(shadowcut_scene* scene,
                                                            const shadowcut_light_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_light(shadowcut_scene* scene,
                                                         const shadowcut_light_id* id,
                                                         const shadowcut_light* light);
/* Removes all lights and adds these (an array of pointers) at the indices 0, 1, ... */
SHADOWCUT_API shadowcut_status shadowcut_scene_replace_lights(shadowcut_scene* scene,
                                                              const shadowcut_light* const* lights,
                                                              int32_t light_count);

/* The id of the object (light) at an index. SHADOWCUT_NOT_FOUND: the index is free. */
SHADOWCUT_API shadowcut_status shadowcut_scene_object_id(const shadowcut_scene* scene,
                                                         uint32_t index, shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_light_id(const shadowcut_scene* scene,
                                                        uint32_t index, shadowcut_light_id* id);
/* The name is valid until the scene changes. */
SHADOWCUT_API shadowcut_status shadowcut_scene_light(const shadowcut_scene* scene,
                                                     const shadowcut_light_id* id,
                                                     shadowcut_light* light);

typedef struct {
  uint32_t size;
  int32_t sides; /* as decided: closed or open */
  int32_t casts_shadows, receives_shadows, dynamic;
  uint32_t first_face, face_count; /* a range of the scene's faces; likewise below */
  uint32_t first_vertex, vertex_count;
  uint32_t first_facet, facet_count;
  uint32_t first_edge, edge_count;
  uint32_t aligned;     /* number of facets that were moved into the plane of another facet */
  double aligned_by;    /* the largest distance of a corner of these from that plane */
  double signed_volume; /* positive for a solid whose faces look outward */
  double pose[16];
  const char* name; /* valid until the scene changes */
} shadowcut_object;
/* Sets `size` only, for the functions that fill the struct. */
SHADOWCUT_API shadowcut_status shadowcut_object_init(shadowcut_object* object);
SHADOWCUT_API shadowcut_status shadowcut_scene_object(const shadowcut_scene* scene,
                                                      const shadowcut_object_id* id,
                                                      shadowcut_object* object);

/* The lengths of the scene's arrays, places of removed objects included, and the number of changes
 * made to the scene. */
typedef struct {
  uint32_t size;
  uint32_t objects, lights, faces, facets, corners, vertices, edges, planes, issues;
  uint64_t revision;
} shadowcut_scene_counts;
SHADOWCUT_API shadowcut_status shadowcut_scene_counts_init(shadowcut_scene_counts* counts);
SHADOWCUT_API shadowcut_status shadowcut_scene_count(const shadowcut_scene* scene,
                                                     shadowcut_scene_counts* counts);
/* The indices of the objects changed after a revision, the least recently changed one first. Writes
 * at most `capacity` of them; `count` is their number. */
SHADOWCUT_API shadowcut_status shadowcut_scene_changed_since(const shadowcut_scene* scene,
                                                             const uint64_t* revision,
                                                             uint32_t capacity, uint32_t* indices,
                                                             uint32_t* count);

/* The scene as flat arrays, in world coordinates. */
typedef struct {
  uint32_t object;                   /* SHADOWCUT_INVALID_INDEX: the place of a removed face */
  uint32_t number;                   /* within its object, as in its mesh */
  uint32_t first_facet, facet_count; /* 0 facets: the face was refused */
  double area;
} shadowcut_face;
typedef struct {
  uint32_t face, plane, first_corner, corner_count;
} shadowcut_facet;
typedef struct {
  uint32_t vertex;
  uint32_t edge; /* (index of the edge << 1) | 1 if it runs from b to a */
} shadowcut_corner;
typedef struct {
  uint32_t a, b;
} shadowcut_edge;
typedef struct {
  double normal[3], point[3], exact_normal[3], flatness, tilt;
} shadowcut_plane;
SHADOWCUT_API shadowcut_status shadowcut_scene_faces(const shadowcut_scene* scene, uint32_t first,
                                                     uint32_t count, shadowcut_face* faces);
SHADOWCUT_API shadowcut_status shadowcut_scene_facets(const shadowcut_scene* scene, uint32_t first,
                                                      uint32_t count, shadowcut_facet* facets);
SHADOWCUT_API shadowcut_status shadowcut_scene_corners(const shadowcut_scene* scene, uint32_t first,
                                                       uint32_t count, shadowcut_corner* corners);
SHADOWCUT_API shadowcut_status shadowcut_scene_vertices(const shadowcut_scene* scene,
                                                        uint32_t first, uint32_t count,
                                                        double* xyz);
SHADOWCUT_API shadowcut_status shadowcut_scene_edges(const shadowcut_scene* scene, uint32_t first,
                                                     uint32_t count, shadowcut_edge* edges);
SHADOWCUT_API shadowcut_status shadowcut_scene_planes(const shadowcut_scene* scene, uint32_t first,
                                                      uint32_t count, shadowcut_plane* planes);

/* Why a face was refused or repaired. */
enum {
  SHADOWCUT_NON_FINITE = 0,
  SHADOWCUT_INDEX_OUT_OF_RANGE = 1,
  SHADOWCUT_TOO_FEW_CORNERS = 2,
  SHADOWCUT_ZERO_AREA = 3,
  SHADOWCUT_SELF_INTERSECTING = 4,
  SHADOWCUT_DUPLICATE = 5,
  SHADOWCUT_REPEATED_CORNER = 6, /* repaired */
  SHADOWCUT_NOT_FLAT = 7         /* repaired */
};
typedef struct {
  uint32_t object; /* index of the object */
  uint32_t face;   /* number of the face within the object */
  int32_t reason;
  const char* detail; /* may be ""; valid until the scene changes */
} shadowcut_issue;
SHADOWCUT_API shadowcut_status shadowcut_scene_issues(const shadowcut_scene* scene, uint32_t first,
                                                      uint32_t count, shadowcut_issue* issues);
/* A short English phrase, or "" for an invalid value. A constant. */
SHADOWCUT_API const char* shadowcut_reason_text(int32_t reason);
/* 1: the face was refused. 0: it was repaired. */
SHADOWCUT_API int32_t shadowcut_is_refusal(int32_t reason);

/* ---- Options -------------------------------------------------------------------------------- */

enum { SHADOWCUT_KERNEL_FAST = 0, SHADOWCUT_KERNEL_EXACT = 1 };
enum { SHADOWCUT_FORM_PIECES = 0, SHADOWCUT_FORM_MERGED = 1, SHADOWCUT_FORM_CONFORMING = 2 };
enum { SHADOWCUT_ORDER_SOLID_ANGLE = 0, SHADOWCUT_ORDER_AS_GIVEN = 1, SHADOWCUT_ORDER_RANDOM = 2 };

/* Parameters of speed and memory, as shadowcut::Options::Tuning. */
typedef struct {
  int32_t order;
  uint64_t seed;            /* of the random order */
  uint32_t facets_per_cell; /* 0: no k-d tree, a single cell */
  int32_t incremental;      /* 0 or 1; engines only, as join_threshold */
  uint32_t join_threshold;
} shadowcut_tuning;

/* As shadowcut::Options. An option that does not apply is refused (SHADOWCUT_REFUSED). */
typedef struct {
  uint32_t size;
  int32_t kernel, form;
  uint32_t threads; /* 0: one for each processor */
  double min_area, min_solid_angle;
  int32_t constructions; /* 0 or 1; exact kernel, forms pieces and merged */
  shadowcut_tuning tuning;
} shadowcut_options;
/* The defaults of shadowcut::Options. shadowcut_engine_progress replaces its progress function. */
SHADOWCUT_API shadowcut_status shadowcut_options_init(shadowcut_options* options);

/* ---- Shadows of one light ------------------------------------------------------------------- */

typedef struct shadowcut_shadows shadowcut_shadows;

/* Computes the shadows of one light once. The caller owns the result. options: null stands for the
 * defaults. */
SHADOWCUT_API shadowcut_status shadowcut_cast_shadows(const shadowcut_scene* scene,
                                                      const shadowcut_light* light,
                                                      const shadowcut_options* options,
                                                      shadowcut_shadows** shadows);
/* Does nothing to the shadows of an engine. */
SHADOWCUT_API void shadowcut_shadows_destroy(shadowcut_shadows* shadows);

/* Identifies a place in the tree. Constant for as long as the fragment does not change. */
typedef struct {
  uint32_t cell, piece, place;
} shadowcut_fragment_id;
typedef struct {
  shadowcut_fragment_id id;
  uint32_t face, facet;
  uint32_t caster;                     /* SHADOWCUT_INVALID_INDEX: lit, or turned away */
  uint32_t first_corner, corner_count; /* a range of the corners of its block */
  int32_t lit;
  double area;
} shadowcut_fragment;
/* Fragments are stored in blocks; the block of a fragment is the cell of its id. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_block_count(const shadowcut_shadows* shadows,
                                                             uint32_t* block_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_fragment_count(const shadowcut_shadows* shadows,
                                                                uint32_t block,
                                                                uint32_t* fragment_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_fragments(const shadowcut_shadows* shadows,
                                                           uint32_t block, uint32_t first,
                                                           uint32_t count,
                                                           shadowcut_fragment* fragments);
/* Counter-clockwise seen from the light. Valid until the shadows change. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_corners(const shadowcut_shadows* shadows,
                                                         uint32_t block, const double** xyz,
                                                         uint32_t* corner_count);

/* A plane through the light: that of an edge (two points), or that through the line in which two
 * planes meet (a normal and a point of each). */
typedef struct {
  int32_t crossing; /* 1: of two planes */
  double v[4][3];
} shadowcut_light_line;
typedef struct {
  shadowcut_light_line in, out;
  uint32_t vertex; /* of the scene; SHADOWCUT_INVALID_INDEX: `in` and `out` define the corner */
} shadowcut_construction;
/* The exact definitions of the corners of a block; their number is 0 unless
 * shadowcut_options::constructions is set. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_construction_count(
    const shadowcut_shadows* shadows, uint32_t block, uint32_t* count);
SHADOWCUT_API shadowcut_status
shadowcut_shadows_constructions(const shadowcut_shadows* shadows, uint32_t block, uint32_t first,
                                uint32_t count, shadowcut_construction* constructions);

enum {
  SHADOWCUT_FACING_REFUSED = 0,
  SHADOWCUT_AWAY = 1,
  SHADOWCUT_OUT_OF_REACH = 2,
  SHADOWCUT_IGNORED = 3,
  SHADOWCUT_TOWARD = 4
};
typedef struct {
  int32_t facing;
  double area, lit, shadowed, dropped;
} shadowcut_face_area;
/* By index of the scene's faces. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_area_count(const shadowcut_shadows* shadows,
                                                            uint32_t* face_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_areas(const shadowcut_shadows* shadows,
                                                       uint32_t first, uint32_t count,
                                                       shadowcut_face_area* areas);

/* As shadowcut::Stats. */
typedef struct {
  uint32_t size;
  uint64_t faces, facing_faces, facets;
  double facing_area, lit_area, shadowed_area, dropped_area;
  uint64_t lit_fragments, shadowed_fragments;
  uint64_t cells, nodes, sp_nodes, pp_nodes, pieces;
  uint64_t crossing_lines;
  uint64_t predicates, on, by_identity, by_filter, by_exact;
  uint64_t depth, bytes;
  double build_ms, emit_ms;
  uint64_t marked_nodes, longest_location_list, cells_rebuilt, joined, deferred;
} shadowcut_stats;
SHADOWCUT_API shadowcut_status shadowcut_stats_init(shadowcut_stats* stats);
SHADOWCUT_API shadowcut_status shadowcut_shadows_stats(const shadowcut_shadows* shadows,
                                                       shadowcut_stats* stats);

/* ---- Engines -------------------------------------------------------------------------------- */

typedef struct shadowcut_engine shadowcut_engine;

/* Follows the scene and keeps it alive. The first update builds. options: null stands for the
 * defaults. */
SHADOWCUT_API shadowcut_status shadowcut_engine_create(const shadowcut_scene* scene,
                                                       const shadowcut_options* options,
                                                       shadowcut_engine** engine);
SHADOWCUT_API void shadowcut_engine_destroy(shadowcut_engine* engine);
/* Applies all edits made to the scene since the last update; the first update builds. If memory
 * runs out, every function of this engine except compact, progress and destroy returns
 * SHADOWCUT_MUST_COMPACT until compact has succeeded. */
SHADOWCUT_API shadowcut_status shadowcut_engine_update(shadowcut_engine* engine);
/* The same, but stops between two objects when the time, in milliseconds, is over. */
SHADOWCUT_API shadowcut_status shadowcut_engine_update_within(shadowcut_engine* engine, double ms);
/* Rebuilds everything. */
SHADOWCUT_API shadowcut_status shadowcut_engine_compact(shadowcut_engine* engine);
/* The completed share, 0 to 1, of the running update or build. May be called from any thread at any
 * time. */
SHADOWCUT_API shadowcut_status shadowcut_engine_progress(const shadowcut_engine* engine,
                                                         double* share);

/* The changes made by the last update or compact. */
typedef struct {
  uint32_t size;
  uint32_t light_count; /* number of lights whose shadows changed */
  uint64_t update;      /* number of updates and compactions so far */
  uint32_t applied;     /* number of objects and lights brought up to date */
  int32_t complete;     /* 0: the time ran out */
  double ms;
} shadowcut_changes;
SHADOWCUT_API shadowcut_status shadowcut_changes_init(shadowcut_changes* changes);
SHADOWCUT_API shadowcut_status shadowcut_engine_changes(const shadowcut_engine* engine,
                                                        shadowcut_changes* changes);

typedef struct {
  uint32_t size;
  uint32_t light;  /* index of the light */
  int32_t rebuilt; /* 1: the light has a new tree */
  int32_t removed; /* 1: the light and all of its fragments have been removed */
  uint32_t gone_count, added_count, area_count;
} shadowcut_light_changes;
typedef struct {
  shadowcut_fragment_id id;
  uint32_t index; /* within its block */
} shadowcut_added;
typedef struct {
  uint32_t face;
  shadowcut_face_area area;
} shadowcut_changed_area;
SHADOWCUT_API shadowcut_status shadowcut_light_changes_init(shadowcut_light_changes* changes);
/* The i-th changed light, i < shadowcut_changes::light_count; then its removed and added fragments,
 * and the faces whose facing or areas changed. Added fragments may have ids of removed ones: apply
 * `gone` first. */
SHADOWCUT_API shadowcut_status shadowcut_engine_light_changes(const shadowcut_engine* engine,
                                                              uint32_t i,
                                                              shadowcut_light_changes* changes);
SHADOWCUT_API shadowcut_status shadowcut_engine_gone(const shadowcut_engine* engine, uint32_t i,
                                                     uint32_t first, uint32_t count,
                                                     shadowcut_fragment_id* gone);
SHADOWCUT_API shadowcut_status shadowcut_engine_added(const shadowcut_engine* engine, uint32_t i,
                                                      uint32_t first, uint32_t count,
                                                      shadowcut_added* added);
SHADOWCUT_API shadowcut_status shadowcut_engine_changed_areas(const shadowcut_engine* engine,
                                                              uint32_t i, uint32_t first,
                                                              uint32_t count,
                                                              shadowcut_changed_area* areas);

/* The engine's copy of the scene, to which all of its indices refer. Read only, valid as long as
 * the engine. */
SHADOWCUT_API shadowcut_status shadowcut_engine_scene(const shadowcut_engine* engine,
                                                      const shadowcut_scene** scene);
/* The length of the engine's array of lights, removed lights included. */
SHADOWCUT_API shadowcut_status shadowcut_engine_light_count(const shadowcut_engine* engine,
                                                            uint32_t* light_count);
/* The shadows of a light, by its index. The handle is valid as long as the engine and follows its
 * updates. Functions on it return SHADOWCUT_NOT_FOUND while the light does not exist or the engine
 * must be compacted. */
SHADOWCUT_API shadowcut_status shadowcut_engine_shadows(const shadowcut_engine* engine,
                                                        uint32_t light,
                                                        const shadowcut_shadows** shadows);
/* SHADOWCUT_NOT_FOUND: there is no such fragment at present. */
SHADOWCUT_API shadowcut_status shadowcut_engine_find(const shadowcut_engine* engine, uint32_t light,
                                                     const shadowcut_fragment_id* id,
                                                     shadowcut_fragment* fragment);
/* For each face of the engine's scene an upper bound on the area whose state, lit or shadowed, may
 * be wrong. face_count: the capacity of `areas`. Cost: about that of extracting all fragments. */
SHADOWCUT_API shadowcut_status shadowcut_engine_uncertain_area(const shadowcut_engine* engine,
                                                               uint32_t light, uint32_t face_count,
                                                               double* areas);
/* Whether a light reaches a point of a face (index into the faces of the engine's scene): 1 or 0.
 * See shadowcut::Engine::is_lit. */
SHADOWCUT_API shadowcut_status shadowcut_engine_is_lit(const shadowcut_engine* engine,
                                                       uint32_t light, uint32_t face,
                                                       const double* point, int32_t* lit);
/* Checks every invariant; for tests. SHADOWCUT_INTERNAL_ERROR: the message says which one fails. */
SHADOWCUT_API shadowcut_status shadowcut_engine_validate(const shadowcut_engine* engine);

/* ---- Several lights ------------------------------------------------------------------------- */

typedef struct shadowcut_light_partition shadowcut_light_partition;

/* One partition of all faces for all lights, computed by each call. The caller owns it. */
SHADOWCUT_API shadowcut_status shadowcut_engine_overlay(const shadowcut_engine* engine,
                                                        shadowcut_light_partition** partition);
/* The same for these faces only. */
SHADOWCUT_API shadowcut_status
shadowcut_engine_overlay_faces(const shadowcut_engine* engine, const uint32_t* faces,
                               int32_t face_count, shadowcut_light_partition** partition);
SHADOWCUT_API void shadowcut_light_partition_destroy(shadowcut_light_partition* partition);

typedef struct {
  uint32_t face, facet, first_corner, corner_count;
} shadowcut_partition_fragment;
/* mask_words: number of 64-bit words of a fragment's set of lights. */
SHADOWCUT_API shadowcut_status shadowcut_light_partition_count(
    const shadowcut_light_partition* partition, uint32_t* fragment_count, uint32_t* mask_words);
SHADOWCUT_API shadowcut_status
shadowcut_light_partition_fragments(const shadowcut_light_partition* partition, uint32_t first,
                                    uint32_t count, shadowcut_partition_fragment* fragments);
/* Bit k%64 of masks[i*mask_words + k/64] is set iff light k reaches fragment i. Valid as long as
 * the partition. */
SHADOWCUT_API shadowcut_status
shadowcut_light_partition_masks(const shadowcut_light_partition* partition, const uint64_t** masks);
SHADOWCUT_API shadowcut_status shadowcut_light_partition_corners(
    const shadowcut_light_partition* partition, const double** xyz, uint32_t* corner_count);

/* ---- Vertex buffers that follow an engine --------------------------------------------------- */

typedef struct shadowcut_buffers shadowcut_buffers;

enum { SHADOWCUT_SHOW_ALL = 0, SHADOWCUT_SHOW_LIT = 1, SHADOWCUT_SHOW_SHADOWED = 2 };
/* In place of the index of a light. */
#define SHADOWCUT_ALL_LIGHTS SHADOWCUT_INVALID_INDEX

/* shadowcut::BufferLayout; flags are 0 or 1. */
typedef struct {
  uint32_t size;
  int32_t doubles, indexed, normals, faces, objects, states, masks;
  int32_t show;      /* SHADOWCUT_SHOW_... */
  double origin[3];  /* subtracted from all positions */
  double hole_share; /* 0 to 1 */
  uint32_t joined_gap;
} shadowcut_buffer_layout;
SHADOWCUT_API shadowcut_status shadowcut_buffer_layout_init(shadowcut_buffer_layout* layout);

/* Empty buffers for one light, by its index, or for the partition by all lights. layout: null
 * stands for the defaults. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_create(uint32_t light,
                                                        const shadowcut_buffer_layout* layout,
                                                        shadowcut_buffers** buffers);
SHADOWCUT_API void shadowcut_buffers_destroy(shadowcut_buffers* buffers);
/* Applies the changes of the engine's last update; to be called after every update. Refills the
 * buffers after an update that was skipped or that failed, and for another engine than before. If
 * memory runs out, the contents are unspecified until the next successful call. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_update(shadowcut_buffers* buffers,
                                                        const shadowcut_engine* engine);
/* Fills the buffers from shadows or a partition, and the scene these were computed for.
 * SHADOWCUT_REFUSED: they are not of the scene in its present state (not every such error can be
 * detected), or buffers of one light get a partition, or the reverse. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_fill(shadowcut_buffers* buffers,
                                                      const shadowcut_scene* scene,
                                                      const shadowcut_shadows* shadows);
SHADOWCUT_API shadowcut_status
shadowcut_buffers_fill_partition(shadowcut_buffers* buffers, const shadowcut_scene* scene,
                                 const shadowcut_light_partition* partition);
/* The next update refills the buffers. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_set_origin(shadowcut_buffers* buffers,
                                                            const double* origin);

typedef struct {
  uint32_t size;
  uint32_t vertex_count;                /* to draw, holes included */
  uint32_t vertex_capacity;             /* the length of the streams */
  uint32_t index_count, index_capacity; /* 0 unless indexed */
  uint32_t fragment_count, hole_vertices;
  uint32_t mask_words; /* number of 32-bit words of a vertex' mask */
  /* 1: a capacity or mask_words changed. Create new buffers of the graphics interface; the changed
   * ranges cover everything. */
  int32_t grown;
  uint32_t changed_vertex_ranges, changed_index_ranges;
} shadowcut_buffers_info;
SHADOWCUT_API shadowcut_status shadowcut_buffers_info_init(shadowcut_buffers_info* info);
SHADOWCUT_API shadowcut_status shadowcut_buffers_get_info(const shadowcut_buffers* buffers,
                                                          shadowcut_buffers_info* info);

/* The streams: one element for each vertex, or for each index. */
enum {
  SHADOWCUT_POSITIONS = 0, /* 3 floats, or 3 doubles */
  SHADOWCUT_NORMALS = 1,   /* 3 floats: normal of the front of the face */
  SHADOWCUT_FACES = 2,     /* uint32_t: index of the face; SHADOWCUT_INVALID_INDEX in holes */
  SHADOWCUT_OBJECTS = 3,   /* uint32_t: index of the object; likewise */
  SHADOWCUT_STATES = 4,    /* uint8_t: 1 lit, 0 shadowed */
  SHADOWCUT_MASKS = 5,     /* mask_words uint32_t: bit k%32 of word k/32 is set for light k */
  SHADOWCUT_INDICES = 6    /* uint32_t: three for each triangle */
};
/* The address of a stream and the size in bytes of an element. A stream has as many elements as the
 * capacity; those beyond the count are unspecified. SHADOWCUT_NOT_FOUND: the layout excludes it.
 * Valid until the buffers are updated, filled or destroyed. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_stream(const shadowcut_buffers* buffers,
                                                        int32_t stream, const void** data,
                                                        uint32_t* bytes_each);
typedef struct {
  uint32_t first, count;
} shadowcut_range;
/* The changes of the last update: ascending ranges of vertices, for all streams except the indices,
 * and of indices. Multiply by bytes_each for bytes. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_changed_vertices(const shadowcut_buffers* buffers,
                                                                  uint32_t first, uint32_t count,
                                                                  shadowcut_range* ranges);
SHADOWCUT_API shadowcut_status shadowcut_buffers_changed_indices(const shadowcut_buffers* buffers,
                                                                 uint32_t first, uint32_t count,
                                                                 shadowcut_range* ranges);

#ifdef __cplusplus
}
#endif

#endif
