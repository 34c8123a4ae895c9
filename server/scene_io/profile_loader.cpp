// See profile_loader.h.
#include "server/scene_io/profile_loader.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "proto/wire/field_table.h"
#include "server/scene_io/field_check.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/sheet_translation.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using P = v1::DeviceProfile;

void fault(SceneProblems& problems, std::string path, std::string message, std::string remedy) {
  problems.push_back({false, "", 0, 0, std::move(path), std::move(message), std::move(remedy)});
}

bool is_name(const std::string& name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string in_words(double value) {
  std::string text = std::to_string(value);
  while (text.ends_with('0')) text.pop_back();
  if (text.ends_with('.')) text.pop_back();
  return text;
}

/// Shape, range and source of one Quantity, which the comment of the field that holds it gives.
void check_quantity(const v1::Quantity& quantity, const wire::FieldRow& row,
                    const std::string& path, SceneProblems& problems) {
  if (quantity.source().empty()) {
    fault(problems, path + ".source", "a number without a source",
          "Say where it comes from, or why this guess.");
  }
  const int count = quantity.value_size();
  const bool one = row.shape.starts_with("1");
  const bool three = row.shape.starts_with("3") || row.shape.ends_with("3");
  if (!((one && count == 1) || (three && count == 3))) {
    fault(problems, path + ".value", std::to_string(count) + " numbers",
          "Give " + std::string(row.shape) + ".");
  }
  const auto range = wire::parse_interval(row.range);
  for (int i = 0; i < count && range; ++i) {
    if (range->contains(quantity.value(i))) continue;
    fault(problems, path + ".value[" + std::to_string(i) + "]",
          in_words(quantity.value(i)) + " is not in " + std::string(row.range) + " " +
              std::string(row.unit),
          "");
  }
}

/// Every Quantity that is a field of `message`.
void check_quantities(const pb::Message& message, const std::string& prefix,
                      SceneProblems& problems) {
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    if (field.message_type() != v1::Quantity::descriptor()) continue;
    const pb::Reflection& reflection = *message.GetReflection();
    const wire::FieldRow* row = wire::find_row(type.name() + "." + field.name());
    if (row == nullptr || !reflection.HasField(message, &field)) continue;
    const auto& quantity =
        dynamic_cast<const v1::Quantity&>(reflection.GetMessage(message, &field));
    check_quantity(quantity, *row, prefix + field.name(), problems);
  }
}

void check_axis_map(const v1::AxisMap& map, SceneProblems& problems) {
  std::set<int> directions;
  for (const int axis : map.axes()) directions.insert((axis + 1) / 2);
  const bool each_once = directions == std::set<int>{1, 2, 3} && map.axes_size() == 3;
  if (!map.axes().empty() && !each_once) {
    fault(problems, "axis_map.axes", "x, y and z of D do not come from three different axes",
          "Name each axis once.");
  }
  for (const double sign : map.force_sign().value()) {
    if (sign == 1.0 || sign == -1.0) continue;
    fault(problems, "axis_map.force_sign", in_words(sign) + " is not a sign", "Give -1 or 1.");
  }
  check_quantities(map, "axis_map.", problems);
}

void check_required(const P& profile, SceneProblems& problems) {
  if (!is_name(profile.name())) {
    fault(problems, "name", "'" + profile.name() + "' is not a name for a profile",
          "Use a to z, 0 to 9 and _ alone.");
  }
  if (profile.driver() == v1::DRIVER_UNSPECIFIED) {
    fault(problems, "driver", "no driver", "Give one, such as DRIVER_SIMULATED.");
  }
  const double actuated = profile.has_actuated_axes() ? profile.actuated_axes().value(0) : 6.0;
  if (actuated > 0.0 && !profile.has_peak_force_n()) {
    fault(problems, "peak_force_n", "a device that pushes needs its peak force", "");
  }
  if (actuated > 3.0 && !profile.has_peak_torque_n_m()) {
    fault(problems, "peak_torque_n_m", "a device that turns needs its peak torque", "");
  }
  for (const auto* axes : {&profile.sensed_axes(), &profile.actuated_axes()}) {
    if (axes->value_size() == 1 && axes->value(0) != std::floor(axes->value(0))) {
      fault(problems, axes == &profile.sensed_axes() ? "sensed_axes" : "actuated_axes",
            "axes come in whole numbers", "");
    }
  }
  for (int i = 0; i < 3 && profile.has_workspace_lower_m() && profile.has_workspace_upper_m();
       ++i) {
    if (profile.workspace_lower_m().value(i) < profile.workspace_upper_m().value(i)) continue;
    fault(problems, "workspace_upper_m.value[" + std::to_string(i) + "]",
          "not above the lower corner", "");
  }
}

}  // namespace

ProfileFolders installed_profiles() {
  return {installed_paths().scenes.front().parent_path() / "devices"};
}

std::vector<DeviceSheet> load_installed_profiles() {
  std::vector<DeviceSheet> sheets;
  const ProfileFolders folders = installed_profiles();
  for (const std::string& name : list_names(folders)) {
    ProfileResult result = load_profile(name, folders);
    if (result.loaded) sheets.push_back(std::move(*result.loaded));
  }
  return sheets;
}

ProfileResult load_profile(const std::string& source, const ProfileFolders& folders) {
  const NamedText named = read_named(source, folders, "device profile", kMaxText);
  if (named.problem) return {std::nullopt, {*named.problem}};
  return check_text(named.text, named.path.string(), "device profile", check_profile);
}

ProfileResult check_profile(const P& profile) {
  ProfileResult result;
  result.problems = check_fields(profile);
  check_axis_map(profile.axis_map(), result.problems);
  check_quantities(profile, "", result.problems);
  // What follows looks at values that are there.
  if (!any_fault(result.problems)) check_required(profile, result.problems);
  if (any_fault(result.problems)) return result;
  result.loaded = to_sheet(profile);
  return result;
}

}  // namespace hapticd
