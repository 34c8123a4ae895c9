// Checks and constants of a string. See string_parameters.h. RT: yes.
#include "core/instrument/string_parameters.h"

#include <array>
#include <cmath>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

constexpr ParameterRange kCoordinate{-1e7, 1e7, true, "[-1e7, 1e7]"};
constexpr ParameterRange kFrequency{0.0, kMaxFrequency, false, "(0, 2e4]"};

/// Share of the tuning's linear density a given one may differ by without a doubt, 1. Normal value
/// 0.2; smaller doubts wound strings, larger lets a wrong gauge pass.
constexpr double kMaxDensityError = 0.2;

/// Modal masses between these are usable, kg: their products with squared frequencies stay in the
/// range of a double. Normal values 1e-100 and 1e100; a tuning that needs others never sounds.
constexpr double kMinModalMass = 1e-100;
constexpr double kMaxModalMass = 1e100;

/// A number of the scene with its range.
struct NumberField {
  const char* field;
  double StringParameters::*value;
  ParameterRange range;
  std::optional<double> absent;  ///< "not given", although the range excludes it
  const char* remedy;
};

constexpr std::array<NumberField, 13> kNumberFields{{
    {"radius_m",
     &StringParameters::radius,
     {0.0, 1.0, true, "[0, 1]"},
     std::nullopt,
     "Give the radius in metres; 0 is a thin line."},
    {"tension_n",
     &StringParameters::tension,
     {0.0, 1e6, true, "[0, 1e6]"},
     std::nullopt,
     "Give the tension in newtons; 0 is a slack string."},
    {"youngs_modulus_pa",
     &StringParameters::youngs_modulus,
     {0.0, 1e13, true, "[0, 1e13]"},
     std::nullopt,
     "Give Young's modulus in pascals; steel has 1.9e11."},
    {"axial_stiffness_n",
     &StringParameters::axial_stiffness,
     {0.0, 1e12, true, "[0, 1e12]"},
     kNoAxialStiffness,
     "Give E A in newtons, or leave it out for that of a solid string."},
    {"linear_density_kg_per_m",
     &StringParameters::linear_density,
     {0.0, 100.0, false, "(0, 100]"},
     0.0,
     "Give the mass per metre in kilograms, or leave it out and give frequency_hz."},
    {"frequency_hz", &StringParameters::frequency, kFrequency, 0.0,
     "Give the fundamental in hertz, or leave it out for a string that follows its density."},
    {"decay_s",
     &StringParameters::decay,
     {0.0, 1000.0, false, "(0, 1000]"},
     std::nullopt,
     "Give the time in seconds in which the amplitude falls to 1/e."},
    {"loss_n2_per_s",
     &StringParameters::loss_n2,
     {0.0, 1e3, true, "[0, 1e3]"},
     std::nullopt,
     "Give the loss in 1/s that mode n has n^2 times; 0.002 is usual."},
    {"touch_decay_s",
     &StringParameters::touch_decay,
     {0.0, 1000.0, false, "(0, 1000]"},
     std::nullopt,
     "Give the time in seconds in which a finger damps the amplitude to 1/e."},
    {"k_s",
     &StringParameters::k_s,
     {0.0, 1e6, false, "(0, 1e6]"},
     std::nullopt,
     "Give the haptic displacement per metre of deflection; 1 is usual."},
    {"contact_stiffness_n_per_m",
     &StringParameters::contact_stiffness,
     {1e-3, 1e9, true, "[1e-3, 1e9]"},
     std::nullopt,
     "Give the stiffness in newtons per metre; the smaller of kt and 1000 is usual."},
    {"inharmonicity",
     &StringParameters::inharmonicity,
     {0.0, 0.1, true, "[0, 0.1]"},
     std::nullopt,
     "Give B; 0 is an ideal string."},
    {"friction_coefficient",
     &StringParameters::friction_coefficient,
     {0.0, 10.0, true, "[0, 10]"},
     std::nullopt,
     "Give the coefficient of friction; 0 is frictionless."},
}};

std::optional<ParameterFault> check_end(const char* field, const Array3& end) noexcept {
  for (const double coordinate : end) {
    if (!contains(kCoordinate, coordinate)) {
      return ParameterFault{field, coordinate, kCoordinate.text,
                            "Give x, y and z in metres, in the world's frame."};
    }
  }
  return std::nullopt;
}

/// L = |AB|, m; 0 below kMinString.
double length_of(const StringParameters& parameters) noexcept {
  const double x = parameters.p_WB[0] - parameters.p_WA[0];
  const double y = parameters.p_WB[1] - parameters.p_WA[1];
  const double z = parameters.p_WB[2] - parameters.p_WA[2];
  const double length = std::sqrt((x * x + y * y) + z * z);
  return length < kMinString ? 0.0 : length;
}

/// f_1, Hz: the tuning, or what the density gives; 0 when neither does.
double fundamental(const StringParameters& parameters, double length) noexcept {
  if (length <= 0.0 || parameters.tension <= 0.0) return 0.0;
  if (!density_decides(parameters)) return parameters.frequency;
  return std::sqrt(parameters.tension / parameters.linear_density) / (2.0 * length);
}

}  // namespace

std::optional<ParameterFault> check_string(const StringParameters& parameters) noexcept {
  if (const auto fault = check_end("p_wa_m", parameters.p_WA)) return fault;
  if (const auto fault = check_end("p_wb_m", parameters.p_WB)) return fault;
  for (const NumberField& entry : kNumberFields) {
    const double value = parameters.*entry.value;
    if (value == entry.absent) continue;
    if (!contains(entry.range, value)) {
      return ParameterFault{entry.field, value, entry.range.text, entry.remedy};
    }
  }
  if (parameters.model > kMaxStringContact) {
    return ParameterFault{"model", static_cast<double>(parameters.model), "a model of strings",
                          "Choose what a contact does to the string."};
  }
  if (parameters.tuning > StringTuning::kTension) {
    return ParameterFault{"tuning", static_cast<double>(parameters.tuning), "frequency or tension",
                          "Choose what decides the pitch."};
  }
  if (parameters.max_level > StringDetail::kModes) {
    return ParameterFault{"max_level", static_cast<double>(parameters.max_level),
                          "rigid, static, fundamental or modes",
                          "Choose the highest model the string may climb to."};
  }
  const double frequency = fundamental(parameters, length_of(parameters));
  if (frequency > kFrequency.high) {
    return ParameterFault{"linear_density_kg_per_m", parameters.linear_density,
                          "such that the fundamental is <= 2e4 Hz",
                          "Give frequency_hz, more density, less tension or a longer string."};
  }
  return std::nullopt;
}

std::optional<ParameterFault> doubt_string(const StringParameters& parameters) noexcept {
  const double length = length_of(parameters);
  if (length <= 0.0 || parameters.tension <= 0.0) return std::nullopt;
  if (parameters.frequency <= 0.0 || parameters.linear_density <= 0.0) return std::nullopt;
  const double density = tuned_density(length, parameters.tension, parameters.frequency);
  const double error = std::fabs(parameters.linear_density - density);
  if (error <= kMaxDensityError * density) return std::nullopt;
  return ParameterFault{"linear_density_kg_per_m", parameters.linear_density,
                        "within 20 % of tension_n / (2 length frequency_hz)^2",
                        parameters.tuning == StringTuning::kTension
                            ? "The density wins; correct the tuning or leave it out."
                            : "The tuning wins; correct the density or leave it out."};
}

double axial_stiffness_of(const StringParameters& parameters) noexcept {
  if (parameters.axial_stiffness != kNoAxialStiffness) return parameters.axial_stiffness;
  return parameters.youngs_modulus * (kPi * (parameters.radius * parameters.radius));
}

bool density_decides(const StringParameters& parameters) noexcept {
  const bool chosen = parameters.tuning == StringTuning::kTension || parameters.frequency <= 0.0;
  return chosen && parameters.linear_density > 0.0;
}

double tuned_density(double length, double tension, double frequency) noexcept {
  const double speed = 2.0 * length * frequency;
  return tension / speed / speed;
}

StringConstants derive_string(const StringParameters& parameters) noexcept {
  StringConstants string;
  string.length = length_of(parameters);
  string.tension = parameters.tension;
  string.axial_stiffness = axial_stiffness_of(parameters);
  const double frequency = fundamental(parameters, string.length);
  if (frequency > 0.0) {
    const double density = tuned_density(string.length, string.tension, frequency);
    const double modal_mass = 0.5 * density * string.length;
    if (modal_mass >= kMinModalMass && modal_mass <= kMaxModalMass) {
      string.frequency = frequency;
      string.modal_mass = modal_mass;
    }
  }
  string.decay = parameters.decay;
  string.loss_n2 = parameters.loss_n2;
  string.touch_decay = parameters.touch_decay;
  string.k_s = parameters.k_s;
  string.contact_stiffness = parameters.contact_stiffness;
  string.inharmonicity = parameters.inharmonicity;
  string.friction_coefficient = parameters.friction_coefficient;
  const bool sphere = string.length <= 0.0;
  string.model = sphere ? StringContact::kStraight : parameters.model;
  string.max_level = sphere ? StringDetail::kLine : parameters.max_level;
  return string;
}

double k_s_from_device(double length, double reference_tension, double lambda,
                       double device_stiffness) noexcept {
  return reference_tension / (length * lambda * (1.0 - lambda)) / device_stiffness;
}

}  // namespace hapticd
