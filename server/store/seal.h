// What ties a row to its place: a sum over all that it says and over whose it is.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/store/store.h"

namespace sightline::server::store {

/// The scene that a row belongs to. The number of a scene may be damaged in an index, and may be
/// used again after an old copy of a database was put back; together with `uid` it is one scene for
/// ever.
struct SceneKey {
  SceneId id = 0;
  std::uint64_t uid = 0;  ///< Random; never changes.
};

enum class RowKind : std::uint8_t {
  kScene = 1,
  kBatch = 2,
  kAnswer = 3,
  kProducer = 4,
  kPut = 5,
  kSnapshot = 6,
  kChunk = 7,
  kMark = 8,
};

/// Adds the columns of a row up, in an order that is part of the format.
class Seal {
 public:
  explicit Seal(RowKind kind) : text_(1, static_cast<char>(kind)) {}
  Seal(RowKind kind, const SceneKey& scene) : Seal(kind) { add(scene.id).add(scene.uid); }

  Seal& add(std::uint64_t number);
  Seal& add(std::int64_t number) { return add(static_cast<std::uint64_t>(number)); }
  Seal& add(double number);
  Seal& add(std::string_view text);

  /// The first eight bytes of the SHA-256 of what was added; never 0, which is a row without one.
  std::int64_t value() const;

 private:
  std::string text_;
};

/// Seals and digests are added up modulo 2^64: so the order does not matter, one can be taken away
/// again, and a row that is missing or there twice shows.
inline std::uint64_t to_sum(std::int64_t seal) { return static_cast<std::uint64_t>(seal); }

}  // namespace sightline::server::store
