// The two sets of defaults a scene may name: the model as published, and strings that yield. They
// fill in what a scene leaves out and never switch a feature on. RT: plain data.
#pragma once

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"

namespace hapticd {

enum class StringPreset : std::uint8_t {
  kPaper,       ///< rigid strings, k_s 1, level by force, T_d in touch as in air
  kDeflecting,  ///< strings that yield, level by amplitude, damped by the finger
};

/// A string with the defaults of `preset`.
[[nodiscard]] inline StringParameters default_string(StringPreset preset) noexcept {
  StringParameters string;
  if (preset == StringPreset::kPaper) {
    string.model = StringContact::kStraight;
    string.touch_decay = string.decay;
  }
  return string;
}

/// Options with the defaults of `preset`.
[[nodiscard]] inline InstrumentOptions default_options(StringPreset preset) noexcept {
  InstrumentOptions options;
  if (preset == StringPreset::kPaper) options.tones.level = ToneLevel::kForce;
  return options;
}

}  // namespace hapticd
