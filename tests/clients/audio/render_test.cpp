// Offline rendering: the same bits in every run and in blocks of any size, from a score or from a
// recording that the daemon's own writer has made; and what recordings that are broken give.
#include "clients/audio/render.h"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "hapticd/v1/recording.pb.h"
#include "proto/recording/mcap_writer.h"
#include "proto/recording/recording_format.h"
#include "proto/recording/schema_set.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/temporary_folder.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::audio {
namespace {

std::vector<float> rendered(const Score& score, std::size_t block = kRenderBlock,
                            RenderReport* report = nullptr) {
  std::vector<float> sound;
  const RenderReport made = render(
      score, test::whole(), nullptr,
      [&](std::span<const float> frames) {
        sound.insert(sound.end(), frames.begin(), frames.end());
      },
      block);
  if (report != nullptr) *report = made;
  return sound;
}

/// Writes a recording of a scene and of the events of `score`, whose times begin at t0.
void record(const std::string& path, const Score& score, std::uint64_t t0) {
  McapWriter writer;
  REQUIRE(writer.open(path, "test"));
  const auto add = [&](const char* topic, const google::protobuf::Descriptor& type) {
    return writer.add_channel(topic, type.full_name(), schema_set(type));
  };
  const std::uint16_t headers = add("/hapticd/header", *v1::RecordHeader::descriptor());
  const std::uint16_t scenes = add("/hapticd/scene", *v1::SceneRecord::descriptor());
  const std::uint16_t ticks = add("/hapticd/tick", *v1::TickRecord::descriptor());
  const std::uint16_t events = add("/hapticd/event", *v1::EventRecord::descriptor());
  v1::RecordHeader header;
  header.set_format_version(kRecordFormat);
  writer.write(headers, t0, header.SerializeAsString());
  for (const ScoreEntry& entry : score) {
    const std::uint64_t t_ns = t0 + static_cast<std::uint64_t>(entry.t_ns);
    writer.write(ticks, t_ns, v1::TickRecord().SerializeAsString());
    if (entry.item.has_scene_info()) {
      v1::SceneRecord scene;
      *scene.mutable_scene() = entry.item.scene_info().scene();
      writer.write(scenes, t_ns, scene.SerializeAsString());
      continue;
    }
    v1::EventRecord event;
    *event.mutable_item() = entry.item;
    event.mutable_item()->mutable_tone()->set_t_ns(t_ns);
    writer.write(events, t_ns, event.SerializeAsString());
    writer.flush();
  }
  REQUIRE(writer.close());
}

}  // namespace

TEST_CASE("a score gives the same bits in every run and in blocks of any size") {
  const auto once = rendered(open_strings());
  CHECK(rendered(open_strings()) == once);
  for (const std::size_t block : {1U, 100U, 4096U}) CHECK(rendered(open_strings(), block) == once);
}

TEST_CASE("the open strings sound one after the other, in the tuning zheng diao") {
  RenderReport report;
  const auto sound = rendered(open_strings(), kRenderBlock, &report);
  CHECK_EQ(report.played, 14);
  CHECK_EQ(report.events.unplayable, 0);
  CHECK(report.length_s == doctest::Approx(static_cast<double>(sound.size()) / 48000.0));
  for (std::size_t i = 0; i < std::size(kZhengDiao); ++i) {
    const double pitch = kZhengDiao[i].frequency_hz;
    const double measured =
        test::frequency_near(sound, 48000.0, pitch, static_cast<double>(i) + 0.1, 0.5, 0.3);
    CHECK(std::abs(test::cents(measured, pitch)) < 0.5);
  }
}

TEST_CASE("a recording sounds as its events do, whatever its clock begins with") {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "session.mcap").string();
  const Score score = open_strings();
  record(path, score, 123'456'789'012'345);
  std::string problem;
  const Score read = recorded_score(path, problem);
  CHECK_EQ(problem, "");
  REQUIRE_EQ(read.size(), score.size());
  CHECK_EQ(read[0].item.scene_info().scene().strings_size(), 7);
  CHECK(rendered(read) == rendered(score));
}

TEST_CASE("time that begins anew with a scene goes on where it was") {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "session.mcap").string();
  Score twice = open_strings();
  const Score again = open_strings();
  twice.insert(twice.end(), again.begin(), again.end());
  record(path, twice, 0);
  std::string problem;
  const Score read = recorded_score(path, problem);
  REQUIRE_EQ(read.size(), 30);
  std::int64_t before = 0;
  for (const ScoreEntry& entry : read) {
    CHECK(entry.t_ns >= before);
    before = entry.t_ns;
  }
  CHECK_EQ(read.back().t_ns, 2 * again.back().t_ns);
}

TEST_CASE("a recording cut off anywhere gives what is whole of it, and damaged bytes do no harm") {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "session.mcap").string();
  record(path, open_strings(), 5);
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  const std::string whole = content.str();
  std::string problem;
  const auto entries = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    problem.clear();
    try {
      return recorded_score(path, problem).size();
    } catch (const std::runtime_error& error) {
      problem = error.what();
      return std::size_t{0};
    }
  };
  std::size_t most = 0;
  for (std::size_t length = 0; length < whole.size(); length += 13) {
    const std::size_t found = entries(whole.substr(0, length));
    CHECK(found >= most);
    most = found;
    if (length < whole.size() / 2) CHECK(problem != "");
  }
  CHECK_EQ(most, 15);
  CHECK_EQ(entries(whole), 15);
  CHECK_EQ(problem, "");
  test::SplitMix64 random(3);
  for (int i = 0; i < test::scaled(2000); ++i) {
    std::string damaged = whole;
    damaged[random.below(damaged.size())] = static_cast<char>(random.next());
    CHECK(entries(damaged) <= 15);
  }
  CHECK_EQ(entries("no recording"), 0);
  CHECK(problem.find("not a recording of hapticd") != std::string::npos);
  CHECK_THROWS_WITH_AS((void)recorded_score("/no/such/file.mcap", problem),
                       doctest::Contains("/no/such/file.mcap: No such file"), std::runtime_error);
}

}  // namespace hapticd::audio
