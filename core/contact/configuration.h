// Tool, soft parts and strings as they stand together, and a step of all of them. Frames: W unless
// the name says otherwise. SI. RT: yes, plain data.
#pragma once

#include "core/contact/contact_input.h"
#include "core/contact/contact_state.h"

namespace hapticd {

/// What is asked of a tool's contact problem, and where it has come. Views both.
struct Configuration {
  const ContactInput& input;
  const ContactState& state;
};

/// A step of the whole configuration.
struct ConfigurationStep {
  ToolMotion tool;
  StringMotions strings;
  PartMotions parts;
  /// How much a string's vertex may change a gap as it goes to the centre of its contact, m.
  double centring_room = 0.0;
};

/// No point of the tool with its soft parts is farther from its origin, m.
[[nodiscard]] inline double tool_reach(const Configuration& at) noexcept {
  return reach(at.input.tool) + greatest_displacement(at.state.parts);
}

}  // namespace hapticd
