// See told_bends.h. RT: yes.
#include "core/simulation/told_bends.h"

namespace hapticd {
namespace {

/// Where a bend is along the whole string, and how far from it.
StringBendTick bend_of(const ToolPlay& play, std::int32_t tool, const StringBend& bend) noexcept {
  const StringPart* part = part_of(play.view, bend.capsule);
  if (part == nullptr) return {bend.capsule, tool, bend.lambda, to_array(bend.u_W)};
  const auto string = static_cast<std::size_t>(bend.capsule);
  const Capsule& line = play.scene.obstacles.capsules_W[string];
  const Vector3 p_P = leg_of(part->part_W, bend, 0).capsule_W.p_B;
  const double lambda = lambda_of(line, p_P);
  const Vector3 u_W = p_P - (line.p_A + lambda * (line.p_B - line.p_A));
  return {bend.capsule, tool, lambda, to_array(u_W)};
}

/// Vertices of one string go from A to B in the order of the tools that hold it, whatever rounding
/// makes of places that are nearly the same.
int place_among(const StringSharing& sharing, const StringBendTick& bend) noexcept {
  for (const SharedString& held : sharing) {
    if (held.string != bend.string) continue;
    for (std::size_t k = 0; k < held.holders.size(); ++k) {
      if (held.holders[k] == bend.tool) return static_cast<int>(k);
    }
  }
  return 0;
}

/// Puts the last of the bends where it belongs.
void sort_in_last(const StringSharing& sharing, Tick& tick) noexcept {
  auto& bends = tick.string_bends;
  const auto before = [&](const StringBendTick& a, const StringBendTick& b) {
    if (a.string != b.string) return a.string < b.string;
    return place_among(sharing, a) < place_among(sharing, b);
  };
  for (std::size_t k = bends.size() - 1; k > 0 && before(bends[k], bends[k - 1]); --k) {
    std::swap(bends[k], bends[k - 1]);
  }
}

/// Where strings lie on rests they are bent, too.
void tell_rests(const SimulationMemory& memory, const StringSharing& sharing, Tick& tick) noexcept {
  const ToolScene& scene = memory.tools.front().scene;
  for (const SharedString& held : sharing) {
    const Capsule& line = scene.obstacles.capsules_W[static_cast<std::size_t>(held.string)];
    for (const std::int32_t holder : held.holders) {
      if (!is_rest(holder)) continue;
      const StringRest& rest = scene.rests[rest_of(holder)];
      const Vector3 u_W = rest.p_W - (line.p_A + rest.lambda * (line.p_B - line.p_A));
      const StringBendTick bend{held.string, holder, rest.lambda, to_array(u_W)};
      if (tick.string_bends.push_back(bend)) sort_in_last(sharing, tick);
    }
  }
}

/// Leaves out strings that no vertex bends. One that is straight is left where others bend the
/// string: that one goes through it.
void leave_out_straight(Tick& tick) noexcept {
  auto& bends = tick.string_bends;
  std::size_t kept = 0;
  std::size_t end = 0;
  for (std::size_t first = 0; first < bends.size(); first = end) {
    bool bent = false;
    for (end = first; end < bends.size() && bends[end].string == bends[first].string; ++end) {
      bent = bent || to_vector(bends[end].deflection_W).norm() > kMinToldBend;
    }
    for (std::size_t k = first; bent && k < end; ++k) bends[kept++] = bends[k];
  }
  bends.truncate(kept);
}

}  // namespace

void tell_bends(const SimulationMemory& memory, const StringSharing& sharing, Tick& tick) noexcept {
  tick.string_bends.clear();
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    const ToolPlay& play = memory.tools[k];
    const auto tool = static_cast<std::int32_t>(k);
    for (const TouchedString& string : play.state.contact.touched) {
      if (!string.yields) continue;
      const StringBendTick bend = bend_of(play, tool, string.bend);
      if (tick.string_bends.push_back(bend)) sort_in_last(sharing, tick);
    }
  }
  tell_rests(memory, sharing, tick);
  leave_out_straight(tick);
}

}  // namespace hapticd
