// Messages and errors in JSON.
#include "server/admin/json_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "sightline/v1/scene.pb.h"

namespace sightline::server::admin {
namespace {

TEST(JsonCodec, UnaryMethodsHaveJsonAndStreamsHaveNone) {
  const auto get = json_method("GetScene");
  ASSERT_TRUE(get);
  EXPECT_EQ((*get)->full_name(), "sightline.v1.SceneService.GetScene");
  for (const char* name : {"CastRays", "QueryPoints", "GetServerInfo", "FindMissingBlobs"})
    EXPECT_TRUE(json_method(name)) << name;
  for (const char* name : {"WatchScene", "StreamCastRays", "UploadBlob"})
    EXPECT_EQ(json_method(name).error().code, Code::kUnimplemented) << name;
  for (const char* name : {"", "getscene", "GetScene/", "sightline.v1.SceneService.GetScene"})
    EXPECT_EQ(json_method(name).error().code, Code::kNotFound) << name;
}

TEST(JsonCodec, MessagesGoThereAndBack) {
  for (const double meters : {0.1, 1e300, 5e-324, HUGE_VAL}) {
    v1::CreateSceneRequest request;
    request.mutable_scene()->set_name("Dach \xC3\xA4");
    request.mutable_scene()->set_meters_per_unit(meters);
    const auto& type = *v1::CreateSceneRequest::descriptor();
    const auto text = json_of_message(type, request.SerializeAsString());
    ASSERT_TRUE(text) << text.error().message;
    EXPECT_EQ(text->back(), '\n');
    const auto back = message_of_json(type, *text);
    ASSERT_TRUE(back) << back.error().message << *text;
    EXPECT_EQ(*back, request.SerializeAsString());
  }
}

TEST(JsonCodec, FieldsThatAMessageDoesNotHaveAreRefused) {
  const auto& type = *v1::GetSceneRequest::descriptor();
  for (const char* text :
       {R"({"nome": "x"})", R"({"name": 1})", R"({"name": ["x"]})", "{'name': 1}"}) {
    const auto made = message_of_json(type, text);
    ASSERT_FALSE(made) << text;
    EXPECT_EQ(made.error().reason, "BAD_JSON");
  }
  EXPECT_TRUE(message_of_json(type, R"({"name": "x"})"));
}

TEST(JsonCodec, BytesThatAreNoMessageAreAnError) {
  const auto text = json_of_message(*v1::GetSceneRequest::descriptor(), "\xff");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, Code::kInternal);
}

TEST(JsonCodec, ErrorsHaveTheirStatus) {
  const auto reply = json_error({Code::kNotFound, "no scene \"\xff\"", "SCENE_NOT_FOUND"});
  EXPECT_EQ(reply.code, 404);
  EXPECT_EQ(reply.type, "application/json");
  const auto body = nlohmann::json::parse(reply.body);
  EXPECT_EQ(body["error"]["code"], "NOT_FOUND");
  EXPECT_EQ(body["error"]["reason"], "SCENE_NOT_FOUND");
  EXPECT_EQ(json_error({Code::kResourceExhausted, "full", {}}).code, 429);
  EXPECT_EQ(json_error({Code::kDeadlineExceeded, "late", {}}).code, 504);
  EXPECT_EQ(json_error({Code::kDataLoss, "lost", {}}).code, 500);
}

}  // namespace
}  // namespace sightline::server::admin
