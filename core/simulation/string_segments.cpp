// See string_segments.h. RT: yes.
#include "core/simulation/string_segments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// Largest inharmonicity, as scenes may have it.
constexpr double kMaxInharmonicity = 0.1;

const Capsule& whole(const StringTool& tool, std::int32_t string) noexcept {
  return tool.scene->obstacles.capsules_W[static_cast<std::size_t>(string)];
}

bool same(const Capsule& a, const Capsule& b) noexcept { return a.p_A == b.p_A && a.p_B == b.p_B; }

/// The part of a string that the tool is nearest to.
std::size_t nearest_part(const StringTool& tool, const StringPoints& points,
                         double radius) noexcept {
  const ContactState& state = tool.state->contact;
  StringLegs parts_W;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    parts_W.push_back({points[k], points[k + 1], radius});
  }
  const double margin = tool.scene->options.margin;
  const double room = reach(tool.scene->tool) + greatest_displacement(state.parts) + margin;
  std::size_t nearest = 0;
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < parts_W.size(); ++k) {
    const double there = closest_point_on_segment(points[k], points[k + 1], state.X_WG.p).distance;
    if (there < distance) nearest = k;
    distance = std::min(distance, there);
  }
  if (distance - radius > room) return nearest;
  const ToolShape shape(tool.scene->parts, state.parts);
  find_contacts({tool.scene->tool, state.X_WG, shape.view()},
                {{parts_W.begin(), parts_W.size()}, {}}, {margin, margin}, *tool.scratch);
  double gap = std::numeric_limits<double>::infinity();
  for (const Contact& contact : tool.scratch->contacts) {
    if (contact.gap < gap) nearest = static_cast<std::size_t>(contact.key.obstacle);
    gap = std::min(gap, contact.gap);
  }
  return nearest;
}

/// False when others do not hold the string, or the tool can meet it neither bent nor straight on
/// its way to p_WH, or to where it was to go last if that pose is useless.
bool concerns(std::span<const StringTool> tools, const StringSharing& all, const SharedString& held,
              std::int32_t tool, const Vector3& p_WH) noexcept {
  const bool holds =
      std::find(held.holders.begin(), held.holders.end(), tool) != held.holders.end();
  if (holds) return held.holders.size() > 1;
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  const ContactState& state = self.state->contact;
  const Vector3& p_WG = state.X_WG.p;
  const double way = std::max((p_WH - p_WG).norm(), (self.state->hand.X_WH.p - p_WG).norm());
  // Wherever it turns to.
  const double room = 2.0 * (reach(self.scene->tool) + greatest_displacement(state.parts)) + way +
                      2.0 * self.scene->options.margin + whole(self, held.string).r;
  if (!(self.state->placed && std::isfinite(room))) return true;
  StringPoints points;
  string_points(tools, all, held.string, tool, points);
  points.push_back(points[0]);  // back along the straight string
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const double distance = closest_point_on_segment(points[k], points[k + 1], p_WG).distance;
    if (distance <= room) return true;
  }
  return false;
}

/// The same vertex between other ends.
void rebase(const Capsule& before, const Capsule& after, TouchedString& hold) noexcept {
  if (same(before, after)) return;
  const Vector3 p_P = leg_of(before, hold.bend, 0).capsule_W.p_B;
  hold.bend.lambda = lambda_of(after, p_P);
  const Vector3 u_before_W = hold.bend.u_W;
  hold.bend.u_W = p_P - (after.p_A + hold.bend.lambda * (after.p_B - after.p_A));
  hold.u_felt_W += hold.bend.u_W - u_before_W;
}

/// Takes what carried force on rigid parts out of the state: their numbers change.
void part_with_rigid_pairs(std::size_t capsules, ContactState& state,
                           StringSegments& view) noexcept {
  view.rigid_active.clear();
  if (view.rigid.empty()) return;
  int kept = 0;
  for (int k = 0; k < state.active_count; ++k) {
    const ActivePair& pair = state.active[static_cast<std::size_t>(k)];
    if (is_string(pair.key) && static_cast<std::size_t>(pair.key.obstacle) >= capsules) {
      view.rigid_active.push_back(pair);
    } else {
      state.active[static_cast<std::size_t>(kept++)] = pair;
    }
  }
  state.active_count = kept;
}

/// Puts the part of a string that the tool may bend, and the rigid rest, into its view.
void take_part(std::span<const StringTool> tools, const StringSharing& all,
               const SharedString& holders, std::int32_t tool) noexcept {
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  StringSegments& view = *self.view;
  StringPoints points;
  string_points(tools, all, holders.string, tool, points);
  const auto* const at = std::find(holders.holders.begin(), holders.holders.end(), tool);
  // One that has just gone over a rest has no vertex yet.
  const auto has_point = [&](std::int32_t holder) {
    return is_rest(holder) ||
           hold_of(*tools[static_cast<std::size_t>(holder)].state, holders.string) != nullptr;
  };
  const std::size_t slot =
      at != holders.holders.end()
          ? static_cast<std::size_t>(std::count_if(holders.holders.begin(), at, has_point))
          : nearest_part(self, points, whole(self, holders.string).r);
  const Capsule& line = whole(self, holders.string);
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Capsule part_W{points[k], points[k + 1], line.r};
    const double from = k == 0 ? 0.0 : lambda_of(line, points[k]);
    const double to = k + 2 == points.size() ? 1.0 : lambda_of(line, points[k + 1]);
    if (k == slot) {
      const auto string = static_cast<std::size_t>(holders.string);
      view.parts.push_back({holders.string, static_cast<std::int32_t>(slot), part_W, from, to});
      view.capsules_W[string] = part_W;
      view.strings[string] = part_constants(self.scene->strings[string], points, slot);
    } else if (view.rigid.push_back({holders.string, from, to})) {
      view.capsules_W[self.scene->obstacles.capsules_W.size() + view.rigid.size() - 1] = part_W;
    }
  }
}

}  // namespace

double lambda_of(const Capsule& string, const Vector3& p_W) noexcept {
  const Vector3 axis = string.p_B - string.p_A;
  const double squared = axis.squaredNorm();
  return squared > 0.0 ? std::clamp((p_W - string.p_A).dot(axis) / squared, 0.0, 1.0) : 0.5;
}

const TouchedString* hold_of(const ToolState& state, std::int32_t string) noexcept {
  for (const TouchedString& hold : state.contact.touched) {
    if (hold.bend.capsule == string && hold.yields) return &hold;
  }
  return nullptr;
}

Vector3 vertex_of(const StringTool& tool, const TouchedString& hold) noexcept {
  const StringPart* part = part_of(*tool.view, hold.bend.capsule);
  const Capsule& line = part != nullptr ? part->part_W : whole(tool, hold.bend.capsule);
  return leg_of(line, hold.bend, 0).capsule_W.p_B;
}

void string_points(std::span<const StringTool> tools, const StringSharing& holders,
                   std::int32_t string, std::int32_t without, StringPoints& points) noexcept {
  points.clear();
  const Capsule& line = whole(tools.front(), string);
  points.push_back(line.p_A);
  for (const SharedString& held : holders) {
    if (held.string != string) continue;
    for (const std::int32_t holder : held.holders) {
      if (is_rest(holder)) {
        points.push_back(tools.front().scene->rests[rest_of(holder)].p_W);
        continue;
      }
      const StringTool& tool = tools[static_cast<std::size_t>(holder)];
      const TouchedString* hold = hold_of(*tool.state, string);
      if (holder != without && hold != nullptr) points.push_back(vertex_of(tool, *hold));
    }
  }
  points.push_back(line.p_B);
}

void string_legs(std::span<const StringTool> tools, const StringSharing& holders,
                 std::int32_t string, StringLegs& legs_W) noexcept {
  StringPoints points;
  string_points(tools, holders, string, -1, points);
  legs_W.clear();
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    legs_W.push_back({points[k], points[k + 1], whole(tools.front(), string).r});
  }
}

StringConstants part_constants(const StringConstants& whole, const StringPoints& points,
                               std::size_t part) noexcept {
  StringConstants out = whole;
  double polyline = 0.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    polyline += (points[k + 1] - points[k]).norm();
  }
  out.length = (points[part + 1] - points[part]).norm();
  if (out.length < kMinString || !(whole.length > 0.0)) {
    out.length = 0.0;
    out.model = StringContact::kStraight;
    out.max_level = StringDetail::kLine;
    out.frequency = 0.0;
    out.modal_mass = 0.0;
    return out;
  }
  const double share = out.length / whole.length;
  out.tension += whole.axial_stiffness * std::max(0.0, polyline / whole.length - 1.0);
  out.shared = true;
  out.axial_stiffness *= share;
  if (whole.frequency > 0.0) {
    const double tighter = out.tension / whole.tension;
    out.frequency *= std::sqrt(tighter) / share;
    out.modal_mass *= share;
    out.inharmonicity =
        std::min(whole.inharmonicity / (share * share * tighter), kMaxInharmonicity);
  }
  return out;
}

ToolScene segment_strings(std::span<const StringTool> tools, const StringSharing& holders,
                          std::int32_t tool, const Vector3& p_WH) noexcept {
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  StringSegments& view = *self.view;
  ToolScene seen = *self.scene;
  FixedVector<std::size_t, kMaxHeldStrings> near;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    if (concerns(tools, holders, holders[k], tool, p_WH)) near.push_back(k);
  }
  if (view.parts.empty() && near.empty()) return seen;
  const auto line_of = [&](std::int32_t string) -> const Capsule& {
    const StringPart* part = part_of(view, string);
    return part != nullptr ? part->part_W : whole(self, string);
  };
  FixedVector<Capsule, kMaxDeflectingStrings> before;
  for (const TouchedString& hold : self.state->contact.touched) {
    before.push_back(line_of(hold.bend.capsule));
  }
  const std::span<const Capsule> lines = seen.obstacles.capsules_W;
  FixedVector<std::size_t, 2 * kMaxHeldStrings> changed;
  for (const StringPart& part : view.parts) {
    const auto string = static_cast<std::size_t>(part.string);
    view.capsules_W[string] = lines[string];
    changed.push_back(string);
  }
  view.parts.clear();
  view.rigid.clear();
  std::copy(seen.strings.begin(), seen.strings.end(), view.strings.begin());
  for (const std::size_t k : near) take_part(tools, holders, holders[k], tool);
  for (const StringPart& part : view.parts)
    changed.push_back(static_cast<std::size_t>(part.string));
  const Capsule* held_before = before.begin();
  for (TouchedString& hold : self.state->contact.touched) {
    const Capsule& was = *held_before++;
    if (hold.yields) rebase(was, line_of(hold.bend.capsule), hold);
  }
  const std::size_t capsules = lines.size() + view.rigid.size();
  seen.obstacles.capsules_W = view.capsules_W.first(capsules);
  seen.strings = view.strings;
  seen.rounding = kSharedRounding;
  if (!seen.rests.empty()) seen.rigid_parts = {view.rigid.begin(), view.rigid.size()};
  if (seen.obstacles.groups.empty()) return seen;
  for (const std::size_t string : changed) {
    const std::size_t group = string / kCapsulesPerGroup;
    view.groups[group] = group_capsules(seen.obstacles.capsules_W, group);
  }
  for (std::size_t group = lines.size() / kCapsulesPerGroup; group < group_count(capsules);
       ++group) {
    view.groups[group] = group_capsules(seen.obstacles.capsules_W, group);
  }
  seen.obstacles.groups = view.groups.first(group_count(capsules));
  seen.obstacles.all = box_of(seen.obstacles.groups);
  return seen;
}

void update_sharing(std::span<const StringTool> tools, std::int32_t tool,
                    StringSharing& holders) noexcept {
  const StringTool& self = tools[static_cast<std::size_t>(tool)];
  part_with_rigid_pairs(self.scene->obstacles.capsules_W.size(), self.state->contact, *self.view);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    auto& held = holders[k].holders;
    if (hold_of(*self.state, holders[k].string) == nullptr) {
      const auto* const end = std::remove(held.begin(), held.end(), tool);
      held.truncate(static_cast<std::size_t>(end - held.begin()));
    }
    if (held.empty()) continue;
    if (kept != k) holders[kept] = holders[k];
    ++kept;
  }
  holders.truncate(kept);
  for (const TouchedString& hold : self.state->contact.touched) {
    if (!hold.yields) continue;
    const std::int32_t string = hold.bend.capsule;
    auto* held = std::find_if(holders.begin(), holders.end(),
                              [&](const SharedString& other) { return other.string == string; });
    if (held == holders.end()) {
      held = holders.append();
      HD_ASSERT(held != nullptr);
      held->string = string;
      held->holders.clear();
    }
    if (std::find(held->holders.begin(), held->holders.end(), tool) != held->holders.end())
      continue;
    const StringPart* part = part_of(*self.view, string);
    const auto slot = static_cast<std::size_t>(part != nullptr ? part->slot : 0);
    held->holders.push_back(tool);
    std::rotate(held->holders.begin() + slot, held->holders.end() - 1, held->holders.end());
  }
}

}  // namespace hapticd
