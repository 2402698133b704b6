// The pages of the admin port, and readiness.
#include "server/admin/pages.h"

#include <gtest/gtest.h>

namespace sightline::server::admin {
namespace {

TEST(Pages, ReadyUntilACheckFailsOrTheServerDrains) {
  Readiness readiness;
  bool disk = true, store = true;
  const auto check = [](const bool& good, const char* why) {
    return [&good, why]() -> Status {
      if (good) return {};
      return Error{Code::kUnavailable, why, {}};
    };
  };
  readiness.add("disk", check(disk, "it is full"));
  readiness.add("store", check(store, "it does not answer"));
  const auto handler = pages(readiness, [] { return std::string(); });
  EXPECT_EQ(handler("/readyz").code, 200);
  EXPECT_EQ(handler("/readyz").body, "ready\n");
  disk = false;
  EXPECT_EQ(handler("/readyz").code, 503);
  EXPECT_EQ(handler("/readyz").body, "disk: it is full\n");
  store = false;
  readiness.drain();
  EXPECT_EQ(handler("/readyz").body, "draining\ndisk: it is full\nstore: it does not answer\n");
  disk = store = true;
  EXPECT_EQ(handler("/readyz").code, 503);
}

TEST(Pages, MetricsHaveTheTypeThatPrometheusExpects) {
  const Readiness readiness;
  const auto handler = pages(readiness, [] { return std::string("a 1\n"); });
  EXPECT_EQ(handler("/metrics").body, "a 1\n");
  EXPECT_TRUE(handler("/metrics").type.starts_with("text/plain; version=0.0.4"));
  EXPECT_EQ(handler("/nowhere").code, 404);
}

TEST(Pages, ServesTheLivePage) {
  const Readiness readiness;
  const auto handler = pages(readiness, [] { return std::string(); });
  const HttpReply first = handler("/");
  EXPECT_EQ(first.code, 200);
  EXPECT_TRUE(first.type.starts_with("text/html"));
  for (const PageFile& file : page_files()) {
    const HttpReply reply = handler(file.path);
    EXPECT_EQ(reply.code, 200) << file.path;
    EXPECT_EQ(reply.body, file.content) << file.path;
    EXPECT_EQ(file.content.find("https://"), std::string_view::npos) << file.path;
  }
}

}  // namespace
}  // namespace sightline::server::admin
