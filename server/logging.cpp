// The server's log: lines on stderr, written by a thread of their own.
#include "server/logging.h"

#include <fmt/format.h>
#include <grpc/support/log.h>
#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <string>

#include "proto/printable.h"
#include "server/log_tail.h"

namespace sightline::server {
namespace {

/// Says before a line how many lines were dropped since the last one.
class Sink final : public spdlog::sinks::stderr_sink_st {
 public:
  /// `writer`: the pool whose thread calls log(). It outlives its thread.
  explicit Sink(spdlog::details::thread_pool& writer) : writer_(writer) {}

  void log(const spdlog::details::log_msg& message) override {
    // Not spdlog::thread_pool(): spdlog::shutdown() holds its lock until the last line is written.
    const std::size_t dropped = writer_.overrun_counter();
    if (dropped != reported_) {
      const std::string text = fmt::format("event=log_dropped lines={}", dropped - reported_);
      reported_ = dropped;
      spdlog::sinks::stderr_sink_st::log(
          {message.time, {}, message.logger_name, spdlog::level::warn, text});
    }
    const std::string text = one_line({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg shown = message;
    shown.payload = text;
    spdlog::sinks::stderr_sink_st::log(shown);
    spdlog::memory_buf_t line;
    formatter_->format(shown, line);
    log_tail().add({line.data(), line.size()});
  }

 private:
  spdlog::details::thread_pool& writer_;
  std::size_t reported_ = 0;
};

void log_grpc(gpr_log_func_args* args) {
  const auto level = args->severity == GPR_LOG_SEVERITY_ERROR  ? spdlog::level::warn
                     : args->severity == GPR_LOG_SEVERITY_INFO ? spdlog::level::debug
                                                               : spdlog::level::trace;
  spdlog::log(level, "event=grpc {}", args->message);
}

}  // namespace

void start_logging(spdlog::level::level_enum level) {
  spdlog::init_thread_pool(kLogQueue, 1);
  const auto writer = spdlog::thread_pool();
  spdlog::set_default_logger(
      std::make_shared<spdlog::async_logger>("sightlined", std::make_shared<Sink>(*writer), writer,
                                             spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_pattern("time=%Y-%m-%dT%H:%M:%S.%e%z level=%l %v");
  spdlog::set_level(level);
  gpr_set_log_function(log_grpc);
}

}  // namespace sightline::server
