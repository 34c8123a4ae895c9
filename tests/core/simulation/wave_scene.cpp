// See wave_scene.h.
#include "tests/core/simulation/wave_scene.h"

#include "core/math/elementary.h"

namespace hapticd::test {

InstrumentOptions wave_options() {
  InstrumentOptions options;
  options.modes = 32;
  return options;
}

StringParameters WaveScene::string() const {
  StringParameters string;
  string.tension = tension;
  string.frequency = frequency;
  string.youngs_modulus = axial_stiffness / (kPi * string.radius * string.radius);
  string.decay = decay;
  string.friction_coefficient = friction;
  string.contact_stiffness = kt;
  return string;
}

Instrument wave_instrument(const WaveScene& scene, bool sounds) {
  InstrumentOptions options = wave_options();
  options.friction = scene.friction > 0.0;
  if (!sounds) {
    options.modes = 0;
    options.vibration = false;
  }
  Instrument instrument(1, scene.string(), options, {{Vector3::Zero(), scene.tip}});
  instrument.scene().stiffness.kt = scene.kt;
  return instrument;
}

Vector3 felt_force(const Instrument& instrument) {
  return instrument.output().tool(0).F_computed_H_W.f;
}

}  // namespace hapticd::test
