// Shadow tiling: M. Slater, "A comparison of three shadow volume algorithms", 1992, section 5. A
// cube around the light, each face a grid of tiles that know which polygons are seen through them;
// a polygon is cut by the shadow volumes of those with which it shares a tile. A tile that lies
// wholly within a polygon needs to know of no other behind it.
//
// Departures. Which tiles a polygon touches, and which it covers, is decided from where its outline
// crosses the rows of tiles, so that none is missed (Slater does not say how; scan conversion of
// the edges would miss some). For a directional light one grid across the light, as large as the
// scene, takes the cube's place. Lit parts are cut as in brute.cpp.
#include <algorithm>
#include <array>
#include <cmath>

#include "shadow_volumes.hpp"

namespace shadowcut::compare {
namespace {

// A face of the cube, or the one grid: rows of homogeneous coordinates, so that a point x lies at
// (column . x, row . x) / (depth . x) in tiles.
struct Grid {
  Vec3 column, row, depth;
  double column_offset = 0, row_offset = 0, depth_offset = 0;
};
using Homogeneous = Vec3;  // (column, row, depth)

class Tiling : public ShadowVolumes {
 public:
  Tiling(const Lighting& lighting, const Settings& settings)
      : lighting_(lighting),
        side_(std::max(settings.tiles, 1u)),
        counts_(settings.count_shadow_polygons) {
    if (lighting.light().kind == Light::Kind::point) make_cube();
    else make_sheet();
    heads_.assign(grids_.size() * side_ * side_, empty);
  }

  void cut(const Polygon& polygon, std::vector<Fragment>& parts) override {
    find_tiles(polygon);
    cut_by_neighbours(polygon, parts);
  }

  void add(const Polygon& polygon, bool lit) override {
    find_tiles(polygon);
    enter(polygon, lit);
  }

  void cut_and_add(const Polygon& polygon, std::vector<Fragment>& parts) override {
    find_tiles(polygon);
    const std::size_t first = parts.size();
    cut_by_neighbours(polygon, parts);
    enter(polygon, std::any_of(parts.begin() + static_cast<std::ptrdiff_t>(first), parts.end(),
                               [](const Fragment& f) { return f.lit; }));
  }

  std::size_t bytes() const override {
    return volumes_.capacity() * sizeof(Volume) + heads_.capacity() * sizeof(heads_[0]) +
           entries_.capacity() * sizeof(Entry);
  }

 private:
  // What a tile holds: nothing, a list of polygons that touch it, or one that covers it (Slater
  // marks it by the sign too).
  static constexpr std::int32_t empty = -1;
  static std::int32_t covered_by(std::uint32_t volume) {
    return -2 - static_cast<std::int32_t>(volume);
  }
  struct Entry {
    std::uint32_t volume;
    std::int32_t next;
  };
  struct Tile {
    std::size_t index;
    bool covered;
  };
  struct Interval {
    double low = std::numeric_limits<double>::infinity(),
           high = -std::numeric_limits<double>::infinity();
    void take(double x) { low = std::min(low, x), high = std::max(high, x); }
  };
  struct Row {
    Interval touched, below, above;  // the polygon's extent within the row, and on its two borders
  };

  void make_cube() {
    const double half = 0.5 * side_;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        Grid grid;
        grid.depth = sign * Vec3::Unit(axis);
        grid.column = half * (Vec3::Unit((axis + 1) % 3) + grid.depth);
        grid.row = half * (Vec3::Unit((axis + 2) % 3) + grid.depth);
        place(grid, lighting_.light().position);
      }
    }
  }

  void make_sheet() {
    const Vec3 d = lighting_.light().direction.stableNormalized(), u = d.unitOrthogonal(),
               v = d.cross(u);
    Interval across, along;
    for (const Facet& facet : lighting_.scene().facets()) {
      for (const Corner& corner : lighting_.scene().corners_of(facet)) {
        const Vec3& x = lighting_.scene().vertices()[corner.vertex];
        across.take(u.dot(x)), along.take(v.dot(x));
      }
    }
    const double widest = std::max(
        {across.high - across.low, along.high - along.low, std::numeric_limits<double>::min()});
    Grid grid{u * (side_ / widest), v * (side_ / widest), Vec3::Zero()};
    grid.column_offset = -across.low * (side_ / widest),
    grid.row_offset = -along.low * (side_ / widest), grid.depth_offset = 1;
    grids_.push_back(grid);
  }

  void place(Grid grid, const Vec3& origin) {
    grid.column_offset = -grid.column.dot(origin), grid.row_offset = -grid.row.dot(origin),
    grid.depth_offset = -grid.depth.dot(origin);
    grids_.push_back(grid);
  }

  // Fills tiles_ with those that the polygon touches.
  void find_tiles(const Polygon& polygon) {
    tiles_.clear();
    for (std::size_t g = 0; g < grids_.size(); ++g) {
      seen_.clear();
      const Grid& grid = grids_[g];
      for (const PolygonCorner& c : polygon.corners)
        seen_.emplace_back(grid.column.dot(c.at) + grid.column_offset,
                           grid.row.dot(c.at) + grid.row_offset,
                           grid.depth.dot(c.at) + grid.depth_offset);
      clip_to_grid();
      if (seen_.size() >= 3) find_tiles_of(g * side_ * side_);
    }
  }

  // To 0 <= column, row <= side * depth; what meets all four lies before the light.
  void clip_to_grid() {
    const double n = side_;
    for (const Vec3& border : {Vec3(1, 0, 0), Vec3(-1, 0, n), Vec3(0, 1, 0), Vec3(0, -1, n)}) {
      clipped_.clear();
      for (std::size_t i = 0; i < seen_.size(); ++i) {
        const Homogeneous &a = seen_[i], &b = seen_[i + 1 == seen_.size() ? 0 : i + 1];
        const double here = border.dot(a), there = border.dot(b);
        if (here >= 0) clipped_.push_back(a);
        if ((here > 0 && there < 0) || (here < 0 && there > 0))
          clipped_.push_back(a + (here / (here - there)) * (b - a));
      }
      seen_.swap(clipped_);
    }
  }

  // Of the polygon in seen_, row by row.
  void find_tiles_of(std::size_t first_tile) {
    Interval height;
    for (Homogeneous& p : seen_) {
      p = p / p[2];
      height.take(p[1]);
    }
    const std::size_t bottom = tile_of(height.low), top = tile_of(height.high);
    rows_.assign(top - bottom + 1, {});
    for (std::size_t i = 0; i < seen_.size(); ++i)
      follow_edge(seen_[i], seen_[i + 1 == seen_.size() ? 0 : i + 1], bottom);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Row& row = rows_[r];
      const double low = std::max(row.below.low, row.above.low),
                   high = std::min(row.below.high, row.above.high);
      for (std::size_t t = tile_of(row.touched.low), last = tile_of(row.touched.high); t <= last;
           ++t) {
        const auto left = static_cast<double>(t);
        tiles_.push_back({first_tile + (bottom + r) * side_ + t,
                          low <= left + slack && high >= left + 1 - slack});
      }
    }
  }

  // Notes where an edge runs in each row, and where it crosses the borders between them.
  void follow_edge(const Homogeneous& a, const Homogeneous& b, std::size_t bottom) {
    const Homogeneous &lower = a[1] <= b[1] ? a : b, &upper = a[1] <= b[1] ? b : a;
    const auto column_at = [&](double height) {
      if (height <= lower[1]) return lower[0];
      if (height >= upper[1]) return upper[0];
      return lower[0] + (height - lower[1]) / (upper[1] - lower[1]) * (upper[0] - lower[0]);
    };
    for (std::size_t r = tile_of(lower[1]), last = tile_of(upper[1]); r <= last; ++r) {
      Row& row = rows_[r - bottom];
      const double below = static_cast<double>(r), above = below + 1;
      row.touched.take(column_at(below));
      row.touched.take(column_at(above));
      if (lower[1] <= below + slack && upper[1] >= below - slack) row.below.take(column_at(below));
      if (lower[1] <= above + slack && upper[1] >= above - slack) row.above.take(column_at(above));
    }
  }

  std::size_t tile_of(double x) const {
    return static_cast<std::size_t>(std::clamp(std::floor(x), 0.0, static_cast<double>(side_ - 1)));
  }

  void cut_by_neighbours(const Polygon& polygon, std::vector<Fragment>& parts) {
    const std::size_t first = parts.size();
    parts.push_back({polygon, true});
    neighbours_.clear();
    for (const Tile& tile : tiles_) {
      const std::int32_t head = heads_[tile.index];
      if (head < empty) neighbours_.push_back(static_cast<std::uint32_t>(-2 - head));
      for (std::int32_t e = head; e >= 0; e = entries_[static_cast<std::size_t>(e)].next)
        neighbours_.push_back(entries_[static_cast<std::size_t>(e)].volume);
    }
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
    for (const std::uint32_t i : neighbours_) {
      if (counts_ && meets(volumes_[i], polygon, lighting_.tolerance())) ++shadow_polygons_;
      subtract(volumes_[i], lighting_.tolerance(), parts, first);
    }
  }

  // Slater's rule: a covered tile stays as it is; a tile that the polygon covers forgets the
  // others; else it is one more.
  void enter(const Polygon& polygon, bool lit) {
    if (!lit) return;
    const auto volume = static_cast<std::uint32_t>(volumes_.size());
    volumes_.emplace_back();
    lighting_.shadow_planes(polygon, volumes_.back());
    for (const Tile& tile : tiles_) {
      std::int32_t& head = heads_[tile.index];
      if (head < empty) continue;
      if (tile.covered) {
        head = covered_by(volume);
        continue;
      }
      entries_.push_back({volume, head});
      head = static_cast<std::int32_t>(entries_.size() - 1);
    }
  }

  static constexpr double slack = 1e-12;  // of a tile

  const Lighting& lighting_;
  const std::uint32_t side_;
  const bool counts_;
  std::vector<Grid> grids_;
  std::vector<std::int32_t> heads_;  // by grid, row, column
  std::vector<Entry> entries_;
  std::vector<Volume> volumes_;
  // Of the present polygon.
  std::vector<Homogeneous> seen_, clipped_;
  std::vector<Row> rows_;
  std::vector<Tile> tiles_;
  std::vector<std::uint32_t> neighbours_;
};

}  // namespace

std::unique_ptr<ShadowVolumes> make_tiling(const Lighting& lighting, const Settings& settings) {
  return std::make_unique<Tiling>(lighting, settings);
}

}  // namespace shadowcut::compare
