// See scene_assignment.h.
#include "server/scene_io/scene_assignment.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "core/scene/quality.h"
#include "core/scene/scene_check.h"
#include "proto/hints/quantity.h"
#include "proto/wire/field_table.h"
#include "server/scene_io/field_check.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_parameters.h"
#include "server/scene_io/scene_translation.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using Kind = pb::FieldDescriptor::CppType;

/// Why an assignment is refused.
struct Refusal {
  v1::ResultCode code;
  std::string message;  ///< empty: its path names nothing
};

/// One step of a path: a field, and which element of it.
struct Step {
  std::string name;
  std::optional<int> index;
};

Refusal no_such_path() { return {v1::RESULT_CODE_NOT_FOUND, ""}; }

Step read_step(std::string_view text) {
  const std::size_t bracket = text.find('[');
  Step step{std::string(text.substr(0, bracket)), std::nullopt};
  if (bracket == std::string_view::npos) return step;
  int index = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + bracket + 1, end, index);
  if (error != std::errc() || stop + 1 != end || *stop != ']' || index < 0) throw no_such_path();
  step.index = index;
  return step;
}

/// The field a path names, in the message that holds it.
struct Target {
  pb::Message* message = nullptr;
  const pb::FieldDescriptor* field = nullptr;
  const wire::FieldRow* row = nullptr;
  int index = 0;  ///< of a number among several
};

Target find_target(v1::Scene& scene, std::string_view path) {
  pb::Message* message = &scene;
  while (true) {
    const std::size_t dot = path.find('.');
    const Step step = read_step(path.substr(0, dot));
    const pb::FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(step.name);
    if (field == nullptr || field->is_repeated() != step.index.has_value()) throw no_such_path();
    const pb::Reflection& r = *message->GetReflection();
    const wire::FieldRow* row =
        wire::find_row(message->GetDescriptor()->name() + "." + field->name());
    if (dot == std::string_view::npos) {
      if (row == nullptr || !row->live) {
        throw Refusal{v1::RESULT_CODE_INVALID, "It is not live. Change it with LoadScene."};
      }
      if (step.index && *step.index >= r.FieldSize(*message, field)) throw no_such_path();
      return {message, field, row, step.index.value_or(0)};
    }
    if (field->cpp_type() != Kind::CPPTYPE_MESSAGE) throw no_such_path();
    if (step.index && *step.index >= r.FieldSize(*message, field)) throw no_such_path();
    if (!step.index && !r.HasField(*message, field)) {
      throw Refusal{v1::RESULT_CODE_NOT_FOUND, "The scene does not model it."};
    }
    message = step.index ? r.MutableRepeatedMessage(message, field, *step.index)
                         : r.MutableMessage(message, field);
    path.remove_prefix(dot + 1);
  }
}

Refusal wrong_kind(const char* wanted) {
  return {v1::RESULT_CODE_INVALID, std::string("Give ") + wanted + "."};
}

std::string choices_of(const pb::EnumDescriptor& type) {
  std::string names;
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() == 0) continue;
    names += (names.empty() ? "" : ", ") + type.value(i)->name();
  }
  return "one of " + names;
}

void set_enum(const Target& target, const v1::Assignment& assignment) {
  const pb::EnumDescriptor& type = *target.field->enum_type();
  const pb::EnumValueDescriptor* value = nullptr;
  if (assignment.has_text()) value = type.FindValueByName(assignment.text());
  if (assignment.has_number()) {
    const double number = assignment.number();
    if (number == std::floor(number) && std::abs(number) < 1e6) {
      value = type.FindValueByNumber(static_cast<int>(number));
    }
  }
  // 0 means a choice that was not made.
  if (value == nullptr || value->number() == 0) {
    throw wrong_kind(choices_of(type).c_str());
  }
  target.message->GetReflection()->SetEnum(target.message, target.field, value);
}

void set_pose(const Target& target, const v1::Assignment& assignment) {
  if (!assignment.has_numbers() || assignment.numbers().values_size() != 7) {
    throw wrong_kind("a pose as 7 numbers: p, then q");
  }
  auto& pose = dynamic_cast<v1::Pose&>(
      *target.message->GetReflection()->MutableMessage(target.message, target.field));
  pose.Clear();
  for (int k = 0; k < 3; ++k) pose.add_p_m(assignment.numbers().values(k));
  for (int k = 3; k < 7; ++k) pose.add_q(assignment.numbers().values(k));
}

/// Of a number, or of a text with one and its unit.
double number_of(const v1::Assignment& assignment, std::string_view unit) {
  if (assignment.has_number()) return assignment.number();
  if (!assignment.has_text()) throw wrong_kind("a number");
  const hints::Quantity quantity = hints::parse_quantity(assignment.text(), unit);
  if (!quantity.fault.empty()) throw Refusal{v1::RESULT_CODE_INVALID, quantity.fault};
  return quantity.value;
}

void set_number(const Target& target, const v1::Assignment& assignment) {
  const double number = number_of(assignment, target.row->unit);
  const pb::Reflection& r = *target.message->GetReflection();
  const auto range = wire::parse_interval(target.row->range);
  if (!std::isfinite(number) || (range && !range->contains(number))) {
    throw Refusal{v1::RESULT_CODE_OUT_OF_RANGE,
                  "It is not in " + std::string(target.row->range) + "."};
  }
  if (target.field->is_repeated()) {
    r.SetRepeatedDouble(target.message, target.field, target.index, number);
    return;
  }
  if (target.field->cpp_type() == Kind::CPPTYPE_DOUBLE) {
    r.SetDouble(target.message, target.field, number);
    return;
  }
  if (number != std::floor(number)) throw wrong_kind("a whole number");
  r.SetUInt32(target.message, target.field, static_cast<std::uint32_t>(number));
}

/// The choice that `assignment` makes.
v1::Quality quality_choice(const v1::Assignment& assignment, const v1::Quality& before,
                           double usual_budget_us) {
  v1::Quality quality;
  if (assignment.has_text() && assignment.text() == "auto") {
    quality.mutable_automatic()->set_budget_us(usual_budget_us);
    return before.has_automatic() ? before : quality;
  }
  const double level = assignment.number();
  if (!assignment.has_number()) throw wrong_kind("a level, 0 to 4, or the text auto");
  if (!(level >= 0.0 && level < kQualityLevels && level == std::floor(level))) {
    throw Refusal{v1::RESULT_CODE_OUT_OF_RANGE, "Levels are 0 to 4."};
  }
  quality.set_level(static_cast<std::uint32_t>(level));
  return quality;
}

/// The scene's coefficient of friction goes from `before` to what `scene` says now, and with it all
/// strings that have it: which of them said so themselves is not kept once defaults are filled in.
void follow_friction(double before, v1::Scene& scene) {
  for (v1::String& string : *scene.mutable_strings()) {
    if (string.friction_coefficient() != before) continue;
    string.set_friction_coefficient(scene.friction().coefficient());
  }
}

/// Whether it is the pitch of a string that its tension tunes.
bool follows_tension(const Target& target) {
  const auto* const string = dynamic_cast<const v1::String*>(target.message);
  return string != nullptr && string->tuning() == v1::TUNING_TENSION &&
         target.field->number() == v1::String::kFrequencyHzFieldNumber;
}

void assign(const v1::Assignment& assignment, double usual_budget_us, v1::Scene& scene) {
  if (assignment.path() == "quality") {
    *scene.mutable_quality() = quality_choice(assignment, scene.quality(), usual_budget_us);
    return;
  }
  const Target target = find_target(scene, assignment.path());
  if (follows_tension(target)) {
    throw Refusal{v1::RESULT_CODE_INVALID, "It follows tension_n: the string has TUNING_TENSION."};
  }
  if (target.field->cpp_type() == Kind::CPPTYPE_MESSAGE) {
    set_pose(target, assignment);
  } else if (target.field->cpp_type() == Kind::CPPTYPE_ENUM) {
    set_enum(target, assignment);
  } else {
    const double friction = scene.friction().coefficient();
    set_number(target, assignment);
    if (scene.friction().coefficient() != friction) follow_friction(friction, scene);
  }
}

/// All that settings depend on, the knobs by quality filled in: no shape is read again.
v1::Scene without_shapes(v1::Scene scene) {
  fill_knobs(scene.quality(), *scene.mutable_solver());
  scene.clear_bodies();
  scene.clear_lines();
  for (v1::Tool& tool : *scene.mutable_tools()) tool.clear_parts();
  return scene;
}

AssignmentResult refused(const Refusal& refusal, const std::string& path) {
  AssignmentResult result;
  result.code = refusal.code;
  result.path = path;
  result.message = refusal.message;
  return result;
}

/// What contradicts another value.
std::optional<SceneProblem> contradiction(const v1::Scene& scene, double device_stiffness,
                                          SceneDescription& description) {
  SceneProblems problems = check_fields(scene);
  if (!any_fault(problems)) {
    ModelFiles no_files({});
    description = translate_scene(without_shapes(scene), device_stiffness, no_files, problems);
  }
  for (const SceneFinding& finding : check_couplings(description)) {
    problems.push_back(
        {false, "", 0, 0, finding.path, finding.message + ". " + finding.remedy, ""});
  }
  for (SceneProblem& problem : problems) {
    if (!problem.doubt) return problem;
  }
  for (std::size_t i = 0; i < description.strings.size(); ++i) {
    const auto fault = check_string(description.strings[i].parameters);
    if (!fault) continue;
    SceneProblem problem;
    problem.field = "strings[" + std::to_string(i) + "]." + std::string(fault->field);
    problem.message = "its values contradict each other";
    return problem;
  }
  return std::nullopt;
}

}  // namespace

AssignmentResult assign_parameters(const v1::Scene& scene, const v1::SetParameter& change,
                                   double device_stiffness, double usual_budget_us) {
  if (change.assignments_size() < 1 || change.assignments_size() > 64) {
    return refused({v1::RESULT_CODE_OUT_OF_RANGE, "Give 1 to 64 assignments."},
                   "set_parameter.assignments");
  }
  AssignmentResult result;
  result.scene = scene;
  for (const v1::Assignment& assignment : change.assignments()) {
    try {
      assign(assignment, usual_budget_us, result.scene);
    } catch (Refusal& refusal) {
      if (refusal.message.empty()) {
        refusal.message = unknown_parameter(result.scene, assignment.path());
      }
      return refused(refusal, assignment.path());
    }
  }
  follow_tension(result.scene);
  SceneDescription description;
  const auto fault = contradiction(result.scene, device_stiffness, description);
  if (fault) return refused({v1::RESULT_CODE_INVALID, fault->message}, fault->field);
  result.settings = scene_settings(description);
  return result;
}

}  // namespace hapticd
