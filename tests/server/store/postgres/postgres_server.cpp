// A PostgreSQL server of this process, from the system's package, in a directory that ends with it.
#include "tests/server/store/postgres/postgres_server.h"

#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sightline::tests {
namespace {

namespace fs = std::filesystem;

/// Where Debian's package has the programs; empty if it is missing.
fs::path programs() {
  for (const char* version : {"15", "16", "17"}) {
    const fs::path bin = fs::path("/usr/lib/postgresql") / version / "bin";
    if (access((bin / "initdb").c_str(), X_OK) == 0) return bin;
  }
  return {};
}

/// PostgreSQL refuses to run as root: then it runs as a user that can do nothing else.
const passwd* user_of_server() {
  if (geteuid() != 0) return nullptr;
  const passwd* user = getpwnam("postgres");
  return user == nullptr ? getpwnam("nobody") : user;
}

[[noreturn]] void become(const std::vector<std::string>& command, const fs::path& log) {
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
  if (const passwd* user = user_of_server()) {
    if (setgroups(0, nullptr) != 0 || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0)
      _exit(126);
  }
  prctl(PR_SET_PDEATHSIG, SIGQUIT);  // it ends if the test is killed
  if (chdir("/") != 0) _exit(126);
  std::vector<char*> arguments;
  for (const std::string& one : command) arguments.push_back(const_cast<char*>(one.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

pid_t spawn(const std::vector<std::string>& command, const fs::path& log) {
  const pid_t process = fork();
  if (process == 0) become(command, log);
  return process;
}

void run_program(const std::vector<std::string>& command, const fs::path& log) {
  int status = -1;
  waitpid(spawn(command, log), &status, 0);
  EXPECT_EQ(status, 0) << command.front() << " failed";
}

struct Finish {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};
struct Clear {
  void operator()(PGresult* result) const { PQclear(result); }
};

}  // namespace

bool PostgresServer::installed() { return !programs().empty(); }

PostgresServer& PostgresServer::shared() {
  static PostgresServer server;
  return server;
}

PostgresServer::PostgresServer() {
  give_directory();
  run_program({programs() / "initdb", "-D", data(), "-U", "sightline", "-A", "trust", "-E", "UTF8",
               "--locale=C", "--no-sync", "--no-instructions"},
              directory_.path() / "log");
  start();
}

PostgresServer::PostgresServer(const PostgresServer& primary) {
  give_directory();
  run_program({programs() / "pg_basebackup", "-h", primary.sockets(), "-U", "sightline", "-D",
               data(), "-R", "-c", "fast", "--no-sync"},
              directory_.path() / "log");
  start();
  primary.run("postgres", "ALTER SYSTEM SET synchronous_standby_names = '*'");
  primary.run("postgres", "SELECT pg_reload_conf()");
  while (primary.run("postgres", "SELECT sync_state FROM pg_stat_replication") != "sync")
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

/// To the user that the server runs as.
void PostgresServer::give_directory() const {
  const passwd* const user = user_of_server();
  if (user == nullptr) return;
  EXPECT_EQ(chown(directory_.path().c_str(), user->pw_uid, user->pw_gid), 0);
}

PostgresServer::~PostgresServer() { kill(); }

void PostgresServer::start() {
  process_ = spawn({programs() / "postgres", "-D", data(), "-k", directory_.path(), "-h", "", "-c",
                    "fsync=off", "-c", "max_connections=60", "-c", "shared_buffers=32MB", "-c",
                    "deadlock_timeout=100ms", "-c", "autovacuum=off"},
                   directory_.path() / "log");
  wait_until_ready();
}

void PostgresServer::wait_until_ready() const {
  const std::string address = uri("postgres");
  for (int i = 0; i < 3000; ++i) {
    if (PQping(address.c_str()) == PQPING_OK) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("PostgreSQL does not start");
}

void PostgresServer::kill() {
  if (process_ < 0) return;
  ::kill(process_, SIGQUIT);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

void PostgresServer::promote() const { run("postgres", "SELECT pg_promote()"); }

std::string PostgresServer::uri(const std::string& database, const std::string& sockets) {
  return "postgresql://sightline@/" + database + "?host=" + sockets;
}

std::string PostgresServer::make_database() {
  std::string name = "test" + std::to_string(++databases_);
  run("postgres", "CREATE DATABASE " + name + " TEMPLATE template0");
  return name;
}

std::string PostgresServer::run(const std::string& database, const std::string& statement) const {
  const std::unique_ptr<PGconn, Finish> connection(PQconnectdb(uri(database).c_str()));
  const std::unique_ptr<PGresult, Clear> result(PQexec(connection.get(), statement.c_str()));
  const ExecStatusType status = PQresultStatus(result.get());
  EXPECT_TRUE(status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK)
      << statement << ": " << PQerrorMessage(connection.get());
  return PQntuples(result.get()) > 0 ? PQgetvalue(result.get(), 0, 0) : "";
}

}  // namespace sightline::tests
