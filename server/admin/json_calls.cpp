// Calls in JSON: from HTTP requests to the server's own services, within the process.
#include "server/admin/json_calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cstdint>

#include "server/admin/json_call.h"
#include "server/admin/json_codec.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::admin {

std::shared_ptr<JsonCalls::Call> JsonCalls::begin(Request request, Done done) {
  auto call = std::make_shared<Call>(std::move(request), std::move(done));
  bool full = false;
  {
    const std::lock_guard lock(mutex_);
    full = open_ == kMaxCalls;
    if (!full) ++open_;
  }
  boost::asio::post(thread_, [this, call, full] {
    if (!full) return start(call);
    HttpReply reply =
        json_error({Code::kUnavailable, fmt::format("{} calls in JSON are open already", kMaxCalls),
                    "TOO_MANY_CALLS"});
    reply.retry = true;
    call->reply(reply);
  });
  return call;
}

void JsonCalls::start(const std::shared_ptr<Call>& call) {
  const Status begun = exec::to_status([&] {
    return call->start(tunnel_, [this, call] {
      boost::asio::post(thread_, [this, call] {
        HttpReply reply;
        const Status made = exec::to_status([&] {
          reply = call->answer();
          return Status();
        });
        end(call, made ? reply : json_error(made.error()));
      });
    });
  });
  if (!begun) end(call, json_error(begun.error()));
}

void JsonCalls::end(const std::shared_ptr<Call>& call, const HttpReply& reply) {
  {
    const std::lock_guard lock(mutex_);
    --open_;
  }
  call->reply(reply);
}

void JsonCalls::join() { thread_.join(); }

Result<std::chrono::nanoseconds> parse_timeout(const std::string& text) {
  using std::chrono::nanoseconds;
  constexpr std::size_t kMostDigits = 8;
  const auto wrong = [&] {
    return exec::invalid_argument(
        fmt::format("the Grpc-Timeout {} is none: take 1 to 99999999 and H, M, S, m, u or n",
                    exec::quote(text)),
        "BAD_TIMEOUT");
  };
  if (text.size() < 2 || text.size() > kMostDigits + 1) return wrong();
  const std::string digits = text.substr(0, text.size() - 1);
  if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return wrong();
  const std::int64_t count = std::stoll(digits);
  if (count == 0) return wrong();
  switch (text.back()) {
    case 'H':
      // Hours beyond a year would not fit into a time.
      return nanoseconds(std::chrono::hours(std::min(count, std::int64_t{24} * 365)));
    case 'M':
      return nanoseconds(std::chrono::minutes(count));
    case 'S':
      return nanoseconds(std::chrono::seconds(count));
    case 'm':
      return nanoseconds(std::chrono::milliseconds(count));
    case 'u':
      return nanoseconds(std::chrono::microseconds(count));
    case 'n':
      return nanoseconds(count);
    default:
      return wrong();
  }
}

}  // namespace sightline::server::admin
