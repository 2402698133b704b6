// Makes the pages of the admin port, on a thread that may wait.
#include "server/admin/page_thread.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

namespace sightline::server::admin {

PageThread::~PageThread() {
  thread_.stop();
  thread_.join();
}

bool PageThread::make(std::string path, std::function<void(HttpReply)> done) {
  if (waiting_.fetch_add(1) >= kMaxWaiting) {
    --waiting_;
    return false;
  }
  boost::asio::post(thread_, [this, path = std::move(path), done = std::move(done)] {
    done(ask(path));
    --waiting_;
  });
  return true;
}

HttpReply PageThread::ask(const std::string& path) const {
  try {
    return handler_(path);
  } catch (const std::exception& thrown) {
    return {.code = 500, .body = fmt::format("{}\n", thrown.what())};
  }
}

}  // namespace sightline::server::admin
