// sightline backup and restore: exit codes, JSON, and scenes that come back.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "client/cli/terminal.h"
#include "tests/client/support/run_program.h"
#include "tests/server/store/postgres/postgres_server.h"

namespace sightline::client::cli::verbs {
namespace {

using nlohmann::json;
using tests::run_program;

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";

/// A server with a data directory.
class Backup : public testing::Test {
 protected:
  Backup() { serve("data"); }
  ~Backup() override { ::unsetenv("SIGHTLINE_ENDPOINT"); }

  void serve(const std::string& directory) { serve_at(dir_.path(directory)); }
  void serve_at(const std::string& location) {
    server_.reset();
    server_ = tests::start_server(location);
    ASSERT_NE(server_, nullptr);
    const std::string endpoint = "127.0.0.1:" + std::to_string(server_->port());
    ::setenv("SIGHTLINE_ENDPOINT", endpoint.c_str(), 1);
  }
  /// A scene of one mesh, and revisions that add nodes.
  void make_scene(const std::string& name, int revisions) {
    const std::string file = dir_.write("square.obj", kSquare);
    ASSERT_EQ(run_program({"scene", "import", name, file}).exit, 0);
    while (revision(name) < revisions) {
      const json put{
          {"put_node", {{"node", -1}, {"name", "another"}, {"labels", {{"class", name}}}}}};
      const std::string ops = dir_.write("ops.ndjson", put.dump() + "\n");
      const auto updated = run_program({"update", name, "--file", ops});
      ASSERT_EQ(updated.exit, 0) << updated.err;
    }
  }
  static json show(const std::string& name) {
    const auto shown = run_program({"scene", "show", name, "--json"});
    return shown.exit == 0 ? json::parse(shown.out) : json{};
  }
  static json nodes(const std::string& name) {
    return json::parse(run_program({"scene", "nodes", name, "--json"}).out)["nodes"];
  }
  static int revision(const std::string& name) { return show(name)["revision"]; }

  tests::TempDir dir_;
  std::unique_ptr<server::Server> server_;
};

TEST_F(Backup, ScenesOfALostDirectoryComeBack) {
  make_scene("a", 4);
  make_scene("b", 3);
  const json before = show("a");
  const json nodes_before = nodes("a");
  EXPECT_EQ(nodes_before.back()["labels"], (json{{"class", "a"}}));
  const auto backed_up = run_program({"backup", dir_.path("backup"), "--json"});
  ASSERT_EQ(backed_up.exit, 0) << backed_up.err;
  const json rows = json::parse(backed_up.out)["scenes"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["scene"], "projects/default/scenes/a");
  EXPECT_EQ(rows[0]["revision"], 4);
  EXPECT_EQ(rows[0]["base"], 1);  // an import writes all nodes down

  serve("empty");
  const auto restored = run_program({"restore", dir_.path("backup"), "--json"});
  ASSERT_EQ(restored.exit, 0) << restored.err;
  EXPECT_EQ(json::parse(restored.out)["scenes"].size(), 2u);
  EXPECT_EQ(show("a"), before);
  EXPECT_EQ(nodes("a"), nodes_before);
  EXPECT_EQ(revision("b"), 3);
}

TEST_F(Backup, MovesScenesToPostgreSqlAndBack) {
  if (!tests::PostgresServer::installed()) GTEST_SKIP() << "PostgreSQL is not installed";
  tests::PostgresServer& postgres = tests::PostgresServer::shared();
  const std::string uri = postgres.uri(postgres.make_database());
  make_scene("a", 4);
  const json before = show("a");
  ASSERT_EQ(run_program({"backup", dir_.path("backup")}).exit, 0);

  serve_at(uri);
  const auto moved = run_program({"restore", dir_.path("backup")});
  ASSERT_EQ(moved.exit, 0) << moved.err;
  EXPECT_EQ(show("a"), before);
  make_scene("b", 3);
  serve_at(uri);
  EXPECT_EQ(show("a"), before) << "after a restart";
  EXPECT_EQ(revision("b"), 3);
  ASSERT_EQ(run_program({"backup", dir_.path("back")}).exit, 0);

  serve("empty");
  ASSERT_EQ(run_program({"restore", dir_.path("back")}).exit, 0);
  EXPECT_EQ(show("a"), before);
  EXPECT_EQ(revision("b"), 3);
}

TEST_F(Backup, AnEarlierRevisionComesBack) {
  make_scene("a", 5);
  make_scene("b", 2);
  ASSERT_EQ(run_program({"backup", dir_.path("backup")}).exit, 0);
  const auto restored =
      run_program({"restore", dir_.path("backup"), "--scene", "a", "--revision", "3"});
  ASSERT_EQ(restored.exit, 0) << restored.err;
  EXPECT_EQ(restored.out, "projects/default/scenes/a restored at revision 3\n");
  EXPECT_EQ(revision("a"), 3);
  EXPECT_EQ(revision("b"), 2);
  EXPECT_NE(run_program({"restore", dir_.path("backup"), "--revision", "9"}).exit, 0);
  EXPECT_EQ(revision("a"), 3);
}

TEST_F(Backup, SinceAnEarlierOneSharesItsMeshes) {
  make_scene("a", 2);
  ASSERT_EQ(run_program({"backup", dir_.path("monday")}).exit, 0);
  const std::string other = dir_.write("other.obj", "v 0 0 0\nv 5 0 0\nv 5 5 0\nf 1 2 3\n");
  ASSERT_EQ(run_program({"scene", "import", "b", other}).exit, 0);
  const auto tuesday =
      run_program({"backup", dir_.path("tuesday"), "--since", dir_.path("monday"), "--json"});
  ASSERT_EQ(tuesday.exit, 0) << tuesday.err;
  EXPECT_EQ(json::parse(tuesday.out)["scenes"].size(), 2u);
  std::multiset<std::uintmax_t> links;
  for (const auto& mesh : std::filesystem::directory_iterator(dir_.path("tuesday") + "/meshes"))
    links.insert(mesh.hard_link_count());
  EXPECT_EQ(links, (std::multiset<std::uintmax_t>{1, 2}));
  const json a = show("a"), b = show("b");

  std::filesystem::remove_all(dir_.path("monday"));
  serve("empty");
  const auto restored = run_program({"restore", dir_.path("tuesday")});
  ASSERT_EQ(restored.exit, 0) << restored.err;
  EXPECT_EQ(show("a"), a);
  EXPECT_EQ(show("b"), b);
  const auto none = run_program({"backup", dir_.path("x"), "--since", dir_.path("monday")});
  EXPECT_EQ(none.exit, kFailed);
  EXPECT_NE(none.err.find(dir_.path("monday")), std::string::npos) << none.err;
}

TEST_F(Backup, ErrorsAndTheirExitCodes) {
  EXPECT_EQ(run_program({"backup"}).exit, kUsage);
  EXPECT_EQ(run_program({"restore", "x", "--revision", "-1"}).exit, kUsage);
  EXPECT_EQ(run_program({"restore", dir_.path("nothing")}).exit, kFailed);
  EXPECT_EQ(run_program({"backup", dir_.path("backup"), "--scene", "none"}).exit, kNotFound);
  EXPECT_EQ(run_program({"restore", dir_.path("backup")}).exit, kFailed) << "it is not whole";
  dir_.write("full", "");
  EXPECT_EQ(run_program({"backup", dir_.path("")}).exit, kConflict) << "it is not empty";

  make_scene("a", 2);
  ASSERT_EQ(run_program({"backup", dir_.path("good")}).exit, 0);
  EXPECT_EQ(run_program({"restore", dir_.path("good"), "--scene", "b"}).exit, kNotFound);
  const std::filesystem::path parts = dir_.path("good") + "/scenes.parts";
  std::filesystem::resize_file(parts, std::filesystem::file_size(parts) - 1);
  const auto corrupt = run_program({"restore", dir_.path("good")});
  EXPECT_EQ(corrupt.exit, kFailed);
  EXPECT_NE(corrupt.err.find("is not what was written"), std::string::npos) << corrupt.err;
}

using BackupOfMemory = tests::LiveProgram;

TEST_F(BackupOfMemory, IsRefused) {
  const auto refused = run_program({"backup", dir_.path("backup")});
  EXPECT_EQ(refused.exit, kConflict);
  EXPECT_NE(refused.err.find("--data-dir"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace sightline::client::cli::verbs
