// A segment of a server, as its client sees it.
#pragma once

#include <grpcpp/client_context.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "server/net/descriptor.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::tests {

/// Connects to a Unix socket of this name in the abstract namespace.
server::net::Descriptor connect_abstract(const std::string& name);

/// What a client has of a segment: its descriptor, and the connection by which it came.
struct TakenSegment {
  server::net::Descriptor connection, descriptor;
  explicit operator bool() const { return static_cast<bool>(descriptor); }
};
/// Sends a key to a socket and takes what comes; nothing if the socket is closed.
TakenSegment take_segment(const std::string& socket, const std::string& key);
/// The pages that a descriptor's file has.
std::uint64_t pages_of(int descriptor);

/// An open OpenSegment call.
class SegmentCall {
 public:
  SegmentCall(v1::RayQueryService::Stub& rays, std::uint64_t bytes);
  /// Calls end().
  ~SegmentCall();
  SegmentCall(const SegmentCall&) = delete;
  SegmentCall& operator=(const SegmentCall&) = delete;

  /// Whether the segment is there; else end() says why.
  bool is_open() const { return open_; }
  const v1::OpenSegmentResponse& response() const { return response_; }
  /// Waits until the server ends the call.
  grpc::Status wait();
  /// Cancels the call. Returns how it ended.
  grpc::Status end();

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::OpenSegmentResponse>> reader_;
  v1::OpenSegmentResponse response_;
  bool open_ = false, ended_ = false;
  grpc::Status status_;
};

/// A segment that is mapped; its call is open until close() or the end of this object. Fails the
/// test where there is none.
class SharedSegment {
 public:
  SharedSegment(v1::RayQueryService::Stub& rays, std::uint64_t bytes);
  ~SharedSegment();
  SharedSegment(const SharedSegment&) = delete;
  SharedSegment& operator=(const SharedSegment&) = delete;

  const std::string& name() const { return call_.response().segment(); }
  std::span<std::byte> bytes() const { return {data_, size_}; }
  int descriptor() const { return taken_.descriptor.number(); }
  /// Copies a column behind those before it, and returns where it begins.
  std::uint64_t put(const std::string& column);
  /// Leaves room for a column behind those before it, and returns where it begins.
  std::uint64_t reserve(std::size_t bytes);
  /// Forgets all columns.
  void clear() { used_ = 0; }
  std::string column(std::uint64_t begin, std::size_t bytes) const;

  /// Ends the call; what is mapped stays mapped.
  grpc::Status close() { return call_.end(); }
  /// Closes the connection by which the segment came; what is mapped stays mapped.
  void disconnect() { taken_.connection = server::net::Descriptor(); }

 private:
  SegmentCall call_;
  TakenSegment taken_;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  std::uint64_t used_ = 0;
};

}  // namespace sightline::tests
