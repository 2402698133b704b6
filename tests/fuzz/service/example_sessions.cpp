// Sessions that use every method as it is meant.
#include <openssl/sha.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "sightline/v1/blob.pb.h"
#include "sightline/v1/query.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/fuzz/service/session.h"

namespace sightline::tests {
namespace {

const std::string kScene = "projects/p/scenes/s";

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

FuzzCall call(const std::string& method, std::vector<std::string> messages) {
  for (std::size_t i = 0; i < methods().size(); ++i) {
    if (methods()[i]->name() == method)
      return {.method = static_cast<std::uint8_t>(i), .messages = std::move(messages)};
  }
  return {};
}

template <class Request, class Fill>
std::string message(Fill fill) {
  Request request;
  fill(request);
  return request.SerializeAsString();
}

/// Two triangles over the unit square at z = 0.
std::string square() {
  return "SLM1" + bytes_of<std::uint32_t>({0}) + bytes_of<std::uint64_t>({4, 2}) +
         bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) +
         bytes_of<std::uint32_t>({0, 1, 2, 0, 2, 3});
}

std::string digest_of(const std::string& blob) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> sum{};
  SHA256(reinterpret_cast<const unsigned char*>(blob.data()), blob.size(), sum.data());
  std::string text = "sha256:";
  for (const unsigned char byte : sum) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text + "/" + std::to_string(blob.size());
}

v1::Update put(std::int64_t node, const std::string& digest) {
  v1::Update update;
  update.mutable_put_node()->set_node(node);
  update.mutable_put_node()->set_name("node");
  update.mutable_put_node()->set_mesh_digest(digest);
  return update;
}

FuzzCall create() {
  return call("CreateScene", {message<v1::CreateSceneRequest>([](auto& request) {
                request.mutable_scene()->set_name(kScene);
                request.mutable_scene()->set_up_axis(v1::UP_AXIS_Z);
              })});
}

FuzzCall put_scene() {
  return call("PutScene", {message<v1::PutSceneRequest>([](auto& request) {
                             request.mutable_scene()->set_name(kScene);
                             request.set_replace(true);
                             *request.add_nodes() = put(-1, digest_of(square())).put_node();
                           }),
                           message<v1::PutSceneRequest>([](auto& request) {
                             *request.add_nodes() = put(-2, "").put_node();
                             request.set_finish(true);
                           })});
}

FuzzCall upload() {
  const std::string blob = square();
  const auto part = [&](std::size_t first, std::size_t count, bool finish) {
    return message<v1::UploadBlobRequest>([&](auto& request) {
      if (first == 0) request.set_digest(digest_of(blob));
      request.set_offset(first);
      request.set_data(blob.substr(first, count));
      request.set_finish(finish);
    });
  };
  return call("UploadBlob", {part(0, 40, false), part(40, blob.size(), true)});
}

FuzzCall apply() {
  return call("ApplyUpdates", {message<v1::ApplyUpdatesRequest>([](auto& request) {
                request.set_scene(kScene);
                request.set_request_id("once");
                *request.add_updates() = put(-1, digest_of(square()));
                *request.add_updates() = put(-2, digest_of(square()));
                auto& moved = *request.add_updates()->mutable_set_transforms();
                moved.add_nodes(-2);
                moved.set_matrices(bytes_of<double>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2}));
                auto& patch = *request.add_updates()->mutable_patch_vertices();
                patch.add_nodes(-1);
                patch.set_first(1);
                patch.set_positions(bytes_of<float>({1, 0, 0.5F}));
              })});
}

v1::CastRaysRequest query(v1::QueryKind kind) {
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  request.set_kind(kind);
  request.add_exclude(2);
  request.mutable_rays()->set_float64(true);
  request.mutable_rays()->set_origins(bytes_of<double>({0.5, 0.25, 5, 3, 3, 3}));
  request.mutable_rays()->set_directions(bytes_of<double>({0, 0, -1, 0, 0, -1}));
  return request;
}

v1::QueryPointsRequest points(v1::QueryKind kind) {
  v1::QueryPointsRequest request;
  request.set_scene(kScene);
  request.set_kind(kind);
  request.add_exclude(2);
  request.mutable_points()->set_float64(true);
  request.mutable_points()->set_positions(bytes_of<double>({0.5, 0.25, 5, 3, 3, 3}));
  request.mutable_points()->set_max_distance(bytes_of<double>({9, 2}));
  return request;
}

v1::QueryPointsRequest grid() {
  v1::QueryPointsRequest request;
  request.set_scene(kScene);
  v1::PointGrid& of = *request.mutable_grid();
  for (const double x : {0.0, 0.5, 1.0}) {
    of.add_origin(x);
    of.add_across(1 - x);
    of.add_down(x);
  }
  of.set_columns(3);
  of.set_rows(2);
  return request;
}

v1::QueryPointsRequest sides(v1::SideRule rule, std::uint32_t rays) {
  v1::QueryPointsRequest request = points(v1::QUERY_KIND_CLOSEST);
  request.add_fields(v1::HIT_FIELD_SIGNED);
  request.add_fields(v1::HIT_FIELD_INSIDE);
  if (rule != v1::SIDE_RULE_NORMAL) request.add_fields(v1::HIT_FIELD_VOTES);
  request.set_side_rule(rule);
  request.set_side_rays(rays);
  return request;
}

std::vector<FuzzCall> queries_of_sides() {
  std::vector<FuzzCall> made;
  for (const auto& [rule, rays] :
       {std::pair(v1::SIDE_RULE_UNSPECIFIED, 0U), std::pair(v1::SIDE_RULE_PARITY, 63U),
        std::pair(v1::SIDE_RULE_WINDING, 7U), std::pair(v1::SIDE_RULE_NORMAL, 1U)})
    made.push_back(call("QueryPoints", {sides(rule, rays).SerializeAsString()}));
  v1::QueryPointsRequest occupancy = grid();
  occupancy.add_fields(v1::HIT_FIELD_INSIDE);
  made.push_back(call("QueryPoints", {occupancy.SerializeAsString()}));
  made.push_back(
      call("StreamQueryPoints", {message<v1::StreamQueryPointsRequest>([](auto& request) {
             *request.mutable_request() = sides(v1::SIDE_RULE_WINDING, 3);
           })}));
  return made;
}

std::vector<FuzzCall> queries_of_points() {
  std::vector<FuzzCall> made;
  for (const v1::QueryKind kind :
       {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ANY, v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ALL})
    made.push_back(call("QueryPoints", {points(kind).SerializeAsString()}));
  made.push_back(call("QueryPoints", {grid().SerializeAsString()}));
  made.push_back(
      call("StreamQueryPoints", {message<v1::StreamQueryPointsRequest>([](auto& request) {
             request.set_chunk(1);
             *request.mutable_request() = points(v1::QUERY_KIND_ALL);
           })}));
  return made;
}

std::vector<FuzzCall> casts() {
  std::vector<FuzzCall> made;
  for (const v1::QueryKind kind :
       {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ANY, v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ALL})
    made.push_back(call("CastRays", {query(kind).SerializeAsString()}));
  std::vector<std::string> stream;
  for (const std::uint64_t chunk : {1u, 2u}) {
    stream.push_back(message<v1::StreamCastRaysRequest>([&](auto& request) {
      request.set_chunk(chunk);
      *request.mutable_request() = query(v1::QUERY_KIND_ALL);
    }));
  }
  made.push_back(call("StreamCastRays", std::move(stream)));
  made.push_back(call("Prefetch", {message<v1::PrefetchRequest>([](auto& request) {
                        request.set_scene(kScene);
                        *request.mutable_rays() = query(v1::QUERY_KIND_ANY).rays();
                      })}));
  return made;
}

/// A request with its rays, or its points, and its answer in the segment, the answer at `offset`.
template <class Request>
std::string in_segment(Request request, bool has_rows, std::uint64_t offset) {
  constexpr std::uint64_t kColumnBytes = 8 * kSegmentRows;
  request.set_segment(kFuzzSegment);
  request.set_kind(v1::QUERY_KIND_CLOSEST);
  for (const v1::HitField field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_HIT}) {
    v1::SharedColumn& column = *request.add_answer();
    column.set_field(field);
    column.set_offset(offset);
    offset += kColumnBytes;
  }
  if (!has_rows) return request.SerializeAsString();
  auto& shared = *request.mutable_shared();
  shared.set_float64(true);
  shared.set_count(kSegmentRows);
  if constexpr (std::is_same_v<Request, v1::CastRaysRequest>) {
    shared.set_origins(0);
    shared.set_directions(3 * kColumnBytes);
  } else {
    shared.set_positions(0);
  }
  return request.SerializeAsString();
}

std::vector<FuzzCall> casts_in_a_segment() {
  constexpr std::uint64_t kAnswer = 48 * kSegmentRows, kOther = kAnswer + 24 * kSegmentRows;
  const auto rays = query(v1::QUERY_KIND_CLOSEST);
  const auto near = points(v1::QUERY_KIND_CLOSEST);
  std::vector<FuzzCall> made;
  made.push_back(call("CastRays", {in_segment(rays, true, kAnswer)}));
  made.push_back(call("CastRays", {in_segment(rays, false, kOther)}));
  made.push_back(call("QueryPoints", {in_segment(near, true, kAnswer)}));
  made.push_back(call("QueryPoints", {in_segment(grid(), false, kOther)}));
  std::vector<std::string> stream;
  for (const std::uint64_t offset : {kAnswer, kOther}) {
    stream.push_back(message<v1::StreamCastRaysRequest>([&](auto& request) {
      request.mutable_request()->ParseFromString(in_segment(rays, true, offset));
    }));
  }
  made.push_back(call("StreamCastRays", std::move(stream)));
  return made;
}

FuzzCall cast_with_updates() {
  v1::CastRaysRequest request = query(v1::QUERY_KIND_CLOSEST);
  request.mutable_apply()->set_request_id("with rays");
  *request.mutable_apply()->add_updates() = put(-1, digest_of(square()));
  return call("CastRays", {request.SerializeAsString()});
}

FuzzCall stream_updates() {
  const auto batch = [](std::uint64_t sequence, bool more) {
    return message<v1::StreamUpdatesRequest>([&](auto& request) {
      request.mutable_batch()->set_sequence(sequence);
      request.mutable_batch()->set_more(more);
      *request.mutable_batch()->add_updates() = put(-1, "");
    });
  };
  return call("StreamUpdates", {message<v1::StreamUpdatesRequest>([](auto& request) {
                                  request.mutable_open()->set_scene(kScene);
                                  request.mutable_open()->set_producer("one");
                                }),
                                batch(1, false), batch(2, true), batch(2, false)});
}

std::vector<FuzzCall> reads() {
  std::vector<FuzzCall> made;
  made.push_back(call(
      "GetScene", {message<v1::GetSceneRequest>([](auto& request) { request.set_name(kScene); })}));
  made.push_back(call("ListScenes", {message<v1::ListScenesRequest>([](auto& request) {
                        request.set_parent("projects/p");
                        request.set_page_size(1);
                      })}));
  made.push_back(call("BatchGetNodes", {message<v1::BatchGetNodesRequest>([](auto& request) {
                        request.set_scene(kScene);
                        request.add_ids(1);
                        request.add_ids(2);
                      })}));
  made.push_back(call("OpenSegment", {message<v1::OpenSegmentRequest>(
                                         [](auto& request) { request.set_bytes(4096); })}));
  made.push_back(call("WatchScene", {message<v1::WatchSceneRequest>([](auto& request) {
                        request.set_scene(kScene);
                        request.set_start_revision(0);
                      })}));
  made.push_back(call("GetSceneStats", {message<v1::GetSceneStatsRequest>(
                                           [](auto& request) { request.set_scene(kScene); })}));
  made.push_back(call("ListDeferredCells", {message<v1::ListDeferredCellsRequest>(
                                               [](auto& request) { request.set_scene(kScene); })}));
  made.push_back(call("CoolScene", {message<v1::CoolSceneRequest>(
                                       [](auto& request) { request.set_scene(kScene); })}));
  made.push_back(call("ReadMesh", {message<v1::ReadMeshRequest>([](auto& request) {
                        request.set_scene(kScene);
                        request.set_node(2);
                        request.set_offset(8);
                      })}));
  made.push_back(call("FindMissingBlobs", {message<v1::FindMissingBlobsRequest>([](auto& request) {
                        request.add_digests(digest_of(square()));
                      })}));
  made.push_back(call("GetUploadStatus", {message<v1::GetUploadStatusRequest>([](auto& request) {
                        request.set_digest(digest_of(square()));
                      })}));
  made.push_back(call("GetServerInfo", {""}));
  made.push_back(call("ReadLog", {""}));
  return made;
}

FuzzCall remove() {
  return call("DeleteScene",
              {message<v1::DeleteSceneRequest>([](auto& request) { request.set_name(kScene); })});
}

Session join(std::initializer_list<std::vector<FuzzCall>> parts) {
  Session session;
  for (const auto& part : parts) session.insert(session.end(), part.begin(), part.end());
  return session;
}

}  // namespace

std::vector<Session> example_sessions() {
  return {join({{create(), upload(), apply()}, casts(), casts_in_a_segment()}),
          join({{create(), upload(), apply()}, queries_of_points()}),
          join({{create(), upload(), apply()}, queries_of_sides()}),
          join({{create(), upload(), apply(), stream_updates()}, reads(), {put_scene(), remove()}}),
          join({{create(), stream_updates(), apply(), remove(), stream_updates()}}),
          join({{create(), upload(), cast_with_updates(), cast_with_updates()}})};
}

}  // namespace sightline::tests
