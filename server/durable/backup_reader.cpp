// What a store keeps of scenes, as the parts of a backup.
#include "server/durable/backup_reader.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "server/scenes/scene_info.h"
#include "server/updates/scene_codec.h"

namespace sightline::server::durable {
namespace {

/// About the bytes of a part.
constexpr std::size_t kBytes = std::size_t{512} << 10;
/// How often a scene is read whose log is cut meanwhile.
constexpr int kAttempts = 5;

/// Whether the scene was removed, or its log was cut, after its turn had come.
bool has_changed(const Error& error) {
  return error.code == Code::kNotFound || error.code == Code::kOutOfRange;
}

}  // namespace

Status BackupReader::begin() {
  auto scenes = store_.scenes();
  if (!scenes) return scenes.error();
  scenes_ = std::move(*scenes);
  std::ranges::reverse(scenes_);
  if (only_.empty()) return {};
  std::erase_if(scenes_, [this](const auto& scene) { return scene.info.name != only_; });
  if (scenes_.empty())
    return Error{Code::kNotFound, "there is no scene " + only_, "SCENE_NOT_FOUND"};
  return {};
}

Result<bool> BackupReader::next(v1::BackupPart& part) {
  for (;;) {
    part.Clear();
    auto read = read_step(part);
    if (read) {
      if (!*read || part.content_case() != v1::BackupPart::CONTENT_NOT_SET) return read;
      continue;
    }
    if (!has_changed(read.error()) || attempts_ >= kAttempts) return read;
    step_ = Step::kScene;
  }
}

/// Reads a part, or makes a step without one. False: there are no more scenes.
Result<bool> BackupReader::read_step(v1::BackupPart& part) {
  Status done;
  switch (step_) {
    case Step::kScene:
      if (scenes_.empty()) return false;
      done = begin_scene();
      break;
    case Step::kMeshes: {
      auto more = read_mesh(part);
      if (!more) return more;
      if (!*more) {
        describe_scene(part);
        step_ = Step::kNodes;
      }
      break;
    }
    case Step::kNodes: {
      auto more = read_nodes(part);
      if (!more) return more;
      if (!*more) step_ = Step::kBatches;
      break;
    }
    case Step::kBatches:
      done = read_batch(part);
      break;
  }
  if (!done) return done.error();
  return true;
}

Status BackupReader::begin_scene() {
  auto scene = store_.scene(scenes_.back().id);
  if (!scene && scene.error().code == Code::kNotFound) {  // removed meanwhile
    scenes_.pop_back();
    attempts_ = 0;
    return {};
  }
  if (!scene) return scene.error();
  scene_ = std::move(*scene);
  auto meshes = store_.blobs_of(scene_.id);
  if (!meshes) return meshes.error();
  meshes_ = std::move(*meshes);
  std::erase_if(meshes_, [this](const auto& digest) { return sent_.contains(digest); });
  static_cast<void>(store_.has_blobs(meshes_));  // not swept soon
  ++attempts_;
  mesh_ = nullptr;
  chunk_ = 0;
  batches_.clear();
  revision_ = scene_.base;
  offset_ = 0;
  step_ = Step::kMeshes;
  return {};
}

Result<bool> BackupReader::read_mesh(v1::BackupPart& part) {
  if (meshes_.empty()) return false;
  const blobs::BlobDigest digest = meshes_.back();
  if (known_.contains(digest)) {
    part.mutable_mesh()->set_digest(digest.text());
    sent_.insert(digest);
    meshes_.pop_back();
    return true;
  }
  if (mesh_ == nullptr) {
    auto mesh = store_.blob(digest);
    if (!mesh) return mesh.error();
    mesh_ = std::move(*mesh);
  }
  const auto rest = mesh_->bytes().subspan(offset_);
  const auto bytes = rest.first(std::min(kBytes, rest.size()));
  v1::BackupMesh& piece = *part.mutable_mesh();
  piece.set_digest(digest.text());
  piece.mutable_data()->assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  piece.set_more(bytes.size() < rest.size());
  offset_ += bytes.size();
  if (piece.more()) return true;
  sent_.insert(digest);
  meshes_.pop_back();
  mesh_ = nullptr;
  offset_ = 0;
  return true;
}

void BackupReader::describe_scene(v1::BackupPart& part) const {
  v1::BackupScene& begun = *part.mutable_scene();
  updates::encode_info({scene_.info.name, static_cast<scenes::UpAxis>(scene_.info.up_axis),
                        scene_.info.meters_per_unit},
                       *begun.mutable_scene());
  begun.set_base(scene_.base);
  begun.set_revision(scene_.revision);
}

Result<bool> BackupReader::read_nodes(v1::BackupPart& part) {
  if (scene_.base == 0) return false;
  auto nodes = store_.read_snapshot(scene_.id, scene_.base, chunk_++);
  if (!nodes) return nodes.error();
  if (nodes->empty()) return false;
  part.set_nodes(std::move(*nodes));
  return true;
}

/// Reads a batch; after the last, the end of the scene.
Status BackupReader::read_batch(v1::BackupPart& part) {
  if (batches_.empty() && revision_ == scene_.revision) {
    part.mutable_end();
    scenes_.pop_back();
    attempts_ = 0;
    step_ = Step::kScene;
    return {};
  }
  if (batches_.empty()) {
    auto read = store_.read(scene_.id, revision_, kBytes);
    if (!read) return read.error();
    // Batches that came later are left out.
    std::erase_if(*read, [this](const auto& batch) { return batch.revision > scene_.revision; });
    batches_.assign(std::make_move_iterator(read->begin()), std::make_move_iterator(read->end()));
    if (batches_.empty())
      return Error{Code::kDataLoss, "the log ends before its scene: run sightlined doctor",
                   "STORE_CORRUPT"};
    revision_ = batches_.back().revision;
  }
  const store::LoggedBatch& batch = batches_.front();
  v1::BackupBatch& piece = *part.mutable_batch();
  piece.set_revision(batch.revision);
  piece.set_updates(batch.updates.substr(offset_, kBytes));
  offset_ += piece.updates().size();
  piece.set_more(offset_ < batch.updates.size());
  if (piece.more()) return {};
  batches_.pop_front();
  offset_ = 0;
  return {};
}

}  // namespace sightline::server::durable
