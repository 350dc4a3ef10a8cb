// Everything Assimp reads: glTF, DAE, FBX, IFC, 3DS and so on. Its coordinates are floats.
//
// A node with meshes becomes an object. Assimp makes a mesh of each material; all of a node's
// meshes go into one object, so that faces of different materials stay neighbours. The node's
// transform is the object's pose.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <map>
#include <numbers>

#include "files.hpp"
#include "readers.hpp"
#include "text.hpp"

namespace shadowcut::io {

namespace {

struct Place {
  const aiNode* node;
  Pose to_world;
};

Pose pose_of(const aiMatrix4x4& m) {
  Pose pose = Pose::Identity();
  for (unsigned row = 0; row < 3; ++row)
    for (unsigned column = 0; column < 4; ++column)
      pose(row, column) = static_cast<double>(m[row][column]);
  return pose;
}

Vec3 vector_of(const aiVector3D& v) { return Vec3(v.x, v.y, v.z); }

// Every node, parents first and in the file's order. A list, not a recursion: files nest as deep as
// they like.
std::vector<Place> places_of(const aiNode* root) {
  std::vector<Place> places, open{{root, pose_of(root->mTransformation)}};
  while (!open.empty()) {
    const Place place = open.back();
    open.pop_back();
    places.push_back(place);
    for (unsigned i = place.node->mNumChildren; i-- > 0;) {
      const aiNode* child = place.node->mChildren[i];
      open.push_back({child, place.to_world * pose_of(child->mTransformation)});
    }
  }
  return places;
}

// Points and lines are no faces; everything else is, however bad.
void append_mesh(const aiMesh& from, Mesh& to) {
  const auto first = static_cast<std::uint32_t>(to.vertices.size());
  for (unsigned i = 0; i < from.mNumVertices; ++i)
    to.vertices.push_back(vector_of(from.mVertices[i]));
  std::vector<std::uint32_t> loop;
  for (unsigned f = 0; f < from.mNumFaces; ++f) {
    const aiFace& face = from.mFaces[f];
    if (face.mNumIndices < 3) continue;
    loop.clear();
    for (unsigned i = 0; i < face.mNumIndices; ++i)
      loop.push_back(face.mIndices[i] < from.mNumVertices ? first + face.mIndices[i] : bad_index);
    to.add_face(loop);
  }
}

class Builder {
 public:
  Builder(const aiScene& file, std::string path, const ReadOptions& options)
      : file_(file), path_(std::move(path)), options_(options) {}

  Scene build() {
    places_ = places_of(file_.mRootNode);
    for (const Place& place : places_)
      if (place.node->mNumMeshes > 0) ++bearers_[place.node->mName.C_Str()];
    for (const Place& place : places_) add_object(place);
    for (unsigned i = 0; i < file_.mNumLights; ++i) add_light(*file_.mLights[i]);
    return std::move(scene_);
  }

 private:
  void add_object(const Place& place) {
    if (place.node->mNumMeshes == 0) return;
    Mesh mesh;
    std::string name = name_of(*place.node);
    for (unsigned i = 0; i < place.node->mNumMeshes; ++i) {
      const aiMesh& part = *file_.mMeshes[place.node->mMeshes[i]];
      append_mesh(part, mesh);
      if (name.empty()) name = part.mName.C_Str();
    }
    if (mesh.face_count() == 0) return;
    ObjectSettings settings;
    settings.sides = options_.sides;
    settings.name = unique(name.empty() ? stem_of(path_) : name);
    settings.pose = place.to_world;
    // a node scaled to nothing: its faces are to be refused one by one, not the file
    if (!usable(place.to_world)) {
      for (Vec3& v : mesh.vertices) v = place.to_world * v;
      settings.pose = Pose::Identity();
    }
    scene_.add(mesh, settings);
  }

  // Many nodes of an IFC are called after their kind only ("IfcMappedItem"): those are told apart
  // by their parents' names.
  std::string name_of(const aiNode& node) const {
    const std::string name = node.mName.C_Str();
    if (name.empty() || bearers_.at(name) == 1 || node.mParent == nullptr ||
        node.mParent == file_.mRootNode)
      return name;
    const std::string parent = node.mParent->mName.C_Str();
    return parent.empty() ? name : parent + "/" + name;
  }

  static bool usable(const Pose& pose) {
    const double determinant = pose.linear().determinant();
    return pose.matrix().allFinite() && std::isfinite(determinant) && determinant != 0;
  }

  std::string unique(const std::string& name) {
    unsigned& count = used_[name];
    if (++count == 1) return name;
    while (true) {
      std::string numbered = name + " (" + std::to_string(count) + ")";
      if (used_.try_emplace(numbered, 1).second) return numbered;
      ++count;
    }
  }

  // Light that comes from everywhere or from an area casts no sharp shadow and has no counterpart
  // here.
  void add_light(const aiLight& from) {
    const bool directional = from.mType == aiLightSource_DIRECTIONAL,
               spot = from.mType == aiLightSource_SPOT;
    if (!directional && !spot && from.mType != aiLightSource_POINT) return;
    for (const Place& place : places_) {
      if (place.node->mName != from.mName) continue;
      scene_.add(directional ? directional_light(from, place) : point_light(from, place, spot));
      return;
    }
  }

  static Light directional_light(const aiLight& from, const Place& place) {
    Light light = Light::directional(place.to_world.linear() * vector_of(from.mDirection));
    light.name = from.mName.C_Str();
    return light;
  }

  Light point_light(const aiLight& from, const Place& place, bool spot) const {
    Light light = Light::point(place.to_world * vector_of(from.mPosition));
    light.name = from.mName.C_Str();
    ai_real range = 0;  // KHR_lights_punctual's, which Assimp leaves with the node
    if (place.node->mMetaData != nullptr && place.node->mMetaData->Get("PBR_LightRange", range) &&
        range > 0)
      light.range = static_cast<double>(range);
    if (spot)
      light.spot =
          Light::Spot{place.to_world.linear() * vector_of(from.mDirection), half_angle(from)};
    return light;
  }

  // Assimp documents full angles, and its glTF reader hands on half ones.
  double half_angle(const aiLight& from) const {
    const std::string extension = extension_of(path_);
    const bool gltf = extension == ".gltf" || extension == ".glb" || extension == ".vrm";
    const double angle = static_cast<double>(from.mAngleOuterCone) * (gltf ? 1.0 : 0.5);
    return angle > 0 ? std::min(angle, std::numbers::pi) : std::numbers::pi;
  }

  const aiScene& file_;
  const std::string path_;
  const ReadOptions& options_;
  Scene scene_ = empty_scene(options_);
  std::vector<Place> places_;
  std::map<std::string, unsigned> bearers_;  // by node name, how many nodes with meshes have it
  std::map<std::string, unsigned> used_;
};

}  // namespace

Scene read_with_assimp(const std::string& path, const ReadOptions& options) {
  check_readable(path);
  Assimp::Importer importer;
  const aiScene* file = importer.ReadFile(path, 0);  // no triangulation: polygons stay polygons
  if (file == nullptr || file->mRootNode == nullptr)
    throw Error(path + ": " + printable(trimmed(importer.GetErrorString())));
  return Builder(*file, path, options).build();
}

}  // namespace shadowcut::io
