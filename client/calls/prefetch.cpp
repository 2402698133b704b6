// A prefetch is one call that reports its progress. For rays there is one call for each message of
// them.
#include "client/calls/prefetch.h"

#include <fmt/format.h>

#include <utility>

#include "client/calls/callback_scope.h"
#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/message_source.h"
#include "client/calls/retries.h"
#include "client/wire/option_codec.h"

namespace sightline::client::calls {
namespace {

v1::PrefetchRequest describe(const std::string& scene, const PrefetchOptions& options) {
  v1::PrefetchRequest request;
  request.set_scene(scene);
  request.mutable_roots()->Assign(options.roots.begin(), options.roots.end());
  request.mutable_exclude()->Assign(options.exclude.begin(), options.exclude.end());
  wire::encode(options.only_labels, *request.mutable_only_labels());
  wire::encode(options.exclude_labels, *request.mutable_exclude_labels());
  request.set_kind(wire::encode(options.kind));
  return request;
}

// Adds a response to the report of the calls before it.
PrefetchReport sum(const PrefetchReport& before, const v1::PrefetchResponse& response) {
  PrefetchReport report;
  report.revision = response.served().revision();
  report.meshes_done = response.meshes_done();
  report.meshes_total = response.meshes_total();
  report.triangles_done = response.triangles_done();
  report.triangles_total = response.triangles_total();
  report.rays_done = before.rays_done + response.rays_done();
  report.cells_expanded = before.cells_expanded + response.cells_expanded();
  report.bytes_trees = response.bytes_trees();
  report.build_us = before.build_us + response.build_us();
  report.elapsed_us = before.elapsed_us + response.elapsed_us();
  return report;
}

Error no_last_report() {
  return {Code::kInternal, "the server ended a prefetch without its last report", {}};
}

// What is built stays: a call that is refused is repeated as it was.
Result<PrefetchReport> call(const Connection& connection, const v1::PrefetchRequest& request,
                            const PrefetchReport& before, const std::stop_token& stop,
                            const PrefetchProgress& progress, Retries& retries) {
  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  set_route(context, request.scene());
  const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
  const auto reader = connection.queries->Prefetch(&context, request);
  PrefetchReport report = before;
  bool done = false;
  v1::PrefetchResponse response;
  while (reader->Read(&response)) {
    report = sum(before, response);
    done = response.done();
    if (progress) progress(report);
  }
  const grpc::Status status = reader->Finish();
  if (!status.ok() && retries.wait(status, stop))
    return call(connection, request, before, stop, progress, retries);
  if (!status.ok()) return rpc_error(status, stop);
  if (!done) return no_last_report();
  return report;
}

// An asynchronous call: gRPC passes each response to it.
class PrefetchCall final : public AsyncOperation,
                           private grpc::ClientReadReactor<v1::PrefetchResponse> {
 public:
  using Done = std::function<void(Result<PrefetchReport>)>;

  PrefetchCall(const std::shared_ptr<const Connection>& connection, const std::string& scene,
               const PrefetchOptions& options, PrefetchProgress progress)
      : AsyncOperation(connection, connection->timeout, Repeat::kRefusals, {scene}, options.stop),
        request_(describe(scene, options)),
        progress_(std::move(progress)) {}

  void begin(Done done) {
    done_ = std::move(done);
    AsyncOperation::begin();
  }

 private:
  void start(grpc::ClientContext& context) override {
    under_way_ = shared_from_this();
    is_last_ = false;
    connection().queries->async()->Prefetch(&context, &request_, this);
    StartRead(&response_);
    StartCall();
  }

  void OnReadDone(bool ok) noexcept override {
    if (!ok) return;
    const CallbackScope scope;
    report_ = sum({}, response_);
    is_last_ = response_.done();
    if (progress_) progress_(report_);
    StartRead(&response_);
  }

  void OnDone(const grpc::Status& status) override {
    const CallbackScope scope;
    const auto kept = std::move(under_way_);
    ended(status);
  }

  void complete(const grpc::Status& status) override {
    const Done done = std::move(done_);
    if (!status.ok()) return done(rpc_error(status, stop()));
    done(is_last_ ? Result<PrefetchReport>(report_) : no_last_report());
  }

  const v1::PrefetchRequest request_;
  const PrefetchProgress progress_;
  v1::PrefetchResponse response_;
  PrefetchReport report_;
  bool is_last_ = false;
  std::shared_ptr<AsyncOperation> under_way_;  // this, until gRPC has done with it
  Done done_;
};

}  // namespace

Begin<PrefetchReport> async_prefetch(const std::shared_ptr<const Connection>& connection,
                                     const std::string& scene, const PrefetchOptions& options,
                                     PrefetchProgress progress) {
  const auto call = std::make_shared<PrefetchCall>(connection, scene, options, std::move(progress));
  return [call](PrefetchCall::Done done) { call->begin(std::move(done)); };
}

Result<PrefetchReport> prefetch(const Connection& connection, const std::string& scene,
                                const PrefetchOptions& options, const PrefetchProgress& progress) {
  Retries retries(deadline_after(connection.timeout));
  return call(connection, describe(scene, options), {}, options.stop, progress, retries);
}

namespace {

Result<PrefetchReport> prefetch_messages(const Connection& connection, const std::string& scene,
                                         const MessageSource<v1::PrefetchRequest>& source,
                                         const PrefetchOptions& options,
                                         const PrefetchProgress& progress) {
  v1::PrefetchRequest request = describe(scene, options);
  PrefetchReport report;
  for (bool first = true;; first = false) {
    const auto count = source(request);
    if (!count) return count.error();
    // One call is made even without rays, so that an unknown scene is still an error.
    if (*count == 0 && !first) return report;
    Retries retries(deadline_after(connection.timeout));
    auto grown = call(connection, request, report, options.stop, progress, retries);
    if (!grown || *count == 0) return grown;
    report = *std::move(grown);
  }
}

}  // namespace

template <class Columns>
Result<PrefetchReport> prefetch_rows(const Connection& connection, const std::string& scene,
                                     const RowSource<Columns>& source,
                                     typename Columns::Shape shape, const PrefetchOptions& options,
                                     const PrefetchProgress& progress) {
  return prefetch_messages(connection, scene, messages_of<v1::PrefetchRequest>(source, shape),
                           options, progress);
}

template <class Generator>
Result<PrefetchReport> prefetch_made(const Connection& connection, const std::string& scene,
                                     const Generator& generator, const PrefetchOptions& options,
                                     const PrefetchProgress& progress) {
  const auto source = messages_of<v1::PrefetchRequest>(generator);
  if (!source) return source.error();
  return prefetch_messages(connection, scene, *source, options, progress);
}

template <class Rows>
Result<PrefetchReport> prefetch_columns(const Connection& connection, const std::string& scene,
                                        const Rows& rows, const PrefetchOptions& options,
                                        const PrefetchProgress& progress) {
  if (const Status checked = check_rows(rows, HitColumns{}); !checked) return checked.error();
  return prefetch_rows(connection, scene, source_of(rows), shape_of(rows), options, progress);
}

template Result<PrefetchReport> prefetch_rows(const Connection&, const std::string&,
                                              const RaySource<float>&, RayShape,
                                              const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_rows(const Connection&, const std::string&,
                                              const RaySource<double>&, RayShape,
                                              const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_rows(const Connection&, const std::string&,
                                              const PointSource<float>&, PointShape,
                                              const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_rows(const Connection&, const std::string&,
                                              const PointSource<double>&, PointShape,
                                              const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_columns(const Connection&, const std::string&,
                                                 const RayColumns<const float>&,
                                                 const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_columns(const Connection&, const std::string&,
                                                 const RayColumns<const double>&,
                                                 const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_columns(const Connection&, const std::string&,
                                                 const PointColumns<const float>&,
                                                 const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_columns(const Connection&, const std::string&,
                                                 const PointColumns<const double>&,
                                                 const PrefetchOptions&, const PrefetchProgress&);
template Result<PrefetchReport> prefetch_made(const Connection&, const std::string&,
                                              const RayGenerator&, const PrefetchOptions&,
                                              const PrefetchProgress&);
template Result<PrefetchReport> prefetch_made(const Connection&, const std::string&,
                                              const PointGrid&, const PrefetchOptions&,
                                              const PrefetchProgress&);

}  // namespace sightline::client::calls
