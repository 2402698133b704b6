// How tables are read by threads that share connections.
#pragma once

#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include "proto/result.h"
#include "server/store/database.h"

namespace sightline::server::store {

/// Threads: any.
class Reader {
 public:
  virtual ~Reader() = default;

  /// Calls read(Database&), which returns a Result, with a connection that no other thread uses
  /// meanwhile; again, if the connection was lost. It should be short. Errors: those of read().
  template <class Read>
  auto operator()(const Read& read) -> std::invoke_result_t<Read, Database&> {
    std::optional<std::invoke_result_t<Read, Database&>> result;
    const Status done = lend([&](Database& database) -> Status {
      result.emplace(read(database));
      return *result ? Status() : Status(result->error());
    });
    if (!done) return done.error();
    return std::move(*result);
  }

 protected:
  using Use = std::function<Status(Database&)>;

  virtual Status lend(const Use& use) = 0;
};

}  // namespace sightline::server::store
