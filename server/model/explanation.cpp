// See explanation.h. Numbers that are not of the scene at hand are closed forms, or stand in
// string_costs.inc and tests/benchmark/results.
#include "server/model/explanation.h"

#include <algorithm>
#include <iomanip>
#include <set>
#include <sstream>
#include <vector>

#include "core/scene/quality.h"
#include "core/scene/sagging_cable.h"
#include "server/model/string_cost.h"
#include "server/model/surface_ripple.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {
namespace {

std::string in_um(double metres) {
  std::ostringstream text;
  text << std::setprecision(3) << 1e6 * metres << " um";
  return text.str();
}

std::string spheres(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " sphere" : " spheres");
}

void print_shape(std::ostream& out, const std::string& name, const ShapeDescription& shape,
                 int level) {
  const MeasuredTree& file = *shape.tree;
  out << "  " << name << ": ";
  if (shape.exact) {
    out << spheres(file.tree.leaf_r.size()) << " as written, exact\n";
    return;
  }
  const auto coarse = static_cast<std::size_t>(level - 1);
  if (level > 0 && coarse < file.levels.size()) {
    out << file.levels[coarse].spheres << " spheres of level " << level << " of " << shape.tree_name
        << ", at most " << in_um(file.levels[coarse].outer);
  } else {
    out << spheres(file.tree.leaf_r.size()) << " of " << shape.tree_name << ", at most "
        << in_um(file.outer);
  }
  out << " outside its mesh";
  const double blend = file.tree.blend.width;
  if (blend > 0.0 && level == 0) {
    out << ", blended over " << std::setprecision(3) << 1e3 * blend << " mm into one surface";
  }
  if (file.inner > 0.0) out << ", which may stick out of them by " << in_um(file.inner);
  out << "\n";
}

void print_ripple(std::ostream& out, const ShapeDescription& shape) {
  const SurfaceRipple ripple = measure_ripple(shape.tree->tree);
  if (ripple.patches == 0) return;
  constexpr double kDegree = 57.29577951308232;
  out << "    ripple under a tip of " << 1e3 * kRippleTip << " mm: " << in_um(ripple.height)
      << " and " << std::setprecision(2) << kDegree * ripple.angle << " degrees rms\n";
}

int level_or_leaves(int level) { return level == kLeafLevel ? 0 : level; }

/// Of axes that differ.
void print_axes(std::ostream& out, const CouplingStiffness& stiffness) {
  if (!stiffness.per_axis) return;
  const auto axes = [&out](const Vector3& k) -> std::ostream& {
    return out << k.x() << ", " << k.y() << ", " << k.z();
  };
  out << "  coupling: ";
  axes(stiffness.along_W()) << " N/m along x, y, z of the world; ";
  axes(stiffness.about_G()) << " N m/rad about x, y, z of the tool\n";
}

/// What follows the live tension_n of a string.
const char* tuning_of(const StringParameters& string) {
  if (derive_string(string).frequency <= 0.0) return "no pitch";
  return density_decides(string) ? "the pitch follows tension_n, the linear density holds"
                                 : "the pitch holds, the linear density follows tension_n";
}

/// Once, where it is the same of all strings.
void print_tuning(std::ostream& out, const std::vector<StringDescription>& strings) {
  std::set<std::string> kinds;
  for (const StringDescription& string : strings) kinds.insert(tuning_of(string.parameters));
  if (kinds.size() == 1) {
    out << "  tuning: " << *kinds.begin() << "\n";
    return;
  }
  for (const StringDescription& string : strings) {
    out << "  tuning of " << string.name << ": " << tuning_of(string.parameters) << "\n";
  }
}

void print_objects(std::ostream& out, const Scene& scene) {
  const SceneDescription& d = scene.description();
  for (std::size_t i = 0; i < d.tools.size(); ++i) {
    out << "tool " << d.tools[i].tool_id << ", " << d.tools[i].name << ": "
        << spheres(scene.tool_spheres(i)) << "\n";
    print_axes(out, d.tools[i].coupling);
    for (const PartDescription& part : d.tools[i].parts) {
      const bool soft = part.softness.stiffness > 0.0;
      print_shape(out, part.name + (soft ? " (soft)" : ""), part.shape,
                  level_or_leaves(d.contact.tool_level));
    }
  }
  if (!d.bodies.empty()) out << "bodies: " << spheres(scene.body_spheres()) << "\n";
  for (const BodyDescription& body : d.bodies) {
    print_shape(out, body.name, body.shape, level_or_leaves(d.contact.body_level));
    if (d.contact.body_level == kLeafLevel) print_ripple(out, body.shape);
  }
  const std::size_t capsules = scene.capsule_owners().size() - scene.string_pieces();
  if (!d.lines.empty()) {
    out << "rigid lines: " << d.lines.size() << " of " << capsules << " capsules, exact\n";
  }
  if (!d.strings.empty()) {
    out << "strings: " << d.strings.size();
    if (scene.string_pieces() != d.strings.size()) {
      out << " of " << scene.string_pieces() << " pieces";
    }
    out << "\n";
    print_tuning(out, d.strings);
  }
  for (const StringDescription& string : d.strings) {
    if (string.sag == 0.0) continue;
    out << "  " << string.name << ": " << cable_pieces(string.sag) << " straight pieces, at most "
        << in_um(cable_error(string.sag))
        << " off the parabola; each yields between its own ends\n";
  }
}

/// Something a scene may have.
struct Feature {
  bool on;
  std::string with;
  std::string without;
};

/// What strings lie on, and what of bodies and lines is rough.
void add_touches(const SceneDescription& d, std::vector<Feature>& list) {
  const auto lies = [](const StringDescription& string) {
    return !string.touched_lines.empty() || !string.touched_bodies.empty();
  };
  const auto lying = std::count_if(d.strings.begin(), d.strings.end(), lies);
  list.push_back({lying > 0,
                  std::to_string(lying) + " of " + std::to_string(d.strings.size()) +
                      " strings lie on lines and bodies where they are pressed on them",
                  "strings on lines and bodies: they pass them; touch names what they lie on"});
  const auto rough = [](const auto& object) { return object.friction_coefficient > 0.0; };
  const auto rough_ones = std::count_if(d.bodies.begin(), d.bodies.end(), rough) +
                          std::count_if(d.lines.begin(), d.lines.end(), rough);
  list.push_back({d.instrument.friction && rough_ones > 0,
                  "friction of " + std::to_string(rough_ones) + " of " +
                      std::to_string(d.bodies.size() + d.lines.size()) + " bodies and lines",
                  "friction of bodies and lines"});
}

std::vector<Feature> features_of(const SceneDescription& d) {
  const InstrumentOptions& o = d.instrument;
  bool yields = false;
  bool rigid = false;
  for (const StringDescription& string : d.strings) {
    const bool one = string.parameters.model != StringContact::kStraight;
    yields = yields || one;
    rigid = rigid || !one;
  }
  std::vector<Feature> list;
  list.push_back({d.torque, "torque: the wrench has all six components",
                  "torque: forces alone are rendered; contact still turns the tool"});
  if (d.strings.empty()) {
    list.push_back({false, "", "strings: there are none, and nothing of them is computed"});
    return list;
  }
  if (yields) {
    list.push_back({true,
                    "strings that yield: bent by the exact law of Eq. 10 to 12; at most " +
                        std::to_string(kMaxDeflectingStrings) + " at once, further ones rigid",
                    ""});
  }
  if (rigid) {
    list.push_back({true,
                    "rigid strings: straight in contact, with the force of Eq. 10 to 13 for "
                    "the depth |F| / (kt k_s): what is seen is not bent",
                    ""});
  }
  list.push_back({o.vibration, "vibration: Eq. 9 after a release, never more energy than released",
                  "vibration: a released string is still at once"});
  list.push_back({o.vibration && o.modes > 0,
                  "waves of " + std::to_string(o.modes) + " modes in two planes, stepped " +
                      std::to_string(o.substeps) + " times a millisecond",
                  "modes beyond the fundamental, which holds 81 % of the energy of a pluck in the "
                  "middle and 21 % of one at a tenth of the string"});
  list.push_back({o.vibration && o.pitch_glide, "pitch glide with amplitude",
                  "pitch glide: the pitch does not depend on the amplitude"});
  list.push_back(
      {o.friction, "friction: Coulomb, one stick anchor per string",
       "friction: a finger slides along and across strings freely. Pressed straight down "
       "on one\n    that bends it stands as on a ridge, and the string slips round it"});
  add_touches(d, list);
  if (yields) {
    list.push_back({true,
                    "lateral force of strings that yield: all of their force is the gradient "
                    "of what they store",
                    ""});
  }
  if (rigid) {
    list.push_back({o.lateral_force, "lateral force of rigid strings, from unequal angles",
                    "lateral force of rigid strings: gliding along one may give energy, which "
                    "the limit at the device takes back"});
  }
  list.push_back({d.tones, "tones at release", "tones: none is sent"});
  return list;
}

void print_features(std::ostream& out, const SceneDescription& d) {
  const std::vector<Feature> features = features_of(d);
  out << "modelled\n  contact of all six degrees of freedom\n";
  for (const Feature& feature : features) {
    if (feature.on) out << "  " << feature.with << "\n";
  }
  out << "not modelled, at no cost\n";
  for (const Feature& feature : features) {
    if (!feature.on) out << "  " << feature.without << "\n";
  }
  for (const ToolDescription& tool : d.tools) {
    bool soft = false;
    for (const PartDescription& part : tool.parts) soft = soft || part.softness.stiffness > 0.0;
    if (!soft) out << "  soft parts: " << tool.name << " is rigid\n";
  }
}

void print_accuracy(std::ostream& out, const LoadedScene& loaded) {
  const ContactOptions& o = loaded.scene->description().contact;
  const v1::Quality& quality = loaded.message.quality();
  out << "accuracy beside the shapes\n  forces are those of the exact surfaces, of which a tool in "
         "fast motion keeps clear by "
      << in_um(o.skin) << ", the skin;\n    nothing is ever entered\n";
  const int level = quality_level(quality);
  const Quality measured = quality_of(level);
  const bool as_level = o.sub_steps == measured.options.sub_steps &&
                        o.stop_tolerance == measured.options.stop_tolerance &&
                        o.rotation_step == measured.options.rotation_step;
  if (as_level) {
    out << "  quality " << level << ": force error at most " << 100.0 * measured.force_error
        << " % rms in the gestures of hapticd-lab tradeoff, at up to " << o.sub_steps
        << " linearisations a tick;\n    predicted work of a tick in touch: " << measured.work
        << " times that of quality " << kDefaultQuality << ", the default\n";
  } else {
    out << "  up to " << o.sub_steps << " linearisations a tick, steps below "
        << in_um(o.stop_tolerance) << " end it\n";
  }
}

void print_times(std::ostream& out, const char* what, const TickTimes& times) {
  out << "  " << what << ": ";
  if (times.ticks == 0) {
    out << "never on this path\n";
    return;
  }
  out << std::setprecision(2) << std::fixed << times.median << " us, 99 % below " << times.p99
      << " us, worst " << times.worst << " us of " << times.ticks << " ticks\n"
      << std::defaultfloat;
}

void print_bound(std::ostream& out, const BoundedTicks& bounded, bool automatic) {
  out << "work of a tick: bounded to " << std::setprecision(6) << bounded.budget_us
      << " us of processor time, "
      << (automatic ? "the budget of automatic quality\n"
                    : "half of a tick at 1 kHz;\n    bounded otherwise with 'hapticd --budget-us "
                      "N', not at "
                      "all where N is 0\n")
      << std::setprecision(2) << std::fixed << "  the most on this path: " << bounded.most_us
      << " us here; " << std::defaultfloat;
  if (bounded.beyond == 0) {
    out << "no tick of " << bounded.ticks << " would be cut short\n";
    return;
  }
  out << bounded.beyond << " of " << bounded.ticks
      << " ticks would be cut short: the tool lags, and enters nothing\n";
}

}  // namespace

std::string explain(const LoadedScene& loaded, const TickCost& cost) {
  const SceneDescription& d = loaded.scene->description();
  std::ostringstream out;
  out << "scene " << d.name;
  if (!loaded.message.description().empty()) out << ": " << loaded.message.description();
  out << "\n";
  print_objects(out, *loaded.scene);
  print_features(out, d);
  print_accuracy(out, loaded);
  out << "cost of a tick on this machine, the first tool led into every object\n";
  print_times(out, "free", cost.free);
  print_times(out, "in contact", cost.contact);
  print_bound(out, cost.bounded, loaded.message.quality().has_automatic());
  out << string_costs(d);
  out << "memory: " << (loaded.scene->memory() + 1023) / 1024 << " KiB\n";
  return out.str();
}

}  // namespace hapticd
