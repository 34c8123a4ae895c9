// What scenes may say of their strings: every range of scene.proto at its edges and just outside,
// by the field's name, and what is refused or doubted although each number alone is in its range.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "tests/core/instrument/proto_range.h"
#include "tests/core/instrument/strings.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

StringParameters usual_string() { return string_parameters(1.1, 30.0, 1.9e11, 0.34e-3); }

/// The fault found with one number of an otherwise usual description replaced.
using CheckWith = std::function<std::optional<ParameterFault>(double)>;

/// A number of a scene.
struct Field {
  const char* proto;  ///< its message and name in scene.proto
  const char* name;   ///< what a fault calls it
  bool zero_is_absent;
  CheckWith check_with;
};

Field of_string(const char* name, double StringParameters::*member, bool zero_is_absent = false) {
  return {"String", name, zero_is_absent, [member](double value) {
            StringParameters parameters = usual_string();
            parameters.*member = value;
            return check_string(parameters);
          }};
}

Field of_end(const char* name, Array3 StringParameters::*end, std::size_t axis) {
  return {"String", name, false, [end, axis](double value) {
            StringParameters parameters = usual_string();
            (parameters.*end).at(axis) = value;
            return check_string(parameters);
          }};
}

template <class Set>
Field of_options(const char* message, const char* name, Set set) {
  return {message, name, false, [set](double value) {
            InstrumentOptions options;
            set(options, value);
            return check_options(options);
          }};
}

std::vector<Field> all_fields() {
  using S = StringParameters;
  using O = InstrumentOptions;
  std::vector<Field> fields{
      of_string("radius_m", &S::radius),
      of_string("tension_n", &S::tension),
      of_string("youngs_modulus_pa", &S::youngs_modulus),
      of_string("axial_stiffness_n", &S::axial_stiffness),
      of_string("linear_density_kg_per_m", &S::linear_density, true),
      of_string("frequency_hz", &S::frequency, true),
      of_string("decay_s", &S::decay),
      of_string("loss_n2_per_s", &S::loss_n2),
      of_string("touch_decay_s", &S::touch_decay),
      of_string("k_s", &S::k_s),
      of_string("contact_stiffness_n_per_m", &S::contact_stiffness),
      of_string("inharmonicity", &S::inharmonicity),
      of_string("friction_coefficient", &S::friction_coefficient),
      of_options("Vibration", "vibration.sleep_energy",
                 [](O& o, double value) { o.sleep_energy = value; }),
      of_options("Friction", "friction.anchor_stiffness_n_per_m",
                 [](O& o, double value) { o.anchor_stiffness = value; }),
      of_options("Tones", "tones.reference_amplitude_m",
                 [](O& o, double value) { o.tones.reference_amplitude = value; }),
      of_options("Tones", "tones.reference_force_n",
                 [](O& o, double value) { o.tones.reference_force = value; }),
      of_options("Tones", "tones.gain", [](O& o, double value) { o.tones.gain = value; }),
      of_options("ReleaseDetector", "release.arm_deflection_m",
                 [](O& o, double value) { o.release.arm_deflection = value; }),
      of_options("ReleaseDetector", "release.release_gap_m",
                 [](O& o, double value) { o.release.release_gap = value; }),
      of_options("ReleaseDetector", "release.refractory_s",
                 [](O& o, double value) { o.release.refractory = value; }),
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fields.push_back(of_end("p_wa_m", &S::p_WA, axis));
    fields.push_back(of_end("p_wb_m", &S::p_WB, axis));
  }
  return fields;
}

/// Its range as scene.proto has it.
ProtoRange range_of(const Field& field) {
  static const std::map<std::string, ProtoRange> ranges = proto_ranges();
  const std::string name = field.name;
  const std::string last = name.substr(name.find('.') + 1);  // npos + 1 is the whole name
  return ranges.at(std::string(field.proto) + '.' + last);
}

void check_refused(const Field& field, double value) {
  CAPTURE(field.name);
  CAPTURE(value);
  const std::optional<ParameterFault> fault = field.check_with(value);
  REQUIRE(fault.has_value());
  CHECK(std::string(fault->field) == field.name);
  CHECK(fault->range == range_of(field).text);
  CHECK((fault->value == value || std::isnan(value)));
  CHECK(std::strlen(fault->remedy) > 10);
  CHECK(fault->remedy[std::strlen(fault->remedy) - 1] == '.');
}

void check_accepted(const Field& field, double value) {
  CAPTURE(field.name);
  CAPTURE(value);
  CHECK(!field.check_with(value).has_value());
}

TEST_CASE("the usual string and the usual options have no fault") {
  CHECK(!check_string(StringParameters{}).has_value());
  CHECK(!check_string(usual_string()).has_value());
  CHECK(!doubt_string(usual_string()).has_value());
  CHECK(!check_options(InstrumentOptions{}).has_value());
}

TEST_CASE("every number is accepted up to the edges of its range in scene.proto") {
  for (const Field& field : all_fields()) {
    const ProtoRange range = range_of(field);
    check_accepted(field, range.low_included ? range.low : std::nextafter(range.low, kInfinity));
    REQUIRE(range.high_included);
    check_accepted(field, range.high);
    check_accepted(field, 0.5 * (range.low + range.high));
  }
}

TEST_CASE("every number just outside of its range is refused by its name, and so is no number") {
  for (const Field& field : all_fields()) {
    const ProtoRange range = range_of(field);
    check_refused(field, std::nextafter(range.low, -kInfinity));
    check_refused(field, std::nextafter(range.high, kInfinity));
    if (!range.low_included && !field.zero_is_absent) check_refused(field, range.low);
    for (const double value : {kInfinity, -kInfinity, kNan, -1e300, 1e300}) {
      check_refused(field, value);
    }
  }
}

TEST_CASE("an axial stiffness that is not given is no fault, and any other below 0 is") {
  StringParameters parameters = usual_string();
  parameters.axial_stiffness = kNoAxialStiffness;
  CHECK(!check_string(parameters).has_value());
  for (const double value : {-0.5, -1.0 - 1e-9, -2.0}) {
    parameters.axial_stiffness = value;
    CHECK(check_string(parameters).has_value());
  }
}

TEST_CASE("a density or a tuning of 0 is one not given") {
  StringParameters parameters = usual_string();
  parameters.frequency = 0.0;
  parameters.linear_density = 0.0;
  CHECK(!check_string(parameters).has_value());
}

TEST_CASE("the count of modes is bounded") {
  const auto fault_with = [](int modes) {
    InstrumentOptions options;
    options.modes = modes;
    return check_options(options);
  };
  CHECK(!fault_with(0).has_value());
  CHECK(!fault_with(64).has_value());
  for (const int modes : {-1, 65, std::numeric_limits<int>::max()}) {
    REQUIRE(fault_with(modes).has_value());
    CHECK(std::string(fault_with(modes)->field) == "modes.count");
  }
}

TEST_CASE("modes are stepped 8, 16, 32 or 64 times a millisecond, and nothing between") {
  const auto fault_with = [](int substeps) {
    InstrumentOptions options;
    options.substeps = substeps;
    return check_options(options);
  };
  for (const int substeps : {8, 16, 32, 64}) CHECK(!fault_with(substeps).has_value());
  for (const int substeps : {-8, 0, 4, 9, 12, 24, 33, 48, 128, std::numeric_limits<int>::max()}) {
    CAPTURE(substeps);
    REQUIRE(fault_with(substeps).has_value());
    CHECK(std::string(fault_with(substeps)->field) == "wave.substeps");
    CHECK(std::string(fault_with(substeps)->range) == "8, 16, 32 or 64");
  }
}

TEST_CASE("the largest acceleration is above 0 and finite") {
  for (const double value : {0.0, -1.0, 1.1e6, kInfinity, kNan}) {
    InstrumentOptions options;
    options.max_acceleration = value;
    REQUIRE(check_options(options).has_value());
    CHECK(std::string(check_options(options)->field) == "max_acceleration");
  }
}

TEST_CASE("modes without vibration are refused") {
  InstrumentOptions options;
  options.vibration = false;
  CHECK(!check_options(options).has_value());
  options.modes = 16;
  REQUIRE(check_options(options).has_value());
  CHECK(std::string(check_options(options)->field) == "modes.count");
}

TEST_CASE("an enumerator that does not exist is refused") {
  StringParameters parameters = usual_string();
  parameters.model = static_cast<StringContact>(2);
  REQUIRE(check_string(parameters).has_value());
  CHECK(std::string(check_string(parameters)->field) == "model");
  parameters = usual_string();
  parameters.max_level = static_cast<StringDetail>(4);
  REQUIRE(check_string(parameters).has_value());
  CHECK(std::string(check_string(parameters)->field) == "max_level");
  InstrumentOptions options;
  options.tones.level = static_cast<ToneLevel>(2);
  REQUIRE(check_options(options).has_value());
  CHECK(std::string(check_options(options)->field) == "tones.level");
}

TEST_CASE("a density that alone would tune the string beyond 20 kHz is refused") {
  // 1 m, 1600 N: f = sqrt(T / mu) / (2 L) is 20 kHz at mu = 1e-6.
  StringParameters parameters = string_parameters(1.0, 1600.0, 1.9e11, 0.34e-3);
  parameters.frequency = 0.0;
  parameters.linear_density = 1.001e-6;
  CHECK(!check_string(parameters).has_value());
  parameters.linear_density = 0.999e-6;
  REQUIRE(check_string(parameters).has_value());
  CHECK(std::string(check_string(parameters)->field) == "linear_density_kg_per_m");
  parameters.frequency = 110.0;
  CHECK(!check_string(parameters).has_value());
}

TEST_CASE("a density more than 20 % off the tuning is doubted, not refused") {
  StringParameters parameters = usual_string();
  const double speed = 2.0 * 1.1 * 110.0;
  const double density = 30.0 / (speed * speed);
  for (const double share : {0.81, 1.0, 1.19}) {
    parameters.linear_density = share * density;
    CHECK(!doubt_string(parameters).has_value());
  }
  for (const double share : {0.01, 0.79, 1.21, 10.0}) {
    parameters.linear_density = share * density;
    CHECK(!check_string(parameters).has_value());
    const std::optional<ParameterFault> doubt = doubt_string(parameters);
    REQUIRE(doubt.has_value());
    CHECK(std::string(doubt->field) == "linear_density_kg_per_m");
    CHECK(doubt->value == parameters.linear_density);
  }
}

TEST_CASE("there is nothing to doubt about a string without density, tuning, tension or length") {
  StringParameters parameters = usual_string();
  parameters.linear_density = 50.0;
  REQUIRE(doubt_string(parameters).has_value());
  StringParameters changed = parameters;
  changed.frequency = 0.0;
  CHECK(!doubt_string(changed).has_value());
  changed = parameters;
  changed.tension = 0.0;
  CHECK(!doubt_string(changed).has_value());
  changed = parameters;
  changed.p_WB = changed.p_WA;
  CHECK(!doubt_string(changed).has_value());
}

}  // namespace
}  // namespace hapticd::test
