// See scene_defaults.h. The numbers are those of core's own defaults.
#include "server/scene_io/scene_defaults.h"

#include <algorithm>
#include <cmath>

#include "core/contact/virtual_coupling.h"
#include "core/instrument/string_preset.h"
#include "core/scene/quality.h"
#include "server/scene_io/solver_knobs.h"

namespace hapticd {
namespace {

/// Modes of a scene that asks for waves, or modes, without saying how many.
constexpr unsigned kUsualModes = 32;
/// Sub-steps of a millisecond of a scene that does not say how many.
constexpr unsigned kUsualSubsteps = 32;

/// Sets field `NAME` of a message that is a reference named `m`, unless it is set.
template <typename Message, typename Value>
void set_absent(Message& message, bool (Message::*has)() const, void (Message::*set)(Value),
                Value value) {
  if (!(message.*has)()) (message.*set)(value);
}

void fill_tool(v1::Tool& tool) {
  const CouplingStiffness usual;
  for (v1::ToolPart& part : *tool.mutable_parts()) fill_pose(*part.mutable_pose_gp());
  fill_pose(*tool.mutable_pose_wg());
  v1::Coupling& coupling = *tool.mutable_coupling();
  if (coupling.kt_w_n_per_m().empty()) {
    set_absent(coupling, &v1::Coupling::has_kt_n_per_m, &v1::Coupling::set_kt_n_per_m, usual.kt);
  }
  if (coupling.kr_g_n_m_per_rad().empty()) {
    set_absent(coupling, &v1::Coupling::has_length_m, &v1::Coupling::set_length_m, usual.length);
  }
  v1::WorkspaceMap& map = *tool.mutable_workspace();
  set_absent(map, &v1::WorkspaceMap::has_scale, &v1::WorkspaceMap::set_scale, 1.0);
  fill_pose(*map.mutable_pose_wd());
  if (map.mirror() == v1::MIRROR_UNSPECIFIED) map.set_mirror(v1::MIRROR_NONE);
  set_absent(tool, &v1::Tool::has_force_gain, &v1::Tool::set_force_gain, 1.0);
}

/// Stiffness of a stick anchor over that of the coupling, and its most, N/m. It slips by a tenth of
/// what the coupling gives, and is above the force over the radius of the edge of a nail. Larger:
/// forces that differ by more from a finer time step, 0.1 % rms here, 5 % at 100.
constexpr double kAnchorPerCoupling = 10.0;
constexpr double kStiffestAnchor = 1e9;

/// Stiffness of the softest tool, along its stiffest axis: what a string's and an anchor's default
/// follow. A string that is as stiff as the softest axis alone would be softer than it has to be
/// along the others, and an anchor would slip there before the coupling gives.
double softest_coupling(const v1::Scene& scene) {
  double kt = CouplingStiffness{}.kt;
  for (int i = 0; i < scene.tools_size(); ++i) {
    const v1::Coupling& coupling = scene.tools(i).coupling();
    const auto& axes = coupling.kt_w_n_per_m();
    const double each =
        axes.empty() ? coupling.kt_n_per_m() : *std::max_element(axes.begin(), axes.end());
    kt = i == 0 ? each : std::min(kt, each);
  }
  return kt;
}

v1::StringLevel highest_level(const v1::Scene& scene) {
  if (scene.has_wave() || scene.has_modes()) return v1::STRING_LEVEL_WAVE;
  return scene.has_vibration() ? v1::STRING_LEVEL_FUNDAMENTAL : v1::STRING_LEVEL_STATIC;
}

/// |AB|, m; 0 where an end is missing or both are one.
double length_of(const v1::String& string) {
  if (string.p_wa_m_size() != 3 || string.p_wb_m_size() != 3) return 0.0;
  const double length =
      std::hypot(string.p_wb_m(0) - string.p_wa_m(0), string.p_wb_m(1) - string.p_wa_m(1),
                 string.p_wb_m(2) - string.p_wa_m(2));
  return length < kMinString ? 0.0 : length;
}

/// What decides the pitch where it is the density, which has to be told from a checked one; with
/// TUNING_TENSION the density that gives the pitch under the loaded tension.
void fill_tuning(v1::String& string) {
  const bool untold = string.tuning() == v1::TUNING_UNSPECIFIED;
  if (untold && string.has_linear_density_kg_per_m() && !string.has_frequency_hz()) {
    string.set_tuning(v1::TUNING_TENSION);
  }
  const double length = length_of(string);
  if (string.tuning() == v1::TUNING_TENSION && string.has_frequency_hz() && length > 0.0 &&
      string.tension_n() > 0.0) {
    set_absent(string, &v1::String::has_linear_density_kg_per_m,
               &v1::String::set_linear_density_kg_per_m,
               tuned_density(length, string.tension_n(), string.frequency_hz()));
  }
}

void fill_string(const v1::Scene& scene, StringPreset preset, v1::String& string) {
  using S = v1::String;
  const StringParameters usual = default_string(preset);
  set_absent(string, &S::has_radius_m, &S::set_radius_m, usual.radius);
  set_absent(string, &S::has_tension_n, &S::set_tension_n, usual.tension);
  set_absent(string, &S::has_youngs_modulus_pa, &S::set_youngs_modulus_pa, usual.youngs_modulus);
  fill_tuning(string);
  set_absent(string, &S::has_decay_s, &S::set_decay_s, usual.decay);
  set_absent(string, &S::has_loss_n2_per_s, &S::set_loss_n2_per_s, usual.loss_n2);
  set_absent(string, &S::has_touch_decay_s, &S::set_touch_decay_s,
             preset == StringPreset::kPaper ? string.decay_s() : usual.touch_decay);
  if (string.model() == v1::STRING_MODEL_UNSPECIFIED) {
    string.set_model(usual.model == StringContact::kStraight ? v1::STRING_MODEL_RIGID
                                                             : v1::STRING_MODEL_DEFLECTING);
  }
  if (string.displacement_scale_case() == S::DISPLACEMENT_SCALE_NOT_SET) string.set_k_s(usual.k_s);
  if (string.has_k_s_from_device()) {
    v1::DisplacementScaleFromDevice& scale = *string.mutable_k_s_from_device();
    if (!scale.has_reference_lambda()) scale.set_reference_lambda(0.5);
    if (!scale.has_reference_tension_n()) scale.set_reference_tension_n(string.tension_n());
  }
  set_absent(string, &S::has_contact_stiffness_n_per_m, &S::set_contact_stiffness_n_per_m,
             std::min(softest_coupling(scene), usual.contact_stiffness));
  if (scene.has_friction()) {
    set_absent(string, &S::has_friction_coefficient, &S::set_friction_coefficient,
               scene.friction().coefficient());
  }
  if (string.max_level() == v1::STRING_LEVEL_UNSPECIFIED) {
    string.set_max_level(highest_level(scene));
  }
}

void fill_features(StringPreset preset, v1::Scene& scene) {
  const InstrumentOptions usual = default_options(preset);
  if (scene.has_vibration()) {
    set_absent(*scene.mutable_vibration(), &v1::Vibration::has_sleep_energy,
               &v1::Vibration::set_sleep_energy, usual.sleep_energy);
  }
  if (scene.has_friction()) {
    set_absent(*scene.mutable_friction(), &v1::Friction::has_anchor_stiffness_n_per_m,
               &v1::Friction::set_anchor_stiffness_n_per_m,
               std::min(kAnchorPerCoupling * softest_coupling(scene), kStiffestAnchor));
  }
  const bool told = scene.has_wave() || scene.has_modes();
  if (scene.has_vibration() && preset == StringPreset::kDeflecting && !told) scene.mutable_wave();
  if (scene.has_wave()) {
    v1::Wave& wave = *scene.mutable_wave();
    set_absent(wave, &v1::Wave::has_modes, &v1::Wave::set_modes, kUsualModes);
    set_absent(wave, &v1::Wave::has_substeps, &v1::Wave::set_substeps, kUsualSubsteps);
  }
  if (scene.has_modes() && !scene.modes().has_count()) {
    scene.mutable_modes()->set_count(kUsualModes);
  }
  if (scene.has_tones()) {
    using T = v1::Tones;
    T& tones = *scene.mutable_tones();
    if (tones.level() == v1::TONE_LEVEL_UNSPECIFIED) {
      tones.set_level(usual.tones.level == ToneLevel::kForce ? v1::TONE_LEVEL_FORCE
                                                             : v1::TONE_LEVEL_AMPLITUDE);
    }
    set_absent(tones, &T::has_reference_amplitude_m, &T::set_reference_amplitude_m,
               usual.tones.reference_amplitude);
    set_absent(tones, &T::has_reference_force_n, &T::set_reference_force_n,
               usual.tones.reference_force);
    set_absent(tones, &T::has_gain, &T::set_gain, usual.tones.gain);
  }
  using R = v1::ReleaseDetector;
  R& release = *scene.mutable_release();
  set_absent(release, &R::has_arm_deflection_m, &R::set_arm_deflection_m,
             usual.release.arm_deflection);
  set_absent(release, &R::has_release_gap_m, &R::set_release_gap_m, usual.release.release_gap);
  set_absent(release, &R::has_refractory_s, &R::set_refractory_s, usual.release.refractory);
}

void forget_friction(v1::Scene& scene) {
  scene.clear_friction();
  for (v1::String& string : *scene.mutable_strings()) string.clear_friction_coefficient();
  for (v1::Body& body : *scene.mutable_bodies()) body.clear_friction_coefficient();
  for (v1::Line& line : *scene.mutable_lines()) line.clear_friction_coefficient();
}

/// Forgets what a preset decides, and with the paper's the friction that it has none of.
void forget_preset_fields(v1::Preset preset, v1::Scene& scene) {
  if (preset == v1::PRESET_PAPER) forget_friction(scene);
  for (v1::String& string : *scene.mutable_strings()) {
    string.clear_model();
    string.clear_displacement_scale();
    string.clear_touch_decay_s();
  }
  if (scene.has_tones()) scene.mutable_tones()->clear_level();
}

}  // namespace

void fill_pose(v1::Pose& pose) {
  if (pose.p_m().empty()) pose.mutable_p_m()->Resize(3, 0.0);
  if (!pose.q().empty()) return;
  pose.mutable_q()->Resize(4, 0.0);
  pose.set_q(0, 1.0);
}

void fill_defaults(std::optional<v1::Preset> preset, v1::Scene& scene) {
  if (preset) {
    forget_preset_fields(*preset, scene);
    scene.set_preset(*preset);
  }
  if (scene.preset() == v1::PRESET_UNSPECIFIED) scene.set_preset(v1::PRESET_DEFLECTING);
  const StringPreset named =
      scene.preset() == v1::PRESET_PAPER ? StringPreset::kPaper : StringPreset::kDeflecting;
  for (v1::Tool& tool : *scene.mutable_tools()) fill_tool(tool);
  for (v1::Body& body : *scene.mutable_bodies()) fill_pose(*body.mutable_pose_wb());
  fill_features(named, scene);
  for (v1::String& string : *scene.mutable_strings()) fill_string(scene, named, string);
  follow_tension(scene);
  fill_quality(*scene.mutable_quality());
  fill_open(OpenKnob::kUsual, {}, *scene.mutable_solver());
  fill_knobs(scene.quality(), *scene.mutable_solver());
}

void follow_tension(v1::Scene& scene) {
  for (v1::String& string : *scene.mutable_strings()) {
    if (string.tuning() != v1::TUNING_TENSION) continue;
    const double length = length_of(string);
    const double density = string.linear_density_kg_per_m();
    if (!(length > 0.0 && density > 0.0)) continue;
    const double frequency = std::sqrt(string.tension_n() / density) / (2.0 * length);
    string.clear_frequency_hz();
    if (frequency > 0.0 && frequency <= kMaxFrequency) string.set_frequency_hz(frequency);
  }
}

int modes_of(const v1::Scene& scene) {
  if (scene.has_wave()) return static_cast<int>(scene.wave().modes());
  return scene.has_modes() ? static_cast<int>(scene.modes().count()) : 0;
}

void fill_quality(v1::Quality& quality) {
  if (quality.choice_case() == v1::Quality::CHOICE_NOT_SET) quality.set_level(kDefaultQuality);
}

void fill_knobs(const v1::Quality& quality, v1::Solver& solver) {
  fill_open(OpenKnob::kByQuality, quality_of(quality_level(quality)).options, solver);
}

void choose_quality(const QualityWish& wish, v1::Scene& scene) {
  if (wish.quality) *scene.mutable_quality() = *wish.quality;
  if (!scene.quality().has_automatic()) return;
  v1::AutomaticQuality& automatic = *scene.mutable_quality()->mutable_automatic();
  if (wish.budget_us) {
    automatic.set_budget_us(*wish.budget_us);
  } else if (!automatic.has_budget_us()) {
    automatic.set_budget_us(wish.usual_budget_us);
  }
}

int quality_level(const v1::Quality& quality) {
  int level = kDefaultQuality;
  if (quality.has_level()) {
    level = static_cast<int>(quality.level());
  } else if (quality.has_max_force_error()) {
    level = quality_for(quality.max_force_error());
  }
  return std::clamp(level, 0, kQualityLevels - 1);
}

}  // namespace hapticd
