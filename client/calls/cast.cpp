// Casts rays in one message, or over a stream with one thread that writes and one that reads.
#include "client/calls/cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <semaphore>
#include <thread>

#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/message_source.h"
#include "client/wire/cast_codec.h"

namespace sightline::client::calls {
namespace {

using Stream = grpc::ClientReaderWriter<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>;

// State shared by the thread that writes and the thread that reads.
struct Window {
  std::counting_semaphore<> free{kMessagesInFlight};
  std::array<std::atomic<std::size_t>, kMessagesInFlight>
      rays{};  // of message k, at k % kMessagesInFlight
  std::atomic<bool> closed = false;
  std::optional<Error> source_error;  // read after the writing thread has ended
};

struct Writer {
  Stream& stream;
  grpc::ClientContext& context;
  Window& window;
  const MessageSource<v1::CastRaysRequest>& source;
  // The first request describes the cast; the object is used for all requests
  v1::StreamCastRaysRequest request;

  // Fills the next message with rays. Returns 0 at the end, and after an error, which it stores.
  std::size_t fill() {
    const auto count = source(*request.mutable_request());
    if (count) return *count;
    window.source_error = count.error();
    context.TryCancel();
    return 0;
  }

  void run() {
    for (std::uint64_t chunk = 0;; ++chunk) {
      window.free.acquire();
      if (window.closed) return;
      const std::size_t count = fill();
      // The first message is sent even without rays, so that an unknown scene is still an error.
      if ((count == 0 && chunk > 0) || window.source_error) break;
      window.rays[chunk % kMessagesInFlight] = count;
      request.set_chunk(chunk);
      if (!stream.Write(request) || count == 0) break;
      if (chunk == 0) forget_description();
    }
    stream.WritesDone();
  }

  void forget_description() {
    request.mutable_request()->clear_scene();
    request.mutable_request()->clear_fields();
    request.mutable_request()->clear_kind();
    request.mutable_request()->clear_build();
    request.mutable_request()->clear_culling();
    request.mutable_request()->clear_root();
    request.mutable_request()->clear_exclude();
    request.mutable_request()->clear_max_hits();
    request.mutable_request()->clear_consistency();
  }
};

// Takes the answers in order. The answers to one message may come in several parts.
struct Reader {
  Window& window;
  HitFields fields;
  QueryKind kind;
  const HitSink& sink;
  CastReport& report;
  std::uint64_t chunk = 0;
  std::uint64_t first = 0;   // the first ray of the chunk
  std::size_t answered = 0;  // rays of the chunk that are answered

  Status receive(const v1::StreamCastRaysResponse& response) {
    if (response.chunk() != chunk) {
      return Error{
          Code::kInternal,
          fmt::format("the server answered message {} instead of {}", response.chunk(), chunk),
          {}};
    }
    const std::size_t n = window.rays[chunk % kMessagesInFlight];
    const bool is_all = kind == QueryKind::kAll;
    const auto answers = is_all ? wire::view_all_hits(response.response(), fields, answered, n)
                                : wire::view_hits(response.response(), fields, n);
    if (!answers) return answers.error();
    const std::size_t count = is_all ? answers->offsets.size() - 1 : n;
    if (Status taken = sink(first + answered, count, *answers); !taken) return taken;
    answered += count;
    if (!response.response().more()) next_chunk(response.response());
    return {};
  }

  void next_chunk(const v1::CastRaysResponse& response) {
    wire::add_stats(response, report);
    first += answered;
    answered = 0;
    ++chunk;
    window.free.release();
  }
};

// Reads every answer. The first wrong answer cancels the call, and its error is returned.
Status read_all(Stream& stream, grpc::ClientContext& context, Reader reader) {
  Status failed;
  v1::StreamCastRaysResponse response;
  while (stream.Read(&response)) {
    if (!failed) continue;
    failed = reader.receive(response);
    if (!failed) context.TryCancel();
  }
  return failed;
}

}  // namespace

template <class Scalar>
Result<CastReport> cast(const Connection& connection, const std::string& scene,
                        const RayColumns<const Scalar>& rays, const HitColumns& hits,
                        const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const Status checked = check_rows(rays, hits); !checked) return checked.error();
  const HitFields fields = fields_of(hits);
  v1::CastRaysRequest request;
  wire::describe(scene, fields, options, request);
  copy_rays(rays, 0,
            wire::resize_columns<Scalar>(rays.size(), shape_of(rays), *request.mutable_rays()));

  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  v1::CastRaysResponse response;
  const grpc::Status status = connection.queries->CastRays(&context, request, &response);
  if (!status.ok()) return rpc_error(status);
  const auto answers = wire::view_hits(response, fields, rays.size());
  if (!answers) return answers.error();
  copy_hits(*answers, 0, hits);
  CastReport report;
  wire::add_stats(response, report);
  return report;
}

template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const float>&, const HitColumns&,
                                 const CastOptions&);
template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const double>&, const HitColumns&,
                                 const CastOptions&);

namespace {

Result<CastReport> cast_messages(const Connection& connection, const std::string& scene,
                                 const MessageSource<v1::CastRaysRequest>& source, HitFields fields,
                                 const HitSink& sink, const CastOptions& options) {
  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  connection.wait_until_connected();
  const auto stream = connection.queries->StreamCastRays(&context);

  Window window;
  Writer writer{*stream, context, window, source, {}};
  wire::describe(scene, fields, options, *writer.request.mutable_request());
  std::thread writing([&] { writer.run(); });
  CastReport report;
  const Status read =
      read_all(*stream, context, Reader{window, fields, options.kind, sink, report});
  window.closed = true;
  window.free.release();
  writing.join();
  const grpc::Status status = stream->Finish();

  if (window.source_error) return *window.source_error;
  if (!read) return read.error();
  if (!status.ok()) return rpc_error(status, options.stop);
  return report;
}

HitSink copy_to(const HitColumns& hits) {
  return [&hits](std::uint64_t first, std::size_t, const HitView& answers) {
    copy_hits(answers, first, hits);
    return Status();
  };
}

}  // namespace

template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RaySource<Scalar>& source, RayShape shape, HitFields fields,
                               const HitSink& sink, const CastOptions& options) {
  return cast_messages(connection, scene, messages_of<v1::CastRaysRequest>(source, shape), fields,
                       sink, options);
}

Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, HitFields fields, const HitSink& sink,
                               const CastOptions& options) {
  const auto source = messages_of<v1::CastRaysRequest>(generator);
  if (!source) return source.error();
  return cast_messages(connection, scene, *source, fields, sink, options);
}

Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, const HitColumns& hits,
                               const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  if (const Status checked = check_rows(proto::rays::count_of(generator), hits); !checked)
    return checked.error();
  return cast_stream(connection, scene, generator, fields_of(hits), copy_to(hits), options);
}

template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayColumns<const Scalar>& rays, const HitColumns& hits,
                               const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const Status checked = check_rows(rays, hits); !checked) return checked.error();
  return cast_stream<Scalar>(connection, scene, source_of(rays), shape_of(rays), fields_of(hits),
                             copy_to(hits), options);
}

template <class Scalar>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const RayColumns<const Scalar>& rays, HitFields fields,
                         CastOptions options) {
  if (const Status checked = check_rows(rays, HitColumns{}); !checked) return checked.error();
  options.kind = QueryKind::kAll;
  AllHits all;
  const HitSink sink = [&](std::uint64_t, std::size_t, const HitView& answers) {
    all.append(answers);
    return Status();
  };
  const auto report = cast_stream<Scalar>(connection, scene, source_of(rays), shape_of(rays),
                                          fields, sink, options);
  if (!report) return report.error();
  all.report = *report;
  return all;
}

template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RaySource<float>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RaySource<double>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const float>&, const HitColumns&,
                                        const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const double>&, const HitColumns&,
                                        const CastOptions&);

template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const float>&, HitFields, CastOptions);
template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const double>&, HitFields, CastOptions);

}  // namespace sightline::client::calls
