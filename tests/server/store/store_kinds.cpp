// The engines of the store, so that one test runs on each.
#include "tests/server/store/store_kinds.h"

#include <utility>

#include "server/store/postgres/postgres_store.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/postgres/postgres_server.h"

namespace sightline::tests {
namespace {

namespace store = server::store;

template <class Engine>
std::unique_ptr<store::Store> expect_open(Result<std::unique_ptr<Engine>> opened) {
  EXPECT_TRUE(opened.ok()) << opened.error().message;
  return opened ? std::move(*opened) : nullptr;
}

class SqliteHome final : public StoreHome {
 public:
  std::unique_ptr<store::Store> open(const store::StoreLimits& limits) override {
    return expect_open(store::SqliteStore::open(directory_.path(), limits));
  }

 private:
  const Directory directory_;
};

class PostgresHome final : public StoreHome {
 public:
  std::unique_ptr<store::Store> open(const store::StoreLimits& limits) override {
    return expect_open(store::postgres::PostgresStore::open(PostgresServer::shared().uri(database_),
                                                            cache_.path(), limits));
  }

 private:
  const Directory cache_;
  const std::string database_ = PostgresServer::shared().make_database();
};

}  // namespace

bool has_engine(const std::string& engine) {
  return engine != "PostgreSql" || PostgresServer::installed();
}

std::unique_ptr<StoreHome> make_home(const std::string& engine) {
  if (engine == "PostgreSql") return std::make_unique<PostgresHome>();
  return std::make_unique<SqliteHome>();
}

}  // namespace sightline::tests
