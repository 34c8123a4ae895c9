// See rest_meeting.h. RT: yes.
#include "core/simulation/rest_meeting.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/instrument/wave_string.h"

namespace hapticd {
namespace {

/// A tool this near to a place of a surface presses the string on the surface, m.
constexpr double kSurfaceGap = 12e-3;
/// What the tick may move a string by beyond its swing, m.
constexpr double kRestMargin = 1e-3;

/// A rest, and how far the string as it is bent is above it, m.
struct NearRest {
  std::size_t number;
  double gap;
};
using NearRests = FixedVector<NearRest, kMaxWaveRests>;

/// The string's way from A to B, bent as the static laws have it, and how it swings about it.
struct BentWay {
  StringPoints points;
  std::array<double, decltype(StringPoints{})::capacity()> lambda;
};

void find_way(const Playing& playing, BentWay& way) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  StringTools views;
  string_points(string_tools(memory, views), playing.wave.sharing, playing.wave.string, -1,
                way.points);
  const Capsule& line =
      memory.tools.front()
          .scene.obstacles.capsules_W[static_cast<std::size_t>(playing.wave.string)];
  for (std::size_t k = 0; k < way.points.size(); ++k) {
    way.lambda[k] = lambda_of(line, way.points[k]);
  }
  way.lambda[way.points.size() - 1] = 1.0;
}

/// How far above `rest` the way is, m.
double gap_to(const BentWay& way, const StringRest& rest) noexcept {
  std::size_t leg = 0;
  while (leg + 2 < way.points.size() && way.lambda[leg + 1] < rest.lambda) ++leg;
  const double length = way.lambda[leg + 1] - way.lambda[leg];
  const double share = length > 0.0 ? (rest.lambda - way.lambda[leg]) / length : 0.0;
  const Vector3 p_W = way.points[leg] + share * (way.points[leg + 1] - way.points[leg]);
  return (p_W - rest.p_W).dot(rest.nhat_W);
}

/// Rests that stand under a tool have numbers from here on.
constexpr std::int32_t kUnderTool = 1 << 20;

/// Rests beside tools that press the string on a surface.
using Replaced = FixedVector<std::int32_t, 2 * kMaxTools>;

/// The rests of a surface beside a holder of the string, that it presses the string on; null: none.
struct BesideTool {
  const StringRest* towards_A = nullptr;
  const StringRest* towards_B = nullptr;
};

BesideTool beside_tool(const Playing& playing, const SharedString& held, std::size_t slot,
                       double lambda) noexcept {
  const std::span<const StringRest> all = playing.wave.memory.tools.front().scene.rests;
  const auto near = [&](std::size_t index) -> const StringRest* {
    if (index >= held.holders.size() || !is_rest(held.holders[index])) return nullptr;
    const StringRest& rest = all[rest_of(held.holders[index])];
    const double way = std::abs(rest.lambda - lambda) * playing.string.length;
    return rest.surface && way <= kSurfaceGap ? &rest : nullptr;
  };
  return {slot > 0 ? near(slot - 1) : nullptr, near(slot + 1)};
}

/// Of a string that lies on the surface at lambda, m.
Transverse surface_at(const Playing& playing, const BesideTool& beside, double lambda) noexcept {
  const auto d = [&](const StringRest& rest) {
    return across(playing.frame,
                  rest.p_W - playing.frame.p_WA - rest.lambda * playing.frame.axis_W);
  };
  if (beside.towards_A == nullptr) return d(*beside.towards_B);
  if (beside.towards_B == nullptr) return d(*beside.towards_A);
  const Transverse from = d(*beside.towards_A);
  const Transverse to = d(*beside.towards_B);
  const double length = beside.towards_B->lambda - beside.towards_A->lambda;
  const double share = length > 0.0 ? (lambda - beside.towards_A->lambda) / length : 0.0;
  return {from.y + share * (to.y - from.y), from.z + share * (to.z - from.z)};
}

/// A surface goes on between its places: where a tool presses the string on it, it is right under
/// the tool, and sounds from there. The contact problem, which has it yield between the places,
/// lets the tool in a little further.
void put_under_tools(const Playing& playing, NearTools& tools, const Touches& touches,
                     WaveRestTouches& rests, Replaced& replaced) noexcept {
  for (const SharedString& held : playing.wave.sharing) {
    if (held.string != playing.wave.string) continue;
    for (std::size_t k = 0; k < held.holders.size(); ++k) {
      if (is_rest(held.holders[k])) continue;
      const auto tool = static_cast<std::size_t>(held.holders[k]);
      if (touches[tool] == nullptr || !(touches[tool]->force > 0.0)) continue;
      WaveTouch& touch = tools[tool].touch;
      const BesideTool beside = beside_tool(playing, held, k, touch.lambda);
      const StringRest* rest = beside.towards_A != nullptr ? beside.towards_A : beside.towards_B;
      if (rest == nullptr) continue;
      if (beside.towards_A != nullptr) replaced.push_back(held.holders[k - 1]);
      if (beside.towards_B != nullptr) replaced.push_back(held.holders[k + 1]);
      const Transverse n = across(playing.frame, rest->nhat_W);
      const Transverse d = surface_at(playing, beside, touch.lambda);
      const Transverse u{touch.centre.y - touch.radius * touch.normal.y,
                         touch.centre.z - touch.radius * touch.normal.z};
      const double in = std::max(0.0, (d.y - u.y) * n.y + (d.z - u.z) * n.z);
      touch.centre = {touch.centre.y + in * n.y, touch.centre.z + in * n.z};
      rests.push_back({kUnderTool + held.holders[k], touch.lambda, d, n, rest->friction});
    }
  }
}

/// Among the nearest, if it is one of them.
void keep_nearest(const NearRest& rest, NearRests& nearest) noexcept {
  if (nearest.full()) {
    if (!(rest.gap < nearest[nearest.size() - 1].gap)) return;
    nearest[nearest.size() - 1] = rest;
  } else {
    nearest.push_back(rest);
  }
  for (std::size_t k = nearest.size() - 1; k > 0 && nearest[k].gap < nearest[k - 1].gap; --k) {
    std::swap(nearest[k], nearest[k - 1]);
  }
}

}  // namespace

void find_rests(const Playing& playing, NearTools& tools, const Touches& touches,
                WaveRestTouches& rests) noexcept {
  const std::span<const StringRest> all = playing.wave.memory.tools.front().scene.rests;
  const WaveState& state = playing.kept.state;
  if (all.empty()) return;
  BentWay way;
  find_way(playing, way);
  Replaced replaced;
  put_under_tools(playing, tools, touches, rests, replaced);
  // What modes cannot tell from the place under a tool is that place.
  const double cell = 1.0 / std::max(state.string.count, 1);
  const auto is_under_tool = [&](const StringRest& rest) {
    return rest.surface && std::any_of(rests.begin(), rests.end(), [&](const WaveRestTouch& under) {
             return std::abs(under.lambda - rest.lambda) < cell;
           });
  };
  NearRests nearest;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::int32_t holder = rest_holder(k);
    if (all[k].string != playing.wave.string) continue;
    if (std::find(replaced.begin(), replaced.end(), holder) != replaced.end()) continue;
    if (is_under_tool(all[k])) continue;
    const double gap = gap_to(way, all[k]);
    const double swing = reach_of(state.string.tuning, state.ringing, all[k].lambda);
    if (gap <= swing + kRestMargin) keep_nearest({k, gap}, nearest);
  }
  for (const NearRest& near : nearest) {
    const StringRest& rest = all[near.number];
    const Vector3 at_rest_W = playing.frame.p_WA + rest.lambda * playing.frame.axis_W;
    rests.push_back({static_cast<std::int32_t>(near.number), rest.lambda,
                     across(playing.frame, rest.p_W - at_rest_W),
                     across(playing.frame, rest.nhat_W), rest.friction});
  }
}

}  // namespace hapticd
