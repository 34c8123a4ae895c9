// The presets against the table in scene.proto.
#include "core/instrument/string_preset.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("the preset paper has rigid strings that ring under a finger as in air, level by force") {
  const StringParameters string = default_string(StringPreset::kPaper);
  const InstrumentOptions options = default_options(StringPreset::kPaper);
  CHECK(string.model == StringContact::kStraight);
  CHECK(string.k_s == 1.0);
  CHECK(string.touch_decay == string.decay);
  CHECK(options.tones.level == ToneLevel::kForce);
  CHECK_FALSE(options.friction);
  CHECK_FALSE(options.lateral_force);
  CHECK_FALSE(check_string(string).has_value());
  CHECK_FALSE(check_options(options).has_value());
}

TEST_CASE(
    "the preset deflecting has strings that yield, damped by the finger, level by amplitude") {
  const StringParameters string = default_string(StringPreset::kDeflecting);
  const InstrumentOptions options = default_options(StringPreset::kDeflecting);
  CHECK(string.model == StringContact::kYielding);
  CHECK(string.touch_decay == 0.03);
  CHECK(options.tones.level == ToneLevel::kAmplitude);
  CHECK_FALSE(options.friction);
  CHECK_FALSE(options.lateral_force);
}

}  // namespace hapticd::test
