// Makes the pages of the admin port, on a thread that may wait.
#pragma once

#include <array>
#include <boost/asio/thread_pool.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/admin/http_server.h"

namespace sightline::server::admin {

/// Probes go before pages.
enum class Urgency : std::uint8_t { kProbe, kPage };

/// Readiness and metrics ask the store, which may take seconds to answer: the thread of the
/// connections does not wait for them. All who ask for a page before it is begun share it, so that
/// it costs the same however many ask. Threads: any, for every member.
class PageThread {
 public:
  /// Requests at a time, of each urgency. More than there are connections: those of connections
  /// that gave way wait, too.
  static constexpr std::size_t kMaxWaiting = 4 * HttpServer::kMaxConnections;

  using Done = std::function<void(const HttpReply& reply)>;

  explicit PageThread(HttpServer::Handler handler) : handler_(std::move(handler)) {}
  /// Waits for the page that is being made; the others are dropped.
  ~PageThread();
  PageThread(const PageThread&) = delete;
  PageThread& operator=(const PageThread&) = delete;

  /// Calls `done` on that thread with a page that was begun after this call; those of one urgency
  /// in the order in which they were first asked for. What the handler throws is a page with code
  /// 500. False: too many requests wait already.
  bool make(std::string path, Urgency urgency, Done done);

 private:
  struct Page {
    std::string path;
    std::vector<Done> asked;
  };
  struct Line {
    std::deque<Page> pages;
    std::size_t requests = 0;  // for these pages and the one that is being made
  };

  void make_next();
  HttpReply ask(const std::string& path) const;

  const HttpServer::Handler handler_;
  std::mutex mutex_;
  std::array<Line, 2> lines_;  // by urgency
  boost::asio::thread_pool thread_{1};
};

}  // namespace sightline::server::admin
