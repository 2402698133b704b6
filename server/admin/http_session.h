// One connection of the HTTP server: one request, and its reply or a WebSocket.
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>
#include <optional>
#include <string>

#include "server/admin/http_server.h"
#include "server/admin/json_calls.h"
#include "server/admin/page_thread.h"
#include "server/net/descriptor.h"

namespace sightline::server::admin {

/// A stream over TCP or a Unix socket.
using Stream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;

/// A session lives as long as something is to be done for it. Threads: that of the connections.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  /// `pages`, `tunnel` and `json` (null: none) outlive the thread of the connections.
  static std::shared_ptr<HttpSession> start(boost::asio::io_context& context,
                                            net::Descriptor socket, PageThread& pages,
                                            Tunnel* tunnel, JsonCalls* json);

  void close();

  /// The address of the peer without its port, in the form of exec::Caller::principal.
  const std::string& address() const { return address_; }
  /// Whether it asks if the server is alive or ready, and has no answer yet.
  bool is_probe() const { return is_probe_; }

 private:
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  HttpSession(boost::asio::io_context& context, net::Descriptor socket, PageThread& pages,
              Tunnel* tunnel, JsonCalls* json);

  void read();
  void answer();
  void upgrade();
  bool is_json() const;
  Result<JsonCalls::Request> json_request() const;
  void read_json();
  void call(JsonCalls::Request request);
  void watch();
  void refuse_size();
  void ask(std::string path);
  void write(const HttpReply& reply);
  void linger();

  Stream stream_;
  const std::string peer_, address_;
  bool is_probe_ = false;
  PageThread& pages_;
  Tunnel* const tunnel_;
  JsonCalls* const json_;
  boost::beast::flat_buffer buffer_{2 * HttpServer::kMaxRequest};
  boost::beast::http::request_parser<boost::beast::http::empty_body> parser_;
  // The same request with its body, if it is a call in JSON; parser_ is empty then.
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> body_;
  std::weak_ptr<JsonCalls::Call> call_;
  bool answered_ = false;  // the call has ended
  Response response_;
};

}  // namespace sightline::server::admin
