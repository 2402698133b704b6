// The batches of an UpdateStream that are not answered, and the thread that sends them. Internal to
// the library.
#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "client/calls/connection.h"
#include "client/calls/retries.h"
#include "client/result.h"
#include "client/update.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

class UpdateStreamWorker {
 public:
  using Messages = std::vector<v1::StreamUpdatesRequest>;

  UpdateStreamWorker(std::unique_ptr<v1::SceneService::Stub> stub, const std::string& scene,
                     const std::string& producer, UpdateStreamOptions options);
  ~UpdateStreamWorker();

  /// Waits for the first opening. Errors: those of the call; kDeadlineExceeded.
  Status open(std::chrono::milliseconds timeout);
  /// Adds the messages of one batch and returns its sequence number. Returns nothing if the window
  /// is full and `waits` is false.
  Result<std::optional<std::uint64_t>> enqueue(Messages messages, bool waits);
  Status wait(std::uint64_t sequence);
  Status flush();
  Status close();
  UpdateStreamState state() const;

 private:
  using Call = grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>;

  struct Batch {
    std::uint64_t sequence = 0;
    std::shared_ptr<const Messages> messages;  // shared: the writing thread may still use them
  };

  void run();
  Status run_call(grpc::ClientContext& context);
  Status resume(const v1::StreamUpdatesResponse& first);
  void write_batches(Call& call);
  std::shared_ptr<const Messages> next_to_write();
  void receive(const v1::StreamUpdatesResponse& response);
  void receive(const v1::UpdateAck& ack);
  void receive(const v1::UpdateReject& reject);
  void set_revision(const v1::SceneRevision& revision);
  void mark_answered(std::uint64_t up_to);
  bool is_done() const { return closing_ && unanswered_.empty(); }
  bool should_retry(const Status& ended);
  void fail(const Error& error);

  const std::unique_ptr<v1::SceneService::Stub> stub_;
  const UpdateStreamOptions options_;
  v1::StreamUpdatesRequest opening_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  grpc::ClientContext* context_ = nullptr;  // the open call's, used to cancel it
  bool opened_ = false;                     // at least once
  bool connected_ = false;                  // at present
  bool closing_ = false;                    // no further batch is accepted
  bool abandoned_ = false;
  bool ended_ = false;
  bool progressed_ = false;      // some batch was answered since the call was opened
  std::optional<Error> failed_;  // why the stream ended
  std::deque<Batch> unanswered_;
  std::uint64_t next_to_write_ = 1;       // a sequence number
  std::uint64_t coalesced_in_calls_ = 0;  // sum over the calls before this one
  std::map<std::uint64_t, Error> rejects_;
  UpdateStreamState state_;

  Backoff backoff_;
  Retries retries_;
  grpc::Status last_call_;                          // how it ended
  std::chrono::milliseconds pause_before_next_{0};  // set by should_retry()
  std::thread thread_;                              // must be the last member: it uses all others
};

}  // namespace sightline::client::calls
