// The command against servers with TLS and tokens: its exit codes.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/client/support/run_program.h"
#include "tests/server/support/secured_server.h"

namespace sightline::tests {
namespace {

class SecurityFlags : public SecuredServer {
 protected:
  SecurityFlags() {
    dir_.write("ca.pem", authority_.certificate());
    dir_.write("other.pem", TestAuthority("Other CA").certificate());
    dir_.write("reader", kReader + "\n");
    dir_.write("writer", kWriter);
  }

  ProgramOutcome run(const std::string& authority, const std::string& token,
                     std::vector<std::string> words) {
    words.insert(words.end(), {"--endpoint", "127.0.0.1:" + std::to_string(server_->port())});
    if (!authority.empty()) words.insert(words.end(), {"--tls-ca", dir_.path(authority)});
    if (!token.empty()) words.insert(words.end(), {"--token-file", dir_.path(token)});
    return run_program(words);
  }
};

TEST_F(SecurityFlags, EndWithTheCodeOfWhatWasWrong) {
  EXPECT_EQ(run("ca.pem", "reader", {"scene", "show", "projects/site/scenes/own"}).exit, 3);
  EXPECT_EQ(run("ca.pem", "", {"scene", "ls"}).exit, 6) << "no token";
  EXPECT_EQ(run("ca.pem", "writer", {"scene", "rm", "projects/site/scenes/own"}).exit, 6);
  EXPECT_EQ(run("other.pem", "reader", {"scene", "ls"}).exit, 6) << "another authority";
  EXPECT_EQ(run("", "reader", {"scene", "ls"}).exit, 5) << "no TLS";
  EXPECT_EQ(run("ca.pem", "no-such-file", {"scene", "ls"}).exit, 1);
  EXPECT_EQ(run_program({"scene", "ls", "--tls-cert", dir_.path("ca.pem")}).exit, 2);
}

TEST_F(SecurityFlags, TheTokenMayBeInTheEnvironment) {
  ::setenv("SIGHTLINE_TOKEN", kReader.c_str(), 1);
  const ProgramOutcome shown = run("ca.pem", "", {"scene", "show", "projects/site/scenes/own"});
  const ProgramOutcome far = run_program({"scene", "ls", "--endpoint", "192.0.2.1:1"});
  ::unsetenv("SIGHTLINE_TOKEN");
  EXPECT_EQ(shown.exit, 3) << shown.err;
  EXPECT_EQ(far.exit, 6) << "not sent in plaintext";
  EXPECT_EQ(far.err.find(kReader), std::string::npos);
}

TEST(UnixSocket, ServesTheCommand) {
  const TempDir dir;
  server::ServerConfig config;
  config.listen = "unix:" + dir.path("socket");
  config.threads = 1;
  const auto server = server::Server::start(config);
  ASSERT_TRUE(server) << server.error().message;
  const ProgramOutcome listed = run_program({"scene", "ls", "--endpoint", config.listen});
  EXPECT_EQ(listed.exit, 0) << listed.err;
  (*server)->drain();
  EXPECT_EQ(dir.names(), "");
}

}  // namespace
}  // namespace sightline::tests
