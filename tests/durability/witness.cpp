// Follows a scene through a watch, and holds it against a plain scene and brute force.
#include "tests/durability/witness.h"

#include <grpcpp/client_context.h>

#include <cstring>

#include "server/codec/update_codec.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::tests::durability {
namespace {

/// Revisions that the server keeps for reads, less those that are replaced meanwhile.
constexpr std::size_t kKept = 60;

/// The translation along x that the update gives to its only node.
double x_of(const v1::SetTransforms& set) {
  scenegraph::model::Affine matrix;
  std::memcpy(matrix.m.data(), set.matrices().data(), sizeof matrix.m);
  return matrix.m[3];
}

std::vector<accel::geometry::Ray> random_rays(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<accel::geometry::Ray> rays(count);
  for (accel::geometry::Ray& ray : rays) {
    const accel::geometry::Vec3d to{random.uniform(-5, 5), random.uniform(-5, 5),
                                    random.uniform(-5, 5)};
    ray.direction = random.direction();
    ray.origin = to + ray.direction * -20.0;
  }
  return rays;
}

}  // namespace

std::string Witness::add_mesh(const TestMesh& mesh) {
  const std::string blob = blob_of(mesh);
  const auto digest = digest_of(blob);
  const auto upload = *meshes_.begin(digest, 0, {"witness", "witness"});
  static_cast<void>(upload->append(0, bytes_of(blob)));
  static_cast<void>(meshes_.complete(upload));
  return digest.text();
}

void Witness::go_back(std::uint64_t revision) {
  while (revisions_.size() > 1 && revisions_.back().revision > revision) revisions_.pop_back();
  if (this->revision() > revision)
    findings_.add(findings_.lost, fmt::format("more than {} revisions", kKept));
  seen_ = this->revision();
  for (auto& [producer, batches] : skipped_)
    batches.erase(batches.upper_bound(revisions_.back().applied[producer]), batches.end());
}

void Witness::watch(Api& api, std::uint64_t until) {
  if (until > 0 && revision() >= until) return;
  grpc::ClientContext context;
  v1::WatchSceneRequest request;
  request.set_scene(kScene);
  request.set_start_revision(revision());
  const auto call = api.scenes->WatchScene(&context, request);
  v1::WatchSceneResponse message;
  std::vector<v1::Update> updates;
  bool cancelled = false;
  while (!cancelled && call->Read(&message)) {
    if (message.progress()) continue;
    updates.insert(updates.end(), message.updates().begin(), message.updates().end());
    if (message.more()) continue;
    take(message.revision().revision(), updates);
    updates.clear();
    cancelled = revision() == until;
  }
  if (cancelled) context.TryCancel();
  const grpc::Status ended = call->Finish();
  if (!cancelled && ended.error_code() != grpc::StatusCode::UNAVAILABLE)
    findings_.add(findings_.gaps, "the watch ended: " + ended.error_message());
}

void Witness::take(std::uint64_t revision, const std::vector<v1::Update>& updates) {
  if (revision != this->revision() + 1)
    findings_.add(findings_.gaps,
                  fmt::format("revision {} follows {}", revision, this->revision()));
  google::protobuf::RepeatedPtrField<v1::Update> message(updates.begin(), updates.end());
  const auto decoded = server::codec::decode_updates(message, meshes_);
  if (!decoded) return findings_.add(findings_.other, decoded.error().message);
  Kept next = revisions_.back();
  next.revision = revision;
  for (const auto& update : *decoded) next.scene.apply(update);
  next.scene.publish();
  revisions_.push_back(std::move(next));
  seen_ = revision;
  if (revisions_.size() > kKept) revisions_.pop_front();
  for (const v1::Update& update : updates) {
    if (update.has_put_node()) name_nodes(update.put_node());
  }
  check_batch(revision, updates);
}

void Witness::name_nodes(const v1::PutNode& put) {
  const std::string& name = put.name();
  if (name.starts_with("request-") && !requests_.insert(name).second)
    findings_.add(findings_.repeats, name + " was applied twice");
  const std::size_t counter = name.find(" counter ");
  if (counter == std::string::npos) return;
  const std::string producer = name.substr(0, counter);
  const bool first = name.ends_with('1');
  revisions_.back().counters[put.node()] = {producer, first};
  if (first) note_batch(producer, 1);
}

/// A producer's batch begins with its first counter and ends with its second.
void Witness::check_batch(std::uint64_t revision, const std::vector<v1::Update>& updates) {
  if (updates.empty() || !updates.front().has_set_transforms()) {
    if (updates.size() != 1 && updates.size() != 2)
      findings_.add(findings_.halves, fmt::format("revision {} lacks its beginning", revision));
    return;
  }
  const auto counter_of = [&](const v1::Update& update) {
    const auto& counters = revisions_.back().counters;
    const auto found = update.has_set_transforms() ? counters.find(update.set_transforms().nodes(0))
                                                   : counters.end();
    return found == counters.end() ? Counter{} : found->second;
  };
  const Counter first = counter_of(updates.front()), last = counter_of(updates.back());
  const bool whole =
      !first.producer.empty() && first.producer == last.producer && first.first && !last.first &&
      x_of(updates.front().set_transforms()) == x_of(updates.back().set_transforms());
  if (!whole) {
    findings_.add(findings_.halves, fmt::format("revision {} holds a part of a batch", revision));
    return;
  }
  note_batch(first.producer, static_cast<std::uint64_t>(x_of(updates.front().set_transforms())));
}

void Witness::note_batch(const std::string& producer, std::uint64_t sequence) {
  std::uint64_t& last = revisions_.back().applied[producer];
  if (sequence <= last)
    findings_.add(findings_.repeats,
                  fmt::format("batch {} of {} came after {}", sequence, producer, last));
  for (std::uint64_t left_out = last + 1; left_out < sequence; ++left_out)
    skipped_[producer].insert(left_out);
  last = sequence;
}

void Witness::check_rays(Api& api, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  cast(api, revisions_.back(), false, count / 2, random.next());
  cast(api, revisions_[random.below(revisions_.size())], true, count - count / 2, random.next());
}

void Witness::cast(Api& api, const Kept& at, bool exact, std::size_t count, std::uint64_t seed) {
  const auto rays = random_rays(count, seed);
  v1::CastRaysRequest request = cast_request(kScene, rays);
  for (const v1::HitField field :
       {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
        v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT})
    request.add_fields(field);
  if (exact) request.mutable_consistency()->set_exact_revision(at.revision);
  v1::CastRaysResponse reply;
  const grpc::Status status = api.cast(request, &reply);
  if (!status.ok()) return findings_.add(findings_.other, "a cast: " + status.error_message());
  if (reply.served().revision() != at.revision) {
    return findings_.add(findings_.gaps, fmt::format("revision {} was served, expected {}",
                                                     reply.served().revision(), at.revision));
  }
  const Comparison compared = compare(rays, decode_hits(reply), BruteForce(at.scene.placed()));
  rays_ += count;
  if (compared.clean()) return;
  findings_.add(findings_.wrong, fmt::format("at revision {}: {}", at.revision, compared.report()));
}

}  // namespace sightline::tests::durability
