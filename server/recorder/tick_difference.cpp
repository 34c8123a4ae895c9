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

/// What differs first; the wrench that the hand felt before all else.
std::string_view output_difference(const ToolTrace& a, const ToolTrace& b) {
  if (differ(a.f_H_W, b.f_H_W) || differ(a.t_H_W, b.t_H_W)) return "wrench_h_w";
  if (differ(a.f_computed_H_W, b.f_computed_H_W) || differ(a.t_computed_H_W, b.t_computed_H_W)) {
    return "wrench_unlimited_h_w";
  }
  if (differ(a.p_WG, b.p_WG) || differ(a.q_WG, b.q_WG)) return "pose_wg";
  if (differ(a.p_WH, b.p_WH) || differ(a.q_WH, b.q_WH)) return "pose_wh";
  if (differ(a.v_WH_W, b.v_WH_W) || differ(a.w_WH_W, b.w_WH_W)) return "twist_wh_w";
  if (a.flags != b.flags) return "flags";
  if (a.held != b.held) return "held";
  if (differ<1>({a.stiffness_scale}, {b.stiffness_scale})) return "stiffness_scale";
  return a.tool_id != b.tool_id ? "tool_id" : "";
}

std::string_view loop_difference(const TickTrace& a, const TickTrace& b) {
  if (a.tick != b.tick) return "tick";
  if (a.scene_id != b.scene_id) return "scene_id";
  if (a.dt_ns != b.dt_ns) return "dt_ns";
  if (a.loop_state != b.loop_state) return "loop_state";
  if (a.cause != b.cause) return "cause";
  if (a.level != b.level || a.substeps != b.substeps || a.sphere_tests != b.sphere_tests ||
      a.qp_iterations != b.qp_iterations || a.work_budget != b.work_budget) {
    return "budget";
  }
  return a.tool_count != b.tool_count ? "outputs" : "";
}

}  // namespace

std::string tick_difference(const TickTrace& recorded, const TickTrace& replayed) {
  const auto tools = static_cast<std::size_t>(std::min(recorded.tool_count, replayed.tool_count));
  for (std::size_t k = 0; k < tools; ++k) {
    const std::string_view what = output_difference(recorded.tools[k], replayed.tools[k]);
    if (!what.empty()) {
      return std::string(what) + " of tool " + std::to_string(recorded.tools[k].tool_id);
    }
  }
  return std::string(loop_difference(recorded, replayed));
}

}  // namespace hapticd
