// Tests of the store in PostgreSQL: a database of their own, and processes that share it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "server/store/postgres/postgres_store.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/postgres/postgres_server.h"
#include "tests/server/store/store_steps.h"

namespace sightline::tests {

/// A process: a store with a cache of its own.
struct Process {
  using Pointer = std::unique_ptr<server::store::postgres::PostgresStore>;

  /// Fails the test if the store cannot be opened.
  Pointer open(const std::string& uri,
               const server::store::StoreLimits& limits = small_disk()) const {
    auto opened = server::store::postgres::PostgresStore::open(uri, cache.path(), limits);
    if (opened) return std::move(*opened);
    ADD_FAILURE() << opened.error().message;
    return nullptr;
  }

  Directory cache;
};

/// Skipped where PostgreSQL is not installed.
class PostgresTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!PostgresServer::installed()) GTEST_SKIP() << "PostgreSQL is not installed";
    database_ = server().make_database();
  }

  static PostgresServer& server() { return PostgresServer::shared(); }
  std::string uri() const { return server().uri(database_); }
  /// Runs a statement in the database.
  std::string run(const std::string& statement) const { return server().run(database_, statement); }
  Process::Pointer open(const server::store::StoreLimits& limits = small_disk()) const {
    return one_.open(uri(), limits);
  }

  std::string database_;
  Process one_;
  Process two_;
};

}  // namespace sightline::tests
