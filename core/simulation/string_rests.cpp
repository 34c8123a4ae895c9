// See string_rests.h. RT: yes.
#include "core/simulation/string_rests.h"

#include <algorithm>

namespace hapticd {
namespace {

/// A rest that would bend a string by less does not hold it, m: rounding of where it lies.
constexpr double kLeastLift = 1e-9;

using Holders = decltype(SharedString::holders);

/// A point of the string's way.
struct WayPoint {
  std::int32_t holder = 0;
  double lambda = 0.0;
  Vector3 p_W;
};

/// Ends, tools, and what rests are found on the way; from A to B.
using Way = FixedVector<WayPoint, kMaxTools + kMaxHeldRests + 2>;

/// The rests of a string, and the number of the first.
struct Rests {
  std::span<const StringRest> all;
  std::size_t first;
};

Rests rests_of(const StringTool& tool, std::int32_t string) noexcept {
  const std::span<const StringRest> all = tool.scene->rests;
  const auto* const from =
      std::lower_bound(all.data(), all.data() + all.size(), string,
                       [](const StringRest& rest, std::int32_t s) { return rest.string < s; });
  const StringRest* to = from;
  while (to != all.data() + all.size() && to->string == string) ++to;
  return {{from, to}, static_cast<std::size_t>(from - all.data())};
}

/// How far the straight way from `a` to `b` passes below a rest, m; negative: above.
double lift(const WayPoint& a, const WayPoint& b, const StringRest& rest) noexcept {
  const double length = b.lambda - a.lambda;
  const double share = length > 0.0 ? (rest.lambda - a.lambda) / length : 0.5;
  return (rest.p_W - a.p_W - share * (b.p_W - a.p_W)).dot(rest.nhat_W);
}

/// What would lift the string most.
struct Highest {
  double lift = kLeastLift;
  std::size_t leg = 0;
  std::size_t rest = 0;
};

bool is_on(const Way& way, std::int32_t holder) noexcept {
  return std::any_of(way.begin(), way.end(),
                     [&](const WayPoint& point) { return point.holder == holder; });
}

Highest find_highest(const Way& way, const Rests& rests) noexcept {
  Highest highest;
  for (std::size_t k = 0; k < rests.all.size(); ++k) {
    const StringRest& rest = rests.all[k];
    for (std::size_t leg = 0; leg + 1 < way.size(); ++leg) {
      if (rest.lambda < way[leg].lambda || rest.lambda > way[leg + 1].lambda) continue;
      const double by = lift(way[leg], way[leg + 1], rest);
      if (by <= highest.lift || is_on(way, rest_holder(rests.first + k))) continue;
      highest = {by, leg, rests.first + k};
    }
  }
  return highest;
}

/// Ends and tools. The ends' numbers are no holders'.
void begin_way(std::span<const StringTool> tools, const SharedString& held, Way& way) noexcept {
  const Capsule& line =
      tools.front().scene->obstacles.capsules_W[static_cast<std::size_t>(held.string)];
  constexpr auto kEnd = static_cast<std::int32_t>(kMaxTools);
  way.push_back({kEnd, 0.0, line.p_A});
  for (const std::int32_t holder : held.holders) {
    if (is_rest(holder)) continue;
    const StringTool& tool = tools[static_cast<std::size_t>(holder)];
    const TouchedString* hold = yielding_hold(tool, held.string);
    if (hold == nullptr) continue;
    const Vector3 p_W = vertex_of(tool, *hold);
    way.push_back({holder, lambda_of(line, p_W), p_W});
  }
  way.push_back({kEnd, 1.0, line.p_B});
}

/// The holders of the shortest way. Each rest found lifts the string furthest, so none that was
/// found before comes free.
Holders lay_over(std::span<const StringTool> tools, const SharedString& held) noexcept {
  Way way;
  begin_way(tools, held, way);
  const Rests rests = rests_of(tools.front(), held.string);
  for (std::size_t k = 0; k < kMaxHeldRests && !rests.all.empty(); ++k) {
    const Highest highest = find_highest(way, rests);
    if (!(highest.lift > kLeastLift)) break;
    const StringRest& rest = tools.front().scene->rests[highest.rest];
    way.push_back({rest_holder(highest.rest), rest.lambda, rest.p_W});
    std::rotate(way.begin() + highest.leg + 1, way.end() - 1, way.end());
  }
  Holders found;
  for (std::size_t k = 1; k + 1 < way.size(); ++k) found.push_back(way[k].holder);
  return found;
}

bool same(const Holders& a, const Holders& b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool holds(const SharedString& held, std::int32_t tool) noexcept {
  return std::find(held.holders.begin(), held.holders.end(), tool) != held.holders.end();
}

/// Only rests are left.
bool is_left(const SharedString& held) noexcept {
  return std::all_of(held.holders.begin(), held.holders.end(), is_rest);
}

/// Where a tool that no longer holds its part of the string presses a part beside it, it goes there:
/// the slot of that part, -1: it does not.
std::int32_t next_slot(const StringTool& self, const SharedString& held) noexcept {
  const StringPart* part = part_of(*self.view, held.string);
  if (part == nullptr) return -1;
  const std::size_t capsules = self.scene->obstacles.capsules_W.size();
  for (const ActivePair& pair : self.view->rigid_active) {
    const auto number = static_cast<std::size_t>(pair.key.obstacle) - capsules;
    if (number >= self.view->rigid.size() || !(pair.multiplier > 0.0)) continue;
    const RigidPart& rigid = self.view->rigid[number];
    if (rigid.string != held.string) continue;
    if (rigid.lambda_from == part->lambda_to) return part->slot + 1;
    if (rigid.lambda_to == part->lambda_from) return part->slot - 1;
  }
  return -1;
}

/// Holds the next part, if there is a rest between and the tool presses that.
bool go_over(const StringTool& self, std::int32_t tool, SharedString& held) noexcept {
  const std::int32_t slot = next_slot(self, held);
  const auto count = static_cast<std::int32_t>(held.holders.size());
  if (slot < 0 || slot > count) return false;
  const StringPart* part = part_of(*self.view, held.string);
  const auto between = static_cast<std::size_t>(std::min(slot, part->slot));
  if (between >= held.holders.size() || !is_rest(held.holders[between])) return false;
  held.holders.push_back(tool);
  std::rotate(held.holders.begin() + slot, held.holders.end() - 1, held.holders.end());
  return true;
}

}  // namespace

bool settle_rests(std::span<const StringTool> tools, std::int32_t tool,
                  StringSharing& holders) noexcept {
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  bool settled = true;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    SharedString& held = holders[k];
    const bool was_near = part_of(*self.view, held.string) != nullptr;
    if (holds(held, tool)) {
      const Holders found = lay_over(tools, held);
      settled = settled && same(found, held.holders);
      held.holders = found;
    } else if (!was_near || !go_over(self, tool, held)) {
      if (is_left(held)) continue;
      if (was_near) held.holders = lay_over(tools, held);
    }
    if (kept != k) holders[kept] = held;
    ++kept;
  }
  holders.truncate(kept);
  return settled;
}

}  // namespace hapticd
