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

/// Strings that several tools shape, as they are after all of them.
class SharedShapes {
 public:
  SharedShapes(const SimulationMemory& memory, const StringSharing& sharing) noexcept
      : all_(string_tools(memory, tools_)), sharing_(sharing) {}

  /// A pair of the tool with `string` where it is nearest now: others have moved it since the tool
  /// was rendered. `key` becomes that of the leg.
  [[nodiscard]] Contact nearest(std::int32_t string, const ToolView& tool,
                                ContactKey& key) const noexcept {
    StringLegs legs_W;
    string_legs(all_, sharing_, string, legs_W);
    const ObstaclesView legs{{legs_W.begin(), legs_W.size()}, {}};
    key = {ObstacleKind::kCapsule, 0, key.tool_sphere, 0};
    Contact nearest = evaluate_contact(key, tool, legs);
    for (std::size_t k = 1; k < legs_W.size(); ++k) {
      const ContactKey leg{ObstacleKind::kCapsule, static_cast<std::int32_t>(k), key.tool_sphere,
                           0};
      const Contact there = evaluate_contact(leg, tool, legs);
      if (there.gap < nearest.gap) nearest = there;
    }
    const auto leg = static_cast<std::size_t>(nearest.key.obstacle);
    const Capsule& line =
        all_.front().scene->obstacles.capsules_W[static_cast<std::size_t>(string)];
    const double from = leg == 0 ? 0.0 : lambda_of(line, legs_W[leg].p_A);
    const double to = leg + 1 == legs_W.size() ? 1.0 : lambda_of(line, legs_W[leg].p_B);
    nearest.lambda = from + nearest.lambda * (to - from);
    key = {ObstacleKind::kCapsule, string, key.tool_sphere, nearest.key.obstacle};
    return nearest;
  }

 private:
  StringTools tools_;
  std::span<const StringTool> all_;
  const StringSharing& sharing_;
};

/// What there is to tell of the pairs of one tool.
class PairReader {
 public:
  PairReader(const SimulationMemory& memory, const StringSharing& sharing,
             std::size_t tool) noexcept
      : play_(memory.tools[tool]),
        sharing_(sharing),
        shapes_(memory, sharing),
        bent_(play_.way.input.obstacles, play_.state.contact.touched),
        shape_(play_.way.input.parts, play_.state.contact.parts),
        obstacles_(bent_.view()) {}

  /// True of a pair whose gap may be up to `near`.
  [[nodiscard]] bool may_be_within(const Contact& contact, double near) const noexcept {
    return play_.problem.candidates().may_be_within(contact, near) ||
           is_shared(play_, sharing_, contact.key);
  }

  [[nodiscard]] ContactTick read(const ContactKey& pair, double force) const noexcept {
    const ToolView tool{play_.way.input.tool, play_.state.contact.X_WG, shape_.view()};
    ContactKey key = pair;
    const Contact contact = is_shared(play_, sharing_, pair)
                                ? shapes_.nearest(string_of(pair), tool, key)
                                : evaluate_contact(pair, tool, obstacles_);
    return {key,
            play_.way.input.parts.part_of(pair.tool_sphere),
            to_array(contact.p_WC),
            to_array(contact.nhat_OG_W),
            contact.lambda,
            contact.gap,
            force};
  }

 private:
  /// That a pair with a string, or with a part of one, belongs to.
  [[nodiscard]] std::int32_t string_of(const ContactKey& pair) const noexcept {
    const auto index = static_cast<std::size_t>(pair.obstacle);
    const std::size_t capsules = play_.scene.obstacles.capsules_W.size();
    return index >= capsules ? play_.view.rigid[index - capsules].string : pair.obstacle;
  }

  const ToolPlay& play_;
  const StringSharing& sharing_;
  SharedShapes shapes_;
  BentObstacles bent_;
  ToolShape shape_;
  ObstaclesView obstacles_;
};

/// Of a sphere at a vertex both legs are listed, and of a shared string all pairs are with the
/// nearest leg: one of those is enough, with the force of all.
bool joins(const ContactTick& reading, ContactReport& report) noexcept {
  for (ContactTick& told : report.contacts) {
    if (!(told.key == reading.key)) continue;
    told.force += reading.force;
    return true;
  }
  return false;
}

}  // namespace

void report_contacts(const SimulationMemory& memory, const StringSharing& sharing, std::size_t tool,
                     ContactReport& report) noexcept {
  report.contacts.clear();
  report.total = 0;
  const ToolPlay& play = memory.tools[tool];
  const ContactState& state = play.state.contact;
  const PairReader reader(memory, sharing, tool);
  const auto tell = [&](const ContactKey& pair, const ContactTick& reading) {
    if (is_shared(play, sharing, pair) && joins(reading, report)) return;
    add(reading, report);
  };
  const auto active = std::span(state.active).first(static_cast<std::size_t>(state.active_count));
  for (const ActivePair& pair : active) tell(pair.key, reader.read(pair.key, pair.multiplier));
  for (const ActivePair& pair : play.view.rigid_active) {
    tell(pair.key, reader.read(pair.key, pair.multiplier));
  }
  const double near = kNearSkins * skin_of(play.way.input.options);
  for (const Contact& contact : play.problem.candidates().contacts().contacts) {
    if (!reader.may_be_within(contact, near)) continue;
    const auto same = [&](const ActivePair& pair) { return pair.key == contact.key; };
    if (std::any_of(active.begin(), active.end(), same)) continue;
    if (std::any_of(play.view.rigid_active.begin(), play.view.rigid_active.end(), same)) continue;
    const ContactTick reading = reader.read(contact.key, 0.0);
    if (reading.gap <= near) tell(contact.key, reading);
  }
  std::sort_heap(report.contacts.begin(), report.contacts.end(), deeper);
}

}  // namespace hapticd
