// One long call that is opened again after the connection breaks.
#include "client/calls/watch.h"

#include <chrono>
#include <utility>

#include "client/calls/connection.h"
#include "client/wire/scene_codec.h"

namespace sightline::client::calls {
namespace {

constexpr int kWatchAttempts = 8;

class Watch {
 public:
  Watch(const Connection& connection, const std::string& scene, std::optional<std::uint64_t> start,
        const SceneChangeSink& sink, const std::stop_token& stop)
      : connection_(connection), sink_(sink), stop_(stop) {
    request_.set_scene(scene);
    if (start) request_.set_start_revision(*start);
  }

  Status run() {
    Backoff backoff(kWatchAttempts);
    while (true) {
      const std::uint64_t seen = messages_;
      Status ended = read();
      if (stopped_by_sink_) return {};
      if (ended) ended = Error{Code::kUnavailable, "the server ended the watch", {}};
      if (messages_ > seen) backoff.reset();
      if (!is_broken_connection(ended.error().code) || !backoff.again()) return ended;
      if (!sleep_unless_stopped(backoff.pause(), stop_))
        return Error{Code::kCancelled, "cancelled", {}};
    }
  }

 private:
  Status read() {
    grpc::ClientContext context;
    set_route(context, request_.scene());
    const std::stop_callback cancel(stop_, [&] { context.TryCancel(); });
    const auto reader = connection_.scenes->WatchScene(&context, request_);
    Status good;
    v1::WatchSceneResponse response;
    change_ = {};
    while (reader->Read(&response)) {
      ++messages_;
      if (good && !stopped_by_sink_) good = receive(response);
      if (!good || stopped_by_sink_) context.TryCancel();
    }
    const grpc::Status status = reader->Finish();
    if (!good) return good;
    return status.ok() ? Status() : Status(rpc_error(status, stop_));
  }

  Status receive(const v1::WatchSceneResponse& response) {
    for (const v1::Update& update : response.updates()) {
      auto decoded = wire::decode(update);
      if (!decoded) return decoded.error();
      change_.updates.push_back(*std::move(decoded));
    }
    if (response.more()) return {};
    change_.revision = response.revision().revision();
    change_.token = response.revision().token();
    change_.is_progress = response.progress();
    request_.set_start_revision(change_.revision);  // where to continue if the connection breaks
    stopped_by_sink_ = !sink_(change_);
    change_ = {};
    return {};
  }

  const Connection& connection_;
  const SceneChangeSink& sink_;
  const std::stop_token& stop_;
  v1::WatchSceneRequest request_;
  SceneChange change_;  // collects the parts of one change
  std::uint64_t messages_ = 0;
  bool stopped_by_sink_ = false;
};

}  // namespace

Status watch(const Connection& connection, const std::string& scene,
             std::optional<std::uint64_t> start, const SceneChangeSink& sink,
             const std::stop_token& stop) {
  return Watch(connection, scene, start, sink, stop).run();
}

}  // namespace sightline::client::calls
