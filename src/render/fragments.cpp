// The engine's own fragments: those that a light reaches are drawn, the others are not. There is no
// shadow pass; after an edit only the fragments emitted by Engine::update() are uploaded.
//
// The conforming form: the rasteriser would leave cracks at T-junctions. The ambient picture below
// them is made of whole faces, so fragments are drawn a little in front of it.
#include <shadowcut/buffers.hpp>

#include "technique.hpp"

namespace shadowcut::render {
namespace {

// The lit fragments of one light, in vertex buffers of the driver's.
class LitBuffers {
 public:
  LitBuffers(std::uint32_t light, const Model& model) : fragments_(light, layout(model)) {}

  // Returns the bytes uploaded: all where the buffers have to grow.
  std::size_t update(const Engine& engine, const Changes& changes) {
    fragments_.update(engine, changes);
    colours_.resize(fragments_.vertex_capacity());
    if (fragments_.grown()) {
      positions_.make(fragments_.positions()), normals_.make(fragments_.normals()),
          paint_.make(std::span<const Paint>(colours_));
    }
    std::size_t bytes = 0;
    for (const FragmentBuffers::Range& range : fragments_.changed_vertices()) {
      paint(engine.scene(), range);
      bytes += positions_.upload(fragments_.positions(), 3, range) +
               normals_.upload(fragments_.normals(), 3, range) +
               paint_.upload(std::span<const Paint>(colours_), 1, range);
    }
    return bytes;
  }

  void draw() const {
    glBindVertexArray(array_.get());
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(fragments_.vertex_count()));
  }

 private:
  static BufferLayout layout(const Model& model) {
    BufferLayout layout;
    layout.origin = model.origin();
    layout.faces = layout.states = false;
    layout.objects = true;
    layout.show = Show::lit;
    return layout;
  }

  // One attribute of the vertices.
  class Stream {
   public:
    Stream(const VertexArray& array, GLuint index, GLint count, GLenum type, GLboolean normalised) {
      glBindVertexArray(array.get());
      glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
      glEnableVertexAttribArray(index);
      glVertexAttribPointer(index, count, type, normalised, 0, nullptr);
    }
    template <class T>
    void make(std::span<const T> values) {
      glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
      glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size_bytes()), nullptr,
                   GL_DYNAMIC_DRAW);
    }
    template <class T>
    std::size_t upload(std::span<const T> values, std::size_t width,
                       const FragmentBuffers::Range& range) {
      const std::span<const T> part = values.subspan(width * range.first, width * range.count);
      glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
      glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(width * range.first * sizeof(T)),
                      static_cast<GLsizeiptr>(part.size_bytes()), part.data());
      return part.size_bytes();
    }

   private:
    Buffer buffer_ = make_buffer();
  };

  void paint(const Scene& scene, const FragmentBuffers::Range& range) {
    std::uint32_t last = invalid_index;
    Paint colour{};
    for (std::size_t v = range.first; v < std::size_t{range.first} + range.count; ++v) {
      const std::uint32_t object = fragments_.objects()[v];
      if (object != last)
        colour = object == invalid_index ? Paint{} : paint_of(scene.objects()[object]);
      last = object;
      colours_[v] = colour;
    }
  }

  FragmentBuffers fragments_;
  std::vector<Paint> colours_;  // by vertex
  VertexArray array_ = make_vertex_array();
  Stream positions_{array_, 0, 3, GL_FLOAT, GL_FALSE}, normals_{array_, 1, 3, GL_FLOAT, GL_FALSE};
  Stream paint_{array_, 2, 4, GL_UNSIGNED_BYTE, GL_TRUE};
};

class Fragments : public Technique {
 public:
  Fragments(const Scene& scene, const Model& model)
      : model_(model),
        engine_(scene, options()),
        lit_(Model::lit_vertex_shader(), Model::lit_fragment_shader()) {}

  void update() override {
    const Changes& changes = engine_.update();
    gone_ = added_ = bytes_ = 0;
    update_ms_ = changes.ms;
    for (const LightChanges& change : changes.lights) {
      gone_ += static_cast<double>(change.gone.size()),
          added_ += static_cast<double>(change.added.size());
    }
    while (buffers_.size() < engine_.light_count())
      buffers_.emplace_back(static_cast<std::uint32_t>(buffers_.size()), model_);
    for (LitBuffers& buffers : buffers_)
      bytes_ += static_cast<double>(buffers.update(engine_, changes));
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
    // corners go to the driver as floats, and two fragments that meet in them may both cover a
    // pixel
    Model::once_a_pixel();
    buffers_[light].draw();
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_BLEND);
  }

  Figures figures() const override {
    return {{"update_ms", update_ms_},
            {"fragments_gone", gone_},
            {"fragments_new", added_},
            {"bytes_uploaded", bytes_}};
  }
  const Engine* engine() const override { return &engine_; }

 private:
  static Options options() {
    Options options;
    options.form = Form::conforming;
    return options;
  }

  const Model& model_;
  Engine engine_;
  Program lit_;
  std::vector<LitBuffers> buffers_;  // by light
  double gone_ = 0, added_ = 0, bytes_ = 0, update_ms_ = 0;
};

}  // namespace

std::unique_ptr<Technique> make_fragments(const Scene& scene, const Model& model) {
  return std::make_unique<Fragments>(scene, model);
}

}  // namespace shadowcut::render
