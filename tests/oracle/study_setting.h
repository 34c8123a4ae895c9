// What a study changes of a scene: one knob, several, or a level of quality, written as
// "NAME:KEY=VALUE,KEY=VALUE". Not RT.
#pragma once

#include <optional>
#include <string>

#include "core/scene/scene_description.h"

namespace hapticd {

struct StudySetting {
  std::string name;
  std::string scene;        ///< played instead, as one with coarser leaves; empty: none
  double rate_hz = 1000.0;  ///< of the loop
  bool judged = true;       ///< its way is searched, unless nothing is judged
  ContactOptions options;
  // Of the strings; as the scene has it where nothing is said.
  std::optional<StringContact> string_model;
  std::optional<StringDetail> string_level;
  std::optional<int> modes;
  std::optional<int> substeps;  ///< of a millisecond, of modes

  [[nodiscard]] bool changes_strings() const noexcept {
    return string_model || string_level || modes || substeps;
  }
};

/// The setting `text` of `scene`. Throws std::invalid_argument naming what makes no sense, and what
/// would.
[[nodiscard]] StudySetting parse_setting(const std::string& text, const SceneDescription& scene);

/// The scene that the setting `text` plays instead; empty: none.
[[nodiscard]] std::string scene_of_setting(const std::string& text);

/// What `setting` is held against: its strings and its scene, 400 sub-steps, 4 mrad, 1e-10 m, the
/// leaves, all rows.
[[nodiscard]] ContactOptions truth_options(const SceneDescription& scene);

/// `scene` with the strings that `setting` says.
[[nodiscard]] SceneDescription with_strings(SceneDescription scene, const StudySetting& setting);

}  // namespace hapticd
