// Stands between a store and PostgreSQL, and cuts connections at the worst moments.
#pragma once

#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/server/store/directory.h"

namespace sightline::tests {

/// Where a commit of a writer is lost.
enum class Cut {
  kNone,
  kBeforeCommit,  ///< The server never hears of it.
  kAfterCommit,   ///< The server's answer is lost.
};

/// Forwards a Unix socket. Threads: any, for every member.
class CuttingProxy {
 public:
  explicit CuttingProxy(const std::filesystem::path& server);
  ~CuttingProxy();
  CuttingProxy(const CuttingProxy&) = delete;
  CuttingProxy& operator=(const CuttingProxy&) = delete;

  /// The directory of the socket.
  const std::filesystem::path& sockets() const { return directory_.path(); }

  /// Cuts the connection of the next writer that commits.
  void cut(Cut cut) { cut_ = cut; }
  /// Whether that was done.
  bool has_cut() const { return cut_ == Cut::kNone; }
  /// Closes new connections at once, until it is called with false.
  void refuse(bool refuse) { refuse_ = refuse; }

 private:
  void accept_all();
  void forward(int client);

  const std::filesystem::path server_;
  const Directory directory_;
  int listener_ = -1;
  std::atomic<Cut> cut_{Cut::kNone};
  std::atomic<bool> refuse_{false};
  std::atomic<bool> ending_{false};
  std::vector<std::thread> forwarders_;  // used by the acceptor
  std::thread acceptor_;                 // begins last
};

}  // namespace sightline::tests
