// Asks the peers, and waits for no answer.
#include "server/shards/sharded_cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "server/shards/peer_errors.h"
#include "server/shards/shard_messages.h"

namespace sightline::server::shards {

using accel::geometry::Ray;
using scenegraph::QueryKind;
using scenegraph::query::ShardQuestion;

namespace {

using Clock = ShardedCast::Clock;
using std::chrono::milliseconds;

/// An eighth of a time is kept for what follows it, up to this.
constexpr milliseconds kMostForReply{50}, kMostForPeer{20};

Clock::duration less_reserve(Clock::duration left, milliseconds most) {
  return left - std::clamp<Clock::duration>(left / 8, Clock::duration::zero(), most);
}

/// When a caller with a deadline gets what there is; nothing if that is not soon.
std::optional<Clock::time_point> before_deadline(const grpc::CallbackServerContext& caller) {
  const auto left = caller.deadline() - std::chrono::system_clock::now();
  if (left > std::chrono::hours(1)) return {};
  return Clock::now() + less_reserve(left, kMostForReply);
}

void make_earlier(std::optional<Clock::time_point>& at, Clock::time_point other) {
  at = at ? std::min(*at, other) : other;
}

}  // namespace

std::size_t sharded_side_bytes(std::size_t points, const scenegraph::SideQuestion& question,
                               std::size_t shards) {
  // A point without its limit, its side and votes.
  constexpr std::size_t kPoint = sizeof(Ray) + 2;
  // In a question: its index, coordinates, limit and mask; in the answer: its side, twice.
  constexpr std::size_t kAsked = 4 + 3 * sizeof(double) + sizeof(double) + 4 + 2;
  const std::size_t at_a_time = std::min(points, scenegraph::query::kMaxCrossings / question.rays);
  const std::size_t crossings = at_a_time * question.rays * sizeof(std::uint32_t);
  // A message is there twice while it is parsed; one is decoded at a time.
  return points * kPoint + shards * (at_a_time * kAsked + 2 * crossings) + 2 * crossings;
}

ShardedCast::ShardedCast(const Peers& peers, const grpc::CallbackServerContext& caller,
                         const v1::CastRaysRequest& asked, const Query& query)
    : peers_(peers),
      caller_(caller),
      query_(query),
      template_(RayMessages{make_template(asked, query.kind, query.surface), {}}) {}

ShardedCast::ShardedCast(const Peers& peers, const grpc::CallbackServerContext& caller,
                         const v1::QueryPointsRequest& asked, const Query& query)
    : peers_(peers),
      caller_(caller),
      query_(query),
      template_(PointMessages{make_template(asked, query.kind, query.surface), {}}),
      side_template_(query.sides ? PointMessages{make_side_template(asked, *query.sides), {}}
                                 : PointMessages()) {}

const v1::SceneRevision& ShardedCast::Call::served() const {
  return std::visit([](const auto& of) -> auto& { return of.reply.served(); }, messages);
}
const HitColumns& ShardedCast::Call::columns() const {
  return std::visit([](const auto& of) -> auto& { return of.reply.columns(); }, messages);
}
const v1::CastStats& ShardedCast::Call::stats() const {
  return std::visit([](const auto& of) -> auto& { return of.reply.stats(); }, messages);
}

void ShardedCast::begin(Batch batch) {
  batch_ = std::move(batch);
  cost_ = {};
  at_sides_ = false;
  std::span<const Ray> rays = batch_.rays;
  if (by_normal()) {
    unlimited_.assign(rays.begin(), rays.end());
    for (Ray& point : unlimited_) {
      if (!std::isnan(point.tmax)) point.tmax = accel::geometry::kInfinity;
    }
    rays = unlimited_;
  } else if (query_.sides_alone) {
    rays = {};
  }
  merge_.begin(*batch_.cut, query_.kind, rays, query_.max_hits,
               std::holds_alternative<PointMessages>(template_));
  ask_until_ = batch_.budget_ends;
  wait_until_.reset();
  if (batch_.budget_ends) wait_until_ = *batch_.budget_ends + kAfterBudget;
  if (!query_.allow_partial) return;
  if (const auto latest = before_deadline(caller_)) {
    make_earlier(ask_until_, *latest);
    make_earlier(wait_until_, *latest);
  }
}

bool ShardedCast::by_normal() const {
  return query_.sides && query_.sides->rule == scenegraph::SideRule::kNormal;
}

/// The questions for hits or nearest faces, then those for sides.
std::vector<ShardQuestion> ShardedCast::next() {
  if (!at_sides_) {
    std::vector<ShardQuestion> questions = merge_.next();
    if (!questions.empty() || !query_.sides) return questions;
    at_sides_ = true;
    sides_.begin(*batch_.cut, *query_.sides, batch_.rays, merge_.hits());
  }
  return sides_.next();
}

/// Questions for which no time is left have no answer.
std::vector<ShardQuestion> ShardedCast::next_in_time() {
  for (;;) {
    std::vector<ShardQuestion> questions = next();
    if (questions.empty() || !ask_until_ || Clock::now() < *ask_until_) return questions;
    for (const ShardQuestion& question : questions) lose(question);
  }
}

void ShardedCast::lose(const ShardQuestion& question) {
  if (at_sides_) {
    sides_.lose(question);
  } else {
    merge_.lose(question);
  }
}

bool ShardedCast::ask(std::function<void()> answered) {
  std::vector<ShardQuestion> questions = next_in_time();
  calls_.clear();
  if (questions.empty()) return false;
  calls_.resize(questions.size());
  for (std::size_t i = 0; i < calls_.size(); ++i) {
    Call& call = calls_[i];
    call.question = std::move(questions[i]);
    call.context = Peers::context_for(caller_);
    if (wait_until_)
      call.context->set_deadline(std::chrono::system_clock::now() +
                                 std::chrono::ceil<milliseconds>(*wait_until_ - Clock::now()));
    call.messages = at_sides_ ? side_template_ : template_;
    std::visit([&](auto& of) { set_question(call.question, of.request); }, call.messages);
  }
  answered_ = std::move(answered);
  open_.store(calls_.size() + 1);
  for (Call& call : calls_) start(call);
  end_one();
  return true;
}

template <class Request>
void ShardedCast::set_question(const ShardQuestion& question, Request& request) const {
  request.mutable_consistency()->set_exact_revision(batch_.revision);
  v1::Shard& shard = *request.mutable_shard();
  shard.set_index(question.shard);
  shard.set_count(batch_.cut->size());
  shard.set_cut(batch_.cut->fingerprint());
  request.set_time_budget_ms(budget_ms());
  const auto ray_of = [this](std::uint32_t ray) {
    return at_sides_ ? batch_.rays[ray] : merge_.limited(ray);
  };
  set_rays(ray_of, question, request);
}

/// The time budget of a peer; 0: none. If it has passed, the shortest one is asked for.
std::uint32_t ShardedCast::budget_ms() const {
  if (!batch_.budget_ends) return 0;
  const auto left = less_reserve(*batch_.budget_ends - Clock::now(), kMostForPeer);
  const auto rounded = std::chrono::duration_cast<milliseconds>(left).count();
  return static_cast<std::uint32_t>(std::max<std::int64_t>(rounded, 1));
}

void ShardedCast::start(Call& call) {
  Peer& peer = peers_.peer(call.question.shard);
  const auto stub = peer.begin(call.context);
  if (stub == nullptr) {
    call.status = peer.lost_status();
    return end(call);
  }
  try {
    const auto ended = [this, &call, &peer](grpc::Status status) {
      call.status = peer.end(call.context, std::move(status));
      end(call);
    };
    if (auto* const rays = std::get_if<RayMessages>(&call.messages)) {
      stub->async()->CastRays(call.context.get(), &rays->request, &rays->reply, ended);
    } else {
      auto& points = std::get<PointMessages>(call.messages);
      stub->async()->QueryPoints(call.context.get(), &points.request, &points.reply, ended);
    }
  } catch (const std::exception& thrown) {
    call.status = peer.end(call.context, {grpc::StatusCode::RESOURCE_EXHAUSTED, thrown.what()});
    end(call);
  }
}

void ShardedCast::end(Call& call) {
  // The other side may be the first to notice.
  const bool timed_out = call.status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED ||
                         call.status.error_code() == grpc::StatusCode::CANCELLED;
  call.late = timed_out && batch_.budget_ends && Clock::now() >= *batch_.budget_ends &&
              peers_.peer(call.question.shard).unanswered() <= 1;
  // The batch fails: what others compute for it is not needed.
  if (!call.status.ok() && !call.late && !query_.allow_partial) {
    for (const Call& other : calls_) other.context->TryCancel();
  }
  end_one();
}

void ShardedCast::end_one() {
  if (open_.fetch_sub(1) > 1) return;
  const std::function<void()> answered = std::move(answered_);
  answered();
}

/// Whether the peer is gone, or has another revision.
bool ShardedCast::may_be_lost(const Call& call) const {
  return call.status.ok() ? call.served().token() != batch_.token : means_lost(call.status);
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
  if (call.late || may_be_lost(call)) {
    if (!call.late && !query_.allow_partial) return lost(call);
    lose(call.question);
    return {};
  }
  if (!call.status.ok()) return error_of_peer(peers_, call.question.shard, call.status);
  Status taken = at_sides_ ? take_sides(call) : take_hits(call);
  if (taken) cost_ += decode_cost(call.stats());
  return taken;
}

Status ShardedCast::take_hits(const Call& call) {
  const auto answer = decode(call.columns(), query_.kind, call.question.rays.size());
  if (!answer) return answer.error();
  if (query_.kind == QueryKind::kClosest || query_.kind == QueryKind::kAny) {
    merge_.take(call.question, answer->hits);
  } else {
    merge_.take(call.question, answer->tallies, answer->hits);
  }
  return {};
}

Status ShardedCast::take_sides(const Call& call) {
  const auto answer = decode_sides(call.columns(), *query_.sides, call.question.rays.size());
  if (!answer) return answer.error();
  sides_.take(call.question, answer->sides, answer->crossings);
  return {};
}

scenegraph::TraceStats ShardedCast::stats() const {
  scenegraph::TraceStats stats = merge_.stats();
  stats += cost_;
  return stats;
}

void ShardedCast::rest() {
  merge_ = {};
  sides_ = {};
  unlimited_ = {};
  calls_ = {};
}

}  // namespace sightline::server::shards
