// The engines of the store, so that one test runs on each.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/store/store.h"
#include "tests/server/store/store_steps.h"

namespace sightline::tests {

/// An empty store of one engine, which can be opened again and again.
class StoreHome {
 public:
  virtual ~StoreHome() = default;
  /// Fails the test if it cannot be opened.
  virtual std::unique_ptr<server::store::Store> open(const server::store::StoreLimits& limits) = 0;
};

/// Whether the engine can be run here.
bool has_engine(const std::string& engine);
std::unique_ptr<StoreHome> make_home(const std::string& engine);

/// A test of all engines: TEST_P, with RUN_ON_ALL_ENGINES once for each class of tests. It is
/// skipped for an engine that is not installed.
class StoreTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!has_engine(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
    home_ = make_home(GetParam());
  }

  std::unique_ptr<server::store::Store> open(
      const server::store::StoreLimits& limits = small_disk()) {
    return home_->open(limits);
  }

 private:
  std::unique_ptr<StoreHome> home_;
};

}  // namespace sightline::tests

#define RUN_ON_ALL_ENGINES(tests)                                              \
  INSTANTIATE_TEST_SUITE_P(On, tests, testing::Values("Sqlite", "PostgreSql"), \
                           [](const auto& instance) { return std::string(instance.param); })
