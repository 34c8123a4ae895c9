// What is shown live and what is shown of its recording. Truth: the State that a client gets of the
// same tick.
#include "proto/recording/recorded_state.h"

#include <doctest/doctest.h>

#include <memory>

#include "server/recorder/tick_record.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

SceneIndex index_of_strings(int count) {
  SceneIndex index;
  for (int k = 0; k < count; ++k) {
    index.pieces.push_back({static_cast<std::uint32_t>(k), true, 1e-3, 0.0, 1.0});
  }
  return index;
}

constexpr int kStrings = 40;

/// A tick with strings, contacts and all else that is shown.
std::unique_ptr<Tick> shown_tick(SplitMix64& random) {
  auto tick = std::make_unique<Tick>(any_tick(random, random.below(1'000'000), 3));
  for (std::uint32_t& time_ns : tick->times.stages) {
    time_ns = 1 + static_cast<std::uint32_t>(random.below(1'000'000));
  }
  std::int32_t id = 0;
  for (ToolTick& tool : tick->tools) {
    tool.tool_id = static_cast<std::uint32_t>(++id);
    tool.came = true;
    // Numbers as ticks have them: finite.
    for (Array3* a : {&tool.sample.p_DH, &tool.X_WH.p, &tool.X_WG.p, &tool.F_computed_H_W.f,
                      &tool.F_computed_H_W.t, &tool.F_written_H_W.f, &tool.F_written_H_W.t}) {
      for (double& x : *a) x = random.uniform(-1.0, 1.0);
    }
    for (Array4* a : {&tool.sample.q_DH, &tool.X_WH.q, &tool.X_WG.q}) {
      for (double& x : *a) x = random.uniform(-1.0, 1.0);
    }
    if (random.chance(0.3)) tool.F_computed_H_W = tool.F_written_H_W;
    tool.contact.minimum_gap = random.uniform(-1.0, 1.0);
    tool.port = {random.uniform(), random.uniform()};
    tool.gesture.plays = random.chance(0.5);
    tool.contacts = static_cast<std::int32_t>(random.below(20));
    for (std::int32_t k = 0; k < tool.contacts; ++k) {
      ContactTick contact;
      contact.key.obstacle = static_cast<std::int32_t>(random.below(kStrings));
      contact.key.kind = random.chance(0.5) ? ObstacleKind::kBody : ObstacleKind::kCapsule;
      contact.gap = 1e-4 * random.uniform(-1.0, 1.0);
      contact.force = random.uniform();
      contact.nhat_OG_W = random.direction();
      tick->contacts.push_back(contact);
    }
  }
  tick->contacts_total = static_cast<std::int32_t>(tick->contacts.size());
  for (std::int32_t k = 0; k < kStrings; ++k) {
    if (random.chance(0.5)) continue;
    const bool touched = random.chance(0.5);
    tick->strings.push_back({k, 0, StringPhase::kModes, touched, false, random.uniform(), 1e-3});
    if (touched) tick->string_forces.push_back({0, k, random.direction()});
  }
  return tick;
}

}  // namespace

TEST_CASE("a recorded tick shows what was shown live, strings and contacts included") {
  SplitMix64 random(17);
  const SceneIndex index = index_of_strings(kStrings);
  for (std::int64_t k = 0; k < scaled(300); ++k) {
    const std::unique_ptr<Tick> tick = shown_tick(random);
    v1::TickRecord record;
    to_record(*tick, record);
    add_shown(*tick, index, record);
    v1::TickRecord read;
    REQUIRE(read.ParseFromString(record.SerializeAsString()));
    v1::State live;
    constexpr std::uint32_t kSections = kCanonicalSections | 1U << v1::SECTION_STAGES;
    encode_state(*tick, index, {kSections, kShownContacts}, live);
    live.mutable_timing()->set_last_ns(tick->times.cpu_ns);
    const bool same = state_of(read).SerializeAsString() == live.SerializeAsString();
    CHECK(same);
    CHECK(live.strings_size() > 0);
    CHECK(live.contacts_size() > 0);
  }
}

TEST_CASE("of a tick without a State tools and devices are shown, and nothing is guessed") {
  SplitMix64 random(18);
  v1::TickRecord record;
  to_record(*shown_tick(random), record);
  const v1::State state = state_of(record);
  CHECK(state.tools_size() == 3);
  CHECK(state.devices_size() == 3);
  CHECK(state.strings_size() + state.contacts_size() + state.stiffness_size() == 0);
  CHECK_FALSE(state.has_energy());
  CHECK_FALSE(state.has_quality());
}

TEST_CASE("of what is damaged as much is shown as there is") {
  v1::TickRecord record;
  record.add_inputs()->set_tool_id(3);
  CHECK(state_of(record).tools_size() == 0);
  record.add_outputs();
  const v1::State state = state_of(record);
  REQUIRE(state.tools_size() == 1);
  CHECK(state.tools(0).tool_id() == 3);
  CHECK(state.tools(0).p_wh_m_size() == 0);
}

}  // namespace hapticd::test
