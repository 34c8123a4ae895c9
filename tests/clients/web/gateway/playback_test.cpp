// A recording as a source: ten seconds of a tool that moves 1 mm each tick along x, with a pluck at
// 2 s, a touch from 4 to 5 s that its ticks show, and another scene at 8 s.
#include "clients/web/gateway/playback.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "tests/clients/web/gateway/sample_recording.h"

namespace hapticd::test {
namespace {

using web::Playback;

constexpr std::uint64_t kEpoch_ns = 1'700'000'000'000'000'000;
constexpr std::uint64_t kTick_ns = 1'000'000;
constexpr std::uint64_t kTicks = 10'001;
/// t_ns of a tick: the daemon's clock had begun earlier.
constexpr std::uint64_t kClock_ns = 77'000'000'000;

std::string header_bytes(std::uint32_t format = 3) {
  v1::RecordHeader header;
  header.set_format_version(format);
  header.set_server_version("0.1.0");
  header.set_period_ns(kTick_ns);
  return header.SerializeAsString();
}

std::string scene_bytes(std::uint32_t id) {
  v1::SceneRecord scene;
  scene.set_scene_id(id);
  scene.set_hash(std::string(32, static_cast<char>('0' + id)));
  for (int i = 0; i < 7; ++i) scene.mutable_scene()->add_strings()->set_radius_m(0.0005);
  return scene.SerializeAsString();
}

void show_touch(std::uint64_t tick, v1::State& shown) {
  v1::ContactPatch& patch = *shown.add_contacts();
  patch.set_string_index(5);
  patch.add_p_wc_um(static_cast<std::int64_t>(1000 * tick));
  patch.add_force_mn(2000);
  v1::StringState& string = *shown.add_strings();
  string.set_string_index(5);
  string.set_phase(v1::STRING_PHASE_PRESSED);
  string.set_radius_m(0.002F);
}

std::string tick_bytes(std::uint64_t tick) {
  v1::TickRecord record;
  record.set_tick(tick);
  record.set_t_ns(kClock_ns + tick * kTick_ns);
  record.set_scene_id(tick < 8000 ? 1 : 2);
  record.set_loop_state(v1::LOOP_STATE_ENGAGED);
  record.add_inputs()->set_tool_id(0);
  v1::ToolOutput& output = *record.add_outputs();
  for (const double p : {1e-3 * static_cast<double>(tick), 0.25, 0.0}) {
    record.mutable_inputs(0)->mutable_pose_wh()->add_p_m(p);
    output.mutable_pose_wg()->add_p_m(p);
  }
  for (const double f : {0.0, 2.0, 0.0}) output.mutable_wrench_h_w()->add_f_n(f);
  for (int i = 0; i < 3; ++i) output.mutable_wrench_h_w()->add_t_n_m(0.0);
  if (tick >= 4000 && tick <= 5000) show_touch(tick, *record.mutable_shown());
  return record.SerializeAsString();
}

std::string event_bytes(std::uint64_t tick, const v1::Item& item) {
  v1::EventRecord record;
  record.set_tick(tick);
  *record.mutable_item() = item;
  return record.SerializeAsString();
}

v1::Item pluck() {
  v1::Item item;
  v1::StringRadius& radius = *item.mutable_string_radius();
  radius.set_t_ns(kClock_ns + 2000 * kTick_ns);
  radius.set_string_index(3);
  radius.set_phase(v1::STRING_RADIUS_PHASE_RELEASE);
  radius.set_r_max_m(0.004F);
  radius.set_decay_s(0.5F);
  return item;
}

v1::Item touch(v1::ContactPhase phase) {
  v1::Item item;
  v1::Contact& contact = *item.mutable_contact();
  contact.set_phase(phase);
  contact.set_string_index(5);
  for (const float p : {4.0F, 0.25F, 0.0F}) contact.add_p_wc_m(p);
  for (const float n : {0.0F, 1.0F, 0.0F}) contact.add_nhat_og_w(n);
  contact.set_force_n(2.0F);
  return item;
}

/// The recording in a file of its own.
struct Sample {
  explicit Sample(bool finished = true, std::uint32_t format = 3) {
    const auto time_ns = [](std::uint64_t tick) { return kEpoch_ns + tick * kTick_ns; };
    SampleRecording recording;
    recording.message(1, kEpoch_ns, header_bytes(format));
    recording.message(2, kEpoch_ns, scene_bytes(1));
    for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
      if (tick == 8000) recording.message(2, time_ns(tick), scene_bytes(2));
      recording.message(4, time_ns(tick), tick_bytes(tick));
      if (tick == 2000) recording.message(5, time_ns(tick), event_bytes(tick, pluck()));
      if (tick == 4000) {
        recording.message(5, time_ns(tick), event_bytes(tick, touch(v1::CONTACT_PHASE_BEGIN)));
      }
      if (tick == 5000) {
        recording.message(5, time_ns(tick), event_bytes(tick, touch(v1::CONTACT_PHASE_END)));
      }
      if (tick % 1000 == 999) recording.close_chunk();
    }
    recording.close_chunk();
    std::string name = (std::filesystem::temp_directory_path() / "hapticd_XXXXXX").string();
    const int file = ::mkstemp(name.data());
    REQUIRE(file >= 0);
    ::close(file);
    path = name;
    recording.save(path, finished);
  }
  ~Sample() { std::filesystem::remove(path); }
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;
  std::string path;
};

/// A playback and all it showed.
struct Show {
  explicit Show(const std::string& path)
      : playback(path, {[this](const v1::State& state) { states.push_back(state); },
                        [this](const v1::Item& item) { items.push_back(item); }}) {}

  void go_to(double position_s, bool playing = false, double rate = 1.0) {
    v1::PagePlayback wanted;
    wanted.set_position_s(position_s);
    wanted.set_playing(playing);
    wanted.set_rate(rate);
    playback.steer(wanted);
  }

  std::vector<v1::State> states;
  std::vector<v1::Item> items;
  Playback playback;
};

TEST_CASE("played to its end every event comes once and in order, and States go forward") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  for (int step = 0; step < 1100; ++step) show.playback.advance(0.01);
  REQUIRE(show.items.size() == 5);
  CHECK(show.items[0].scene_info().scene_id() == 1);
  CHECK(show.items[0].scene_info().rate_hz() == 1000.0);
  CHECK(show.items[0].scene_info().has_solver_in_force());
  CHECK(show.items[1].has_string_radius());
  CHECK(show.items[2].contact().phase() == v1::CONTACT_PHASE_BEGIN);
  CHECK(show.items[3].contact().phase() == v1::CONTACT_PHASE_END);
  CHECK(show.items[4].scene_info().scene_id() == 2);
  for (std::size_t i = 1; i < show.states.size(); ++i) {
    REQUIRE(show.states[i].tick() > show.states[i - 1].tick());
  }
  CHECK(show.states.back().tick() == kTicks - 1);
  CHECK(show.states.size() > 2500);
  CHECK(show.states.size() < 3100);
  CHECK_FALSE(show.playback.position().playing());
  CHECK(show.playback.position().position_s() == doctest::Approx(10.0));
}

TEST_CASE("the State of any place is that of its tick, forward and back") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  for (const double place_s : {9.5, 0.0, 4.321, 4.320, 10.0, 7.0}) {
    CAPTURE(place_s);
    show.go_to(place_s);
    const v1::State& state = show.states.back();
    const double tick = std::round(place_s * 1000.0);
    CHECK(static_cast<double>(state.tick()) == tick);
    REQUIRE(state.tools_size() == 1);
    CHECK(state.tools(0).p_wg_m(0) == doctest::Approx(1e-3 * tick));
    CHECK(state.tools(0).wrench_h_w(1) == 2.0F);
    CHECK(show.playback.shown_t_ns() ==
          static_cast<std::int64_t>(kClock_ns) + std::llround(place_s * 1e9));
  }
}

TEST_CASE("strings and contacts are those that the tick shows, wherever one jumps to") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  CHECK_FALSE(show.playback.tools_only());
  for (const double place_s : {4.0, 4.6, 5.0, 4.321}) {
    CAPTURE(place_s);
    show.go_to(place_s);
    const v1::State& state = show.states.back();
    REQUIRE(state.contacts_size() == 1);
    CHECK(state.contacts(0).p_wc_um(0) == std::llround(place_s * 1e6));
    CHECK(state.contacts(0).force_mn(0) == 2000);
    REQUIRE(state.strings_size() == 1);
    CHECK(state.strings(0).string_index() == 5);
    CHECK(state.strings(0).radius_m() == 0.002F);
  }
  for (const double place_s : {3.999, 5.001, 2.5}) {
    show.go_to(place_s);
    CHECK(show.states.back().strings_size() == 0);
    CHECK(show.states.back().contacts_size() == 0);
  }
}

TEST_CASE("a recording of format 2 shows tools, and says that it shows no more") {
  const Sample sample(true, 2);
  Show show(sample.path);
  show.playback.begin();
  CHECK(show.playback.tools_only());
  show.go_to(9.5);
  CHECK(show.states.back().tools(0).p_wg_m(0) == doctest::Approx(9.5));
}

TEST_CASE("a jump into another scene tells of it, within the same one it does not") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  CHECK(show.items.size() == 1);
  show.go_to(5.0);
  CHECK(show.items.size() == 1);
  show.go_to(9.0);
  REQUIRE(show.items.size() == 2);
  CHECK(show.items[1].scene_info().scene_id() == 2);
  show.go_to(1.0);
  REQUIRE(show.items.size() == 3);
  CHECK(show.items[2].scene_info().scene_id() == 1);
}

TEST_CASE("paused nothing moves; a rate of a quarter takes four times as long") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  show.go_to(3.0);
  const std::size_t shown = show.states.size();
  for (int step = 0; step < 100; ++step) show.playback.advance(0.01);
  CHECK(show.states.size() == shown);
  show.go_to(3.0, true, 0.25);
  for (int step = 0; step < 200; ++step) show.playback.advance(0.01);
  CHECK(show.playback.position().position_s() == doctest::Approx(3.5));
  CHECK(show.states.back().tick() == 3500);
}

TEST_CASE("while it plays, a page's view of now is no jump, and no number breaks it") {
  const Sample sample;
  Show show(sample.path);
  show.playback.begin();
  for (int step = 0; step < 100; ++step) show.playback.advance(0.01);
  show.go_to(0.9, true, 2.0);
  CHECK(show.playback.position().position_s() == doctest::Approx(1.0));
  CHECK(show.playback.position().rate() == 2.0);
  const double nan = std::nan("");
  show.go_to(nan, true, nan);
  CHECK(show.playback.position().position_s() == doctest::Approx(1.0));
  CHECK(show.playback.position().rate() == 2.0);
  show.go_to(1e300, true, 1e300);
  CHECK(show.playback.position().position_s() == doctest::Approx(10.0));
  CHECK(show.playback.position().rate() == 100.0);
  show.go_to(-5.0, false, -1.0);
  CHECK(show.playback.position().position_s() == 0.0);
}

TEST_CASE("a recording that a killed daemon left plays as far as it goes") {
  const Sample sample(false);
  const std::uintmax_t size = std::filesystem::file_size(sample.path);
  std::filesystem::resize_file(sample.path, size * 7 / 10);
  Show show(sample.path);
  const double length_s = show.playback.position().duration_s();
  CHECK(length_s > 5.0);
  CHECK(length_s < 8.0);
}

TEST_CASE("what is no recording is refused with its name and a remedy, wherever it is cut") {
  const Sample sample;
  const auto refusal = [](const std::string& path) {
    try {
      const Show show(path);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal("/nowhere/x.mcap").find("/nowhere/x.mcap") == 0);
  for (const std::uintmax_t size : {0U, 7U, 8U, 40U, 300U, 500U}) {
    CAPTURE(size);
    std::filesystem::resize_file(sample.path, size);
    const std::string text = refusal(sample.path);
    CHECK(text.find(sample.path) == 0);
    CHECK(text.find(". ") != std::string::npos);
  }
}

TEST_CASE("a recording of a later format, or a compressed one, is refused") {
  const Sample place;
  SampleRecording later;
  v1::RecordHeader header;
  header.set_format_version(4);
  later.message(1, 1, header.SerializeAsString());
  later.save(place.path);
  CHECK_THROWS_WITH(Show(place.path), doctest::Contains("format 4"));
  SampleRecording compressed;
  compressed.message(1, 1, header_bytes());
  compressed.close_chunk("lz4");
  compressed.save(place.path);
  CHECK_THROWS_WITH(Show(place.path), doctest::Contains("not a recording"));
}

}  // namespace
}  // namespace hapticd::test
