// Random batches of updates of all kinds, valid ones and ones that must be refused.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "tests/support/plain_scene.h"
#include "tests/support/random.h"

namespace sightline::tests {

struct MeshChoice {
  std::shared_ptr<const scenegraph::model::Mesh> mesh;
  std::string digest;
};

/// Small meshes of 2 to 320 triangles, without digests.
std::vector<MeshChoice> small_meshes();

struct RandomEdit {
  std::vector<scenegraph::model::Update> updates;
  std::optional<Code> refusal;  ///< Why the whole batch must be refused; nothing: it is valid.
  /// For a valid batch: the resulting scene, and the ids that its PutNodes get.
  PlainScene after;
  std::vector<scenegraph::model::NodeId> put_nodes;
};

/// A wide, mostly static group for the beginning: kGround small nodes under one.
inline constexpr std::size_t kGround = 300;
RandomEdit ground(const std::vector<MeshChoice>& meshes);

/// Keeps some dozens of nodes and seven levels besides the ground, which it changes rarely.
/// Threads: one caller.
class RandomEdits {
 public:
  RandomEdits(std::vector<MeshChoice> meshes, std::uint64_t seed)
      : meshes_(std::move(meshes)), random_(seed) {}

  /// For the current scene.
  RandomEdit next(const PlainScene& now);

 private:
  struct Batch;
  using NodeId = scenegraph::model::NodeId;

  scenegraph::model::Affine frame();
  const MeshChoice& mesh() { return meshes_[random_.below(meshes_.size())]; }
  scenegraph::model::Mobility mobility();
  std::optional<NodeId> pick(const PlainScene& scene, bool with_mesh);
  void edit(Batch& batch);
  void put_new(Batch& batch, scenegraph::model::NodeRef parent, bool group);
  void put_group(Batch& batch);
  void change(Batch& batch);
  void move(Batch& batch);
  void patch(Batch& batch);
  void remove(Batch& batch);
  Code spoil(Batch& batch);

  std::vector<MeshChoice> meshes_;
  Random random_;
};

}  // namespace sightline::tests
