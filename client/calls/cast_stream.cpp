// Messages that wait for their answers are kept, to be sent again.
#include "client/calls/cast_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <semaphore>
#include <thread>
#include <utility>

#include "client/calls/connection.h"
#include "client/calls/query_calls.h"
#include "client/calls/retries.h"
#include "client/calls/segment_messages.h"
#include "client/wire/cast_codec.h"

namespace sightline::client::calls {
namespace {

constexpr int kCastAttempts = 4;

template <class Request>
void forget_description(Request& request) {
  request.clear_scene();
  request.clear_fields();
  request.clear_kind();
  request.clear_build();
  CallsOf<Request>::clear_own(request);
  request.clear_root();
  request.clear_exclude();
  request.clear_only_labels();
  request.clear_exclude_labels();
  request.clear_max_hits();
  request.clear_consistency();
}

/// The messages of a cast: from the source, and once more if they were not answered. Threads: the
/// one that writes; rays() and forget_rays() also the one that reads.
template <class Request>
class Messages {
 public:
  using Message = typename CallsOf<Request>::StreamRequest;

  explicit Messages(MessageSource<Request> source) : source_(std::move(source)) {}

  /// Message `number`, with its rays: one of the last kMessagesInFlight, or the next. Null: there
  /// are no more. Errors: those of the source, here and from then on.
  Result<Message*> get(std::uint64_t number) {
    Message& message = kept_[number % kMessagesInFlight];
    if (number < made_) return &message;
    if (ended_) return nullptr;
    const auto count = source_(*message.mutable_request());
    if (!count) return count.error();
    ended_ = *count == 0;
    // The first message is sent even without rays, so that an unknown scene is still an error.
    if (ended_ && number > 0) return nullptr;
    rays_[number % kMessagesInFlight] = *count;
    message.set_chunk(number);
    made_ = number + 1;
    return &message;
  }

  std::size_t rays(std::uint64_t number) const { return rays_[number % kMessagesInFlight]; }
  /// Another answer to the message would have no rays, so that it has nowhere to be written.
  void forget_rays(std::uint64_t number) { rays_[number % kMessagesInFlight] = 0; }

 private:
  const MessageSource<Request> source_;
  std::array<Message, kMessagesInFlight> kept_;
  std::array<std::atomic<std::size_t>, kMessagesInFlight> rays_{};
  std::uint64_t made_ = 0;
  bool ended_ = false;
};

/// Takes the answers in order, those to one message in one or several parts.
template <class Request>
class Answers {
 public:
  /// `segment`: what views the answers; null: they are in the responses.
  Answers(HitFields fields, QueryKind kind, const HitSink& sink, SegmentMessages<Request>* segment)
      : fields_(fields), kind_(kind), sink_(sink), segment_(segment) {}

  /// The message that is answered next, wholly or from some ray on.
  std::uint64_t message() const { return message_; }
  /// Its first ray.
  std::uint64_t ray() const { return first_; }
  const CastReport& report() const { return report_; }
  bool has_begun() const { return !report_.token.empty(); }

  /// Notes that a new stream begins with message().
  void begin_again() { seen_ = 0; }
  /// Notes that the rays from ray() on are in other messages, without a segment, from number 0 on.
  void leave_segment() {
    segment_ = nullptr;
    message_ = 0;
  }

  /// Returns whether the message, which has n rays, is answered.
  Result<bool> receive(const typename CallsOf<Request>::StreamResponse& response, std::size_t n) {
    if (response.chunk() != message_) {
      return Error{
          Code::kInternal,
          fmt::format("the server answered message {} instead of {}", response.chunk(), message_),
          {}};
    }
    const std::string& token = response.response().served().token();
    if (has_begun() && token != report_.token)
      return Error{Code::kAborted, "the scene was made anew during the cast", "SCENE_REPLACED"};
    const bool is_all = kind_ == QueryKind::kAll;
    const auto hits = segment_ != nullptr ? segment_->view(message_, n, response.response())
                      : is_all ? wire::view_all_hits(response.response(), fields_, seen_, n)
                               : wire::view_hits(response.response(), fields_, n);
    if (!hits) return hits.error();
    if (const Status taken = take(is_all ? hits->offsets.size() - 1 : n, *hits); !taken)
      return taken.error();
    report_.revision = response.response().served().revision();
    report_.token = token;
    if (response.response().more()) return false;
    wire::add_stats(response.response(), report_);
    first_ += answered_;
    seen_ = answered_ = 0;
    ++message_;
    return true;
  }

 private:
  /// Parts depend on the hits alone, so that they come again as they were, unless rays are left
  /// without an answer.
  Status take(std::size_t count, const HitView& hits) {
    const std::size_t begin = std::exchange(seen_, seen_ + count);
    if (seen_ <= answered_ && count > 0) return {};
    if (begin < answered_)
      return Error{Code::kUnavailable, "the server has parted its answer in another way", {}};
    answered_ = seen_;
    return sink_(first_ + begin, count, hits);
  }

  const HitFields fields_;
  const QueryKind kind_;
  const HitSink& sink_;
  SegmentMessages<Request>* segment_;
  CastReport report_;
  std::uint64_t message_ = 0;
  std::uint64_t first_ = 0;   ///< Ray of the message.
  std::size_t answered_ = 0;  ///< How many of its rays the sink has got.
  std::size_t seen_ = 0;      ///< How many of its rays this stream has answered.
};

template <class Request>
class Cast {
 public:
  Cast(const Connection& connection, std::string scene, const MessageSource<Request>& source,
       HitFields fields, const HitSink& sink, CastOptions options)
      : connection_(connection),
        scene_(std::move(scene)),
        fields_(fields),
        options_(std::move(options)),
        messages_(std::in_place, source),
        answers_(fields, options_.kind, sink, nullptr),
        deadline_(deadline_after(connection.timeout)),
        retries_(deadline_) {}

  Cast(const Connection& connection, std::string scene, SegmentMessages<Request>& segment,
       HitFields fields, const HitSink& sink, CastOptions options, Retries::Deadline deadline)
      : connection_(connection),
        scene_(std::move(scene)),
        fields_(fields),
        options_(std::move(options)),
        segment_(&segment),
        messages_(std::in_place,
                  [&segment](Request& request) -> Result<std::size_t> {
                    return segment.set_next(request);
                  }),
        answers_(fields, options_.kind, sink, segment_),
        deadline_(deadline),
        retries_(deadline_) {}

  Result<CastReport> run() {
    Backoff backoff(kCastAttempts);
    while (true) {
      const std::uint64_t before = answers_.message();
      const Status ended = attempt();
      const bool may_leave = segment_ == nullptr || segment_->end_call(status_);
      if (failed_) return *failed_;
      if (ended) return answers_.report();
      if (answers_.message() > before) {
        backoff.reset();
        retries_.progressed();
      }
      if (retries_.wait(status_, options_.stop)) continue;
      if (options_.stop.stop_requested()) return Error{Code::kCancelled, "cancelled", {}};
      if (segment_ != nullptr) {
        if (answers_.ray() == segment_->rows()) return answers_.report();
        if (!may_leave || retry_delay(status_) || status_.error_code() == grpc::DEADLINE_EXCEEDED)
          return ended.error();
        leave_segment();
        if (!may_resume(ended.error().code)) continue;
      }
      if (!may_resume(ended.error().code) || !backoff.again()) return ended.error();
      if (!sleep_unless_stopped(backoff.pause(), options_.stop))
        return Error{Code::kCancelled, "cancelled", {}};
    }
  }

 private:
  using Calls = CallsOf<Request>;
  using Stream =
      grpc::ClientReaderWriter<typename Calls::StreamRequest, typename Calls::StreamResponse>;

  /// What the server says without a segment is what counts.
  void leave_segment() {
    messages_.emplace(segment_->rest(answers_.ray()));
    answers_.leave_segment();
    segment_ = nullptr;
  }

  /// A replica may not have the revision yet.
  bool may_resume(Code code) const {
    return is_broken_connection(code) || (answers_.has_begun() && code == Code::kOutOfRange);
  }

  /// Runs one stream, from the first message without an answer on. An error that no other stream
  /// would mend is in failed_.
  Status attempt() {
    grpc::ClientContext context;
    if (deadline_) context.set_deadline(*deadline_);
    set_route(context, scene_, options_.route_key);
    const std::stop_callback cancel(options_.stop, [&] { context.TryCancel(); });
    connection_.wait_until_connected();
    const auto stream = Calls::open(*connection_.queries, context);
    answers_.begin_again();
    if (answers_.has_begun())
      options_.consistency = {.at_least = {}, .exact_revision = answers_.report().revision};

    Window window;
    std::thread writing(
        [&, first = answers_.message()] { write(*stream, context, window, first); });
    read(*stream, context, window);
    window.closed = true;
    window.free.release();
    writing.join();
    status_ = stream->Finish();
    if (window.source_error) failed_ = std::move(window.source_error);
    return status_.ok() || failed_ ? Status() : Status(rpc_error(status_, options_.stop));
  }

  struct Window {
    std::counting_semaphore<> free{kMessagesInFlight};
    std::atomic<bool> closed = false;
    std::optional<Error> source_error;  ///< Read after the writing thread has ended.
  };

  void write(Stream& stream, grpc::ClientContext& context, Window& window, std::uint64_t first) {
    for (std::uint64_t number = first;; ++number) {
      window.free.acquire();
      if (window.closed) return;
      const auto message = messages_->get(number);
      if (!message) {
        window.source_error = message.error();
        context.TryCancel();
        break;
      }
      if (*message == nullptr) break;
      Request& request = *(*message)->mutable_request();
      if (number == first)
        wire::describe(scene_, segment_ != nullptr ? HitFields() : fields_, options_, request);
      set_rest_of_budget(request);
      const bool is_empty = messages_->rays(number) == 0;
      const bool written = stream.Write(**message);
      if (number == first) forget_description(request);
      if (!written || is_empty) break;
    }
    stream.WritesDone();
  }

  /// The time budget is of all messages together.
  void set_rest_of_budget(Request& request) const {
    if (options_.time_budget.count() == 0) return;
    const auto spent = std::chrono::duration_cast<std::chrono::milliseconds>(
        std::chrono::steady_clock::now() - begun_);
    const auto rest = std::max(options_.time_budget - spent, std::chrono::milliseconds(1));
    request.set_time_budget_ms(wire::milliseconds_of(rest));
  }

  /// The first wrong answer cancels the call.
  void read(Stream& stream, grpc::ClientContext& context, Window& window) {
    typename Calls::StreamResponse response;
    while (stream.Read(&response)) {
      if (failed_) continue;
      const std::uint64_t number = answers_.message();
      const auto is_answered = answers_.receive(response, messages_->rays(number));
      if (!is_answered) {
        failed_ = is_answered.error();
        context.TryCancel();
      } else if (*is_answered) {
        messages_->forget_rays(number);
        window.free.release();
      }
    }
  }

  const Connection& connection_;
  const std::string scene_;
  const HitFields fields_;
  CastOptions options_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  SegmentMessages<Request>* segment_ = nullptr;  // null: messages have the rays and the answers
  std::optional<Messages<Request>> messages_;
  Answers<Request> answers_;
  const Retries::Deadline deadline_;
  Retries retries_;
  grpc::Status status_;  // how the last attempt ended
  std::optional<Error> failed_;
};

}  // namespace

template <class Request>
Result<CastReport> cast_messages(const Connection& connection, const std::string& scene,
                                 const MessageSource<Request>& source, HitFields fields,
                                 const HitSink& sink, const CastOptions& options) {
  if (const Status checked = CallsOf<Request>::check(options, fields); !checked)
    return checked.error();
  return Cast<Request>(connection, scene, source, fields, sink, options).run();
}

template <class Request>
Result<CastReport> cast_messages(const Connection& connection, const std::string& scene,
                                 SegmentMessages<Request>& messages, HitFields fields,
                                 const HitSink& sink, const CastOptions& options,
                                 Retries::Deadline deadline) {
  if (const Status checked = CallsOf<Request>::check(options, fields); !checked)
    return checked.error();
  return Cast<Request>(connection, scene, messages, fields, sink, options, deadline).run();
}

template Result<CastReport> cast_messages(const Connection&, const std::string&,
                                          SegmentMessages<v1::CastRaysRequest>&, HitFields,
                                          const HitSink&, const CastOptions&, Retries::Deadline);
template Result<CastReport> cast_messages(const Connection&, const std::string&,
                                          SegmentMessages<v1::QueryPointsRequest>&, HitFields,
                                          const HitSink&, const CastOptions&, Retries::Deadline);

template Result<CastReport> cast_messages(const Connection&, const std::string&,
                                          const MessageSource<v1::CastRaysRequest>&, HitFields,
                                          const HitSink&, const CastOptions&);
template Result<CastReport> cast_messages(const Connection&, const std::string&,
                                          const MessageSource<v1::QueryPointsRequest>&, HitFields,
                                          const HitSink&, const CastOptions&);

}  // namespace sightline::client::calls
