// Scenes from the parts of a backup.
#include "server/durable/restorer.h"

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <utility>

#include "server/durable/batch_codec.h"
#include "server/durable/read_bytes.h"
#include "server/scenes/applied_updates.h"
#include "server/scenes/names.h"
#include "server/updates/scene_codec.h"
#include "sightline/stored/v1/stored.pb.h"

namespace sightline::server::durable {
namespace {

using sightline::stored::v1::Batch;
using sightline::stored::v1::NodesPart;

Error incomplete(const std::string& what) {
  return {Code::kDataLoss, "the backup is not whole: " + what, "BACKUP_INCOMPLETE"};
}

}  // namespace

struct Restorer::Scene {
  Scene(blobs::BlobStore& blobs, std::unique_ptr<blobs::UploadShares::Slot> taken)
      : slot(std::move(taken)), nodes(blobs) {}

  const std::unique_ptr<blobs::UploadShares::Slot> slot;

  scenes::SceneInfo info;
  std::uint64_t base = 0, revision = 0;
  std::uint64_t wanted = 0;  ///< The revision to restore.
  NodesReader nodes;
  std::uint64_t name_bytes = 0, node_bytes = 0;  ///< Bytes of the nodes so far.
  bool in_log = false;                           ///< The nodes at the base are whole.
  std::uint64_t logged = 0;                      ///< The revision of the last whole batch.
  std::string updates;                           ///< Bytes of a batch that is not whole.
  scenegraph::Scene scene;
};

Restorer::Restorer(const Parts& parts, Wanted wanted) : parts_(parts), wanted_(std::move(wanted)) {}

Restorer::~Restorer() {
  if (upload_ != nullptr) parts_.blobs.abandon(upload_);
}

Status Restorer::take(const v1::BackupPart& part) {
  const bool of_mesh = part.content_case() == v1::BackupPart::kMesh;
  if (in_mesh_ && !of_mesh) return incomplete("a mesh ends before its last byte");
  if (of_mesh) return take_mesh(part.mesh());
  if (part.content_case() == v1::BackupPart::kScene) return begin_scene(part.scene());
  if (!in_scene_) return incomplete("a part belongs to no scene");
  if (part.content_case() == v1::BackupPart::kEnd) return end_scene();
  if (scene_ == nullptr) return {};
  if (part.content_case() == v1::BackupPart::kBatch) return take_batch(*scene_, part.batch());
  if (scene_->in_log) return incomplete("nodes come after batches");
  return take_nodes(*scene_, part.nodes());
}

/// Books what the scene takes so far, and `more`.
Status Restorer::hold(const Scene& scene, std::uint64_t more) {
  return scene.slot->hold(scene.node_bytes + scene.updates.size() + more);
}

Status Restorer::take_nodes(Scene& scene, const std::string& nodes) {
  const std::uint64_t reading = bytes_when_read(*NodesPart::descriptor(), nodes);
  if (Status fits = hold(scene, reading); !fits) return fits;
  if (Status added = scene.nodes.add(nodes); !added) return added;
  scene.name_bytes += nodes.size();  // at most
  scene.node_bytes = scenes::bytes_of_scene(scene.nodes.size(), scene.name_bytes);
  return hold(scene, 0);
}

/// Takes part of a mesh. A mesh that is stored is skipped.
Status Restorer::take_mesh(const v1::BackupMesh& mesh) {
  if (!std::exchange(in_mesh_, true)) {
    const auto digest = blobs::BlobDigest::parse(mesh.digest());
    if (!digest) return digest.error();
    if (!parts_.blobs.has(*digest)) {
      auto begun = parts_.blobs.begin(*digest, 0, parts_.caller);
      if (!begun) return begun.error();
      upload_ = std::move(*begun);
    }
  }
  if (upload_ != nullptr) {
    Status added = upload_->append(upload_->committed(), std::as_bytes(std::span(mesh.data())));
    if (!added) return added;
  }
  in_mesh_ = mesh.more();
  if (in_mesh_ || upload_ == nullptr) return {};
  const auto made = parts_.blobs.complete(std::exchange(upload_, nullptr));
  return made ? Status() : Status(made.error());
}

/// Begins a scene. One that has no end yet is dropped.
Status Restorer::begin_scene(const v1::BackupScene& begun) {
  auto info = updates::decode_scene(begun.scene());
  if (!info) return info.error();
  in_scene_ = true;
  scene_ = nullptr;
  if (!wanted_.scene.empty() && info->name != wanted_.scene) return {};
  const std::uint64_t revision = wanted_.revision == 0 ? begun.revision() : wanted_.revision;
  if (revision < begun.base() || revision > begun.revision()) {
    return Error{Code::kOutOfRange,
                 fmt::format("the backup has revisions {} to {} of {}, not {}", begun.base(),
                             begun.revision(), info->name, revision),
                 "REVISION_NOT_KEPT"};
  }
  auto slot = parts_.blobs.take_slot(parts_.caller);
  if (!slot) return slot.error();
  scene_ = std::make_unique<Scene>(parts_.blobs, std::move(*slot));
  scene_->info = std::move(*info);
  scene_->base = scene_->logged = begun.base();
  scene_->revision = begun.revision();
  scene_->wanted = revision;
  return {};
}

Status Restorer::take_batch(Scene& scene, const v1::BackupBatch& batch) {
  if (batch.revision() != scene.logged + 1) {
    return incomplete(fmt::format("revision {} of {} follows {}", batch.revision(), scene.info.name,
                                  scene.logged));
  }
  if (batch.revision() <= scene.wanted) {
    // A string that grows is held twice.
    if (Status fits = hold(scene, scene.updates.size() + 2 * batch.updates().size()); !fits)
      return fits;
    scene.updates += batch.updates();
  }
  if (batch.more()) return {};
  scene.logged = batch.revision();
  if (scene.logged > scene.wanted) return {};
  if (Status begun = begin_log(scene); !begun) return begun;
  return apply(scene, std::exchange(scene.updates, {}));
}

/// Begins the log of a scene after the last of its nodes.
Status Restorer::begin_log(Scene& scene) {
  if (std::exchange(scene.in_log, true) || scene.base == 0) return {};
  return scene.scene.restore(std::move(scene.nodes).finish(scene.base));
}

Status Restorer::apply(Scene& scene, const std::string& updates) {
  const std::uint64_t reading = updates.size() + bytes_when_read(*Batch::descriptor(), updates);
  if (Status fits = hold(scene, reading); !fits) return fits;
  const auto batch = decode_batch(updates, parts_.blobs);
  if (!batch) return batch.error();
  const auto before = scene.scene.snapshot();
  const auto needed = scenes::needed_by(*before, batch->updates);
  if (!needed) return needed.error();
  const std::uint64_t changed =
      needed->nodes + scenes::bytes_replaced(*before, batch->updates).bytes;
  if (Status fits = hold(scene, reading + changed); !fits) return fits;
  const auto charge = [this](std::uint64_t bytes) -> Result<std::shared_ptr<const void>> {
    auto patch = parts_.memory.charge(exec::Held::kPatches, bytes);
    if (!patch) return patch.error();
    return std::shared_ptr<const void>(
        std::make_shared<exec::MemoryAccount::Charge>(std::move(*patch)));
  };
  const auto applied = scene.scene.apply(batch->updates, {.charge = charge});
  if (!applied && applied.error().code == Code::kResourceExhausted) return applied.error();
  if (applied && applied->nodes == batch->nodes) {
    scene.node_bytes += needed->nodes;
    return hold(scene, 0);
  }
  return incomplete(fmt::format("the batch of revision {} of {} cannot be applied again{}",
                                scene.logged, scene.info.name,
                                applied ? "" : ": " + applied.error().message));
}

Status Restorer::end_scene() {
  in_scene_ = false;
  if (scene_ == nullptr) return {};
  Scene& scene = *scene_;
  if (Status begun = begin_log(scene); !begun) return begun;
  if (scene.logged != scene.revision) {
    return incomplete(fmt::format("{} ends at revision {} instead of {}", scene.info.name,
                                  scene.logged, scene.revision));
  }
  const auto restored = parts_.scenes.restore(scene.info, scene.scene.state());
  if (!restored) return restored.error();
  restored_.push_back({scene.info.name, (*restored)->token(scene.wanted)});
  scene_ = nullptr;
  return {};
}

Status Restorer::finish() const {
  if (in_mesh_ || in_scene_) return incomplete("its last part is missing");
  if (restored_.empty() && !wanted_.scene.empty()) {
    return Error{Code::kNotFound, fmt::format("{} is not in the backup", wanted_.scene),
                 "SCENE_NOT_FOUND"};
  }
  if (restored_.empty()) return incomplete("it has no scene");
  return {};
}

}  // namespace sightline::server::durable
