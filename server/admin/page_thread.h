// Makes the pages of the admin port, on a thread that may wait.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>

#include "server/admin/http_server.h"

namespace sightline::server::admin {

/// Readiness and metrics ask the store, which may take seconds to answer: the thread of the
/// connections does not wait for them. Threads: any, for every member.
class PageThread {
 public:
  /// Pages at a time. More than there are connections: those of connections that gave way wait,
  /// too.
  static constexpr std::size_t kMaxWaiting = 4 * HttpServer::kMaxConnections;

  explicit PageThread(HttpServer::Handler handler) : handler_(std::move(handler)) {}
  /// Waits for the page that is being made; the others are dropped.
  ~PageThread();
  PageThread(const PageThread&) = delete;
  PageThread& operator=(const PageThread&) = delete;

  /// Calls `done` on that thread with the page, one after the other. What the handler throws is a
  /// page with code 500. False: too many wait already.
  bool make(std::string path, std::function<void(HttpReply)> done);

 private:
  HttpReply ask(const std::string& path) const;

  const HttpServer::Handler handler_;
  std::atomic<std::size_t> waiting_{0};
  boost::asio::thread_pool thread_{1};
};

}  // namespace sightline::server::admin
