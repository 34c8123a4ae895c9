// See touch_place.h. RT: yes.
#include "core/simulation/touch_place.h"

namespace hapticd {
namespace {

/// Whose touch events are, and where it is.
struct TouchPlace {
  std::int32_t tool;
  std::int32_t part;
  Vector3 p_WC;
  Vector3 nhat_W;
};

/// Where the touch is: where the tool is nearest to the string, or, where it is not near any more,
/// where it was last, at the same place of the tool.
TouchPlace place_of(const Toucher& toucher) noexcept {
  const auto& [play, tool, string, time, seen] = toucher;
  const Configuration at{play.way.input, play.state.contact};
  if (const auto nearest = nearest_to_string(at, string_pairs(play), string)) {
    return {tool, nearest->part, nearest->p_WC, nearest->nhat_W};
  }
  const Pose& X_WG = play.rendered.X_WG;
  const Quaternion turn = X_WG.q * play.way.X_WG_before.q.conjugate();
  return {tool, seen.part, X_WG.p + turn * seen.p_GC_W, turn * seen.told_nhat_W};
}

std::int64_t start_of(const TickTime& time) noexcept { return time.t_ns - time.dt_ns; }

}  // namespace

void name_place(std::size_t first, const Toucher& toucher, StringEvents& events) noexcept {
  if (first == events.size()) return;
  const ToolStringState& seen = toucher.seen;
  const TouchPlace now = place_of(toucher);
  const TouchPlace left{toucher.tool, seen.left_part, seen.left_p_WC, seen.left_nhat_W};
  for (std::size_t k = first; k < events.size(); ++k) {
    StringEvent& event = events[k];
    const bool is_end =
        event.kind == StringEventKind::kLeave || event.kind == StringEventKind::kRelease;
    const TouchPlace& place = is_end && event.t_ns <= start_of(toucher.time) ? left : now;
    event.tool = place.tool;
    event.part = place.part;
    if (!is_end && event.kind != StringEventKind::kTouch) continue;
    event.p_WC = to_array(place.p_WC);
    event.nhat_OG_W = to_array(place.nhat_W);
  }
}

void remember(const Toucher& toucher, const StringProximity& near, std::int64_t touched_ns,
              ToolStringState& seen) noexcept {
  const TouchPlace place = place_of(toucher);
  seen.v_W = (near.u_W - seen.u_W) / (1e-9 * static_cast<double>(near.touch.time.dt_ns));
  seen.u_W = near.u_W;
  seen.distance = near.touch.distance;
  seen.p_GC_W = place.p_WC - toucher.play.rendered.X_WG.p;
  seen.nhat_W = near.nhat_W;
  seen.told_nhat_W = place.nhat_W;
  if (touched_ns <= start_of(toucher.time)) return;
  seen.left_p_WC = place.p_WC;
  seen.left_nhat_W = place.nhat_W;
  seen.left_part = place.part;
}

}  // namespace hapticd
