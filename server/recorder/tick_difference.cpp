// See tick_difference.h.
#include "server/recorder/tick_difference.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace hapticd {
namespace {

template <std::size_t N>
bool differ(const std::array<double, N>& a, const std::array<double, N>& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): -0 is not 0 here, and NaN is itself
  return std::memcmp(a.data(), b.data(), sizeof(a)) != 0;
}

bool differ(const PlainWrench& a, const PlainWrench& b) {
  return differ(a.f, b.f) || differ(a.t, b.t);
}

bool differ(const PlainPose& a, const PlainPose& b) { return differ(a.p, b.p) || differ(a.q, b.q); }

/// What of the hand differs first.
std::string_view hand_difference(const ToolTick& a, const ToolTick& b) {
  if (a.tool_id != b.tool_id) return "tool_id";
  if (differ(a.X_WH, b.X_WH)) return "pose_wh";
  return differ(a.V_WH.v, b.V_WH.v) || differ(a.V_WH.w, b.V_WH.w) ? "twist_wh_w" : "";
}

/// What differs first; the wrench that the hand felt before all else.
std::string_view output_difference(const ToolTick& a, const ToolTick& b) {
  if (differ(a.F_written_H_W, b.F_written_H_W)) return "wrench_h_w";
  if (differ(a.F_computed_H_W, b.F_computed_H_W)) return "wrench_unlimited_h_w";
  if (differ(a.X_WG, b.X_WG)) return "pose_wg";
  const std::string_view hand = hand_difference(a, b);
  if (!hand.empty()) return hand;
  if (a.flags != b.flags) return "flags";
  if (a.held != b.held) return "held";
  return differ<1>({a.stiffness.scale}, {b.stiffness.scale}) ? "stiffness_scale" : "";
}

std::string_view loop_difference(const Tick& a, const Tick& b) {
  if (a.tick != b.tick) return "tick";
  if (a.scene_id != b.scene_id) return "scene_id";
  if (a.dt_ns != b.dt_ns) return "dt_ns";
  if (a.state != b.state) return "loop_state";
  if (a.cause != b.cause) return "cause";
  if (a.budget.level != b.budget.level || a.budget.work != b.budget.work ||
      a.work.sub_steps != b.work.sub_steps || a.work.sphere_tests != b.work.sphere_tests ||
      a.work.qp_iterations != b.work.qp_iterations) {
    return "budget";
  }
  return a.tools.size() != b.tools.size() ? "outputs" : "";
}

}  // namespace

std::string tick_difference(const Tick& recorded, const Tick& replayed, Compared compared) {
  const std::size_t tools = std::min(recorded.tools.size(), replayed.tools.size());
  for (std::size_t k = 0; k < tools; ++k) {
    const ToolTick& a = recorded.tools[k];
    const ToolTick& b = replayed.tools[k];
    const std::string_view what =
        compared == Compared::kPoses ? hand_difference(a, b) : output_difference(a, b);
    if (!what.empty()) return std::string(what) + " of tool " + std::to_string(a.tool_id);
  }
  if (compared == Compared::kPoses) return tools < recorded.tools.size() ? "outputs" : "";
  return std::string(loop_difference(recorded, replayed));
}

}  // namespace hapticd
