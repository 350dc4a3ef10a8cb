// Shadow volumes without silhouettes, for any mesh: I. Kolic, Z. Mihajlovic, L. Budin, "Stencil
// shadow volumes for complex and deformable objects", ITI 2004. A mesh that the vertex shader
// deforms has its shadow with it, as the volume goes the same way. Every triangle casts, whichever
// way it faces, and its volume is drawn like any other mesh: six triangles of sides and the
// triangle itself, pushed away from the light in the vertex shader. One stencil state serves fronts
// and backs (section 3.2): INVERT where the depth test fails, INCR where it passes, under the write
// mask 1101b, so that the second bit never comes to be; a pixel once marked 1100b, both a pass and
// a failure, is left alone.
//
// Departures. Sides end at infinity, and an eighth triangle closes the volume there: without it a
// ray of the eye that hits a surface before or within a volume and never leaves it fails the depth
// test once, not twice, and what that leaves in the stencil buffer makes a shadow of the next
// volume in front, which two sides should have left as it was. Section 3.2's mask is also the mask
// of the comparison. Nothing is said of a camera within a volume: only one side of it is then seen,
// and what lies in it comes out wrong (tests/system/render_test.cpp has the case).
#include "scene/scene_access.hpp"
#include "technique.hpp"

namespace shadowcut::render {
namespace {

struct VolumeVertex {
  float position[3];
  float pushed;  // 1: to infinity
};

const char* const volume_vertex_shader = R"(
layout(location = 0) in vec4 corner;
uniform mat4 clip;
uniform vec4 light;
invariant gl_Position;
void main() {
  vec4 position = vec4(bent(corner.xyz), 1.0);
  if (corner.w > 0.5)
    position = light.w > 0.5 ? vec4(position.xyz - light.xyz, 0.0) : vec4(light.xyz, 0.0);
  gl_Position = clip * position;
}
)";

constexpr GLint shadow = 0xC;  // 1100b
constexpr GLuint mask = 0xD;   // 1101b

class Kolic : public Technique {
 public:
  Kolic(const Scene& scene, const Model& model)
      : scene_(scene),
        model_(model),
        program_(Model::bending_shader() + volume_vertex_shader, "void main() {}"),
        buffer_(make_buffer()),
        array_(make_vertex_array()) {
    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(VolumeVertex), nullptr);
  }

  void update() override {
    if (known_ == SceneAccess::revision(scene_)) return;
    known_ = SceneAccess::revision(scene_);
    std::vector<VolumeVertex> vertices;
    for (const Facet& facet : scene_.facets()) {
      if (facet.corner_count == 0 ||
          !scene_.objects()[scene_.faces()[facet.face].object].casts_shadows)
        continue;
      const auto corners = scene_.corners_of(facet);
      for (std::size_t i = 2; i < corners.size(); ++i)
        add_volume(vertices, {corners[0].vertex, corners[i - 1].vertex, corners[i].vertex});
    }
    count_ = static_cast<GLsizei>(vertices.size());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(VolumeVertex)),
                 vertices.data(), GL_STATIC_DRAW);
    require_no_error("uploading shadow volumes");
  }

  void add_light(const Frame& frame, std::size_t k) override {
    const Light& light = scene_.lights()[k];
    const bool point = light.kind == Light::Kind::point;
    const Vec3f at = point ? model_.shifted(light.position)
                           : light.direction.stableNormalized().cast<float>().eval();
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    // the triangle fails on itself, and so takes back what its volume did there
    glDepthFunc(GL_LESS);
    glEnable(GL_DEPTH_CLAMP);
    glEnable(GL_STENCIL_TEST);
    glStencilMask(0xFF);
    glClear(GL_STENCIL_BUFFER_BIT);
    glStencilMask(mask);
    glStencilFunc(GL_NOTEQUAL, shadow, mask);
    glStencilOp(GL_KEEP, GL_INVERT, GL_INCR);
    program_.use();
    program_.set("clip", frame.shifted_clip);
    model_.use_wind(program_);
    program_.set("light", Eigen::Vector4f(at.x(), at.y(), at.z(), point ? 1.f : 0.f));
    glBindVertexArray(array_.get());
    glDrawArrays(GL_TRIANGLES, 0, count_);
    glDisable(GL_DEPTH_CLAMP);
    glStencilMask(0xFF);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);  // lit once, however many faces are at one place
    model_.add_light(frame, light, scene_.lights().size(), true);
    glDisable(GL_STENCIL_TEST);
  }

  Figures figures() const override { return {{"volume_triangles", count_ / 3.0}}; }
  bool bends() const override { return true; }

 private:
  void add_volume(std::vector<VolumeVertex>& vertices,
                  const std::array<std::uint32_t, 3>& triangle) const {
    const auto add = [&](std::size_t k, float pushed) {
      const Vec3f p = model_.shifted(scene_.vertices()[triangle[k]]);
      vertices.push_back({{p.x(), p.y(), p.z()}, pushed});
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      add(k, 0), add(k, 1), add(next, 0);
      add(next, 0), add(k, 1), add(next, 1);
    }
    for (std::size_t k = 0; k < 3; ++k) add(k, 0);
    add(0, 1), add(2, 1), add(1, 1);
  }

  const Scene& scene_;
  const Model& model_;
  Program program_;
  Buffer buffer_;
  VertexArray array_;
  GLsizei count_ = 0;
  std::optional<std::uint64_t> known_;  // revision of the scene that this is of
};

}  // namespace

std::unique_ptr<Technique> make_stencil_kolic(const Scene& scene, const Model& model) {
  return std::make_unique<Kolic>(scene, model);
}

}  // namespace shadowcut::render
