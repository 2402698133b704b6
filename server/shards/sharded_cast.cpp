// Asks the peers, and waits for no answer.
#include "server/shards/sharded_cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "server/shards/peer_errors.h"
#include "server/shards/shard_messages.h"

namespace sightline::server::shards {

using scenegraph::QueryKind;

ShardedCast::ShardedCast(const Peers& peers, const grpc::CallbackServerContext& caller,
                         const v1::CastRaysRequest& asked, const Query& query)
    : peers_(peers),
      caller_(caller),
      query_(query),
      template_(make_template(asked, query.kind, query.surface)) {}

void ShardedCast::begin(Batch batch) {
  batch_ = std::move(batch);
  cost_ = {};
  merge_.begin(*batch_.cut, query_.kind, batch_.rays, query_.max_hits);
}

bool ShardedCast::ask(std::function<void()> answered) {
  std::vector<scenegraph::query::ShardQuestion> questions = merge_.next();
  calls_.clear();
  if (questions.empty()) return false;
  calls_.resize(questions.size());
  for (std::size_t i = 0; i < calls_.size(); ++i) {
    Call& call = calls_[i];
    call.question = std::move(questions[i]);
    call.context = Peers::context_for(caller_);
    call.request = template_;
    call.request.mutable_consistency()->set_exact_revision(batch_.revision);
    v1::Shard& shard = *call.request.mutable_shard();
    shard.set_index(call.question.shard);
    shard.set_count(batch_.cut->size());
    shard.set_cut(batch_.cut->fingerprint());
    call.request.set_time_budget_ms(budget_ms());
    set_rays(merge_, call.question, call.request);
  }
  answered_ = std::move(answered);
  open_.store(calls_.size() + 1);
  for (Call& call : calls_) start(call);
  end_one();
  return true;
}

/// 0: none. One that has passed is asked for as the shortest.
std::uint32_t ShardedCast::budget_ms() const {
  if (!batch_.budget_ends) return 0;
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(*batch_.budget_ends - Clock::now());
  return static_cast<std::uint32_t>(std::max<std::int64_t>(left.count(), 1));
}

void ShardedCast::start(Call& call) {
  try {
    peers_.stub(call.question.shard)
        .async()
        ->CastRays(call.context.get(), &call.request, &call.reply,
                   [this, &call](grpc::Status status) {
                     call.status = std::move(status);
                     // The batch fails: what others compute for it is not needed.
                     if (!call.status.ok() && !query_.allow_partial) {
                       for (Call& other : calls_) other.context->TryCancel();
                     }
                     end_one();
                   });
  } catch (const std::exception& thrown) {
    call.status = {grpc::StatusCode::RESOURCE_EXHAUSTED, thrown.what()};
    end_one();
  }
}

void ShardedCast::end_one() {
  if (open_.fetch_sub(1) > 1) return;
  const std::function<void()> answered = std::move(answered_);
  answered();
}

/// Whether the peer is gone, or has another revision.
bool ShardedCast::may_be_lost(const Call& call) const {
  return call.status.ok() ? call.reply.served().token() != batch_.token : means_lost(call.status);
}

Error ShardedCast::lost(const Call& call) const {
  const std::string why =
      call.status.ok() ? "it has another scene of this name" : call.status.error_message();
  return lost_shard(peers_, call.question.shard,
                    fmt::format("answer at revision {}: {}", batch_.revision, why));
}

Status ShardedCast::take() {
  std::stable_sort(calls_.begin(), calls_.end(), [](const Call& a, const Call& b) {
    return rank_of(a.status) < rank_of(b.status);
  });
  for (const Call& call : calls_) {
    if (Status taken = take(call); !taken) return taken;
  }
  return {};
}

Status ShardedCast::take(const Call& call) {
  if (may_be_lost(call)) {
    if (!query_.allow_partial) return lost(call);
    merge_.lose(call.question);
    return {};
  }
  if (!call.status.ok()) return error_of_peer(peers_, call.question.shard, call.status);
  const auto answer = decode(call.reply, query_.kind, call.question.rays.size());
  if (!answer) return answer.error();
  cost_ += decode_cost(call.reply.stats());
  if (query_.kind == QueryKind::kClosest || query_.kind == QueryKind::kAny) {
    merge_.take(call.question, answer->hits);
  } else {
    merge_.take(call.question, answer->tallies, answer->hits);
  }
  return {};
}

scenegraph::TraceStats ShardedCast::stats() const {
  scenegraph::TraceStats stats = merge_.stats();
  stats += cost_;
  return stats;
}

}  // namespace sightline::server::shards
