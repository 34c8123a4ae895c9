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

/// Where the touch of `string` is: where the tool is nearest to it, or, where it is not near any
/// more, where it was last, at the same place of the tool.
TouchPlace place_of(const Toucher& toucher, std::int32_t string) noexcept {
  const auto& [play, tool, seen] = toucher;
  const Configuration at{play.way.input, play.state.contact};
  if (const auto nearest = nearest_to_string(at, string_pairs(play), string)) {
    return {tool, nearest->part, nearest->p_WC, nearest->nhat_W};
  }
  const Pose& X_WG = play.rendered.X_WG;
  const Quaternion turn = X_WG.q * play.way.X_WG_before.q.conjugate();
  return {tool, seen.part, X_WG.p + turn * seen.p_GC_W, turn * seen.told_nhat_W};
}

}  // namespace

void name_place(std::size_t first, const Toucher& toucher, std::int32_t string,
                StringEvents& events) noexcept {
  if (first == events.size()) return;
  const TouchPlace place = place_of(toucher, string);
  for (std::size_t k = first; k < events.size(); ++k) {
    StringEvent& event = events[k];
    event.tool = place.tool;
    event.part = place.part;
    const bool is_touch = event.kind == StringEventKind::kTouch ||
                          event.kind == StringEventKind::kLeave ||
                          event.kind == StringEventKind::kRelease;
    if (!is_touch) continue;
    event.p_WC = to_array(place.p_WC);
    event.nhat_OG_W = to_array(place.nhat_W);
  }
}

void remember(const Toucher& toucher, std::int32_t string, const StringProximity& near,
              ToolStringState& seen) noexcept {
  const TouchPlace place = place_of(toucher, string);
  seen.v_W = (near.u_W - seen.u_W) / (1e-9 * static_cast<double>(near.touch.time.dt_ns));
  seen.u_W = near.u_W;
  seen.distance = near.touch.distance;
  seen.p_GC_W = place.p_WC - toucher.play.rendered.X_WG.p;
  seen.nhat_W = near.nhat_W;
  seen.told_nhat_W = place.nhat_W;
}

}  // namespace hapticd
