// See scene_translation.h.
#include "server/scene_io/scene_translation.h"

#include <sstream>
#include <stdexcept>

#include "core/contact/coupling_axes.h"
#include "core/math/rotation.h"
#include "proto/hints/nearest_name.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/solver_knobs.h"

namespace hapticd {
namespace {

/// Largest deviation of a quaternion's norm from 1, as a factor, that is taken for carelessness.
constexpr double kMinNorm = 0.5;
constexpr double kMaxNorm = 2.0;

std::string indexed(const std::string& field, int i) {
  return field + "[" + std::to_string(i) + "]";
}

Vector3 vector_of(const google::protobuf::RepeatedField<double>& numbers, int first = 0) {
  return {numbers.Get(first), numbers.Get(first + 1), numbers.Get(first + 2)};
}

/// Of all that a string can lie on.
std::vector<std::string> things_to_touch(const v1::Scene& scene) {
  std::vector<std::string> names;
  for (const v1::Line& line : scene.lines()) names.push_back(line.name());
  for (const v1::Body& body : scene.bodies()) names.push_back(body.name());
  return names;
}

class Translation {
 public:
  Translation(double device_stiffness, ModelFiles& files, SceneProblems& problems)
      : device_stiffness_(device_stiffness), files_(files), problems_(problems) {}

  SceneDescription translate(const v1::Scene& scene);

 private:
  void fault(const std::string& path, std::string message, std::string remedy) {
    problems_.push_back({false, "", 0, 0, path, std::move(message), std::move(remedy)});
  }
  Pose pose(const v1::Pose& pose, const std::string& path);
  ShapeDescription shape(const v1::Shape& shape, const std::string& path);
  ShapeDescription written_out(const v1::Spheres& spheres, const std::string& path);
  ToolDescription tool(const v1::Tool& tool, const std::string& path);
  CouplingStiffness coupling(const v1::Coupling& coupling, const std::string& path);
  LineDescription line(const v1::Line& line, const std::string& path);
  StringDescription string(const v1::Scene& scene, const v1::String& string,
                           const std::string& path);
  void touch(const v1::Scene& scene, const v1::String& string, const std::string& path,
             StringDescription& result);
  void need(const v1::Scene& scene, const v1::String& string, const std::string& path);
  void waves(const v1::Scene& scene);

  double device_stiffness_;
  ModelFiles& files_;
  SceneProblems& problems_;
};

Pose Translation::pose(const v1::Pose& pose, const std::string& path) {
  Quaternion q(pose.q(0), pose.q(1), pose.q(2), pose.q(3));
  const double norm = q.norm();
  if (!(norm >= kMinNorm && norm <= kMaxNorm)) {
    fault(path + ".q", "its norm is " + std::to_string(norm) + ", not in [0.5, 2]",
          "Give a unit quaternion, w first.");
    q = Quaternion::Identity();
  }
  return {renormalised(q), vector_of(pose.p_m())};
}

ShapeDescription Translation::written_out(const v1::Spheres& spheres, const std::string& path) {
  ShapeDescription result;
  result.exact = true;
  const int count = spheres.centre_m_size() / 3;
  if (count == 0) fault(path + ".centre_m", "there is no sphere", "Give x, y and z of each.");
  if (spheres.radius_m_size() != 1 && spheres.radius_m_size() != count) {
    fault(path + ".radius_m",
          std::to_string(spheres.radius_m_size()) + " radii for " + std::to_string(count) +
              " centres",
          "Give one radius for all, or one for each.");
    return result;
  }
  if (count == 0) return result;
  std::vector<Sphere> leaves;
  leaves.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    leaves.push_back({vector_of(spheres.centre_m(), 3 * i),
                      spheres.radius_m(spheres.radius_m_size() == 1 ? 0 : i)});
  }
  MeasuredTree file;
  file.tree = build_sphere_tree(leaves);
  file.source_name = "spheres of the scene";
  result.tree = std::make_shared<const MeasuredTree>(std::move(file));
  return result;
}

ShapeDescription Translation::shape(const v1::Shape& shape, const std::string& path) {
  ShapeDescription result;
  if (shape.has_spheres()) {
    result = written_out(shape.spheres(), path + ".spheres");
  } else if (shape.has_tree()) {
    try {
      result.tree = files_.tree(shape.tree());
      result.tree_name = shape.tree();
    } catch (const std::runtime_error& error) {
      fault(path + ".tree", error.what(),
            "Make it with hapticd-model build, and put it beside the scene's file or into a folder "
            "of models.");
    }
  } else {
    fault(path, "there is nothing to touch", "Give a tree or spheres.");
  }
  if (shape.mesh().empty()) return result;
  try {
    files_.note_mesh(shape.mesh());
    result.mesh = shape.mesh();
  } catch (const std::runtime_error& error) {
    fault(path + ".mesh", error.what(), "Leave it out: the spheres are drawn.");
  }
  return result;
}

CouplingStiffness Translation::coupling(const v1::Coupling& coupling, const std::string& path) {
  const auto& along = coupling.kt_w_n_per_m();
  const auto& about = coupling.kr_g_n_m_per_rad();
  if (!along.empty() && coupling.has_kt_n_per_m()) {
    fault(path + ".kt_w_n_per_m", "kt_n_per_m says the same of all axes",
          "Drop kt_n_per_m to have one stiffness per axis, or kt_w_n_per_m to have one for all.");
  }
  if (!about.empty() && coupling.has_length_m()) {
    fault(path + ".kr_g_n_m_per_rad", "length_m says the same of all axes",
          "Drop length_m to have one stiffness per axis, or kr_g_n_m_per_rad to have one for all.");
  }
  if (along.empty() && about.empty()) return {coupling.kt_n_per_m(), coupling.length_m()};
  const double kt = coupling.kt_n_per_m();
  const Vector3 along_W = along.empty() ? Vector3(kt, kt, kt) : vector_of(along);
  const double kr = CouplingStiffness{along_W.maxCoeff(), coupling.length_m()}.kr();
  const Vector3 about_G = about.empty() ? Vector3(kr, kr, kr) : vector_of(about);
  return coupling_of_axes(along_W, about_G);
}

ToolDescription Translation::tool(const v1::Tool& tool, const std::string& path) {
  ToolDescription result;
  result.tool_id = tool.tool_id();
  result.name = tool.name();
  for (int i = 0; i < tool.parts_size(); ++i) {
    const v1::ToolPart& part = tool.parts(i);
    const std::string part_path = indexed(path + ".parts", i);
    PartDescription translated;
    translated.name = part.name();
    translated.shape = shape(part.shape(), part_path + ".shape");
    translated.X_GP = pose(part.pose_gp(), part_path + ".pose_gp");
    if (part.has_fingertip()) {
      translated.softness = {part.fingertip().stiffness_n_per_m(),
                             part.fingertip().damping_n_s_per_m()};
    }
    result.parts.push_back(std::move(translated));
  }
  result.X_WG = pose(tool.pose_wg(), path + ".pose_wg");
  result.coupling = coupling(tool.coupling(), path + ".coupling");
  result.coupling_damping = tool.coupling().damping_n_s_per_m();
  const v1::WorkspaceMap& map = tool.workspace();
  result.workspace.scale = map.scale();
  result.workspace.X_WD = pose(map.pose_wd(), path + ".workspace.pose_wd");
  result.workspace.mirror = map.mirror() == v1::MIRROR_X   ? Mirror::kX
                            : map.mirror() == v1::MIRROR_Z ? Mirror::kZ
                                                           : Mirror::kNone;
  if (map.has_clutch_button()) {
    result.workspace.clutch_button = static_cast<int>(map.clutch_button());
  }
  if (map.has_recentre_button()) {
    result.workspace.recentre_button = static_cast<int>(map.recentre_button());
  }
  result.force_gain = tool.force_gain();
  return result;
}

LineDescription Translation::line(const v1::Line& line, const std::string& path) {
  LineDescription result;
  result.name = line.name();
  result.radius = line.radius_m();
  result.friction_coefficient = line.friction_coefficient();
  if (line.points_w_m_size() < 6) {
    fault(path + ".points_w_m", "a line needs two points", "Give x, y and z of each corner.");
  }
  for (int i = 0; i + 2 < line.points_w_m_size(); i += 3) {
    result.points_W.push_back(vector_of(line.points_w_m(), i));
  }
  return result;
}

StringDescription Translation::string(const v1::Scene& scene, const v1::String& string,
                                      const std::string& path) {
  StringDescription result;
  result.name = string.name();
  result.sag = string.sag_m();
  StringParameters& p = result.parameters;
  const bool ends = string.p_wa_m_size() == 3 && string.p_wb_m_size() == 3;
  if (!ends) {
    fault(path + (string.p_wa_m_size() == 3 ? ".p_wb_m" : ".p_wa_m"), "an end is missing",
          "Give x, y and z of both ends.");
    return result;
  }
  p.p_WA = to_array(vector_of(string.p_wa_m()));
  p.p_WB = to_array(vector_of(string.p_wb_m()));
  p.radius = string.radius_m();
  p.tension = string.tension_n();
  p.youngs_modulus = string.youngs_modulus_pa();
  if (string.has_axial_stiffness_n()) p.axial_stiffness = string.axial_stiffness_n();
  p.linear_density = string.linear_density_kg_per_m();
  p.frequency = string.frequency_hz();
  p.tuning =
      string.tuning() == v1::TUNING_TENSION ? StringTuning::kTension : StringTuning::kFrequency;
  p.decay = string.decay_s();
  p.loss_n2 = string.loss_n2_per_s();
  p.touch_decay = string.touch_decay_s();
  // In the order of the wire.
  p.model = static_cast<StringContact>(string.model() - v1::STRING_MODEL_RIGID);
  p.contact_stiffness = string.contact_stiffness_n_per_m();
  touch(scene, string, path, result);
  p.inharmonicity = string.inharmonicity();
  p.friction_coefficient = string.friction_coefficient();
  p.max_level = static_cast<StringDetail>(string.max_level() - v1::STRING_LEVEL_RIGID);
  if (string.has_k_s_from_device()) {
    const v1::DisplacementScaleFromDevice& from = string.k_s_from_device();
    const double length = (to_vector(p.p_WB) - to_vector(p.p_WA)).norm();
    const double stiffness =
        from.has_device_stiffness_n_per_m() ? from.device_stiffness_n_per_m() : device_stiffness_;
    p.k_s = k_s_from_device(length, from.reference_tension_n(), from.reference_lambda(), stiffness);
  } else {
    p.k_s = string.k_s();
  }
  need(scene, string, path);
  return result;
}

/// What it lies on, by name.
void Translation::touch(const v1::Scene& scene, const v1::String& string, const std::string& path,
                        StringDescription& result) {
  for (int k = 0; k < string.touch_size(); ++k) {
    const auto named = [&](const auto& things) {
      std::vector<std::size_t> numbers;
      for (int i = 0; i < things.size(); ++i) {
        if (things[i].name() == string.touch(k)) numbers.push_back(static_cast<std::size_t>(i));
      }
      return numbers;
    };
    const auto lines = named(scene.lines());
    const auto bodies = named(scene.bodies());
    if (lines.empty() && bodies.empty()) {
      fault(indexed(path + ".touch", k), "'" + string.touch(k) + "' is no line or body",
            "Give the name of one in the scene." +
                hints::did_you_mean(string.touch(k), things_to_touch(scene)));
    }
    result.touched_lines.insert(result.touched_lines.end(), lines.begin(), lines.end());
    result.touched_bodies.insert(result.touched_bodies.end(), bodies.begin(), bodies.end());
  }
}

/// Faults of what `string` asks for and nothing gives.
void Translation::need(const v1::Scene& scene, const v1::String& string, const std::string& path) {
  const bool wave = string.max_level() == v1::STRING_LEVEL_WAVE;
  const bool rings = wave || string.max_level() == v1::STRING_LEVEL_FUNDAMENTAL;
  const bool no_wave = wave && modes_of(scene) == 0;
  if ((rings && !scene.has_vibration()) || no_wave) {
    fault(path + ".max_level",
          "it needs " + std::string(no_wave ? "wave" : "vibration") +
              ", which the scene does not have",
          "Leave it out: a string climbs as high as the scene allows.");
  }
  if (string.tuning() == v1::TUNING_FREQUENCY && !string.has_frequency_hz()) {
    fault(path + ".tuning", "it needs frequency_hz", "Give the fundamental in hertz.");
  }
  if (string.tuning() == v1::TUNING_TENSION && !string.has_linear_density_kg_per_m()) {
    fault(path + ".tuning", "it needs linear_density_kg_per_m",
          "Give it, or frequency_hz of a string that has tension and length.");
  }
}

/// What is wrong or doubtful in what a scene says of waves and modes.
void Translation::waves(const v1::Scene& scene) {
  const char* const field = scene.has_wave() ? "wave" : "modes";
  if (scene.has_wave() && scene.has_modes()) {
    fault("wave", "modes is given, too, which is what wave was before it", "Leave out modes.");
  }
  if (modes_of(scene) > 0 && !scene.has_vibration()) {
    fault(field, "it needs vibration, which the scene does not have",
          "Add vibration, or leave it out.");
  }
  if (scene.has_modes()) {
    const std::string count = std::to_string(modes_of(scene));
    problems_.push_back({true, "", 0, 0, "modes", "wave plays it, in " + count + " modes",
                         "Write wave { modes: " + count + " } instead."});
  }
}

InstrumentOptions instrument_of(const v1::Scene& scene) {
  InstrumentOptions options;
  options.vibration = scene.has_vibration();
  if (options.vibration) {
    options.sleep_energy = scene.vibration().sleep_energy();
    options.pitch_glide = scene.vibration().has_pitch_glide();
  }
  options.modes = modes_of(scene);
  if (scene.has_wave()) options.substeps = static_cast<int>(scene.wave().substeps());
  options.friction = scene.has_friction();
  if (options.friction) options.anchor_stiffness = scene.friction().anchor_stiffness_n_per_m();
  // The paper leaves it out; else it is what makes the force of a string a gradient.
  options.lateral_force = scene.has_lateral_force() || scene.preset() != v1::PRESET_PAPER;
  options.release = {scene.release().arm_deflection_m(), scene.release().release_gap_m(),
                     scene.release().refractory_s()};
  options.tones.enabled = scene.has_tones();
  if (options.tones.enabled) {
    const v1::Tones& tones = scene.tones();
    options.tones = {
        true, tones.level() == v1::TONE_LEVEL_FORCE ? ToneLevel::kForce : ToneLevel::kAmplitude,
        tones.reference_amplitude_m(), tones.reference_force_n(), tones.gain()};
  }
  return options;
}

SceneDescription Translation::translate(const v1::Scene& scene) {
  SceneDescription result;
  result.name = scene.name();
  if (scene.name().find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") !=
      std::string::npos) {
    fault("name", "'" + scene.name() + "' has characters other than a-z 0-9 _",
          "Choose such a name.");
  }
  for (int i = 0; i < scene.tools_size(); ++i) {
    result.tools.push_back(tool(scene.tools(i), indexed("tools", i)));
  }
  for (int i = 0; i < scene.bodies_size(); ++i) {
    const v1::Body& body = scene.bodies(i);
    const std::string path = indexed("bodies", i);
    result.bodies.push_back({body.name(), shape(body.shape(), path + ".shape"),
                             pose(body.pose_wb(), path + ".pose_wb"), body.friction_coefficient()});
  }
  for (int i = 0; i < scene.lines_size(); ++i) {
    result.lines.push_back(line(scene.lines(i), indexed("lines", i)));
  }
  for (int i = 0; i < scene.strings_size(); ++i) {
    result.strings.push_back(string(scene, scene.strings(i), indexed("strings", i)));
  }
  result.instrument = instrument_of(scene);
  result.tones = scene.has_tones();
  result.torque = scene.has_torque();
  result.contact = contact_options_of(scene.solver());
  if (!(result.contact.margin > result.contact.skin)) {
    std::ostringstream message;
    message << result.contact.margin << " is not above skin_m, " << result.contact.skin
            << ": the tool would keep off what it does not see";
    fault("solver.margin_m", message.str(), "Give a larger margin_m, or a smaller skin_m.");
  }
  result.quality_level = static_cast<std::uint32_t>(quality_level(scene.quality()));
  result.quality_automatic = scene.quality().has_automatic();
  waves(scene);
  return result;
}

}  // namespace

SceneDescription translate_scene(const v1::Scene& scene, double device_stiffness, ModelFiles& files,
                                 SceneProblems& problems) {
  return Translation(device_stiffness, files, problems).translate(scene);
}

}  // namespace hapticd
