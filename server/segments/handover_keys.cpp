// The keys by which clients get the descriptors of segments.
#include "server/segments/handover_keys.h"

#include <openssl/crypto.h>

#include <utility>

#include "server/segments/random_bytes.h"

namespace sightline::server::segments {

HandoverKeys::Key HandoverKeys::add(const std::shared_ptr<const Segment>& segment,
                                    Clock::time_point now) {
  Key key{};
  fill_at_random(key);
  const std::lock_guard lock(mutex_);
  forget_late(now);
  entries_.push_back({key, segment, now + kGoodFor});
  return key;
}

std::shared_ptr<const Segment> HandoverKeys::take(std::span<const std::uint8_t, kBytes> key,
                                                  Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  forget_late(now);
  auto found = entries_.end();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (CRYPTO_memcmp(entry->key.data(), key.data(), kBytes) == 0) found = entry;
  }
  if (found == entries_.end()) return nullptr;
  auto segment = found->segment.lock();
  entries_.erase(found);
  return segment;
}

std::size_t HandoverKeys::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

/// Call it with the mutex held.
void HandoverKeys::forget_late(Clock::time_point now) {
  std::erase_if(entries_, [now](const Entry& entry) {
    return entry.until <= now || entry.segment.expired();
  });
}

}  // namespace sightline::server::segments
