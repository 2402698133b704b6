// The law of memory: whatever clients do, the server program holds no more than its budget and what
// the program itself takes.
#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "sightline/v1/backup.grpc.pb.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/child_server.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr std::uint64_t kBudget = std::uint64_t{256} << 20;
/// The program, its libraries and threads, gRPC's buffers, and freed memory that is kept.
constexpr std::uint64_t kBeside = std::uint64_t{96} << 20;

/// A scene of this many moving nodes. What is refused is the attacker's loss.
class MovingScene {
 public:
  static constexpr std::size_t kNodes = 15'000;

  MovingScene(Api& api, std::string scene) : api_(api), scene_(std::move(scene)) {
    static_cast<void>(api_.create(scene_));
    const std::string blob = blob_of(planar_sheet(1)), digest = digest_of(blob).text();
    static_cast<void>(api_.upload(blob, digest));
    std::vector<v1::Update> nodes;
    for (std::size_t i = 0; i < kNodes; ++i)
      nodes.push_back(put_node(-1 - static_cast<std::int64_t>(i), digest, 0, pose_of(i, 0)));
    static_cast<void>(api_.apply(scene_, nodes));
  }

  /// Moves every node.
  grpc::Status move(double z) {
    v1::Update update;
    v1::SetTransforms& rows = *update.mutable_set_transforms();
    for (std::size_t i = 0; i < kNodes; ++i) {
      rows.add_nodes(static_cast<std::int64_t>(i + 1));
      const auto at = pose_of(i, z);
      rows.mutable_matrices()->append(reinterpret_cast<const char*>(at.m.data()), sizeof(at.m));
    }
    return api_.apply(scene_, {update});
  }

 private:
  static scenegraph::model::Affine pose_of(std::size_t i, double z) {
    const auto x = static_cast<double>(i % 100 * 2), y = static_cast<double>(i / 100 * 2);
    return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
  }

  Api& api_;
  const std::string scene_;
};

/// Streams of rays that were answered once and are left open.
class OpenStreams {
 public:
  explicit OpenStreams(int port) : port_(port) {}
  ~OpenStreams() {
    for (auto& open : open_) open.context->TryCancel();
    for (auto& open : open_) open.stream->Finish();
  }

  /// Returns whether it was answered.
  bool open(const std::string& scene, std::size_t rays) {
    if (open_.size() % 16 == 0) clients_.push_back(std::make_unique<Api>(connect(port_)));
    Open& open = open_.emplace_back();
    open.stream = clients_.back()->rays->StreamCastRays(open.context.get());
    return ask(open, scene, rays);
  }
  std::size_t size() const { return open_.size(); }
  /// Asks the stream again. Returns the reason of its end; empty if it was answered.
  std::string ask_again(std::size_t which, const std::string& scene) {
    Open& open = open_[which];
    if (ask(open, scene, 1)) return {};
    const std::string reason = reason_of(open.stream->Finish());
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(which));
    return reason;
  }

 private:
  using Stream = grpc::ClientReaderWriter<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>;
  struct Open {
    std::unique_ptr<grpc::ClientContext> context = std::make_unique<grpc::ClientContext>();
    std::unique_ptr<Stream> stream;
  };

  static bool ask(Open& open, const std::string& scene, std::size_t rays) {
    v1::StreamCastRaysRequest request;
    *request.mutable_request() = cast_request(scene, rays_downward(rays));
    v1::StreamCastRaysResponse reply;
    return open.stream->Write(request) && open.stream->Read(&reply);
  }

  const int port_;
  std::vector<std::unique_ptr<Api>> clients_;
  std::vector<Open> open_;
};

/// Uploads that declare much and are left open.
class OpenUploads {
 public:
  explicit OpenUploads(int port) : port_(port) {}
  ~OpenUploads() {
    for (auto& open : open_) open.context->TryCancel();
    for (auto& open : open_) open.writer->Finish();
  }

  /// Declares `declared` bytes and sends `sent` of them. Returns whether all were written.
  bool open(std::uint64_t declared, std::uint64_t sent) {
    if (open_.size() % 8 == 0) clients_.push_back(std::make_unique<Api>(connect(port_)));
    Open& open = open_.emplace_back();
    open.writer = clients_.back()->blobs->UploadBlob(open.context.get(), &open.reply);
    v1::UploadBlobRequest request;
    const std::uint64_t rows = (declared - 24) / 12, counts[2] = {rows, 0};
    request.set_digest(fmt::format("sha256:{:064x}/{}", open_.size(), 24 + rows * 12));
    std::string data("SLM1\0\0\0\0", 8);
    data.append(reinterpret_cast<const char*>(counts), sizeof(counts));
    for (std::uint64_t at = 0; at < sent; at += data.size(), data.clear()) {
      data.resize(std::min<std::uint64_t>(std::uint64_t{1} << 20, sent - at));
      request.set_offset(at);
      request.set_data(data);
      const std::uint64_t bytes = data.size();
      if (!open.writer->Write(request)) return false;
      request.clear_digest();
      at += bytes - data.size();
    }
    return true;
  }

 private:
  struct Open {
    std::unique_ptr<grpc::ClientContext> context = std::make_unique<grpc::ClientContext>();
    v1::UploadBlobResponse reply;
    std::unique_ptr<grpc::ClientWriter<v1::UploadBlobRequest>> writer;
  };

  const int port_;
  std::vector<std::unique_ptr<Api>> clients_;
  std::vector<Open> open_;
};

class SightlinedMemory : public testing::Test {
 protected:
  SightlinedMemory()
      : folder_(make_folder()),
        child_({"--listen", "127.0.0.1:0", "--threads", "2", "--memory-budget",
                std::to_string(kBudget), "--data-dir", folder_ + "/data"}),
        port_(child_.port()),
        api_(connect(port_)) {
    api_.make_scene(kScene, planar_sheet(50));
  }
  ~SightlinedMemory() override {
    child_.signal(SIGKILL);
    child_.wait();
    std::filesystem::remove_all(folder_);
  }

  static std::string make_folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sightline-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    return pattern;
  }

  void expect_law(const char* attack) {
    const std::uint64_t peak = child_.peak_resident_bytes();
    RecordProperty(attack, std::to_string(peak >> 20) + " MiB");
    fmt::print("{}: at most {} MiB were resident\n", attack, peak >> 20);
    if (kMemoryIsPlain) {
      EXPECT_LE(peak, kBudget + kBeside) << attack;
    }
  }
  /// As clients do with what is refused for now.
  static grpc::Status repeat(const std::function<grpc::Status()>& call) {
    grpc::Status status = call();
    for (int i = 0; i < 200 && status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      status = call();
    }
    return status;
  }

  /// What another client does: a small cast, an update, an upload.
  void expect_serving(int round) {
    Api api(connect(port_));
    v1::CastRaysResponse reply;
    const grpc::Status cast =
        repeat([&] { return api.cast(cast_request(kScene, rays_downward(16)), &reply); });
    EXPECT_TRUE(cast.ok()) << cast.error_message();
    EXPECT_EQ(reply.stats().hits(), 16u);
    const grpc::Status moved =
        repeat([&] { return api.apply(kScene, {move_to(1, round % 2 * -0.001)}); });
    EXPECT_TRUE(moved.ok()) << moved.error_message();
    TestMesh mesh = planar_sheet(20);
    mesh.vertices.front().z = static_cast<float>(round);
    const std::string blob = blob_of(mesh);
    const grpc::Status uploaded = repeat([&] { return api.upload(blob, digest_of(blob).text()); });
    EXPECT_TRUE(uploaded.ok()) << uploaded.error_message();
  }
  std::uint64_t held(const std::string& kind) {
    grpc::ClientContext context;
    v1::GetServerInfoResponse info;
    EXPECT_TRUE(api_.server->GetServerInfo(&context, {}, &info).ok());
    for (const auto& use : info.memory()) {
      if (use.kind() == kind) return use.bytes();
    }
    return 0;
  }

  // The attacks.

  /// Streams that rest, each at a revision of its own. Returns how often it was refused.
  int pin_revisions(OpenStreams& streams, int revisions) {
    Api api(connect(port_));
    const std::string scene = "projects/p/scenes/moving";
    MovingScene moving(api, scene);
    int refused = 0;
    for (int i = 0; i < revisions; ++i) {
      if (!moving.move(i * 0.01).ok() || !streams.open(scene, 1)) ++refused;
    }
    return refused;
  }
  /// Streams that rest, each at a scene that is deleted. Returns how often it was refused.
  int pin_deleted(OpenStreams& streams, int scenes) {
    Api api(connect(port_));
    int refused = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::string scene = "projects/p/scenes/deleted" + std::to_string(i);
      const MovingScene moving(api, scene);
      if (!streams.open(scene, 1) || !api.remove(scene).ok()) ++refused;
    }
    return refused;
  }
  /// A batch that never ends. Returns the reason of its refusal.
  std::string restore_endlessly(int megabytes) {
    const auto stub = v1::BackupService::NewStub(connect(port_));
    grpc::ClientContext context;
    v1::RestoreResponse reply;
    const auto writer = stub->Restore(&context, &reply);
    v1::RestoreRequest request;
    v1::BackupScene& scene = *request.mutable_part()->mutable_scene();
    scene.mutable_scene()->set_name("projects/p/scenes/restored");
    scene.set_revision(5);
    bool going = writer->Write(request);
    v1::BackupBatch& batch = *request.mutable_part()->mutable_batch();
    batch.set_revision(1);
    batch.set_more(true);
    batch.set_updates(std::string(std::size_t{1} << 20, 'x'));
    for (int i = 0; going && i < megabytes; ++i) going = writer->Write(request);
    if (going) context.TryCancel();
    return reason_of(writer->Finish());
  }

  const std::string folder_;
  ChildServer child_;
  int port_;
  Api api_;
};

TEST_F(SightlinedMemory, RevisionsThatOnlyReadersHave) {
  OpenStreams streams(port_);
  EXPECT_EQ(pin_revisions(streams, 40), 0);  // 0.4 GB of nodes
  expect_law("pinned revisions");
  EXPECT_EQ(streams.ask_again(0, "projects/p/scenes/moving"), "REVISION_LET_GO");
  EXPECT_EQ(streams.ask_again(streams.size() - 1, "projects/p/scenes/moving"), "");
  expect_serving(1);
}

TEST_F(SightlinedMemory, DeletedScenesThatReadersHave) {
  OpenStreams streams(port_);
  EXPECT_EQ(pin_deleted(streams, 40), 0);
  expect_law("deleted scenes");
  EXPECT_EQ(streams.ask_again(0, kScene), "REVISION_LET_GO");
  expect_serving(1);
}

TEST_F(SightlinedMemory, UploadsThatDeclareMuch) {
  OpenUploads uploads(port_);
  for (int i = 0; i < 24; ++i) ASSERT_TRUE(uploads.open(kBudget / 25, 1 << 16));
  for (int round = 0; round < 3; ++round) expect_serving(round);
  EXPECT_LT(held("uploads"), std::uint64_t{8} << 20);
  expect_law("declared uploads");
}

TEST_F(SightlinedMemory, UploadsThatEndBeforeTheirLastByte) {
  OpenUploads uploads(port_);
  for (int i = 0; i < 40; ++i) static_cast<void>(uploads.open(9 << 20, 8 << 20));
  expect_law("half uploads");
  v1::CastRaysResponse reply;
  EXPECT_TRUE(api_.cast(cast_request(kScene, rays_downward(16)), &reply).ok());
}

TEST_F(SightlinedMemory, ARestoreThatDoesNotEnd) {
  EXPECT_EQ(restore_endlessly(600), "MEMORY_BUDGET");
  expect_law("endless restore");
  EXPECT_EQ(held("uploads"), 0u);
  expect_serving(1);
}

TEST_F(SightlinedMemory, StreamsThatRestAfterALargeBatch) {
  OpenStreams streams(port_);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(streams.open(kScene, 16'000));
  expect_law("streams after large batches");
  expect_serving(1);
}

TEST_F(SightlinedMemory, NamesOfProducers) {
  const std::uint64_t before = held("logs");
  constexpr int kNames = 200;
  // The server may count streams that were cancelled, for a while: then it refuses the next.
  for (int i = 0; i < kNames;) {
    UpdateStream stream(api_);
    v1::StreamUpdatesResponse answer;
    if (stream.send_open(kScene, fmt::format("{:060}", i)) && stream.read(answer) &&
        answer.has_opened())
      ++i;
  }
  EXPECT_GE(held("logs"), before + kNames * 500);
}

TEST_F(SightlinedMemory, AllAtOnce) {
  OpenStreams pins(port_), deleted(port_), resting(port_);
  OpenUploads uploads(port_);
  std::atomic<bool> stop{false};
  std::vector<std::thread> attacks;
  attacks.emplace_back([&] { static_cast<void>(pin_revisions(pins, 25)); });
  attacks.emplace_back([&] { static_cast<void>(pin_deleted(deleted, 15)); });
  attacks.emplace_back([&] {
    for (int i = 0; i < 24; ++i) static_cast<void>(uploads.open(kBudget / 25, 1 << 16));
  });
  attacks.emplace_back([&] { static_cast<void>(restore_endlessly(300)); });
  attacks.emplace_back([&] {
    for (int i = 0; i < 30; ++i) static_cast<void>(resting.open(kScene, 16'000));
  });
  std::thread good([&] {
    for (int round = 0; !stop; ++round) expect_serving(round);
  });
  for (std::thread& attack : attacks) attack.join();
  stop = true;
  good.join();
  expect_law("all at once");
}

}  // namespace
}  // namespace sightline::tests
