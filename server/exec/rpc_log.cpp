// One log line per call, at level debug.
#include "server/exec/rpc_log.h"

#include <spdlog/spdlog.h>

#include "server/exec/quote.h"

namespace sightline::server::exec {

void log_rpc(std::string_view method, const grpc::Status& status, LogClock::time_point begun,
             std::string_view more) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  const auto us =
      std::chrono::duration_cast<std::chrono::microseconds>(LogClock::now() - begun).count();
  const auto code = static_cast<int>(status.error_code());
  if (status.ok()) {
    spdlog::debug("event=rpc method={} code={} us={} {}", method, code, us, more);
  } else {
    spdlog::debug("event=rpc method={} code={} us={} error={} {}", method, code, us,
                  quote(status.error_message()), more);
  }
}

}  // namespace sightline::server::exec
