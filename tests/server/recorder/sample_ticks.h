// Ticks, scenes and snapshots to record in tests: numbered, with doubles of every kind.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/math/state_fields.h"
#include "hapticd/v1/recording.pb.h"
#include "server/haptic_loop/tick_trace.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// Any bits at all: NaN payloads, infinities, denormals and -0 among them.
inline double any_double(SplitMix64& random) {
  constexpr std::uint64_t kSpecial[] = {0x7FF8000000000123U, 0x7FF0000000000001U,
                                        0xFFF0000000000000U, 0x8000000000000000U, 1U};
  return std::bit_cast<double>(random.chance(0.3) ? kSpecial[random.below(5)] : random.next());
}

/// A tick of `tools` tools with arbitrary numbers in it.
inline TickTrace any_tick(SplitMix64& random, std::uint64_t tick, int tools) {
  TickTrace trace;
  trace.tick = tick;
  trace.t_ns = tick * 1'000'000 % std::uint64_t{kMax_ns};
  trace.dt_ns = 1'000'000;
  trace.state_hash = random.next();
  trace.sphere_tests = random.below(1000);
  trace.qp_iterations = random.below(100);
  trace.work_budget = random.below(100000);
  trace.substeps = static_cast<std::uint32_t>(random.below(9));
  trace.level = static_cast<std::uint32_t>(random.below(5));
  trace.scene_id = 1;
  trace.cpu_ns = static_cast<std::uint32_t>(random.next());
  trace.skipped = random.below(10);
  trace.change = random.below(10);
  trace.orders = static_cast<std::uint16_t>(random.below(1U << static_cast<unsigned>(kOrderBits)));
  trace.first = random.chance(0.5);
  trace.loop_state = static_cast<LoopState>(1 + random.below(7));
  trace.cause = static_cast<Cause>(random.below(kMaxCause + 1));
  trace.tool_count = tools;
  for (int k = 0; k < tools; ++k) {
    ToolTrace& tool = trace.tools[static_cast<std::size_t>(k)];
    tool.tool_id = static_cast<std::uint32_t>(random.below(32));
    tool.buttons = static_cast<std::uint16_t>(random.next());
    tool.flags = static_cast<std::uint16_t>(random.next());
    tool.sample_came = random.chance(0.5);
    tool.held = random.chance(0.5);
    tool.has_velocity = random.chance(0.5);
    tool.lost = random.chance(0.5);
    tool.write_failed = random.chance(0.5);
    tool.recentre = random.chance(0.5);
    tool.clutch_open = random.chance(0.5);
    tool.push = static_cast<PushAxis>(random.below(kPushAxes + 1));
    tool.device_flags = static_cast<std::uint16_t>(random.next());
    // Instants within kMax_ns, others are refused.
    tool.sample_t_ns = static_cast<std::int64_t>(random.next()) / 2;
    tool.sample_counter = random.next();
    tool.age_ns = random.next() / 4;
    tool.stiffness_scale = random.uniform();
    if (random.chance(0.5)) tool.measured_delay_s = random.uniform();
    for (Array3* a :
         {&tool.p_DH, &tool.v_DH_D, &tool.w_DH_D, &tool.p_WH, &tool.v_WH_W, &tool.w_WH_W,
          &tool.p_WG, &tool.f_computed_H_W, &tool.t_computed_H_W, &tool.f_H_W, &tool.t_H_W}) {
      for (double& x : *a) x = any_double(random);
    }
    for (Array4* a : {&tool.q_DH, &tool.q_WH, &tool.q_WG}) {
      for (double& x : *a) x = any_double(random);
    }
    if (!tool.has_velocity) tool.v_DH_D = tool.w_DH_D = {};
    if (!tool.sample_came) {
      tool.p_DH = {};
      tool.q_DH = {1.0, 0.0, 0.0, 0.0};
    }
  }
  return trace;
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
        (std::filesystem::temp_directory_path() / "hapticd-telemetry-XXXXXX").string();
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
