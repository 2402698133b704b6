// A producer that streams batches to a server that is killed.
#include "tests/durability/producer.h"

#include <grpcpp/client_context.h>

#include <chrono>
#include <thread>

#include "tests/server/updates/update_stream.h"

namespace sightline::tests::durability {
namespace {

constexpr std::size_t kWindow = 16;
/// Revisions that a watch may be behind: less than a server keeps across its end.
constexpr std::uint64_t kLead = 16;
constexpr std::uint64_t kNoNode = std::uint64_t{1} << 60;

scenegraph::model::Affine at(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

}  // namespace

Producer::Producer(int number, const Options& options, Findings& findings)
    : name_(fmt::format("producer-{}", number)),
      options_(options),
      findings_(findings),
      random_(static_cast<std::uint64_t>(number)) {}

void Producer::run(Api& api) {
  grpc::ClientContext context;
  const auto call = api.scenes->StreamUpdates(&context);
  broken_ = false;
  if (open(*call)) {
    std::thread writing([&] { write(*call); });
    v1::StreamUpdatesResponse answer;
    while (call->Read(&answer)) receive(answer);
    {
      const std::lock_guard lock(mutex_);
      broken_ = true;
    }
    writing.join();
  }
  const grpc::Status ended = call->Finish();
  if (ended.error_code() != grpc::StatusCode::UNAVAILABLE)
    findings_.add(findings_.other, name_ + ": " + ended.error_message());
}

bool Producer::open(Call& call) {
  v1::StreamUpdatesRequest request;
  request.mutable_open()->set_scene(kScene);
  request.mutable_open()->set_producer(name_);
  request.mutable_open()->set_durability(options_.relaxed ? v1::DURABILITY_RELAXED
                                                          : v1::DURABILITY_COMMITTED);
  v1::StreamUpdatesResponse answer;
  if (!call.Write(request) || !call.Read(&answer)) return false;
  begin_after(answer.opened());
  return true;
}

void Producer::begin_after(const v1::ProducerOpened& opened) {
  committed_ = opened.last_committed();
  if (committed_ > made_)
    findings_.add(findings_.other, fmt::format("{} has sent {} batches, the server has {}", name_,
                                               made_, committed_));
  if (committed_ < acknowledged_ && !options_.relaxed) {
    findings_.add(findings_.lost, fmt::format("{} had batch {} acknowledged, the server has {}",
                                              name_, acknowledged_, committed_));
  }
  if (committed_ < acknowledged_) forget_after(committed_);
  for (const v1::PutNodes& put : opened.put()) learn(put);
  // The last one that was committed is sent again and must change nothing.
  sent_ = committed_ > 0 && !unanswered_.empty() && unanswered_.front().sequence <= committed_
              ? committed_ - 1
              : committed_;
}

/// What was made on top of lost batches may name nodes that are gone: other batches get its
/// numbers.
void Producer::forget_after(std::uint64_t sequence) {
  const auto is_lost = [&](const PutNode& node) { return node.sequence > sequence; };
  forgotten_ += acknowledged_ - sequence;
  std::erase_if(counters_, is_lost);
  std::erase_if(nodes_, is_lost);
  unanswered_.clear();
  bad_.erase(bad_.upper_bound(sequence), bad_.end());
  made_ = acknowledged_ = learned_ = sequence;
  revision_ = 0;
}

void Producer::write(Call& call) {
  for (;;) {
    v1::StreamUpdatesRequest request;
    {
      const std::lock_guard lock(mutex_);
      if (broken_) return;
      if (sent_ < made_) {
        const Batch& batch = unanswered_[sent_ + 1 - unanswered_.front().sequence];
        request.mutable_batch()->set_sequence(batch.sequence);
        request.mutable_batch()->mutable_updates()->Assign(batch.updates.begin(),
                                                           batch.updates.end());
        ++sent_;
      } else if (may_make()) {
        unanswered_.push_back(make());
      }
    }
    if (!request.has_batch()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } else if (!call.Write(request)) {
      return;
    }
  }
}

bool Producer::may_make() const {
  if (made_ == 0) return true;
  return !counters_.empty() && unanswered_.size() < kWindow && revision_ <= options_.seen + kLead;
}

void Producer::receive(const v1::StreamUpdatesResponse& answer) {
  const std::lock_guard lock(mutex_);
  if (answer.has_ack()) {
    for (const v1::PutNodes& put : answer.ack().put()) learn(put);
    revision_ = answer.ack().revision().revision();
    answered(answer.ack().up_to_sequence());
    return;
  }
  const std::uint64_t sequence = answer.reject().sequence();
  if (!bad_.contains(sequence))
    findings_.add(findings_.other, fmt::format("{}: batch {} is rejected: {}", name_, sequence,
                                               answer.reject().message()));
  answered(sequence);
}

void Producer::answered(std::uint64_t up_to) {
  acknowledged_ = std::max(acknowledged_, up_to);
  while (!unanswered_.empty() && unanswered_.front().sequence <= up_to) unanswered_.pop_front();
}

/// The server tells at each opening what the last batches have put.
void Producer::learn(const v1::PutNodes& put) {
  if (put.sequence() <= learned_) return;
  learned_ = put.sequence();
  std::vector<PutNode>& known = put.sequence() == 1 ? counters_ : nodes_;
  for (const std::uint64_t id : put.nodes()) known.push_back({put.sequence(), id});
}

Producer::Batch Producer::make() {
  Batch batch{++made_, {}};
  if (counters_.empty()) {
    for (const std::int64_t alias : {-1, -2}) {
      v1::Update counter = put_node(alias, {}, 0, at(1, 0, 0));
      counter.mutable_put_node()->set_name(fmt::format("{} counter {}", name_, -alias));
      batch.updates.push_back(counter);
    }
    return batch;
  }
  const auto value = static_cast<double>(batch.sequence);
  batch.updates.push_back(move_to(counters_[0].id, value));
  for (std::uint64_t changes = 1 + random_.below(3); changes > 0; --changes)
    add_change(batch.updates);
  if (random_.below(20) == 0) {
    bad_.insert(batch.sequence);
    batch.updates.push_back(move_to(kNoNode, 0));
  }
  batch.updates.push_back(move_to(counters_[1].id, value));
  return batch;
}

void Producer::add_change(std::vector<v1::Update>& updates) {
  const std::size_t kinds = nodes_.size() > 40 ? 4 : 3;
  const auto any = [this] { return nodes_[random_.below(nodes_.size())].id; };
  const std::size_t kind = nodes_.empty() ? 0 : random_.below(kinds);
  if (kind == 0) {
    const auto alias = -1 - static_cast<std::int64_t>(updates.size());
    updates.push_back(
        put_node(alias, options_.digests[random_.below(options_.digests.size())], 0,
                 at(random_.uniform(-5, 5), random_.uniform(-5, 5), random_.uniform(-5, 5))));
  } else if (kind == 1) {
    updates.push_back(move_to(any(), random_.uniform(-5, 5)));
  } else if (kind == 2) {
    const auto z = static_cast<float>(random_.uniform(-1, 1));
    updates.push_back(patch({any()}, 0, {{-1, -1, z}, {1, -1, z}}));
  } else {
    // Several batches may be on their way: a node is not used again after this one.
    const std::size_t index = random_.below(nodes_.size());
    v1::Update removal;
    removal.mutable_delete_node()->set_node(static_cast<std::int64_t>(nodes_[index].id));
    nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(index));
    updates.push_back(removal);
  }
}

}  // namespace sightline::tests::durability
