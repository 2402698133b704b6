// Answers are finished by a thread with a timer that is finer than those of gRPC.
#include "tests/load/delay_service.h"

#include <grpcpp/grpcpp.h>
#include <sys/prctl.h>

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::tests::load {
namespace {

namespace v1 = ::sightline::v1;

template <class T>
void append(std::string& bytes, T value, std::size_t times) {
  for (std::size_t i = 0; i < times; ++i)
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void answer(const v1::CastRaysRequest& request, v1::CastRaysResponse& reply) {
  const v1::Rays& rays = request.rays();
  const std::size_t count = rays.origins().size() / (rays.float64() ? 24 : 12);
  reply.mutable_served()->set_revision(1);
  reply.mutable_stats()->set_rays(count);
  reply.mutable_stats()->set_hits(count);
  for (const int field : request.fields()) {
    v1::HitColumn& column = *reply.add_columns();
    column.set_field(static_cast<v1::HitField>(field));
    std::string& bytes = *column.mutable_data();
    if (field == v1::HIT_FIELD_T) append(bytes, 1.0, count);
    if (field == v1::HIT_FIELD_NODE) append(bytes, std::uint64_t{1}, count);
    if (field == v1::HIT_FIELD_PRIMITIVE) append(bytes, std::uint32_t{0}, count);
    if (field == v1::HIT_FIELD_NORMAL) append(bytes, 1.0F, 3 * count);
  }
}

// Does what is due, one after the other.
class Timer {
 public:
  using Clock = std::chrono::steady_clock;

  void at(Clock::time_point time, std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    due_.emplace(time, std::move(work));
    changed_.notify_all();
  }

 private:
  void run(const std::stop_token& stop) {
    ::prctl(PR_SET_TIMERSLACK, 1UL);
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      if (due_.empty()) {
        changed_.wait(lock, stop, [&] { return !due_.empty(); });
      } else if (due_.begin()->first > Clock::now()) {
        const auto time = due_.begin()->first;
        changed_.wait_until(lock, stop, time, [&] { return due_.begin()->first < time; });
      } else {
        const auto work = std::move(due_.extract(due_.begin()).mapped());
        lock.unlock();
        work();
        lock.lock();
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::multimap<Clock::time_point, std::function<void()>> due_;
  std::jthread thread_{[this](const std::stop_token& stop) { run(stop); }};
};

class Queries final : public v1::RayQueryService::CallbackService {
 public:
  explicit Queries(std::chrono::microseconds delay) : delay_(delay) {}

  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* reply) override {
    grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
    const auto due = Timer::Clock::now() + delay_;
    answer(*request, *reply);
    timer_.at(due, [=] { reactor->Finish(grpc::Status::OK); });
    return reactor;
  }

  // What the rays are made from.
  grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* StreamCastRays(
      grpc::CallbackServerContext*) override {
    class Stream final
        : public grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse> {
     public:
      Stream() { StartRead(&request_); }
      void OnReadDone(bool ok) override {
        if (!ok) return Finish(grpc::Status::OK);
        if (asked_.fields().empty()) asked_ = request_.request();
        *asked_.mutable_rays() = request_.request().rays();
        reply_.Clear();
        answer(asked_, *reply_.mutable_response());
        reply_.set_chunk(request_.chunk());
        StartWrite(&reply_);
      }
      void OnWriteDone(bool ok) override {
        if (!ok) return Finish(grpc::Status::CANCELLED);
        StartRead(&request_);
      }
      void OnDone() override { delete this; }

     private:
      v1::StreamCastRaysRequest request_;
      v1::CastRaysRequest asked_;
      v1::StreamCastRaysResponse reply_;
    };
    return new Stream;
  }

 private:
  const std::chrono::microseconds delay_;
  Timer timer_;
};

grpc::ServerUnaryReactor* finish(grpc::CallbackServerContext* context) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

class Scenes final : public v1::SceneService::CallbackService {
 public:
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* reply) override {
    v1::Scene& scene = *reply->mutable_scene();
    scene.set_name(request->name());
    for (const double bound : {0, 0, 0, 1, 1, 1}) scene.add_bounds(bound);
    return finish(context);
  }
  grpc::ServerUnaryReactor* GetSceneStats(grpc::CallbackServerContext* context,
                                          const v1::GetSceneStatsRequest*,
                                          v1::GetSceneStatsResponse*) override {
    return finish(context);
  }
};

class Info final : public v1::ServerService::CallbackService {
 public:
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest*,
                                          v1::GetServerInfoResponse* reply) override {
    reply->set_threads(1);
    return finish(context);
  }
};

}  // namespace

class DelayService::Calls {
 public:
  explicit Calls(std::chrono::microseconds delay) : queries_(delay) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(&queries_);
    builder.RegisterService(&scenes_);
    builder.RegisterService(&info_);
    server_ = builder.BuildAndStart();
  }
  int port() const { return port_; }

 private:
  Queries queries_;
  Scenes scenes_;
  Info info_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

DelayService::DelayService(std::chrono::microseconds delay)
    : calls_(std::make_unique<Calls>(delay)) {}
DelayService::~DelayService() = default;

std::string DelayService::endpoint() const { return "127.0.0.1:" + std::to_string(calls_->port()); }

}  // namespace sightline::tests::load
