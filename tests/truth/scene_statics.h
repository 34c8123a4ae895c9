// The exact statics (exact_statics.h) of a tool in a scene as it is played, from where the tool is.
// Rigid tools; strings yield or are lines. Frames: W. SI. Not RT: 10 to 500 ms.
#pragma once

#include <vector>

#include "core/simulation/tool_renderer.h"
#include "tests/truth/exact_statics.h"

namespace hapticd {

class SceneStatics {
 public:
  /// `scene` is looked at now only.
  explicit SceneStatics(const ToolScene& scene);

  /// The rest downhill of where tool and strings are in `from`, for the hand at X_WH. What is
  /// further than kRange from the tool there is left out.
  [[nodiscard]] StaticRest rest(const Pose& X_WH, const ContactState& from) const;

  /// Nothing moves so far within a tick, m.
  static constexpr double kRange = 0.02;

 private:
  double kt_;
  double length_;
  std::vector<Sphere> tool_G_;
  std::vector<Sphere> bodies_W_;
  std::vector<Capsule> lines_W_;
  std::vector<StaticString> strings_;
  std::vector<std::int32_t> capsule_of_string_;
};

}  // namespace hapticd
