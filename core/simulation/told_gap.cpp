// See told_gap.h. RT: yes.
#include "core/simulation/told_gap.h"

#include <algorithm>
#include <limits>

namespace hapticd {
namespace {

/// Of a margin that counts as all of it: what a horizon and a way of the same lengths round by.
constexpr double kWholeMargin = 1.0 - 1e-9;

constexpr double kNone = std::numeric_limits<double>::infinity();

/// A tool as it stands, with its own bends.
struct StandingTool {
  explicit StandingTool(const ToolPlay& play) noexcept
      : input(play.way.input),
        state(play.state.contact),
        bent(input.obstacles, state.touched),
        shape(input.parts, state.parts),
        obstacles(bent.view()) {}
  [[nodiscard]] ToolView tool() const noexcept { return {input.tool, state.X_WG, shape.view()}; }

  const ContactInput& input;
  const ContactState& state;
  BentObstacles bent;
  ToolShape shape;
  ObstaclesView obstacles;
};

/// The smallest gap of the listed pairs, as far as they may be nearer than `most`.
double nearest_listed(const ToolPlay& play, const StringSharing& sharing, const StandingTool& at,
                      double most) noexcept {
  const Candidates& candidates = play.problem.candidates();
  double nearest = most;
  for (const Contact& contact : candidates.contacts().contacts) {
    if (!candidates.may_be_within(contact, nearest) || is_shared(play, sharing, contact.key))
      continue;
    nearest = std::min(nearest, evaluate_contact(contact.key, at.tool(), at.obstacles).gap);
  }
  return nearest;
}

/// A traversal of what the tool alone sees; what is shared is left to nearest_shared().
double search(ToolPlay& play, const StringSharing& sharing, const StandingTool& at) noexcept {
  const ContactOptions& options = at.input.options;
  const bool leaves = any_soft(at.input.parts);
  find_contacts(at.tool(), at.obstacles,
                {.margin = options.margin,
                 .horizon = options.margin,
                 .tool_level = leaves ? kLeafLevel : at.state.tool_level,
                 .body_level = leaves ? kLeafLevel : at.state.body_level},
                play.swung);
  if (play.view.parts.empty() && sharing.empty()) return play.swung.minimum_gap;
  double nearest = options.margin;
  for (const Contact& contact : play.swung.contacts) {
    if (!is_shared(play, sharing, contact.key)) nearest = std::min(nearest, contact.gap);
  }
  return nearest;
}

/// The smallest gap of a tool to the strings that several tools shape, up to `margin`.
class SharedStrings {
 public:
  SharedStrings(const SimulationMemory& memory, const StringSharing& sharing) noexcept
      : all_(string_tools(memory, tools_)), sharing_(sharing) {}

  [[nodiscard]] double gap(std::int32_t string, const ToolView& tool, double margin,
                           ContactSet& found) const noexcept {
    StringLegs legs_W;
    string_legs(all_, sharing_, string, legs_W);
    find_contacts(tool, {{legs_W.begin(), legs_W.size()}, {}}, {margin, margin}, found);
    return found.minimum_gap;
  }

 private:
  StringTools tools_;
  std::span<const StringTool> all_;
  const StringSharing& sharing_;
};

}  // namespace

double told_gap(const SimulationMemory& memory, const StringSharing& sharing,
                std::size_t tool) noexcept {
  ToolPlay& play = memory.tools[tool];
  const StandingTool at(play);
  const double margin = at.input.options.margin;
  const Candidates& candidates = play.problem.candidates();
  const bool recovered = play.rendered.contact.status == ContactStatus::kRecovering;
  const double seen = recovered ? -kNone : std::min(candidates.room_left(), margin);
  double nearest = nearest_listed(play, sharing, at, margin);
  if (nearest > seen && (recovered || !candidates.clear_within(kWholeMargin * margin))) {
    nearest = search(play, sharing, at);
  }
  if (sharing.empty() && play.view.parts.empty()) return nearest;
  const SharedStrings shared(memory, sharing);
  const auto look_at = [&](std::int32_t string) {
    nearest = std::min(nearest, shared.gap(string, at.tool(), margin, play.swung));
  };
  for (const SharedString& held : sharing) look_at(held.string);
  for (const StringPart& part : play.view.parts) {
    if (!is_held(sharing, part.string)) look_at(part.string);
  }
  return nearest;
}

double standing_gap(const SimulationMemory& memory, const StringSharing& sharing, std::size_t tool,
                    const Pose& X_WG) noexcept {
  ToolPlay& play = memory.tools[tool];
  const ToolScene& scene = play.scene;
  const ContactState& state = play.state.contact;
  const double margin = scene.options.margin;
  const TouchedStrings none;
  const BentObstacles bent(scene.obstacles, memory.tools.size() == 1 ? state.touched : none);
  const ToolShape shape(scene.parts, state.parts);
  const ToolView view{scene.tool, X_WG, shape.view()};
  find_contacts(view, bent.view(), {margin, margin}, play.swung);
  if (sharing.empty()) return play.swung.minimum_gap;
  const SharedStrings shared(memory, sharing);
  double nearest = margin;
  for (const Contact& contact : play.swung.contacts) {
    if (is_string(contact.key) && is_held(sharing, contact.key.obstacle)) continue;
    nearest = std::min(nearest, contact.gap);
  }
  for (const SharedString& held : sharing) {
    nearest = std::min(nearest, shared.gap(held.string, view, margin, play.swung));
  }
  return nearest;
}

}  // namespace hapticd
