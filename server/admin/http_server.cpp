// HTTP/1.1 for probes, metrics, calls in JSON and the live page, and the WebSockets of that page.
#include "server/admin/http_server.h"

#include <sys/socket.h>

#include <cerrno>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "server/admin/http_session.h"
#include "server/admin/json_calls.h"
#include "server/admin/page_thread.h"
#include "server/admin/tunnel.h"

namespace sightline::server::admin {
namespace {

/// The pause after accept() has failed for want of descriptors.
constexpr std::chrono::milliseconds kPause{100};

}  // namespace

HttpServer::HttpServer(std::vector<net::Descriptor> listeners, Handler handler, Tunnel* tunnel,
                       JsonCalls* json)
    : tunnel_(tunnel), json_(json), pages_(std::make_unique<PageThread>(std::move(handler))) {
  for (net::Descriptor& one : listeners) {
    Listener& listener = listeners_.emplace_back(
        Listener{boost::asio::posix::stream_descriptor(context_, one.release()),
                 boost::asio::steady_timer(context_)});
    wait_at(listener);
  }
  thread_ = std::thread([this] { context_.run(); });
}

HttpServer::~HttpServer() {
  context_.stop();
  thread_.join();
  if (tunnel_ != nullptr) tunnel_->end_calls();  // their events need the context
  if (json_ != nullptr) json_->join();           // so do its replies
}

void HttpServer::wait_at(Listener& listener) {
  listener.descriptor.async_wait(boost::asio::posix::descriptor_base::wait_read,
                                 [this, &listener](const boost::system::error_code& error) {
                                   if (!error) accept_from(listener);
                                 });
}

void HttpServer::accept_from(Listener& listener) {
  net::Descriptor socket(
      accept4(listener.descriptor.native_handle(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  const bool later = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  if (!socket && !later && errno != ECONNABORTED) {
    listener.pause.expires_after(kPause);
    listener.pause.async_wait(
        [this, &listener](const boost::system::error_code&) { wait_at(listener); });
    return;
  }
  wait_at(listener);
  if (!socket) return;
  std::erase_if(sessions_, [](const auto& one) { return one.expired(); });
  if (sessions_.size() >= kMaxConnections) close_one();
  sessions_.push_back(HttpSession::start(context_, std::move(socket), *pages_, tunnel_, json_));
}

/// Closes a probe last: it gets its reply whatever floods the port.
void HttpServer::close_one() {
  std::map<std::string, std::size_t> of_address;
  for (const auto& one : sessions_) ++of_address[one.lock()->address()];
  const auto goes_first = [&](const HttpSession& one, const HttpSession& other) {
    if (one.is_probe() != other.is_probe()) return other.is_probe();
    return of_address[one.address()] > of_address[other.address()];
  };
  auto first = sessions_.begin();
  for (auto at = std::next(first); at != sessions_.end(); ++at) {
    if (goes_first(*at->lock(), *first->lock())) first = at;
  }
  first->lock()->close();
  sessions_.erase(first);
}

}  // namespace sightline::server::admin
