// Writers beside producers: requests with ids, and uploads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/durability/producer.h"

namespace sightline::tests::durability {

/// Puts one node a request, named after the request, and deletes that of the request before. Every
/// other request comes with a ray, which sees what it has made.
class Requester {
 public:
  explicit Requester(Findings& findings) : findings_(findings) {}

  /// Sends the last acknowledged request again, then the one without an answer, then further ones
  /// until a call breaks.
  void run(Api& api);
  std::uint64_t acknowledged() const { return nodes_.size(); }
  std::uint64_t revision() const { return answer_.revision().revision(); }

 private:
  grpc::Status send(Api& api, std::uint64_t number, v1::ApplyUpdatesResponse& reply);
  grpc::Status cast(Api& api, const v1::ApplyUpdatesRequest& updates,
                    v1::ApplyUpdatesResponse& reply);

  Findings& findings_;
  std::vector<std::uint64_t> nodes_;  // of acknowledged requests
  v1::ApplyUpdatesResponse answer_;   // to the last acknowledged request
};

class Uploader {
 public:
  explicit Uploader(Findings& findings) : findings_(findings) {}

  /// Uploads meshes until a call breaks.
  void run(Api& api);
  /// Asks for all meshes whose upload was acknowledged.
  void check(Api& api);
  std::size_t acknowledged() const { return digests_.size(); }

 private:
  Findings& findings_;
  std::uint64_t next_ = 0;
  std::vector<std::string> digests_;  // acknowledged
};

}  // namespace sightline::tests::durability
