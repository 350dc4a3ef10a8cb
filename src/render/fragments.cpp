// The engine's own fragments: those that a light reaches are drawn, the others are not. There is no shadow pass; after an edit only what
// Engine::update() hands out is uploaded.
//
// The conforming form: the rasteriser would leave cracks at T-junctions. The ambient picture below them is made of whole faces, so
// fragments are drawn a little in front of it.
#include <algorithm>
#include <map>
#include <unordered_map>

#include "technique.hpp"

namespace shadowcut::render {
namespace {

struct IdHash {
  std::size_t operator()(const FragmentId& id) const {
    return (id.cell * std::size_t{0x9E3779B97F4A7C15} ^ id.piece) * std::size_t{0xC2B2AE3D27D4EB4F} ^ id.place;
  }
};

// A vertex buffer in which fragments come and go. What is free is drawn as triangles of no extent.
class FragmentBuffer {
 public:
  void clear() {
    places_.clear(), free_.clear(), vertices_.clear();
    ranges_.clear(), capacity_ = 0;
  }

  void remove(const FragmentId& id) {
    const auto place = places_.find(id);
    if (place == places_.end()) return;  // it was not lit
    const Range range = place->second;
    places_.erase(place);
    for (std::size_t i = range.first; i < range.first + range.count; ++i) vertices_[i] = {};
    free_[range.count].push_back(range.first);
    change(range);
  }

  void add(const FragmentId& id, std::span<const Vertex> triangles) {
    Range range{vertices_.size(), triangles.size()};
    std::vector<std::size_t>& holes = free_[range.count];
    if (holes.empty()) {
      vertices_.insert(vertices_.end(), triangles.begin(), triangles.end());
    } else {
      range.first = holes.back();
      holes.pop_back();
      std::copy(triangles.begin(), triangles.end(), vertices_.begin() + static_cast<std::ptrdiff_t>(range.first));
    }
    places_.emplace(id, range);
    change(range);
  }

  // Uploads what has changed: all where the buffer has to grow. Returns the bytes.
  std::size_t upload() {
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    if (vertices_.size() > capacity_) {
      capacity_ = vertices_.size() + vertices_.size() / 2;
      glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_ * sizeof(Vertex)), nullptr, GL_DYNAMIC_DRAW);
      ranges_.assign(1, {0, vertices_.size()});
    }
    std::size_t bytes = 0;
    for (const Range& range : ranges_) {
      glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(range.first * sizeof(Vertex)),
                      static_cast<GLsizeiptr>(range.count * sizeof(Vertex)), vertices_.data() + range.first);
      bytes += range.count * sizeof(Vertex);
    }
    ranges_.clear();
    return bytes;
  }

  void draw() const {
    glBindVertexArray(array_.get());
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
  }

 private:
  struct Range {
    std::size_t first, count;
  };
  // Ranges that follow one another are uploaded as one.
  void change(const Range& range) {
    if (!ranges_.empty() && ranges_.back().first + ranges_.back().count == range.first) ranges_.back().count += range.count;
    else ranges_.push_back(range);
  }

  Buffer buffer_ = make_buffer();
  VertexArray array_ = Model::array_of(buffer_);
  std::vector<Vertex> vertices_;
  std::size_t capacity_ = 0;  // of the driver's buffer, in vertices
  std::unordered_map<FragmentId, Range, IdHash> places_;
  std::map<std::size_t, std::vector<std::size_t>> free_;  // first vertices of holes, by size
  std::vector<Range> ranges_;                             // changed since the last upload
};

class Fragments : public Technique {
 public:
  Fragments(const Scene& scene, const Model& model)
      : model_(model), engine_(scene, options()), lit_(Model::lit_vertex_shader(), Model::lit_fragment_shader()) {}

  void update() override {
    const Changes& changes = engine_.update();
    gone_ = added_ = bytes_ = 0;
    update_ms_ = changes.ms;
    buffers_.resize(engine_.light_count());
    for (const LightChanges& change : changes.lights) apply(change);
  }

  void add_light(const Frame& frame, std::size_t light) override {
    const Scene& scene = engine_.scene();
    model_.use_light(lit_, frame, scene.lights()[light], scene.lights().size());
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_LEQUAL);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(-0.25f, -4);
    // Once a pixel: corners go to the driver as floats, and two fragments that meet in them may both cover a pixel.
    glEnable(GL_STENCIL_TEST);
    glStencilMask(0xFF);
    glClear(GL_STENCIL_BUFFER_BIT);
    glStencilFunc(GL_EQUAL, 0, 0xFF);
    glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
    buffers_[light].draw();
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_BLEND);
  }

  Figures figures() const override {
    return {{"update_ms", update_ms_}, {"fragments_gone", gone_}, {"fragments_new", added_}, {"bytes_uploaded", bytes_}};
  }
  const Engine* engine() const override { return &engine_; }

 private:
  static Options options() {
    Options options;
    options.form = Form::conforming;
    return options;
  }

  void apply(const LightChanges& change) {
    FragmentBuffer& buffer = buffers_[change.light];
    gone_ += static_cast<double>(change.gone.size()), added_ += static_cast<double>(change.added.size());
    if (change.removed || change.rebuilt) buffer.clear();
    else
      for (const FragmentId& id : change.gone) buffer.remove(id);
    if (change.removed) return;
    const Shadows& shadows = engine_.shadows(change.light);
    for (const LightChanges::Added& a : change.added) {
      const Block& block = shadows.blocks[a.id.cell];
      const shadowcut::Fragment& fragment = block.fragments[a.index];
      if (fragment.lit) add(buffer, fragment, block.corners_of(fragment));
    }
    bytes_ += static_cast<double>(buffer.upload());
  }

  void add(FragmentBuffer& buffer, const shadowcut::Fragment& fragment, std::span<const Vec3> corners) {
    triangles_.clear();
    for (std::size_t i = 2; i < corners.size(); ++i)
      for (const std::size_t k : {std::size_t{0}, i - 1, i})
        triangles_.push_back(model_.vertex(engine_.scene(), fragment.facet, corners[k]));
    buffer.add(fragment.id, triangles_);
  }

  const Model& model_;
  Engine engine_;
  Program lit_;
  std::vector<FragmentBuffer> buffers_;  // by light
  std::vector<Vertex> triangles_;
  double gone_ = 0, added_ = 0, bytes_ = 0, update_ms_ = 0;
};

}  // namespace

std::unique_ptr<Technique> make_fragments(const Scene& scene, const Model& model) { return std::make_unique<Fragments>(scene, model); }

}  // namespace shadowcut::render
