// See string_rests.h. RT: yes.
#include "core/simulation/string_rests.h"

#include <algorithm>

namespace hapticd {
namespace {

/// A rest that would bend a string by less does not hold it, m: rounding of where it lies.
constexpr double kLeastLift = 1e-9;
/// And one that holds it is left where the string would pass so far above it, m: a tool touches a
/// string beside its vertex, too. Larger: a rest pulls a string that leaves it.
constexpr double kLetGoLift = -5e-6;
/// A place nearer to an end of its part, as a share of it, is at the end.
constexpr double kAtEnd = 1e-9;

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

/// What would lift the string most, beyond what a rest needs to hold it.
struct Highest {
  double lift = 0.0;
  std::size_t leg = 0;
  std::size_t rest = 0;
};

bool is_on(const Way& way, std::int32_t holder) noexcept {
  return std::any_of(way.begin(), way.end(),
                     [&](const WayPoint& point) { return point.holder == holder; });
}

Highest find_highest(const Way& way, const Rests& rests, const Holders& before) noexcept {
  Highest highest;
  std::size_t leg = 0;
  for (std::size_t k = 0; k < rests.all.size(); ++k) {
    const StringRest& rest = rests.all[k];
    while (leg + 2 < way.size() && way[leg + 1].lambda < rest.lambda) ++leg;
    const double by = lift(way[leg], way[leg + 1], rest);
    if (by - kLetGoLift <= highest.lift) continue;
    const std::int32_t holder = rest_holder(rests.first + k);
    const bool held = std::find(before.begin(), before.end(), holder) != before.end();
    const double beyond = by - (held ? kLetGoLift : kLeastLift);
    if (beyond <= highest.lift || is_on(way, holder)) continue;
    highest = {beyond, leg, rests.first + k};
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
    const TouchedString* hold = hold_of(*tool.state, held.string);
    if (hold == nullptr) continue;
    const Vector3 p_W = vertex_of(tool, *hold);
    way.push_back({holder, lambda_of(line, p_W), p_W});
  }
  way.push_back({kEnd, 1.0, line.p_B});
}

/// Puts a rest into the leg that it is on.
void put(const StringTool& tool, std::int32_t holder, Way& way) noexcept {
  const StringRest& rest = tool.scene->rests[rest_of(holder)];
  std::size_t leg = 0;
  while (leg + 2 < way.size() && way[leg + 1].lambda < rest.lambda) ++leg;
  way.push_back({holder, rest.lambda, rest.p_W});
  std::rotate(way.begin() + leg + 1, way.end() - 1, way.end());
}

using PressedRests = FixedVector<std::int32_t, 2>;

/// The holders of the shortest way over the rests, those that a tool presses in any case. Each that
/// is found lifts the string furthest, so none that was found before comes free.
Holders lay_over(std::span<const StringTool> tools, const SharedString& held,
                 const PressedRests& pressed) noexcept {
  Way way;
  begin_way(tools, held, way);
  for (const std::int32_t holder : pressed) put(tools.front(), holder, way);
  const Rests rests = rests_of(tools.front(), held.string);
  for (std::size_t k = pressed.size(); k < kMaxHeldRests && !rests.all.empty(); ++k) {
    const Highest highest = find_highest(way, rests, held.holders);
    if (!(highest.lift > 0.0)) break;
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

/// The parts beside its own that a tool presses.
struct BesidePressed {
  bool towards_A = false;
  bool towards_B = false;
};

BesidePressed beside_pressed(const StringTool& self, std::int32_t string) noexcept {
  BesidePressed pressed;
  const StringPart* part = part_of(*self.view, string);
  if (part == nullptr) return pressed;
  const std::size_t capsules = self.scene->obstacles.capsules_W.size();
  for (const ActivePair& pair : self.view->rigid_active) {
    const auto number = static_cast<std::size_t>(pair.key.obstacle) - capsules;
    if (number >= self.view->rigid.size() || !(pair.multiplier > 0.0)) continue;
    const RigidPart& rigid = self.view->rigid[number];
    if (rigid.string != string) continue;
    if (rigid.lambda_from == part->lambda_to) pressed.towards_B = true;
    if (rigid.lambda_to == part->lambda_from) pressed.towards_A = true;
  }
  return pressed;
}

/// Rests that the tool itself presses the string on: a finger on top of a fret, whatever way the
/// string takes.
PressedRests pressed_rests(const StringTool& self, std::int32_t tool,
                           const SharedString& held) noexcept {
  PressedRests pressed;
  const BesidePressed beside = beside_pressed(self, held.string);
  const Holders& holders = held.holders;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    if (holders[k] != tool) continue;
    if (beside.towards_A && k > 0 && is_rest(holders[k - 1])) pressed.push_back(holders[k - 1]);
    if (beside.towards_B && k + 1 < holders.size() && is_rest(holders[k + 1])) {
      pressed.push_back(holders[k + 1]);
    }
  }
  return pressed;
}

/// A tool that has come to the end of its part of the string, or off it, and presses the one beside
/// it has gone over the rest between them, and holds that one from now on. False: it has not.
bool go_over(const StringTool& self, std::int32_t tool, SharedString& held) noexcept {
  const BesidePressed beside = beside_pressed(self, held.string);
  const TouchedString* hold = hold_of(*self.state, held.string);
  const double lambda = hold != nullptr ? hold->bend.lambda : 0.5;
  const bool to_B = beside.towards_B && (hold == nullptr || lambda >= 1.0 - kAtEnd);
  const bool to_A = beside.towards_A && (hold == nullptr || lambda <= kAtEnd);
  if (!to_A && !to_B) return false;
  Holders& holders = held.holders;
  auto slot = static_cast<std::size_t>(part_of(*self.view, held.string)->slot);
  if (hold == nullptr) {
    // It was taken off.
    holders.push_back(tool);
    std::rotate(holders.begin() + slot, holders.end() - 1, holders.end());
  } else {
    slot =
        static_cast<std::size_t>(std::find(holders.begin(), holders.end(), tool) - holders.begin());
  }
  const std::size_t rest = to_B ? slot + 1 : slot - 1;
  if (rest >= holders.size() || !is_rest(holders[rest])) return hold != nullptr;
  std::swap(holders[slot], holders[rest]);
  return true;
}

/// A tool has come off its part of the string beside a rest, which it may have lifted the string
/// from: it holds it without the rests beside it. False: there is none.
bool take_off_rests(const StringTool& self, std::int32_t tool, SharedString& held) noexcept {
  Holders& holders = held.holders;
  const auto slot = static_cast<std::size_t>(part_of(*self.view, held.string)->slot);
  Holders left;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    if (k == slot) left.push_back(tool);
    const bool beside = k == slot || k + 1 == slot;
    if (!beside || !is_rest(holders[k])) left.push_back(holders[k]);
  }
  if (slot >= holders.size()) left.push_back(tool);
  if (left.size() > holders.size()) return false;
  holders = left;
  return true;
}

/// Another tool has just gone over a rest and holds nothing yet: nobody knows its way until its
/// turn.
bool awaits_other(std::span<const StringTool> tools, std::int32_t tool,
                  const SharedString& held) noexcept {
  return std::any_of(held.holders.begin(), held.holders.end(), [&](std::int32_t holder) {
    return !is_rest(holder) && holder != tool &&
           hold_of(*tools[static_cast<std::size_t>(holder)].state, held.string) == nullptr;
  });
}

/// The entry of a string that presses the tool; null: no room. Made where there is none, with the
/// friction on the tool, which is in the others.
PressedString* pressed_string(const StringTool& self, std::int32_t string,
                              PressedStrings& pressed) noexcept {
  const auto place = std::lower_bound(
      pressed.begin(), pressed.end(), string,
      [](const PressedString& entry, std::int32_t number) { return entry.string < number; });
  const auto index = static_cast<std::size_t>(place - pressed.begin());
  if (index < pressed.size() && pressed[index].string == string) return &pressed[index];
  PressedString entry;
  entry.string = string;
  const TouchedString* hold = hold_of(*self.state, string);
  entry.F_W = hold != nullptr ? hold->tangential_W : Vector3(0.0, 0.0, 0.0);
  entry.nhat_W = entry.p_WC = Vector3::Zero();
  if (!pressed.push_back(entry)) return nullptr;
  std::rotate(pressed.begin() + index, pressed.end() - 1, pressed.end());
  return &pressed[index];
}

/// Of a string that presses the tool at the end of its part alone.
void describe_end(const Contact& contact, const ContactInput& input, double lambda,
                  PressedString& pressed) noexcept {
  pressed.nhat_W = contact.nhat_OG_W;
  pressed.p_WC = contact.p_WC;
  pressed.radius = input.tool.leaf(contact.key.tool_sphere).r;
  pressed.lambda = lambda;
  pressed.part = input.parts.part_of(contact.key.tool_sphere);
}

}  // namespace

void add_rest_forces(const StringTool& self, const ContactInput& input,
                     RenderedTool& tick) noexcept {
  const std::size_t capsules = self.scene->obstacles.capsules_W.size();
  const ToolShape shape(input.parts, self.state->contact.parts);
  const ToolView tool{input.tool, self.state->contact.X_WG, shape.view()};
  for (const ActivePair& pair : self.view->rigid_active) {
    const auto number = static_cast<std::size_t>(pair.key.obstacle) - capsules;
    if (number >= self.view->rigid.size() || !(pair.multiplier > 0.0)) continue;
    const RigidPart& rigid = self.view->rigid[number];
    const StringPart* part = part_of(*self.view, rigid.string);
    if (part == nullptr) continue;
    const bool beside_B = rigid.lambda_from == part->lambda_to;
    if (!beside_B && rigid.lambda_to != part->lambda_from) continue;
    PressedString* pressed = pressed_string(self, rigid.string, tick.strings);
    if (pressed == nullptr) continue;
    const Contact contact = evaluate_contact(pair.key, tool, input.obstacles);
    if (!(pressed->force > 0.0)) describe_end(contact, input, beside_B ? 1.0 : 0.0, *pressed);
    pressed->force += pair.multiplier;
    pressed->displacement += pair.multiplier / input.stiffness.kt;
    pressed->F_W += pair.multiplier * contact.nhat_OG_W;
  }
}

bool settle_rests(std::span<const StringTool> tools, std::int32_t tool, const ToolState& before,
                  StringSharing& holders) noexcept {
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  bool settled = true;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    SharedString& held = holders[k];
    const bool was_near = part_of(*self.view, held.string) != nullptr;
    const bool over = was_near && go_over(self, tool, held);
    if (awaits_other(tools, tool, held)) {
      // As it lies.
    } else if (!over && holds(held, tool)) {
      const Holders found = lay_over(tools, held, pressed_rests(self, tool, held));
      settled = settled && same(found, held.holders);
      held.holders = found;
    } else if (!over && was_near && hold_of(before, held.string) != nullptr &&
               take_off_rests(self, tool, held)) {
      settled = false;
    } else if (!over) {
      if (is_left(held)) continue;
      if (was_near) held.holders = lay_over(tools, held, {});
    }
    if (kept != k) holders[kept] = held;
    ++kept;
  }
  holders.truncate(kept);
  return settled;
}

}  // namespace hapticd
