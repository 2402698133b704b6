// Asks the peers, and adds up what they report.
#include "server/shards/sharded_prefetch.h"

#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/client_callback.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "server/shards/peer_errors.h"

namespace sightline::server::shards {

/// The call to one peer.
class ShardedPrefetch::Call final : public grpc::ClientReadReactor<v1::PrefetchResponse> {
 public:
  Call(ShardedPrefetch& all, const v1::PrefetchRequest& asked, std::uint32_t shard)
      : all_(all), shard_(shard), context_(Peers::context_for(all.caller_)), request_(asked) {
    request_.mutable_shard()->set_index(shard);
    request_.mutable_shard()->set_count(all.peers_.size());
  }

  void start() {
    Peer& peer = all_.peers_.peer(shard_);
    const auto stub = peer.begin(context_);
    if (stub == nullptr) return end(peer.lost_status());
    try {
      stub->async()->Prefetch(context_.get(), &request_, this);
    } catch (const std::exception& thrown) {
      return end(peer.end(context_, {grpc::StatusCode::RESOURCE_EXHAUSTED, thrown.what()}));
    }
    StartRead(&read_);
    StartCall();
  }

  void OnReadDone(bool read) override {
    if (!read) return;
    {
      const std::lock_guard lock(all_.mutex_);
      reported_ = read_;
    }
    StartRead(&read_);
  }

  void OnDone(const grpc::Status& status) override {
    end(all_.peers_.peer(shard_).end(context_, status));
  }

  void cancel() { context_->TryCancel(); }
  std::uint32_t shard() const { return shard_; }
  const grpc::Status& status() const { return status_; }
  /// Call it under the mutex.
  const std::optional<v1::PrefetchResponse>& reported() const { return reported_; }

 private:
  /// Ends this call, and all others if it failed: what they build is not needed without this shard.
  void end(grpc::Status status) {
    status_ = std::move(status);
    if (!status_.ok()) all_.cancel();
    all_.end_one();  // this may be gone
  }

  ShardedPrefetch& all_;
  const std::uint32_t shard_;
  const Peer::Context context_;
  v1::PrefetchRequest request_;
  v1::PrefetchResponse read_;
  std::optional<v1::PrefetchResponse> reported_;
  grpc::Status status_;
};

ShardedPrefetch::ShardedPrefetch(const Peers& peers, const grpc::CallbackServerContext& caller)
    : peers_(peers), caller_(caller) {}

ShardedPrefetch::~ShardedPrefetch() = default;

void ShardedPrefetch::start(const v1::PrefetchRequest& asked, std::function<void()> ended) {
  std::vector<std::unique_ptr<Call>> calls;
  for (std::uint32_t shard = 0; shard < peers_.size(); ++shard)
    calls.push_back(std::make_unique<Call>(*this, asked, shard));
  ended_ = std::move(ended);
  open_.store(calls.size() + 1);
  bool cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    calls_ = std::move(calls);
    cancelled = cancelled_;
  }
  if (cancelled) cancel();
  for (const auto& call : calls_) call->start();
  end_one();
}

void ShardedPrefetch::end_one() {
  if (open_.fetch_sub(1) > 1) return;
  const std::function<void()> ended = std::move(ended_);
  ended();
}

Status ShardedPrefetch::take() const {
  const Call& worst = **std::min_element(
      calls_.begin(), calls_.end(),
      [](const auto& a, const auto& b) { return rank_of(a->status()) < rank_of(b->status()); });
  if (worst.status().ok()) return {};
  if (!means_lost(worst.status())) return error_of_peer(peers_, worst.shard(), worst.status());
  return lost_shard(peers_, worst.shard(),
                    fmt::format("build trees: {}", worst.status().error_message()));
}

void ShardedPrefetch::cancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    if (calls_.empty()) return;  // start() cancels them
  }
  // The mutex is not held: calls that end may say so in this thread.
  for (const auto& call : calls_) call->cancel();
}

void ShardedPrefetch::report(v1::PrefetchResponse& response) const {
  const std::lock_guard lock(mutex_);
  const auto has_reported = [](const auto& call) { return call->reported().has_value(); };
  if (calls_.empty() || !std::all_of(calls_.begin(), calls_.end(), has_reported)) return;
  v1::PrefetchResponse sum;
  for (const auto& call : calls_) {
    const v1::PrefetchResponse& of_peer = *call->reported();
    if (call == calls_.front() || of_peer.served().revision() < sum.served().revision())
      *sum.mutable_served() = of_peer.served();
    sum.set_meshes_done(sum.meshes_done() + of_peer.meshes_done());
    sum.set_meshes_total(sum.meshes_total() + of_peer.meshes_total());
    sum.set_triangles_done(sum.triangles_done() + of_peer.triangles_done());
    sum.set_triangles_total(sum.triangles_total() + of_peer.triangles_total());
    sum.set_cells_expanded(sum.cells_expanded() + of_peer.cells_expanded());
    sum.set_bytes_trees(sum.bytes_trees() + of_peer.bytes_trees());
    sum.set_build_us(sum.build_us() + of_peer.build_us());
  }
  response = std::move(sum);
}

}  // namespace sightline::server::shards
