// Everything the engine holds for one light: light space, the prefix, its cells' trees, and the
// shadows. Made in light_tree.cpp, edited in light_tree_edit.cpp.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "emit.hpp"
#include "light_shadows.hpp"
#include "live.hpp"
#include "parallel.hpp"
#include "prefix.hpp"
#include "reach.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

// An exact sum of doubles, however often something is added and taken away again: kept as doubles
// that do not overlap (Shewchuk 1997, grow-expansion).
class Sum {
 public:
  void add(double x) {
    std::size_t kept = 0;
    for (double part : parts_) {
      const TwoDoubles s = two_sum(x, part);
      if (s.low != 0) parts_[kept++] = s.low;
      x = s.high;
    }
    parts_.resize(kept);
    if (x != 0) parts_.push_back(x);
  }
  double value() const { return std::accumulate(parts_.begin(), parts_.end(), 0.0); }

 private:
  std::vector<double> parts_;  // smallest first
};

class LightTree final : public LightShadows {
 public:
  LightTree(const Scene& scene, const Light& light, const Options& options);

  const Shadows& shadows() const override { return shadows_; }
  Shadows take_shadows() override { return std::move(shadows_); }
  const LightSpace& space() const { return space_; }
  const LightTables& tables() const { return tables_; }
  const Prefix& prefix() const { return *prefix_; }
  std::span<const CellTree> cells() const { return cells_; }
  std::string validate() const override;

  // How a facet's side that counts stands to the light. Only `toward` may be lit.
  Facing facing(std::uint32_t facet) const { return facing_[facet]; }
  // The facet's loop runs counter-clockwise in light space when followed forward.
  bool forward(std::uint32_t facet) const {
    const bool ahead =
        turned_[facet] == Turned::toward ? space_.handedness() > 0 : space_.handedness() < 0;
    return ahead != (is_exact() && (shapes_[facet] & reversed));
  }
  bool front_lit(std::uint32_t facet) const { return turned_[facet] == Turned::toward; }

  void begin_update() override;
  void rebuild(const Light& light) override;
  void remove_objects(std::span<const std::uint32_t> objects) override;
  void insert_objects(std::span<const std::uint32_t> objects) override;
  void finish_update(LightChanges& changes) override;
  void rebuild_to_nothing(LightChanges& changes) override;

  const Fragment* find(FragmentId id) const override;
  std::vector<double> undecided() const override;  // undecided.cpp

 private:
  struct LineBlock {             // line ids of one object's edges, at one of its poses
    std::uint32_t first, count;  // ids
    std::uint32_t kept;          // planes left behind that still use them
    bool orphan;                 // its object has gone elsewhere
  };
  struct CellSums {  // what a cell adds to the statistics
    std::uint64_t nodes = 0, pp_nodes = 0, pieces = 0, crossing_lines = 0, predicates = 0, on = 0,
                  by_identity = 0, by_exact = 0, marked = 0, joined = 0, deferred = 0,
                  built_again = 0, bytes = 0;
  };
  struct Fresh {  // a cell as it was when it was built last
    double nodes_per_entry = 0;
    std::uint64_t edits = 0;             // entries inserted since
    std::uint32_t changes_of_mover = 0;  // how often that was another object than the last few
    // while that stays 0: twice as long at each step until the cell is built again
    std::uint32_t patience = 0;
    struct Mover {
      std::uint32_t object;
      std::uint32_t update;  // in which it came last
      std::uint32_t times;   // in how many it came
    };
    bool stirred = false;            // since, by a face large enough to count
    std::vector<Mover> movers = {};  // the objects inserted last, the latest last
  };
  // of as many fragments as there may be, each of up to 2^62 units
  __extension__ using Count = __int128;
  // a face's areas as whole numbers of a unit of its own, so that adding and taking away is exact
  struct Units {
    double unit = 1;
    bool faces_light = false;
    Count lit = 0, shadowed = 0;
  };
  // A facet as the light sees it, exactly: nearly always its loop is convex.
  enum Shape : std::uint8_t { convex = 0, to_be_cut = 1, reversed = 2 };
  struct Parts {  // of facets, in cells
    struct Part {
      std::uint32_t cell, facet;
      std::uint32_t first_corner, corner_count;  // 0: the whole facet
      float error;
    };
    std::vector<Part> list;
    std::vector<ConeCorner> corners;
  };
  struct Old {
    std::uint32_t face;
    FaceArea area;
  };

  // light_tree.cpp
  void build_all();
  void refer_to_scene();
  bool reached(std::uint32_t face) const;
  void face_facet(std::uint32_t facet, bool reached, bool holds_light);
  bool holds_light(const Object& object) const;
  void face_the_light();
  void make_ray(std::uint32_t vertex) {
    tables_.rays[vertex] = rounded(space_.ray(scene_.vertices()[vertex]));
  }
  void make_line(std::uint32_t edge, std::uint32_t id);
  void make_plane(std::uint32_t plane) {
    tables_.planes[plane] = rounded(space_.plane(scene_.planes()[plane]));
  }
  void fill_tables();
  double solid_angle(std::uint32_t facet) const;
  std::vector<std::uint32_t> by_object(std::span<const std::uint32_t> objects,
                                       const std::function<double(std::uint32_t)>& size_of) const;
  std::vector<std::uint32_t> insertion_order(std::vector<Vec3>& centers) const;
  Cone* cone_of_facet(std::uint32_t facet, ConePool& pool) const;
  void note_for_exact(const Object& object, ExactLight& exact) const;
  void span_prefix();
  void face_exactly();  // shapes.cpp, with the next three
  void face_exactly(std::uint32_t facet);
  bool cut_convex(Cone* cone, Workspace& w, std::vector<Cone*>& parts) const;
  double turn_behind(const Cone& cone, std::uint32_t edge) const;
  // The convex cones of a facet: mostly one.
  template <class Take>
  void for_each_cone_of(std::uint32_t facet, Workspace& w, const Take& take) const {
    Cone* cone = cone_of_facet(facet, w.pool);
    if (!is_exact() || !(shapes_[facet] & to_be_cut)) return take(cone);
    std::vector<Cone*> parts;
    cut_convex(cone, w, parts);
    for (Cone* part : parts) take(part);
  }
  void filter_into_cells(std::uint32_t facet, Parts& parts, Workspace& w) const;
  std::vector<Parts> filter_in_chunks(const std::vector<std::uint32_t>& order, std::size_t size);
  Cone* cone_of_part(const Parts& parts, const Parts::Part& part, ConePool& pool) const;
  void build(const std::vector<std::uint32_t>& order);
  void link_entry(std::uint32_t cell, std::uint32_t entry);
  EmitTarget target() const {
    const bool conforming = options_.form == Form::conforming;
    return {scene_, space_, tables_, conforming,
            tables_.exact && options_.constructions && !conforming};
  }
  bool is_exact() const { return options_.kernel == Kernel::exact; }
  Lines lines() const { return Lines(tables_, {}); }  // of scene and prefix
  bool stands_away(std::uint32_t facet) const {       // never entered, and is shadowed whole
    return scene_.facets()[facet].corner_count != 0 &&
           (facing_[facet] == Facing::away || facing_[facet] == Facing::out_of_reach);
  }
  bool is_live() const { return options_.edits && options_.form != Form::conforming; }
  void emit();
  void emit_live();
  Fragment emit_away(std::uint32_t facet, std::uint32_t first_corner, Block& away) const;
  void emit_all_away(CellOutput& away) const;
  FaceArea whole_area(std::uint32_t face) const;
  void sum_up();
  CellSums sums_of(std::size_t cell) const;
  void add_sums(const CellSums& sums, bool more);

  std::string validate_books() const;
  double most_area(std::uint32_t facet, const ExactLight& exact) const;
  double thickness_of(std::uint32_t facet) const;
  double kink(const Cone& cone) const;
  double thickness_left_out(const ExactLight& exact, std::vector<double>& undecided) const;
  double doubt_of_outline(std::uint32_t facet, double thickness) const;

  // light_tree_edit.cpp
  void start_edits();
  void note_everything();
  template <class Edit>
  void edit_cells(std::span<const std::uint32_t> cells, std::size_t work, const Edit& edit);
  // Keeps what a face was before this update.
  void note(std::uint32_t face) {
    if (face >= noted_in_.size() || noted_in_[face] != update_) note_first(face);
  }
  void note_first(std::uint32_t face);
  void note_location_list(std::uint32_t object);
  void grow();
  void face_objects(std::span<const std::uint32_t> objects);
  void face_facets(std::uint32_t object);
  void fill_tables(std::uint32_t object);
  void count_line(std::uint32_t line, bool kept);
  void leave_lines(std::uint32_t object);
  void give_lines_back(std::uint32_t object);
  void take_lines(std::uint32_t object);
  void remove_away(std::uint32_t facet);
  void insert_away(std::uint32_t facet);
  static double unit_for(double area);
  void count_face(const FaceArea& before, const FaceArea& now);
  void measure(std::uint32_t face);
  void total_up();
  void set_area(std::uint32_t face, const FaceArea& area);
  // Nothing but the smallest features is missing from a face's fragments, and they do not overlap.
  void set_dropped(FaceArea& a) const {
    const bool has_fragments = a.facing != Facing::ignored && a.facing != Facing::refused;
    a.dropped = has_fragments && !tables_.least.keeps_all()
                    ? std::max(0.0, a.area - a.lit - a.shadowed)
                    : 0;
  }
  void absorb(std::span<const std::uint32_t> cells);
  void absorb(const LiveCell::AreaChange& change);
  void note_mover(Fresh& fresh, std::uint32_t object) const;
  bool is_much(std::uint32_t cell, std::size_t pieces) const;
  void note_shattered(std::uint32_t cell, std::uint32_t entry, std::uint32_t object);
  bool has_grown(std::uint32_t cell) const;
  void note_fresh(std::uint32_t cell);
  void build_again(std::uint32_t cell, std::vector<std::uint32_t>& given_up, Workspace& w);
  double size_in_order(std::uint32_t facet) const {
    return options_.order == Order::solid_angle ? solid_angle(facet) : 0.0;
  }
  bool suits_numbers(std::span<const std::uint32_t> objects) const;
  Parts filter_into_cells(const std::vector<std::uint32_t>& order);
  void insert_into_cells(const std::vector<std::uint32_t>& order);
  void emit_again();
  void list_changes(LightChanges& changes);
  void list_all(LightChanges& changes) const;
  void list_differences(LightChanges& changes) const;

  const Scene& scene_;
  Options options_;
  Light light_;
  LightSpace space_;
  LightTables tables_;
  std::vector<Turned> turned_;        // by facet
  std::vector<Facing> facing_;        // by facet
  std::vector<std::uint8_t> enters_;  // by facet
  std::vector<std::uint8_t> shapes_;  // by facet, exact kernel: see Shape
  std::unique_ptr<Prefix> prefix_;
  std::vector<CellTree> cells_;
  Shadows shadows_;
  PerThread<Workspace> workspaces_;

  // For edits.
  std::vector<LiveCell> live_;  // by cell
  // by object: the head of its location list (CS95, section 3)
  std::vector<Location> locations_;
  // by facet: index of its fragment in the last block, or none
  std::vector<std::uint32_t> away_;
  RangeList away_corners_;                // of the last block
  std::vector<std::uint32_t> away_born_;  // by facet: the update in which it came
  std::vector<Units> units_;              // by face
  std::vector<FaceArea> fragment_areas_;  // by face: sums of what emit() handed out
  Sum facing_area_, lit_area_, shadowed_area_, dropped_area_;
  std::vector<LineBlock> line_blocks_;
  // indices into line_blocks_, or none
  std::vector<std::uint32_t> block_of_object_, block_of_line_;
  std::multimap<std::uint32_t, std::uint32_t> free_blocks_;  // by count

  std::vector<std::uint32_t> cells_built_again_;  // by cell: how often
  std::vector<Fresh> fresh_;                      // by cell

  // Of this update.
  std::uint32_t update_ = 0;
  bool rebuilt_ = false, edited_ = false;
  // cells; and by cell: the update in which it was touched last
  std::vector<std::uint32_t> touched_, touched_in_;
  std::vector<CellSums> sums_;        // by cell: as the statistics know them
  std::vector<std::uint32_t> batch_;  // cells changed since objects were removed
  std::vector<FragmentId> gone_;      // besides those the cells know of
  std::vector<FragmentId> away_added_;
  std::vector<Old> noted_;               // faces that may have changed, as they were
  std::vector<std::uint32_t> noted_in_;  // by face: the update in which it was noted last
  std::vector<Block> before_;            // where fragments do not know whether they are new
};

}  // namespace shadowcut::SHADOWCUT_NUMBERS
