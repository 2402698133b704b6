// Gives messages to the decoders, without a server.
#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "proto/rays/generated_rays.h"
#include "server/blobs/blob_store.h"
#include "server/blobs/mesh_blob.h"
#include "server/codec/update_codec.h"
#include "server/exec/admission.h"
#include "server/exec/memory_account.h"
#include "server/queries/batch_rays.h"
#include "server/queries/cast_query.h"
#include "server/queries/generator_codec.h"
#include "server/queries/ray_codec.h"
#include "server/queries/shared_rays.h"
#include "server/scenes/names.h"
#include "server/updates/producer_messages.h"
#include "server/updates/scene_codec.h"
#include "sightline/v1/blob.pb.h"
#include "sightline/v1/query.pb.h"
#include "sightline/v1/scene.pb.h"
#include "tests/fuzz/service/check_session.h"

namespace sightline::tests {
namespace {

using Wrong = std::optional<std::string>;

/// Without any mesh, and never destroyed.
server::blobs::BlobStore& no_blobs() {
  static auto& memory = *new server::exec::MemoryAccount(std::uint64_t{1} << 30);
  static auto& blobs = *new server::blobs::BlobStore(memory);
  return blobs;
}

/// Decoding an encoded update must give the same message again.
Wrong check_updates(const google::protobuf::RepeatedPtrField<v1::Update>& updates) {
  const auto decoded = server::codec::decode_updates(updates, no_blobs());
  if (!decoded) return std::nullopt;
  google::protobuf::RepeatedPtrField<v1::Update> again;
  constexpr std::size_t kAll = std::size_t{1} << 30;
  for (const auto& update : *decoded) server::codec::encode_update(update, 0, kAll, *again.Add());
  const auto twice = server::codec::decode_updates(again, no_blobs());
  if (!twice) return "an encoded update is refused: " + twice.error().message;
  for (std::size_t i = 0; i < twice->size(); ++i) {
    v1::Update third;
    server::codec::encode_update((*twice)[i], 0, kAll, third);
    if (third.SerializeAsString() != again[static_cast<int>(i)].SerializeAsString())
      return fmt::format("update {} is not the same when it is decoded again", i);
  }
  return std::nullopt;
}

Wrong check_rays(const v1::Rays& rays) {
  const auto count = server::queries::count_rays(rays);
  if (!count) return std::nullopt;
  std::vector<accel::geometry::Ray> decoded(*count);
  server::queries::decode_rays(rays, 0, decoded);
  const std::size_t bytes = decoded.size() * 3 * (rays.float64() ? 8 : 4);
  if (rays.origins().size() != bytes || decoded.size() > server::queries::kMaxRaysPerRequest)
    return fmt::format("{} bytes of origins are {} rays", rays.origins().size(), decoded.size());
  return std::nullopt;
}

/// Makes some rays of a generator that is accepted.
Wrong check_generator(const v1::RayGenerator& message) {
  constexpr std::uint64_t kSome = 100;
  auto generator = server::queries::decode_generator(message);
  if (!generator) return std::nullopt;
  const std::uint64_t count = std::min(proto::rays::count_of(*generator), kSome);
  if (count == 0) return std::nullopt;
  generator->count = count;
  proto::rays::GeneratedRays rays;
  rays.begin(*generator);
  std::uint64_t made = 0;
  using proto::rays::Vector;
  rays.make(0, rays.size(), [&](std::size_t, const Vector&, const Vector&) { ++made; });
  if (made != count) return fmt::format("{} rays are made, not {}", made, count);
  return std::nullopt;
}

Wrong check_names(const std::string& text) {
  static_cast<void>(server::scenes::check_scene_name(text));
  static_cast<void>(server::scenes::check_project_name(text));
  const auto digest = server::blobs::BlobDigest::parse(text);
  if (digest && digest->text() != text) return "a digest has two forms: " + text;
  const auto token = server::scenes::RevisionToken::parse(text);
  if (token && token->text() != text) return "a token has two forms: " + text;
  return std::nullopt;
}

/// The bytes of a mesh in two pieces, cut at `cut`.
Wrong check_mesh(const std::string& bytes, std::uint64_t cut) {
  server::blobs::MeshBlobReader reader(bytes.size());
  const auto all = std::as_bytes(std::span(bytes));
  const auto first = all.first(std::min<std::size_t>(cut, all.size()));
  if (!reader.append(first) || !reader.append(all.subspan(first.size()))) return std::nullopt;
  const auto mesh = reader.finish();
  if (mesh && reader.received() != bytes.size()) return "a mesh of other bytes is taken";
  return std::nullopt;
}

/// Reads all points as a server does.
Wrong check_points(const v1::QueryPointsRequest& request) {
  server::queries::BatchRays batch;
  if (!batch.begin(request, {})) return std::nullopt;
  std::vector<accel::geometry::Ray> rays(batch.size());
  batch.decode(0, rays);
  std::vector<double> made;
  const auto view = batch.view(0, batch.size(), made);
  return view.size == rays.size() ? std::nullopt : Wrong("a view of other points");
}

/// Columns of a segment that are accepted are within it.
template <class Message>
Wrong check_shared(const Message& message) {
  constexpr std::uint64_t kSegment = std::uint64_t{1} << 20;
  const auto shared =
      server::queries::SharedRays::decode(message, kSegment, server::queries::kMaxSharedRays);
  if (!shared) return std::nullopt;
  for (const server::queries::SegmentRange& range : shared->ranges()) {
    if (range.begin > kSegment || range.bytes > kSegment - range.begin)
      return fmt::format("column {} of a segment is not within it", range.name);
  }
  return std::nullopt;
}

Wrong check_batch(const v1::UpdateBatch& batch) {
  server::exec::Admission admission({}), batch_admission({});
  server::exec::Quotas quotas({});
  server::updates::UpdateBatches batches(no_blobs(), {"a", "a:1"}, admission, batch_admission,
                                         quotas);
  batches.begin(batch.sequence() - 1);
  static_cast<void>(batches.accept(batch));
  return check_updates(batch.updates());
}

Wrong check_message(const google::protobuf::Message& message) {
  if (const auto* cast = dynamic_cast<const v1::CastRaysRequest*>(&message)) {
    static_cast<void>(server::queries::decode_query(*cast, scenegraph::Growth::kFirstTouch));
    if (Wrong wrong = check_names(cast->consistency().SerializeAsString())) return wrong;
    if (cast->has_shared()) return check_shared(cast->shared());
    return cast->has_generator() ? check_generator(cast->generator()) : check_rays(cast->rays());
  }
  if (const auto* points = dynamic_cast<const v1::QueryPointsRequest*>(&message)) {
    static_cast<void>(server::queries::decode_query(*points, scenegraph::Growth::kFirstTouch));
    return points->has_shared() ? check_shared(points->shared()) : check_points(*points);
  }
  if (const auto* apply = dynamic_cast<const v1::ApplyUpdatesRequest*>(&message))
    return check_updates(apply->updates());
  if (const auto* stream = dynamic_cast<const v1::StreamUpdatesRequest*>(&message))
    return check_batch(stream->batch());
  if (const auto* scene = dynamic_cast<const v1::CreateSceneRequest*>(&message)) {
    static_cast<void>(server::updates::decode_scene(scene->scene()));
    return check_names(scene->scene().name());
  }
  if (const auto* upload = dynamic_cast<const v1::UploadBlobRequest*>(&message)) {
    if (Wrong wrong = check_names(upload->digest())) return wrong;
    return check_mesh(upload->data(), upload->offset());
  }
  return std::nullopt;
}

}  // namespace

Wrong check_decoders(const Session& session) {
  for (const FuzzCall& call : session) {
    for (const std::string& message : call.messages) {
      if (Wrong wrong = check_names(message)) return wrong;
      const auto typed = parse(call, message);
      if (!typed) continue;
      if (Wrong wrong = check_message(*typed)) return wrong;
    }
  }
  return std::nullopt;
}

}  // namespace sightline::tests
