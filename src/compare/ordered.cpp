// The ordered shadow-volume BSP tree: N. Chin, S. Feiner, "Near real-time object-precision shadow
// generation using BSP trees", SIGGRAPH 1989, as M. Slater has it in "A comparison of three shadow
// volume algorithms", 1992, section 4. Polygons come front to back; what of one comes to an outside
// leaf is lit, and its planes of light take the leaf's place.
//
// Departures. Planes of light are made of the lines that a polygon's edges lie on, not of
// fragments' corners; an edge that a shadow plane cut adds no node, as its plane stands above.
// Polygons in one plane are all cut before any of them is added: contact casts no shadow. With
// Settings::reunite parts of one state are put together again on the way up (Slater's figure 6).
// The tree is as deep as it comes; lists stand in place of recursion.
#include <algorithm>

#include "shadow_volumes.hpp"

namespace shadowcut::compare {
namespace {

class Ordered : public ShadowVolumes {
 public:
  Ordered(const Lighting& lighting, const Settings& settings)
      : lighting_(lighting), reunite_(settings.reunite) {}

  void cut(const Polygon& polygon, std::vector<Fragment>& parts) override {
    filter(polygon);
    hand_out(parts);
  }

  void add(const Polygon& polygon, bool lit) override {
    if (!lit) return;
    filter(polygon);
    attach_lit();
  }

  void cut_and_add(const Polygon& polygon, std::vector<Fragment>& parts) override {
    filter(polygon);
    attach_lit();
    hand_out(parts);
  }

  std::size_t bytes() const override { return nodes_.capacity() * sizeof(Node); }

 private:
  static constexpr std::uint32_t out = invalid_index,
                                 in = invalid_index - 1;  // leaves, in place of nodes
  struct Node {
    HalfSpace plane;         // its front is inside
    std::uint32_t child[2];  // outside, inside
  };
  enum class State : std::uint8_t { divided, lit, shadowed };
  // A part of the polygon being filtered. Where it is divided its two parts follow one another,
  // later in the list.
  struct Part {
    Polygon polygon;
    std::uint32_t node;   // where it is; of a lit one: whose
    std::uint32_t side;   // child it came to be
    std::uint32_t parts;  // of a divided one: the first of two
    State state;
  };

  std::uint32_t& child(std::uint32_t node, std::uint32_t side) {
    return node == invalid_index ? root_ : nodes_[node].child[side];
  }

  void filter(const Polygon& polygon) {
    parts_.clear();
    parts_.push_back({polygon, invalid_index, 0, 0, State::divided});
    for (std::size_t i = 0; i < parts_.size(); ++i) sink(i);
  }

  // Takes a part down until it comes to a leaf or is divided.
  void sink(std::size_t i) {
    for (;;) {
      const std::uint32_t next = child(parts_[i].node, parts_[i].side);
      if (next == out || next == in) {
        parts_[i].state = next == out ? State::lit : State::shadowed;
        return;
      }
      const Standing standing = stand(parts_[i].polygon, nodes_[next].plane, lighting_.tolerance());
      if (standing.side == Side::across) {
        Halves halves = split(parts_[i].polygon, standing, {Carrier::Kind::shadow_plane, 0});
        parts_[i].parts = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back({std::move(halves.back), next, 0, 0, State::divided});
        parts_.push_back({std::move(halves.front), next, 1, 0, State::divided});
        return;
      }
      parts_[i].node = next;
      parts_[i].side = standing.side == Side::front ? 1 : 0;
    }
  }

  void attach_lit() {
    for (const Part& part : parts_) {
      if (part.state != State::lit) continue;
      lighting_.shadow_planes(part.polygon, planes_);
      if (planes_.empty()) {  // all its edges are bounded above
        child(part.node, part.side) = in;
        continue;
      }
      std::uint32_t node = part.node, side = part.side;
      for (const HalfSpace& plane : planes_) {
        nodes_.push_back({plane, {out, in}});
        child(node, side) = static_cast<std::uint32_t>(nodes_.size() - 1);
        node = child(node, side), side = 1;
      }
    }
  }

  void hand_out(std::vector<Fragment>& parts) {
    if (reunite_) {
      for (auto part = parts_.rbegin(); part != parts_.rend(); ++part) {
        if (part->state == State::divided &&
            parts_[part->parts].state == parts_[part->parts + 1].state)
          part->state = parts_[part->parts].state;
      }
    }
    waiting_.assign(1, 0);
    while (!waiting_.empty()) {
      Part& part = parts_[waiting_.back()];
      waiting_.pop_back();
      if (part.state != State::divided)
        parts.push_back({std::move(part.polygon), part.state == State::lit});
      else waiting_.insert(waiting_.end(), {part.parts + 1, part.parts});
    }
  }

  const Lighting& lighting_;
  const bool reunite_;
  std::uint32_t root_ = out;
  std::vector<Node> nodes_;
  std::vector<Part> parts_;  // of the polygon filtered last
  std::vector<std::uint32_t> waiting_;
  Volume planes_;
};

}  // namespace

std::unique_ptr<ShadowVolumes> make_ordered(const Lighting& lighting, const Settings& settings) {
  return std::make_unique<Ordered>(lighting, settings);
}

}  // namespace shadowcut::compare
