// What a writer writes through: a connection of an engine, and what that engine needs around
// transactions.
#pragma once

#include <cstdint>
#include <span>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Threads: the writer's.
class Engine {
 public:
  virtual ~Engine() = default;

  virtual Database& database() = 0;

  /// Whether there is space for this many bytes. Errors: kResourceExhausted.
  virtual Status admit(std::uint64_t bytes) = 0;

  /// Begins a transaction that changes these scenes, ascending. If the last one has failed, first
  /// makes sure that nothing of it is left. Errors: as Database.
  virtual Status begin(std::span<const SceneId> scenes) = 0;

  /// Ends the transaction. Success if it is kept; an error if it is not. Errors: as Database.
  virtual Status commit() = 0;

  /// Whether a savepoint before each piece of work costs too much: then there are none, and a
  /// transaction in which work has failed is run again with them.
  virtual bool avoids_savepoints() const = 0;

  /// Whether a transaction that failed with this error is worth a second try.
  virtual bool can_repeat(const Error& error) const = 0;

  /// The transaction has failed with this error, and is rolled back where that is possible.
  virtual void failed(const Error& error) = 0;

  /// Deletes some rows that nothing needs any more, within a transaction. `all`: space is short.
  /// Returns whether there is more to delete.
  virtual Result<bool> purge(bool all) = 0;

  /// Called after each transaction, when its callers know how it ended. `tight`: there was no space
  /// for it.
  virtual void transaction_ended(bool tight) = 0;
};

}  // namespace sightline::server::store
