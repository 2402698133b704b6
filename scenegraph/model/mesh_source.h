// Where the arrays of a mesh are that are not in memory.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <utility>

#include "proto/result.h"

namespace sightline::scenegraph::model {

class Mesh;

/// Whether trees and other data that can be rebuilt are dropped if memory for a mesh is short.
enum class Reclaim : std::uint8_t {
  kAllowed,    ///< The caller holds no lock.
  kForbidden,  ///< charge() returns an error instead.
};

/// Reads the arrays of a mesh. Threads: any, for every member.
class MeshSource {
 public:
  virtual ~MeshSource() = default;

  /// Charges the bytes of the arrays. The charge ends when its last pointer goes. Errors:
  /// kResourceExhausted.
  virtual Result<std::shared_ptr<const void>> charge(std::uint64_t bytes,
                                                     Reclaim reclaim) const = 0;
  /// Reads the mesh with its arrays. May wait for a disk or another machine. Errors: kDataLoss,
  /// kUnavailable, and what the source may return beside these.
  virtual Result<std::shared_ptr<const Mesh>> read() const = 0;
};

/// Thrown on the way of a ray, and in builds: the arrays of a mesh cannot be read.
class MeshUnreadable : public std::exception {
 public:
  explicit MeshUnreadable(Error error) : error_(std::move(error)) {}
  const Error& error() const { return error_; }
  const char* what() const noexcept override { return error_.message.c_str(); }

 private:
  Error error_;
};

}  // namespace sightline::scenegraph::model
