// Casts at a changing scene.
#include "tests/e2e/casting_client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "tests/e2e/wire_updates.h"
#include "tests/support/compare_hits.h"
#include "tests/support/kinds.h"

namespace sightline::tests {
namespace {

using scenegraph::RayTally;

constexpr std::size_t kRays = 24;
constexpr std::uint64_t kFarBack = 100;  // Revisions, some of which are no longer kept

// One row for each ray, or for each hit.
std::vector<accel::geometry::Hit> rows_of(const v1::CastRaysResponse& reply) {
  const auto t = column_values<double>(reply, v1::HIT_FIELD_T);
  const auto node = column_values<std::uint64_t>(reply, v1::HIT_FIELD_NODE);
  const auto primitive = column_values<std::uint32_t>(reply, v1::HIT_FIELD_PRIMITIVE);
  std::vector<accel::geometry::Hit> hits(t.size());
  for (std::size_t k = 0; k < t.size(); ++k) {
    hits[k].t = t[k];
    hits[k].node = node[k];
    hits[k].primitive = primitive[k];
    hits[k].state = accel::geometry::HitState::kHit;
  }
  return hits;
}

v1::Culling to_message(accel::geometry::Culling culling) {
  switch (culling) {
    case accel::geometry::Culling::kBack:
      return v1::CULLING_BACK;
    case accel::geometry::Culling::kFront:
      return v1::CULLING_FRONT;
    case accel::geometry::Culling::kNone:
      break;
  }
  return v1::CULLING_NONE;
}

}  // namespace

grpc::StatusCode wire_code(Code code) {
  switch (code) {
    case Code::kNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case Code::kFailedPrecondition:
      return grpc::StatusCode::FAILED_PRECONDITION;
    default:
      return grpc::StatusCode::INVALID_ARGUMENT;
  }
}

void begin(Api& api, ServedStress& stress) {
  ASSERT_TRUE(api.create(kMovingScene).ok());
  for (MeshChoice choice : small_meshes()) {
    const accel::geometry::MeshView view = choice.mesh->view();
    choice.digest = api.add_mesh(
        {{view.vertices.begin(), view.vertices.end()}, {view.faces.begin(), view.faces.end()}});
    stress.meshes.push_back(std::move(choice));
  }
  RandomEdit first = ground(stress.meshes);
  std::vector<v1::Update> updates;
  for (const scenegraph::model::Update& update : first.updates)
    updates.push_back(sightline::tests::to_message(update));
  const grpc::Status applied = api.apply(kMovingScene, updates);
  ASSERT_TRUE(applied.ok()) << applied.error_message();
  stress.history.add(std::move(first.after));
}

void CastingClient::record_revision(const v1::SceneRevision& revision) {
  if (revision.revision() > known_.revision()) known_ = revision;
}

v1::CastRaysRequest CastingClient::request(const RandomQuestion& question) {
  v1::CastRaysRequest request = cast_request(kMovingScene, question.rays);
  request.set_root(question.root);
  request.mutable_exclude()->Assign(question.excluded.begin(), question.excluded.end());
  request.set_culling(to_message(question.culling));
  constexpr v1::QueryKind kKinds[] = {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ANY,
                                      v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ALL};
  request.set_kind(kKinds[random_.below(4)]);
  request.add_fields(v1::HIT_FIELD_HIT);
  if (request.kind() == v1::QUERY_KIND_CLOSEST || request.kind() == v1::QUERY_KIND_ALL) {
    for (const auto field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE})
      request.add_fields(field);
  }
  if (request.kind() == v1::QUERY_KIND_ALL) request.set_max_hits(question.max_hits);
  const std::uint64_t consistency = random_.below(4);
  if (consistency == 0 && !known_.token().empty()) {
    request.mutable_consistency()->set_at_least(known_.token());
  } else if (consistency == 1) {
    const std::uint64_t newest = stress_.history.latest()->revision();
    request.mutable_consistency()->set_exact_revision(newest -
                                                      random_.below(std::min(newest, kFarBack)));
  }
  return request;
}

// When the server answers, a node that the query names may be deleted, or not exist yet.
void CastingClient::cast(bool judged) {
  const RandomQuestion question = random_question(*stress_.history.latest(), kRays, random_);
  if (question.rays.empty()) return;
  const v1::CastRaysRequest asked = request(question);
  v1::CastRaysResponse reply;
  const grpc::Status status = api_.cast(asked, &reply);
  const bool names_nodes = question.root != 0 || !question.excluded.empty();
  const bool exact = asked.consistency().has_exact_revision();
  if ((names_nodes && status.error_code() == grpc::StatusCode::NOT_FOUND) ||
      (exact && status.error_code() == grpc::StatusCode::OUT_OF_RANGE)) {
    ++stress_.gone;
    return;
  }
  ASSERT_TRUE(status.ok()) << status.error_message();
  if (exact) {
    ASSERT_EQ(reply.served().revision(), asked.consistency().exact_revision());
  } else {
    // No answer is older than a revision that the server has reported to this client.
    ASSERT_GE(reply.served().revision(), known_.revision());
    record_revision(reply.served());
  }
  const auto plain = stress_.history.at(reply.served().revision());
  ASSERT_NE(plain, nullptr) << "revision " << reply.served().revision() << " is not kept";
  if (judged) judge(*plain, question, asked.kind(), reply);
  ++stress_.casts;
}

void CastingClient::judge(const PlainScene& plain, const RandomQuestion& question,
                          v1::QueryKind kind, const v1::CastRaysResponse& reply) {
  const BruteForce oracle(plain.placed());
  const Filter filter{question.culling, plain.hidden(question.root, question.excluded)};
  const auto states = column_values<std::uint8_t>(reply, v1::HIT_FIELD_HIT);
  ASSERT_EQ(states.size(), question.rays.size());
  const auto counts = column_values<std::uint32_t>(reply, v1::HIT_FIELD_COUNT);
  const auto offsets = column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET);
  const std::vector<accel::geometry::Hit> rows = rows_of(reply);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Reference all = oracle.trace_all(question.rays[i], filter);
    const auto state = static_cast<accel::geometry::HitState>(states[i] == 3 ? 1 : states[i]);
    Agreement agreement = Agreement::kMismatch;
    if (kind == v1::QUERY_KIND_CLOSEST) {
      accel::geometry::Hit hit = rows[i];
      hit.state = state;
      agreement = compare(hit, nearest_part(all));
    } else if (kind == v1::QUERY_KIND_ANY) {
      accel::geometry::Hit hit;
      hit.state = state;
      agreement = compare_any(hit, all);
    } else if (kind == v1::QUERY_KIND_COUNT) {
      agreement = compare_count({.count = counts[i], .state = state}, all);
    } else {
      const RayTally tally{
          .count = offsets[i + 1] - offsets[i], .state = state, .cut_off = states[i] == 3};
      agreement = compare_list(std::span(rows).subspan(offsets[i], tally.count), tally, all);
    }
    ASSERT_NE(agreement, Agreement::kMismatch)
        << v1::QueryKind_Name(kind) << " of ray " << i << " at revision " << plain.revision();
    stress_.hits += states[i] != 0;
  }
}

}  // namespace sightline::tests
