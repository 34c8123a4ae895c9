// Changes of live parameters: applied to a scene message, checked as scene files are, all or none.
// Offline.
#pragma once

#include <string>

#include "core/scene/scene_settings.h"
#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/control.pb.h"
#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {

struct AssignmentResult {
  v1::ResultCode code = v1::RESULT_CODE_OK;
  std::string path;        ///< of the first assignment that is at fault
  std::string message;     ///< what is wrong, and what to do
  v1::Scene scene;         ///< with the changes; only when OK
  SceneSettings settings;  ///< of tool 0; only when OK
};

/// `scene`, defaults filled in except the settings that quality decides (told_scene.h), after
/// `change`. `device_stiffness` as in LoadOptions, `usual_budget_us` as in QualityWish. Automatic
/// quality is at the level it begins with.
[[nodiscard]] AssignmentResult assign_parameters(const v1::Scene& scene,
                                                 const v1::SetParameter& change,
                                                 double device_stiffness,
                                                 double usual_budget_us = kUsualBudget_us);

}  // namespace hapticd
