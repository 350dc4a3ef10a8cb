/* The C interface: everything that scene.hpp, shadows.hpp and buffers.hpp offer, as flat functions on opaque handles. What the words mean
 * (fragment, facet, side, reach, kernel, form) is said there, once.
 *
 * Conventions. Every function that can fail returns a status; what it hands out goes through its last parameters, and is not touched unless
 * the status is SHADOWCUT_OK. No exception, no C++ type and no callback crosses; every id and count is 32 bits wide, so that the functions
 * can be called from JavaScript as they are. Numbers said to be of an enum are int32_t; others than its own are refused.
 *
 * Units and frame: one right-handed world frame in the caller's length unit; areas are that squared; angles are radians. Positions are
 * x, y, z one after another. A pose is sixteen doubles, row by row, local to world; its last row is 0 0 0 1.
 *
 * Ownership: what a *_create function or shadowcut_cast_shadows, shadowcut_engine_combined, shadowcut_scene_copy hands out is the caller's,
 * to be given to the *_destroy function of its kind, which takes null as well. Everything else that is handed out by pointer is lent: each
 * function says for how long. Arrays and strings given to a function are copied before it returns. Engines keep their scene alive.
 *
 * Structs that may grow begin with their size, put there by their *_init function; another size than this library's is refused. Structs
 * without one stay as they are. Array elements are copied out: `count` of them from `first` on, into room that the caller has; a range
 * that is not all there is refused.
 *
 * Threads: as in C++. One handle may be read (const) from any number of threads, and changed by one alone; an engine reads its scene during
 * update and compact. Different handles know nothing of each other, and messages are kept by thread. Costs are those of the C++ functions
 * of the same name; where nothing is said, a call is constant or in proportion to what it copies. */
#ifndef SHADOWCUT_C_H
#define SHADOWCUT_C_H

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
  SHADOWCUT_INVALID_ARGUMENT =
      1, /* misuse: a null pointer, a count or range out of bounds, no number of the enum, a struct's size */
  SHADOWCUT_REFUSED =
      2, /* the value cannot be used: a pose that is not invertible, a light that is not finite, ... */
  SHADOWCUT_STALE = 3,     /* nothing was done: what the id named has been removed */
  SHADOWCUT_FOREIGN = 4,   /* nothing was done: the id is of another scene, or of none */
  SHADOWCUT_NOT_FOUND = 5, /* there is no such thing (now) */
  SHADOWCUT_OUT_OF_MEMORY =
      6, /* nothing was done; but an engine that runs out of memory in an update must be compacted */
  SHADOWCUT_MUST_COMPACT =
      7, /* the engine ran out of memory in an update: shadowcut_engine_compact builds it anew */
  SHADOWCUT_INTERNAL_ERROR = 8 /* a fault of the library's */
};

/* One line, in English, about the last call in this thread that did not return SHADOWCUT_OK; "" if there was none. Lent until the next
 * call in this thread. */
SHADOWCUT_API const char* shadowcut_message(void);
/* The constant's name without its prefix, such as "OUT_OF_MEMORY"; "" for other numbers. */
SHADOWCUT_API const char* shadowcut_status_name(shadowcut_status status);
/* "0.1.0". */
SHADOWCUT_API const char* shadowcut_version(void);

#define SHADOWCUT_NONE UINT32_C(0xFFFFFFFF) /* as an index: no such thing */

/* ---- Meshes: what an object is made of ------------------------------------------------------------------------------------------- */

typedef struct shadowcut_mesh shadowcut_mesh;

/* Nothing is checked here but pointers and counts: scenes check faces, and report them as issues. A mesh that ran out of memory is good
 * for destruction only. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_create(shadowcut_mesh** mesh);
SHADOWCUT_API void shadowcut_mesh_destroy(shadowcut_mesh* mesh);
/* All positions, in the object's frame. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_set_vertices(shadowcut_mesh* mesh, const double* xyz,
                                                           int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_set_vertices_float(shadowcut_mesh* mesh,
                                                                 const float* xyz,
                                                                 int32_t vertex_count);
/* A face: its outer loop, convex or concave, counter-clockwise seen from its front; then its holes, either way round. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_face(shadowcut_mesh* mesh,
                                                       const uint32_t* corners,
                                                       int32_t corner_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_hole(shadowcut_mesh* mesh,
                                                       const uint32_t* corners,
                                                       int32_t corner_count);
/* Many faces without holes: all their corners, one face after another, and how many each has (null: three each, face_count triangles). */
SHADOWCUT_API shadowcut_status shadowcut_mesh_add_faces(shadowcut_mesh* mesh,
                                                        const uint32_t* corners,
                                                        const int32_t* corner_counts,
                                                        int32_t face_count);
/* What is in a mesh. Pointers are lent until it changes. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_vertices(const shadowcut_mesh* mesh,
                                                       const double** xyz, uint32_t* vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_face_count(const shadowcut_mesh* mesh,
                                                         uint32_t* face_count);
SHADOWCUT_API shadowcut_status shadowcut_mesh_loop_count(const shadowcut_mesh* mesh, uint32_t face,
                                                         uint32_t* loop_count);
/* Loop 0 is the outer one. */
SHADOWCUT_API shadowcut_status shadowcut_mesh_loop(const shadowcut_mesh* mesh, uint32_t face,
                                                   uint32_t loop, const uint32_t** corners,
                                                   uint32_t* corner_count);

/* ---- Scenes ------------------------------------------------------------------------------------------------------------------------ */

typedef struct shadowcut_scene shadowcut_scene;

/* Names an object (a light) of one scene: its index among them, which is used again once it has been removed, and a generation, which tells
 * the two apart. Passed by pointer, compared member by member. */
typedef struct {
  uint32_t index, generation, scene;
} shadowcut_object_id;
typedef struct {
  uint32_t index, generation, scene;
} shadowcut_light_id;

enum { SHADOWCUT_SIDES_AUTOMATIC = 0, SHADOWCUT_SIDES_CLOSED = 1, SHADOWCUT_SIDES_OPEN = 2 };

typedef struct {
  uint32_t size;
  int32_t sides; /* SHADOWCUT_SIDES_... */
  int32_t casts; /* 0 or 1, as all that follow */
  int32_t receives;
  int32_t moves; /* expected to move: kept at the leaves of the tree */
  double pose[16];
  const char* name; /* UTF-8; null: "" */
} shadowcut_object_settings;
/* Automatic sides, casts, receives, does not move, the identity, no name. */
SHADOWCUT_API shadowcut_status shadowcut_object_settings_init(shadowcut_object_settings* settings);

enum { SHADOWCUT_POINT = 0, SHADOWCUT_DIRECTIONAL = 1 };

typedef struct {
  uint32_t size;
  int32_t kind;     /* SHADOWCUT_POINT, SHADOWCUT_DIRECTIONAL */
  double at[3];     /* a point light's place; the direction in which a directional light travels */
  double range;     /* point lights; INFINITY for none */
  int32_t has_spot; /* point lights: 1 to confine the light to a cone */
  double spot_axis[3];
  double spot_half_angle; /* radians, in (0, pi] */
  const char* name;       /* null: "" */
} shadowcut_light;
/* A point light at 0, 0, 0 without range, cone or name. */
SHADOWCUT_API shadowcut_status shadowcut_light_init(shadowcut_light* light);

SHADOWCUT_API shadowcut_status shadowcut_scene_create(shadowcut_scene** scene);
/* A scene of its own, which knows the ids of the original. */
SHADOWCUT_API shadowcut_status shadowcut_scene_copy(const shadowcut_scene* scene,
                                                    shadowcut_scene** copy);
SHADOWCUT_API void shadowcut_scene_destroy(shadowcut_scene* scene);

/* Scene::flatness_tolerance (1e-6 unless set) and Scene::coplanarity_tolerance (1e-12; 0: every face keeps a plane of its own). Before
 * objects are added. Refused unless they are finite and not negative. */
SHADOWCUT_API shadowcut_status shadowcut_scene_set_tolerances(shadowcut_scene* scene,
                                                              double flatness, double coplanarity);
SHADOWCUT_API shadowcut_status shadowcut_scene_tolerances(const shadowcut_scene* scene,
                                                          double* flatness, double* coplanarity);

/* settings null: as initialised. Faces that cannot be used are left out, and listed among the issues. */
SHADOWCUT_API shadowcut_status shadowcut_scene_add_object(shadowcut_scene* scene,
                                                          const shadowcut_mesh* mesh,
                                                          const shadowcut_object_settings* settings,
                                                          shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_remove_object(shadowcut_scene* scene,
                                                             const shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_pose(shadowcut_scene* scene,
                                                        const shadowcut_object_id* id,
                                                        const double* pose);
/* As many vertices as the object's mesh has, in its own frame. */
SHADOWCUT_API shadowcut_status shadowcut_scene_set_vertices(shadowcut_scene* scene,
                                                            const shadowcut_object_id* id,
                                                            const double* xyz,
                                                            int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_vertices_float(shadowcut_scene* scene,
                                                                  const shadowcut_object_id* id,
                                                                  const float* xyz,
                                                                  int32_t vertex_count);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_casts(shadowcut_scene* scene,
                                                         const shadowcut_object_id* id,
                                                         int32_t casts);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_receives(shadowcut_scene* scene,
                                                            const shadowcut_object_id* id,
                                                            int32_t receives);
/* What makes the object again as it stands, so that one that is removed can be brought back: a mesh, which is the caller's, and settings
 * (null: not wanted), whose name is lent until the scene changes. */
SHADOWCUT_API shadowcut_status shadowcut_scene_given(const shadowcut_scene* scene,
                                                     const shadowcut_object_id* id,
                                                     shadowcut_mesh** mesh,
                                                     shadowcut_object_settings* settings);

SHADOWCUT_API shadowcut_status shadowcut_scene_add_light(shadowcut_scene* scene,
                                                         const shadowcut_light* light,
                                                         shadowcut_light_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_remove_light(shadowcut_scene* scene,
                                                            const shadowcut_light_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_set_light(shadowcut_scene* scene,
                                                         const shadowcut_light_id* id,
                                                         const shadowcut_light* light);
/* Removes all lights and adds these (an array of pointers), at indices 0, 1, ... */
SHADOWCUT_API shadowcut_status shadowcut_scene_replace_lights(shadowcut_scene* scene,
                                                              const shadowcut_light* const* lights,
                                                              int32_t light_count);

/* The id of what stands at an index; SHADOWCUT_NOT_FOUND when it is free. */
SHADOWCUT_API shadowcut_status shadowcut_scene_object_id(const shadowcut_scene* scene,
                                                         uint32_t index, shadowcut_object_id* id);
SHADOWCUT_API shadowcut_status shadowcut_scene_light_id(const shadowcut_scene* scene,
                                                        uint32_t index, shadowcut_light_id* id);
/* The name is lent until the scene changes. */
SHADOWCUT_API shadowcut_status shadowcut_scene_light(const shadowcut_scene* scene,
                                                     const shadowcut_light_id* id,
                                                     shadowcut_light* light);

typedef struct {
  uint32_t size;
  int32_t sides; /* as decided: closed or open */
  int32_t casts, receives, moves;
  uint32_t first_face, face_count; /* of the scene's faces; likewise below */
  uint32_t first_vertex, vertex_count;
  uint32_t first_facet, facet_count;
  uint32_t first_edge, edge_count;
  uint32_t aligned;     /* facets put into a plane not quite their own */
  double aligned_by;    /* and how far a corner was off */
  double signed_volume; /* positive for a solid with its faces outward */
  double pose[16];
  const char* name; /* lent until the scene changes */
} shadowcut_object;
/* With only `size` set, for the functions that fill it. */
SHADOWCUT_API shadowcut_status shadowcut_object_init(shadowcut_object* object);
/* SHADOWCUT_STALE or _FOREIGN when the id names nothing here. */
SHADOWCUT_API shadowcut_status shadowcut_scene_object(const shadowcut_scene* scene,
                                                      const shadowcut_object_id* id,
                                                      shadowcut_object* object);

/* How long the scene's arrays are (removed objects' places among them), and how often it has been changed. */
typedef struct {
  uint32_t size;
  uint32_t objects, lights, faces, facets, corners, vertices, edges, planes, issues;
  uint64_t revision;
} shadowcut_scene_counts;
SHADOWCUT_API shadowcut_status shadowcut_scene_counts_init(shadowcut_scene_counts* counts);
SHADOWCUT_API shadowcut_status shadowcut_scene_count(const shadowcut_scene* scene,
                                                     shadowcut_scene_counts* counts);
/* Indices of the objects changed after a revision, the one changed longest ago first. At most `room` are written; `count` is how many
 * there are. */
SHADOWCUT_API shadowcut_status shadowcut_scene_changed_since(const shadowcut_scene* scene,
                                                             const uint64_t* revision,
                                                             uint32_t room, uint32_t* indices,
                                                             uint32_t* count);

/* The scene flattened, in world coordinates. */
typedef struct {
  uint32_t object;                   /* SHADOWCUT_NONE: a place left by one that was removed */
  uint32_t number;                   /* within its object, as in its mesh */
  uint32_t first_facet, facet_count; /* 0 facets: refused */
  double area;
} shadowcut_face;
typedef struct {
  uint32_t face, plane, first_corner, corner_count;
} shadowcut_facet;
typedef struct {
  uint32_t vertex;
  uint32_t edge; /* (index of the edge << 1) | 1 when it runs from b to a */
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

/* Why faces were refused, or repaired. */
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
  uint32_t object; /* its index */
  uint32_t face;   /* number within the object */
  int32_t reason;
  const char* detail; /* may be ""; lent until the scene changes */
} shadowcut_issue;
SHADOWCUT_API shadowcut_status shadowcut_scene_issues(const shadowcut_scene* scene, uint32_t first,
                                                      uint32_t count, shadowcut_issue* issues);
/* A short English phrase; "" for other numbers. Lent for good. */
SHADOWCUT_API const char* shadowcut_describe(int32_t reason);
/* 1: the face was refused; 0: it was repaired. */
SHADOWCUT_API int32_t shadowcut_refuses(int32_t reason);

/* ---- Options ----------------------------------------------------------------------------------------------------------------------- */

enum { SHADOWCUT_KERNEL_FAST = 0, SHADOWCUT_KERNEL_EXACT = 1 };
enum { SHADOWCUT_FORM_PIECES = 0, SHADOWCUT_FORM_MERGED = 1, SHADOWCUT_FORM_CONFORMING = 2 };
enum { SHADOWCUT_ORDER_SOLID_ANGLE = 0, SHADOWCUT_ORDER_AS_GIVEN = 1, SHADOWCUT_ORDER_RANDOM = 2 };

typedef struct {
  uint32_t size;
  int32_t kernel, form, order;
  uint64_t seed;            /* of the random order */
  uint32_t threads;         /* 0: one for each processor */
  uint32_t facets_per_cell; /* 0: no prefix */
  double min_area, min_solid_angle;
  int32_t edits; /* 0 or 1; engines only, as all that follow */
  uint32_t join_threshold;
  int32_t constructions; /* 0 or 1 */
} shadowcut_options;
/* The defaults of shadowcut::Options. Its progress function is shadowcut_engine_progress here. */
SHADOWCUT_API shadowcut_status shadowcut_options_init(shadowcut_options* options);

/* ---- Shadows of one light ------------------------------------------------------------------------------------------------------------ */

typedef struct shadowcut_shadows shadowcut_shadows;

/* The one-off call; the shadows are the caller's. options null: as initialised. */
SHADOWCUT_API shadowcut_status shadowcut_cast_shadows(const shadowcut_scene* scene,
                                                      const shadowcut_light* light,
                                                      const shadowcut_options* options,
                                                      shadowcut_shadows** shadows);
/* Of one's own, not of an engine's. */
SHADOWCUT_API void shadowcut_shadows_destroy(shadowcut_shadows* shadows);

/* Names a place in the tree. It stays the same for as long as the fragment is unchanged. */
typedef struct {
  uint32_t cell, piece, place;
} shadowcut_fragment_id;
typedef struct {
  shadowcut_fragment_id id;
  uint32_t face, facet;
  uint32_t caster;                     /* SHADOWCUT_NONE: lit, or turned away */
  uint32_t first_corner, corner_count; /* of its block's */
  int32_t lit;
  double area;
} shadowcut_fragment;
/* Fragments come in blocks; a fragment's is its id's cell. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_block_count(const shadowcut_shadows* shadows,
                                                             uint32_t* block_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_fragment_count(const shadowcut_shadows* shadows,
                                                                uint32_t block,
                                                                uint32_t* fragment_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_fragments(const shadowcut_shadows* shadows,
                                                           uint32_t block, uint32_t first,
                                                           uint32_t count,
                                                           shadowcut_fragment* fragments);
/* Counter-clockwise seen from the light. Lent for as long as the shadows stay as they are. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_corners(const shadowcut_shadows* shadows,
                                                         uint32_t block, const double** xyz,
                                                         uint32_t* corner_count);

/* A plane through the light: an edge's, by two points; or one through the line in which two planes cross, a normal and a point of each. */
typedef struct {
  int32_t crossing;
  double v[4][3];
} shadowcut_light_line;
typedef struct {
  shadowcut_light_line in, out;
  uint32_t vertex; /* of the scene; or SHADOWCUT_NONE, and then `in` and `out` count */
} shadowcut_construction;
/* What a block's corners are, exactly. None at all unless shadowcut_options::constructions. */
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
/* By the scene's faces. */
SHADOWCUT_API shadowcut_status shadowcut_shadows_area_count(const shadowcut_shadows* shadows,
                                                            uint32_t* face_count);
SHADOWCUT_API shadowcut_status shadowcut_shadows_areas(const shadowcut_shadows* shadows,
                                                       uint32_t first, uint32_t count,
                                                       shadowcut_face_area* areas);

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
  uint64_t marked_nodes, longest_location_list, cells_built_again, joined, deferred;
} shadowcut_stats;
SHADOWCUT_API shadowcut_status shadowcut_stats_init(shadowcut_stats* stats);
SHADOWCUT_API shadowcut_status shadowcut_shadows_stats(const shadowcut_shadows* shadows,
                                                       shadowcut_stats* stats);

/* ---- Engines ------------------------------------------------------------------------------------------------------------------------- */

typedef struct shadowcut_engine shadowcut_engine;

/* Follows the scene, which it keeps alive. options null: as initialised. Builds nothing yet. */
SHADOWCUT_API shadowcut_status shadowcut_engine_create(const shadowcut_scene* scene,
                                                       const shadowcut_options* options,
                                                       shadowcut_engine** engine);
SHADOWCUT_API void shadowcut_engine_destroy(shadowcut_engine* engine);
/* Applies all edits since the last one; the first builds. Where memory runs out on the way, every function of the engine's but compact,
 * progress and destroy returns SHADOWCUT_MUST_COMPACT from then on, until compact has succeeded. */
SHADOWCUT_API shadowcut_status shadowcut_engine_update(shadowcut_engine* engine);
/* Stops between objects once the time, in milliseconds, is up. */
SHADOWCUT_API shadowcut_status shadowcut_engine_update_within(shadowcut_engine* engine, double ms);
SHADOWCUT_API shadowcut_status shadowcut_engine_compact(shadowcut_engine* engine);
/* The share, 0 to 1, of the work that the update or build under way has done; from any thread at any time. */
SHADOWCUT_API shadowcut_status shadowcut_engine_progress(const shadowcut_engine* engine,
                                                         double* share);

/* What the last update or compact did. */
typedef struct {
  uint32_t size;
  uint32_t light_count; /* of the lights whose shadows changed */
  uint64_t update;      /* counts updates and compactions */
  uint32_t applied;     /* objects and lights brought up to date */
  int32_t complete;     /* 0: the time ran out */
  double ms;
} shadowcut_changes;
SHADOWCUT_API shadowcut_status shadowcut_changes_init(shadowcut_changes* changes);
SHADOWCUT_API shadowcut_status shadowcut_engine_changes(const shadowcut_engine* engine,
                                                        shadowcut_changes* changes);

typedef struct {
  uint32_t size;
  uint32_t light;  /* index of the light */
  int32_t rebuilt; /* its tree is a new one */
  int32_t removed; /* it is gone, with all its fragments */
  uint32_t gone_count, added_count, area_count;
} shadowcut_light_changes;
typedef struct {
  shadowcut_fragment_id id;
  uint32_t index; /* in its block */
} shadowcut_added;
typedef struct {
  uint32_t face;
  shadowcut_face_area area;
} shadowcut_changed_area;
SHADOWCUT_API shadowcut_status shadowcut_light_changes_init(shadowcut_light_changes* changes);
/* The i-th light of those changed (i below shadowcut_changes::light_count); then the fragments gone and added, and the faces whose facing
 * or areas changed. What was added may use ids that are gone: apply `gone` first. */
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

/* The engine's own copy of the scene, which the shadows are of: all indices handed out are of it. To be read only. Lent for as long as the
 * engine lives. */
SHADOWCUT_API shadowcut_status shadowcut_engine_scene(const shadowcut_engine* engine,
                                                      const shadowcut_scene** scene);
/* Lights with places in the engine, removed ones among them. */
SHADOWCUT_API shadowcut_status shadowcut_engine_light_count(const shadowcut_engine* engine,
                                                            uint32_t* light_count);
/* The shadows of a light, by its index. The handle is lent for as long as the engine lives, and follows it; it is empty, and functions on
 * it return SHADOWCUT_NOT_FOUND, while there is no such light or the engine must be compacted. */
SHADOWCUT_API shadowcut_status shadowcut_engine_shadows(const shadowcut_engine* engine,
                                                        uint32_t light,
                                                        const shadowcut_shadows** shadows);
/* SHADOWCUT_NOT_FOUND when there is no such fragment (now). */
SHADOWCUT_API shadowcut_status shadowcut_engine_find(const shadowcut_engine* engine, uint32_t light,
                                                     const shadowcut_fragment_id* id,
                                                     shadowcut_fragment* fragment);
/* By face, for all of the engine's scene (face_count says how many there is room for): a bound of the area that may be in the other
 * state. Cost: about that of handing out all fragments. */
SHADOWCUT_API shadowcut_status shadowcut_engine_undecided(const shadowcut_engine* engine,
                                                          uint32_t light, uint32_t face_count,
                                                          double* areas);
/* Checks every invariant; for tests. SHADOWCUT_INTERNAL_ERROR, with the message, when one does not hold. */
SHADOWCUT_API shadowcut_status shadowcut_engine_validate(const shadowcut_engine* engine);

/* ---- Several lights ------------------------------------------------------------------------------------------------------------------ */

typedef struct shadowcut_light_sets shadowcut_light_sets;

/* One partition for all lights, made anew with every call; it is the caller's. */
SHADOWCUT_API shadowcut_status shadowcut_engine_combined(const shadowcut_engine* engine,
                                                         shadowcut_light_sets** sets);
/* The part of it on these faces. */
SHADOWCUT_API shadowcut_status shadowcut_engine_combined_faces(const shadowcut_engine* engine,
                                                               const uint32_t* faces,
                                                               int32_t face_count,
                                                               shadowcut_light_sets** sets);
SHADOWCUT_API void shadowcut_light_sets_destroy(shadowcut_light_sets* sets);

typedef struct {
  uint32_t face, facet, first_corner, corner_count;
} shadowcut_set_fragment;
/* mask_words: 64-bit words of a fragment's set of lights. */
SHADOWCUT_API shadowcut_status shadowcut_light_sets_count(const shadowcut_light_sets* sets,
                                                          uint32_t* fragment_count,
                                                          uint32_t* mask_words);
SHADOWCUT_API shadowcut_status shadowcut_light_sets_fragments(const shadowcut_light_sets* sets,
                                                              uint32_t first, uint32_t count,
                                                              shadowcut_set_fragment* fragments);
/* Lent for as long as the sets live. Light k reaches fragment i iff bit k%64 of masks[i*mask_words + k/64] is set. */
SHADOWCUT_API shadowcut_status shadowcut_light_sets_masks(const shadowcut_light_sets* sets,
                                                          const uint64_t** masks);
SHADOWCUT_API shadowcut_status shadowcut_light_sets_corners(const shadowcut_light_sets* sets,
                                                            const double** xyz,
                                                            uint32_t* corner_count);

/* ---- Vertex buffers that follow an engine ------------------------------------------------------------------------------------------- */

typedef struct shadowcut_buffers shadowcut_buffers;

enum { SHADOWCUT_SHOW_ALL = 0, SHADOWCUT_SHOW_LIT = 1, SHADOWCUT_SHOW_SHADOWED = 2 };
#define SHADOWCUT_ALL_LIGHTS SHADOWCUT_NONE /* instead of a light's index */

/* shadowcut::BufferLayout; flags are 0 or 1. */
typedef struct {
  uint32_t size;
  int32_t doubles, indexed, normals, faces, objects, states, masks;
  int32_t show;      /* SHADOWCUT_SHOW_... */
  double origin[3];  /* positions are handed out less this */
  double hole_share; /* 0 to 1 */
  uint32_t joined_gap;
} shadowcut_buffer_layout;
SHADOWCUT_API shadowcut_status shadowcut_buffer_layout_init(shadowcut_buffer_layout* layout);

/* Empty buffers for one light, by its index, or for the partition by all. layout null: as initialised. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_create(uint32_t light,
                                                        const shadowcut_buffer_layout* layout,
                                                        shadowcut_buffers** buffers);
SHADOWCUT_API void shadowcut_buffers_destroy(shadowcut_buffers* buffers);
/* After every update of the engine: applies what it changed, at a cost in proportion to that. After one that was missed, or failed, or
 * with another engine than before, everything is filled anew. Out of memory: what the buffers hold is nobody's until the next call. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_update(shadowcut_buffers* buffers,
                                                        const shadowcut_engine* engine);
/* From shadows, or a partition, and the scene that they are of. SHADOWCUT_REFUSED when they are not of the scene as it stands (not every
 * such error can be seen), or buffers of one light are given a partition, or the reverse. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_fill(shadowcut_buffers* buffers,
                                                      const shadowcut_scene* scene,
                                                      const shadowcut_shadows* shadows);
SHADOWCUT_API shadowcut_status shadowcut_buffers_fill_sets(shadowcut_buffers* buffers,
                                                           const shadowcut_scene* scene,
                                                           const shadowcut_light_sets* sets);
/* The next update fills everything anew. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_set_origin(shadowcut_buffers* buffers,
                                                            const double* origin);

typedef struct {
  uint32_t size;
  uint32_t vertex_count,
      vertex_capacity;                  /* to draw, holes among them; and what there is room for */
  uint32_t index_count, index_capacity; /* 0 unless indexed */
  uint32_t fragment_count, hole_vertices;
  uint32_t mask_words; /* 32-bit words of a vertex' mask */
  int32_t
      grown; /* capacities or mask_words changed: make the buffers to upload to anew; the ranges are everything */
  uint32_t changed_vertex_ranges, changed_index_ranges;
} shadowcut_buffers_info;
SHADOWCUT_API shadowcut_status shadowcut_buffers_info_init(shadowcut_buffers_info* info);
SHADOWCUT_API shadowcut_status shadowcut_buffers_get_info(const shadowcut_buffers* buffers,
                                                          shadowcut_buffers_info* info);

/* What there is of every vertex; and the indices. */
enum {
  SHADOWCUT_POSITIONS = 0, /* 3 floats, or 3 doubles */
  SHADOWCUT_NORMALS = 1,   /* 3 floats: of the face's front */
  SHADOWCUT_FACES = 2,     /* uint32_t: index of the scene's face; SHADOWCUT_NONE in holes */
  SHADOWCUT_OBJECTS = 3,   /* uint32_t: index of the object; likewise */
  SHADOWCUT_STATES = 4,    /* uint8_t: 1 lit, 0 shadowed */
  SHADOWCUT_MASKS = 5,     /* mask_words uint32_t: bit k%32 of word k/32 is light k's */
  SHADOWCUT_INDICES = 6    /* uint32_t, three a triangle */
};
/* Where a stream is, and how many bytes it has for each vertex (index): as many of these as the capacity; past the count they are
 * unspecified. SHADOWCUT_NOT_FOUND where the layout does without it. Lent until the buffers are updated, filled or destroyed. */
SHADOWCUT_API shadowcut_status shadowcut_buffers_stream(const shadowcut_buffers* buffers,
                                                        int32_t stream, const void** data,
                                                        uint32_t* bytes_each);
typedef struct {
  uint32_t first, count;
} shadowcut_range;
/* What the last update changed: ascending ranges of vertices, for all streams but the indices, and of indices. In bytes: times bytes_each.
 */
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
