// Reads a scene's log as messages of limited size.
#include "server/updates/watch_cursor.h"

#include "server/updates/update_codec.h"

namespace sightline::server::updates {

Status WatchCursor::next(v1::WatchSceneResponse& out) {
  out.Clear();
  if (updates_ == nullptr) {
    auto found = scene_.log().find(reached_ + 1);
    if (!found) return found.error();
    updates_ = std::move(*found);
    update_ = row_ = 0;
  }
  encode_revision(scene_.token(reached_ + 1), *out.mutable_revision());
  std::size_t bytes = 0;
  while (update_ < updates_->size() && bytes < kWatchMessageBytes) {
    v1::Update& update = *out.add_updates();
    row_ = encode_update((*updates_)[update_], row_, kWatchMessageBytes - bytes, update);
    bytes += update.ByteSizeLong();
    if (row_ == 0) ++update_;
  }
  out.set_more(update_ < updates_->size());
  if (out.more()) return {};
  updates_.reset();
  ++reached_;
  return {};
}

void WatchCursor::progress(v1::WatchSceneResponse& out) const {
  out.Clear();
  encode_revision(scene_.token(reached_), *out.mutable_revision());
  out.set_progress(true);
}

}  // namespace sightline::server::updates
