// Ticks and events on the wire, against the words of the .proto files.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "server/encoding/encode_event.h"
#include "server/encoding/encode_state.h"
#include "tests/support/no_heap.h"

namespace hapticd::test {
namespace {

constexpr std::uint32_t kAll = 0xffffffffU;

/// Two strings (the second a cable of two pieces), one line, one tool with id 5.
SceneIndex small_index() {
  SceneIndex index;
  index.pieces = {{0, true, 1e-3, 0.0, 1.0},
                  {1, true, 2e-3, 0.0, 0.5},
                  {1, true, 2e-3, 0.5, 0.5},
                  {0, false, 5e-3, 0.0, 1.0}};
  index.tool_ids = {5};
  return index;
}

ContactTick contact_at(ObstacleKind kind, std::int32_t obstacle, double gap, double force) {
  ContactTick contact;
  contact.key.kind = kind;
  contact.key.obstacle = obstacle;
  contact.key.tool_sphere = 17;
  contact.p_WC = {0.5, -0.121, 1e-7};
  contact.nhat_OG_W = {0.0, 1.0, 0.0};
  contact.gap = gap;
  contact.force = force;
  return contact;
}

std::unique_ptr<Tick> small_tick() {
  auto tick = std::make_unique<Tick>();
  tick->tick = 7;
  tick->t_ns = 7'000'000;
  tick->scene_id = 3;
  tick->state = LoopState::kEngaged;
  ToolTick tool;
  tool.tool_id = 5;
  tool.flags = kSlewLimited | kClutched;
  tool.X_WH.p = {1e6, 0.1, -0.2};
  tool.F_written_H_W.f = {1.0, 2.0, 3.0};
  tool.F_computed_H_W.f = {1.0, 2.0, 4.0};
  tool.sample.grip_m = std::numeric_limits<float>::quiet_NaN();
  tool.sample.flags = 0b101;
  tool.contacts = 3;
  tick->tools.push_back(tool);
  tick->strings.push_back({0, 0, StringPhase::kStatic, true, true, 0.25, 1e-3, {0.0, -1e-3, 0.0}});
  tick->strings.push_back({1, 0, StringPhase::kFundamental, false, false, 0.5, 1e-4, {}});
  tick->strings.push_back({2, 0, StringPhase::kFundamental, false, false, 0.5, 3e-4, {}});
  tick->contacts.push_back(contact_at(ObstacleKind::kBody, 4, -2e-9, 1.5));
  tick->contacts.push_back(contact_at(ObstacleKind::kCapsule, 3, 1.5e-9, 0.5));
  tick->contacts.push_back(contact_at(ObstacleKind::kBody, 4, 20e-6, 0.25));
  tick->contacts_total = 3;
  tick->string_forces.push_back({0, 0, {0.0, 7.0, 0.0}});
  return tick;
}

v1::State encoded(std::uint32_t sections, std::uint32_t max_contacts = 256) {
  v1::State state;
  encode_state(*small_tick(), small_index(), {sections, max_contacts}, state);
  return state;
}

}  // namespace

TEST_CASE("a State has the sections that were asked for and no others") {
  const v1::State bare = encoded(0);
  CHECK(bare.tick() == 7);
  CHECK(bare.loop_state() == v1::LOOP_STATE_ENGAGED);
  CHECK(bare.scene_id() == 3);
  CHECK(bare.tools_size() + bare.devices_size() + bare.strings_size() + bare.contacts_size() == 0);
  CHECK_FALSE(bare.has_energy());
  CHECK_FALSE(bare.has_quality());
  CHECK(encoded(1U << v1::SECTION_TOOLS).tools_size() == 1);
  CHECK(encoded(1U << v1::SECTION_TOOLS).devices_size() == 0);
}

TEST_CASE("the stages of a State are those of the tick, and the simulation as a whole") {
  const auto tick = small_tick();
  tick->times.stages = {1, 20, 300, 4000, 5, 6, 7};
  v1::State state;
  encode_state(*tick, small_index(), {1U << v1::SECTION_STAGES, 256}, state);
  std::uint32_t sum_ns = 0;
  for (const v1::StageTiming& stage : state.timing().stages()) {
    if (stage.stage() == v1::STAGE_STRINGS) CHECK(stage.last_ns() == 4000);
    if (stage.stage() == v1::STAGE_SIMULATION) CHECK(stage.last_ns() == 4320);
    sum_ns += stage.last_ns();
  }
  CHECK(sum_ns == 4339 + 4320);
}

TEST_CASE("a string that is bent is listed with all its vertices, whoever plays it") {
  const auto tick = small_tick();
  tick->string_bends.push_back({0, 1, 0.125, {0.0, -4e-3, 0.0}});
  tick->string_bends.push_back({0, 0, 0.25, {0.0, -1e-3, 0.0}});
  tick->string_bends.push_back({0, 2, 0.75, {0.0, 0.0, 2e-3}});
  v1::State state;
  encode_state(*tick, small_index(), {1U << v1::SECTION_STRINGS, 256}, state);
  REQUIRE(state.strings_size() == 2);
  const v1::StringState& string = state.strings(0);
  CHECK(string.phase() == v1::STRING_PHASE_PRESSED);
  CHECK(string.lambda() == 0.25F);
  CHECK(string.deflection_w_m(1) == -1e-3F);
  REQUIRE(string.further_lambda_size() == 2);
  CHECK(string.further_lambda(0) == 0.125F);
  CHECK(string.further_lambda(1) == 0.75F);
  REQUIRE(string.further_deflection_w_m_size() == 6);
  CHECK(string.further_deflection_w_m(1) == -4e-3F);
  CHECK(string.further_deflection_w_m(5) == 2e-3F);
}

TEST_CASE(
    "a string that is bent without a touch or a sound is listed, and one that is straight is not") {
  const auto tick = small_tick();
  tick->strings.clear();
  tick->string_bends.push_back({0, 1, 0.125, {0.0, 3e-3, -4e-3}});
  v1::State state;
  encode_state(*tick, small_index(), {1U << v1::SECTION_STRINGS, 256}, state);
  REQUIRE(state.strings_size() == 1);
  CHECK(state.strings(0).string_index() == 0);
  CHECK(state.strings(0).phase() == v1::STRING_PHASE_TOUCHED);
  CHECK(state.strings(0).lambda() == 0.125F);
  CHECK(state.strings(0).radius_m() == doctest::Approx(1e-3 + 5e-3));
  CHECK(state.strings(0).further_lambda_size() == 0);
}

TEST_CASE("of a cable the knots beside a bent piece are told as what stays where it is") {
  const auto tick = small_tick();
  tick->strings.clear();
  tick->string_bends.push_back({1, 0, 0.5, {0.0, -1e-3, 0.0}});
  v1::State state;
  encode_state(*tick, small_index(), {1U << v1::SECTION_STRINGS, 256}, state);
  REQUIRE(state.strings_size() == 1);
  CHECK(state.strings(0).lambda() == 0.25F);
  REQUIRE(state.strings(0).further_lambda_size() == 1);
  CHECK(state.strings(0).further_lambda(0) == 0.5F);
  CHECK(state.strings(0).further_deflection_w_m(1) == 0.0F);
  tick->string_bends.push_back({2, 1, 0.5, {0.0, -5e-4, 0.0}});
  encode_state(*tick, small_index(), {1U << v1::SECTION_STRINGS, 256}, state);
  REQUIRE(state.strings(0).further_lambda_size() == 2);
  CHECK(state.strings(0).further_lambda(0) == 0.5F);
  CHECK(state.strings(0).further_lambda(1) == 0.75F);
}

TEST_CASE("a State that is filled and written once more leaves the heap alone") {
  const auto tick = small_tick();
  const SceneIndex index = small_index();
  v1::State state;
  std::array<std::uint8_t, 4096> datagram;
  const auto write = [&] {
    encode_state(*tick, index, {kAll, 256}, state);
    return state.SerializeToArray(datagram.data(), static_cast<int>(datagram.size()));
  };
  REQUIRE(write());
  bool written = false;
  const NoHeapScope scope;
  written = write();
  const std::int64_t touched = scope.count();
  CHECK(written);
  CHECK(touched == 0);
}

TEST_CASE("a tool keeps its micrometres far from the origin, and its flags their names") {
  const v1::State state = encoded(kAll);
  const v1::ToolState& tool = state.tools(0);
  CHECK(tool.tool_id() == 5);
  CHECK(tool.p_wh_m(0) == 1e6);
  CHECK(tool.wrench_h_w(2) == 3.0F);
  CHECK(tool.wrench_unlimited_h_w(2) == 4.0F);
  REQUIRE(tool.flags_size() == 2);
  CHECK(tool.flags(0) == v1::TOOL_FLAG_SLEW_LIMITED);
  CHECK(tool.flags(1) == v1::TOOL_FLAG_CLUTCHED);
}

TEST_CASE("what a device does not measure is not there") {
  const v1::State state = encoded(kAll);
  const v1::DeviceState& device = state.devices(0);
  CHECK_FALSE(device.has_grip_m());
  REQUIRE(device.flags_size() == 2);
  CHECK(device.flags(0) == v1::DEVICE_FLAG_ATTACHED);
  CHECK(device.flags(1) == v1::DEVICE_FLAG_ENABLED);
}

TEST_CASE(
    "a string is listed once, of a cable the piece that moves most, with its place along all") {
  const v1::State state = encoded(kAll);
  REQUIRE(state.strings_size() == 2);
  CHECK(state.strings(0).phase() == v1::STRING_PHASE_PRESSED);
  CHECK(state.strings(0).radius_m() == doctest::Approx(2e-3));
  CHECK(state.strings(1).string_index() == 1);
  CHECK(state.strings(1).lambda() == doctest::Approx(0.75));
  CHECK(state.strings(1).radius_m() == doctest::Approx(2.3e-3));
}

TEST_CASE("a string's phase is that of its touch, and of what rings under it") {
  auto tick = small_tick();
  tick->strings.clear();
  tick->strings.push_back({0, 0, StringPhase::kStatic, true, false, 0.5, 0.0, {}});
  tick->strings.push_back({1, 0, StringPhase::kModes, true, false, 0.5, 0.0, {}});
  v1::State state;
  encode_state(*tick, small_index(), {kAll, 256}, state);
  CHECK(state.strings(0).phase() == v1::STRING_PHASE_TOUCHED);
  CHECK(state.strings(1).phase() == v1::STRING_PHASE_DAMPED);
}

TEST_CASE(
    "contacts are patches per object, in whole units, ties to even, and forces are complete") {
  const v1::State state = encoded(kAll);
  REQUIRE(state.contacts_size() == 3);
  const v1::ContactPatch& body = state.contacts(0);
  CHECK(body.tool_id() == 5);
  CHECK(body.body_index() == 4);
  REQUIRE(body.gap_nanometres_size() == 2);
  CHECK(body.gap_nanometres(0) == -2);
  CHECK(body.gap_nanometres(1) == 20000);
  CHECK(body.p_wc_um(0) == 500000);
  CHECK(body.p_wc_um(1) == -121000);
  CHECK(body.nhat_og_w_e4(1) == 10000);
  CHECK(body.force_mn(0) == 1500);
  CHECK(body.force_w_n(1) == doctest::Approx(1.75));
  CHECK(state.contacts(1).line_index() == 0);
  CHECK(state.contacts(1).gap_nanometres(0) == 2);
  // A string's force is that of its law, its contacts listed or not.
  CHECK(state.contacts(2).string_index() == 0);
  CHECK(state.contacts(2).force_w_n(1) == 7.0F);
  CHECK_FALSE(state.has_contacts_total());
}

TEST_CASE("of more contacts than asked for the deepest are listed and all are counted") {
  const v1::State state = encoded(kAll, 1);
  CHECK(state.contacts_total() == 3);
  int listed = 0;
  for (const v1::ContactPatch& patch : state.contacts()) listed += patch.tool_sphere_size();
  CHECK(listed == 1);
  CHECK(state.contacts(0).gap_nanometres(0) == -2);
  CHECK(state.contacts(0).force_w_n(1) == doctest::Approx(1.75));
}

TEST_CASE("tools that touch one object have a patch each, and the deepest of all are listed") {
  auto tick = small_tick();
  ToolTick second;
  second.tool_id = 9;
  second.contacts = 2;
  tick->tools.push_back(second);
  tick->contacts.push_back(contact_at(ObstacleKind::kBody, 4, -5e-9, 4.0));
  tick->contacts.push_back(contact_at(ObstacleKind::kBody, 4, 30e-6, 0.5));
  tick->contacts_total = 5;
  tick->string_forces.push_back({1, 0, {0.0, -2.0, 0.0}});
  v1::State state;
  encode_state(*tick, small_index(), {kAll, 2}, state);
  int listed_of_first = 0;
  double force_of_second = 0.0;
  double string_of_second = 0.0;
  for (const v1::ContactPatch& patch : state.contacts()) {
    if (patch.tool_id() == 5) listed_of_first += patch.tool_sphere_size();
    if (patch.tool_id() != 9) continue;
    if (patch.has_body_index()) {
      force_of_second = patch.force_w_n(1);
      REQUIRE(patch.gap_nanometres_size() == 1);
      CHECK(patch.gap_nanometres(0) == -5);
    }
    if (patch.has_string_index()) string_of_second = patch.force_w_n(1);
  }
  CHECK(listed_of_first == 1);
  CHECK(force_of_second == 4.5);
  CHECK(string_of_second == -2.0);
  CHECK(state.contacts_total() == 5);
}

TEST_CASE("units saturate instead of turning over") {
  auto tick = small_tick();
  tick->contacts.clear();
  tick->contacts.push_back(contact_at(ObstacleKind::kBody, 0, 5.0, 1e9));
  tick->tools[0].contacts = 1;
  v1::State state;
  encode_state(*tick, small_index(), {kAll, 256}, state);
  CHECK(state.contacts(0).gap_nanometres(0) == std::numeric_limits<std::int32_t>::max());
  CHECK(state.contacts(0).force_mn(0) == std::numeric_limits<std::uint32_t>::max());
}

TEST_CASE("a tone carries its instant, its string and its sound") {
  StringEvent event;
  event.kind = StringEventKind::kTone;
  event.t_ns = 19'345'678;
  event.string = 2;
  event.lambda = 0.5;
  event.frequency = 98.0;
  event.amplitude = 0.00390625;
  event.level = 0.75;
  event.partial_count = 2;
  event.partials[0] = 1.0F;
  event.partials[1] = 0.5F;
  const auto item = encode_event(event, {20, 20'000'000, 5}, small_index());
  REQUIRE(item.has_value());
  REQUIRE(item->has_tone());
  const v1::Tone& tone = item->tone();
  CHECK(tone.t_ns() == 19'345'678);
  CHECK(tone.string_index() == 1);
  CHECK(tone.tool_id() == 5);
  CHECK(tone.lambda() == doctest::Approx(0.75));
  CHECK(tone.frequency_hz() == 98.0F);
  CHECK(tone.partials_size() == 2);
}

TEST_CASE(
    "a touch of a string begins a contact, leave and release end it, and a press is no Item") {
  StringEvent event;
  const EventPlace place{1, 1'000'000, 5};
  for (const auto kind :
       {StringEventKind::kTouch, StringEventKind::kLeave, StringEventKind::kRelease}) {
    event.kind = kind;
    const auto item = encode_event(event, place, small_index());
    REQUIRE(item.has_value());
    CHECK(item->contact().phase() ==
          (kind == StringEventKind::kTouch ? v1::CONTACT_PHASE_BEGIN : v1::CONTACT_PHASE_END));
  }
  event.kind = StringEventKind::kPress;
  CHECK_FALSE(encode_event(event, place, small_index()).has_value());
}

TEST_CASE("every cause has words for people, short enough for the wire") {
  for (int cause = 1; cause <= kMaxCause; ++cause) {
    const std::string_view text = explain(static_cast<Cause>(cause));
    CHECK(text.size() > 5);
    CHECK(text.size() <= 400);
    CHECK(v1::Cause_IsValid(cause));
  }
  CHECK_FALSE(v1::Cause_IsValid(kMaxCause + 1));
  const v1::Item item = encode_fault(Cause::kStopped, true, {9, 9'000'000, 5});
  CHECK(item.fault().cause() == v1::CAUSE_STOPPED);
  CHECK(item.fault().latched());
  CHECK(item.fault().tick() == 9);
}

}  // namespace hapticd::test
