// The server program: its exit codes, its files, and how it ends.
#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "server/logging.h"
#include "tests/server/support/child_server.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/tcp.h"
#include "tests/server/support/token_file.h"
#include "tests/support/certificates.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

namespace fs = std::filesystem;

class Sightlined : public testing::Test {
 protected:
  Sightlined() {
    std::string pattern = (fs::temp_directory_path() / "sightlined-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
  }
  ~Sightlined() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(Sightlined, WritesItsPortServesAndEndsOnSigterm) {
  for (const int number : {SIGTERM, SIGINT}) {
    const fs::path port_file = root_ / "port";
    const fs::path data_dir = root_ / "data" / fmt::format("of signal {}", number);
    ChildServer child({"--listen", "127.0.0.1:0", "--port-file", port_file, "--data-dir", data_dir,
                       "--threads", "1"});
    const int port = child.port();
    ASSERT_GT(port, 0) << child.output();
    int written = 0;
    std::ifstream(port_file) >> written;
    EXPECT_EQ(written, port);
    EXPECT_TRUE(fs::is_directory(data_dir));
    Api(connect(port)).make_scene(kScene, cube());
    child.signal(number);
    EXPECT_EQ(child.wait(), 0) << child.output();
    EXPECT_EQ(child.output().find("not kept across restarts"), std::string::npos);
  }
}

v1::Scene only_scene(Api& api) {
  grpc::ClientContext context;
  v1::ListScenesRequest request;
  request.set_parent("projects/p");
  v1::ListScenesResponse reply;
  EXPECT_TRUE(api.scenes->ListScenes(&context, request, &reply).ok());
  EXPECT_EQ(reply.scenes_size(), 1);
  return reply.scenes_size() == 1 ? reply.scenes(0) : v1::Scene();
}

TEST_F(Sightlined, KeepsScenesInItsDataDirectory) {
  const std::vector<std::string> flags{"--listen",     "127.0.0.1:0", "--data-dir",
                                       root_ / "data", "--threads",   "1"};
  std::string token, digest;
  {
    ChildServer child(flags);
    Api api(connect(child.port()));
    digest = api.add_mesh(cube());
    ASSERT_TRUE(api.create(kScene).ok());
    v1::ApplyUpdatesResponse reply;
    ASSERT_TRUE(api.apply(kScene, {put_node(-1, digest)}, &reply).ok());
    EXPECT_EQ(reply.durability(), v1::DURABILITY_COMMITTED);
    ASSERT_TRUE(api.apply(kScene, {put_node(-1, digest)}, &reply).ok());
    token = reply.revision().token();
    child.signal(SIGKILL);
    child.wait();
  }
  ChildServer child(flags);
  Api api(connect(child.port()));
  const v1::Scene unread = only_scene(api);
  EXPECT_TRUE(unread.unread());
  EXPECT_EQ(unread.head().token(), token);
  for (const std::uint64_t exact : {0, 1}) {
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(10));
    if (exact == 0) {
      request.mutable_consistency()->set_at_least(token);
    } else {
      request.mutable_consistency()->set_exact_revision(exact);
    }
    v1::CastRaysResponse reply;
    const grpc::Status cast = api.cast(request, &reply);
    ASSERT_TRUE(cast.ok()) << cast.error_message();
    EXPECT_EQ(reply.served().revision(), exact == 0 ? 2u : 1u);
  }
  EXPECT_EQ(api.get(kScene).nodes(), 2u);
  EXPECT_EQ(api.get(kScene).head().token(), token);
  EXPECT_FALSE(only_scene(api).unread());
  EXPECT_EQ(only_scene(api).nodes(), 2u);
  ASSERT_TRUE(api.remove(kScene).ok());
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0);
  ChildServer last(flags);
  Api again(connect(last.port()));
  EXPECT_TRUE(again.create(kScene).ok()) << "it was removed";
}

/// Lets this process and its children run on one core.
class OneCore {
 public:
  OneCore() {
    EXPECT_EQ(sched_getaffinity(0, sizeof before_, &before_), 0);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (std::size_t core = 0; CPU_COUNT(&one) == 0; ++core) {
      if (CPU_ISSET(core, &before_)) CPU_SET(core, &one);
    }
    EXPECT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  }
  ~OneCore() { EXPECT_EQ(sched_setaffinity(0, sizeof before_, &before_), 0); }

 private:
  cpu_set_t before_;
};

TEST_F(Sightlined, EndsOnOneCore) {
  const OneCore one;
  for (int i = 0; i < 10; ++i) {
    ChildServer child({"--listen", "127.0.0.1:0"});
    const int port = child.port();
    ASSERT_GT(port, 0) << child.output();
    {
      Api api(connect(port));
      api.make_scene(kScene, cube());
      v1::CastRaysResponse reply;
      ASSERT_TRUE(api.cast(cast_request(kScene, rays_downward(100)), &reply).ok());
    }
    child.signal(SIGTERM);
    EXPECT_EQ(child.wait(), 0);
    EXPECT_EQ(child.output().find("watchdog"), std::string::npos) << child.output();
  }
}

/// More lines than a pipe and the queue of the log hold.
void fill_log(Api& api) {
  for (std::size_t i = 0; i < 2 * server::kLogQueue; ++i)
    EXPECT_EQ(api.create("no name").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(Sightlined, ServesWhileItsLogIsNotRead) {
  ChildServer child({"--listen", "127.0.0.1:0", "--log-level", "debug"});
  Api api(connect(child.port()));
  child.stop_reading();
  fill_log(api);
  api.make_scene(kScene, cube());
  child.read_on();
  EXPECT_TRUE(child.writes("event=log_dropped lines="));
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0);
}

TEST_F(Sightlined, EndsWhileItsLogIsNotRead) {
  ChildServer child({"--listen", "127.0.0.1:0", "--log-level", "debug"});
  Api api(connect(child.port()));
  child.stop_reading();
  fill_log(api);
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0);
}

/// Waits until the server has closed this connection, which never sent anything.
void wait_for_end(const server::net::Descriptor& connection) {
  char byte = 0;
  while (recv(connection.number(), &byte, 1, 0) > 0) {
  }
}

TEST_F(Sightlined, WritesTheLinesThatAreLeftWhenItEnds) {
  ChildServer child({"--listen", "127.0.0.1:0", "--log-level", "debug"});
  const int port = child.port();
  const server::net::Descriptor connection = connect_tcp(port);
  Api api(connect(port));
  child.stop_reading();
  fill_log(api);
  child.signal(SIGTERM);
  wait_for_end(connection);
  child.read_on();
  EXPECT_EQ(child.wait(), 0);
  EXPECT_NE(child.output().find("event=stopped"), std::string::npos);
  EXPECT_EQ(child.output().find("watchdog"), std::string::npos);
}

TEST_F(Sightlined, AcceptsAgainAfterMoreConnectionsThanFileDescriptors) {
  ChildProcess child("/usr/bin/prlimit", {"--nofile=64", SIGHTLINED, "--listen", "127.0.0.1:0"});
  const int port = std::atoi(child.rest_of_line(" port=").c_str());
  ASSERT_GT(port, 0) << child.output();
  for (int round = 0; round < 3; ++round) {
    std::vector<server::net::Descriptor> many;
    for (int i = 0; i < 100; ++i) many.push_back(connect_tcp(port));
  }
  Api(connect(port)).make_scene(kScene, cube());
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0);
}

TEST_F(Sightlined, ReportsWhyItDoesNotStart) {
  const auto expect_end = [](const std::vector<std::string>& flags, int code,
                             const std::string& message) {
    ChildServer child(flags);
    EXPECT_EQ(child.wait(), code) << child.output();
    EXPECT_NE(child.output().find(message), std::string::npos) << child.output();
  };
  expect_end({"--policy", "sometimes"}, 2, "sometimes");
  expect_end({"--listen", "0.0.0.0:0"}, 2, "--insecure");
  expect_end({"--data-dir", root_ / "d", "--store", "postgresql://host/db"}, 2,
             "exclude each other");
  expect_end({"--store", "host/db", "--check-config"}, 2, "postgresql://USER@HOST");
  expect_end({"--listen", "127.0.0.1:0", "--store", "postgresql://u@127.0.0.1:1/db"}, 1,
             "postgresql://u@127.0.0.1:1/db");
  std::ofstream(root_ / "file") << "x";
  expect_end({"--listen", "127.0.0.1:0", "--data-dir", root_ / "file"}, 1,
             (root_ / "file").string());
  expect_end({"--listen", "127.0.0.1:0", "--port-file", root_ / "none" / "port"}, 1, "port file");
  expect_end({"--listen", "127.0.0.1:0", "--tokens", root_ / "none"}, 1, (root_ / "none").string());
  expect_end({"--listen", "127.0.0.1:0", "--tokens", root_ / "file"}, 1, "line 1");
  expect_end({"--tls-cert", "c"}, 2, "need each other");
  expect_end({"--tls-client-ca", "a"}, 2, "needs both");
  expect_end({"--tls-cert", root_ / "none", "--tls-key", root_ / "file"}, 1,
             (root_ / "none").string());
  expect_end({"--tls-cert", root_ / "file", "--tls-key", root_ / "file"}, 1, "no certificate");
  ChildServer first({"--listen", "127.0.0.1:0"});
  const std::string taken = "127.0.0.1:" + std::to_string(first.port());
  expect_end({"--listen", taken}, 1, taken);
}

TEST_F(Sightlined, SignalsForOtherProgramsAreIgnored) {
  ChildServer child({"--listen", "127.0.0.1:0"});
  const int port = child.port();
  ASSERT_GT(port, 0) << child.output();
  for (const int number : {SIGUSR1, SIGUSR2, SIGPIPE, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGPWR,
                           SIGSTKFLT, SIGRTMIN, SIGRTMAX, SIGHUP})
    child.signal(number);
  EXPECT_TRUE(child.writes("event=reloaded certificates=none tokens=none")) << child.output();
  Api(connect(port)).make_scene(kScene, cube());
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0) << child.output();
}

TEST_F(Sightlined, SaysWhatItReadsOnSighup) {
  std::ofstream(root_ / "tokens") << token_row("robot", "secret", "read", R"("")");
  ChildServer child({"--listen", "127.0.0.1:0", "--tokens", root_ / "tokens"});
  ASSERT_GT(child.port(), 0) << child.output();
  child.signal(SIGHUP);
  EXPECT_TRUE(child.writes("event=reloaded certificates=none tokens=read")) << child.output();
  std::ofstream(root_ / "tokens") << "[[token]]\nname = ";
  for (int i = 0; i < 2; ++i) child.signal(SIGHUP);
  EXPECT_TRUE(child.writes("event=reloaded certificates=none tokens=kept error=\""))
      << child.output();
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0) << child.output();
}

TEST_F(Sightlined, ServesWithTlsAndTokensThatItReadsAgain) {
  const auto write = [this](const char* name, const std::string& content) {
    std::ofstream(root_ / name) << content;
    return (root_ / name).string();
  };
  const TestCertificate own = TestAuthority().issue();
  const std::string row = token_row("robot", "secret", "read", R"("")");
  ChildServer child({"--listen", "0.0.0.0:0", "--tls-cert", write("own.pem", own.certificate),
                     "--tls-key", write("own.key", own.key), "--tokens", write("tokens", row)});
  EXPECT_GT(child.port(), 0) << child.output();
  EXPECT_TRUE(child.writes("event=certificates_loaded"));
  EXPECT_TRUE(child.writes("tls=true tokens=true"));
  write("tokens", "[[token]]\nname = ");
  EXPECT_TRUE(child.writes("event=tokens_not_loaded kept=old"));
  write("tokens", row + token_row("other", "secret too", "read", R"("")"));
  EXPECT_TRUE(child.writes("tokens=2"));
  write("own.pem", "no certificate");
  EXPECT_TRUE(child.writes("event=certificates_not_loaded kept=old"));
  child.signal(SIGTERM);
  EXPECT_EQ(child.wait(), 0) << child.output();
  EXPECT_EQ(child.output().find("secret"), std::string::npos);
  EXPECT_EQ(child.output().find(hash_of("secret")), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests
