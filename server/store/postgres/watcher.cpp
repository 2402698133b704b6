// Hears which scenes other processes have changed.
#include "server/store/postgres/watcher.h"

#include <spdlog/spdlog.h>

#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include "server/exec/rpc_status.h"
#include "server/store/postgres/write_engine.h"

namespace sightline::server::store::postgres {
namespace {

/// Ids parted by blanks. Nothing: all scenes.
std::vector<SceneId> parse_ids(const std::string& text) {
  std::vector<SceneId> ids;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    SceneId id = 0;
    const auto [next, error] = std::from_chars(at, end, id);
    if (error != std::errc{}) return {};
    ids.push_back(id);
    at = next == end ? end : next + 1;
  }
  return ids;
}

}  // namespace

Watcher::Watcher(const Address& address, std::function<int()> own, Store::Changed changed)
    : address_(address), own_(std::move(own)), changed_(std::move(changed)) {
  thread_ = std::thread([this] { loop(); });
}

Watcher::~Watcher() {
  ending_ = true;
  thread_.join();
}

void Watcher::loop() {
  bool said = false;
  while (!ending_) {
    bool connected = false;
    const Status lost = exec::to_status([&] { return follow(connected); });
    if (ending_) return;
    if (connected) said = false;
    if (!lost && !std::exchange(said, true))
      spdlog::warn("event=store_notices_lost error={}", lost.error().message);
    std::this_thread::sleep_for(kWatchEvery);
  }
}

/// Returns when the connection is lost, or the object ends.
Status Watcher::follow(bool& connected) {
  auto connection = Connection::open(address_);
  if (!connection) return connection.error();
  const std::string listen = std::string("LISTEN ") + kChannel;
  if (Status listens = (*connection)->run(listen.c_str()); !listens) return listens;
  connected = true;
  using Clock = std::chrono::steady_clock;
  changed_({});  // what has changed meanwhile is not known
  Clock::time_point all_changed = Clock::now();
  while (!ending_) {
    const auto notices = (*connection)->wait(static_cast<int>(kWatchEvery.count()));
    if (!notices) return notices.error();
    // This happens also where notices never end.
    if (notices->empty() || Clock::now() - all_changed >= kWatchEvery) {
      changed_({});
      all_changed = Clock::now();
    } else {
      report(*notices);
    }
  }
  return {};
}

void Watcher::report(std::span<const Connection::Notice> notices) {
  const int own = own_();
  std::vector<SceneId> scenes;
  for (const Connection::Notice& notice : notices) {
    if (notice.backend == own) continue;
    const auto ids = parse_ids(notice.text);
    if (ids.empty()) return changed_({});
    scenes.insert(scenes.end(), ids.begin(), ids.end());
  }
  if (!scenes.empty()) changed_(scenes);
}

}  // namespace sightline::server::store::postgres
