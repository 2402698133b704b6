// Makes the pages of the admin port, on a thread that may wait.
#include "server/admin/page_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

namespace sightline::server::admin {

PageThread::~PageThread() {
  thread_.stop();
  thread_.join();
}

bool PageThread::make(std::string path, Urgency urgency, Done done) {
  const std::lock_guard lock(mutex_);
  Line& line = lines_.at(static_cast<std::size_t>(urgency));
  if (line.requests >= kMaxWaiting) return false;
  const auto same = std::find_if(line.pages.begin(), line.pages.end(),
                                 [&](const Page& page) { return page.path == path; });
  if (same != line.pages.end()) {
    same->asked.push_back(std::move(done));
  } else {
    line.pages.push_back({std::move(path), {std::move(done)}});
    boost::asio::post(thread_, [this] { make_next(); });
  }
  ++line.requests;
  return true;
}

void PageThread::make_next() {
  std::unique_lock lock(mutex_);
  Line& line = lines_[0].pages.empty() ? lines_[1] : lines_[0];
  const Page page = std::move(line.pages.front());
  line.pages.pop_front();
  lock.unlock();
  const HttpReply reply = ask(page.path);
  for (const Done& done : page.asked) done(reply);
  lock.lock();
  line.requests -= page.asked.size();
}

HttpReply PageThread::ask(const std::string& path) const {
  try {
    return handler_(path);
  } catch (const std::exception& thrown) {
    return {.code = 500, .body = fmt::format("{}\n", thrown.what())};
  }
}

}  // namespace sightline::server::admin
