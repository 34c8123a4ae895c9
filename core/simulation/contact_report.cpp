// Which pairs are reported. See contact_report.h. RT: yes.
#include "core/simulation/contact_report.h"

#include <algorithm>

#include "core/contact/clearance.h"
#include "core/simulation/tool_play.h"

namespace hapticd {
namespace {

/// Deepest first; equal gaps in the order of their pairs, so that the list is the same everywhere.
bool deeper(const ContactTick& a, const ContactTick& b) noexcept {
  return a.gap != b.gap ? a.gap < b.gap : a.key < b.key;
}

/// Adds to a heap whose top is the shallowest, which makes place when it is full.
void add(const ContactTick& reading, ContactReport& report) noexcept {
  ++report.total;
  auto& kept = report.contacts;
  if (!kept.full()) {
    kept.push_back(reading);
  } else if (deeper(reading, kept[0])) {
    std::pop_heap(kept.begin(), kept.end(), deeper);
    kept[kept.size() - 1] = reading;
  } else {
    return;
  }
  std::push_heap(kept.begin(), kept.end(), deeper);
}

/// Position along the string of a place on a part of it; `key` becomes that of the string.
double whole_lambda(const StringSegments& view, std::size_t capsules, double lambda,
                    ContactKey& key) noexcept {
  if (!is_string(key) || view.parts.empty()) return lambda;
  const auto index = static_cast<std::size_t>(key.obstacle);
  if (index >= capsules) {
    const RigidPart& part = view.rigid[index - capsules];
    key.obstacle = part.string;
    return part.lambda_from + lambda * (part.lambda_to - part.lambda_from);
  }
  return whole_lambda(view, key.obstacle, lambda);
}

}  // namespace

void report_contacts(const ToolPlay& play, ContactReport& report) noexcept {
  report.contacts.clear();
  report.total = 0;
  const ContactInput& scene = play.way.input;
  const std::size_t capsules = play.scene.obstacles.capsules_W.size();
  const ContactState& state = play.state.contact;
  const BentObstacles bent(scene.obstacles, state.touched);
  const ToolShape shape(scene.parts, state.parts);
  const auto reading_of = [&](const ContactKey& key, double force) {
    const Contact contact =
        evaluate_contact(key, {scene.tool, state.X_WG, shape.view()}, bent.view());
    ContactKey owner = key;
    const double lambda = whole_lambda(play.view, capsules, contact.lambda, owner);
    return ContactTick{owner,
                       scene.parts.part_of(key.tool_sphere),
                       to_array(contact.p_WC),
                       to_array(contact.nhat_OG_W),
                       lambda,
                       contact.gap,
                       force};
  };
  const auto active = std::span(state.active).first(static_cast<std::size_t>(state.active_count));
  for (const ActivePair& pair : active) add(reading_of(pair.key, pair.multiplier), report);
  for (const ActivePair& pair : play.view.rigid_active) {
    add(reading_of(pair.key, pair.multiplier), report);
  }
  const double near = kNearSkins * skin_of(scene.options);
  for (const Contact& contact : play.problem.candidates().contacts().contacts) {
    if (!play.problem.candidates().may_be_within(contact, near)) continue;
    const auto same = [&](const ActivePair& pair) { return pair.key == contact.key; };
    if (std::any_of(active.begin(), active.end(), same)) continue;
    if (std::any_of(play.view.rigid_active.begin(), play.view.rigid_active.end(), same)) continue;
    const ContactTick reading = reading_of(contact.key, 0.0);
    if (reading.gap <= near) add(reading, report);
  }
  std::sort_heap(report.contacts.begin(), report.contacts.end(), deeper);
}

}  // namespace hapticd
