// Ticks, scenes and snapshots to record in tests: numbered, with doubles of every kind.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/math/state_fields.h"
#include "core/tick/tick.h"
#include "hapticd/v1/recording.pb.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// Any bits at all: NaN payloads, infinities, denormals and -0 among them.
inline double any_double(SplitMix64& random) {
  constexpr std::uint64_t kSpecial[] = {0x7FF8000000000123U, 0x7FF0000000000001U,
                                        0xFFF0000000000000U, 0x8000000000000000U, 1U};
  return std::bit_cast<double>(random.chance(0.3) ? kSpecial[random.below(5)] : random.next());
}

/// A tick of `tools` tools with arbitrary numbers in it.
inline Tick any_tick(SplitMix64& random, std::uint64_t number, int tools) {
  Tick tick;
  tick.tick = number;
  tick.t_ns = static_cast<std::int64_t>(number * 1'000'000 % std::uint64_t{kMax_ns / 2});
  tick.dt_ns = 1'000'000;
  tick.work.sphere_tests = random.below(1000);
  tick.work.qp_iterations = static_cast<std::uint32_t>(random.below(100));
  tick.budget.work = random.below(100000);
  tick.work.sub_steps = static_cast<std::uint32_t>(random.below(9));
  tick.budget.level = static_cast<std::uint32_t>(random.below(5));
  tick.scene_id = 1;
  tick.times.cpu_ns = static_cast<std::uint32_t>(random.next());
  tick.skipped = random.below(10);
  tick.change = random.below(10);
  tick.orders = static_cast<std::uint16_t>(random.below(1U << static_cast<unsigned>(kOrderBits)));
  tick.first = random.chance(0.5);
  tick.state = static_cast<LoopState>(1 + random.below(7));
  tick.cause = static_cast<Cause>(random.below(kMaxCause + 1));
  for (int k = 0; k < tools; ++k) {
    ToolTick& tool = *tick.tools.append();
    tool = {};
    DeviceSample& sample = tool.sample;
    tool.tool_id = static_cast<std::uint32_t>(random.below(32));
    sample.buttons = static_cast<std::uint16_t>(random.next());
    tool.flags = static_cast<std::uint16_t>(random.next());
    tool.came = random.chance(0.5);
    tool.held = random.chance(0.5);
    sample.has_velocity = random.chance(0.5);
    tool.lost = random.chance(0.5);
    tool.write_failed = random.chance(0.5);
    tool.asked = {random.chance(0.5), random.chance(0.5),
                  static_cast<PushAxis>(random.below(kPushAxes + 1)),
                  static_cast<PushAxis>(random.below(kPushAxes + 1))};
    sample.flags = static_cast<std::uint16_t>(random.next());
    // Instants within kMax_ns, others are refused; so is the age that follows from them.
    sample.t_ns = static_cast<std::int64_t>(random.next()) / 8;
    sample.counter = random.next();
    tool.stiffness.scale = random.uniform();
    if (random.chance(0.5)) sample.measured_delay_s = random.uniform();
    for (Array3* a : {&sample.p_DH, &sample.v_DH_D, &sample.w_DH_D, &tool.X_WH.p, &tool.V_WH.v,
                      &tool.V_WH.w, &tool.X_WG.p, &tool.F_computed_H_W.f, &tool.F_computed_H_W.t,
                      &tool.F_written_H_W.f, &tool.F_written_H_W.t}) {
      for (double& x : *a) x = any_double(random);
    }
    for (Array4* a : {&sample.q_DH, &tool.X_WH.q, &tool.X_WG.q}) {
      for (double& x : *a) x = any_double(random);
    }
    if (!sample.has_velocity) sample.v_DH_D = sample.w_DH_D = {};
    if (!tool.came) {
      sample.p_DH = {};
      sample.q_DH = {1.0, 0.0, 0.0, 0.0};
    }
  }
  return tick;
}

inline v1::RecordHeader sample_header() {
  v1::RecordHeader header;
  header.set_server_version("test");
  header.set_period_ns(1'000'000);
  return header;
}

inline v1::SceneRecord sample_scene(std::uint32_t id) {
  v1::SceneRecord record;
  record.set_scene_id(id);
  record.mutable_scene()->set_name("scene_" + std::to_string(id));
  return record;
}

inline v1::Snapshot sample_snapshot(std::uint64_t next_tick) {
  v1::Snapshot snapshot;
  snapshot.set_next_tick(next_tick);
  return snapshot;
}

/// A folder of its own that is gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name =
        (std::filesystem::temp_directory_path() / "hapticd-recorder-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace hapticd::test
