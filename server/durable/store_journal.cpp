// A scene's journal in a store: the update log, and all nodes from time to time.
#include "server/durable/store_journal.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/durable/batch_codec.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::durable {
namespace {

/// Bytes of updates that are read from the log at a time.
constexpr std::uint64_t kReadBytes = std::uint64_t{16} << 20;
static_assert(2 * kPartBytes <= store::kMaxSnapshotChunk);

/// A snapshot is not written before the log has this many bytes.
constexpr std::uint64_t kLeastLog = std::uint64_t{1} << 20;
/// What applying a batch again costs beside its updates, in bytes.
constexpr std::uint64_t kBatchCost = 512;

scenes::KeptProducer kept_producer(store::ProducerRecord producer) {
  scenes::KeptProducer kept{producer.last_committed, {}};
  kept.recent.reserve(producer.recent.size());
  for (store::ProducerCommit& commit : producer.recent)
    kept.recent.push_back({commit.sequence, std::move(commit.nodes)});
  return kept;
}

/// Whether another server has written a newer snapshot meanwhile.
bool is_superseded(const Error& error) {
  return error.code == Code::kAlreadyExists || error.code == Code::kOutOfRange ||
         error.code == Code::kAborted;
}

}  // namespace

StoreJournal::StoreJournal(const StoreParts& parts, const store::SceneRecord& record)
    : parts_(parts),
      id_(record.id),
      log_bytes_(record.log_bytes + kBatchCost * (record.revision - record.base)) {}

Status StoreJournal::load(scenes::JournalReader& into) {
  const auto record = parts_.store.scene(id_);
  if (!record) return record.error();
  if (Status loaded = load_base(*record, into); !loaded) return loaded;
  if (Status loaded = load_log(record->base, into); !loaded) return loaded;
  return load_writers(into);
}

Status StoreJournal::load_base(const store::SceneRecord& record, scenes::JournalReader& into) {
  if (record.base == 0) return {};
  NodesReader reader(parts_.blobs);
  for (std::uint64_t index = 0;; ++index) {
    const auto part = parts_.store.read_snapshot(id_, record.base, index);
    if (!part) return part.error();
    if (part->empty()) break;
    if (Status added = reader.add(*part); !added) return added;
  }
  return into.base(std::move(reader).finish(record.base));
}

Status StoreJournal::load_log(std::uint64_t base, scenes::JournalReader& into) {
  for (std::uint64_t last = base;;) {
    const auto batches = parts_.store.read(id_, last, kReadBytes);
    if (!batches) return batches.error();
    if (batches->empty()) return {};
    for (const store::LoggedBatch& logged : *batches) {
      if (logged.revision != ++last) {
        return Error{
            Code::kDataLoss,
            fmt::format("revision {} is missing from the log: run sightlined doctor", last),
            "STORE_CORRUPT"};
      }
      auto batch = decode_batch(logged.updates, parts_.blobs);
      if (!batch) return batch.error();
      if (Status taken = into.batch(last, std::move(batch->updates), batch->nodes); !taken)
        return taken;
    }
  }
}

Status StoreJournal::load_writers(scenes::JournalReader& into) {
  const auto answers = parts_.store.answers(id_);
  if (!answers) return answers.error();
  for (const store::RequestAnswer& answer : *answers) {
    Status taken = into.answer(answer.request_id, answer.content, {answer.revision, answer.nodes});
    if (!taken) return taken;
  }
  const auto producers = parts_.store.producers(id_);
  if (!producers) return producers.error();
  for (const store::ProducerRecord& producer : *producers) {
    scenes::KeptProducer kept = kept_producer(producer);
    Status taken = into.producer(producer.name, kept.last_committed, std::move(kept.recent));
    if (!taken) return taken;
  }
  return {};
}

Status StoreJournal::follow(std::uint64_t revision, scenes::JournalReader& into) {
  return load_log(revision, into);
}

Result<std::optional<scenes::KeptAnswer>> StoreJournal::answer(const std::string& request_id) {
  auto answer = parts_.store.answer(id_, request_id);
  if (!answer) return answer.error();
  if (!*answer) return std::optional<scenes::KeptAnswer>();
  return std::optional(
      scenes::KeptAnswer{(*answer)->content, {(*answer)->revision, std::move((*answer)->nodes)}});
}

Result<std::optional<scenes::KeptProducer>> StoreJournal::producer(const std::string& name) {
  auto producer = parts_.store.producer(id_, name);
  if (!producer) return producer.error();
  if (!*producer) return std::optional<scenes::KeptProducer>();
  return std::optional(kept_producer(std::move(**producer)));
}

std::string StoreJournal::encode(const std::vector<scenegraph::model::Update>& updates,
                                 const std::vector<scenegraph::model::NodeId>& nodes) const {
  return encode_batch(updates, nodes);
}

Result<std::vector<scenegraph::model::Update>> StoreJournal::decode(const std::string& updates) {
  auto batch = decode_batch(updates, parts_.blobs);
  if (!batch) return batch.error();
  return std::move(batch->updates);
}

Status StoreJournal::append(const scenes::JournalEntry& entry, Done done) {
  store::Batch batch;
  batch.scene = id_;
  batch.expected = entry.expected;
  batch.updates = entry.updates;
  for (const std::string& text : entry.mesh_digests) {
    const auto digest = blobs::BlobDigest::parse(text);
    if (!digest) return digest.error();
    batch.blobs.push_back(*digest);
  }
  if (!entry.request_id.empty()) {
    batch.answer =
        store::RequestAnswer{entry.request_id, entry.content, entry.expected + 1, entry.nodes};
  }
  for (const scenes::ProducerBatch& one : entry.batches)
    batch.commits.push_back({entry.producer, one.sequence, one.nodes});
  batch.outcome = entry.outcome;
  batch.after = entry.after;
  if (entry.updates) log_bytes_ += entry.updates->size() + kBatchCost;
  return parts_.store.append(std::move(batch), std::move(done));
}

void StoreJournal::published(const scenegraph::SceneState& newest, std::uint64_t oldest) noexcept {
  if (log_bytes_ < std::max(kLeastLog, last_cost_.load()) || writing_.exchange(true)) return;
  const Status begun = exec::to_status([&]() -> Status {
    parts_.compute.enqueue_background([self = shared_from_this(), newest, oldest] {
      const Status written = exec::to_status([&] { return self->write_snapshot(newest, oldest); });
      if (!written) self->note_failure(newest.snapshot->revision(), written.error());
      self->writing_ = false;
    });
    return {};
  });
  if (!begun) writing_ = false;  // a later revision tries again
}

Status StoreJournal::write_snapshot(const scenegraph::SceneState& state, std::uint64_t oldest) {
  const std::uint64_t revision = state.snapshot->revision();
  const std::uint64_t logged = log_bytes_;
  parts_.store.flush();  // a relaxed revision is published before it is in the log
  NodesWriter writer(state);
  const auto cost = writer.keep_patched(parts_.blobs);
  if (!cost) return cost.error();
  const auto bytes = write_parts(writer, revision);
  if (!bytes && !(parts_.store.shared() && is_superseded(bytes.error()))) return bytes.error();
  if (bytes) last_cost_ = *cost + *bytes;
  log_bytes_ -= logged;
  return move_base(oldest);
}

/// Drops what no readable revision needs. Other servers may do so, too.
Status StoreJournal::move_base(std::uint64_t oldest) {
  const auto record = parts_.store.scene(id_);
  if (!record) return record.error();
  const auto after = std::ranges::upper_bound(record->snapshots, oldest);
  if (after == record->snapshots.begin() || *std::prev(after) == record->base) return {};
  Status dropped = parts_.store.drop_before(id_, *std::prev(after));
  if (!dropped && parts_.store.shared() && dropped.error().code == Code::kFailedPrecondition)
    return {};  // the base is beyond it by now
  return dropped;
}

/// The next snapshot is tried when the log has doubled.
void StoreJournal::note_failure(std::uint64_t revision, const Error& error) {
  last_cost_ = 2 * log_bytes_;
  if (error.code == Code::kNotFound) return;  // the scene was removed
  spdlog::error("event=snapshot_failed revision={} error={}", revision, error.message);
}

/// Returns the bytes of the parts.
Result<std::uint64_t> StoreJournal::write_parts(NodesWriter& writer, std::uint64_t revision) {
  std::uint64_t bytes = 0;
  const Status put =
      parts_.store.put_snapshot(id_, revision, writer.blobs(), [&]() -> Result<std::string> {
        std::string part = writer.next(kPartBytes);
        bytes += part.size();
        return part;
      });
  if (!put) return put.error();
  return bytes;
}

Status StoreJournal::remove() { return parts_.store.remove_scene(id_); }

}  // namespace sightline::server::durable
