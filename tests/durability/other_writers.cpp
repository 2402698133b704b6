// Writers beside producers: requests with ids, and uploads.
#include "tests/durability/other_writers.h"

#include <grpcpp/client_context.h>

#include <algorithm>

#include "tests/server/blobs/blob_of.h"

namespace sightline::tests::durability {
namespace {

/// Of an uploaded mesh.
constexpr std::uint32_t kTriangles = 2000;
/// As many digests as one request may have.
constexpr std::size_t kAskedAtOnce = 8192;

bool same_answer(const v1::ApplyUpdatesResponse& a, const v1::ApplyUpdatesResponse& b) {
  return a.revision().token() == b.revision().token() && std::ranges::equal(a.nodes(), b.nodes());
}

}  // namespace

void Requester::run(Api& api) {
  v1::ApplyUpdatesResponse reply;
  if (!nodes_.empty()) {
    if (!send(api, nodes_.size(), reply).ok()) return;
    if (!reply.replayed() || !same_answer(reply, answer_))
      findings_.add(findings_.repeats, fmt::format("request {} was answered anew", nodes_.size()));
  }
  for (;;) {
    const grpc::Status sent = send(api, nodes_.size() + 1, reply);
    if (!sent.ok()) {
      if (sent.error_code() != grpc::StatusCode::UNAVAILABLE)
        findings_.add(findings_.other, "a request: " + sent.error_message());
      return;
    }
    nodes_.push_back(reply.nodes(0));
    answer_ = reply;
  }
}

grpc::Status Requester::send(Api& api, std::uint64_t number, v1::ApplyUpdatesResponse& reply) {
  v1::ApplyUpdatesRequest request;
  request.set_scene(kScene);
  request.set_request_id(fmt::format("request-{}", number));
  *request.add_updates() = put_node(-1);
  request.mutable_updates(0)->mutable_put_node()->set_name(request.request_id());
  if (number > 1) {
    request.add_updates()->mutable_delete_node()->set_node(
        static_cast<std::int64_t>(nodes_[number - 2]));
  }
  if (number % 2 == 0) return cast(api, request, reply);
  grpc::ClientContext context;
  return api.scenes->ApplyUpdates(&context, request, &reply);
}

grpc::Status Requester::cast(Api& api, const v1::ApplyUpdatesRequest& updates,
                             v1::ApplyUpdatesResponse& reply) {
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(1));
  *request.mutable_apply() = updates;
  v1::CastRaysResponse answer;
  grpc::Status status = api.cast(request, &answer);
  reply = answer.applied();
  const std::uint64_t served = answer.served().revision(), made = reply.revision().revision();
  if (status.ok() && (served < made || (served > made && !reply.replayed())))
    findings_.add(findings_.wrong,
                  fmt::format("updates that made revision {} were seen at {}", made, served));
  return status;
}

void Uploader::run(Api& api) {
  for (;; ++next_) {
    const std::string blob = blob_of(random_soup(kTriangles, 0.1, next_));
    const std::string digest = digest_of(blob).text();
    if (!api.upload(blob, digest, nullptr, std::size_t{16} << 10).ok()) return;
    digests_.push_back(digest);
  }
}

void Uploader::check(Api& api) {
  for (std::size_t first = 0; first < digests_.size(); first += kAskedAtOnce) {
    v1::FindMissingBlobsRequest request;
    v1::FindMissingBlobsResponse reply;
    for (std::size_t i = first; i < std::min(digests_.size(), first + kAskedAtOnce); ++i)
      request.add_digests(digests_[i]);
    grpc::ClientContext context;
    const grpc::Status asked = api.blobs->FindMissingBlobs(&context, request, &reply);
    if (!asked.ok()) findings_.add(findings_.other, asked.error_message());
    for (const std::string& digest : reply.digests())
      findings_.add(findings_.missing, "an upload is gone: " + digest);
  }
}

}  // namespace sightline::tests::durability
