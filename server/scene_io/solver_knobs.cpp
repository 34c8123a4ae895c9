// See solver_knobs.h.
#include "server/scene_io/solver_knobs.h"

#include <array>
#include <variant>

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using Options = ContactOptions;

struct Knob {
  const char* field;  ///< of Solver
  std::variant<int Options::*, double Options::*> option;
  OpenKnob open;
};

constexpr std::array kKnobs{
    Knob{"max_substeps", &Options::sub_steps, OpenKnob::kByQuality},
    Knob{"stop_step_m", &Options::stop_tolerance, OpenKnob::kByQuality},
    Knob{"margin_m", &Options::margin, OpenKnob::kUsual},
    Knob{"skin_m", &Options::skin, OpenKnob::kUsual},
    Knob{"max_rotation_rad", &Options::rotation_step, OpenKnob::kUsual},
    Knob{"max_rows", &Options::max_rows, OpenKnob::kUsual},
    Knob{"recovery_speed_m_per_s", &Options::recovery_speed, OpenKnob::kUsual},
    Knob{"tool_level", &Options::tool_level, OpenKnob::kAbsent},
    Knob{"body_level", &Options::body_level, OpenKnob::kAbsent},
};

const pb::FieldDescriptor& field_of(const Knob& knob) {
  return *v1::Solver::descriptor()->FindFieldByName(knob.field);
}

bool has(const v1::Solver& solver, const Knob& knob) {
  return v1::Solver::GetReflection()->HasField(solver, &field_of(knob));
}

/// Whole ones are of the type uint32.
void set(const Knob& knob, const Options& options, v1::Solver& solver) {
  const pb::Reflection& r = *v1::Solver::GetReflection();
  if (const auto* whole = std::get_if<int Options::*>(&knob.option)) {
    r.SetUInt32(&solver, &field_of(knob), static_cast<std::uint32_t>(options.*(*whole)));
  } else {
    r.SetDouble(&solver, &field_of(knob), options.*std::get<double Options::*>(knob.option));
  }
}

void get(const Knob& knob, const v1::Solver& solver, Options& options) {
  const pb::Reflection& r = *v1::Solver::GetReflection();
  if (const auto* whole = std::get_if<int Options::*>(&knob.option)) {
    options.*(*whole) = static_cast<int>(r.GetUInt32(solver, &field_of(knob)));
  } else {
    options.*std::get<double Options::*>(knob.option) = r.GetDouble(solver, &field_of(knob));
  }
}

}  // namespace

ContactOptions contact_options_of(const v1::Solver& solver) {
  ContactOptions options;
  for (const Knob& knob : kKnobs) {
    if (has(solver, knob)) get(knob, solver, options);
  }
  return options;
}

void fill_open(OpenKnob kind, const ContactOptions& options, v1::Solver& solver) {
  for (const Knob& knob : kKnobs) {
    if (knob.open == kind && !has(solver, knob)) set(knob, options, solver);
  }
}

void leave_to_quality(const v1::Solver& given, v1::Solver& solver) {
  for (const Knob& knob : kKnobs) {
    if (knob.open != OpenKnob::kByQuality || has(given, knob)) continue;
    v1::Solver::GetReflection()->ClearField(&solver, &field_of(knob));
  }
}

void keep_from_quality(const v1::Solver& given, ContactOptions& options) {
  for (const Knob& knob : kKnobs) {
    if (knob.open == OpenKnob::kByQuality && has(given, knob)) get(knob, given, options);
  }
}

}  // namespace hapticd
